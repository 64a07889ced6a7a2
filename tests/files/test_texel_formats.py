"""Texel formats: what bits mean, by their definitions and against an encoder library."""

import ispc_texcomp
import numpy as np
import pytest

from reflet.files.textures.texel_formats import HALF_MAX, TEXEL_FORMATS


def encoded_blocks(name, texels):
    """Blocks of an encoder of another make; texels are (rows, columns, 4), multiples of 4 texels."""
    rows, columns, _ = texels.shape
    surface = ispc_texcomp.RGBASurface(texels.tobytes(), columns, rows, texels.strides[0])
    if name == "bc6h":
        data = ispc_texcomp.compress_blocks_bc6h(surface, ispc_texcomp.BC6HEncSettings.from_profile("slow"))
    elif name == "bc7":
        data = ispc_texcomp.compress_blocks_bc7(surface, ispc_texcomp.BC7EncSettings.from_profile("alpha_slow"))
    else:
        data = getattr(ispc_texcomp, f"compress_blocks_{name}")(surface)
    return np.frombuffer(data, np.uint8)[None]


def smooth(rows, columns, channels):
    row, column = np.mgrid[:rows, :columns] / 64.0
    waves = [0.5 + 0.4 * np.sin(2.0 * row + k) * np.cos(1.5 * column + 2 * k) for k in range(channels)]
    return np.stack(waves, -1)


@pytest.mark.parametrize("name", [name for name, form in TEXEL_FORMATS.items() if form.is_writable])
def test_what_a_format_holds_comes_back(name):
    """Encoded once, texels are the format's own: they come back exactly from then on, denormals and zeros too."""
    form = TEXEL_FORMATS[name]
    rng = np.random.default_rng(1)
    texels = rng.random((2, 5, 7, form.channels)) * 2.0 ** rng.integers(-30, 20, (2, 5, 7, 1))
    texels[0, 0] = 0.0
    held = form.decode(form.encode(texels.astype(np.float32)), 5, 7)
    assert held.max() > 1e3
    assert held.shape == texels.shape
    np.testing.assert_array_equal(form.decode(form.encode(held), 5, 7), held)


@pytest.mark.parametrize("name", ["r16f", "rgb16f", "rgba16f"])
def test_halves_clamp_and_keep_signs(name):
    form = TEXEL_FORMATS[name]
    texels = np.array([1e9, -1e9, 65519.0, -0.5, 2.0**-24, 2.0**-26], np.float32)
    stored = form.encode(np.repeat(texels[None, None, :, None], form.channels, axis=3))
    expected = [HALF_MAX, -HALF_MAX, HALF_MAX, -0.5, 2.0**-24, 0.0]
    np.testing.assert_array_equal(form.decode(stored, 1, 6)[0, 0, :, 0], expected)


@pytest.mark.parametrize(
    ("name", "stored", "expected"),
    [
        ("rgba8", [255, 51, 0, 102], [1.0, 0.2, 0.0, 0.4]),
        ("rgb8", [255, 51, 0], [1.0, 0.2, 0.0]),
        ("bgra8", [0, 51, 255, 102], [1.0, 0.2, 0.0, 0.4]),
        ("bgrx8", [0, 51, 255, 102], [1.0, 0.2, 0.0]),
        ("bgr8", [0, 51, 255], [1.0, 0.2, 0.0]),
        ("r8", [51], [0.2]),
        # sRGB 188 is 0.5029 linear; alpha is linear as it is
        ("rgba8_srgb", [255, 188, 0, 102], [1.0, 0.5028865, 0.0, 0.4]),
        ("bgrx8_srgb", [0, 188, 255, 9], [1.0, 0.5028865, 0.0]),
    ],
)
def test_eight_bits(name, stored, expected):
    decoded = TEXEL_FORMATS[name].decode(np.array([stored], np.uint8), 1, 1)
    np.testing.assert_allclose(decoded[0, 0, 0], expected, rtol=0, atol=1e-6)  # the last bits of float32


WEIGHTS = np.array([0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64])


def one_region_block(low, high, indices):
    """A BC6H block in the mode of one region and two endpoints of 10 bits, by the table of the Khronos Data Format."""
    bits = 0b00011
    for k, value in enumerate([*low, *high]):
        bits |= (int(value) & 1023) << (5 + 10 * k)
    bits |= int(indices[0]) << 65  # the first index has 3 bits, the others 4
    for k, index in enumerate(indices[1:]):
        bits |= int(index) << (68 + 4 * k)
    return np.frombuffer(bits.to_bytes(16, "little"), np.uint8)[None]


