"""A page for any static web host: the viewer and one scene in a folder."""

import errno
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from reflet.errors import RefletError
from reflet.files.atomic import REASONS
from reflet.pem import layout
from reflet.view.static_files import SCENE_FOLDER, scene_folder, viewer_folder


def export_viewer(folder: str | Path, out: str | Path) -> Path:
    """Copy the viewer and the scene in ``folder`` to ``out``, which is new or empty, and return its ``index.html``.

    A scene is a PEM or what `reflet.view.shaded_scene` writes. Raises RefletError where ``folder`` is neither, ``out``
    holds files already or cannot be written; then it is left empty.
    """
    source, viewer, out = scene_folder(folder), viewer_folder(), Path(out)
    if out.exists() and not out.is_dir():
        raise RefletError(f"{out} cannot be written: {REASONS[errno.EEXIST]}.")
    if out.exists() and any(out.iterdir()):
        raise RefletError(f"{out} holds files already; choose a new or empty folder.")
    try:
        out.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".", suffix=".tmp", dir=out) as unfinished:
            page = Path(unfinished)
            _copy(viewer, page)
            _copy(source, page / SCENE_FOLDER)
            for whole in sorted(page.iterdir(), key=lambda item: item.name == "index.html"):
                whole.rename(out / whole.name)
    except OSError as error:
        raise RefletError(f"{out} cannot be written: {REASONS.get(error.errno or 0, error.strerror)}.") from None
    return out / "index.html"


def _copy(folder: Path, to: Path) -> None:
    """All files in ``folder`` but those that are only for `reflet.bake`, and hidden ones. Raises OSError."""
    for path in folder.rglob("*"):
        inside = path.relative_to(folder)
        if path.is_file() and not any(
            part in (layout.STATE, layout.PARAMETERS) or part.startswith(".") for part in inside.parts
        ):
            (to / inside).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, to / inside)
