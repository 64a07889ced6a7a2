"""Tallies, figures, tables and pages of a made-up comparison."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.report import measures
from reflet.report.comparison import METHODS, PLACES, Comparison, Exhibit, Viewpoint, ViewResult
from reflet.report.curves import curve
from reflet.report.figure import BACKGROUND, comparison_figure
from reflet.report.maps_figure import env_map_sheet
from reflet.report.table import comparison_table
from reflet.report.tally import Tally


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    """A disc whose methods are brighter than the reference by ever more."""
    y, x = np.mgrid[:32, :40]
    coverage = np.clip(13.0 - np.hypot(x - 19.5, y - 15.5), 0.0, 1.0).astype(np.float32)
    reference = np.full((32, 40, 3), 0.5, np.float32)
    tally, exhibits = Tally(), []
    for where in PLACES:
        pictures = {}
        for number, method in enumerate(METHODS):
            pictures[method] = (reference * (1.1 + 0.1 * number)).astype(np.float32)
            tally.add(
                Viewpoint(where, 0, 60.0, 22.0, float(len(exhibits))),
                method,
                reference,
                pictures[method],
                coverage > 0.5,
            )
        exhibits.append(Exhibit(where, 60.0, 22.0, reference, coverage, pictures))
    results = tally.results(2.0, dict.fromkeys(PLACES, 22.0))
    return Comparison(results, tuple(tally.views), tuple(exhibits), {"samples": 16}, reference, reference)


def test_tally_pools_views_like_the_measures() -> None:
    rng = np.random.default_rng(3)
    references, images = rng.random((2, 2, 24, 24, 3))
    masks = np.zeros((2, 24, 24), bool)
    masks[0, 4:20, 4:20] = True
    masks[1, 8:14, 6:16] = True
    tally = Tally()
    for number, (reference, image, mask) in enumerate(zip(references, images, masks, strict=True)):
        tally.add(Viewpoint("sample", number, 60.0, 22.0, 0.0), "layered", reference, image, mask)
        assert tally.views[number].psnr_display == pytest.approx(measures.display_psnr(reference, image, mask))
    (result,) = tally.results(2.0, {"sample": 22.0})
    assert result.psnr_display == pytest.approx(measures.display_psnr(references, images, masks), abs=1e-9)
    # Means over all pixels of both views, so the larger mask counts more.
    sizes = masks.sum((1, 2))
    views = list(zip(references, images, masks, strict=True))
    assert result.ssim == pytest.approx(np.average([measures.ssim(*view) for view in views], weights=sizes), abs=1e-12)
    assert result.flip == pytest.approx(np.average([measures.flip(*view) for view in views], weights=sizes), abs=1e-12)


def test_json_has_one_row_for_each_place_and_method(comparison: Comparison) -> None:
    document = json.loads(json.dumps(comparison.as_json()))
    assert [(row["where"], row["method"]) for row in document["results"]] == [(w, m) for w in PLACES for m in METHODS]
    assert set(document["results"][0]) == {
        "where", "method", "spacing_deg", "elevation_deg", "distance_factor", "psnr_display", "ssim", "flip",
    }  # fmt: skip
    assert document["samples"] == 16
    assert [(row["where"], row["method"]) for row in document["views"]] == [(w, m) for w in PLACES for m in METHODS]
    assert document["views"][0] == {
        "where": "sample", "number": 0, "azimuth_deg": 60.0, "elevation_deg": 22.0, "away_deg": 0.0,
        "method": "traced", "psnr_display": document["results"][0]["psnr_display"],
    }  # fmt: skip


def test_a_curve_pools_the_squared_errors_of_viewpoints_equally_far(comparison: Comparison) -> None:
    def view(number: int, away_deg: float, error: float) -> ViewResult:
        return ViewResult(Viewpoint("dome", number, 60.0, 22.0, away_deg), "traced", -10.0 * np.log10(error))

    views = (view(0, 7.0, 0.03), view(1, 0.0, 0.01), view(2, 9.0, 0.01), view(3, 0.0, 0.01), view(4, 30.0, 0.1))
    away, psnr = curve(replace(comparison, views=views), "traced")
    np.testing.assert_allclose(away, [0.0, 8.0, 30.0])
    np.testing.assert_allclose(psnr, [20.0, -10.0 * np.log10(0.02), 10.0])


def test_figure_is_legible_and_reproducible(comparison: Comparison) -> None:
    png = comparison_figure(comparison)
    assert png == comparison_figure(comparison)
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
    assert pixels.shape[1] == 2000
    # The background behind the objects covers a good part, and text and objects leave no row of cells empty.
    ground = np.abs(pixels.astype(int) - 255.0 * BACKGROUND).max(-1) <= 1.0  # 8 bits
    assert 0.1 < ground.mean() < 0.7
    for band in np.array_split(pixels, 12):
        assert band.std() > 5.0


def test_table_names_every_method_and_marks_no_place_that_was_not_measured(comparison: Comparison) -> None:
    table = comparison_table(comparison)
    for method, words in METHODS.items():
        assert words in table
        assert f"{comparison.result('sample', method).psnr_display:.2f}" in table
    first = tuple(result for result in comparison.results if result.where == "sample")
    only = Comparison(first, (), comparison.exhibits[:1], {}, *(2 * [comparison.reference_picture]))
    assert PLACES["sample"] in comparison_table(only)
    assert PLACES["between"] not in comparison_table(only)


def test_sheet_shows_every_texel_of_every_level_once() -> None:
    chain = MipChain(8)
    texels = np.full((chain.texel_count, 4), 1e3, np.float32)  # so bright that it shows as white
    texels[:, :3] = 0.0
    texels[:, 3] = 1.0
    sheet = env_map_sheet(EnvMap(chain, texels, InfiniteSphere()))
    assert np.count_nonzero(np.all(sheet == 0, axis=-1)) == chain.texel_count  # black radiance, then white alpha
    opaque = env_map_sheet(EnvMap(chain, texels[:, :3], InfiniteSphere()))
    assert sheet.shape[0] > 2 * opaque.shape[0]
    assert np.count_nonzero(np.all(opaque == 0, axis=-1)) == chain.texel_count


def test_sheet_puts_faces_in_order() -> None:
    chain = MipChain(4)
    texels = np.zeros((chain.texel_count, 3), np.float32)
    for face in range(6):
        chain.level(texels, 0)[face] = 0.1 * (face + 1)
    sheet = env_map_sheet(EnvMap(chain, texels, InfiniteSphere()))
    expected = measures.picture_srgb(0.1 * np.arange(1, 7))
    assert np.array_equal(sheet[2, 2:24:4, 0], expected)
