"""BRDFs: reciprocity, energy, closed forms; and tables of them."""

from pathlib import Path

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.files.measured_brdf_file import read_measured_brdf, write_measured_brdf
from reflet.reflectance.brdfs.brdf import Brdf, directional_albedo, half_vector_cosines
from reflet.reflectance.brdfs.charlie import Charlie, d_charlie
from reflet.reflectance.brdfs.ggx import Ggx, d_ggx
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf, tabulate
from reflet.reflectance.brdfs.phong import Phong

RECIPROCAL: list[Brdf] = [Lambert(), Ggx(0.1), Ggx(0.5), Ggx(1.0), Charlie(0.2), Charlie(1.0), tabulate(Ggx(0.5))]
VIEWS = np.cos(np.deg2rad([0.0, 30.0, 60.0, 80.0]))


def random_pairs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(0)
    cos_i, cos_o = random.uniform(0.01, 1.0, (2, 1000))
    cos_i[:2], cos_o[:2] = 1.0, (1.0, 0.01)
    return cos_i, cos_o, random.uniform(-1.0, 1.0, 1000)


@pytest.mark.parametrize("brdf", RECIPROCAL, ids=lambda brdf: type(brdf).__name__)
def test_reciprocity(brdf: Brdf) -> None:
    cos_i, cos_o, cos_phi = random_pairs()
    there = brdf.evaluate(cos_i, cos_o, cos_phi)
    np.testing.assert_allclose(there, brdf.evaluate(cos_o, cos_i, cos_phi), rtol=1e-9)  # rounding
    assert (there >= 0.0).all()


def test_phong_is_reciprocal_but_for_one_cosine() -> None:
    cos_i, cos_o, cos_phi = random_pairs()
    there = Phong(20.0).evaluate(cos_i, cos_o, cos_phi)[:, 0] * cos_i
    back = Phong(20.0).evaluate(cos_o, cos_i, cos_phi)[:, 0] * cos_o
    np.testing.assert_allclose(there, back, rtol=1e-9)


@pytest.mark.parametrize("brdf", [*RECIPROCAL, Phong(1.0), Phong(50.0)], ids=lambda brdf: type(brdf).__name__)
def test_no_surface_gives_more_than_it_gets(brdf: Brdf) -> None:
    albedo = directional_albedo(brdf, VIEWS)
    assert (albedo <= 1.0 + 1e-4).all()  # the quadrature's error
    assert (albedo > 0.01).all()  # sheen seen along the normal


def test_albedo_in_closed_form() -> None:
    assert directional_albedo(Lambert(), VIEWS) == pytest.approx(1.0, abs=1e-12)
    # Seen along the normal, Phong's lobe is above the surface as a whole.
    assert directional_albedo(Phong(50.0), np.array([1.0])) == pytest.approx(1.0, abs=1e-4)  # the quadrature's error
    # GGX of α = 1 along the normal: D = 1/π, V = 1/(2(1 + c)), ∫ 2c/(2(1 + c)) dc = 1 - ln 2.
    assert directional_albedo(Ggx(1.0), np.array([1.0])) == pytest.approx(1.0 - np.log(2.0), abs=1e-6)


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
def test_microfacets_projected_cover_the_surface(alpha: float) -> None:
    # ∫ D·(n·h) dω = ∫ D·c·2π dc, in x with c = 1 - x² to resolve the peak at c = 1
    node, weight = np.polynomial.legendre.leggauss(400)
    x, dx = 0.5 + 0.5 * node, 0.5 * weight
    c = 1.0 - x * x
    for d in (d_ggx, d_charlie):
        assert (d(c, alpha) * c * 2.0 * np.pi * 2.0 * x * dx).sum() == pytest.approx(1.0, abs=1e-9)  # smooth integrand


def test_half_vector() -> None:
    random = np.random.default_rng(0)
    wi, wo = random.normal(size=(2, 100, 3))
    wi[:, 1], wo[:, 1] = np.abs(wi[:, 1]), np.abs(wo[:, 1])
    wi, wo = (w / np.linalg.norm(w, axis=-1, keepdims=True) for w in (wi, wo))
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    flat_i, flat_o = (w[:, [0, 2]] / np.linalg.norm(w[:, [0, 2]], axis=-1, keepdims=True) for w in (wi, wo))
    n_dot_h, v_dot_h = half_vector_cosines(wi[:, 1], wo[:, 1], (flat_i * flat_o).sum(-1))
    np.testing.assert_allclose(n_dot_h, h[:, 1], atol=1e-12)
    np.testing.assert_allclose(v_dot_h, (h * wo).sum(-1), atol=1e-12)


def test_a_table_follows_its_function_and_survives_a_file(tmp_path: Path) -> None:
    table = tabulate(Ggx(0.5))
    write_measured_brdf(tmp_path / "ggx.npz", table)
    read = read_measured_brdf(tmp_path / "ggx.npz")
    random = np.random.default_rng(1)
    cosines = random.uniform(0.3, 1.0, (2, 500))
    cos_phi = random.uniform(-1.0, 1.0, 500)
    exact, tabulated = (b.evaluate(cosines[0], cosines[1], cos_phi) for b in (Ggx(0.5), read))
    # Steps of 2°: linear interpolation errs by h²/8·f''/f ~ (0.035)²/8·(4/α²) = 0.25 % a direction near the peak.
    np.testing.assert_allclose(tabulated, exact, rtol=0.01)


def test_bad_tables_are_refused(tmp_path: Path) -> None:
    theta, phi = np.array([0.0, 1.5]), np.array([0.0, np.pi])
    with pytest.raises(RefletError, match="ascending"):
        MeasuredBrdf(theta[::-1], theta, phi, np.ones((2, 2, 2, 1)))
    with pytest.raises(RefletError, match="shape"):
        MeasuredBrdf(theta, theta, phi, np.ones((2, 3, 2, 1)))
    with pytest.raises(RefletError, match="negative"):
        MeasuredBrdf(theta, theta, phi, -np.ones((2, 2, 2, 1)))
    np.savez(tmp_path / "incomplete.npz", theta_i=theta, values=np.ones(3))
    with pytest.raises(RefletError, match="theta_o, delta_phi"):
        read_measured_brdf(tmp_path / "incomplete.npz")
    (tmp_path / "no.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(RefletError, match="archive of arrays"):
        read_measured_brdf(tmp_path / "no.npz")


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_bad_parameters_are_refused(bad: float) -> None:
    for each in (Phong, Ggx, Charlie):
        with pytest.raises(RefletError):
            each(bad)
