"""The viewer in a browser draws environment-mapped materials as the renderer does.

One browser session (web/test/shading.mjs) drives the built viewer; here its frames are judged against those of
`EnvMapRenderer` with the device's prefilters, on the same rasterizer, and of `MaterialRenderer`, which filters with the
CPU.
"""

import json
from itertools import pairwise

import numpy as np
import pytest
from browser import draw, drive, need_built_viewer

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import facts
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import read_env_image
from reflet.files.measured_brdf_file import read_measured_brdf, write_measured_brdf
from reflet.npr.drawing import drawn_levels
from reflet.npr.drawings import drawing
from reflet.reflectance.brdfs.brdf import FunctionBrdf
from reflet.reflectance.brdfs.measured_brdf import tabulate
from reflet.reflectance.lobes.lobes import fit_lobes
from reflet.reflectance.materials.map_material import Lookup, MapMaterial
from reflet.reflectance.materials.material import Coated, Mirror
from reflet.reflectance.materials.metals import METALS
from reflet.reflectance.prefilter.brdf_map import brdf_map_3d, rows_for
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.views.parameter_space import Orbit
from reflet.view.export import export_viewer
from reflet.view.server import viewer_server
from reflet.view.shaded_scene import NamedMap, material_to_json, write_shaded_scene

GOLD = METALS["Au"]
MATERIALS = {
    "mirror": {"kind": "mirror", "reflectance": [0.9, 0.8, 0.7]},
    "dielectric": {"kind": "dielectric", "index": 5.0},
    "dielectric_over_diffuse": {"kind": "dielectric_over_diffuse", "index": 1.5, "albedo": [0.5, 0.02, 0.02]},
    "coated": {"kind": "coated", "index": 1.5, "albedo": [0.1, 0.5, 0.9]},
    "conductor": {"kind": "conductor", "n": list(GOLD.n), "k": list(GOLD.k)},
    "phong": {"kind": "phong", "exponent": 10.0, "specular": [0.6, 0.5, 0.4], "diffuse": [0.1, 0.2, 0.3]},
    "phong-sharper": {"kind": "phong", "exponent": 200.0, "specular": [0.6, 0.5, 0.4], "diffuse": [0.1, 0.2, 0.3]},
    "ggx": {"kind": "ggx", "baseColor": [0.9, 0.6, 0.2], "metallic": 1.0, "roughness": 0.6},
    "ggx-smoother": {"kind": "ggx", "baseColor": [0.9, 0.6, 0.2], "metallic": 0.5, "roughness": 0.2},
    "table": {"kind": "table", "table": "paint.npz"},
    "by-normal": {"kind": "map", "map": "directions"},
    "drawn": {"kind": "map", "map": "gooch+silhouette"},
}
LAMP = {"on": True, "azimuth": 20, "elevation": 25, "radius": 12, "brightness": 16, "colour": [1, 0.8, 0.5]}
SETTINGS = {name: {"material": material} for name, material in MATERIALS.items()} | {
    "ggx-in-turned-light": {"material": MATERIALS["ggx"], "turn": 70},
    "mirror-by-lamp": {"material": MATERIALS["mirror"], "turn": 0, "lamp": LAMP},
    "coated-by-lamp": {"material": MATERIALS["coated"]},
    "phong-by-lamp": {"material": MATERIALS["phong"]},
    "ggx-by-lamp": {"material": MATERIALS["ggx"]},
    "table-by-lamp": {"material": MATERIALS["table"]},
    "table-by-moved-lamp": {"lamp": {"azimuth": 70, "radius": 20, "colour": [0.2, 0.5, 1]}},
    "ggx-by-moved-lamp": {"material": MATERIALS["ggx"]},
    "table-again": {"material": MATERIALS["table"], "lamp": {"on": False}},
    "ggx-again": {"material": MATERIALS["ggx"], "turn": 70},
}
FILTERED = (
    "table",
    "phong",
    "phong-sharper",
    "ggx",
    "ggx-smoother",
    "ggx-in-turned-light",
    "phong-again",
    "phong-by-keys",
    *(name for name in SETTINGS if name.endswith(("lamp", "again"))),
)
BY_HAND = ("phong-again", "phong-by-keys", "copper", "alone", "turned")


