"""DDS textures: written with DirectX 10's header, read with it and with the older codes."""

import struct

import numpy as np
import pytest
from textures import assert_same, random_texture

from reflet.errors import RefletError
from reflet.files.textures.dds import DXGI_FORMATS, read_dds_texture, write_dds_texture
from reflet.files.textures.texel_formats import TEXEL_FORMATS

WRITABLE = sorted(name for name in DXGI_FORMATS.values() if TEXEL_FORMATS[name].is_writable)


@pytest.mark.parametrize("name", WRITABLE)
def test_round_trip(tmp_path, name):
    for k, shape in enumerate(((5, 7, 3), (1, 1, 1), (6, 12, 1))):
        written = random_texture(name, *shape, seed=k, layers=1 + k)
        write_dds_texture(tmp_path / "a.dds", written)
        assert_same(read_dds_texture(tmp_path / "a.dds"), written)
    written = random_texture(name, 9, 9, 4, is_cube=True, alpha_is_premultiplied=True)
    write_dds_texture(tmp_path / "a.dds", written)
    read = read_dds_texture(tmp_path / "a.dds")
    assert_same(read, written)
    assert read.alpha_is_premultiplied


@pytest.mark.parametrize(("dxgi", "name"), sorted(DXGI_FORMATS.items()))
def test_every_format_is_read(tmp_path, dxgi, name):
    texture = random_texture(name, 4, 4, 2, is_cube=True)
    head = b"DDS " + struct.pack("<7I", 124, 0x1007, 4, 4, 0, 0, 2) + bytes(44)
    head += struct.pack("<8I", 32, 4, int.from_bytes(b"DX10", "little"), 0, 0, 0, 0, 0)
    head += struct.pack("<5I", 0x1000, 0xFE00, 0, 0, 0) + struct.pack("<5I", dxgi, 3, 4, 1, 0)
    pictures = [level[face].tobytes() for face in range(6) for level in texture.levels]
    (tmp_path / "a.dds").write_bytes(head + b"".join(pictures))
    read = read_dds_texture(tmp_path / "a.dds")
    assert_same(read, texture)
    np.testing.assert_array_equal(read.decode(1), texture.decode(1))


def test_bytes_are_where_the_format_says(tmp_path):
    texture = random_texture("rgba16f", 4, 4, 3, is_cube=True)
    write_dds_texture(tmp_path / "a.dds", texture)
    data = (tmp_path / "a.dds").read_bytes()
    assert data[:4] == b"DDS "
    size, flags, height, width, pitch, _, levels = struct.unpack_from("<7I", data, 4)
    assert (size, height, width, pitch, levels) == (124, 4, 4, 32, 3)
    assert flags & 0x1007 == 0x1007  # caps, height, width, pixel format
    assert struct.unpack_from("<2I", data, 76) == (32, 4)
    assert data[84:88] == b"DX10"
    caps, faces = struct.unpack_from("<2I", data, 108)
    assert caps == 0x401008  # texture, complex, mip-mapped
    assert faces == 0xFE00  # a cube with all faces
    # R16G16B16A16_FLOAT, 2D, cube, one of it, alpha unknown
    assert struct.unpack_from("<5I", data, 128) == (10, 3, 4, 1, 0)
    # each face with all its levels: 16 + 4 + 1 texels of 8 bytes; face +Y, level 1, row 1, column 0
    at = 148 + 2 * 21 * 8 + 16 * 8 + 2 * 8
    np.testing.assert_array_equal(np.frombuffer(data, "<f2", 4, at), texture.decode(1)[2, 1, 0])
    assert len(data) == 148 + 6 * 21 * 8


def legacy(code=0, bits=0, masks=(0, 0, 0, 0), kind=4, faces=0, shape=(4, 4), depth=0, levels=0):
    head = b"DDS " + struct.pack("<7I", 124, 0x1007, *shape, 0, depth, levels) + bytes(44)
    return head + struct.pack("<8I", 32, kind, code, bits, *masks) + struct.pack("<5I", 0x1000, faces, 0, 0, 0)


