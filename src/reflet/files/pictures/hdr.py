"""Radiance pictures (.hdr): shared-exponent RGBE or XYZE, run-length encoded by the scanline [Ward91]."""

import math
import os
from collections.abc import Mapping
from pathlib import Path

import numba
import numpy as np
from jaxtyping import Float32, Float64, UInt8

from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.files.pictures.hdr_header import HEADER_LIMIT, read_hdr_header
from reflet.files.pictures.primaries import EQUAL_ENERGY, REC709, rec709_from_rgb, rec709_from_xyz, to_rec709
from reflet.files.unreadable import unreadable

LARGEST_PICTURE = 2**29  # pixels: 32768×16384

_EXCESS = 136  # a component is mantissa·2^(exponent - 136)
_EFFICACY = 179.0  # lumens per watt: Radiance's XYZE holds luminance, its RGBE radiance
_SHORTEST, _LONGEST = 8, 32767  # scanlines of these lengths have the new run-length form
_SHORTEST_RUN = 4  # of a byte that is worth two


def read_hdr(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width 3"]:
    """The pixels of `read_hdr_with_doubts`."""
    return read_hdr_with_doubts(path)[0]


def read_hdr_with_doubts(
    path: str | os.PathLike[str],
) -> tuple[Float32[np.ndarray, "height width 3"], tuple[str, ...]]:
    """Linear Rec. 709 radiance of a .hdr file, row 0 at the top, and sentences about what its header cannot mean.

    Reads both run-length forms and flat pixels, scanlines that are rows or columns, from any of the four corners.
    EXPOSURE and COLORCORR are divided out. PRIMARIES other than Rec. 709's are converted, white staying white; so are
    XYZE pictures, whose white is that of equal energy and whose luminance is 179 times their radiance, as Radiance has
    it [Ward91]. Without PRIMARIES a picture is taken as Rec. 709. Lines that cannot be meant (EXPOSURE=0) are ignored.

    Memory: the file, 8 bytes a scanline and the picture; twice the picture where primaries are converted. A file that
    does not hold as many pixels as its header says is refused before anything is allocated for them.

    Raises RefletError for files that are missing, truncated, damaged, larger than `LARGEST_PICTURE`, or no .hdr.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise unreadable(path, error) from error
    header = read_hdr_header(path, data)
    if header.width * header.height > LARGEST_PICTURE:
        raise RefletError(f"{path} is {header.width}×{header.height} pixels, more than can be read; scale it down.")
    count, length = header.height, header.width
    if header.is_column_major:
        count, length = length, count
    body = np.frombuffer(data, np.uint8)[header.end :]
    # no scanline is shorter than four bytes: what cannot be there gets no room
    starts = np.empty(count if 4 * count <= len(body) else 0, np.int64)
    if _find_lines(body, length, starts) != count:
        raise RefletError(f"{path} is truncated or damaged; copy or download it again.")
    image = np.empty((header.height, header.width, 3), np.float32)
    as_stored = image[:: -1 if header.is_upside_down else 1, :: -1 if header.is_mirrored else 1]
    if header.is_column_major:
        as_stored = as_stored.transpose(1, 0, 2)
    _decode_lines(body, starts, _scales(header.exposure * (_EFFICACY if header.is_xyz else 1.0)), as_stored)
    if header.is_xyz:
        return to_rec709(image, rec709_from_xyz(EQUAL_ENERGY)), header.doubts
    if np.abs(header.primaries - REC709).max() > 5e-4:  # white is written as 0.313 0.329 or 0.3127 0.329
        return to_rec709(image, rec709_from_rgb(header.primaries)), header.doubts
    return image, header.doubts


def hdr_size(path: str | os.PathLike[str]) -> tuple[int, int]:
    """(height, width) of a .hdr file by its header. Raises RefletError where that is none."""
    try:
        with open(path, "rb") as file:
            header = read_hdr_header(path, file.read(HEADER_LIMIT))
    except OSError as error:
        raise unreadable(path, error) from error
    return header.height, header.width


@numba.njit(cache=True)
def _find_lines(data: np.ndarray, length: int, starts: np.ndarray) -> int:
    """Number of whole scanlines at the beginning of ``data``, up to as many as ``starts`` has room for."""
    nothing = np.empty((0, 4), np.uint8)
    at = 0
    for line in range(starts.size):
        starts[line] = at
        at = _decode_line(data, at, length, nothing)
        if at < 0:
            return line
    return starts.size


@numba.njit(cache=True, parallel=True)
def _decode_lines(data: np.ndarray, starts: np.ndarray, scales: np.ndarray, out: np.ndarray) -> None:
    """Radiance (lines, length, 3) of the scanlines that begin at ``starts``."""
    lines, length = out.shape[:2]
    blocks = min(lines, 64)
    for block in numba.prange(blocks):
        rgbe = np.empty((length, 4), np.uint8)
        for line in range(block * lines // blocks, (block + 1) * lines // blocks):
            _decode_line(data, starts[line], length, rgbe)
            for k in range(length):
                for channel in range(3):
                    out[line, k, channel] = rgbe[k, channel] * scales[rgbe[k, 3], channel]


@numba.njit(cache=True)
def _decode_line(data: np.ndarray, at: int, length: int, out: UInt8[np.ndarray, "length 4"]) -> int:
    """Where the scanline that begins at ``at`` ends, -1 where it is not whole; writes it unless ``out`` is empty."""
    end = data.size
    writes = out.size > 0
    if at + 4 > end:
        return -1
    if _SHORTEST <= length <= _LONGEST and data[at] == 2 and data[at + 1] == 2 and data[at + 2] < 128:
        # each of the four channels on its own: a number over 128 repeats a byte, else as many bytes follow
        if data[at + 2] * 256 + data[at + 3] != length:
            return -1
        at += 4
        for channel in range(4):
            k = 0
            while k < length:
                if at + 2 > end:
                    return -1
                number = int(data[at])
                at += 1
                if number > 128:
                    number -= 128
                    if k + number > length:
                        return -1
                    if writes:
                        for j in range(k, k + number):
                            out[j, channel] = data[at]
                    at += 1
                else:
                    if number == 0 or k + number > length or at + number > end:
                        return -1
                    if writes:
                        for j in range(number):
                            out[k + j, channel] = data[at + j]
                    at += number
                k += number
        return at
    # plain pixels; (1, 1, 1, n) repeats the pixel before n times, successive ones are digits in base 256
    k, shift = 0, 0
    while k < length:
        if at + 4 > end:
            return -1
        if k > 0 and data[at] == 1 and data[at + 1] == 1 and data[at + 2] == 1:
            if shift > 24:
                return -1
            number = int(data[at + 3]) << shift
            shift += 8
            if k + number > length:
                return -1
            if writes:
                for j in range(k, k + number):
                    for channel in range(4):
                        out[j, channel] = out[k - 1, channel]
            k += number
        else:
            if writes:
                for channel in range(4):
                    out[k, channel] = data[at + channel]
            k += 1
            shift = 0
        at += 4
    return at


def _scales(exposure: Float64[np.ndarray, "3"]) -> Float64[np.ndarray, "256 3"]:
    """What mantissas are multiplied by, by exponent and channel: 2^(exponent - 136)/exposure. Ward adds 1/2 to the
    mantissa, the readers in use do not (three.js, OpenCV, stb). Exponent 0 is black."""
    scale = np.ldexp(1.0, np.arange(256) - _EXCESS)
    scale[0] = 0.0
    return scale[:, None] / exposure


def write_hdr(
    path: str | os.PathLike[str],
    image: Float32[np.ndarray, "height width 3"],
    notes: Mapping[str, str] | None = None,
) -> None:
    """Writes linear Rec. 709 radiance as RGBE with the new run-length form, atomically.

    ``notes`` become variables of its header, upper-case by custom.

    Each component is within half a step of the mantissa: 1/512 to 1/256 of the pixel's largest component. Raises
    RefletError for radiance that is negative, not finite or above 1.7e38, which RGBE cannot hold, and where the file
    cannot be written.
    """
    low, high = image.min(initial=0.0), image.max(initial=0.0)
    if not (np.isfinite(low) and np.isfinite(high)):
        raise RefletError(
            f"{path} cannot be written: the radiance is not finite everywhere; repair it first, files by "
            "reflet convert --repair."
        )
    if low < 0.0 or high > 1.7e38:
        what, instead = (low, "reflet convert --repair makes it 0") if low < 0.0 else (high, "write .exr")
        raise RefletError(f"{path} cannot be written: .hdr holds no radiance of {what:g}; {instead}.")
    height, width = image.shape[:2]
    said = "".join(f"{key.upper()}={value}\n" for key, value in (notes or {}).items()).encode()
    header = b"#?RADIANCE\nSOFTWARE=reflet\n%sFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (said, height, width)
    # at worst a number before each 128 literal bytes
    room = np.empty(height * 4 * (width + width // 128 + 2), np.uint8)
    length = _encode(np.ascontiguousarray(image), room)
    atomic_write(path, header + room[:length].tobytes())


@numba.njit(cache=True)
def _encode(image: np.ndarray, out: np.ndarray) -> int:
    """Fills ``out`` with scanlines and returns how many bytes they are."""
    height, width, _ = image.shape
    line = np.empty((4, width), np.uint8)
    at = 0
    for row in range(height):
        for column in range(width):
            _to_rgbe(image[row, column], line[:, column])
        if not _SHORTEST <= width <= _LONGEST:
            # Nothing here reads as a run (1, 1, 1, n): a pixel's largest mantissa is at least 128, or all are 0.
            for column in range(width):
                for channel in range(4):
                    out[at] = line[channel, column]
                    at += 1
            continue
        out[at], out[at + 1], out[at + 2], out[at + 3] = 2, 2, width >> 8, width & 255
        at += 4
        for channel in range(4):
            at = _encode_channel(line[channel], out, at)
    return at


@numba.njit(cache=True)
def _to_rgbe(color: np.ndarray, out: np.ndarray) -> None:
    """Rounds to the nearest mantissas. Ward truncates, which is nearest for readers that add 1/2 as his does."""
    largest = max(color[0], color[1], color[2])
    if largest < 2.0**-128:  # the exponent's byte would be below 1, or its mantissas below 128
        out[:] = 0
        return
    _, exponent = math.frexp(largest)
    if largest * 2.0 ** (8 - exponent) >= 255.5:  # would round to 256
        exponent += 1
    for channel in range(3):
        out[channel] = int(color[channel] * 2.0 ** (8 - exponent) + 0.5)
    out[3] = exponent + 128


@numba.njit(cache=True)
def _encode_channel(line: np.ndarray, out: np.ndarray, at: int) -> int:
    """Runs of `_SHORTEST_RUN` and more equal bytes as runs, what lies between as literals."""
    width = line.size
    literal = 0  # where bytes not yet written begin
    k = 0
    while k <= width:
        run = 1
        if k < width:
            while run < 127 and k + run < width and line[k + run] == line[k]:
                run += 1
        if k < width and run < _SHORTEST_RUN:
            k += run
            continue
        while literal < k:
            number = min(k - literal, 128)
            out[at] = number
            out[at + 1 : at + 1 + number] = line[literal : literal + number]
            at += 1 + number
            literal += number
        if k == width:
            break
        out[at], out[at + 1] = 128 + run, line[k]
        at += 2
        k += run
        literal = k
    return at
