"""Pictures that are not plain sRGB: profiles are applied; gain maps, gamma and HDR codes are told of."""

import io
import struct
import warnings
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms

from reflet.files.pictures.png import read_linear_picture, read_linear_picture_with_doubts

# sRGB's primaries under D50 [IEC 61966-2-1, in its ICC profile]
RED, GREEN, BLUE = (0.4360, 0.2225, 0.0139), (0.3851, 0.7169, 0.0971), (0.1431, 0.0606, 0.7141)


def profile(red, green, blue):
    """A minimal ICC profile of three primaries and gamma 2.2."""

    def fixed(*numbers):
        return b"".join(struct.pack(">i", round(number * 65536)) for number in numbers)

    tags = {
        b"desc": b"desc" + bytes(4) + struct.pack(">I", 5) + b"test\0" + bytes(78),
        b"wtpt": b"XYZ " + bytes(4) + fixed(0.9642, 1.0, 0.8249),
        b"cprt": b"text" + bytes(4) + b"none\0",
    }
    for letter, primary in zip(b"rgb", (red, green, blue), strict=True):
        tags[bytes([letter]) + b"XYZ"] = b"XYZ " + bytes(4) + fixed(*primary)
        tags[bytes([letter]) + b"TRC"] = b"curv" + bytes(4) + struct.pack(">IH", 1, round(2.2 * 256))
    table, body, at = struct.pack(">I", len(tags)), b"", 128 + 4 + 12 * len(tags)
    for name, data in tags.items():
        data += bytes(-len(data) % 4)
        table += name + struct.pack(">II", at + len(body), len(data))
        body += data
    head = struct.pack(">I4sI4s4s4s", 128 + len(table + body), b"none", 0x02400000, b"mntr", b"RGB ", b"XYZ ")
    head += bytes(12) + b"acsp" + bytes(28) + fixed(0.9642, 1.0, 0.8249)
    return head.ljust(128, b"\0") + table + body


SWAPPED = profile(GREEN, RED, BLUE)  # what it calls red is sRGB's green


def saved(path, pixels, **options):
    Image.fromarray(pixels).save(path, **options)
    return path


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp"])
def test_a_profile_is_applied(tmp_path, suffix):
    pixels = np.full((8, 16, 3), (255, 0, 0), np.uint8)
    quality = {} if suffix == ".png" else {"quality": 100}
    path = saved(tmp_path / f"a{suffix}", pixels, icc_profile=SWAPPED, **quality)
    image, doubts = read_linear_picture_with_doubts(path)
    # a code of 255, and JPEG's rounding; the primaries have 4 digits
    np.testing.assert_allclose(image, np.broadcast_to([0.0, 1.0, 0.0], image.shape), atol=0.02)
    assert doubts == ()


def test_alpha_and_grey_survive_a_profile(tmp_path):
    pixels = np.full((4, 8, 4), (255, 0, 0, 51), np.uint8)
    image = read_linear_picture(saved(tmp_path / "a.png", pixels, icc_profile=SWAPPED))
    np.testing.assert_allclose(image[0, 0], [0.0, 1.0, 0.0, 0.2], atol=0.02)
    grey = Image.fromarray(np.full((4, 8), 255, np.uint8))
    grey.save(tmp_path / "b.png", icc_profile=SWAPPED)  # a profile of colours on a picture that has none
    image, doubts = read_linear_picture_with_doubts(tmp_path / "b.png")
    np.testing.assert_array_equal(image, 1.0)
    assert [doubt.partition(" has ")[2] for doubt in doubts] == [
        "a colour profile that cannot be applied; its colours are taken as sRGB."
    ]


def test_srgb_and_damaged_profiles(tmp_path):
    pixels = np.random.default_rng(1).integers(0, 256, (4, 8, 3), np.uint8)
    plain = read_linear_picture(saved(tmp_path / "a.png", pixels))
    srgb = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    for icc_profile, is_said in ((srgb, False), (b"no profile at all", True)):
        path = saved(tmp_path / "b.png", pixels, icc_profile=icc_profile)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            image, doubts = read_linear_picture_with_doubts(path)
        np.testing.assert_array_equal(image, plain)
        assert ["cannot be applied" in doubt for doubt in doubts] == [True] * is_said


def with_chunk(path, name, data):
    """The PNG with a chunk more, behind its header."""
    png = path.read_bytes()
    chunk = name + data
    path.write_bytes(png[:33] + struct.pack(">I", len(data)) + chunk + struct.pack(">I", zlib.crc32(chunk)) + png[33:])
    return path


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        (b"gAMA", struct.pack(">I", 100000), "says that its gamma is 1; it is taken as sRGB."),
        (b"gAMA", struct.pack(">I", 45455), None),
        (
            b"cICP",
            bytes([9, 16, 0, 1]),
            "is coded for HDR displays (PQ) and is taken as sRGB; save it as .exr or .hdr.",
        ),
        (b"cICP", bytes([1, 13, 0, 1]), None),
    ],
)
def test_codes_that_are_not_honoured_are_said(tmp_path, name, data, said):
    path = with_chunk(saved(tmp_path / "a.png", np.zeros((4, 8, 3), np.uint8)), name, data)
    _, doubts = read_linear_picture_with_doubts(path)
    assert [doubt.partition("a.png ")[2] for doubt in doubts] == ([said] if said else [])


def test_a_gain_map_is_said(tmp_path):
    xmp = b'<x:xmpmeta xmlns:hdrgm="http://ns.adobe.com/hdr-gain-map/1.0/" hdrgm:Version="1.0"/>'
    path = saved(tmp_path / "a.jpg", np.zeros((4, 8, 3), np.uint8), xmp=xmp)
    _, doubts = read_linear_picture_with_doubts(path)
    assert ["has a gain map for its brightest parts, which is not applied" in doubt for doubt in doubts] == [True]
    buffer = io.BytesIO(path.read_bytes())
    assert Image.open(buffer).size == (8, 4)
