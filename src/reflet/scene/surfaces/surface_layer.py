"""Local light of rough surfaces, from everywhere: mesh colours that depend on direction.

Sites are spread over the surfaces as those of irradiance are (`reflet.scene.surfaces.irradiance`). Each holds an
octahedral map: what the surface mirrors there along a texel's direction, averaged by its lobe.
"""

from dataclasses import dataclass
from math import isqrt

import numpy as np
from jaxtyping import Float, Float16, Int64, UInt32

from reflet.envmap.parameterizations.octahedral import Octahedral

SIDES = (8, 12, 16)
"""Texels along a site's map there may be: 25°, 17° and 12° apart."""
_LEAST_ROUGHNESS = (0.45, 0.35, 0.0)  # whose lobes are half as wide again as texels lie apart


@dataclass(frozen=True)
class SurfaceLayer:
    """Maps of a scene's rough faces.

    Sample ``offset + i·(2R + 3 - i)/2 + j`` of a triangle lies at the barycentric coordinates (i/R, j/R) of its second
    and third vertex, R its ``resolution``, 0 where it has none; those of a double-sided triangle's back follow. Each
    sample belongs to a ``site``, whose map is ``light[site]``, in rows: the radiance that arrives, and alpha, the share
    of the distant light that does not. They make up for what is wrong in maps of distant light as well: alpha lies in
    [-1, 1], radiance may be below 0. Maps are looked up along the mirrored ray, which does not lean as the lobe's peak
    does. All have the same number of texels.
    """

    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    site: UInt32[np.ndarray, "samples"]
    light: Float16[np.ndarray, "sites texels 4"]

    @property
    def side(self) -> int:
        """Texels along a map."""
        return isqrt(self.light.shape[1])


def side_for(perceptual_roughness: float) -> int:
    """How many of `SIDES` show lobes of a roughness and wider ones."""
    return next(side for side, least in zip(SIDES, _LEAST_ROUGHNESS, strict=True) if perceptual_roughness >= least)


def texel_directions(side: int) -> Float[np.ndarray, "texels 3"]:
    """Unit directions of a map's texels."""
    middle = (np.arange(side) + 0.5) / side
    uv = np.stack(np.meshgrid(middle, middle), -1).reshape(-1, 2)
    return Octahedral().direction_from_uv(np.zeros(len(uv), np.int64), uv)[0]


def neighbours(side: int) -> Int64[np.ndarray, "texels 4"]:
    """The four texels beside each; beyond the map's edge, which is folded, those that lie there."""
    row, column = np.divmod(np.arange(side * side), side)
    beside = []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        r, c = row + down, column + right
        outside = (r < 0) | (r >= side) | (c < 0) | (c >= side)
        r, c = np.clip(r, 0, side - 1), np.clip(c, 0, side - 1)
        across = r * side + (side - 1 - c) if right == 0 else (side - 1 - r) * side + c
        beside.append(np.where(outside, across, r * side + c))
    return np.stack(beside, -1)
