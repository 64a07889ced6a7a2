"""What a KTX 2.0 file says about its texels' bits. Implements the Khronos Data Format 1.3, for what reflet writes."""

import struct

from reflet.files.textures.texel_formats import TexelFormat

_LINEAR, _BT709, _RGBSDA = 1, 1, 1
_RED, _GREEN, _BLUE, _ALPHA = 0, 1, 2, 15
_FLOAT, _SIGNED, _EXPONENT = 0x80, 0x40, 0x20
_ZERO, _ONE, _MINUS_ONE = 0, 0x3F800000, 0xBF800000  # as bits of floats


def data_format_descriptor(texel_format: TexelFormat, *, premultiplied: bool) -> bytes:
    """One basic descriptor block: linear, Rec. 709. Raises KeyError for formats that reflet does not write."""
    samples = b"".join(
        struct.pack("<HBB4x2I", offset, length - 1, channel, lower, upper)
        for offset, length, channel, lower, upper in _samples(texel_format)
    )
    size = 24 + len(samples)
    block = struct.pack(
        "<IHH4B4x8B", 0, 2, size, _RGBSDA, _BT709, _LINEAR, premultiplied, texel_format.block_bytes, *[0] * 7
    )
    return struct.pack("<I", 4 + size) + block + samples


def _samples(texel_format: TexelFormat) -> list[tuple[int, int, int, int, int]]:
    """(bit offset, bits, channel and qualifiers, lower, upper) of each sample."""
    if texel_format.name == "rgb9e5":
        # Every channel has a sample for its mantissa and one for the exponent they share, bias 15. The bounds of the
        # mantissas are the specification's.
        return [
            sample
            for number, channel in enumerate((_RED, _GREEN, _BLUE))
            for sample in ((9 * number, 9, channel, 0, 8448), (27, 5, channel | _EXPONENT, 15, 31))
        ]
    if texel_format.name == "r11g11b10f":
        layout = ((0, 11, _RED), (11, 11, _GREEN), (22, 10, _BLUE))
        return [(offset, bits, channel | _FLOAT, _ZERO, _ONE) for offset, bits, channel in layout]
    bits = 8 * texel_format.word_bytes
    channels = (_RED, _GREEN, _BLUE, _ALPHA)[: texel_format.channels]
    return [
        (bits * number, bits, channel | _FLOAT | _SIGNED, _MINUS_ONE, _ONE) for number, channel in enumerate(channels)
    ]
