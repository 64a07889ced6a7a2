"""Draws env maps as others: of another parameterization, turned, or both."""

from collections.abc import Sequence

import numpy as np
import wgpu

from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.render.maps.env_map_texture import EnvMapTexture, env_map_group, env_map_layout
from reflet.render.maps.map_levels import MapLevels
from reflet.render.meshes.device_mesh import depth_state
from reflet.render.meshes.views import Rotation, Views, face_view, view_layout
from reflet.shaders.link import link


class WarpPrograms:
    """Pipelines that fill a face of a map with what another map holds in the same directions."""

    def __init__(self, device: wgpu.GPUDevice, view_layout: wgpu.GPUBindGroupLayout, as_backdrop: bool) -> None:
        self._device, self._as_backdrop = device, as_backdrop
        self._map_layout = env_map_layout(device)
        self._layout = device.create_pipeline_layout(bind_group_layouts=[view_layout, self._map_layout])
        self._module = device.create_shader_module(code=link("warp.wgsl"))
        self._pipelines: dict[tuple[int, int, bool, str], wgpu.GPURenderPipeline] = {}

    def source_group(self, source: EnvMapTexture, source_from_target: Rotation | None = None) -> wgpu.GPUBindGroup:
        """The map that is drawn."""
        return env_map_group(self._device, self._map_layout, source, source_from_target)

    def draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        source: EnvMapTexture,
        source_group: wgpu.GPUBindGroup,
        to: Parameterization,
        texture_format: str,
    ) -> None:
        """Fills the face of the view that is bound; sets bind group 1."""
        key = to.kind, source.parameterization.kind, source.by_hardware, texture_format
        if key not in self._pipelines:
            self._pipelines[key] = self._device.create_render_pipeline(
                layout=self._layout,
                vertex={"module": self._module, "entry_point": "vertex_warp"},
                primitive={"topology": "triangle-list"},
                depth_stencil=depth_state(backdrop=True) if self._as_backdrop else None,
                fragment={
                    "module": self._module,
                    "entry_point": "warp",
                    "constants": {"TO_KIND": key[0], "KIND": key[1], "BY_HARDWARE": int(key[2])},
                    "targets": [{"format": texture_format}],
                },
            )
        render_pass.set_pipeline(self._pipelines[key])
        render_pass.set_bind_group(1, source_group)
        render_pass.draw(3)


def face_views(texture: wgpu.GPUTexture, faces: int) -> Sequence[wgpu.GPUTextureView]:
    """The finest level of each face, to draw into."""
    return [
        texture.create_view(dimension="2d", base_array_layer=face, array_layer_count=1, mip_level_count=1)
        for face in range(faces)
    ]


class Warp:
    """Fills a half-float map and its mip levels from other maps, on the device.

    One pass a face: each texel is one filtered lookup in its direction, as coarse as the texels beside it ask for.
    """

    def __init__(self, device: wgpu.GPUDevice, target: EnvMapTexture) -> None:
        self._device, self._target = device, target
        faces = target.parameterization.face_count
        layout = view_layout(device)
        self._programs = WarpPrograms(device, layout, as_backdrop=False)
        self._views = Views(device, layout, faces, 1)
        self._views.write([face_view(face, target.size) for face in range(faces)], np.eye(4)[None])
        self._faces = face_views(target.texture, faces)
        self._levels = MapLevels(device, target)

    def draw(
        self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture, source_from_target: Rotation | None = None
    ) -> None:
        """All of the target; ``source_from_target`` turns its directions into the source's, by default not at all."""
        group = self._programs.source_group(source, source_from_target)
        for view_group, face in zip(self._views.groups, self._faces, strict=True):
            render_pass = encoder.begin_render_pass(
                color_attachments=[{"view": face, "load_op": "clear", "store_op": "store"}]
            )
            render_pass.set_bind_group(0, view_group)
            self._programs.draw(render_pass, source, group, self._target.parameterization, self._target.texture.format)
            render_pass.end()
        self._levels.fill(encoder)
