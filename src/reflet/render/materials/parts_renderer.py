"""Draws several meshes, each of an environment-mapped material of its own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.reflectance.materials.material import SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.render.device.device import shared_device
from reflet.render.filters.still_environment import StillEnvironment
from reflet.render.materials.material_programs import material_programs
from reflet.render.meshes.device_mesh import DeviceMesh, Picture
from reflet.render.meshes.views import Rotation, Views, camera_view
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera


@dataclass(frozen=True)
class ShadedPart:
    """A mesh of one material; the back of single-sided ones is black."""

    mesh: Mesh
    material: SurfaceMaterial
    double_sided: bool = False


class PartsRenderer:
    """Parts in one still environment."""

    def __init__(
        self, parts: Sequence[ShadedPart], environment: EnvironmentMaps, device: wgpu.GPUDevice | None = None
    ) -> None:
        self.device = device or shared_device()
        self._programs = material_programs(self.device, Picture.FORMAT)
        self._environment = StillEnvironment(environment, self.device)
        self._parts = [(DeviceMesh(self.device, part.mesh), part) for part in parts]
        self._views = Views(self.device, self._programs.view_layout, 1, 1)

    def picture(
        self, camera: Camera, *, frame: Rotation | None = None, samples: int = 4, backdrop: bool = True
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance, and coverage by the parts in alpha; see `MaterialRenderer.picture`."""
        target = Picture(self.device, camera, samples)
        self._views.write([camera_view(target.camera)], np.eye(4)[None])
        encoder = self.device.create_command_encoder()
        render_pass = target.begin(encoder)
        render_pass.set_bind_group(0, self._views.groups[0])
        for mesh, part in self._parts:
            maps = self._environment.maps(part.material)
            material = self._programs.material(part.material, maps.diffuse)
            render_pass.set_bind_group(1, self._programs.map_group(maps.reflected, frame, maps.roughness))
            self._programs.draw(render_pass, maps.reflected, material, mesh, double_sided=part.double_sided)
        if backdrop:
            behind = self._environment.environment
            render_pass.set_bind_group(1, self._programs.map_group(behind, frame))
            self._programs.draw_backdrop(render_pass, behind)
        render_pass.end()
        self.device.queue.submit([encoder.finish()])
        return target.read()
