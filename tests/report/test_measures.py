"""Error measures against closed forms."""

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.report import measures

SHAPE = (24, 32)
EVERYWHERE = np.ones(SHAPE, bool)


def radiance_of_display(value: float) -> np.ndarray:
    """A constant picture whose tone-mapped value is ``value``: the inverse of the tone map, by hand."""
    linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    return np.full((*SHAPE, 3), -np.log1p(-linear) / 1.6)


@pytest.mark.parametrize("value", [0.0, 0.02, 0.5, 0.75, 0.99])
def test_tone_map_is_srgb_of_one_minus_exp(value: float) -> None:
    # Float64 all through; the two pieces of the sRGB curve meet within 1e-7.
    assert np.allclose(measures.tone_map(radiance_of_display(value)), value, atol=1e-7)


def test_tone_map_shows_negative_radiance_as_black() -> None:
    assert measures.tone_map(np.array([-3.0])) == 0.0


def test_psnr_of_a_constant_difference() -> None:
    reference, image = radiance_of_display(0.5), radiance_of_display(0.6)
    assert measures.display_psnr(reference, image, EVERYWHERE) == pytest.approx(20.0, abs=1e-9)


def test_psnr_pools_squared_errors_over_views() -> None:
    # One view off by 0.1, one exact: the mean squared error is 0.005, not the mean of 20 dB and infinity.
    reference = np.stack([radiance_of_display(0.5), radiance_of_display(0.5)])
    image = np.stack([radiance_of_display(0.6), radiance_of_display(0.5)])
    pooled = measures.display_psnr(reference, image, np.stack([EVERYWHERE, EVERYWHERE]))
    assert pooled == pytest.approx(-10.0 * np.log10(0.005), abs=1e-9)
    streamed = measures.squared_error(reference[0], image[0], EVERYWHERE) + measures.squared_error(
        reference[1], image[1], EVERYWHERE
    )
    assert streamed.psnr == pytest.approx(pooled, abs=1e-12)


def test_equal_pictures_are_perfect() -> None:
    picture = np.random.default_rng(1).gamma(1.0, 1.0, (*SHAPE, 3))
    assert measures.display_psnr(picture, picture, EVERYWHERE) == np.inf
    assert measures.ssim(picture, picture, EVERYWHERE) == pytest.approx(1.0, abs=1e-12)
    assert measures.flip(picture, picture, EVERYWHERE) == 0.0


def test_ssim_of_constants_is_its_luminance_term() -> None:
    # No variance: SSIM = (2ab + c1)/(a² + b² + c1) with c1 = (0.01·data_range)².
    a, b, c1 = 0.5, 0.7, 1e-4
    value = measures.ssim(radiance_of_display(a), radiance_of_display(b), EVERYWHERE)
    assert value == pytest.approx((2 * a * b + c1) / (a * a + b * b + c1), abs=1e-9)


def test_flip_of_black_against_white_is_nearly_one() -> None:
    # FLIP maps the largest colour difference (blue against green) to 1, and black against white just below.
    value = measures.flip(radiance_of_display(0.0), np.full((*SHAPE, 3), 1e3), EVERYWHERE)
    assert 0.9 < value <= 1.0


@pytest.mark.parametrize("name", ["display_psnr", "ssim", "flip"])
def test_only_the_mask_counts(name: str) -> None:
    """What lies outside the mask changes nothing, and more picture around it changes nothing."""
    measure = getattr(measures, name)
    rng = np.random.default_rng(2)
    reference, image = rng.random((2, 64, 80, 3))
    mask = np.zeros((64, 80), bool)
    mask[20:44, 30:60] = rng.random((24, 30)) > 0.2
    value = measure(reference, image, mask)
    elsewhere = np.where(mask[..., None], image, 7.0)
    assert measure(reference, elsewhere, mask) == value
    pad = ((40, 40), (40, 40))
    larger = [np.pad(picture, (*pad, (0, 0)), constant_values=3.0) for picture in (reference, image)]
    # SSIM's running sums round differently where they start elsewhere.
    assert measure(larger[0], larger[1], np.pad(mask, pad)) == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("name", ["display_psnr", "ssim", "flip"])
def test_an_empty_mask_is_refused(name: str) -> None:
    picture = np.zeros((*SHAPE, 3))
    with pytest.raises(RefletError, match=r"mask is empty|No pixel"):
        getattr(measures, name)(picture, picture, np.zeros(SHAPE, bool))
