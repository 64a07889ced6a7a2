"""Radiance pictures (.hdr): shared-exponent RGBE or XYZE, run-length encoded by the scanline [Ward91]."""

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numba
import numpy as np
from jaxtyping import Float32, Float64, UInt8

from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.files.pictures.primaries import (
    EQUAL_ENERGY,
    REC709,
    are_usable,
    rec709_from_rgb,
    rec709_from_xyz,
    to_rec709,
)

LARGEST_PICTURE = 2**29  # pixels: 32768×16384

_HEADER_LIMIT = 2**20  # bytes of text that are looked through for the line of the size
_SIZE = re.compile(rb"([-+])([XY])[ \t]+(\d{1,9})[ \t]+([-+])([XY])[ \t]+(\d{1,9})[ \t]*\r?\n")
_EXCESS = 136  # a component is mantissa·2^(exponent - 136)
_EFFICACY = 179.0  # lumens per watt: Radiance's XYZE holds luminance, its RGBE radiance
_SHORTEST, _LONGEST = 8, 32767  # scanlines of these lengths have the new run-length form
_SHORTEST_RUN = 4  # of a byte that is worth two


@dataclass(frozen=True)
class _Header:
    """What a .hdr file says before its scanlines begin, at byte ``end``."""

    end: int
    width: int
    height: int
    is_column_major: bool  # scanlines are columns
    is_upside_down: bool  # the first row is the lowest
    is_mirrored: bool  # the first column is the rightmost
    is_xyz: bool = False
    exposure: np.ndarray = field(default_factory=lambda: np.ones(3))  # what the pixels were multiplied by, per channel
    primaries: np.ndarray = field(default_factory=lambda: REC709)


