"""Lobes as filters in the plane of a dual paraboloid."""

import numpy as np
import pytest

from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.prefilter.plane_filter import REACH, WIDEST, lobe_angle, plane_filters

# [Heidrich00, sec. 3.2.5]: exponent, filter sizes small and large, shrink factors small and large.
TABLE = [
    (10, 174, 260, 32, 64),
    (50, 78, 136, 16, 32),
    (100, 56, 100, 8, 16),
    (250, 36, 66, 8, 16),
    (500, 26, 48, 4, 8),
]


@pytest.mark.parametrize(("exponent", "small", "large", "shrink_small", "shrink_large"), TABLE)
def test_the_table_of_the_notes(exponent: int, small: int, large: int, shrink_small: int, shrink_large: int) -> None:
    of_middle, of_rim = plane_filters(PhongKernel(exponent), 512, 0.1)
    assert (of_middle.size, of_rim.size) == (small, large)
    assert (1 << of_middle.shrink_level, 1 << of_rim.shrink_level) == (shrink_small, shrink_large)


@pytest.mark.parametrize("exponent", [1.0, 10.0, 300.0])
def test_the_lobe_ends_where_it_falls_below_the_limit(exponent: float) -> None:
    # Forty bisections: the angle is exact but for rounding.
    assert np.cos(lobe_angle(PhongKernel(exponent), 0.1)) ** exponent == pytest.approx(0.1, rel=1e-9)


def test_radii_are_those_of_projected_circles() -> None:
    """Cones of the lobe's angle around a face's middle and around a direction at its rim, projected."""
    kernel = PhongKernel(20.0)
    beta = lobe_angle(kernel, 0.1)
    of_middle, of_rim = plane_filters(kernel, 256)
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    ring = np.stack([np.sin(beta) * np.cos(angle), np.sin(beta) * np.sin(angle), np.full(721, np.cos(beta))], -1)
    _, uv = DualParaboloid().uv_from_direction(ring)
    assert np.hypot(*(2.0 * uv - 1.0).T) == pytest.approx(of_middle.radius, rel=1e-9)
    at_rim = ring[:, [2, 1, 0]]  # around +x
    inner = at_rim[at_rim[:, 2] >= 0.0]
    _, uv = DualParaboloid().uv_from_direction(inner)
    # 721 directions: the innermost is within half a degree squared.
    assert 1.0 - np.hypot(*(2.0 * uv - 1.0).T).min() == pytest.approx(of_rim.radius, rel=1e-4)


@pytest.mark.parametrize("kernel", [PhongKernel(3.0), PhongKernel(400.0), GgxKernel(0.2), DiffuseKernel()], ids=str)
def test_weights(kernel: Kernel) -> None:
    for each in plane_filters(kernel, 256):
        assert each.weights.sum() == pytest.approx(1.0)
        assert each.weights.min() >= 0.0
        assert each.weights[REACH, REACH] == each.weights.max()
        np.testing.assert_allclose(each.weights, each.weights.T)
        assert each.size <= WIDEST << each.shrink_level
        assert each.shrink_level == 0 or each.size > WIDEST << (each.shrink_level - 1)


def test_limits_must_be_shares() -> None:
    with pytest.raises(RefletError, match="between 0 and 1"):
        plane_filters(PhongKernel(10.0), 256, 1.0)
