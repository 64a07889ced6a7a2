"""The frame in which lobes are fitted: n = +y, the plane of incidence x-y, the mirrored side +x; and integrals in it.

Axes lie in the plane of incidence, at angles from the normal, positive on the mirrored side. Integrals are sums over
polar grids around every lobe's axis at angles θ = π·u², dense in the middle, over half the sphere (the plane of
incidence is a mirror for isotropic BRDFs); a point that lies in several grids counts 1/Σ of their densities.
"""

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf

RINGS, SPOKES = 144, 24  # of a polar grid


def cosine_weighted(
    brdf: Brdf, cos_theta_o: float, direction: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n channels"]:
    """f·max(n·l, 0) in directions of the frame in which n = +y and the mirrored side is +x.

    Raises RefletError for BRDFs that are negative or not finite.
    """
    above = direction[:, 1] > 1e-4
    x, y, z = direction[above].T
    across = np.maximum(np.hypot(x, z), 1e-12)
    values = brdf.evaluate(y, np.array([max(cos_theta_o, 1e-4)]), np.clip(-x / across, -1.0, 1.0))
    if not np.isfinite(values).all() or values.min(initial=0.0) < 0.0:
        raise RefletError("A BRDF must be finite and not negative for all directions above the surface; repair it.")
    q = np.zeros((len(direction), values.shape[-1]))
    q[above] = values * y[:, None]
    return q


def polar_points(axes: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Directions, RINGS·SPOKES an axis, over the half sphere z > 0, and solid angles, doubled for the other half."""
    u = (np.arange(RINGS) + 0.5) / RINGS
    spoke = (np.arange(SPOKES) + 0.5) / SPOKES * np.pi
    theta = np.pi * u[:, None] ** 2
    along, side, up = np.sin(theta) * np.cos(spoke), np.sin(theta) * np.sin(spoke), np.cos(theta) + 0.0 * spoke
    grids = [
        np.stack([np.sin(a) * up + np.cos(a) * along, np.cos(a) * up - np.sin(a) * along, side], -1).reshape(-1, 3)
        for a in axes
    ]
    direction = np.concatenate(grids)
    density = sum(_points_per_steradian(angle_to(direction, a)) for a in axes)
    return direction, 2.0 / np.asarray(density)


def _points_per_steradian(theta: np.ndarray) -> np.ndarray:
    """dω = sin θ dθ dφ, dθ = 2π·u du, over φ in [0, π]."""
    theta = np.clip(theta, 1e-9, np.pi - 1e-6)
    return RINGS * SPOKES / (np.pi * 2.0 * np.sqrt(np.pi * theta) * np.sin(theta))


def angle_to(direction: Float[np.ndarray, "n 3"], axis_angle: float) -> Float[np.ndarray, "n"]:
    """Angles to an axis, in radians."""
    apart = direction - np.array([np.sin(axis_angle), np.cos(axis_angle), 0.0])
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(apart, axis=-1), 1.0)))
