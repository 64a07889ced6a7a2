"""Damaged KTX and DDS files: each ends in a RefletError or a texture, in memory that the file's size bounds."""

import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from fuzz import NUMBERS, damaged
from textures import random_texture

from reflet.errors import RefletError
from reflet.files.textures import dds, ktx1, ktx2_container

READ = {".ktx2": ktx2_container.read_texture, ".ktx": ktx1.read_ktx1_texture, ".dds": dds.read_dds_texture}
WRITE = {".ktx2": ktx2_container.write_texture, ".ktx": ktx1.write_ktx1_texture, ".dds": dds.write_dds_texture}
HEADER = {".ktx2": 80 + 3 * 24, ".ktx": 64, ".dds": 148}

# What a refused file may take: as much as it is long, some times over. What a texture may: its texels as stored
# (read, and on the way), and as four floats each (decoded, and on the way).
TIMES = 4
OVERHEAD = 2 << 20  # Python's own objects, and buffers of one block of work


def valid_files(suffix, folder):
    """A cube with mip levels and metadata, an odd array, and for KTX 2.0 a packed one."""
    metadata = {} if suffix == ".dds" else {"KTXorientation": b"rd", "sh": b"1 2 3"}
    textures = [
        random_texture("rgba16f", 4, 4, 3, is_cube=True, metadata=metadata),
        random_texture("rgb9e5", 3, 5, 2, layers=2, metadata=metadata),
    ]
    if suffix == ".ktx2":
        textures.append(random_texture("r11g11b10f", 4, 8, 2, metadata=metadata, supercompression="zstd"))
    for texture in textures:
        WRITE[suffix](folder / f"valid{suffix}", texture)
        yield (folder / f"valid{suffix}").read_bytes()
    if suffix == ".ktx2":
        yield zlib_file(folder)


def zlib_file(folder):
    """The packed texture with its levels deflated."""
    path = folder / "valid.ktx2"
    write_texture = WRITE[".ktx2"]
    texture = random_texture("r11g11b10f", 4, 8)
    write_texture(path, texture)
    data = bytearray(path.read_bytes())
    (at,) = struct.unpack_from("<Q", data, 80)
    packed = zlib.compress(texture.levels[0].tobytes())
    struct.pack_into("<Q", data, 88, len(packed))
    data[44] = 3
    return bytes(data[:at]) + packed


def with_other_numbers(data, header, skip):
    """Each 32-bit number of the header replaced by some others; which, depends on ``skip``: files share the work."""
    for at in range(12, header - 3, 4):
        for number in (*NUMBERS, 3, 6, 17, 131)[skip % 3 :: 3]:
            yield data[:at] + struct.pack("<I", number) + data[at + 4 :]


@pytest.mark.parametrize("suffix", READ)
def test_damaged_files(tmp_path, suffix):
    path = tmp_path / f"damaged{suffix}"
    rng = np.random.default_rng(7)
    read = refused = 0
    for number, valid in enumerate(valid_files(suffix, tmp_path)):
        header = HEADER[suffix]
        for data in (*damaged(valid, header + 64, rng, 16), *with_other_numbers(valid, header, skip=number)):
            path.write_bytes(data)
            bound = OVERHEAD + TIMES * len(data)
            tracemalloc.start()
            try:
                texture = READ[suffix](path)
                shapes = [texture.level_shape(level) for level in range(len(texture.levels))]
                bound += TIMES * sum(level.nbytes for level in texture.levels)
                bound += TIMES * 16 * texture.image_count * sum(rows * columns for rows, columns in shapes)
                with np.errstate(all="ignore"):  # radiance of random bits may be anything
                    for level in range(len(texture.levels)):
                        assert texture.decode(level).shape[:1] == (texture.image_count,)
                read += 1
            except RefletError as error:
                assert str(error).endswith(".")
                assert len(str(error)) < 400
                refused += 1
            assert tracemalloc.get_traced_memory()[1] < bound
            tracemalloc.stop()
    assert read > 50  # flipped texels are still texels
    assert refused > 150


def test_a_packed_bomb(tmp_path):
    """A valid frame of 16 MiB of zeros under a header that declares 16 GiB: refused before anything is unpacked."""
    path = tmp_path / "bomb.ktx2"
    texture = random_texture("r16f", 1 << 11, 1 << 12, supercompression="zstd")
    texture.levels[0][:] = 0
    ktx2_container.write_texture(path, texture)
    data = bytearray(path.read_bytes())
    assert len(data) < 2000
    struct.pack_into("<2I", data, 20, 1 << 17, 1 << 16)
    (length,) = struct.unpack_from("<Q", data, 88)
    struct.pack_into("<2Q", data, 88, length, 1 << 34)
    path.write_bytes(data)
    tracemalloc.start()
    with pytest.raises(RefletError, match="truncated or damaged"):
        ktx2_container.read_texture(path)
    assert tracemalloc.get_traced_memory()[1] < OVERHEAD
    tracemalloc.stop()
