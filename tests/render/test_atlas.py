"""Pictures of different sizes in one array texture."""

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from reflet.render.playback.atlas import atlas_of


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(1, 40)), max_size=12))
def test_pictures_lie_inside_and_apart(sizes: list[tuple[int, int]]) -> None:
    atlas = atlas_of(sizes)
    width, height, layers = atlas.size
    assert (width, height) == (max((w for w, _ in sizes), default=1), max((h for _, h in sizes), default=1))
    placed = list(zip(atlas.places, sizes, strict=True))
    for (x, y, layer), (w, h) in placed:
        assert 0 <= x <= width - w and 0 <= y <= height - h and 0 <= layer < layers
    for ((x0, y0, z0), (w0, h0)), ((x1, y1, z1), (w1, h1)) in combinations(placed, 2):
        assert z0 != z1 or x0 + w0 <= x1 or x1 + w1 <= x0 or y0 + h0 <= y1 or y1 + h1 <= y0


def test_small_pictures_share_a_layer() -> None:
    """Four quarters lie in one layer."""
    assert atlas_of([(64, 64), *[(32, 32)] * 4]).size == (64, 64, 2)


def test_layers_grow_where_there_would_be_too_many() -> None:
    """An array has at most 256."""
    assert atlas_of([(64, 32)] * 256).size == (64, 32, 256)
    assert atlas_of([(64, 32)] * 1000).size == (128, 64, 250)
