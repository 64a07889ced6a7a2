"""Env maps and environments as small files of AV1."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32

from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.files.unreadable import unreadable
from reflet.pem.coding.atlas import Atlas, Layout, Raster
from reflet.pem.coding.avif import fits
from reflet.pem.coding.coded_light import QUALITY, decode_light, encode_light

MOST_PLANES = 5
_ROWS_CODED = 4  # levels with fewer rows are stored as they are


def check_codable(chain: MipChain) -> None:
    """Raises RefletError where maps of this kind are too large for AVIF."""
    rows, columns = Atlas(chain).shape
    if not fits(MOST_PLANES * rows, columns):
        raise RefletError(
            f"Maps of {chain.size} rows are too large to be coded as AV1 pictures; give smaller ones, or --codec none."
        )


def write_coded_map(
    path: Path, chain: MipChain, texels: Float[np.ndarray, "texels channels"], quality: int = QUALITY
) -> None:
    """Write a map with all its mip levels, atomically; equal texels give equal bytes.

    ``texels`` have 3 channels, or 4, premultiplied by alpha. Radiance is clamped to [0, 65504]. ``quality``: 0 to 100.
    Raises RefletError where a texel is not a number, the map is too large or the file cannot be written.
    """
    check_codable(chain)
    if np.isnan(texels).any():
        raise RefletError(f"The map {path} holds values that are not numbers; nothing was written.")
    atomic_write(path, encode_light(np.asarray(texels, np.float32), Atlas(chain), _exact_from(chain), quality))


def read_coded_map(path: Path, chain: MipChain, channels: int) -> Float32[np.ndarray, "texels channels"]:
    """The texels that `write_coded_map` wrote. Raises RefletError where the file is missing, another's or damaged."""
    what = f"{chain.parameterization.name} of {chain.size} rows with {channels} channels"
    return _read(path, Atlas(chain), chain.texel_count, channels, _exact_from(chain), what)


def environment_fits(rows: int, columns: int) -> bool:
    """Whether an environment of this size can be coded."""
    return fits((MOST_PLANES - 1) * rows, columns)


def write_coded_environment(
    path: Path, radiance: Float32[np.ndarray, "rows columns 3"], quality: int = QUALITY
) -> None:
    """Write a lat-long picture, as `write_coded_map` does."""
    rows, columns, _ = radiance.shape
    texels = radiance.reshape(-1, 3)
    atomic_write(path, encode_light(texels, Raster(rows, columns), len(texels), quality))


def read_coded_environment(path: Path, rows: int, columns: int) -> Float32[np.ndarray, "rows columns 3"]:
    """The radiance that `write_coded_environment` wrote. Raises RefletError as `read_coded_map` does."""
    count = rows * columns
    what = f"picture of {columns}×{rows} texels"
    return _read(path, Raster(rows, columns), count, 3, count, what).reshape(rows, columns, 3)


def _read(
    path: Path, layout: Layout, count: int, channels: int, exact_from: int, what: str
) -> Float32[np.ndarray, "texels channels"]:
    try:
        file = path.read_bytes()
    except OSError as error:
        raise unreadable(path, error) from None
    try:
        return decode_light(file, layout, count, channels, exact_from)
    except ValueError as error:
        raise RefletError(
            f"{path} is not the coded {what} that scene.gltf says, or is truncated or damaged ({error}); "
            "copy it again, or bake again."
        ) from None


def _exact_from(chain: MipChain) -> int:
    """Number of the first texel of the levels that are stored as they are."""
    return chain.offsets[sum(size >= _ROWS_CODED for size in chain.level_sizes)]
