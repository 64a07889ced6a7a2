"""Diffuse prefiltered maps as nine numbers a channel: order-2 spherical harmonics.

L(n) = ∫ L(ω)·max(n·ω, 0)/π dω is a convolution with a radially symmetric kernel, so each band of L's harmonics is
multiplied by a number A_l [Ramamoorthi01, eqs 6 to 8]: by Funk and Hecke's theorem A_l = 2π·∫₀¹ P_l(t)·t/π dt, that is

    A_0 = 1, A_1 = 2/3, A_2 = 2·∫ (3t³ - t)/2 dt = 1/4, A_3 = 0, A_4 = 2·∫ (35t⁵ - 30t³ + 3t)/8 dt = -1/24, …

(π times smaller than the paper's, for we keep irradiance/π). So bands up to 2 leave out little: of the kernel's own
square norm Σ (2l + 1)·A_l²/4π they hold 127/128. What is left shows where a sun stands in a black sky: with c = n·ω
the sum is 1/4 + c/2 + 5(3c² - 1)/32 in place of max(c, 0): off by 3/32 at most, and down to -19/480 on the far side.
Windows that damp the bands make that worse: it is the third band that lifts the other two's -1/4 there. So we clip.
"""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.spherical_harmonics import project, radiance_from_harmonics
from reflet.reflectance.brdfs.quadrature import check_radiance

Coefficients = Float[np.ndarray, "9 channels"]

_BAND = np.array([0, 1, 1, 1, 2, 2, 2, 2, 2])
_CONSTANT = np.sqrt(np.array([1.0, 3.0, 3.0, 3.0, 15.0, 15.0, 1.25, 15.0, 3.75]) / (4.0 * np.pi))  # of Y_lm
_COSINE = np.array([1.0, 2.0 / 3.0, 1.0 / 4.0])  # A_l


def irradiance_harmonics(image: EnvImage) -> Coefficients:
    """Coefficients of irradiance/π over the normal, in bands 0 to 2, ordered as in `envmap.spherical_harmonics`.

    Implements [Ramamoorthi01, eq. 8]. Raises RefletError for radiance that is negative or not finite.
    """
    check_radiance(image)
    return project(image, 3) * _COSINE[_BAND, None]


def polynomial_coefficients(coefficients: Coefficients) -> Coefficients:
    """Factors p of the plain polynomials of a unit normal, for shaders: the harmonics' own constants multiplied in.

    The function is p₀ + p₁y + p₂z + p₃x + p₄xy + p₅yz + p₆(3z² - 1) + p₇xz + p₈(x² - y²), [Ramamoorthi01, eq. 3].
    """
    return coefficients * _CONSTANT[:, None]


def diffuse_map_from_harmonics(coefficients: Coefficients, to: Parameterization, size: int) -> EnvImage:
    """The diffuse map of these coefficients, clipped at 0, in float32."""
    direction, _ = to.texel_directions(size)
    return EnvImage(to, np.maximum(radiance_from_harmonics(coefficients, direction), 0.0).astype(np.float32))
