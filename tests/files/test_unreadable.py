"""Why a file cannot be read: the reason, and what helps against just that."""

import errno
from collections.abc import Callable
from pathlib import Path

import pytest

from reflet.errors import RefletError
from reflet.files.env_image_file import read_env_image
from reflet.files.ior_file import read_spectral_index
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.files.unreadable import unreadable
from reflet.scene.readers.gltf.read import read_gltf

READERS: dict[str, Callable[[Path], object]] = {
    **dict.fromkeys((".hdr", ".exr", ".ktx2", ".ktx", ".dds", ".png", ".jpg"), read_env_image),
    ".yml": read_spectral_index,
    ".npz": read_measured_brdf,
    ".glb": read_gltf,
}


@pytest.mark.parametrize("suffix", list(READERS))
def test_a_missing_file_a_file_for_a_folder_and_a_folder_for_a_file(tmp_path: Path, suffix: str) -> None:
    read = READERS[suffix]
    (tmp_path / "file").write_text("")
    (tmp_path / f"folder{suffix}").mkdir()
    for name, says in (
        (f"nowhere{suffix}", "check the name"),
        (f"file/a{suffix}", "check the name"),
        (f"folder{suffix}", "folder"),
    ):
        with pytest.raises(RefletError, match=says) as caught:
            read(tmp_path / name)
        assert name in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("code", "says"),
    [(errno.EACCES, "change its permissions"), (errno.EIO, "copy it again"), (errno.ENAMETOOLONG, "check the name")],
)
def test_each_reason_has_its_own_advice(code: int, says: str) -> None:
    assert says in str(unreadable("sky.hdr", OSError(code, "")))


def test_an_unknown_reason_is_the_systems_word() -> None:
    assert str(unreadable("sky.hdr", OSError(errno.ESTALE, "Stale file handle"))) == (
        "sky.hdr cannot be read (Stale file handle)."
    )