def environment():
    """A sky over ground with a bright window, 100 times as bright: what filters must not smear or lose."""
    d, _ = CUBE.texel_directions(64)
    sky = 0.4 + 0.3 * d[..., 1:2] + 0.1 * np.sin(9.0 * d)
    window = (d @ np.array([0.6, 0.64, 0.48]) > 0.97)[..., None]
    return EnvImage(CUBE, (sky + 40.0 * window * np.array([1.0, 0.9, 0.7])).astype(np.float32))


def directions():
    """A map whose colours are its directions."""
    levels = []
    for k in range(7):
        d, _ = CUBE.texel_directions(64 >> k)
        levels.append(EnvImage(CUBE, (0.5 + 0.5 * d).astype(np.float32)))
    return tuple(levels)


def paint(cos_i, cos_o, delta_phi):
    """Red ground, a broad highlight, and a blue one back to the viewer."""
    sines = np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2))
    mirrored, back = (np.maximum(cos_i * cos_o + side * sines * np.cos(delta_phi), 0.0) for side in (-1.0, 1.0))
    white, blue = np.array([1.0, 1.0, 1.0]), np.array([0.2, 0.4, 1.0])
    return 0.1 * np.array([1.0, 0.3, 0.2]) + (mirrored**20)[..., None] * white + (back**10)[..., None] * blue


