"""The verb prefilter."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from reflet.cli.main import main
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.files.env_image_file import read_env_image, read_levels, write_env_image
from reflet.files.measured_brdf_file import write_measured_brdf
from reflet.files.pictures.exr import write_exr
from reflet.files.textures.ktx1 import read_ktx1_texture
from reflet.files.textures.ktx2_container import read_texture
from reflet.pipelines.engine_maps import ENGINES
from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf

LATLONG = PARAMETERIZATIONS["latlong"]


def reflet(*arguments: str | Path) -> int:
    """Exit status of one command, run within this process."""
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code or 0


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one sentence that a command is refused with."""
    assert reflet("prefilter", *arguments) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("reflet: ") and "Traceback" not in lines[0]
    return lines[0]


def linear(direction: np.ndarray) -> np.ndarray:
    """1 + ω/2 along an axis of its own for each channel."""
    return (1.0 + 0.5 * direction).astype(np.float32)


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    write_env_image(tmp_path / "studio.exr", [EnvImage(LATLONG, linear(LATLONG.texel_directions(64)[0]))])
    return tmp_path / "studio.exr"


@pytest.mark.parametrize(
    ("brdf", "moment"),
    # ∫ k·cos θ dω; GGX and sheen of roughness 1 and 1/√2: k of α = 1 is diffuse's, of Charlie's α = ½ 6/2π·w·(1 - w)
    [("diffuse", 2 / 3), ("phong:50", 51 / 52), ("ggx:1", 2 / 3), ("sheen:0.70710678", 0.5)],
)
@pytest.mark.parametrize(("name", "to"), [("a.ktx2", None), ("a.exr", "octahedral"), ("a.hdr", None)])
def test_one_lobe_in_any_file(
    studio: Path, tmp_path: Path, brdf: str, moment: float, name: str, to: str | None
) -> None:
    more = ("--parameterization", to) if to else ()
    assert reflet("prefilter", studio, "--brdf", brdf, "--size", "16", *more, "-o", tmp_path / name) == 0
    levels = read_levels(tmp_path / name)
    assert levels[0].parameterization.name == (to or ("cube" if name == "a.ktx2" else "latlong"))
    assert [level.size for level in levels] == ([16, 8, 4, 2, 1] if name == "a.ktx2" else [16])
    expected = 1.0 + 0.5 * moment * levels[0].parameterization.texel_directions(16)[0]
    # 0.1 % is promised of the filter; RGBE's step is 1/256 of the brightest channel, half float's 1/2048.
    np.testing.assert_allclose(levels[0].texels, expected, rtol=1e-3, atol=6e-3 if name == "a.hdr" else 1e-3)


@pytest.mark.parametrize("brdf", ["ggx", "sheen"])
def test_levels_by_roughness(studio: Path, tmp_path: Path, brdf: str) -> None:
    out = ("--size", "32", "--levels", "4")
    assert reflet("prefilter", studio, "--brdf", brdf, *out, "-o", tmp_path / "a.ktx2") == 0
    levels = read_levels(tmp_path / "a.ktx2")
    assert [level.size for level in levels] == [32, 16, 8, 4]
    # The rougher, the less contrast; level 0 of GGX is a mirror's: the environment itself.
    contrast = [float(level.texels[..., 1].max() - level.texels[..., 1].min()) for level in levels]
    assert contrast == sorted(contrast, reverse=brdf == "ggx")
    if brdf == "ggx":
        np.testing.assert_allclose(levels[0].texels, linear(CUBE.texel_directions(32)[0]), atol=2e-3)
    pictures = ("--parameterization", "cube", "-o", tmp_path / "a_{level}.exr")
    assert reflet("prefilter", studio, "--brdf", brdf, *out, *pictures) == 0
    for number, level in enumerate(levels):  # half float against float
        np.testing.assert_allclose(read_env_image(tmp_path / f"a_{number}.exr").texels, level.texels, rtol=1e-3)


