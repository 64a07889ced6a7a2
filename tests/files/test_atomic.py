import contextlib
import errno
import os
import sys

import pytest

from reflet.errors import RefletError
from reflet.files import atomic
from reflet.files.atomic import atomic_path, atomic_write, check_writable, remove_unfinished


def test_writes_the_bytes_into_a_new_folder_and_leaves_nothing_else(tmp_path):
    target = tmp_path / "deep" / "er" / "map.ktx2"
    atomic_write(target, b"abc")
    assert target.read_bytes() == b"abc"
    assert os.listdir(target.parent) == ["map.ktx2"]


def test_file_is_readable_as_the_umask_says(tmp_path):
    mask = os.umask(0o022)
    try:
        atomic_write(tmp_path / "a", b"x")
    finally:
        os.umask(mask)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o644


def test_a_failing_block_keeps_the_old_file_and_removes_the_new(tmp_path):
    atomic_write(tmp_path / "a.exr", b"old")
    with pytest.raises(KeyError), atomic_path(tmp_path / "a.exr") as temporary:
        assert temporary.suffix == ".exr" and temporary.parent == tmp_path
        temporary.write_bytes(b"half")
        raise KeyError
    assert (tmp_path / "a.exr").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.exr"]


def test_errors_name_the_file_that_was_asked_for(tmp_path):
    """Of several files that appear all or none, each is written to a temporary path of its own, by way of another."""
    for reason in (lambda inner: RefletError(f"{inner} cannot be written."), lambda _: OSError(errno.ENOSPC, "full")):
        name = tmp_path / "map_px.exr"
        with pytest.raises(RefletError) as said, atomic_path(name) as outer, atomic_path(outer) as inner:
            raise reason(inner)
        assert str(said.value).startswith(f"{name} cannot be written")
    assert not os.listdir(tmp_path)


def test_full_disk_is_said_in_one_sentence(tmp_path, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RefletError, match="disk is full"):
        atomic_write(tmp_path / "a", b"x")
    assert os.listdir(tmp_path) == []


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(RefletError, match="a file stands where the folder should be"):
        atomic_write(tmp_path / "file" / "a", b"x")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written_to_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(RefletError, match="may not be written to"):
            atomic_write(tmp_path / "a", b"x")
    finally:
        tmp_path.chmod(0o700)


def test_what_cannot_be_written_is_known_beforehand(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(RefletError, match="folder"):
        check_writable(tmp_path / "file" / "a.ktx2")
    (tmp_path / "a.ktx2").write_text("old")
    check_writable(tmp_path / "a.ktx2")
    check_writable(tmp_path / "new" / "b.ktx2")
    assert (tmp_path / "a.ktx2").read_text() == "old"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["a.ktx2", "file", "new"]


def whole(path):
    atomic_write(path, b"whole")


@pytest.mark.parametrize("action", [whole, check_writable])
def test_an_interrupt_between_any_two_instructions_leaves_nothing_half_written(tmp_path, action):
    """Ctrl-C is raised at the first instruction, the second and so on, of this module and of contextlib."""
    watched = {atomic.__file__, contextlib.__file__}
    target = tmp_path / "a"

    def interrupted_at(last: int) -> bool:
        count = 0

        def trace(frame, event, _):
            nonlocal count
            if frame.f_code.co_filename not in watched:
                return None
            frame.f_trace_opcodes = True
            count += event == "opcode"
            if count == last and event == "opcode":
                raise KeyboardInterrupt
            return trace

        sys.settrace(trace)
        try:
            action(target)
        except KeyboardInterrupt:
            return True
        finally:
            sys.settrace(None)
        return False

    last = 1
    while interrupted_at(last):
        remove_unfinished()
        assert os.listdir(tmp_path) in ([], ["a"]), last
        assert not target.exists() or target.read_bytes() == b"whole", last
        target.unlink(missing_ok=True)
        last += 1
    assert last > 100  # it did stop in the middle
