"""A scene as the compact form holds it: rounded to grids, its triangles and vertices in the order that codes best.

Everything that counts triangles or their corners is carried along, and the tree is that of the rounded meshes: the
stored PEM is whole in itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import meshopt
import numpy as np
from jaxtyping import Bool, Float32, Int, Int64, UInt32

from reflet.pem.mesh_codes import as_decoded, on_grid
from reflet.pem.turned_colours import turned_colours
from reflet.scene.bvh.build import build_bvh
from reflet.scene.bvh.bvh import Bvh
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SurfaceLayer

POSITION_BITS = 16
"""Positions lie on a grid that divides the extent of all that reflects into at least so many bits: a picture that the
object fills shows a hundredth of a step a pixel."""

LEAST_BITS = 10  # of a part's own extent, however small it is
COLOR_BITS = 14  # of a vertex colour: errors are a tenth of a step of 8 bits where sRGB has its finest
UV_BITS = 16  # of a repeat: a sixteenth of a texel of a picture of 4096


@dataclass(frozen=True)
class CompactPem:
    """What of a PEM counts triangles."""

    scene: Scene
    irradiance: IrradianceMap
    surface: SurfaceLayer | None
    on_hull: Bool[np.ndarray, "triangles"]
    bvh: Bvh | None


def compacted(
    scene: Scene,
    irradiance: IrradianceMap,
    on_hull: Bool[np.ndarray, "triangles"],
    bvh: Bvh | None,
    *,
    traced: bool,
    surface: SurfaceLayer | None = None,
) -> CompactPem:
    """The scene rounded and reordered, with what belongs to its triangles.

    All parts share one grid, so that what met still meets; parts far smaller than the mirrors have a finer one that
    holds it, parts too far from the origin for 24 bits a coarser one. Texture coordinates and tangents stay where a
    texture needs them. Triangles of the tree are in the order of its leaves, part by part, if rays are ``traced`` (it
    is built if it is not given); others as a GPU's vertex cache likes them. Corners may be turned around.
    """
    rounded = replace(scene, parts=tuple(map(_rounded, scene.parts, _exponents(scene))))
    rank = np.full(scene.triangle_offsets[-1], -1)
    if traced:
        bvh = bvh or build_bvh(rounded, on_hull)
        rank[bvh.order] = np.arange(len(bvh.order))
    parts, orders, turns = [], [], []
    for number, part in enumerate(rounded.parts):
        first, end = scene.triangle_offsets[number], scene.triangle_offsets[number + 1]
        in_tree = bool((rank[first:end] >= 0).any())  # all of them
        order = np.argsort(rank[first:end]) if in_tree else _cached_order(part.mesh.triangles)
        mesh, turn = _reordered(part.mesh, order)
        parts.append(replace(part, mesh=mesh))
        orders.append(order + first)
        turns.append(turn)
    order, turn = np.concatenate(orders), np.concatenate(turns)
    sides = np.repeat([1 + part.material.double_sided for part in scene.parts], np.diff(scene.triangle_offsets))
    if bvh is not None and traced:
        place = np.empty(len(order), np.uint32)
        place[order] = np.arange(len(order))
        bvh = replace(bvh, order=place[bvh.order])
    return CompactPem(
        replace(rounded, parts=tuple(parts)),
        _turned_irradiance(irradiance, sides, order, turn),
        surface and _turned_surface(surface, sides, order, turn),
        on_hull[order],
        bvh if traced else None,
    )


def _turned_irradiance(
    irradiance: IrradianceMap,
    sides: Int[np.ndarray, "triangles"],
    order: Int[np.ndarray, "triangles"],
    turn: Int[np.ndarray, "triangles"],
) -> IrradianceMap:
    grids = irradiance.resolution, irradiance.offset
    more = {"gradient": irradiance.gradient, "visibility": irradiance.visibility}
    return IrradianceMap(
        *turned_colours(*grids, irradiance.radiosity, sides, order, turn),
        **{name: turned_colours(*grids, of, sides, order, turn)[2] for name, of in more.items() if len(of)},
    )


def _turned_surface(
    surface: SurfaceLayer,
    sides: Int[np.ndarray, "triangles"],
    order: Int[np.ndarray, "triangles"],
    turn: Int[np.ndarray, "triangles"],
) -> SurfaceLayer:
    """Its sites in the order in which triangles now come to them: neighbours lie together, numbers grow slowly."""
    resolution, offset, site = turned_colours(
        surface.resolution, surface.offset, surface.site[:, None], sides, order, turn
    )
    _, first, number = np.unique(site[:, 0], return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.uint32)
    rank[np.argsort(first)] = np.arange(len(first))
    light = np.empty((len(first), *surface.light.shape[1:]), np.float16)
    light[rank] = surface.light[site[first, 0]]
    return SurfaceLayer(resolution, offset, rank[number], light)


def _exponents(scene: Scene) -> list[int]:
    """Of two, the step of each part's grid."""
    boxes = np.array([[part.mesh.positions.min(axis=0), part.mesh.positions.max(axis=0)] for part in scene.parts])
    extents = np.maximum(np.ptp(boxes, axis=1).max(axis=-1).astype(np.float64), 1e-30)
    mirrors = boxes[[part.reflective for part in scene.parts]]
    common = np.inf if not len(mirrors) else float((mirrors[:, 1].max(axis=0) - mirrors[:, 0].min(axis=0)).max())
    common = common if 0.0 < common < np.inf else float(extents.max())
    wanted = np.minimum(np.log2(common) - POSITION_BITS, np.log2(extents) - LEAST_BITS)
    held = np.log2(np.maximum(np.abs(boxes).max(axis=(1, 2)).astype(np.float64), 1e-30)) - 22.0
    return np.ceil(np.maximum(np.floor(wanted), held)).astype(int).tolist()


