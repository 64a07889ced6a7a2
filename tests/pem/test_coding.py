"""Maps coded small: they come back as close as was asked, and no file is taken for what it is not."""

import re
import struct
from dataclasses import replace

import numpy as np
import pytest
from coded_light import light
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from small_pem import small_pem

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.pem.coding.atlas import Atlas
from reflet.pem.coding.boxes import announced_shapes, own_box, with_own_box
from reflet.pem.coding.coded_light import QUALITY, decode_light
from reflet.pem.coding.coded_map import (
    check_codable,
    environment_fits,
    read_coded_environment,
    read_coded_map,
    write_coded_environment,
    write_coded_map,
)
from reflet.pem.coding.colour import rgb_from_ycc, ycc_from_rgb
from reflet.pem.coding.transfer import gains, join_radiance, split_radiance
from reflet.pem.container import open_pem, save_pem

LOSSLESS = 100
ROUNDING = 1.6 * 2.4 / 255  # see below


def display(radiance):
    """As CONVENTIONS.md shows it, 0 to 1."""
    linear = 1.0 - np.exp(-1.6 * np.maximum(radiance, 0.0))
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def there_and_back(tmp_path, chain, texels, quality=QUALITY):
    write_coded_map(tmp_path / "map.avif", chain, texels, quality)
    return read_coded_map(tmp_path / "map.avif", chain, texels.shape[1])


@pytest.mark.parametrize("size", [1, 2, 4, 8, 64])
@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_an_atlas_holds_every_texel_once(name, size):
    chain = MipChain(size, PARAMETERIZATIONS[name])
    numbers = np.arange(chain.texel_count)
    planes = np.stack([numbers & 255, numbers >> 8 & 255, numbers >> 16]).astype(np.uint8)
    pictures = Atlas(chain).lay_out(planes)
    assert pictures.shape == (3, *Atlas(chain).shape)
    np.testing.assert_array_equal(Atlas(chain).gather(pictures), planes)


def test_faces_and_levels_lie_where_the_format_says():
    """Level 0 of a cube in two rows of three faces, the next beside it."""
    chain = MipChain(4)
    faces = np.concatenate([np.repeat(np.arange(6) + 10 * level, size**2) for level, size in enumerate((4, 2, 1))])
    (picture,) = Atlas(chain).lay_out(faces[None].astype(np.uint8))
    assert picture.shape == (8, 18)
    np.testing.assert_array_equal(picture[::4, :12:4], [[0, 1, 2], [3, 4, 5]])
    np.testing.assert_array_equal(picture[:4:2, 12:18:2], [[10, 11, 12], [13, 14, 15]])
    np.testing.assert_array_equal(picture[4:6, 12:15], [[20, 21, 22], [23, 24, 25]])


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("size", [1, 2, 4, 16])
@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_every_kind_of_map_comes_back(tmp_path, name, size, channels):
    """Without loss in the picture, what is left is rounding to codes: half of one of luma and one of chroma, where
    it is clamped, weighted by at most 1.86: 2.4 of 255. Display values grow up to 1.6 times as fast, in the dark."""
    chain = MipChain(size, PARAMETERIZATIONS[name])
    texels = light(chain, channels)
    back = there_and_back(tmp_path, chain, texels, LOSSLESS)
    np.testing.assert_allclose(display(back[:, :3]), display(texels[:, :3]), atol=ROUNDING)
    np.testing.assert_allclose(back[:, 3:], texels[:, 3:], atol=0.5 / 255 + 2**-11)  # and of half floats
    assert back[:, :3].max() == np.float16(texels[:, :3].max())


@pytest.mark.parametrize("channels", [3, 4])
def test_the_default_quality_is_close(tmp_path, channels):
    """40 dB of display values over all levels: the sun's neighbours and the sharp alpha of this map are the worst there
    is, and the picture that AV1 takes of so small a map is mostly edges."""
    chain = MipChain(64)
    texels = light(chain, channels)
    back = there_and_back(tmp_path, chain, texels)
    error = display(back[:, :3]) - display(texels[:, :3])
    assert -10.0 * np.log10(np.mean(error**2)) > 40.0
    assert np.abs(back[:, 3:] - texels[:, 3:]).max(initial=0.0) < 0.05
    assert (tmp_path / "map.avif").stat().st_size < 0.12 * 8 * chain.texel_count


@pytest.mark.parametrize(
    "colour", [(3.25, 2.0, 0.625, 1.0), (0.5, 0.25, 0.125, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 9.0, 0.0, 1.0)]
)
@pytest.mark.parametrize(
    ("name", "size"), [("cube", 1), ("cube", 16), ("cube", 128), ("gazing_ball", 64), ("latlong", 4)]
)
def test_a_constant_map_is_exact(tmp_path, name, size, colour):
    """White furnace: each channel's largest value is code 255, and flat pictures lose nothing."""
    chain = MipChain(size, PARAMETERIZATIONS[name])
    for channels in (3, 4):
        texels = np.tile(np.float32(colour[:channels]), (chain.texel_count, 1))
        np.testing.assert_array_equal(there_and_back(tmp_path, chain, texels), texels)


