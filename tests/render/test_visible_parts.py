"""No face leaves out a part that reaches into it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reflet.envmap.parameterizations.cube import face_from_direction
from reflet.render.meshes.visible_parts import bounding_spheres, reach_into_cube, reach_into_paraboloids
from reflet.scene.material import MIRROR
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part, Scene


@given(st.integers(0, 2**32 - 1))
def test_every_point_of_a_sphere_is_drawn(seed: int) -> None:
    random = np.random.default_rng(seed)
    centre = random.normal(size=(1, 3)) * 3.0
    radius = random.uniform(0.01, 4.0, 1)
    point = random.normal(size=(50, 3))
    point = centre + radius * random.uniform(0.0, 1.0, (50, 1)) * point / np.linalg.norm(point, axis=1, keepdims=True)
    faces, _, _ = face_from_direction(point)
    assert reach_into_cube(centre, radius)[faces].all()
    outward = point[:, 2] / np.linalg.norm(point, axis=1)
    front, back = reach_into_paraboloids(centre, radius)
    # A face's corners see what lies at -1/3.
    assert front[0] or (outward < -1.0 / 3.0).all()
    assert back[0] or (outward > 1.0 / 3.0).all()


def test_small_spheres_are_drawn_where_they_are() -> None:
    axes = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    np.testing.assert_array_equal(reach_into_cube(axes, np.full(6, 0.1)), np.eye(6, dtype=bool))
    np.testing.assert_array_equal(
        reach_into_paraboloids(axes, np.full(6, 0.1)), [[1, 1, 1, 1, 1, 0], [1, 1, 1, 1, 0, 1]]
    )


def test_bounding_spheres_hold_their_parts() -> None:
    torus = torus_mesh(0.7, 0.3, (1.0, 2.0, 3.0))
    (sphere,) = bounding_spheres(Scene((Part("torus", torus, MIRROR, True),), ()))
    np.testing.assert_allclose(sphere, (1.0, 2.0, 3.0, 1.0), atol=2e-3)
    assert (np.linalg.norm(torus.positions - sphere[:3], axis=1) <= sphere[3]).all()
