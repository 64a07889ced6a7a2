"""Colours of other primaries, brought to Rec. 709 at the file boundary."""

import numpy as np
from jaxtyping import Float

# CIE xy of red, green, blue and white [ITU-R BT.709]
REC709 = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]])
REC709.setflags(write=False)

EQUAL_ENERGY = np.array([1.0 / 3.0, 1.0 / 3.0])
EQUAL_ENERGY.setflags(write=False)

# cone responses from XYZ, for adaptation to another white [Lam85]
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def _xyz(xy: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 3"]:
    """XYZ of a chromaticity, Y = 1."""
    x, y = xy[..., 0], xy[..., 1]
    return np.stack([x / y, np.ones_like(y), (1.0 - x - y) / y], -1)


def xyz_from_rgb(primaries: Float[np.ndarray, "4 2"]) -> Float[np.ndarray, "3 3"]:
    """The matrix to CIE XYZ: its columns are the primaries, scaled so that (1, 1, 1) becomes the white with Y = 1."""
    columns = _xyz(primaries[:3]).T
    return columns * np.linalg.solve(columns, _xyz(primaries[3]))


def rec709_from_xyz(white: Float[np.ndarray, "2"]) -> Float[np.ndarray, "3 3"]:
    """The matrix from CIE XYZ, where ``white`` is what the picture's white looks like, to linear Rec. 709.

    The white becomes (1, 1, 1): cone responses are scaled by the ratio of the two whites' (Bradford's adaptation).
    """
    ratio = (_BRADFORD @ _xyz(REC709[3])) / (_BRADFORD @ _xyz(white))
    adapted = np.linalg.solve(_BRADFORD, ratio[:, None] * _BRADFORD)
    return np.linalg.solve(xyz_from_rgb(REC709), adapted)


def rec709_from_rgb(primaries: Float[np.ndarray, "4 2"]) -> Float[np.ndarray, "3 3"]:
    """The matrix from linear RGB of other ``primaries`` (xy of red, green, blue, white); white stays (1, 1, 1)."""
    return rec709_from_xyz(primaries[3]) @ xyz_from_rgb(primaries)


def are_usable(primaries: Float[np.ndarray, "4 2"]) -> bool:
    """Whether these are chromaticities at all: finite, no y of 0, and not on one line (some programs write zeros)."""
    if not np.isfinite(primaries).all() or (np.abs(primaries[:, 1]) < 1e-6).any():
        return False
    (x, y), sides = primaries[0], primaries[1:3] - primaries[0]
    area = abs(sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0])
    return bool(area > 1e-6 and np.abs((x, y)).max() < 10.0)


def to_rec709(
    image: Float[np.ndarray, "height width 3"], matrix: Float[np.ndarray, "3 3"]
) -> Float[np.ndarray, "height width 3"]:
    """The image in Rec. 709 by one of the matrices above.

    Colours outside Rec. 709's gamut would have negative components; these are clipped to 0, unless the image already
    held negative values.
    """
    converted = image @ matrix.T.astype(image.dtype)
    if image.min(initial=0.0) >= 0.0:
        np.maximum(converted, 0.0, out=converted)
    return converted
