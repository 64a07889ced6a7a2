"""Environments turned: texel by texel where that can be, filtered with their energy kept elsewhere."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS, parameterization
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.turned import turned
from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT, turn_about_vertical

EACH = pytest.mark.parametrize("kind", PARAMETERIZATIONS.values(), ids=str)
LATLONG = parameterization("latlong")
Z_UP = SOURCE_FROM_UPRIGHT["z"]


def smooth(direction: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([1.0 + 0.5 * x + 0.2 * y * z, 1.0 + 0.5 * y, 1.0 + 0.5 * z - 0.3 * x * y], -1)


def noise(kind: Parameterization, size: int) -> EnvImage:
    return EnvImage(kind, np.random.default_rng(5).random((*kind.shape(size), 3), np.float32))


@EACH
@pytest.mark.parametrize("matrix", [turn_about_vertical(37.0), Z_UP, Z_UP @ turn_about_vertical(-100.0)])
def test_every_map_shows_the_source_in_turned_directions(kind: Parameterization, matrix: np.ndarray) -> None:
    image = EnvImage(kind, smooth(kind.texel_directions(64)[0]).astype(np.float32))
    made = turned(image, kind, 64, matrix)
    direction, valid = kind.texel_directions(64)
    narrow = np.minimum(*(kind.axis_rates(d)[0] for d in (direction, direction @ matrix.T))) * 64 > 10.0
    # Where texels are up to h = 0.1 wide in both maps. At the kinks of the octahedral maps a footprint's mean is off by
    # h/8 times the slope, of up to 1; a wrong turn is off by 0.5.
    assert np.abs(made.texels - smooth(direction @ matrix.T))[valid & narrow].max() < 0.0125
    assert (valid & narrow).mean() > 0.25


def test_a_turn_is_counter_clockwise_seen_from_above() -> None:
    """What lay along +x, in the middle of a lat-long picture, then lies along -z: a quarter to the left."""
    image = noise(LATLONG, 16)
    made = turned(image, LATLONG, 16, turn_about_vertical(90.0))
    np.testing.assert_array_equal(made.texels, np.roll(image.texels, -8, axis=2))


@pytest.mark.parametrize("columns", [1, 5, -13, 32])
def test_latlong_turned_by_whole_texels_is_rolled(columns: int) -> None:
    image = noise(LATLONG, 16)
    made = turned(image, LATLONG, 16, turn_about_vertical(columns * 360.0 / 32))
    np.testing.assert_array_equal(made.texels, np.roll(image.texels, -columns, axis=2))


def test_a_cube_set_upright_keeps_every_texel() -> None:
    image = noise(CUBE, 8)
    upright = turned(image, CUBE, 8, Z_UP)
    np.testing.assert_array_equal(np.sort(upright.texels.ravel()), np.sort(image.texels.ravel()))
    # the middle of +z, of four texels about it, becomes that of +y; +y's becomes -z's
    for result, source in ((2, 4), (3, 5), (5, 2), (4, 3), (0, 0), (1, 1)):
        np.testing.assert_array_equal(
            np.sort(upright.texels[result].ravel()), np.sort(image.texels[source].ravel()), err_msg=str(result)
        )
    back = turned(upright, CUBE, 8, Z_UP.T)
    np.testing.assert_array_equal(back.texels, image.texels)


@EACH
def test_a_sun_keeps_its_flux_and_its_place(kind: Parameterization) -> None:
    image = EnvImage(kind, np.full((*kind.shape(64), 3), 0.01, np.float32))
    image.texels[0, 21, 38] = 8e4
    matrix = turn_about_vertical(31.0)
    made = turned(image, kind, 64, matrix)
    weight = kind.texel_solid_angle(64)[..., None]
    # As when nothing is turned: exact but for float32, and a ten-thousandth that does not go its own way.
    assert np.abs((weight * made.texels).sum((0, 1, 2)) / (weight * image.texels).sum((0, 1, 2)) - 1.0).max() < 1e-4
    direction = kind.texel_directions(64)[0]
    middle = (weight * made.texels * direction).sum((0, 1, 2))
    expected = matrix.T @ direction[0, 21, 38]
    # Within half a texel, which is at most 0.05 wide here.
    assert np.linalg.norm(middle / np.linalg.norm(middle) - expected) < 0.025
