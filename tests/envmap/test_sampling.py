"""How evenly parameterizations sample: the papers' figures, and closed forms."""

import numpy as np
import pytest

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.sampling import analyze, valid_texels

EACH = pytest.mark.parametrize("p", PARAMETERIZATIONS.values(), ids=str)


@EACH
def test_rates_average_to_an_even_map(p: Parameterization) -> None:
    rates = analyze(p, 400, 96)
    solid_angle = np.sin(rates.angle)[:, None] / np.sin(rates.angle).sum() / 96
    # Midpoint rule; poles where the rate grows as 1/sin θ, and creases, cost it the width of a cell: 1e-3.
    assert (rates.area * solid_angle).sum() == pytest.approx(1.0, abs=2e-3)
    assert (rates.least <= rates.most * (1.0 + 1e-12)).all()
    np.testing.assert_allclose(rates.least * rates.most, rates.area, rtol=1e-12)


@EACH
def test_valid_texels_are_those_that_see_something(p: Parameterization) -> None:
    size = 256
    # A rim crosses some 4·256 texels, each of which counts whole here: 4·256/256² = 1.6 % of a face, of which half.
    assert (p.texel_solid_angle(size) > 0.0).sum() / size**2 == pytest.approx(valid_texels(p), rel=0.02)


@pytest.mark.parametrize(
    ("name", "ratio"),
    [
        ("dual_paraboloid", 4.0),  # [Heidrich98, sec. 3]
        ("cube", 3.0 * np.sqrt(3.0)),  # [Heidrich98, sec. 2]
        ("octahedral", 3.0 * np.sqrt(3.0)),  # the cube's dual: densest where the cube is sparsest
        ("gazing_ball", 1.0),
        ("equal_area_octahedral", 1.0),
        ("latlong", np.inf),
        ("angular", np.inf),
    ],
)
def test_ratio_by_area(name: str, ratio: float) -> None:
    assert analyze(PARAMETERIZATIONS[name]).area_ratio == pytest.approx(ratio, rel=1e-12)


def test_the_sphere_map_is_even_by_area_and_loses_all_resolution_along_its_radius() -> None:
    rates = analyze(PARAMETERIZATIONS["gazing_ball"])
    np.testing.assert_allclose(rates.area, 1.0, rtol=1e-12)
    np.testing.assert_allclose(rates.least, np.cos(rates.angle / 2)[:, None] + 0 * rates.least, rtol=1e-12)
    np.testing.assert_allclose(rates.most, 1 / np.cos(rates.angle / 2)[:, None] + 0 * rates.most, rtol=1e-12)
    assert rates.axis_extremes == (0.0, np.inf) and rates.cost == np.inf and rates.longest_texel == np.inf


def test_the_paraboloid_keeps_angles_and_costs_twice_an_even_map() -> None:
    rates = analyze(PARAMETERIZATIONS["dual_paraboloid"])
    # tan(θ/2) keeps angles. In the middle a texel sees 4 of the disc's π/4·2·size² texels: 4·(π/2)/4π = 1/2 of even.
    assert rates.longest_texel == pytest.approx(1.0, rel=1e-12)
    assert rates.area_extremes == pytest.approx((0.5, 2.0), rel=1e-12)
    assert rates.cost == pytest.approx(2.0, rel=1e-12)


def test_costs_in_closed_form() -> None:
    # The worst axis: the cube's in the middles of faces, 1/2 of 6 texels; lat-long's along the meridians, 1/π of 2.
    assert analyze(PARAMETERIZATIONS["cube"]).cost == pytest.approx(6.0 / np.pi, rel=1e-12)
    assert analyze(PARAMETERIZATIONS["latlong"]).cost == pytest.approx(np.pi / 2.0, rel=1e-12)
    assert analyze(PARAMETERIZATIONS["angular"]).cost == pytest.approx(np.pi**2 / 4.0, rel=1e-12)
