"""What the web part shares with Python: the shaders' text, tables and small functions, the glTF file."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_pem import small_pem
from surface_layers import random_surface

from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, pack
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import FAR_AWAY
from reflet.pem.arrays import BufferWriter
from reflet.pem.container import open_pem, save_pem
from reflet.pem.geometry_json import geometry_to_json as described
from reflet.render.playback.hit_buffers import bvh_words
from reflet.render.playback.punctual_lights import light_words
from reflet.scene.bvh.build import build_bvh
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.scene import ReflectiveObject, Scene
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.scene.views.sample_pattern import SAMPLE_COUNTS, sample_positions
from reflet.shaders.link import link

WEB = Path(__file__).parents[2] / "web"

CENTRE, HALF, ORIGIN = (0.5, 1.0, -0.25), (1.0, 2.0, 3.0), (0.1, 0.2, 0.3)
BOX = Box((-0.5, -1.0, -3.25), (1.5, 3.0, 2.75), ORIGIN)
GEOMETRIES = (
    InfiniteSphere(),
    Sphere(CENTRE, (2.0, 2.0, 2.0), ORIGIN),
    Ellipsoid(CENTRE, HALF, ORIGIN),
    BOX,
    Hemisphere(CENTRE, HALF, 0.5, ORIGIN),
)
LIGHTS = (
    PunctualLight("lamp", (3.0, 0.1, 1.7), (0.5, 0.25, -2.0), (0.6, -0.8, 0.0), cone=(0.25, 0.5)),
    PunctualLight("sun", (0.1, 0.2, 0.3), None, (0.0, -1.0, 0.0)),
)
SURROUNDINGS = {"lower": [-5.0, -5.0, -5.0], "upper": [5.0, 5.0, 5.0]}


@pytest.fixture(scope="module")
def node(tmp_path_factory):
    """Runs a script of web/test and gives what it printed."""
    if not shutil.which("node") or not (WEB / "node_modules").exists():
        pytest.skip("needs Node.js and its packages; run: make web")

    def run(script, *arguments):
        command = ["node", f"test/{script}", *map(str, arguments)]
        done = subprocess.run(command, cwd=WEB, capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="module")
def call(node, tmp_path_factory):
    """Calls functions of the viewer: [(module, function, arguments), …]."""

    def run(calls):
        path = tmp_path_factory.mktemp("calls") / "calls.json"
        path.write_text(json.dumps(calls))
        return node("call.mjs", path)

    return run


@pytest.fixture(scope="module")
def node_reads(node, tmp_path_factory):
    """What the viewer reads of a PEM's folder, or the sentence that it refuses it by."""

    def run(folder):
        out = tmp_path_factory.mktemp("read") / "pem.json"
        said = node("read_pem.mjs", folder, out)
        return json.loads(out.read_text()) if said == "read" else said

    return run


def test_both_linkers_give_the_same_bytes(call):
    programs = ("picture", "traced_picture", "backdrop", "accumulate", "display", "map_view", "mipmap", "probe")
    linked = call([("gpu/device/shaders", "link", [program]) for program in programs])
    assert [link(f"{program}.wgsl") for program in programs] == linked
    assert "#import" not in re.sub(r"//.*", "", linked[0])


def test_sub_samples_are_those_of_the_table(call):
    found = call([("maths/sample-pattern", "samplePositions", [count]) for count in SAMPLE_COUNTS])
    for count, positions in zip(SAMPLE_COUNTS, found, strict=True):
        np.testing.assert_array_equal(positions, sample_positions(count))


def test_the_tree_is_refitted_to_the_same_boxes(call):
    """Bit for bit; a companion, which does not reflect, stands before the mirrors and the lamp, which is none, between
    them, so that numbers differ from places."""
    scene = small_pem().scene
    ball, knob, room, lamp = scene.parts
    room = replace(room, mesh=replace(room.mesh, positions=room.mesh.positions * np.float32(0.6)))
    parts = (room, ball, lamp, replace(knob, mesh=replace(knob.mesh, triangles=knob.mesh.triangles[::-1].copy())))
    scene = Scene(parts, (ReflectiveObject("balls", (1, 3)),))
    bvh = build_bvh(scene, np.zeros(scene.triangle_offsets[-1], bool))
    assert bvh.companions == (0,)
    described = [
        {
            "reflective": part.reflective,
            "indices": part.mesh.triangles.ravel().tolist(),
            "positions": part.mesh.positions.ravel().tolist(),
        }
        for part in parts
    ]
    tree = {"order": bvh.order.tolist(), "leafCounts": bvh.leaf_counts.tolist(), "companions": [0]}
    [found] = call([("gpu/playback/hit-buffers", "bvhWords", [described, tree])])
    expected = bvh_words(scene, bvh, np.arange(scene.triangle_offsets[-1]))
    np.testing.assert_array_equal(np.array(found, np.uint32), expected.ravel())


