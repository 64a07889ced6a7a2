"""Pictures of a moving scene whose reflective parts mirror it, in the same frame, as it is then."""

import numpy as np
import wgpu
from jaxtyping import Float, Float32

from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.infer.fit_geometry import em_origin
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.materials.material import Mirror
from reflet.render.capture.capture import EnvironmentCapture, Method, upload_environment
from reflet.render.capture.matte_scene import MatteScene
from reflet.render.device.device import shared_device
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.materials.env_map_renderer import view_frame
from reflet.render.materials.material_programs import material_programs
from reflet.render.meshes.device_mesh import DeviceMesh, Picture
from reflet.render.meshes.views import Views, camera_view
from reflet.scene.scene import Scene
from reflet.scene.sky_light import OVERCAST, SkyLight
from reflet.scene.views.camera import Camera


class MovingSceneRenderer:
    """Each frame captures what surrounds the reflective parts and draws all; the map never leaves the device.

    All reflective parts mirror one map, taken from the middle of their surface, with their base colour as reflectance;
    they do not mirror one another. ``size``, ``method``, ``to`` and ``light`` are those of `EnvironmentCapture`. With a
    ``phong_exponent`` they are glossy: the map is filtered with Phong's lobe, every frame, by `PhongParaboloidFilter`.
    """

    def __init__(
        self,
        scene: Scene,
        size: int,
        method: Method = "cube",
        to: Parameterization | None = None,
        light: SkyLight = OVERCAST,
        device: wgpu.GPUDevice | None = None,
        phong_exponent: float | None = None,
    ) -> None:
        self.device = device or shared_device()
        self._lobe = PhongKernel(phong_exponent) if phong_exponent is not None else None
        self._filter = PhongParaboloidFilter(self.device, size) if self._lobe is not None else None
        self._mirrors = [i for i, part in enumerate(scene.parts) if part.reflective]
        self._others = [i for i, part in enumerate(scene.parts) if not part.reflective]
        if not self._mirrors:
            raise RefletError("Nothing in this scene mirrors; make a part reflective.")
        self.capture = EnvironmentCapture(self.device, scene, size, method, to, light)
        self._follows_view = to is not None and to.is_view_dependent
        self._programs = material_programs(self.device, Picture.FORMAT)
        self._matte = MatteScene(self.device, scene, light, self._programs.view_layout)
        self._meshes = {i: DeviceMesh(self.device, scene.parts[i].mesh) for i in self._mirrors}
        self._materials = {
            i: self._programs.material(Mirror(scene.parts[i].material.base_color)) for i in self._mirrors
        }
        self._views = Views(self.device, self._programs.view_layout, 1, len(scene.parts))
        self._environment = upload_environment(self.device, scene)
        self._centres = {i: em_origin(scene, (i,)) for i in self._mirrors}

    def frame(
        self, world_from_part: Float[np.ndarray, "parts 4 4"], camera: Camera, samples: int = 4
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance with every part moved by its rigid transform; alpha is 0 where only the environment is."""
        centres = [(world_from_part[i] @ [*centre, 1.0])[:3] for i, centre in self._centres.items()]
        x, y, z = np.mean(centres, 0)
        turn = view_frame(camera) if self._follows_view else np.eye(3)
        env_map = self.capture.frame(world_from_part, (x, y, z), turn)
        target = Picture(self.device, camera, samples)
        self._views.write([camera_view(target.camera)], world_from_part)
        encoder = self.device.create_command_encoder()
        if self._filter is not None and self._lobe is not None:
            env_map = self._filter.refilter(encoder, env_map, self._lobe)
        mirrored = self._programs.map_group(env_map, turn)
        render_pass = target.begin(encoder)
        render_pass.set_bind_group(0, self._views.groups[0])
        self._matte.draw(render_pass, self._others, Picture.FORMAT)
        for i in self._mirrors:
            render_pass.set_bind_group(1, mirrored)
            self._programs.draw(render_pass, env_map, self._materials[i], self._meshes[i], i)
        if self._environment is not None:
            render_pass.set_bind_group(1, self._programs.map_group(self._environment))
            self._programs.draw_backdrop(render_pass, self._environment)
        render_pass.end()
        self.device.queue.submit([encoder.finish()])
        return target.read()
