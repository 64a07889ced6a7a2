"""The LOD policy against cases that can be worked out by hand."""

import numpy as np

from reflet.envmap.cube import direction_from_face
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain

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
