"""The analytic rendering matrix against lookups made one by one, and against what it must conserve."""

from dataclasses import replace

import numba
import numpy as np
import pytest
import scipy.sparse
from synthetic import Picture, as_scipy, mirror_scene, picture, sphere_mesh

from reflet.envmap.geometry import Box, Ellipsoid, Geometry, Hemisphere, InfiniteSphere, Sphere
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.texture_filter import taps
from reflet.infer.product import Gatherer, multiply, squared_columns
from reflet.infer.records import Rows
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.scene.views.camera import Camera

CHAIN = MipChain(32)
GEOMETRIES = [
    InfiniteSphere(),
    Sphere((0.1, 0.2, -0.1), (2.0, 2.0, 2.0), (0.0, 0.3, 0.0)),
    Ellipsoid((0.1, 0.0, 0.0), (0.5, 0.6, 0.8), (0.0, 0.05, 0.0)),
    Box((-2.0, -0.3, -2.0), (2.0, 2.0, 1.0), (0.0, 0.1, 0.0)),
    Hemisphere((0.0, -0.3, 0.0), (3.0, 3.0, 3.0), -0.3, (0.0, 0.1, 0.0)),
]


CAMERA = Camera((0.8, 0.4, 0.7), (0.0, 0.0, 0.0))  # of the shared picture


def map_from_world(chain: MipChain, camera: Camera) -> np.ndarray:
    """The frame of a map made at a camera."""
    return camera.view_from_world() if chain.parameterization.is_view_dependent else np.eye(3)


def by_single_lookups(
    gbuffer: GBuffer, geometry: Geometry, lod_bias: float, chain: MipChain = CHAIN
) -> scipy.sparse.csr_matrix:
    """The matrix from the NumPy reference of geometry, LOD and filter."""
    lookups = gbuffer.lookups[0]
    position, direction = lookups.position.astype(np.float64), lookups.direction.astype(np.float64)
    met = np.stack([geometry.lookup_direction(position[j], direction[j]) for j in range(3)])
    met = met @ map_from_world(chain, CAMERA).T
    indices, weights = taps(chain, met[0], lod_from_neighbours(chain, met, lod_bias))
    weights /= np.bincount(gbuffer.row_of_sample)[gbuffer.row_of_sample][:, None]
    rows = np.repeat(gbuffer.row_of_sample, 8)
    shape = (len(gbuffer.row_pixel), chain.texel_count)
    return scipy.sparse.csr_matrix((weights.ravel(), (rows, indices.ravel())), shape)


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: g.kind)
def test_equals_single_lookups(sphere_picture: Picture, geometry: Geometry) -> None:
    matrix = as_scipy(rendering_matrix(sphere_picture.gbuffer, CHAIN, geometry, -1.0))
    # Geometry parameters are packed as float32: relative 6e-8, on lookups of 32 texels a face and slopes of 1.
    assert np.abs((matrix - by_single_lookups(sphere_picture.gbuffer, geometry, -1.0)).data).max() < 1e-5


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_all_parameterizations_equal_single_lookups(sphere_picture: Picture, name: str) -> None:
    chain = MipChain(32, PARAMETERIZATIONS[name])
    frame = map_from_world(chain, CAMERA)
    matrix = as_scipy(rendering_matrix(sphere_picture.gbuffer, chain, GEOMETRIES[3], -1.0, None, frame))
    expected = by_single_lookups(sphere_picture.gbuffer, GEOMETRIES[3], -1.0, chain)
    # As above; beside poles and rims directions magnify what geometry rounds, up to tenfold where 32 rows sample them.
    assert np.abs((matrix - expected).data).max() < 1e-4
    assert np.abs(matrix.sum(1).A1 - 1.0).max() < 1e-6  # float32 weights, some tens a row


def test_a_constant_map_shows_constant(sphere_picture: Picture) -> None:
    matrix = rendering_matrix(sphere_picture.gbuffer, CHAIN, GEOMETRIES[3], -1.5)
    shown = multiply(matrix, np.full((CHAIN.texel_count, 3), 0.7, np.float32))
    assert np.abs(shown - 0.7).max() < 0.0005 * 0.7  # the project's bound for a white furnace
    assert matrix.weights.min() > 0.0


def test_columns_are_increasing_and_unique(sphere_picture: Picture) -> None:
    matrix = rendering_matrix(sphere_picture.gbuffer, CHAIN, InfiniteSphere(), 0.0)
    rows = np.repeat(np.arange(len(matrix.starts) - 1), np.diff(matrix.starts))
    key = rows.astype(np.int64) * CHAIN.texel_count + matrix.columns
    assert (np.diff(key) > 0).all()


def test_samples_left_out_count_as_zero(sphere_picture: Picture) -> None:
    gbuffer = sphere_picture.gbuffer
    select = np.random.default_rng(0).random(len(gbuffer.row_of_sample)) < 0.4
    matrix = as_scipy(rendering_matrix(gbuffer, CHAIN, GEOMETRIES[2], -1.0, select))
    share = np.bincount(gbuffer.row_of_sample, weights=select) / np.bincount(gbuffer.row_of_sample)
    assert np.abs(matrix.sum(1).A1 - share).max() < 1e-6  # float32 weights, some tens a row
    rest = as_scipy(rendering_matrix(gbuffer, CHAIN, GEOMETRIES[2], -1.0, ~select))
    whole = as_scipy(rendering_matrix(gbuffer, CHAIN, GEOMETRIES[2], -1.0))
    assert np.abs((matrix + rest - whole).data).max() < 1e-6


