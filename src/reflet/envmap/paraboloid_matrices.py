"""The dual paraboloid by texture matrices: all of a lookup but the reflection itself is projective.

A hemisphere's texture coordinates follow from the reflected ray in eye space, as homogeneous coordinates, by one matrix
and the division that perspective textures end with: (s, t) = (bias·P·S·Ml⁻¹·(r, 1)).st/q.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid

Matrix = Float[np.ndarray, "4 4"]

# Texture coordinates of a face over [-1, 1]² with y up: u right, v down, both in [0, 1].
_BIAS = np.array([[0.5, 0.0, 0.0, 0.5], [0.0, -0.5, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
# Divides by z.
_P = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


def texture_matrix(face: int, map_from_eye: Float[np.ndarray, "3 3"]) -> Matrix:
    """From the unit reflected ray in eye space, with a fourth coordinate 1, to a face's (s, t, ·, q): divide by q.

    Implements [Heidrich00, eqs 9 to 12]; ``map_from_eye`` is the rotation (Ml)⁻¹, a map's ``z`` points to the middle of
    its front face. S computes d + r, so that d + r = 2(n·d)n is a multiple of the paraboloid's normal (x, y, 1): with
    d = (0, 0, 1) for the front. (In eq. 11 it is d - r, which belongs to [Heidrich98], where d = (0, 0, -1) points
    the other way.) For the back d = (0, 0, -1); dividing by z then changes the sign of x and y, which S takes back.
    """
    sign = 1.0 if face == 0 else -1.0
    add = np.diag([sign, sign, 1.0, 1.0])
    add[2, 3] = sign
    turn = np.eye(4)
    turn[:3, :3] = map_from_eye
    return _BIAS @ _P @ add @ turn


def marked_levels(levels: Sequence[EnvImage], ring: float) -> tuple[EnvImage, ...]:
    """Levels of a dual paraboloid whose alpha marks, by 1, the texels that a hemisphere's pass may show; else it is 0.

    These are the texels whose centres lie in the disc, or at most ``ring`` texels of their own level outside. A
    filtered alpha is 1 only where all four texels are marked, so that without a ring of one or two texels
    [Heidrich98, sec. 7] neither hemisphere shows the rim.
    """
    return tuple(_marked(level.texels, ring) for level in levels)


def _marked(texels: np.ndarray, ring: float) -> EnvImage:
    size = texels.shape[1]
    centre = (2.0 * np.arange(size) + 1.0) / size - 1.0
    radius = np.hypot(centre[:, None], centre[None, :])
    alpha: Float32[np.ndarray, "size size"] = (radius <= 1.0 + ring * 2.0 / size).astype(texels.dtype)
    channel = np.broadcast_to(alpha[None, :, :, None], (2, size, size, 1))
    return EnvImage(DualParaboloid(), np.concatenate([texels[..., :3], channel], -1))
