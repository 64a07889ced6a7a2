"""Prefiltering cubes on the device, as often as what surrounds them changes."""

from collections.abc import Sequence

import wgpu

from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.lobes.lobe_taps import LobeTaps, lobe_taps
from reflet.reflectance.prefilter.ggx_levels import GEOMETRIC, RoughnessScale
from reflet.render.filters.probe_pyramid import FILLED, DeviceLobes, ProbePyramid
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map

_SMALLEST = 8  # rows of the last level: texels of an octahedral map's 16 rows; coarser ones would be seen

_DIFFUSE = (DiffuseKernel(), GgxKernel(1.0))  # the same: of alpha 1 GGX's D is constant, and what is left is the cosine


def ggx_kernels(size: int, scale: RoughnessScale = GEOMETRIC) -> tuple[GgxKernel, ...]:
    """The kernels of levels 1 and coarser of a cube of ``size`` rows, by the one relation of roughness and LOD."""
    count = max(size // _SMALLEST, 2).bit_length()
    return tuple(GgxKernel(scale.roughness_of_level(level, count) ** 2) for level in range(1, count))


class ProbeFilter:
    """Filters a cube into a half-float cube: level 0 mirrors, level k is filtered with ``kernels[k - 1]``.

    In the manner of [Manson16]: a smooth pyramid (`ProbePyramid`), from which each texel of a level takes up to 49
    hardware-filtered lookups (`lobe_taps`). The diffuse kernel, and GGX's of roughness 1, which is the same, is summed.

    ``size`` rows, a power of two; level k has ``size`` >> k. By default the kernels are `ggx_kernels`: sample at
    `RoughnessScale.lod_from_roughness`. Filters that look at the same environment may share a ``pyramid`` of this size.
    ``result`` is the texture that is filled, the same every time. Memory: 128·size² bytes, half of them the pyramid's.
    """

    def __init__(
        self,
        device: wgpu.GPUDevice,
        size: int,
        kernels: Sequence[Kernel] | None = None,
        pyramid: ProbePyramid | None = None,
    ) -> None:
        self.pyramid = pyramid or ProbePyramid(device, size)
        self.size = size
        kernels = ggx_kernels(size) if kernels is None else kernels
        if not 1 <= len(kernels) < size.bit_length():
            raise RefletError(
                f"A cube of {size} rows has 1 to {size.bit_length() - 1} filtered levels, not {len(kernels)}."
            )
        self.result = create_env_map(device, CUBE, size, len(kernels) + 1, HALF, FILLED)
        self._lobes = [
            None if kernel in _DIFFUSE else DeviceLobes(device, size, [lobe_taps(kernel)]) for kernel in kernels
        ]

    def set_lobe(self, mip_level: int, lobe: LobeTaps) -> None:
        """Filters a level, from 1, with another lobe from now on."""
        self._lobes[mip_level - 1] = DeviceLobes(self.pyramid.device, self.size, [lobe])

    def refilter(self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture) -> EnvMapTexture:
        """The passes that filter a half-float cube, with mip levels if it is larger."""
        self.pyramid.fill(encoder, source)
        return self.filter_levels(encoder, source)

    def filter_levels(self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture) -> EnvMapTexture:
        """The same, where the pyramid has been filled from this source."""
        self.pyramid.mirror(encoder, source, self.result)
        for level, lobe in enumerate(self._lobes, start=1):
            if lobe is None:
                self.pyramid.diffuse(encoder, self.result, level)
            else:
                self.pyramid.filter(encoder, lobe, self.result, level)
        return self.result