def test_motion_is_drawn_as_finely_as_there_is_time(call):
    """How a frame is drawn (screen pixels along an edge, more samples or not), its time, and how the next one is."""
    frames = [
        (4, None, 11, 2, None),
        (2, None, 30, 2, None),
        (2, None, 11, 1, None),
        (1, None, 11, 1, True),  # there is time
        (1, True, 30, 1, True),
        (1, True, 51, 1, False),  # there was not
        (1, False, 11, 1, False),  # and it is not tried again
        (1, False, 51, 2, False),
        (4, None, 51, 4, None),
    ]
    pace = [({"coarseness": edge, **({} if more is None else {"more": more})}, ms) for edge, more, ms, _, _ in frames]
    found = call([("players/pace", "nextPace", [*each]) for each in pace])
    assert [(each["coarseness"], each.get("more")) for each in found] == [(edge, more) for *_, edge, more in frames]


def test_sub_samples_come_in_bursts_that_are_not_slow(call):
    times = [
        (1, 20, 2),
        (2, 24, 4),
        (4, 30, 4),
        (4, 51, 2),
        (1, 51, 1),
        (64, 1, 64),
    ]  # how many, their ms, how many next
    found = call([("players/pace", "nextBurst", [burst, ms]) for burst, ms, _ in times])
    assert found == [following for *_, following in times]


def test_pictures_come_to_the_screen_where_they_look_better(call):
    asked = [(3, 0, False), (4, 0, True), (5, 4, True), (9, 8, False), (10, 8, True), (255, 240, False)]
    found = call([("players/pace", "worthShowing", [samples, shown]) for samples, shown, _ in asked])
    assert found == [worth for *_, worth in asked]


def geometry_to_json(geometry):
    return described(geometry, BufferWriter("maps.bin"))


def test_geometries_pack_alike(call):
    packed = call([("maths/geometry", "pack", [geometry_to_json(geometry)]) for geometry in GEOMETRIES])
    np.testing.assert_array_equal(np.array(packed, np.float32), [pack(geometry) for geometry in GEOMETRIES])


@pytest.mark.parametrize("largest", [0.0, 2.0**-20, 0.37, 1.0, 13.5])
def test_reliefs_pack_alike(call, largest):
    inverse = np.zeros((6, 2, 2), np.float16)
    inverse[3, 1, 0] = largest
    relief = Relief(inverse, BOX.lower, BOX.upper, ORIGIN)
    bits = inverse.view(np.uint16).ravel().tolist()
    (packed,) = call([("maths/geometry", "pack", [{**geometry_to_json(relief), "size": 2, "inverseDistance": bits}])])
    np.testing.assert_array_equal(np.array(packed, np.float32), pack(relief))


def test_lights_pack_alike(call):
    """Number, lights and what is seen of them; the cone's cosines are those of another library."""
    described = [
        {
            "intensity": light.intensity,
            "direction": light.direction,
            "range": 4.0,
            **({} if light.position is None else {"position": light.position}),
            **({} if light.cone is None else {"cone": light.cone}),
        }
        for light in LIGHTS
    ]
    lights = tuple(replace(light, range=4.0) for light in LIGHTS)  # JSON knows no infinity
    seen = np.arange(2 * 5, dtype=np.uint8).reshape(-1, 2)
    pem = {"lights": described, "visibility": seen.ravel().tolist()}
    [words] = call([("gpu/playback/punctual-lights", "lightWords", [pem])])
    colours = replace(small_pem().irradiance, visibility=seen)
    ours = light_words(replace(small_pem().scene, lights=lights), colours).ravel()
    theirs = np.array(words, np.uint32)
    floats = slice(4, 4 + 12 * len(lights))
    np.testing.assert_array_equal(np.delete(theirs, range(4, 28)), np.delete(ours, range(4, 28)))
    np.testing.assert_allclose(theirs[floats].view(np.float32), ours[floats].view(np.float32), rtol=1e-6)


