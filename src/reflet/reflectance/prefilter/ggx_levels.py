"""Prefiltered maps of GGX as mip levels: the one relation between roughness and LOD, and the maps made by it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.resample import resample
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.prefilter.prefilter import Prefilter, Progress, unheard

_SMALLEST = 16  # rows of the last level by default: coarser ones would show their texels


@dataclass(frozen=True)
class RoughnessScale:
    """How a renderer finds the LOD of a perceptual_roughness r, as a share of the last level's: 0 at 0, 1 at 1."""

    name: str
    lod_share: Callable[[float], float]
    roughness: Callable[[float], float]  # its inverse

    def lod_from_roughness(self, perceptual_roughness: float, level_count: int) -> float:
        """LOD in [0, level_count - 1]."""
        return self.lod_share(perceptual_roughness) * (level_count - 1)

    def roughness_of_level(self, mip_level: int, level_count: int) -> float:
        """perceptual_roughness that a mip level is filtered with, in [0, 1]."""
        return self.roughness(mip_level / max(level_count - 1, 1))


LINEAR = RoughnessScale("linear", lambda r: r, lambda share: share)  # glTF Sample Viewer, three.js's idea too
FILAMENT = RoughnessScale("filament", lambda r: r * (2.0 - r), lambda share: 1.0 - float(np.sqrt(1.0 - share)))

# That of our own renderers: lobes widen by the same factor from level to level, so that what lies between is a blend of
# lobes that differ little. What level 0 blurs counts as a lobe: texels of width w, boxes that are interpolated between,
# have the variance w²/12 + w²/6, and α² = w²/8 has as much (`material_maps.roughness_over`). An octahedral map of 256
# rows has w = √4π/256 and α = 0.0049. We take α² + 0.0055² to grow by one factor from level to level: the first lobe of
# `renderer_levels`, of α = 0.0146, is then as narrow as can be without a finer `radiance_tree`, which takes seconds.
_FINEST = 0.0055**2
_ALL = float(np.log1p(1.0 / _FINEST))
GEOMETRIC = RoughnessScale(
    "geometric",
    lambda r: float(np.log1p(r**4 / _FINEST)) / _ALL,  # twin: ggx_lod.wgsl
    lambda share: float(_FINEST * np.expm1(share * _ALL)) ** 0.25 if share < 1.0 else 1.0,
)


def ggx_levels(
    image: EnvImage,
    to: Parameterization,
    size: int,
    level_count: int | None = None,
    scale: RoughnessScale = LINEAR,
    progress: Progress = unheard,
) -> tuple[EnvImage, ...]:
    """The environment filtered with `GgxKernel`: level k, of ``size`` >> k rows, for the roughness ``scale`` gives it.

    Level 0 is a mirror's, the last one that of roughness 1.

    ``level_count`` is by default that which ends at 16 rows. ``progress`` hears of texels made, and of all. Raises
    RefletError for radiance that is negative or not finite, and where there are fewer levels than 2 or more than
    ``size`` can be halved to.
    """
    count = checked_level_count(size, level_count)
    environment = Prefilter(image)
    kernels = [GgxKernel(scale.roughness_of_level(level, count) ** 2) for level in range(1, count)]
    sizes = [max(size >> level, 1) for level in range(1, count)]
    return (resample(image, to, size), *filtered_levels(environment, kernels, to, sizes, progress))


def renderer_levels(image: EnvImage, to: Parameterization, size: int) -> tuple[EnvImage, ...]:
    """The same for our renderers, by `GEOMETRIC`: two levels of each size, ``size`` rows and down to a quarter of it.

    Below 64 rows sizes end at 16. With one level a size lobes are so far apart that between two of them a small sun
    shows both, and the last level has so few texels that they can be seen where such a sun sets.
    """
    count = 2 * min(max(size // _SMALLEST, 1).bit_length(), 3)
    kernels = [GgxKernel(GEOMETRIC.roughness_of_level(level, count) ** 2) for level in range(1, count)]
    sizes = [size >> level // 2 for level in range(1, count)]
    return (resample(image, to, size), *filtered_levels(Prefilter(image), kernels, to, sizes))


def checked_level_count(size: int, level_count: int | None) -> int:
    """By default the levels down to 16 rows, at least 2. Raises RefletError for numbers that cannot be."""
    count = max(size // _SMALLEST, 2).bit_length() if level_count is None else level_count
    if not 2 <= count <= size.bit_length():
        raise RefletError(f"A map of {size} rows has 2 to {size.bit_length()} levels, not {count}; ask for fewer.")
    return count


def filtered_levels(
    environment: Prefilter,
    kernels: Sequence[Kernel],
    to: Parameterization,
    sizes: Sequence[int],
    progress: Progress = unheard,
) -> list[EnvImage]:
    """A map of so many rows for each kernel; ``progress`` hears of texels."""
    texels = [int(np.prod(to.shape(size))) for size in sizes]
    levels: list[EnvImage] = []
    for kernel, size in zip(kernels, sizes, strict=True):
        before = sum(texels[: len(levels)])

        def heard(done: int, total: int, before: int = before, own: int = texels[len(levels)]) -> None:
            progress(before + own * done // total, sum(texels))

        levels.append(environment.map(kernel, to, size, heard))
    progress(sum(texels), sum(texels))
    return levels
