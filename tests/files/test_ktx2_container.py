"""KTX 2.0 textures: every form that is written comes back, as another parser sees it too; the rest is one sentence."""

import itertools
import json
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import numpy as np
import pytest
import zstandard
from textures import assert_same, random_texture

from reflet.errors import RefletError
from reflet.files.textures.ktx2_container import VK_FORMATS, read_texture, write_texture
from reflet.files.textures.texel_formats import TEXEL_FORMATS

WRITABLE = [name for name, form in TEXEL_FORMATS.items() if form.is_writable]
PARSER = Path(__file__).parents[2] / "web/node_modules/ktx-parse/dist/index.mjs"


@pytest.mark.parametrize("packed", [None, "zstd"])
@pytest.mark.parametrize("name", WRITABLE)
def test_round_trip(tmp_path, name, packed):
    """Sizes that are no powers of two, arrays, cubes, few levels and many."""
    for k, shape in enumerate(((5, 7, 3), (1, 1, 1), (6, 12, 1))):
        written = random_texture(name, *shape, seed=k, layers=1 + k, supercompression=packed, metadata={"Key": b"text"})
        write_texture(tmp_path / "a.ktx2", written)
        read = read_texture(tmp_path / "a.ktx2")
        assert_same(read, written)
        assert (read.metadata, read.supercompression) == (written.metadata, packed)
    written = random_texture(name, 9, 9, 4, is_cube=True, supercompression=packed, alpha_is_premultiplied=True)
    write_texture(tmp_path / "a.ktx2", written)
    read = read_texture(tmp_path / "a.ktx2")
    assert_same(read, written)
    assert read.alpha_is_premultiplied


def test_zstandard_packs(tmp_path):
    texture = random_texture("rgba16f", 64, 64)
    texture.levels[0][:] = 0
    write_texture(tmp_path / "a.ktx2", texture)
    plain = (tmp_path / "a.ktx2").stat().st_size
    write_texture(tmp_path / "a.ktx2", type(texture)(**{**vars(texture), "supercompression": "zstd"}))
    assert (tmp_path / "a.ktx2").stat().st_size < plain / 50  # 32 KiB of zeros in a frame of some bytes, and headers


def test_no_levels_declared_means_one(tmp_path):
    texture = random_texture("rgba16f", 4, 4)
    write_texture(tmp_path / "a.ktx2", texture)
    data = bytearray((tmp_path / "a.ktx2").read_bytes())
    struct.pack_into("<I", data, 40, 0)
    (tmp_path / "a.ktx2").write_bytes(data)
    assert_same(read_texture(tmp_path / "a.ktx2"), texture)


@pytest.mark.parametrize(("vk_format", "name"), sorted(VK_FORMATS.items()))
def test_every_format_is_read(tmp_path, vk_format, name):
    """Headers by the specification's table, without descriptor and metadata; 2 levels, the coarser first."""
    texture = random_texture(name, 4, 8, 2)
    fine, coarse = (level.tobytes() for level in texture.levels)
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", vk_format, 1, 8, 4, 0, 0, 1, 2, 0) + bytes(32)
    at = len(head) + 2 * 24
    index = struct.pack("<6Q", at + len(coarse), len(fine), len(fine), at, len(coarse), len(coarse))
    (tmp_path / "a.ktx2").write_bytes(head + index + coarse + fine)
    read = read_texture(tmp_path / "a.ktx2")
    assert_same(read, texture)
    np.testing.assert_array_equal(read.decode(1), texture.decode(1))


@pytest.mark.parametrize(("word", "turned"), [(b"rd", (1, 1)), (b"ru", (-1, 1)), (b"ld", (1, -1)), (b"lu", (-1, -1))])
def test_orientation(tmp_path, word, turned):
    texture = random_texture("rgb32f", 2, 3, metadata={"KTXorientation": word})
    write_texture(tmp_path / "a.ktx2", texture)
    plain = texture.levels[0].view("<f4").reshape(1, 2, 3, 3)
    np.testing.assert_array_equal(read_texture(tmp_path / "a.ktx2").decode(0), plain[:, :: turned[0], :: turned[1]])


