"""Draws meshes that mirror a plain env map of any parameterization, before that environment."""

from collections.abc import Sequence
from functools import cache
from typing import Literal

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.render.device import shared_device
from reflet.render.device_mesh import VERTEX_BUFFERS, DeviceMesh, Picture, depth_state
from reflet.render.env_map_texture import EnvMapTexture, env_map_group, env_map_layout, upload_env_map
from reflet.render.views import Rotation, Views, camera_view, view_layout
from reflet.scene.camera import Camera
from reflet.scene.mesh import Mesh
from reflet.shaders.link import link

Vec3 = tuple[float, float, float]


def view_frame(camera: Camera) -> Rotation:
    """The rotation ``map_from_world`` of a map made for this camera's viewing direction: +z is towards the viewer.

    What gazing balls need [Heidrich00, sec. 2.1]: directions near +z are those that spheres mirror towards the viewer.
    """
    right, up, forward = camera.frame()
    return np.stack([right, up, -forward])


def render_mirror(
    mesh: Mesh,
    levels: Sequence[EnvImage],
    camera: Camera,
    frame: Rotation | None = None,
    samples: int = 4,
) -> Float32[np.ndarray, "height width 4"]:
    """One picture by `EnvMapRenderer`: a perfect mirror before its environment, ``levels`` with finest first."""
    renderer = EnvMapRenderer(mesh)
    return renderer.picture(upload_env_map(renderer.device, levels), camera, frame=frame, samples=samples)


@cache
def mirror_programs(device: wgpu.GPUDevice, colour_format: str) -> "MirrorPrograms":
    """One for all who draw into this format; building pipelines takes longer than a frame."""
    return MirrorPrograms(device, colour_format)


class MirrorPrograms:
    """Pipelines that draw a mesh that mirrors a map, and that map as a backdrop, into passes with depth."""

    def __init__(self, device: wgpu.GPUDevice, colour_format: str) -> None:
        self._device, self._format = device, colour_format
        self.view_layout, self.map_layout = view_layout(device), env_map_layout(device)
        uniform = {"binding": 0, "visibility": wgpu.ShaderStage.FRAGMENT, "buffer": {"type": "uniform"}}
        self._material_layout = device.create_bind_group_layout(entries=[uniform])
        groups = [self.view_layout, self.map_layout, self._material_layout]
        self._layout = device.create_pipeline_layout(bind_group_layouts=groups)
        self._module = device.create_shader_module(code=link("mirror_picture.wgsl"))
        self._pipelines: dict[tuple[str, int, bool], wgpu.GPURenderPipeline] = {}

    def draw(
        self, render_pass: wgpu.GPURenderPassEncoder, env_map: EnvMapTexture, mesh: DeviceMesh, instance: int = 0
    ) -> None:
        """Draws a mesh; its three bind groups are set."""
        render_pass.set_pipeline(self._pipeline("mesh", env_map))
        mesh.draw(render_pass, instance)

    def draw_backdrop(self, render_pass: wgpu.GPURenderPassEncoder, env_map: EnvMapTexture) -> None:
        """Draws the map behind everything; the first two bind groups are set, and the third where meshes were drawn."""
        render_pass.set_pipeline(self._pipeline("backdrop", env_map))
        render_pass.draw(3)

    def _pipeline(self, what: Literal["mesh", "backdrop"], env_map: EnvMapTexture) -> wgpu.GPURenderPipeline:
        """Built for the map's parameterization."""
        key = what, env_map.parameterization.kind, env_map.by_hardware
        if key not in self._pipelines:
            mesh = what == "mesh"
            self._pipelines[key] = self._device.create_render_pipeline(
                layout=self._layout,
                vertex={
                    "module": self._module,
                    "entry_point": "vertex_mirror" if mesh else "vertex_backdrop",
                    "buffers": VERTEX_BUFFERS if mesh else [],
                },
                primitive={"topology": "triangle-list"},
                depth_stencil=depth_state(backdrop=not mesh),
                fragment={
                    "module": self._module,
                    "entry_point": f"mirror_{what}",
                    "constants": {"KIND": key[1], "BY_HARDWARE": int(key[2])},
                    "targets": [{"format": self._format}],
                },
            )
        return self._pipelines[key]

    def map_group(self, env_map: EnvMapTexture, map_from_world: Rotation | None = None) -> wgpu.GPUBindGroup:
        """Bind group 1."""
        return env_map_group(self._device, self.map_layout, env_map, map_from_world)

    def material_group(self, reflectance: Vec3) -> wgpu.GPUBindGroup:
        """Bind group 2: a mirror that reflects this share at all angles."""
        data = np.array([*reflectance, 0.0], np.float32).tobytes()
        buffer = self._device.create_buffer_with_data(data=data, usage=wgpu.BufferUsage.UNIFORM)
        return self._device.create_bind_group(
            layout=self._material_layout, entries=[{"binding": 0, "resource": {"buffer": buffer}}]
        )


class EnvMapRenderer:
    """Draws one mesh, a mirror of the given reflectance."""

    def __init__(self, mesh: Mesh, device: wgpu.GPUDevice | None = None, reflectance: Vec3 = (1.0, 1.0, 1.0)) -> None:
        self.device = device or shared_device()
        self._programs = mirror_programs(self.device, Picture.FORMAT)
        self._mesh = DeviceMesh(self.device, mesh)
        self._material = self._programs.material_group(reflectance)
        self._views = Views(self.device, self._programs.view_layout, 1, 1)

    def picture(
        self,
        env_map: EnvMapTexture,
        camera: Camera,
        *,
        frame: Rotation | None = None,
        samples: int = 4,
        backdrop: bool = True,
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance, and coverage of the mesh in alpha.

        ``frame`` is ``map_from_world``, the rotation of directions into the map's own space, by default none; a map
        that depends on the view is its caller's to make and to turn (`view_frame`). ``samples`` a pixel are 1, 4 or
        16 (`Picture`).
        """
        target = Picture(self.device, camera, samples)
        self._views.write([camera_view(target.camera)], np.eye(4)[None])
        group = self._programs.map_group(env_map, frame)
        encoder = self.device.create_command_encoder()
        render_pass = target.begin(encoder)
        render_pass.set_bind_group(0, self._views.groups[0])
        render_pass.set_bind_group(1, group)
        render_pass.set_bind_group(2, self._material)
        self._programs.draw(render_pass, env_map, self._mesh)
        if backdrop:
            self._programs.draw_backdrop(render_pass, env_map)
        render_pass.end()
        self.device.queue.submit([encoder.finish()])
        return target.read()
