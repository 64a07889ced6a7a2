"""The process of a command: Ctrl-C at awkward moments, and places where compiled functions cannot be kept."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from reflet.files.pictures.exr import write_exr

IMPORTING = """
import sys
class Interrupting:  # Ctrl-C while modules are loaded
    def find_spec(self, name, path=None, target=None):
        if name == "reflet.cli.main":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupting())
"""
TRANSLATED = """
from reflet.cli import main as command_line
def work(*arguments, **more):  # Ctrl-C while a library loads its own
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as error:
        raise ImportError("initialization failed") from error
command_line.commands.main = work
"""
UNHEARD = """
import threading
class Busy:
    def __del__(self):  # Ctrl-C in here is lost: nothing gets out of a destructor
        raise KeyboardInterrupt
from reflet.cli import main as command_line
def work(*arguments, **more):
    Busy()
    threading.Event().wait(60)
command_line.commands.main = work
"""
LATE = """
import atexit, signal
atexit.register(signal.raise_signal, signal.SIGINT)  # Ctrl-C while the process ends
import sys
sys.argv[1:] = ["--version"]
"""


def run(before: str, *arguments: str | Path, **environment: str) -> "subprocess.CompletedProcess[str]":
    """A command in a process of its own, in which something is done before."""
    command = [sys.executable, "-B", "-c", f"{before}\nfrom reflet.cli.start import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **environment})


@pytest.mark.parametrize("before", [IMPORTING, TRANSLATED, UNHEARD])
def test_ctrl_c_is_always_heard(before: str) -> None:
    done = run(before, "sampling")
    assert (done.returncode, done.stdout, done.stderr.split()) == (130, "", ["Stopped."])


def test_ctrl_c_after_the_end_changes_nothing() -> None:
    done = run(LATE)
    assert (done.returncode, done.stderr) == (0, "")
    assert "reflet" in done.stdout


def test_help_loads_no_heavy_library() -> None:
    code = (
        "import reflet.cli.main, sys; print([m for m in ('numba', 'scipy', 'matplotlib', 'PIL') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.fixture
def sky(tmp_path: Path) -> Path:
    write_exr(tmp_path / "sky.exr", np.ones((8, 16, 3), np.float32))
    return tmp_path / "sky.exr"


def test_a_disk_too_full_for_compiled_functions(sky: Path, tmp_path: Path) -> None:
    """A limit on file sizes stands for the full disk."""
    limit = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); import reflet.pipelines.convert;"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))"
    done = run(limit, "convert", sky, tmp_path / "a.exr", "--to", "cube", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.splitlines()) == 1 and "NUMBA_CACHE_DIR" in done.stderr
    assert not (tmp_path / "a.exr").exists()


def test_too_little_memory_is_one_sentence() -> None:
    before = """
from reflet.cli import main as command_line
def work(*arguments, **more):
    bytearray(1 << 60)
command_line.commands.main = work
"""
    done = run(before)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1) and "memory" in done.stderr


def test_other_errors_are_told_in_full() -> None:
    before = "from reflet.cli import main as command_line\ncommand_line.commands.main = lambda *_, **__: 1 // 0"
    done = run(before)
    assert done.returncode == 1 and "ZeroDivisionError" in done.stderr and "Traceback" in done.stderr


def test_nowhere_to_keep_compiled_functions(tmp_path: Path) -> None:
    """A program installed for all, run by somebody without a home: they go where only this command looks."""
    before = """
import os, pathlib
os.environ.pop("NUMBA_CACHE_DIR", None)
os.access = lambda *_: False
from reflet.cli import main as command_line
def work(*arguments, **more):
    folder = pathlib.Path(os.environ["NUMBA_CACHE_DIR"])
    print(folder, folder.stat().st_mode & 0o077)
command_line.commands.main = work
"""
    done = run(before, TMPDIR=str(tmp_path))
    folder, others = done.stdout.split()
    assert Path(folder).parent == tmp_path and others == "0"
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_under_what_is_printed() -> None:
    command = [sys.executable, "-c", "from reflet.cli.start import main; main()", "sampling"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1) and "the disk is full" in done.stderr
