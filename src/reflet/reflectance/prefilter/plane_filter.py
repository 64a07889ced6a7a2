"""Radially symmetric lobes as shift-invariant filters in the plane of a dual paraboloid.

The paraboloid's map is the stereographic projection: a direction at the angle θ from the middle of a face lies at
radius tan(θ/2), the hemisphere fills the disc of radius 1. Circles stay circles. So a lobe, cut off where it falls
below a share of its peak, at the angle β from its axis, covers a disc wherever it stands. With t = tan(β/2):

- at the middle of the face its radius is r_s = t;
- with its axis at the rim, 90° from the middle, it reaches inwards to 90° - β, at radius
  tan(45° - β/2) = (1 - t)/(1 + t): its radius, measured inwards, is r_l = 1 - (1 - t)/(1 + t) = 2t/(1 + t).

That is twice r_s for narrow lobes, as areas there are four times as large, and less for wide ones. In texels, rounded
up and doubled, these are the filter sizes of the table in [Heidrich00, sec. 3.2.5], all ten of them.

In between, at distance d from the middle, texels a steradian are (1 + d²)² of the middle's and lengths 1 + d²: the
radius is (1 - d²)·r_s + d²·r_l, and so the maps filtered with the two are blended by d².

What is lost: circles stay circles, but their middles move. At the rim the filter ends where the lobe does on the inner
side, and on the outer side at 1 + r_l, 2·atan(1 + r_l) - 90° from its axis, less than β: 13° instead of 17° for
exponent 50.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.kernel import Kernel

WIDEST = 7  # texels
REACH = WIDEST // 2


@dataclass(frozen=True)
class PlaneFilter:
    """One of the two filters.

    ``radius``, with that of the disc as 1; ``size``, its width in texels of the map, even; ``shrink_level``, the mip
    level on which that is at most ``WIDEST``; and there the lobe at offsets (row, column) from -REACH to REACH, whose
    sum is 1.
    """

    radius: float
    size: int
    shrink_level: int
    weights: Float[np.ndarray, "7 7"]


def plane_filters(kernel: Kernel, rows: int, limit: float = 0.1) -> tuple[PlaneFilter, PlaneFilter]:
    """The filters for the middle and for the rim of faces whose discs are ``rows`` texels wide.

    Implements [Heidrich00, sec. 3.2.5, steps 3 to 7]. The lobe counts as zero below ``limit`` of its peak, in (0, 1),
    and beyond a right angle.
    """
    if not 0.0 < limit < 1.0:
        raise RefletError(f"A lobe is cut off at a share of its peak between 0 and 1, not {limit}; 0.1 is usual.")
    t = min(float(np.tan(0.5 * lobe_angle(kernel, limit))), 1.0)
    small = _plane_filter(kernel, rows, t, lambda radius: radius)
    large = _plane_filter(kernel, rows, 2.0 * t / (1.0 + t), lambda radius: radius / (2.0 - radius))
    return small, large


def lobe_angle(kernel: Kernel, limit: float) -> float:
    """The largest angle in radians at which the kernel is at least ``limit`` of its peak."""
    root = np.linspace(0.0, 1.0, 4097)  # of s: sin(θ/2)
    density = kernel.density(root**2)
    least = limit * density.max()
    last = int(np.flatnonzero(density >= least).max())
    if last == len(root) - 1:
        return float(np.pi)
    low, high = root[last], root[last + 1]
    for _ in range(40):
        middle = 0.5 * (low + high)
        if kernel.density(np.array([middle**2]))[0] >= least:
            low = middle
        else:
            high = middle
    return float(2.0 * np.arcsin(low))


def _plane_filter(
    kernel: Kernel, rows: int, radius: float, half_tangent: Callable[[np.ndarray], np.ndarray]
) -> PlaneFilter:
    """``half_tangent`` gives tan(θ/2) of the lobe at a radius in the plane."""
    size = 2 * int(np.ceil(0.5 * rows * radius - 1e-9))
    shrink_level = 0
    while size > WIDEST << shrink_level:
        shrink_level += 1
    texel = 2.0 * (1 << shrink_level) / rows
    offset = np.arange(-REACH, REACH + 1) * texel
    distance = np.hypot(offset, offset[:, None])
    squared_tangent = half_tangent(np.minimum(distance, 1.0)) ** 2
    lobe = np.where(distance <= radius, kernel.density(squared_tangent / (1.0 + squared_tangent)), 0.0)
    return PlaneFilter(radius, size, shrink_level, lobe / lobe.sum())
