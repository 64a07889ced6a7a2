"""Fresnel reflectance: the share of light that a smooth surface mirrors, by the angle to its normal.

All functions are for unpolarized light: the mean of the two polarizations. ``cos_theta_i`` lies in [0, 1].

**Dielectric.** Snell's law with the relative index n = n_inside/n_outside turns the cosine c outside into
cos θ_t = g/n inside, g² = n² - 1 + c². The two reflection coefficients are

    r_s = (c - g)/(c + g),    r_p = (n²c - g)/(n²c + g).

With n² = 1 + (g - c)(g + c), n²c - g = (c - g)·(1 - c(g + c)) and n²c + g = (c + g)·(1 + c(g - c)), so that
(r_s² + r_p²)/2 is r_s²/2·(1 + ((c(g + c) - 1)/(c(g - c) + 1))²), equation 13. Where g² < 0, which takes n < 1,
nothing enters: F = 1, total reflection.

**Conductor.** The same with the complex index n - ik, so that g = a - ib is complex: a² - b² = n² - k² - sin²θ and
2ab = 2nk, hence a² + b² = sqrt((n² - k² - sin²θ)² + 4n²k²) and

    R_s = ((c - a)² + b²)/((c + a)² + b²),    R_p/R_s = ((a - sin²θ/c)² + b²)/((a + sin²θ/c)² + b²).
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

Array = Float[np.ndarray, "*#batch"]
Reflectance = Float[np.ndarray, "..."]


def fresnel_dielectric(cos_theta_i: Array, index: float | Array) -> Reflectance:
    """Reflectance of a dielectric. ``index`` is that of the inside over that of the outside, > 0.

    Implements [Heidrich00, eq. 13]; 1 where all is reflected, inside a denser medium beyond the critical angle.
    """
    c = np.asarray(cos_theta_i, np.float64)
    g_squared = np.square(index) - 1.0 + c * c
    g = np.sqrt(np.maximum(g_squared, 0.0))
    total = (g_squared <= 0.0) | (g + c <= 0.0)
    r_s = (g - c) / np.where(total, 1.0, g + c)
    ratio = (c * (g + c) - 1.0) / np.where(total, 1.0, c * (g - c) + 1.0)
    return np.where(total, 1.0, 0.5 * r_s * r_s * (1.0 + ratio * ratio))


def fresnel_conductor(cos_theta_i: Array, n: float | Array, k: float | Array) -> Reflectance:
    """Reflectance of a conductor of complex index n - ik, seen from vacuum; n > 0, k ≥ 0.

    Implements [BornWolf99, sec. 14.2]. With k = 0 it is `fresnel_dielectric` of index n.
    """
    c = np.asarray(cos_theta_i, np.float64)
    sine_squared = 1.0 - c * c
    real = np.square(n) - np.square(k) - sine_squared
    modulus = np.hypot(real, 2.0 * np.asarray(n) * k)  # a² + b²
    a_twice = 2.0 * np.sqrt(np.maximum(0.5 * (modulus + real), 0.0))
    r_s = (modulus - a_twice * c + c * c) / np.maximum(modulus + a_twice * c + c * c, np.finfo(float).tiny)
    # R_p/R_s, with numerator and denominator multiplied by c²: finite at grazing angles
    even, odd = c * c * modulus + sine_squared * sine_squared, a_twice * c * sine_squared
    return np.asarray(0.5 * r_s * (1.0 + (even - odd) / np.maximum(even + odd, np.finfo(float).tiny)))


def f0_from_index(n: float | Array, k: float | Array = 0.0) -> Reflectance:
    """Reflectance at normal incidence, ((n - 1)² + k²)/((n + 1)² + k²): F0 of Schlick's approximation."""
    return np.asarray((np.square(np.subtract(n, 1.0)) + np.square(k)) / (np.square(np.add(n, 1.0)) + np.square(k)))


def fresnel_schlick(cos_theta_i: Array, f0: float | Array, f90: float | Array = 1.0) -> Reflectance:
    """f0 + (f90 - f0)·(1 - c)⁵. Implements [Schlick94]."""
    return np.asarray(f0 + (np.asarray(f90) - f0) * (1.0 - np.asarray(cos_theta_i)) ** 5)


def fresnel_table(fresnel: Callable[[Float[np.ndarray, "size"]], np.ndarray], size: int = 256) -> np.ndarray:
    """A 1-D texture of ``fresnel`` over cos θ in (0, 1) [Heidrich00, sec. 3.1.1]: entry k holds cosine (k + 0.5)/size.

    Texel centres lie at +0.5, as everywhere: a clamped, linearly filtered lookup at u = cos θ is right but for cosines
    below 0.5/size, which see those of 0.5/size.
    """
    return fresnel((np.arange(size) + 0.5) / size)
