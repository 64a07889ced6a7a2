"""The other half of the split sum: what the BRDF reflects of constant light, as a table.

With Schlick's F = f0 + (1 - f0)·(1 - v·h)⁵ (f90 = 1) the integral of the BRDF over the hemisphere is f0·A + B
[Karis13],

    A = ∫ D·V·(1 - Fc)·n·l dl,   B = ∫ D·V·Fc·n·l dl,   Fc = (1 - v·h)⁵.

**Sampling.** Half vectors of density D·(n·h) give directions l of density D·(n·h)/(4·v·h); the integrand over it is
V·n·l·4·v·h/(n·h), so that over samples

    A, B = mean of 4·V·(n·l)·(v·h)/(n·h)·(1 - Fc, Fc) where n·l > 0.

GGX's half vectors have cos²θ_h = (1 - u)/(1 + (α² - 1)·u) for u in [0, 1) [Walter07, eq. 35]. Near u = 1 the 1/(n·h)
grows like (1 - u)^-½: with u = 1 - t² and the factor du/dt = 2t it is gone, and with it nine tenths of the error. t is
taken at midpoints and the azimuth, from 0 to π for symmetry, at golden-ratio steps: half the error of Hammersley's
points.

**Sheen** has no f0; the third number is ∫ D·V·n·l dl with Charlie's D and V. It is smooth: Gauss-Legendre quadrature.
"""

import numpy as np
from jaxtyping import Float

from reflet.reflectance.brdfs.brdf import directional_albedo
from reflet.reflectance.brdfs.charlie import Charlie
from reflet.reflectance.brdfs.ggx import v_smith_ggx

SAMPLES = 4096
_GOLDEN = 0.6180339887498949
_LEAST_ALPHA = 1e-4  # below, GGX is a mirror to float32
_SHEEN_ALPHA = 0.07  # below, the fitted V gives sheen more light than comes in


def dfg(n_dot_v: Float[np.ndarray, "views"], alpha: float, samples: int = SAMPLES) -> Float[np.ndarray, "views 2"]:
    """(A, B) for n·v in (0, 1] and alpha in [0, 1]: f0·A + B of white light is reflected. Good to 4e-4.

    Implements [Karis13] with height-correlated V.
    """
    _, v_dot_h, weight = half_vector_samples(n_dot_v, alpha, samples)
    fresnel = (1.0 - v_dot_h) ** 5
    return np.stack([(weight * (1.0 - fresnel)).mean(-1), (weight * fresnel).mean(-1)], -1)


def half_vector_samples(
    n_dot_v: Float[np.ndarray, "views"], alpha: float, samples: int
) -> tuple[
    Float[np.ndarray, "views samples 2"], Float[np.ndarray, "views samples"], Float[np.ndarray, "views samples"]
]:
    """(l, v·h, weight): the mean of weight·g(l) is ∫ D·V·g(l)·n·l dl for F = 1, for g symmetric about v's plane.

    n is the second axis; of l stand (along v's projection on the surface, n·l). ``weight`` is 0 below the surface.
    """
    alpha = max(alpha, _LEAST_ALPHA)
    t = (np.arange(samples) + 0.5) / samples
    cos_phi = np.cos(np.pi * np.mod(_GOLDEN * np.arange(samples) + 0.5, 1.0))
    n_dot_h = t / np.sqrt(1.0 - (1.0 - alpha * alpha) * (1.0 - t * t))
    sin_h = np.sqrt(1.0 - n_dot_h * n_dot_h)
    view = n_dot_v[:, None]
    sin_v = np.sqrt(1.0 - view * view)
    v_dot_h = view * n_dot_h + sin_v * sin_h * cos_phi
    n_dot_l = 2.0 * v_dot_h * n_dot_h - view
    lit = np.where(n_dot_l > 0.0, n_dot_l, 0.0)  # v·h > 0 follows
    weight = 4.0 * v_smith_ggx(lit, view, alpha) * lit * v_dot_h / n_dot_h * (2.0 * t)
    return np.stack([2.0 * v_dot_h * sin_h * cos_phi - sin_v, n_dot_l], -1), v_dot_h, weight


def dfg_lut(size: int = 128, samples: int = SAMPLES) -> Float[np.ndarray, "size size 3"]:
    """A table of (A, B, sheen) at texel centres, in float32: columns by n·v, rows by perceptual_roughness.

    Both run from 0 at the top left to 1. Some seconds for 128².
    """
    centre = (np.arange(size) + 0.5) / size
    table = np.empty((size, size, 3), np.float32)
    for row, perceptual_roughness in enumerate(centre):
        alpha = float(perceptual_roughness**2)
        table[row, :, :2] = dfg(centre, alpha, samples)
        table[row, :, 2] = directional_albedo(Charlie(max(alpha, _SHEEN_ALPHA)), centre, nodes=64)[:, 0]
    return table


def energy_compensation(f0: Float[np.ndarray, "*#batch"], albedo: Float[np.ndarray, "*#batch"]) -> np.ndarray:
    """Factor of the reflected light that makes up for what bounces between microfacets, which GGX leaves out.

    ``albedo`` is A + B. A white metal (f0 = 1) then reflects all. Implements [Turquin19, eq. 16].
    """
    return np.asarray(1.0 + f0 * (1.0 / albedo - 1.0))
