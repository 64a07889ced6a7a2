"""What mirrored rays meet, on the device: `shaders/bvh.wgsl` and `shaders/traced.wgsl` describe it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import wgpu
from jaxtyping import Int, UInt32

from reflet.render.playback.layouts import HIT_MATERIAL, METAL, fill_material, pictures_of
from reflet.render.playback.picture_atlas import picture_atlas
from reflet.scene.bvh.bvh import Bvh, corners_of
from reflet.scene.bvh.nodes import refitted
from reflet.scene.companions import traced_parts
from reflet.scene.scene import Part, Scene
from reflet.scene.surface_mean import coat_mean


def bvh_words(scene: Scene, bvh: Bvh, drawn_number: Int[np.ndarray, "triangles"]) -> UInt32[np.ndarray, "places 4"]:
    """The tree's nodes and triangles as `shaders/bvh.wgsl` says, 64 to 112 bytes a triangle; ``drawn_number`` by the
    scene's numbers."""
    corners = corners_of(scene, bvh.order)
    nodes = refitted(bvh.leaf_counts, corners)
    count, leaf = len(nodes.counts), nodes.counts > 0
    node = np.empty((count, 2, 4), np.uint32)
    node[:, 0, :3], node[:, 1, :3] = nodes.lower.view(np.uint32), nodes.upper.view(np.uint32)
    node[:, 0, 3], node[:, 1, 3] = np.where(leaf, 2 * count + 3 * nodes.link, 2 * nodes.link), nodes.counts
    triangle = np.zeros((len(corners), 3, 4), np.uint32)
    triangle[:, 0, :3] = np.ascontiguousarray(corners[:, 0]).view(np.uint32)
    triangle[:, 1:, :3] = (corners[:, 1:] - corners[:, :1]).view(np.uint32)
    triangle[:, 0, 3] = drawn_number[bvh.order]
    part_of = np.searchsorted(scene.triangle_offsets, bvh.order, side="right") - 1
    triangle[:, 1, 3] = np.searchsorted(traced_parts(scene, bvh.companions), part_of)
    return np.concatenate([node.reshape(-1, 4), triangle.reshape(-1, 4)])


def drawn_directions(
    scene: Scene, bvh: Bvh, drawn_number: Int[np.ndarray, "triangles"]
) -> UInt32[np.ndarray, "triangles 2"]:
    """`Bvh.directions` in the order in which triangles are drawn."""
    out = np.zeros((scene.triangle_offsets[-1], 2), np.uint32)
    out[drawn_number[bvh.order]] = bvh.directions
    return out


def hit_materials(
    device: wgpu.GPUDevice, met: Sequence[Part], extras: Sequence[int], bits: Sequence[int]
) -> tuple[np.ndarray, wgpu.GPUTexture, int]:
    """`HIT_MATERIAL` of parts, whose vertices' extras lie at ``extras`` and which have ``bits`` besides, the texture
    that holds their pictures, and all bits that any of them has."""
    parts = [part if part.reflective else _matte(part) for part in met]
    texture, place_of = picture_atlas(device, (picture for part in parts for picture in pictures_of(part)))
    out = np.zeros(max(len(parts), 1), HIT_MATERIAL)  # a binding may not be empty
    for entry, part, its_extras, its_bits in zip(out, parts, extras, bits, strict=False):
        fill_material(entry, part, its_extras)
        entry["bits"] |= its_bits
        if part.is_coated:
            share, roughness = (round(65535.0 * mean) for mean in coat_mean(part))
            entry["coat"] = share | roughness << 16
        for k, picture_or_none in enumerate(pictures_of(part)):
            if picture_or_none is not None:
                entry["pictures"][k] = place_of[id(picture_or_none.pixels)]
    return out, texture, int(np.bitwise_or.reduce(out["bits"], initial=METAL))


def _matte(part: Part) -> Part:
    """A part that does not reflect without what only mirrors have: its light is diffuse, of metals too."""
    return replace(part, material=replace(part.material, metallic=0.0, metallic_roughness_texture=None))
