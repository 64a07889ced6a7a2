"""Where irradiance is sampled: a grid of mesh colours on every triangle that shows diffuse light [Yuksel10]."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Int32, UInt32
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reflet.scene.scene import Part, Scene

FINEST = 512  # most samples along a triangle's edge
ALIKE_POSITION = 1e-5  # samples closer than this share of the scene's size,
ALIKE_NORMAL = 0.1  # whose unit normals differ by less than this in every component, are one


@dataclass(frozen=True)
class SampleSites:
    """All samples of an `IrradianceMap`, and the sites that coincident ones share.

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
    """Samples on all triangles that show diffuse light, about ``budget`` of them in all.

    Their spacing grows with the distance from the reflective objects. Where triangles alone are more than the budget
    allows, each has one sample at each of its corners, as triangles of reflective parts always have. Both sides of
    double-sided triangles are sampled.
    """
    corners = np.concatenate([p.mesh.positions[p.mesh.triangles] for p in scene.parts]).astype(np.float64)
    normals = np.concatenate([p.mesh.normals[p.mesh.triangles] for p in scene.parts]).astype(np.float64)
    sizes = [len(p.mesh.triangles) for p in scene.parts]
    shows = np.repeat([_shows_diffuse(part) for part in scene.parts], sizes)
    mirror = np.repeat([owner >= 0 for owner in scene.object_of_part], sizes)
    sides = np.repeat([1 + part.material.double_sided for part in scene.parts], sizes)
    resolution = _resolutions(corners, shows, mirror, sides, budget)

    grid = np.where(resolution > 0, (resolution + 1) * (resolution + 2) // 2, 0)
    offset = np.concatenate([[0], np.cumsum(grid * sides)])
    triangle = np.repeat(np.arange(len(resolution)), grid * sides)
    entry = np.arange(offset[-1]) - offset[triangle]
    back = entry >= grid[triangle]
    i, j = _grid_point(entry - back * grid[triangle], resolution[triangle])

    r = resolution[triangle]
    weights = np.stack([r - i - j, i, j], -1) / r[:, None]
    on_edge = (i == 0) | (j == 0) | (i + j == r)
    position = np.einsum("sk,skc->sc", weights[on_edge], corners[triangle[on_edge]])
    normal = np.einsum("sk,skc->sc", weights[on_edge], normals[triangle[on_edge]])
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    normal *= np.where(back[on_edge], -1.0, 1.0)[:, None]
    site = np.arange(len(triangle))
    site[on_edge] = site[on_edge][_first_alike(position, normal)]
    _, site = np.unique(site, return_inverse=True)
    members = np.argsort(site, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(site))])
    return SampleSites(
        resolution=resolution.astype(np.uint32),
        offset=offset[:-1].astype(np.uint32),
        triangle=triangle.astype(np.uint32),
        i=i.astype(np.uint32),
        j=j.astype(np.uint32),
        back=back,
        site=site.astype(np.int32),
        members=members.astype(np.uint32),
        starts=starts.astype(np.uint32),
    )


def _shows_diffuse(part: Part) -> bool:
    material = part.material
    black = not any(material.base_color)
    mirror_only = part.reflective and material.metallic >= 1.0 and material.metallic_roughness_texture is None
    return not black and not mirror_only


def _resolutions(
    corners: Float[np.ndarray, "triangles 3 3"],
    shows: Bool[np.ndarray, "triangles"],
    mirror: Bool[np.ndarray, "triangles"],
    sides: Int[np.ndarray, "triangles"],
    budget: int,
) -> Int[np.ndarray, "triangles"]:
    """Samples along each triangle's edge: its longest edge over a spacing that keeps the budget."""
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(-1)
    ruler = np.ones(len(corners))
    if mirror.any():
        lower, upper = corners[mirror].min((0, 1)), corners[mirror].max((0, 1))
        gap = np.maximum(np.maximum(lower - corners.max(1), corners.min(1) - upper), 0.0)
        ruler = np.maximum(np.linalg.norm(gap, axis=-1), np.linalg.norm(upper - lower) / 2.0)

    def with_scale(scale: float) -> np.ndarray:
        fine = np.clip(np.ceil(edge / ruler * scale), 1, FINEST).astype(np.int64)
        return np.where(shows, np.where(mirror, 1, fine), 0)

    def count(resolution: np.ndarray) -> int:
        return int(((resolution + 1) * (resolution + 2) // 2 * sides)[resolution > 0].sum())

    low, high = 1e-6, 1e6
    for _ in range(60):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if count(with_scale(middle)) <= budget else (low, middle)
    return with_scale(low)


def _grid_point(entry: np.ndarray, resolution: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(i, j) of an entry of its triangle's grid: the inverse of entry = i·(2R + 3 - i)/2 + j."""
    b = 2.0 * resolution + 3.0
    i = np.floor((b - np.sqrt(b * b - 8.0 * entry)) / 2.0).astype(np.int64)
    i += (i + 1) * (2 * resolution + 2 - i) // 2 <= entry  # rounding of the root, either way
    i -= i * (2 * resolution + 3 - i) // 2 > entry
    return i, entry - i * (2 * resolution + 3 - i) // 2


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