def volume(geometry):
    """Volume inside a geometry as JSON."""
    if geometry["kind"] == "box":
        return np.prod(np.subtract(geometry["upper"], geometry["lower"]))
    return np.prod(geometry["radii"]) * np.pi * (2 / 3 if geometry["kind"] == "hemisphere" else 4 / 3)


def test_geometries_turn_into_others_of_their_volume_and_origin(call):
    kinds = ("sphere", "ellipsoid", "box", "hemisphere")
    turned = call([("maths/geometry", "asKind", [geometry_to_json(BOX), kind, 1, SURROUNDINGS]) for kind in kinds])
    for geometry in turned:
        assert volume(geometry) == pytest.approx(2.0 * 4.0 * 6.0)
        assert tuple(geometry["origin"]) == ORIGIN
    assert turned[2] == json.loads(json.dumps(geometry_to_json(BOX)))  # the same kind: nothing changes
    assert turned[3]["floor"] == BOX.lower[1]  # a hemisphere stands where the box does
    back = call(
        [("maths/geometry", "asKind", [geometry, "box", 1, SURROUNDINGS]) for geometry in (turned[1], turned[3])]
    )
    for geometry in back:
        np.testing.assert_allclose([geometry["lower"], geometry["upper"]], [BOX.lower, BOX.upper], atol=1e-12)
    (doubled,) = call([("maths/geometry", "asKind", [geometry_to_json(BOX), "box", 2, SURROUNDINGS])])
    assert (doubled["lower"], doubled["upper"]) == ([-1.5, -3.0, -6.25], [2.5, 5.0, 5.75])
    half_open = Box((BOX.lower[0], -FAR_AWAY, BOX.lower[2]), (FAR_AWAY, *BOX.upper[1:]), ORIGIN)
    (closed,) = call([("maths/geometry", "asKind", [geometry_to_json(half_open), "box", 2, SURROUNDINGS])])
    sides = np.array([BOX.lower, BOX.upper])
    sides[0, 1], sides[1, 0] = SURROUNDINGS["lower"][1], SURROUNDINGS["upper"][0]  # where its own are not there
    np.testing.assert_allclose([closed["lower"], closed["upper"]], sides + 0.5 * np.diff(sides, axis=0) * [[-1], [1]])
    (enclosing,) = call([("maths/geometry", "asKind", [{"kind": "infinite_sphere"}, "box", 1, SURROUNDINGS])])
    assert enclosing == {"kind": "box", **SURROUNDINGS, "origin": [0, 0, 0]}


def written(axis):
    """As in a file."""
    return {"name": axis.name, "values": axis.values} | ({} if axis.period is None else {"period": axis.period})


def test_samples_blend_alike(call):
    """In one and two dimensions, at random points: inside, outside, on samples, round the circle, open and closed."""
    orbit = Orbit((0.0, 0.0, 0.0), 0.0, 0.0, 1.0)
    turn = Axis("azimuth_deg", (60.0, 150.0, 200.0, 330.0), 360.0)
    azimuth, elevation = Axis("azimuth_deg", (60.0, 62.0, 65.0)), Axis("elevation_deg", (-10.0, 0.0, 30.0, 40.0))
    random = np.random.default_rng(7)
    points = [{"azimuth_deg": 62.0, "elevation_deg": 0.0}, {"azimuth_deg": -298.5, "elevation_deg": 35.0}] + [
        {"azimuth_deg": a, "elevation_deg": e}
        for a, e in zip(random.uniform(-720, 720, 40), random.uniform(-60, 90, 40), strict=True)
    ]
    for axes in ((azimuth,), (azimuth, elevation), (turn,), (elevation, turn)):
        described = [written(axis) for axis in axes]
        weights = call([("maths/parameter-space", "blendWeights", [described, point]) for point in points])
        order = call([("maths/parameter-space", "samplesByDistance", [described, point]) for point in points])
        for point, found, near in zip(points, weights, order, strict=True):
            expected = ParameterSpace(axes, orbit).blend_weights(point)
            assert [sample for sample, _ in found] == list(expected)
            np.testing.assert_allclose([weight for _, weight in found], list(expected.values()), atol=1e-12)
            assert sorted(near) == list(range(len(near)))
            assert near[0] in expected  # the closest sample is one of those blended


