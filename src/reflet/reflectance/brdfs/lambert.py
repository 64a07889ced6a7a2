"""Diffuse reflection.

The BRDF is 1/π times the albedo. The radiance of a white diffuse surface of normal n is L(n) = ∫ L(ω)·max(n·ω, 0)/π dω
[Heidrich00, eq. 15 with k_d = 1/π]: a function of n alone, irradiance/π. With s = sin²(θ/2), cos θ = 1 - 2s, and
4π·∫₀^½ (1 - 2s)/π ds = 1.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.reflectance.brdfs.brdf import Brdf, Cosine, Values
from reflet.reflectance.brdfs.kernel import Kernel


@dataclass(frozen=True)
class Lambert(Brdf):
    """The white diffuse BRDF, 1/π."""

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """The same for all directions."""
        shape = np.broadcast_shapes(np.shape(cos_theta_i), np.shape(cos_theta_o), np.shape(cos_delta_phi))
        return np.full((*shape, 1), 1.0 / np.pi)


@dataclass(frozen=True)
class DiffuseKernel(Kernel):
    """cos θ/π where positive, looked up in the direction of the normal."""

    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """See the class."""
        return np.asarray(np.maximum(1.0 - 2.0 * s, 0.0) / np.pi)
