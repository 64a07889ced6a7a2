"""Light too bright for a texel format: all of it stays, from where it came."""

import warnings

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import facts
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.spread_light import HALF_MAX, held, spread_light
from reflet.errors import RefletWarning

SUN = np.array([0.48, 0.6, 0.64])


def sky(kind: Parameterization, size: int, sun: float, radius_deg: float = 1.5) -> EnvImage:
    """A gradient, and a reddish sun."""
    direction, _ = kind.texel_directions(size)
    disc = (direction @ SUN > np.cos(np.radians(radius_deg)))[..., None]
    texels = np.where(disc, sun * np.array([1.0, 0.9, 0.7]), 1.0 + 0.5 * direction[..., 1:2])
    return EnvImage(kind, texels.astype(np.float32))


@pytest.mark.parametrize("kind", PARAMETERIZATIONS.values(), ids=str)
@pytest.mark.parametrize("sun", [8e4, 8e6])
def test_flux_colour_and_direction_are_kept(kind: Parameterization, sun: float) -> None:
    image = sky(kind, 128, sun)
    spread = spread_light(image, HALF_MAX)
    before, after = facts(image), facts(spread.image)
    assert after.greatest <= HALF_MAX and spread.lost == 0.0
    np.testing.assert_allclose(after.power, before.power, rtol=1e-6)  # one rounding to float32
    texel = np.sqrt(4.0 * np.pi / np.prod(kind.shape(128)))
    # Discs consist of whole texels, so that their centres are off by fractions of one.
    assert np.linalg.norm(np.subtract(after.dominant, before.dominant)) < 0.5 * texel
    half = EnvImage(kind, spread.image.texels.astype(np.float16).astype(np.float32))
    np.testing.assert_allclose(facts(half).power, before.power, rtol=2**-11)  # of half floats
    above = image.texels[..., :3].astype(np.float64) - HALF_MAX
    share = (np.maximum(above, 0.0).sum(-1) * kind.texel_solid_angle(128)).sum() / np.sum(before.power)
    np.testing.assert_allclose(spread.share, share, rtol=1e-9)


def test_the_disc_is_as_wide_as_it_has_to_be() -> None:
    """A sun of radiance k·65504 within the angle r fills one of √k·r; nothing else changes."""
    kind = PARAMETERIZATIONS["equal_area_octahedral"]
    image = sky(kind, 512, 100.0 * HALF_MAX, 1.0)
    spread = spread_light(image, HALF_MAX)
    # 10° and, for texels are 0.22° wide, a texel more
    assert abs(spread.radius_deg - 10.0) < 0.25
    direction, _ = kind.texel_directions(512)
    away = direction @ SUN < np.cos(np.radians(10.5))
    np.testing.assert_array_equal(spread.image.texels[away], image.texels[away])


def test_suns_in_several_places_stay_where_they_are() -> None:
    kind = PARAMETERIZATIONS["latlong"]
    texels = np.ones((1, 64, 128, 3), np.float32)
    for row, column in ((10, 0), (31, 64), (63, 20)):  # over the edge, in the middle, at the pole
        texels[0, row, column] = 3e6
    image = EnvImage(kind, texels)
    spread = spread_light(image, HALF_MAX)
    np.testing.assert_allclose(facts(spread.image).power, facts(image).power, rtol=1e-6)
    direction, _ = kind.texel_directions(64)
    for row, column in ((10, 0), (31, 64), (63, 20)):
        near = (direction @ direction[0, row, column] > np.cos(np.radians(40.0)))[0]
        flux = [each.texels[0, near, 0] @ kind.texel_solid_angle(64)[0, near] for each in (spread.image, image)]
        np.testing.assert_allclose(*flux, rtol=1e-6)


def test_alpha_and_dim_images_are_left_alone() -> None:
    image = sky(PARAMETERIZATIONS["cube"], 32, 1e6)
    alpha = np.random.default_rng(0).random((6, 32, 32, 1), np.float32)
    spread = spread_light(EnvImage(image.parameterization, np.concatenate([image.texels, alpha], -1)), HALF_MAX)
    np.testing.assert_array_equal(spread.image.texels[..., 3:], alpha)
    dim = sky(PARAMETERIZATIONS["cube"], 32, HALF_MAX)
    assert spread_light(dim, HALF_MAX).image is dim


def test_one_warning_says_the_share() -> None:
    texels = np.ones((1, 16, 32, 3), np.float32)
    image = EnvImage(PARAMETERIZATIONS["latlong"], texels)
    texels[0, 8, 5] = 90000.0  # 24,496 too much, of 90,000 and 327 texels of 1
    with pytest.warns(RefletWarning, match=r"^27 % of the light is .* a file can hold \(65504\); none is lost") as said:
        held([image, image], HALF_MAX, "a file", "Dim it.")
    assert len(said) == 1
    too_bright = EnvImage(PARAMETERIZATIONS["cube"], np.full((6, 4, 4, 3), 2.0 * HALF_MAX, np.float32))
    with pytest.warns(RefletWarning, match="50 % is lost, for all is too bright"):
        (cut,) = held([too_bright], HALF_MAX, "a file", "Dim it.")
    np.testing.assert_array_equal(cut.texels, np.float32(HALF_MAX))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        held([EnvImage(PARAMETERIZATIONS["cube"], np.ones((6, 4, 4, 3), np.float32))], HALF_MAX, "a file", "Dim it.")
