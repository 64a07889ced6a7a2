"""The local server gives the viewer and one PEM, to this machine, and nothing else."""

import errno
import http.client
import shutil
from urllib.parse import urlsplit

import pytest
from small_pem import small_pem

from reflet.errors import RefletError
from reflet.pem.container import open_pem, save_pem
from reflet.view import static_files
from reflet.view.export import export_viewer
from reflet.view.server import viewer_server


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A PEM, a stand-in for the built viewer, and a secret beside them."""
    viewer = tmp_path / "viewer"
    viewer.mkdir()
    (viewer / "index.html").write_text("<reflet-viewer>")
    (viewer / "reflet-viewer.js").write_text("script")
    monkeypatch.setattr(static_files, "_VIEWER", viewer)
    save_pem(tmp_path / "pem", small_pem(views=1, size=2))
    (tmp_path / "secret").write_text("secret")
    return tmp_path


def get(address, path, host=None):
    """(status, MIME type, body) of a raw request: the path goes out as it is written."""
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=10)
    connection.putrequest("GET", path, skip_host=host is not None)
    if host is not None:
        connection.putheader("Host", host)
    connection.endheaders()
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, response.headers["Content-Type"], body


def test_files_and_their_types(folder):
    with viewer_server(folder / "pem") as address:
        assert get(address, "/") == (200, "text/html; charset=utf-8", b"<reflet-viewer>")
        assert get(address, "/reflet-viewer.js")[:2] == (200, "text/javascript; charset=utf-8")
        assert get(address, "/scene/scene.gltf")[:2] == (200, "model/gltf+json")
        assert get(address, "/scene/textures/0.png")[:2] == (200, "image/png")
        status, kind, body = get(address, "/scene/maps/0000/0-balls.ktx2?again")
        assert (status, kind) == (200, "image/ktx2")
        assert body == (folder / "pem/maps/0000/0-balls.ktx2").read_bytes()


@pytest.mark.parametrize(
    "path",
    ["/../secret", "/scene/../secret", "/scene/%2e%2e/secret", "/scene/..%2fsecret", "/scene//../secret",
     "/%2e%2e/secret", "/scene/", "/scene/maps/", "/scene/nothing", "/scene/x%00y", "//etc/hostname"],
)  # fmt: skip
def test_nothing_else_is_served(folder, path):
    with viewer_server(folder / "pem") as address:
        assert get(address, path)[0] == 404


def test_other_names_of_this_machine_are_refused(folder):
    """A page elsewhere cannot read the PEM by letting its own name resolve to this address."""
    with viewer_server(folder / "pem") as address:
        assert get(address, "/scene/scene.gltf", host="attacker.example")[0] == 403
        assert get(address, "/scene/scene.gltf", host="localhost:80")[0] == 200


def test_no_pem_no_server(folder):
    with pytest.raises(RefletError, match=r"holds no scene\.gltf"), viewer_server(folder / "viewer"):
        pass


def test_taken_port_is_one_sentence(folder):
    with viewer_server(folder / "pem") as address:
        port = urlsplit(address).port
        with pytest.raises(RefletError, match=f"Port {port} cannot be used"), viewer_server(folder / "pem", port):
            pass


def test_viewer_not_built_is_one_sentence(folder, monkeypatch):
    monkeypatch.setattr(static_files, "_VIEWER", folder / "nowhere")
    with pytest.raises(RefletError, match="make web"), viewer_server(folder / "pem"):
        pass


def test_export_is_a_whole_page(folder):
    index = export_viewer(folder / "pem/scene.gltf", folder / "site")
    assert index.read_text() == "<reflet-viewer>"
    assert (folder / "site/reflet-viewer.js").exists()
    assert len(open_pem(folder / "site/scene").maps[0]) == 3
    assert not (folder / "site/scene/bake.json").exists()
    with pytest.raises(RefletError, match="holds files already"):
        export_viewer(folder / "pem", folder / "site")


@pytest.mark.parametrize("stop", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_page_is_exported_whole_or_not_at_all(folder, monkeypatch, stop):
    copied = []

    def full(source, target):
        if len(copied) == 4:
            raise stop
        copied.append(target)
        target.write_bytes(source.read_bytes())

    (folder / "site").mkdir()
    monkeypatch.setattr(shutil, "copyfile", full)
    expected = pytest.raises(RefletError, match=r"site cannot be written: the disk is full.*\.$")
    with expected if isinstance(stop, OSError) else pytest.raises(KeyboardInterrupt):
        export_viewer(folder / "pem", folder / "site")
    assert len(copied) == 4 and not list((folder / "site").iterdir())
