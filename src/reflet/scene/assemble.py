"""From parts as a file holds them to a scene that can be baked: checked, named, told apart."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase

import numpy as np
from jaxtyping import Bool, Float32, UInt32

from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import EnvironmentLight
from reflet.scene.meshes.corners import face_normals
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.touching import touch
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surface_mean import coat_mean, surface_mean

SMOOTH = TRACED_ROUGHNESS
"""What is no metal reflects by default up to this perceptual roughness: smooth paint, varnish and glaze are seen to
mirror. Of what is rougher 4 % and a little more of the light around is spread too wide to be told from diffuse light,
but for lamps: a room's walls and furniture stay as they are."""

LEAST_COAT = 0.1
"""Of the surface (mean share of its clear coat), above which a coat as smooth makes a part reflect as well."""

SURROUNDINGS = 1.75
"""Under an environment all else reflects as well, but for what is so many times as large (boxes' diagonals) as all that
reflects by these rules: a bright sky is seen in leather, wood and cloth, most of all along their surface, while walls
and floors around a model are its surroundings."""

NONE_OF = "none-of "
"""Before a name: such parts do not reflect."""

TOUCHING = 0.04
"""Parts that come closer than this share of the smaller one's diagonal form one object. A lid lies loosely in its rim
(the Newell teapot's leaves 2.4 % of the lid's diagonal), and mirrors so close show each other more than all else."""

_BLOCK = 16384  # rows at a time in float64, so that a large mesh needs no second copy of itself in memory


def assemble(
    parts: Sequence[Part],
    *,
    environment: EnvironmentLight | None = None,
    reflect: Sequence[str] = (),
    lights: Sequence[PunctualLight] = (),
) -> Scene:
    """The scene these parts make, and the ``lights`` among them.

    Parts reflect if they are metallic (mean over the surface at least 1/2), if they are smooth (mean perceptual
    roughness at most 0.2, or that of a clear coat), if they are of glass, or are named in ``reflect``: case does not
    count, ``*`` matches anything, names after `NONE_OF` are left out. Where no part reflects so all do; and where an
    environment lights them and no names choose, all that are not their `SURROUNDINGS` and do not shine. What is matte
    (`Material.reflects`) does so by name only, or where all is. Glass becomes clear, with a RefletWarning where its
    roughness is not 0. Parts that touch form one object. Names are made unique by _2, _3…; zero-area triangles and
    unused vertices are dropped, the former with a RefletWarning.

    Raises RefletError, in one sentence, for geometry that is empty or not finite, broken indices, names that match
    nothing, scenes where nothing can reflect, and scenes without any light.
    """
    checked = [p for p in (_checked(part) for part in parts) if p is not None]
    if not checked:
        raise RefletError("The scene holds no triangles; export it with its meshes.")
    named = _uniquely_named(checked)
    chosen = _chosen(named, reflect, alone=environment is not None)
    finished = tuple(replace(part, reflective=p in chosen) for p, part in enumerate(named))
    if environment is None and not lights and not any(_emits(part) for part in finished):
        raise RefletError(
            "Nothing in the scene gives light; add --environment FILE.hdr, an emissive material or a light."
        )
    return Scene(finished, _objects(finished), environment, tuple(lights))


