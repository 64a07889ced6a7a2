"""The map that real-time engines look up: static, filtered for a few roughnesses, projected on a simple shape."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.geometry import Shape
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.resample import radiance_at
from reflet.reflectance.prefilter.ggx_levels import FILAMENT, ggx_levels


@dataclass(frozen=True)
class SplitSumMap:
    """Levels of `ggx_levels` by Filament's relation of roughness and LOD, and the shape that lookups meet.

    The split sum's lookup [Karis13]: along the mirrored ray, as if the surface were seen along its normal; the LOD
    follows from roughness alone, however near what is seen.
    """

    levels: tuple[EnvImage, ...]
    geometry: Shape

    def radiance(
        self,
        position: Float[np.ndarray, "n 3"],
        mirrored: Float[np.ndarray, "n 3"],
        perceptual_roughness: Float[np.ndarray, "n"],
    ) -> Float[np.ndarray, "n 3"]:
        """What comes in along unit rays from points in metres, averaged by the lobes: trilinear."""
        direction = self.geometry.lookup_direction(position, mirrored)
        share = np.vectorize(FILAMENT.lod_share, otypes=[np.float64])
        lod = share(perceptual_roughness) * (len(self.levels) - 1)
        out = np.zeros(mirrored.shape)
        for number, level in enumerate(self.levels):
            weight = 1.0 - np.abs(lod - number)
            reads = weight > 0.0
            if reads.any():
                out[reads] += weight[reads, None] * radiance_at(level, direction[reads])
        return out


def split_sum_map(image: EnvImage, geometry: Shape) -> SplitSumMap:
    """The map of an environment, in cubes of its own size and down to 16 rows."""
    return SplitSumMap(ggx_levels(image, CUBE, image.size, scale=FILAMENT), geometry)
