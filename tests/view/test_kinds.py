"""PEMs of every kind in a browser, frame by frame as the renderer draws them.

One browser session (web/test/kinds.mjs) opens them; here its frames are judged against `Renderer`'s.
"""

import json
from contextlib import ExitStack
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from browser import drive, need_built_viewer
from frames import browser_frame, drawn_frames, srgb, srgb_display, texels_on_screen
from small_pem import small_pem
from surface_layers import random_surface

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.relief import Relief
from reflet.pem.container import open_pem, save_pem
from reflet.scene.material import CLAMPS, Refraction, Texture
from reflet.scene.scene import Part
from reflet.view.server import viewer_server

BETWEEN = {"azimuth_deg": 61.25}
# A frame of its own for each sample; shells, half faded to their base; shells of another parameterization with a base
# alone; mirrors that see each other, painted all over; and glass, solid and thin.
KINDS = {
    "gazing_ball": BETWEEN,
    "shells": {"azimuth_deg": 61.25, "elevation_deg": 27.0},
    "static": {"azimuth_deg": 200.0, "elevation_deg": 40.0},
    "traced": BETWEEN,
    "glass": BETWEEN,
}
# Twice as wide; two faces; distances in a map of their own.
SLOW_KINDS = {"latlong": BETWEEN, "dual_paraboloid": BETWEEN, "relief": BETWEEN}
VIEWPOINTS = {**KINDS, **SLOW_KINDS}
# Both readers read coded PEMs to the same bits (test_web_twins, test_coded_maps). Yet of these two, and of "pem", a few
# pixels on the ball's silhouette differ where its mesh is coded: why is not known.
UNCODED = ("shells", "traced")
# What is done with some of them besides (web/test/kinds.mjs).
STEPS = {
    "gazing_ball": ["multisampled"],
    "shells": ["multisampled", "maps", "far", "infinite-sphere"],
    "traced": ["without"],
}
ARGUMENTS = {
    **{name: {"samples": 4} for name in KINDS},
    "gazing_ball-multisampled": {"samples": 4, "multisampled": True, "exact": False},
    "shells-multisampled": {"samples": 4, "multisampled": True, "exact": False},
    "shells-far": {"samples": 4, "shells": [1]},
    "shells-far-origin": {"samples": 4, "shells": [1], "by_origin": True},
    "shells-infinite-sphere": {"samples": 4},
    "traced-without": {"samples": 4, "layers": ["diffuse", "fresnel", "distant"]},
}
# Chromium's rasterizer takes a quarter of a minute to compile each program that traces.
SLOW_STEPS = {"traced": ["multisampled", "origin"]}
SLOW_ARGUMENTS = {
    "traced-multisampled": {"samples": 4, "multisampled": True, "exact": False},
    "traced-origin": {"samples": 4, "by_origin": True},
}


def relief_pem():
    """The small PEM, its surroundings of no shape but somewhat rough: no texel's distance is its neighbour's."""
    pem = small_pem()
    inverse = np.random.default_rng(3).uniform(0.3, 0.6, (6, 8, 8)).astype(np.float16)
    box = pem.layers[0].geometry
    relief = Relief(inverse, box.lower, box.upper, box.origin)
    return replace(pem, layers=(replace(pem.layers[0], geometry=relief), *pem.layers[1:]))


def traced_pem():
    """The small PEM, its balls painted, rays traced from one to the other, and to the lamp: it hangs low enough to be a
    companion, with textures of which only its colour may count. Vertices have colours and further texture coordinates,
    and textures wrap in all ways; the ball is rough here and there and has maps of local light; the lamp has holes, the
    room is blended, dielectrics reflect by their own index."""
    pem = small_pem()

    def picture(seed, *size):
        return Texture(
            np.random.default_rng(seed).integers(0, 256, (*size, 4)).astype(np.uint8) | np.uint8([0, 0, 0, 255])
        )

    ball, knob, room, lamp = pem.scene.parts
    painted = replace(
        ball.material, metallic=0.9,
        base_color_texture_srgb=replace(picture(1, 5, 9), wraps=("mirror", "repeat"), coordinates=2),
        metallic_roughness_texture=replace(picture(2, 4, 4), wraps=CLAMPS, coordinates=1), emission=(0.1, 0.2, 0.0),
        perceptual_roughness=0.4,
    )  # fmt: skip
    shining = replace(knob.material, emission=(0.5, 0.1, 0.1), emission_texture_srgb=picture(3, 3, 2))
    low = replace(lamp.mesh, positions=lamp.mesh.positions * np.float32(0.6))
    dull = replace(painted, metallic=1.0, double_sided=True, alpha_mode="mask", alpha_cutoff=0.7)
    painted = replace(painted, ior=1.8, specular=0.7, specular_color=(1.0, 0.5, 0.2))
    tiled = replace(room.material.base_color_texture_srgb, wraps=("clamp", "mirror"), coordinates=1)
    parts = (
        Part("ball", dressed(ball.mesh), painted, True),
        replace(knob, mesh=dressed(knob.mesh), material=shining),
        Part("room", dressed(room.mesh), replace(room.material, base_color_texture_srgb=tiled, alpha_mode="blend")),
        Part("lamp", dressed(low), dull),
    )
    out = replace(pem, scene=replace(pem.scene, parts=parts), most_hits=5)
    assert out.companions == (3,)
    return replace(out, surface=random_surface(out.scene, (0,)))