def test_defaults_need_no_more_than_a_name(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert reflet("prefilter", studio, "--brdf", "ggx", "-o", tmp_path / "a.ktx2") == 0
    assert "cube, 256 rows a face, 5 levels by roughness" in capsys.readouterr().out
    assert [level.size for level in read_levels(tmp_path / "a.ktx2")] == [256, 128, 64, 32, 16]


def test_spherical_harmonics(studio: Path, tmp_path: Path) -> None:
    assert reflet("prefilter", studio, "--sh", tmp_path / "sh.json") == 0
    said = json.loads((tmp_path / "sh.json").read_text())
    # L = 1 + ω_c/2 in channel c: √4π in band 0, and ½·√(4π/3) in band 1, whose orders are y, z, x: channels 1, 2, 0.
    expected = np.zeros((9, 3))
    expected[0] = np.sqrt(4.0 * np.pi)
    expected[[1, 2, 3], [1, 2, 0]] = 0.5 * np.sqrt(4.0 * np.pi / 3.0)
    np.testing.assert_allclose(said["radiance"], expected, atol=3e-3)  # texels of 3°: 2e-3
    polynomial = np.zeros((9, 3))
    polynomial[0], polynomial[[1, 2, 3], [1, 2, 0]] = 1.0, 1.0 / 3.0
    np.testing.assert_allclose(said["irradiance_polynomial"], polynomial, atol=1e-3)
    np.testing.assert_allclose(said["irradiance_over_pi"][1][1], expected[1, 1] * 2 / 3, atol=2e-3)


def nearest(level: EnvImage, face: int, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Texels nearest to (s, t) of a face, from the upper left corner."""
    column, row = (np.clip(((1.0 + x) * 0.5 * level.size).astype(int), 0, level.size - 1) for x in (s, t))
    return level.texels[face, row, column]


def test_gltf_files_are_oriented_as_the_sample_viewers(studio: Path, tmp_path: Path) -> None:
    """Khronos's sampler draws face f's texel (s, t) from the panorama at u = ½ + atan2(z, x)/2π, v = 1 - acos(y)/π from
    the top, of the direction below, which has y upside down; all of its faces written out, not taken from our table."""
    picture = np.random.default_rng(0).random((64, 128, 3)).astype(np.float32)
    picture = np.repeat(np.repeat(picture[::8, ::8], 8, 0), 8, 1)
    write_exr(tmp_path / "noise.exr", picture)
    assert reflet("prefilter", tmp_path / "noise.exr", "--engine", "gltf", "--size", "64", "-o", tmp_path / "out") == 0
    levels = read_levels(tmp_path / "out" / "ggx" / "specular.ktx2")
    # u_MipCount is log2 of the width, the LOD roughness·(u_MipCount - 1): as many levels, the last of roughness 1.
    assert [level.size for level in levels] == [64, 32, 16, 8, 4, 2]
    sheen = read_levels(tmp_path / "out" / "charlie" / "sheen.ktx2")
    assert [level.size for level in sheen] == [level.size for level in levels]
    diffuse = read_levels(tmp_path / "out" / "lambertian" / "diffuse.ktx2")
    assert len(diffuse) == 1
    s, t = np.random.default_rng(1).uniform(-0.95, 0.95, (2, 400))
    one = np.ones_like(s)
    faces = [(one, t, -s), (-one, t, s), (s, -one, t), (s, one, -t), (s, t, one), (-s, t, -one)]
    ratios = []
    for face, scan in enumerate(faces):
        x, y, z = scan / np.linalg.norm(scan, axis=0)
        u, v = 0.5 + np.arctan2(z, x) / (2.0 * np.pi), 1.0 - np.arccos(y) / np.pi
        seen = picture[np.minimum((v * 64).astype(int), 63), np.minimum((u * 128).astype(int), 127)]
        ratios.append(np.abs(nearest(levels[0], face, s, t) - seen).mean())
    # Blocks of 22° against texels of 1.4°: one lookup in ten falls on an edge; noise misplaced differs by 1/3.
    assert max(ratios) < 0.06
    # Level of roughness 1: the diffuse map, at its own directions.
    expected = read_env_image(tmp_path / "out" / "lambertian" / "diffuse.ktx2").texels
    np.testing.assert_allclose(levels[-1].texels.mean((0, 1, 2)), expected.mean((0, 1, 2)), rtol=0.02)  # 2² of 64²


def test_filament_files(studio: Path, tmp_path: Path) -> None:
    assert reflet("prefilter", studio, "--engine", "filament", "--size", "64", "-o", tmp_path / "studio") == 0
    folder = tmp_path / "studio"
    assert sorted(path.name for path in folder.iterdir()) == ["sh.txt", "studio_ibl.ktx", "studio_skybox.ktx"]
    texture = read_ktx1_texture(folder / "studio_ibl.ktx")
    assert (texture.texel_format.name, texture.rows, len(texture.levels)) == ("r11g11b10f", 64, 3)
    head = np.frombuffer((folder / "studio_ibl.ktx").read_bytes()[16:64], "<u4")
    # Filament's reader knows R11G11B10F by a glType of its internal format, and RGB by the glFormat.
    assert (head[0], head[2], head[3]) == (0x8C3A, 0x1907, 0x8C3A)
    irradiance = np.array(texture.metadata["sh"].split(), float).reshape(9, 3)
    # The picture's middle, our +x, is Filament's +z, and our +z its -x: 1 + n/3 along these.
    expected = np.zeros((9, 3))
    expected[0], expected[1, 1], expected[2, 0], expected[3, 2] = 1.0, 1 / 3, 1 / 3, -1 / 3
    np.testing.assert_allclose(irradiance, expected, atol=1e-3)
    text = (folder / "sh.txt").read_text().splitlines()
    assert text[0].endswith("// L00, irradiance, pre-scaled base") and len(text) == 9
    sky = read_levels(folder / "studio_skybox.ktx")
    assert len(sky) == 1
    # The middle of pz; R11G11B10F's step is 1/64 or 1/32.
    np.testing.assert_allclose(sky[0].texels[4, 32, 32], [1.5, 1.0, 1.0], atol=1 / 32 + 0.01)


def test_maps_of_a_table(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    theta, phi = np.deg2rad(np.arange(0.0, 90.0, 9.0)), np.deg2rad(np.arange(0.0, 181.0, 20.0))
    # Half of all light goes every way, and f = ½/π·cos θi·cos θo besides.
    values = 0.5 / np.pi + 0.5 / np.pi * np.cos(theta)[:, None, None] * np.cos(theta)[None, :, None]
    table = MeasuredBrdf(theta, theta, phi, np.repeat(values, len(phi), 2)[..., None])
    write_measured_brdf(tmp_path / "paint.npz", table)
    brdf = ("--brdf", f"table:{tmp_path / 'paint.npz'}")
    assert reflet("prefilter", studio, *brdf, "--size", "16", "-o", tmp_path / "paint") == 0
    said = json.loads((tmp_path / "paint" / "lobes.json").read_text())
    assert {path.name for path in (tmp_path / "paint").iterdir()} == {
        "diffuse.ktx2", "lobes.json", *(lobe["file"] for lobe in said["lobes"])
    }  # fmt: skip
    assert read_env_image(tmp_path / "paint" / "diffuse.ktx2").parameterization.name == "octahedral"
    albedo = np.array(said["diffuse_albedo"])
    for lobe in said["lobes"]:
        layers = read_texture(tmp_path / "paint" / lobe["file"])
        assert (layers.image_count, layers.rows, layers.is_cube) == (len(said["cos_theta_o"]), 16, False)
        # Each slice holds the mean radiance, 1, times the lobe's albedo, but for octahedral's uneven texels.
        weight = PARAMETERIZATIONS["octahedral"].texel_solid_angle(16)[..., None] / (4.0 * np.pi)
        means = (layers.decode(0)[..., :3] * weight).sum((1, 2))
        np.testing.assert_allclose(means, np.broadcast_to(lobe["albedo"], means.shape), atol=2e-3)
        albedo = albedo + np.array(lobe["albedo"])
    # All together reflect what the BRDF does: ½ + ½·⅔·cos θo, as far as the table goes.
    expected = 0.5 + np.maximum(said["cos_theta_o"], np.cos(theta[-1]))[:, None] / 3.0
    np.testing.assert_allclose(albedo, expected, atol=0.01)  # the table's 9° steps: (π/20)²/8, and more at the last
    assert "one face" in refused(capsys, studio, *brdf, "--parameterization", "cube", "-o", tmp_path / "b")
    assert "neither levels" in refused(capsys, studio, *brdf, "--levels", "3", "-o", tmp_path / "b")
    assert "b.npz" in refused(capsys, studio, "--brdf", f"table:{tmp_path / 'b.npz'}", "-o", tmp_path / "b")
    assert not (tmp_path / "b").exists()


def test_brightness_beyond_half_floats_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = np.ones((32, 64, 3), np.float32)
    picture[8:12, 16:20] = 1e6
    write_exr(tmp_path / "sun.exr", picture)
    more = ("--brdf", "ggx", "--size", "32")
    for name in ("a.ktx2", "a_{level}.ktx2"):
        assert reflet("prefilter", tmp_path / "sun.exr", *more, "-o", tmp_path / name) == 0
        assert capsys.readouterr().err.count("can hold (65504); none is lost") == 1
    assert reflet("prefilter", tmp_path / "sun.exr", *more, "--texel-format", "float", "-o", tmp_path / "a.ktx2") == 0
    assert not capsys.readouterr().err
    assert read_env_image(tmp_path / "a.ktx2").texels.max() > 9e5


def test_the_verb_teaches_by_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert reflet("prefilter", "--help") == 0
    examples = capsys.readouterr().out.split("Examples", 1)[1]
    assert all(words in examples for words in ("--engine gltf", "--brdf phong:50", "--sh", *ENGINES))


# What goes wrong


def test_brdfs_that_are_none(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ("-o", tmp_path / "a.ktx2")
    for brdf, said in (
        ("plastic", "table:FILE"),
        ("diffuse:1", "table:FILE"),
        ("phong", "phong:50"),
        ("phong:shiny", "phong:50"),
        ("phong:0", "greater than 0"),
        ("phong:-3", "greater than 0"),
        ("phong:nan", "greater than 0"),
        ("ggx:2", "(0, 1]"),
        ("ggx:0", "(0, 1]"),
        ("sheen:-1", "(0, 1]"),
    ):
        assert said in refused(capsys, studio, "--brdf", brdf, *out), brdf
    assert not (tmp_path / "a.ktx2").exists()


def test_radiance_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for value, said in ((np.nan, "finite"), (np.inf, "finite")):
        picture = np.ones((32, 64, 3), np.float32)
        picture[3, 3] = value
        write_exr(tmp_path / "bad.exr", picture)
        for what in (("--brdf", "ggx", "-o", "a.ktx2"), ("--engine", "filament", "-o", "f"), ("--sh", "a.json")):
            *options, name = what
            assert said in refused(capsys, tmp_path / "bad.exr", *options, tmp_path / name)
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["bad.exr"]


def test_negative_radiance_gives_no_light(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same as of the picture without it, and a word about it."""
    picture = np.ones((32, 64, 3), np.float32)
    picture[3, 3] = -1.0
    write_exr(tmp_path / "bad.exr", picture)
    write_exr(tmp_path / "good.exr", np.maximum(picture, 0.0))
    for name in ("bad", "good"):
        assert reflet("prefilter", tmp_path / f"{name}.exr", "--brdf", "diffuse", "-o", tmp_path / f"{name}.ktx2") == 0
        assert ("negative radiance, which is no light" in capsys.readouterr().err) == (name == "bad")
    assert (tmp_path / "bad.ktx2").read_bytes() == (tmp_path / "good.ktx2").read_bytes()


def test_what_files_cannot_hold(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "{level}" in refused(capsys, studio, "--brdf", "ggx", "-o", tmp_path / "a.exr")
    assert "{level}" in refused(capsys, studio, "--brdf", "diffuse", "-o", tmp_path / "a_{level}.exr")
    assert ".gif" in refused(capsys, studio, "--brdf", "diffuse", "-o", tmp_path / "a.gif")
    assert "levels" in refused(
        capsys, studio, "--brdf", "ggx", "--size", "8", "--levels", "9", "-o", tmp_path / "a.dds"
    )
    assert "rows" in refused(capsys, studio, "--brdf", "ggx", "--size", "0", "-o", tmp_path / "a.dds")
    assert "fewer rows" in refused(capsys, studio, "--brdf", "diffuse", "--size", "1500", "-o", tmp_path / "a.dds")
    assert "power of two" in refused(capsys, studio, "--engine", "gltf", "--size", "100", "-o", tmp_path / "a")
    assert "what to make" in refused(capsys, studio)
    assert "-o NAME" in refused(capsys, studio, "--brdf", "ggx")
    assert "leave --brdf out" in refused(capsys, studio, "--brdf", "ggx", "--engine", "gltf", "-o", tmp_path / "a")
    assert "--size" in refused(capsys, studio, "--engine", "gltf", "--levels", "3", "-o", tmp_path / "a")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["studio.exr"]


def test_folders_that_cannot_be_written(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("not a folder")
    for what in (("--brdf", "ggx", "-o", "a.ktx2"), ("--engine", "filament", "-o", "f"), ("--sh", "a.json")):
        *options, name = what
        assert "folder" in refused(capsys, studio, *options, tmp_path / "file" / name)


def test_ctrl_c_stops_it_and_leaves_nothing(studio: Path, tmp_path: Path) -> None:
    """Some minutes' work, interrupted as soon as the temporary files are there."""
    out = tmp_path / "out"
    command = [
        sys.executable, "-c", "from reflet.cli.start import main; main()",
        "prefilter", studio, "--engine", "gltf", "--size", "2048", "-o", out,
    ]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not [path for path in out.rglob("*") if path.is_file()]:
        time.sleep(0.01)
    time.sleep(1.0)  # into the filtering
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert (process.returncode, err.split()) == (130, ["Stopped."])
    assert not [path for path in out.rglob("*") if path.is_file()]
