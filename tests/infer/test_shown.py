"""What maps show of shells, and what rows ask of them: beside NumPy, and back to the maps that were shown."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic import Picture, layers_of, mirror_scene, picture, sphere_mesh

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief
from reflet.infer.infer_layer import infer_map, layer_rows
from reflet.infer.product import multiply
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.infer.shown import shown_rows
from reflet.infer.solve import SolverSettings

ROOM = Box((-2.0, -0.3, -2.0), (2.0, 2.0, 1.0), (0.0, 0.1, 0.0))
BIAS = -1.5
INVERSE = (1.5 + 0.4 * np.sin(3.0 * texel_directions(8)).sum(-1)).astype(np.float16)
NEAR = Relief(INVERSE, ROOM.lower, ROOM.upper, ROOM.origin)


@pytest.fixture(scope="module")
def seen() -> Picture:
    """Two mirror spheres side by side, parts of one object."""
    spheres = [sphere_mesh(0.25, 12, (x, 0.0, 0.0)) for x in (-0.26, 0.26)]
    return picture(mirror_scene(*spheres), (0.3, 0.5, 1.2), 24, sample_count=4)


def env_map(chain: MipChain, channels: int, geometry: Geometry, seed: int = 0) -> EnvMap:
    """Random texels, premultiplied where they have an alpha."""
    texels = np.random.default_rng(seed).random((chain.texel_count, channels)).astype(np.float32)
    if channels == 4:
        texels[:, :3] *= texels[:, 3:]
    return EnvMap(chain, texels, geometry)


def by_sample(seen: Picture, each: EnvMap) -> np.ndarray:
    """What every sub-sample looks up, by the matrix of a picture with a row for each of them."""
    count = len(seen.gbuffer.triangle)
    rows = np.arange(count, dtype=np.int32)
    apart = replace(seen.gbuffer, row_pixel=rows, row_part=np.zeros(count, np.int32), row_of_sample=rows)
    return multiply(rendering_matrix(apart, each.chain, each.geometry, BIAS), each.texels).astype(np.float64)


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
@pytest.mark.parametrize("geometry", [ROOM, NEAR], ids=lambda g: g.kind)
def test_one_shell_is_the_rendering_matrixs_product(seen: Picture, name: str, geometry: Geometry) -> None:
    only = env_map(MipChain(16, PARAMETERIZATIONS[name]), 3, geometry)
    expected = multiply(rendering_matrix(seen.gbuffer, only.chain, geometry, BIAS), only.texels)
    assert np.abs(shown_rows(seen.gbuffer, [only], BIAS) - expected).max() < 1e-5  # float32 sums of some tens of terms
    assert expected.std() > 0.05


@pytest.mark.parametrize("name", ["cube", "octahedral", "latlong"])
def test_shells_are_composited_sample_by_sample(seen: Picture, name: str) -> None:
    """Not row by row: within a pixel light is where the nearer shell is not."""
    chain = MipChain(16, PARAMETERIZATIONS[name])
    shells = [
        env_map(chain, 4, NEAR, 1),
        env_map(MipChain(8, chain.parameterization), 4, ROOM, 2),
        env_map(chain, 3, ROOM, 3),
    ]
    near, middle, far = (by_sample(seen, each) for each in shells)
    light = near[:, :3] + (1 - near[:, 3:]) * (middle[:, :3] + (1 - middle[:, 3:]) * far)
    row = seen.gbuffer.row_of_sample
    mean = np.stack([np.bincount(row, light[:, c]) for c in range(3)], -1) / np.bincount(row)[:, None]
    assert np.abs(shown_rows(seen.gbuffer, shells, BIAS) - mean).max() < 1e-5
    opaque = EnvMap(chain, np.concatenate([shells[2].texels, np.ones((chain.texel_count, 1), np.float32)], 1), ROOM)
    hidden = shown_rows(seen.gbuffer, [opaque, shells[2]], BIAS)
    assert np.abs(hidden - shown_rows(seen.gbuffer, [shells[2]], BIAS)).max() < 1e-5


def test_rows_of_shells_have_the_weights_that_are_told(seen: Picture) -> None:
    """coverage/(1 + b)² · ((1 - α)² + 0.02), and so on for every shell that is nearer; b is what all of them show."""
    rows, random = len(seen.gbuffer.row_pixel), np.random.default_rng(4)
    shells, local = random.random((rows, 3, 4)), random.random((rows, 4))
    layers = layers_of(seen, shells, local)
    weight = layers.coverage / (1.0 + layers.distant.max(1)) ** 2 * ((1.0 - layers.alpha) ** 2 + 0.02)
    for number, channels in ((0, 4), (1, 4), (2, 3)):
        found = layer_rows(
            "distant", seen.gbuffer, layers, (0, 1), ROOM, MipChain(8), BIAS, shell=number, channels=channels
        )  # type: ignore[arg-type]
        np.testing.assert_allclose(found.weights, weight, rtol=1e-5)
        np.testing.assert_array_equal(found.target, layers.shells[:, number, :channels])
        weight = weight * ((1.0 - layers.shells[:, number, 3]) ** 2 + 0.02)
    one = layer_rows("distant", seen.gbuffer, layers, (1,), ROOM, MipChain(8), BIAS, shell=2)
    np.testing.assert_array_equal(one.weights > 0.0, layers.part == 1)  # other parts look nothing up


def test_two_shells_are_found_again(seen: Picture) -> None:
    """Targets row by row are what the maps show; together they then show the picture they came from, but for products
    within pixels."""
    chain = MipChain(8)
    y = np.concatenate([chain.parameterization.texel_directions(size)[0].reshape(-1, 3) for size in chain.level_sizes])
    alpha = np.clip(0.5 + y[:, 1:2], 0.0, 1.0)
    truth = [
        EnvMap(chain, np.concatenate([alpha * (0.6 + 0.4 * y), alpha], 1).astype(np.float32), NEAR),
        EnvMap(chain, (0.5 + 0.5 * y[:, ::-1] ** 2).astype(np.float32), ROOM),
    ]
    wanted = [multiply(rendering_matrix(seen.gbuffer, chain, each.geometry, BIAS), each.texels) for each in truth]
    shells = np.stack([wanted[0], np.concatenate([wanted[1], np.ones((len(wanted[1]), 1))], 1)], 1)
    layers = layers_of(seen, shells, np.zeros((len(shells), 4)))
    found = []
    for number, each in enumerate(truth):
        channels = each.texels.shape[1]
        rows = layer_rows(
            "distant", seen.gbuffer, layers, (0, 1), each.geometry, chain, BIAS, shell=number, channels=channels
        )  # type: ignore[arg-type]
        settings = SolverSettings(regularization=1e-4, rounds=(100, 20), tolerance=1e-6)
        solution = infer_map([rows], np.zeros_like(each.texels), chain, settings)
        assert solution.texels.shape == each.texels.shape and solution.relative_residual < 0.01
        assert solution.texels.min() >= 0.0 and (channels == 3 or solution.texels[:, 3].max() <= 1.0)
        found.append(EnvMap(chain, solution.texels, each.geometry))
    shown, expected = (shown_rows(seen.gbuffer, maps, BIAS) for maps in (found, truth))
    assert np.sqrt(np.mean((shown - expected) ** 2)) < 0.01  # the penalty's 1e-4 against rows of weight 1
    assert expected.std() > 0.05
