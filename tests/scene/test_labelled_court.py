"""The labelled court: every direction shows what its name says."""

import numpy as np

from reflet.scene.builtin.labelled_court import SUN, SUN_RADIANCE, SUN_RADIUS, court_radiance, labelled_court


def test_walls_have_their_colours() -> None:
    """Beside the letters, a quarter of the wall to the right of its middle and a little up."""
    for axis, strongest in (([1, 0, 0], 0), ([-1, 0, 0], 1), ([0, 0, 1], 2)):
        ahead = np.array(axis, float)
        right = np.cross(ahead, [0.0, 1.0, 0.0])
        direction = ahead + 0.55 * right + np.array([0.0, 0.07, 0.0])
        assert int(np.argmax(court_radiance(direction / np.linalg.norm(direction)))) == strongest
    yellow = court_radiance(np.array([0.45, 0.05, -1.0]) / np.linalg.norm([0.45, 0.05, -1.0]))
    assert yellow[0] > yellow[1] > 4.0 * yellow[2]


def test_letters_read_from_inside() -> None:
    """A plus sign has a vertical bar, a minus sign has none; both are left of the letter as seen from inside."""
    up = np.linspace(-0.3, 0.05, 201)
    right = np.linspace(-0.35, 0.0, 101)  # left of the middle

    def ink(ahead: list[float]) -> np.ndarray:
        axis = np.array(ahead, float)
        sideways = np.cross(axis, [0.0, 1.0, 0.0])
        at = axis + right[None, :, None] * sideways + up[:, None, None] * np.array([0.0, 1.0, 0.0])
        return court_radiance(at / np.linalg.norm(at, axis=-1, keepdims=True)).min(-1) > 0.3

    plus, minus = ink([1, 0, 0]), ink([-1, 0, 0])
    # The plus sign is 0.19 high, the bar of a hyphen 0.03.
    tall = plus[:, :60].any(1).mean() * 0.35
    low = minus[:, :60].any(1).mean() * 0.35
    assert tall > 0.12 and 0.0 < low < 0.06


def test_the_sun_is_where_it_is_said() -> None:
    image = labelled_court(64)
    direction, _ = image.parameterization.texel_directions(64)
    texels = image.texels[..., 1]
    assert direction.reshape(-1, 3)[np.argmax(texels)] @ SUN > np.cos(np.radians(2.0))  # texels are 1.4 degrees wide
    # A disc of SUN_RADIUS; points three to a texel catch its area to a few per cent, the sky's share is 0.2 %.
    flux = (texels * image.parameterization.texel_solid_angle(64))[direction @ SUN > np.cos(np.radians(5.0))].sum()
    disc = 2.0 * np.pi * (1.0 - np.cos(SUN_RADIUS)) * SUN_RADIANCE * 0.93
    assert abs(flux / disc - 1.0) < 0.15
