"""Colours and names of texels in test renderings."""

import numpy as np
import pytest

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.texture_filter import padded_index_table, taps
from reflet.render.playback.coloring import coloring

SIZES = (1, 2, 4, 8, 32)
ALL = [MipChain(size, parameterization) for parameterization in PARAMETERIZATIONS.values() for size in SIZES]


def directions_everywhere(chain: MipChain) -> np.ndarray:
    """All over the sphere, and close to every place of the border of every face."""
    random = np.random.default_rng(chain.size)
    faces, rows, columns = chain.level_shape(0)
    uv = random.uniform(-0.5, 0.5, (20000, 2)) / (columns, rows)
    side, along = random.integers(0, 4, 20000), random.uniform(0, 1, 20000)
    uv[:, 0] += np.choose(side, [0.0, 1.0, along, along])
    uv[:, 1] += np.choose(side, [along, along, 0.0, 1.0])
    corner = random.random(20000) < 0.2
    uv[corner] = random.integers(0, 2, (20000, 2))[corner] + random.uniform(-1, 1, (20000, 2))[corner] / (columns, rows)
    beside, _ = chain.parameterization.direction_from_uv(random.integers(0, faces, 20000), np.clip(uv, 0.0, 1.0))
    axes = np.repeat(np.concatenate([np.eye(3), -np.eye(3)]), 500, 0) + random.normal(size=(3000, 3)) / rows
    return np.concatenate([random.normal(size=(20000, 3)), beside, axes])


@pytest.mark.parametrize("chain", ALL, ids=str)
def test_no_lookup_weighs_two_texels_of_one_color(chain: MipChain) -> None:
    direction = directions_everywhere(chain)
    lod = np.random.default_rng(1).uniform(0, chain.level_count - 1, len(direction))
    texel, weight = taps(chain, direction, lod)
    color = coloring(chain).colors[texel]
    for i in range(8):
        for j in range(i):
            both = (weight[:, i] > 0) & (weight[:, j] > 0) & (texel[:, i] != texel[:, j])
            assert not (both & (color[:, i] == color[:, j])).any()


@pytest.mark.parametrize("chain", ALL, ids=str)
def test_no_footprint_holds_two_texels_of_one_color(chain: MipChain) -> None:
    """Every 2×2 window of the table, whether a direction leads there or not."""
    colors, (table, starts) = coloring(chain).colors, padded_index_table(chain)
    for level, start in enumerate(starts):
        faces, rows, columns = chain.level_shape(level)
        count = faces * (rows + 2) * (columns + 2)
        index = table[start : start + count].reshape(faces, rows + 2, columns + 2)
        windows = [index[:, j : j + rows + 1, i : i + columns + 1].ravel() for j in (0, 1) for i in (0, 1)]
        for k in range(4):
            for m in range(k):
                a, b = windows[k], windows[m]
                assert not ((a >= 0) & (b >= 0) & (a != b) & (colors[a] == colors[b])).any()


def test_few_colors() -> None:
    """Four are the least of any plane grid; seams take some more. Two classes of levels."""
    counts = {name: coloring(MipChain(64, p)).color_count for name, p in PARAMETERIZATIONS.items()}
    assert counts["latlong"] == 8
    assert counts["cube"] <= 12 and max(counts.values()) <= 14


@pytest.mark.parametrize("chain", [*ALL, MipChain(256)], ids=str)
def test_names_are_unique_within_a_color_and_lead_back(chain: MipChain) -> None:
    known = coloring(chain)
    shown = np.zeros(chain.texel_count, int)
    for color in range(known.color_count):
        names = known.names(color)
        texels = np.flatnonzero(names[:, 0])
        shown[texels] += 1
        assert (names[texels, 0] == 1).all() and (known.colors[texels] == color).all()
        np.testing.assert_array_equal(known.texels_of(color, names[texels, 1:]), texels)
    assert (shown == 1).all()
    assert known.base < 50  # small numbers: names of up to 25, of which filters round off less than 1e-5


def test_names_that_no_texel_has_are_known_as_such() -> None:
    names = np.array([[500, 0, 0], [0, 500, 0], [0, 0, -100], [0, -20, 0]], np.float32)
    assert (coloring(MipChain(16)).texels_of(0, names) == -1).all()
