"""The exact path: from visible triangles to mirrored rays.

Everything about a sub-sample follows from its triangle and the camera by intersecting view rays with the triangle's
plane, so that tracer, G-buffer and shader agree whatever rasterizer found the triangle (CONVENTIONS.md, "Surfaces").
"""

from dataclasses import dataclass
from math import floor, sqrt

import numpy as np
from jaxtyping import Float32, Int32, Int64, UInt8, UInt32
from numba import njit, prange

from reflet.envmap.lod import lobe_spread
from reflet.reflectance.materials.material import dfg_table
from reflet.scene.material import WRAPS, Texture
from reflet.scene.roughness import is_rough
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.gbuffer import GBuffer, Lookups
from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.sample_pattern import sample_positions

NEIGHBOUR_STEP = 0.25  # pixels from a sub-sample to its neighbours: the distance of 16 sub-samples from each other
FARTHEST_BARYCENTRIC = 20.0  # neighbours on a plane seen edge-on are cut off here
SMALLEST_CLIMB = 0.001  # the least r·ng of a mirrored ray


def gbuffer_from_visibility(scene: Scene, visibility: Visibility) -> GBuffer:
    """The G-buffer of a picture: for each visible sub-sample the mirrored ray and those of its two neighbours.

    Those of rough surfaces lean towards their normals by as much as the sub-sample's own lobe does. Rows are ordered by
    pixel, then part. Computed in float64, 88 bytes a sub-sample are kept. Sub-samples must be
    ordered as `Visibility` says.
    """
    camera = visibility.camera
    part = np.searchsorted(scene.triangle_offsets, visibility.triangle, side="right").astype(np.int32) - 1
    # By pixel, then part; sub-samples of one pixel that see different parts come interleaved.
    row_key = visibility.pixel.astype(np.int64) * len(scene.parts) + part
    order = np.argsort(row_key, kind="stable")
    row_key = row_key[order]
    first = np.flatnonzero(np.diff(row_key, prepend=-1))
    row_of_sample = np.repeat(np.arange(len(first), dtype=np.int32), np.diff(first, append=len(row_key)))

    pixel, triangle = visibility.pixel[order], visibility.triangle[order]
    pattern = sample_positions(visibility.sample_count)[visibility.sub_sample[order]]
    xy = np.stack([pixel % camera.width, pixel // camera.width], -1) + pattern
    surface, seen = _surface(scene, triangle)
    position = np.empty((3, len(pixel), 3), np.float32)
    direction = np.empty_like(position)
    mirrored = np.empty((len(pixel), 3), np.float32)
    roughness, wide = np.zeros((2, len(pixel)), np.float32)
    table = dfg_table() if surface.roughness.any() else np.zeros((2, 2, 4), np.float32)
    leans, widenings = (np.ascontiguousarray(table[..., channel]) for channel in (2, 3))
    _mirror(
        np.asarray(camera.position, np.float64), *camera.ray_basis(), NEIGHBOUR_STEP, xy, seen,
        surface.positions, surface.normals, surface.uv, surface.tangents, surface.texture, surface.normal_scale,
        surface.texels, surface.textures, surface.roughness, surface.roughness_texture, surface.roughness_uv,
        leans, widenings, position, direction, mirrored, roughness, wide,
    )  # fmt: skip
    spread = lobe_spread(wide).astype(np.float32)
    ones = np.ones(len(pixel), np.float32)
    lookups = Lookups(np.arange(len(pixel), dtype=np.int32), ones, position, direction, spread)
    row_pixel, row_part = np.divmod(row_key[first], len(scene.parts))
    return GBuffer(
        row_pixel.astype(np.int32), row_part.astype(np.int32), row_of_sample, triangle, roughness, mirrored, (lookups,)
    )


@dataclass(frozen=True)
class _Surface:
    """Corners of those triangles of the scene that a picture sees, their normal maps and their roughness.

    ``texture`` is a triangle's normal map, -1 for none; ``roughness_texture`` that in whose green, looked up by
    ``roughness_uv``, its roughness, 0 of mirrors, is multiplied; ``textures`` holds (offset into texels, width, height,
    what it does beyond its edges along u + 4 times that along v, of `WRAPS`).
    """

    positions: Float32[np.ndarray, "triangles 3 3"]
    normals: Float32[np.ndarray, "triangles 3 3"]
    uv: Float32[np.ndarray, "triangles 3 2"]
    tangents: Float32[np.ndarray, "triangles 3 4"]
    texture: Int32[np.ndarray, "triangles"]
    normal_scale: Float32[np.ndarray, "triangles"]
    texels: UInt8[np.ndarray, "texels 4"]
    textures: Int32[np.ndarray, "textures 4"]
    roughness: Float32[np.ndarray, "triangles"]
    roughness_texture: Int32[np.ndarray, "triangles"]
    roughness_uv: Float32[np.ndarray, "triangles 3 2"]


def _surface(scene: Scene, triangle: UInt32[np.ndarray, "samples"]) -> tuple[_Surface, Int64[np.ndarray, "samples"]]:
    """The triangles, all of reflective parts, that samples see, and which of them each sample sees."""
    seen = np.zeros(scene.triangle_offsets[-1], bool)
    seen[triangle] = True
    number = np.cumsum(seen) - 1
    chosen = np.flatnonzero(seen)
    bounds = np.searchsorted(chosen, scene.triangle_offsets)
    count = len(chosen)
    mapped = any(image is not None for part in scene.parts if part.reflective for image in _images(part))
    positions, normals = np.zeros((count, 3, 3), np.float32), np.zeros((count, 3, 3), np.float32)
    uv = np.zeros((count if mapped else 0, 3, 2), np.float32)
    tangents = np.zeros((count if mapped else 0, 3, 4), np.float32)
    texture, scale = np.full(count, -1, np.int32), np.zeros(count, np.float32)
    roughness, roughness_texture = np.zeros(count, np.float32), np.full(count, -1, np.int32)
    roughness_uv = np.zeros_like(uv)
    texels, textures, offset = [np.zeros((1, 4), np.uint8)], [np.zeros(4, np.int32)], 1
    for i, part in enumerate(scene.parts):
        span = slice(bounds[i], bounds[i + 1])
        if bounds[i] == bounds[i + 1]:
            continue
        mesh = part.mesh
        corners = mesh.triangles[chosen[span] - scene.triangle_offsets[i]]
        positions[span], normals[span] = mesh.positions[corners], mesh.normals[corners]
        scale[span] = part.material.normal_scale
        if is_rough(part):
            roughness[span] = part.material.perceptual_roughness
        for image, which, of_which in zip(_images(part), (texture, roughness_texture), (uv, roughness_uv), strict=True):
            coordinates = None if image is None else mesh.uv_set(image.coordinates)
            if image is None or coordinates is None:
                continue
            of_which[span], which[span] = coordinates[corners], len(textures)
            if which is texture and mesh.tangents is not None:
                tangents[span] = mesh.tangents[corners]
            height, width = image.pixels.shape[:2]
            texels.append(image.pixels.reshape(-1, 4))
            wraps = WRAPS.index(image.wraps[0]) + 4 * WRAPS.index(image.wraps[1])
            textures.append(np.array([offset, width, height, wraps], np.int32))
            offset += width * height
    surface = _Surface(
        positions, normals, uv, tangents, texture, scale, np.concatenate(texels), np.stack(textures), roughness,
        roughness_texture, roughness_uv,
    )  # fmt: skip
    return surface, number[triangle]


def _images(part: Part) -> tuple[Texture | None, Texture | None]:
    """A part's normal map and the texture of its roughness, as far as it has any and its mesh is laid out for it."""
    material, mesh = part.material, part.mesh
    normal = material.normal_texture if mesh.tangents is not None else None
    roughness = material.metallic_roughness_texture if is_rough(part) else None
    return (normal, roughness) if mesh.uv is not None else (None, None)


@njit(cache=True, error_model="numpy")
def _wrapped(i, size, wrap):  # type: ignore[no-untyped-def]
    """A texel's place within a picture, by the number of a wrap in `WRAPS`."""
    if wrap == 1:
        return min(max(i, 0), size - 1)
    if wrap == 2:
        there = i % (2 * size)
        return min(there, 2 * size - 1 - there)
    return i % size


@njit(cache=True, error_model="numpy")
def _fetch(texels, texture, u, v, channel):  # type: ignore[no-untyped-def]
    """One channel of a texture in [0, 1], bilinear."""
    offset, width, height, wraps = texture[0], texture[1], texture[2], texture[3]
    x, y = u * width - 0.5, v * height - 0.5
    column, row = floor(x), floor(y)
    fx, fy = x - column, y - row
    total = 0.0
    for dy in range(2):
        for dx in range(2):
            i, j = _wrapped(int(column) + dx, width, wraps % 4), _wrapped(int(row) + dy, height, wraps // 4)
            weight = (fx if dx else 1.0 - fx) * (fy if dy else 1.0 - fy)
            total += weight * texels[offset + j * width + i, channel]
    return total / 255.0


@njit(cache=True, error_model="numpy")
def _normalized(x, y, z):  # type: ignore[no-untyped-def]
    length = sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 1e-12 else 0.0
    return x * scale, y * scale, z * scale


@njit(cache=True, error_model="numpy")
def _shading_normal(k, b0, b1, b2, normals, uv, tangents, texture, scales, texels, textures):  # type: ignore[no-untyped-def]
    """Interpolated normal, bent by the normal map where there is one; of unit length, or zero where undefined."""
    n = normals[k]
    nx, ny, nz = _normalized(
        b0 * n[0, 0] + b1 * n[1, 0] + b2 * n[2, 0],
        b0 * n[0, 1] + b1 * n[1, 1] + b2 * n[2, 1],
        b0 * n[0, 2] + b1 * n[1, 2] + b2 * n[2, 2],
    )
    if texture[k] < 0:
        return nx, ny, nz
    t, c = tangents[k], uv[k]
    tx, ty, tz = _normalized(
        b0 * t[0, 0] + b1 * t[1, 0] + b2 * t[2, 0],
        b0 * t[0, 1] + b1 * t[1, 1] + b2 * t[2, 1],
        b0 * t[0, 2] + b1 * t[1, 2] + b2 * t[2, 2],
    )
    handedness = t[0, 3]
    bx, by, bz = (ny * tz - nz * ty), (nz * tx - nx * tz), (nx * ty - ny * tx)
    u = b0 * c[0, 0] + b1 * c[1, 0] + b2 * c[2, 0]
    v = b0 * c[0, 1] + b1 * c[1, 1] + b2 * c[2, 1]
    image = textures[texture[k]]
    mx = (2.0 * _fetch(texels, image, u, v, 0) - 1.0) * scales[k]
    my = (2.0 * _fetch(texels, image, u, v, 1) - 1.0) * scales[k] * handedness
    mz = 2.0 * _fetch(texels, image, u, v, 2) - 1.0
    return _normalized(mx * tx + my * bx + mz * nx, mx * ty + my * by + mz * ny, mx * tz + my * bz + mz * nz)


@njit(cache=True, error_model="numpy")
def _entry(table, n_dot_v, roughness):  # type: ignore[no-untyped-def]
    """Of one number of `dfg_table`, bilinear."""
    rows, columns = table.shape
    x, y = sqrt(n_dot_v) * (columns - 1), roughness * (rows - 1)
    column, row = min(int(x), columns - 2), min(int(y), rows - 2)
    fx, fy = x - column, y - row
    upper = table[row, column] * (1.0 - fx) + table[row, column + 1] * fx
    lower = table[row + 1, column] * (1.0 - fx) + table[row + 1, column + 1] * fx
    return upper * (1.0 - fy) + lower * fy


@njit(parallel=True, cache=True, error_model="numpy")
def _mirror(
    eye, corner, dx, dy, step, xy, triangle, positions, normals, uv, tangents, texture, scales, texels, textures,
    roughness, roughness_texture, roughness_uv, leans, widenings, position, direction, mirrored, rough, wide,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Fills ``position`` and ``direction`` (three rays a sub-sample): itself, its neighbours right and down; and
    ``mirrored``, its ray before it leans, ``rough``, the roughness, and ``wide``, that of a lobe about the normal as
    wide as its own."""
    for i in prange(len(triangle)):
        k = triangle[i]
        v = positions[k]
        e1x, e1y, e1z = float(v[1, 0]) - v[0, 0], float(v[1, 1]) - v[0, 1], float(v[1, 2]) - v[0, 2]
        e2x, e2y, e2z = float(v[2, 0]) - v[0, 0], float(v[2, 1]) - v[0, 1], float(v[2, 2]) - v[0, 2]
        gx, gy, gz = _normalized(e1y * e2z - e1z * e2y, e1z * e2x - e1x * e2z, e1x * e2y - e1y * e2x)
        wx, wy, wz = eye[0] - v[0, 0], eye[1] - v[0, 1], eye[2] - v[0, 2]
        if gx * wx + gy * wy + gz * wz < 0.0:  # the back of a double-sided face
            gx, gy, gz = -gx, -gy, -gz
        lean = 0.0
        for j in range(3):
            x, y = xy[i, 0] + step * (j == 1), xy[i, 1] + step * (j == 2)
            dirx, diry, dirz = _normalized(
                corner[0] + x * dx[0] + y * dy[0], corner[1] + x * dx[1] + y * dy[1], corner[2] + x * dx[2] + y * dy[2]
            )
            # Ray and plane [MoellerTrumbore97]: b1 = w·(d×e2)/det, b2 = d·(w×e1)/det.
            hx, hy, hz = diry * e2z - dirz * e2y, dirz * e2x - dirx * e2z, dirx * e2y - diry * e2x
            det = e1x * hx + e1y * hy + e1z * hz
            inverse = 1.0 / det if det != 0.0 else 0.0
            qx, qy, qz = wy * e1z - wz * e1y, wz * e1x - wx * e1z, wx * e1y - wy * e1x
            b1 = (wx * hx + wy * hy + wz * hz) * inverse
            b2 = (dirx * qx + diry * qy + dirz * qz) * inverse
            b1 = min(max(b1, -FARTHEST_BARYCENTRIC), FARTHEST_BARYCENTRIC)
            b2 = min(max(b2, -FARTHEST_BARYCENTRIC), FARTHEST_BARYCENTRIC)
            nx, ny, nz = _shading_normal(
                k, 1.0 - b1 - b2, b1, b2, normals, uv, tangents, texture, scales, texels, textures
            )
            if nx * gx + ny * gy + nz * gz < 0.0:
                nx, ny, nz = -nx, -ny, -nz
            along = 2.0 * (dirx * nx + diry * ny + dirz * nz)
            rx, ry, rz = dirx - along * nx, diry - along * ny, dirz - along * nz
            climb = rx * gx + ry * gy + rz * gz
            if climb < SMALLEST_CLIMB:
                lift = SMALLEST_CLIMB - climb
                rx, ry, rz = _normalized(rx + lift * gx, ry + lift * gy, rz + lift * gz)
            if j == 0:
                mirrored[i, 0], mirrored[i, 1], mirrored[i, 2] = rx, ry, rz
                rough[i] = roughness[k]
                if roughness_texture[k] >= 0:
                    c, b0 = roughness_uv[k], 1.0 - b1 - b2
                    u, v_ = b0 * c[0, 0] + b1 * c[1, 0] + b2 * c[2, 0], b0 * c[0, 1] + b1 * c[1, 1] + b2 * c[2, 1]
                    rough[i] *= _fetch(texels, textures[roughness_texture[k]], u, v_, 1)
                if rough[i] > 0.0:
                    n_dot_v = min(0.5 * sqrt((rx - dirx) ** 2 + (ry - diry) ** 2 + (rz - dirz) ** 2), 1.0)
                    lean = _entry(leans, n_dot_v, rough[i])
                    wide[i] = rough[i] * _entry(widenings, n_dot_v, rough[i])
            if lean != 0.0:  # towards the normal that mirrors
                nx, ny, nz = _normalized(rx - dirx, ry - diry, rz - dirz)
                rx, ry, rz = _normalized(rx + lean * (nx - rx), ry + lean * (ny - ry), rz + lean * (nz - rz))
            position[j, i, 0] = v[0, 0] + b1 * e1x + b2 * e2x
            position[j, i, 1] = v[0, 1] + b1 * e1y + b2 * e2y
            position[j, i, 2] = v[0, 2] + b1 * e1z + b2 * e2z
            direction[j, i, 0], direction[j, i, 1], direction[j, i, 2] = rx, ry, rz
