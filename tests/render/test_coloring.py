"""Colours and names of texels in test renderings."""

import numpy as np
import pytest

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.texture_filter import taps
from reflet.render.coloring import COLOR_COUNT, texel_colors, texel_names, texels_from_names

SIZES = (1, 2, 4, 8, 32)


def directions_everywhere(size: int) -> np.ndarray:
    """All over the sphere, and close to every corner and along every edge of the cube."""
    random = np.random.default_rng(size)
    anywhere = random.normal(size=(20000, 3))
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    near_corners = np.repeat(corners, 500, 0) + random.uniform(-1, 1, (4000, 3)) / size
    edges = random.uniform(-1, 1, (6000, 3))
    axis = random.integers(0, 3, 6000)
    for k in (1, 2):
        row = np.arange(6000), (axis + k) % 3
        edges[row] = np.sign(edges[row]) * (1 + random.uniform(-0.5, 0.5, 6000) / size)
    return np.concatenate([anywhere, near_corners, edges])


@pytest.mark.parametrize("size", SIZES)
def test_no_lookup_weighs_two_texels_of_one_color(size: int) -> None:
    chain = MipChain(size)
    direction = directions_everywhere(size)
    lod = np.random.default_rng(1).uniform(0, chain.level_count - 1, len(direction))
    texel, weight = taps(chain, direction, lod)
    color = texel_colors(chain)[texel]
    for i in range(8):
        for j in range(i):
            both = (weight[:, i] > 0) & (weight[:, j] > 0) & (texel[:, i] != texel[:, j])
            assert not (both & (color[:, i] == color[:, j])).any()


@pytest.mark.parametrize("size", [*SIZES, 256])
def test_names_are_unique_within_a_color_and_lead_back(size: int) -> None:
    chain = MipChain(size)
    colors, names = texel_colors(chain), texel_names(chain)
    assert colors.min() >= 0 and colors.max() < COLOR_COUNT
    assert (names[:, 0] == 1).all()
    for color in range(COLOR_COUNT):
        texels = np.flatnonzero(colors == color)
        np.testing.assert_array_equal(texels_from_names(chain, color, names[texels, 1:]), texels)


def test_names_that_no_texel_has_are_known_as_such() -> None:
    names = np.array([[500, 0, -20], [0, 500, -20], [0, 0, 100], [0, 0, -21]], np.float32)
    assert (texels_from_names(MipChain(16), 0, names) == -1).all()
