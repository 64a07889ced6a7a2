"""`reflet join`: two photographs, or one of two circles, become a map."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from verbs import reflet, refused, sky

from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.exr import read_exr, write_exr


def fisheyes(folder: Path, fov: float = 190.0, size: int = 96) -> tuple[Path, Path]:
    """Equidistant pictures of the sky to the front (+z) and to the back."""
    at = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    right, up = np.meshgrid(at, -at)
    radius = np.hypot(right, up)
    theta = radius * np.radians(fov / 2.0)
    ahead = np.stack([-right / radius * np.sin(theta), up / radius * np.sin(theta), np.cos(theta)], -1)
    write_exr(folder / "front.exr", sky(ahead))
    write_exr(folder / "back.exr", sky(ahead * [-1.0, 1.0, -1.0]))
    return folder / "front.exr", folder / "back.exr"


@pytest.mark.parametrize("to", ["dual_paraboloid", "cube", "latlong"])
def test_join_gives_the_sky_back(tmp_path: Path, to: str) -> None:
    out = tmp_path / "joined.exr"
    assert reflet("join", *fisheyes(tmp_path), "--fov", "190", "--to", to, "-o", out) == 0
    image = read_env_image(out)
    direction, valid = image.parameterization.texel_directions(image.size)
    # The outermost 1.5 pixels, of 2 degrees each, are continued, where alpha is at most 0.15: 0.15·0.026·0.5.
    assert np.abs(image.texels - sky(direction))[valid].max() < 3e-3


@pytest.mark.parametrize("arrangement", ["beside", "below", "circles"])
def test_join_takes_one_picture_of_two_circles(tmp_path: Path, arrangement: str) -> None:
    """What 360° cameras write, and two circles anywhere in a picture."""
    circles = [read_exr(path) for path in fisheyes(tmp_path)]
    at = (np.arange(96) + 0.5) / 48 - 1.0
    outside = np.hypot(at, at[:, None]) > 1.0
    for circle in circles:
        circle[outside] = 0.0
    out, more = tmp_path / "joined.exr", []
    if arrangement == "circles":
        both = np.concatenate([circles[1], np.zeros((96, 20, 3), np.float32), circles[0]], 1)
        more = ["--circle", "164,48,48", "--back-circle", "48,48,48"]
    else:
        both = np.concatenate(circles, 1 if arrangement == "beside" else 0)
    write_exr(tmp_path / "both.exr", both)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert reflet("join", tmp_path / "both.exr", "--fov", "190", "--to", "cube", *more, "-o", out) == 0
    image = read_env_image(out)
    assert np.abs(image.texels - sky(image.parameterization.texel_directions(image.size)[0])).max() < 3e-3  # as above


def test_join_says_what_it_doubts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A lat-long map is no picture of two circles, and eight bits cut lamps."""
    Image.fromarray(np.full((32, 64, 3), 255, np.uint8)).save(tmp_path / "both.png")
    assert reflet("join", tmp_path / "both.png", "-o", tmp_path / "out.exr") == 0
    said = capsys.readouterr().err
    assert "is taken for two circles beside each other, though it is not dark in the corners" in said
    assert "holds no radiance above 1: 100 % of its light is there" in said


def test_join_turns_the_back_camera(tmp_path: Path) -> None:
    front, back = fisheyes(tmp_path, fov=250.0)
    rolled = tmp_path / "rolled.exr"  # a camera rolled by 90 degrees clockwise sees the world turned counter-clockwise
    write_exr(rolled, np.rot90(read_exr(back)))
    out = tmp_path / "joined.exr"
    assert reflet("join", front, rolled, "--fov", "250", "--back-turn", "180,0,90", "-o", out) == 0
    image = read_env_image(out)
    direction, valid = image.parameterization.texel_directions(image.size)
    assert np.abs(image.texels - sky(direction))[valid].max() < 2e-3


def test_join_reads_photographs_as_srgb(tmp_path: Path) -> None:
    Image.fromarray(np.full((64, 64, 3), 188, np.uint8)).save(tmp_path / "grey.png")  # sRGB 188 is 0.503 linear
    assert reflet("join", tmp_path / "grey.png", "-o", tmp_path / "grey.exr") == 0
    assert read_env_image(tmp_path / "grey.exr").texels == pytest.approx(0.503, abs=5e-4)


def test_hemispheres_that_make_no_sense(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    front, back = fisheyes(tmp_path)
    out = ("-o", tmp_path / "out.exr")
    assert "120" in refused(capsys, "join", front, back, "--fov", "120", *out)
    assert "16384 rows" in refused(capsys, "join", front, back, "--size", "10000000", *out)
    assert "circle" in refused(capsys, "join", front, back, "--circle", "20,20,-3", *out)
    assert "neither" in refused(capsys, "join", front, back, "--back-turn", "90,0,0", *out)
    assert "balanced" in refused(capsys, "join", front, back, "--balance", *out)
    assert "out.gif" in refused(capsys, "join", front, back, "-o", tmp_path / "out.gif")
    assert not (tmp_path / "out.exr").exists()
