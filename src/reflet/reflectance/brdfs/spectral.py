"""From refractive indices over the wavelength to linear Rec. 709.

A reflectance spectrum R(λ) under an illuminant S(λ) has the tristimulus values XYZ = ∫R·S·(x̄, ȳ, z̄)dλ / ∫S·ȳ dλ. We
take S = D65, the white of Rec. 709, so that R = 1 is RGB (1, 1, 1); what is left of the matching functions' error there
(they are fits) is divided out. The matching functions are the CIE 1931 ones as fitted by [Wyman13, sec. 2.2].
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares

from reflet.errors import RefletError
from reflet.reflectance.brdfs.fresnel import fresnel_conductor

WAVELENGTHS = np.arange(380.0, 781.0, 5.0)  # nm, of all integrals; measured metals are smoother than this

# Relative power of CIE standard illuminant D65 at 380, 390, … 780 nm [CIE15]; linear in between by definition.
_D65 = np.array(
    [
        49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811,
        109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062, 89.5991,
        87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856,
        75.087, 63.5927, 46.4182, 66.8054, 63.3828,
    ]
)  # fmt: skip

# [Wyman13, table 1]: amplitude, mean, widths below and above the mean (nm)
_LOBES = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)

# Linear Rec. 709 from XYZ, from the standard's chromaticities and D65 (0.3127, 0.3290)
RGB_FROM_XYZ = np.linalg.inv(
    np.array(
        [
            [0.4123907993, 0.3575843394, 0.1804807884],
            [0.2126390059, 0.7151686788, 0.0721923154],
            [0.0193308187, 0.1191947798, 0.9505321522],
        ]
    )
)


@dataclass(frozen=True)
class SpectralIndex:
    """Complex index of refraction n - ik over the wavelength: nm, ascending, from at most 380 to at least 780."""

    wavelength: Float[np.ndarray, "samples"]
    n: Float[np.ndarray, "samples"]
    k: Float[np.ndarray, "samples"]

    def __post_init__(self) -> None:
        if len(self.wavelength) < 2 or self.wavelength[0] > WAVELENGTHS[0] or self.wavelength[-1] < WAVELENGTHS[-1]:
            raise RefletError("A table of refractive indices must span 380 to 780 nm; take one that does.")
        if (np.diff(self.wavelength) <= 0.0).any() or (self.n <= 0.0).any() or (self.k < 0.0).any():
            raise RefletError("A table of refractive indices needs ascending wavelengths, n > 0 and k ≥ 0; repair it.")

    def at(self, wavelength: Float[np.ndarray, "*batch"]) -> tuple[np.ndarray, np.ndarray]:
        """n and k, linear between samples."""
        return np.interp(wavelength, self.wavelength, self.n), np.interp(wavelength, self.wavelength, self.k)


def matching_functions(wavelength: Float[np.ndarray, "samples"]) -> Float[np.ndarray, "samples 3"]:
    """CIE 1931 x̄, ȳ, z̄ at wavelengths in nm. Implements [Wyman13, eq. 4]."""

    def lobe(amplitude: float, mean: float, below: float, above: float) -> np.ndarray:
        deviation = (wavelength - mean) / np.where(wavelength < mean, below, above)
        return amplitude * np.exp(-0.5 * deviation * deviation)

    return np.stack([np.sum([lobe(*each) for each in lobes], axis=0) for lobes in _LOBES], -1)


def d65(wavelength: Float[np.ndarray, "samples"]) -> Float[np.ndarray, "samples"]:
    """Relative spectral power of D65 at wavelengths in nm, 100 at 560 nm."""
    return np.interp(wavelength, np.arange(380.0, 781.0, 10.0), _D65)


def rgb_from_reflectance(reflectance: Float[np.ndarray, "samples *batch"]) -> Float[np.ndarray, "*batch 3"]:
    """Linear Rec. 709 of reflectance sampled at `WAVELENGTHS`, under D65. Saturated spectra may leave [0, 1]."""
    weight = d65(WAVELENGTHS)[:, None] * matching_functions(WAVELENGTHS)
    rgb_weight = weight @ RGB_FROM_XYZ.T
    rgb_weight /= rgb_weight.sum(0)
    return np.tensordot(np.moveaxis(reflectance, 0, -1), rgb_weight, 1)


def f0_rgb(index: SpectralIndex) -> Float[np.ndarray, "3"]:
    """Reflectance at normal incidence as linear Rec. 709 under D65, clipped to [0, 1]."""
    n, k = index.at(WAVELENGTHS)
    return np.clip(rgb_from_reflectance(fresnel_conductor(np.ones_like(n), n, k)), 0.0, 1.0)


def index_rgb(index: SpectralIndex) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """(n, k) for each channel, with which `fresnel_conductor` comes closest to the spectrum's colour at all angles.

    The mean of n(λ) and k(λ) would not do: reflectance is not linear in them. Least squares over cos θ in [0, 1]; the
    colour at each angle is clipped to [0, 1] first.
    """
    n, k = index.at(WAVELENGTHS)
    cosine = np.linspace(0.0, 1.0, 65)
    colour = np.clip(rgb_from_reflectance(fresnel_conductor(cosine, n[:, None], k[:, None])), 0.0, 1.0)
    start = np.clip(rgb_from_reflectance(np.stack([n, k], -1)), 0.05, 15.0)
    fits = [
        least_squares(
            lambda nk, target=colour[:, c]: fresnel_conductor(cosine, nk[0], nk[1]) - target,
            start[:, c],
            bounds=([1e-3, 0.0], [20.0, 20.0]),
        ).x
        for c in range(3)
    ]
    return np.array([fit[0] for fit in fits]), np.array([fit[1] for fit in fits])
