"""Light and gloss that change in every frame: small."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.slow  # captures, filters and materials are tested in tests/render
def test_live_materials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)  # for the table, which is an example of its own
    example = runpy.run_path(str(EXAMPLES / "live_materials.py"))
    example["main"](tmp_path, size=72, frames=3, map_rows=32, samples=1, angles=2)
    film = Image.open(tmp_path / "live.webp")
    assert (film.n_frames, film.size) == (3, (2 * 72, 72))
    frames = []
    for k in range(3):
        film.seek(k)
        frames.append(np.asarray(film.convert("RGB"), float) / 255.0)
    body = np.s_[28:50, 22:44]  # of the left pot; the lamps' light runs over it
    assert min(np.abs(frames[k][body] - frames[k + 1][body]).mean() for k in range(2)) > 0.02
    assert (tmp_path / "strip.png").exists()
    # Back where it began after a whole turn: the least exponent, the lamps in their first places.
    assert [example["exponent"](share) for share in (0.0, 1.0)] == pytest.approx([example["EXPONENTS"][0]] * 2)
    start, end = (example["places"](np.zeros(3), 1.0, share) for share in (0.0, 1.0))
    np.testing.assert_allclose(start, end, atol=1e-12)
