"""Sums of pictures, and which pixels need no more of them."""

import numpy as np
import wgpu
from jaxtyping import Float32, UInt32

from reflet.render.playback.target import Target
from reflet.shaders.link import link

_CRITERION = np.dtype([("exposure", "f4"), ("curve", "u4"), ("width", "u4"), ("count", "u4")])
_EXPOSURE = 1.6  # CONVENTIONS.md
_EXPONENTIAL = 0  # TONE_EXPONENTIAL
_DEPTH, _COLOR = "depth32float", "rgba32float"


class Sums:
    """Adds pictures up, of one sample a pixel or all alike; keeps what has enough samples out of further ones."""

    def __init__(self, device: wgpu.GPUDevice) -> None:
        self._device = device
        self._accumulate, self._accumulate_spread, self._decide = (
            device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": entry_point})
            for module in [device.create_shader_module(code=link("accumulate.wgsl"))]
            for entry_point in ("accumulate", "accumulate_spread", "decide")
        )
        module = device.create_shader_module(code=link("enough.wgsl"))
        self._enough = device.create_render_pipeline(
            layout="auto",
            vertex={"module": module, "entry_point": "vertex_enough"},
            primitive={"topology": "triangle-list"},
            depth_stencil={"format": _DEPTH, "depth_write_enabled": True, "depth_compare": "always"},
            fragment={
                "module": module,
                "entry_point": "enough_single",
                "targets": [{"format": _COLOR, "write_mask": 0}],
            },
        )
        self._criterion = device.create_buffer(
            size=_CRITERION.itemsize, usage=wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        )

    def begin(self, encoder: wgpu.GPUCommandEncoder, target: Target, decided_after: int | None) -> None:
        """Empties the sum. Where samples count is decided after ``decided_after`` of them, if at all.

        Submit the encoder before another picture begins.
        """
        encoder.clear_buffer(target.sum)
        if decided_after is not None:
            encoder.clear_buffer(target.spread)
            encoder.clear_buffer(target.enough)
            criterion = np.array((_EXPOSURE, _EXPONENTIAL, target.size[0], decided_after), _CRITERION)
            self._device.queue.write_buffer(self._criterion, 0, criterion.tobytes())

    def add(
        self, encoder: wgpu.GPUCommandEncoder, picture: wgpu.GPUTexture, target: Target, *, spread: bool = False
    ) -> None:
        """Adds a picture, and if asked how far its values lie from those before."""
        bound = {0: picture.create_view(), 1: {"buffer": target.sum}}
        if spread:
            bound |= {2: {"buffer": self._criterion}, 3: {"buffer": target.spread}}
        self._dispatch(encoder, self._accumulate_spread if spread else self._accumulate, bound, target)

    def decide(self, encoder: wgpu.GPUCommandEncoder, target: Target) -> None:
        """Which pixels have enough of the pictures added with their spread."""
        bound = {2: {"buffer": self._criterion}, 3: {"buffer": target.spread}, 4: {"buffer": target.enough}}
        self._dispatch(encoder, self._decide, bound, target)

    def keep_out(self, render_pass: wgpu.GPURenderPassEncoder, target: Target) -> None:
        """Begins a pass, one sample a pixel: nothing more is drawn where a pixel has enough."""
        bound = {0: {"buffer": self._criterion}, 1: {"buffer": target.enough}}
        render_pass.set_pipeline(self._enough)
        render_pass.set_bind_group(0, self._group(self._enough, bound))
        render_pass.draw(3)

    def read(self, target: Target) -> Float32[np.ndarray, "height width 4"]:
        """The sum."""
        width, height = target.size
        return np.frombuffer(self._device.queue.read_buffer(target.sum), np.float32).reshape(height, width, 4)

    def read_counts(self, target: Target, count: int) -> UInt32[np.ndarray, "height width"]:
        """The samples of each pixel of a sum of ``count`` pictures where they count."""
        width, height = target.size
        enough = np.frombuffer(self._device.queue.read_buffer(target.enough), np.uint32).reshape(height, width)
        return np.where(enough == 0, np.uint32(count), enough)

    def _group(self, pipeline: wgpu.GPUPipelineBase, bound: dict) -> wgpu.GPUBindGroup:
        entries = [{"binding": binding, "resource": resource} for binding, resource in bound.items()]
        return self._device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)

    def _dispatch(
        self, encoder: wgpu.GPUCommandEncoder, pipeline: wgpu.GPUComputePipeline, bound: dict, target: Target
    ) -> None:
        width, height = target.size
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(pipeline)
        compute_pass.set_bind_group(0, self._group(pipeline, bound))
        compute_pass.dispatch_workgroups(-(-width // 8), -(-height // 8))
        compute_pass.end()
