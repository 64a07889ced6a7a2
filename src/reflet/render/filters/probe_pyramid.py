"""The smooth pyramid that cubes are prefiltered from on the device."""

from collections.abc import Sequence

import numpy as np
import wgpu

from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError
from reflet.reflectance.lobes.lobe_taps import MOST_TAPS, LobeTaps
from reflet.render.device.face_passes import FacePasses, one_level
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map

FILLED = wgpu.TextureUsage.RENDER_ATTACHMENT
_TAP = np.dtype([("direction", "f4", 3), ("lod", "f4"), ("weight", "f4", 3), ("padding", "f4")])
_LOBE = np.dtype([("reflected", "f4", 3), ("count", "u4"), ("taps", _TAP, MOST_TAPS)])
# Standard deviation, in texels, of what a lookup sees of a level: the quadratic B-spline that the pyramid tends to has
# 1/4 texel² an axis, bilinear interpolation 1/6 on the mean; lookups between two levels mix them.
_BLUR_OF_TEXELS = 0.6
_DIFFUSE_SOURCE = 16  # rows of the level that diffuse maps sum


class ProbePyramid:
    """A pyramid of quadratic B-splines over a half-float cube of ``size`` rows, a power of two from 2 on.

    Its texels stand at equal angles on a face, s = tan(πs'/4): their solid angles vary by 1.4, where a cube's vary by
    5.2. On the way to coarser levels no light is lost or made: suns keep theirs, and a constant environment stays the
    same half float everywhere. Memory: 64·size² bytes.
    """

    def __init__(self, device: wgpu.GPUDevice, size: int) -> None:
        if size < 2 or size & (size - 1):
            raise RefletError(f"A filtered cube's size must be a power of two from 2 on, not {size}.")
        self.size, self.device = size, device
        self._passes = FacePasses(device, "probe_filter.wgsl", HALF)
        self._sampler = device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
        self._texture = create_env_map(device, CUBE, size, size.bit_length(), HALF, FILLED).texture

    def fill(self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture) -> None:
        """The passes that fill the pyramid from a half-float cube, with mip levels if it is larger."""
        _check(source)
        incoming = {0: source.texture.create_view(dimension="cube"), 1: self._sampler}
        self._passes.draw(encoder, "first_level", self._texture, 0, incoming, SIZE=self.size)
        for level in range(1, self._texture.mip_level_count):
            self._passes.draw(encoder, "next_level", self._texture, level, {2: one_level(self._texture, level - 1)})

    def mirror(
        self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture, target: EnvMapTexture, mip_level: int = 0
    ) -> None:
        """A level of a cube with what the source itself holds."""
        _check(source)
        incoming = {0: source.texture.create_view(dimension="cube"), 1: self._sampler}
        self._passes.draw(encoder, "mirrored", target.texture, mip_level, incoming, SIZE=target.size >> mip_level)

    def filter(
        self, encoder: wgpu.GPUCommandEncoder, lobes: "DeviceLobes", target: EnvMapTexture, mip_level: int = 0
    ) -> None:
        """A level of a map of any parameterization with the pyramid's light filtered with a lobe.

        Or of several maps one after the other in the target's layers, as many as there are ``lobes``.
        """
        bound = {0: self._texture.create_view(dimension="cube"), 1: self._sampler, 3: {"buffer": lobes.buffer}}
        kind = target.parameterization.kind
        self._passes.draw(
            encoder, "prefiltered", target.texture, mip_level, bound, SIZE=target.size >> mip_level, KIND=kind
        )

    def coarser(self, encoder: wgpu.GPUCommandEncoder, target: EnvMapTexture) -> None:
        """All other mip levels of such maps."""
        kind = target.parameterization.kind
        for level in range(1, target.texture.mip_level_count):
            bound: dict[int, object] = {2: one_level(target.texture, level - 1)}
            self._passes.draw(encoder, "coarser_map", target.texture, level, bound, KIND=kind)

    def diffuse(self, encoder: wgpu.GPUCommandEncoder, target: EnvMapTexture, mip_level: int = 0) -> None:
        """A level of a cube with the light that reaches surfaces by their normal, irradiance/π: sums over all light.

        Every texel reads 1536 texels; without taps, as the kernel's edge at the horizon is more than they can follow.
        """
        level = max(self.size // _DIFFUSE_SOURCE, 1).bit_length() - 1
        bound = {2: one_level(self._texture, level)}
        self._passes.draw(encoder, "diffuse", target.texture, mip_level, bound, SIZE=target.size >> mip_level)


class DeviceLobes:
    """Taps of a pyramid of ``size`` rows, on the device: of one lobe, or of one after the other."""

    def __init__(self, device: wgpu.GPUDevice, size: int, lobes: Sequence[LobeTaps]) -> None:
        self._queue, self._size = device.queue, size
        usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST
        self.buffer = device.create_buffer(size=len(lobes) * _LOBE.itemsize, usage=usage)
        self.write(lobes)

    def write(self, lobes: Sequence[LobeTaps]) -> None:
        """As many others, for what is submitted from now on."""
        packed = np.zeros(len(lobes), _LOBE)
        for one, lobe in zip(packed, lobes, strict=True):
            weight = lobe.weight.reshape(len(lobe.blur), -1)  # of one channel or three
            one["reflected"], one["count"] = weight.sum(0), len(weight)
            some = one["taps"][: len(weight)]
            some["direction"], some["weight"] = lobe.direction, weight
            some["lod"] = np.log2(lobe.blur / _BLUR_OF_TEXELS * (2.0 * self._size / np.pi))
        self._queue.write_buffer(self.buffer, 0, packed.tobytes())


def _check(source: EnvMapTexture) -> None:
    if not source.by_hardware:
        raise RefletError(
            f"A probe filter takes cubes in half float, not a {source.parameterization} map in "
            f"{source.texture.format}; warp it to a cube."
        )
