"""Resampling between parameterizations: constants, energy, harmonics, aliasing, seams."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS, parameterization
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.padding import continued, outside_disc
from reflet.envmap.resampling.resample import radiance_at, resample
from reflet.envmap.sampling import valid_texels
from reflet.envmap.spherical_harmonics import project
from reflet.envmap.texture_filter import sample
from reflet.files.pictures.hdr import read_hdr

KLOPPENHEIM = Path(__file__).parents[3] / "shared/data/hdr/kloppenheim_05_1k.hdr"
EACH = pytest.mark.parametrize("to", PARAMETERIZATIONS.values(), ids=str)
EACH_SOURCE = pytest.mark.parametrize("source", PARAMETERIZATIONS.values(), ids=str)
_ALL = list(PARAMETERIZATIONS.values())
# Where source and destination are taken apart in the code, each with two others is enough.
SOME_PAIRS = pytest.mark.parametrize(
    ("source", "to"), [(each, _ALL[(i + on) % 7]) for i, each in enumerate(_ALL) for on in (1, 3)], ids=str
)
LATLONG = parameterization("latlong")
SLOPE = np.array([[0.3, -0.2, 0.1], [0.1, 0.4, -0.3], [-0.2, 0.1, 0.5]])


def linear(direction: np.ndarray) -> np.ndarray:
    """Radiance that grows along an axis, another one for each colour."""
    return 1.0 + direction @ SLOPE


def of(function, kind: Parameterization, size: int) -> EnvImage:
    return EnvImage(kind, function(kind.texel_directions(size)[0]).astype(np.float32))


def equal_size(image: EnvImage, to: Parameterization, scale: float = 1.0) -> int:
    return max(round(equal_sampling_size(to, valid_texels(image.parameterization) * image.size**2) * scale), 1)


def flux(image: EnvImage, weight: np.ndarray | float = 1.0) -> np.ndarray:
    """∫ L·weight dω, texel by texel."""
    solid_angle = image.parameterization.texel_solid_angle(image.size) * weight
    return np.einsum("frc,frck->k", solid_angle, image.texels.astype(np.float64))


@EACH
@EACH_SOURCE
def test_a_constant_stays_constant(source: Parameterization, to: Parameterization) -> None:
    image = EnvImage(source, np.full((*source.shape(16), 4), 0.3, np.float32))
    for size in (3, 16, 40):
        # Sums of up to 64² float32 terms, which round up and down by 6e-8 of themselves.
        assert np.abs(resample(image, to, size).texels / np.float32(0.3) - 1.0).max() < 2e-5


@SOME_PAIRS
def test_suns_of_one_texel_keep_their_flux(source: Parameterization, to: Parameterization) -> None:
    size = 64
    solid_angle = source.texel_solid_angle(size)
    faces, rows, columns = source.shape(size)
    sliver = np.argwhere(
        (solid_angle > 0.0) & (solid_angle <= 0.4 * np.median(solid_angle))
    )  # at the rim of round maps
    places = [(0, 0, columns // 2), (faces - 1, rows - 1, columns // 2), (0, 21, 38), *map(tuple, sliver[:1])]
    for place, scale in product(places, (0.125, 1.5)):
        image = EnvImage(source, np.full((faces, rows, columns, 3), 0.01, np.float32))
        image.texels[place] = 8e4
        made = resample(image, to, equal_size(image, to, scale))
        # The demand is 1e-3. What goes its own way is exact but for float32; a ten-thousandth at most stays.
        assert np.abs(flux(made) / flux(image) - 1.0).max() < 1e-4, (place, scale)


@pytest.mark.parametrize("scale", [1.0, 2.0])
@EACH
def test_harmonics_of_a_sun_and_its_sky_are_kept(to: Parameterization, scale: float) -> None:
    image = of(linear, LATLONG, 256)
    image.texels[0, 70, 300] = 2e4  # half of the light
    before = project(image)
    after = project(resample(image, to, equal_size(image, to, scale)))
    for band in range(3):
        chosen = slice(band**2, (band + 1) ** 2)
        error = np.linalg.norm(after[chosen] - before[chosen], axis=0) / np.linalg.norm(before[chosen], axis=0)
        assert error.max() < 1e-3  # of the band's own norm: what is asked for


@pytest.mark.skipif(not KLOPPENHEIM.exists(), reason="no shared data")
@EACH
def test_the_sun_of_kloppenheim_survives(to: Parameterization) -> None:
    image = EnvImage(LATLONG, read_hdr(KLOPPENHEIM)[None])
    at = np.unravel_index(image.texels.sum(-1).argmax(), image.texels.shape[:3])
    axis = LATLONG.texel_directions(image.size)[0][at]

    def around_sun(some: EnvImage) -> np.ndarray:
        """Flux within 8° of the sun, faded out to 16°, so that no texel is in or out by a hair."""
        angle = np.arccos(np.clip(some.parameterization.texel_directions(some.size)[0] @ axis, -1.0, 1.0))
        t = np.clip(2.0 - angle / np.radians(8.0), 0.0, 1.0)
        return flux(some, t * t * (3.0 - 2.0 * t))

    for scale in (1.0, 0.125, 2.0):
        made = resample(image, to, equal_size(image, to, scale))
        for measure in (flux, around_sun):
            assert np.abs(measure(made) / measure(image) - 1.0).max() < 1e-3  # what is asked for


@SOME_PAIRS
def test_texels_are_means_over_their_footprints(source: Parameterization, to: Parameterization) -> None:
    rng = np.random.default_rng(5)
    chain = MipChain(64, source)
    texels = rng.random((chain.texel_count, 1))
    finest = chain.level(texels, 0)
    finest[...] = continued(source, finest, outside_disc(source, 64))
    image = EnvImage(source, finest)
    inside = np.argwhere(~np.broadcast_to(outside_disc(to, 1000), to.shape(1000)))
    for scale in (0.3, 0.7):  # not halved before
        size = equal_size(image, to, scale)
        made = resample(image, to, size).texels[..., 0]
        # Some texels, a grid of 24² points each, by the reference of the texture filter.
        face, row, column = (rng.permutation(inside)[:48] * [1, size / 1000, size / 1000]).astype(int).T[..., None]
        down, right = np.indices((24, 24)).reshape(2, -1)
        uv = np.stack([(column + (right + 0.5) / 24) / made.shape[2], (row + (down + 0.5) / 24) / size], -1)
        direction, valid = to.direction_from_uv(np.broadcast_to(face, uv.shape[:2]), uv)
        shown = sample(chain, texels, direction.reshape(-1, 3), np.zeros(48 * 24**2)).reshape(48, -1)
        valid = valid if to.name == "gazing_ball" else np.ones_like(valid)
        expected = (shown * valid).sum(-1) / np.maximum(valid.sum(-1), 1)
        chosen = valid.any(-1)
        error = (made[tuple(np.concatenate([face, row, column], -1).T)] - expected)[chosen]
        # The noise has a standard deviation of 0.29. A tent's weight in a mean of a few texels is off by some per cent
        # with 2.25² sub-samples a texel, by more where texels are far longer than wide: 0.005 to 0.014 over all pairs.
        assert np.sqrt(np.mean(error**2)) < 0.02


@pytest.mark.parametrize("name", ["cube", "latlong", "dual_paraboloid", "octahedral", "equal_area_octahedral"])
def test_minified_details_do_not_alias(name: str) -> None:
    to = parameterization(name)
    rows, columns = np.indices((256, 512))
    checkerboard = ((rows + columns) % 2).astype(np.float32)[None, ..., None]
    image = EnvImage(LATLONG, checkerboard)
    for scale in (0.125, 0.27):
        made = resample(image, to, equal_size(image, to, scale)).texels
        # Footprints hold 64 or 14 texels, black and white in turn; point samples would give anything from 0 to 1.
        assert np.abs(made - 0.5).max() < 0.1


@EACH
@EACH_SOURCE
def test_magnified_radiance_is_smooth_over_seams(source: Parameterization, to: Parameterization) -> None:
    image = of(linear, source, 64)
    size = equal_size(image, to, 2.0)
    direction, _ = to.texel_directions(size)
    error = np.abs(resample(image, to, size).texels - linear(direction)).max(-1)
    # Around the gazing ball's singularity its last texel sees 2·acos(1 - 2/64) = 29°: nothing can be asked for there.
    smallest = 0.2 if "gazing_ball" in (source.name, to.name) else 0.0
    error = error[direction[..., 2] > -1.0 + smallest]
    # Bilinear interpolation errs by h²/8·|L''| with texels of up to 0.1 radians, at seams by a part of h·|L'| = 0.05,
    # where the neighbour's texel lies up to half a texel aside; a wrong neighbour would err by 0.3 and more.
    assert error.max() < 0.03
    assert np.sqrt(np.mean(error**2)) < 2e-3


@pytest.mark.parametrize("to", [to for to in PARAMETERIZATIONS.values() if to != CUBE], ids=str)
def test_cube_and_back_at_equal_sampling(to: Parameterization) -> None:
    def smooth_hdr(direction: np.ndarray) -> np.ndarray:
        """A dim sky, a lamp and a narrow light, from 0.1 to 40: what 128² texels a face hold without loss."""
        lamp = 3.0 * np.exp(8.0 * (direction @ np.array([-0.79, 0.24, -0.56]) - 1.0))
        light = 40.0 * np.exp(60.0 * (direction @ np.array([0.44, 0.87, 0.22]) - 1.0))
        return (0.2 + 0.1 * direction[..., 1] + lamp + light)[..., None] * np.array([1.0, 0.8, 0.6])

    image = of(smooth_hdr, CUBE, 128)
    back = resample(resample(image, to, equal_size(image, to)), CUBE, 128)
    direction, _ = CUBE.texel_directions(128)
    kept = direction[..., 2] > -np.cos(np.radians(10.0)) if to.name == "gazing_ball" else np.full((6, 128, 128), True)
    error = np.mean((back.texels - image.texels)[kept].astype(np.float64) ** 2)
    assert 10.0 * np.log10(image.texels.max() ** 2 / error) > 65.0  # 45 is asked for; data_range: the brightest texel


@EACH
def test_outside_the_disc_is_the_continuation(to: Parameterization) -> None:
    outside = outside_disc(to, 64)
    assert outside.any() == to.is_round
    if to.name == "gazing_ball":  # what a texel at the rim sees of the inside is far away from the rim's direction
        outside = to.texel_solid_angle(64)[0] == 0.0
    made = resample(of(linear, CUBE, 64), to, 64).texels[:, outside]
    # to the rounding of float32 and bilinear interpolation, h²/8 with h = 1/32
    assert np.abs(made - linear(to.texel_directions(64)[0])[:, outside]).max(initial=0.0) < 2e-3


@EACH_SOURCE
def test_what_lies_outside_the_disc_is_not_read(source: Parameterization) -> None:
    image = of(linear, source, 32)
    black = image.texels.copy()
    black[:, outside_disc(source, 32)] = 0.0
    made, of_black = (resample(EnvImage(source, texels), CUBE, 32).texels for texels in (image.texels, black))
    # The ceiling alone knows of it, and nothing comes near the ceiling.
    assert (made == of_black).all()


def test_nothing_happens_where_nothing_changes() -> None:
    image = of(linear, CUBE, 8)
    assert resample(image, CUBE, 8) is image


@settings(max_examples=20)
@given(st.sampled_from(sorted(PARAMETERIZATIONS)), st.integers(1, 50), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_means_stay_within_what_came(name: str, size: int, channels: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    source = parameterization(rng.choice(sorted(PARAMETERIZATIONS)))
    image = EnvImage(source, rng.random((*source.shape(int(rng.integers(1, 40))), channels), np.float32))
    made = resample(image, parameterization(name), size).texels
    assert made.shape == (*parameterization(name).shape(size), channels)
    # No texel of uniform noise reaches the ceiling of 8 times the mean but in the tiniest maps, where it is spread.
    assert made.min() >= image.texels.min() - 1e-6
    assert made.max() <= image.texels.max() + 1e-6


@EACH_SOURCE
def test_lookups_are_those_of_the_graphics_system(source: Parameterization) -> None:
    rng = np.random.default_rng(2)
    chain = MipChain(16, source)
    texels = rng.random((chain.texel_count, 3))
    image = EnvImage(source, chain.level(texels, 0))
    direction = rng.normal(size=(500, 3))
    if source.is_round:  # here the outside is read as it is, there from inside
        _, uv = source.uv_from_direction(direction)
        direction = direction[np.hypot(*(2.0 * uv - 1.0).T) < 1.0 - 3.0 / 16.0]
    expected = sample(chain, texels, direction, np.zeros(len(direction)))
    # Weights in single precision: 1e-7, of coordinates up to 32.
    assert np.abs(radiance_at(image, direction) - expected).max() < 5e-6


@EACH_SOURCE
def test_patches_are_averaged(source: Parameterization) -> None:
    image = of(linear, source, 32)
    direction = np.array([[0.36, 0.48, 0.8], [1.0, -0.1, 0.2], [-0.3, 2.0, 0.5]])
    unit = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    # The mean of a unit vector over a tangent square of width w, seen from the centre, is shorter by 1 - w²/12.
    for solid_angle in (0.01, np.array([0.02, 0.05, 0.04])):
        width = np.sqrt(np.broadcast_to(solid_angle, 3))[:, None]
        expected = linear(unit * (1.0 - width**2 / 12.0))
        # Interpolation (h²/8, h up to 0.2) and the next term w⁴/20.
        assert np.abs(radiance_at(image, direction, solid_angle) - expected).max() < 6e-3
    rows, columns = np.indices((128, 256))
    checks = EnvImage(LATLONG, ((rows + columns) % 2).astype(np.float32)[None, ..., None])
    assert np.abs(radiance_at(checks, unit, 0.04) - 0.5).max() < 0.01
