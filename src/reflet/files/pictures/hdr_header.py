"""What a .hdr file says before its scanlines begin [Ward91], and what of it cannot be meant."""

import os
import re
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from reflet.errors import RefletError
from reflet.files.pictures.primaries import REC709, are_usable

HEADER_LIMIT = 2**20  # bytes of text that are looked through for the line of the size
# "-Y 512 +X 1024" begins a line; the blank line that should stand before it is missing in some files
_SIZE = re.compile(rb"^([-+])([XY])[ \t]+(\d{1,9})[ \t]+([-+])([XY])[ \t]+(\d{1,9})[ \t]*\r?\n", re.MULTILINE)
_FAINTEST, _BRIGHTEST = 1e-30, 1e30  # of all exposures together: floats hold the radiance that they give


@dataclass(frozen=True)
class HdrHeader:
    """The scanlines begin at byte ``end``; the pixels were multiplied by ``exposure``, channel by channel."""

    end: int
    width: int
    height: int
    is_column_major: bool  # scanlines are columns
    is_upside_down: bool  # the first row is the lowest
    is_mirrored: bool  # the first column is the rightmost
    is_xyz: bool
    exposure: Float64[np.ndarray, "3"]
    primaries: Float64[np.ndarray, "4 2"]
    doubts: tuple[str, ...]  # sentences about lines that cannot be meant, and what is done instead


def read_hdr_header(path: str | os.PathLike[str], data: bytes) -> HdrHeader:
    """The header of the file whose bytes are ``data``. Raises RefletError where it is none of a .hdr file."""
    start = data[:HEADER_LIMIT]
    size = _SIZE.search(start)
    text = start[: size.start()] if size else start
    if size is None or size[2] == size[5] or not (start.startswith(b"#?") or b"FORMAT=32-bit_rle_" in text):
        raise RefletError(
            f"{path} is not a Radiance .hdr picture: it has no line of its size, such as -Y 512 +X 1024, below a first "
            "line that begins with #?; check what it is."
        )
    first, second = int(size[3]), int(size[6])
    if not first * second:
        raise RefletError(f"{path} has no pixels; copy or download it again.")
    is_xyz, exposure, primaries, doubts = False, np.ones(3), REC709, []
    for line in text.splitlines():
        name, _, value = line.strip().partition(b"=")
        name = name.strip()
        said = line.decode("latin-1").strip()[:60]
        if name == b"FORMAT":
            if value.strip() not in (b"32-bit_rle_rgbe", b"32-bit_rle_xyze"):
                raise RefletError(f"{path} is stored as {value.decode('latin-1')[:40]}, not as RGBE; save it as that.")
            is_xyz = value.strip().endswith(b"xyze")
        elif name in (b"EXPOSURE", b"COLORCORR"):
            factor = _numbers(value, 1 if name == b"EXPOSURE" else 3)
            together = exposure * (1.0 if factor is None else factor)
            if factor is None or not ((together > _FAINTEST) & (together < _BRIGHTEST)).all():
                doubts.append(f'{path} says "{said}" in its header, which no picture was multiplied by; it is ignored.')
            else:
                exposure = together
        elif name == b"PRIMARIES":
            given = _numbers(value, 8)
            if given is not None and are_usable(given.reshape(4, 2)):
                primaries = given.reshape(4, 2)
            elif given is None or given.any():  # eight zeros mean nothing by custom
                doubts.append(f'{path} says "{said}" in its header, which are no colours; it is taken as Rec. 709.')
        elif name == b"GAMMA" and ((gamma := _numbers(value, 1)) is None or gamma[0] != 1.0):
            doubts.append(f'{path} says "{said}" in its header; its pixels are taken as linear nonetheless.')
    sign = {size[2]: size[1], size[5]: size[4]}
    is_column_major = size[2] == b"X"
    width, height = (first, second) if is_column_major else (second, first)
    return HdrHeader(
        end=size.end(), width=width, height=height, is_column_major=is_column_major,
        is_upside_down=sign[b"Y"] == b"+", is_mirrored=sign[b"X"] == b"-",
        is_xyz=is_xyz, exposure=exposure, primaries=primaries, doubts=tuple(doubts),
    )  # fmt: skip


def _numbers(value: bytes, count: int) -> np.ndarray | None:
    """The numbers of a header line, or None where there are not just so many finite ones."""
    try:
        numbers = np.array([float(word) for word in value.split()])
    except ValueError:
        return None
    return numbers if len(numbers) == count and np.isfinite(numbers).all() else None
