"""A page for any static web host: the viewer and one scene in a folder."""

import shutil
from pathlib import Path

from reflet.errors import RefletError
from reflet.pem import layout
from reflet.view.static_files import SCENE_FOLDER, scene_folder, viewer_folder


def export_viewer(folder: str | Path, out: str | Path) -> Path:
    """Copy the viewer and the scene in ``folder`` to ``out``, which is new or empty, and return its ``index.html``.

    A scene is a PEM or what `reflet.view.shaded_scene` writes. Raises RefletError where
    ``folder`` is neither, ``out`` holds files already or cannot be written.
    """
    source, viewer, out = scene_folder(folder), viewer_folder(), Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise RefletError(f"{out} holds files already; choose a new or empty folder.")
    try:
        shutil.copytree(viewer, out, dirs_exist_ok=True)
        shutil.copytree(
            source, out / SCENE_FOLDER, ignore=shutil.ignore_patterns(layout.STATE, layout.PARAMETERS, ".*")
        )
    except OSError as error:
        raise RefletError(f"{out} cannot be written: {error}.") from None
    return out / "index.html"
