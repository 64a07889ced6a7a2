"""KTX 1 textures: written as the format says, read in both byte orders, and as a peer writes them."""

import struct
from pathlib import Path

import numpy as np
import pytest
from textures import assert_same, random_texture

from reflet.errors import RefletError
from reflet.files.textures.ktx1 import read_ktx1_texture, write_ktx1_texture
from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture

PEER = Path(__file__).parents[3] / "shared/data/peers/cmgen_neutral"
WRITABLE = [name for name, form in TEXEL_FORMATS.items() if form.is_writable]


@pytest.mark.parametrize("name", WRITABLE)
def test_round_trip(tmp_path, name):
    """Odd widths too, whose rows are padded to 4 bytes."""
    for k, shape in enumerate(((5, 7, 3), (1, 1, 1), (6, 12, 1))):
        written = random_texture(name, *shape, seed=k, layers=1 + k, metadata={"sh": b"0.5 0.25\n", "b": b"\x01\x02"})
        write_ktx1_texture(tmp_path / "a.ktx", written)
        read = read_ktx1_texture(tmp_path / "a.ktx")
        assert_same(read, written)
        assert read.metadata == written.metadata
    written = random_texture(name, 9, 9, 4, is_cube=True)
    write_ktx1_texture(tmp_path / "a.ktx", written)
    assert_same(read_ktx1_texture(tmp_path / "a.ktx"), written)


def test_bytes_are_where_the_format_says(tmp_path):
    texture = random_texture("rgb16f", 3, 3, 2, is_cube=True, metadata={"KTXorientation": b"rd"})
    write_ktx1_texture(tmp_path / "a.ktx", texture)
    data = (tmp_path / "a.ktx").read_bytes()
    assert data[:12] == bytes.fromhex("AB4B5458203131BB0D0A1A0A")
    # endianness, GL_HALF_FLOAT, its size, GL_RGB, GL_RGB16F, GL_RGB, width, height, depth, layers, faces, levels, pairs
    assert struct.unpack_from("<13I", data, 12) == (0x04030201, 0x140B, 2, 0x1907, 0x881B, 0x1907, 3, 3, 0, 0, 6, 2, 28)
    assert data[64:92] == struct.pack("<I", 23) + b"KTXorientation\0S=r,T=d\0" + b"\0"
    # a face of 3 rows of 18 bytes and 2 of padding; the size is that of one face
    assert struct.unpack_from("<I", data, 92) == (60,)
    at = 96 + 2 * 60 + 20 + 6  # face +Y, row 1, column 1
    np.testing.assert_array_equal(np.frombuffer(data, "<f2", 3, at), texture.decode(0)[2, 1, 1])
    assert len(data) == 96 + 6 * 60 + 4 + 6 * 8


@pytest.mark.parametrize("name", ["rgb16f", "rgba32f", "r11g11b10f"])
def test_big_endian(tmp_path, name):
    """The same file with all its numbers turned around."""
    texture = random_texture(name, 2, 5, metadata={"sh": b"1 2"})
    write_ktx1_texture(tmp_path / "a.ktx", texture)
    data = (tmp_path / "a.ktx").read_bytes()
    word = texture.texel_format.word_bytes
    (pairs,) = struct.unpack_from("<I", data, 60)
    numbers = struct.unpack_from("<13I", data, 12) + struct.unpack_from("<I", data, 64)
    (size,) = struct.unpack_from("<I", data, 64 + pairs)
    texels = np.frombuffer(data[68 + pairs :], np.uint8).reshape(-1, word)[:, ::-1].tobytes()
    turned = data[:12] + struct.pack(">14I", *numbers) + data[68 : 64 + pairs] + struct.pack(">I", size) + texels
    (tmp_path / "b.ktx").write_bytes(turned)
    read = read_ktx1_texture(tmp_path / "b.ktx")
    assert_same(read, texture)
    assert read.metadata == texture.metadata


def compressed_file(tmp_path, texture, internal):
    head = struct.pack("<5I", 0x04030201, 0, 1, 0, internal)
    head += struct.pack("<8I", 0x1907, texture.columns, texture.rows, 0, 0, 6 if texture.is_cube else 1, 1, 0)
    level = texture.levels[0]
    size = level.shape[1] if texture.is_cube else level.size
    path = tmp_path / "a.ktx"
    path.write_bytes(b"\xabKTX 11\xbb\r\n\x1a\n" + head + struct.pack("<I", size) + level.tobytes())
    return path


@pytest.mark.parametrize(("internal", "name"), [(0x8E8F, "bc6h"), (0x8E8E, "bc6h_signed"), (0x8E8D, "bc7_srgb")])
def test_blocks(tmp_path, internal, name):
    texture = random_texture(name, 6, 6, is_cube=True)
    read = read_ktx1_texture(compressed_file(tmp_path, texture, internal))
    assert_same(read, texture)


