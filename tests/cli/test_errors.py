"""Bad input gets one sentence on stderr and exit status 2."""

import shlex
from pathlib import Path

import pytest

from reflet.cli import main as command_line
from reflet.cli.main import main


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one sentence that a command is refused with."""
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    assert stop.value.code == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("Warning: ")]
    assert len(lines) == 1 and "Traceback" not in lines[0]
    return lines[0]


def bake(capsys: pytest.CaptureFixture[str], scene: str | Path, out: Path, *more: str | Path) -> str:
    return refused(capsys, "bake", scene, "--image-size", "32", "--em-size", "16", "--spp", "1", "--out", out, *more)


def test_missing_files_are_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    assert "nowhere.glb" in bake(capsys, tmp_path / "nowhere.glb", tmp_path / "out")
    assert "nowhere.hdr" in bake(capsys, scene_files[0], tmp_path / "out", "--environment", tmp_path / "nowhere.hdr")


def test_what_is_no_scene_is_told_what_scenes_are(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "teapot-room" in bake(capsys, "scene.blend", tmp_path / "out")


@pytest.mark.parametrize("length", [0, 11, 40])
def test_a_truncated_glb(capsys: pytest.CaptureFixture[str], tmp_path: Path, length: int) -> None:
    whole = b"glTF\x02\x00\x00\x00\x40\x01\x00\x00\x34\x00\x00\x00JSON" + b'{"asset":{"version":"2.0"},' + b" " * 200
    (tmp_path / "cut.glb").write_bytes(whole[:length])
    assert "cut.glb" in bake(capsys, tmp_path / "cut.glb", tmp_path / "out")


def test_positions_that_are_no_numbers(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    scene = tmp_path / "nan.obj"
    scene.write_text("o bad\nv 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n")
    assert "nan.obj" in bake(capsys, scene, tmp_path / "out", "--environment", scene_files[1])


def test_a_part_that_is_not_there(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    (tmp_path / "wall.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\n")
    scene = tmp_path / "wall.obj"
    scene.write_text("mtllib wall.mtl\no wall\nusemtl wall\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    unknown = bake(capsys, scene, tmp_path / "out", "--environment", scene_files[1], "--reflect", "vase")
    assert "vase" in unknown and "wall" in unknown


def test_no_light(capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]) -> None:
    assert "--environment" in bake(capsys, scene_files[0], tmp_path / "out")


def test_a_camera_inside_the_object(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    inside = bake(
        capsys, scene_files[0], tmp_path / "out", "--environment", scene_files[1], "--target", "0.5,0.2,0",
        "--distance", "0.05",
    )  # fmt: skip
    assert "inside" in inside


def test_sizes_and_views_that_make_no_sense(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    light = ("--environment", scene_files[1])
    assert "power of two" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--em-size", "100")
    assert "memory" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--em-size", "8192")
    assert "--views" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--views", "-1")
    assert "turn" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--views", "100", "--spacing", "10")
    assert "add --floor." in bake(capsys, scene_files[0], tmp_path / "out", *light, "--floor-height", "2")
    assert "add --floor." in bake(capsys, scene_files[0], tmp_path / "out", *light, "--floor-roughness", "0")
    assert "make it polished" in bake(
        capsys, scene_files[0], tmp_path / "out", *light, "--floor", "--floor-roughness", "0.1"
    )
    assert "'matte', 'polished', 'shadow'" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--floor", "wet")
    assert "without --floor" in bake(capsys, "teapot-room", tmp_path / "out", "--floor")
    twice = ("--axis", "distance=1:2:2", "--axis", "distance=2:3:2")
    assert "given once; they are distance, distance" in bake(capsys, scene_files[0], tmp_path / "out", *light, *twice)
    assert "no axis 'light'" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--axis", "light=0:1:2")
    both = ("--axis", "azimuth_deg=0:9:2", "--views", "3")
    assert "given twice" in bake(capsys, scene_files[0], tmp_path / "out", *light, *both)
    assert "--static, or --views" in bake(capsys, scene_files[0], tmp_path / "out", *light, "--static", "--views", "2")


def test_a_folder_that_cannot_be_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    (tmp_path / "file").write_text("not a folder")
    assert "file" in bake(capsys, scene_files[0], tmp_path / "file" / "out", "--environment", scene_files[1])
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.doc").write_text("mine")
    assert "full" in bake(capsys, scene_files[0], tmp_path / "full", "--environment", scene_files[1])


@pytest.mark.parametrize("verb", ["info", "render", "compare", "verify", "view"])
def test_a_folder_that_is_no_pem(capsys: pytest.CaptureFixture[str], tmp_path: Path, verb: str) -> None:
    more = ["-o", tmp_path / "view.png"] if verb == "render" else []
    assert str(tmp_path) in refused(capsys, verb, tmp_path, *more)


def test_a_picture_of_an_unknown_kind(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "view.gif" in refused(capsys, "render", tmp_path, "-o", tmp_path / "view.gif")


def test_ctrl_c_tells_how_to_go_on(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command_line.commands, "main", interrupted)
    with pytest.raises(SystemExit) as stop:
        main(["bake", "my scene.glb", "--out", "pem"])
    assert stop.value.code == 130
    assert "reflet bake 'my scene.glb' --out pem --resume" in capsys.readouterr().err


def test_a_mesh_without_triangles(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    empty = tmp_path / "empty.gltf"
    empty.write_text('{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"name": "camera"}]}')
    said = refused(capsys, "view", empty, "--material", "gooch", "--no-browser")
    assert said == f"reflet: {empty} holds no triangles; export it with its meshes."


def test_a_folder_where_a_file_is_meant_and_a_file_where_a_folder_is(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    (tmp_path / "room.glb").mkdir()
    (tmp_path / "file.exr").write_text("")
    assert "room.glb is a folder" in bake(capsys, tmp_path / "room.glb", tmp_path / "out")
    assert "neither a PEM nor six files" in refused(capsys, "info", tmp_path / "room.glb")
    assert "it is a file" in refused(capsys, "verify", tmp_path / "file.exr")
    assert "reflet view teapot" in refused(capsys, "view", tmp_path / "file.exr")
    assert "does not exist" in refused(capsys, "compare", tmp_path / "nothing")
    pasted = refused(capsys, "view", scene_files[1].rename(tmp_path / "my sky's.exr"))
    (tmp_path / "my sky's.exr").rename(scene_files[1])
    assert shlex.split(pasted.partition(": ")[2].rpartition("mesh: ")[2])[-1] == str(tmp_path / "my sky's.exr")


def test_a_variant_that_is_not_there_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, scene_files: tuple[Path, Path]
) -> None:
    import mitsuba as mi

    def missing(_: str) -> None:
        raise ImportError("the CUDA backend hasn't been initialized")

    monkeypatch.setattr(mi, "set_variant", missing)
    light = ("--environment", scene_files[1])
    said = bake(capsys, scene_files[0], tmp_path / "out", *light, "--variant", "cuda")
    assert "NVIDIA" in said and "--variant llvm" in said
    assert not (tmp_path / "out").exists()


def test_usage_errors_are_sentences(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert refused(capsys, "join", "a.exr", "-o", "b.exr", "--circle", "1,2").endswith(
        "not '1,2'. Try reflet join --help."
    )
    assert "table:FILE.npz" in refused(capsys, "prefilter", "a.exr", "--brdf", "table:", "-o", tmp_path / "out")


def test_results_that_cannot_be_written_are_refused_before_the_work(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    from small_pem import small_pem

    from reflet.pem.container import save_pem

    def worked(*_: object, **__: object) -> None:
        raise AssertionError("the work was begun")

    monkeypatch.setattr("reflet.pipelines.compare.compare", worked)
    monkeypatch.setattr("reflet.pipelines.verify.verify", worked)
    save_pem(tmp_path / "pem", small_pem())
    (tmp_path / "file").write_text("")
    for option, name in (("--json", "a.json"), ("--figure", "a.png"), ("--page", "a.html"), ("--images", "pictures")):
        assert "stands where the folder" in refused(
            capsys, "compare", tmp_path / "pem", option, tmp_path / "file" / name
        )
    assert "stands where the folder" in refused(capsys, "verify", tmp_path / "pem", "--json", tmp_path / "file/a.json")
    assert "A figure is a .png" in refused(capsys, "compare", tmp_path / "pem", "--figure", tmp_path / "a.jpg")
    assert "A page is a .html" in refused(capsys, "compare", tmp_path / "pem", "--page", tmp_path / "a")
    assert "finite numbers" in refused(capsys, "render", tmp_path / "pem", "--azimuth", "nan", "-o", tmp_path / "a.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "pem"]
