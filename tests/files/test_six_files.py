"""Six files by the names that tools give them, each set oriented as its tool has it."""

from contextlib import nullcontext
from functools import cache

import numpy as np
import pytest

from reflet.envmap.cube_seams import broken_edges
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import file_facts, read_env_image, write_env_image
from reflet.files.pictures.exr import write_exr
from reflet.files.pictures.six_files import NAMES, siblings_of, six_files
from reflet.scene.builtin.labelled_court import court_radiance, labelled_court

# What Quake's engines draw where: the direction of a picture's point (s to the right, t up), x ahead, y left, z up.
QUAKE = {
    "rt": lambda s, t, one: (one, -s, t),
    "lf": lambda s, t, one: (-one, s, t),
    "bk": lambda s, t, one: (s, one, t),
    "ft": lambda s, t, one: (-s, -one, t),
    "up": lambda s, t, one: (-t, -s, one),
    "dn": lambda s, t, one: (t, -s, -one),
}


@cache
def court(size=64):
    return labelled_court(size, 1)


@cache
def hills(size=64):
    """Light that varies along every edge of the cube, and along no two of them alike."""
    x, y, z = np.moveaxis(CUBE.texel_directions(size)[0], -1, 0)
    light = np.exp(
        np.sin(4.0 * x + 1.0) + np.cos(5.0 * y + 0.5) + np.sin(6.0 * z + 2.0) + np.sin(3.0 * x * y - 2.0 * z)
    )
    return EnvImage(CUBE, np.repeat(light[..., None], 3, -1).astype(np.float32))


def write_quake(folder, size=64):
    """The court as Quake's engines would have it, the court's y, z, x being their z, x, y."""
    t, s = np.meshgrid(
        1.0 - (2.0 * np.arange(size) + 1.0) / size, (2.0 * np.arange(size) + 1.0) / size - 1.0, indexing="ij"
    )
    for name, direction in QUAKE.items():
        x, y, z = direction(s, t, np.ones_like(s))
        ours = np.stack([y, z, x], -1) / np.sqrt(s**2 + t**2 + 1.0)[..., None]
        write_exr(folder / f"unit1_{name}.exr", court_radiance(ours).astype(np.float32))


def test_quakes_names_are_oriented_as_its_engines_draw_them(tmp_path):
    write_quake(tmp_path)
    image = read_env_image(tmp_path)
    # samples at the same points, which rounding moves over a border here and there
    assert np.mean(np.abs(image.texels - court().texels) > 1e-3) < 1e-3
    assert broken_edges(image)[0] == 0


@pytest.mark.parametrize("names", NAMES, ids=lambda names: names[0])
@pytest.mark.parametrize("spelled", [str.lower, str.upper, str.capitalize])
def test_every_set_goes_on_over_its_edges(tmp_path, names, spelled):
    """Any one of the six means all of them; so does the folder."""
    faces = court().texels[[1, 0, 2, 3, 4, 5]][:, :, ::-1]
    for name, face in zip(names, faces, strict=True):
        write_exr(tmp_path / f"sky_{spelled(name)}.exr", np.ascontiguousarray(face))
    for path in (tmp_path, tmp_path / f"sky_{spelled(names[3])}.exr", tmp_path / "sky_{face}.exr"):
        found = six_files(path, [".exr"]) or siblings_of(path, [".exr"])
        assert [file.stem for file in found.paths] == [f"sky_{spelled(name)}" for name in names]
        assert len(found.doubts) == (names[0] == "0")
        doubted = pytest.warns(RefletWarning, match="0 1 2 3 4 5 are taken as px nx py ny pz nz")
        with doubted if found.doubts else nullcontext():
            read = read_env_image(path)
        np.testing.assert_array_equal(read.texels, court().texels)
        assert file_facts(path).layout == "faces"


@pytest.mark.parametrize("names", NAMES, ids=lambda names: names[0])
def test_names_without_anything_between(tmp_path, names):
    for name in names:
        (tmp_path / f"sky{name}.png").touch()
    if names[0] == "r":  # a letter alone ends too many words
        with pytest.raises(RefletError, match="does not name the six files"):
            six_files(tmp_path, [".png"])
    else:
        assert [file.stem for file in six_files(tmp_path, [".png"]).paths] == [f"sky{name}" for name in names]


def test_frames_of_a_film_are_no_cube(tmp_path):
    for number in range(20):
        (tmp_path / f"frame{number:02}.png").touch()
    with pytest.raises(RefletError, match="does not name the six files"):
        six_files(tmp_path, [".png"])
    assert siblings_of(tmp_path / "frame03.png", [".png"]) is None


def test_a_few_numbered_squares_are_no_cube(tmp_path):
    """Levels by roughness, say: nothing is missing beside them."""
    for number in range(5):
        write_exr(tmp_path / f"level_{number}.exr", np.ones((8, 8, 3), np.float32))
    assert read_env_image(tmp_path / "level_0.exr", PARAMETERIZATIONS["angular"]).size == 8
    assert siblings_of(tmp_path / "level_0.exr", [".exr"]) is None


def test_a_square_that_says_what_it_is_stays_that(tmp_path):
    """Beside five others like it: balls numbered from 0 to 5, or pictures twice as wide as high."""
    angular = PARAMETERIZATIONS["angular"]
    for number in range(6):
        write_env_image(tmp_path / f"ball{number}.exr", [EnvImage(angular, np.ones((1, 8, 8, 3), np.float32))])
        write_exr(tmp_path / f"room{number}.exr", np.ones((4, 8, 3), np.float32))
        write_exr(tmp_path / f"told{number}.exr", np.ones((8, 8, 3), np.float32))
    assert read_env_image(tmp_path / "ball2.exr").parameterization == angular
    assert read_env_image(tmp_path / "room2.exr").size == 4
    assert read_env_image(tmp_path / "told2.exr", angular).parameterization == angular
    with pytest.warns(RefletWarning, match="the files 0 1 2 3 4 5 are taken as px nx py ny pz nz"):
        assert read_env_image(tmp_path / "told2.exr").parameterization == CUBE


def test_faces_in_another_order_are_said(tmp_path):
    """Names in Quake's sense where those of front and right were meant, and tops that are turned."""
    faces = hills().texels[[1, 0, 2, 3, 4, 5]][:, :, ::-1]
    for name, face in zip(("rt", "lf", "up", "dn", "ft", "bk"), faces, strict=True):
        write_exr(tmp_path / f"{name}.exr", np.ascontiguousarray(face))
    with pytest.warns(RefletWarning, match="do not go on into each other at 12 of 12 edges that tell; they may be"):
        read_env_image(tmp_path)


def test_edges_that_tell_nothing_are_no_doubt():
    """Faces of one colour each, noise, and maps so small that any two texels differ."""
    colors = np.broadcast_to(np.arange(1.0, 7.0, dtype=np.float32).reshape(6, 1, 1, 1), (6, 64, 64, 3))
    assert broken_edges(EnvImage(CUBE, colors)) == (0, 0)
    noise = np.random.default_rng(3).random((6, 64, 64, 3)).astype(np.float32)
    assert broken_edges(EnvImage(CUBE, noise))[0] == 0
    assert broken_edges(court(16)) == (0, 0)
    assert broken_edges(court())[0] == 0
    turned = hills().texels.copy()
    turned[2] = np.rot90(turned[2], 2)
    assert broken_edges(hills()) == (0, 12)
    assert broken_edges(EnvImage(CUBE, turned))[0] == 4
