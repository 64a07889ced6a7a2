"""A BRDF table as a gonioreflectometer gives it, made by formulas: a worn, dusty satin paint, with noise.

Run it with the file to write, and look at what it holds::

    python examples/brdf_table.py out/satin.npz
    reflet info out/satin.npz

Three things happen on this surface, none of which a prefiltered Phong map can show: rough dielectric facets, whose
highlight at grazing angles lies beyond the mirrored direction [TorranceSparrow67]; paint that is flatter than
Lambert's [OrenNayar94]; and dust that throws light back to where it came from. Every value is off by 2 %, at random.
The format is described in docs/brdf_table.md.
"""

import sys
from pathlib import Path

import numpy as np

from reflet.files.measured_brdf_file import write_measured_brdf
from reflet.reflectance.brdfs.brdf import cosine_between, half_vector_cosines
from reflet.reflectance.brdfs.fresnel import fresnel_dielectric
from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf

PAINT = np.array([0.36, 0.07, 0.05])  # what a matt surface of this colour would reflect
DUST = np.array([0.10, 0.10, 0.09])
SLOPE = 0.28  # root mean square slope of the facets
SIGMA = np.deg2rad(30.0)  # spread of the paint's own facets
RETRO_EXPONENT = 30.0
NOISE = 0.02


def main(out: Path, step_deg: float = 5.0) -> None:
    """Writes the table, angles ``step_deg`` apart."""
    write_measured_brdf(out, measured(step_deg))
    print(f"{out} is written; `reflet info {out}` tells what it holds.")


def measured(step_deg: float = 5.0, noise: float = NOISE) -> MeasuredBrdf:
    """`satin` at angles up to 85°, as instruments reach, each value off by some ``noise`` of itself."""
    theta = np.deg2rad(np.arange(0.0, 85.1, step_deg))
    phi = np.linspace(0.0, np.pi, round(180.0 / step_deg) + 1)
    exact = satin(np.cos(theta)[:, None, None], np.cos(theta)[None, :, None], phi)
    values = exact * (1.0 + noise * np.random.default_rng(7).normal(size=exact.shape))
    return MeasuredBrdf(theta, theta, phi, np.maximum(values, 0.0))


def satin(cos_i: np.ndarray, cos_o: np.ndarray, delta_phi: np.ndarray) -> np.ndarray:
    """The BRDF per steradian in red, green and blue, of the cosines' shape and three channels."""
    n_dot_h, v_dot_h = half_vector_cosines(cos_i, cos_o, np.cos(delta_phi))
    square = n_dot_h**2
    facets = np.exp((1.0 - 1.0 / square) / SLOPE**2) / (np.pi * SLOPE**2 * square**2)
    seen = np.minimum(1.0, 2.0 * n_dot_h * np.minimum(cos_i, cos_o) / v_dot_h)
    gloss = facets * seen * fresnel_dielectric(np.minimum(v_dot_h, 1.0), 1.5) / (4.0 * cos_i * cos_o)

    a = 1.0 - 0.5 * SIGMA**2 / (SIGMA**2 + 0.33)
    b = 0.45 * SIGMA**2 / (SIGMA**2 + 0.09)
    sines = np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2))
    matt = (a + b * np.maximum(np.cos(delta_phi), 0.0) * sines / np.maximum(cos_i, cos_o)) / np.pi

    back = np.maximum(cosine_between(cos_i, cos_o, np.cos(delta_phi)), 0.0) ** RETRO_EXPONENT
    retro = (RETRO_EXPONENT + 1.0) / (2.0 * np.pi) * back
    return np.asarray(gloss[..., None] + matt[..., None] * PAINT + retro[..., None] * DUST)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