def measured(path):
    """The environment, as its file holds it, filtered with the lobes of a table that is written to this path."""
    write_measured_brdf(path, tabulate(FunctionBrdf(paint), 16, 31))
    lobes = fit_lobes(read_measured_brdf(path), angles=3)
    light = EnvImage(CUBE, environment().texels.astype(np.float16).astype(np.float32))
    return brdf_map_3d(light, lobes, Octahedral(), rows_for(lobes, Octahedral(), 128))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A torus in that environment, a measured paint, and two maps to show as they are."""
    folder = tmp_path_factory.mktemp("shading")
    maps = {
        "directions": NamedMap(directions(), Lookup.NORMAL),
        "gooch+silhouette": NamedMap(drawn_levels(drawing("gooch+silhouette"), DualParaboloid(), 64)),
    }
    orbit = Orbit((0.0, 0.0, 0.0), -60.0, 30.0, 3.5)
    mesh = torus_mesh(around=72, sides=36)
    tables = {"paint.npz": measured(folder / "paint.npz")}
    write_shaded_scene(folder, mesh, environment(), orbit, [Coated(1.5)], maps=maps, tables=tables)
    return folder


@pytest.fixture(scope="module")
def seen(folder):
    """What the browser saw; its frames lie in the folder."""
    need_built_viewer()
    with viewer_server(folder) as address:
        drive("shading.mjs", address, folder, json.dumps(SETTINGS))
    return json.loads((folder / "seen.json").read_text())


@pytest.fixture(scope="module")
def drawn(seen, folder):
    """The same frames by Python, by the settings that the viewer says it has."""
    requests = {
        name: {"width": 64, "height": 48, "samples": 16 if name == "all-samples" else 1, "settings": settings}
        for name, settings in seen["settings"].items()
        if not name.endswith("-loss")
    }
    (folder / "requests.json").write_text(json.dumps(requests))
    return draw("draw_materials.py", folder, folder / "requests.json", folder / "drawn.npz")


def frame(folder, name):
    """A raw frame as the browser read it back."""
    return np.fromfile(folder / f"{name}.f32", np.float32).reshape(48, 64, 4)


def display_psnr(a, b):
    """CONVENTIONS.md: sRGB(1 - exp(-1.6 radiance)); in dB."""

    def display(radiance):
        linear = 1.0 - np.exp(-1.6 * radiance.astype(np.float64))
        return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)

    return -10.0 * np.log10(np.mean(np.square(display(a[..., :3]) - display(b[..., :3]))))


def test_the_page_has_nothing_to_complain_of(seen):
    assert seen["complaints"] == []


@pytest.mark.parametrize("name", ["home", *SETTINGS, *BY_HAND])
def test_frames_equal_the_renderers(seen, folder, drawn, name):
    """Byte for byte, but where maps are filtered: weights and taps are reckoned in other languages' arithmetic, and a
    sum that falls on the other side of a half float's rounding moves by 2⁻¹¹. The renderer holds the table's maps in
    float32, so that every texel is off by so much, and a sum of positive ones at most by as much."""
    expected, found = drawn[name], frame(folder, name)
    if name in ("by-normal", "drawn"):  # on white paper
        expected = expected + (1.0 - expected[..., 3:]) * np.array([1.0, 1.0, 1.0, 0.0], np.float32)
    if name in FILTERED:
        np.testing.assert_allclose(found, expected, rtol=2.0**-10, atol=1e-5)
    else:
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(("name", "least"), [
    ("mirror", 80.0),  # the hardware's filter against eight loads: the same but for its rounding; measured 96
    ("coated", 80.0), ("conductor", 80.0),
    ("phong", 34.0), ("phong-sharper", 34.0), ("phong-by-keys", 34.0),  # the paper's hardware method has 36 to 40
    ("table", 70.0),  # half floats, and a finer diffuse map: measured 78
    ("table-by-lamp", 52.0), ("table-by-moved-lamp", 52.0),  # taps: measured 59
    ("ggx", 40.0), ("ggx-smoother", 40.0), ("ggx-in-turned-light", 40.0),  # taps, and fewer levels, have 43
])  # fmt: skip
def test_frames_are_close_to_maps_filtered_by_the_cpu(seen, folder, drawn, name, least):
    assert display_psnr(frame(folder, name), drawn[f"{name}-cpu"]) > least


def test_all_samples_make_the_renderers_antialiased_picture(seen, folder, drawn):
    """16 samples each: at other places in the pixel, so that edges differ by some shades."""
    shown = drawn["all-samples"]
    antialiased = display_psnr(frame(folder, "all-samples"), shown)
    assert antialiased > 38.0  # measured 42; the one pass in motion has 35
    assert antialiased > display_psnr(frame(folder, "multisampled"), shown)


def test_each_step_changes_the_picture(seen, folder):
    """So the comparisons above are not of equal pictures."""
    names = ["home", *SETTINGS, *BY_HAND]
    for a, b in pairwise(names):
        assert np.abs(frame(folder, a)[..., :3] - frame(folder, b)[..., :3]).mean() > 1e-3  # far above rounding


def test_the_lamp_lights_what_is_turned_to_it_and_leaves_no_trace(seen, folder):
    """With it and without, the material and the light's turn being equal."""
    for name, least in (("mirror", 0.0), ("coated", -0.03)):  # diffuse light is summed on the device: off by as much
        gain = frame(folder, f"{name}-by-lamp")[..., :3] - frame(folder, name)[..., :3]
        assert gain.min() > least - 1e-6 and gain.mean() > 0.02
    np.testing.assert_array_equal(frame(folder, "ggx-again"), frame(folder, "ggx-in-turned-light"))
    np.testing.assert_array_equal(frame(folder, "table-again"), frame(folder, "table"))


def test_keys_and_panel_move_the_lamp(seen):
    """And it goes round by itself: else the script would have waited in vain."""
    assert seen["lampByKeys"] == {**LAMP, "azimuth": 72, "radius": 20, "colour": [0.2, 0.5, 1], "circling": False}
    assert (seen["lampByPanel"]["radius"], seen["lampByPanel"]["circling"]) == (20.5, True)


