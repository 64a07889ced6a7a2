"""Reading Wavefront OBJ (.obj, .mtl) into parts."""

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from reflet.errors import RefletError, RefletWarning
from reflet.files.pictures.png import read_picture
from reflet.scene.material import MIRROR, Material, Texture
from reflet.scene.meshes.corners import crease_normals, weld
from reflet.scene.scene import Part

CREASE_DEG = 60.0
"""Edges that turn by less are smooth where a file gives neither normals nor smoothing groups."""


def read_obj(path: str | Path) -> list[Part]:
    """The faces of a file, one part for every object or group and material in it, none marked reflective yet.

    Polygons become fans of triangles. Faces without normals are smoothed over edges that turn by less than 60°, or flat
    where the file says ``s off``. Materials are read from .mtl files: Kd, map_Kd, Ke and the common extensions Pm
    (metallic) and Pr (roughness); faces without a material become mirrors of F0 = 0.65. Raises RefletError where the
    file is missing or damaged.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror}); check the name.") from error
    try:
        return _parts(text, path)
    except (ValueError, IndexError) as error:
        raise RefletError(f"{path} is no valid OBJ file ({error}); export it again.") from error


def _parts(text: str, path: Path) -> list[Part]:
    rows: dict[str, list[str]] = {"v": [], "vt": [], "vn": []}
    faces: dict[tuple[str, str | None, bool], list[tuple[list[str], int, int, int]]] = {}
    materials: dict[str, Material] = {}
    group, flat = path.stem, False
    material: str | None = None
    for line in text.replace("\\\n", " ").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word in rows:
            rows[word].append(rest)
        elif word == "f":
            counts = len(rows["v"]), len(rows["vt"]), len(rows["vn"])  # what negative indices count back from
            faces.setdefault((group, material, flat), []).append((rest.split(), *counts))
        elif word in ("o", "g"):
            group = rest.strip() or path.stem
        elif word == "usemtl":
            material = rest.strip()
        elif word == "s":
            flat = rest.strip() in ("off", "0")
        elif word == "mtllib":
            materials.update(_read_mtl(path.parent / rest.strip()))
    positions, uv, normals = (_table(rows[kind], width, kind) for kind, width in (("v", 3), ("vt", 2), ("vn", 3)))
    missing = {name for _, name, _ in faces if name is not None and name not in materials}
    for name in sorted(missing):
        text = f"{path.name} uses material {name}, which is not there; it is a mirror."
        warnings.warn(text, RefletWarning, stacklevel=3)
    merged: dict[tuple[str, str | None], list[tuple[np.ndarray, ...]]] = {}
    for (group, used, flat), polygons in faces.items():
        corner = _corners(polygons, (len(positions), len(uv), len(normals)))
        at = positions[corner[:, 0]]
        shading = normals[corner[:, 2]] if len(normals) else np.zeros_like(at)
        bare = (corner[:, 2] < 0) | ~shading.any(axis=1)
        if bare.any():
            shading = np.where(bare[:, None], crease_normals(at, 0.0 if flat else CREASE_DEG), shading)
        shading = shading / np.maximum(np.linalg.norm(shading, axis=1, keepdims=True), 1e-30)
        has_uv = bool((corner[:, 1] >= 0).all()) and len(uv) > 0
        texture = uv[corner[:, 1]] * (1.0, -1.0) + (0.0, 1.0) if has_uv else np.full((len(at), 2), np.nan)
        merged.setdefault((group, used), []).append((at, shading, texture))
    split = {group for group, _ in merged if sum(g == group for g, _ in merged) > 1}
    parts = []
    for (group, used), pieces in merged.items():
        at, shading, texture = (np.concatenate(column) for column in zip(*pieces, strict=True))
        mesh = weld(at, shading, texture if np.isfinite(texture).all() else None)
        part_name = f"{group}_{used}" if group in split and used else group
        parts.append(Part(part_name, mesh, materials.get(used or "", MIRROR)))
    return parts


def _table(lines: list[str], width: int, kind: str) -> Float[np.ndarray, "rows width"]:
    """The first ``width`` numbers of every line (a position may bring a weight or a colour along)."""
    table = np.zeros((0, width))
    if lines:
        columns = len(lines[0].split())
        values = np.array(" ".join(lines).split(), dtype=np.float64)
        if columns < width or values.size != columns * len(lines):
            raise ValueError(f"its {kind} lines hold different counts of numbers")
        table = values.reshape(-1, columns)[:, :width]
    return table


def _corners(
    polygons: list[tuple[list[str], int, int, int]], sizes: tuple[int, int, int]
) -> Int[np.ndarray, "corners 3"]:
    """Indices (position, uv, normal; -1 where absent) of the corners of all triangles."""
    flat = [
        [int(field) if field else 0 for field in (*token.split("/"), "", "")[:3]]
        for tokens, *_ in polygons
        for token in tokens
    ]
    index = np.array(flat, dtype=np.int64).reshape(-1, 3)
    length = np.array([len(tokens) for tokens, *_ in polygons])
    so_far = np.repeat(np.array([counts for _, *counts in polygons], dtype=np.int64).reshape(-1, 3), length, axis=0)
    index = np.where(index < 0, index + so_far, index - 1)
    if index.size and ((index >= sizes).any() or (index < -1).any() or index[:, 0].min() < 0):
        raise ValueError("a face refers to a vertex that is not there")
    start = np.cumsum(length) - length
    fans = np.maximum(length - 2, 0)
    first = np.repeat(start, fans)
    step = np.arange(fans.sum()) - np.repeat(np.cumsum(fans) - fans, fans)
    return index[np.column_stack([first, first + step + 1, first + step + 2]).ravel()]


def _statements(path: Path) -> Iterator[tuple[str, str]]:
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        lost = f"The material file {path} cannot be read; its materials are mirrors."
        warnings.warn(lost, RefletWarning, stacklevel=5)
        return
    for line in text.splitlines():
        word, _, rest = line.strip().partition(" ")
        yield word, rest.strip()


def _read_mtl(path: Path) -> dict[str, Material]:
    """Materials by name. A .mtl's colours are taken as linear, as most exporters write them."""
    fields: dict[str, dict] = {}
    current: dict = {}
    for word, rest in _statements(path):
        if word == "newmtl":
            current = fields.setdefault(rest, {"name": rest, "metallic": 0.0})
        elif word == "Kd":
            current["base_color"] = tuple(float(x) for x in rest.split()[:3])
        elif word == "Ke":
            current["emission"] = tuple(float(x) for x in rest.split()[:3])
        elif word == "Pm":
            current["metallic"] = float(rest)
        elif word == "Pr":
            current["perceptual_roughness"] = float(rest)
        elif word == "map_Kd":
            # options such as -s 1 1 1 come before the name; the name is what is left when none is given
            name = rest if not rest.startswith("-") else rest.split()[-1]
            current["base_color_texture_srgb"] = Texture(read_picture(path.parent / name.replace("\\", "/")))
    return {name: Material(**given) for name, given in fields.items()}
