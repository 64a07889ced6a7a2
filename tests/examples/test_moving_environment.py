"""The mirror in a moving world: small, its ways to a map side by side."""

import runpy
from pathlib import Path

import numpy as np
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_moving_environment(tmp_path: Path) -> None:
    runpy.run_path(str(EXAMPLES / "moving_environment.py"))["main"](tmp_path, width=96, frames=2, map_rows=64)
    strip = np.asarray(Image.open(tmp_path / "strip.png"), float) / 255.0
    assert strip.shape == (3 * 72, 4 * 96, 3)
    cube, paraboloid, sphere_map = strip.reshape(3, 72, 4, 96, 3).swapaxes(1, 2)
    for other in (paraboloid, sphere_map):
        # Nothing differs but the pot's 6 % of the pixels, by the detail of maps. Measured 37 and 36 dB.
        assert -10.0 * np.log10(np.mean((cube - other) ** 2)) > 32.0
    pot = np.s_[:, 26:46, 38:52]  # its body, which nothing passes in front of at these moments
    motion = np.abs(np.diff(cube, axis=0))[pot].mean((1, 2, 3))
    assert (motion > 0.02).all()
    film = Image.open(tmp_path / "moving.webp")
    assert (film.n_frames, film.size) == (2, (96, 72))
