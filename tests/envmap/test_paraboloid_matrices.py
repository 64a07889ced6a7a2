"""The dual paraboloid by texture matrices is the dual paraboloid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflet.envmap.env_image import EnvImage
from reflet.envmap.paraboloid_matrices import marked_levels, texture_matrix
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid


def rotation(random: np.random.Generator) -> np.ndarray:
    q, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def projected(matrix: np.ndarray, r: np.ndarray) -> np.ndarray:
    s, t, _, q = matrix @ [*r, 1.0]
    return np.array([s, t]) / q


@given(st.integers(0, 2**32 - 1))
def test_matrices_lead_to_the_texture_coordinates(seed: int) -> None:
    random = np.random.default_rng(seed)
    map_from_eye = rotation(random)
    r = random.normal(size=3)
    r /= np.linalg.norm(r)
    face, uv = DualParaboloid().uv_from_direction(map_from_eye @ r)
    # Two ways to the same quotient in float64, of numbers near 1.
    np.testing.assert_allclose(projected(texture_matrix(int(face), map_from_eye), r), uv, atol=1e-13)


@given(st.integers(0, 2**32 - 1))
def test_the_other_hemisphere_falls_outside_the_disc(seed: int) -> None:
    random = np.random.default_rng(seed)
    map_from_eye = rotation(random)
    r = random.normal(size=3)
    r /= np.linalg.norm(r)
    face = int(DualParaboloid().uv_from_direction(map_from_eye @ r)[0])
    inside, outside = (
        np.linalg.norm(2.0 * projected(texture_matrix(f, map_from_eye), r) - 1.0) for f in (face, 1 - face)
    )
    assert inside <= 1.0 + 1e-12 and outside >= 1.0 - 1e-12
    # Inversion in the circle: where the map goes on. The product of far and near loses as many digits as far has.
    assert inside * outside == pytest.approx(1.0, rel=1e-9) or inside < 1e-5


def test_the_middle_and_the_rim() -> None:
    front, back = (texture_matrix(face, np.eye(3)) for face in range(2))
    np.testing.assert_allclose(projected(front, np.array([0.0, 0.0, 1.0])), 0.5)
    np.testing.assert_allclose(projected(back, np.array([0.0, 0.0, -1.0])), 0.5)
    for matrix in (front, back):  # +x at the right, +y at the top, on both
        np.testing.assert_allclose(projected(matrix, np.array([1.0, 0.0, 0.0])), (1.0, 0.5))
        np.testing.assert_allclose(projected(matrix, np.array([0.0, 1.0, 0.0])), (0.5, 0.0))


def filtered(alpha: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Bilinear, clamped at the border."""
    size = alpha.shape[-1]
    at = uv * size - 0.5
    low = np.floor(at).astype(int)
    fx, fy = (at - low).T
    (x0, y0), (x1, y1) = (np.clip(i, 0, size - 1).T for i in (low, low + 1))
    upper = (1 - fx) * alpha[y0, x0] + fx * alpha[y0, x1]
    return (1 - fy) * upper + fy * ((1 - fx) * alpha[y1, x0] + fx * alpha[y1, x1])


@pytest.mark.parametrize("size", [64, 16, 4])
def test_only_with_a_ring_is_the_rim_wholly_marked(size: int) -> None:
    levels = [EnvImage(DualParaboloid(), np.full((2, size, size, 3), 0.25, np.float32))]
    bare, ringed = (marked_levels(levels, ring)[0].texels for ring in (0.0, 2.0))
    angle = np.linspace(0.0, 2.0 * np.pi, 500)
    rim = 0.5 + 0.5 * np.stack([np.cos(angle), np.sin(angle)], -1)
    for face in range(2):
        np.testing.assert_allclose(filtered(ringed[face, ..., 3], rim), 1.0, atol=1e-12)
        assert filtered(bare[face, ..., 3], rim).min() < 0.5
        assert filtered(bare[face, ..., 3], np.array([[0.5, 0.5]])) == 1.0
    assert (ringed[..., :3] == 0.25).all()
    assert ringed[:, 0, 0, 3].max() == (1.0 if size == 4 else 0.0)  # the corners are far outside, but for coarse levels
