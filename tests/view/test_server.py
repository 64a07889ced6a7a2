"""The local server gives the viewer and one PEM, to this machine, and nothing else."""

import errno
import getpass
import http.client
import os
import shutil
import socket
import struct
import sys
import threading
import webbrowser
from urllib.parse import urlsplit

import pytest
from small_pem import small_pem

from reflet.errors import RefletError
from reflet.pem.container import open_pem, save_pem
from reflet.view import server, static_files
from reflet.view.export import export_viewer
from reflet.view.hosts import read_hosts, ways_in
from reflet.view.server import serve, viewer_server


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


def ask(address, path, method="GET", **headers):
    """(status, headers, body) of a raw request: the path goes out as it is written."""
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=10)
    connection.putrequest(method, path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    response = connection.getresponse()
    body = response.read()
    connection.close()
    return response.status, response.headers, body


def get(address, path, **headers):
    """(status, MIME type, body)."""
    status, found, body = ask(address, path, **headers)
    return status, found["Content-Type"], body


def test_files_and_their_types(folder):
    with viewer_server(folder / "pem") as address:
        assert get(address, "/") == (200, "text/html; charset=utf-8", b"<reflet-viewer>")
        assert get(address, "/reflet-viewer.js")[:2] == (200, "text/javascript; charset=utf-8")
        assert get(address, "/scene/scene.gltf")[:2] == (200, "model/gltf+json")
        assert get(address, "/scene/textures/0.png")[:2] == (200, "image/png")
        status, kind, body = get(address, "/scene/maps/0000/0-balls.avif?again")
        assert (status, kind) == (200, "image/avif")
        assert body == (folder / "pem/maps/0000/0-balls.avif").read_bytes()


@pytest.mark.parametrize(
    "path",
    ["/../secret", "/scene/../secret", "/scene/%2e%2e/secret", "/scene/..%2fsecret", "/scene//../secret",
     "/%2e%2e/secret", "/scene/", "/scene/maps/", "/scene/nothing", "/scene/x%00y", "//etc/hostname", "//[/",
     "/scene/" + 300 * "x", "/scene/.hidden/key"],
)  # fmt: skip
def test_nothing_else_is_served(folder, path):
    (folder / "pem/.hidden").mkdir()
    (folder / "pem/.hidden/key").write_text("secret")
    with viewer_server(folder / "pem") as address:
        assert get(address, path)[0] == 404


@pytest.mark.parametrize(
    "host", ["attacker.example", "attacker.example:80", "localhost.attacker.example", "localhost@attacker.example",
             "", ":80", "[::1", "a b", "notlocalhost", "127.0.0.1.attacker.example"],
)  # fmt: skip
def test_other_names_are_refused(folder, host):
    """A page elsewhere cannot read the PEM by letting its own name resolve to this address."""
    with viewer_server(folder / "pem") as address:
        status, kind, body = get(address, "/scene/scene.gltf", Host=host)
        assert (status, kind) == (403, "text/plain; charset=utf-8")
        assert b"reflet does not answer requests by th" in body


@pytest.mark.parametrize(
    "host", ["localhost", "localhost:80", "LOCALHOST:8000", "localhost.", "pem.localhost:1", "127.0.0.1", "[::1]:80",
             "[::1]", "192.168.0.7:8000"],
)  # fmt: skip
def test_this_machines_names_and_addresses_are_answered(folder, host):
    with viewer_server(folder / "pem") as address:
        assert get(address, "/scene/scene.gltf", Host=host)[0] == 200


def test_who_is_refused_is_told_why_and_how_to_come_in(folder):
    """The tunnel's command can be pasted; a strange name is not repeated."""
    with viewer_server(folder / "pem") as address:
        port = urlsplit(address).port
        said = get(address, "/", Host="hub.example.org")[2].decode()
        assert "requests by the name hub.example.org: a page elsewhere could use it to read" in said
        assert f"open {address}\n" in said
        assert f"run ssh -N -L {port}:127.0.0.1:{port} hub.example.org and open http://localhost:{port}/" in said
        assert "with --host hub.example.org" in said
        strange = get(address, "/", Host="$(reboot)")[2].decode()
        assert "reboot" not in strange and "with --host NAME" in strange


def test_names_that_are_given_are_answered(folder):
    with viewer_server(folder / "pem", hosts=["Hub.example.org", "lab_box"]) as address:
        assert address.startswith("http://127.0.0.1:")
        for host in ("hub.example.org", "hub.example.org:443", "lab_box", "localhost"):
            assert get(address, "/", Host=host)[0] == 200
        assert get(address, "/", Host="other.example.org")[0] == 403


@pytest.mark.parametrize(("host", "here"), [("0.0.0.0", "127.0.0.1"), ("::1", "[::1]"), ("[::]", "[::1]")])
def test_other_addresses_are_listened_on(folder, host, here):
    if ":" in host and not has_ipv6():
        pytest.skip("needs IPv6")
    with viewer_server(folder / "pem", hosts=[host]) as address:
        assert address.startswith(f"http://{here}:")
        assert get(address, "/")[0] == 200
        open_to_all = host != "::1"
        assert get(address, "/", Host=f"{socket.gethostname()}:80")[0] == (200 if open_to_all else 403)
        assert get(address, "/", Host="attacker.example")[0] == 403


def has_ipv6():
    try:
        with socket.socket(socket.AF_INET6) as trial:
            trial.bind(("::1", 0))
    except OSError:
        return False
    return True


@pytest.mark.parametrize(
    ("hosts", "said"),
    [
        (["http://hub.example.org/"], "--host takes a name or an address alone"),
        (["hub.example.org:80"], "--host takes a name or an address alone"),
        (["127.0.0.1", "0.0.0.0"], r"One address can be listened on, not 0\.0\.0\.0 and 127\.0\.0\.1"),
        (["192.0.2.1"], r"cannot be used \(.*\); choose another with --port, or another address than 192\.0\.2\.1"),
    ],
)
def test_hosts_that_cannot_be_used_are_one_sentence(folder, hosts, said):
    with pytest.raises(RefletError, match=said), viewer_server(folder / "pem", hosts=hosts):
        pass


def test_ways_in_from_elsewhere():
    """In a session by ssh the command names this machine as the other side knows it, and ssh's port."""
    assert ways_in(read_hosts([]), 8000, {}) == ""
    said = ways_in(read_hosts([]), 8000, {"SSH_CONNECTION": "198.51.100.7 50000 192.0.2.1 2222"})
    user = getpass.getuser()
    assert f"run: ssh -N -L 8000:127.0.0.1:8000 -p 2222 {user}@192.0.2.1\nand open http://localhost:8000/" in said
    assert "over https only" in ways_in(read_hosts(["0.0.0.0"]), 8000, {})


@pytest.mark.parametrize("far", [False, True])
def test_no_browser_opens_within_a_terminal(folder, monkeypatch, capsys, far):
    """In a session by ssh without a display Python would open one that draws in text, over what is printed."""
    opened = []

    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SSH_CONNECTION"):
        monkeypatch.delenv(name, raising=False)
    if far:
        monkeypatch.setenv("SSH_CONNECTION", "198.51.100.7 50000 192.0.2.1 22")
    monkeypatch.setattr(server, "_wait", interrupt)
    serve(folder / "pem", name="it")
    address, *ways = filter(None, capsys.readouterr().out.splitlines())
    assert address.endswith("/ shows it; Ctrl-C ends it.")
    assert opened == ([] if far else [address.split()[0]])
    assert [way for way in ways if "ssh -N -L" in way] == (ways[:1] if far else [])


def test_only_what_changed_is_sent_again(folder):
    """Even within the second that dates in HTTP count in."""
    file = folder / "pem/bytes"
    file.write_bytes(b"one")
    with viewer_server(folder / "pem") as address:
        _, headers, _ = ask(address, "/scene/bytes")
        tag, date = headers["ETag"], headers["Last-Modified"]
        status, headers, body = ask(address, "/scene/bytes", If_None_Match=tag, If_Modified_Since=date)
        assert (status, headers["ETag"], body) == (304, tag, b"")
        times = file.stat()
        file.write_bytes(b"two")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns + 1000))
        for conditions in ({"If_None_Match": tag, "If_Modified_Since": date}, {"If_Modified_Since": date}):
            assert ask(address, "/scene/bytes", **conditions)[::2] == (200, b"two")