def read_hdr(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width 3"]:
    """Linear Rec. 709 radiance of a .hdr file, row 0 at the top.

    Reads both run-length forms and flat pixels, scanlines that are rows or columns, from any of the four corners.
    EXPOSURE and COLORCORR are divided out. PRIMARIES other than Rec. 709's are converted, white staying white; so are
    XYZE pictures, whose white is that of equal energy and whose luminance is 179 times their radiance, as Radiance has
    it [Ward91]. Without PRIMARIES a picture is taken as Rec. 709.

    Memory: the file, 4 bytes a pixel and the picture; twice the picture where primaries are converted. A file that does
    not hold as many pixels as its header says is refused before anything is allocated for them.

    Raises RefletError for files that are missing, truncated, damaged, larger than `LARGEST_PICTURE`, or no .hdr.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror}); check the name.") from error
    header = _read_header(path, data)
    if header.width * header.height > LARGEST_PICTURE:
        raise RefletError(f"{path} is {header.width}×{header.height} pixels, more than can be read; scale it down.")
    count, length = header.height, header.width
    if header.is_column_major:
        count, length = length, count
    body = np.frombuffer(data, np.uint8)[header.end :]
    if _decode(body, count, length, np.empty((0, 0, 4), np.uint8)) != count:
        raise RefletError(f"{path} is truncated or damaged; copy or download it again.")
    rgbe = np.empty((count, length, 4), np.uint8)
    _decode(body, count, length, rgbe)
    if header.is_column_major:
        rgbe = rgbe.transpose(1, 0, 2)
    if header.is_upside_down:
        rgbe = rgbe[::-1]
    if header.is_mirrored:
        rgbe = rgbe[:, ::-1]
    image = _radiance(rgbe, header.exposure * (_EFFICACY if header.is_xyz else 1.0))
    if header.is_xyz:
        return to_rec709(image, rec709_from_xyz(EQUAL_ENERGY))
    if np.abs(header.primaries - REC709).max() > 5e-4:  # white is written as 0.313 0.329 or 0.3127 0.329
        return to_rec709(image, rec709_from_rgb(header.primaries))
    return image


def _read_header(path: str | os.PathLike[str], data: bytes) -> _Header:
    """Raises RefletError where the header is none of a .hdr file."""
    start = data[:_HEADER_LIMIT]
    text_end = min((at + 1 for at in (start.find(b"\n\n"), start.find(b"\n\r\n")) if at >= 0), default=-1)
    newline = start.find(b"\n", text_end)
    size = _SIZE.match(start, newline + 1)
    if not start.startswith(b"#?") or text_end < 0 or size is None or size[2] == size[5]:
        raise RefletError(f"{path} is not a Radiance .hdr picture; convert it.")
    first, second = int(size[3]), int(size[6])
    if not first * second:
        raise RefletError(f"{path} has no pixels; copy or download it again.")
    sign = {size[2]: size[1], size[5]: size[4]}
    is_xyz, exposure, primaries = False, np.ones(3), REC709
    for line in start[:text_end].splitlines():
        name, _, value = line.strip().partition(b"=")
        name = name.strip()
        if name == b"FORMAT":
            if value.strip() not in (b"32-bit_rle_rgbe", b"32-bit_rle_xyze"):
                raise RefletError(f"{path} is stored as {value.decode('latin-1')[:40]}, not as RGBE; convert it.")
            is_xyz = value.strip().endswith(b"xyze")
        elif name in (b"EXPOSURE", b"COLORCORR"):
            exposure = exposure * _numbers(path, line, 1 if name == b"EXPOSURE" else 3)
        elif name == b"PRIMARIES":
            given = _numbers(path, line, 8).reshape(4, 2)
            primaries = given if are_usable(given) else REC709
    with np.errstate(over="ignore", under="ignore"):
        if not (np.isfinite(exposure).all() and (exposure > 1e-30).all()):
            raise RefletError(f"{path} has an EXPOSURE or COLORCORR that is not a positive number; correct its header.")
    is_column_major = size[2] == b"X"
    width, height = (first, second) if is_column_major else (second, first)
    return _Header(
        end=size.end(), width=width, height=height, is_column_major=is_column_major,
        is_upside_down=sign[b"Y"] == b"+", is_mirrored=sign[b"X"] == b"-",
        is_xyz=is_xyz, exposure=exposure, primaries=primaries,
    )  # fmt: skip


def _numbers(path: str | os.PathLike[str], line: bytes, count: int) -> np.ndarray:
    """The numbers of a header line ``NAME= number …``. Raises RefletError where there are not so many."""
    try:
        numbers = np.array([float(word) for word in line.partition(b"=")[2].split()])
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != count:
        said = line.decode("latin-1").strip()[:60]
        raise RefletError(f'{path} says "{said}" in its header, which is not {count} numbers; correct it.')
    return numbers


@numba.njit(cache=True)
def _decode(data: np.ndarray, count: int, length: int, out: UInt8[np.ndarray, "count length 4"]) -> int:
    """Number of whole scanlines at the beginning of ``data``, up to ``count``; writes them unless ``out`` is empty."""
    at, end = 0, data.size
    writes = out.size > 0
    for line in range(count):
        if at + 4 > end:
            return line
        if _SHORTEST <= length <= _LONGEST and data[at] == 2 and data[at + 1] == 2 and data[at + 2] < 128:
            # each of the four channels on its own: a number over 128 repeats a byte, else as many bytes follow
            if data[at + 2] * 256 + data[at + 3] != length:
                return line
            at += 4
            for channel in range(4):
                k = 0
                while k < length:
                    if at + 2 > end:
                        return line
                    number = int(data[at])
                    at += 1
                    if number > 128:
                        number -= 128
                        if k + number > length:
                            return line
                        if writes:
                            for j in range(k, k + number):
                                out[line, j, channel] = data[at]
                        at += 1
                    else:
                        if number == 0 or k + number > length or at + number > end:
                            return line
                        if writes:
                            for j in range(number):
                                out[line, k + j, channel] = data[at + j]
                        at += number
                    k += number
        else:
            # plain pixels; (1, 1, 1, n) repeats the pixel before n times, successive ones are digits in base 256
            k, shift = 0, 0
            while k < length:
                if at + 4 > end:
                    return line
                if k > 0 and data[at] == 1 and data[at + 1] == 1 and data[at + 2] == 1:
                    if shift > 24:
                        return line
                    number = int(data[at + 3]) << shift
                    shift += 8
                    if k + number > length:
                        return line
                    if writes:
                        for j in range(k, k + number):
                            for channel in range(4):
                                out[line, j, channel] = out[line, k - 1, channel]
                    k += number
                else:
                    if writes:
                        for channel in range(4):
                            out[line, k, channel] = data[at + channel]
                    k += 1
                    shift = 0
                at += 4
    return count


def _radiance(
    rgbe: UInt8[np.ndarray, "height width 4"], exposure: Float64[np.ndarray, "3"]
) -> Float32[np.ndarray, "height width 3"]:
    """mantissa·2^(exponent - 136)/exposure: Ward adds 1/2 to the mantissa, the readers in use do not (three.js, OpenCV,
    stb). Exponent 0 is black."""
    scale = np.ldexp(1.0, np.arange(256) - _EXCESS)
    scale[0] = 0.0
    out = np.empty((*rgbe.shape[:2], 3), np.float32)
    _scale(rgbe, scale[:, None] / exposure, out)
    return out


@numba.njit(cache=True)
def _scale(rgbe: np.ndarray, scale: np.ndarray, out: np.ndarray) -> None:
    for row in range(rgbe.shape[0]):
        for column in range(rgbe.shape[1]):
            for channel in range(3):
                out[row, column, channel] = rgbe[row, column, channel] * scale[rgbe[row, column, 3], channel]


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
        raise RefletError(f"{path} cannot be written: the radiance is not finite everywhere; repair these pixels.")
    if low < 0.0 or high > 1.7e38:
        what = low if low < 0.0 else high
        raise RefletError(f"{path} cannot be written: .hdr holds no radiance of {what:g}; clip it.")
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
