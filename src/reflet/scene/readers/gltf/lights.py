"""glTF's point, spot and directional lights (KHR_lights_punctual)."""

import math

import numpy as np

from reflet.scene.material import Vec3
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.nodes import Matrix, Nodes
from reflet.scene.readers.gltf.values import (
    DamagedError,
    JsonObject,
    child,
    children,
    extension,
    number,
    numbers,
    text,
    whole,
)

LIGHTS = "KHR_lights_punctual"
_WIDEST = math.pi / 2.0


def read_lights(document: Document, nodes: Nodes) -> list[PunctualLight]:
    """The lights of all nodes that are shown, but for those that give none. What is odd in them is noted."""
    described = children(extension(document.root, LIGHTS) or {}, "lights")
    lights = []
    for index, node in nodes.shown():
        used = extension(node, LIGHTS)
        if used is None:
            continue
        which = whole(used.get("light"), "light")
        if which >= len(described):
            raise DamagedError(f"node {index} has light {which} of its {len(described)}")
        found = _light(document, index, node, described[which], nodes.world_from_node(index))
        if found is not None and max(found.intensity) > 0.0:
            lights.append(found)
    return lights


def _light(
    document: Document, index: int, node: JsonObject, item: JsonObject, world_from_node: Matrix
) -> PunctualLight | None:
    name = text(node, "name") or text(item, "name") or f"node {index}"

    def note(what: str) -> None:
        document.notes.add(what, "nodes", index, name)

    kind, color, intensity = item.get("type"), numbers(item, "color", (1.0,) * 3), number(item, "intensity", 1.0)
    if kind not in ("point", "spot", "directional"):
        note("lights that are neither point, spot nor directional are left out")
        return None
    if min(*color, intensity) < 0.0:
        note("lights of negative colour or intensity are left out")
        return None
    red, green, blue = (intensity * channel for channel in color)
    length = float(np.linalg.norm(world_from_node[:3, 2]))
    if kind != "point" and not length > 0.0:
        note("lights of nodes without any size, which point nowhere, are left out")
        return None
    direction = _vector(-world_from_node[:3, 2] / length) if kind != "point" else PunctualLight.direction
    if kind == "directional":
        return PunctualLight(name, (red, green, blue), direction=direction)
    reach = number(item, "range", math.inf)
    if reach <= 0.0:
        note("the range of lights is not above 0, and taken for infinite")
        reach = math.inf
    position, cone = _vector(world_from_node[:3, 3]), None
    if kind == "spot":
        spot = child(item, "spot")
        inner, outer = number(spot, "innerConeAngle", 0.0), number(spot, "outerConeAngle", math.pi / 4.0)
        cone = max(min(inner, outer), 0.0), min(max(inner, outer, 0.0), _WIDEST)
        if cone != (inner, outer):
            note("cones of lights are not from 0 to the inner angle to the outer one to 90°, and are taken for such")
    return PunctualLight(name, (red, green, blue), position, direction, reach, cone)


def _vector(values: np.ndarray) -> Vec3:
    return float(values[0]), float(values[1]), float(values[2])
