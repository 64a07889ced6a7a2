"""The verbs for environment map files: convert, info, join, sampling."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from verbs import CUBE, LATLONG, reflet, refused, sky_image

from reflet.cli import main as command_line
from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import facts
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletWarning
from reflet.files.env_image_file import read_env_image, read_levels, write_env_image
from reflet.files.pictures.exr import read_exr, write_exr


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    """A lat-long sky with a bright texel towards +x, 0.3 radians up."""
    image = sky_image("latlong", 64)
    image.texels[0, 25, 64] = 1000.0
    write_env_image(tmp_path / "studio.exr", [image])
    return tmp_path / "studio.exr"


@pytest.mark.parametrize("name", list(PARAMETERIZATIONS))
@pytest.mark.parametrize("suffix", [".exr", ".ktx2"])
def test_convert_and_back_keeps_what_is_there(studio: Path, tmp_path: Path, name: str, suffix: str) -> None:
    middle, back = tmp_path / f"middle{suffix}", tmp_path / "back.exr"
    assert reflet("convert", studio, middle, "--to", name) == 0
    assert reflet("convert", middle, back, "--to", "latlong", "--size", "64") == 0
    levels = read_levels(middle)
    assert levels[0].parameterization.name == name
    assert len(levels) == (levels[0].size.bit_length() if suffix == ".ktx2" else 1)
    before, after = read_env_image(studio), read_env_image(back)
    weight = LATLONG.texel_solid_angle(64)[..., None]
    power, kept = (weight * before.texels).sum((0, 1, 2)), (weight * after.texels).sum((0, 1, 2))
    # Resampling keeps 0.1 % of the power; half float rounds each texel by at most 1/2048 in .ktx2.
    assert kept == pytest.approx(power, rel=2e-3)


def test_convert_needs_no_more_than_two_names(studio: Path, tmp_path: Path) -> None:
    assert reflet("convert", studio, tmp_path / "same.hdr") == 0
    image = read_env_image(tmp_path / "same.hdr")
    assert (image.parameterization, image.size) == (LATLONG, 64)


@pytest.mark.parametrize("layout", ["vertical-strip", "horizontal-strip", "vertical-cross", "horizontal-cross"])
def test_convert_into_layouts_and_six_files(studio: Path, tmp_path: Path, layout: str) -> None:
    strip, six = tmp_path / "cube.exr", tmp_path / "sky_{face}.exr"
    assert reflet("convert", studio, strip, "--to", "cube", "--size", "32", "--layout", layout) == 0
    assert reflet("convert", strip, six) == 0
    assert np.array_equal(read_env_image(strip).texels, read_env_image(six).texels)
    assert len(list(tmp_path.glob("sky_*.exr"))) == 6
    rows, columns = {
        "vertical-strip": (6, 1), "horizontal-strip": (1, 6), "vertical-cross": (4, 3), "horizontal-cross": (3, 4)
    }[layout]  # fmt: skip
    assert read_exr(strip).shape[:2] == (32 * rows, 32 * columns)


def test_convert_packs_texels(studio: Path, tmp_path: Path) -> None:
    for texel_format, step in (("float", 0.0), ("rgb9e5", 2.0**-9), ("r11g11b10f", 2.0**-6)):
        out = tmp_path / f"{texel_format}.ktx2"
        assert reflet("convert", studio, out, "--to", "latlong", "--texel-format", texel_format, "--zstd") == 0
        difference = np.abs(read_env_image(out).texels - read_env_image(studio).texels)
        assert (difference <= step * 2.0 * np.maximum(read_env_image(studio).texels.max(-1, keepdims=True), 1e-3)).all()


def test_mip_levels_that_a_file_has_are_kept(tmp_path: Path) -> None:
    levels = [EnvImage(CUBE, np.full((6, 16 >> k, 16 >> k, 3), float(k + 1), np.float32)) for k in range(5)]
    write_env_image(tmp_path / "a.ktx2", levels)
    assert reflet("convert", tmp_path / "a.ktx2", tmp_path / "b.dds") == 0
    assert [float(level.texels.max()) for level in read_levels(tmp_path / "b.dds")] == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_info_says_what_a_map_holds(studio: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert reflet("info", studio) == 0
    out = capsys.readouterr().out
    for words in ("latlong", "128×64", "RGB", "to 1000", "azimuth 358.6°, elevation 18.3°"):
        assert words in out
    # Mean of each channel is 1, ∫ L dω 4π, and the texel adds 1000·(π/64)²·sin(acos(…)) = 2.29 to both.
    assert "14.85 14.85 14.84" in out or "14.85 14.85 14.85" in out
    assert "\x1b" not in out and "▀" not in out  # no terminal, no picture


def test_info_of_six_files_and_of_textures(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "cube").mkdir()
    assert reflet("convert", studio, tmp_path / "cube" / "{face}.hdr", "--to", "cube", "--size", "16") == 0
    assert reflet("convert", studio, tmp_path / "t.ktx2", "--to", "dual_paraboloid", "--size", "16", "--zstd") == 0
    capsys.readouterr()
    assert reflet("info", tmp_path / "cube") == 0
    assert "16×16, 6 faces" in capsys.readouterr().out
    assert reflet("info", tmp_path / "t.ktx2") == 0
    out = capsys.readouterr().out
    for words in ("KTX 2.0", "rgba16f", "dual_paraboloid", "16×16, 2 faces", "5 mip levels"):
        assert words in out


def test_info_of_a_cube_that_lacks_a_face_says_which(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("ft", "bk", "up", "dn", "rt"):
        write_exr(tmp_path / f"sky_{name}.exr", np.ones((8, 8, 3), np.float32))
    assert "beside sky_ft.exr those called lf are missing" in refused(capsys, "info", tmp_path)
    assert "beside sky_ft.exr those called lf are missing" in refused(capsys, "info", tmp_path / "sky_up.exr")


def test_sampling_prints_a_table_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert reflet("sampling", "--figure", tmp_path / "rates.png") == 0
    out = capsys.readouterr().out
    assert all(name in out for name in PARAMETERIZATIONS)
    assert "5.20" in out and "4.00" in out  # 3√3 for the cube, 4 for the paraboloids: the papers' ratios
    assert Image.open(tmp_path / "rates.png").width >= 1000


def test_every_verb_teaches_by_example(capsys: pytest.CaptureFixture[str]) -> None:
    for verb in ("convert", "info", "join", "sampling"):
        assert reflet(verb, "--help") == 0
        assert f"reflet {verb}" in capsys.readouterr().out.split("Example", 1)[1]


# What goes wrong


def test_missing_and_damaged_files(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out.exr"
    for verb in (("info",), ("convert",), ("join",)):
        more = {"info": (), "convert": (out,), "join": ("-o", out)}[verb[0]]
        for name in ("nowhere.exr", "nowhere.hdr", "nowhere.png"):
            assert name in refused(capsys, *verb, tmp_path / name, *more)
        whole = studio.read_bytes()
        for length in (0, 3, 40, len(whole) // 2):
            (tmp_path / "cut.exr").write_bytes(whole[:length])
            assert "cut.exr" in refused(capsys, *verb, tmp_path / "cut.exr", *more)
    assert "cut.ktx2" in refused(capsys, "info", tmp_path / "cut.ktx2")
    assert not out.exists()


def test_shapes_that_do_not_tell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_exr(tmp_path / "square.exr", np.ones((32, 32, 3), np.float32))
    write_exr(tmp_path / "odd.exr", np.ones((32, 45, 3), np.float32))
    out = tmp_path / "out.exr"
    asked = refused(capsys, "convert", tmp_path / "square.exr", out, "--to", "cube")
    assert "angular" in asked and "--from" in asked
    assert "45×32" in refused(capsys, "info", tmp_path / "odd.exr")
    assert "twice as wide" in refused(capsys, "info", tmp_path / "square.exr", "--from", "latlong")
    assert reflet("convert", tmp_path / "square.exr", out, "--from", "octahedral", "--to", "cube") == 0


def test_radiance_that_is_not_finite(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = np.ones((32, 64, 3), np.float32)
    picture[3, 3] = np.nan
    write_exr(tmp_path / "nan.exr", picture)
    out = tmp_path / "out.exr"
    for arguments in (("info",), ("convert", out), ("join", "-o", out)):
        verb, *more = arguments
        assert "finite" in refused(capsys, verb, tmp_path / "nan.exr", *more)
    assert not out.exists()


def test_what_formats_cannot_hold(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ".gif" in refused(capsys, "convert", studio, tmp_path / "out.gif")
    assert "mip" in refused(capsys, "convert", studio, tmp_path / "out.exr", "--mips")
    assert "power of two" in refused(capsys, "convert", studio, tmp_path / "out.ktx2", "--to", "cube", "--size", "100")
    assert "Zstandard" in refused(capsys, "convert", studio, tmp_path / "out.exr", "--zstd")
    assert "horizontal-cross" in refused(
        capsys, "convert", studio, tmp_path / "out.ktx2", "--to", "cube", "--layout", "horizontal-cross"
    )
    assert "rows" in refused(capsys, "convert", studio, tmp_path / "out.exr", "--size", "0")
    one = ("--to", "cube", "--size", "1", "--layout", "openexr")
    assert "2 or more, not 1×6" in refused(capsys, "convert", studio, tmp_path / "out.exr", *one)
    assert "does not exist" in refused(capsys, "info", tmp_path / "nothing")
    assert "png" in refused(capsys, "sampling", "--figure", tmp_path / "rates.jpg")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["studio.exr"]


def test_suns_that_a_texture_cannot_hold_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sun = np.ones((16, 32, 3), np.float32)
    sun[3, 5] = 90000.0
    write_exr(tmp_path / "sun.exr", sun)
    before = facts(read_env_image(tmp_path / "sun.exr")).power
    # Of 90,000 and the 515 that all others send. What is held is rounded to 11 bits of mantissa, 9 and 5 or 6.
    formats = (("half", "65504", "27", 2**-11), ("rgb9e5", "65408", "27", 2**-9), ("r11g11b10f", "64512", "28", 2**-6))
    for texel_format, most, share, rounding in formats:
        assert reflet("convert", tmp_path / "sun.exr", tmp_path / "a.ktx2", "--texel-format", texel_format) == 0
        err = capsys.readouterr().err
        assert len(err.splitlines()) == 1 and f"{share} % of the light" in err and f"({most})" in err
        np.testing.assert_allclose(facts(read_env_image(tmp_path / "a.ktx2")).power, before, rtol=rounding)
    assert reflet("convert", tmp_path / "sun.exr", tmp_path / "c.exr", "--texel-format", "half") == 0
    assert "27 % of the light" in capsys.readouterr().err
    np.testing.assert_allclose(facts(read_env_image(tmp_path / "c.exr")).power, before, rtol=2**-11)
    assert reflet("convert", tmp_path / "sun.exr", tmp_path / "a.png") == 0
    assert "99 % of the light is above 1" in capsys.readouterr().err
    for out, *options in (("a.ktx2", "--texel-format", "float"), ("b.exr",), ("a.hdr",)):
        assert reflet("convert", tmp_path / "sun.exr", tmp_path / out, *options) == 0
        assert capsys.readouterr().err == ""


def test_radiance_is_scaled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By a power of two exactly, alpha apart; a warning's own advice brings a sun into half floats whole."""
    sky = np.random.default_rng(4).random((8, 16, 4)).astype(np.float32)
    write_exr(tmp_path / "sky.exr", sky)
    assert reflet("convert", tmp_path / "sky.exr", tmp_path / "dim.exr", "--scale", "0.25") == 0
    dim = read_env_image(tmp_path / "dim.exr").texels[0]
    np.testing.assert_array_equal(dim[..., :3], sky[..., :3] / 4.0)
    np.testing.assert_array_equal(dim[..., 3:], sky[..., 3:])
    sun = np.ones((16, 32, 3), np.float32)
    sun[3, 5] = 1e9
    write_exr(tmp_path / "sun.exr", sun)
    with pytest.warns(RefletWarning, match="--scale 6e-05") as said:
        held([read_env_image(tmp_path / "sun.exr")], HALF_MAX, "the viewer")
    command = str(said[0].message).split("--scale ")[1].rstrip(".")
    capsys.readouterr()
    assert reflet("convert", tmp_path / "sun.exr", tmp_path / "held.ktx2", "--scale", command) == 0
    assert capsys.readouterr().err == ""
    for wrong in ("0", "-1", "nan"):
        assert "above 0" in refused(capsys, "convert", tmp_path / "sun.exr", tmp_path / "b.exr", "--scale", wrong)


