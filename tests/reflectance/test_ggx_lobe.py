"""Where GGX's lobe points and how wide it is."""

import numpy as np
import pytest

from reflet.reflectance.brdfs.ggx import GgxKernel, d_ggx, v_smith_ggx
from reflet.reflectance.brdfs.ggx_lobe import ggx_lobe, moment

N_DOT_V = np.array([0.15, 0.4, 0.7, 0.95])


def mean_of(n_dot_v: float, alpha: float, lean: float, q: float) -> float:
    """The mean of s^q over D·V·n·l around a lookup that leans so far, by midpoints around the mirrored direction."""
    edge = np.concatenate([[0.0], np.geomspace(1e-3 * alpha, np.pi, 1500)])
    theta, phi = np.meshgrid(0.5 * (edge[1:] + edge[:-1]), np.pi * (np.arange(200) + 0.5) / 200, indexing="ij")
    sin_v = np.sqrt(1.0 - n_dot_v**2)
    towards, mirrored, across = np.array([n_dot_v, sin_v]), np.array([-sin_v, n_dot_v]), np.sin(theta)[..., None]
    light = np.cos(theta)[..., None] * mirrored + across * np.cos(phi)[..., None] * towards
    n_dot_l, v_dot_l = np.maximum(light[..., 1], 1e-9), light @ np.array([sin_v, n_dot_v])
    view = np.full_like(theta, n_dot_v)
    n_dot_h = np.minimum((n_dot_l + n_dot_v) / np.sqrt(2.0 + 2.0 * v_dot_l), 1.0)
    weight = d_ggx(n_dot_h, alpha) * v_smith_ggx(n_dot_l, view, alpha) * n_dot_l * -np.diff(np.cos(edge))[:, None]
    weight[light[..., 1] <= 0.0] = 0.0
    axis = (1.0 - lean) * mirrored + lean * np.array([0.0, 1.0])
    s = np.maximum(0.5 - 0.5 * light @ axis / np.linalg.norm(axis), 0.0)
    return float((weight * s**q).sum() / weight.sum())


@pytest.mark.parametrize("alpha", [0.01, 0.16, 0.4, 0.75])
def test_the_lookup_has_the_moment_of_the_lobe(alpha: float) -> None:
    lean, widening = ggx_lobe(N_DOT_V, alpha, samples=1 << 14).T
    q = moment(alpha)
    s = 0.5 * ((np.arange(1 << 17) + 0.5) / (1 << 17)) ** 4
    for n_dot_v, share, wide in zip(N_DOT_V.tolist(), lean, widening.tolist(), strict=True):
        least = mean_of(n_dot_v, alpha, share, q)
        # It is the least mean. A tenth of the lobe's width aside it is greater by a hundredth or so.
        aside = 0.1 * alpha / np.arccos(n_dot_v)
        assert least < mean_of(n_dot_v, alpha, share - aside, q)
        assert least < mean_of(n_dot_v, alpha, share + aside, q)
        widened = wide**2 * alpha
        if widened < 1.0:
            density = GgxKernel(widened).density(s) * s**0.75
            # Two quadratures of some 10⁴ and 10⁵ points; 129 widths over five decades, linear in their logarithms.
            assert (density * s**q).sum() / density.sum() == pytest.approx(least, rel=0.01)


def test_the_roughest_lobe_does_not_know_the_viewer() -> None:
    # D·V·n·l = n·l/(2π·(n·l + n·v)): symmetric about n, and wider than a cosine lobe.
    lean, widening = ggx_lobe(N_DOT_V, 1.0, samples=1 << 14).T
    np.testing.assert_allclose(lean, 1.0, atol=2e-3)  # golden-ratio steps in azimuth leave an imbalance
    np.testing.assert_allclose(widening, 1.0, atol=1e-9)


def test_narrow_lobes_lie_along_the_mirrored_direction() -> None:
    # A facet's turn by δ in the plane of n and v turns l by 2δ, one across it by 2δ·(n·v), which is known to be the
    # lobes' stretch at grazing angles. So s^q is (cos²φ + (n·v)²·sin²φ)^q of what it is in the kernel, and means of
    # s^q go with alpha^2q = (alpha·widening²)^2q.
    alpha = 1e-3
    lean, widening = ggx_lobe(N_DOT_V[1:], alpha, samples=1 << 14).T
    np.testing.assert_allclose(lean, 0.0, atol=1e-4)
    phi, q = np.pi * (np.arange(1000) + 0.5) / 1000, moment(alpha)
    across = N_DOT_V[1:, None] * np.sin(phi)
    expected = ((np.cos(phi) ** 2 + across**2) ** q).mean(-1) ** (0.25 / q)
    # GGX's tail ends at the horizon, where nothing is small: half of a lobe's mean chord comes from beyond 4·alpha,
    # some thousandths from beyond 1 radian.
    np.testing.assert_allclose(widening, expected, rtol=3e-3)
