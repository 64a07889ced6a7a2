"""The viewer in a browser shows what the renderer draws.

One browser session (web/test/viewer.mjs) drives the built viewer; here its frames are judged against `Renderer`'s.
"""

import json
import re
from contextlib import ExitStack
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from browser import draw, drive, need_built_viewer
from PIL import Image
from small_pem import small_pem

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.relief import Relief
from reflet.pem.container import save_pem
from reflet.scene.views.parameter_space import Axis
from reflet.view.server import viewer_server

ORBIT_VIEWS = 60  # more than the 42 that can be resident

# Twice as wide; two faces; a frame of its own for each sample; distances in a map of their own.
OTHERS = ("latlong", "dual_paraboloid", "gazing_ball", "relief")
LAYERS = ["diffuse", "fresnel", "distant", "local"]
ARGUMENTS = {
    "home": {"samples": 16},
    "home-multisampled": {"samples": 4, "multisampled": True, "exact": False},
    "dragged": {"samples": 16},
    "zoomed": {"samples": 4},
    "blended": {"samples": 4},
    "nearest": {"samples": 4, "blend": False},
    "without-local": {"samples": 4, "blend": False, "layers": ["diffuse", "fresnel", "distant"]},
    "distant-alone": {"samples": 4, "blend": False, "layers": ["distant"]},
    "infinite-sphere": {"samples": 4, "blend": False, "layers": ["distant"]},
    "far-round": {"samples": 4},  # many viewpoints: maps were evicted and fetched again on the way
    **{name: {"samples": 4} for name in OTHERS},
    "gazing_ball-multisampled": {"samples": 4, "multisampled": True, "exact": False},
}


def pem_folder(name):
    """The PEM that a frame shows."""
    return "orbit" if name == "far-round" else next((other for other in OTHERS if name.startswith(other)), "pem")


def orbit_pem():
    """The small PEM all the way round, 6° apart, in the open: the environment is its backdrop."""
    pem = small_pem(views=ORBIT_VIEWS, size=4, with_room=False)
    azimuths = tuple(6.0 * view for view in range(ORBIT_VIEWS))
    return replace(pem, space=replace(pem.space, axes=(Axis("azimuth_deg", azimuths),)))


def relief_pem():
    """The small PEM, its surroundings of no shape but somewhat rough: no texel's distance is its neighbour's."""
    pem = small_pem()
    inverse = np.random.default_rng(3).uniform(0.3, 0.6, (6, 8, 8)).astype(np.float16)
    box = pem.layers[0].geometry
    relief = Relief(inverse, box.lower, box.upper, box.origin)
    return replace(pem, layers=(replace(pem.layers[0], geometry=relief), *pem.layers[1:]))


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """(what the browser saw, folder of its frames, PEM folder, orbit's PEM folder)."""
    need_built_viewer()
    folder = tmp_path_factory.mktemp("viewer")
    save_pem(folder / "pem", small_pem())
    save_pem(folder / "orbit", orbit_pem())
    for name in OTHERS:
        save_pem(
            folder / name, relief_pem() if name == "relief" else small_pem(parameterization=PARAMETERIZATIONS[name])
        )
    with ExitStack() as servers:
        address, orbit_address, *others = (
            servers.enter_context(viewer_server(folder / name)) for name in ("pem", "orbit", *OTHERS)
        )
        by_name = json.dumps(dict(zip(OTHERS, others, strict=True)))
        drive("viewer.mjs", address, orbit_address, folder, by_name)
    return json.loads((folder / "seen.json").read_text()), folder


def browser_frame(session, name):
    """A raw frame as the browser read it back."""
    seen, folder = session
    frame = seen["frames"][name]
    return np.fromfile(folder / f"{name}.f32", np.float32).reshape(frame["height"], frame["width"], 4)


def srgb_display(radiance):
    """CONVENTIONS.md: sRGB(1 - exp(-1.6 radiance))."""
    linear = 1.0 - np.exp(-1.6 * radiance)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


