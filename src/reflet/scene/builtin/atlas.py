"""Many small pictures in one texture."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, UInt8

from reflet.errors import RefletError

GUTTER = 2  # texels of repeated border, so that bilinear taps never reach a neighbour


def pack(
    tiles: Sequence[UInt8[np.ndarray, "_ _ 3"]], width: int
) -> tuple[UInt8[np.ndarray, "height width 4"], Float[np.ndarray, "tiles 4"]]:
    """The atlas (opaque RGBA, unused texels black) and each tile's rectangle in it: (u, v, extent in u, extent in v).

    Tiles lie on shelves, the highest first. A tile's own uv in [0,1]² maps to rectangle[:2] + uv·rectangle[2:]. Raises
    RefletError where a tile is wider than the atlas.
    """
    order = sorted(range(len(tiles)), key=lambda k: (-tiles[k].shape[0], -tiles[k].shape[1], k))
    corners = np.zeros((len(tiles), 2), int)  # x, y of the tile within its gutter
    x = y = shelf = 0
    for k in order:
        high, wide = tiles[k].shape[0] + 2 * GUTTER, tiles[k].shape[1] + 2 * GUTTER
        if wide > width:
            raise RefletError(f"A tile of {wide - 2 * GUTTER} texels does not fit an atlas of {width}; widen it.")
        if x + wide > width:
            x, y, shelf = 0, y + shelf, 0
        corners[k] = x + GUTTER, y + GUTTER
        x, shelf = x + wide, max(shelf, high)
    height = y + shelf
    atlas = np.zeros((height, width, 4), np.uint8)
    atlas[..., 3] = 255
    rectangles = np.zeros((len(tiles), 4))
    for k, tile in enumerate(tiles):
        (left, top), (high, wide) = corners[k], tile.shape[:2]
        padded = np.pad(tile, ((GUTTER, GUTTER), (GUTTER, GUTTER), (0, 0)), mode="edge")
        atlas[top - GUTTER : top + high + GUTTER, left - GUTTER : left + wide + GUTTER, :3] = padded
        rectangles[k] = left / width, top / height, wide / width, high / height
    return atlas, rectangles
