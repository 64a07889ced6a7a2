"""What inference hands on. Imports nothing heavy."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int32


@dataclass(frozen=True)
class RenderingMatrix:
    """The sparse matrix A of a picture: row value = Σ weight·texel, in compressed sparse rows.

    Row r holds ``columns[starts[r]:starts[r + 1]]`` (texel indices in the order of `MipChain`, increasing, no
    duplicates) and their ``weights``. Weights are at least 0; a row's weights add up to at most 1, and to 1 where all
    its samples look the map up.
    """

    starts: Int32[np.ndarray, "rows_and_one"]
    columns: Int32[np.ndarray, "entries"]
    weights: Float32[np.ndarray, "entries"]
    texel_count: int


@dataclass(frozen=True)
class Rows:
    """Rows of a least-squares problem: what ``matrix`` times the texels should give, and each row's weight."""

    matrix: RenderingMatrix
    target: Float32[np.ndarray, "rows channels"]
    weights: Float32[np.ndarray, "rows"]


@dataclass(frozen=True)
class Solution:
    """A least-squares solve: its value and how it went.

    ``relative_residual`` is ‖b - A·x‖ / ‖b‖ with the solve's row weights; ``seen_share`` the share of texels (of all
    levels) that any row of positive weight sees.
    """

    texels: Float32[np.ndarray, "texels channels"]
    iterations: int
    relative_residual: float
    seen_share: float
