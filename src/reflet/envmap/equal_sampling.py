"""How large a map of one parameterization must be to hold as much as one of another."""

import numpy as np

from reflet.envmap.parameterization import Parameterization


def texels_over_sphere(parameterization: Parameterization) -> float:
    """Texels that a map of size 1 spends on the sphere: what lies outside the discs of a round map does not count."""
    _, corner_is_valid = parameterization.direction_from_uv(np.zeros(1, np.int64), np.zeros((1, 2)))
    faces, rows, columns = parameterization.shape(1)
    return faces * rows * columns * (1.0 if corner_is_valid[0] else np.pi / 4.0)


def equal_sampling_size(parameterization: Parameterization, texels: float) -> int:
    """Rows of a face for about ``texels`` texels over the sphere, at least 1: rounded to a power of two if within 2 %.

    Powers of two have whole mip chains; 2 % more or less cannot be seen.
    """
    size = (texels / texels_over_sphere(parameterization)) ** 0.5
    power = 2.0 ** np.round(np.log2(max(size, 1.0)))
    return int(power if abs(size - power) <= 0.02 * power else max(np.round(size), 1.0))
