"""OpenEXR pictures, through the OpenEXR library."""

import io
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import OpenEXR
from jaxtyping import Float, Float32

from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.errors import RefletError
from reflet.files.atomic import REASONS, atomic_path
from reflet.files.pictures.exr_layers import ExrLayer, chosen_layer
from reflet.files.pictures.primaries import REC709, are_usable, rec709_from_rgb, to_rec709, xyz_from_rgb
from reflet.files.unreadable import check_is_file

LARGEST_PICTURE = 2**29  # pixels: 32768×16384

Layout = Literal["latlong", "cube"]

_CHANNELS = {1: "Y", 3: "RGB", 4: "RGBA"}
_SPARSEST = 16  # a display window of more than this many data windows is a mistake
_LARGEST_TILE = 2**20  # pixels, unless the picture is large itself


def write_exr(
    path: str | os.PathLike[str],
    image: Float32[np.ndarray, "height width channels"],
    layout: Layout | None = None,
    half: bool = False,
    notes: Mapping[str, str] | None = None,
) -> None:
    """Writes a picture of 1 (Y), 3 (RGB) or 4 (RGBA) channels, losslessly compressed, atomically.

    Samples are 32-bit floats, or 16-bit ones if ``half``. With a ``layout`` the file's ``envmap`` attribute says so;
    the picture has to be laid out as `openexr_layout` says. ``notes`` become string attributes. Raises RefletError if
    the file cannot be written, or if half floats cannot hold the radiance.
    """
    name = _CHANNELS[image.shape[2]]
    if half and np.abs(image[np.isfinite(image)]).max(initial=0.0) > HALF_MAX:
        raise RefletError(
            f"{path} cannot be written in half floats, which end at 65504; write 32-bit floats (--texel-format float)."
        )
    pixels = np.ascontiguousarray(image if name != "Y" else image[..., 0], dtype=np.float16 if half else np.float32)
    header: dict[str, Any] = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **(notes or {})}
    if layout is not None:
        header["envmap"] = OpenEXR.ENVMAP_LATLONG if layout == "latlong" else OpenEXR.ENVMAP_CUBE
    with atomic_path(path) as temporary, OpenEXR.File(header, {name: pixels}) as file:
        try:
            file.write(str(temporary))
        except RuntimeError as error:  # the library says what the system said, but not its number
            for number in REASONS:
                if os.strerror(number) in str(error):
                    raise OSError(number, os.strerror(number)) from error
            raise RefletError(f"{path} cannot be written ({error}); is the disk full?") from error


@dataclass(frozen=True)
class _Window:
    """A rectangle of pixels, from its top left corner; may lie anywhere."""

    x: int
    y: int
    width: int
    height: int

    @staticmethod
    def of(corners: tuple[np.ndarray, np.ndarray]) -> "_Window":
        (x0, y0), (x1, y1) = ([int(c) for c in corner] for corner in corners)
        return _Window(x0, y0, x1 - x0 + 1, y1 - y0 + 1)


@dataclass(frozen=True)
class ExrPicture:
    """Linear Rec. 709 of 1 (Y), 3 (RGB) or 4 (RGBA) channels, the ``envmap`` attribute, and what of it is in doubt."""

    pixels: Float32[np.ndarray, "height width channels"]
    layout: Layout | None
    doubts: tuple[str, ...] = ()


