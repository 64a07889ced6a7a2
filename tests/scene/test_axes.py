"""Axes as people write them."""

import pytest

from reflet.errors import RefletError
from reflet.scene.views.axes import axis_from_text
from reflet.scene.views.parameter_space import Axis


@pytest.mark.parametrize(
    ("text", "axis"),
    [
        ("elevation_deg=0:60:4", Axis("elevation_deg", (0.0, 20.0, 40.0, 60.0))),
        ("azimuth_deg=-10:20:3", Axis("azimuth_deg", (-10.0, 5.0, 20.0))),
        ("azimuth_deg=30:390:4", Axis("azimuth_deg", (30.0, 120.0, 210.0, 300.0), 360.0)),
        ("distance=1.5:1.5:1", Axis("distance", (1.5,))),
    ],
)
def test_axes_are_even_and_turns_closed(text: str, axis: Axis) -> None:
    assert axis_from_text(text) == axis


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("azimut=0:1:2", "no axis 'azimut'; there are azimuth_deg, elevation_deg, distance"),
        ("azimuth_deg", "a first and last coordinate and how many"),
        ("azimuth_deg=0:90", "a first and last coordinate and how many"),
        ("azimuth_deg=0:90:2.5", "a first and last coordinate and how many"),
        ("azimuth_deg=90:0:4", "has no coordinates"),
        ("azimuth_deg=0:90:1", "has no coordinates"),
        ("azimuth_deg=0:90:0", "has no coordinates"),
        ("azimuth_deg=0:nan:2", "has no coordinates"),
        ("azimuth_deg=0:0:2", "has no coordinates"),
        ("azimuth_deg=0:400:9", "more than a turn"),
        ("elevation_deg=0:120:4", "elevations from -90"),
        ("distance=0:2:3", "above 0 m"),
    ],
)
def test_impossible_axes_are_one_sentence(text: str, what: str) -> None:
    with pytest.raises(RefletError, match=what):
        axis_from_text(text)