def test_lookups_of_several_kinds_add_up(sphere_picture: Picture) -> None:
    gbuffer = sphere_picture.gbuffer
    lookups = gbuffer.lookups[0]
    halves = tuple(replace(lookups, weight=np.full_like(lookups.weight, w)) for w in (0.25, 0.75))
    twice = rendering_matrix(replace(gbuffer, lookups=halves), CHAIN, GEOMETRIES[3], -1.0)
    once = rendering_matrix(gbuffer, CHAIN, GEOMETRIES[3], -1.0)
    assert np.abs((as_scipy(twice) - as_scipy(once)).data).max() < 1e-6  # float32 weights


def test_threads_do_not_change_a_bit(sphere_picture: Picture) -> None:
    found = []
    threads = numba.get_num_threads()
    for count in {1, threads}:
        numba.set_num_threads(count)
        found.append(rendering_matrix(sphere_picture.gbuffer, CHAIN, GEOMETRIES[3], -1.0))
    numba.set_num_threads(threads)
    assert all(np.array_equal(found[0].weights, each.weights) for each in found)
    assert all(np.array_equal(found[0].columns, each.columns) for each in found)


def test_gathering_is_the_transpose_times_the_rows(sphere_picture: Picture) -> None:
    matrix = rendering_matrix(sphere_picture.gbuffer, CHAIN, GEOMETRIES[3], -1.0)
    a, rng = as_scipy(matrix).astype(np.float64), np.random.default_rng(5)
    x, target = rng.random((CHAIN.texel_count, 4)), rng.random((a.shape[0], 4))
    weights = rng.random(a.shape[0])
    rows = Rows(matrix, target.astype(np.float32), weights.astype(np.float32))
    for minus_target in (False, True):
        gatherer = Gatherer(x)
        squares = gatherer.add(rows, minus_target=minus_target)
        shown = a @ x - (target if minus_target else 0.0)
        # float32 sums of some tens of terms each way
        assert squares == pytest.approx((weights[:, None] * shown**2).sum(), rel=1e-5)
        assert np.abs(gatherer.planar_sum().T - a.T @ (weights[:, None] * shown)).max() < 1e-4
    diagonal = np.zeros(CHAIN.texel_count, np.float32)
    squared_columns(rows, diagonal)
    assert np.abs(diagonal - a.power(2).T @ weights).max() < 1e-4


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_a_mirror_sphere_shows_the_analytic_lookup(name: str) -> None:
    """A sphere of 1,056 facets under radiance that is linear in direction, against the true sphere's mirrored rays."""
    axis = np.array([0.3, 0.5, -0.2])
    scene = mirror_scene(sphere_mesh(0.3, 24))
    seen = picture(scene, (0.0, 0.4, 1.5), 24, sample_count=1)
    chain = MipChain(64, PARAMETERIZATIONS[name])
    frame = map_from_world(chain, seen.visibility.camera)
    directions = [chain.parameterization.texel_directions(n)[0].reshape(-1, 3) @ frame for n in chain.level_sizes]
    texels = 1.0 + np.concatenate(directions) @ axis[:, None]
    # Only the finest level: coarser texels of a linear function lie inside the sphere of directions.
    matrix = rendering_matrix(seen.gbuffer, chain, InfiniteSphere(), -20.0, None, frame)
    shown = multiply(matrix, texels.astype(np.float32))[:, 0]

    camera = seen.visibility.camera
    corner, dx, dy = camera.ray_basis()
    pixel = seen.gbuffer.row_pixel
    ray = corner + (pixel % 24 + 0.5)[:, None] * dx + (pixel // 24 + 0.5)[:, None] * dy
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    eye = np.asarray(camera.position)
    along = -ray @ eye
    inside = along**2 - (eye @ eye - 0.09)
    normal = (eye + (along - np.sqrt(np.maximum(inside, 0.0)))[:, None] * ray) / 0.3
    mirrored = ray - 2.0 * np.einsum("ni,ni->n", ray, normal)[:, None] * normal
    facing = -np.einsum("ni,ni->n", ray, normal) > 0.5
    # Facets lie up to 0.4 % of the radius inside the sphere. Where the ray meets them at up to 60° the normal turns by
    # up to 0.4 %·tan 60°, the mirrored ray by twice that, and |axis| is 0.62: 0.9 %. Linear radiance interpolated
    # between texels up to 1/8 apart adds (1/8)²/8·0.62 = 0.1 %; at an octahedron's edges, where directions bend over
    # the texels as |x| does, a quarter of a texel of 1/16: 1 %.
    assert facing.sum() > 80
    assert np.abs(shown - 1.0 - mirrored @ axis)[facing].max() < (0.02 if "octahedral" in name else 0.01)


def test_a_gazing_ball_in_another_frame_shows_another_picture(sphere_picture: Picture) -> None:
    chain = MipChain(32, PARAMETERIZATIONS["gazing_ball"])
    own = rendering_matrix(sphere_picture.gbuffer, chain, GEOMETRIES[3], -1.0, None, CAMERA.view_from_world())
    worlds = rendering_matrix(sphere_picture.gbuffer, chain, GEOMETRIES[3], -1.0)
    assert np.abs((as_scipy(own) - as_scipy(worlds)).data).max() > 0.5
