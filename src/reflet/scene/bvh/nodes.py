"""The tree with its boxes, as rays need it: refitted to the meshes in linear time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Shaped, UInt8, UInt32
from numba import njit

from reflet.scene.bvh.bvh import LARGEST_LEAF, MOST_DEPTH, Bvh, met_triangles
from reflet.scene.scene import Scene


@dataclass(frozen=True)
class BvhNodes:
    """The nodes of a `Bvh`, in its order. ``link`` is a leaf's first triangle in the order of the leaves; of an inner
    node, whose first child follows it at once, it is the second child. ``counts`` are 0 of inner nodes, else how many
    triangles a leaf holds."""

    lower: Float32[np.ndarray, "nodes 3"]
    upper: Float32[np.ndarray, "nodes 3"]
    link: UInt32[np.ndarray, "nodes"]
    counts: UInt8[np.ndarray, "nodes"]


def refitted(leaf_counts: UInt8[np.ndarray, "nodes"], corners: Float32[np.ndarray, "met 3 3"]) -> BvhNodes:
    """The nodes over triangles in the order of the leaves. Raises ValueError as `links_of` does."""
    link = links_of(leaf_counts, len(corners))
    lower, upper = np.empty((len(link), 3), np.float32), np.empty((len(link), 3), np.float32)
    _fit(leaf_counts, link, corners.min(axis=1), corners.max(axis=1), lower, upper)
    return BvhNodes(lower, upper, link, leaf_counts)


def checked_bvh(
    scene: Scene,
    order: Shaped[np.ndarray, "..."],
    leaf_counts: Shaped[np.ndarray, "..."],
    directions: Shaped[np.ndarray, "..."],
    companions: Sequence[int] = (),
) -> Bvh:
    """The tree of these arrays. Raises ValueError where they are none over the scene's reflective triangles and those
    of its ``companions``, or these are none."""
    dull = {number for number, part in enumerate(scene.parts) if not part.reflective}
    if any(type(number) is not int for number in companions) or not dull.issuperset(companions):
        raise ValueError(f"companions are parts that do not reflect, not {list(companions)}")
    chosen = met_triangles(scene, companions)
    types = order.dtype, leaf_counts.dtype, directions.dtype
    if types != (np.uint32, np.uint8, np.uint32) or leaf_counts.ndim != 1:
        raise ValueError("the tree's arrays are of other types")
    if not np.array_equal(np.sort(order, axis=None), chosen) or directions.shape != (len(chosen), 2):
        raise ValueError(f"the tree holds other triangles than the {len(chosen)} of mirrors and companions")
    links_of(leaf_counts, len(chosen))
    return Bvh(order.reshape(-1), leaf_counts, directions, tuple(sorted(set(companions))))


def links_of(leaf_counts: UInt8[np.ndarray, "nodes"], triangles: int) -> UInt32[np.ndarray, "nodes"]:
    """`BvhNodes.link`. Raises ValueError where the counts are no tree over so many triangles that `Bvh` allows."""
    link = _links(leaf_counts, triangles, LARGEST_LEAF, MOST_DEPTH)
    if len(link) != len(leaf_counts) or not len(link):
        raise ValueError(f"{len(leaf_counts)} nodes are no tree over {triangles} triangles")
    return link


@njit(cache=True)
def _links(counts, triangles, largest_leaf, most_depth):  # type: ignore[no-untyped-def]
    """Of each node; empty where these are not the counts of one tree over so many triangles."""
    nothing = np.empty(0, np.uint32)
    link = np.zeros(len(counts), np.uint32)
    waiting = np.empty((most_depth + 1, 2), np.int64)  # inner nodes whose second child is yet to come, and their depth
    top, depth, triangle = 0, 0, 0
    for i in range(len(counts)):
        if i and counts[i - 1]:
            if top == 0:
                return nothing
            top -= 1
            link[waiting[top, 0]] = i
            depth = waiting[top, 1] + 1
        if counts[i] == 0:
            if depth == most_depth:
                return nothing
            waiting[top] = i, depth
            top += 1
            depth += 1
        else:
            link[i] = triangle
            triangle += counts[i]
            if counts[i] > largest_leaf:
                return nothing
    whole = top == 0 and triangle == triangles and (len(counts) == 0 or counts[-1] > 0)
    return link if whole else nothing


@njit(cache=True)
def _fit(counts, link, least, largest, lower, upper):  # type: ignore[no-untyped-def]
    for i in range(len(counts) - 1, -1, -1):  # children come after their parents
        if counts[i]:
            lower[i], upper[i] = np.inf, -np.inf
            for t in range(link[i], link[i] + counts[i]):
                for k in range(3):
                    lower[i, k], upper[i, k] = min(lower[i, k], least[t, k]), max(upper[i, k], largest[t, k])
        else:
            for k in range(3):
                lower[i, k] = min(lower[i + 1, k], lower[link[i], k])
                upper[i, k] = max(upper[i + 1, k], upper[link[i], k])