def _rounded(part: Part, exponent: int) -> Part:
    material, mesh = part.material, part.mesh
    textured = any(texture is not None for texture in material.textures.values())
    return replace(
        part,
        mesh=replace(
            mesh,
            positions=on_grid(mesh.positions, exponent),
            uv=_uv_on_grid(mesh.uv) if textured and mesh.uv is not None else None,
            tangents=mesh.tangents if material.bends_normals else None,
            colors=None if mesh.colors is None else on_grid(mesh.colors, -COLOR_BITS),
            more_uv=tuple(map(_uv_on_grid, mesh.more_uv)) if textured else (),
        ),
    )


def _uv_on_grid(uv: Float32[np.ndarray, "vertices 2"]) -> Float32[np.ndarray, "vertices 2"]:
    largest = float(np.abs(uv).max(initial=0.0))
    return on_grid(uv, max(-UV_BITS, int(np.ceil(np.log2(max(largest, 1.0)))) - 22))


def _cached_order(triangles: UInt32[np.ndarray, "triangles 3"]) -> Int64[np.ndarray, "triangles"]:
    """The triangles' numbers in an order that finds most corners among those just used."""
    indices, place, _ = meshopt.reorder_mesh(np.ascontiguousarray(triangles).reshape(-1), True, True)
    # the library tells the triangles themselves, not their numbers
    ours, theirs = (np.lexsort(rows.T) for rows in (place[triangles], indices.reshape(-1, 3)))
    order = np.empty(len(triangles), np.int64)
    order[theirs] = ours
    return order


def _reordered(mesh: Mesh, order: Int[np.ndarray, "triangles"]) -> tuple[Mesh, Int64[np.ndarray, "triangles"]]:
    """The mesh with its triangles in that order and its vertices in that of their first use, without unused ones; and
    how its corners were turned around: corner c was corner (c + turn) modulo 3."""
    triangles = mesh.triangles[order]
    used, first = np.unique(triangles.reshape(-1), return_index=True)
    kept = used[np.argsort(first)]
    place = np.zeros(len(mesh.positions), np.uint32)
    place[kept] = np.arange(len(kept))
    renumbered = mesh.picked(kept, place[triangles])
    coded = as_decoded(renumbered)
    turned: Sequence[np.ndarray] = [
        (np.roll(renumbered.triangles, -turn, axis=1) == coded).all(axis=1) for turn in range(3)
    ]
    return replace(renumbered, triangles=coded), np.argmax(turned, axis=0)
