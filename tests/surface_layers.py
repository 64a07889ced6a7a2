"""Surface layers made by hand, and how they are looked up, in NumPy."""

import numpy as np

from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer


def random_surface(
    scene: Scene, parts: tuple[int, ...], sites: int = 50, seed: int = 5, side: int = SIDES[0]
) -> SurfaceLayer:
    """Maps on all triangles of some parts, of resolutions 1 to 3, whose samples belong to any of the sites; radiance
    within ±1 and alpha in [-1, 1]."""
    rng = np.random.default_rng(seed)
    of_part = np.repeat(np.arange(len(scene.parts)), np.diff(scene.triangle_offsets))
    sides = np.array([1 + part.material.double_sided for part in scene.parts])[of_part]
    resolution = np.where(np.isin(of_part, parts), 1 + np.arange(len(of_part)) % 3, 0).astype(np.uint32)
    counts = np.where(resolution > 0, (resolution + 1) * (resolution + 2) // 2 * sides, 0)
    return SurfaceLayer(
        resolution=resolution,
        offset=(np.cumsum(counts) - counts).astype(np.uint32),
        site=rng.integers(0, sites, int(counts.sum())).astype(np.uint32),
        light=rng.uniform(-1.0, 1.0, (sites, side**2, 4)).astype(np.float16),
    )


def looked_up(surface: SurfaceLayer, triangle: np.ndarray, b: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
    """Radiance and alpha on triangles' fronts at barycentric coordinates of their second and third corner."""
    r, first = surface.resolution[triangle].astype(int), surface.offset[triangle].astype(int)
    x, y = b.T * r
    i = np.minimum(x.astype(int), r - 1)
    j = np.minimum(y.astype(int), r - 1 - i)
    fx, fy = x - i, y - j
    upper = (fx + fy > 1.0) & (i + j + 1 < r)
    corners = [(i + upper, j + upper), (i + 1, j), (i, j + 1)]
    along, across = np.where(upper, 1.0 - fy, fx), np.where(upper, 1.0 - fx, fy)
    uv = Octahedral().uv_from_direction(mirrored)[1] * surface.side - 0.5
    low = np.floor(uv).astype(int)
    fraction = uv - low
    out = np.zeros((len(triangle), 4))
    for (a, c), weight in zip(corners, (1.0 - along - across, along, across), strict=True):
        site = surface.site[first + a * (2 * r + 3 - a) // 2 + c]
        for column in (0, 1):
            for row in (0, 1):
                share = np.prod(np.where((column, row), fraction, 1.0 - fraction), axis=-1)
                texel = _texel(*(low + (column, row)).T, surface.side)
                out += (weight * share)[:, None] * surface.light[site, texel].astype(float)
    return out


def _texel(column: np.ndarray, row: np.ndarray, side: int) -> np.ndarray:
    """Over an edge the octahedron goes on mirrored at that edge's middle."""
    inside_column, inside_row = np.clip(column, 0, side - 1), np.clip(row, 0, side - 1)
    folded_column = np.where(row != inside_row, side - 1 - inside_column, inside_column)
    folded_row = np.where(column != inside_column, side - 1 - inside_row, inside_row)
    return folded_row * side + folded_column
