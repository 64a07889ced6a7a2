"""Martin Newell's teapot of 1975, told by what makes it up: profiles that are turned, and tubes of two mirrored halves.

The 32 bicubic Bézier patches follow from these few numbers (`patches`); coordinates are Newell's, z up.
"""

import numpy as np
from jaxtyping import Float

QUARTER = 0.56
"""Newell's handle length for a quarter circle (the best would be 0.5523)."""

# (radius, height) from the top down the outside; every third point is shared by two curves
BODY = [
    (1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9),
    (2.0, 0.45), (1.5, 0.225), (1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0),
]  # fmt: skip
LID = [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)]

# (x, height) of the cross-section's near end, its half width, (x, height) of its far end; along the tube
HANDLE = [
    (-1.6, 2.025, 0.3, -1.5, 2.25), (-2.3, 2.025, 0.3, -2.5, 2.25), (-2.7, 2.025, 0.3, -3.0, 2.25),
    (-2.7, 1.8, 0.3, -3.0, 1.8),
    (-2.7, 1.575, 0.3, -3.0, 1.35), (-2.5, 1.125, 0.3, -2.65, 0.9375), (-2.0, 0.9, 0.3, -1.9, 0.6),
]  # fmt: skip
SPOUT = [
    (1.7, 1.425, 0.66, 1.7, 0.6), (2.6, 1.425, 0.66, 3.1, 0.825), (2.3, 2.1, 0.25, 2.4, 2.025),
    (2.7, 2.4, 0.25, 3.3, 2.4),
    (2.8, 2.475, 0.25, 3.525, 2.49375), (2.9, 2.475, 0.15, 3.45, 2.5125), (2.8, 2.4, 0.15, 3.2, 2.4),
]  # fmt: skip

PARTS = ("body", "lid", "handle", "spout")
Patches = Float[np.ndarray, "along around 4 4 3"]


def patches(part: str) -> Patches:
    """Control points of a part's patches: patches along the profile or tube, patches around it, 4 rows along, 4 around.

    Patches follow one another around without a gap, the last meeting the first. ∂along × ∂around points outwards.
    """
    if part in ("body", "lid"):
        return _turned(np.array(BODY if part == "body" else LID), knob=part == "lid")
    return _tube(np.array(HANDLE if part == "handle" else SPOUT))


def _turned(profile: Float[np.ndarray, "points 2"], knob: bool) -> Patches:
    quarter = np.full(len(profile), QUARTER)
    if knob:
        quarter[1] = 0.5625  # Newell rounded 0.8·0.56 to 0.45 here
    c, s = np.array([1.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0])
    inner = np.array([0.0, 1.0, 1.0, 0.0])  # which of the four points carry the handle length, in which direction
    rows = []
    for turn in range(4):
        cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][turn]
        x = c + inner * quarter[:, None] * s
        y = s + inner * quarter[:, None] * c
        radius = profile[:, :1]
        rows.append(np.stack([radius * (cos * x - sin * y), radius * (sin * x + cos * y),
                              np.broadcast_to(profile[:, 1:], x.shape)], axis=-1))  # fmt: skip
    return _cut(np.stack(rows, axis=1))


def _tube(sections: Float[np.ndarray, "sections 5"]) -> Patches:
    x0, z0, width, x1, z1 = sections.T
    zero = np.zeros_like(width)
    near, far = (x0, z0), (x1, z1)
    halves = []
    for (xa, za), (xb, zb), side in ((near, far, width), (far, near, -width)):
        points = [(xa, zero, za), (xa, side, za), (xb, side, zb), (xb, zero, zb)]
        halves.append(np.stack([np.stack(p, axis=-1) for p in points], axis=1))
    return _cut(np.stack(halves, axis=1))


def _cut(rows: Float[np.ndarray, "rows around 4 3"]) -> Patches:
    """Rows of control points, every third shared, as patches of four rows."""
    return np.stack([rows[k : k + 4].transpose(1, 0, 2, 3) for k in range(0, len(rows) - 1, 3)])
