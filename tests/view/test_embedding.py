"""The viewer in pages of other people: what it leaves to them, and what may become of it there.

One browser session (web/test/embedding.mjs) drives the built viewer; here what it saw is judged.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from browser import drive, need_built_viewer
from small_pem import small_pem

from reflet.pem.container import save_pem
from reflet.scene.scene import ReflectiveObject
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.view.export import export_viewer
from reflet.view.server import viewer_server

AT_HOME = {"azimuth_deg": 60, "elevation_deg": 22, "distance": 2}
PLACED = {"azimuth_deg": 61.25, "elevation_deg": 15, "distance": 2.5}


def plain_pem():
    """A ball under the sky, of one layer: it is opened many times, and each time Chromium's rasterizer compiles what
    draws it."""
    pem = small_pem(views=2, size=4, with_room=False)
    scene = replace(pem.scene, parts=pem.scene.parts[:1], objects=(ReflectiveObject("ball", (0,)),))
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    return replace(
        pem, scene=scene, irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)),
        layers=(replace(pem.layers[0], parts=(0,)),), maps=[maps[:1] for maps in pem.maps],
        on_hull=pem.on_hull[: len(none)], sample_count=1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """What the browser saw."""
    need_built_viewer()
    folder = tmp_path_factory.mktemp("embedding")
    save_pem(folder / "pem", plain_pem())
    index = export_viewer(folder / "pem", folder / "site")
    with viewer_server(folder / "pem") as address:
        drive("embedding.mjs", address, index, folder)
    return json.loads((folder / "seen.json").read_text())


def moved(before, after):
    """By which factor or how many degrees each coordinate changed, and by how many pixels the page."""
    return {
        "scroll": after["scroll"] - before["scroll"],
        "distance": after["distance"] / before["distance"],
        "azimuth_deg": after["azimuth_deg"] - before["azimuth_deg"],
        "elevation_deg": after["elevation_deg"] - before["elevation_deg"],
    }


STILL = {"scroll": 0, "distance": 1, "azimuth_deg": 0, "elevation_deg": 0}


def test_the_page_has_nothing_to_complain_of(seen):
    """Under a content security policy that allows nothing inline, and elements from text to this viewer alone."""
    assert seen["complaints"] == []


def test_a_page_opened_from_the_disk_says_what_to_do(seen):
    assert "Opened as a file this page draws nothing" in seen["fromDisk"]
    assert "run reflet view FOLDER" in seen["fromDisk"] and "python3 -m http.server" in seen["fromDisk"]


def test_styles_of_the_page_stay_outside(seen):
    assert seen["styles"] == {"letterSpacing": "normal", "textTransform": "none", "position": "absolute"}


def test_the_wheel_is_the_pages_until_the_viewer_has_the_focus(seen):
    assert moved(seen["atFirst"], seen["afterWheel"]) == {**STILL, "scroll": 5}
    assert "Ctrl and the wheel zoom, or click the picture first" in seen["hints"]
    # The wheel's 25 count as 100 on a screen of a quarter pixel for each of the page's.
    zoomed = {**STILL, "distance": pytest.approx(1.001**100)}
    assert moved(seen["afterWheel"], seen["afterCtrlWheel"]) == zoomed
    assert moved(seen["afterCtrlWheel"], seen["afterClickAndWheel"]) == zoomed


def test_one_finger_scrolls_or_turns_sideways_and_two_do_all(seen):
    up = moved(seen["afterClickAndWheel"], seen["afterSwipeUp"])
    assert up == {**STILL, "scroll": up["scroll"]} and up["scroll"] > 0
    assert seen["hints"][-1] == "Two fingers turn and zoom, one turns sideways"
    # 180° for the shorter side of 200 pixels, from the scene's own turn on: 50 to the right, 5 down.
    right = {**STILL, "azimuth_deg": pytest.approx(-45), "elevation_deg": pytest.approx(4.5)}
    assert moved(seen["afterSwipeUp"], seen["afterSwipeRight"]) == right
    # From 100 pixels apart to 50, and 20 down.
    both = {"distance": pytest.approx(2), "azimuth_deg": pytest.approx(0), "elevation_deg": pytest.approx(18)}
    assert moved(seen["afterSwipeRight"], seen["afterTwoFingers"]) == {"scroll": 0, **both}


def test_a_button_let_go_elsewhere_turns_no_more(seen):
    before = seen["afterTwoFingers"]
    assert seen["afterLostButton"] == {name: before[name] for name in AT_HOME}


def test_the_canvas_follows_its_place_and_the_screen(seen):
    assert seen["size"] == [60, 50]  # 240 × 200 of the page's pixels
    assert seen["sizeAtTwiceTheRatio"] == [120, 100]
    assert seen["sizeHidden"] == [120, 100]  # nothing is drawn; settled() does not wait for it
    assert seen["sizeShownAgain"] == [100, 100]


def test_after_the_loss_of_its_device_the_picture_is_the_same(seen):
    assert {name: seen["beforeLoss"][name] for name in PLACED} == PLACED
    assert seen["afterLoss"] == seen["beforeLoss"]
    assert np.ptp(seen["afterLoss"]["frame"]) > 0.1  # and no empty one
    assert seen["samePanel"]


def test_put_back_it_shows_the_same_and_holds_one_device(seen):
    assert seen["removed"] == {
        "said": "The viewer was removed from the page.",
        "destroyed": 1,
        "viewpoint": PLACED,
        "exposure": 3,
    }
    assert seen["frameAgain"] == seen["beforeLoss"]["frame"] == seen["second"]


def test_another_scene_takes_the_place_of_the_first(seen):
    """Even one that was on its way: its device goes too. The sentence about a missing one goes with that."""
    other = dict(seen["other"])
    assert re.search(r"nowhere\.gltf cannot be read: the server says 404", other.pop("said"))
    # The one put back, the second viewer's, and those of the two scenes that were not shown.
    assert other.pop("destroyed") == 1 + 1 + 1 + 2
    assert other.pop("toLose") == -1  # two devices that were lost at once, before the third
    assert other == {"fresh": True, "notice": True, "panels": 1, "viewpoint": AT_HOME}


def test_devices_that_are_always_lost(seen):
    assert seen["lostAlways"].startswith("The graphics device was lost 3 times within a minute; close other pages")
    assert seen["toLose"] == 9 - 3


def test_without_webgpu_each_cause_has_its_sentence(seen):
    assert "this browser found no graphics adapter for it: hardware acceleration may be" in seen["noAdapter"]
    assert seen["insecure"] == (
        "This picture is drawn with WebGPU, which browsers offer to pages over https and from localhost only, not to "
        "http://lab.example:8000. Open it over https, or run ssh -N -L 8000:lab.example:8000 lab.example and open "
        "http://localhost:8000/user/you/proxy/80/"
    )
    assert seen["selected"] == seen["insecure"]  # so that the command can be copied


def test_a_page_of_our_own_takes_all_gestures_but_in_a_frame(seen):
    assert seen["captured"] == [1, 0]
