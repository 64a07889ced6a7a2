"""The microfacet reflection of GGX, and the kernel of its prefiltered maps.

f = D·V·F with D the normals' distribution [Walter07, eq. 33] and V = G/(4·n·l·n·v) with the height-correlated masking
and shadowing of Smith [Heitz14]. F is left to the caller.

**The kernel.** Image-based lighting with prefiltered maps splits the reflection integral in two [Karis13]: the map, and
a table of the BRDF (`dfg`). The map is filtered as if seen along its normal, n = v = r, and what engines sample is
D·(n·h) weighted by n·l and normalized. A half vector of density D·(n·h) makes a direction l of density
D·(n·h)/(4·v·h) = D/4, so the kernel is

    k(θ) = D(θ/2)·max(cos θ, 0)/∫ D·cos⁺ dω,    for n·h = cos(θ/2) where v = n.

With s = sin²(θ/2), (n·h)² = 1 - s, so D = α²/(π·(α² + b·s)²), b = 1 - α², and cos θ = 1 - 2s. The normalization, with
dω = 4π·ds and t = α² + b·s from α² to T = (1 + α²)/2:

    4α²·∫₀^½ (1 - 2s)/(α² + bs)² ds = 4α²/b²·∫ (1 + α² - 2t)/t² dt = 4α²/b²·[-(1 + α²)/t - 2·ln t]
                                   = 4/b²·(b - 2α²·ln(T/α²)) = 8α²/b²·(u - ln(1 + u)),    u = T/α² - 1 = b/2α².

For α = 1 it is 1 and the kernel that of diffuse reflection.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf, Cosine, Values, half_vector_cosines
from reflet.reflectance.brdfs.kernel import Kernel


def d_ggx(n_dot_h: Cosine, alpha: float) -> Float[np.ndarray, "..."]:
    """Density of microfacet normals, per steradian: ∫ D·(n·h) dω = 1. Implements [Walter07, eq. 33]."""
    root = 1.0 - (1.0 - alpha * alpha) * np.square(n_dot_h)
    return np.asarray(alpha * alpha / (np.pi * root * root))


def v_smith_ggx(n_dot_l: Cosine, n_dot_v: Cosine, alpha: float) -> Float[np.ndarray, "..."]:
    """G/(4·n·l·n·v), height-correlated. Implements [Heitz14, eq. 99]."""
    square = alpha * alpha
    masking = n_dot_l * np.sqrt(square + (1.0 - square) * np.square(n_dot_v))
    shadowing = n_dot_v * np.sqrt(square + (1.0 - square) * np.square(n_dot_l))
    return np.asarray(0.5 / (masking + shadowing))


def _check(alpha: float) -> None:
    if not 0.0 < alpha <= 1.0:
        raise RefletError(f"GGX needs an alpha (perceptual_roughness²) in (0, 1], not {alpha}; a mirror has no lobe.")


@dataclass(frozen=True)
class Ggx(Brdf):
    """D·V for F = 1: single scattering, which loses energy as α grows. 0 < alpha ≤ 1, else RefletError."""

    alpha: float

    def __post_init__(self) -> None:
        _check(self.alpha)

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """See the class."""
        n_dot_h, _ = half_vector_cosines(cos_theta_i, cos_theta_o, cos_delta_phi)
        return (d_ggx(n_dot_h, self.alpha) * v_smith_ggx(cos_theta_i, cos_theta_o, self.alpha))[..., None]


@dataclass(frozen=True)
class GgxKernel(Kernel):
    """The split sum's kernel, looked up in the mirrored direction. 0 < alpha ≤ 1, else RefletError."""

    alpha: float

    def __post_init__(self) -> None:
        _check(self.alpha)

    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """Implements [Karis13], see the module."""
        square = self.alpha * self.alpha
        b = 1.0 - square
        u = 0.5 * b / square
        # u - ln(1 + u) loses its digits where u is small; 8α²/b² is 2/(α²·u²)
        rest = u - np.log1p(u) if u > 1e-2 else u * u * (1 / 2 - u * (1 / 3 - u * (1 / 4 - u * (1 / 5 - u / 6))))
        total = 2.0 / square * (rest / (u * u) if u > 0.0 else 0.5)
        d = square / (np.pi * np.square(square + b * s))
        return np.asarray(d * np.maximum(1.0 - 2.0 * s, 0.0) / total)
