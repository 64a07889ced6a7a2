"""The cube parameterization: round trips, orientation, seams, solid angles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflet.envmap.cube import (
    AXES,
    FACES,
    direction_from_face,
    face_from_direction,
    texel_directions,
    texel_solid_angle,
)

# float64 sums and divisions of numbers near 1: a few ulp
EXACT = 1e-14

component = st.floats(-1.0, 1.0, allow_nan=False)


@given(st.tuples(component, component, component).filter(lambda d: max(map(abs, d)) > 1e-3))
def test_direction_to_face_and_back_is_the_direction(d: tuple[float, float, float]) -> None:
    direction = np.array([d])
    face, s, t = face_from_direction(direction)
    assert np.abs(s).max() <= 1 + EXACT and np.abs(t).max() <= 1 + EXACT
    back = direction_from_face(face, s, t)
    np.testing.assert_allclose(back, direction / np.abs(direction).max(), atol=4 * EXACT)


def test_labelled_axes_meet_their_faces() -> None:
    axes = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    face, s, t = face_from_direction(axes)
    assert [FACES[f] for f in face] == ["px", "nx", "py", "ny", "pz", "nz"]
    assert not s.any() and not t.any()


def test_orientation_is_webgpus() -> None:
    """Seen from inside with +y up, the side faces have +y at their top; right of pz's centre lies +x."""
    for name in ("px", "nx", "pz", "nz"):
        np.testing.assert_array_equal(AXES[FACES.index(name), 2], [0, -1, 0])
    np.testing.assert_array_equal(AXES[FACES.index("pz"), 1], [1, 0, 0])
    np.testing.assert_array_equal(AXES[FACES.index("px"), 1], [0, 0, -1])
    np.testing.assert_array_equal(AXES[FACES.index("py"), 2], [0, 0, 1])
    # every face: right × down = -outward or outward alike, so that no face is mirrored against another
    handedness = [np.dot(np.cross(a[1], a[2]), a[0]) for a in AXES]
    assert handedness == [handedness[0]] * 6


@pytest.mark.parametrize("size", [1, 2, 16, 64])
def test_solid_angles_add_up_to_the_sphere(size: int) -> None:
    # closed form, summed in float64: rounding grows with the number of texels
    assert 6 * texel_solid_angle(size).sum() == pytest.approx(4 * np.pi, rel=1e-12)


def test_solid_angle_tends_to_area_over_distance_cubed() -> None:
    size = 256
    direction = direction_from_face(
        np.zeros((size, size), int), *np.meshgrid(*[(2 * np.arange(size) + 1) / size - 1] * 2)
    )
    density = (2 / size) ** 2 / np.linalg.norm(direction, axis=-1) ** 3
    # midpoint rule against the exact integral: second order in the texel's size
    np.testing.assert_allclose(texel_solid_angle(size), density, rtol=2 / size**2 * 4)


def test_neighbouring_texels_stay_close_over_every_seam() -> None:
    """Stepping over a face's edge moves the direction no further than a texel's largest step inside a face."""
    size = 32
    inside = texel_directions(size)
    largest = max(
        np.linalg.norm(np.diff(inside, axis=1), axis=-1).max(), np.linalg.norm(np.diff(inside, axis=2), axis=-1).max()
    )
    along = (2 * np.arange(size) + 1) / size - 1
    for face in range(6):
        for s, t in ((1 + 1 / size, along), (-1 - 1 / size, along), (along, 1 + 1 / size), (along, -1 - 1 / size)):
            s, t = np.broadcast_arrays(s, t)
            there = direction_from_face(np.full(size, face), s, t)
            other, os, ot = face_from_direction(there)
            assert (other != face).all()
            column, row = (np.floor((np.stack([os, ot]) + 1) / 2 * size)).astype(int)
            edge_s, edge_t = np.clip(s, along[0], along[-1]), np.clip(t, along[0], along[-1])
            here = direction_from_face(np.full(size, face), edge_s, edge_t)
            here /= np.linalg.norm(here, axis=-1, keepdims=True)
            step = np.linalg.norm(inside[other, row, column] - here, axis=-1)
            assert (
                step.max() <= largest * 1.01
            )  # the two texels at a seam are mirror images: same spacing up to rounding
