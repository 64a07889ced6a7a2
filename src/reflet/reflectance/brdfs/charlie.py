"""Sheen: the microfacet reflection of cloth, with normals that stand up.

D = (2 + 1/α)·sin(θ_h)^(1/α)/2π and V = 1/((1 + Λ(l) + Λ(v))·4·n·l·n·v), Λ a fitted function [EstevezKulla17], as in
glTF's KHR_materials_sheen with α = perceptual_roughness².

**The kernel** follows GGX's (`ggx`): D·cos⁺ with n = v = r, normalized. As sin²θ_h = s, with p = 1/2α and w = 2s =
1 - cos θ it is proportional to w^p·(1 - w), and with dω = 2π·dw

    2π·∫₀¹ w^p·(1 - w) dw = 2π/((p + 1)(p + 2)),    so k = (p + 1)(p + 2)/2π·(1 - cos θ)^p·cos⁺θ.

It is dark in the middle and brightest towards the horizon.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf, Cosine, Values, half_vector_cosines
from reflet.reflectance.brdfs.kernel import Kernel

# The fit's parameters a to e for α = 1 and α = 0, blended by (1 - α)²
_SMOOTH = np.array([25.3245, 3.32435, 0.16801, -1.27393, -4.85967])
_ROUGH = np.array([21.5473, 3.82987, 0.19823, -1.97760, -4.32054])


def d_charlie(n_dot_h: Cosine, alpha: float) -> Float[np.ndarray, "..."]:
    """Density of microfacet normals, per steradian: ∫ D·(n·h) dω = 1. Implements [EstevezKulla17, eq. 2]."""
    sine = np.sqrt(np.maximum(1.0 - np.square(n_dot_h), 0.0))
    return np.asarray((2.0 + 1.0 / alpha) * sine ** (1.0 / alpha) / (2.0 * np.pi))


def v_charlie(n_dot_l: Cosine, n_dot_v: Cosine, alpha: float) -> Float[np.ndarray, "..."]:
    """G/(4·n·l·n·v). Implements [EstevezKulla17, eq. 3] without its softened terminator, which is not reciprocal."""
    both = 1.0 + _lambda(n_dot_l, alpha) + _lambda(n_dot_v, alpha)
    return np.asarray(1.0 / (both * 4.0 * n_dot_l * n_dot_v))


def _lambda(cosine: Cosine, alpha: float) -> np.ndarray:
    a, b, c, d, e = _ROUGH + (1.0 - alpha) ** 2 * (_SMOOTH - _ROUGH)

    def curve(x: np.ndarray | float) -> np.ndarray:
        return np.asarray(a / (1.0 + b * np.power(x, c)) + d * np.asarray(x) + e)

    x = np.asarray(cosine)
    return np.asarray(np.exp(np.where(x < 0.5, curve(x), 2.0 * curve(0.5) - curve(1.0 - x))))


def _check(alpha: float) -> None:
    if not 0.0 < alpha <= 1.0:
        raise RefletError(f"Sheen needs an alpha (perceptual_roughness²) in (0, 1], not {alpha}.")


@dataclass(frozen=True)
class Charlie(Brdf):
    """D·V for a sheen colour of 1. 0 < alpha ≤ 1, else RefletError."""

    alpha: float

    def __post_init__(self) -> None:
        _check(self.alpha)

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """See the class."""
        n_dot_h, _ = half_vector_cosines(cos_theta_i, cos_theta_o, cos_delta_phi)
        return (d_charlie(n_dot_h, self.alpha) * v_charlie(cos_theta_i, cos_theta_o, self.alpha))[..., None]


@dataclass(frozen=True)
class CharlieKernel(Kernel):
    """The split sum's kernel for sheen, looked up in the mirrored direction. 0 < alpha ≤ 1, else RefletError."""

    alpha: float

    def __post_init__(self) -> None:
        _check(self.alpha)

    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """See the module."""
        p, w = 0.5 / self.alpha, np.minimum(2.0 * s, 1.0)
        return np.asarray((p + 1.0) * (p + 2.0) / (2.0 * np.pi) * w**p * (1.0 - w))
