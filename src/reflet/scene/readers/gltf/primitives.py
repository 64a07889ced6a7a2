"""From a node's mesh to parts: where they stand, and what they are made of."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from jaxtyping import Float32, UInt32

from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.attributes import TRIANGLES, Attributes, mode
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.images import CLAMP, REPEAT
from reflet.scene.readers.gltf.materials import Materials, TextureUse
from reflet.scene.readers.gltf.nodes import PlacedNode
from reflet.scene.readers.gltf.pose import Vertices
from reflet.scene.readers.gltf.rig import Rig
from reflet.scene.readers.gltf.surfaces import surface
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, children, index_or_none, text, whole
from reflet.scene.scene import Part


class Primitives:
    """Makes parts of placed nodes."""

    def __init__(
        self, document: Document, accessors: Accessors, buffers: Buffers, rig: Rig, materials: Materials
    ) -> None:
        self._document, self._accessors, self._buffers = document, accessors, buffers
        self._rig, self._materials = rig, materials

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
        uv = self._texture_coordinates(attributes, read.use, len(positions), key, name)
        material = self._tinted(read.material, attributes, triangles, len(positions), key, name)
        bumpy = material.normal_texture is not None and uv is not None
        # [glTF 2.0, 3.7.2.1]: without normals they are flat, and given tangents are ignored
        normals = attributes.floats("NORMAL", (3,), len(positions))
        tangents = attributes.floats("TANGENT", (4,), len(positions)) if bumpy and normals is not None else None
        if normals is not None and not np.isfinite(normals).all():
            notes.add("normals that are no numbers give way to those of the faces", "primitives", key, name)
            normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, np.float32(0.0))
        if tangents is not None and not np.isfinite(tangents).all():
            tangents = None  # and are computed
        for vertices in self._rig.posed(Vertices(positions, normals, tangents), node, primitive, attributes):
            yield surface(vertices, triangles, uv, bumpy), material

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

    # -- looks ---------------------------------------------------------------------------------------------------------

    def _texture_coordinates(
        self, attributes: Attributes, use: TextureUse | None, count: int, key: tuple[int, int], name: str
    ) -> Float32[np.ndarray, "vertices 2"] | None:
        notes = self._document.notes
        uv = attributes.floats(f"TEXCOORD_{use.coordinates if use else 0}", (2,), count)
        if uv is None:
            if use is not None:
                notes.add("textures are left out where there are no coordinates for them", "primitives", key, name)
            return None
        if not np.isfinite(uv).all():
            notes.add("texture coordinates that are no numbers count as 0", "primitives", key, name)
            uv = np.nan_to_num(uv, nan=0.0, posinf=0.0, neginf=0.0)
        uv = uv.copy()  # a view would keep the whole file in memory
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
        count: int,
        key: tuple[int, int],
        name: str,
    ) -> Material:
        """The material times the vertices' colour, which is one for all: their mean where it varies."""
        colors = attributes.floats("COLOR_0", (3, 4), count, fractions=True)
        if colors is None or not triangles.size:
            return material
        used = np.nan_to_num(colors[triangles.ravel(), :3])
        if (used != used[0]).any():
            notes = self._document.notes
            notes.add("vertex colours that vary are shown as their mean", "primitives", key, name)
        mean = used.mean(axis=0, dtype=np.float64) if (used != used[0]).any() else used[0].astype(np.float64)
        r, g, b = (np.clip(mean, 0.0, 1.0) * material.base_color).tolist()
        return replace(material, base_color=(r, g, b))


def _transformed(uv: Float32[np.ndarray, "vertices 2"], use: TextureUse) -> Float32[np.ndarray, "vertices 2"]:
    """KHR_texture_transform: scale, then rotate counter-clockwise in the image, then shift."""
    if use.transform == (0.0, 0.0, 0.0, 1.0, 1.0):
        return uv
    x, y, angle, scale_x, scale_y = use.transform
    cos, sin = np.cos(angle), np.sin(angle)
    matrix = np.array([[cos * scale_x, -sin * scale_x], [sin * scale_y, cos * scale_y]])
    return (uv.astype(np.float64) @ matrix + (x, y)).astype(np.float32)