def test_heads_and_ranges(folder):
    """A range may be answered with the whole file, as long as that is said."""
    (folder / "pem/a file.bin").write_bytes(b"0123456789")
    with viewer_server(folder / "pem") as address:
        status, headers, body = ask(address, "/scene/a%20file.bin", "HEAD")
        assert (status, headers["Content-Length"], headers["Content-Type"], body) == (
            200, "10", "application/octet-stream", b"")  # fmt: skip
        assert ask(address, "/scene/nothing", "HEAD")[::2] == (404, b"")
        status, headers, body = ask(address, "/scene/a%20file.bin", Range="bytes=2-3")
        assert (status, headers["Accept-Ranges"], body) == (200, None, b"0123456789")


def test_browsers_that_leave_are_no_error(folder, capfd):
    (folder / "pem/large").write_bytes(bytes(8 * 2**20))  # more than sockets buffer
    with viewer_server(folder / "pem") as address:
        with socket.create_connection(("127.0.0.1", urlsplit(address).port)) as browser:
            browser.sendall(b"GET /scene/large HTTP/1.1\r\nHost: localhost\r\n\r\n")
            browser.recv(10)
            browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # leave at once
        for thread in threading.enumerate():
            if "process_request" in thread.name:
                thread.join(10)
        assert get(address, "/")[0] == 200
    assert capfd.readouterr() == ("", "")


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


def test_an_exported_page_is_served_like_its_scene(folder):
    export_viewer(folder / "pem", folder / "site")
    with viewer_server(folder / "site") as address:
        assert get(address, "/scene/scene.gltf")[2] == (folder / "pem/scene.gltf").read_bytes()


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
