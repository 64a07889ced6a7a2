"""Figure 15, small: lines on every mesh, and levels that matter."""

import runpy
from pathlib import Path

import numpy as np
from PIL import Image

MAIN = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "nonphotorealistic.py"))["main"]
TITLE, GAP = 30, 6  # of plates


def test_figures(tmp_path: Path) -> None:
    side = 63
    MAIN(tmp_path, picture=side, samples=4, map_rows=128)
    sheet = np.asarray(Image.open(tmp_path / "drawings.png").convert("RGB"), float) / 255.0
    balls = [sheet[TITLE : TITLE + side, left : left + side] for left in range(0, 5 * (side + GAP), side + GAP)]
    window, gooch, silhouette, hatching, all_three = balls
    middle = slice(side // 2 - 4, side // 2 + 4)
    assert (silhouette[middle, middle] > 0.99).all() and silhouette.min() < 0.2
    assert gooch[middle, middle, 2].mean() < gooch[middle, middle, 0].mean() < 0.95
    y, x = np.mgrid[:side, :side] + 0.5 - side / 2
    ring = np.abs(np.hypot(x, y) - 22.0) < 4.0  # 4 to 12 pixels within the contour
    assert 1.0 - hatching[ring].mean() > 4.0 * (1.0 - silhouette[ring].mean())
    assert window.min() < 0.2
    # over one another: nowhere brighter than shading alone, but for rounding and pixels half paper
    assert (all_three - gooch).max() < 0.02
    levels = np.asarray(Image.open(tmp_path / "levels.png").convert("L"), float) / 255.0
    top = 2 * TITLE
    rows = [levels[y : y + side] for y in (top, top + side + GAP + TITLE)]
    drawn, filtered = (
        [1.0 - row[:, left : left + side] for left in range(0, 4 * (side + GAP), side + GAP)] for row in rows
    )
    # Ink over the circumference: of the drawn ones it stays, of the filtered it shrinks with the ball.
    ratio = [np.array([each.sum() for each in row]) * [3.6, 7.0, 14.0, 28.0] for row in (drawn, filtered)]
    assert ratio[0][2] > 0.7 * ratio[0][0] and ratio[1][2] < 0.5 * ratio[1][0]
