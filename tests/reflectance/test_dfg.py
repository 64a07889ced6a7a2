"""The table of the split sum against quadrature and closed forms."""

import numpy as np
import pytest

from reflet.reflectance.brdfs.brdf import directional_albedo, half_vector_cosines
from reflet.reflectance.brdfs.charlie import Charlie
from reflet.reflectance.brdfs.dfg import dfg, dfg_lut, energy_compensation
from reflet.reflectance.brdfs.ggx import Ggx

VIEWS = np.array([0.05, 0.1, 0.3, 0.6, 0.95, 1.0])


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.6, 1.0])
def test_it_is_the_integral(alpha: float) -> None:
    node, weight = np.polynomial.legendre.leggauss(300)
    cos_i, weight_i = 0.5 + 0.5 * node[:, None], 0.5 * weight[:, None]
    cos_phi = np.cos(np.pi * (np.arange(600) + 0.5) / 600)[None, :]
    sampled = dfg(VIEWS, alpha)
    for view, pair in zip(VIEWS, sampled, strict=True):
        cos_o = np.full((1, 1), view)
        _, v_dot_h = half_vector_cosines(cos_i, cos_o, cos_phi)
        each = Ggx(alpha).evaluate(cos_i, cos_o, cos_phi)[..., 0] * cos_i * weight_i * (2.0 * np.pi / 600)
        fresnel = (1.0 - v_dot_h) ** 5
        # 4096 samples; half floats, in which such tables are kept, step by 5e-4 below 1
        np.testing.assert_allclose(pair, [(each * (1 - fresnel)).sum(), (each * fresnel).sum()], atol=4e-4)


def test_closed_forms() -> None:
    # α = 1 along the normal: 1 - ln 2 (see the tests of BRDFs). A mirror reflects all, F of it Schlick's.
    assert dfg(np.array([1.0]), 1.0).sum() == pytest.approx(1.0 - np.log(2.0), abs=1e-4)
    mirror = dfg(VIEWS, 0.0)
    np.testing.assert_allclose(mirror[:, 1], (1.0 - VIEWS) ** 5, atol=1e-3)
    np.testing.assert_allclose(mirror.sum(-1), 1.0, atol=1e-3)


def test_the_table() -> None:
    table = dfg_lut(16, samples=1024)
    centre = (np.arange(16) + 0.5) / 16
    np.testing.assert_allclose(table[12, :, :2], dfg(centre, float(centre[12] ** 2)), atol=3e-3)  # 1024 samples
    sheen = directional_albedo(Charlie(float(centre[12] ** 2)), centre)[:, 0]
    np.testing.assert_allclose(table[12, :, 2], sheen, atol=1e-3)
    assert (table[..., :2] >= 0.0).all()
    assert (table[..., 0] + table[..., 1] < 1.0 + 3e-3).all()
    assert (table[..., 2] < 1.01).all()
    assert (np.diff(table[:, 8, 0] + table[:, 8, 1]) < 3e-3).all()  # rougher surfaces lose more


def test_a_compensated_white_metal_reflects_all() -> None:
    albedo = dfg(VIEWS, 0.8).sum(-1)
    np.testing.assert_allclose(albedo * energy_compensation(np.ones(6), albedo), 1.0, rtol=1e-12)
    np.testing.assert_allclose(energy_compensation(np.zeros(6), albedo), 1.0)
