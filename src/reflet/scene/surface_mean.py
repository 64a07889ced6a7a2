"""Means of a material over the surface that wears it."""

import numpy as np
from jaxtyping import Float, Integer, UInt8

from reflet.scene.material import Texture, Wrap
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part

_POINTS = 16384


def surface_area(mesh: Mesh) -> float:
    """Square metres of one side of a mesh."""
    return float(_areas(mesh).sum())


def _areas(mesh: Mesh) -> Float[np.ndarray, "triangles"]:
    p = mesh.positions[mesh.triangles].astype(np.float64)
    return np.asarray(0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1))


def surface_points(mesh: Mesh, count: int) -> tuple[Integer[np.ndarray, "count"], Float[np.ndarray, "count 3"]]:
    """Triangles and barycentric coordinates of ``count`` points spread evenly over a mesh's area; always the same."""
    area = 2.0 * _areas(mesh)
    reach = np.cumsum(area)
    triangle = np.searchsorted(reach, (np.arange(count) + 0.5) / count * reach[-1], side="right")
    triangle = np.minimum(triangle, len(area) - 1)
    # the R2 sequence of Roberts, folded into the triangle
    golden = 1.32471795724474602596
    i = np.arange(1, count + 1)
    s, t = np.mod(i / golden, 1.0), np.mod(i / golden**2, 1.0)
    fold = s + t > 1.0
    s, t = np.where(fold, 1.0 - s, s), np.where(fold, 1.0 - t, t)
    return triangle, np.column_stack([1.0 - s - t, s, t])


def surface_mean(part: Part) -> tuple[float, float]:
    """Area-weighted mean of (metallic, perceptual_roughness) over a part, textures included."""
    material, texels = part.material, surface_texels(part)
    if texels is None:
        return material.metallic, material.perceptual_roughness
    mean = texels.mean(axis=0) / 255.0
    return material.metallic * float(mean[2]), material.perceptual_roughness * float(mean[1])


def coat_mean(part: Part) -> tuple[float, float]:
    """Area-weighted mean of (share, perceptual roughness) of a part's clear coat, textures included; the roughness is
    that of what there is of it."""
    material, mesh = part.material, part.mesh
    shares, roughness = (texels_on(mesh, t) for t in (material.clearcoat_texture, material.clearcoat_roughness_texture))
    weight = np.ones(1) if shares is None else shares[:, 0] / 255.0
    rough = np.ones(1) if roughness is None else roughness[:, 1] / 255.0
    mean = float(weight.mean())
    of_coat = float((weight * rough).mean()) / mean if mean > 0.0 else 1.0
    return material.clearcoat * mean, material.clearcoat_roughness * of_coat


def surface_texels(part: Part) -> UInt8[np.ndarray, "points 4"] | None:
    """The metallic-roughness texture at `surface_points` of a part, None where it has none."""
    return texels_on(part.mesh, part.material.metallic_roughness_texture)


def texels_on(mesh: Mesh, texture: Texture | None) -> UInt8[np.ndarray, "points 4"] | None:
    """A texture at `surface_points` of a mesh, None where there is none or it cannot be laid on it."""
    coordinates = None if texture is None else mesh.uv_set(texture.coordinates)
    if texture is None or coordinates is None:
        return None
    triangle, weights = surface_points(mesh, _POINTS)
    uv = np.einsum("pk,pki->pi", weights, coordinates[mesh.triangles[triangle]])
    height, width = texture.pixels.shape[:2]
    column = np.minimum((_within(uv[:, 0], texture.wraps[0]) * width).astype(int), width - 1)
    row = np.minimum((_within(uv[:, 1], texture.wraps[1]) * height).astype(int), height - 1)
    return np.asarray(texture.pixels[row, column])


def _within(coordinate: Float[np.ndarray, "points"], wrap: Wrap) -> Float[np.ndarray, "points"]:
    """Where in a picture, from 0 to 1, a texture coordinate leads."""
    if wrap == "clamp":
        return np.clip(coordinate, 0.0, 1.0)
    if wrap == "mirror":
        there = np.mod(coordinate, 2.0)
        return np.minimum(there, 2.0 - there)
    return np.mod(coordinate, 1.0)
