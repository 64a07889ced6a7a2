"""Radiance, with alpha or without, in one file: an AVIF picture of its planes, and beside it what must not be rounded.

The planes stand below each other: Y, Cb, Cr; the gain, where anything is brighter than 1; alpha, where there is any.
The box of ours after the picture (little-endian):

    float32 ×3        the largest values of the channels, but for
    uint32            the number of the texels that are brighter than these: they are stored as they are,
    uint32 × number   their numbers, and
    float16 ×3 each   their radiance; then
    float16 each      all channels of the last texels of a map, of levels with fewer than four rows, in their order

A sun is a handful of texels a thousand times brighter than all others: in the picture it would take their codes.
"""

import struct

import numpy as np
from jaxtyping import Float16, Float32

from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.pem.coding.atlas import Layout
from reflet.pem.coding.avif import decode_grey, encode_grey
from reflet.pem.coding.boxes import own_box, with_own_box
from reflet.pem.coding.colour import rgb_from_ycc, ycc_from_rgb
from reflet.pem.coding.transfer import has_gain, join_radiance, split_radiance

QUALITY = 95  # of pictures: costs no viewpoint of the benchmark scene 0.1 dB at 512², see docs/measurements.md
_BRIGHTEST = 4096  # one of so many texels is stored as it is, and one more, at the most
_HEAD = struct.Struct("<3fI")

Texels = Float32[np.ndarray, "texels channels"]


def encode_light(texels: Texels, layout: Layout, exact_from: int, quality: int = QUALITY) -> bytes:
    """Texels of 3 or 4 channels, those from number ``exact_from`` on as half floats.

    Radiance is clamped to [0, 65504], alpha to [0, 1]; none may be NaN.
    """
    channels = np.ascontiguousarray(texels.T)
    light, alpha = np.clip(channels[:3], 0.0, HALF_MAX), np.clip(channels[3:], 0.0, 1.0)
    brightness = light.max(0)
    count = min(1 + len(texels) // _BRIGHTEST, len(texels) - 1)
    brightest = np.flatnonzero(brightness > np.partition(brightness, -1 - count)[-1 - count]).astype("<u4")
    others = light.copy()
    others[:, brightest] = 0.0
    most = others.max(1).astype(np.float16).astype(np.float32)
    colour, gain = split_radiance(light, most)
    planes = [ycc_from_rgb(colour), *([gain[None]] if has_gain(most) else []), np.rint(255.0 * alpha).astype(np.uint8)]
    picture = layout.lay_out(np.concatenate(planes))
    exact = np.concatenate([light, alpha])[:, exact_from:].T
    payload = (
        _HEAD.pack(*most, len(brightest))
        + brightest.tobytes()
        + light[:, brightest].T.astype("<f2").tobytes()
        + exact.astype("<f2").tobytes()
    )
    return with_own_box(encode_grey(picture.reshape(-1, picture.shape[-1]), quality), payload)


def decode_light(
    file: bytes, layout: Layout, count: int, channels: int, exact_from: int
) -> Float32[np.ndarray, "texels channels"]:
    """The ``count`` texels of `encode_light`, in half precision. Raises ValueError where it is another's file."""
    payload = own_box(file)
    if len(payload) < _HEAD.size:
        raise ValueError("its box is cut short")
    *largest, number = _HEAD.unpack_from(payload)
    most = np.array(largest, np.float32)
    texels_end = _HEAD.size + 10 * number
    if len(payload) != texels_end + 2 * channels * (count - exact_from):
        raise ValueError("its box is of another size")
    if not (np.isfinite(most).all() and (most >= 0.0).all() and most.max() <= HALF_MAX):
        raise ValueError("its light has no range")
    places = np.frombuffer(payload, "<u4", number, _HEAD.size)
    if number and int(places.max()) >= count:
        raise ValueError("its brightest texels are not there")
    rows, columns = layout.shape
    plane_count = 3 + has_gain(most) + (channels == 4)
    pictures = decode_grey(file, (plane_count * rows, columns)).reshape(plane_count, rows, columns)
    planes = layout.gather(pictures)
    gain = planes[3] if has_gain(most) else np.zeros(count, np.uint8)
    texels = np.empty((count, channels), np.float16)
    texels[:, :3] = join_radiance(rgb_from_ycc(planes[:3]), gain, most).T
    if channels == 4:
        texels[:, 3] = planes[-1] / np.float32(255.0)
    texels[places, :3] = _halves(payload, _HEAD.size + 4 * number, 3 * number).reshape(-1, 3)
    texels[exact_from:] = _halves(payload, texels_end, channels * (count - exact_from)).reshape(-1, channels)
    return texels.astype(np.float32)


def _halves(payload: bytes, offset: int, count: int) -> Float16[np.ndarray, "count"]:
    return np.frombuffer(payload, "<f2", count, offset)
