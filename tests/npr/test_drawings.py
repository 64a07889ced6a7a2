"""What drawn maps hold, against closed forms."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS, parameterization
from reflet.envmap.texture_filter import sample
from reflet.errors import RefletError
from reflet.npr.drawing import Drawing, Overprint, ball_at, drawn_levels
from reflet.npr.drawings import DRAWINGS, drawing
from reflet.npr.gooch import Gooch
from reflet.npr.hatching import Hatching
from reflet.npr.noise import chance
from reflet.npr.silhouette import Silhouette
from reflet.npr.window import Window

EACH = pytest.mark.parametrize("name", DRAWINGS)
EVERY = pytest.mark.parametrize("kind", PARAMETERIZATIONS)


def on_ball(radius: float, depth: np.ndarray, azimuth: np.ndarray | float = 0.7) -> tuple[np.ndarray, np.ndarray]:
    """Normals at some depths on a ball, all in pixels, and how far they turn over a pixel there."""
    depth, azimuth = np.broadcast_arrays(depth, azimuth)
    cosine = 1.0 - depth / radius
    sine = np.sqrt(1.0 - cosine**2)
    normal = np.stack([cosine * np.cos(azimuth), cosine * np.sin(azimuth), sine], -1)
    return normal, 1.0 / (radius * sine)


def flat(levels: tuple[EnvImage, ...]) -> np.ndarray:
    return np.concatenate([level.texels.reshape(-1, 3) for level in levels])


@given(radius=st.floats(2.0, 4000.0), share=st.floats(0.01, 1.0), azimuth=st.floats(-3.0, 3.0))
def test_a_normal_and_its_turn_tell_the_ball(radius: float, share: float, azimuth: float) -> None:
    depth = np.array([0.6 + share * (radius - 0.6)])
    ball = ball_at(*on_ball(radius, depth, azimuth))
    np.testing.assert_allclose(ball.radius, radius, rtol=1e-9)  # rounding
    np.testing.assert_allclose(ball.depth, depth, rtol=1e-6)  # 1 - cos a from a sine that was rounded
    if share < 1.0:
        np.testing.assert_allclose(ball.azimuth, azimuth, atol=1e-9)


@pytest.mark.parametrize("radius", [4.0, 37.0, 800.0])
def test_silhouettes_are_as_wide_on_any_ball(radius: float) -> None:
    depth = np.array([0.6, 1.9, 2.5, 3.1, 3.9])
    shown = Silhouette(width=2.5).colors(*on_ball(radius, depth))
    np.testing.assert_allclose(shown[:, 1], [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-6)
    back = Silhouette().colors(np.array([[0.6, 0.0, -0.8]]), np.array([0.01]))
    np.testing.assert_array_equal(back, 0.0)


def test_gooch_is_the_papers_formula() -> None:
    plain = Gooch(shine=0.0, light=(0.0, 1.0, 0.0))
    cool, warm = (0.25 * 0.75 + np.array(each) for each in ((0, 0, 0.45), (0, 0, 0)))
    warm = 0.6 * 0.75 + np.array([0.4, 0.4, 0.0])
    normal = np.array([[0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0.6, 0.8]], float)
    expected = np.stack([warm, cool, (warm + cool) / 2, 0.8 * warm + 0.2 * cool])
    np.testing.assert_allclose(plain.display(normal), expected, atol=1e-12)
    # linear light, not display values, is what a map holds: sRGB's curve is 0.2140 at one half
    grey = Gooch(color=(1.0, 1.0, 1.0), blue=0.0, yellow=0.0, alpha=0.5, beta=0.5, shine=0.0)
    np.testing.assert_allclose(grey.colors(normal, np.ones(4)), 0.2140, atol=5e-5)


def test_gooch_shines_half_way_between_light_and_viewer() -> None:
    light = np.array([0.0, 0.6, 0.8])
    half = (light + [0.0, 0.0, 1.0]) / np.linalg.norm(light + [0.0, 0.0, 1.0])
    shiny = Gooch(shine=1.0, light=tuple(light)).display(np.stack([half, [0.0, -1.0, 0.0]]))
    np.testing.assert_allclose(shiny[0], 1.0, atol=1e-12)
    np.testing.assert_allclose(shiny[1], Gooch(shine=0.0, light=tuple(light)).display(np.array([[0.0, -1.0, 0.0]]))[0])


@pytest.mark.parametrize("radius", [30.0, 130.0, 700.0])
def test_hatching_is_denser_towards_the_contour(radius: float) -> None:
    """Mean ink on the side away from the light falls inwards; amid the ball there is none."""
    azimuth = np.linspace(-1.9, 0.0, 400)[:, None]
    facing = np.array([0.1, 0.3, 0.55, 0.7, 0.95])
    ink = []
    for at in facing:
        # some rows deep, so that not one row's place counts
        depth = np.clip(radius * (1.0 - np.sqrt(1.0 - at**2)) + np.linspace(-12, 12, 49), 0.5, radius)
        ink.append(1.0 - Hatching().colors(*on_ball(radius, depth, azimuth)).mean())
    if radius > 100:  # on the small one the steps are closer together than rows
        assert (np.diff(ink) < 0).all()
    assert ink[0] > 0.2 and ink[-1] < 0.35 * ink[0]
    middle = Hatching().colors(*on_ball(radius, np.array([0.99 * radius])))
    np.testing.assert_array_equal(middle, 1.0)


def test_neighbouring_levels_hold_the_same_strokes() -> None:
    """A ball of half the size has rows where the larger one has every second: its strokes are among the others."""
    azimuth = np.linspace(-3.0, 3.0, 1500)
    row = 4 * Hatching().spacing

    def ink(radius: float, depth: float) -> np.ndarray:
        return 1.0 - Hatching().colors(*on_ball(radius, np.array(depth), azimuth))[:, 0]

    large, small, other = ink(400.0, row), ink(200.0, row / 2), ink(200.0, row)
    # They stray by as many pixels, on the small ball twice as far of its size, so that edges differ.
    assert np.corrcoef(large, small)[0, 1] > 0.8
    assert np.corrcoef(large, other)[0, 1] < 0.5


def test_windows_are_where_the_room_has_them() -> None:
    """Behind the viewer, a little to the left; a mirror that faces the viewer shows the wall beside it."""
    step = np.full(2, 1e-3)
    pane, wall = np.array([-0.25, 0.25, 1.1]), np.array([0.6, 0.3, 1.1])
    direction = np.stack([pane / np.linalg.norm(pane), wall / np.linalg.norm(wall)])
    np.testing.assert_array_equal(Window().room(direction, step)[:, 0], [0.0, 1.0])
    normal = direction + [0.0, 0.0, 1.0]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    np.testing.assert_allclose(Window().colors(normal, step / 2), Window().room(direction, step), atol=1e-9)


@EACH
@EVERY
def test_every_drawing_is_a_map_of_any_kind_and_size(name: str, kind: str) -> None:
    for size in (1, 2, 32):
        levels = drawn_levels(DRAWINGS[name], parameterization(kind), size)
        assert [level.size for level in levels] == [size >> k for k in range(size.bit_length())]
        for level in levels:
            assert level.texels.dtype == np.float32
            assert level.texels.min() >= 0.0 and level.texels.max() <= 1.0


@EACH
def test_drawings_repeat_and_follow_their_seed(name: str) -> None:
    kind = parameterization("octahedral")
    first, again, other = (flat(drawn_levels(drawing(name, seed), kind, 64)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.array_equal(first, other) == (name in ("gooch", "silhouette"))


def test_chance_is_even_and_fixed() -> None:
    numbers = chance(1, np.arange(100_000), 5)
    # The mean of n even numbers strays by 1/√(12n) = 0.0009; five times that.
    assert abs(numbers.mean() - 0.5) < 0.005 and numbers.min() >= 0.0 and numbers.max() < 1.0
    assert abs(np.corrcoef(numbers[1:], numbers[:-1])[0, 1]) < 0.016  # 5/√n
    np.testing.assert_array_equal(chance(1, 7, 5), chance(1, np.array([7]), 5)[0])
    assert len({float(chance(seed, 7)) for seed in range(100)}) == 100


@EVERY
@pytest.mark.parametrize("drawn", [Gooch(), Silhouette(6.0)], ids=["gooch", "silhouette"])
def test_no_seam_shows(kind: str, drawn: Drawing) -> None:
    """Lookups on circles that cross all edges of faces change no faster over them than elsewhere."""
    to = parameterization(kind)
    chain = MipChain(64, to)
    texels = flat(drawn_levels(drawn, to, 64))
    turn = np.linspace(0.0, 2.0 * np.pi, 6000)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], -1)
    for frame in (np.eye(3), np.roll(np.eye(3), 1, 0), np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2 + np.eye(3))[0]):
        for lod in (0.0, 1.5, 3.0):
            shown = sample(chain, texels, circle @ frame, np.full(len(turn), lod))
            # A step is 0.001 radians. From black to white is a texel's way: 0.05 radians at size 64, a tenth of that
            # near poles and rims.
            assert np.abs(np.diff(shown, axis=0)).max() < 0.2


@settings(max_examples=20)
@given(azimuth=st.floats(-3.1, 3.1), tilt=st.floats(0.05, 1.5))
def test_overprints_multiply(azimuth: float, tilt: float) -> None:
    normal = np.array([[np.cos(azimuth) * np.cos(tilt), np.sin(azimuth) * np.cos(tilt), np.sin(tilt)]])
    pixel = np.array([0.02])
    both = drawing("gooch+silhouette:3")
    assert both == Overprint((Gooch(), Silhouette(3.0)))
    np.testing.assert_allclose(
        both.colors(normal, pixel), Gooch().colors(normal, pixel) * Silhouette(3.0).colors(normal, pixel)
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("etching", "Drawings are window, gooch"),
        ("gooch+", "'' is none"),
        ("gooch:2", "no lines"),
        ("silhouette:thick", "a width in pixels"),
        ("silhouette:0", "0.5 to 64"),
        ("hatching:5", "apart"),
        ("window:nan", "0.25 to 64"),
    ],
)
def test_what_cannot_be_drawn_is_said(text: str, words: str) -> None:
    with pytest.raises(RefletError, match=words):
        drawing(text)


def test_sizes_are_powers_of_two() -> None:
    with pytest.raises(RefletError, match="power of two"):
        drawn_levels(Gooch(), parameterization("cube"), 100)
