"""Lights of glTF files (KHR_lights_punctual): which there are, where they stand, and what is odd in them."""

import math
import re

import numpy as np
import pytest
from gltf_files import TRIANGLE, Gltf

from reflet.errors import RefletError, RefletWarning
from reflet.pipelines.load import load_scene
from reflet.scene.punctual_light import LEAST_FADE, PunctualLight, packed
from reflet.scene.readers.gltf.read import read_gltf, read_gltf_scene

LIGHTS = "KHR_lights_punctual"
INFINITE = float("inf")


def lit(*lights: dict, **node: object) -> Gltf:
    """A triangle, and a node with each light that turns and moves like ``node``."""
    file = Gltf().attribute("POSITION", TRIANGLE)
    file.json["extensions"] = {LIGHTS: {"lights": list(lights)}}
    file.json["extensionsUsed"] = [LIGHTS]
    for number in range(len(lights)):
        file.json["nodes"].append({"name": f"lamp {number}", "extensions": {LIGHTS: {"light": number}}, **node})
        file.json["scenes"][0]["nodes"].append(number + 1)
    return file


def lights_of(folder, file: Gltf) -> list[PunctualLight]:
    (folder / "a.gltf").write_text(file.finished())
    return read_gltf_scene(folder / "a.gltf").lights


def test_lights_have_the_defaults_of_the_specification(tmp_path):
    point, spot, sun = lights_of(tmp_path, lit({"type": "point"}, {"type": "spot"}, {"type": "directional"}))
    assert point == PunctualLight("lamp 0", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    assert spot == PunctualLight("lamp 1", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), cone=(0.0, math.pi / 4.0))
    assert sun == PunctualLight("lamp 2", (1.0, 1.0, 1.0))
    assert point.range == sun.range == INFINITE and spot.direction == sun.direction == (0.0, 0.0, -1.0)


def test_lights_stand_as_their_nodes_do(tmp_path):
    """Colour times intensity; sizes of nodes turn and move, but neither brighten nor widen."""
    cone = {"innerConeAngle": 0.2, "outerConeAngle": 0.4}
    file = lit({"type": "spot", "color": [0.5, 1.0, 0.25], "intensity": 8.0, "range": 3.0, "spot": cone})
    half = math.sqrt(0.5)
    file.json["nodes"][1] |= {"translation": [1.0, 0.0, 0.0], "rotation": [half, 0.0, 0.0, half]}  # -z to +y
    file.json["nodes"].append({"children": [1], "scale": [2.0, 2.0, 2.0], "translation": [0.0, 5.0, 0.0]})
    file.json["scenes"][0]["nodes"] = [0, 2]
    (light,) = lights_of(tmp_path, file)
    assert light.intensity == (4.0, 8.0, 2.0) and light.range == 3.0 and light.cone == (0.2, 0.4)
    assert light.position == (2.0, 5.0, 0.0)
    np.testing.assert_allclose(light.direction, (0.0, 1.0, 0.0), atol=1e-15)  # float64


def test_hidden_and_dark_lights_are_none(tmp_path):
    hidden = lit({"type": "point"}, extensions={LIGHTS: {"light": 0}, "KHR_node_visibility": {"visible": False}})
    assert lights_of(tmp_path, hidden) == []
    assert lights_of(tmp_path, lit({"type": "point", "intensity": 0})) == []


@pytest.mark.parametrize(
    ("light", "says", "left"),
    [
        ({"type": "area"}, "neither point, spot nor directional are left out (1 of 2 nodes: lamp 0)", 0),
        ({"type": "point", "intensity": -1}, "negative colour or intensity are left out", 0),
        ({"type": "point", "range": 0}, "range of lights is not above 0, and taken for infinite", 1),
        ({"type": "spot", "spot": {"outerConeAngle": 3.0}}, "cones of lights are not", 1),
        ({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.4}}, "cones of lights are not", 1),
    ],
)
def test_odd_lights_are_said(tmp_path, light, says, left):
    with pytest.warns(RefletWarning, match=re.escape(says)):
        lights = lights_of(tmp_path, lit(light))
    assert len(lights) == left
    assert all(each.range == INFINITE and (each.cone or (0, 1))[1] <= math.pi / 2 for each in lights)


def test_a_light_that_points_nowhere_is_left_out(tmp_path):
    with pytest.warns(RefletWarning, match="which point nowhere, are left out"):
        assert lights_of(tmp_path, lit({"type": "directional"}, scale=[0.0, 0.0, 0.0])) == []


@pytest.mark.parametrize("which", [1, -1, "lamp", None])
def test_lights_that_are_not_there_are_damage(tmp_path, which):
    with pytest.raises(RefletError, match="damaged"):
        lights_of(tmp_path, lit({"type": "point"}, extensions={LIGHTS: {"light": which}}))


def test_readers_of_meshes_alone_say_that_lights_are_left_out(tmp_path):
    (tmp_path / "a.gltf").write_text(lit({"type": "point"}).finished())
    with pytest.warns(RefletWarning, match=r"its 1 lights are left out \(lamp 0\)"):
        assert len(read_gltf(tmp_path / "a.gltf")) == 1


def test_lights_are_light_enough_and_turn_with_their_scene(tmp_path):
    """No environment, nothing emits: a light does. Of a scene with +z up it is turned as its meshes are."""
    (tmp_path / "a.gltf").write_text(lit({"type": "spot"}, translation=[1.0, 2.0, 3.0]).finished())
    scene = load_scene(tmp_path / "a.gltf", up="z")
    (light,) = scene.lights
    assert light.position == (1.0, 3.0, -2.0) and light.direction == (0.0, -1.0, 0.0)
    dark = Gltf().attribute("POSITION", TRIANGLE)
    (tmp_path / "b.gltf").write_text(dark.finished())
    with pytest.raises(RefletError, match="Nothing in the scene gives light"):
        load_scene(tmp_path / "b.gltf")


def test_cones_fade_as_the_specification_says():
    """The square of the clamped share of the cosines' difference; an inner angle equal to the outer one is an edge."""
    inner, outer = 0.3, 0.7
    for cone in ((inner, outer), (outer, outer)):
        row = packed([PunctualLight("", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (0.0, -1.0, 0.0), cone=cone)])[0, 2]
        for angle in (0.0, 0.29, 0.5, 0.69, 0.71, 2.0):
            towards = np.array([math.sin(angle), math.cos(angle), 0.0])
            fade = np.clip(row[:3] @ towards + row[3], 0.0, 1.0)
            difference = max(math.cos(cone[0]) - math.cos(outer), LEAST_FADE)
            wanted = np.clip((math.cos(angle) - math.cos(outer)) / difference, 0.0, 1.0)
            assert fade == pytest.approx(wanted, abs=2e-4)  # float32 over an edge of a thousandth
