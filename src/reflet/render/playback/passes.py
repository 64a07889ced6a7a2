"""Render passes: pipelines and the textures they draw into."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Literal

import numpy as np
import wgpu

from reflet.render.playback.layouts import HOLES, SWITCHES, frame_layout, part_layout
from reflet.render.playback.scene_buffers import Draw
from reflet.render.playback.sums import Sums
from reflet.render.playback.target import Target
from reflet.shaders.link import link

Cull = Literal["none", "front", "back"]

_NUMBERS = {"probe_triangle": "r32uint", "probe_hits": "rgba32uint"}  # what entry points draw that are no colours
_MOST_PIPELINES = 256  # kept: a driver may hold a megabyte of code for each


class Passes:
    """Draws parts and backdrop, reads pictures back."""

    def __init__(self, device: wgpu.GPUDevice) -> None:
        self._device = device
        self.sums = Sums(device)

    def draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        program: str,
        entry_point: str,
        sub_sample: int,
        backdrop: bool,
        constants: Mapping[str, float],
        frame_group: wgpu.GPUBindGroup,
        part_groups: Sequence[wgpu.GPUBindGroup],
        draws: Sequence[Draw],
        *,
        keeps_out: bool = False,
    ) -> wgpu.GPUTexture:
        """One pass over all parts, then the backdrop; the texture that holds the picture, one sample a pixel.

        ``constants`` are those of the frame that pipelines are built for. ``keeps_out`` draws nothing where pixels have
        enough samples (`Sums.decide`); such passes have one sample a pixel, and show radiance.
        """
        colour, resolved, depth = self._attachments(target, entry_point)
        render_pass = encoder.begin_render_pass(
            color_attachments=[
                {
                    "view": colour.create_view(),
                    "resolve_target": resolved and resolved.create_view(),
                    "clear_value": (0, 0, 0, 0),
                    "load_op": "clear",
                    "store_op": "store" if resolved is None else "discard",
                }
            ],
            depth_stencil_attachment={
                "view": depth.create_view(),
                "depth_clear_value": 0.0,
                "depth_load_op": "clear",
                "depth_store_op": "discard",
            },
        )
        if keeps_out:
            self.sums.keep_out(render_pass, target)
        render_pass.set_bind_group(0, frame_group)
        shows_backs_apart = program == "picture.wgsl"
        rate = "multi" if _is_multi(entry_point) else "single"
        for item in draws:
            render_pass.set_bind_group(1, part_groups[item.part])
            vertices = 3 * item.count, 1, 3 * item.first, sub_sample
            cull: Cull = "back" if shows_backs_apart and not item.double_sided and not item.bits & HOLES else "none"
            traces = program == "picture.wgsl" and item.traced and int(constants["SWITCHES"]) & SWITCHES["local"]
            shown_by = "traced_picture.wgsl" if traces else program
            built_for = {**constants, "PART_BITS": item.bits, **item.constants}
            if shown_by.startswith("traced_"):
                built_for |= item.traced
            render_pass.set_pipeline(self._pipeline(shown_by, entry_point, cull, **built_for))
            render_pass.draw(*vertices)
            if cull == "back":
                back = self._pipeline(program, f"picture_{rate}_back", "front", SWITCHES=constants["SWITCHES"])
                render_pass.set_pipeline(back)
                render_pass.draw(*vertices)
        if backdrop:
            render_pass.set_pipeline(self._pipeline("backdrop.wgsl", f"backdrop_{rate}", "none"))
            render_pass.draw(3, 1, 0, sub_sample)
        render_pass.end()
        return resolved or colour

    def read(self, texture: wgpu.GPUTexture, dtype: type) -> np.ndarray:
        """A texture's contents, (height, width, channels)."""
        width, height, _ = texture.size
        channels = 1 if texture.format == "r32uint" else 4
        bytes_per_row = width * channels * np.dtype(dtype).itemsize
        data = self._device.queue.read_texture(
            {"texture": texture}, {"bytes_per_row": bytes_per_row, "rows_per_image": height}, (width, height, 1)
        )
        return np.frombuffer(data, dtype).reshape(height, width, channels)

    def _attachments(
        self, target: Target, entry_point: str
    ) -> tuple[wgpu.GPUTexture, wgpu.GPUTexture | None, wgpu.GPUTexture]:
        texture_format = _format(entry_point)
        if _is_multi(entry_point):
            return target.texture(texture_format, 4), target.texture(texture_format), target.texture("depth32float", 4)
        return target.texture(texture_format), None, target.texture("depth32float")

    def _pipeline(self, program: str, entry_point: str, cull: Cull, **constants: float) -> wgpu.GPURenderPipeline:
        """A pipeline built for constants that the program leaves open; made when first asked for."""
        return _compiled(self._device, link(program), program, entry_point, cull, tuple(constants.items()))


@lru_cache(_MOST_PIPELINES)
def _compiled(
    device: wgpu.GPUDevice,
    text: str,
    program: str,
    entry_point: str,
    cull: Cull,
    constants: tuple[tuple[str, float], ...],
) -> wgpu.GPURenderPipeline:
    """Once for all renderers of a device: to compile one takes longer than most pictures."""
    module = _module(device, text)
    backdrop, multi = program == "backdrop.wgsl", _is_multi(entry_point)
    vertex = "multi" if multi else "single"
    if backdrop:
        vertex = "backdrop"
    elif entry_point.endswith("_back"):
        vertex += "_place"
    elif entry_point.endswith("_fast"):
        vertex += "_fast"
    groups = [frame_layout(device)] if backdrop else [frame_layout(device), part_layout(device)]
    return device.create_render_pipeline(
        layout=device.create_pipeline_layout(bind_group_layouts=groups),
        vertex={"module": module, "entry_point": f"vertex_{vertex}", "constants": dict(constants)},
        primitive={"topology": "triangle-list", "cull_mode": cull},
        depth_stencil={
            "format": "depth32float",
            "depth_write_enabled": not backdrop,
            "depth_compare": "greater-equal" if backdrop else "greater",
        },
        multisample={"count": 4 if multi else 1},
        fragment={
            "module": module,
            "entry_point": entry_point,
            "constants": dict(constants),
            "targets": [{"format": _format(entry_point)}],
        },
    )


@lru_cache(_MOST_PIPELINES)
def _module(device: wgpu.GPUDevice, text: str) -> wgpu.GPUShaderModule:
    return device.create_shader_module(code=text)


def _is_multi(entry_point: str) -> bool:
    return "multi" in entry_point.split("_")


def _format(entry_point: str) -> str:
    """Of the texture that a fragment entry point draws into."""
    return _NUMBERS.get(entry_point, "rgba16float" if _is_multi(entry_point) else "rgba32float")
