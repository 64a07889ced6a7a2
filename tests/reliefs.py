"""Reliefs of what is known in closed form."""

import numpy as np

from reflet.envmap.geometry import Box, InfiniteSphere, Sphere
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief, inverse_chebyshev
from reflet.envmap.shapes import FAR_AWAY

NOWHERE = ((-FAR_AWAY,) * 3, (FAR_AWAY,) * 3)
ROOM = Box((-2.0, -0.5, -3.0), (2.5, 2.0, 3.5), (0.1, 0.2, -0.3))
BALL = Sphere((0.1, 0.2, -0.3), (2.0,) * 3, (0.1, 0.2, -0.3))


def distances(shape: Box | Sphere | InfiniteSphere, origin: tuple[float, float, float], size: int) -> np.ndarray:
    """How far a shape lies from an origin inside it, along each texel's unit direction."""
    direction = texel_directions(size)
    if isinstance(shape, InfiniteSphere):
        return np.full(direction.shape[:-1], np.inf)
    hit = shape.lookup_direction(np.broadcast_to(origin, direction.shape), direction)
    scale = shape.radii[0] if isinstance(shape, Sphere) else 1.0
    return np.linalg.norm(hit * scale, axis=-1)


def relief_of(shape: Box | Sphere | InfiniteSphere, size: int = 128, start: Box | None = None) -> Relief:
    """What a probe would make of a shape."""
    origin = (0.1, 0.2, -0.3) if isinstance(shape, InfiniteSphere) else shape.origin
    q = inverse_chebyshev(distances(shape, origin, size)).astype(np.float16)
    return Relief(q, *((start.lower, start.upper) if start else NOWHERE), origin)


def plane_relief(height: float, size: int = 128, start: Box | None = None) -> Relief:
    """A floor ``height`` below the origin under an infinite sky."""
    direction = texel_directions(size)
    with np.errstate(divide="ignore"):
        distance = np.where(direction[..., 1] < 0.0, -height / direction[..., 1], np.inf)
    q = inverse_chebyshev(distance).astype(np.float16)
    return Relief(q, *((start.lower, start.upper) if start else NOWHERE), (0.0, 0.0, 0.0))


def rays(count: int, seed: int, reach: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """Points near the origin and unit directions."""
    rng = np.random.default_rng(seed)
    r = rng.standard_normal((count, 3))
    return rng.uniform(-reach, reach, (count, 3)), r / np.linalg.norm(r, axis=1, keepdims=True)


def angle_deg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Degrees between vectors of any length."""
    unit_a, unit_b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    return np.degrees(2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(unit_a - unit_b, axis=-1), 0.0, 1.0)))
