"""Mesh colours of triangles that were put in another order, and turned around to begin with another corner."""

import numpy as np
from jaxtyping import Int, Shaped, UInt32
from numba import njit


def turned_colours(
    resolution: UInt32[np.ndarray, "triangles"],
    offset: UInt32[np.ndarray, "triangles"],
    colours: Shaped[np.ndarray, "samples channels"],
    sides: Int[np.ndarray, "triangles"],
    order: Int[np.ndarray, "triangles"],
    turn: Int[np.ndarray, "triangles"],
) -> tuple[
    UInt32[np.ndarray, "triangles"], UInt32[np.ndarray, "triangles"], Shaped[np.ndarray, "turned_samples channels"]
]:
    """Resolutions, offsets and colours where triangle k is what was triangle ``order[k]``, and its corner c what was
    corner (c + ``turn[k]``) modulo 3. ``sides`` are 2 of triangles whose backs have samples, else 1."""
    resolution, source = resolution[order], offset[order]
    grid = (resolution.astype(np.int64) + 1) * (resolution + 2) // 2
    counts = np.where(resolution > 0, grid * sides[order], 0)
    offset = (np.cumsum(counts) - counts).astype(np.uint32)
    turned = np.zeros(
        (max(int(counts.sum()), 1), colours.shape[1]), colours.dtype
    )  # tracers gather from no empty table
    _turn(resolution, source, offset, sides[order], turn, colours, turned)
    return resolution, offset, turned


@njit(cache=True)
def _turn(
    resolution: UInt32[np.ndarray, "triangles"],
    source: UInt32[np.ndarray, "triangles"],
    target: UInt32[np.ndarray, "triangles"],
    sides: Int[np.ndarray, "triangles"],
    turn: Int[np.ndarray, "triangles"],
    colours: Shaped[np.ndarray, "samples channels"],
    turned: Shaped[np.ndarray, "turned_samples channels"],
) -> None:
    for t in range(len(resolution)):
        r = np.int64(resolution[t])
        grid = (r + 1) * (r + 2) // 2 if r else 0
        for side in range(sides[t]):
            entry = np.int64(target[t]) + side * grid
            for i in range(r + 1 if r else 0):
                for j in range(r - i + 1):
                    corner = (r - i - j, i, j)  # barycentric coordinates times r
                    was_i, was_j = corner[(1 - turn[t]) % 3], corner[(2 - turn[t]) % 3]
                    was = np.int64(source[t]) + side * grid + was_i * (2 * r + 3 - was_i) // 2 + was_j
                    for channel in range(colours.shape[1]):
                        turned[entry, channel] = colours[was, channel]
                    entry += 1
