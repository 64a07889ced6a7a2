"""OpenEXR pictures."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

import numpy as np
import OpenEXR
from jaxtyping import Float32

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path

_CHANNELS = {1: "Y", 3: "RGB", 4: "RGBA"}


def write_exr(path: str | os.PathLike[str], image: Float32[np.ndarray, "height width channels"]) -> None:
    """Writes a picture of 1 (Y), 3 (RGB) or 4 (RGBA) channels as 32-bit floats, losslessly compressed, atomically.

    Raises RefletError if the file cannot be written.
    """
    name = _CHANNELS[image.shape[2]]
    pixels = np.ascontiguousarray(image if name != "Y" else image[..., 0], dtype=np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with atomic_path(path) as temporary, OpenEXR.File(header, {name: pixels}) as file:
        try:
            file.write(str(temporary))
        except RuntimeError as error:  # the library hides errno; a full disk is what remains after mkstemp succeeded
            raise RefletError(f"{path} cannot be written ({error}); is the disk full?") from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Keeps what the library prints about damaged files, beside raising, from the process's standard error."""
    saved, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)


def read_exr_layout(
    path: str | os.PathLike[str],
) -> tuple[Float32[np.ndarray, "height width channels"], Literal["latlong", "cube"] | None]:
    """Pixels of the first part (its data window) as 1 (Y), 3 (RGB) or 4 (RGBA) channels, and its ``envmap`` attribute.

    Raises RefletError for files that are missing, damaged, or hold other channels.
    """
    if not os.path.isfile(path):
        raise RefletError(f"{path} does not exist; check the name.")
    try:
        with _quiet(), OpenEXR.File(os.fspath(path)) as file:
            channels, attribute = file.channels(), file.header().get("envmap")
            names = ", ".join(sorted(channels))
            found = next((channels[name].pixels for name in ("RGBA", "RGB", "Y") if name in channels), None)
            # compared while the file is open: its attributes die with it
            layout: Literal["latlong", "cube"] | None = None
            if attribute is not None:
                layout = "latlong" if attribute == OpenEXR.ENVMAP_LATLONG else "cube"
    except (RuntimeError, ValueError, TypeError) as error:
        raise RefletError(f"{path} is not a readable OpenEXR picture ({error}); it may be truncated.") from error
    if found is None:
        raise RefletError(f"{path} holds the channels {names}; expected R, G, B or Y.")
    pixels = np.array(found, dtype=np.float32)
    return (pixels if pixels.ndim == 3 else pixels[..., None]), layout


def read_exr(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width channels"]:
    """The pixels of `read_exr_layout`."""
    return read_exr_layout(path)[0]
