"""Damaged .hdr files: each ends in a RefletError or a picture, in memory that is bounded by what it holds."""

import faulthandler
import re
import tracemalloc

import numpy as np
import pytest
from fuzz import damaged, with_text_numbers
from test_hdr import RGBE, XYZE, flat, new_runs, old_runs, picture, write

from reflet.errors import RefletError
from reflet.files.pictures.hdr import read_hdr

OVERHEAD = 1 << 18  # Python's own objects, exceptions and tables
SIZE = re.compile(rb"[-+][XY][ \t]+(\d+)[ \t]+[-+][XY][ \t]+(\d+)")

VALID = {
    "new runs": (new_runs, RGBE, None),
    "old runs": (old_runs, RGBE + b"EXPOSURE=2.5\n", None),
    "flat": (flat, b"#?RGBE\n", None),
    "columns": (new_runs, RGBE, b"+X 12 -Y 24\n"),
    "xyze": (new_runs, XYZE + b"COLORCORR= 1 2 3\nPRIMARIES= 0.6 0.3 0.3 0.6 0.1 0.1 0.3 0.3\n", None),
}


@pytest.fixture
def _no_hang():
    """Compiled loops cannot be interrupted: a hang ends the whole run, with a traceback that says where."""
    faulthandler.dump_traceback_later(120.0, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


@pytest.mark.usefixtures("_no_hang")
@pytest.mark.parametrize("form", VALID)
def test_damaged_files(tmp_path, form):
    encode, header, size = VALID[form]
    path = write(tmp_path / "a.hdr", picture(12, 24), encode, header, size)
    valid = path.read_bytes()
    read_hdr(path)  # compiles
    end = SIZE.search(valid).end() + 1
    rng = np.random.default_rng(11)
    read = refused = 0
    for data in (*damaged(valid, end, rng), *with_text_numbers(valid, end)):
        path.write_bytes(data)
        tracemalloc.start()
        try:
            image = read_hdr(path)
            assert image.dtype == np.float32 and image.shape[2] == 3
            read += 1
            # the file twice (its header a second time), where its lines begin (8 bytes for 4 or more of the file),
            # 4 bytes a pixel, its picture, and that once more converted
            bound = OVERHEAD + 4 * len(data) + (4 + 12 + 12) * image.shape[0] * image.shape[1]
        except RefletError as error:
            assert str(error).endswith(".") and len(str(error)) < 300 + len(str(path))
            refused += 1
            bound = OVERHEAD + 4 * len(data)  # nothing at all for pixels
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak <= bound
    assert read > 100 and refused > 100  # both ways were taken


@pytest.mark.parametrize(("count", "length"), [(20000, 20000), (1, 500_000_000), (500_000_000, 1)])
@pytest.mark.parametrize(
    "body", [b"", bytes(4000), b"\x02\x02\x4e\x20" + b"\xff\x01" * 1000, b"\x01\x01\x01\xff" * 1000]
)
def test_a_size_that_the_file_cannot_hold_costs_nothing(tmp_path, count, length, body):
    (tmp_path / "a.hdr").write_bytes(RGBE + b"\n-Y %d +X %d\n" % (count, length) + body)
    read_damaged = pytest.raises(RefletError, match="truncated")
    tracemalloc.start()
    with read_damaged:
        read_hdr(tmp_path / "a.hdr")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < OVERHEAD