def test_spaces_without_samples_blend_none(call):
    axes = [{"name": "azimuth_deg", "values": []}]
    results = call(
        [
            ("maths/parameter-space", "blendWeights", [axes, {"azimuth_deg": 10.0}]),
            ("maths/parameter-space", "samplesByDistance", [axes, {"azimuth_deg": 10.0}]),
        ]
    )
    assert results == [[], []]


def test_displacement_and_the_bases_share_are_alike(call):
    """On the range, beside it, above it, farther away; on one, two and three axes."""
    orbit = Orbit((0.1, 0.2, -0.3), 60.0, 22.0, 1.25)
    described_orbit = {"target": orbit.target, "azimuthDeg": 60.0, "elevationDeg": 22.0, "distance": 1.25, "fovDeg": 36}
    azimuth, elevation = Axis("azimuth_deg", (60.0, 62.0, 65.0)), Axis("elevation_deg", (10.0, 30.0))
    random = np.random.default_rng(11)
    points = [{"azimuth_deg": 62.5, "elevation_deg": 22.0, "distance": 1.25}] + [
        {"azimuth_deg": a, "elevation_deg": e, "distance": d}
        for a, e, d in zip(
            random.uniform(-400, 400, 20), random.uniform(-60, 80, 20), random.uniform(0.5, 3, 20), strict=True
        )
    ]
    turn = Axis("azimuth_deg", (60.0, 180.0, 300.0), 360.0)
    for axes in (
        (azimuth,), (azimuth, elevation), (azimuth, elevation, Axis("distance", (1.0, 1.5))), (turn, elevation),
    ):  # fmt: skip
        space = ParameterSpace(axes, orbit)
        described = [written(axis) for axis in axes]
        found = call([("maths/parameter-space", "displacementDeg", [described, described_orbit, it]) for it in points])
        np.testing.assert_allclose(found, [space.displacement_deg(point) for point in points], atol=1e-5)
        assert found[0] < 1e-5 and max(found) > 30.0
        pem = replace(small_pem(), space=space, fade_deg=150.0)
        written_pem = {"axes": described, "orbit": described_orbit, "maps": [[]], "base": ["map"], "fadeDeg": 150.0}
        shares = call([("scene/pem", "baseShare", [written_pem, point]) for point in points])
        np.testing.assert_allclose(shares, [pem.base_share(point) for point in points], atol=1e-6)
        assert len(set(shares)) > 5  # some between 0 and 1
    cases = {"without samples": ({"maps": []}, 1), "without base": ({"base": []}, 0), "at once": ({"fadeDeg": 0}, 1)}
    for changed, share in cases.values():
        assert call([("scene/pem", "baseShare", [{**written_pem, **changed}, points[1]])]) == [share]


