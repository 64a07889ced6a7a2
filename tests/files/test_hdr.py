import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflet.errors import RefletError
from reflet.files.pictures.hdr import read_hdr, read_hdr_with_doubts, write_hdr
from reflet.files.pictures.notes import read_notes

RGBE = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"
XYZE = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n"


def radiance(rgbe):
    """Mantissa times a power of two: exact in float32."""
    return (rgbe[..., :3] * 2.0 ** (rgbe[..., 3:].astype(float) - 136.0)).astype(np.float32)


def new_runs(line):
    """One scanline of the new form: runs where four equal bytes follow one another, else literals of at most three."""
    out = bytes([2, 2, len(line) >> 8, len(line) & 255])
    for channel in line.T:
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


def old_runs(line):
    """One scanline of the old form: (1, 1, 1, n) repeats a pixel, each further one counts 256 times as much."""
    out, at = b"", 0
    while at < len(line):
        run = 1
        while at + run < len(line) and (line[at + run] == line[at]).all():
            run += 1
        out += bytes(line[at])
        repeats = run - 1
        while repeats:
            out += bytes([1, 1, 1, repeats % 256])
            repeats //= 256
        at += run
    return out


def flat(line):
    return line.tobytes()


def write(path, lines, encode, header=RGBE, size=None):
    """A file of ``lines``, (count, length, 4) in the file's own order."""
    size = size or b"-Y %d +X %d\n" % lines.shape[:2]
    path.write_bytes(header + b"\n" + size + b"".join(encode(line) for line in lines))
    return path


def picture(height, width, seed=0):
    random = np.random.default_rng(seed)
    out = random.integers(2, 256, (height, width, 4)).astype(np.uint8)
    out[..., 3] = random.integers(120, 140, (height, width))
    out[height // 3 : height // 2, width // 5 : width - 1] = (10, 200, 30, 129)  # something to run over
    return out


@pytest.mark.parametrize(
    ("encode", "width"),
    # below 8 and above 32767 there is no new form
    [(new_runs, 8), (new_runs, 300), (new_runs, 32767), (old_runs, 3), (old_runs, 300), (old_runs, 70000), (flat, 1),
     (flat, 7), (flat, 300), (flat, 32768)],
)  # fmt: skip
def test_every_run_length_form_and_width(tmp_path, encode, width):
    rgbe = picture(3, width)
    np.testing.assert_array_equal(read_hdr(write(tmp_path / "a.hdr", rgbe, encode)), radiance(rgbe))


def test_runs_longer_than_a_byte_can_count(tmp_path):
    rgbe = np.broadcast_to(np.uint8([9, 8, 7, 130]), (2, 70000, 4))
    body = bytes([9, 8, 7, 130, 1, 1, 1, 111, 1, 1, 1, 17, 1, 1, 1, 1])  # 1 + 111 + 256·17 + 65536
    path = write(tmp_path / "a.hdr", rgbe, lambda _: body)
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe))


@pytest.mark.parametrize("first", [b"-Y", b"+Y", b"-X", b"+X"])
@pytest.mark.parametrize("second", [b"-", b"+"])
def test_all_eight_orientations_show_the_same_picture(tmp_path, first, second):
    """The sign says whether the coordinate falls or grows along the file; y grows upwards, x to the right."""
    rgbe = picture(5, 9)
    lines = rgbe
    if first[1:] == b"Y":
        size = b"%b 5 %bX 9\n" % (first, second)
        lines = lines[::-1] if first == b"+Y" else lines
        lines = lines[:, ::-1] if second == b"-" else lines
    else:
        size = b"%b 9 %bY 5\n" % (first, second)
        lines = lines[:, ::-1] if first == b"-X" else lines
        lines = lines[::-1] if second == b"+" else lines
        lines = lines.transpose(1, 0, 2)
    path = write(tmp_path / "a.hdr", np.ascontiguousarray(lines), flat, size=size)
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe))


def test_exposures_and_colour_corrections_multiply_and_are_divided_out(tmp_path):
    header = RGBE + b"EXPOSURE=4\n# a comment\nEXPOSURE= 0.5\r\nCOLORCORR= 2 1 4\nVIEW= -vtv -vp 0 0 0\n"
    rgbe = picture(4, 8)
    path = write(tmp_path / "a.hdr", rgbe, new_runs, header)
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe) / np.float32([4, 2, 8]))  # powers of two: exact


