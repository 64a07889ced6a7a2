"""Draws meshes before a plain env map of any geometry and parameterization."""

from collections.abc import Sequence

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap
from reflet.reflectance.materials.material import WHITE, Mirror, Rgb
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import EnvMapTexture, upload_env_map
from reflet.render.materials.material_programs import DeviceMaterial, material_programs
from reflet.render.meshes.device_mesh import DeviceMesh, Picture
from reflet.render.meshes.views import Rotation, Views, camera_view
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera


def view_frame(camera: Camera) -> Rotation:
    """The rotation ``map_from_world`` of a map made for this camera's viewing direction: +z is towards the viewer.

    What gazing balls need [Heidrich00, sec. 2.1]: directions near +z are those that spheres mirror towards the viewer.
    """
    right, up, forward = camera.frame()
    return np.stack([right, up, -forward])


def render_mirror(
    mesh: Mesh,
    env_map: EnvMap | Sequence[EnvImage],
    camera: Camera,
    frame: Rotation | None = None,
    samples: int = 4,
) -> Float32[np.ndarray, "height width 4"]:
    """One picture by `EnvMapRenderer`: a perfect mirror before its environment, and that behind it.

    An `EnvMap` is met at its geometry, in the mesh's space, by mirrored rays and by those from the camera, which stands
    within it; mip levels alone, finest first, are infinitely far.
    """
    renderer = EnvMapRenderer(mesh)
    return renderer.picture(upload_env_map(renderer.device, env_map), camera, frame=frame, samples=samples)


class EnvMapRenderer:
    """Draws one mesh, by default a mirror of the given reflectance. `MaterialRenderer` brings all a material needs."""

    def __init__(self, mesh: Mesh, device: wgpu.GPUDevice | None = None, reflectance: Rgb = WHITE) -> None:
        self.device = device or shared_device()
        self.programs = material_programs(self.device, Picture.FORMAT)
        self._mesh = DeviceMesh(self.device, mesh)
        self._mirror = self.programs.material(Mirror(reflectance))
        self._views = Views(self.device, self.programs.view_layout, 1, 1)

    def picture(
        self,
        env_map: EnvMapTexture,
        camera: Camera,
        *,
        frame: Rotation | None = None,
        samples: int = 4,
        backdrop: bool | EnvMapTexture = True,
        material: DeviceMaterial | None = None,
        roughness: float | None = None,
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance, and coverage of the mesh in alpha.

        ``env_map`` is what the mesh reflects: the environment, or one filtered for the material, and where its levels
        are for rougher and rougher surfaces, at this perceptual ``roughness``. ``backdrop`` is what lies behind it: the
        same map, or another. ``frame`` is ``map_from_world``, the rotation of directions into the maps' own space, by
        default none; a map that depends on the view is its caller's to make and to turn (`view_frame`). ``samples`` a
        pixel are 1, 4 or 16 (`Picture`). A map's geometry stays in the world's space, and serves materials that mirror,
        sharply or not.
        """
        material = material or self._mirror
        # Samples are drawn as pixels of a finer grid; levels drawn by hand are for the picture's own.
        lod_bias = 0.5 * float(np.log2(samples)) if material.lookup is not None else 0.0
        target = Picture(self.device, camera, samples)
        self._views.write([camera_view(target.camera)], np.eye(4)[None])
        encoder = self.device.create_command_encoder()
        render_pass = target.begin(encoder)
        render_pass.set_bind_group(0, self._views.groups[0])
        render_pass.set_bind_group(1, self.programs.map_group(env_map, frame, roughness, lod_bias))
        self.programs.draw(render_pass, env_map, material, self._mesh)
        if backdrop:
            behind = env_map if backdrop is True else backdrop
            render_pass.set_bind_group(1, self.programs.map_group(behind, frame))
            self.programs.draw_backdrop(render_pass, behind)
        render_pass.end()
        self.device.queue.submit([encoder.finish()])
        return target.read()
