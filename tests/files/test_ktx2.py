"""KTX 2.0 cube maps: what is written is what the format says, and comes back."""

import struct

import numpy as np
import pytest

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.files.textures.ktx2 import read_ktx2, write_ktx2
from reflet.files.textures.texel_formats import HALF_MAX


@pytest.fixture
def chain():
    return MipChain(8)


@pytest.fixture
def texels(chain):
    """Every texel another value, each of them exact in half precision."""
    return (np.arange(chain.texel_count)[:, None] + np.array([0, 0.25, 0.5, 0.75])).astype(np.float32)


@pytest.mark.parametrize("laid_out", PARAMETERIZATIONS.values(), ids=str)
@pytest.mark.parametrize("size", [1, 2, 8])
def test_round_trip(tmp_path, size, laid_out):
    chain = MipChain(size, laid_out)
    texels = np.random.default_rng(1).normal(0, 10, (chain.texel_count, 4)).astype(np.float32)
    write_ktx2(tmp_path / "map.ktx2", chain, texels)
    cube = read_ktx2(tmp_path / "map.ktx2")
    assert cube.chain == chain
    np.testing.assert_array_equal(cube.texels(), texels.astype(np.float16))
    for mip_level, level in enumerate(cube.levels):
        np.testing.assert_array_equal(level, chain.level(texels, mip_level).astype(np.float16))


def test_bytes_are_where_the_format_says(tmp_path, chain, texels):
    """Read with nothing but the specification's tables."""
    write_ktx2(tmp_path / "map.ktx2", chain, texels)
    data = (tmp_path / "map.ktx2").read_bytes()
    assert data[:12] == bytes.fromhex("AB4B5458203230BB0D0A1A0A")
    # vkFormat R16G16B16A16_SFLOAT, typeSize, width, height, depth, layers, faces, levels, supercompression
    assert struct.unpack_from("<9I", data, 12) == (97, 2, 8, 8, 0, 0, 6, 4, 0)
    descriptor_at, descriptor_length, metadata_at, metadata_length = struct.unpack_from("<4I", data, 48)
    assert struct.unpack_from("<2Q", data, 64) == (0, 0)
    index = [struct.unpack_from("<3Q", data, 80 + 24 * level) for level in range(4)]
    assert descriptor_at == 80 + 24 * 4
    assert metadata_at == descriptor_at + descriptor_length
    previous_end = metadata_at + metadata_length
    for level in (3, 2, 1, 0):  # the coarsest level comes first, each aligned to a texel, padding below one texel
        offset, length, uncompressed = index[level]
        assert offset % 8 == 0
        assert 0 <= offset - previous_end < 8
        assert length == uncompressed == 6 * (8 >> level) ** 2 * 8
        previous_end = offset + length
    assert previous_end == len(data)
    # face +Y (2) of level 1, row 2, column 3, green
    at = index[1][0] + ((2 * 4 + 2) * 4 + 3) * 8 + 2
    assert np.frombuffer(data, "<f2", 1, at)[0] == chain.level(texels, 1)[2, 2, 3, 1]


def test_data_format_descriptor(tmp_path, chain, texels):
    """Signed floating-point samples R, G, B, A of 16 bits, linear Rec. 709; premultiplied if there is alpha."""
    for channels in (3, 4):
        write_ktx2(tmp_path / "map.ktx2", chain, texels[:, :channels])
        data = (tmp_path / "map.ktx2").read_bytes()
        at, length = struct.unpack_from("<2I", data, 48)
        total, vendor_and_type, version, block_size = struct.unpack_from("<IIHH", data, at)
        assert total == length == 4 + block_size == 4 + 24 + 4 * 16
        assert (vendor_and_type, version) == (0, 2)
        assert data[at + 12 : at + 16] == bytes([1, 1, 1, int(channels == 4)])  # RGBSDA, BT.709, linear, premultiplied
        assert data[at + 16 : at + 28] == bytes([0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0])
        for number, channel in enumerate((0, 1, 2, 15)):
            sample = struct.unpack_from("<HBB4xff", data, at + 28 + 16 * number)
            assert sample == (16 * number, 15, 0xC0 | channel, -1.0, 1.0)


def test_orientation_is_stated(tmp_path, chain, texels):
    write_ktx2(tmp_path / "map.ktx2", chain, texels)
    data = (tmp_path / "map.ktx2").read_bytes()
    at, length = struct.unpack_from("<2I", data, 56)
    pairs, end = {}, at + length
    while at < end:
        (size,) = struct.unpack_from("<I", data, at)
        key, value = data[at + 4 : at + 4 + size].split(b"\0", 1)
        pairs[key] = value
        at += 4 + size + -size % 4
    assert at == end
    assert pairs == {
        b"KTXorientation": b"rd\0",
        b"KTXwriter": b"reflet\0",
        b"RefletParameterization": b"cube\0",
    }


def test_radiance_beyond_half_floats_is_clamped(tmp_path):
    chain = MipChain(1)
    write_ktx2(tmp_path / "map.ktx2", chain, np.full((6, 3), 1e6, np.float32))
    texels = read_ktx2(tmp_path / "map.ktx2").texels()
    np.testing.assert_array_equal(texels[:, :3], HALF_MAX)
    np.testing.assert_array_equal(texels[:, 3], 1)


def test_not_a_number_is_refused(tmp_path):
    with pytest.raises(RefletError, match="not numbers"):
        write_ktx2(tmp_path / "map.ktx2", MipChain(1), np.full((6, 3), np.nan, np.float32))
    assert not list(tmp_path.iterdir())


def test_equal_maps_give_equal_bytes(tmp_path, chain, texels):
    write_ktx2(tmp_path / "a.ktx2", chain, texels)
    write_ktx2(tmp_path / "b.ktx2", chain, texels.copy())
    assert (tmp_path / "a.ktx2").read_bytes() == (tmp_path / "b.ktx2").read_bytes()


@pytest.mark.parametrize("kept", [0, 11, 40, 100, 400, -1])
def test_truncated_at_any_place_is_one_sentence(tmp_path, chain, texels, kept):
    write_ktx2(tmp_path / "map.ktx2", chain, texels)
    data = (tmp_path / "map.ktx2").read_bytes()
    (tmp_path / "map.ktx2").write_bytes(data[:kept])
    with pytest.raises(RefletError, match=r"truncated|not a KTX"):
        read_ktx2(tmp_path / "map.ktx2")


@pytest.mark.parametrize(
    ("at", "value", "said"),
    [
        (12, 38, "VkFormat 38"),
        (12, 109, "truncated or damaged"),
        (36, 1, "truncated or damaged"),
        (36, 3, "3 faces"),
        (20, 16, "16×8×0 texels"),
        (40, 3, "all mip levels"),
        (40, 9, "9 mip levels"),
        (44, 1, "basis universal"),
        (44, 2, "truncated or damaged"),
        (44, 9, "unknown scheme 9"),
    ],
)
def test_other_forms_are_refused(tmp_path, chain, texels, at, value, said):
    write_ktx2(tmp_path / "map.ktx2", chain, texels)
    data = bytearray((tmp_path / "map.ktx2").read_bytes())
    struct.pack_into("<I", data, at, value)
    (tmp_path / "map.ktx2").write_bytes(data)
    with pytest.raises(RefletError, match=said):
        read_ktx2(tmp_path / "map.ktx2")


def test_missing_file_is_one_sentence(tmp_path):
    with pytest.raises(RefletError, match="does not exist"):
        read_ktx2(tmp_path / "none.ktx2")
