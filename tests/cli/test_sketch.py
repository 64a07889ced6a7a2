"""`reflet sketch`, and `reflet shade` with drawings and other maps shown as they are."""

from pathlib import Path

import numpy as np
import pytest

from reflet.cli.main import main
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.files.env_image_file import read_env_image, read_levels
from reflet.files.pictures.png import read_picture
from reflet.pipelines.sketch import sketch_levels


def reflet(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(list(arguments))
    return int(end.value.code or 0)


def test_all_levels_are_written(tmp_path: Path) -> None:
    drawn = sketch_levels("gooch+hatching", parameterization("octahedral"), 32, seed=5)
    arguments = ["--parameterization", "octahedral", "--size", "32", "--seed", "5"]
    assert reflet("sketch", "gooch+hatching", *arguments, "-o", str(tmp_path / "map.ktx2")) == 0
    assert reflet("sketch", "gooch+hatching", *arguments, "-o", str(tmp_path / "map_{level}.png")) == 0
    assert reflet("sketch", "gooch+hatching", *arguments, "-o", str(tmp_path / "map.png")) == 0
    read = read_levels(tmp_path / "map.ktx2")
    assert len(read) == len(drawn) == 6
    for k, (level, written) in enumerate(zip(drawn, read, strict=True)):
        np.testing.assert_allclose(written.texels, level.texels, atol=2.0**-11)  # half float
        picture = read_env_image(tmp_path / f"map_{k}.png")
        np.testing.assert_allclose(picture.texels, level.texels, atol=0.5 / 255 * 2.4)  # sRGB's slope is 1/2.4 at least
    assert (tmp_path / "map.png").read_bytes() == (tmp_path / "map_0.png").read_bytes()


def test_a_drawing_and_its_file_give_one_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    view = ["--size", "48", "--samples", "4"]
    assert reflet("shade", "torus", "--material", "silhouette:2", *view, "-o", "direct.png") == 0
    assert reflet("sketch", "silhouette:2", "-o", "map.ktx2") == 0
    assert reflet("shade", "torus", "map.ktx2", "--material", "map:view-normal", *view, "-o", "by_file.png") == 0
    direct, by_file = read_picture(Path("direct.png")), read_picture(Path("by_file.png"))
    assert np.abs(direct.astype(int) - by_file).max() <= 1  # half float
    assert (direct[0] == 255).all() and direct[..., 0].min() < 30  # ink on white paper
    assert reflet("shade", "torus", "--material", "silhouette:2", *view, "--no-backdrop", "-o", "cut.png") == 0
    assert (read_picture(Path("cut.png"))[0, :, 3] == 0).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sketch", "etching", "-o", "out.ktx2"], "Drawings are window"),
        (["sketch", "gooch", "--size", "100", "-o", "out.ktx2"], "power of two"),
        (["sketch", "gooch", "-o", "out.gif"], "ends in one of"),
        (["shade", "torus", "sky.hdr", "--material", "gooch", "-o", "out.png"], "leave it out"),
        (["shade", "torus", "--material", "map:view-normal", "-o", "out.png"], "give its file"),
        (["shade", "torus", "sky.hdr", "--material", "map:sideways", "-o", "out.png"], "view-reflection"),
        (["shade", "torus", "--material", "ggx:0.3", "-o", "out.png"], "lit by an environment"),
        (["shade", "torus", "--material", "gooch+ink", "-o", "out.png"], "'ink' is none"),
    ],
)
def test_bad_input_ends_in_a_sentence(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert reflet(*arguments) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("reflet: ") and words in lines[0]
    assert not list(tmp_path.glob("out*"))
