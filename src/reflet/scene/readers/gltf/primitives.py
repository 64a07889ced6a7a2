"""From a node's mesh to parts: posed, placed, and shaded as its materials say."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Float32, UInt32

from reflet.scene.material import Material
from reflet.scene.meshes.corners import corner_tangents, crease_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.attributes import TRIANGLES, Attributes, mode
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.images import CLAMP, REPEAT
from reflet.scene.readers.gltf.materials import Materials, TextureUse
from reflet.scene.readers.gltf.nodes import Nodes, PlacedNode
from reflet.scene.readers.gltf.pose import MorphTarget, Vertices, morphed, placed, skinned
from reflet.scene.readers.gltf.values import (
    DamagedError,
    JsonObject,
    array,
    children,
    index_or_none,
    numbers,
    text,
    whole,
)
from reflet.scene.scene import Part

_BLOCK = 65536


class Primitives:
    """Makes parts of placed nodes."""

    def __init__(
        self, document: Document, accessors: Accessors, buffers: Buffers, nodes: Nodes, materials: Materials
    ) -> None:
        self._document, self._accessors, self._buffers = document, accessors, buffers
        self._nodes, self._materials = nodes, materials

    def parts(self, node: PlacedNode) -> Iterator[Part]:
        """One part for each primitive of triangles and each place where the node stands."""
        index = whole(node.node.get("mesh"), "mesh")
        mesh = self._document.item("meshes", index)
        primitives = children(mesh, "primitives")
        stem = text(node.node, "name") or text(mesh, "name") or self._document.path.stem
        for number, primitive in enumerate(primitives):
            read = self._materials.material(index_or_none(primitive, "material"))
            name = stem if len(primitives) == 1 else f"{stem}_{read.material.name or number}"
            try:
                for geometry, material in self._placed(node, (index, number), name, primitive):
                    yield Part(name, geometry, material)
            except DamagedError as error:
                raise DamagedError(f"in part {name}, {error}") from error

    def _placed(
        self, node: PlacedNode, key: tuple[int, int], name: str, primitive: JsonObject
    ) -> Iterator[tuple[Mesh, Material]]:
        notes = self._document.notes
        if mode(primitive) < TRIANGLES:
            notes.add("points and lines are left out", "primitives", key, name)
            return
        attributes = Attributes(primitive, self._accessors, self._buffers)
        positions = attributes.floats("POSITION", (3,))
        if positions is None:
            notes.add("what has no positions is left out", "primitives", key, name)
            return
        read = self._materials.material(index_or_none(primitive, "material"))
        triangles, surplus = attributes.triangles(len(positions))
        if surplus:
            notes.add("corners that make no whole triangle are left out", "primitives", key, f"{surplus} of {name}")
        positions, triangles = self._numbered(positions, triangles, key, name)
        uv = self._texture_coordinates(attributes, read.use, key, name)
        material = self._tinted(read.material, attributes, triangles, key, name)
        bumpy = material.normal_texture is not None and uv is not None
        # [glTF 2.0, 3.7.2.1]: without normals they are flat, and given tangents are ignored
        normals = attributes.floats("NORMAL", (3,))
        tangents = attributes.floats("TANGENT", (4,)) if bumpy and normals is not None else None
        for what, rows in (("normals", normals), ("tangents", tangents)):
            if rows is not None and len(rows) != len(positions):
                raise DamagedError(f"there are {len(rows)} {what} for {len(positions)} vertices")
        if normals is not None and not np.isfinite(normals).all():
            notes.add("normals that are no numbers give way to those of the faces", "primitives", key, name)
            normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, np.float32(0.0))
        if tangents is not None and not np.isfinite(tangents).all():
            tangents = None
        rest = Vertices(positions, normals, tangents)
        targets = self._morph_targets(node, primitive, len(positions))
        if targets:
            rest = morphed(rest, targets)
        posed = self._skinned(rest, node, attributes)
        shown = (placed(rest, world) for world in node.world_from_node) if posed is None else (posed,)
        for vertices in shown:
            yield _mesh(vertices, triangles, uv, bumpy), material

    def _numbered(
        self,
        positions: Float32[np.ndarray, "vertices 3"],
        triangles: UInt32[np.ndarray, "triangles 3"],
        key: tuple[int, int],
        name: str,
    ) -> tuple[Float32[np.ndarray, "vertices 3"], UInt32[np.ndarray, "kept 3"]]:
        """Positions that are numbers, and the triangles between such."""
        number = np.isfinite(positions).all(axis=1)
        if number.all():
            return positions, triangles
        kept = number[triangles].all(axis=1)
        if not kept.all():
            counted = f"{np.count_nonzero(~kept)} of {len(kept)} in {name}"
            what = "triangles whose corners are no numbers (NaN or infinite) are left out"
            self._document.notes.add(what, "primitives", key, counted)
        return np.where(number[:, None], positions, np.float32(0.0)), triangles[kept]

    # -- pose ----------------------------------------------------------------------------------------------------------

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
            kinds = [moves.floats(kind, (3,)) for kind in ("POSITION", "NORMAL", "TANGENT")]
            if any(rows is not None and len(rows) != count for rows in kinds):
                raise DamagedError(f"a morph target does not move {count} vertices")
            targets.append(MorphTarget(weight, *kinds))
        return targets

    def _skinned(self, rest: Vertices, node: PlacedNode, attributes: Attributes) -> Vertices | None:
        """The vertices as the joints hold them, in the world; None for what has no skin."""
        index = index_or_none(node.node, "skin")
        if index is None:
            return None
        joints: list[np.ndarray] = []
        weights: list[np.ndarray] = []
        while (js := attributes.integers(f"JOINTS_{len(joints)}", 4)) is not None:
            ws = attributes.floats(f"WEIGHTS_{len(joints)}", (4,), fractions=True)
            if ws is None or not len(js) == len(ws) == len(rest.positions):
                raise DamagedError(f"joints and weights are not those of {len(rest.positions)} vertices")
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

    # -- looks ---------------------------------------------------------------------------------------------------------

    def _texture_coordinates(
        self, attributes: Attributes, use: TextureUse | None, key: tuple[int, int], name: str
    ) -> Float32[np.ndarray, "vertices 2"] | None:
        notes = self._document.notes
        uv = attributes.floats(f"TEXCOORD_{use.coordinates if use else 0}", (2,))
        if uv is None:
            if use is not None:
                notes.add("textures are left out where there are no coordinates for them", "primitives", key, name)
            return None
        if not np.isfinite(uv).all():
            notes.add("texture coordinates that are no numbers count as 0", "primitives", key, name)
            uv = np.nan_to_num(uv, nan=0.0, posinf=0.0, neginf=0.0)
        if use is None:
            return uv
        uv = _transformed(uv, use)
        if use.wraps not in ((REPEAT, REPEAT), (CLAMP, CLAMP)) and len(uv):
            beyond = (uv.min(axis=0) < 0.0) | (uv.max(axis=0) > 1.0)
            if any(out and wrap != REPEAT for out, wrap in zip(beyond, use.wraps, strict=True)):
                what = "textures that repeat mirrored, or in one direction only, repeat as they are in both"
                notes.add(what, "primitives", key, name)
        return uv

    def _tinted(
        self,
        material: Material,
        attributes: Attributes,
        triangles: UInt32[np.ndarray, "triangles 3"],
        key: tuple[int, int],
        name: str,
    ) -> Material:
        """The material times the vertices' colour, which is one for all: their mean where it varies."""
        colors = attributes.floats("COLOR_0", (3, 4), fractions=True)
        if colors is None or not triangles.size:
            return material
        if triangles.max() >= len(colors):
            raise DamagedError(f"there are only {len(colors)} vertex colours")
        used = np.nan_to_num(colors[triangles.ravel(), :3])
        if (used != used[0]).any():
            notes = self._document.notes
            notes.add("vertex colours that vary are shown as their mean", "primitives", key, name)
        mean = used.mean(axis=0, dtype=np.float64) if (used != used[0]).any() else used[0].astype(np.float64)
        r, g, b = (np.clip(mean, 0.0, 1.0) * material.base_color).tolist()
        return replace(material, base_color=(r, g, b))