@pytest.mark.parametrize(
    ("at", "value", "said"),
    [
        (0, 7, "not a KTX 1 file"),
        (12, 7, "truncated or damaged"),
        (16, 7, "type 0x7"),
        (28, 0x1234, None),  # the internal format of floats says nothing that type and format do not
        (36, 0, "0×4×0 texels"),
        (36, 5, "truncated or damaged"),
        (44, 2, "4×4×2 texels"),
        (48, 3, "truncated or damaged"),
        (52, 2, "2 faces"),
        (56, 9, "9 mip levels"),
        (60, 1 << 31, "truncated or damaged"),
    ],
)
def test_damaged_headers_are_one_sentence(tmp_path, at, value, said):
    texture = random_texture("rgba16f", 4, 4, metadata={"a": b"b"})
    write_ktx1_texture(tmp_path / "a.ktx", texture)
    data = bytearray((tmp_path / "a.ktx").read_bytes())
    struct.pack_into("<I", data, at, value)
    (tmp_path / "a.ktx").write_bytes(data)
    if said is None:
        assert_same(read_ktx1_texture(tmp_path / "a.ktx"), texture)
        return
    with pytest.raises(RefletError, match=said):
        read_ktx1_texture(tmp_path / "a.ktx")


def test_formats_without_a_writer_say_so(tmp_path):
    with pytest.raises(ValueError, match="only read"):
        write_ktx1_texture(tmp_path / "a.ktx", random_texture("bc6h", 4, 4))


needs_peer = pytest.mark.skipif(not PEER.exists(), reason="the peer's files are not here")


@needs_peer
def test_a_peers_prefiltered_cube():
    """R11G11B10F, 256² texels a face, 5 levels; spherical harmonics as text under the key "sh"."""
    texture = read_ktx1_texture(PEER / "neutral_ibl.ktx")
    assert (texture.texel_format.name, texture.rows, texture.is_cube) == ("r11g11b10f", 256, True)
    assert [level.shape for level in texture.levels] == [(6, 4 * (256 >> k) ** 2) for k in range(5)]
    harmonics = np.array(texture.metadata["sh"].split(), float)
    assert harmonics.shape == (27,)
    # levels are prefiltered, so that their means stay about the same; the faces' unequal angles leave some percent
    means = [texture.decode(k).mean() for k in range(5)]
    np.testing.assert_allclose(means, means[0], rtol=0.05)


@needs_peer
def test_a_peers_skybox_is_oriented_as_ours():
    """A lookup along a world direction finds what its source, lat-long by u = 1 + atan2(x, -z)/2π, shows there."""
    from reflet.envmap.parameterizations.cube import texel_directions
    from reflet.files.pictures.hdr import read_hdr

    texture = read_ktx1_texture(PEER / "neutral_skybox.ktx")
    assert isinstance(texture, Texture)
    cube = texture.decode(0)[:, 8::16, 8::16].mean(-1)
    source = read_hdr(PEER / "neutral.hdr").mean(-1)
    x, y, z = np.moveaxis(texel_directions(texture.rows)[:, 8::16, 8::16], -1, 0)
    u, v = np.mod(1.0 + np.arctan2(x, -z) / (2.0 * np.pi), 1.0), np.arccos(y) / np.pi
    height, width = source.shape
    seen = source[(v * height).astype(int), (u * width).astype(int)]
    right = np.corrcoef(np.log(cube.ravel()), np.log(seen.ravel()))[0, 1]
    mirrored = source[(v * height).astype(int), ((1.0 - u) * width).astype(int)]
    wrong = np.corrcoef(np.log(cube.ravel()), np.log(mirrored.ravel()))[0, 1]
    assert right > 0.97  # the skybox is blurred a little
    assert wrong < 0.9


def written(tmp_path, texture):
    write_ktx1_texture(tmp_path / "a.ktx", texture)
    return bytearray((tmp_path / "a.ktx").read_bytes())


def with_header(data, **numbers):
    at = {"type": 16, "format": 24, "internal": 28, "depth": 44, "layers": 48, "faces": 52, "levels": 56, "pairs": 60}
    for name, number in numbers.items():
        struct.pack_into("<I", data, at[name], number)
    return data


def reread(tmp_path, data):
    (tmp_path / "b.ktx").write_bytes(data)
    return read_ktx1_texture(tmp_path / "b.ktx")


@pytest.mark.parametrize("depth", [0, 1])
@pytest.mark.parametrize("layers", [0, 1])
def test_a_count_of_one_means_as_little_as_none(tmp_path, depth, layers):
    """bimg writes a depth and a layer of 1, gli no face for what is no cube."""
    flat = random_texture("rgba16f", 4, 8, 2)
    for faces in (0, 1):
        read = reread(tmp_path, with_header(written(tmp_path, flat), depth=depth, layers=layers, faces=faces))
        assert_same(read, flat)
        assert read.doubts == ()
    cube = random_texture("rgba16f", 4, 4, 3, is_cube=True)
    read = reread(tmp_path, with_header(written(tmp_path, cube), depth=depth, layers=layers))
    assert_same(read, cube)
    assert read.doubts == ()


