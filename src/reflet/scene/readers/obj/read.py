"""Reading Wavefront OBJ (.obj, .mtl) into parts."""

import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Int, Int32, Int64

from reflet.errors import RefletWarning
from reflet.scene.material import Material
from reflet.scene.meshes.compiled_corners import smooth_fans
from reflet.scene.meshes.corners import corner_tangents, unique_rows, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.triangulate import Triangulation, triangulate
from reflet.scene.readers.obj.libraries import materials_of
from reflet.scene.readers.obj.mtl import PlacedMaterial
from reflet.scene.readers.obj.plain_text import name_of
from reflet.scene.readers.obj.statements import ObjText, read_obj_text
from reflet.scene.scene import Part

CREASE_DEG = 60.0
"""Edges that turn by less are smooth where a file gives neither normals nor smoothing groups."""

FOLD_DEG = 150.0
"""Edges that turn by more are never smooth: there a surface meets its own back, as double-sided ones do."""

_NO_GROUP, _FLAT = -1, 0  # smoothing groups: none given, and off


def read_obj(path: str | Path) -> list[Part]:
    """The faces of a file, one part for every object or group and material in it, none marked reflective yet.

    Polygons become triangles. Faces without normals are smooth within their smoothing group and flat where the file
    says ``s off``; where it says nothing they are smooth over edges that turn by less than 60°. Smoothing ends at
    objects (``o``), not at groups and materials. Materials are read from .mtl files (`materials_of`); faces without one
    become mirrors of F0 = 0.65. What is left out is said in a RefletWarning each. Raises RefletError, naming the line,
    where the file is missing, damaged or holds no faces.
    """
    path = Path(path)
    text = read_obj_text(path)
    cut = triangulate(text.positions, text.corners[:, 0], text.starts)
    oddities = list(text.oddities)
    if cut.crossing:
        oddities.append(f"polygons that cross themselves ({cut.crossing}) are filled as well as they can be")
    if oddities:
        warnings.warn(f"{path.name}: {'; '.join(oddities)}.", RefletWarning, stacklevel=2)
    materials, material_of_face = materials_of(text, path)
    return _parts(text, path.stem, cut, materials, material_of_face)


def _parts(
    text: ObjText,
    stem: str,
    cut: Triangulation,
    materials: list[PlacedMaterial],
    material_of_face: Int32[np.ndarray, "faces"],
) -> list[Part]:
    faces = len(text.starts) - 1
    known = {stem: 0}
    of_texts = [known.setdefault(name_of(name) or stem, len(known)) for name in text.names.texts]
    name_of_face = text.names.spread(np.array(of_texts, np.int32)[text.names.text], 0, faces)
    textured = np.array([_has_textures(placed.material) for placed in materials])
    # faces of a textured material that are nowhere on its textures are a part of their own, which has no uv
    on_textures = (np.minimum.reduceat(text.corners[:, 1], text.starts[:-1]) >= 0) & textured[material_of_face]
    first, part = unique_rows(np.column_stack([name_of_face, material_of_face, on_textures.astype(np.int32)]))
    of_parts = list(zip(name_of_face[first].tolist(), material_of_face[first].tolist(), strict=True))
    worn = Counter(name for name, _ in set(of_parts))
    surface, names = _Surface(text, cut), list(known)
    parts = []
    for triangles, (name, wears) in zip(_triangles_of_parts(part[cut.face], len(first)), of_parts, strict=True):
        material = materials[wears].material
        part_name = f"{names[name]}_{material.name}" if worn[name] > 1 and wears else names[name]
        parts.append(Part(part_name, surface.mesh(triangles, materials[wears]), material))
    return parts


def _triangles_of_parts(part: Int32[np.ndarray, "triangles"], count: int) -> Sequence[slice | Int64[np.ndarray, "_"]]:
    """The triangles of each part, in their order."""
    if count == 1:
        return [slice(None)]
    sizes = np.bincount(part, minlength=count)
    return np.split(np.argsort(part, kind="stable"), np.cumsum(sizes)[:-1])


def _has_textures(material: Material) -> bool:
    return any(texture is not None for texture in material.textures.values())


