"""What shells of env maps show in a picture: the lookups of its G-buffer, composited sample by sample."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float32, Int
from numba import njit, prange

from reflet.envmap.compiled_lookup import compiled_geometry, place, taps_into
from reflet.envmap.env_map import EnvMap
from reflet.envmap.texture_filter import padded_index_table
from reflet.scene.surfaces.gbuffer import GBuffer, Lookups

_BLOCKS = 64


def shown_rows(gbuffer: GBuffer, shells: Sequence[EnvMap], lod_bias: float) -> Float32[np.ndarray, "rows 3"]:
    """Mean radiance of every row of a G-buffer, whose samples have one lookup each (`shown_lookups`)."""
    (lookups,) = gbuffer.lookups
    seen = shown_lookups(lookups, shells, lod_bias)
    row, rows = gbuffer.row_of_sample[lookups.sample], len(gbuffer.row_pixel)
    samples = np.maximum(np.bincount(row, minlength=rows), 1)
    sums = [np.bincount(row, seen[:, channel], rows) for channel in range(3)]
    return (np.stack(sums, -1) / samples[:, None]).astype(np.float32)


def shown_lookups(lookups: Lookups, shells: Sequence[EnvMap], lod_bias: float) -> Float32[np.ndarray, "lookups 3"]:
    """Radiance where the shells, nearest first, are looked up and each lies over the next.

    ``shells`` are maps in the world's frame, all but the last of 4 channels.
    """
    count = len(lookups.sample)
    seen, clear = np.zeros((count, 3), np.float32), np.ones(count, np.float32)
    for env_map in shells:
        chain = env_map.chain
        table, starts = padded_index_table(chain)
        texels = np.ascontiguousarray(env_map.texels, dtype=np.float32)
        _add_shell(
            lookups.position, lookups.direction, lookups.spread, *compiled_geometry(env_map.geometry), np.eye(3),
            chain.parameterization.kind, chain.parameterization.aspect, chain.size, chain.level_count, float(lod_bias),
            table, starts, texels, seen, clear,
        )  # fmt: skip
    return seen


def shown_by_object(
    lookups: Lookups, owner: Int[np.ndarray, "lookups"], shells_of: Sequence[Sequence[EnvMap]], lod_bias: float
) -> Float32[np.ndarray, "lookups 3"]:
    """The same of lookups that each look up the shells of one object, its ``owner``."""
    seen = np.zeros((len(owner), 3), np.float32)
    for index, shells in enumerate(shells_of):
        own = np.flatnonzero(owner == index)
        of_object = Lookups(
            sample=np.arange(len(own), dtype=np.int32),
            weight=lookups.weight[own],
            position=lookups.position[:, own],
            direction=lookups.direction[:, own],
            spread=lookups.spread[own],
        )
        seen[own] = shown_lookups(of_object, shells, lod_bias)
    return seen


@njit(parallel=True, cache=True, error_model="numpy")
def _add_shell(
    position, direction, spread, geometry, faces, map_from_world, kind, aspect, size, level_count, lod_bias, table,
    starts, texels, seen, clear,
):  # type: ignore[no-untyped-def]  # fmt: skip
    count = len(clear)
    for block in prange(_BLOCKS):
        tap, weight = np.empty(8, np.int32), np.empty(8, np.float64)
        value = np.empty(4, np.float64)
        for k in range(block * count // _BLOCKS, (block + 1) * count // _BLOCKS):
            face, u, v, lod = place(
                kind, geometry, faces, map_from_world, position, direction, spread, size, lod_bias, k
            )
            taps_into(tap, weight, table, starts, aspect, size, level_count, face, u, v, lod)
            value[:3] = 0.0
            value[3] = 0.0 if texels.shape[1] == 4 else 1.0
            for j in range(8):
                for c in range(texels.shape[1]):
                    value[c] += weight[j] * texels[tap[j], c]
            for c in range(3):
                seen[k, c] += clear[k] * value[c]
            clear[k] *= 1.0 - value[3]