def test_the_brightest_texels_are_exact(tmp_path):
    """A sun of 4e4 in a sky below 1, in every level: as a code it would be off by tens of percent."""
    chain = MipChain(64)
    texels = light(chain, 3)
    back = there_and_back(tmp_path, chain, texels, 60)
    sun = texels[:, 0] == np.float32(4e4)
    assert sun.sum() == chain.level_count
    np.testing.assert_array_equal(back[sun], texels[sun].astype(np.float16))


def test_no_colour_is_nothing_and_nothing_is_no_colour(tmp_path):
    """Where alpha is 0, radiance, premultiplied, is 0 too: it must not add light."""
    chain = MipChain(64)
    texels = light(chain, 4, sun=3.0)
    back = there_and_back(tmp_path, chain, texels)
    through = texels[:, 3] == 0.0
    assert 0.2 < through.mean() < 0.8
    assert np.abs(back[through]).mean() < 1e-3  # but for a few beside edges


def test_what_cannot_be_held_is_clamped(tmp_path):
    chain = MipChain(4)
    texels = np.full((chain.texel_count, 4), 0.5, np.float32)
    texels[7] = -1.0, 1e9, np.inf, 2.0
    texels[-1] = 1e3, -1.0, 0.5, -1.0
    back = there_and_back(tmp_path, chain, texels)
    np.testing.assert_array_equal(back[7], (0.0, 65504.0, 65504.0, back[7, 3]))
    assert back[7, 3] > 0.95
    np.testing.assert_array_equal(back[-1], (1e3, 0.0, 0.5, 0.0))
    with pytest.raises(RefletError, match="not numbers; nothing was written"):
        write_coded_map(tmp_path / "nan.avif", chain, texels * np.nan)
    assert not (tmp_path / "nan.avif").exists()


@given(st.lists(st.floats(0.0, 65504.0, width=16), min_size=3, max_size=3))
def test_any_colour_comes_back_from_its_codes(colour):
    """Beside a texel that is four times as bright: its channels' codes are off by half of one each, of which the
    largest of the sums takes 1/2 + 1.86/2."""
    wanted = np.float32(colour)
    most = 4.0 * wanted.clip(2.0**-12, 16000.0).astype(np.float32)
    radiance = np.stack([np.minimum(wanted, most), most], axis=1)
    b, gain = split_radiance(radiance, most)
    assert b.min() >= 0.0 and b.max() <= 1.0
    back = join_radiance(rgb_from_ycc(ycc_from_rgb(b)), gain, most)
    white = most / max(most.max(), 1.0)
    share = back[:, 0] / (white * gains(most)[gain[0]])
    codes = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(codes, b[:, 0], atol=1.5 / 255)
    np.testing.assert_allclose(back[:, 1], most, rtol=1e-5)


def test_grey_has_no_colour():
    """The matrix: greys have neutral chroma and come back as they were, primaries have what BT.709 says."""
    greys = np.linspace(0.0, 1.0, 256, dtype=np.float32)
    ycc = ycc_from_rgb(np.tile(greys, (3, 1)))
    np.testing.assert_array_equal(ycc, [np.arange(256), np.full(256, 128), np.full(256, 128)])
    np.testing.assert_array_equal(rgb_from_ycc(ycc), np.tile(16 * np.arange(256), (3, 1)))
    np.testing.assert_array_equal(
        ycc_from_rgb(np.eye(3, dtype=np.float32)).T, [[54, 99, 255], [182, 30, 12], [18, 255, 116]]
    )


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_environments_of_any_size_come_back(tmp_path_factory, rows, columns, seed):
    radiance = np.random.default_rng(seed).exponential(0.5, (rows, columns, 3)).astype(np.float32)
    path = tmp_path_factory.mktemp("sky") / "sky.avif"
    write_coded_environment(path, radiance, LOSSLESS)
    back = read_coded_environment(path, rows, columns)
    np.testing.assert_allclose(display(back), display(radiance), atol=ROUNDING)
    with pytest.raises(RefletError, match="is not the coded picture"):
        read_coded_environment(path, rows + 1, columns)


def test_equal_maps_give_equal_files(tmp_path):
    chain = MipChain(32)
    for name in ("a", "b"):
        write_coded_map(tmp_path / name, chain, light(chain, 4))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_other_programs_open_the_picture(tmp_path):
    """The box of ours is none of theirs."""
    chain = MipChain(16)
    write_coded_map(tmp_path / "map.avif", chain, light(chain, 4))
    rows, columns = Atlas(chain).shape
    with Image.open(tmp_path / "map.avif") as picture:
        assert (picture.mode, picture.size) == ("L", (columns, 5 * rows))


@pytest.fixture(scope="module")
def coded(tmp_path_factory):
    """(a file of the smallest map with a picture, its chain)."""
    path = tmp_path_factory.mktemp("coded") / "map.avif"
    write_coded_map(path, MipChain(4), light(MipChain(4), 4))
    return path, path.read_bytes(), MipChain(4)


def refused(coded, file):
    path, _, chain = coded
    path.write_bytes(file)
    with pytest.raises(RefletError, match=r"is not the coded cube of 4 rows with 4 channels .* bake again\.$"):
        read_coded_map(path, chain, 4)


