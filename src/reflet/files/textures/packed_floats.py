"""Three colour components in 32 bits: a shared exponent (RGB9E5), or two small floats of 11 bits and one of 10.

Neither holds a sign. Encoding rounds to the nearest value there is, ties to the even one, and clamps what is negative
to 0 and what is too large to the largest. Everything works on blocks of texels, so that what it needs beside input and
output is a few MiB.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float32, UInt32

RGB9E5_MAX = 65408.0  # 511/512·2^16
R11G11B10_MAX = (65024.0, 65024.0, 64512.0)  # (2 - 1/64)·2^15 and (2 - 1/32)·2^15

_BLOCK = 1 << 16
_MANTISSA, _BIAS = 9, 15  # of RGB9E5


def _by_blocks(convert: Callable[[np.ndarray], np.ndarray], values: np.ndarray, out: np.ndarray) -> np.ndarray:
    for start in range(0, len(values), _BLOCK):
        out[start : start + _BLOCK] = convert(values[start : start + _BLOCK])
    return out


def encode_rgb9e5(rgb: Float32[np.ndarray, "n 3"]) -> UInt32[np.ndarray, "n"]:
    """Mantissas of 9 bits (red lowest) under one exponent of 5: m·2^(e - 24), no implied leading one.

    Not for values that are not numbers.
    """
    return _by_blocks(_encode_rgb9e5, rgb, np.empty(len(rgb), np.uint32))


def _encode_rgb9e5(rgb: np.ndarray) -> np.ndarray:
    rgb = np.clip(rgb, np.float32(0.0), np.float32(RGB9E5_MAX))
    largest = rgb.max(axis=1)
    # The largest component shall have 9 bits before the point: largest = f·2^k with f in [1/2, 1), e - 24 = k - 9.
    _, k = np.frexp(largest)
    exponent = np.maximum(k + _BIAS, 0)
    # Scaling by a power of two is exact, so that rint rounds once.
    overflow = np.rint(np.ldexp(largest, _BIAS + _MANTISSA - exponent)) == 1 << _MANTISSA
    exponent += overflow
    mantissa = np.rint(np.ldexp(rgb, (_BIAS + _MANTISSA - exponent)[:, None])).astype(np.uint32)
    return mantissa[:, 0] | mantissa[:, 1] << 9 | mantissa[:, 2] << 18 | exponent.astype(np.uint32) << 27


def decode_rgb9e5(packed: UInt32[np.ndarray, "n"]) -> Float32[np.ndarray, "n 3"]:
    """m·2^(e - 24) of each component, exactly."""
    return _by_blocks(_decode_rgb9e5, packed, np.empty((len(packed), 3), np.float32))


def _decode_rgb9e5(packed: np.ndarray) -> np.ndarray:
    mantissa = (packed[:, None] >> np.array([0, 9, 18], np.uint32)) & np.uint32(0x1FF)
    exponent = (packed >> np.uint32(27)).astype(np.int32) - (_BIAS + _MANTISSA)
    return np.ldexp(mantissa.astype(np.float32), exponent[:, None])


def encode_r11g11b10(rgb: Float32[np.ndarray, "n 3"]) -> UInt32[np.ndarray, "n"]:
    """Red and green with 6 bits of mantissa, blue with 5, each with its own exponent of 5 as in half floats.

    Not for values that are not numbers.
    """
    return _by_blocks(_encode_r11g11b10, rgb, np.empty(len(rgb), np.uint32))


def _encode_r11g11b10(rgb: np.ndarray) -> np.ndarray:
    rgb = np.clip(rgb, np.float32(0.0), np.array(R11G11B10_MAX, np.float32))
    red, green, blue = _small_float(rgb[:, 0], 6), _small_float(rgb[:, 1], 6), _small_float(rgb[:, 2], 5)
    return red | green << 11 | blue << 22


def _small_float(value: np.ndarray, mantissa_bits: int) -> np.ndarray:
    """Bits of the nearest float with an exponent of 5 bits, bias 15, no sign; ``value`` is in its range.

    A binary float's bits, read as a whole number, count the floats up from 0: rounding the 23 mantissa bits away may
    carry into the exponent and still is right. Below 2^-14 the steps are even: 2^(-14 - mantissa_bits).
    """
    dropped = np.uint32(23 - mantissa_bits)
    bits = np.ascontiguousarray(value).view(np.uint32) & np.uint32(0x7FFFFFFF)  # of -0 too
    odd = (bits >> dropped) & np.uint32(1)
    below_half = np.uint32((1 << (22 - mantissa_bits)) - 1)
    rounded = (bits - np.uint32((127 - 15) << 23) + below_half + odd) >> dropped
    denormal = np.rint(np.ldexp(np.minimum(value, np.float32(2.0**-14)), 14 + mantissa_bits)).astype(np.uint32)
    return np.where(value < 2.0**-14, denormal, rounded)


def decode_r11g11b10(packed: UInt32[np.ndarray, "n"]) -> Float32[np.ndarray, "n 3"]:
    """The three components, exactly; infinities and values that are not numbers included."""
    return _by_blocks(_decode_r11g11b10, packed, np.empty((len(packed), 3), np.float32))


def _decode_r11g11b10(packed: np.ndarray) -> np.ndarray:
    # a half float has the same exponent and 10 bits of mantissa
    halves = np.stack([packed << 4 & 0x7FF0, packed >> 7 & 0x7FF0, packed >> 17 & 0x7FE0], -1).astype(np.uint16)
    return halves.view(np.float16).astype(np.float32)
