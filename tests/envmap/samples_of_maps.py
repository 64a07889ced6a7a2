"""Directions and places that the suites of all parameterizations try."""

import numpy as np
import pytest

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import Parameterization

EACH = pytest.mark.parametrize("p", PARAMETERIZATIONS.values(), ids=str)
ROUND = [name for name, p in PARAMETERIZATIONS.items() if p.is_round]


def unit(direction: np.ndarray) -> np.ndarray:
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def directions(count: int = 4000, seed: int = 0) -> np.ndarray:
    """Directions of any length: all over the sphere, and close to axes, edges, diagonals and corners of all maps."""
    rng = np.random.default_rng(seed)
    special = np.array(
        [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)]
    )
    near = special[rng.integers(0, len(special), count)] * rng.uniform(0.1, 10.0, (count, 1))
    near += rng.standard_normal((count, 3)) * 10.0 ** rng.uniform(-12, -1, (count, 1))
    return np.concatenate([special, near, rng.standard_normal((count, 3))])


def places(p: Parameterization, count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Random faces and uv, for the round maps inside the disc."""
    rng = np.random.default_rng(seed)
    face, uv = rng.integers(0, p.face_count, count), rng.random((count, 2))
    valid = p.direction_from_uv(face, uv)[1]
    return face[valid], uv[valid]


def jacobian(p: Parameterization, face: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """∂d/∂u, ∂d/∂v and d: central differences with an error of some 1e-10."""
    step = 1e-6
    at = [
        p.direction_from_uv(face, uv + np.array(offset))[0] for offset in ((step, 0), (-step, 0), (0, step), (0, -step))
    ]
    return (at[0] - at[1]) / (2 * step), (at[2] - at[3]) / (2 * step), p.direction_from_uv(face, uv)[0]


def away_from_folds(p: Parameterization, uv: np.ndarray) -> np.ndarray:
    """Where differences of directions do not mix two sides of a fold, nor come so close to poles that rates are clamped
    or to rims that directions are not smooth."""
    x, y = np.abs(2.0 * uv.T - 1.0)
    smooth = (np.minimum(x, y) > 1e-4) & (np.maximum(x, y) < 1 - 1e-3) & (np.abs(x + y - 1.0) > 1e-4)
    return smooth & (np.hypot(x, y) < 1 - 1e-3) if p.is_round else smooth
