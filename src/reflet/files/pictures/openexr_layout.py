"""OpenEXR's own layouts of environments (its ImfEnvmap.h), and ours.

OpenEXR's samples lie on a grid whose border is the border of the picture: the first and the last column of a lat-long
show the same meridian, its first and last row are the poles, and each of a cube's faces shows its edges. Ours are
centres of texels. A texel centre always lies between four samples of one face, half a step or so inside its border, so
that reading needs nothing from across a seam; samples on the border lie between texels of two faces, so writing does.
"""

from typing import Literal

import numba
import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import AXES, CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError

# On each face, the direction in which OpenEXR's columns grow, and its rows: all six are mirror images of WebGPU's.
_GROWTH = np.array(
    [
        [[0, 0, 1], [0, -1, 0]],
        [[0, 0, -1], [0, -1, 0]],
        [[1, 0, 0], [0, 0, -1]],
        [[1, 0, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, -1, 0]],
        [[1, 0, 0], [0, -1, 0]],
    ],
    dtype=np.float64,
)


def latlong_from_openexr(image: Float[np.ndarray, "height width channels"]) -> EnvImage:
    """OpenEXR's lat-long picture as ours of the same size, by interpolation along either axis.

    There, column c and row r of W×H samples see longitude atan2(x, z) = π - 2π·c/(W - 1) and latitude
    π/2 - π·r/(H - 1). With φ = atan2(z, x) = π/2 - longitude this is c/(W - 1) = 1/4 + φ/2π = u - 1/4 and
    r/(H - 1) = v: a quarter turn, not a mirror image.

    Raises RefletError where the picture is not twice as wide as high.
    """
    height, width = image.shape[:2]
    if width != 2 * height or height < 2:
        raise RefletError(
            f"A lat-long picture is twice as wide as high, not {width}×{height} pixels; crop or scale it."
        )
    v = (np.arange(height) + 0.5) / height
    u = (np.arange(width) + 0.5) / width
    rows = _interpolated(image, 0, v * (height - 1))
    return EnvImage(LatLong(), _interpolated(rows, 1, np.mod(u - 0.25, 1.0) * (width - 1), wraps=True)[None])


def cube_from_openexr(image: Float[np.ndarray, "height width channels"]) -> EnvImage:
    """OpenEXR's cube, six faces +X -X +Y -Y +Z -Z one below the other, as ours of the same size.

    Interpolated within each face: texel j of N has its centre at s = (2j + 1)/N - 1, sample i lies at 2i/(N - 1) - 1,
    so that texel j lies at sample (j + 1/2)·(N - 1)/N, which is between 0 and N - 1.

    Raises RefletError where the picture is not six times as high as wide.
    """
    height, width = image.shape[:2]
    if height != 6 * width or width < 2:
        raise RefletError(
            f"A cube in OpenEXR's layout is six times as high as wide, 2 or more, not {width}×{height} pixels."
        )
    faces = image.reshape(6, width, width, -1)
    at = (np.arange(width) + 0.5) * ((width - 1) / width)
    mirrored = np.stack([faces[face][_flip(face)] for face in range(6)])
    return EnvImage(CUBE, _interpolated(_interpolated(mirrored, 1, at), 2, at))


def _flip(face: int) -> tuple[slice, slice]:
    """Rows and columns of an OpenEXR face in the order of ours."""
    columns, rows = (int(_GROWTH[face, k] @ AXES[face, 1 + k]) for k in range(2))
    return slice(None, None, rows), slice(None, None, columns)


def _interpolated(samples: np.ndarray, axis: int, position: np.ndarray, wraps: bool = False) -> np.ndarray:
    """Samples at real positions from 0 to n - 1 along one axis; ``wraps`` where samples 0 and n - 1 are the same.

    The cubic through two samples on either side [Keys81], but never beyond the two between which the position lies:
    sharper than linear interpolation, yet a sun rings no darkness around it, and a constant stays exactly constant.
    """
    shape = samples.shape
    flat = np.ascontiguousarray(samples).reshape(int(np.prod(shape[:axis])), shape[axis], -1)
    return _interpolate(flat, position, wraps).reshape(*shape[:axis], len(position), *shape[axis + 1 :])


@numba.njit(cache=True)
def _interpolate(samples: np.ndarray, position: np.ndarray, wraps: bool) -> np.ndarray:
    outer, count, inner = samples.shape
    out = np.empty((outer, position.size, inner), samples.dtype)
    for k in range(outer):
        for j in range(position.size):
            at = min(max(int(position[j]), 0), count - 2)
            t = position[j] - at
            before = at - 1 if at > 0 else count - 2
            after = at + 2 if at + 2 < count else 1
            for i in range(inner):
                low, high = samples[k, at, i], samples[k, at + 1, i]
                # beyond the last sample the straight line goes on
                left = samples[k, before, i] if wraps or at > 0 else 2.0 * low - high
                right = samples[k, after, i] if wraps or at + 2 < count else 2.0 * high - low
                bend = 2.0 * left - 5.0 * low + 4.0 * high - right
                value = low + 0.5 * t * (high - left + t * (bend + t * (3.0 * (low - high) + right - left)))
                out[k, j, i] = min(max(value, min(low, high)), max(low, high))
    return out


def openexr_directions(
    layout: Literal["latlong", "cube"], width: int, height: int
) -> Float[np.ndarray, "height width 3"]:
    """Unit directions of all samples of a picture in OpenEXR's layout, for whoever fills one.

    Raises RefletError where the size does not suit the layout: a cube is six times as high as wide.
    """
    if layout == "latlong":
        if min(width, height) < 2:
            raise RefletError(f"A lat-long picture in OpenEXR's layout has 2×2 samples or more, not {width}×{height}.")
        longitude = np.pi - 2.0 * np.pi * np.arange(width) / (width - 1)
        latitude = (0.5 * np.pi - np.pi * np.arange(height) / (height - 1))[:, None]
        y = np.broadcast_to(np.sin(latitude), (height, width))
        ring = np.cos(latitude)
        return np.stack([ring * np.sin(longitude), y, ring * np.cos(longitude)], -1)
    if height != 6 * width or width < 2:
        raise RefletError(
            f"A cube in OpenEXR's layout is six times as high as wide, 2 or more, not {width}×{height} samples."
        )
    at = np.linspace(-1.0, 1.0, width)
    direction = (
        AXES[:, None, None, 0] + at[:, None] * _GROWTH[:, None, None, 0] + at[:, None, None] * _GROWTH[:, None, None, 1]
    )
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    return direction.reshape(height, width, 3)