def test_folders_that_cannot_be_written(studio: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("not a folder")
    for out in ("file/out.exr", "file/out.ktx2", "file/out.hdr", "file/out.png"):
        assert "folder" in refused(capsys, "convert", studio, tmp_path / out)
    assert "folder" in refused(capsys, "sampling", "--figure", tmp_path / "file" / "rates.png")


@pytest.mark.parametrize("name", ["out.exr", "out.ktx2", "sky_{face}.hdr"])
def test_a_disk_that_fills_up_leaves_nothing(studio: Path, tmp_path: Path, name: str) -> None:
    """A limit on file sizes stands for the full disk: writes fail half way."""
    out = tmp_path / "out"
    out.mkdir()
    code = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from reflet.cli.main import main; import reflet.pipelines.convert;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)); main(sys.argv[1:])"
    )
    command = [sys.executable, "-B", "-c", code, "convert", studio, out / name, "--to", "cube", "--size", "64"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.splitlines()) == 1 and "written" in done.stderr
    assert not list(out.iterdir())


def test_ctrl_c_leaves_nothing(studio: Path, tmp_path: Path) -> None:
    """Interrupted while the temporary file is there."""
    out = tmp_path / "out"
    command = [
        sys.executable, "-c", "from reflet.cli.start import main; main()",
        "convert", studio, out / "big.exr", "--to", "cube", "--size", "512",
    ]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not (out.is_dir() and list(out.iterdir())):
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert (process.returncode, err.split()) in [(130, ["Stopped."]), (0, [])]  # 0: it came when all was done
    left = [path.name for path in out.iterdir()]
    assert left in ([], ["big.exr"]), err
    if left:  # a signal that comes late finds the file whole
        assert read_env_image(out / "big.exr").size == 512


