"""Scenes whose files have another axis than +y point up."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT
from reflet.scene.material import Vec3
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.scene import Part


def upright(parts: Sequence[Part], up: str) -> list[Part]:
    """The parts turned so that what points along ``up``, "y" or "z", in them points along +y."""
    return list(parts) if up == "y" else [replace(part, mesh=_turned(part.mesh, up)) for part in parts]


def upright_lights(lights: Sequence[PunctualLight], up: str) -> list[PunctualLight]:
    """The lights of such a scene, turned likewise."""

    def turned(vector: Vec3) -> Vec3:
        x, y, z = (np.asarray(vector) @ SOURCE_FROM_UPRIGHT[up]).tolist()
        return x, y, z

    return [
        replace(light, position=light.position and turned(light.position), direction=turned(light.direction))
        for light in lights
    ]


def _turned(mesh: Mesh, up: str) -> Mesh:
    source_from_upright = SOURCE_FROM_UPRIGHT[up].astype(np.float32)  # of 0, 1 and -1: nothing is rounded
    tangents = None
    if mesh.tangents is not None:
        tangents = np.concatenate([mesh.tangents[:, :3] @ source_from_upright, mesh.tangents[:, 3:]], -1)
    return replace(
        mesh,
        positions=mesh.positions @ source_from_upright,
        normals=mesh.normals @ source_from_upright,
        tangents=tangents,
    )
