"""Where light is sampled on surfaces: a grid of mesh colours on every triangle that shows it [Yuksel10]."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Int32, UInt32
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reflet.scene.roughness import is_rough
from reflet.scene.scene import Part, Scene

FINEST = 512  # most samples along a triangle's edge
ALIKE_POSITION = 1e-5  # samples closer than this share of the scene's size,
ALIKE_NORMAL = 0.1  # whose unit normals differ by less than this in every component, are one
MOST_SITES = 4  # times the budget: what triangles smaller than a picture's pixels may have of sites
_NORMAL_STEPS = 2  # classes of normals that share a site, from 0 to 1 in every component
_TRIALS = 20  # of a cell size; mostly three do


@dataclass(frozen=True)
class SampleSites:
    """All samples of mesh colours (`reflet.scene.surfaces.irradiance`), and the sites that coincident ones share.

    Sample k lies on ``triangle[k]`` at the grid point (``i[k]``, ``j[k]``), on its back where ``back[k]``. It belongs
    to site ``site[k]``; the members of site s are ``members[starts[s]:starts[s + 1]]``.
    """

    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    triangle: UInt32[np.ndarray, "samples"]
    i: UInt32[np.ndarray, "samples"]
    j: UInt32[np.ndarray, "samples"]
    back: Bool[np.ndarray, "samples"]
    site: Int32[np.ndarray, "samples"]
    members: UInt32[np.ndarray, "samples"]
    starts: UInt32[np.ndarray, "bounds"]


def sample_sites(scene: Scene, budget: int) -> SampleSites:
    """Samples on all triangles that show diffuse light, and, where there are lights without extent, on those of rough
    parts, about ``budget`` of them in all.

    Their spacing grows with the distance from the reflective objects, on a floor with its square. Both sides of
    double-sided triangles are sampled. Triangles smaller than the spacing have one sample at each of their corners, and
    triangles that meet share them. Where there are more than `MOST_SITES` budgets of such corners, neighbours in cells
    of space share a site, the larger the farther from the reflective objects, so that the number of sites, and with it
    the rays, is bounded however many triangles there are. About 120 bytes a triangle that shows diffuse light.
    """
    lit = bool(scene.lights)  # rough parts show these, where they are seen
    shown = [number for number, part in enumerate(scene.parts) if _shows_diffuse(part) or (lit and is_rough(part))]
    return sites_of_parts(scene, shown, budget, MOST_SITES * budget)


def sites_of_parts(
    scene: Scene, parts: Collection[int], budget: int, most: int, *, shared: bool = False
) -> SampleSites:
    """The same on the parts of some indices, with at most about ``most`` sites on corners and edges.

    The budget is of samples, or, ``shared``, of sites on meshes whose triangles share theirs.
    """
    of_part = np.isin(np.arange(len(scene.parts)), list(parts))
    shows = np.repeat(of_part, np.diff(scene.triangle_offsets))
    shown = np.flatnonzero(shows)
    corners, normals, vertices, sides = _shown(scene, of_part)
    ruler = _ruler(corners, scene)
    if scene.floor:  # what a model hides of the sky falls with the square of the distance
        least = ruler.min(initial=np.inf)
        begin, end = (scene.triangle_offsets[part] for part in (scene.floor[0], scene.floor[-1] + 1))
        ruler *= np.where((shown >= begin) & (shown < end), ruler / least, 1.0)
    fine = _resolutions(corners, sides, ruler, budget, shared)

    grid = (fine + 1) * (fine + 2) // 2
    offset = np.concatenate([[0], np.cumsum(grid * sides)])
    own = np.repeat(np.arange(len(shown), dtype=np.int32), grid * sides)  # of the shown triangles
    entry = np.arange(offset[-1], dtype=np.int32) - offset[own].astype(np.int32)
    back = entry >= grid[own]
    i, j = _grid_point(entry - back * grid[own], fine[own])
    site = _sites(corners, normals, vertices, ruler, fine, own, i, j, back, most)

    samples = np.arange(len(site), dtype=np.int32)
    by_site = coo_matrix(
        (np.ones(len(site), bool), (site, samples)), (int(site.max(initial=-1)) + 1, len(site))
    ).tocsr()
    resolution, first = np.zeros(len(shows), np.uint32), np.zeros(len(shows), np.uint32)
    resolution[shown] = fine
    counts = np.zeros(len(shows), np.int64)
    counts[shown] = grid * sides
    first[1:] = np.cumsum(counts)[:-1]
    return SampleSites(
        resolution=resolution,
        offset=first,
        triangle=shown.astype(np.uint32)[own],
        i=i.astype(np.uint32),
        j=j.astype(np.uint32),
        back=back,
        site=site.astype(np.int32),
        members=by_site.indices.astype(np.uint32),
        starts=by_site.indptr.astype(np.uint32),
    )


def _shown(scene: Scene, of_part: Bool[np.ndarray, "parts"]) -> tuple[np.ndarray, ...]:
    """Of all triangles of some parts: corners, normals there, the scene's vertices (numbered through all parts), and
    how many sides are sampled."""
    columns: list[tuple[np.ndarray, ...]] = []
    first = 0
    for part, shown in zip(scene.parts, of_part, strict=True):
        mesh, count = part.mesh, len(part.mesh.triangles)
        if shown:
            corners, normals = mesh.positions[mesh.triangles], mesh.normals[mesh.triangles]
            sides = np.full(count, 1 + part.material.double_sided, np.int32)
            columns.append((corners, normals, mesh.triangles.astype(np.int64) + first, sides))
        first += len(mesh.positions)
    if not columns:
        nothing = np.zeros((0, 3, 3), np.float32)
        return nothing, nothing, np.zeros((0, 3), np.int64), np.zeros(0, np.int32)
    return tuple(np.concatenate(column) for column in zip(*columns, strict=True))


def _sites(
    corners: Float[np.ndarray, "triangles 3 3"],
    normals: Float[np.ndarray, "triangles 3 3"],
    vertices: Int[np.ndarray, "triangles 3"],
    ruler: Float[np.ndarray, "triangles"],
    resolution: Int[np.ndarray, "triangles"],
    triangle: Int[np.ndarray, "samples"],
    i: Int[np.ndarray, "samples"],
    j: Int[np.ndarray, "samples"],
    back: Bool[np.ndarray, "samples"],
    most: int,
) -> Int[np.ndarray, "samples"]:
    """The site of each sample, numbered in the order of their first samples. At most about ``most`` sites hold the
    samples on edges and corners of triangles."""
    r = resolution[triangle]
    site = np.arange(len(triangle))
    # samples at one vertex are one
    at_corner = np.flatnonzero((i == r) | (j == r) | ((i == 0) & (j == 0)))
    corner = (i[at_corner] == r[at_corner]) + 2 * (j[at_corner] == r[at_corner])
    vertex = 2 * vertices[triangle[at_corner], corner] + back[at_corner]
    first = np.zeros(int(vertex.max(initial=0)) + 1, np.int64)
    first[vertex[::-1]] = at_corner[::-1]
    site[at_corner] = first[vertex]
    # and those alike, of other triangles
    k = np.flatnonzero(((i == 0) | (j == 0) | (i + j == r)) & (site == np.arange(len(site))))
    t = triangle[k]
    weights = np.stack([r[k] - i[k] - j[k], i[k], j[k]], -1) / r[k, None]
    position = np.einsum("sk,skc->sc", weights, corners[t], dtype=np.float64)
    normal = np.einsum("sk,skc->sc", weights, normals[t], dtype=np.float64)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    normal *= np.where(back[k], -1.0, 1.0)[:, None]
    alike = _first_alike(position, normal) if len(k) <= most else _first_near(position, normal, ruler[t], most)
    of_sample = np.arange(len(site))
    of_sample[k] = k[alike]
    chosen = of_sample[site]
    used = np.zeros(len(site), bool)
    used[chosen] = True
    return (np.cumsum(used) - 1)[chosen]


def _shows_diffuse(part: Part) -> bool:
    material = part.material
    black = material.unlit or not any(material.base_color)
    mirror_only = part.reflective and material.metallic >= 1.0 and material.metallic_roughness_texture is None
    if part.reflective and material.refraction is not None:
        mirror_only = material.refraction.transmission >= 1.0
    return not black and not mirror_only


def _ruler(corners: Float[np.ndarray, "triangles 3 3"], scene: Scene) -> Float[np.ndarray, "triangles"]:
    """What spacing is measured in: the distance from the box around all reflective objects, at least half its
    diagonal; 1 where nothing reflects."""
    reflective = [
        part.mesh.positions[part.mesh.triangles]
        for number, part in enumerate(scene.parts)
        if part.reflective and number not in scene.floor
    ]
    if not reflective:
        return np.ones(len(corners))
    lower = np.min([mesh.min((0, 1)) for mesh in reflective], axis=0).astype(np.float64)
    upper = np.max([mesh.max((0, 1)) for mesh in reflective], axis=0).astype(np.float64)
    gap = np.maximum(np.maximum(lower - corners.max(1), corners.min(1) - upper), 0.0)
    return np.maximum(np.linalg.norm(gap, axis=-1), np.linalg.norm(upper - lower) / 2.0)


def _resolutions(
    corners: Float[np.ndarray, "triangles 3 3"],
    sides: Int[np.ndarray, "triangles"],
    ruler: Float[np.ndarray, "triangles"],
    budget: int,
    shared: bool,
) -> Int[np.ndarray, "triangles"]:
    """Samples along each triangle's edge: its longest edge over a spacing that keeps the budget.

    Where samples at the corners alone would spend the budget, it is all for the triangles that have more than those.
    In a large mesh R²/2 are a triangle's own: half of each edge's, a sixth of each corner's.
    """
    edges = corners - np.roll(corners, 1, axis=1)
    edge = np.sqrt(np.einsum("tki,tki->tk", edges, edges, dtype=np.float64).max(-1))
    ratio = edge / ruler

    def held(resolution: np.ndarray) -> np.ndarray:
        return resolution**2 / 2.0 if shared else (resolution + 1) * (resolution + 2) / 2.0

    spent = float((held(np.ones(1)) * sides).sum()) > budget
    # more triangles than that cannot have more samples than their corners'
    largest = np.argpartition(ratio, -budget)[-budget:] if spent and len(ratio) > budget else slice(None)
    large, large_sides = ratio[largest], sides[largest]

    def with_scale(ratio: np.ndarray, scale: float) -> np.ndarray:
        return np.clip(np.ceil(ratio * scale), 1, FINEST).astype(np.int64)

    def count(scale: float) -> float:
        resolution = with_scale(large, scale)
        samples = held(resolution) * large_sides
        return float(samples[resolution > 1].sum() if spent else samples.sum())

    low, high = 1e-6, 1e6
    for _ in range(60):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if count(middle) <= budget else (low, middle)
    return with_scale(ratio, low)


def _grid_point(entry: np.ndarray, resolution: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(i, j) of an entry of its triangle's grid: the inverse of entry = i·(2R + 3 - i)/2 + j."""
    b = 2.0 * resolution + 3.0
    i = np.floor((b - np.sqrt(b * b - 8.0 * entry)) / 2.0).astype(np.int64)
    i += (i + 1) * (2 * resolution + 2 - i) // 2 <= entry  # rounding of the root, either way
    i -= i * (2 * resolution + 3 - i) // 2 > entry
    return i, entry - i * (2 * resolution + 3 - i) // 2


