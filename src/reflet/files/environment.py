"""Reading lat-long environments into the project's own convention: the file boundary where conversion happens."""

import os
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from reflet.errors import RefletError
from reflet.files.exr import read_exr_layout
from reflet.files.hdr import read_hdr
from reflet.files.openexr_layout import latlong_from_openexr

LatLong = Float32[np.ndarray, "height width 3"]


def read_environment(path: str | os.PathLike[str]) -> LatLong:
    """Radiance of a lat-long .hdr or .exr file with +x in the middle: u = 1/2 + atan2(z, x)/2π, v = acos(y)/π.

    Plain files are taken as they are; files with OpenEXR's ``envmap`` attribute follow OpenEXR's own convention and are
    resampled. Raises RefletError for files that are missing, damaged, no lat-long picture, or hold radiance that is
    negative or not finite.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".hdr":
        image = read_hdr(path)
    elif suffix == ".exr":
        image, layout = read_exr_layout(path)
        image = image[..., :3] if image.shape[2] >= 3 else np.repeat(image, 3, axis=2)
        if layout == "cube":
            raise RefletError(f"{path} holds a cube map; give a lat-long picture instead.")
        if layout == "latlong":
            _check(path, image)
            image = latlong_from_openexr(image).texels[0]
    else:
        raise RefletError(f"{path} is no environment that can be read; give a lat-long .hdr or .exr file.")
    _check(path, image)
    return np.ascontiguousarray(image)


def _check(path: str | os.PathLike[str], image: LatLong) -> None:
    height, width = image.shape[:2]
    if width != 2 * height or height < 2:
        raise RefletError(f"{path} is {width}×{height} pixels; a lat-long picture is twice as wide as high.")
    if not np.isfinite(image).all():
        raise RefletError(f"{path} holds radiance that is not finite (NaN or infinite); repair these pixels.")
    if image.min() < 0.0:
        raise RefletError(f"{path} holds negative radiance ({image.min():g}); clip it to zero.")
