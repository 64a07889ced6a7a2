"""Environments that light scenes: whatever a file holds, as a lat-long map."""

import math
import os

import numpy as np
from jaxtyping import Float32

from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_light

LatLong = Float32[np.ndarray, "height width 3"]


def read_environment(
    path: str | os.PathLike[str], source_is: Parameterization | None = None, layer: str | None = None
) -> LatLong:
    """Radiance of an environment with +x in the middle: u = 1/2 + atan2(z, x)/2π, v = acos(y)/π.

    ``path`` is anything that `read_light` takes, ``source_is`` its parameterization where it does not tell,
    ``layer`` that of an .exr. Maps that are not lat-long are resampled, as finely along the equator as they are on
    average. Negative radiance is taken as 0, and warned of. Raises RefletError for files that are missing, damaged, of
    no or of unknown kind, or hold radiance that is not finite.
    """
    image = read_light(path, source_is, layer=layer)
    latlong = parameterization("latlong")
    if image.parameterization != latlong:
        # a map of n texels has n/4π in a steradian; so many has one of H rows, H²/π², at its equator
        rows = math.ceil(0.5 * math.sqrt(math.pi * math.prod(image.texels.shape[:3])))
        image = resample(image, latlong, rows)
    return np.ascontiguousarray(image.texels[0, ..., :3])
