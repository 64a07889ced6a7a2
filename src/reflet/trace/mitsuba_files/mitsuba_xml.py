"""Reading Mitsuba's XML scenes: shapes, materials, lights and the camera."""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mitsuba as mi
import numpy as np
from jaxtyping import Float

from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT
from reflet.errors import RefletError, RefletWarning
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.upright import upright, upright_lights
from reflet.scene.views.parameter_space import Orbit
from reflet.trace.mitsuba_files.mitsuba_doubts import Doubts
from reflet.trace.mitsuba_files.mitsuba_lights import environment_of, punctual_lights
from reflet.trace.mitsuba_files.mitsuba_materials import material_of
from reflet.trace.mitsuba_files.mitsuba_nodes import Node, read_nodes
from reflet.trace.mitsuba_files.mitsuba_shapes import mesh_of, moved, with_tangents
from reflet.trace.variant import use_variant

_GROUPS = ("shapegroup", "merge")


def read_mitsuba_xml(
    path: str | Path,
    *,
    environment: EnvironmentLight | None = None,
    reflect: Sequence[str] = (),
    up: str | None = None,
) -> Scene:
    """The scene in a Mitsuba 3 XML file; ``environment`` replaces its own, ``reflect`` is as in `assemble`.

    Shapes become triangles, instances copies of their group; twosided BSDFs are double-sided materials. ``up`` is the
    axis that points up, "y" or "z"; by default z where the first camera's ``lookat`` says so, with a RefletWarning,
    else y. What looks other than in Mitsuba is said in RefletWarnings, one for each kind. Raises RefletError for files
    that Mitsuba cannot read and for shapes and BSDFs that have no counterpart.
    """
    use_variant()
    path = Path(path)
    nodes = read_nodes(path)
    if up is None and _camera_is_z_up(path):
        up = "z"
        warnings.warn(
            f"The camera of {path} has +z up: the scene is turned so that +z is up; --up y leaves it as it is.",
            RefletWarning,
            stacklevel=2,
        )
    doubts = Doubts()
    parts = _parts([node for node in nodes if node.kind == "shape"], doubts)
    light = environment
    emitters = [node for node in nodes if node.kind == "emitter"]
    if light is None:
        light = environment_of(path, emitters, SOURCE_FROM_UPRIGHT[up or "y"])
    lights = upright_lights(punctual_lights(emitters, doubts), up or "y")
    doubts.say()
    return assemble(upright(parts, up or "y"), environment=light, reflect=reflect, lights=lights)


def read_mitsuba_orbit(path: str | Path, scene: Scene, up: str | None = None) -> Orbit:
    """An orbit that begins at the camera of a Mitsuba XML file, around the point of its line of sight that is closest
    to the middle of the reflective parts; ``up`` is as in `read_mitsuba_xml`. Raises RefletError where the file has no
    perspective camera."""
    use_variant()
    path = Path(path)
    cameras = [node for node in read_nodes(path) if node.kind == "sensor"]
    if not cameras or cameras[0].plugin not in ("perspective", "thinlens"):
        raise RefletError(f"{path} has no perspective camera; give azimuth, elevation and distance.")
    sensor = cameras[0].built("the camera")
    parameters = mi.traverse(sensor)
    to_world = np.array(parameters["to_world"].matrix, np.float64).reshape(4, 4)
    upright_from_source = SOURCE_FROM_UPRIGHT[up or ("z" if _camera_is_z_up(path) else "y")].T
    eye = upright_from_source @ to_world[:3, 3]
    forward = upright_from_source @ (to_world[:3, 2] / np.linalg.norm(to_world[:3, 2]))
    corners = np.concatenate([part.mesh.positions for part in scene.parts if part.reflective])
    middle = (corners.min(0) + corners.max(0)) / 2.0
    target = eye + max(float((middle - eye) @ forward), 1e-3) * forward
    width, height = (int(size) for size in sensor.film().size())
    half = np.tan(np.radians(float(np.ravel(parameters["x_fov"])[0])) / 2.0) * height / width
    x, y, z = eye - target
    distance = float(np.linalg.norm(eye - target))
    return Orbit(
        target=(float(target[0]), float(target[1]), float(target[2])),
        azimuth_deg=float(np.degrees(np.arctan2(-z, x))),
        elevation_deg=float(np.degrees(np.arcsin(y / distance))),
        distance=distance,
        fov_deg=float(np.degrees(2.0 * np.arctan(half))),
        image_size=height,
    )


def _parts(shapes: Sequence[Node], doubts: Doubts) -> list[Part]:
    """The shapes that can be seen; groups stand for themselves only where they are instanced."""
    parts: list[Part] = []
    for number, shape in enumerate(shapes):
        name = _name(shape, number)
        if shape.plugin == "merge":
            parts += _parts(shape.of_kind("shape"), doubts)
        elif shape.plugin == "instance":
            parts += _instances(shape, name, doubts)
        elif shape.plugin not in _GROUPS:
            parts += _part(shape, name, doubts)
    return parts


def _instances(shape: Node, name: str, doubts: Doubts) -> Iterator[Part]:
    group = next((each for each in shape.of_kind("shape") if each.plugin in _GROUPS), None)
    if group is None:
        raise RefletError(f"The instance {name} is of no shapegroup; refer to one in it.")
    to_world = shape.values.get("to_world")
    world_from_group = np.eye(4) if to_world is None else np.array(to_world.matrix, np.float64).reshape(4, 4)
    for part in _parts(group.of_kind("shape"), doubts):
        yield replace(part, mesh=moved(part.mesh, world_from_group))


def _part(shape: Node, name: str, doubts: Doubts) -> list[Part]:
    mesh = mesh_of(shape, name)
    found = material_of(shape, name, mesh.uv is not None, doubts)
    if found is None:
        doubts.add("Shapes that let all light through are left out", name)
        return []
    if found.material.normal_texture is not None:
        mesh = with_tangents(mesh)
    return [Part(name, _placed(mesh, found.texture_from_mesh), found.material)]


def _placed(mesh: Mesh, texture_from_mesh: Float[np.ndarray, "3 3"] | None) -> Mesh:
    if mesh.uv is None or texture_from_mesh is None:
        return mesh
    uv = mesh.uv.astype(np.float64) @ texture_from_mesh[:2, :2].T + texture_from_mesh[:2, 2]
    return replace(mesh, uv=uv.astype(np.float32))


def _name(shape: Node, number: int) -> str:
    return shape.id or Path(str(shape.values.get("filename", f"{shape.plugin}{number}"))).stem


def _camera_is_z_up(path: Path) -> bool:
    """Whether the first camera stands upright along +z, by what its ``lookat`` was given: its matrix does not tell."""
    try:
        transform = ElementTree.parse(path).getroot().find(".//sensor/transform")
        if transform is None or [element.tag for element in transform] != ["lookat"]:
            return False
        x, y, z = (float(word) for word in transform[0].get("up", "").replace(",", " ").split())
    except (ElementTree.ParseError, ValueError):
        return False
    return z > 0.0 and x == y == 0.0
