"""What moves a node's vertices to where the file shows them: its morph targets, its skin, its place."""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.attributes import Attributes
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.nodes import Nodes, PlacedNode
from reflet.scene.readers.gltf.pose import MorphTarget, Vertices, morphed, placed, skinned
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, array, children, index_or_none, numbers, whole

_MOVED = ("POSITION", "NORMAL", "TANGENT")


class Rig:
    """Poses primitives by the weights and the joints that the file's nodes have."""

    def __init__(self, document: Document, accessors: Accessors, buffers: Buffers, nodes: Nodes) -> None:
        self._document, self._accessors, self._buffers, self._nodes = document, accessors, buffers, nodes

    def posed(
        self, vertices: Vertices, node: PlacedNode, primitive: JsonObject, attributes: Attributes
    ) -> Iterator[Vertices]:
        """The vertices in the world, once for each place where the node stands; a skin stands where its joints do."""
        targets = self._morph_targets(node, primitive, len(vertices.positions))
        rest = morphed(vertices, targets) if targets else vertices
        held = self._skinned(rest, node, attributes)
        if held is not None:
            yield held
        else:
            for world in node.world_from_node:
                yield placed(rest, world)

    def _morph_targets(self, node: PlacedNode, primitive: JsonObject, count: int) -> list[MorphTarget]:
        given = children(primitive, "targets")
        mesh = self._document.item("meshes", whole(node.node.get("mesh"), "mesh"))
        holder = node.node if array(node.node, "weights") else mesh
        weights = numbers(holder, "weights", (0.0,) * min(len(given), len(array(holder, "weights"))))
        targets = []
        for target, weight in zip(given, weights, strict=False):
            if weight == 0.0:
                continue
            moves = Attributes({"attributes": target}, self._accessors, self._buffers)
            targets.append(MorphTarget(weight, *(moves.floats(kind, (3,), count) for kind in _MOVED)))
        return targets

    def _skinned(self, rest: Vertices, node: PlacedNode, attributes: Attributes) -> Vertices | None:
        """The vertices as the joints hold them, in the world; None for what has no skin."""
        index = index_or_none(node.node, "skin")
        if index is None:
            return None
        joints: list[np.ndarray] = []
        weights: list[np.ndarray] = []
        count = len(rest.positions)
        while (js := attributes.integers(f"JOINTS_{len(joints)}", 4, count)) is not None:
            ws = attributes.floats(f"WEIGHTS_{len(joints)}", (4,), count, fractions=True)
            if ws is None:
                raise DamagedError(f"it has joints without WEIGHTS_{len(joints)}")
            joints.append(js)
            weights.append(np.maximum(np.nan_to_num(ws, posinf=0.0), 0.0))
        if not joints:
            self._document.notes.add(
                "what has a skin but no joints stands as its node does", "nodes", node.index, node.name
            )
            return None
        matrices = self._world_from_bind(self._document.item("skins", index))
        all_joints, all_weights = np.concatenate(joints, axis=1), np.concatenate(weights, axis=1)
        all_joints = np.where(all_weights > 0.0, all_joints, 0)  # unused ones may be anything
        if all_joints.size and all_joints.max() >= len(matrices):
            raise DamagedError(f"it refers to joint {all_joints.max()} of {len(matrices)}")
        self._document.notes.add(
            "skins are shown in the pose that the file gives their joints", "nodes", node.index, node.name
        )
        return skinned(rest, all_joints, all_weights, matrices)

    def _world_from_bind(self, skin: JsonObject) -> Float[np.ndarray, "joints 4 4"]:
        joints = [whole(joint, "a joint") for joint in array(skin, "joints")]
        if not joints:
            raise DamagedError("its skin has no joints")
        world = np.stack([self._nodes.world_from_node(joint) for joint in joints])
        index = index_or_none(skin, "inverseBindMatrices")
        if index is None:
            return world
        inverse_bind = self._accessors.floats(index, (16,))[: len(joints)]
        if len(inverse_bind) < len(joints) or not np.isfinite(inverse_bind).all():
            raise DamagedError(f"its skin has {len(joints)} joints, but no inverse bind matrix of numbers for each")
        return world @ inverse_bind.astype(np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)
