"""Linear radiance as small integers and back: colour below white as displays see it, what is brighter by a gain.

With m the largest value of each channel, G = max(1, m) over all three, and w = m/G: radiance x = w·g·b. The gain g, one
for all channels, runs from 1 to G and is coded by its logarithm; what is left, b in [0, 1], by sRGB's curve and then as
luma and chroma. Where no channel exceeds 1 there is no gain. Steps of b are at most 1.6 of an 8-bit display's, steps of
g are 1.3 % where m = 27; one logarithm for everything has steps of 2.9 % there, which show as bands in smooth skies,
and takes up to half as many bytes again for the same loss. A channel's largest value comes back exact.
"""

import numpy as np
from jaxtyping import Float32, Int32, UInt8

SIXTEENTHS = 16 * 255  # of a code, in which decoded colours are counted: sums of luma and chroma fall between codes
_TOE = 0.0031308


def has_gain(most: Float32[np.ndarray, "3"]) -> bool:
    """Whether there is anything brighter than 1."""
    return bool(most.max() > 1.0)


def split_radiance(
    radiance: Float32[np.ndarray, "3 texels"], most: Float32[np.ndarray, "3"]
) -> tuple[Float32[np.ndarray, "3 texels"], UInt8[np.ndarray, "texels"]]:
    """b by sRGB's curve, and the codes of g. Radiance is clamped to [0, ``most``]; black channels have ``most`` = 0."""
    white, largest = _white(most)[:, None], max(float(most.max()), 1.0)
    share = np.divide(radiance, white, out=np.zeros_like(radiance), where=white > 0.0)
    share[white[:, 0] == 0.0] = share.max(0)  # black whatever its code is: one that costs nothing
    if not has_gain(most):
        return _srgb(np.clip(share, 0.0, 1.0)), np.zeros(share.shape[1], np.uint8)
    brightest = np.clip(share.max(0), 1.0, largest)
    wanted = np.log(brightest) * np.float32(255.0 / np.log(largest))
    gain = np.minimum(np.ceil(wanted - np.float32(1e-3)), 255.0).astype(np.uint8)  # up: b may not exceed 1
    return _srgb(np.clip(share / gains(most)[gain], 0.0, 1.0)), gain


def join_radiance(
    colour: Int32[np.ndarray, "3 texels"], gain: UInt8[np.ndarray, "texels"], most: Float32[np.ndarray, "3"]
) -> Float32[np.ndarray, "3 texels"]:
    """Radiance of b in sixteenths of a code and of g's codes; in float32 throughout, as every reader has it."""
    y = np.arange(SIXTEENTHS + 1) / SIXTEENTHS
    linear = np.where(y <= 12.92 * _TOE, y / 12.92, ((y + 0.055) / 1.055) ** 2.4).astype(np.float32)
    channels = [(white * linear)[codes] for white, codes in zip(_white(most), colour, strict=True)]
    return np.stack(channels) * gains(most)[gain]


def gains(most: Float32[np.ndarray, "3"]) -> Float32[np.ndarray, "256"]:
    """g of each code: G to the power of code/255."""
    return (max(float(most.max()), 1.0) ** (np.arange(256) / 255.0)).astype(np.float32)


def _white(most: Float32[np.ndarray, "3"]) -> Float32[np.ndarray, "3"]:
    return most / np.float32(max(most.max(), 1.0))


def _srgb(linear: Float32[np.ndarray, "3 texels"]) -> Float32[np.ndarray, "3 texels"]:
    curve = np.float32(1.055) * np.power(linear, np.float32(1.0 / 2.4)) - np.float32(0.055)
    return np.where(linear <= _TOE, np.float32(12.92) * linear, curve)
