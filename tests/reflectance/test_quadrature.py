"""The brute-force reference against closed forms."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError
from reflet.reflectance.brdfs.charlie import CharlieKernel
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel, sine_squared_of_half
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel

KERNELS: list[Kernel] = [DiffuseKernel(), PhongKernel(20.0), GgxKernel(0.2), CharlieKernel(0.3)]


def some_directions(count: int) -> np.ndarray:
    direction = np.random.default_rng(0).normal(size=(count, 3))
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def linear(parameterization, size: int) -> EnvImage:  # type: ignore[no-untyped-def]
    """L = 1 + ½ω_z."""
    direction, _ = parameterization.texel_directions(size)
    return EnvImage(parameterization, 1.0 + 0.5 * direction[..., 2:])


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
def test_white_furnace(name: str, kernel: Kernel) -> None:
    parameterization = PARAMETERIZATIONS[name]
    image = EnvImage(parameterization, np.full((*parameterization.shape(32), 3), 0.7))
    np.testing.assert_allclose(filtered_reference(image, kernel, some_directions(20)), 0.7, rtol=1e-12)  # divided out
    # Undivided the sum is the quadrature of the kernel itself: texels of 3° against lobes of 10° and more.
    np.testing.assert_allclose(filtered_reference(image, kernel, some_directions(20), normalized=False), 0.7, rtol=0.02)


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_a_linear_environment_keeps_the_kernels_first_moment(name: str) -> None:
    image, direction = linear(PARAMETERIZATIONS[name], 64), some_directions(50)
    z = direction[:, 2:]
    # Midpoint quadrature with texels of at most 3° (cube: 1.8°): relative error of order (0.05)²/24·curvature. The
    # gazing ball's rim is one direction: its last texels reach 20° along the radius.
    within = 4e-3 if name == "gazing_ball" else 1e-3
    np.testing.assert_allclose(filtered_reference(image, DiffuseKernel(), direction), 1.0 + z / 3.0, atol=within)
    for n in (1.0, 20.0):
        expected = 1.0 + 0.5 * (n + 1.0) / (n + 2.0) * z
        np.testing.assert_allclose(filtered_reference(image, PhongKernel(n), direction), expected, atol=within)


def test_a_small_sun_shows_the_kernel() -> None:
    image = EnvImage(CUBE, np.zeros((6, 32, 32, 1)))
    image.texels[4, 10, 20] = 1000.0
    sun = CUBE.texel_directions(32)[0][4, 10, 20]
    power = 1000.0 * CUBE.texel_solid_angle(32)[4, 10, 20]
    direction = some_directions(200)
    for kernel in KERNELS:
        expected = power * kernel.density(sine_squared_of_half(direction @ sun))
        np.testing.assert_allclose(
            filtered_reference(image, kernel, direction, normalized=False)[:, 0], expected, rtol=1e-9, atol=1e-12
        )


def test_a_table_of_a_kernel_filters_alike() -> None:
    theta = np.linspace(0.0, np.pi, 2001)
    table = TabulatedKernel(theta, PhongKernel(20.0).density(np.sin(0.5 * theta) ** 2))
    image, direction = linear(CUBE, 32), some_directions(20)
    by_table, by_formula = (filtered_reference(image, k, direction, False) for k in (table, PhongKernel(20.0)))
    np.testing.assert_allclose(by_table, by_formula, rtol=1e-5)  # h²/8·f''/f = (π/2000)²/8·20


def test_bad_radiance_and_bad_tables_are_refused() -> None:
    for bad, reason in ((-1.0, "negative"), (np.nan, "not finite"), (np.inf, "not finite")):
        image = EnvImage(CUBE, np.ones((6, 2, 2, 3)))
        image.texels[1, 1, 1, 1] = bad
        with pytest.raises(RefletError, match=reason):
            filtered_reference(image, DiffuseKernel(), some_directions(1))
    with pytest.raises(RefletError, match="ascend from 0"):
        TabulatedKernel(np.array([0.1, 1.0]), np.ones(2))
    with pytest.raises(RefletError, match="not negative"):
        TabulatedKernel(np.array([0.0, 1.0]), -np.ones(2))
