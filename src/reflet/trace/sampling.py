"""Samples on the device: how many at a time, their places, and their means."""

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

LANES = 1 << 20  # samples traced at a time: up to 250 MB of results
R2 = (0.7548776662466927, 0.5698402909980532)  # steps of a sequence that fills the square evenly
_UNIT = 2.0**-32


def shifted_hammersley(sample, count, key, seed):  # type: ignore[no-untyped-def]
    """Points (x, y) in [0, 1)² number ``sample`` of Hammersley sets of ``count``, each set shifted around the square by
    an offset that follows from its ``key`` and the ``seed``."""
    shift_x, shift_y = mi.sample_tea_32(key, seed, 4)
    x = (mi.Float(sample) + 0.5) / mi.Float(count) + mi.Float(shift_x) * _UNIT
    # The radical inverse in base 2 and its shift add as 32-bit fractions: the overflow wraps around.
    y = mi.Float(dr.brev(sample) + shift_y) * _UNIT
    return x - dr.floor(x), dr.minimum(y, 1.0 - 2.0**-24)


def shifted_multiples(sample, fractions: tuple[int, ...], key, seed):  # type: ignore[no-untyped-def]
    """Multiples number ``sample`` of 32-bit ``fractions`` modulo 1, each shifted around by an offset that follows from
    ``key`` and ``seed``."""
    offsets = (mi.sample_tea_32(key, seed ^ mi.UInt32(fraction), 4)[0] for fraction in fractions)
    bits = [sample * mi.UInt32(fraction) + offset for fraction, offset in zip(fractions, offsets, strict=True)]
    return [mi.Float(each >> 8) * 2.0**-24 for each in bits]


def shifts(key, seed):  # type: ignore[no-untyped-def]
    """A number in [0, 1) for each ``key``, as if random."""
    bits, _ = mi.sample_tea_32(key, seed, 4)
    return mi.Float(bits >> 8) * 2.0**-24


def chances(direction, position, salt: int):  # type: ignore[no-untyped-def]
    """Two numbers in [0, 1), as if random, that follow from rays alone, others for each ``salt``: one that is mirrored
    to and fro comes back along the same direction, but elsewhere."""
    u, v, w = (dr.reinterpret_array(mi.UInt32, axis) for axis in direction)
    x, y, z = (dr.reinterpret_array(mi.UInt32, axis) for axis in position)
    first, _ = mi.sample_tea_32(u, v, 4)
    second, _ = mi.sample_tea_32(x ^ w, y, 4)
    return tuple(mi.Float(bits >> 8) * 2.0**-24 for bits in mi.sample_tea_32(first ^ z, second ^ mi.UInt32(salt), 4))


def threshold(pixel, sample, triangle):  # type: ignore[no-untyped-def]
    """A number in [0, 1) for each sample of a picture and triangle: what its alpha has to exceed to be seen there.
    Evenly spread over a pixel's samples. Twin of `threshold` in `shaders/holes.wgsl`."""
    x = pixel * 747796405 + triangle * 2891336453 + 277803737
    x = ((x >> ((x >> 28) + 4)) ^ x) * 277803737
    x = (x >> 22) ^ x
    value = mi.Float(x >> 8) * 2.0**-24 + mi.Float(sample) * 0.618034
    return dr.minimum(value - dr.floor(value), 1.0 - 2.0**-24)


def block_means(light, count: int) -> Float32[np.ndarray, "blocks channels"]:  # type: ignore[no-untyped-def]
    """Means over blocks of ``count`` neighbouring lanes of all channels."""
    dr.eval(light)  # all at once, else every channel's sum would trace anew
    return np.stack([dr.block_sum(channel, count).numpy() for channel in light], -1) / np.float32(count)
