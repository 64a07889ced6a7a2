"""What prefiltering needs to know of a reflection: a radially symmetric kernel on the sphere."""

from abc import ABC, abstractmethod

import numpy as np
from jaxtyping import Float


class Kernel(ABC):
    """A filter on the sphere, radially symmetric about the direction a prefiltered map is looked up in.

    A prefiltered map holds L(r) = ∫ k(θ)·L(ω) dω, θ the angle between r and ω. Kernels are functions of
    s = sin²(θ/2) = (1 - cos θ)/2 = |r - ω|²/4 in [0, 1], which keeps all digits of narrow lobes; dω = 4π·ds.
    They are normalized, ∫ k dω = 4π·∫k ds = 1, unless they say otherwise, so that a prefiltered map is radiance.
    """

    @abstractmethod
    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """k, per steradian, ≥ 0; continuous."""


def sine_squared_of_half(cosine: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """s of cos θ."""
    return np.asarray(np.clip(0.5 - 0.5 * cosine, 0.0, 1.0))
