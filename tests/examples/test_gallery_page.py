"""The gallery page is made, with every picture it shows; the maps agree with each other, and one singularity shows."""

import re
import runpy
from pathlib import Path

import pytest
from PIL import Image

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow  # maps and mirrors are tested in their rooms; the page is here alone, and rarely changes
def test_parameterizations(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main = runpy.run_path(str(EXAMPLES / "parameterizations.py"))["main"]
    main(tmp_path, picture=96, texels=6 * 64**2, samples=4)
    page = (tmp_path / "index.html").read_text()
    shown = re.findall(r'src="([^"]+)"', page)
    assert len(shown) == len(set(shown)) == 4 + 5 * len(PARAMETERIZATIONS)
    for file in shown:
        assert Image.open(tmp_path / file).size[0] >= 96
    psnr = {
        line.split()[0]: [float(number) for number in re.findall(r"([0-9.]+) dB", line)]
        for line in capsys.readouterr().out.splitlines()
        if " dB" in line
    }
    assert set(psnr) == set(PARAMETERIZATIONS)
    cube = psnr["cube"]
    for name, views in psnr.items():
        for view, (value, of_cube) in enumerate(zip(views, cube, strict=True)):
            # Equal texels give equal pictures to 2 dB (measured 0.1 to 1.2); a mirrored axis or a face in the wrong
            # place leaves 15 dB in all. A gazing ball seen from aside is 4 dB worse: its singularity.
            if name == "gazing_ball" and view == 1:
                assert of_cube - 8.0 < value < of_cube - 2.0
            else:
                assert value > of_cube - 2.0
