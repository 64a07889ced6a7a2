"""A lamp in an environment, on the device."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lamp import Lamp
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.reflectance.materials.material import Coated, GlossyPhong
from reflet.render.filters.lamp import LampPainter
from reflet.render.filters.live_environment import LiveEnvironment

SIZE = 32
LAMP = Lamp((1.0, 0.9, 0.4), 12.0, (20.0, 10.0, 5.0))  # over an edge of the cube


def sky() -> EnvImage:
    """Dim and smooth."""
    d, _ = CUBE.texel_directions(SIZE)
    return EnvImage(CUBE, (0.4 + 0.3 * d).astype(np.float32))


@pytest.fixture(scope="module")
def live() -> LiveEnvironment:
    """One for all tests."""
    return LiveEnvironment(SIZE)


@pytest.mark.parametrize("radius", [1.0, 8.0, 60.0])
def test_the_lamp_has_the_solid_angle_of_its_disc(radius: float) -> None:
    """∫ share dω = 2π(1 − cos radius), exactly: π·Δx is the solid angle of a ring."""
    lamp = Lamp((0.0, 2.0, 0.0), radius)
    x = (np.arange(4000) + 0.5) / 4000 * 2.0 * lamp.square_chord  # it ends at 1.5 times that
    sine = np.sqrt(np.maximum(1.0 - (1.0 - x / 2.0) ** 2, 0.0))
    share = lamp.share(np.stack([sine, 1.0 - x / 2.0, 0.0 * x], -1))
    solid_angle = np.pi * share.mean() * 2.0 * lamp.square_chord
    assert solid_angle == pytest.approx(2.0 * np.pi * (1.0 - np.cos(np.radians(radius))), rel=1e-5)


def test_it_is_added_to_every_level(live: LiveEnvironment) -> None:
    plain = sky().texels
    live.show(sky(), LAMP)
    shown = live.environment
    d, _ = CUBE.texel_directions(4 * SIZE)
    share = LAMP.share(d).reshape(6, SIZE, 4, SIZE, 4).mean((2, 4))
    expected = plain + share[..., None] * np.array(LAMP.radiance)
    # Half floats of up to 20.7 are 2⁻⁶ apart: half of that, and what is stored of the share, 2⁻¹² of 20.
    np.testing.assert_allclose(shown.read().texels[..., :3], expected, atol=0.016)
    solid_angle = CUBE.texel_solid_angle(SIZE)
    for level in range(1, 6):
        size = SIZE >> level
        area = CUBE.texel_solid_angle(size)
        means = (share * solid_angle).reshape(6, size, 1 << level, size, 1 << level).sum((2, 4)) / area
        # Texels' weights are those of their middles: coarse ones, of 4 by 4 a face, are off by a fiftieth.
        np.testing.assert_allclose(shown.read(level).texels[..., 3], means, rtol=0.02, atol=0.001)


def test_what_depends_on_it_is_filtered_anew(live: LiveEnvironment) -> None:
    """Light is additive: diffuse maps gain what the lamp alone has; without the lamp all is as before."""
    material = GlossyPhong(20.0, (0.5,) * 3, (0.5,) * 3)

    def maps(image: EnvImage, lamp: Lamp | None) -> tuple[np.ndarray, np.ndarray]:
        live.show(image, lamp)
        found = live.maps(material)
        assert found.diffuse is not None
        return found.reflected.read().texels[..., :3].astype(float), found.diffuse.read().texels[..., :3].astype(float)

    black = EnvImage(CUBE, np.zeros_like(sky().texels))
    before, both, lamp, after = maps(sky(), None), maps(sky(), LAMP), maps(black, LAMP), maps(sky(), None)
    for k in range(2):
        np.testing.assert_allclose(both[k], before[k] + lamp[k], rtol=0.005)  # each rounded to half floats, some times
        np.testing.assert_array_equal(after[k], before[k])
    # Towards the lamp, whose light comes within 12° of the normal: cos⁺ is 1 - sin²(12°)/2 in its mean, over π.
    towards = both[1][0, 3, 8] - before[1][0, 3, 8]
    assert (towards > 0.05 * np.array(LAMP.radiance) * 2.0 * np.pi * (1.0 - np.cos(np.radians(12.0)))).all()


def test_of_other_maps_the_cube_that_is_filtered_gets_it(live: LiveEnvironment) -> None:
    live.show(EnvImage(LatLong(), np.zeros((1, 16, 32, 3), np.float32)), LAMP)
    maps = live.maps(Coated(1.5, (0.5, 0.5, 0.5)))
    assert (maps.reflected.parameterization, maps.reflected.size) == (CUBE, SIZE)
    assert maps.reflected.read().texels[..., 0].max() == pytest.approx(20.0, rel=1e-3)


def test_what_is_no_lamp_is_one_sentence(live: LiveEnvironment) -> None:
    for wrong, why in ((((0.0, 0.0, 0.0),), "direction"), (((0.0, 1.0, 0.0), 0.5), "radius"),
                       (((0.0, 1.0, 0.0), 5.0, (1.0, -1.0, 0.0)), "radiance")):  # fmt: skip
        with pytest.raises(RefletError, match=why):
            Lamp(*wrong)
    live.show(sky(), LAMP)
    with pytest.raises(RefletError, match="half-float cubes of 64 rows"):
        LampPainter(live.device, 64).paint(live.device.create_command_encoder(), live.environment, LAMP)
