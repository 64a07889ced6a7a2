"""Draws a mesh of any environment-mapped material in one environment, the material changed from picture to picture."""

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.reflectance.brdf_map import BrdfMap3d
from reflet.reflectance.material import GlossyPhong, SurfaceMaterial
from reflet.reflectance.material_maps import EnvironmentMaps
from reflet.reflectance.measured_material import Measured
from reflet.reflectance.phong import PhongKernel
from reflet.render.brdf_map_texture import BrdfMapTexture, upload_brdf_map
from reflet.render.device import shared_device
from reflet.render.env_map_renderer import EnvMapRenderer
from reflet.render.env_map_texture import EnvMapTexture, upload_env_map
from reflet.render.phong_paraboloid import PhongParaboloidFilter
from reflet.render.views import Rotation
from reflet.scene.camera import Camera
from reflet.scene.mesh import Mesh


class MaterialRenderer:
    """One mesh in one environment. Maps go to the device when a material first needs them, and stay there.

    GGX's roughness is a choice of mip level, so that changing it costs nothing. A new Phong exponent takes a new map:
    filtered by the CPU, or, with ``filter_on_device``, every time anew by the paper's hardware method (see
    `PhongParaboloidFilter` for its error), fast enough for every frame. A measured BRDF takes as many maps as its lobes
    have view angles, filtered by the CPU.
    """

    def __init__(
        self,
        mesh: Mesh,
        environment: EnvironmentMaps | EnvImage,
        device: wgpu.GPUDevice | None = None,
        filter_on_device: bool = False,
    ) -> None:
        self.device = device or shared_device()
        self._maps = environment if isinstance(environment, EnvironmentMaps) else EnvironmentMaps(environment)
        self._renderer = EnvMapRenderer(mesh, self.device)
        self._filter = PhongParaboloidFilter(self.device, 128) if filter_on_device else None
        self._brdf_map: tuple[BrdfMap3d, BrdfMapTexture] | None = None  # the last one
        self._textures: dict[int, tuple[object, EnvMapTexture]] = {}

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
        environment = self._texture(self._maps.levels)
        roughness, diffuse = None, None
        if isinstance(material, Measured):
            lobes = self._lobes(material)
            shown, diffuse = lobes.slices, lobes.diffuse
        elif self._filter is not None and isinstance(material, GlossyPhong):
            encoder = self.device.create_command_encoder()
            shown = self._filter.refilter(encoder, environment, PhongKernel(material.phong_exponent))
            self.device.queue.submit([encoder.finish()])
        else:
            maps = self._maps.maps(material)
            shown, roughness = self._texture(maps.reflected), maps.roughness
        if material.diffuses and diffuse is None:
            diffuse = self._texture((self._maps.diffuse,))
        return self._renderer.picture(
            shown,
            camera,
            frame=frame,
            samples=samples,
            material=self._renderer.programs.material(material, diffuse),
            roughness=roughness,
            backdrop=environment if backdrop else False,
        )

    def _lobes(self, material: Measured) -> BrdfMapTexture:
        maps = self._maps.brdf_map(material.lobes)
        if self._brdf_map is None or self._brdf_map[0] is not maps:
            self._brdf_map = maps, upload_brdf_map(self.device, maps)
        return self._brdf_map[1]

    def _texture(self, levels: tuple[EnvImage, ...]) -> EnvMapTexture:
        """Uploaded once. Levels are known by their finest image, which is kept so that its number stays its own."""
        finest = levels[0]
        if id(finest) not in self._textures:
            self._textures[id(finest)] = finest, upload_env_map(self.device, levels)
        return self._textures[id(finest)][1]
