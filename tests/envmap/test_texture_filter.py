"""The texture filter: trilinear, seamless, and its compiled twin."""

import numpy as np
import pytest

from reflet.envmap.compiled_lookup import lookup_direction, taps_into
from reflet.envmap.cube import direction_from_face, face_from_direction, texel_directions
from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, pack
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.texture_filter import padded_index_table, padded_indices, sample, taps

GEOMETRIES = [
    InfiniteSphere(),
    Sphere((0.1, 0.2, -0.1), (2.0, 2.0, 2.0), (0.0, 0.3, 0.0)),
    Ellipsoid((0.1, 0.2, -0.1), (0.9, 1.4, 2.0), (0.0, 0.3, 0.0)),
    Box((-1.0, -0.7, -2.0), (1.5, 0.9, 1.0), (0.0, 0.1, 0.2)),
    Hemisphere((0.0, -0.6, 0.0), (3.0, 3.0, 3.0), -0.6, (0.0, 0.1, 0.0)),
]


def random_directions(count: int, seed: int = 0) -> np.ndarray:
    """Directions all over the sphere, a third of them close to cube edges and corners, where filters go wrong."""
    rng = np.random.default_rng(seed)
    direction = rng.standard_normal((count, 3))
    edge = np.sign(direction) * (1.0 - 0.02 * rng.random((count, 3)))
    edge[::2, 0] = direction[::2, 0] / 3.0
    direction[: count // 3] = edge[: count // 3]
    return direction


@pytest.mark.parametrize("size", [1, 2, 8, 32])
def test_weights_add_up_to_one(size: int) -> None:
    chain = MipChain(size)
    lod = np.random.default_rng(1).uniform(0.0, chain.level_count - 1, 3000)
    indices, weights = taps(chain, random_directions(3000), lod)
    assert weights.min() >= 0.0
    assert indices.min() >= 0
    assert indices.max() < chain.texel_count
    assert np.abs(weights.sum(1) - 1.0).max() < 1e-12  # rounding of eight products in float64


def test_at_a_texel_centre_one_texel_counts() -> None:
    chain = MipChain(16)
    for level, size in enumerate(chain.level_sizes):
        texels = np.arange(chain.texel_count, dtype=np.float64)[:, None]
        direction = texel_directions(size).reshape(-1, 3)
        shown = sample(chain, texels, direction, np.full(len(direction), float(level)))
        # Indices go up to 2046; float64 directions place the centres to 1e-15 of a texel.
        assert np.abs(shown[:, 0] - np.arange(chain.offsets[level], chain.offsets[level + 1])).max() < 1e-9


@pytest.mark.parametrize("size", [2, 4, 16])
def test_padding_crosses_to_the_geometrically_nearest_texel(size: int) -> None:
    chain = MipChain(size)
    table = padded_indices(chain, 0)
    centres = texel_directions(size).reshape(-1, 3)
    position = (2.0 * np.arange(size) + 1.0) / size - 1.0
    for face in range(6):
        for row in range(size):
            beyond = direction_from_face(np.array(face), np.array(-1.0 - 1.0 / size), np.array(position[row]))
            assert table[face, row + 1, 0] == np.argmax(centres @ beyond)
    assert (table < 0).sum() == 24
    assert set(table[table >= 0].tolist()) == set(range(6 * size * size))


@pytest.mark.parametrize("level", [0.0, 1.0, 2.4])
def test_continuous_over_every_edge_and_corner(level: float) -> None:
    chain = MipChain(16)
    texels = np.random.default_rng(2).random((chain.texel_count, 1))
    rng = np.random.default_rng(3)
    along = rng.uniform(-1.0, 1.0, 4000)
    edges = np.stack([np.sign(rng.standard_normal(4000)), np.sign(rng.standard_normal(4000)), along], -1)
    for axis in range(3):
        on = np.roll(edges, axis, 1)
        step = 1e-7 * rng.standard_normal((4000, 3))
        one, other = (sample(chain, texels, on + sign * step, np.full(4000, level)) for sign in (1, -1))
        # Across an edge the two faces blend the same two rows half and half at the edge. Only the position along the
        # edge is read on either face's own grid, and it is the same there: what remains is the step's 1e-7 times 16/2
        # texels times differences of up to 1. A corner's three faces all show the mean of the three texels.
        assert np.abs(one - other).max() < 1e-5


def test_constant_texels_stay_constant() -> None:
    chain = MipChain(32)
    texels = np.full((chain.texel_count, 3), 0.7)
    shown = sample(chain, texels, random_directions(1000), np.linspace(0, 5, 1000))
    assert np.abs(shown - 0.7).max() < 1e-12


def test_compiled_taps_are_the_same() -> None:
    chain = MipChain(32)
    direction = random_directions(2000)
    lod = np.random.default_rng(4).uniform(0.0, 5.0, 2000)
    lod[:50] = 5.0
    indices, weights = taps(chain, direction, lod)
    face, s, t = face_from_direction(direction)
    table, starts = padded_index_table(chain)
    index, weight = np.empty(8, np.int32), np.empty(8)
    for k in range(2000):
        taps_into(index, weight, table, starts, 1, 32, 6, int(face[k]), 0.5 + 0.5 * s[k], 0.5 + 0.5 * t[k], float(lod[k]))
        used = weight > 0
        assert np.array_equal(index[used], indices[k][used])
        assert np.abs(weight - weights[k]).max() < 1e-12  # the same float64 operations up to their order


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: g.kind)
def test_compiled_geometry_is_the_same(geometry) -> None:
    rng = np.random.default_rng(5)
    p, r = rng.uniform(-0.5, 0.5, (500, 3)), rng.standard_normal((500, 3))
    r /= np.linalg.norm(r, axis=1, keepdims=True)
    expected = geometry.lookup_direction(p, r)
    packed = pack(geometry).astype(np.float64)
    found = np.array([lookup_direction(packed, *p[k], *r[k]) for k in range(500)])
    assert np.abs(found - expected).max() < 2e-6  # the packed parameters are float32: 6e-8 of values up to 3, amplified
