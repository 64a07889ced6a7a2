"""``reflet info`` of a BRDF table, and the example that writes one."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from reflet.cli.main import main
from reflet.files.measured_brdf_file import read_measured_brdf

EXAMPLE = Path(__file__).parents[2] / "examples" / "brdf_table.py"


def info(path: Path) -> int:
    with pytest.raises(SystemExit) as stop:
        main(["info", str(path)])
    return stop.value.code or 0


def test_the_example_table_is_written_read_and_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example = runpy.run_path(str(EXAMPLE))
    example["main"](tmp_path / "satin.npz", 10.0)
    table, made = read_measured_brdf(tmp_path / "satin.npz"), example["measured"](10.0)
    for name in ("theta_i", "theta_o", "delta_phi", "values"):
        np.testing.assert_allclose(getattr(table, name), getattr(made, name), rtol=1e-7)  # values in float32
    exact = example["measured"](10.0, 0.0).values
    assert np.std(made.values / exact - 1.0) == pytest.approx(example["NOISE"], rel=0.05)  # 6,000 values
    capsys.readouterr()
    assert info(tmp_path / "satin.npz") == 0
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
    assert info(path) == 2
    assert "anisotropic" in capsys.readouterr().err
