from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from reflet.errors import RefletError
from reflet.files.environment import read_environment
from reflet.files.exr import read_exr, write_exr
from reflet.files.hdr import read_hdr
from reflet.files.openexr_layout import latlong_from_openexr
from reflet.files.png import read_picture, write_png

SHARED = Path(__file__).parents[3] / "shared" / "data"


def rle_scanline(row):
    """One scanline as new-style RLE: runs where four equal bytes follow one another, else literals."""
    out = bytes([2, 2, len(row) >> 8, len(row) & 255])
    for channel in row.T:
        at = 0
        while at < len(channel):
            run = 1
            while at + run < len(channel) and run < 127 and channel[at + run] == channel[at]:
                run += 1
            if run >= 4:
                out += bytes([128 + run, channel[at]])
            else:
                run = min(3, len(channel) - at)
                out += bytes([run, *channel[at : at + run]])
            at += run
    return out


def hdr_file(path, rgbe, encoded, header=b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", size=None):
    size = size or b"-Y %d +X %d\n" % rgbe.shape[:2]
    path.write_bytes(header + b"\n" + size + encoded)
    return path


@pytest.fixture
def rgbe():
    random = np.random.default_rng(0)
    picture = random.integers(0, 256, (8, 16, 4)).astype(np.uint8)
    picture[..., 3] = random.integers(120, 140, (8, 16))
    picture[2:5, 3:12] = (10, 200, 30, 129)  # something to run over
    return picture


def radiance(rgbe):
    return (rgbe[..., :3] * 2.0 ** (rgbe[..., 3:].astype(float) - 136.0)).astype(np.float32)


def test_hdr_run_length_encoded(tmp_path, rgbe):
    path = hdr_file(tmp_path / "a.hdr", rgbe, b"".join(rle_scanline(row) for row in rgbe))
    # mantissa times a power of two is exact in float32
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe))


def test_hdr_flat_and_old_runs(tmp_path, rgbe):
    np.testing.assert_array_equal(read_hdr(hdr_file(tmp_path / "a.hdr", rgbe, rgbe.tobytes())), radiance(rgbe))
    narrow = np.repeat(np.array([[[9, 8, 7, 130]]], np.uint8), 6, axis=1)
    old = hdr_file(tmp_path / "b.hdr", narrow, bytes([9, 8, 7, 130, 1, 1, 1, 5]))
    np.testing.assert_array_equal(read_hdr(old), radiance(narrow))


def test_hdr_orientation_and_exposure(tmp_path, rgbe):
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n"
    path = hdr_file(tmp_path / "a.hdr", rgbe, rgbe.tobytes(), header, b"+Y 8 -X 16\n")
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe)[::-1, ::-1] / 4.0)


@pytest.mark.parametrize("kept", [0.3, 0.7, 0.99])
def test_truncated_hdr_is_refused(tmp_path, rgbe, kept):
    body = b"".join(rle_scanline(row) for row in rgbe)
    path = hdr_file(tmp_path / "a.hdr", rgbe, body[: int(kept * len(body))])
    with pytest.raises(RefletError, match="truncated"):
        read_environment(path)


def test_exr_round_trip_is_exact(tmp_path):
    random = np.random.default_rng(1)
    for channels in (1, 3, 4):
        picture = (random.random((5, 7, channels)) * 1e4).astype(np.float32)
        write_exr(tmp_path / "a.exr", picture)
        np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), picture)


def test_png_round_trip_is_exact(tmp_path):
    picture = np.random.default_rng(2).integers(0, 256, (5, 7, 4)).astype(np.uint8)
    write_png(tmp_path / "a.png", picture)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), picture)


def directions(u, v):
    """The project's lat-long convention."""
    phi, theta = (u - 0.5) * 2.0 * np.pi, v * np.pi
    return np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1)