@pytest.mark.parametrize(
    "header",
    [b"#?RGBE\n", b"#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\n\r", b"#?RADIANCE\n# made by hand\nGAMMA=1\n",
     b"#?rpict -vf a.vf\n\tFORMAT= 32-bit_rle_rgbe \nPIXASPECT=1\n", b"FORMAT=32-bit_rle_rgbe\n"],
)  # fmt: skip
def test_headers_in_use(tmp_path, header):
    rgbe = picture(4, 8)
    np.testing.assert_array_equal(read_hdr(write(tmp_path / "a.hdr", rgbe, new_runs, header)), radiance(rgbe))


def test_a_header_without_its_blank_line(tmp_path):
    rgbe = picture(4, 8)
    path = tmp_path / "a.hdr"
    path.write_bytes(RGBE + b"-Y 4 +X 8\n" + b"".join(new_runs(line) for line in rgbe))
    np.testing.assert_array_equal(read_hdr(path), radiance(rgbe))
    assert read_notes(path) == {"format": "32-bit_rle_rgbe"}


@pytest.mark.parametrize(
    ("line", "divisor"),
    [(b"EXPOSURE=0", 1), (b"EXPOSURE= 0.0\nEXPOSURE=4", 4), (b"EXPOSURE=-2", 1), (b"EXPOSURE=nan", 1),
     (b"EXPOSURE=inf", 1), (b"EXPOSURE=much", 1), (b"EXPOSURE=1e-300\nEXPOSURE=2", 2), (b"COLORCORR=1 2", 1),
     (b"COLORCORR=1 0 1", 1), (b"PRIMARIES=0.3 0.3", 1), (b"PRIMARIES=1 1 1 1 1 1 1 1", 1), (b"GAMMA=2.2", 1)],
)  # fmt: skip
def test_lines_that_cannot_be_meant_are_ignored_and_said(tmp_path, line, divisor):
    """Some tools write EXPOSURE=0 for none: the pixels are as they are."""
    rgbe = picture(4, 8)
    path = write(tmp_path / "a.hdr", rgbe, new_runs, RGBE + line + b"\n")
    image, doubts = read_hdr_with_doubts(path)
    np.testing.assert_array_equal(image, radiance(rgbe) / divisor)  # a power of two: exact
    assert [line.partition(b"\n")[0].decode() in doubt for doubt in doubts] == [True]
    assert read_hdr_with_doubts(write(path, rgbe, new_runs, RGBE + b"EXPOSURE=2\nGAMMA=1\n"))[1] == ()


def test_xyze_is_luminance_over_equal_energy_white(tmp_path):
    """White is white, and 179 units of luminance are one of radiance."""
    white = np.broadcast_to(np.uint8([179, 179, 179, 136]), (2, 8, 4))
    # rounding of float32
    np.testing.assert_allclose(read_hdr(write(tmp_path / "a.hdr", white, flat, XYZE)), 1.0, rtol=1e-6)
    grey = np.broadcast_to(np.uint8([179, 179, 179, 135]), (2, 8, 4))
    np.testing.assert_allclose(read_hdr(write(tmp_path / "b.hdr", grey, flat, XYZE)), 0.5, rtol=1e-6)


