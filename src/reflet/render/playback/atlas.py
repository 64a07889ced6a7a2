"""Pictures of different sizes in the layers of one array texture."""

from collections.abc import Sequence
from dataclasses import dataclass

MOST_LAYERS = 256  # WebGPU's default


@dataclass(frozen=True)
class Atlas:
    """Where pictures lie: ``places`` are (column, row, layer) of their corners, ``size`` is (width, height, layers)."""

    places: tuple[tuple[int, int, int], ...]
    size: tuple[int, int, int]


def atlas_of(sizes: Sequence[tuple[int, int]]) -> Atlas:
    """Pictures of these widths and heights, in layers as wide and high as the widest and the highest, larger where
    there would be too many layers. Without pictures one texel."""
    width, height = max((w for w, _ in sizes), default=1), max((h for _, h in sizes), default=1)
    while (atlas := _on_shelves(sizes, width, height)).size[2] > MOST_LAYERS:
        width, height = (2 * width, height) if width <= height else (width, 2 * height)
    return atlas


def _on_shelves(sizes: Sequence[tuple[int, int]], width: int, height: int) -> Atlas:
    """The highest pictures first."""
    places: list[tuple[int, int, int]] = [(0, 0, 0)] * len(sizes)
    x, y, layer, shelf = 0, 0, 0, 0
    for k in sorted(range(len(sizes)), key=lambda k: (-sizes[k][1], -sizes[k][0])):
        w, h = sizes[k]
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        if y + h > height:
            x, y, layer, shelf = 0, 0, layer + 1, 0
        places[k] = x, y, layer
        x, shelf = x + w, max(shelf, h)
    return Atlas(tuple(places), (width, height, layer + 1))