def read_exr_picture(path: str | os.PathLike[str], layer: str | None = None) -> ExrPicture:
    """The layer of that name, else the one that is meant (`chosen_layer`).

    Half and float samples, scan lines and tiles (of mip-mapped ones the finest level), luminance with chroma at half
    the resolution, and the library's compressions are read. ``chromaticities`` other than Rec. 709's are converted,
    white staying white.

    A part with an ``envmap`` attribute is its data window, for that is what OpenEXR's layouts refer to. Any other is
    its display window, the frame that the picture was made for: pixels beyond it (overscan) are left out, pixels that
    are not stored are 0, and their share is a doubt.

    Memory: all of the file's parts and channels, for the library reads no less, and the picture. Raises RefletError for
    files that are missing, damaged, larger than `LARGEST_PICTURE`, or hold other channels, integers or deep samples.
    """
    check_is_file(path)
    try:
        with quiet() as said:
            with OpenEXR.File(os.fspath(path), header_only=True) as file:
                for each in file.parts:
                    _check_part(path, each.header)
            with OpenEXR.File(os.fspath(path), separate_channels=True) as file:
                if not file.parts:
                    raise RuntimeError(said.getvalue().strip().rpartition(" - ")[2] or "it holds no pixels")
                parts = [(str(part.header.get("name", "")), list(part.channels)) for part in file.parts]
                chosen, doubts = chosen_layer(path, parts, layer)
                return _picture(path, file.parts[chosen.part], chosen, doubts)
    except (RuntimeError, ValueError, TypeError, MemoryError, IndexError, OverflowError) as error:
        reason = " ".join(str(error).split())[:200]
        raise RefletError(f"{path} is not a readable OpenEXR picture ({reason}); copy or download it again.") from error


def read_exr(path: str | os.PathLike[str], layer: str | None = None) -> Float32[np.ndarray, "height width channels"]:
    """The pixels of `read_exr_picture`."""
    return read_exr_picture(path, layer).pixels


@contextmanager
def quiet() -> Iterator[io.StringIO]:
    """Keeps what the library prints about damaged files, beside raising, from the process's output.

    It writes to standard error by itself, and to Python's standard output where it skips a part; the latter is handed
    on.
    """
    saved, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        with redirect_stdout(io.StringIO()) as said:
            yield said
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)


def _check_part(path: str | os.PathLike[str], header: dict[str, Any]) -> None:
    """Refuses what must not be read at all: every part of a file is read, whichever is wanted."""
    if header.get("type") in (OpenEXR.deepscanline, OpenEXR.deeptile):
        raise RefletError(f"{path} holds deep samples, many a pixel; flatten it in the program that rendered it.")
    window = _Window.of(header["dataWindow"])
    if window.width * window.height > LARGEST_PICTURE:
        raise RefletError(f"{path} is {window.width}×{window.height} pixels, more than can be read; scale it down.")
    tiles = header.get("tiles")
    if tiles is not None and tiles.xSize * tiles.ySize > max(_LARGEST_TILE, 4 * window.width * window.height):
        raise RefletError(f"{path} has tiles of {tiles.xSize}×{tiles.ySize} pixels; store it in smaller ones.")


def _picture(path: str | os.PathLike[str], part: Any, layer: ExrLayer, doubts: tuple[str, ...]) -> ExrPicture:
    """See `read_exr_picture`. Copies everything: a part dies with its file."""
    header = part.header
    roles = [role for role in ("R", "G", "B", "A") if role in layer.channels]
    if not {"R", "G", "B"} <= set(roles):
        roles = ["Y"]
        if {"RY", "BY"} <= set(layer.channels):
            roles += ["RY", "BY", "A"] if "A" in layer.channels else ["RY", "BY"]
    data = _Window.of(header["dataWindow"])
    pixels = np.empty((data.height, data.width, len(roles)), np.float32)
    for k, role in enumerate(roles):
        pixels[..., k] = _samples(path, part.channels[layer.channels[role]], role, data)
    primaries = _primaries(header)
    if "RY" in roles:
        pixels = _from_luminance_chroma(pixels, primaries)
    if pixels.shape[2] >= 3 and np.abs(primaries - REC709).max() > 5e-4:
        pixels[..., :3] = to_rec709(pixels[..., :3], rec709_from_rgb(primaries))
    if "envmap" in header:
        layout: Layout = "latlong" if header["envmap"] == OpenEXR.ENVMAP_LATLONG else "cube"
        return ExrPicture(pixels, layout, doubts)
    display = _Window.of(header["displayWindow"])
    framed, stored = _framed(path, pixels, data, display)
    if stored < display.width * display.height:
        share = 1.0 - stored / (display.width * display.height)
        doubts += (
            f"{path} is cropped: {100.0 * share:.3g} % of its display window's pixels are not stored and are black.",
        )
    return ExrPicture(framed, None, doubts)


