"""Packed floats: every code comes back, rounding is to the nearest there is, and ranges end where they should."""

import numpy as np
import pytest

from reflet.files.textures.packed_floats import (
    R11G11B10_MAX,
    RGB9E5_MAX,
    decode_r11g11b10,
    decode_rgb9e5,
    encode_r11g11b10,
    encode_rgb9e5,
)


def small_floats(mantissa_bits):
    """All finite unsigned floats with an exponent of 5 bits, by their definition; the index is the code."""
    denormal = np.arange(1 << mantissa_bits) * 2.0 ** (-14 - mantissa_bits)
    normal = [
        (1.0 + np.arange(1 << mantissa_bits) / (1 << mantissa_bits)) * 2.0 ** (exponent - 15)
        for exponent in range(1, 31)
    ]
    return np.concatenate([denormal, *normal])


@pytest.mark.parametrize(("channel", "shift", "mantissa_bits"), [(0, 0, 6), (1, 11, 6), (2, 22, 5)])
def test_r11g11b10_decodes_every_code(channel, shift, mantissa_bits):
    values = small_floats(mantissa_bits)
    codes = np.arange(len(values), dtype=np.uint32)
    decoded = decode_r11g11b10(codes << np.uint32(shift))
    np.testing.assert_array_equal(decoded[:, channel], values)
    np.testing.assert_array_equal(np.delete(decoded, channel, axis=1), 0)
    infinite = decode_r11g11b10(np.array([len(values)], np.uint32) << np.uint32(shift))
    assert np.isposinf(infinite[0, channel])
    assert np.isnan(decode_r11g11b10(np.array([len(values) + 1], np.uint32) << np.uint32(shift))[0, channel])


@pytest.mark.parametrize(("channel", "shift", "mantissa_bits"), [(0, 0, 6), (1, 11, 6), (2, 22, 5)])
def test_r11g11b10_rounds_to_the_nearest(channel, shift, mantissa_bits):
    """Exact values keep their code; halves go to the even code; a hair below and above a half go down and up."""
    values = small_floats(mantissa_bits).astype(np.float32)
    codes = np.arange(len(values))

    def encoded(value):
        rgb = np.zeros((len(value), 3), np.float32)
        rgb[:, channel] = value
        return encode_r11g11b10(rgb) >> np.uint32(shift) & np.uint32((32 << mantissa_bits) - 1)

    np.testing.assert_array_equal(encoded(values), codes)
    halves = (0.5 * (values[:-1].astype(np.float64) + values[1:])).astype(np.float32)  # exact in float32
    np.testing.assert_array_equal(encoded(halves), codes[:-1] + codes[:-1] % 2)
    np.testing.assert_array_equal(encoded(np.nextafter(halves, np.float32(0))), codes[:-1])
    np.testing.assert_array_equal(encoded(np.nextafter(halves, np.float32(np.inf))), codes[1:])


def test_r11g11b10_clamps():
    rgb = np.array([[1e9, np.inf, 65024.0], [-1.0, -0.0, -np.inf]], np.float32)
    np.testing.assert_array_equal(decode_r11g11b10(encode_r11g11b10(rgb)), [R11G11B10_MAX, [0, 0, 0]])


def test_rgb9e5_decodes_by_its_definition():
    packed = np.random.default_rng(1).integers(0, 1 << 32, 5000, dtype=np.uint64).astype(np.uint32)
    wide = packed.astype(np.int64)
    scale = 2.0 ** ((wide >> 27) - 24)
    expected = np.stack([wide & 511, wide >> 9 & 511, wide >> 18 & 511], -1) * scale[:, None]
    np.testing.assert_array_equal(decode_rgb9e5(packed), expected)


def test_rgb9e5_keeps_what_it_can_hold():
    values = decode_rgb9e5(np.random.default_rng(2).integers(0, 1 << 32, 5000, dtype=np.uint64).astype(np.uint32))
    np.testing.assert_array_equal(decode_rgb9e5(encode_rgb9e5(values)), values)


def test_rgb9e5_is_the_nearest_under_the_smallest_exponent():
    """No component is further than half a step away, the step being that of the exponent the largest one needs.

    That exponent is the smallest whose 9 bits hold the largest component after rounding.
    """
    rng = np.random.default_rng(3)
    rgb = (rng.random((20000, 3)) * 2.0 ** rng.integers(-26, 17, (20000, 1))).astype(np.float32)
    rgb = np.minimum(rgb, np.float32(RGB9E5_MAX))
    largest = rgb.max(axis=1).astype(np.float64)
    exponent = np.maximum(np.floor(np.log2(largest)) + 16, 0)
    exponent += np.rint(largest * 2.0 ** (24 - exponent)) > 511
    step = 2.0 ** (exponent - 24)
    packed = encode_rgb9e5(rgb)
    np.testing.assert_array_equal(packed >> np.uint32(27), exponent)
    assert (np.abs(decode_rgb9e5(packed) - rgb.astype(np.float64)) <= 0.5 * step[:, None]).all()


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [
        ((511.5, 1.0, 0.0), (512.0, 0.0, 0.0)),  # rounds up to 512, which takes the next exponent, of steps of 2:
        ((511.4, 1.0, 0.0), (511.0, 1.0, 0.0)),  # 1 is a tie there and goes to the even 0
        ((1e9, np.inf, 1.0), (RGB9E5_MAX, RGB9E5_MAX, 0.0)),
        ((-1.0, -0.0, 0.25), (0.0, 0.0, 0.25)),
        ((2.0**-24, 2.0**-25, 1.5 * 2.0**-24), (2.0**-24, 0.0, 2.0**-23)),  # the smallest step; ties to even
        ((2.0**-26, 1e-38, 1e-45), (0.0, 0.0, 0.0)),
    ],
)
def test_rgb9e5_at_the_ends_of_its_range(rgb, expected):
    packed = encode_rgb9e5(np.array([rgb], np.float32))
    np.testing.assert_array_equal(decode_rgb9e5(packed)[0], np.array(expected, np.float32))


def test_blocks_of_texels_join():
    """Longer than one block of the work; each texel by itself gives the same."""
    rgb = np.random.default_rng(4).random(((1 << 16) + 3, 3)).astype(np.float32)
    for encode, decode in ((encode_rgb9e5, decode_rgb9e5), (encode_r11g11b10, decode_r11g11b10)):
        packed = encode(rgb)
        np.testing.assert_array_equal(packed[-4:], np.concatenate([encode(rgb[-4 + k :][:1]) for k in range(4)]))
        np.testing.assert_array_equal(decode(packed)[-4:], decode(packed[-4:]))