def uastc_file(path, colors, model=166, scheme=0, transfer=1):
    """Squares of 4×4 texels of one colour each, a face or level after the other, in Basis Universal's UASTC code."""
    head = struct.pack("<IHH4B4x8B", 0, 2, 40, model, 1, transfer, 0, 16, *[0] * 7)
    head = head[:12] + b"\x03\x03" + head[14:]  # blocks of 4×4 texels
    descriptor = struct.pack("<I", 44) + head + struct.pack("<HBB4x2I", 0, 127, 3, 0, 0xFFFFFFFF)
    # mode 8 of the code, a block of one colour: five bits of mode, then red, green, blue, alpha
    blocks = [sum(c << (5 + 8 * k) for k, c in enumerate((*color, 255))) | 23 for color in colors]
    data = b"".join(block.to_bytes(16, "little") for block in blocks)
    at = 80 + 24 + len(descriptor)
    at += -at % 16
    numbers = (0, 1, 4, 4, 0, 1, len(colors), 1, scheme, 104, len(descriptor), 0, 0, 0, 0)
    path.write_bytes(b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I4I2Q", *numbers))
    index = struct.pack("<3Q", at, len(data), len(data))
    path.write_bytes((path.read_bytes() + index + descriptor).ljust(at, b"\0") + data)
    return path


@pytest.mark.parametrize(("transfer", "name"), [(1, "rgba8"), (2, "rgba8_srgb")])
def test_basis_universal_is_decoded(tmp_path, transfer, name):
    pytest.importorskip("opengl_basisu")  # has no wheel for every machine
    colors = [(10, 100, 200), (0, 0, 0), (255, 255, 255), (1, 2, 3), (200, 50, 25), (7, 77, 177)]
    read = read_texture(uastc_file(tmp_path / "a.ktx2", colors, transfer=transfer))
    assert (read.texel_format.name, read.is_cube, read.supercompression) == (name, True, "uastc")
    np.testing.assert_array_equal(read.levels[0].reshape(6, 16, 4), [[(*color, 255)] * 16 for color in colors])
    single = read_texture(uastc_file(tmp_path / "a.ktx2", colors[:1], transfer=transfer))
    assert (single.is_cube, single.image_count) == (False, 1)


@pytest.mark.parametrize(("model", "scheme", "code"), [(163, 1, "etc1s"), (167, 0, "uastc hdr"), (0, 1, "basis univ")])
def test_what_undoes_basis_universal_is_named(tmp_path, model, scheme, code):
    path = uastc_file(tmp_path / "a b.ktx2", [(1, 2, 3)], model, scheme)
    with pytest.raises(RefletError, match=rf"stored as {code}.*; .* tools may: ktx transcode '.*a b.ktx2' plain.ktx2"):
        read_texture(path)


def frame_of(tmp_path, frame, declared):
    """A file whose one level is ``frame``, said to unpack to ``declared`` bytes of a square texture of r8 texels."""
    texture = random_texture("rgba32f", 4, 4, supercompression="zstd")
    write_texture(tmp_path / "a.ktx2", texture)
    data = bytearray((tmp_path / "a.ktx2").read_bytes())
    (offset,) = struct.unpack_from("<Q", data, 80)
    size = int(np.sqrt(declared))
    struct.pack_into("<4I", data, 12, 9, 1, size, size)
    struct.pack_into("<2Q", data, 88, len(frame), declared)
    (tmp_path / "a.ktx2").write_bytes(bytes(data[:offset]) + frame)
    return tmp_path / "a.ktx2"


def test_frames_that_unpack_to_another_size_are_refused(tmp_path):
    compress = zstandard.ZstdCompressor().compress
    assert read_texture(frame_of(tmp_path, compress(bytes(64 * 64)), 64 * 64)).rows == 64
    for frame in (
        compress(bytes(64 * 64 + 1)),
        compress(bytes(64 * 64 - 1)),
        zstandard.ZstdCompressor(write_content_size=False).compress(bytes(64 * 65)),
        zstandard.ZstdCompressor(write_content_size=False).compress(bytes(64 * 63)),
        b"no frame at all",
        compress(bytes(64 * 64))[:-1],
    ):
        with pytest.raises(RefletError, match="truncated or damaged"):
            read_texture(frame_of(tmp_path, frame, 64 * 64))


def test_frames_that_cannot_hold_what_is_declared_are_refused_unpacked(tmp_path):
    """32 GiB from some 20 bytes: beyond what any Zstandard frame can be."""
    frame = zstandard.ZstdCompressor().compress(bytes(1 << 16))
    with pytest.raises(RefletError, match="truncated or damaged"):
        read_texture(frame_of(tmp_path, frame, (1 << 17) ** 2))


@pytest.fixture
def parsed(tmp_path):
    """What the JavaScript library that viewers use reads from a file."""
    if not shutil.which("node") or not PARSER.exists():
        pytest.skip("no Node.js or no web packages")
    script = tmp_path / "parse.mjs"
    script.write_text(f"""
        import {{ readFileSync }} from "node:fs";
        import {{ read, KHR_DF_MODEL_RGBSDA }} from "{PARSER.as_uri()}";
        const texture = read(new Uint8Array(readFileSync(process.argv[2])));
        const levels = texture.levels.map((level) => Buffer.from(level.levelData).toString("hex"));
        console.log(JSON.stringify({{ ...texture, levels, rgb: KHR_DF_MODEL_RGBSDA, globalData: null }}));
    """)

    def parse(path):
        done = subprocess.run(["node", script, path], capture_output=True, text=True, check=True, timeout=600)
        return json.loads(done.stdout)

    return parse


@pytest.mark.parametrize("name", ["rgba16f", "rgb9e5", "r11g11b10f", "rgb32f"])
def test_another_parser_reads_it_alike(tmp_path, parsed, name):
    texture = random_texture(name, 6, 6, 2, is_cube=True, metadata={"KTXorientation": b"rd"})
    write_texture(tmp_path / "a.ktx2", texture)
    said = parsed(tmp_path / "a.ktx2")
    assert VK_FORMATS[said["vkFormat"]] == name
    assert (said["typeSize"], said["supercompressionScheme"]) == (texture.texel_format.word_bytes, 0)
    shape = [said[key] for key in ("pixelWidth", "pixelHeight", "pixelDepth", "layerCount", "faceCount", "levelCount")]
    assert shape == [6, 6, 0, 0, 6, 2]
    assert said["keyValue"]["KTXorientation"] == "rd"
    assert said["levels"] == [level.tobytes().hex() for level in texture.levels]
    (descriptor,) = said["dataFormatDescriptor"]
    assert [descriptor[key] for key in ("colorModel", "transferFunction", "colorPrimaries")] == [said["rgb"], 1, 1]
    assert descriptor["texelBlockDimension"] == [0, 0, 0, 0]
    assert descriptor["bytesPlane"] == [texture.texel_format.block_bytes, 0, 0, 0, 0, 0, 0, 0]
    # every bit of a texel belongs to a channel; the shared exponent to all three
    bits = [(s["bitOffset"], s["bitLength"] + 1, s["channelType"] & 15) for s in descriptor["samples"]]
    covered = sorted({(offset, length) for offset, length, _ in bits})
    assert covered[0][0] == 0
    assert all(a + length == b for (a, length), (b, _) in itertools.pairwise(covered))
    assert sum(covered[-1]) == 8 * texture.texel_format.block_bytes
    if name == "rgb9e5":
        exponents = [s for s in descriptor["samples"] if s["channelType"] & 32]
        assert [s["channelType"] & 15 for s in exponents] == [0, 1, 2]
        assert {(s["bitOffset"], s["bitLength"], s["sampleLower"], s["sampleUpper"]) for s in exponents} == {
            (27, 4, 15, 31)
        }


def test_files_of_another_writer(tmp_path, parsed):
    """Written by ktx-parse as we hand it over: read back the same."""
    texture = random_texture("rgb9e5", 4, 4, 3, metadata={"KTXorientation": b"rd"})
    write_texture(tmp_path / "a.ktx2", texture)
    script = tmp_path / "rewrite.mjs"
    script.write_text(f"""
        import {{ readFileSync, writeFileSync }} from "node:fs";
        import {{ read, write }} from "{PARSER.as_uri()}";
        writeFileSync(process.argv[3], write(read(new Uint8Array(readFileSync(process.argv[2])))));
    """)
    subprocess.run(["node", script, tmp_path / "a.ktx2", tmp_path / "b.ktx2"], check=True, timeout=600)
    assert_same(read_texture(tmp_path / "b.ktx2"), texture)


def rewritten(tmp_path, texture, **numbers):
    """The same file with other numbers in its header."""
    at = {"depth": 28, "layers": 32, "faces": 36, "levels": 40, "scheme": 44, "descriptor_length": 52}
    write_texture(tmp_path / "a.ktx2", texture)
    data = bytearray((tmp_path / "a.ktx2").read_bytes())
    for name, number in numbers.items():
        struct.pack_into("<I", data, at[name], number)
    (tmp_path / "b.ktx2").write_bytes(data)
    return data


@pytest.mark.parametrize("depth", [0, 1])
@pytest.mark.parametrize("layers", [0, 1])
def test_a_count_of_one_means_as_little_as_none(tmp_path, depth, layers):
    flat, cube = random_texture("rgba16f", 4, 8, 2), random_texture("rgba16f", 4, 4, 2, is_cube=True)
    for texture, faces in ((flat, 0), (flat, 1), (cube, 6)):
        rewritten(tmp_path, texture, depth=depth, layers=layers, faces=faces)
        read = read_texture(tmp_path / "b.ktx2")
        assert_same(read, texture)
        assert read.doubts == ()


@pytest.mark.parametrize("packed", [None, "zstd"])
def test_the_first_of_several_cubes_is_read(tmp_path, packed):
    layers = random_texture("rgba16f", 4, 4, 2, layers=12, supercompression=packed)
    rewritten(tmp_path, layers, layers=2, faces=6)
    read = read_texture(tmp_path / "b.ktx2")
    assert read.is_cube
    for ours, theirs in zip(read.levels, layers.levels, strict=True):
        np.testing.assert_array_equal(ours, theirs[:6])
    assert read.doubts == (f"{tmp_path / 'b.ktx2'} holds 2 cubes; the first is read.",)


@pytest.mark.parametrize("name", ["rgba16f", "rgb9e5", "r11g11b10f", "rgb32f", "rgba16", "bc6h"])
def test_levels_may_lie_anywhere(tmp_path, name):
    """Finest first, at odd offsets, no descriptor, and lengths but no uncompressed lengths."""
    texture = random_texture(name, 8, 8, 3, is_cube=True)
    vk_format = next(number for number, each in VK_FORMATS.items() if each == name)
    index, body, at = b"", b"", 80 + 3 * 24 + 1
    for level in texture.levels:
        index += struct.pack("<3Q", at, level.size, 0)
        body += level.tobytes() + b"\0"
        at += level.size + 1
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I4I2Q", vk_format, 1, 8, 8, 0, 0, 6, 3, 0, 0, 0, 0, 0, 0, 0)
    (tmp_path / "a.ktx2").write_bytes(head + index + b"\0" + body)
    read = read_texture(tmp_path / "a.ktx2")
    assert_same(read, texture)
    for level in range(3):
        assert read.decode(level).shape[:2] == (6, 8 >> level)


def test_zlib(tmp_path):
    frame = zlib.compress(bytes(range(64)) * 64)
    path = frame_of(tmp_path, frame, 64 * 64)
    data = bytearray(path.read_bytes())
    data[44] = 3
    path.write_bytes(data)
    assert read_texture(path).levels[0].tobytes() == bytes(range(64)) * 64
    assert read_texture(path).supercompression == "zlib"
    for damaged in (zlib.compress(bytes(64 * 64 + 1)), zlib.compress(bytes(64 * 63)), frame[:-5], b"no frame at all"):
        path = frame_of(tmp_path, damaged, 64 * 64)
        data = bytearray(path.read_bytes())
        data[44] = 3
        path.write_bytes(data)
        with pytest.raises(RefletError, match="truncated or damaged"):
            read_texture(path)


@pytest.mark.parametrize(
    ("at", "value", "said"),
    [
        (13, 4, "says that its primaries are BT.2020; its colours are taken as Rec. 709."),
        (13, 77, "says that its primaries are number 77; its colours are taken as Rec. 709."),
        (14, 2, "says that its texels have transfer function 2, but their format is linear; they are taken as that."),
        (14, 0, None),
        (13, 0, None),
    ],
)
def test_colours_that_are_not_honoured_are_said(tmp_path, at, value, said):
    texture = random_texture("rgba16f", 4, 4)
    data = rewritten(tmp_path, texture)
    data[80 + 24 + at] = value
    (tmp_path / "b.ktx2").write_bytes(data)
    read = read_texture(tmp_path / "b.ktx2")
    assert_same(read, texture)
    assert [doubt.partition(".ktx2 ")[2] for doubt in read.doubts] == ([said] if said else [])


@pytest.mark.parametrize(
    ("name", "swizzle", "is_said"),
    [("rgba16f", b"bgra", True), ("rgba16f", b"rgba", False), ("rgb16f", b"rgb1", False), ("r16f", b"rrr1", False)],
)
def test_swizzles_that_change_colours_are_said(tmp_path, name, swizzle, is_said):
    write_texture(tmp_path / "a.ktx2", random_texture(name, 4, 4, metadata={"KTXswizzle": swizzle}))
    doubts = read_texture(tmp_path / "a.ktx2").doubts
    assert [f"swizzled ({swizzle.decode()})" in doubt for doubt in doubts] == [True] * is_said


@pytest.mark.parametrize(("vk_format", "name"), [(147, "ETC2"), (184, "ASTC"), (1000066000, "ASTC HDR")])
def test_formats_that_are_not_decoded_are_called_by_name(tmp_path, vk_format, name):
    data = rewritten(tmp_path, random_texture("rgba16f", 4, 4))
    struct.pack_into("<I", data, 12, vk_format)
    (tmp_path / "b.ktx2").write_bytes(data)
    with pytest.raises(RefletError, match=rf"VkFormat {vk_format} \({name}\); expected"):
        read_texture(tmp_path / "b.ktx2")