def test_a_file_cut_short_anywhere_is_one_sentence(coded):
    _, file, chain = coded
    refused(coded, file[:-1])
    for length in range(len(file)):
        with pytest.raises(ValueError, match=r".+"):
            decode_light(file[:length], Atlas(chain), chain.texel_count, 4, chain.offsets[1])


def test_garbage_is_one_sentence_or_a_map(coded):
    """Of numbers that no reader can check a map may come of the right size; nothing else happens."""
    path, file, chain = coded
    random = np.random.default_rng(5)
    for _ in range(300):
        damaged = bytearray(file)
        for at in random.integers(0, len(file), random.integers(1, 4)):
            damaged[at] = random.integers(0, 256)
        path.write_bytes(damaged)
        try:
            assert read_coded_map(path, chain, 4).shape == (chain.texel_count, 4)
        except RefletError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: b"",
        lambda file: b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80),
        lambda file: re.sub(rb"ispe.{12}", b"ispe" + bytes(4) + struct.pack(">II", 65536, 65536), file, flags=re.S),
        lambda file: file.replace(b"mdat\x12\x00\x0a", b"mdat\x12\x00\x12"),  # no sequence header
        lambda file: file[: -len(own_box(file)) - 24],
        lambda file: with_own_box(file[: -len(own_box(file)) - 24], own_box(file) + b"\0\0"),
        lambda file: with_own_box(file[: -len(own_box(file)) - 24], b"\0\0\xc0\x7f" + own_box(file)[4:]),  # NaN
        lambda file: with_own_box(file[: -len(own_box(file)) - 24], b"\0\0\0\xbf" + own_box(file)[4:]),
        lambda file: with_own_box(
            file[: -len(own_box(file)) - 24], own_box(file)[:16] + b"\xff" * 4 + own_box(file)[20:]
        ),
    ],
)
def test_what_is_not_such_a_map_is_one_sentence(coded, damage):
    refused(coded, damage(coded[1]))


def test_huge_pictures_are_refused_before_they_are_decoded(coded):
    """An AV1 picture of 65536² in a file that announces a small one would take 4 GiB."""
    file = coded[1]
    [shape] = announced_shapes(file)
    assert shape == (40, 18)
    at = file.index(b"mdat") + 8  # past the delimiter: a sequence header's contents begin
    bits = f"{int.from_bytes(file[at : at + file[at - 1]], 'big'):0{8 * file[at - 1]}b}"
    huge = bits[:10] + "1111" + "1111" + "1" * 32
    huge += bits[18 + int(bits[10:14], 2) + 1 + int(bits[14:18], 2) + 1 :]
    huge = huge.ljust(-8 * (-len(huge) // 8), "0")
    header = int(huge, 2).to_bytes(len(huge) // 8, "big")
    box = file.index(b"mdat") - 4
    size = struct.unpack_from(">I", file, box)[0] + len(header) - file[at - 1]
    damaged = struct.pack(">I", size) + b"mdat\x12\x00\x0a" + bytes([len(header)]) + header + file[at + file[at - 1] :]
    assert announced_shapes(file[:box] + damaged) == {shape, (65536, 65536)}
    refused(coded, file[:box] + damaged)


def test_a_missing_file_is_one_sentence(tmp_path):
    with pytest.raises(RefletError, match="does not exist"):
        read_coded_map(tmp_path / "map.avif", MipChain(4), 3)


def test_what_is_too_large_is_said_before_anything_is_written(tmp_path):
    check_codable(MipChain(2048))
    with pytest.raises(RefletError, match=r"4096 rows are too large to be coded .* --codec none"):
        check_codable(MipChain(4096))
    assert environment_fits(4096, 8192) and not environment_fits(8192, 16384)


def test_a_pem_is_small_by_default_and_plain_by_choice(tmp_path):
    """Coded and decoded: maps of sharp alpha are off by a tenth at the most, beside its edges."""
    pem = small_pem(shells=2, size=64)
    save_pem(tmp_path / "small", pem)
    small = open_pem(tmp_path / "small")
    save_pem(tmp_path / "plain", small, codec="none")
    plain = open_pem(tmp_path / "plain")
    maps = {
        name: sorted(path.suffix for path in (tmp_path / name / "maps").rglob("*.*2*")) for name in ("small", "plain")
    }
    assert set(maps["plain"]) == {".ktx2"} and maps["small"] == []
    assert (tmp_path / "small/environment.avif").exists() and (tmp_path / "plain/environment.bin").exists()
    for coded_map, plain_map, given_map in zip(small.base, plain.base, pem.base, strict=True):
        np.testing.assert_array_equal(coded_map.texels, plain_map.texels)
        np.testing.assert_allclose(coded_map.texels, given_map.texels, atol=0.1)
    np.testing.assert_array_equal(small.scene.environment.radiance, plain.scene.environment.radiance)
    with pytest.raises(RefletError, match="no codec bc6h"):
        save_pem(tmp_path / "other", replace(pem, base=()), codec="bc6h")
    assert not (tmp_path / "other").exists()
