"""The figure of mip levels is made, and its numbers say what it shows."""

import re
import runpy
from pathlib import Path

import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_mip_levels(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main = runpy.run_path(str(EXAMPLES / "mip_levels.py"))["main"]
    main(tmp_path / "figure.png", rows=8, picture=64)
    assert Image.open(tmp_path / "figure.png").size == (1500, 1110)
    lines = [re.findall(r"([0-9.]+)%", line) for line in capsys.readouterr().out.splitlines() if "%" in line]
    assert len(lines) == 5
    for plain, ours in lines:
        assert float(plain) > 3.0  # a sun and a sky that is brighter than the floor: plain means cannot get it right
        assert float(ours) < 0.001  # float32's rounding
