"""From one environment map file to another: read, resample, filter mip levels, write."""

from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.turned import turned
from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT, Rotation, turn_about_vertical
from reflet.envmap.sampling import valid_texels
from reflet.errors import RefletError
from reflet.files.env_image_file import read_levels, write_env_image
from reflet.files.textures.env_texture import holdable
from reflet.progress import ProgressCallback, silent

WITH_MIP_LEVELS = (".ktx2", ".ktx", ".dds")  # formats of textures, which come with their mip levels
LARGEST = 16384  # rows of a face: graphics systems take no larger textures


def convert(
    source: str | Path,
    out: str | Path,
    *,
    to: Parameterization | None = None,
    size: int | None = None,
    source_is: Parameterization | None = None,
    turn_deg: float = 0.0,
    up: str = "y",
    scale: float = 1.0,
    repair: bool = False,
    layer: str | None = None,
    layout: str | None = None,
    mips: bool | None = None,
    texel_format: str | None = None,
    zstd: bool = False,
    progress: ProgressCallback = silent,
) -> EnvImage:
    """Writes the environment in ``source`` to ``out`` in the parameterization ``to`` and returns its finest level.

    By default the parameterization stays as it is, and ``size``, the rows of a face, is that of equal sampling: about
    as many texels over the sphere as before. ``source_is`` is the source's parameterization where its file does not
    tell. ``up`` is the axis, "y" or "z", that points up in it: +z becomes +y, +y becomes -z. Then ``turn_deg`` turns
    the environment about the vertical, counter-clockwise seen from above. What lands texel on texel is not filtered.
    ``scale`` multiplies radiance, which takes units of light to those of a display, or a sun to what half floats hold.
    ``repair`` and ``layer`` are those of `read_levels`, ``layout``, ``texel_format`` and ``zstd`` of `write_env_image`.
    ``mips`` adds all mip levels, by default to .ktx2, .ktx and .dds; where neither parameterization nor size change,
    the source's own are kept. Raises RefletError for what cannot be read, written or held.
    """
    check_size(size)
    source_from_result = _turn(turn_deg, up)
    if not (np.isfinite(scale) and scale > 0.0):
        raise RefletError(f"Radiance is multiplied by a number above 0, not {scale:g}.")
    with_mips = Path(out).suffix.lower() in WITH_MIP_LEVELS if mips is None else mips
    progress("read", 0, 1)
    levels = read_levels(source, source_is, layer=layer, repair=repair)
    progress("read", 1, 1)
    if scale != 1.0:
        levels = tuple(_scaled(level, scale) for level in levels)
    finest = levels[0]
    to = finest.parameterization if to is None else to
    if size is None:
        size = default_size(finest, to, with_mips)
    progress("resample", 0, 1)
    if (to, size) == (finest.parameterization, finest.size):
        levels = tuple(turned(level, to, level.size, source_from_result) for level in levels)
    else:
        levels = (turned(finest, to, size, source_from_result),)
    progress("resample", 1, 1)
    progress("write", 0, 1)
    write_levels(out, levels, with_mips, layout=layout, texel_format=texel_format, zstd=zstd)
    progress("write", 1, 1)
    return levels[0]


def _turn(turn_deg: float, up: str) -> Rotation:
    """``source_from_result`` of what is asked for."""
    if up not in SOURCE_FROM_UPRIGHT:
        raise RefletError(f"What points up is one of {' '.join(SOURCE_FROM_UPRIGHT)}, not {up!r}.")
    if not np.isfinite(turn_deg):
        raise RefletError(f"A turn is a number of degrees, not {turn_deg:g}.")
    return SOURCE_FROM_UPRIGHT[up] @ turn_about_vertical(turn_deg)


def _scaled(image: EnvImage, scale: float) -> EnvImage:
    """The image with its radiance multiplied, its alpha as it was."""
    texels = image.texels.copy()
    texels[..., :3] *= np.float32(scale)
    return EnvImage(image.parameterization, texels)


def check_size(size: int | None) -> None:
    """Raises RefletError where a face cannot have so many rows; None says nothing."""
    if size is not None and not 1 <= size <= LARGEST:
        raise RefletError(f"A map has 1 to {LARGEST} rows a face, not {size}.")


def default_size(image: EnvImage, to: Parameterization, with_mips: bool) -> int:
    """The image's own size where that will do, else that of equal sampling: a power of two if mip levels are wanted."""
    if to == image.parameterization and not (with_mips and _odd(image.size)):
        return image.size
    return equal_sampling_size(to, valid_texels(image.parameterization) * image.size**2, with_mips)


def write_levels(
    out: str | Path,
    levels: tuple[EnvImage, ...],
    with_mips: bool,
    *,
    layout: str | None = None,
    texel_format: str | None = None,
    zstd: bool = False,
) -> None:
    """Writes the finest level alone, or all, which are filtered from it where there is only that one.

    Light that a texture's format cannot hold is spread before, so that all levels show the same (`holdable`).
    """
    levels = as_held(out, levels if with_mips else levels[:1], texel_format)
    if with_mips and len(levels) == 1:
        if _odd(levels[0].size):
            raise RefletError(
                f"Mip levels need a size that is a power of two, not {levels[0].size}; choose one or leave them out "
                "(--no-mips)."
            )
        levels = mip_images(levels[0])
    write_env_image(out, levels, layout, texel_format=texel_format, zstd=zstd)


def as_held(out: str | Path, levels: tuple[EnvImage, ...], texel_format: str | None) -> tuple[EnvImage, ...]:
    """The levels as the texels of a texture's file, by default half floats, can hold them; others as they are."""
    if Path(out).suffix.lower() not in WITH_MIP_LEVELS:
        return levels
    return holdable(levels, texel_format or "half")


def _odd(size: int) -> bool:
    """Whether a map of this size has no whole chain of mip levels."""
    return bool(size & (size - 1))
