"""The texture filter: trilinear, seamless, and its compiled twin."""

import numpy as np
import pytest
from reliefs import plane_relief

from reflet.envmap.compiled_lookup import compiled_geometry, lookup_direction, place, taps_into
from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, lookup_directions, pack
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE, direction_from_face, texel_directions
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.texture_filter import padded_index_table, padded_indices, sample, taps

EACH = pytest.mark.parametrize("p", PARAMETERIZATIONS.values(), ids=str)
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


@EACH
@pytest.mark.parametrize("size", [1, 2, 8, 32])
def test_weights_add_up_to_one(p: Parameterization, size: int) -> None:
    chain = MipChain(size, p)
    lod = np.random.default_rng(1).uniform(0.0, chain.level_count - 1, 3000)
    indices, weights = taps(chain, random_directions(3000), lod)
    assert weights.min() >= 0.0
    assert indices.min() >= 0
    assert indices.max() < chain.texel_count
    assert np.abs(weights.sum(1) - 1.0).max() < 1e-12  # rounding of eight products in float64


@EACH
def test_at_a_texel_centre_one_texel_counts(p: Parameterization) -> None:
    chain = MipChain(16, p)
    texels = np.arange(chain.texel_count, dtype=np.float64)[:, None]
    for level, size in enumerate(chain.level_sizes):
        direction, valid = p.texel_directions(size)
        # Valid texels on a rim or where seams meet may be looked up on its other side: there two texels are one place.
        inside = valid & (size > 1)
        shown = sample(chain, texels, direction[inside], np.full(inside.sum(), float(level)))
        # Indices go up to 2046; float64 directions place the centres to 1e-15 of a texel.
        assert np.abs(shown[:, 0] - chain.level(texels[:, 0], level)[inside]).max(initial=0.0) < 1e-9


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


def test_constant_texels_stay_constant() -> None:
    chain = MipChain(32)
    texels = np.full((chain.texel_count, 3), 0.7)
    shown = sample(chain, texels, random_directions(1000), np.linspace(0, 5, 1000))
    assert np.abs(shown - 0.7).max() < 1e-12


@EACH
def test_compiled_taps_are_the_same(p: Parameterization) -> None:
    chain = MipChain(32, p)
    direction = random_directions(1000)
    lod = np.random.default_rng(4).uniform(0.0, 5.0, 1000)
    lod[:50] = 5.0
    indices, weights = taps(chain, direction, lod)
    face, uv = p.uv_from_direction(direction)
    table, starts = padded_index_table(chain)
    index, weight = np.empty(8, np.int32), np.empty(8)
    for k in range(1000):
        taps_into(index, weight, table, starts, p.aspect, 32, 6, int(face[k]), *uv[k].tolist(), float(lod[k]))
        used = weight > 0
        assert np.array_equal(index[used], indices[k][used])
        assert np.abs(weight - weights[k]).max() < 1e-12  # the same float64 operations up to their order


@EACH
@pytest.mark.parametrize("geometry", [*GEOMETRIES, plane_relief(0.5, size=32)], ids=lambda g: g.kind)
def test_compiled_places_are_the_same(geometry, p: Parameterization) -> None:
    """Where a mirrored ray looks the map up, and how coarsely: geometry, parameterization and LOD in one."""
    rng = np.random.default_rng(6)
    position = rng.uniform(-0.3, 0.3, (1, 200, 3)) + 0.01 * rng.standard_normal((3, 200, 3))
    ray = rng.standard_normal((1, 200, 3)) + 0.01 * rng.standard_normal((3, 200, 3))
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    met = lookup_directions(geometry, position, ray)
    map_from_world = np.eye(3) if p == CUBE else np.linalg.qr(rng.standard_normal((3, 3)))[0]
    met = met @ map_from_world.T
    lod = lod_from_neighbours(MipChain(256, p), met, -1.0)
    face, uv = p.uv_from_direction(met[0])
    packed = compiled_geometry(geometry)
    mirrors = np.zeros(200, np.float32)
    found = np.array([place(p.kind, *packed, map_from_world, position, ray, mirrors, 256, -1.0, k) for k in range(200)])
    np.testing.assert_array_equal(found[:, 0], face)
    # The packed parameters are float32: 6e-8 of values up to 3, amplified, and of steps of 0.01 a hundred times that.
    np.testing.assert_allclose(found[:, 1:3], uv, atol=2e-6)
    np.testing.assert_allclose(found[:, 3], lod, atol=2e-4)


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: g.kind)
def test_compiled_geometry_is_the_same(geometry) -> None:
    rng = np.random.default_rng(5)
    p, r = rng.uniform(-0.5, 0.5, (500, 3)), rng.standard_normal((500, 3))
    r /= np.linalg.norm(r, axis=1, keepdims=True)
    expected = geometry.lookup_direction(p, r)
    packed = pack(geometry).astype(np.float64)
    found = np.array([lookup_direction(packed, *p[k], *r[k]) for k in range(500)])
    assert np.abs(found - expected).max() < 2e-6  # the packed parameters are float32: 6e-8 of values up to 3, amplified