def test_the_exponent_follows_the_keys(seen):
    """Ten steps of a twentieth of an octave."""
    before, after = (seen["settings"][name]["material"] for name in ("phong-again", "phong-by-keys"))
    assert after["exponent"] == pytest.approx(before["exponent"] * 2**0.5, rel=0.02)  # the slider's first step rounds
    assert {**after, "exponent": 0} == {**before, "exponent": 0}


def test_shift_drag_and_keys_turn_the_light_alone(seen):
    # 180° for the shorter side of 360 pixels: by 40 to the right 20°, from the 70° before.
    assert seen["settings"]["alone"]["turn"] == 70
    assert seen["settings"]["turned"]["turn"] == pytest.approx(90)
    assert seen["afterKey"]["turn"] == pytest.approx(92)
    assert seen["viewpoint"] == {"azimuth_deg": -60, "elevation_deg": 30, "distance": 3.5}


def test_materials_that_are_not_there_are_refused(seen):
    for name, said in zip(("map:nothing", "table:nothing", "velvet"), seen["unknown"], strict=True):
        assert said.startswith(f"There is no material {name} here; there are mirror, dielectric, ")
        assert said.endswith(", map:directions, map:gooch+silhouette, table:paint.npz.")


def test_after_the_loss_of_its_device_the_picture_is_the_same(seen, folder):
    assert seen["settings"]["after-loss"] == seen["settings"]["before-loss"]
    np.testing.assert_array_equal(frame(folder, "after-loss"), frame(folder, "before-loss"))
    assert np.ptp(frame(folder, "after-loss")[..., :3]) > 0.1  # and no empty one


def test_the_panel_chooses_metals_by_name(seen):
    assert seen["settings"]["copper"]["material"] == material_to_json(METALS["Cu"])


def test_a_shaded_scene_is_exported_as_a_whole_page(folder, tmp_path):
    need_built_viewer()
    index = export_viewer(folder, tmp_path / "site")
    assert 'src="scene/scene.gltf"' in index.read_text()
    assert (tmp_path / "site/scene/maps/environment.ktx2").exists()


def test_what_the_viewer_cannot_show_is_one_sentence(tmp_path):
    with pytest.raises(RefletError, match="cannot show a MapMaterial"):
        write_shaded_scene(tmp_path, torus_mesh(), None, Orbit((0.0, 0.0, 0.0), 0.0, 0.0, 3.0), [MapMaterial()])
    assert not (tmp_path / "scene.gltf").exists()
    assert material_to_json(Mirror()) == {"kind": "mirror", "reflectance": [1.0, 1.0, 1.0]}


def test_a_sun_beyond_half_floats_keeps_its_light_in_the_files(tmp_path):
    """What the browser uploads are these files' half floats as they are."""
    texels = np.full((1, 128, 256, 3), 0.5, np.float32)
    texels[0, 40:42, 100:103] = 3e6
    image = EnvImage(PARAMETERIZATIONS["latlong"], texels)
    with pytest.warns(RefletWarning, match="none is lost") as said:
        write_shaded_scene(tmp_path, torus_mesh(), image, Orbit((0.0, 0.0, 0.0), 0.0, 0.0, 3.0), [Coated(1.5)])
    assert len(said) == 1
    cube, before = facts(read_env_image(tmp_path / "maps/environment.ktx2")), facts(image)
    np.testing.assert_allclose(cube.power, before.power, rtol=1e-3)  # half floats' 2⁻¹¹, and as much for resampling
    assert np.linalg.norm(np.subtract(cube.dominant, before.dominant)) < 0.5 * np.pi / 128  # half a texel
    diffuse = facts(read_env_image(tmp_path / "maps/diffuse.ktx2"))
    np.testing.assert_allclose(diffuse.power, before.power, rtol=2e-3)  # and of prefiltered ones