@pytest.fixture(scope="module")
def drawn(session):
    """The same frames by the Python renderer on Chromium's rasterizer."""
    seen, folder = session
    requests = {
        name: {
            **seen["frames"][name],
            "arguments": arguments,
            "pem": pem_folder(name),
            "infinite": name == "infinite-sphere",
        }
        for name, arguments in ARGUMENTS.items()
    }
    (folder / "requests.json").write_text(json.dumps(requests))
    return draw("draw_frames.py", folder, folder / "requests.json", folder / "drawn.npz")


def test_the_page_has_nothing_to_complain_of(session):
    assert session[0]["complaints"] == []


@pytest.mark.parametrize("name", ARGUMENTS)
def test_frames_equal_the_renderers_byte_for_byte(session, drawn, name):
    np.testing.assert_array_equal(browser_frame(session, name), drawn[name])


def test_each_step_changes_the_picture(session):
    """So the comparison above is not one of equal pictures."""
    names = [name for name, frame in session[0]["frames"].items() if name in ARGUMENTS and frame["width"] == 64]
    assert len(names) == len(ARGUMENTS) - 1  # all but the one of the whole screen
    for a, b in pairwise(browser_frame(session, name)[..., :3] for name in names):
        assert np.abs(a - b).mean() > 1e-3  # a thousandth of white: far above rounding


def test_resident_maps_are_bounded(session):
    resident = [int(re.search(r"(\d+) of (\d+) viewpoints", text)[1]) for text in session[0]["resident"]]
    assert resident[0] < ORBIT_VIEWS / 2  # opens with the neighbourhood alone
    assert max(resident) == 42  # fills the cube arrays, and no more


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


def test_the_screen_shows_the_tone_mapped_frame(session):
    """At rest the canvas shows sRGB(1 - exp(-1.6 radiance)) of all 16 sub-samples."""
    screen = np.asarray(Image.open(session[1] / "picture.png").convert("RGB"), np.float64)
    expected = 255.0 * srgb_display(browser_frame(session, "home")[..., :3].astype(np.float64))
    assert screen.shape == expected.shape
    assert (
        np.abs(screen - expected).max() < 1.0
    )  # half a step of rounding, the rest for float32 powers and exponentials


def test_maps_are_laid_out_as_in_figure_5(session):
    """Faces px nx py ny pz nz from left to right, each further level below at half the size."""
    screen = np.asarray(Image.open(session[1] / "maps.png").convert("RGB"), np.float64) / 255.0
    height, width = screen.shape[:2]
    face = min(width / 6.5, height / 2.5)
    left, top = round((width - 6 * face) / 2), round((height - 2 * face) / 2)
    env_map = small_pem().maps[0][1]  # the ball's local map, with alpha
    for mip_level in range(3):
        size, edge = env_map.chain.level_sizes[mip_level], face / 2**mip_level
        y = top + 2 * face - 2 * edge
        for number in range(6):
            row, column = size // 4, size // 2
            at_x, at_y = left + (number + (column + 0.5) / size) * edge, y + (row + 0.5) / size * edge
            value = env_map.level(mip_level)[number, row, column].astype(np.float16).astype(np.float64)
            shown = srgb_display(value[:3])
            # Behind transparent texels lies a board of 0.25 and 0.4.
            low, high = (np.minimum(shown + (1 - value[3]) * board, 1.0) for board in (0.25, 0.4))
            pixel = screen[int(at_y), int(at_x)]
            assert (pixel > low - 1 / 255).all() and (pixel < high + 1 / 255).all(), (mip_level, number)  # 8-bit screen


def test_what_cannot_be_shown_is_said(session):
    notices = session[0]["notices"]
    assert re.search(r"nowhere\.gltf cannot be read: the server says 404", notices["missing"])
    assert re.search(r"truncated or no glTF file", notices["foreign"])
    assert re.search(r"drawn with WebGPU, and this browser does not offer it", notices["noWebGpu"])
