"""Radiance that no light has: counted, placed, and replaced by what stands beside it."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.repair import flaws_of, repaired

LATLONG = PARAMETERIZATIONS["latlong"]


def image(value=1.0):
    return EnvImage(LATLONG, np.full((1, 16, 32, 3), value, np.float32))


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_light_without_a_flaw_is_the_same_image(name):
    laid_out = PARAMETERIZATIONS[name]
    sound = EnvImage(laid_out, np.zeros((*laid_out.shape(4), 4), np.float32))
    assert flaws_of(sound) is None
    assert repaired(sound) == (sound, None)


def test_each_kind_is_counted_and_replaced():
    flawed = image(2.0)
    flawed.texels[0, 4, 8] = np.nan
    flawed.texels[0, 4, 9, 1] = np.nan
    flawed.texels[0, 6, 8] = (np.inf, 7.0, np.inf)
    flawed.texels[0, 7, 8] = (-np.inf, 2.0, 2.0)
    flawed.texels[0, 9, 3] = (-1.0, 2.0, 2.0)
    flawed.texels[0, 15, 0] = 5.0  # the brightest there is
    mended, flaws = repaired(flawed)
    assert (flaws.nan, flaws.infinite, flaws.negative) == (2, 2, 1)
    assert flaws.rows == (4, 9)
    expected = image(2.0).texels
    expected[0, 6, 8] = (5.0, 7.0, 5.0)
    expected[0, 7, 8, 0] = 0.0
    expected[0, 9, 3, 0] = 0.0
    expected[0, 15, 0] = 5.0
    np.testing.assert_array_equal(mended.texels, expected)
    assert np.isnan(flawed.texels[0, 4, 8, 0])  # the input stays


def test_where_and_how_much_of_the_light():
    """All of the northern half at -1 against 3 in the southern: a quarter of the light, seen around the zenith."""
    flawed = image(3.0)
    flawed.texels[0, :8] = -1.0
    flaws = flaws_of(flawed)
    assert flaws.negative == 8 * 32
    assert flaws.negative_share == pytest.approx(0.25, abs=1e-6)  # floats
    assert flaws.around[1] == pytest.approx(90.0, abs=1e-6)
    assert str(flaws).startswith("256 negative (25 % of the light) of 512 texels, in rows 0 to 7, around azimuth ")


def test_a_hole_is_filled_from_its_edge_and_nothing_becomes_black():
    flawed = image(4.0)
    flawed.texels[0, :, 16:] = np.nan
    np.testing.assert_array_equal(repaired(flawed)[0].texels, image(4.0).texels)
    np.testing.assert_array_equal(repaired(image(np.nan))[0].texels, image(0.0).texels)
