"""Builds the tree of a scene's mirrors and their companions."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from reflet.scene.bvh.bvh import LARGEST_LEAF, MOST_DEPTH, Bvh, corners_of, met_triangles
from reflet.scene.bvh.compiled_split import split
from reflet.scene.bvh.directions import direction_bits
from reflet.scene.bvh.nodes import refitted
from reflet.scene.companions import companions
from reflet.scene.scene import Scene


def build_bvh(scene: Scene, on_hull: Bool[np.ndarray, "triangles"]) -> Bvh:
    """The tree over all reflective parts and their companions. ``on_hull`` flags triangles whose fronts see nothing of
    their own object (`hull_triangles`): where there is nothing else, their rays meet nothing.

    The same scene gives the same tree. Time and memory grow little faster than the number of triangles: for a million
    some seconds and 200 MB.
    """
    beside = companions(scene)
    chosen = met_triangles(scene, beside)
    corners = corners_of(scene, chosen)
    boxes = np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1).astype(np.float64)
    place, leaf_counts = split(boxes, LARGEST_LEAF, MOST_DEPTH)
    none = np.zeros((len(chosen), 2), np.uint32)
    bvh, corners = Bvh(chosen[place], leaf_counts, none, beside), corners[place]
    counts = np.diff(scene.triangle_offsets)
    double_sided = np.repeat([part.material.double_sided for part in scene.parts], counts)
    looks = np.repeat([part.reflective for part in scene.parts], counts)
    if len(scene.objects) == 1 and not beside:
        looks &= ~on_hull
    nodes = refitted(leaf_counts, corners)
    return replace(bvh, directions=direction_bits(nodes, corners, looks[bvh.order], double_sided[bvh.order]))
