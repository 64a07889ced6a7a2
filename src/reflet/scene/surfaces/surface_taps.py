"""Where a surface layer is looked up: twelve texels, four of each of three sites' maps. Twin of surface_light.wgsl."""

import numpy as np
from jaxtyping import Bool, Float, Float32, Int64, UInt32

from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.scene.scene import Scene
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.scene.surfaces.surface_layer import SurfaceLayer

TAPS = 12
_ACROSS = ((0, 0), (1, 0), (0, 1), (1, 1))  # columns and rows of a bilinear lookup


def surface_taps(
    layer: SurfaceLayer,
    triangle: UInt32[np.ndarray, "n"],
    b: Float[np.ndarray, "n 2"],
    back: Bool[np.ndarray, "n"],
    mirrored: Float[np.ndarray, "n 3"],
) -> tuple[Int64[np.ndarray, "n 12"], Float32[np.ndarray, "n 12"]]:
    """Texels, counted through all sites' maps, and their weights, which add up to 1: of lookups on the triangles'
    fronts or backs, at barycentric coordinates ``b`` of their second and third vertex, along unit directions.

    Every triangle has a resolution of at least 1.
    """
    sample, share = _cell(layer, triangle, b, back)
    site = layer.site[sample].astype(np.int64)
    uv = Octahedral().uv_from_direction(mirrored.astype(np.float64))[1] * layer.side - 0.5
    low = np.floor(uv).astype(np.int64)
    along, across = (uv - low).T
    texel = np.stack([_texel(low[:, 0] + column, low[:, 1] + row, layer.side) for column, row in _ACROSS], -1)
    weight = np.stack([(1 - along) * (1 - across), along * (1 - across), (1 - along) * across, along * across], -1)
    texels = site[:, :, None] * layer.side**2 + texel[:, None]
    weights = share[:, :, None] * weight[:, None]
    return texels.reshape(-1, TAPS), weights.reshape(-1, TAPS).astype(np.float32)


def seen_from(
    scene: Scene, gbuffer: GBuffer, eye: tuple[float, float, float]
) -> tuple[Float[np.ndarray, "samples 2"], Bool[np.ndarray, "samples"]]:
    """Of a G-buffer's sub-samples the barycentric coordinates of their triangles' second and third vertex, and whether
    they see backs."""
    part = np.searchsorted(scene.triangle_offsets, gbuffer.triangle, side="right") - 1
    corners = np.empty((len(part), 3, 3))
    for number in np.unique(part):
        own, mesh = part == number, scene.parts[number].mesh
        corners[own] = mesh.positions[mesh.triangles[gbuffer.triangle[own] - scene.triangle_offsets[number]]]
    (lookups,) = gbuffer.lookups
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    at = lookups.position[0] - corners[:, 0]
    xx, xy, yy, ax, ay = (
        np.einsum("nc,nc->n", u, v)
        for u, v in ((first, first), (first, second), (second, second), (at, first), (at, second))
    )
    area = np.maximum(xx * yy - xy * xy, np.finfo(np.float64).tiny)
    b = np.stack([(yy * ax - xy * ay) / area, (xx * ay - xy * ax) / area], -1)
    back = np.einsum("nc,nc->n", np.cross(first, second), np.asarray(eye) - corners[:, 0]) < 0.0
    return b, back


def _cell(
    layer: SurfaceLayer, triangle: UInt32[np.ndarray, "n"], b: Float[np.ndarray, "n 2"], back: Bool[np.ndarray, "n"]
) -> tuple[Int64[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """Three samples of each triangle's grid, and their weights. Twin of mesh_colours.wgsl."""
    r = layer.resolution[triangle].astype(np.int64)
    first = layer.offset[triangle].astype(np.int64) + np.where(back, (r + 1) * (r + 2) // 2, 0)
    inside = np.maximum(b, 0.0)
    inside /= np.maximum(inside.sum(1, keepdims=True), 1.0)
    at = inside * r[:, None]
    i = np.minimum(at[:, 0].astype(np.int64), r - 1)
    j = np.minimum(at[:, 1].astype(np.int64), r - 1 - i)
    x, y = at[:, 0] - i, at[:, 1] - j
    corner = first + i * (2 * r + 3 - i) // 2 + j
    right = corner + r + 1 - i
    upper = (x + y > 1.0) & (i + j + 2 <= r)
    samples = np.stack([np.where(upper, right + 1, corner), right, corner + 1], -1)
    shares = [np.where(upper, x + y - 1.0, 1.0 - x - y), np.where(upper, 1.0 - y, x), np.where(upper, 1.0 - x, y)]
    return samples, np.stack(shares, -1)


def _texel(column: Int64[np.ndarray, "n"], row: Int64[np.ndarray, "n"], side: int) -> Int64[np.ndarray, "n"]:
    """A texel of a map; over an edge the octahedron goes on mirrored at that edge's middle."""
    inside_column, inside_row = np.clip(column, 0, side - 1), np.clip(row, 0, side - 1)
    folded_column = np.where(row != inside_row, side - 1 - inside_column, inside_column)
    folded_row = np.where(column != inside_column, side - 1 - inside_row, inside_row)
    return folded_row * side + folded_column
