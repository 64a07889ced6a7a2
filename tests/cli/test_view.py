"""``reflet view`` with a mesh: what it writes and serves, and what it refuses."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from verbs import reflet, refused

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.files.env_image_file import write_env_image
from reflet.files.measured_brdf_file import write_measured_brdf
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.brdfs.measured_brdf import tabulate
from reflet.view import static_files


@pytest.fixture
def environment(tmp_path: Path) -> Path:
    """A grey environment of 16 rows."""
    path = tmp_path / "grey.hdr"
    write_env_image(path, [EnvImage(LatLong(), np.full((1, 16, 32, 3), 0.5, np.float32))])
    return path


@pytest.fixture(autouse=True)
def viewer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for the built viewer."""
    (tmp_path / "viewer").mkdir()
    (tmp_path / "viewer/index.html").write_text("<reflet-viewer>")
    monkeypatch.setattr(static_files, "_VIEWER", tmp_path / "viewer")


def extension(folder: Path) -> dict:
    """What the exported scene says beyond glTF."""
    return json.loads((folder / "scene/scene.gltf").read_bytes())["extensions"][static_files.SHADED_EXTENSION]


def test_the_command_says_how_an_exported_page_is_looked_at(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a command that can be pasted and works: of an exported page, `reflet view` shows the scene in it."""
    site = tmp_path / "my site"
    assert reflet("view", "sphere", "--material", "gooch", "--export", site) == 0
    said = capsys.readouterr().out
    assert f"{site}/index.html is written" in said and "opened as a file it draws nothing" in said
    *_, last = said.splitlines()
    command = shlex.split(last.partition("Look at it with: ")[2])
    assert command == ["reflet", "view", str(site)]
    monkeypatch.setattr("reflet.view.server.serve", lambda folder, **_: print(static_files.scene_folder(folder)))
    assert reflet(*command[1:]) == 0
    assert capsys.readouterr().out == f"{site}/scene\n"


def test_export_of_a_mesh_in_an_environment(environment: Path, tmp_path: Path) -> None:
    assert reflet("view", "sphere", environment, "--material", "ggx:0.3", "--export", tmp_path / "site") == 0
    written = extension(tmp_path / "site")
    assert written["materials"] == [{"kind": "ggx", "baseColor": [1, 1, 1], "metallic": 0, "roughness": 0.3}]
    assert written["environment"]["size"] == 64  # the least: a lamp may be painted into it
    assert (tmp_path / "site/scene" / written["environment"]["uri"]).exists()


def test_drawings_need_no_environment(tmp_path: Path) -> None:
    assert reflet("view", "sphere", "--material", "gooch", "--export", tmp_path / "site") == 0
    written = extension(tmp_path / "site")
    assert written["materials"] == [{"kind": "map", "map": "gooch"}]
    assert [(item["name"], item["lookup"]) for item in written["maps"]] == [("gooch", "view_normal")]


def test_a_map_shown_as_it_is(environment: Path, tmp_path: Path) -> None:
    assert reflet("view", "sphere", environment, "--material", "map:normal", "--export", tmp_path / "site") == 0
    (item,) = extension(tmp_path / "site")["maps"]
    assert (item["lookup"], item["parameterization"], item["size"]) == ("normal", "latlong", 16)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """A white paper's BRDF."""
    path = tmp_path / "paper.npz"
    write_measured_brdf(path, tabulate(Lambert(), 4, 5))
    return path


def test_a_table_is_filtered_into_layers_by_view_angle(environment: Path, table: Path, tmp_path: Path) -> None:
    assert reflet("view", "sphere", environment, "--material", f"table:{table}", "--export", tmp_path / "site") == 0
    written = extension(tmp_path / "site")
    assert written["materials"] == [{"kind": "table", "table": "paper.npz"}]
    (item,) = written["tables"]
    assert (item["slices"], item["lobes"]["shape"]) == (24, [3, 12, 4])  # glossy and retro lobes; and the diffuse one
    assert str(tmp_path) not in (tmp_path / "site/scene/scene.gltf").read_text()  # a page tells nothing of this machine
    # 8 bytes a texel of 24 octahedral maps, and a third more for mip levels.
    texels = 24 * item["size"] ** 2 * 4 / 3
    assert (tmp_path / "site/scene" / item["uri"]).stat().st_size == pytest.approx(8 * texels, rel=0.03, abs=1500)


def test_what_cannot_be_shown_is_one_sentence(
    capsys: pytest.CaptureFixture[str], environment: Path, table: Path, tmp_path: Path
) -> None:
    assert "needs an environment map" in refused(capsys, "view", "sphere")
    assert "lit by an environment" in refused(capsys, "view", "sphere", "--material", "mirror")
    assert "plastic" in refused(capsys, "view", "sphere", environment, "--material", "plastic")
    assert "one material" in refused(capsys, "view", "sphere", environment, "--material", "gltf")
    assert "needs its file" in refused(capsys, "view", "sphere", environment, "--material", "table:")
    twice = ("--material", f"table:{table}") * 2
    assert "two are paper.npz" in refused(capsys, "view", "sphere", environment, *twice)
    assert "chair.stl" in refused(capsys, "view", tmp_path / "chair.stl", environment)
