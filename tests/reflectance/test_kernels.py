"""Kernels of prefiltered maps: normalization, first moments, and what they are the limit of."""

import numpy as np
import pytest

from reflet.reflectance.brdfs.charlie import CharlieKernel
from reflet.reflectance.brdfs.ggx import GgxKernel, d_ggx
from reflet.reflectance.brdfs.kernel import Kernel, sine_squared_of_half
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel

KERNELS: list[Kernel] = [
    DiffuseKernel(),
    *(PhongKernel(n) for n in (0.5, 1.0, 10.0, 1000.0)),
    *(GgxKernel(alpha) for alpha in (1e-3, 0.01, 0.1, 0.5, 0.99, 0.9999, 1.0)),
    *(CharlieKernel(alpha) for alpha in (0.01, 0.2, 1.0)),
]


def over_the_sphere(kernel: Kernel, power: int) -> float:
    """∫ k·cos^power θ dω = 4π·∫ k·(1 - 2s)^power ds, with s = e^x below s = 1/2: narrow lobes span many scales."""
    node, weight = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(np.log(1e-16), np.log(0.5), 101)
    step = edges[1] - edges[0]
    s = np.exp(edges[:-1, None] + step * (0.5 + 0.5 * node))
    return float(4.0 * np.pi * (kernel.density(s) * (1.0 - 2.0 * s) ** power * s * 0.5 * step * weight).sum())


@pytest.mark.parametrize("kernel", KERNELS, ids=repr)
def test_kernels_are_normalized_and_end_at_the_horizon(kernel: Kernel) -> None:
    # What lies below s = 1e-16 is at most 4π·1e-16·k(0), and k(0) < 1/(π·α²) = 1e6/π.
    # The square root with which a Phong exponent of 1/2 ends at the horizon leaves the quadrature 4e-6.
    assert over_the_sphere(kernel, 0) == pytest.approx(1.0, abs=1e-9 if kernel != PhongKernel(0.5) else 1e-5)
    assert (kernel.density(np.array([0.5, 0.7, 1.0])) < 1e-12).all()


def test_first_moments() -> None:
    assert over_the_sphere(DiffuseKernel(), 1) == pytest.approx(2.0 / 3.0, abs=1e-9)
    for n in (1.0, 10.0, 1000.0):
        assert over_the_sphere(PhongKernel(n), 1) == pytest.approx((n + 1.0) / (n + 2.0), abs=1e-9)


def test_limits() -> None:
    s = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(PhongKernel(1.0).density(s), DiffuseKernel().density(s), atol=1e-15)
    np.testing.assert_allclose(GgxKernel(1.0).density(s), DiffuseKernel().density(s), atol=1e-15)
    np.testing.assert_allclose(GgxKernel(1.0 - 1e-7).density(s), DiffuseKernel().density(s), atol=1e-5)


def test_ggx_is_what_engines_sample() -> None:
    """Half vectors of density D·(n·h), mirrored about v = n, weighted by n·l: their histogram over s is the kernel."""
    alpha, count = 0.3, 2_000_000
    u = (np.arange(count) + 0.5) / count
    cos_h = np.sqrt((1.0 - u) / (1.0 + (alpha**2 - 1.0) * u))  # [Karis13]
    n_dot_l = 2.0 * cos_h**2 - 1.0
    edges = np.linspace(0.0, 0.5, 51)
    weight = np.maximum(n_dot_l, 0.0)
    histogram, _ = np.histogram(sine_squared_of_half(n_dot_l), edges, weights=weight / weight.sum())
    middle = 0.5 * (edges[1:] + edges[:-1])
    simpson = sum(w * GgxKernel(alpha).density(x) for w, x in ((1, edges[:-1]), (4, middle), (1, edges[1:]))) / 6.0
    # Simpson's error in the bins of the peak, where k falls by a factor of 2 over a bin
    np.testing.assert_allclose(histogram, simpson * 4.0 * np.pi * 0.01, rtol=2e-3, atol=1e-5)
    assert d_ggx(np.array(1.0), alpha) == pytest.approx(1.0 / (np.pi * alpha**2))
