"""Corners that are equal, and corners that are joined over smooth edges."""

import numpy as np
import pytest

from reflet.scene.meshes.compiled_corners import smooth_fans
from reflet.scene.meshes.corners import crease_normals, unique_rows, weld

CREASE = np.cos(np.radians(60.0))


@pytest.mark.parametrize("dtype", [np.int32, np.int64, np.float32, np.float64])
@pytest.mark.parametrize("count", [0, 1, 3000])
def test_equal_rows_are_found_in_order_of_appearance(dtype, count):
    rows = np.random.default_rng(1).integers(-6, 6, (count, 3)).astype(dtype)
    if dtype in (np.float32, np.float64):
        rows[::2] *= -1.0  # zeros of both signs are equal
    first, members = unique_rows(rows)
    seen: dict[tuple, int] = {}
    expected = [seen.setdefault(tuple(row), len(seen)) for row in rows.tolist()]
    np.testing.assert_array_equal(members, expected)
    np.testing.assert_array_equal(rows[first], list(seen) or np.zeros((0, 3)))


def test_rows_that_differ_in_one_bit_are_not_equal():
    """Rows of one shape of bits are the worst for a hash: all of them, far apart or in one bit."""
    rows = np.stack(np.meshgrid(*[2.0 ** np.arange(-20, 20)] * 3), -1).reshape(-1, 3)
    rows = np.concatenate([rows, np.nextafter(rows, 0.0)])
    first, members = unique_rows(rows)
    np.testing.assert_array_equal(first, np.arange(len(rows)))
    np.testing.assert_array_equal(members, np.arange(len(rows)))


def folded(*degrees):
    """Quads along +x in the plane z = 0 which turn by these angles, one after the other: corners of their triangles."""
    at, heading = np.zeros(2), 0.0
    corners = []
    for turn in (0.0, *degrees):
        heading += np.radians(turn)
        to = at + (np.cos(heading), np.sin(heading))
        a, b = (*at, 0.0), (*to, 0.0)
        c, d = (*to, -1.0), (*at, -1.0)
        corners += [a, b, c, a, c, d]
        at = to
    return np.array(corners)


def angles(normals):
    return np.degrees(np.arctan2(-normals[:, 0], normals[:, 1]))


def test_edges_are_smooth_below_the_crease_only():
    normals = crease_normals(folded(59.0, 61.0, -40.0), 60.0).reshape(4, 6, 3)
    left, right = [0, 3, 5], [1, 2, 4]  # corners at a quad's beginning and end
    # every corner at a fold has a right angle of its faces in sum: the mean of two normals halves the turn
    expected = [(0.0, 29.5), (29.5, 59.0), (120.0, 100.0), (100.0, 80.0)]
    for quad, (first, last) in zip(normals, expected, strict=True):
        np.testing.assert_allclose(angles(quad[left]), first, atol=1e-9)
        np.testing.assert_allclose(angles(quad[right]), last, atol=1e-9)


def test_labels_part_what_limits_would_join():
    corners = folded(20.0, 20.0)
    first, point = unique_rows(corners)
    labels = np.repeat([0, 0, 7], 2)
    fan, normals = smooth_fans(point, corners[first], labels, np.full(6, CREASE))
    turned = angles(normals[fan]).reshape(3, 6)
    np.testing.assert_allclose(turned[:, 0], [0.0, 10.0, 40.0], atol=1e-9)
    np.testing.assert_allclose(turned[:, 1], [10.0, 20.0, 40.0], atol=1e-9)
    fan, normals = smooth_fans(point, corners[first], labels * 0, np.array([CREASE, CREASE, 2.0, 2.0, CREASE, CREASE]))
    np.testing.assert_allclose(angles(normals[fan]), np.repeat([0.0, 20.0, 40.0], 6), atol=1e-9)


def test_points_where_hundreds_of_faces_meet():
    """A flat wheel of 300 spokes and a cone of as many: one fan in the hub, and its mean normal the axis."""
    turn = np.arange(300) * np.pi / 150.0
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(300)])
    for height in (0.0, 0.5):
        hub = np.broadcast_to((0.0, 0.0, height), (300, 3))
        corners = np.stack([hub, rim, np.roll(rim, -1, axis=0)], axis=1).reshape(-1, 3)
        mesh = weld(corners, crease_normals(corners, 60.0))
        assert len(mesh.positions) == 301
        np.testing.assert_allclose(
            mesh.normals[np.argmin(np.abs(mesh.positions[:, :2]).sum(axis=1))], [0, 0, 1], atol=1e-6
        )


def test_faces_that_cancel_each_other_keep_their_own_normals():
    """Joined with its own back by a limit that asks for nothing."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 1, 0], [1, 0, 0]], float)
    first, point = unique_rows(corners)
    fan, normals = smooth_fans(point, corners[first], np.zeros(2, np.int64), np.full(2, -2.0))
    np.testing.assert_array_equal(normals[fan], np.repeat([[0, 0, 1.0], [0, 0, -1.0]], 3, axis=0))
