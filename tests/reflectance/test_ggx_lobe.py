"""Where GGX's lobe points and how wide it is."""

import numpy as np
import pytest

from reflet.reflectance.ggx import GgxKernel, d_ggx, v_smith_ggx
from reflet.reflectance.ggx_lobe import ggx_lobe

N_DOT_V = np.array([0.15, 0.4, 0.7, 0.95])


def first_moment(n_dot_v: float, alpha: float) -> np.ndarray:
    """The mean of l over D·V·n·l, as (away from the viewer, up), by midpoints on the hemisphere."""
    z, phi = np.meshgrid((np.arange(1000) + 0.5) / 1000, np.pi * (np.arange(1000) + 0.5) / 1000, indexing="ij")
    x, sin_v = np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - n_dot_v**2)
    v_dot_l = z * n_dot_v - x * sin_v  # x away from the viewer
    view = np.full_like(z, n_dot_v)
    weight = d_ggx((z + n_dot_v) / np.sqrt(2.0 + 2.0 * v_dot_l), alpha) * v_smith_ggx(z, view, alpha) * z
    return np.array([(weight * x).sum(), (weight * z).sum()]) / weight.sum()


@pytest.mark.parametrize("alpha", [0.16, 0.4, 0.75])
def test_the_lookup_has_the_first_moment_of_the_lobe(alpha: float) -> None:
    lean, widening = ggx_lobe(N_DOT_V, alpha, samples=1 << 14).T
    s = (np.arange(1 << 17) + 0.5) / (1 << 18)
    for n_dot_v, share, wide in zip(N_DOT_V.tolist(), lean, widening.tolist(), strict=True):
        moment = first_moment(n_dot_v, alpha)
        towards = (1.0 - share) * np.array([np.sqrt(1.0 - n_dot_v**2), n_dot_v]) + share * np.array([0.0, 1.0])
        length = np.linalg.norm(moment)
        # Two quadratures of some 10⁴ and 10⁶ points.
        np.testing.assert_allclose(towards / np.linalg.norm(towards), moment / length, atol=1e-3)
        widened = wide**2 * alpha
        if widened < 1.0:
            density = GgxKernel(widened).density(s)
            mean_cosine = (density * (1.0 - 2.0 * s)).sum() / density.sum()
            # 129 widths over five decades, linear in their logarithms.
            np.testing.assert_allclose(mean_cosine, length, atol=2e-3)


def test_the_roughest_lobe_does_not_know_the_viewer() -> None:
    # D·V·n·l = n·l/(2π·(n·l + n·v)): symmetric about n, and wider than a cosine lobe.
    lean, widening = ggx_lobe(N_DOT_V, 1.0, samples=1 << 14).T
    np.testing.assert_allclose(lean, 1.0, atol=2e-3)  # golden-ratio steps in azimuth leave an imbalance
    np.testing.assert_allclose(widening, 1.0, atol=1e-9)


def test_narrow_lobes_lie_along_the_mirrored_direction() -> None:
    # A facet's turn by δ in the plane of n and v turns l by 2δ, one across it by 2δ·(n·v), which is known to be the
    # lobes' stretch at grazing angles. Mean squares: widening⁴ = α²_effective/α² = (1 + (n·v)²)/2.
    lean, widening = ggx_lobe(N_DOT_V[1:], 1e-3, samples=1 << 14).T
    np.testing.assert_allclose(lean, 0.0, atol=1e-4)
    # GGX's tail, a thirtieth of the whole for each factor e of angle here, ends at the horizon, where nothing is small.
    np.testing.assert_allclose(widening, ((1.0 + N_DOT_V[1:] ** 2) / 2.0) ** 0.25, rtol=0.05)
