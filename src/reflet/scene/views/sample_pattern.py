"""The sub-sample positions that maps are inferred and shown with, and how many of them a picture takes.

One table of 64, and three times the same moved by half a pixel: diagonally, across, and down. The first 4 are WebGPU's
standard positions for 4 samples a pixel. With twelve more they lie one in each cell of a 4×4 grid, no two in the same
1/32 column or row, at least 5.6/32 apart (also across the pixel's edges, where the pattern repeats). All 64 lie one in
each cell of an 8×8 grid and one in each of 64 columns and rows, at least 12.7/128 apart; each further 16 have one in
each cell of the 4×4 grid, those far from all before first. A search swapped columns and rows within these grids until
the closest pairs were as far apart as they get.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError

PATTERN = (
    np.array(
        [
            (48, 16), (112, 48), (16, 80), (80, 112), (4, 12), (12, 36), (28, 124), (60, 60),
            (44, 92), (52, 116), (92, 28), (84, 52), (76, 76), (108, 4), (100, 68), (116, 108),
            (37, 59), (9, 57), (19, 105), (99, 97), (67, 11), (31, 25), (111, 83), (1, 75),
            (35, 79), (127, 27), (47, 31), (105, 35), (95, 111), (91, 85), (55, 101), (65, 47),
            (89, 7), (11, 121), (27, 41), (51, 73), (123, 127), (115, 65), (21, 9), (41, 3),
            (43, 45), (7, 91), (71, 123), (103, 19), (125, 43), (73, 63), (33, 99), (75, 89),
            (3, 107), (79, 21), (59, 87), (23, 55), (63, 33), (69, 103), (57, 1), (121, 95),
            (15, 23), (119, 15), (39, 115), (83, 39), (87, 67), (97, 51), (107, 119), (25, 71),
        ],
        dtype=np.float64,
    )
    / 128.0
)  # fmt: skip
PATTERN.setflags(write=False)

_MOVED = np.array([(0.0, 0.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.5)])
_ALL = ((PATTERN + _MOVED[:, None]) % 1.0).reshape(-1, 2)

SAMPLE_COUNTS = (1, 4, 16, 64, 256)


@dataclass(frozen=True)
class Adaptive:
    """Samples where they count: the ``first`` in every pixel, all ``most`` where those disagree."""

    first: int
    most: int

    def __post_init__(self) -> None:
        if not (self.first in SAMPLE_COUNTS and self.most in SAMPLE_COUNTS and 1 < self.first < self.most):
            raise RefletError(
                "An adaptive picture begins with 4, 16 or 64 samples a pixel and goes on to 16, 64 or 256, not from "
                f"{self.first} to {self.most}."
            )

    def __str__(self) -> str:
        return f"{self.first} to {self.most}"


AT_REST, QUICKLY, IN_MOTION = Adaptive(16, 256), Adaptive(16, 64), Adaptive(4, 16)
NAMED_SAMPLES: dict[str, Adaptive] = {"adaptive": AT_REST, "quick": QUICKLY, "motion": IN_MOTION}
Samples = int | Adaptive | str  # a pixel; by name as `NAMED_SAMPLES`


def resolved_samples(samples: Samples) -> int | Adaptive:
    """What a name of `NAMED_SAMPLES` stands for, or the samples a pixel themselves; RefletError for others."""
    if isinstance(samples, str) and samples in NAMED_SAMPLES:
        return NAMED_SAMPLES[samples]
    if isinstance(samples, str) or (isinstance(samples, int) and samples not in SAMPLE_COUNTS):
        names = ", ".join(NAMED_SAMPLES)
        raise RefletError(f"Samples a pixel must be 1, 4, 16, 64 or 256, or one of {names}, not {samples}.")
    return samples


def sample_positions(count: int) -> Float[np.ndarray, "count 2"]:
    """The first 1, 4, 16, 64 or 256 positions as (x, y) from a pixel's top left corner; one is the centre."""
    if count not in SAMPLE_COUNTS:
        raise RefletError(f"Samples a pixel must be 1, 4, 16, 64 or 256, not {count}.")
    return np.array([[0.5, 0.5]]) if count == 1 else _ALL[:count]
