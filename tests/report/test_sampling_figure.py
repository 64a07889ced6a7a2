"""The figure and the table of sampling rates."""

from pathlib import Path

import numpy as np
from PIL import Image

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.sampling import analyze
from reflet.report.sampling_figure import LEAST, MOST, PICTURE, sampling_table, sphere_picture, write_sampling_figure


def test_a_sphere_picture_shows_angles_true_in_area_and_azimuths_counter_clockwise() -> None:
    rows, columns = np.meshgrid(np.arange(90), np.arange(120), indexing="ij")
    picture = sphere_picture(1.0 + rows / 90.0)
    shown = np.isfinite(picture)
    assert abs(shown.mean() - np.pi / 4) < 0.01  # a disc, to a pixel at its rim
    # Half of the sphere lies within 90° of the axis, which is row 45: value 1.5.
    assert abs((picture[shown] < 1.5).mean() - 0.5) < 0.01
    middle = PICTURE // 2
    assert picture[middle, middle] < 1.02 and picture[middle, -1] > 1.9
    around = sphere_picture(1.0 + columns / 120.0)
    eighth = PICTURE // 8
    quarters = [
        (middle - eighth, middle + eighth),
        (middle - eighth, middle - eighth),
        (middle + eighth, middle - eighth),
    ]
    for quarter, place in enumerate(quarters):
        assert abs(around[place] - (1.125 + 0.25 * quarter)) < 0.02
    assert (
        np.nanmin(sphere_picture(np.zeros((9, 9)))) == LEAST
        and np.nanmax(sphere_picture(np.full((9, 9), 99.0))) == MOST
    )


def test_the_table_tells_the_papers_ratios() -> None:
    lines = sampling_table([analyze(p, 20, 20) for p in PARAMETERIZATIONS.values()]).splitlines()
    row = {line.split()[0]: line for line in lines if line.split() and line.split()[0] in PARAMETERIZATIONS}
    assert set(row) == set(PARAMETERIZATIONS)
    assert "5.20" in row["cube"] and "4.00" in row["dual_paraboloid"]
    assert "1.00 … 1.00" in row["gazing_ball"] and "0.00 … ∞" in row["gazing_ball"]
    assert max(map(len, lines)) <= 100


def test_the_figure_is_written(tmp_path: Path) -> None:
    path = tmp_path / "sampling.png"
    write_sampling_figure(path, [analyze(p, 20, 20) for p in PARAMETERIZATIONS.values()])
    picture = np.asarray(Image.open(path).convert("RGB"))
    assert picture.shape[1] == 2000
    # The sphere map's resolution along the radius goes to zero: deep red in the second row of pictures.
    red = (picture[..., 0] > 80) & (picture[..., 1] < 40) & (picture[..., 2] < 60)
    assert red[1150:1450, 900:1200].sum() > 1000
