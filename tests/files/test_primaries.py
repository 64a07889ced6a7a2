import numpy as np
import pytest

from reflet.files.pictures.primaries import (
    EQUAL_ENERGY,
    REC709,
    are_usable,
    rec709_from_rgb,
    rec709_from_xyz,
    to_rec709,
    xyz_from_rgb,
)

REC2020 = np.array([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]])
AP0 = np.array([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]])


def test_the_matrix_of_srgb():
    # IEC 61966-2-1, of four digits
    expected = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    np.testing.assert_allclose(xyz_from_rgb(REC709), expected, atol=6e-5)


def test_the_matrix_from_rec_2020():
    # ITU-R BT.2087, of four digits
    expected = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
    np.testing.assert_allclose(rec709_from_rgb(REC2020), expected, atol=6e-5)


@pytest.mark.parametrize("primaries", [REC709, REC2020, AP0], ids=["rec709", "rec2020", "ap0"])
def test_white_stays_white(primaries):
    np.testing.assert_allclose(rec709_from_rgb(primaries) @ np.ones(3), 1.0, atol=1e-12)  # float64 rounding
    np.testing.assert_allclose(rec709_from_xyz(EQUAL_ENERGY) @ np.ones(3), 1.0, atol=1e-12)


def test_rec_709_is_not_changed():
    np.testing.assert_allclose(rec709_from_rgb(REC709), np.eye(3), atol=1e-12)


def test_what_primaries_can_be():
    assert all(are_usable(given) for given in (REC709, REC2020, AP0))
    assert not any(are_usable(given) for given in (np.zeros((4, 2)), np.full((4, 2), np.nan), np.ones((4, 2)) / 3.0))


def test_colours_outside_the_gamut_are_cut_but_negative_pictures_kept():
    green = np.float32([[[0.0, 1.0, 0.0]]])
    assert to_rec709(green, rec709_from_rgb(REC2020)).min() == 0.0
    assert to_rec709(-green, rec709_from_rgb(REC2020)).min() < -1.0