def _mesh(
    vertices: Vertices,
    triangles: UInt32[np.ndarray, "triangles 3"],
    uv: Float32[np.ndarray, "vertices 2"] | None,
    bumpy: bool,
) -> Mesh:
    """The mesh, with flat normals and, where it is ``bumpy``, with tangents of its own making where it has none."""
    triangles = _facing(triangles, vertices.mirrored)
    if bumpy and uv is not None and vertices.tangents is None:
        corner = triangles.ravel()
        at = vertices.positions[corner]
        normals = crease_normals(at, 0.0) if vertices.normals is None else vertices.normals[corner].astype(np.float64)
        return weld(at, normals, uv[corner], corner_tangents(at, normals, uv[corner]))
    if vertices.normals is None:
        return _flat(vertices.positions, triangles, uv)
    return Mesh(vertices.positions, vertices.normals, triangles, uv, vertices.tangents)


def _facing(
    triangles: UInt32[np.ndarray, "triangles 3"], mirrored: bool | Bool[np.ndarray, "vertices"]
) -> UInt32[np.ndarray, "triangles 3"]:
    """Triangles turned over where their transform is mirrored, most of their corners' where it differs [glTF 2.0,
    3.7.4]."""
    turned = np.asarray(mirrored) if isinstance(mirrored, bool) else mirrored[triangles].sum(axis=1) >= 2
    return np.where(turned[..., None], triangles[:, ::-1], triangles) if turned.any() else triangles


def _flat(
    positions: Float32[np.ndarray, "vertices 3"],
    triangles: UInt32[np.ndarray, "triangles 3"],
    uv: Float32[np.ndarray, "vertices 2"] | None,
) -> Mesh:
    """Three vertices of its own for each triangle: faces that bend share none, and those that do not cost little."""
    at = np.empty((3 * len(triangles), 3), np.float32)
    normals = np.empty_like(at)
    for start in range(0, len(triangles), _BLOCK):
        block = slice(3 * start, 3 * (start + _BLOCK))
        at[block] = positions[triangles[start : start + _BLOCK].ravel()]
        normals[block] = crease_normals(at[block], 0.0)
    own = np.arange(len(at), dtype=np.uint32).reshape(-1, 3)
    return Mesh(at, normals, own, None if uv is None else uv[triangles.ravel()])


def _transformed(uv: Float32[np.ndarray, "vertices 2"], use: TextureUse) -> Float32[np.ndarray, "vertices 2"]:
    """KHR_texture_transform: scale, then rotate counter-clockwise in the image, then shift."""
    if use.transform == (0.0, 0.0, 0.0, 1.0, 1.0):
        return uv
    x, y, angle, scale_x, scale_y = use.transform
    cos, sin = np.cos(angle), np.sin(angle)
    matrix = np.array([[cos * scale_x, -sin * scale_x], [sin * scale_y, cos * scale_y]])
    return (uv.astype(np.float64) @ matrix + (x, y)).astype(np.float32)
