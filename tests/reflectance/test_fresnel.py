"""Fresnel reflectance against the optics it comes from."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflet.reflectance.brdfs.fresnel import (
    f0_from_index,
    fresnel_conductor,
    fresnel_dielectric,
    fresnel_schlick,
    fresnel_table,
)
from reflet.reflectance.brdfs.fresnel_error import schlick_errors

COSINE = np.linspace(0.0, 1.0, 201)


def by_complex_snell(cosine: np.ndarray, index: complex) -> np.ndarray:
    """The textbook's coefficients with a complex angle of refraction."""
    inside = np.sqrt(index**2 - (1.0 - cosine**2) + 0j)
    r_s = (cosine - inside) / (cosine + inside)
    r_p = (index**2 * cosine - inside) / (index**2 * cosine + inside)
    return 0.5 * (np.abs(r_s) ** 2 + np.abs(r_p) ** 2)


@pytest.mark.parametrize("index", [0.6, 1.33, 1.5, 5.0, 200.0])
def test_dielectric_is_the_mean_of_both_polarizations(index: float) -> None:
    cosine = COSINE[1:]
    # At grazing angles 1 - F loses digits to cancellation: a few hundred roundings at index 200.
    np.testing.assert_allclose(fresnel_dielectric(cosine, index), by_complex_snell(cosine, index), atol=1e-12)


@pytest.mark.parametrize("index", [0.05 - 4.0j, 1.5 - 7.6j, 1.1 - 0.1j, 3.0 - 0.0j])
def test_conductor_is_the_mean_of_both_polarizations(index: complex) -> None:
    cosine = COSINE[1:]
    by_formula = fresnel_conductor(cosine, index.real, -index.imag)
    np.testing.assert_allclose(by_formula, by_complex_snell(cosine, index), atol=1e-12)  # as above


@given(st.floats(0.0, 1.0), st.floats(0.05, 50.0), st.floats(0.0, 50.0))
def test_reflectance_is_a_share_and_grazing_light_is_all_reflected(cosine: float, n: float, k: float) -> None:
    value = fresnel_conductor(np.array(cosine), n, k)
    assert -1e-12 <= value <= 1.0 + 1e-12  # rounding
    if abs(n - 1.0) > 1e-6:
        assert fresnel_dielectric(np.array(0.0), n) == pytest.approx(1.0, abs=1e-12)


def test_known_values() -> None:
    assert f0_from_index(1.5) == pytest.approx(0.04)
    assert fresnel_dielectric(np.array(1.0), 1.5) == pytest.approx(0.04)
    assert fresnel_dielectric(np.array(1.0), 1.0 / 1.5) == pytest.approx(0.04)
    # At Brewster's angle, tan θ = n, one polarization vanishes; the other has r_s = (1 - n²)/(1 + n²).
    brewster = np.array(1.0 / np.sqrt(1.0 + 1.5**2))
    assert fresnel_dielectric(brewster, 1.5) == pytest.approx(0.5 * ((1.5**2 - 1.0) / (1.5**2 + 1.0)) ** 2)
    # Beyond the critical angle from the denser side, sin θ > 1/1.5, all is reflected; just before it, not.
    critical = np.sqrt(1.0 - 1.0 / 1.5**2)
    inside = fresnel_dielectric(np.array([critical - 0.01, critical + 0.01]), 1.0 / 1.5)
    assert inside[0] == 1.0
    assert inside[1] < 0.7


def test_schlick_meets_the_exact_formula_at_both_ends_and_errs_between() -> None:
    records = schlick_errors([1.33, 1.5, 2.4, 5.0, 200.0, 0.2 + 3.0j])
    for record in records:
        assert abs(record.exact[0] - record.schlick[0]) < 1e-12  # same formula for f0
        assert abs(record.exact[-1] - record.schlick[-1]) < 1e-12  # all is reflected
    errors = {record.n: record.largest for record in records}
    # Schlick made it for common dielectrics; it knows nothing of a high index's Brewster dip (index 5: F falls from
    # 0.44 before it rises), nor of metals' slight one.
    assert errors[1.5] < 0.04 < errors[1.33] < 0.07 < errors[2.4] < 0.1
    assert errors[5.0] > 0.25
    assert errors[200.0] > 0.49
    assert errors[0.2] < 0.02
    assert abs(next(r.hemispherical for r in records if r.n == 1.5)) < 0.01


def test_the_table_holds_texel_centres() -> None:
    table = fresnel_table(lambda cosine: fresnel_schlick(cosine, np.full(4, 0.04)), size=4)
    np.testing.assert_allclose(table, 0.04 + 0.96 * (1.0 - np.array([0.125, 0.375, 0.625, 0.875])) ** 5, rtol=1e-14)