def dressed(mesh):
    """With colours, and two further sets of texture coordinates that go beyond the pictures' edges."""
    uv = mesh.uv if mesh.uv is not None else mesh.positions[:, :2].copy()
    colors = np.random.default_rng(7).uniform(0.4, 1.0, (len(uv), 4)).astype(np.float32)
    further = uv * np.float32(1.3) - np.float32(0.2), uv * np.float32([-1.5, 2.0]) + np.float32(0.1)
    return replace(mesh, uv=uv, colors=colors, more_uv=further)


def glass_pem():
    """The same of coloured glass, some of the light diffuse; the knob a bubble."""
    pem = traced_pem()
    ball, knob, *rest = pem.scene.parts
    green = Refraction(1.4, transmission=0.8, attenuation_color=(0.1, 0.9, 0.4), attenuation_distance=0.7)
    glass = replace(ball.material, refraction=green, emission=(0.0, 0.0, 0.0))
    bubble = replace(knob.material, emission=(0.0, 0.0, 0.0), refraction=Refraction(1.6, thin=True))
    parts = (replace(ball, material=glass), replace(knob, material=bubble), *rest)
    return replace(pem, scene=replace(pem.scene, parts=parts), surface=None)


def pem_of(name):
    """One of `VIEWPOINTS`."""
    match name:
        case "relief":
            return relief_pem()
        case "shells":
            return small_pem(shells=2)
        case "static":
            return small_pem(views=0, shells=3, parameterization=PARAMETERIZATIONS["dual_paraboloid"])
        case "traced":
            return traced_pem()
        case "glass":
            return glass_pem()
    return small_pem(parameterization=PARAMETERIZATIONS[name])


def seen_by_browser(folder, kinds, steps):
    """(what the browser saw of these kinds, folder of its frames and of the PEMs)."""
    need_built_viewer()
    for name in kinds:
        save_pem(folder / name, pem_of(name), codec="none" if name in UNCODED else "av1")
    with ExitStack() as servers:
        by_name = {
            name: {
                "address": servers.enter_context(viewer_server(folder / name)),
                "viewpoint": VIEWPOINTS[name],
                "steps": steps.get(name, []),
            }
            for name in kinds
        }
        drive("kinds.mjs", folder, json.dumps(by_name))
    return json.loads((folder / "seen.json").read_text()), folder


def kind_of(frame):
    """The PEM that a frame shows."""
    return next(kind for kind in VIEWPOINTS if frame.startswith(kind))


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return seen_by_browser(tmp_path_factory.mktemp("kinds"), KINDS, STEPS)


@pytest.fixture(scope="module")
def drawn(session):
    return drawn_frames(session, ARGUMENTS, kind_of)


def test_no_kind_has_anything_to_complain_of(session):
    assert session[0]["complaints"] == []


@pytest.mark.parametrize("name", ARGUMENTS)
def test_frames_equal_the_renderers_byte_for_byte(session, drawn, name):
    np.testing.assert_array_equal(browser_frame(session, name), drawn[name])


@pytest.mark.slow
def test_other_kinds(tmp_path):
    """Half a minute. Their parts are in quick tests: two faces in "static", reliefs in "shells"; all parameterizations'
    lookups, whose text both hosts share, in tests/render/test_parameterization_twins.py."""
    session = seen_by_browser(tmp_path, SLOW_KINDS, {})
    assert session[0]["complaints"] == []
    drawn = drawn_frames(session, {name: {"samples": 4} for name in SLOW_KINDS}, kind_of)
    for name in SLOW_KINDS:
        np.testing.assert_array_equal(browser_frame(session, name), drawn[name])


@pytest.mark.slow
def test_other_frames_of_mirrors_that_see_each_other(tmp_path):
    """Most of a minute. Their parts are in quick tests: what is traced in "traced", multi-sampling and colours by
    origin in frames of shells, and both where rays are traced in tests/render/test_traced.py."""
    session = seen_by_browser(tmp_path, SLOW_STEPS, SLOW_STEPS)
    drawn = drawn_frames(session, SLOW_ARGUMENTS, kind_of)
    for name in SLOW_ARGUMENTS:
        np.testing.assert_array_equal(browser_frame(session, name), drawn[name])
    different = np.abs(browser_frame(session, "traced-origin") - browser_frame(session, "traced"))[..., :3]
    assert different.mean() > 1e-3  # a thousandth of white: far above rounding


def test_a_settled_picture_is_of_full_size(session):
    """As soon as the viewer is ready too, even where nothing has to be fetched any more."""
    assert session[0]["settledSize"] == [120, 90]


def test_each_kind_and_step_changes_the_picture(session):
    """So the comparison above is not one of equal pictures."""
    names = list(session[0]["frames"])
    assert sorted(names) == sorted(ARGUMENTS)
    for a, b in pairwise(browser_frame(session, name)[..., :3] for name in names):
        assert np.abs(a - b).mean() > 1e-3  # a thousandth of white: far above rounding


def test_maps_show_alpha_distance_and_what_serves_all_viewpoints(session):
    pem = open_pem(session[1] / "shells")
    near = pem.maps[1][0]  # 61.25° is nearer to 62° than to 60°
    inverse = pem.layers[0].geometry.inverse_distance
    expected = {
        "alpha": [near.level(mip_level)[..., 3] for mip_level in range(3)],
        "distance": [srgb(inverse / inverse.max().astype(float))],
        "base": [srgb_display(pem.base[1].level(mip_level).astype(float)) for mip_level in range(3)],
    }
    for name, levels in expected.items():
        for value, pixel in texels_on_screen(session, name, levels):
            np.testing.assert_allclose(pixel, np.broadcast_to(value, 3), atol=1.5 / 255)  # 8-bit screen, half floats
