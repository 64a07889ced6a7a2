"""Inferring layers: pictures of known maps lead back to them."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic import Picture, mirror_scene, picture, sphere_mesh
from synthetic import layers_of as layers_of_shells

from reflet.envmap.geometry import Box, Ellipsoid
from reflet.envmap.mip_chain import MipChain
from reflet.infer.infer_layer import infer_layer, looking_up
from reflet.infer.product import multiply
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.infer.solve import SolverSettings
from reflet.trace.layers import SegmentedLayers

CHAIN = MipChain(16)
ROOM = Box((-2.0, -0.3, -2.0), (2.0, 2.0, 1.0), (0.0, 0.1, 0.0))
NEAR = Ellipsoid((0.0, 0.0, 0.0), (0.7, 0.5, 0.5), (0.0, 0.0, 0.0))
BIAS = -1.5
THOROUGH = SolverSettings(regularization=1e-4, rounds=(100, 20), tolerance=1e-6)


@pytest.fixture(scope="module")
def two_spheres() -> Picture:
    """Two mirror spheres beside each other, two parts of one object."""
    spheres = [sphere_mesh(0.25, 12, (x, 0.0, 0.0)) for x in (-0.26, 0.26)]
    return picture(mirror_scene(*spheres), (0.3, 0.5, 1.2), 32, sample_count=4)


def random_texels(channels: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random((CHAIN.texel_count, channels)).astype(np.float32)


def layers_of(seen: Picture, distant: np.ndarray, local: np.ndarray) -> SegmentedLayers:
    """Layers of one shell, with the given values a row."""
    opaque = np.ones((len(distant), 1))
    return layers_of_shells(seen, np.concatenate([distant, opaque], 1)[:, None], local)


def no_local(seen: Picture) -> np.ndarray:
    return np.zeros((len(seen.gbuffer.row_pixel), 4))


def test_one_distant_map_serves_all_parts(two_spheres: Picture) -> None:
    matrix = rendering_matrix(two_spheres.gbuffer, CHAIN, ROOM, BIAS)
    distant = multiply(matrix, random_texels(3))
    layers = layers_of(two_spheres, distant, no_local(two_spheres))
    solution = infer_layer("distant", two_spheres.gbuffer, layers, (0, 1), ROOM, CHAIN, BIAS, settings=THOROUGH)
    assert solution.texels.shape == (CHAIN.texel_count, 3)
    # Random texels hold what no picture of this size tells apart; what is left is the penalty's 1e-4 against rows of 1.
    assert np.sqrt(np.mean((multiply(matrix, solution.texels) - distant) ** 2)) < 0.01
    assert solution.relative_residual < 0.02


def test_a_local_map_is_its_parts_alone_and_knows_no_hull(two_spheres: Picture) -> None:
    gbuffer = two_spheres.gbuffer
    on_hull = np.zeros(two_spheres.scene.triangle_offsets[-1], np.bool_)
    on_hull[::3] = True
    select = looking_up(gbuffer, (1,), on_hull)
    assert np.array_equal(
        select, (gbuffer.triangle >= two_spheres.scene.triangle_offsets[1]) & ~on_hull[gbuffer.triangle]
    )
    matrix = rendering_matrix(gbuffer, CHAIN, NEAR, BIAS, select)
    texels = random_texels(4)
    texels[:, :3] *= texels[:, 3:]
    shown = multiply(matrix, texels)
    layers = layers_of(two_spheres, np.ones((len(shown), 3)), shown)
    solution = infer_layer("local", gbuffer, layers, (1,), NEAR, CHAIN, BIAS, on_hull=on_hull, settings=THOROUGH)
    assert np.sqrt(np.mean((multiply(matrix, solution.texels) - shown) ** 2)) < 0.01
    assert solution.texels.min() >= 0.0
    assert solution.texels[:, 3].max() <= 1.0
    # Nothing of the other part: the same map comes out where only this part was traced.
    own = layers.part == 1
    cut = replace(layers, **{k: getattr(layers, k)[own] for k in ROWS})
    again = infer_layer("local", gbuffer, cut, (1,), NEAR, CHAIN, BIAS, on_hull=on_hull, settings=THOROUGH)
    assert np.array_equal(again.texels, solution.texels)


ROWS = ("pixel", "part", "coverage", "diffuse", "fresnel", "distant", "local", "alpha", "combined", "shells")


def test_a_single_layer_takes_all_incident_light(two_spheres: Picture) -> None:
    matrix = rendering_matrix(two_spheres.gbuffer, CHAIN, ROOM, BIAS)
    incident = multiply(matrix, random_texels(3))
    alpha = np.full((len(incident), 1), 0.5)
    layers = layers_of(two_spheres, incident, np.concatenate([0.5 * incident, alpha], 1))
    single = infer_layer("combined", two_spheres.gbuffer, layers, (0, 1), ROOM, CHAIN, BIAS, settings=THOROUGH)
    assert np.sqrt(np.mean((multiply(matrix, single.texels) - incident) ** 2)) < 0.01


def test_rows_that_only_one_side_has_do_not_matter(two_spheres: Picture) -> None:
    """Tracer and rasterizer see slightly different sub-samples: rows are matched by pixel and part."""
    matrix = rendering_matrix(two_spheres.gbuffer, CHAIN, ROOM, BIAS)
    layers = layers_of(two_spheres, multiply(matrix, random_texels(3)), no_local(two_spheres))
    kept = np.random.default_rng(1).random(len(layers.pixel)) < 0.7
    fewer = replace(layers, **{k: getattr(layers, k)[kept] for k in ROWS})
    zeroed = replace(layers, coverage=np.where(kept, layers.coverage, 0.0).astype(np.float32))
    maps = [
        infer_layer("distant", two_spheres.gbuffer, each, (0, 1), ROOM, CHAIN, BIAS).texels for each in (fewer, zeroed)
    ]
    assert np.abs(maps[0] - maps[1]).max() < 1e-5  # rows of weight zero count nowhere
    foreign = replace(fewer, part=fewer.part + 7)
    prior = random_texels(3, 2)
    unseen = infer_layer("distant", two_spheres.gbuffer, foreign, (0, 1), ROOM, CHAIN, BIAS, prior=prior)
    assert np.abs(unseen.texels - prior).max() < 1e-6
