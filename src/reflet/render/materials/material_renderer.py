"""Draws a mesh of any environment-mapped material in one environment, both changed from picture to picture at will."""

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.reflectance.materials.material import SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.render.device.device import shared_device
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.filters.still_environment import StillEnvironment
from reflet.render.materials.env_map_renderer import EnvMapRenderer
from reflet.render.meshes.views import Rotation
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera


class MaterialRenderer:
    """One mesh in one environment: a still one, whose maps the CPU filters once, or one refiltered as it changes.

    See `StillEnvironment`, which takes time with every new lobe and is exact, and `LiveEnvironment`, whose maps never
    leave the device: change what it shows, and the material, before each picture.
    """

    def __init__(
        self,
        mesh: Mesh,
        environment: LiveEnvironment | EnvironmentMaps | EnvImage,
        device: wgpu.GPUDevice | None = None,
    ) -> None:
        """A live environment brings its own device."""
        if isinstance(environment, LiveEnvironment):
            self.device = environment.device
            self._environment: LiveEnvironment | StillEnvironment = environment
        else:
            self.device = device or shared_device()
            maps = environment if isinstance(environment, EnvironmentMaps) else EnvironmentMaps(environment)
            self._environment = StillEnvironment(maps, self.device)
        self._renderer = EnvMapRenderer(mesh, self.device)

    def picture(
        self,
        material: SurfaceMaterial,
        camera: Camera,
        *,
        frame: Rotation | None = None,
        samples: int = 4,
        backdrop: bool = True,
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance, and coverage of the mesh in alpha. ``frame`` turns the environment: ``map_from_world``."""
        maps = self._environment.maps(material)
        return self._renderer.picture(
            maps.reflected,
            camera,
            frame=frame,
            samples=samples,
            material=self._renderer.programs.material(material, maps.diffuse),
            roughness=maps.roughness,
            backdrop=self._environment.environment if backdrop else False,
        )