def test_bc6h_block_by_its_definition():
    """Endpoints of 10 bits become 16, are mixed with weights of sixty-fourths, and 31/64 of that are a half's bits."""
    low, high, indices = (100, 512, 0), (800, 7, 1023), [5, *range(15)]
    wide = [[0 if v == 0 else 0xFFFF if v == 1023 else ((v << 16) + 0x8000) >> 10 for v in end] for end in (low, high)]
    weight = WEIGHTS[indices][:, None]
    mixed = ((64 - weight) * np.array(wide[0]) + weight * np.array(wide[1]) + 32) >> 6
    expected = (mixed * 31 >> 6).astype(np.uint16).view(np.float16)
    decoded = TEXEL_FORMATS["bc6h"].decode(one_region_block(low, high, indices), 4, 4)
    np.testing.assert_array_equal(decoded.reshape(16, 3), expected)


def test_signed_bc6h_block_by_its_definition():
    low, high, indices = (-300, 511, 0), (200, -7, -511), [5, *range(15)]

    def wide(v):
        magnitude = abs(v)
        return np.sign(v) * (0 if v == 0 else 0x7FFF if magnitude >= 511 else ((magnitude << 15) + 0x4000) >> 9)

    weight = WEIGHTS[indices][:, None]
    ends = [np.array([wide(v) for v in end]) for end in (low, high)]
    mixed = ((64 - weight) * ends[0] + weight * ends[1] + 32) >> 6
    bits = np.abs(mixed) * 31 >> 5 | np.where(mixed < 0, 0x8000, 0)
    decoded = TEXEL_FORMATS["bc6h_signed"].decode(one_region_block(low, high, indices), 4, 4)
    np.testing.assert_array_equal(decoded.reshape(16, 3), bits.astype(np.uint16).view(np.float16))


def test_bc6h_of_an_encoder():
    """8 bits a texel hold a smooth picture of high range to 2 %: its slow waves change by 5 % a texel."""
    texels = (40.0 ** (2.0 * smooth(32, 64, 4))).astype(np.float16)
    decoded = TEXEL_FORMATS["bc6h"].decode(encoded_blocks("bc6h", texels), 32, 64)[0]
    expected = texels[..., :3].astype(np.float32)
    assert expected.max() / expected.min() > 100.0
    assert (np.abs(decoded - expected) / expected).mean() < 0.02


@pytest.mark.parametrize(("name", "levels"), [("bc1", 2.0), ("bc3", 2.0), ("bc7", 1.0)])
def test_eight_bit_blocks_of_an_encoder(name, levels):
    """Mean error in 8-bit levels: two colours a block hold slow ramps to about one, BC7 to half."""
    texels = np.rint(255.0 * smooth(32, 64, 4)).astype(np.uint8)
    if name == "bc1":
        texels[..., 3] = 255
    stored = encoded_blocks(name, texels)
    decoded = TEXEL_FORMATS[name].decode(stored, 32, 64)[0]
    assert np.abs(255.0 * decoded - texels).mean() < levels
    linear = TEXEL_FORMATS[f"{name}_srgb"].decode(stored, 32, 64)[0]
    encoded = np.where(decoded <= 0.04045, decoded / 12.92, ((decoded + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear[..., :3], encoded[..., :3], rtol=0, atol=1e-6)  # rounding of float32
    np.testing.assert_array_equal(linear[..., 3], decoded[..., 3])


def test_blocks_beyond_the_border_are_left_out():
    """6×5 texels take 2×2 blocks; the rest of them is not shown."""
    texels = (1.0 + smooth(8, 8, 4)).astype(np.float16)
    form = TEXEL_FORMATS["bc6h"]
    stored = encoded_blocks("bc6h", texels)
    assert form.image_bytes(5, 6) == stored.size
    np.testing.assert_array_equal(form.decode(stored, 5, 6), form.decode(stored, 8, 8)[:, :5, :6])


def test_formats_that_are_only_read_say_so():
    with pytest.raises(ValueError, match="only read"):
        TEXEL_FORMATS["bc6h"].encode(np.zeros((1, 4, 4, 3), np.float32))
