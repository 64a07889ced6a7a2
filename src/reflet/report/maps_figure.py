"""Env maps laid flat: all faces side by side, all coarser mip levels in a second row."""

import numpy as np
from jaxtyping import Float, UInt8

from reflet.envmap.env_map import EnvMap
from reflet.report.measures import EXPOSURE, tone_map

GAP = 2  # pixels of white between levels
PAPER = 1.0


def env_map_sheet(env_map: EnvMap, exposure: float = EXPOSURE) -> UInt8[np.ndarray, "height width 3"]:
    """All faces and mip levels as an sRGB picture, one pixel a texel, in the manner of [Hakura01, Figure 5].

    The first row holds the finest faces from left to right; the second the coarser levels one after the other, which
    together are just narrower. A local map's alpha follows below in the same layout, white opaque.
    """
    levels = [env_map.level(i) for i in range(env_map.chain.level_count)]
    blocks = [_two_rows([tone_map(level[..., :3], exposure) for level in levels])]
    if env_map.texels.shape[1] == 4:
        blocks.append(_two_rows([np.repeat(level[..., 3:], 3, -1) for level in levels]))
    sheet = np.concatenate(
        [blocks[0], *(np.pad(b, ((3 * GAP, 0), (0, 0), (0, 0)), constant_values=PAPER) for b in blocks[1:])]
    )
    return np.round(np.clip(sheet, 0.0, 1.0) * 255.0).astype(np.uint8)


def _two_rows(levels: list[np.ndarray]) -> Float[np.ndarray, "height width 3"]:
    """The finest level's faces, and below them those of all others."""
    finest = _side_by_side(levels[0])
    rows, columns, _ = finest.shape
    sheet = np.full((rows + GAP + max(rows // 2, 1), columns + GAP * len(levels), 3), PAPER)
    sheet[:rows, :columns] = finest
    left = 0
    for level in levels[1:]:
        faces = _side_by_side(level)
        sheet[rows + GAP : rows + GAP + faces.shape[0], left : left + faces.shape[1]] = faces
        left += faces.shape[1] + GAP
    return sheet


def _side_by_side(faces: np.ndarray) -> Float[np.ndarray, "height width 3"]:
    """All faces in one row."""
    return np.concatenate(list(faces), axis=1).astype(np.float64)
