"""The viewer in a browser shows what the renderer draws.

One browser session (web/test/viewer.mjs) drives the built viewer; here its frames are judged against `Renderer`'s.
"""

import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from browser import drive, need_built_viewer
from frames import browser_frame, drawn_frames, srgb_display, texels_on_screen
from PIL import Image
from small_pem import small_pem

from reflet.pem.container import open_pem, save_pem
from reflet.scene.views.parameter_space import Axis
from reflet.view.server import viewer_server

ORBIT_VIEWS = 60  # more than the 41 that can be resident beside the base

ARGUMENTS = {
    "screen": {"samples": "adaptive"},
    "home": {"samples": 16},
    "home-at-rest": {"samples": "adaptive"},
    "home-in-motion": {"samples": [4, 16]},
    "home-multisampled": {"samples": 4, "multisampled": True, "exact": False},
    "dragged": {"samples": 16},
    "zoomed": {"samples": 4},
    "blended": {"samples": 4},
    "nearest": {"samples": 4, "blend": False},
    "without-local": {"samples": 4, "blend": False, "layers": ["diffuse", "fresnel", "distant"]},
    "infinite-sphere": {"samples": 4, "blend": False, "layers": ["distant"]},
    "far-round": {"samples": 4},  # many viewpoints: maps were evicted and fetched again on the way
}


def orbit_pem():
    """The small PEM all the way round, 6° apart, in the open: the environment is its backdrop."""
    pem = small_pem(views=ORBIT_VIEWS, size=4, with_room=False)
    azimuths = tuple(6.0 * view for view in range(ORBIT_VIEWS))
    return replace(pem, space=replace(pem.space, axes=(Axis("azimuth_deg", azimuths),)))


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """(what the browser saw, folder of its frames and of the PEMs)."""
    need_built_viewer()
    folder = tmp_path_factory.mktemp("viewer")
    save_pem(folder / "pem", small_pem(), codec="none")  # coded, a few pixels differ: see test_kinds
    save_pem(folder / "orbit", orbit_pem())
    with viewer_server(folder / "pem") as address, viewer_server(folder / "orbit") as orbit_address:
        drive("viewer.mjs", address, orbit_address, folder)
    return json.loads((folder / "seen.json").read_text()), folder


@pytest.fixture(scope="module")
def drawn(session):
    return drawn_frames(session, ARGUMENTS, lambda name: "orbit" if name == "far-round" else "pem")


def test_the_page_has_nothing_to_complain_of(session):
    assert session[0]["complaints"] == []


@pytest.mark.parametrize("name", ARGUMENTS)
def test_frames_equal_the_renderers_byte_for_byte(session, drawn, name):
    shown, expected = browser_frame(session, name), drawn[name]
    if ARGUMENTS[name]["samples"] == "adaptive":
        # of 256 positions one may lie so near an edge that the hosts' roundings put it on either side
        differ = (shown != expected).any(-1)
        assert differ.sum() <= 2 and np.abs(shown - expected).max() <= 2 / 256
        shown = np.where(differ[..., None], expected, shown)
    np.testing.assert_array_equal(shown, expected)


def test_each_step_changes_the_picture(session):
    """So the comparison above is not one of equal pictures."""
    names = [name for name, frame in session[0]["frames"].items() if name in ARGUMENTS and frame["width"] == 64]
    assert len(names) == len(ARGUMENTS) - 1  # all but the one of the whole screen
    for a, b in pairwise(browser_frame(session, name)[..., :3] for name in names):
        assert np.abs(a - b).mean() > 1e-3  # a thousandth of white: far above rounding


def test_resident_maps_are_bounded(session):
    resident = [int(re.search(r"(\d+) of (\d+) viewpoints", text)[1]) for text in session[0]["resident"]]
    assert resident[0] < ORBIT_VIEWS / 2  # opens with the neighbourhood alone
    assert max(resident) == 41  # with the base fills the cube arrays, and no more


def test_mouse_wheel_keys_and_fingers_move_the_camera(session):
    seen = session[0]
    home, dragged, zoomed = (seen["frames"][name]["viewpoint"] for name in ("home", "dragged", "zoomed"))
    # 180° for the shorter side of 360 pixels: to the left by 4 turns by +2°, down by 20 lifts by 10°.
    assert dragged["azimuth_deg"] == pytest.approx(home["azimuth_deg"] + 2.0)
    assert dragged["elevation_deg"] == pytest.approx(home["elevation_deg"] + 10.0)
    # The wheel's 100 count as 400 on a screen of a quarter pixel for each of the page's.
    assert zoomed["distance"] == pytest.approx(dragged["distance"] * 1.001**400)
    assert seen["afterArrow"]["azimuth_deg"] == pytest.approx(zoomed["azimuth_deg"] + 2.0)
    assert seen["afterHome"] == home
    assert seen["afterPinch"]["distance"] == pytest.approx(home["distance"] * 150 / 100)


def test_at_rest_nothing_is_drawn_any_more(session):
    """256 sub-samples after the first picture, each of one submission of commands, then none in half a second."""
    commands = session[0]["commands"]
    assert commands["settling"] >= 256 and commands["afterwards"] == 0


def test_the_screen_shows_the_tone_mapped_frame(session):
    """At rest the canvas shows sRGB(1 - exp(-1.6 radiance)) of 16 sub-samples, and of 256 where those disagree."""
    screen = np.asarray(Image.open(session[1] / "picture.png").convert("RGB"), np.float64)
    expected = 255.0 * srgb_display(browser_frame(session, "screen")[..., :3].astype(np.float64))
    assert screen.shape == expected.shape
    assert (
        np.abs(screen - expected).max() < 1.0
    )  # half a step of rounding, the rest for float32 powers and exponentials


def test_maps_are_laid_out_as_in_figure_5(session):
    env_map = open_pem(session[1] / "pem").maps[0][1]  # the ball's local map, with alpha
    levels = [env_map.level(mip_level) for mip_level in range(3)]
    for value, pixel in texels_on_screen(session, "maps", levels):
        shown = srgb_display(value[:3])
        # Behind transparent texels lies a board of 0.25 and 0.4.
        low, high = (np.minimum(shown + (1 - value[3]) * board, 1.0) for board in (0.25, 0.4))
        assert (pixel > low - 1 / 255).all() and (pixel < high + 1 / 255).all()  # 8-bit screen


def test_what_cannot_be_shown_is_said(session):
    notices = session[0]["notices"]
    assert re.search(r"nowhere\.gltf cannot be read: the server says 404", notices["missing"])
    assert re.search(r"truncated or no glTF file", notices["foreign"])
    assert re.search(r"drawn with WebGPU, and this browser does not offer it", notices["noWebGpu"])
