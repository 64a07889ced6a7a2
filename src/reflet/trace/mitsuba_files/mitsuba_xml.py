"""Reading Mitsuba's XML scenes: shapes, materials, area lights, the environment and the camera."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from reflet.errors import RefletError
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.scene import Part, Scene
from reflet.scene.views.parameter_space import Orbit
from reflet.trace.mitsuba_files.mitsuba_materials import material_of
from reflet.trace.mitsuba_files.mitsuba_nodes import Node, read_nodes
from reflet.trace.mitsuba_files.mitsuba_shapes import mesh_of
from reflet.trace.variant import use_variant


def read_mitsuba_xml(
    path: str | Path, *, environment: EnvironmentLight | None = None, reflect: Sequence[str] = (), up: str | None = None
) -> Scene:
    """The scene in a Mitsuba 3 XML file; ``environment`` replaces its own, ``reflect`` is as in `assemble`.

    Shapes become triangles; twosided BSDFs are double-sided materials. Conductors are mirrors by Schlick's
    approximation from their reflectance at normal incidence, with a RefletWarning. Raises RefletError for files that
    Mitsuba cannot read and for shapes, BSDFs and lights that have no counterpart.
    """
    use_variant()
    nodes = read_nodes(path)
    parts = []
    for number, node in enumerate(node for node in nodes if node.kind == "shape"):
        name = node.id or Path(str(node.values.get("filename", f"{node.plugin}{number}"))).stem
        mesh = mesh_of(node, name)
        parts.append(Part(name, mesh, material_of(node, name, mesh.uv is not None)))
    light = environment
    for node in nodes:
        if node.kind == "emitter" and environment is None:
            light = _environment(node)
    return assemble(parts, environment=light, reflect=reflect)


def read_mitsuba_orbit(path: str | Path, scene: Scene) -> Orbit:
    """An orbit that begins at the camera of a Mitsuba XML file, around the point of its line of sight that is closest
    to the middle of the reflective parts. Raises RefletError where the file has no perspective camera."""
    use_variant()
    cameras = [node for node in read_nodes(path) if node.kind == "sensor"]
    if not cameras or cameras[0].plugin not in ("perspective", "thinlens"):
        raise RefletError(f"{path} has no perspective camera; give azimuth, elevation and distance.")
    sensor = mi.load_dict(cameras[0].described())
    parameters = mi.traverse(sensor)
    to_world = np.array(parameters["to_world"].matrix, np.float64).reshape(4, 4)
    eye, forward = to_world[:3, 3], to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
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


def _environment(node: Node) -> EnvironmentLight:
    """A light at infinity, looked at in every direction of a lat-long picture in the project's convention."""
    if node.plugin not in ("envmap", "constant"):
        raise RefletError(f"Lights of type {node.plugin} cannot be seen in mirrors; use area, envmap or constant ones.")
    emitter = mi.load_dict(node.described())
    height = 2
    if node.plugin == "envmap":
        height = int(mi.traverse(emitter)["data"].shape[0])
    width = 2 * height
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    phi, theta = ((u - 0.5) * 2.0 * np.pi).ravel(), (v * np.pi).ravel()
    direction = np.stack([np.cos(phi) * np.sin(theta), np.cos(theta), np.sin(phi) * np.sin(theta)]).astype(np.float32)
    seen: Any = mi.SurfaceInteraction3f()
    seen.wi = -mi.Vector3f(direction)
    radiance = np.zeros((height * width, 3), np.float32)
    for number, channel in enumerate(emitter.eval(seen)):
        radiance[:, number] = channel.numpy()
    return EnvironmentLight(radiance.reshape(height, width, 3))
