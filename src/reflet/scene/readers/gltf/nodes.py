"""Where the nodes of a glTF scene stand, and which of them are shown."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.values import (
    DamagedError,
    JsonObject,
    array,
    child,
    children,
    extension,
    index_or_none,
    numbers,
    text,
    whole,
)

Matrix = Float[np.ndarray, "4 4"]

_INSTANCE_ATTRIBUTES = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}


@dataclass(frozen=True)
class PlacedNode:
    """A node with a mesh, and where it stands: once, or once for each of its instances."""

    index: int
    node: JsonObject
    world_from_node: tuple[Matrix, ...]

    @property
    def name(self) -> str:
        """What sentences call it."""
        return text(self.node, "name") or f"node {self.index}"


class Nodes:
    """The tree of nodes. Raises DamagedError where it is none."""

    def __init__(self, document: Document, accessors: Accessors) -> None:
        self._document, self._accessors = document, accessors
        self._nodes = children(document.root, "nodes")
        self._parents = self._checked_parents()
        self._world: dict[int, Matrix] = {}

    def world_from_node(self, index: int) -> Matrix:
        """Where a node stands; it need not be in the scene that is shown."""
        chain = []
        at: int | None = index
        while at is not None and at not in self._world:
            chain.append(at)
            at = self._parents.get(at)
        for place in reversed(chain):
            parent = self._parents.get(place)
            local = _local_matrix(self._document.item("nodes", place))
            self._world[place] = local if parent is None else self._world[parent] @ local
        return self._world[index]

    def placed(self) -> Iterator[PlacedNode]:
        """The nodes with meshes of the default scene, parents before children."""
        for index, node in self.shown():
            if node.get("mesh") is not None:
                yield PlacedNode(index, node, tuple(self._placements(index, node)))

    def shown(self) -> Iterator[tuple[int, JsonObject]]:
        """The nodes of the default scene and their numbers, parents before children, but for hidden ones."""
        pending = self._roots()[::-1]
        while pending:
            index = pending.pop()
            node = self._nodes[index]
            visibility = extension(node, "KHR_node_visibility")
            if visibility is not None and visibility.get("visible") is False:
                continue  # and all below it
            pending.extend(whole(kid, "a child") for kid in reversed(array(node, "children")))
            yield index, node

    def _roots(self) -> list[int]:
        document = self._document
        scenes = children(document.root, "scenes")
        if not scenes:
            return [index for index in range(len(self._nodes)) if index not in self._parents]
        chosen = index_or_none(document.root, "scene") or 0
        if chosen >= len(scenes):
            document.notes.add(
                "the scene it opens with is not there, and the first is shown", "scenes", 0, f"number {chosen + 1}"
            )
            chosen = 0
        elif len(scenes) > 1:
            name = text(scenes[chosen], "name") or f"number {chosen + 1}"
            document.notes.add("only the scene it opens with is shown", "scenes", chosen, name)
        roots = [whole(root, "a node") for root in array(scenes[chosen], "nodes")]
        for root in roots:
            document.item("nodes", root)
        # some tools list all nodes of a scene, not its roots alone: each is shown once, below its parent
        listed = set(roots)
        return [root for root in dict.fromkeys(roots) if not self._has_ancestor(root, listed)]

    def _has_ancestor(self, index: int, among: set[int]) -> bool:
        at = self._parents.get(index)
        while at is not None and at not in among:
            at = self._parents.get(at)
        return at is not None

    def _checked_parents(self) -> dict[int, int]:
        parents: dict[int, int] = {}
        for index, node in enumerate(self._nodes):
            for kid in array(node, "children"):
                kid = whole(kid, "a child")
                self._document.item("nodes", kid)
                if parents.setdefault(kid, index) != index:
                    raise DamagedError(f"node {kid} is a child of two nodes, {parents[kid]} and {index}")
        reached = [index for index in range(len(self._nodes)) if index not in parents]
        for index in reached:  # grows as it goes
            reached.extend(dict.fromkeys(whole(kid, "a child") for kid in array(self._nodes[index], "children")))
        if len(reached) < len(self._nodes):
            raise DamagedError("it has nodes that contain themselves")
        return parents

    def _placements(self, index: int, node: JsonObject) -> Iterator[Matrix]:
        world = self.world_from_node(index)
        instancing = extension(node, "EXT_mesh_gpu_instancing")
        attributes = child(instancing, "attributes") if instancing is not None else {}
        given = {
            name: self._accessors.floats(whole(attributes[name], name), (width,)).astype(np.float64)
            for name, width in _INSTANCE_ATTRIBUTES.items()
            if name in attributes
        }
        if not given:
            yield world
            return
        counts = {len(values) for values in given.values()}
        if len(counts) > 1 or not all(np.isfinite(values).all() for values in given.values()):
            raise DamagedError(
                f"the instances of node {index} have attributes of different counts or that are no numbers"
            )
        count = counts.pop()
        translation = given.get("TRANSLATION", np.zeros((count, 3)))
        rotation = given.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))
        scale = given.get("SCALE", np.ones((count, 3)))
        for t, r, s in zip(translation, rotation, scale, strict=True):
            yield world @ _composed(t, r, s)


def _local_matrix(node: JsonObject) -> Matrix:
    """parent_from_node, from the node's matrix (column-major in the file) or its translation, rotation and scale."""
    if array(node, "matrix"):
        return np.asarray(numbers(node, "matrix", (0.0,) * 16)).reshape(4, 4).T
    return _composed(
        np.asarray(numbers(node, "translation", (0.0, 0.0, 0.0))),
        np.asarray(numbers(node, "rotation", (0.0, 0.0, 0.0, 1.0))),
        np.asarray(numbers(node, "scale", (1.0, 1.0, 1.0))),
    )


def _composed(
    translation: Float[np.ndarray, "3"], rotation: Float[np.ndarray, "4"], scale: Float[np.ndarray, "3"]
) -> Matrix:
    """Scale, then rotation by a quaternion (x, y, z, w) of any length but 0, which turns nothing, then translation."""
    length = float(np.linalg.norm(rotation))
    x, y, z, w = (rotation / length).tolist() if length > 0.0 else (0.0, 0.0, 0.0, 1.0)
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turned * scale
    matrix[:3, 3] = translation
    return matrix