def test_openexr_latlong_becomes_ours(tmp_path):
    """Radiance 1 + d/2 at every direction d, written as OpenEXR's convention says, is read as ours says."""
    height, width = 128, 256
    row, column = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    longitude = np.pi - 2.0 * np.pi * column / (width - 1)  # atan2(x, z)
    latitude = np.pi / 2.0 - np.pi * row / (height - 1)
    seen = np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), np.cos(latitude) * np.cos(longitude)], -1)
    picture = (1.0 + 0.5 * seen).astype(np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, "envmap": OpenEXR.ENVMAP_LATLONG}
    with OpenEXR.File(header, {"RGB": picture}) as file:
        file.write(str(tmp_path / "a.exr"))
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    # linear interpolation errs by step²/8 of the second derivative: (2π/255)²/8·0.5 < 1e-4
    np.testing.assert_allclose(read_environment(tmp_path / "a.exr"), 1.0 + 0.5 * directions(u, v), atol=1e-4)


def test_constant_environment_stays_constant():
    picture = np.full((16, 32, 3), 3.7, np.float32)
    np.testing.assert_array_equal(latlong_from_openexr(picture).texels[0], picture)  # weights add up to 1


def test_plain_files_are_taken_as_they_are(tmp_path):
    picture = np.random.default_rng(3).random((4, 8, 3)).astype(np.float32)
    write_exr(tmp_path / "a.exr", picture)
    np.testing.assert_array_equal(read_environment(tmp_path / "a.exr"), picture)


@pytest.mark.parametrize(
    ("value", "sentence"), [(np.nan, "not finite"), (np.inf, "not finite"), (-0.5, "negative radiance")]
)
def test_impossible_radiance_is_refused(tmp_path, value, sentence):
    picture = np.ones((4, 8, 3), np.float32)
    picture[1, 2, 0] = value
    write_exr(tmp_path / "a.exr", picture)
    with pytest.raises(RefletError, match=sentence):
        read_environment(tmp_path / "a.exr")


def test_other_files_are_refused(tmp_path, capfd):
    write_exr(tmp_path / "square.exr", np.ones((8, 8, 3), np.float32))
    (tmp_path / "damaged.exr").write_bytes((tmp_path / "square.exr").read_bytes()[:300])
    (tmp_path / "a.jpg").write_bytes(b"")
    refusals = {"square.exr": "twice as wide", "damaged.exr": "not a readable OpenEXR", "a.jpg": "lat-long",
                "none.hdr": "cannot be read", "none.exr": "does not exist"}  # fmt: skip
    for name, sentence in refusals.items():
        with pytest.raises(RefletError, match=sentence):
            read_environment(tmp_path / name)
    assert capfd.readouterr().err == ""  # the sentence is all that is said


@pytest.mark.skipif(not (SHARED / "two_param").exists(), reason="needs the shared data")
def test_openexr_latlong_agrees_with_the_cube_of_the_same_capture():
    """The cube's faces as OpenEXR lays them out: log radiance correlates as the data's notes say (0.996)."""
    cube = read_exr(SHARED / "two_param" / "KernerEnvCube.exr")[..., :3].reshape(6, 256, 256, 3)
    latlong = read_environment(SHARED / "two_param" / "KernerEnvLatLong.exr")
    t, s = np.meshgrid(np.linspace(-1, 1, 256)[4::16], np.linspace(-1, 1, 256)[4::16], indexing="ij")
    one = np.ones_like(s)
    faces = [(one, -t, s), (-one, -t, -s), (s, one, -t), (s, -one, t), (-s, -t, one), (s, -t, -one)]
    for face, (x, y, z) in enumerate(faces):
        u, v = 0.5 + np.arctan2(z, x) / (2 * np.pi), np.arccos(y / np.sqrt(x * x + y * y + z * z)) / np.pi
        ours = latlong[(v * 512).astype(int) % 512, (u * 1024).astype(int) % 1024]
        theirs = cube[face, 4::16, 4::16]
        # two resamplings of one capture, compared at single texels: 0.9 is far above what any mirrored axis gives
        assert np.corrcoef(np.log(ours + 1e-3).ravel(), np.log(theirs + 1e-3).ravel())[0, 1] > 0.9
