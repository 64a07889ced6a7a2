"""From one environment map file to another: read, resample, filter mip levels, write."""

from pathlib import Path

from reflet.envmap.env_image import EnvImage
from reflet.envmap.equal_sampling import equal_sampling_size, texels_over_sphere
from reflet.envmap.mip_reduction import mip_images
from reflet.envmap.parameterization import Parameterization
from reflet.envmap.resample import resample
from reflet.errors import RefletError
from reflet.files.env_image_file import read_env_image, write_env_image
from reflet.progress import ProgressCallback, silent

WITH_MIP_LEVELS = (".ktx2", ".ktx", ".dds")  # formats of textures, which come with their mip levels
LARGEST = 16384  # rows of a face: no graphics system takes larger textures


def convert(
    source: str | Path,
    out: str | Path,
    *,
    to: Parameterization | None = None,
    size: int | None = None,
    layout: str | None = None,
    source_is: Parameterization | None = None,
    mips: bool | None = None,
    progress: ProgressCallback = silent,
) -> EnvImage:
    """Writes the environment in ``source`` to ``out`` in the parameterization ``to`` and returns its finest level.

    By default the parameterization stays as it is, and ``size``, the rows of a face, is that of equal sampling: about
    as many texels over the sphere as before. Formats go by suffix; ``layout`` is how the faces of a cube lie in a
    picture, ``source_is`` the source's parameterization where its file does not tell. ``mips`` adds all mip levels, by
    default to .ktx2, .ktx and .dds. Raises RefletError for what cannot be read, written or held.
    """
    if size is not None and not 1 <= size <= LARGEST:
        raise RefletError(f"A map has 1 to {LARGEST} rows a face, not {size}.")
    progress("read", 0, 1)
    image = read_env_image(source, source_is)
    progress("read", 1, 1)
    to = image.parameterization if to is None else to
    size = size or default_size(image, to)
    progress("resample", 0, 1)
    if (to, size) != (image.parameterization, image.size):
        image = resample(image, to, size)
    progress("resample", 1, 1)
    write(image, out, layout, mips, progress)
    return image


def write(
    image: EnvImage,
    out: str | Path,
    layout: str | None = None,
    mips: bool | None = None,
    progress: ProgressCallback = silent,
) -> None:
    """Writes one level, or with ``mips`` all of them, filtered from it; by default as the format has it."""
    with_mips = Path(out).suffix.lower() in WITH_MIP_LEVELS if mips is None else mips
    progress("write", 0, 1)
    write_env_image(out, mip_images(image) if with_mips else (image,), layout)
    progress("write", 1, 1)


def default_size(image: EnvImage, to: Parameterization) -> int:
    """The image's own size where nothing changes, else that of equal sampling."""
    if to == image.parameterization:
        return image.size
    return equal_sampling_size(to, texels_over_sphere(image.parameterization) * image.size**2)
