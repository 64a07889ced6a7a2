"""Phong's reflection.

The BRDF of equation 16, k_s·(r·wi)^N/cos θi with r = 2(n·wo)n - wo, turns the reflection integral into
k_s·∫ (r·ω)^N·L(ω) dω (equation 17): cos θi is gone, and with it all but r, if the lobe is integrated whole, also where
it reaches below the surface. That is what a prefiltered Phong map is. Its normalization: with t = r·ω,

    ∫ max(r·ω, 0)^N dω = 2π·∫₀¹ t^N dt = 2π/(N + 1),    so k_s = (N + 1)/2π.

Its first moment, ∫ k·cos θ dω = (N + 1)/(N + 2), is what it leaves of a linear environment's contrast.

The BRDF is not reciprocal, for only one of its cosines is in the denominator; f·cos θi is symmetric. It keeps energy:
the part of the lobe above the surface is at most the whole. The roughness r of the paper is 1/N.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf, Cosine, Values
from reflet.reflectance.brdfs.kernel import Kernel


def _check(phong_exponent: float) -> None:
    if not 0.0 < phong_exponent < np.inf:
        raise RefletError(f"A Phong exponent is a number greater than 0, not {phong_exponent}; 1 to 1000 are usual.")


@dataclass(frozen=True)
class Phong(Brdf):
    """(N + 1)/2π·max(r·wi, 0)^N/cos θi. Implements [Heidrich00, eq. 16]. N > 0, else RefletError."""

    phong_exponent: float

    def __post_init__(self) -> None:
        _check(self.phong_exponent)

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """r has wo's angle to the normal and the opposite azimuth."""
        sines = np.sqrt((1.0 - np.square(cos_theta_i)) * (1.0 - np.square(cos_theta_o)))
        r_dot_wi = np.maximum(cos_theta_i * cos_theta_o - sines * cos_delta_phi, 0.0)
        lobe = (self.phong_exponent + 1.0) / (2.0 * np.pi) * r_dot_wi**self.phong_exponent
        return np.asarray(lobe / cos_theta_i)[..., None]


@dataclass(frozen=True)
class PhongKernel(Kernel):
    """(N + 1)/2π·max(cos θ, 0)^N, looked up in the mirrored direction [Heidrich00, eq. 17]. N > 0, else RefletError."""

    phong_exponent: float

    def __post_init__(self) -> None:
        _check(self.phong_exponent)

    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """cos θ = 1 - 2s."""
        with np.errstate(divide="ignore"):
            power = np.exp(self.phong_exponent * np.log1p(-2.0 * np.minimum(s, 0.5)))
        return np.asarray((self.phong_exponent + 1.0) / (2.0 * np.pi) * power)
