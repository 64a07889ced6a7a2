import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from reflet.errors import RefletError
from reflet.files.pictures.png import read_linear_picture, read_picture, write_png


def decoded(encoded):
    """IEC 61966-2-1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def sixteen_bit_png(pixels, size=None):
    """A PNG file written by hand, for Pillow writes none of 16-bit colours."""
    height, width, channels = pixels.shape
    width, height = size or (width, height)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 16, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def test_png_round_trip_is_exact(tmp_path):
    picture = np.random.default_rng(2).integers(0, 256, (5, 7, 4)).astype(np.uint8)
    write_png(tmp_path / "a.png", picture)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), picture)


@pytest.mark.parametrize("channels", [3, 4])
def test_eight_bits_become_linear(tmp_path, channels):
    picture = np.arange(256 * channels).reshape(16, 16, channels).astype(np.uint8)
    write_png(tmp_path / "a.png", picture)
    linear = read_linear_picture(tmp_path / "a.png")
    # float32 rounding
    np.testing.assert_allclose(linear[..., :3], decoded(picture[..., :3] / 255.0), rtol=1e-6)
    np.testing.assert_allclose(linear[..., 3:], picture[..., 3:] / 255.0, rtol=1e-6)


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_all_sixteen_bits_count(tmp_path, channels):
    picture = np.random.default_rng(4).integers(0, 65536, (5, 7, channels)).astype(np.uint16)
    (tmp_path / "a.png").write_bytes(sixteen_bit_png(picture))
    linear = read_linear_picture(tmp_path / "a.png")
    colors = 1 if channels < 3 else 3
    expected = np.broadcast_to(decoded(picture[..., :colors] / 65535.0), (5, 7, 3))
    np.testing.assert_allclose(linear[..., :3], expected, rtol=1e-6)
    assert linear.shape[2] == (3 if channels % 2 else 4)
    np.testing.assert_allclose(linear[..., 3:], picture[..., colors:] / 65535.0, rtol=1e-6)


def test_photographs_are_turned_upright(tmp_path):
    picture = np.zeros((8, 16, 3), np.uint8)
    picture[:, :8] = 255
    exif = Image.Exif()
    exif[0x0112] = 6  # turn by 90° clockwise
    Image.fromarray(picture).save(tmp_path / "a.jpg", exif=exif, quality=100)
    read = read_linear_picture(tmp_path / "a.jpg")
    assert read.shape == (16, 8, 3)
    assert read[:6].min() > 0.9 and read[10:].max() < 0.1


def test_palettes_and_grey_are_colours(tmp_path):
    grey = np.uint8([[0, 128, 255]])
    for image in (Image.fromarray(grey), Image.fromarray(grey).convert("P"), Image.fromarray(grey > 200)):
        image.save(tmp_path / "a.png")
        assert read_linear_picture(tmp_path / "a.png").shape == (1, 3, 3)
    assert read_linear_picture(tmp_path / "a.png")[0, 2].tolist() == [1.0, 1.0, 1.0]


def test_damaged_pictures_are_refused(tmp_path):
    pixels = np.random.default_rng(5).integers(0, 65536, (8, 8, 3)).astype(np.uint16)
    eight = io.BytesIO()
    Image.fromarray((pixels >> 8).astype(np.uint8)).save(eight, "PNG")
    for whole in (sixteen_bit_png(pixels), eight.getvalue()):
        for length in range(0, len(whole) - 20, 7):
            (tmp_path / "a.png").write_bytes(whole[:length])
            with pytest.raises(RefletError):
                read_linear_picture(tmp_path / "a.png")
    (tmp_path / "a.png").write_bytes(sixteen_bit_png(pixels, (16000, 16000)))
    with pytest.raises(RefletError, match="hold no 16000×16000"):
        read_linear_picture(tmp_path / "a.png")