def test_the_first_of_several_cubes_is_read(tmp_path):
    layers = random_texture("rgba16f", 4, 4, 2, layers=12)
    read = reread(tmp_path, with_header(written(tmp_path, layers), layers=2, faces=6))
    assert read.is_cube
    for ours, theirs in zip(read.levels, layers.levels, strict=True):
        np.testing.assert_array_equal(ours, theirs[:6])
    assert read.doubts == (f"{tmp_path / 'b.ktx'} holds 2 cubes; the first is read.",)


def unpadded(texture, size_of, face_padding):
    """A file whose rows follow each other without padding; ``size_of`` gives the declared size of a level."""
    data = b""
    for level in texture.levels:
        gap = bytes(-level.shape[1] % 4 if texture.is_cube and face_padding else 0)
        pictures = b"".join(picture.tobytes() + gap for picture in level)
        data += struct.pack("<I", size_of(level)) + pictures + bytes(-len(pictures) % 4 if face_padding else 0)
    head = struct.pack("<5I", 0x04030201, 0x140B, 2, 0x1907, 0x881B)
    head += struct.pack("<4I", 0x1907, texture.columns, texture.rows, 0)
    head += struct.pack("<4I", 0, 6 if texture.is_cube else 1, len(texture.levels), 0)
    return bytearray(b"\xabKTX 11\xbb\r\n\x1a\n" + head + data)


@pytest.mark.parametrize("face_padding", [True, False])
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("is_cube", [True, False])
def test_rows_without_padding(tmp_path, is_cube, whole, face_padding):
    """Rows of 7 texels are 42 bytes, 44 if padded: the declared size tells; of a cube it may be that of all faces."""
    texture = random_texture("rgb16f", 7, 7, 3, is_cube=is_cube)
    data = unpadded(texture, lambda level: level.size if whole else level.shape[1], face_padding)
    read = reread(tmp_path, data)
    assert_same(read, texture)
    assert read.doubts == ()


def test_sizes_that_the_dimensions_deny(tmp_path):
    """A tool declares a sixth of a face; the file is as long as its dimensions say, so nothing is lost."""
    texture = random_texture("rgba16f", 4, 4, 2, is_cube=True)
    data = with_header(unpadded(texture, lambda level: level.shape[1] // 6, True), format=0x1908, internal=0x881A)
    read = reread(tmp_path, data)
    assert_same(read, texture)
    assert [doubt.partition(" declares ")[2] for doubt in read.doubts] == [
        "sizes of its mip levels that its dimensions deny; the dimensions hold."
    ]


@pytest.mark.parametrize(
    ("junk", "kept", "said"),
    [
        (b"\xff" * 8, {}, ["has damaged metadata; all of it is left out."]),
        (struct.pack("<I", 4) + b"a\0b\0" + struct.pack("<I", 999) + b"xyz\0", {"a": b"b"},
         ["has damaged metadata; all but a is left out."]),
        (bytes(12), {}, []),
    ],
)  # fmt: skip
def test_junk_in_the_metadata_costs_no_texel(tmp_path, junk, kept, said):
    texture = random_texture("rgba16f", 4, 4)
    data = with_header(written(tmp_path, texture), pairs=len(junk))
    data[64:64] = junk
    read = reread(tmp_path, data)
    assert_same(read, texture)
    assert read.metadata == kept
    assert [doubt.partition(".ktx ")[2] for doubt in read.doubts] == said


@pytest.mark.parametrize(
    ("numbers", "name"),
    [
        ({"type": 0x8D61}, "rgba16f"),  # GL_HALF_FLOAT_OES
        ({"type": 0x1403, "internal": 0x805B}, "rgba16"),
        ({"type": 0x1401, "internal": 0x8C43}, "rgba8_srgb"),
        ({"type": 0x8367, "internal": 0x8058}, "rgba8"),
        ({"type": 0x1401, "format": 0x8C42, "internal": 0x8C43}, "rgba8_srgb"),
    ],
)
def test_other_types_of_texels(tmp_path, numbers, name):
    texture = random_texture(name, 4, 4)
    data = with_header(written(tmp_path, random_texture("rgba16f", 4, 4)), **numbers)
    size = texture.levels[0].size
    read = reread(tmp_path, data[:64] + struct.pack("<I", size) + texture.levels[0].tobytes())
    assert_same(read, texture)
    if name == "rgba16":
        words = texture.levels[0].view("<u2").astype(float).reshape(read.decode(0).shape)
        np.testing.assert_allclose(read.decode(0), words / 65535.0, rtol=1e-6)  # floats
