"""Spherical harmonics as JSON that says what its numbers are."""

import json
import os

import numpy as np
from jaxtyping import Float

from reflet.files.atomic import atomic_write
from reflet.reflectance.prefilter.irradiance_sh import polynomial_coefficients


def write_harmonics(
    path: str | os.PathLike[str],
    radiance: Float[np.ndarray, "9 3"],
    irradiance: Float[np.ndarray, "9 3"],
    source: str,
) -> None:
    """Writes the order-2 coefficients of radiance and of irradiance/π. Raises RefletError as `atomic_path` does."""
    document = {
        "source": source,
        "order": "index l*l + l + m: L00, L1-1, L10, L11, L2-2, L2-1, L20, L21, L22; each red, green, blue",
        "basis": "real, orthonormal over the sphere, no Condon-Shortley sign: Y1 = 0.488603*(y, z, x); +y is up",
        "radiance": _rows(radiance),
        "irradiance_over_pi": _rows(irradiance),
        "irradiance_polynomial": _rows(polynomial_coefficients(irradiance)),
        "irradiance_polynomial_of_normal": "p0 + p1*y + p2*z + p3*x + p4*x*y + p5*y*z + p6*(3*z*z - 1) + p7*x*z"
        " + p8*(x*x - y*y), clipped at 0: the radiance of a white diffuse surface",
    }
    # one coefficient a line
    text = json.dumps(document, indent=1).replace("[\n   ", "[").replace(",\n   ", ", ").replace("\n  ]", "]")
    atomic_write(path, (text + "\n").encode())


def _rows(coefficients: Float[np.ndarray, "9 3"]) -> list[list[float]]:
    return [[float(f"{x:.9g}") for x in row] for row in coefficients]
