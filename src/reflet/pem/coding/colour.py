"""Luma and chroma by the matrix of BT.709, full range. Decoding is in integers: every reader gets the same."""

import numpy as np
from jaxtyping import Float32, Int32, UInt8

_KR, _KG, _KB = 0.2126, 0.7152, 0.0722


def ycc_from_rgb(rgb: Float32[np.ndarray, "3 texels"]) -> UInt8[np.ndarray, "3 texels"]:
    """255·Y, 255·Cb + 128 and 255·Cr + 128 of colours in [0, 1], rounded."""
    red, green, blue = np.float32(255.0) * rgb
    y = np.float32(_KR) * red + np.float32(_KG) * green + np.float32(_KB) * blue
    cb = (blue - y) * np.float32(0.5 / (1.0 - _KB)) + np.float32(128.0)
    cr = (red - y) * np.float32(0.5 / (1.0 - _KR)) + np.float32(128.0)
    return np.clip(np.rint(np.stack([y, cb, cr])), 0.0, 255.0).astype(np.uint8)


def rgb_from_ycc(planes: UInt8[np.ndarray, "3 texels"]) -> Int32[np.ndarray, "3 texels"]:
    """Red, green and blue in sixteenths of a code, 0 to 4080; the factors are BT.709's in 1/4096."""
    y = planes[0].astype(np.int32) * 4096 + 128
    cb, cr = (plane.astype(np.int32) - 128 for plane in planes[1:])
    rgb = np.stack([y + 6450 * cr, y - 767 * cb - 1917 * cr, y + 7601 * cb])
    return np.clip(rgb >> 8, 0, 4080)
