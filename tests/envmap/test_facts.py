"""Facts of env images against integrals in closed form."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import azimuth_and_elevation, facts
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS

NAMES = list(PARAMETERIZATIONS)


@pytest.mark.parametrize("name", NAMES)
def test_a_clamped_cosine(name: str) -> None:
    """L = max(d·a, 0) has ∫ L dω = π and ∫ L d dω = (2π/3)·a."""
    to = PARAMETERIZATIONS[name]
    axis = np.array([0.48, 0.64, -0.6])
    direction, _ = to.texel_directions(64)
    lobe = np.maximum(direction @ axis, 0.0)
    found = facts(EnvImage(to, np.stack([lobe, 2.0 * lobe, 3.0 * lobe], -1)))
    # Texel centres stand for texels: a midpoint rule, off by O(1/64²), more where texels are long (gazing ball).
    assert found.power == pytest.approx((np.pi, 2 * np.pi, 3 * np.pi), rel=5e-3)
    assert found.mean == pytest.approx((0.25, 0.5, 0.75), rel=5e-3)
    assert found.dominant == pytest.approx(tuple(axis), abs=5e-3)
    assert found.directedness == pytest.approx(2.0 / 3.0, rel=5e-3)
    assert np.degrees(np.arccos(np.clip(np.dot(found.brightest, axis), -1.0, 1.0))) < 3.0  # a texel's 2 degrees
    assert found.least == 0.0 and found.greatest == pytest.approx(3.0, abs=1e-2)


@pytest.mark.parametrize("name", NAMES)
def test_light_from_everywhere_has_no_direction(name: str) -> None:
    to = PARAMETERIZATIONS[name]
    found = facts(EnvImage(to, np.full((*to.shape(32), 4), 0.5)))
    assert found.power == pytest.approx((2 * np.pi,) * 3, rel=1e-6) and len(found.mean) == 3  # alpha plays no part
    assert found.directedness < 1e-2
    assert found.flux_of_brightest == pytest.approx(1e-4, rel=1e-6)


def test_the_brightest_share_of_a_small_sun() -> None:
    """On an even map of 100² texels the brightest 0.01 % of all directions are one texel."""
    to = PARAMETERIZATIONS["equal_area_octahedral"]
    texels = np.ones((1, 100, 100, 1))
    texels[0, 20, 30] = 9999.0
    found = facts(EnvImage(to, texels))
    assert found.flux_of_brightest == pytest.approx(0.5)
    assert found.brightest_radiance == (9999.0,)


def test_a_black_map_has_facts() -> None:
    found = facts(EnvImage(PARAMETERIZATIONS["cube"], np.zeros((6, 4, 4, 3))))
    assert found.power == (0.0, 0.0, 0.0) and found.flux_of_brightest == 0.0 and found.directedness == 0.0


@pytest.mark.parametrize("azimuth, elevation", [(0.0, 0.0), (90.0, 30.0), (200.0, -80.0), (359.0, 5.0)])
def test_azimuth_and_elevation_are_those_of_an_orbit(azimuth: float, elevation: float) -> None:
    phi, theta = np.radians([azimuth, elevation])
    direction = (np.cos(phi) * np.cos(theta), np.sin(theta), -np.sin(phi) * np.cos(theta))
    assert azimuth_and_elevation(tuple(float(c) for c in direction)) == pytest.approx((azimuth, elevation))
