"""Sums over the cells of a `RadianceTree`, compiled: the inner loops of `prefilter`."""

import numpy as np
from numba import njit, prange

SKIP, TAKE, OPEN = 0, 1, 2  # what to do with a cell: leave it out, use it as a whole, look at its children

_BLOCKS = 64  # pieces of work for the threads
_ROOT_CELLS = 24


@njit(cache=True, parallel=True)
def gather(  # type: ignore[no-untyped-def]
    out, direction, tile_starts, tile_centre, centre, light, bright, starts, verdict, table, width
):
    """out[i] = Σ over cells of k(direction[i], cell)·light[cell], for directions in tiles that share their cells.

    ``centre`` (cells, 3), ``light`` (cells, 4) and ``bright`` (cells, 0 or 1) are a tree's, ``starts`` its levels'.
    ``verdict`` (2, levels, bins) says for plain cells and for bright ones, by the half chord x between tile and cell,
    in [0, 1], what to do with a cell. ``table`` holds k at evenly spaced x·(1 + width)/(x + width). All floats are
    float32. Memory: 8 of them a thread for every cell that a tile uses.
    """
    tiles = len(tile_starts) - 1
    for block in prange(_BLOCKS):
        first, last = tiles * block // _BLOCKS, tiles * (block + 1) // _BLOCKS
        _gather(
            out, direction, tile_starts, tile_centre, centre, light, bright, starts, verdict, table, np.float32(width),
            first, last,
        )  # fmt: skip


@njit(cache=True, fastmath=True, error_model="numpy")
def _gather(  # type: ignore[no-untyped-def]
    out, direction, tile_starts, tile_centre, centre, light, bright, starts, verdict, table, width, first, last
):
    cells, weight = np.empty((7, 4096), np.float32), np.empty(4096, np.float32)
    for tile in range(first, last):
        cells, count = _cells_of(cells, tile_centre[tile], centre, light, bright, starts, verdict)
        if len(weight) < count:
            weight = np.empty(2 * count, np.float32)
        for d in range(tile_starts[tile], tile_starts[tile + 1]):
            _sum(out[d], direction[d], cells, weight, count, table, width)


@njit(cache=True, fastmath=True, error_model="numpy")
def _cells_of(cells, tile, centre, light, bright, starts, verdict):  # type: ignore[no-untyped-def]
    """The cells that a tile uses, in columns of centre and light, and their number."""
    bins = verdict.shape[2]
    count = 0
    frontier = np.arange(_ROOT_CELLS)
    for level in range(len(starts)):
        waiting, opened = len(frontier), 0
        if count + waiting > cells.shape[1]:
            more = np.empty((7, 2 * (count + waiting)), np.float32)
            more[:, :count] = cells[:, :count]
            cells = more
        following = np.empty(4 * waiting, np.int64)
        for k in range(waiting):
            i = starts[level] + frontier[k]
            if light[i, 3] <= 0.0:
                continue
            dx, dy, dz = centre[i, 0] - tile[0], centre[i, 1] - tile[1], centre[i, 2] - tile[2]
            x = np.float32(0.5) * np.sqrt(dx * dx + dy * dy + dz * dz)
            what = verdict[bright[i], level, min(int(x * bins), bins - 1)]
            if what == TAKE:
                for c in range(3):
                    cells[c, count] = centre[i, c]
                for c in range(4):
                    cells[3 + c, count] = light[i, c]
                count += 1
            elif what == OPEN:
                for child in range(4):
                    following[opened + child] = 4 * frontier[k] + child
                opened += 4
        frontier = following[:opened]
    return cells, count


@njit(cache=True, fastmath=True, error_model="numpy")
def _sum(out, direction, cells, weight, count, table, width):  # type: ignore[no-untyped-def]
    """Three plain loops, which compilers turn into vector instructions (but for reading the table)."""
    scale = (np.float32(1.0) + width) * np.float32(len(table) - 1)
    last = np.float32(len(table) - 2)
    x, y, z = cells[0], cells[1], cells[2]
    for j in range(count):
        dx, dy, dz = x[j] - direction[0], y[j] - direction[1], z[j] - direction[2]
        half_chord = np.float32(0.5) * np.sqrt(dx * dx + dy * dy + dz * dz)
        weight[j] = half_chord / (half_chord + width) * scale
    for j in range(count):
        entry = np.uint32(min(weight[j], last))
        below = table[entry]
        weight[j] = below + (weight[j] - np.float32(entry)) * (table[entry + np.uint32(1)] - below)
    a, b, c, w = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
    light_a, light_b, light_c, solid_angle = cells[3], cells[4], cells[5], cells[6]
    for j in range(count):
        k = weight[j]
        a += k * light_a[j]
        b += k * light_b[j]
        c += k * light_c[j]
        w += k * solid_angle[j]
    out[0], out[1], out[2], out[3] = a, b, c, w
