"""The plate of prefiltered maps, small."""

import runpy
from pathlib import Path

import numpy as np
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_plate_of_prefiltered_maps(tmp_path: Path) -> None:
    main = runpy.run_path(str(EXAMPLES / "prefilter_levels.py"))["main"]
    main(tmp_path / "plate.png", rows=16, brdfs=((None, "phong:30", "diffuse"),))
    picture = np.asarray(Image.open(tmp_path / "plate.png"), float)
    assert picture.shape == (30 + 16 + 6 + 32, 3 * 32 + 2 * 6, 3)
    spheres = picture[30 + 16 + 6 :]
    detail = [np.abs(np.diff(spheres[8:24, 38 * k + 8 : 38 * k + 24], axis=1)).mean() for k in range(3)]
    assert detail[0] > 2.0 * detail[1] > 2.0 * detail[2]  # the rougher, the softer
