"""BRDF tables on the command line: what they hold, a picture of one, and the example that writes one."""

import runpy
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from reflet.cli.main import main
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.files.env_image_file import write_env_image
from reflet.files.measured_brdf_file import read_measured_brdf, write_measured_brdf
from reflet.files.pictures.exr import read_exr
from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf

EXAMPLE = Path(__file__).parents[2] / "examples" / "brdf_table.py"


def reflet(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code or 0


def grey(path: Path) -> Path:
    """A table of diffuse reflection that reflects half of all light, without any more angles than needed."""
    angles = np.array([0.0, 1.5])
    write_measured_brdf(path, MeasuredBrdf(angles, angles, angles, np.full((2, 2, 2, 1), 0.5 / np.pi)))
    return path


def test_a_sphere_of_a_table_in_a_white_room_shows_its_albedo(tmp_path: Path) -> None:
    room, out = tmp_path / "white.exr", tmp_path / "out.exr"
    write_env_image(room, [EnvImage(PARAMETERIZATIONS["latlong"], np.ones((1, 16, 32, 3), np.float32))])
    material = f"table:{grey(tmp_path / 'grey.npz')}"
    assert reflet("shade", "sphere", room, "--material", material, "--size", "32", "--samples", "1", "-o", out) == 0
    np.testing.assert_allclose(read_exr(out)[12:20, 12:20], 0.5, atol=1e-3)  # the fit's error (test_lobes)


def test_the_bar_counts_all_maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[str, int, int]] = []
    monkeypatch.setattr("reflet.cli.shade.progress_bar", lambda: nullcontext(lambda *step: told.append(step)))
    room = tmp_path / "white.exr"
    write_env_image(room, [EnvImage(PARAMETERIZATIONS["latlong"], np.ones((1, 16, 32, 3), np.float32))])
    common = ["shade", "sphere", room, "--size", "8", "--samples", "1", "-o", tmp_path / "out.exr", "--material"]
    assert reflet(*common, f"table:{grey(tmp_path / 'grey.npz')}") == 0
    # The diffuse one, and two lobes at twelve view angles.
    assert told[0] == ("read", 0, 1) and told[-1] == ("draw", 1, 1)
    assert [(done, total) for stage, done, total in told if stage == "filter"] == [(k, 25) for k in range(26)]
    told.clear()
    assert reflet(*common, "mirror") == 0 and "filter" not in {stage for stage, _, _ in told}


@pytest.mark.parametrize(("material", "words"), [("table", "table:satin.npz"), ("table:none.npz", "none.npz")])
def test_tables_that_are_none_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], material: str, words: str
) -> None:
    room = tmp_path / "white.exr"
    write_env_image(room, [EnvImage(PARAMETERIZATIONS["latlong"], np.ones((1, 2, 4, 3), np.float32))])
    assert reflet("shade", "sphere", room, "--material", material, "-o", tmp_path / "out.png") == 2
    assert words in capsys.readouterr().err


def test_the_example_table_is_written_read_and_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLE))
    example["main"](tmp_path / "satin.npz", 10.0)
    table, made = read_measured_brdf(tmp_path / "satin.npz"), example["measured"](10.0)
    for name in ("theta_i", "theta_o", "delta_phi", "values"):
        np.testing.assert_allclose(getattr(table, name), getattr(made, name), rtol=1e-7)  # values in float32
    exact = example["measured"](10.0, 0.0).values
    assert np.std(made.values / exact - 1.0) == pytest.approx(example["NOISE"], rel=0.05)  # 6,000 values
    capsys.readouterr()
    assert reflet("info", tmp_path / "satin.npz") == 0
    told = capsys.readouterr().out
    for words in ("isotropic BRDF, RGB", "from 0° to 80°", "reciprocity", "error of one lobe", "diffuse + glossy"):
        assert words in told, told
    at_60 = next(line for line in told.splitlines() if line.strip().startswith("60°")).split()
    assert at_60[-1].startswith("+"), "at 60° this table's highlight lies beyond the mirrored direction"
    one, several = (float(word.rstrip("%")) for word in at_60[-3:-1])
    assert several < 0.5 * one, "a retro lobe cannot be shown by the glossy one"


def test_an_anisotropic_table_is_refused_in_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, angles = tmp_path / "brushed.npz", np.array([0.0, 1.0])
    np.savez(path, theta_i=angles, theta_o=angles, phi_i=angles, phi_o=angles, values=np.ones((2, 2, 2, 2)))
    assert reflet("info", path) == 2
    assert "anisotropic" in capsys.readouterr().err
