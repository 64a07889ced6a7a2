"""The rendering matrix of a picture, known analytically from its G-buffer.

Implements [Hakura01, sec. 4, "EM Inference"]: rendering with an env map is linear in its texels. Where the paper
finds the matrix by test renderings, here each sub-sample's lookup is followed through geometry, face, LOD and filter
taps; the taps of a row's sub-samples are merged.
"""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int64
from numba import njit, prange

from reflet.envmap.compiled_lookup import compiled_geometry, place, taps_into
from reflet.envmap.geometry import Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.texture_filter import padded_index_table
from reflet.infer.records import RenderingMatrix
from reflet.scene.surfaces.gbuffer import GBuffer, Lookups

_SMALLEST_WEIGHT = 1e-9  # of a row: taps that add less are dropped


def rendering_matrix(
    gbuffer: GBuffer,
    chain: MipChain,
    geometry: Geometry,
    lod_bias: float,
    select: Bool[np.ndarray, "samples"] | None = None,
    map_from_world: Float[np.ndarray, "3 3"] | None = None,
) -> RenderingMatrix:
    """The matrix A with one row for each row of ``gbuffer`` and one column a texel of ``chain``.

    A row is the mean over its sub-samples; those that ``select`` leaves out count as zero, so that such a row's weights
    add up to the share of its sub-samples that look the map up. ``map_from_world`` is the rotation of lookup directions
    into the frame of a view-dependent map (`Layer.map_from_world`; of cubes it is not asked for). Deterministic,
    whatever the number of threads. Scratch memory: 12 bytes a filter tap (8 taps a lookup) besides the result.
    """
    lookups, row_starts = _by_row(gbuffer)
    samples_of_row = np.bincount(gbuffer.row_of_sample, minlength=len(gbuffer.row_pixel))
    scale = (lookups.weight / samples_of_row[gbuffer.row_of_sample[lookups.sample]]).astype(np.float32)
    if select is not None:
        scale *= select[lookups.sample]
    table, table_starts = padded_index_table(chain)
    # Each block of rows writes its merged rows one after the other where its first tap would go.
    blocks = np.linspace(0, len(row_starts) - 1, 65).astype(np.int64)
    columns, weights = np.empty(8 * len(scale), np.int32), np.empty(8 * len(scale), np.float32)
    counts = np.zeros(len(row_starts) - 1, np.int64)
    _merge_rows(
        blocks, row_starts, scale, lookups.position, lookups.direction, lookups.spread, *compiled_geometry(geometry),
        np.eye(3) if map_from_world is None else map_from_world, chain.parameterization.kind,
        chain.parameterization.aspect, chain.size, chain.level_count, float(lod_bias), table, table_starts, columns,
        weights, counts,
    )  # fmt: skip
    starts = np.concatenate([[0], np.cumsum(counts)])
    kept_columns, kept_weights = np.empty(starts[-1], np.int32), np.empty(starts[-1], np.float32)
    for low, high in pairwise(blocks):
        source = slice(8 * row_starts[low], 8 * row_starts[low] + starts[high] - starts[low])
        kept_columns[starts[low] : starts[high]] = columns[source]
        kept_weights[starts[low] : starts[high]] = weights[source]
    return RenderingMatrix(starts.astype(np.int32), kept_columns, kept_weights, chain.texel_count)


def _by_row(gbuffer: GBuffer) -> tuple[Lookups, Int64[np.ndarray, "rows_and_one"]]:
    """All lookups in the order of their rows, and where each row's begin."""
    if len(gbuffer.lookups) == 1:
        lookups = gbuffer.lookups[0]
    else:
        sample = np.concatenate([each.sample for each in gbuffer.lookups])
        order = np.argsort(sample, kind="stable")
        lookups = Lookups(
            sample[order],
            np.concatenate([each.weight for each in gbuffer.lookups])[order],
            np.concatenate([each.position for each in gbuffer.lookups], 1)[:, order],
            np.concatenate([each.direction for each in gbuffer.lookups], 1)[:, order],
            np.concatenate([each.spread for each in gbuffer.lookups])[order],
        )
    rows = np.arange(len(gbuffer.row_pixel) + 1)
    return lookups, np.searchsorted(gbuffer.row_of_sample[lookups.sample], rows).astype(np.int64)


@njit(parallel=True, cache=True, error_model="numpy")
def _merge_rows(
    blocks, row_starts, scale, position, direction, spread, geometry, faces, map_from_world, kind, aspect, size,
    level_count, lod_bias, table, table_starts, columns, weights, counts,
):  # type: ignore[no-untyped-def]  # fmt: skip
    longest = 0
    for row in range(len(row_starts) - 1):
        longest = max(longest, row_starts[row + 1] - row_starts[row])
    slots = 16  # of the hash table: a power of two, at least twice the taps of the longest row
    while slots < 16 * longest:
        slots *= 2
    for block in prange(len(blocks) - 1):
        key = np.full(slots, -1, np.int32)
        value = np.zeros(slots, np.float64)
        used = np.empty(slots, np.int32)
        tap, tap_weight = np.empty(8, np.int32), np.empty(8, np.float64)
        out = 8 * row_starts[blocks[block]]
        for row in range(blocks[block], blocks[block + 1]):
            count = 0
            for k in range(row_starts[row], row_starts[row + 1]):
                if scale[k] == 0.0:
                    continue
                face, u, v, lod = place(
                    kind, geometry, faces, map_from_world, position, direction, spread, size, lod_bias, k
                )
                taps_into(tap, tap_weight, table, table_starts, aspect, size, level_count, face, u, v, lod)
                for j in range(8):
                    slot = (tap[j] * 0x9E3779B1) & (slots - 1)
                    while key[slot] != tap[j]:
                        if key[slot] < 0:
                            key[slot] = tap[j]
                            used[count] = slot
                            count += 1
                            break
                        slot = (slot + 1) & (slots - 1)
                    value[slot] += tap_weight[j] * scale[k]
            first = out
            for j in range(count):
                slot = used[j]
                if value[slot] > _SMALLEST_WEIGHT:
                    # Insertion sort: a row has some tens of texels, most of them already in order.
                    at = out
                    while at > first and columns[at - 1] > key[slot]:
                        columns[at], weights[at] = columns[at - 1], weights[at - 1]
                        at -= 1
                    columns[at], weights[at] = key[slot], value[slot]
                    out += 1
                key[slot], value[slot] = -1, 0.0
            counts[row] = out - first
