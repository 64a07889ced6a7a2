"""From an environment map file to prefiltered ones: read, filter by a BRDF, write."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import valid_texels
from reflet.envmap.spherical_harmonics import project
from reflet.errors import RefletError
from reflet.files.atomic import atomic_path, check_writable
from reflet.files.env_image_file import read_light, write_env_image
from reflet.files.harmonics_file import write_harmonics
from reflet.files.pictures.picture_file import WRITTEN
from reflet.pipelines.convert import WITH_MIP_LEVELS, as_held, check_size, write_levels
from reflet.progress import ProgressCallback, silent
from reflet.reflectance.brdfs.charlie import CharlieKernel
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import check_radiance
from reflet.reflectance.prefilter.ggx_levels import ggx_levels
from reflet.reflectance.prefilter.irradiance_sh import irradiance_harmonics
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.reflectance.prefilter.sheen_levels import sheen_levels

LEVEL = "{level}"
"""Stands for the number of the level in the names of files that hold one each."""

_CUBE_ROWS = {"diffuse": 64, "phong": 128, "ggx": 256, "sheen": 64}  # by default, in cubes
_MOST_TEXELS = 1 << 23  # of what is filtered, at some 200 bytes each: a cube of 1024 rows, a lat-long map of 2048
_ROUGH = {"ggx": ggx_levels, "sheen": sheen_levels}
_KNOWN = "diffuse, phong:50, ggx, ggx:0.5, sheen, sheen:0.5 or table:FILE"


@dataclass(frozen=True)
class Lobe:
    """What to filter with: one kernel, or (None) one for each level's roughness."""

    name: str
    kernel: Kernel | None


def lobe(brdf: str) -> Lobe:
    """The lobe of ``diffuse``, ``phong:EXPONENT``, ``ggx`` or ``sheen``, the latter with one :ROUGHNESS or for all.

    Raises RefletError for anything else, exponents that are not positive and roughness outside of (0, 1].
    """
    name, colon, text = brdf.partition(":")
    if name not in _CUBE_ROWS or (name == "diffuse" and colon):
        raise RefletError(f"A BRDF is {_KNOWN}; {brdf} is none.")
    if name == "diffuse":
        return Lobe(name, DiffuseKernel())
    if name != "phong" and not colon:
        return Lobe(name, None)
    try:
        value = float(text)
    except ValueError:
        raise RefletError(
            f"{name} takes a number, such as {name}:{50 if name == 'phong' else 0.5}, not {brdf}."
        ) from None
    if name == "phong":
        return Lobe(name, PhongKernel(value))
    if not 0.0 < value <= 1.0:
        raise RefletError(
            f"{name} takes a perceptual roughness in (0, 1], not {text}; {name} alone gives levels of all."
        )
    return Lobe(name, GgxKernel(value**2) if name == "ggx" else CharlieKernel(value**2))


