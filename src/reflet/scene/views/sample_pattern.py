"""The sub-sample positions that maps are inferred and shown with.

One table of 16, of which the first 4 are WebGPU's standard positions for 4 samples a pixel. The other twelve lie one in
each remaining cell of a 4×4 grid, no two in the same 1/32 column or row, at least 5.6/32 apart (also across the pixel's
edges, where the pattern repeats).
"""

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError

PATTERN = (
    np.array(
        [
            (12, 4), (28, 12), (4, 20), (20, 28), (1, 3), (3, 9), (7, 31), (15, 15),
            (11, 23), (13, 29), (23, 7), (21, 13), (19, 19), (27, 1), (25, 17), (29, 27),
        ],
        dtype=np.float64,
    )
    / 32.0
)  # fmt: skip
PATTERN.setflags(write=False)

SAMPLE_COUNTS = (1, 4, 16)


def sample_positions(count: int) -> Float[np.ndarray, "count 2"]:
    """The first ``count`` (1, 4 or 16) positions as (x, y) from a pixel's top left corner; one sample is the centre."""
    if count not in SAMPLE_COUNTS:
        raise RefletError(f"Samples a pixel must be 1, 4 or 16, not {count}.")
    return np.array([[0.5, 0.5]]) if count == 1 else PATTERN[:count]
