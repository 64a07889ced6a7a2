"""Disks that fill up and folders that cannot be written to, under what bakes and comparisons write."""

import errno
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pytest
from small_pem import small_pem
from verbs import reflet, refused

from reflet.files import atomic
from reflet.pem.container import open_pem, save_pem

FULL = "cannot be written: the disk is full; free some space or choose another folder."


@pytest.fixture
def room_for(monkeypatch: pytest.MonkeyPatch) -> Callable[[int | None], None]:
    """Lets the disk take so many files more, and then no bytes; or, with None, all."""
    sync = atomic._sync

    def fill_after(files: int | None) -> None:
        left = files

        def full(path: Path) -> None:
            nonlocal left
            if left is not None and path.is_file():
                if left == 0:
                    raise OSError(errno.ENOSPC, "No space left on device")
                left -= 1
            sync(path)

        monkeypatch.setattr(atomic, "_sync", full)

    return fill_after


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_a_bake_on_a_full_disk_goes_on_once_there_is_space(
    room_for: Callable[[int | None], None],
    capsys: pytest.CaptureFixture[str],
    scene_files: tuple[Path, Path],
    tmp_path: Path,
) -> None:
    """Each attempt gets some files further. What there is in between is whole, and no PEM."""
    small = ("--static", "--image-size", "16", "--em-size", "8", "--spp", "1")

    def bake(out: Path, *more: str) -> list[str | Path]:
        return ["bake", scene_files[0], "--environment", scene_files[1], *small, "--out", out, *more]

    out = tmp_path / "ring"
    assert reflet(*bake(tmp_path / "at once")) == 0
    capsys.readouterr()
    for files_more in (0, 2, 4):  # none; what a bake keeps on its way; some of what it writes at its end
        room_for(files_more)
        said = refused(capsys, *bake(out, "--resume"))
        assert FULL in said and len(files(out)) >= files_more
        assert not any(Path(name).name.startswith(".") for name in files(out)) and "scene.gltf" not in files(out)
    room_for(None)
    assert reflet(*bake(out, "--resume")) == 0
    for name in files(tmp_path / "at once"):
        assert (out / name).read_bytes() == (tmp_path / "at once" / name).read_bytes()
    assert files(out) == files(tmp_path / "at once")


@pytest.mark.parametrize("stop", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_pem_is_written_again_whole_or_not_at_all(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, stop: BaseException
) -> None:
    save_pem(tmp_path / "pem", small_pem(views=1))
    written: list[Path] = []

    def full(path: Path) -> None:
        if written[10:]:
            raise stop
        written.extend([path] if path.is_file() else [])

    (tmp_path / "again").mkdir()
    (tmp_path / "again" / ".theirs").write_text("kept")
    with monkeypatch.context() as patched:
        patched.setattr(atomic, "_sync", full)
        status = reflet("encode", tmp_path / "pem", "--codec", "none", "-o", tmp_path / "again")
    said = capsys.readouterr().err.strip()
    assert (status, FULL in said) == ((2, True) if isinstance(stop, OSError) else (130, False))
    assert len(said.splitlines()) == 1 and len(written) == 11
    assert [path.name for path in (tmp_path / "again").iterdir()] == [".theirs"]
    assert reflet("encode", tmp_path / "pem", "--codec", "none", "-o", tmp_path / "again") == 0
    assert open_pem(tmp_path / "again").space.sample_count == 1


def test_what_was_found_is_told_though_it_cannot_be_written(
    room_for: Callable[[int | None], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    """Hours of work are not lost with a file."""
    monkeypatch.setattr("reflet.pipelines.compare.compare", lambda *_, **__: SimpleNamespace(as_json=dict))
    monkeypatch.setattr("reflet.report.table.comparison_table", lambda _: "the numbers")
    monkeypatch.setattr("reflet.pipelines.verify.verify", lambda *_, **__: Verified())
    save_pem(tmp_path / "pem", small_pem(views=1))
    room_for(0)
    for verb in ("compare", "verify"):
        assert reflet(verb, tmp_path / "pem", "--json", tmp_path / "a.json") == 2
        told = capsys.readouterr()
        assert told.out == "the numbers\n"
        assert told.err == f"reflet: {tmp_path / 'a.json'} {FULL}\n"
    assert files(tmp_path) == {f"pem/{name}" for name in files(tmp_path / "pem")}


@dataclass(frozen=True)
class Verified:
    agrees: bool = True

    def __str__(self) -> str:
        return "the numbers"


def test_a_picture_that_cannot_be_written_is_refused_before_it_is_drawn(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def drawn(*_: object) -> None:
        raise AssertionError("the drawing was begun")

    monkeypatch.setattr("reflet.render.playback.renderer.Renderer", drawn)
    save_pem(tmp_path / "pem", small_pem(views=1))
    (tmp_path / "file").write_text("")
    said = refused(capsys, "render", tmp_path / "pem", "-o", tmp_path / "file" / "a.png")
    assert "a file stands where the folder should be" in said


def test_an_exr_says_what_the_system_says(tmp_path: Path) -> None:
    """A limit on file sizes stands for the full disk: writes fail half way."""
    code = (
        "import resource, signal, sys, numpy; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from reflet.files.pictures.exr import write_exr;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096));"
        "write_exr(sys.argv[1], numpy.random.default_rng(1).random((64, 64, 3)).astype('f4'))"
    )
    done = subprocess.run([sys.executable, "-c", code, tmp_path / "a.exr"], capture_output=True, text=True, check=False)
    said = done.stderr.splitlines()[-1]
    assert said.endswith("a.exr cannot be written: the system limits how large a file may grow; raise that limit or "
                         "choose another folder.")  # fmt: skip
    assert not list(tmp_path.iterdir())