def prefilter(
    source: str | Path,
    out: str | Path,
    brdf: str,
    *,
    to: Parameterization | None = None,
    size: int | None = None,
    level_count: int | None = None,
    source_is: Parameterization | None = None,
    layout: str | None = None,
    mips: bool | None = None,
    texel_format: str | None = None,
    zstd: bool = False,
    progress: ProgressCallback = silent,
) -> tuple[EnvImage, ...]:
    """Writes the environment in ``source`` filtered by ``brdf`` (see `lobe`) to ``out`` and returns what is written.

    ``to`` is by default a cube in textures and a lat-long map in pictures; ``size``, the rows of a face, what suits the
    lobe. ``ggx`` and ``sheen`` alone make ``level_count`` mip levels by roughness (`ggx_levels`), which textures hold;
    pictures take one file each, named by ``{level}`` in ``out``. All other maps are one level; ``mips`` adds its mip
    levels, by default in textures. ``source_is``, ``layout``, ``texel_format`` and ``zstd`` are those of `convert`.
    Raises RefletError for what cannot be read, filtered (radiance that is negative or not finite, more than 8 million
    texels), or written.
    """
    chosen, out = lobe(brdf), Path(out)
    suffix = out.suffix.lower()
    each = LEVEL in out.name
    _check_names(out, chosen, level_count)
    check_size(size)
    check_writable(out)
    image = read_environment_image(source, source_is, progress)
    if to is None:
        to = CUBE if suffix in WITH_MIP_LEVELS else LatLong()
    if size is None:
        size = equal_sampling_size(to, valid_texels(CUBE) * _CUBE_ROWS[chosen.name] ** 2, power_of_two=True)

    filtered = int(np.prod(to.shape(size if chosen.kernel is not None else max(size // 2, 1))))
    if filtered > _MOST_TEXELS:
        raise RefletError(
            f"A {to} map of {size} rows has more texels than a lobe can fill with detail ({filtered >> 20} of at most "
            f"{_MOST_TEXELS >> 20} million); choose fewer rows."
        )

    def heard(done: int, total: int) -> None:
        progress("filter", done, total)

    heard(0, 1)
    if chosen.kernel is None:
        levels: tuple[EnvImage, ...] = _ROUGH[chosen.name](image, to, size, level_count, progress=heard)
    else:
        levels = (Prefilter(image).map(chosen.kernel, to, size, heard),)
        heard(1, 1)
    progress("write", 0, 1)
    if chosen.kernel is not None:
        with_mips = suffix in WITH_MIP_LEVELS if mips is None else mips
        write_levels(out, levels, with_mips, layout=layout, texel_format=texel_format, zstd=zstd)
    elif each:
        levels = as_held(out, levels, texel_format)
        with ExitStack() as all_or_none:
            for number, level in enumerate(levels):
                name = all_or_none.enter_context(atomic_path(out.with_name(out.name.replace(LEVEL, str(number)))))
                write_env_image(name, [level], layout, texel_format=texel_format, zstd=zstd)
    else:
        write_levels(out, levels, len(levels) > 1, layout=layout, texel_format=texel_format, zstd=zstd)
    progress("write", 1, 1)
    return levels


def _check_names(out: Path, chosen: Lobe, level_count: int | None) -> None:
    suffix = out.suffix.lower()
    if suffix not in (*WRITTEN, *WITH_MIP_LEVELS):
        known = " ".join([*WRITTEN, *WITH_MIP_LEVELS])
        raise RefletError(f"{out} has no format that can be written; give a name that ends in one of {known}.")
    if chosen.kernel is not None and (LEVEL in out.name or level_count is not None):
        raise RefletError(f"Levels by roughness are those of ggx and sheen alone; leave --levels and {LEVEL} out.")
    if chosen.kernel is None and suffix in WRITTEN and LEVEL not in out.name:
        raise RefletError(
            f"{out} can hold one mip level; write .ktx2, a file for each level ({out.stem}_{LEVEL}{out.suffix}), or a "
            f"single roughness ({chosen.name}:0.5)."
        )


def read_environment_image(
    source: str | Path, source_is: Parameterization | None, progress: ProgressCallback = silent
) -> EnvImage:
    """An environment's colours, of its own parameterization.

    Raises RefletError where it cannot be read and for radiance that is not finite; negative radiance is taken as 0.
    """
    progress("read", 0, 1)
    image = read_light(source, source_is)
    image = EnvImage(image.parameterization, np.ascontiguousarray(image.texels[..., :3], np.float32))
    check_radiance(image)
    progress("read", 1, 1)
    return image


def harmonics(
    source: str | Path,
    out: str | Path,
    *,
    source_is: Parameterization | None = None,
    progress: ProgressCallback = silent,
) -> None:
    """Writes the environment's spherical harmonics of order 2 as JSON (`write_harmonics`).

    Raises RefletError as `prefilter` does.
    """
    check_writable(out)
    image = read_environment_image(source, source_is, progress)
    write_harmonics(out, project(image), irradiance_harmonics(image), Path(source).name)
