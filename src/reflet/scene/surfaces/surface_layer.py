"""Local light of rough surfaces, from everywhere: mesh colours that depend on direction.

Sites are spread over the surfaces as those of irradiance are (`reflet.scene.surfaces.irradiance`). Each holds an
octahedral map of `SIDE`² texels: what the surface mirrors there along a texel's direction, averaged by its lobe.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float16, Int64, UInt32

from reflet.envmap.parameterizations.octahedral import Octahedral

SIDE = 8
"""Texels along a site's map, 25° apart: lobes of perceptual_roughness 0.4 are as wide. Twin: `SIDE` of
surface_light.wgsl."""


@dataclass(frozen=True)
class SurfaceLayer:
    """Maps of a scene's rough faces.

    Sample ``offset + i·(2R + 3 - i)/2 + j`` of a triangle lies at the barycentric coordinates (i/R, j/R) of its second
    and third vertex, R its ``resolution``, 0 where it has none; those of a double-sided triangle's back follow. Each
    sample belongs to a ``site``, whose map is ``light[site]``, in rows: the radiance that arrives, and alpha, the share
    of the distant light that does not. They make up for what is wrong in maps of distant light as well: alpha lies in
    [-1, 1], radiance may be below 0. Maps are looked up along the mirrored ray, which does not lean as the lobe's peak
    does.
    """

    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    site: UInt32[np.ndarray, "samples"]
    light: Float16[np.ndarray, "sites texels 4"]


def texel_directions() -> Float[np.ndarray, "texels 3"]:
    """Unit directions of a map's texels."""
    middle = (np.arange(SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(middle, middle), -1).reshape(-1, 2)
    return Octahedral().direction_from_uv(np.zeros(len(uv), np.int64), uv)[0]


def neighbours() -> Int64[np.ndarray, "texels 4"]:
    """The four texels beside each; beyond the map's edge, which is folded, those that lie there."""
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    beside = []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        r, c = row + down, column + right
        outside = (r < 0) | (r >= SIDE) | (c < 0) | (c >= SIDE)
        r, c = np.clip(r, 0, SIDE - 1), np.clip(c, 0, SIDE - 1)
        across = r * SIDE + (SIDE - 1 - c) if right == 0 else (SIDE - 1 - r) * SIDE + c
        beside.append(np.where(outside, across, r * SIDE + c))
    return np.stack(beside, -1)
