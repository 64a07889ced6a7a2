"""One tiny bake through all verbs, and one that is killed."""

import json
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from reflet.cli.main import main
from reflet.files.pictures.exr import read_exr
from reflet.pem.container import open_pem
from reflet.pipelines import compare
from reflet.pipelines.baking.timings import TIMINGS
from reflet.pipelines.compare import dome_points
from reflet.render.playback.renderer import Renderer
from reflet.report.comparison import METHODS, PLACES
from reflet.report.measures import display_psnr, picture_srgb

VIEWS = 2


def reflet(*arguments: str | Path) -> int:
    """Exit status of one command, run within this process."""
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code or 0


def bake_arguments(scene_files: tuple[Path, Path], out: Path) -> list[str]:
    scene, sky = scene_files
    options = "--views 2 --spacing 4 --image-size 64 --em-size 16 --spp 4"
    return ["bake", f"{scene}", "--environment", f"{sky}", *options.split(), "--out", f"{out}"]


@pytest.fixture(scope="module")
def baked(scene_files: tuple[Path, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("pem") / "ring"
    assert reflet(*bake_arguments(scene_files, out)) == 0
    return out


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a bake but its timings."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != TIMINGS)
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_info_tells_what_was_baked(baked: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert reflet("info", baked) == 0
    out = capsys.readouterr().out
    for words in (f"{VIEWS} along azimuth_deg", "16×16×6", "cube", "distant", "local light", "up to 5 hits"):
        assert words in out


def test_render_writes_the_same_picture_as_png_and_exr(baked: Path, tmp_path: Path) -> None:
    assert reflet("render", baked, "--azimuth", "62", "--size", "48", "-o", tmp_path / "view.png") == 0
    assert reflet("render", baked, "--azimuth", "62", "--size", "48", "-o", tmp_path / "view.exr") == 0
    radiance, shown = read_exr(tmp_path / "view.exr"), np.asarray(Image.open(tmp_path / "view.png"))
    assert radiance.shape == (48, 48, 3)
    assert np.array_equal(picture_srgb(radiance), shown)
    # The sky's radiance is between 0.3 and 0.94 a channel, so is its mirror image times at most 1: nothing is left out.
    assert radiance.max() <= 1.0 and (radiance.max(-1) > 0.25).mean() > 0.6


def test_render_takes_samples_where_they_count_unless_told(baked: Path, tmp_path: Path) -> None:
    def picture(*more: str) -> np.ndarray:
        assert reflet("render", baked, "--azimuth", "62", "--size", "48", *more, "-o", tmp_path / "view.exr") == 0
        return read_exr(tmp_path / "view.exr")

    by_default, all_alike = picture(), {count: picture("--samples", count) for count in ("1", "4", "16", "256")}
    np.testing.assert_array_equal(by_default, picture("--samples", "adaptive"))
    adaptive = open_pem(baked)
    expected = Renderer(adaptive).frame(
        replace(adaptive.space.orbit, image_size=48).camera({"azimuth_deg": 62.0}), samples="adaptive"
    )
    np.testing.assert_array_equal(by_default, expected[..., :3])
    for few, more in pairwise([*all_alike.values(), by_default]):
        assert not np.array_equal(few, more)
    # Of the pictures of 1, 4, 16 samples and of where they count the last is nearest to that of 256.
    errors = [np.square(each - all_alike["256"]).mean() for each in (*all_alike.values(), by_default)]
    assert errors[0] > errors[1] > errors[2] > errors[4] > errors[3] == 0


def test_nearest_differs_from_blended_only_between_samples(baked: Path, tmp_path: Path) -> None:
    def picture(azimuth: str, *more: str) -> np.ndarray:
        assert reflet("render", baked, "--azimuth", azimuth, *more, "-o", tmp_path / "view.exr") == 0
        return read_exr(tmp_path / "view.exr")

    assert np.array_equal(picture("64"), picture("64", "--nearest"))
    assert not np.array_equal(picture("61"), picture("61", "--nearest"))


def test_compare_writes_what_its_numbers_can_be_recomputed_from(
    baked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compare, "dome_points", lambda azimuths: dome_points(azimuths)[::9])  # two of twelve
    status = reflet(
        "compare", baked, "--spp", "8", "--samples", "4", "--json", tmp_path / "c.json", "--figure", tmp_path / "c.png",
        "--page", tmp_path / "c.html", "--images", tmp_path / "images",
    )  # fmt: skip
    assert status == 0
    results = json.loads((tmp_path / "c.json").read_text())["results"]
    left_out = "distant-only-joint", "mirror"  # under a sky static maps do, and nothing is rough
    methods = [method for method in METHODS if method not in left_out]
    assert [(row["where"], row["method"]) for row in results] == [(w, m) for w in PLACES for m in methods]
    for row in results:
        names = [path.name[: -len("-mask.exr")] for path in (tmp_path / "images").glob(f"{row['where']}-*-mask.exr")]
        assert len(names) == {"between": VIEWS - 1, "dome": 2}.get(row["where"], VIEWS)
        masks = np.stack([read_exr(tmp_path / "images" / f"{name}-mask.exr")[..., 0] for name in names]) > 0.5
        reference, image = (
            np.stack([read_exr(tmp_path / "images" / f"{name}-{what}.exr") for name in names])
            for what in ("reference", row["method"])
        )
        # The same float32 pictures, pooled in another order.
        assert row["psnr_display"] == pytest.approx(display_psnr(reference, image, masks), abs=1e-6)
        assert 0.0 <= row["flip"] <= 1.0 and row["ssim"] <= 1.0
        assert not image[~masks].any()
    psnr = {(row["where"], row["method"]): row["psnr_display"] for row in results}
    # A static map has no reflection of the ring in itself, a layered one has.
    assert psnr["sample", "layered"] > psnr["sample", "static-infinite"]
    page = (tmp_path / "c.html").read_text()
    # It needs nothing else: no address. (A colon is no letter of base 64, in which any word may stand by chance.)
    assert page.count("data:image/png;base64,") >= 4 and "://" not in page
    assert Image.open(tmp_path / "c.png").width == 2000


def test_a_bake_that_was_killed_goes_on_to_the_very_same_files(
    baked: Path, scene_files: tuple[Path, Path], tmp_path: Path
) -> None:
    out = tmp_path / "killed"
    arguments = bake_arguments(scene_files, out)
    command = [sys.executable, "-c", "from reflet.cli.main import main; main()", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    while process.poll() is None and not (out / "maps" / "0000" / "sample.json").exists():
        time.sleep(0.002)
    process.kill()  # or it has ended: then all is there
    process.communicate()
    assert (out / "bake.json").exists()
    assert process.returncode != 0 or (out / "scene.gltf").exists()
    assert reflet(*arguments, "--resume") == 0
    assert contents(out) == contents(baked)


def test_a_finished_bake_resumes_to_nothing(baked: Path, scene_files: tuple[Path, Path]) -> None:
    before = contents(baked)
    assert reflet(*bake_arguments(scene_files, baked), "--resume") == 0
    assert contents(baked) == before


def test_other_options_are_not_mixed_into_a_bake(
    baked: Path, scene_files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert reflet(*bake_arguments(scene_files, baked), "--spp", "8", "--resume") == 2
    assert "spp" in capsys.readouterr().err
    assert reflet(*bake_arguments(scene_files, baked)) == 2
    assert "--resume" in capsys.readouterr().err
