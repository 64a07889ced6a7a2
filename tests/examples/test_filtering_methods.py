"""Four ways to the same prefiltered map: small."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow  # each method is tested for itself, against brute force, in tests/reflectance and tests/render
def test_filtering_methods(tmp_path: Path) -> None:
    errors = runpy.run_path(str(EXAMPLES / "filtering_methods.py"))["main"](
        tmp_path, map_rows=64, picture=64, samples=1
    )
    assert errors["classic"] == 0.0
    # Measured: 0.014, for the quadtree interpolates between texels as wide as half the lobe; 0.043 and 0.089.
    assert errors["hierarchical"] < 0.02
    assert errors["taps"] < 0.06
    assert errors["taps"] < errors["hardware"] < 0.12
    plate = np.asarray(Image.open(tmp_path / "methods.png"))
    assert plate.shape[1] == 5 * 64 + 4 * 6