def _samples(path: str | os.PathLike[str], channel: Any, name: str, data: _Window) -> Float[np.ndarray, "height width"]:
    """One channel at full resolution. Raises RefletError for integers, and for colours stored at less."""
    stored = channel.pixels
    if stored.dtype.kind != "f":
        raise RefletError(f"{path} stores {name} in integers; expected half or float samples: save it as these.")
    if channel.xSampling == channel.ySampling == 1:
        return stored
    if name not in ("RY", "BY"):
        raise RefletError(f"{path} stores {name} at a fraction of the resolution; save all of it.")
    # the library leaves the fewer samples densely packed at the beginning of an array of the full size
    height, width = data.height // channel.ySampling, data.width // channel.xSampling
    dense = stored.reshape(-1)[: height * width].reshape(height, width).astype(np.float32)
    return _spread(_spread(dense, 0, channel.ySampling), 1, channel.xSampling)


def _spread(
    samples: Float32[np.ndarray, "rows columns"], axis: int, step: int
) -> Float32[np.ndarray, "rows_ columns_"]:
    """Linear interpolation between samples that stand ``step`` pixels apart, the first on pixel 0; the last is kept."""
    count = samples.shape[axis]
    position = np.arange(count * step)
    before = position // step
    fraction = ((position % step) / step).astype(np.float32)
    fraction = fraction[:, None] if axis == 0 else fraction
    low, high = np.take(samples, before, axis), np.take(samples, np.minimum(before + 1, count - 1), axis)
    return low + (high - low) * fraction


def _primaries(header: dict[str, Any]) -> Float[np.ndarray, "4 2"]:
    """Chromaticities of red, green, blue and white; Rec. 709's where the file says nothing usable."""
    given = np.array(header.get("chromaticities", REC709), dtype=np.float64)
    return given.reshape(4, 2) if given.size == 8 and are_usable(given.reshape(4, 2)) else REC709


def _from_luminance_chroma(
    pixels: Float32[np.ndarray, "height width channels"], primaries: Float[np.ndarray, "4 2"]
) -> Float32[np.ndarray, "height width colors"]:
    """RGB from Y, RY = (R - Y)/Y and BY = (B - Y)/Y, and alpha if there; Y is the luminance by these primaries."""
    weight_r, weight_g, weight_b = xyz_from_rgb(primaries)[1]
    y = pixels[..., 0]
    red, blue = (pixels[..., 1] + 1.0) * y, (pixels[..., 2] + 1.0) * y
    green = (y - np.float32(weight_r) * red - np.float32(weight_b) * blue) / np.float32(weight_g)
    return np.concatenate([np.stack([red, green, blue], -1), pixels[..., 3:]], -1)


def _framed(
    path: str | os.PathLike[str], pixels: Float32[np.ndarray, "height width channels"], data: _Window, display: _Window
) -> tuple[Float32[np.ndarray, "rows columns channels"], int]:
    """The display window's pixels, 0 where the data window has none; and how many it has."""
    if data == display:
        return pixels, data.width * data.height
    if min(display.width, display.height) < 1 or (
        display.width * display.height > _SPARSEST * data.width * data.height
    ):
        raise RefletError(
            f"{path} stores {data.width}×{data.height} pixels of a picture of {display.width}×{display.height}; "
            "correct its display window."
        )
    out = np.zeros((display.height, display.width, pixels.shape[2]), np.float32)
    left, top = max(data.x, display.x), max(data.y, display.y)
    right = min(data.x + data.width, display.x + display.width)
    bottom = min(data.y + data.height, display.y + display.height)
    if right <= left or bottom <= top:
        raise RefletError(f"{path} stores no pixel of its display window; correct its windows.")
    out[top - display.y : bottom - display.y, left - display.x : right - display.x] = pixels[
        top - data.y : bottom - data.y, left - data.x : right - data.x
    ]
    return out, (right - left) * (bottom - top)
