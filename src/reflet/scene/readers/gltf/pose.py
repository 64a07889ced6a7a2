"""Vertices moved to where they are shown: by morph targets, by joints, and by the transform of a node.

Everything goes through float64 in blocks of rows, so that a large mesh needs no second copy of itself in memory.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Integer

_BLOCK = 16384


@dataclass(frozen=True)
class Vertices:
    """What the vertices of a primitive have that moves with them. Tangents carry their handedness behind.

    ``mirrored`` tells where the transform so far turns the surface inside out: once for all, or for each vertex.
    """

    positions: Float32[np.ndarray, "vertices 3"]
    normals: Float32[np.ndarray, "vertices 3"] | None
    tangents: Float32[np.ndarray, "vertices 4"] | None
    mirrored: bool | Bool[np.ndarray, "vertices"] = False


@dataclass(frozen=True)
class MorphTarget:
    """How far each vertex moves at weight 1; None where an attribute stays."""

    weight: float
    positions: Float32[np.ndarray, "vertices 3"] | None
    normals: Float32[np.ndarray, "vertices 3"] | None
    tangents: Float32[np.ndarray, "vertices 3"] | None


def morphed(vertices: Vertices, targets: list[MorphTarget]) -> Vertices:
    """The vertices with each target's share added [glTF 2.0, 3.7.2.2]; handedness stays."""
    positions, normals, tangents = vertices.positions.copy(), vertices.normals, vertices.tangents
    normals = None if normals is None else normals.copy()
    tangents = None if tangents is None else tangents.copy()
    for target in targets:
        weight = np.float32(target.weight)
        if target.positions is not None:
            positions += weight * target.positions
        if target.normals is not None and normals is not None:
            normals += weight * target.normals
        if target.tangents is not None and tangents is not None:
            tangents[:, :3] += weight * target.tangents
    return Vertices(positions, normals, tangents, vertices.mirrored)


def placed(vertices: Vertices, world_from_node: Float[np.ndarray, "4 4"]) -> Vertices:
    """The vertices in the world, normals and tangents of unit length."""
    linear, shift = world_from_node[:3, :3], world_from_node[:3, 3]
    # cofactors are the inverse transpose times the determinant, and exist for singular matrices too
    cofactors = np.cross(linear[[1, 2, 0]], linear[[2, 0, 1]])
    mirrored = bool(linear[0] @ cofactors[0] < 0.0)
    sign = -1.0 if mirrored else 1.0
    cofactors = sign * cofactors
    positions, normals, tangents = _empty_like(vertices)
    for block in _blocks(len(positions)):
        positions[block] = _mapped(linear, vertices.positions[block]) + shift
        if vertices.normals is not None and normals is not None:
            normals[block] = _unit(_mapped(cofactors, vertices.normals[block]))
        if vertices.tangents is not None and tangents is not None:
            tangents[block, :3] = _unit(_mapped(linear, vertices.tangents[block, :3]))
            # cross(M n, M t) turns over with the determinant's sign while M b does not: the handedness must follow
            tangents[block, 3] = sign * vertices.tangents[block, 3]
    return Vertices(positions, normals, tangents, mirrored)


def skinned(
    vertices: Vertices,
    joints: Integer[np.ndarray, "vertices influences"],
    weights: Float32[np.ndarray, "vertices influences"],
    world_from_bind: Float[np.ndarray, "joints 4 4"],
) -> Vertices:
    """The vertices in the world as the joints pull at them [glTF 2.0, 3.7.3.3], normals and tangents of unit length.

    ``world_from_bind`` is for each joint its transform in the world times its inverse bind matrix. Weights count by
    their share of the vertex's sum; a vertex without any follows its first joint.
    """
    positions, normals, tangents = _empty_like(vertices)
    mirrored = np.zeros(len(positions), bool)
    for block in _blocks(len(positions)):
        share = weights[block].astype(np.float64)
        total = share.sum(axis=1, keepdims=True)
        share = np.where(total > 0.0, share / np.where(total > 0.0, total, 1.0), np.eye(1, share.shape[1]))
        matrix = np.einsum("vk,vkij->vij", share, world_from_bind[joints[block]])
        linear = matrix[:, :3, :3]
        cofactors = np.cross(linear[:, [1, 2, 0]], linear[:, [2, 0, 1]])
        mirrored[block] = np.einsum("vi,vi->v", linear[:, 0], cofactors[:, 0]) < 0.0
        sign = np.where(mirrored[block], -1.0, 1.0)[:, None]
        positions[block] = _mapped_each(linear, vertices.positions[block]) + matrix[:, :3, 3]
        if vertices.normals is not None and normals is not None:
            normals[block] = _unit(sign * _mapped_each(cofactors, vertices.normals[block]))
        if vertices.tangents is not None and tangents is not None:
            tangents[block, :3] = _unit(_mapped_each(linear, vertices.tangents[block, :3]))
            tangents[block, 3:] = sign * vertices.tangents[block, 3:]
    return Vertices(positions, normals, tangents, mirrored)


def _empty_like(vertices: Vertices) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    return (
        np.empty_like(vertices.positions),
        None if vertices.normals is None else np.empty_like(vertices.normals),
        None if vertices.tangents is None else np.empty_like(vertices.tangents),
    )


def _blocks(count: int) -> Iterator[slice]:
    return (slice(start, start + _BLOCK) for start in range(0, count, _BLOCK))


def _mapped_each(matrices: Float[np.ndarray, "n 3 3"], vectors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    return np.einsum("vij,vj->vi", matrices, vectors.astype(np.float64))


def _mapped(matrix: Float[np.ndarray, "3 3"], vectors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    # not by @: for matrices so small its threads cost more than they save
    return np.einsum("ij,vj->vi", matrix, vectors.astype(np.float64))


def _unit(vectors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)