def test_a_terminal_with_colours_gets_a_picture(studio: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLORTERM", "truecolor")
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert reflet("info", studio) == 0
    assert "\x1b[38;2;" in capsys.readouterr().out
    monkeypatch.setenv("COLORTERM", "")
    # Other colours than before: rich remembers how it wrote a style.
    write_env_image(studio, [EnvImage(LATLONG, sky_image("latlong", 64).texels[..., ::-1] ** 2)])
    assert reflet("info", studio) == 0
    assert "\x1b[38;5;" in capsys.readouterr().out
    monkeypatch.setenv("NO_COLOR", "1")
    assert reflet("info", studio) == 0
    assert "▀" not in capsys.readouterr().out


def test_the_command_list_names_the_verbs() -> None:
    assert {"convert", "info", "join", "sampling"} <= set(command_line.commands.commands)


def test_convert_turns_as_shade_does(studio: Path, tmp_path: Path) -> None:
    assert reflet("convert", studio, tmp_path / "turned.exr", "--turn", "90") == 0
    before, after = read_env_image(studio).texels, read_env_image(tmp_path / "turned.exr").texels
    np.testing.assert_array_equal(after, np.roll(before, -before.shape[2] // 4, axis=2))
    # what every level of a file holds is turned, not filtered anew
    levels = [EnvImage(CUBE, np.full((6, 4 >> k, 4 >> k, 3), float(k + 1), np.float32)) for k in range(3)]
    write_env_image(tmp_path / "a.ktx2", levels)
    assert reflet("convert", tmp_path / "a.ktx2", tmp_path / "b.ktx2", "--turn", "180") == 0
    assert [float(level.texels.max()) for level in read_levels(tmp_path / "b.ktx2")] == [1.0, 2.0, 3.0]


def test_convert_sets_a_z_up_cube_upright(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    faces = np.broadcast_to(np.arange(6, dtype=np.float32)[:, None, None, None], (6, 8, 8, 3))
    write_env_image(tmp_path / "z.exr", [EnvImage(CUBE, np.ascontiguousarray(faces))])
    assert reflet("convert", tmp_path / "z.exr", tmp_path / "y.exr", "--up", "z") == 0
    # px nx py ny pz nz hold what lay along +x -x +z -z -y +y
    assert read_env_image(tmp_path / "y.exr").texels[:, 3, 3, 0].tolist() == [0.0, 1.0, 4.0, 5.0, 3.0, 2.0]
    assert "number of degrees" in refused(capsys, "convert", tmp_path / "z.exr", tmp_path / "n.exr", "--turn", "nan")


def test_convert_repairs_and_says_what_and_where(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = np.ones((32, 64, 3), np.float32)
    picture[3, 3], picture[4, 3, 0], picture[5, 3, 1] = np.nan, np.inf, -2.0
    write_exr(tmp_path / "broken.exr", picture)
    advice = refused(capsys, "convert", tmp_path / "broken.exr", tmp_path / "out.exr")
    assert "reflet convert --repair" in advice
    assert reflet("convert", tmp_path / "broken.exr", tmp_path / "out.exr", "--repair") == 0
    said = capsys.readouterr().err
    for words in ("1 not a number", "1 infinite", "1 negative", "rows 3 to 5"):
        assert words in said
    np.testing.assert_array_equal(
        read_env_image(tmp_path / "out.exr").texels[0, 3:6, 3], [[1, 1, 1], [1, 1, 1], [1, 0, 1]]
    )


def test_layers_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import OpenEXR

    channels = {
        f"ViewLayer.{layer}.{channel}": np.full((4, 8), value, np.float32)
        for layer, value in (("Combined", 2.0), ("Emit", 3.0))
        for channel in "RGB"
    }
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(tmp_path / "render.exr"))
    for verb, *more in (("info",), ("convert", tmp_path / "a.exr")):
        assert "reflet convert --layer" in refused(capsys, verb, tmp_path / "render.exr", *more)
        assert "ViewLayer.Combined" in refused(capsys, verb, tmp_path / "render.exr", *more, "--layer", "Diffuse")
    assert reflet("convert", tmp_path / "render.exr", tmp_path / "a.exr", "--layer", "ViewLayer.Emit") == 0
    assert (read_env_image(tmp_path / "a.exr").texels == 3.0).all()
    capsys.readouterr()
    assert reflet("info", tmp_path / "render.exr", "--layer", "ViewLayer.Combined") == 0
    assert "8×4" in capsys.readouterr().out
