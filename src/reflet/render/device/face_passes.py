"""Passes that fill the faces of a map."""

from typing import Any

import wgpu

from reflet.shaders.link import link


class FacePasses:
    """A program that fills mip levels, a pass a face: its ``vertex_face`` draws three vertices, instance = face.

    Pipelines are built when first needed, and kept.
    """

    def __init__(self, device: wgpu.GPUDevice, program: str, texture_format: str) -> None:
        self._device, self._format = device, texture_format
        self._module = device.create_shader_module(code=link(program))
        self._pipelines: dict[tuple[Any, ...], wgpu.GPURenderPipeline] = {}

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        entry_point: str,
        texture: wgpu.GPUTexture,
        mip_level: int,
        bound: dict[int, object],
        **constants: float,
    ) -> None:
        """All faces of a level. ``bound`` are the bindings of group 0, ``constants`` the program's overrides."""
        pipeline = self._pipeline(entry_point, constants)
        entries = [{"binding": k, "resource": resource} for k, resource in bound.items()]
        group = self._device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
        for face in range(texture.depth_or_array_layers):
            view = texture.create_view(
                dimension="2d", base_array_layer=face, array_layer_count=1, base_mip_level=mip_level, mip_level_count=1
            )
            render_pass = encoder.begin_render_pass(
                color_attachments=[{"view": view, "load_op": "clear", "store_op": "store"}]
            )
            render_pass.set_pipeline(pipeline)
            render_pass.set_bind_group(0, group)
            render_pass.draw(3, 1, 0, face)
            render_pass.end()

    def _pipeline(self, entry_point: str, constants: dict[str, float]) -> wgpu.GPURenderPipeline:
        key = entry_point, *constants.items()
        if key not in self._pipelines:
            self._pipelines[key] = self._device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._module, "entry_point": "vertex_face"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._module,
                    "entry_point": entry_point,
                    "constants": constants,
                    "targets": [{"format": self._format}],
                },
            )
        return self._pipelines[key]


def one_level(texture: wgpu.GPUTexture, mip_level: int) -> wgpu.GPUTextureView:
    """All faces of one level, to be read."""
    return texture.create_view(dimension="2d-array", base_mip_level=mip_level, mip_level_count=1)
