"""Serves the web viewer and one scene to this machine alone."""

import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from reflet.errors import RefletError
from reflet.view.static_files import SCENE_FOLDER, scene_folder, viewer_folder


def serve(folder: str | Path, port: int = 0, open_browser: bool = True, name: str | None = None) -> None:
    """Serve the viewer with the PEM or shaded scene in ``folder`` on loopback until Ctrl-C; port 0 takes a free one.

    Prints the address, and what is there: ``name``, by default the folder. Raises RefletError where ``folder`` is
    neither, the viewer is not built or the port is taken.
    """
    with viewer_server(folder, port) as address:
        print(f"{address} shows {name or folder}; Ctrl-C ends it.", flush=True)
        if open_browser:
            webbrowser.open(address)
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            print()


@contextmanager
def viewer_server(folder: str | Path, port: int = 0) -> Iterator[str]:
    """Serve in the background while the block runs; gives the viewer's address. Errors are those of `serve`."""
    handler = partial(_Handler, viewer=viewer_folder(), scene=scene_folder(folder))
    try:
        server = ThreadingHTTPServer(("127.0.0.1", port), handler)
    except OSError as error:
        raise RefletError(f"Port {port} cannot be used ({error.strerror}); choose another with --port.") from None
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), name="reflet viewer", daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Handler(SimpleHTTPRequestHandler):
    """Files of the viewer at the root, those of the scene below ``scene/``; nothing else, no listings."""

    protocol_version = "HTTP/1.1"  # one connection for the hundreds of map files
    extensions_map = {  # noqa: RUF012 - the base class declares it so
        ".html": "text/html; charset=utf-8",
        ".js": "text/javascript; charset=utf-8",
        ".css": "text/css; charset=utf-8",
        ".svg": "image/svg+xml",
        ".png": "image/png",
        ".json": "application/json",
        ".gltf": "model/gltf+json",
        ".ktx2": "image/ktx2",
        "": "application/octet-stream",
    }

    def __init__(self, *args: Any, viewer: Path, scene: Path) -> None:
        self.viewer, self.scene = viewer, scene
        super().__init__(*args, directory=str(viewer))

    def translate_path(self, path: str) -> str:
        """The file for a URL; one that leaves the two folders, by whatever trick, is none."""
        parts = [part for part in unquote(urlsplit(path).path).split("/") if part]
        root, inside = (
            (self.scene, parts[1:]) if parts[:1] == [SCENE_FOLDER] else (self.viewer, parts or ["index.html"])
        )
        if any(part in (".", "..") or "\\" in part or "\0" in part for part in inside):
            return str(root / ".nowhere")
        return str(root.joinpath(*inside))

    def send_head(self) -> Any:
        """As the base class, but for this machine's own names only: a page elsewhere whose name is made to resolve to
        this address must not read what is served here."""
        host = self.headers.get("Host", "").rsplit(":", 1)[0]
        if host not in ("127.0.0.1", "localhost"):
            self.send_error(HTTPStatus.FORBIDDEN)
            return None
        if Path(self.translate_path(self.path)).is_dir():
            self.send_error(HTTPStatus.NOT_FOUND)
            return None
        return super().send_head()

    def end_headers(self) -> None:
        """A scene may be written again under the same address: ask each time, send only what changed."""
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Silence: the terminal shows one address."""
