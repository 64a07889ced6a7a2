"""The figures of environment-mapped materials, small: what their captions say can be seen in them."""

import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"
GAP, TITLE = 6, 30  # of plates


def main_of(name: str) -> Callable[..., None]:
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]


def picture(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"), float) / 255.0


def test_fresnel(tmp_path: Path) -> None:
    main_of("fresnel")(tmp_path, picture=64, samples=1, map_rows=64)
    sheet = picture(tmp_path / "fresnel.png")
    cells = np.stack(
        [
            [sheet[(top := 2 * TITLE + row * (64 + TITLE + GAP)) : top + 64, 70 * k : 70 * k + 64] for k in range(6)]
            for row in range(3)
        ]
    )
    mirrored, added, coated = cells
    # What lies behind the meshes is the same in one column; what is brighter with the diffuse part is mesh.
    mesh = (added - mirrored).mean(-1) > 0.03
    assert (mesh.mean((1, 2)) > 0.1).all()
    assert ((added - coated)[mesh] > -0.01).all()  # 8 bits: coats let less through than all
    for first in (0, 3):
        glass, dense, metal = (mirrored[k][mesh[k]].mean() for k in range(first, first + 3))
        assert glass < dense < metal
        # 1 - F is 2 % at index 200, and grey levels differ by that and their rounding.
        assert np.abs(coated[first + 2] - mirrored[first + 2]).mean() < 0.01
        assert np.abs(coated[first] - mirrored[first])[mesh[first]].mean() > 0.1
    assert Image.open(tmp_path / "schlick.png").width == 1600


def test_prefiltered_maps(tmp_path: Path) -> None:
    main_of("prefiltered_maps")(tmp_path, picture=64, samples=1, map_rows=64)
    diffuse, glossy = (picture(tmp_path / f"{name}.png")[TITLE:] for name in ("diffuse", "glossy"))
    assert diffuse.shape == glossy.shape == (64, 4 * 64 + 2 * GAP, 3)
    inside = np.s_[16:48, 16:48]  # of the disc +z
    steps = [np.abs(np.diff(sheet[inside], axis=1)).max() for sheet in (diffuse, glossy)]
    assert steps[0] < 0.05 < steps[1]  # a cosine turns slowly, and lobes of some 10° leave the walls their edges


@pytest.mark.slow  # captures and filters are tested in tests/render
def test_glossy_every_frame(tmp_path: Path) -> None:
    main_of("glossy_every_frame")(tmp_path, picture=96, frames=2, map_rows=64)
    sheet = picture(tmp_path / "glossy.png")[TITLE:]
    cells = [sheet[:, 102 * k : 102 * k + 96] for k in range(4)]
    for blurred, sharp in (cells[:2], cells[2:]):
        assert np.abs(blurred - sharp).max() > 0.05
        roughness = [np.abs(np.diff(cell[20:60, 30:70], axis=0)).mean() for cell in (blurred, sharp)]
        assert roughness[0] < roughness[1]
    film = Image.open(tmp_path / "glossy.webp")
    assert (film.n_frames, film.size) == (2, (96, 72))