def test_half_floats_round_alike(call):
    random = np.random.default_rng(3)
    values = np.concatenate([[0, 1, 65504, 1e9, 2**-24, 2**-25, 1.5 * 2**-24, 6.1e-5, 1 + 2**-11, 1 + 3 * 2**-11, 0.1],
                             2.0 ** random.uniform(-26, 16, 1000)]).astype(np.float32)  # fmt: skip
    values = values[: len(values) // 3 * 3]
    (bits,) = call([("maths/half", "halfTexels", [values.tolist()])])
    rgba = np.array(bits, np.uint16).reshape(-1, 4).view(np.float16)
    np.testing.assert_array_equal(rgba[:, :3].ravel(), np.clip(values, 0, 65504).astype(np.float16))
    np.testing.assert_array_equal(rgba[:, 3], 1)


@pytest.mark.parametrize("codec", ["av1", "none"])
def test_gltf_validator_finds_no_error(node, tmp_path, codec):
    save_pem(tmp_path / "pem", small_pem(), codec=codec)
    issues = node("validate.mjs", tmp_path / "pem/scene.gltf")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    # What it does say: it does not know our extension; tangents stand where no texture needs them.
    said = {message["code"] for message in issues["messages"]} - {"UNUSED_OBJECT"}
    assert said == {"UNSUPPORTED_EXTENSION", *(["UNUSED_MESH_TANGENT"] if codec == "none" else [])}


def test_the_lock_names_no_registry():
    lock = json.loads((WEB / "package-lock.json").read_text())
    assert all("resolved" not in package for package in lock["packages"].values())
    assert all("integrity" in package for name, package in lock["packages"].items() if name)


def test_the_viewer_reads_the_numbers_that_python_reads(node_reads, tmp_path):
    """Coded and plain: meshes, hull flags and the tree bit by bit, irradiance to a rounding of its exponential."""
    for codec in ("av1", "none"):
        pem = small_pem(shells=2, with_environment=False)
        gradient = np.random.default_rng(6).normal(size=pem.irradiance.radiosity.shape).astype(np.float32)
        seen = np.arange(2 * len(gradient), dtype=np.uint8).reshape(-1, 2)
        irradiance = replace(pem.irradiance, gradient=gradient, visibility=seen)
        pem = replace(pem, most_hits=4, surface=random_surface(pem.scene, (1,), side=12), irradiance=irradiance)
        pem = replace(pem, scene=replace(pem.scene, lights=LIGHTS))
        save_pem(tmp_path / codec, pem, codec=codec)
        back, read = open_pem(tmp_path / codec), node_reads(tmp_path / codec)

        def floats(bits):
            return np.array(bits, np.uint32).view(np.float32)

        for ours, theirs in zip(back.scene.parts, read["parts"], strict=True):
            np.testing.assert_array_equal(theirs["indices"], ours.mesh.triangles.ravel())
            for name in ("positions", "normals", "uv", "tangents"):
                array = getattr(ours.mesh, name)
                assert (array is None) == (name not in theirs)
                if array is not None:
                    np.testing.assert_array_equal(floats(theirs[name]), array.ravel())
        np.testing.assert_array_equal(read["onHull"], back.on_hull)
        np.testing.assert_array_equal(read["colourGrids"]["resolution"], back.irradiance.resolution)
        np.testing.assert_array_equal(read["colourGrids"]["offset"], back.irradiance.offset)
        np.testing.assert_allclose(floats(read["radiosity"]), back.irradiance.radiosity.ravel(), rtol=1e-6)
        bends = np.max(np.abs(back.irradiance.gradient))
        assert bends > 1.0
        np.testing.assert_allclose(
            floats(read["gradient"]), back.irradiance.gradient.ravel(), rtol=1e-5, atol=1e-6 * bends
        )
        np.testing.assert_array_equal(read["visibility"], back.irradiance.visibility.ravel())
        for ours, theirs in zip(back.scene.lights, read["lights"], strict=True):
            assert theirs["intensity"] == list(ours.intensity) and theirs["direction"] == list(ours.direction)
        surface = read["surface"]
        for name in ("resolution", "offset", "site"):
            np.testing.assert_array_equal(surface[name], getattr(back.surface, name))
        half = np.array(surface["light"], np.uint16).view(np.float16).reshape(back.surface.light.shape)
        np.testing.assert_allclose(half, back.surface.light, rtol=1e-3)  # another exponential, rounded by way of floats
        tree = read["traced"]["bvh"]
        np.testing.assert_array_equal(tree["order"], back.bvh.order)
        np.testing.assert_array_equal(tree["leafCounts"], back.bvh.leaf_counts)
        np.testing.assert_array_equal(tree["directions"], back.bvh.directions.ravel())
        for ours, theirs in zip(back.layers, read["layers"], strict=True):
            if isinstance(ours.geometry, Relief):
                half = ours.geometry.inverse_distance.view(np.uint16)
                np.testing.assert_array_equal(theirs["geometry"]["inverseDistance"], half.ravel())


@pytest.mark.parametrize("name", ["scene.bin", "surface.bin", "bvh.bin"])
def test_the_viewer_says_which_file_is_cut(node_reads, tmp_path, name):
    save_pem(tmp_path / "pem", replace(small_pem(with_environment=False), most_hits=4))
    file = tmp_path / "pem" / name
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert node_reads(tmp_path / "pem").startswith(f"{name} is truncated")


def test_the_viewer_unpacks_no_bomb(node_reads, tmp_path):
    """A stream of more, of fewer and of far more numbers than its description says."""
    save_pem(tmp_path / "pem", small_pem(with_environment=False))
    path = tmp_path / "pem" / "scene.gltf"
    whole = path.read_text()
    for count in (3, 10**4, 10**11):
        document = json.loads(whole)
        document["extensions"]["REFLET_parameterized_environment_map"]["onHull"]["shape"] = [count]
        path.write_text(json.dumps(document))
        assert node_reads(tmp_path / "pem").startswith("surface.bin is truncated or damaged")
