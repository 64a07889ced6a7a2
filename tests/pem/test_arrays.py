"""Arrays in files come back, however they are stored; what a file does not hold is one sentence, in bounded memory."""

import json
import tracemalloc
import zlib

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.pem.arrays import BufferWriter, read_array

WHOLE = [np.uint8, np.int16, np.uint16, np.uint32]


def stored(folder, array, encoding, before=3):
    buffer = BufferWriter("some.bin")
    buffer.add(np.zeros(before, np.uint8))  # something else in the same file
    description = json.loads(json.dumps(buffer.add(array, encoding)))
    buffer.write(folder)
    return description


@pytest.mark.parametrize("encoding", [None, "deflate", "delta"])
@pytest.mark.parametrize("kind", WHOLE)
def test_numbers_come_back(tmp_path, kind, encoding):
    """The whole range, so that differences go around; one number; none."""
    ends = np.iinfo(kind)
    numbers = np.random.default_rng(1).integers(ends.min, ends.max, (5, 7, 4), kind, endpoint=True)
    numbers[0, 0] = [ends.min, ends.max, ends.min, 0]
    for array in (numbers, numbers[0, 0, :1], numbers[:0]):
        back = read_array(tmp_path, stored(tmp_path, array, encoding))
        assert back.dtype == kind
        np.testing.assert_array_equal(back, array)


def test_floats_come_back(tmp_path):
    numbers = np.random.default_rng(1).normal(size=(9, 3)).astype(np.float32)
    for encoding in (None, "deflate"):
        np.testing.assert_array_equal(read_array(tmp_path, stored(tmp_path, numbers, encoding)), numbers)


def test_the_encoding_is_that_of_the_format(tmp_path):
    """By FORMAT.md alone: planes of bytes, lowest first, of differences 2d or -2d - 1, in a zlib stream."""
    at = stored(tmp_path, np.array([3, 2, 302, 301], np.uint16), "delta")
    data = (tmp_path / "some.bin").read_bytes()[at["byteOffset"] :][: at["byteLength"]]
    differences = [6, 1, 600, 1]
    assert zlib.decompress(data) == bytes(d % 256 for d in differences) + bytes(d // 256 for d in differences)
    assert (at["componentType"], at["shape"], at["byteOffset"]) == (5123, [4], 4)


@pytest.mark.parametrize("encoding", [None, "deflate", "delta"])
def test_truncated_anywhere_is_one_sentence(tmp_path, encoding):
    at = stored(tmp_path, np.arange(300, dtype=np.uint32) ** 2, encoding)
    whole = (tmp_path / "some.bin").read_bytes()
    end = at["byteOffset"] + at.get("byteLength", 1200)
    for length in range(0, end, 1 if end < 300 else 37):
        (tmp_path / "some.bin").write_bytes(whole[:length])
        with pytest.raises(RefletError, match=r"some\.bin is truncated or damaged"):
            read_array(tmp_path, at)


@pytest.mark.parametrize(
    "lie",
    [
        {"shape": [299]},
        {"shape": [301]},
        {"shape": [10**12]},
        {"encoding": "gzip"},
        {"byteOffset": 5},
        {"byteLength": 20},
        {"byteLength": 10**12},
        {"componentType": 5121},
    ],
)
def test_lies_are_one_sentence(tmp_path, lie):
    at = stored(tmp_path, np.random.default_rng(0).integers(0, 2**32, 300, np.uint32), "delta")
    with pytest.raises(RefletError, match=r"some\.bin is truncated or damaged"):
        read_array(tmp_path, {**at, **lie})


def test_odd_descriptions_are_refused(tmp_path):
    at = stored(tmp_path, np.arange(300, dtype=np.uint32), "delta")
    for lie in ({"shape": [-1]}, {"shape": [1.5]}, {"byteOffset": -4}, {"byteLength": "9"}):
        with pytest.raises(ValueError):  # `open_pem` makes a sentence of it
            read_array(tmp_path, {**at, **lie})


@pytest.mark.parametrize("encoding", ["deflate", "delta"])
def test_a_bomb_takes_no_memory(tmp_path, encoding):
    """64 MB of zeros where 100 numbers belong: read in less than the file's own length and a window of zlib's."""
    at = stored(tmp_path, np.zeros(2**26, np.uint8), "deflate")
    tracemalloc.start()
    for shape in ([100], [2**26 - 1], [2**40]):
        tracemalloc.reset_peak()
        with pytest.raises(RefletError, match="damaged"):
            read_array(tmp_path, {**at, "shape": shape, "encoding": encoding})
        allowed = shape[0] if shape[0] < 2**30 else 0  # as much as the shape says, where the file may hold so much
        assert tracemalloc.get_traced_memory()[1] < 2 * allowed + 1e6
    tracemalloc.stop()
