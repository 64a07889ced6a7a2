"""Taps of a BRDF's lobes."""

import numpy as np
import pytest

from reflet.reflectance.brdfs.brdf import FunctionBrdf
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.lobes.brdf_taps import brdf_taps
from reflet.reflectance.lobes.lobe_taps import MOST_TAPS, LobeTaps
from reflet.reflectance.lobes.lobes import THETA, Lobes, fit_lobes


def paint(cos_i: np.ndarray, cos_o: np.ndarray, delta_phi: np.ndarray) -> np.ndarray:
    """Red ground, a highlight that is yellow and narrow in its middle, and a blue one back to the viewer."""
    sines = np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2))
    mirrored, back = (np.maximum(cos_i * cos_o + side * sines * np.cos(delta_phi), 0.0) for side in (-1.0, 1.0))
    lobes = mirrored**20, mirrored**60, back**15
    colours = (1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (0.2, 0.4, 1.0)
    return 0.1 * np.array([1.0, 0.3, 0.2]) + sum(
        lobe[..., None] * np.array(colour) for lobe, colour in zip(lobes, colours, strict=True)
    )


@pytest.fixture(scope="module")
def lobes() -> Lobes:
    return fit_lobes(FunctionBrdf(paint), angles=3)


@pytest.fixture(scope="module")
def taps(lobes: Lobes) -> tuple[LobeTaps, ...]:
    return brdf_taps(lobes)


def test_weights_add_up_to_what_lobes_reflect(lobes: Lobes, taps: tuple[LobeTaps, ...]) -> None:
    albedo = np.concatenate([lobe.albedo for lobe in lobes.lobes])
    assert len(taps) == len(albedo)
    for one, expected in zip(taps, albedo, strict=True):
        assert len(one.blur) <= MOST_TAPS
        assert one.weight.min(initial=0.0) >= 0.0
        # Slices that reflect next to nothing may be left black.
        np.testing.assert_allclose(one.weight.sum(0), expected, rtol=1e-9, atol=1e-4)


def density(one: LobeTaps, direction: np.ndarray) -> np.ndarray:
    """Of true blurs, von Mises and Fisher's, around the taps."""
    sharpness = 1.0 / one.blur**2
    scale = one.weight.T * sharpness / (-2.0 * np.pi * np.expm1(-2.0 * sharpness))
    return np.exp(sharpness * (direction @ one.direction.T - 1.0)) @ scale.T


def test_blurs_add_up_to_the_lobes_in_each_channel(lobes: Lobes, taps: tuple[LobeTaps, ...]) -> None:
    """∫ |Σ w·g - k| dω, as a share of what the lobe reflects, on a polar grid: θ = π·x², midpoints."""
    x = (np.arange(200) + 0.5) / 200
    theta, phi = np.meshgrid(np.pi * x * x, 2.0 * np.pi * np.arange(24) / 24, indexing="ij")
    solid_angle = (np.sin(theta) * (2.0 * np.pi * x / 200)[:, None] * (2.0 * np.pi / 24))[..., None]
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    slices = np.concatenate([lobe.densities for lobe in lobes.lobes])
    for one, densities in zip(taps, slices, strict=True):
        kernel = np.stack([np.interp(theta, THETA, densities[:, c]) for c in range(3)], -1)
        if (kernel * solid_angle).sum() < 1e-2:  # hundredths of what the others reflect
            continue
        apart = (np.abs(density(one, direction) - kernel) * solid_angle).sum((0, 1))
        # A broad floor below a peak, of which one ring stands for all, costs most, here a tenth of the blue. A search
        # that begins without one ends at a fifth; one channel's weights for all would leave as much.
        assert (apart < 0.13 * (kernel * solid_angle).sum((0, 1)) + 1e-4).all()
        assert apart.sum() < 0.06 * (kernel * solid_angle).sum()


def test_one_channel_becomes_three_and_diffuse_reflection_has_no_taps() -> None:
    one = fit_lobes(FunctionBrdf(lambda *cosines: paint(*cosines)[..., :1]), ("glossy",), 2)
    for taps in brdf_taps(one):
        assert taps.weight.shape == (len(taps.blur), 3)
        np.testing.assert_array_equal(taps.weight[:, 0], taps.weight[:, 2])
    assert brdf_taps(fit_lobes(Lambert(), ("diffuse",), 2)) == ()
