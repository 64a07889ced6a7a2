"""How far Schlick's approximation is from the exact formulas."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.reflectance.brdfs.fresnel import f0_from_index, fresnel_conductor, fresnel_schlick


@dataclass(frozen=True)
class SchlickError:
    """Exact and approximate reflectance of one material over the angle; ``k`` is 0 for dielectrics."""

    n: float
    k: float
    theta: Float[np.ndarray, "angles"]  # radians, 0 to π/2
    exact: Float[np.ndarray, "angles"]
    schlick: Float[np.ndarray, "angles"]

    @property
    def largest(self) -> float:
        """The largest absolute difference."""
        return float(np.abs(self.schlick - self.exact).max())

    @property
    def hemispherical(self) -> float:
        """Schlick's mean over a white hemisphere, ∫F·2cos θ·sin θ dθ, minus the exact one."""
        return float(np.trapezoid((self.schlick - self.exact) * np.sin(2.0 * self.theta), self.theta))


def schlick_errors(indices: Sequence[complex], angles: int = 361) -> tuple[SchlickError, ...]:
    """A record for each index n + ik (k ≥ 0) at evenly spaced angles, with Schlick's f0 that of the exact formula."""
    theta = np.linspace(0.0, 0.5 * np.pi, angles)
    cosine = np.cos(theta)
    records = []
    for index in indices:
        n, k = complex(index).real, complex(index).imag
        schlick = fresnel_schlick(cosine, float(f0_from_index(n, k)))
        records.append(SchlickError(n, k, theta, fresnel_conductor(cosine, n, k), schlick))
    return tuple(records)
