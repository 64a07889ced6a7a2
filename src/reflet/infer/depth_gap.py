"""Where to divide distant surroundings into shells: in the gaps of their depth.

Between neighbouring directions depth either goes on or jumps, by a factor of more than `_JUMP`. A distance separates a
jump if it lies within it, and cuts a surface if it lies between neighbours that do not jump. The score of dividing at
some distances is

    (jumps that one of them separates - 1/2 smooth pairs that one of them cuts) / all jumps,

and each is found in turn, as the middle of the range that scores best given those found before. A cut costs less than a
jump left whole: what it divides goes on in both shells, what is behind a jump is in one map with what hides it.
"""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.relief import padded_faces

_JUMP = 1.25
_TOUCHING = 1e-30  # metres to what touches the origin, which is as good as any
_CANDIDATES = 96  # distances tried, evenly in the logarithm
_PLATEAU = 0.02  # of the score: distances that score no less than this below the best are as good
_LEAST_SCORE = 0.1  # below this there is no gap
_CUT = 0.5  # cost of a smooth pair that is cut, in jumps


def depth_gaps(distance: Float[np.ndarray, "6 size size"], nearest: float, most: int) -> tuple[float, ...]:
    """Up to ``most`` distances at which to divide what a probe sees at ``distance`` metres, the best first.

    All are at least ``nearest``, within which objects themselves stand. None is found where dividing separates nothing.
    """
    finite = np.isfinite(distance)
    if most < 1 or not finite.any():
        return ()
    near, far = _pairs(np.where(finite, distance, np.inf).astype(np.float64))
    jumps = far > _JUMP * near
    highest = float(distance[finite].max()) * (1.0 if finite.all() else _JUMP)  # between all there is and the sky too
    if not jumps.any() or highest <= nearest:
        return ()
    tried = np.geomspace(max(nearest, float(distance[finite].min())), highest, _CANDIDATES)
    found: list[float] = []
    separated = np.zeros(len(near), bool)
    for _ in range(most):
        score = np.array([_score(near, far, jumps & ~separated, jumps, end) for end in tried])
        best = int(score.argmax())
        if score[best] < _LEAST_SCORE:
            break
        end = _middle_of_plateau(tried, score >= score[best] - _PLATEAU, best)
        found.append(end)
        separated |= jumps & (near < end) & (end <= far)
    return tuple(found)


def _pairs(distance: Float[np.ndarray, "6 size size"]) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n"]]:
    """The nearer and the farther of all neighbouring texels, across the edges of faces too."""
    inverse = padded_faces(1.0 / np.maximum(distance, _TOUCHING))  # no pair is lost at infinity
    here = inverse[:, 1:-1, 1:-1]
    middle = slice(1, -1)
    beside = np.stack(  # each pair is met from both sides
        [inverse[:, middle, 2:], inverse[:, middle, :-2], inverse[:, 2:, middle], inverse[:, :-2, middle]]
    )
    both = np.stack([np.broadcast_to(here, beside.shape), beside])
    with np.errstate(divide="ignore"):
        return 1.0 / both.max(0).ravel(), 1.0 / both.min(0).ravel()


def _score(
    near: Float[np.ndarray, "n"],
    far: Float[np.ndarray, "n"],
    left: Bool[np.ndarray, "n"],
    jumps: Bool[np.ndarray, "n"],
    end: float,
) -> float:
    between = (near < end) & (end <= far)
    separated, cut = np.count_nonzero(between & left), np.count_nonzero(between & ~jumps)
    return float(separated - _CUT * cut) / np.count_nonzero(jumps)


def _middle_of_plateau(tried: Float[np.ndarray, "k"], good: Bool[np.ndarray, "k"], best: int) -> float:
    first = last = best
    while first > 0 and good[first - 1]:
        first -= 1
    while last < len(tried) - 1 and good[last + 1]:
        last += 1
    return float(np.sqrt(tried[first] * tried[last]))
