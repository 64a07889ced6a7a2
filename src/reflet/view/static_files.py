"""Where the built viewer and a scene's files lie."""

import json
from pathlib import Path

from reflet.errors import RefletError
from reflet.pem import layout
from reflet.pem.reader import open_pem

SCENE_FOLDER = "scene"  # beside the viewer's own files, on a server and in an export
SHADED_EXTENSION = "REFLET_environment_mapped_material"  # of a scene.gltf that holds no PEM but a shaded mesh
_VIEWER = Path(__file__).parent / "static"


def viewer_folder() -> Path:
    """Folder of the built web viewer. Raises RefletError where it is not built."""
    if not (_VIEWER / "index.html").exists():
        raise RefletError("The web viewer is not built in this source tree; run: make web.")
    return _VIEWER


def scene_folder(folder: str | Path) -> Path:
    """Folder of a PEM that opens, or of a shaded scene; of an exported page, that of the scene in it.

    Raises RefletError as `reflet.pem.reader.open_pem` does.
    """
    if (Path(folder) / "index.html").is_file() and (Path(folder) / SCENE_FOLDER / layout.SCENE).is_file():
        folder = Path(folder) / SCENE_FOLDER
    if not _is_shaded(Path(folder)):
        open_pem(folder)
    folder = Path(folder).absolute()
    return folder if folder.is_dir() else folder.parent


def _is_shaded(path: Path) -> bool:
    try:
        document = json.loads((path / layout.SCENE if path.is_dir() else path).read_bytes())
        return SHADED_EXTENSION in document["extensions"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
