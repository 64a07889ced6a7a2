"""Pictures made of half blocks."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.report.measures import EXPOSURE, picture_srgb
from reflet.report.terminal_picture import LOWER_HALF, MIDDLE_GREY, UPPER_HALF, terminal_picture


@pytest.mark.parametrize("radiance", [0.01, 1.0, 300.0])
def test_any_brightness_becomes_middle_grey(radiance: float) -> None:
    image = EnvImage(PARAMETERIZATIONS["latlong"], np.full((1, 32, 64, 3), radiance, np.float32))
    text = terminal_picture(image, 32)
    lines = text.plain.rstrip("\n").split("\n")
    assert lines == [UPPER_HALF * 32] * 8
    grey = picture_srgb(np.array([MIDDLE_GREY]))[0]
    assert grey == picture_srgb(np.array([1.0]), EXPOSURE * MIDDLE_GREY)[0]
    for span in text.spans:
        assert span.style.color.triplet == span.style.bgcolor.triplet == (grey, grey, grey)


def test_top_and_bottom_are_not_swapped() -> None:
    texels = np.zeros((1, 2, 4, 3), np.float32)
    texels[0, 0] = [1.0, 0.0, 0.0]
    texels[0, 1] = [0.0, 0.0, 1.0]
    span = terminal_picture(EnvImage(PARAMETERIZATIONS["latlong"], texels), 4).spans[0]
    assert span.style.color.triplet.red > 0 == span.style.color.triplet.blue
    assert span.style.bgcolor.triplet.blue > 0 == span.style.bgcolor.triplet.red


def test_what_no_direction_leads_to_is_blank() -> None:
    ball = EnvImage(PARAMETERIZATIONS["gazing_ball"], np.ones((1, 16, 16, 1), np.float32))
    lines = terminal_picture(ball, 16).plain.rstrip("\n").split("\n")
    assert lines[0][0] == lines[0][-1] == lines[-1][0] == " "
    assert UPPER_HALF in lines[0] or LOWER_HALF in lines[0]
    cross = EnvImage(PARAMETERIZATIONS["cube"], np.ones((6, 8, 8, 3), np.float32))
    lines = terminal_picture(cross, 32).plain.rstrip("\n").split("\n")
    assert [len(line.strip()) for line in lines] == [8] * 4 + [32] * 4 + [8] * 4


def test_no_wider_than_asked() -> None:
    image = EnvImage(PARAMETERIZATIONS["latlong"], np.ones((1, 50, 100, 3), np.float32))
    assert max(len(line) for line in terminal_picture(image, 30).plain.split("\n")) <= 30
