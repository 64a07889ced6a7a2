"""Serves the web viewer and one scene to this machine, and to others where that is asked for."""

import os
import sys
import threading
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from socket import AF_INET, AF_INET6
from socketserver import TCPServer
from typing import Any
from urllib.parse import unquote, urlsplit

from reflet.errors import RefletError
from reflet.view.hosts import Hosts, read_hosts, ways_in
from reflet.view.static_files import SCENE_FOLDER, scene_folder, viewer_folder


def serve(
    folder: str | Path,
    port: int = 0,
    open_browser: bool = True,
    name: str | None = None,
    hosts: Sequence[str] = (),
) -> None:
    """Serve the viewer with the PEM or shaded scene in ``folder`` until Ctrl-C; port 0 takes a free one.

    It listens on loopback, or on the address among ``hosts``, and answers to the names there (`reflet.view.hosts`).
    Prints the address, and what is there: ``name``, by default the folder. Raises RefletError where ``folder`` is
    neither, the viewer is not built, the port is taken or ``hosts`` cannot be used.
    """
    with viewer_server(folder, port, hosts) as address:
        print(f"{address} shows {name or folder}; Ctrl-C ends it.", flush=True)
        ways = ways_in(read_hosts(hosts), urlsplit(address).port or 0)
        if ways:
            print(ways, flush=True)
        if open_browser and not _far_from_a_screen():
            webbrowser.open(address)
        try:
            _wait()
        except KeyboardInterrupt:
            print()


@contextmanager
def viewer_server(folder: str | Path, port: int = 0, hosts: Sequence[str] = ()) -> Iterator[str]:
    """Serve in the background while the block runs; gives the viewer's address. Errors are those of `serve`."""
    known = read_hosts(hosts)
    handler = partial(_Handler, viewer=viewer_folder(), scene=scene_folder(folder), hosts=known)
    try:
        server = _Server((known.address, port), handler)
    except OSError as error:
        way = f"or another address than {known.address} with --host" if known.is_open else "or leave it to reflet"
        raise RefletError(
            f"Port {port} cannot be used ({error.strerror}); choose another with --port, {way}."
        ) from None
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), name="reflet viewer", daemon=True)
    thread.start()
    try:
        yield f"http://{known.here}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _wait() -> None:
    threading.Event().wait()


def _far_from_a_screen() -> bool:
    """In a session by ssh without a display: a browser that draws in the terminal would take it over."""
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    return sys.platform == "linux" and "SSH_CONNECTION" in os.environ and not any(map(os.environ.get, screens))


class _Server(ThreadingHTTPServer):
    def __init__(self, address: tuple[str, int], handler: Any) -> None:
        self.address_family = AF_INET6 if ":" in address[0] else AF_INET
        super().__init__(address, handler)

    def server_bind(self) -> None:
        """Without asking for this machine's name, which may take seconds where names are not known."""
        TCPServer.server_bind(self)
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Browsers leave in the middle of a file whenever they want another: nothing to report."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(SimpleHTTPRequestHandler):
    """Files of the viewer at the root, those of the scene below ``scene/``: no listings, nothing hidden or else."""

    protocol_version = "HTTP/1.1"  # one connection for the hundreds of map files
    extensions_map = {  # noqa: RUF012 - the base class declares it so
        ".html": "text/html; charset=utf-8",
        ".js": "text/javascript; charset=utf-8",
        ".css": "text/css; charset=utf-8",
        ".svg": "image/svg+xml",
        ".png": "image/png",
        ".json": "application/json",
        ".gltf": "model/gltf+json",
        ".avif": "image/avif",
        ".ktx2": "image/ktx2",
        "": "application/octet-stream",
    }

    def __init__(self, *args: Any, viewer: Path, scene: Path, hosts: Hosts) -> None:
        self.viewer, self.scene, self.hosts = viewer, scene, hosts
        self.version = ""
        super().__init__(*args, directory=str(viewer))

    def translate_path(self, path: str) -> str:
        """The file for a URL; one that leaves the two folders, by whatever trick, is none."""
        parts = [part for part in unquote(path.partition("?")[0].partition("#")[0]).split("/") if part]
        root, inside = (
            (self.scene, parts[1:]) if parts[:1] == [SCENE_FOLDER] else (self.viewer, parts or ["index.html"])
        )
        file = root.joinpath(*inside)
        hidden = any(part.startswith(".") or "\\" in part or "\0" in part for part in inside)
        return str(root / ".nowhere" if hidden or not file.is_relative_to(root) else file)

    def send_head(self) -> Any:
        """As the base class, but for known names only, and with versions to the nanosecond: dates in HTTP are of whole
        seconds, too coarse for a scene that is written again while it is looked at."""
        header = self.headers.get("Host", "")
        if not self.hosts.answers(header):
            return self._say(HTTPStatus.FORBIDDEN, self.hosts.refusal(header, self.connection.getsockname()[1]))
        path = self.translate_path(self.path)
        if not os.path.isfile(path):  # false for names that no file can have, where Path raises
            return self._say(HTTPStatus.NOT_FOUND, "There is no such file here.\n")
        status = os.stat(path)
        self.version = f'"{status.st_mtime_ns:x}-{status.st_size:x}"'
        if self.version in [tag.strip().removeprefix("W/") for tag in self.headers.get("If-None-Match", "").split(",")]:
            self.send_response(HTTPStatus.NOT_MODIFIED)
            self.end_headers()
            return None
        del self.headers["If-Modified-Since"]
        return super().send_head()

    def _say(self, status: HTTPStatus, text: str) -> None:
        body = text.encode()
        self.send_response(status)
        self.send_header("Content-Type", "text/plain; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def end_headers(self) -> None:
        """A scene may be written again under the same address: ask each time, send only what changed."""
        if self.version:
            self.send_header("ETag", self.version)
            self.version = ""
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Silence: the terminal shows one address."""
