"""The LOD policy against cases that can be worked out by hand."""

import numpy as np
import pytest

from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import direction_from_face

CHAIN = MipChain(64)


def directions(step_right: tuple[float, float], step_down: tuple[float, float]) -> np.ndarray:
    """A lookup at (0.1, -0.2) of face pz and its neighbours, steps given in texels of the finest level."""
    face = np.full(3, 4)
    s = 0.1 + np.array([0.0, step_right[0], step_down[0]]) * 2.0 / 64
    t = -0.2 + np.array([0.0, step_right[1], step_down[1]]) * 2.0 / 64
    return direction_from_face(face, s, t)[:, None, :]


def lod(step_right: tuple[float, float], step_down: tuple[float, float], bias: float = 0.0) -> float:
    scale = np.array([1.0, 3.0, 0.2])[:, None, None]  # lengths of directions must not matter
    return float(lod_from_neighbours(CHAIN, directions(step_right, step_down) * scale, bias)[0])


def test_a_texel_a_pixel_is_the_finest_level() -> None:
    assert abs(lod((1.0, 0.0), (0.0, 1.0))) < 1e-12  # exact but for rounding in float64


def test_the_longer_step_counts() -> None:
    assert abs(lod((4.0, 0.0), (0.0, 1.0)) - 2.0) < 1e-12
    assert abs(lod((1.0, 0.0), (3.0, 4.0)) - np.log2(5.0)) < 1e-12


def test_bias_and_clamping() -> None:
    assert abs(lod((8.0, 0.0), (0.0, 1.0), -1.0) - 2.0) < 1e-12
    assert lod((0.0, 0.0), (0.0, 0.0)) == 0.0
    assert lod((200.0, 0.0), (0.0, 1.0)) == 6.0


def test_a_neighbour_behind_the_face_plane_is_infinitely_far() -> None:
    rays = directions((1.0, 0.0), (0.0, 1.0))
    rays[1] = -rays[1]
    assert lod_from_neighbours(CHAIN, rays, -10.0)[0] == 6.0


OTHERS = [p for p in PARAMETERIZATIONS.values() if p.name != "cube"]


def rays(d: np.ndarray, step_right: np.ndarray, step_down: np.ndarray) -> np.ndarray:
    return np.stack([d, d + step_right, d + step_down])


def test_on_the_paraboloid_a_texel_a_pixel_is_the_finest_level() -> None:
    """It keeps angles: chord times the root of the rate is the distance on the map."""
    p = PARAMETERIZATIONS["dual_paraboloid"]
    rng = np.random.default_rng(0)
    uv = 0.5 + 0.3 * rng.uniform(-1.0, 1.0, (500, 2))
    steps = rng.uniform(-4.0, 4.0, (2, 500, 2)) / 512
    face = rng.integers(0, 2, 500)
    direction = np.stack([p.direction_from_uv(face, each)[0] for each in (uv, uv + steps[0], uv + steps[1])])
    texels = np.linalg.norm(steps, axis=-1).max(0) * 512
    found = lod_from_neighbours(MipChain(512, p), direction, 3.0)
    # Steps of up to 6 of 512 texels: the rate changes by their length times twice the radius, 2 %, along the chord.
    np.testing.assert_allclose(found, np.log2(texels) + 3.0, atol=0.03)


@pytest.mark.parametrize("p", OTHERS, ids=str)
def test_equal_areas_share_a_level(p) -> None:
    """A pixel that covers as much solid angle as a texel reads the finest level, wherever it looks."""
    rng = np.random.default_rng(1)
    d = rng.standard_normal((500, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    edge = 1.0 / np.sqrt(p.sampling_rate(d))[:, None] / 1024
    right = np.cross(d, rng.standard_normal((500, 3)))
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    scale = np.array([1.0, 3.0, 0.2])[:, None, None]  # lengths of directions must not matter
    found = lod_from_neighbours(MipChain(1024, p), scale * rays(d, 2.0 * edge * right, edge * np.cross(d, right)), 1.0)
    # A step of e radians along the tangent is a chord of e·(1 - 3e²/8), e at most 2·4π/1024 at the poles of lat-long.
    np.testing.assert_allclose(found, 2.0, atol=1e-3)


@pytest.mark.parametrize("p", OTHERS, ids=str)
def test_the_lod_has_no_seams_and_is_clamped(p) -> None:
    rng = np.random.default_rng(2)
    on = rng.standard_normal((999, 3))
    on[np.arange(999), np.arange(999) % 3] = 0.0  # the planes that hold all seams and folds of these maps
    on /= np.linalg.norm(on, axis=1, keepdims=True)
    chain = MipChain(256, p)
    right, down = 0.02 * rng.standard_normal((2, 999, 3))
    one, other = (
        lod_from_neighbours(chain, rays(on, right, down) + sign * 1e-7 * rng.standard_normal((999, 3)), 0.0)
        for sign in (1, -1)
    )
    # The step of 1e-7 against chords of 1e-3 and more, and what rates change over it: at poles their clamp caps that.
    np.testing.assert_allclose(one, other, atol=2e-3)
    assert (lod_from_neighbours(chain, rays(on, 0 * on, 0 * on), 0.0) == 0.0).all()
    assert (lod_from_neighbours(chain, rays(on, -2 * on, 0 * on), 20.0) == 8.0).all()
