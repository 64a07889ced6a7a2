"""Images for files, and what their formats round."""

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS

LATLONG, PARABOLOID, ANGULAR = (PARAMETERIZATIONS[name] for name in ("latlong", "dual_paraboloid", "angular"))


# Largest error of values in [0, 0.9]: half a step of the format at its coarsest there.
STEP = {
    ".hdr": 1 / 256 / 2,  # mantissas of 8 bits
    ".exr": 0.0,
    ".png": 0.5 / 255 * 2.3,  # half a code, times the slope of sRGB's curve at white
    ".ktx2": 2.0**-12,  # of half floats in [0.5, 1]
    ".ktx": 2.0**-12,
    ".dds": 2.0**-12,
}


def random_levels(laid_out):
    """Levels need not be filtered copies of each other."""
    return [random_image(laid_out, size) for size in (8, 4, 2, 1)]


def random_image(laid_out, size=8, channels=3):
    """Values below 0.9: shared exponents stay below that of 1."""
    rng = np.random.default_rng(5)
    return EnvImage(laid_out, (0.9 * rng.random((*laid_out.shape(size), channels))).astype(np.float32))
