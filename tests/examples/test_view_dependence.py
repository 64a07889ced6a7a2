"""The example of what the early maps get wrong shows it, and that their remedies work."""

import runpy
from pathlib import Path

import numpy as np
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_view_dependence(tmp_path: Path) -> None:
    runpy.run_path(str(EXAMPLES / "view_dependence.py"))["main"](tmp_path, size=64, picture=96)
    _, aside, anew = np.split(np.asarray(Image.open(tmp_path / "sphere_map.png"), float), 3, axis=1)
    left, right = np.s_[:, :48], np.s_[:, 48:]
    # The singularity lies at the right; elsewhere the two differ by detail.
    assert np.abs(aside - anew)[right].mean() > 2.0 * np.abs(aside - anew)[left].mean()

    picture = np.asarray(Image.open(tmp_path / "paraboloid.png"))[:96]
    pink = (picture[..., 0] > 200) & (picture[..., 1] == 0) & (picture[..., 2] > 180)  # as nothing in the court is
    assert [bool(each.any()) for each in np.split(pink, 3, axis=1)] == [True, False, False]
