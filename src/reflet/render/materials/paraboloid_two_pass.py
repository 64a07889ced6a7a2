"""Draws a mesh that mirrors a dual paraboloid by texture matrices, as systems without environment lookups do."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.paraboloid_matrices import marked_levels, texture_matrix
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.errors import RefletError
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.meshes.device_mesh import VERTEX_BUFFERS, DeviceMesh, Picture, depth_state
from reflet.render.meshes.views import Rotation, Views, camera_view, view_layout
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera
from reflet.shaders.link import link

_UNIFORM = np.dtype([("eye_from_world", "f4", (3, 4)), ("texture_matrices", "f4", (2, 4, 4))])


class ParaboloidRenderer:
    """Implements [Heidrich98, sec. 5] and [Heidrich00, sec. 2.3.2]: the reflected ray at the vertices is interpolated.

    Textures are filtered by the hardware, in half float, and clamp at their border. ``ring`` texels around the discs
    are shown too.
    """

    def __init__(
        self, mesh: Mesh, levels: Sequence[EnvImage], device: wgpu.GPUDevice | None = None, ring: float = 2.0
    ) -> None:
        self._device = device or shared_device()
        if levels[0].parameterization != DualParaboloid():
            raise RefletError(
                f"Two passes draw a dual paraboloid, not a {levels[0].parameterization} map; resample it."
            )
        self._mesh = DeviceMesh(self._device, mesh)
        self._layout = view_layout(self._device)
        self._views = Views(self._device, self._layout, 1, 1)
        self._map_layout = _map_layout(self._device)
        half = [
            EnvImage(level.parameterization, level.texels.astype(np.float16)) for level in marked_levels(levels, ring)
        ]
        texture = upload_env_map(self._device, half).texture
        self._faces = [texture.create_view(dimension="2d", base_array_layer=k, array_layer_count=1) for k in range(2)]
        self._sampler = self._device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
        module = self._device.create_shader_module(code=link("paraboloid_two_pass.wgsl"))
        self._pipelines = {name: self._pipeline(module, name) for name in ("front", "back", "blended")}

    def picture(
        self,
        camera: Camera,
        *,
        frame: Rotation | None = None,
        method: Literal["two_pass", "one_pass"] = "two_pass",
    ) -> Float32[np.ndarray, "height width 4"]:
        """Linear radiance with one sample a pixel; alpha 0 where nothing was drawn, thus in gaps between hemispheres.

        ``frame`` is ``map_from_world``, a rotation. Two passes: the front by its alpha test, then the back by its own
        where the front drew nothing. One pass: the front over the back by the front's filtered alpha.
        """
        target = Picture(self._device, camera)
        self._views.write([camera_view(camera)], np.eye(4)[None])
        group = self._map_group(camera, np.eye(3) if frame is None else frame)
        encoder = self._device.create_command_encoder()
        render_pass = target.begin(encoder)
        render_pass.set_bind_group(0, self._views.groups[0])
        render_pass.set_bind_group(1, group)
        for name in ("front", "back") if method == "two_pass" else ("blended",):
            render_pass.set_pipeline(self._pipelines[name])
            self._mesh.draw(render_pass)
        render_pass.end()
        self._device.queue.submit([encoder.finish()])
        return target.read()

    def _map_group(self, camera: Camera, map_from_world: Rotation) -> wgpu.GPUBindGroup:
        right, up, forward = camera.frame()
        eye_from_world = np.stack([right, up, -forward])
        uniform = np.zeros((), _UNIFORM)
        uniform["eye_from_world"][:, :3] = eye_from_world.T
        for face in range(2):
            uniform["texture_matrices"][face] = texture_matrix(face, map_from_world @ eye_from_world.T).T
        buffer = self._device.create_buffer_with_data(data=uniform.tobytes(), usage=wgpu.BufferUsage.UNIFORM)
        resources = [{"buffer": buffer}, *self._faces, self._sampler]
        entries = [{"binding": k, "resource": resource} for k, resource in enumerate(resources)]
        return self._device.create_bind_group(layout=self._map_layout, entries=entries)

    def _pipeline(self, module: wgpu.GPUShaderModule, name: str) -> wgpu.GPURenderPipeline:
        # The front writes its depth: the back's fragments, which are no nearer, come only where it drew nothing.
        return self._device.create_render_pipeline(
            layout=self._device.create_pipeline_layout(bind_group_layouts=[self._layout, self._map_layout]),
            vertex={"module": module, "entry_point": "vertex_paraboloid", "buffers": VERTEX_BUFFERS},
            primitive={"topology": "triangle-list", "cull_mode": "back"},
            depth_stencil=depth_state(backdrop=False),
            fragment={"module": module, "entry_point": f"paraboloid_{name}", "targets": [{"format": Picture.FORMAT}]},
        )


def _map_layout(device: wgpu.GPUDevice) -> wgpu.GPUBindGroupLayout:
    vertex, fragment = wgpu.ShaderStage.VERTEX, wgpu.ShaderStage.FRAGMENT
    texture = {"sample_type": "float", "view_dimension": "2d"}
    return device.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": vertex | fragment, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": fragment, "texture": texture},
            {"binding": 2, "visibility": fragment, "texture": texture},
            {"binding": 3, "visibility": fragment, "sampler": {"type": "filtering"}},
        ]
    )