def dx10(dxgi=10, flags=0, layers=1, faces=0, levels=0, dimension=3, shape=(4, 4)):
    head = legacy(int.from_bytes(b"DX10", "little"), faces=faces, levels=levels, shape=shape)
    return head + struct.pack("<5I", dxgi, dimension, flags, layers, 0)


def texels(texture):
    return b"".join(level[image].tobytes() for image in range(texture.image_count) for level in texture.levels)


BGRA = (0xFF0000, 0xFF00, 0xFF, 0xFF000000)


@pytest.mark.parametrize(
    ("head", "name"),
    [
        (legacy(111), "r16f"),
        (legacy(113), "rgba16f"),
        (legacy(114), "r32f"),
        (legacy(116), "rgba32f"),
        (legacy(int.from_bytes(b"DXT1", "little")), "bc1_srgb"),
        (legacy(int.from_bytes(b"DXT5", "little")), "bc3_srgb"),
        (legacy(0, 32, BGRA, kind=0x41), "bgra8_srgb"),
        (legacy(0, 32, BGRA, kind=0x40), "bgrx8_srgb"),  # alpha's mask without the flag means nothing
        (legacy(0, 24, (*BGRA[:3], 0), kind=0x40), "bgr8_srgb"),
        (legacy(36), "rgba16"),
        (legacy(int.from_bytes(b"DXT3", "little")), "bc2_srgb"),
        (legacy(int.from_bytes(b"DXT4", "little")), "bc3_srgb"),
        (legacy(0, 32, (0xFF, 0xFF00, 0xFF0000, 0), kind=0x40), "rgbx8_srgb"),
        (legacy(0, 24, (0xFF, 0xFF00, 0xFF0000, 0), kind=0x40), "rgb8_srgb"),
        (legacy(0, 8, (0xFF, 0, 0, 0), kind=0x20000), "r8_srgb"),
        (legacy(113, faces=0x200000, depth=1), "rgba16f"),  # a volume of one slice
    ],
)
def test_the_older_header(tmp_path, head, name):
    texture = random_texture(name, 4, 4)
    (tmp_path / "a.dds").write_bytes(head + texture.levels[0].tobytes())
    assert_same(read_dds_texture(tmp_path / "a.dds"), texture)


@pytest.mark.parametrize(
    ("head", "doubt"),
    [
        (dx10(flags=4, faces=0xFE00, levels=2), None),
        (dx10(flags=4, levels=2), None),  # marked in one header only
        (dx10(faces=0xFE00, levels=2), None),
        (dx10(flags=4, layers=0, levels=2), None),
        (dx10(flags=4, dimension=0, levels=2), None),
        (dx10(faces=0x200, levels=2), None),  # no face named
        (dx10(faces=0x600, levels=2), None),  # one face named; by the size there are six
        (legacy(113, faces=0x200, levels=2), None),
        (
            dx10(flags=4, layers=6, levels=2),
            "36 pictures of 2 mip levels, but by its size it is a cube of 2 mip levels",
        ),
        (dx10(flags=4, faces=0xFE00, layers=6, levels=2), "36 pictures of 2 mip levels, but by its size it is a cube"),
        (dx10(levels=2), "1 picture of 2 mip levels, but by its size it is a cube of 2 mip levels"),
        (dx10(flags=4, levels=77, shape=(2, 2)), "77 mip levels, but by its size it is a cube of 2 mip levels"),
        (dx10(flags=4, levels=0, shape=(2, 2)), "1 mip level, but by its size it is a cube of 2 mip levels"),
    ],
)
def test_a_cube_is_one_whatever_says_so(tmp_path, head, doubt):
    """Directly behind each other lie a face's levels: a wrong count of them would shear all faces but the first."""
    size = struct.unpack_from("<I", head, 12)[0]
    texture = random_texture("rgba16f", size, size, 2, is_cube=True)
    (tmp_path / "a.dds").write_bytes(head + texels(texture))
    read = read_dds_texture(tmp_path / "a.dds")
    assert_same(read, texture)
    assert [said.partition(" declares ")[2].startswith(doubt or "") for said in read.doubts] == [True] * bool(doubt)


