"""The tree of boxes that rays find a scene's mirrors and their companions by: what is stored of it."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8, UInt32

from reflet.scene.companions import traced_parts
from reflet.scene.scene import Scene

MOST_DEPTH = 32  # inner nodes above a leaf: as many numbers as a ray has to keep
LARGEST_LEAF = 4  # triangles


@dataclass(frozen=True)
class Bvh:
    """A bounding volume hierarchy over the triangles of all reflective parts and of their ``companions``, indices of
    parts that do not reflect (`reflet.scene.companions`). It is without its boxes: these follow from it.

    ``order`` are the scene's numbers of these triangles in the order of the leaves that hold them. ``leaf_counts`` has
    the nodes in depth-first order, a node before its two subtrees: 0 for an inner node, else how many triangles a leaf
    holds, at most `LARGEST_LEAF`. No leaf has more than `MOST_DEPTH` inner nodes above it. ``directions`` are 64 bits
    for each triangle of ``order``, the first 32 first: whether rays that leave it in a direction may meet any of
    these triangles (`reflet.scene.bvh.directions`); 0 of companions, which no ray leaves.
    """

    order: UInt32[np.ndarray, "met"]
    leaf_counts: UInt8[np.ndarray, "nodes"]
    directions: UInt32[np.ndarray, "met 2"]
    companions: tuple[int, ...] = ()


def met_triangles(scene: Scene, beside: Collection[int]) -> UInt32[np.ndarray, "met"]:
    """The scene's numbers of all triangles of reflective parts, and of the companions ``beside`` them, increasing."""
    is_met = np.zeros(len(scene.parts), bool)
    is_met[list(traced_parts(scene, beside))] = True
    return np.flatnonzero(np.repeat(is_met, np.diff(scene.triangle_offsets))).astype(np.uint32)


def corners_of(scene: Scene, triangles: UInt32[np.ndarray, "chosen"]) -> Float32[np.ndarray, "chosen 3 3"]:
    """The corners of some of the scene's triangles, in metres."""
    out = np.empty((len(triangles), 3, 3), np.float32)
    part_of = np.searchsorted(scene.triangle_offsets, triangles, side="right") - 1
    for index in np.unique(part_of):
        mesh, here = scene.parts[index].mesh, part_of == index
        out[here] = mesh.positions[mesh.triangles[triangles[here] - np.uint32(scene.triangle_offsets[index])]]
    return out
