"""Scenes and their environments from files."""

from pathlib import Path

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.files.env_image_file import write_env_image
from reflet.files.pictures.exr import write_exr
from reflet.pipelines.load import load_scene

TRIANGLE = "o tip\nv 0 0 3\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 1 0 0\nvn 0 1 0\nf 1//1 2//2 3//3\n"


def write(folder: Path, text: str = TRIANGLE) -> Path:
    (folder / "a.obj").write_text(text)
    write_exr(folder / "sky.exr", np.ones((4, 8, 3), np.float32))
    return folder / "a.obj"


def test_a_scene_with_z_up_is_set_upright(tmp_path: Path) -> None:
    scene = load_scene(write(tmp_path), environment=tmp_path / "sky.exr", up="z")
    mesh = scene.parts[0].mesh
    order = np.argsort(-mesh.positions[:, 1])  # the vertex that was at z = 3 is on top
    np.testing.assert_array_equal(mesh.positions[order], [[0, 3, 0], *mesh.positions[order][1:]])
    assert {tuple(p) for p in mesh.positions.tolist()} == {(0.0, 3.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)}
    at = {tuple(p): tuple(n) for p, n in zip(mesh.positions.tolist(), mesh.normals.tolist(), strict=True)}
    assert at == {
        (0.0, 3.0, 0.0): (0.0, 1.0, 0.0),
        (1.0, 0.0, 0.0): (1.0, 0.0, 0.0),
        (0.0, 0.0, -1.0): (0.0, 0.0, -1.0),
    }
    as_it_is = load_scene(tmp_path / "a.obj", environment=tmp_path / "sky.exr")
    assert as_it_is.parts[0].mesh.positions.max() == 3.0 == as_it_is.parts[0].mesh.positions[:, 2].max()


@pytest.mark.parametrize("name", list(PARAMETERIZATIONS))
@pytest.mark.parametrize("suffix", [".exr", ".dds", ".ktx2"])
def test_the_environment_may_be_a_map_of_any_kind(tmp_path: Path, name: str, suffix: str) -> None:
    kind = PARAMETERIZATIONS[name]
    sky = np.array([0.5, 1.0, 2.0], np.float32) * np.ones((*kind.shape(8), 1), np.float32)
    write_env_image(tmp_path / f"map{suffix}", [EnvImage(kind, sky)])
    scene = load_scene(write(tmp_path), environment=tmp_path / f"map{suffix}", source_is=kind)
    assert scene.environment is not None
    # a constant stays constant; half floats hold these numbers exactly, sums round in the seventh digit
    np.testing.assert_allclose(scene.environment.radiance.reshape(-1, 3), np.tile(sky[0, 0, 0], (
        scene.environment.radiance[..., 0].size, 1)), rtol=2e-5)  # fmt: skip


def test_what_is_told_of_no_environment_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RefletError, match="add --environment FILE"):
        load_scene(write(tmp_path), source_is=PARAMETERIZATIONS["cube"])
    with pytest.raises(RefletError, match="one of y z, not 'up'"):
        load_scene(write(tmp_path), up="up")
    with pytest.raises(RefletError, match="give its name alone"):
        load_scene("teapot-room", up="z")


def test_negative_light_is_none(tmp_path: Path) -> None:
    scene = write(tmp_path)
    picture = np.ones((4, 8, 3), np.float32)
    picture[0] = -1.0
    write_exr(tmp_path / "sky.exr", picture)
    with pytest.warns(UserWarning, match="negative radiance, which is no light, and is taken as 0"):
        assert load_scene(scene, environment=tmp_path / "sky.exr").environment.radiance.min() == 0.0


def test_light_that_is_not_finite_names_the_verb_that_mends_it(tmp_path: Path) -> None:
    scene = write(tmp_path)
    write_exr(tmp_path / "sky.exr", np.full((4, 8, 3), np.inf, np.float32))
    with pytest.raises(RefletError, match="reflet convert --repair"):
        load_scene(scene, environment=tmp_path / "sky.exr")
