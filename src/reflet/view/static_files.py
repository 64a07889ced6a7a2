"""Where the built viewer and a PEM's files lie."""

from pathlib import Path

from reflet.errors import RefletError
from reflet.pem.reader import open_pem

PEM_FOLDER = "pem"  # beside the viewer's own files, on a server and in an export
_VIEWER = Path(__file__).parent / "static"


def viewer_folder() -> Path:
    """Folder of the built web viewer. Raises RefletError where it is not built."""
    if not (_VIEWER / "index.html").exists():
        raise RefletError("The web viewer is not built in this source tree; run: make web.")
    return _VIEWER


def pem_folder(folder: str | Path) -> Path:
    """Folder of a PEM that opens. Raises RefletError as `reflet.pem.reader.open_pem` does."""
    open_pem(folder)
    folder = Path(folder).absolute()
    return folder if folder.is_dir() else folder.parent