def _checked(part: Part) -> Part | None:
    mesh = part.mesh
    for what, array in (("positions", mesh.positions), ("normals", mesh.normals), ("texture coordinates", mesh.uv),
                        ("tangents", mesh.tangents), ("colours", mesh.colors),
                        *(("texture coordinates", uv) for uv in mesh.more_uv)):  # fmt: skip
        if array is not None and not np.isfinite(array).all():
            raise RefletError(f"Part {part.name} has {what} that are not finite numbers (NaN or infinite); repair it.")
    if not len(mesh.triangles):
        return None
    if mesh.triangles.max() >= len(mesh.positions):
        raise RefletError(
            f"Part {part.name} refers to vertex {mesh.triangles.max()} of {len(mesh.positions)}; export it again."
        )
    kept = _with_area(mesh)
    if not kept.all():
        dropped = f"Part {part.name} has {np.count_nonzero(~kept)} triangles without area; they are dropped."
        warnings.warn(dropped, RefletWarning, stacklevel=4)
    if not kept.any():
        return None
    triangles = mesh.triangles if kept.all() else mesh.triangles[kept]
    seen = np.zeros(len(mesh.positions), bool)
    seen[triangles] = True
    used: slice | np.ndarray = slice(None)
    if not seen.all():
        used = np.flatnonzero(seen)
        triangles = (np.cumsum(seen, dtype=np.uint32) - np.uint32(1))[triangles]
    positions = np.ascontiguousarray(mesh.positions[used], np.float32)

    def kept_of(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else np.ascontiguousarray(values[used], np.float32)

    clean = Mesh(
        positions=positions,
        normals=_unit_normals(mesh.normals[used], positions, triangles),
        triangles=triangles,
        uv=kept_of(mesh.uv),
        tangents=kept_of(mesh.tangents),
        colors=kept_of(mesh.colors),
        more_uv=tuple(np.ascontiguousarray(uv[used], np.float32) for uv in mesh.more_uv),
    )
    return replace(part, mesh=clean)


def _with_area(mesh: Mesh) -> Bool[np.ndarray, "triangles"]:
    """Which triangles have a plane to speak of: more than (1e-7 of the extent)², the rounding of float32 positions."""
    areas = np.empty(len(mesh.triangles))
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for start in range(0, len(mesh.triangles), _BLOCK):
        corners = mesh.positions[mesh.triangles[start : start + _BLOCK].ravel()]
        areas[start : start + _BLOCK] = face_normals(corners)[1]
        low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
    return areas > (1e-7 * np.linalg.norm(high - low)) ** 2


def _unit_normals(
    normals: Float32[np.ndarray, "vertices 3"],
    positions: Float32[np.ndarray, "vertices 3"],
    triangles: UInt32[np.ndarray, "triangles 3"],
) -> Float32[np.ndarray, "vertices 3"]:
    """Normals of unit length; where they have none, that of the first face at the vertex."""
    unit = np.empty_like(normals)
    flat = np.zeros(len(normals), bool)
    for start in range(0, len(normals), _BLOCK):
        block = slice(start, start + _BLOCK)
        given = normals[block].astype(np.float64)
        length = np.linalg.norm(given, axis=1, keepdims=True)
        flat[block] = length[:, 0] < 1e-6
        unit[block] = given / np.where(length < 1e-6, 1.0, length)
    if flat.any():
        corner = triangles.ravel()
        last_first = np.flatnonzero(flat[corner])[::-1]
        unit[corner[last_first]] = face_normals(positions[triangles[last_first // 3].ravel()])[0]
    return unit


def _uniquely_named(parts: Sequence[Part]) -> list[Part]:
    taken: set[str] = set()
    next_number: dict[str, int] = {}  # thousands of instances may share a name
    named = []
    for part in parts:
        base = part.name.strip() or "part"
        name, number = base, next_number.get(base.lower(), 2)
        while name.lower() in taken:
            name, number = f"{base}_{number}", number + 1
        next_number[base.lower()] = number
        taken.add(name.lower())
        named.append(replace(part, name=name))
    return named


def _chosen(parts: Sequence[Part], reflect: Sequence[str], alone: bool) -> set[int]:
    names = ", ".join(part.name for part in parts[:20]) + (", …" if len(parts) > 20 else "")
    forced: set[int] = set()
    left_out: set[int] = set()
    for word in reflect:
        pattern = word.removeprefix(NONE_OF)
        matches = {p for p, part in enumerate(parts) if fnmatchcase(part.name.lower(), pattern.lower())}
        if not matches:
            raise RefletError(f"No part is named {pattern}; --reflect can name {names}.")
        if pattern == word:
            forced |= matches
        else:
            left_out |= matches
    chosen = set(forced)
    frosted: list[str] = []
    for p, part in enumerate(parts):
        metallic, roughness = surface_mean(part)
        glass = part.material.refraction is not None
        coat, of_coat = coat_mean(part) if part.material.clearcoat > 0.0 else (0.0, 1.0)
        varnished = coat >= LEAST_COAT and of_coat <= SMOOTH
        shiny = (metallic >= 0.5 or roughness <= SMOOTH or varnished) and part.material.reflects
        if (glass or shiny) and p not in left_out:
            chosen.add(p)
        if glass and roughness > 1e-3:
            frosted.append(f"{part.name} ({roughness:.2f})")
    lit = {p for p, part in enumerate(parts) if not part.material.unlit} - left_out - chosen
    others = {p for p in lit if parts[p].material.reflects}
    if not chosen:
        chosen = others or lit
    elif alone and not forced:
        most = SURROUNDINGS * _diagonal([parts[p] for p in chosen])
        chosen |= {p for p in others if _diagonal([parts[p]]) <= most and not _emits(parts[p])}
    if not chosen:
        raise RefletError(f"No part reflects: all are unlit or left out; choose with --reflect NAME from {names}.")
    if frosted:
        listed = ", ".join(frosted[:8]) + (", …" if len(frosted) > 8 else "")
        warnings.warn(f"Baked as clear glass whatever their roughness: {listed}.", RefletWarning, stacklevel=3)
    return chosen


def _diagonal(parts: Sequence[Part]) -> float:
    """Metres, of the box around some parts."""
    lower = np.min([part.mesh.positions.min(axis=0) for part in parts], axis=0)
    upper = np.max([part.mesh.positions.max(axis=0) for part in parts], axis=0)
    return float(np.linalg.norm(np.subtract(upper, lower, dtype=np.float64)))


def _emits(part: Part) -> bool:
    if part.material.unlit:
        return max(part.material.base_color) > 0.0
    texture = part.material.emission_texture_srgb
    return max(part.material.emission) > 0.0 and (texture is None or bool(texture.pixels[..., :3].any()))


def _objects(parts: Sequence[Part]) -> tuple[ReflectiveObject, ...]:
    reflective = [p for p, part in enumerate(parts) if part.reflective]
    group = {p: p for p in reflective}
    low = np.array([parts[p].mesh.positions.min(axis=0) for p in reflective], np.float64)
    high = np.array([parts[p].mesh.positions.max(axis=0) for p in reflective], np.float64)
    diagonal = np.linalg.norm(high - low, axis=-1)
    for i, p in enumerate(reflective):
        tolerances = TOUCHING * np.minimum(diagonal[i], diagonal[i + 1 :])
        # of thousands of parts only those whose boxes come close are looked at
        gap = np.maximum(low[i + 1 :] - high[i], low[i] - high[i + 1 :]).max(axis=-1)
        for near in np.flatnonzero(gap <= 1.01 * tolerances).tolist():
            q, tolerance = reflective[i + 1 + near], float(tolerances[near])
            if group[p] != group[q] and touch(parts[p].mesh, parts[q].mesh, tolerance):
                group = {r: group[p] if g == group[q] else g for r, g in group.items()}
    objects = []
    for first in dict.fromkeys(group.values()):
        members = tuple(p for p in reflective if group[p] == first)
        objects.append(ReflectiveObject("+".join(parts[p].name for p in members[:4]), members))
    return tuple(objects)
