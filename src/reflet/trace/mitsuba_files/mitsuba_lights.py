"""Mitsuba's lights at infinity as an environment, and its points, spots and parallel rays."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.rotations import Rotation
from reflet.errors import RefletError
from reflet.scene.material import EnvironmentLight, Vec3
from reflet.scene.punctual_light import PunctualLight
from reflet.trace.mitsuba_files.mitsuba_doubts import Doubts
from reflet.trace.mitsuba_files.mitsuba_nodes import Node
from reflet.trace.mitsuba_files.mitsuba_textures import Values

_LIGHTS = {"point": "intensity", "spot": "intensity", "directional": "irradiance"}  # and what they say how bright by
_CUTOFF = 20.0  # degrees, Mitsuba's default
ENVIRONMENTS = ("envmap", "constant", "sunsky", "timed_sunsky")
_SKY_ROWS = 512  # of skies that are computed
_SUN_DETAIL = 16  # places across a texel, in the rows of the sun: its disc is one and a half texels wide
_SUN = 50.0  # times the mean radiance, at the least
_BLOCK = 1 << 20  # directions at a time


def environment_of(path: Path, lights: Sequence[Node], source_from_upright: Rotation) -> EnvironmentLight | None:
    """The environment among a scene's lights, in the project's convention, of a scene that is turned upright.

    Raises RefletError for more than one environment, which Mitsuba refuses too.
    """
    around = [light for light in lights if light.plugin in ENVIRONMENTS]
    if len(around) > 1:
        named = ", ".join(light.plugin for light in around)
        raise RefletError(
            f"{path} has {len(around)} environments ({named}), and Mitsuba takes one; leave one in the file, or say "
            "which light there is by --environment FILE."
        )
    return _environment(around[0], source_from_upright) if around else None


def punctual_lights(lights: Sequence[Node], doubts: Doubts) -> list[PunctualLight]:
    """The lights without extent among a scene's lights, as they stand in the file; what else there is, but for
    environments, goes into ``doubts``."""
    found = []
    for number, node in enumerate(light for light in lights if light.plugin not in ENVIRONMENTS):
        name = node.id or f"{node.plugin} {number + 1}"
        if node.plugin not in _LIGHTS:
            doubts.add("Lights of kinds that have no counterpart are left out", name)
            continue
        values = Values(name, False, doubts)
        intensity = values.color(node, _LIGHTS[node.plugin], 1.0, unbounded=True).factor
        parameters = mi.traverse(node.built(f"the light {name}"))
        position, direction, cone = None, PunctualLight.direction, None
        if node.plugin == "point":
            position = _vector(parameters["position"])
        else:
            world_from_light = np.array(parameters["to_world"].matrix, np.float64).reshape(4, 4)
            direction = _vector(world_from_light[:3, 2] / np.linalg.norm(world_from_light[:3, 2]))
            position = _vector(world_from_light[:3, 3]) if node.plugin == "spot" else None
        if node.plugin == "spot":
            cutoff = values.number(node, "cutoff_angle", _CUTOFF)
            inner = values.number(node, "beam_width", 0.75 * cutoff)
            cone = float(np.radians(min(inner, cutoff))), float(np.radians(cutoff))
            doubts.add("Spots fade towards their edges as glTF's do, not Mitsuba's", name)
            if node.children:
                doubts.add("Pictures that lights throw are left out", name)
        if max(intensity) > 0.0:
            found.append(PunctualLight(name, intensity, position, direction, cone=cone))
    return found


def _vector(values: Any) -> Vec3:
    x, y, z = (float(value) for value in np.ravel(values))
    return x, y, z


def _environment(node: Node, source_from_upright: Rotation) -> EnvironmentLight:
    """Looked at in every direction of a lat-long picture, in the rows of a computed sky's sun closely."""
    emitter = node.built(f"the light {node.id or node.plugin}")
    is_sky = node.plugin not in ("envmap", "constant")
    rows = _SKY_ROWS if is_sky else 2
    if node.plugin == "envmap":
        rows = int(mi.traverse(emitter)["data"].shape[0])
    step = max(_BLOCK // (2 * rows), 1)
    radiance = np.concatenate(
        [_seen(emitter, top, min(top + step, rows), rows, source_from_upright) for top in range(0, rows, step)]
    )
    if is_sky:
        brightness = radiance.max(-1)
        of_sun = np.nonzero(brightness.max(1) > _SUN * brightness.mean())[0]
        for row in np.unique(np.clip(of_sun[:, None] + [-1, 0, 1], 0, rows - 1)):
            top = int(row) * _SUN_DETAIL
            fine = _seen(emitter, top, top + _SUN_DETAIL, rows * _SUN_DETAIL, source_from_upright)
            radiance[row] = fine.reshape(_SUN_DETAIL, 2 * rows, _SUN_DETAIL, 3).mean((0, 2))
    return EnvironmentLight(radiance)


def _seen(
    emitter: "mi.Emitter", top: int, below: int, rows: int, source_from_upright: Rotation
) -> Float32[np.ndarray, "rows_ columns 3"]:
    """Some rows of the picture."""
    columns = 2 * rows
    v, u = np.meshgrid((np.arange(top, below) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij")
    direction = LatLong().direction_from_uv(np.zeros(v.shape, np.int64), np.stack([u, v], -1))[0].reshape(-1, 3)
    seen: Any = dr.zeros(mi.SurfaceInteraction3f, len(direction))
    seen.wi = -mi.Vector3f((direction @ source_from_upright.T).T.astype(np.float32))
    radiance = np.empty((len(direction), 3), np.float32)
    for number, channel in enumerate(emitter.eval(seen)):
        radiance[:, number] = channel.numpy()
    return radiance.reshape(below - top, columns, 3)