def test_one_level_where_the_header_says_several(tmp_path):
    texture = random_texture("rgba16f", 4, 8)
    (tmp_path / "a.dds").write_bytes(legacy(113, levels=3, shape=(4, 8)) + texels(texture))
    read = read_dds_texture(tmp_path / "a.dds")
    assert_same(read, texture)
    assert ["3 mip levels, but by its size it is 1 picture of 1 mip level," in said for said in read.doubts] == [True]


def test_the_first_of_several_cubes_is_read(tmp_path):
    texture = random_texture("rgba16f", 4, 4, 3, layers=12)
    (tmp_path / "a.dds").write_bytes(dx10(flags=4, layers=2, levels=3) + texels(texture))
    read = read_dds_texture(tmp_path / "a.dds")
    assert read.is_cube
    for ours, theirs in zip(read.levels, texture.levels, strict=True):
        np.testing.assert_array_equal(ours, theirs[:6])
    assert read.doubts == (f"{tmp_path / 'a.dds'} holds 2 cubes; the first is read.",)


@pytest.mark.parametrize(("dxgi", "name"), [(1, "rgba32f"), (9, "rgba16f"), (94, "bc6h"), (97, "bc7"), (27, "rgba8")])
def test_formats_without_a_type(tmp_path, dxgi, name):
    texture = random_texture(name, 4, 4)
    (tmp_path / "a.dds").write_bytes(dx10(dxgi) + texels(texture))
    assert_same(read_dds_texture(tmp_path / "a.dds"), texture)


def test_an_older_cube(tmp_path):
    texture = random_texture("rgba16f", 4, 4, is_cube=True)
    (tmp_path / "a.dds").write_bytes(legacy(113, faces=0xFE00) + texture.levels[0].tobytes())
    assert_same(read_dds_texture(tmp_path / "a.dds"), texture)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "not a DDS file"),
        (b"DDS ", "truncated"),
        (legacy(113), "truncated"),
        (legacy(112) + bytes(999), "code 112"),
        (legacy(0, 16, (1, 2, 3, 0), kind=0x40) + bytes(999), "16 bits in an unusual order"),
        (legacy(113, faces=0x600) + bytes(9999), "only 1 of its six faces"),
        (legacy(113, faces=0xE00) + bytes(2 * 4 * 4 * 8), "only 2 of its six faces"),
        (legacy(113, faces=0x200000, depth=2) + bytes(9999), "neither a 2D texture"),
        (legacy(113, faces=0xFE00, shape=(4, 8)) + bytes(9999), "nor a whole cube"),
        (legacy(113, shape=(0, 4)) + bytes(999), "neither a 2D texture"),
        (legacy(113, shape=(1 << 31, 1 << 31)) + bytes(999), "truncated"),
        (legacy(int.from_bytes(b"DX10", "little")) + bytes(8), "truncated"),
        (legacy(int.from_bytes(b"DX10", "little")) + struct.pack("<5I", 63, 3, 0, 1, 0), "DXGI format 63"),
    ],
)
def test_others_are_one_sentence(tmp_path, data, said):
    (tmp_path / "a.dds").write_bytes(data)
    with pytest.raises(RefletError, match=said):
        read_dds_texture(tmp_path / "a.dds")


def test_formats_that_dds_does_not_know(tmp_path):
    with pytest.raises(RefletError, match="cannot hold texels stored as rgb16f"):
        write_dds_texture(tmp_path / "a.dds", random_texture("rgb16f", 2, 2))
