"""The vertices of a scene as `shaders/frame.wgsl` and `shaders/surface.wgsl` describe them."""

import numpy as np
from jaxtyping import Float32

from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Scene


def vertex_table(scene: Scene) -> tuple[Float32[np.ndarray, "values 4"], list[int]]:
    """Three values of each vertex, through all parts, and behind them the extras of parts that have any: a colour a
    vertex, or three values where there are further texture coordinates. And for each part where the extras of a vertex
    0 would lie, modulo 2³²."""
    values = [_values(part.mesh) for part in scene.parts]
    extras = [_extras(part.mesh) for part in scene.parts]
    first, place = 0, sum(map(len, values))
    places = []
    for part, block in zip(scene.parts, extras, strict=True):
        count = len(part.mesh.positions)
        places.append((place - first * (len(block) // max(count, 1))) % 2**32)
        first, place = first + count, place + len(block)
    return np.concatenate([*values, *extras]), places


def _values(mesh: Mesh) -> Float32[np.ndarray, "values 4"]:
    block = np.zeros((len(mesh.positions), 3, 4), np.float32)
    block[:, 0, :3], block[:, 1, :3] = mesh.positions, mesh.normals
    if mesh.uv is not None:
        block[:, 0, 3], block[:, 1, 3] = mesh.uv.T
    if mesh.tangents is not None:
        block[:, 2] = mesh.tangents
    return block.reshape(-1, 4)


def _extras(mesh: Mesh) -> Float32[np.ndarray, "values 4"]:
    if mesh.colors is None and not mesh.more_uv:
        return np.zeros((0, 4), np.float32)
    block = np.ones((len(mesh.positions), 3 if mesh.more_uv else 1, 4), np.float32)
    if mesh.colors is not None:
        block[:, 0] = mesh.colors
    for number, uv in enumerate(mesh.more_uv):
        block[:, 1 + number // 2, 2 * (number % 2) : 2 * (number % 2) + 2] = uv
    return block.reshape(-1, 4)
