"""Reliefs of what a probe, or one of its shells, sees."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.geometry import Geometry
from reflet.envmap.parameterizations.cube import texel_solid_angle
from reflet.envmap.relief import Relief, inverse_chebyshev, padded_faces
from reflet.envmap.shapes import FAR_AWAY, Box, InfiniteSphere, Vec3

RELIEF_SIZE = 128

Map = Float[np.ndarray, "6 size size"]


def last_relief(distance: Map, origin: Vec3, start: Geometry) -> Geometry:
    """The relief of a shell that hides all behind it, of at most `RELIEF_SIZE` rows, searched from ``start`` if it is a
    box.

    Of what a texel sees the nearest counts: with means rays slip past the edges of what stands near. Where nothing is
    at a finite distance it is the sphere at infinity.
    """
    inverse = inverse_chebyshev(distance)
    if not inverse.any():
        return InfiniteSphere()
    return _relief(_blocks(inverse).max((2, 4)), origin, start)


def near_relief(distance: Map, origin: Vec3, start: Geometry) -> Relief:
    """The relief of a shell with gaps, infinite in ``distance``: means over what is there, carried on smoothly into the
    gaps, where rays that graze what is there are to meet its continuation."""
    there = np.isfinite(distance)
    inverse = np.where(there, inverse_chebyshev(distance), 0.0)
    count = _blocks(there.astype(np.float64)).sum((2, 4))
    mean = _blocks(inverse).sum((2, 4)) / np.maximum(count, 1.0)
    return _relief(_filled(mean, count > 0), origin, start)


def median_box(distance: Map, origin: Vec3) -> Box | InfiniteSphere:
    """The box whose six sides stand where half of what each face of the cube sees stands nearer. A side is `FAR_AWAY`
    where half of that is infinitely far; where all six are, there is no box but the sphere at infinity."""
    along = 1.0 / np.maximum(inverse_chebyshev(distance), 1.0 / FAR_AWAY)  # on a face: the distance from its side
    solid_angle = texel_solid_angle(distance.shape[-1]).ravel()
    reach = [weighted_median(each.ravel(), solid_angle) for each in along]
    if min(reach) > 0.5 * FAR_AWAY:
        return InfiniteSphere()
    sides = np.asarray(origin)[:, None] + np.array(reach).reshape(3, 2) * (1.0, -1.0)
    upper, lower = ((float(x), float(y), float(z)) for x, y, z in sides.T)
    return Box(lower, upper, origin)


def _relief(inverse: Map, origin: Vec3, start: Geometry) -> Relief:
    lower, upper = (start.lower, start.upper) if isinstance(start, Box) else ((-FAR_AWAY,) * 3, (FAR_AWAY,) * 3)
    return Relief(inverse.astype(np.float16), lower, upper, origin)


def _blocks(values: Map) -> Float[np.ndarray, "6 rows block columns block"]:
    """Texels in blocks: as many blocks a face as a relief has texels."""
    size = min(values.shape[-1], RELIEF_SIZE)
    return values.reshape(6, size, values.shape[-1] // size, size, -1)


def _filled(values: Map, known: Bool[np.ndarray, "6 size size"]) -> Map:
    """Unknown texels from the known ones around: means pulled down to one texel a face, then pushed up smoothly."""
    if values.shape[-1] == 1:
        return np.where(known, values, values[known].mean() if known.any() else 0.0)
    size = values.shape[-1] // 2
    count = known.reshape(6, size, 2, size, 2).sum((2, 4))
    total = np.where(known, values, 0.0).reshape(6, size, 2, size, 2).sum((2, 4))
    coarse = padded_faces(_filled(total / np.maximum(count, 1), count > 0))
    quarter = np.empty_like(values)
    here = coarse[:, 1:-1, 1:-1]
    for y, above in enumerate((coarse[:, :-2], coarse[:, 2:])):
        middle = coarse[:, 1:-1]
        for x in range(2):
            columns = slice(2 * x, 2 * x + size)
            beside, over, corner = middle[:, :, columns], above[:, :, 1:-1], above[:, :, columns]
            quarter[:, y::2, x::2] = (9.0 * here + 3.0 * (beside + over) + corner) / 16.0
    return np.where(known, values, quarter)


def weighted_median(values: Float[np.ndarray, "n"], weights: Float[np.ndarray, "n"]) -> float:
    """The least of the values that, with all below it, has half of the weight."""
    order = np.argsort(values, kind="stable")
    running = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(running, 0.5 * running[-1])])
