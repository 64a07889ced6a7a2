"""Relief: the true distances of what an env map shows, as its geometry.

A cube map holds the inverse q of the Chebyshev distance from the EM origin o, the largest of |x|, |y|, |z| of what is
seen: so a plane is bilinear within a face, and what is infinitely far is 0. A ray from p along the unit vector r meets
the relief at p + r/w. In w = 1/t the lookup direction is

    d(w) = r + w·(p - o),    and the hit is the root of    w = M(w) = max|d(w)|·q(d(w)),

since the point p - o + r/w = d(w)/w has the Chebyshev distance max|d|/w. M is affine where the ray meets a plane, so
that a secant finds a plane in two steps, and w = 0, the infinitely far, is a number like any other. The search starts
where the ray leaves a box, and keeps a bracket: M(w) > w says that the point lies beyond the relief.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE, texel_directions
from reflet.envmap.shapes import Box, Points, Vec3
from reflet.envmap.texture_filter import MISSING, padded_indices

FETCHES = 4  # of a search: 3 lose 0.3 dB off the orbit, more gain 0.1. A constant, so that shaders need no loop
_NEAREST = 2.0**14  # in 1/metres: half floats hold it
_LIMIT = 64.0  # rays are told apart down to this share of the distance of what lies nearest to the origin


@dataclass(frozen=True, eq=False)
class Relief:
    """A cube map of inverse Chebyshev distances around ``origin``, and the box where searches start.

    ``inverse_distance`` is (6, size, size) in 1/metres, in half floats as devices filter them.
    """

    inverse_distance: Float[np.ndarray, "6 size size"]
    lower: Vec3
    upper: Vec3
    origin: Vec3
    kind = "relief"

    def __post_init__(self) -> None:
        if self.inverse_distance.dtype != np.float16:
            raise ValueError("a relief is of half floats")
        MipChain(self.inverse_distance.shape[-1])  # says what is wrong with other sizes

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Relief):
            return NotImplemented
        return self._numbers == other._numbers and np.array_equal(self.inverse_distance, other.inverse_distance)

    def __hash__(self) -> int:
        return hash(self._numbers)

    @property
    def _numbers(self) -> tuple[Vec3, Vec3, Vec3]:
        return self.lower, self.upper, self.origin

    @cached_property
    def limit(self) -> float:
        """The largest w that is told apart, in 1/metres: hits nearer than that are looked up as if they lay there."""
        return float(np.float32(_LIMIT * max(float(self.inverse_distance.max()), 1e-30)))

    @cached_property
    def padded(self) -> Float[np.ndarray, "6 rows columns"]:
        """`inverse_distance` with a texel of its neighbours around every face, as the texture filter sees it."""
        return padded_faces(self.inverse_distance)

    def lookup_direction(self, p: Points, r: Points) -> Points:
        """The hit from the origin, times w: of any length, never zero."""
        return r + self.inverse_hit(p, r)[..., None] * (p - np.asarray(self.origin))

    def lookup_directions(self, p: Points, r: Points) -> Points:
        """Of (3, n, 3) rays: the first ones' hits, and the others where they are as far as those along their rays.

        One search serves all three, and the LOD does not jump with what neighbours meet.
        """
        return r + self.inverse_hit(p[0], r[0])[:, None] * (p - np.asarray(self.origin))

    def inverse_hit(self, p: Points, r: Points, fetches: int = FETCHES) -> Float[np.ndarray, "*batch"]:
        """w = 1/t of the hit, in [0, limit]: a secant search within a bracket, which asks the map ``fetches`` times."""
        a = p - np.asarray(self.origin)
        t = Box(self.lower, self.upper, self.origin).exit_distance(p, r)
        low, high = np.zeros(t.shape), np.full(t.shape, self.limit)
        before = np.where(t * self.limit > 1.0, 1.0 / np.where(t > 0.0, t, 1.0), self.limit)
        m_before = self._inverse_distance_along(a, r, before)
        low, high = np.where(m_before > before, before, low), np.where(m_before > before, high, before)
        w = np.minimum(m_before, self.limit)
        for _ in range(fetches - 1):
            m = self._inverse_distance_along(a, r, w)
            low, high = np.where(m > w, np.maximum(low, w), low), np.where(m > w, high, np.minimum(high, w))
            change = (m - m_before) - (w - before)
            flat = np.abs(change) <= FLAT * self.limit
            after = np.where(flat, m, w - (m - w) * (w - before) / np.where(flat, 1.0, change))
            settled = np.abs(w - before) <= SETTLED * w
            slack = SETTLED * w  # a step to an end of the bracket, such as the infinitely far, is within it
            outside = ~((after >= low - slack) & (after <= high + slack)) & (np.abs(after - w) > slack)
            # beyond a bracket that has no upper end yet the search doubles its step
            beyond = np.where(high < self.limit, 0.5 * (low + high), self._farther(low))
            next_w = np.where(outside, beyond, np.clip(after, 0.0, self.limit))
            before, m_before = w, m
            w = np.where(settled, w, next_w)
        return w

    def _farther(self, low: Float[np.ndarray, "*batch"]) -> np.ndarray:
        return np.minimum(2.0 * low + STEP * self.limit, self.limit)

    def _inverse_distance_along(self, a: Points, r: Points, w: Float[np.ndarray, "*batch"]) -> np.ndarray:
        """M(w)."""
        d = r + w[..., None] * a
        return np.abs(d).max(-1) * fetch(self.padded, d)


FLAT = 1e-9  # of the limit: steps whose M and w change alike know nothing of the root
SETTLED = (
    2.0**-18
)  # of w: steps that small are float32's rounding, and say nothing of where to go on, or of the bracket
STEP = 2.0**-16  # of the limit: the first step up from the infinitely far


def inverse_chebyshev(distance: Float[np.ndarray, "6 size size"]) -> Float[np.ndarray, "6 size size"]:
    """From distances along the unit directions of a cube's texels, infinite where nothing is met, to inverse Chebyshev
    distances, at most `_NEAREST`: surroundings may touch the origin, as the floor does under a flat mirror."""
    largest = np.abs(texel_directions(distance.shape[-1])[0]).max(-1)  # the same on all faces
    return 1.0 / np.maximum(distance.astype(np.float64) * largest, 1.0 / _NEAREST)


def padded_faces(values: Float[np.ndarray, "6 size size"]) -> Float[np.ndarray, "6 rows columns"]:
    """A cube's texels with one more around each face: its neighbours' nearest, and beyond a corner, where three faces
    meet, the mean of their three texels, which is what the texture filter makes of the missing one."""
    index = padded_indices(MipChain(values.shape[-1]), 0)
    out = np.where(index == MISSING, 0.0, values.reshape(-1)[np.maximum(index, 0)].astype(np.float64))
    for row, next_row in ((0, 1), (-1, -2)):
        for column, next_column in ((0, 1), (-1, -2)):
            met = out[:, next_row, next_column] + out[:, row, next_column] + out[:, next_row, column]
            out[:, row, column] = met / 3.0
    return out


def fetch(padded: Float[np.ndarray, "6 rows columns"], direction: Points) -> Float[np.ndarray, "*batch"]:
    """Bilinear lookup of a cube without mip levels; ``padded`` as of `padded_faces`."""
    size = padded.shape[-1] - 2
    face, uv = CUBE.uv_from_direction(direction)
    x, y = uv[..., 0] * size - 0.5, uv[..., 1] * size - 0.5
    column = np.clip(np.floor(x).astype(np.int64), -1, size - 1)
    row = np.clip(np.floor(y).astype(np.int64), -1, size - 1)
    fx, fy = x - column, y - row
    upper = padded[face, row + 1, column + 1] * (1.0 - fx) + padded[face, row + 1, column + 2] * fx
    lower = padded[face, row + 2, column + 1] * (1.0 - fx) + padded[face, row + 2, column + 2] * fx
    return upper * (1.0 - fy) + lower * fy