class _Surface:
    """All triangles of a file. ``corners`` are each corner's places in the tables of points, texture coordinates (-1
    where it has none) and normals."""

    def __init__(self, text: ObjText, cut: Triangulation) -> None:
        """Works in the text's own array of corners where all its faces are triangles."""
        whole = cut.corners.size == len(text.corners) and len(cut.corners) == len(text.starts) - 1
        self.corners = text.corners if whole else text.corners[cut.corners.ravel()]
        first, point = unique_rows(text.positions.astype(np.float32))
        self.positions = text.positions[first]
        self.corners[:, 0] = point[self.corners[:, 0]]
        first, coordinates = unique_rows(text.uv)
        self.uv = text.uv[first]
        # the last one stands for none, here and below
        self.corners[:, 1] = np.append(coordinates, np.int32(-1))[self.corners[:, 1]]
        length = np.linalg.norm(text.normals, axis=1)
        unit = (text.normals / np.where(length > 0.0, length, 1.0)[:, None]).astype(np.float32)
        first, normal = unique_rows(unit)
        self.normals = unit[first]
        self.corners[:, 2] = np.append(np.where(length > 0.0, normal, -1), -1)[self.corners[:, 2]]
        bare = (self.corners[:, 2].reshape(-1, 3) < 0).any(axis=1)
        if bare.any():
            self._smooth(np.flatnonzero(bare), *_smoothing(text, cut.face[bare]))

    def _smooth(
        self,
        triangles: Int[np.ndarray, "triangles"],
        labels: Int64[np.ndarray, "triangles"],
        limits: Float64[np.ndarray, "triangles"],
    ) -> None:
        """Gives the corners of these triangles that lack normals those of the fans that they are in."""
        rows = slice(None) if 3 * len(triangles) == len(self.corners) else _corners(triangles)
        fan, normals = smooth_fans(np.ascontiguousarray(self.corners[rows, 0]), self.positions, labels, limits)
        given = self.corners[rows, 2]
        self.corners[rows, 2] = np.where(given < 0, fan + np.int32(len(self.normals)), given)
        self.normals = np.concatenate([self.normals, normals.astype(np.float32)])

    def mesh(self, triangles: slice | Int[np.ndarray, "triangles"], placed: PlacedMaterial) -> Mesh:
        """The mesh of some triangles, or of all; its uv are those of the material's textures."""
        keys = self.corners if isinstance(triangles, slice) else self.corners[_corners(triangles)]
        has_uv = bool((keys[:, 1] >= 0).all())
        first, vertex = unique_rows(keys if has_uv else keys[:, ::2])
        point, coordinates, normal = keys[first].T
        positions, normals, uv = self.positions[point].astype(np.float32), self.normals[normal], None
        if has_uv:  # a picture's v runs downwards
            uv = self.uv[coordinates] * placed.scale + placed.offset
            uv = (uv * (1.0, -1.0) + (0.0, 1.0)).astype(np.float32)
        if uv is not None and placed.material.normal_texture is not None:
            at, shading, texture = positions[vertex], normals[vertex], uv[vertex]
            return weld(at, shading, texture, corner_tangents(at, shading, texture))
        return Mesh(positions, normals, vertex.reshape(-1, 3).astype(np.uint32), uv)


def _corners(triangles: Int[np.ndarray, "triangles"]) -> Int[np.ndarray, "corners"]:
    return (3 * triangles[:, None] + np.arange(3)).ravel()


def _smoothing(
    text: ObjText, face: Int[np.ndarray, "triangles"]
) -> tuple[Int64[np.ndarray, "triangles"], Float64[np.ndarray, "triangles"]]:
    """Of each triangle a label, equal where smoothing may pass, and the least cosine of a turn that is smooth."""
    faces, objects = len(text.starts) - 1, len(text.objects.text)
    groups = np.array([_group(said) for said in text.smoothing.texts], np.int32)
    group = text.smoothing.spread(groups[text.smoothing.text], _NO_GROUP, faces)[face]
    label = group * np.int64(objects + 1) + text.objects.spread(np.arange(objects), -1, faces)[face]
    crease, fold = np.cos(np.radians([CREASE_DEG, FOLD_DEG]))
    return label, np.select([group == _NO_GROUP, group == _FLAT], [crease, 2.0], fold)


def _group(text: str) -> int:
    """The smoothing group of an s line; ``on``, which some tools write, is group 1."""
    word = (text.split() or ["off"])[0].lower()
    if word in ("off", "null"):
        return _FLAT
    return min(int(word), 2**31 - 1) if word.isdecimal() else 1
