"""Radiance pictures (.hdr): shared-exponent RGBE, run-length encoded by the scanline."""

import os
import re
from pathlib import Path

import numba
import numpy as np
from jaxtyping import Float32, UInt8

from reflet.errors import RefletError

# "#?" and lines of text, an empty line, then the picture's size
_HEADER = re.compile(
    rb"(?P<text>#\?.*?\r?\n)\r?\n(?P<y>[-+])Y +(?P<height>\d+) +(?P<x>[-+])X +(?P<width>\d+)\r?\n", re.DOTALL
)


def read_hdr(path: str | os.PathLike[str]) -> Float32[np.ndarray, "height width 3"]:
    """Linear RGB radiance of a .hdr file, row 0 at the top; EXPOSURE lines of its header are divided out.

    Raises RefletError for files that are missing, truncated, or not RGBE.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror}); check the name.") from error
    header = _HEADER.match(data)
    if header is None:
        raise RefletError(f"{path} is not a Radiance .hdr picture with its rows from top or bottom; convert it.")
    if b"rgbe" not in header["text"]:
        raise RefletError(f"{path} is not stored as RGBE; convert it to RGB.")
    height, width = int(header["height"]), int(header["width"])
    body = np.frombuffer(data, np.uint8)[header.end() :]
    rgbe = np.zeros((height, width, 4), np.uint8)
    if not width * height or _decode(body, rgbe) != height:
        raise RefletError(f"{path} is truncated or damaged; copy or download it again.")
    exposure = np.prod([float(e) for e in re.findall(rb"\nEXPOSURE= *([0-9.eE+-]+)", header["text"])] or [1.0])
    # mantissa·2^(exponent - 136); Ward adds 1/2 to the mantissa, the readers in use (three.js, OpenCV, stb) do not
    scale = np.where(rgbe[..., 3] > 0, np.exp2(rgbe[..., 3].astype(np.float32) - 136.0), 0.0) / exposure
    image = (rgbe[..., :3] * scale[..., None]).astype(np.float32)
    image = image[::-1] if header["y"] == b"+" else image
    return np.ascontiguousarray(image[:, ::-1] if header["x"] == b"-" else image)


@numba.njit(cache=True)
def _decode(data: UInt8[np.ndarray, "bytes"], out: UInt8[np.ndarray, "height width 4"]) -> int:
    """Fills ``out`` and returns the number of whole scanlines that ``data`` held."""
    height, width, _ = out.shape
    at, end = 0, data.size
    for row in range(height):
        if at + 4 > end:
            return row
        if 8 <= width < 32768 and data[at] == 2 and data[at + 1] == 2 and data[at + 2] < 128:
            # each of the four channels on its own: count > 128 repeats a byte, else literal bytes follow
            if data[at + 2] * 256 + data[at + 3] != width:
                return row
            at += 4
            for channel in range(4):
                column = 0
                while column < width:
                    if at + 2 > end:
                        return row
                    count = int(data[at])
                    at += 1
                    if count > 128:
                        count -= 128
                        if column + count > width:
                            return row
                        for k in range(column, column + count):
                            out[row, k, channel] = data[at]
                        at += 1
                    else:
                        if count == 0 or column + count > width or at + count > end:
                            return row
                        for k in range(count):
                            out[row, column + k, channel] = data[at + k]
                        at += count
                    column += count
        else:
            # plain pixels; (1, 1, 1, n) repeats the pixel before n times, successive ones count in base 256
            column, shift = 0, 0
            while column < width:
                if at + 4 > end:
                    return row
                if data[at] == 1 and data[at + 1] == 1 and data[at + 2] == 1 and column > 0:
                    count = int(data[at + 3]) << shift
                    shift += 8
                    if column + count > width:
                        return row
                    for k in range(count):
                        for channel in range(4):
                            out[row, column + k, channel] = out[row, column - 1, channel]
                    column += count
                else:
                    for channel in range(4):
                        out[row, column, channel] = data[at + channel]
                    column += 1
                    shift = 0
                at += 4
    return height
