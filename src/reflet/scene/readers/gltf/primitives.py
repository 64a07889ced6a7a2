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
from reflet.scene.readers.gltf.materials.materials import Materials, Placement, ReadMaterial
from reflet.scene.readers.gltf.nodes import PlacedNode
from reflet.scene.readers.gltf.pose import Vertices
from reflet.scene.readers.gltf.rig import Rig
from reflet.scene.readers.gltf.surfaces import Looks, surface
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
        material, looks = self._looks(attributes, read, len(positions), key, name)
        material = _opaque_if_solid(material, looks)
        bumps = material.normal_texture or material.clearcoat_normal_texture if looks.uv is not None else None
        # [glTF 2.0, 3.7.2.1]: without normals they are flat, and given tangents are ignored
        normals = attributes.floats("NORMAL", (3,), len(positions))
        tangents = attributes.floats("TANGENT", (4,), len(positions)) if bumps and normals is not None else None
        if normals is not None and not np.isfinite(normals).all():
            notes.add("normals that are no numbers give way to those of the faces", "primitives", key, name)
            normals = np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, np.float32(0.0))
        if tangents is not None and not np.isfinite(tangents).all():
            tangents = None  # and are computed
        for vertices in self._rig.posed(Vertices(positions, normals, tangents), node, primitive, attributes):
            yield surface(vertices, triangles, looks, bumps.coordinates if bumps else None), material

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

    def _looks(
        self, attributes: Attributes, read: ReadMaterial, count: int, key: tuple[int, int], name: str
    ) -> tuple[Material, Looks]:
        """The material without the textures that there are no coordinates for, and what vertices have for it."""
        found = [self._texture_coordinates(attributes, placement, count, key, name) for placement in read.placements]
        colors = self._colors(attributes, count, key, name)
        if not read.placements:  # others may want them
            return read.material, Looks(
                self._texture_coordinates(attributes, Placement(), count, key, name), (), colors
            )
        there = [uv for uv in found if uv is not None]
        if len(there) == len(found):
            return read.material, Looks(there[0], tuple(there[1:]), colors)
        notes = self._document.notes
        notes.add("textures are left out where there are no coordinates for them", "primitives", key, name)
        if not there:
            return read.material, Looks(None, (), colors)
        lost = {number for number, uv in enumerate(found) if uv is None}
        kept = {
            slot: None if texture is not None and texture.coordinates in lost else texture
            for slot, texture in read.material.textures.items()
        }
        nothing = np.zeros((count, 2), np.float32)
        first, *others = (nothing if uv is None else uv for uv in found)
        return replace(read.material, **kept), Looks(first, tuple(others), colors)  # type: ignore[arg-type]

    def _texture_coordinates(
        self, attributes: Attributes, placement: Placement, count: int, key: tuple[int, int], name: str
    ) -> Float32[np.ndarray, "vertices 2"] | None:
        uv = attributes.floats(f"TEXCOORD_{placement.coordinates}", (2,), count)
        if uv is None:
            return None
        if not np.isfinite(uv).all():
            notes = self._document.notes
            notes.add("texture coordinates that are no numbers count as 0", "primitives", key, name)
            uv = np.nan_to_num(uv, nan=0.0, posinf=0.0, neginf=0.0)
        return _transformed(uv.copy(), placement)  # a view would keep the whole file in memory

    def _colors(
        self, attributes: Attributes, count: int, key: tuple[int, int], name: str
    ) -> Float32[np.ndarray, "vertices 4"] | None:
        """The vertices' colours, alpha 1 where they have none; None where they change nothing."""
        given = attributes.floats("COLOR_0", (3, 4), count, fractions=True)
        if given is None:
            return None
        notes = self._document.notes
        if not np.isfinite(given).all():
            notes.add("vertex colours that are no numbers count as white", "primitives", key, name)
        if ((given < 0.0) | (given > 1.0)).any():
            notes.add("vertex colours below 0 or above 1 are taken as the nearer of them", "primitives", key, name)
        colors = np.ones((count, 4), np.float32)
        colors[:, : given.shape[1]] = np.clip(np.nan_to_num(given, nan=1.0, posinf=1.0, neginf=1.0), 0.0, 1.0)
        return None if (colors == 1.0).all() else colors


def _opaque_if_solid(material: Material, looks: Looks) -> Material:
    """Opaque where alpha is nowhere so low that anything would be seen through it: many exporters blend everything."""
    texture = None if looks.uv is None else material.base_color_texture_srgb
    least = material.alpha * (1.0 if texture is None else float(texture.pixels[..., 3].min()) / 255.0)
    least *= 1.0 if looks.colors is None else float(looks.colors[:, 3].min(initial=1.0))
    solid = least >= (1.0 if material.alpha_mode == "blend" else material.alpha_cutoff)
    return replace(material, alpha_mode="opaque") if solid and material.alpha_mode != "opaque" else material


def _transformed(uv: Float32[np.ndarray, "vertices 2"], placement: Placement) -> Float32[np.ndarray, "vertices 2"]:
    """KHR_texture_transform: scale, then rotate counter-clockwise in the image, then shift."""
    if placement.transform == Placement().transform:
        return uv
    x, y, angle, scale_x, scale_y = placement.transform
    cos, sin = np.cos(angle), np.sin(angle)
    matrix = np.array([[cos * scale_x, -sin * scale_x], [sin * scale_y, cos * scale_y]])
    return (uv.astype(np.float64) @ matrix + (x, y)).astype(np.float32)
