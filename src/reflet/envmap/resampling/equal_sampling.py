"""How large a map of one parameterization must be to hold as much as one of another."""

import numpy as np

from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.sampling import valid_texels


def equal_sampling_size(parameterization: Parameterization, texels: float, power_of_two: bool = False) -> int:
    """Rows of a face for about ``texels`` texels over the sphere, at least 1: the nearest power of two where asked.

    Otherwise sizes of 64 and more are multiples of 8: within 6 %, and kind to blocks, mip levels and memory.
    """
    size = (texels / valid_texels(parameterization)) ** 0.5
    if power_of_two:
        return int(2 ** np.round(np.log2(max(size, 1.0))))
    return int(8.0 * np.round(size / 8.0) if size >= 64.0 else max(np.round(size), 1.0))