def _first_near(position: np.ndarray, normal: np.ndarray, ruler: np.ndarray, most: int) -> np.ndarray:
    """For each sample the first one in its cell: of space, as large as makes about ``most`` of them in all and in
    proportion to the ``ruler``, rounded to powers of two; and of normals."""
    _, level = np.frexp(ruler)
    level -= level.min()
    centred = (position - 0.5 * (position.min(axis=0) + position.max(axis=0))) / np.ldexp(1.0, level)[:, None]
    facing = np.rint(normal * _NORMAL_STEPS).astype(np.int64) + _NORMAL_STEPS
    kind = level.astype(np.int64)
    for axis in range(3):
        kind = kind * (2 * _NORMAL_STEPS + 1) + facing[:, axis]
    size = max(float(np.abs(centred).max()), 1e-30) / np.sqrt(most)
    for _ in range(_TRIALS):
        cell = np.floor(centred / size).astype(np.int64)
        cell -= cell.min(axis=0)
        reach = cell.max(axis=0) + 1
        key = ((kind * reach[0] + cell[:, 0]) * reach[1] + cell[:, 1]) * reach[2] + cell[:, 2]
        _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
        if 0.8 * most <= len(first) <= most:
            break
        size *= np.sqrt(len(first) / (0.9 * most))
    return first[inverse]


def _first_alike(position: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """For each sample the first one that is alike, over chains of alike samples."""
    if not len(position):
        return np.zeros(0, np.int64)
    extent = max(float(np.ptp(position, axis=0).max()), 1e-12)
    keys = np.concatenate([position / (ALIKE_POSITION * extent), normal / ALIKE_NORMAL], -1)
    pairs = cKDTree(keys).query_pairs(1.0, p=np.inf, output_type="ndarray")
    n = len(keys)
    graph = coo_matrix((np.ones(len(pairs), np.bool_), (pairs[:, 0], pairs[:, 1])), (n, n))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return first[label]