def test_primaries(tmp_path):
    """Photoshop's eight zeros mean nothing; Rec. 709 stays as it is; of a wide gamut white stays, green saturates."""
    rgbe = np.broadcast_to(np.uint8([0, 128, 0, 129]), (2, 8, 4)).copy()
    rgbe[:, 4:] = (128, 128, 128, 129)
    for primaries in (b"0 0 0 0 0 0 0 0", b"0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290"):
        path = write(tmp_path / "a.hdr", rgbe, flat, RGBE + b"PRIMARIES= " + primaries + b"\n")
        np.testing.assert_array_equal(read_hdr(path), radiance(rgbe))
    path = write(tmp_path / "b.hdr", rgbe, flat, RGBE + b"PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.329\n")
    # [ITU-R BT.2087]'s matrix has 4 digits: green becomes (-0.5876, 1.1329, -0.1006), cut at the gamut's border
    np.testing.assert_allclose(read_hdr(path)[0, 0], [0.0, 1.1329, 0.0], atol=1e-4)
    np.testing.assert_allclose(read_hdr(path)[0, 4], 1.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("header", "size", "sentence"),
    [
        (b"P6\n", b"-Y 4 +X 8\n", "not a Radiance"),
        (RGBE, b"-Y 4 +Y 8\n", "not a Radiance"),
        (RGBE, b"-Y 4 +X 8", "not a Radiance"),
        (RGBE, b"-Y 0 +X 8\n", "no pixels"),
        (RGBE, b"-Y 400 +X 8\n", "truncated"),
        (RGBE, b"-Y 999999999 +X 999999999\n", "more than can be read"),
        (RGBE, b"-Y " + b"9" * 5000 + b" +X 8\n", "not a Radiance"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_luv\n", b"-Y 4 +X 8\n", "32-bit_rle_luv"),
    ],
)
def test_what_is_no_picture_is_refused_in_a_sentence(tmp_path, header, size, sentence):
    path = write(tmp_path / "a.hdr", picture(4, 8), flat, header, size)
    with pytest.raises(RefletError, match=re.escape(sentence)):
        read_hdr(path)


@pytest.mark.parametrize("encode", [new_runs, old_runs, flat])
def test_truncation_at_every_byte_is_noticed(tmp_path, encode):
    whole = write(tmp_path / "a.hdr", picture(3, 9), encode).read_bytes()
    for length in range(len(whole)):
        (tmp_path / "a.hdr").write_bytes(whole[:length])
        with pytest.raises(RefletError):
            read_hdr(tmp_path / "a.hdr")


@pytest.mark.parametrize("width", [1, 7, 8, 128, 129, 1000, 32768])
def test_what_was_read_is_written_back_exactly(tmp_path, width):
    image = radiance(picture(4, width))
    image[0, 0] = 0.0
    write_hdr(tmp_path / "a.hdr", image)
    read = read_hdr(tmp_path / "a.hdr")
    # mantissas below 128, if all three are, are stored one exponent lower: nothing is lost
    np.testing.assert_array_equal(read, image)


def test_runs_make_files_small(tmp_path):
    image = np.full((16, 1270, 3), 0.5, np.float32)
    write_hdr(tmp_path / "a.hdr", image)
    scanlines = 16 * (4 + 4 * 2 * 10)  # ten runs of 127 for each channel
    assert len((tmp_path / "a.hdr").read_bytes()) < scanlines + 100


component = st.floats(0.0, 2.0**126, width=32)


@settings(max_examples=100)
@given(st.lists(st.tuples(component, component, component), min_size=1, max_size=60))
def test_writing_errs_by_half_a_mantissa_step(tmp_path_factory, colors):
    path = tmp_path_factory.mktemp("hdr") / "a.hdr"
    image = np.float32([colors])
    write_hdr(path, image)
    for before, after in zip(image[0].astype(float), read_hdr(path)[0].astype(float), strict=True):
        largest = before.max()
        # up to 2^e there are 256 steps, and those of the next exponent where the largest would round up to it
        step = 2.0 ** (math.frexp(largest)[1] - 8)
        if largest * 256.0 / 2.0 ** math.frexp(largest)[1] >= 255.5:
            step *= 2.0
        if largest < 2.0**-128:  # its exponent would be below the first
            assert not after.any()
        else:
            assert np.abs(after - before).max() <= 0.5 * step


@pytest.mark.parametrize(
    ("value", "sentence"),
    [(-1.0, "no radiance of -1"), (np.nan, "finite"), (np.inf, "finite"), (3e38, "no radiance of")],
)
def test_what_rgbe_cannot_hold_is_refused(tmp_path, value, sentence):
    image = np.ones((2, 3, 3), np.float32)
    image[1, 2, 1] = value
    with pytest.raises(RefletError, match=sentence):
        write_hdr(tmp_path / "a.hdr", image)
    assert not list(tmp_path.iterdir())
