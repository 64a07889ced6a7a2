"""Prefiltering cubes on the device, as often as what surrounds them changes."""

from collections.abc import Sequence

import numpy as np
import wgpu

from reflet.envmap.cube import CUBE
from reflet.errors import RefletError
from reflet.reflectance.ggx import GgxKernel
from reflet.reflectance.ggx_levels import LINEAR, RoughnessScale
from reflet.reflectance.kernel import Kernel
from reflet.reflectance.lobe_taps import LobeTaps, lobe_taps
from reflet.render.env_map_texture import HALF, EnvMapTexture, create_env_map
from reflet.shaders.link import link

_SMALLEST = 16  # rows of the last level: coarser ones would show their texels
_TAP = np.dtype([("direction", "f4", 3), ("lod", "f4"), ("weight", "f4"), ("padding", "f4", 3)])
_MOST_TAPS = 64
_FACES = 6
# Standard deviation, in texels, of what a lookup sees of a level: the quadratic B-spline that the pyramid tends to has
# 1/4 texel² an axis, bilinear interpolation 1/6 on the mean; lookups between two levels mix them.
_BLUR_OF_TEXELS = 0.6


def ggx_kernels(size: int, scale: RoughnessScale = LINEAR) -> tuple[GgxKernel, ...]:
    """The kernels of levels 1 and coarser of a cube of ``size`` rows, by the one relation of roughness and LOD."""
    count = max(size // _SMALLEST, 2).bit_length()
    return tuple(GgxKernel(scale.roughness_of_level(level, count) ** 2) for level in range(1, count))


class ProbeFilter:
    """Filters a cube into a half-float cube: level 0 mirrors, level k is filtered with ``kernels[k - 1]``.

    In the manner of [Manson16]: a pyramid of quadratic B-splines, from which each texel of a level takes up to 37
    hardware-filtered lookups (`lobe_taps`). The pyramid's texels stand at equal angles on a face, s = tan(πs'/4):
    their solid angles vary by 1.4, where a cube's vary by 5.2. On the way to coarser levels no light is lost or made:
    suns keep theirs, and a constant environment stays the same half float everywhere.

    ``size`` rows, a power of two; level k has ``size`` >> k. By default the kernels are `ggx_kernels`: sample at
    `RoughnessScale.lod_from_roughness`. For a single lobe, such as `PhongKernel`'s, give one and look up level 1.
    Memory: 2.7·48·size² bytes.
    """

    def __init__(self, device: wgpu.GPUDevice, size: int, kernels: Sequence[Kernel] | None = None) -> None:
        kernels = ggx_kernels(size) if kernels is None else kernels
        if size < 2 or size & (size - 1):
            raise RefletError(f"A filtered cube's size must be a power of two from 2 on, not {size}.")
        if not 1 <= len(kernels) < size.bit_length():
            raise RefletError(
                f"A cube of {size} rows has 1 to {size.bit_length() - 1} filtered levels, not {len(kernels)}."
            )
        self.size, self._device = size, device
        self._module = device.create_shader_module(code=link("probe_filter.wgsl"))
        self._sampler = device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
        self._pipelines: dict[tuple[str, int], wgpu.GPURenderPipeline] = {}
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT
        self._pyramid = create_env_map(device, CUBE, size, size.bit_length(), HALF, usage).texture
        self._result = create_env_map(device, CUBE, size, len(kernels) + 1, HALF, usage)
        uniform = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._lobes = [device.create_buffer(size=16 + _MOST_TAPS * _TAP.itemsize, usage=uniform) for _ in kernels]
        for mip_level, kernel in enumerate(kernels, start=1):
            self.set_lobe(mip_level, lobe_taps(kernel))

    def set_lobe(self, mip_level: int, lobe: LobeTaps) -> None:
        """Filters a level, from 1, with another lobe from now on."""
        taps = np.zeros(_MOST_TAPS, _TAP)
        some = taps[: len(lobe.weight)]
        some["direction"], some["weight"] = lobe.direction, lobe.weight
        some["lod"] = np.log2(lobe.blur / _BLUR_OF_TEXELS * (2.0 * self.size / np.pi))
        head = np.array([len(some), 0, 0, 0], np.uint32)
        self._device.queue.write_buffer(self._lobes[mip_level - 1], 0, head.tobytes() + taps.tobytes())

    def refilter(self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture) -> EnvMapTexture:
        """The passes that filter a half-float cube, with mip levels if it is larger; the same texture every time."""
        if not source.by_hardware:
            raise RefletError(
                f"A probe filter takes cubes in half float, not a {source.parameterization} map in "
                f"{source.texture.format}; warp it to a cube."
            )
        incoming = {0: source.texture.create_view(dimension="cube"), 1: self._sampler}
        self._draw(encoder, "first_level", self._pyramid, 0, incoming)
        for level in range(1, self._pyramid.mip_level_count):
            self._draw(encoder, "next_level", self._pyramid, level, {2: _level(self._pyramid, level - 1)})
        self._draw(encoder, "mirrored", self._result.texture, 0, incoming)
        pyramid = {0: self._pyramid.create_view(dimension="cube"), 1: self._sampler}
        for level, lobe in enumerate(self._lobes, start=1):
            self._draw(encoder, "prefiltered", self._result.texture, level, {**pyramid, 3: {"buffer": lobe}})
        return self._result

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        entry_point: str,
        texture: wgpu.GPUTexture,
        mip_level: int,
        bound: dict[int, object],
    ) -> None:
        pipeline = self._pipeline(entry_point, self.size >> mip_level)
        entries = [{"binding": k, "resource": resource} for k, resource in bound.items()]
        group = self._device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
        for face in range(_FACES):
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

    def _pipeline(self, entry_point: str, rows: int) -> wgpu.GPURenderPipeline:
        key = entry_point, rows
        if key not in self._pipelines:
            self._pipelines[key] = self._device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._module, "entry_point": "vertex_face"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._module,
                    "entry_point": entry_point,
                    "constants": {"SIZE": float(rows)},
                    "targets": [{"format": HALF}],
                },
            )
        return self._pipelines[key]


def _level(texture: wgpu.GPUTexture, mip_level: int) -> wgpu.GPUTextureView:
    return texture.create_view(dimension="2d-array", base_mip_level=mip_level, mip_level_count=1)
