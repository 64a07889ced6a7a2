"""Local light of rough surfaces on the device: `shaders/surface_light.wgsl` describes it."""

import numpy as np
import wgpu
from jaxtyping import Int, UInt32

from reflet.render.playback.layouts import SURFACE
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface_layer import SurfaceLayer

_ROWS = 4096  # sites in a layer of the texture; twin: `ROWS` of surface_light.wgsl


def surface_bits(scene: Scene, surface: SurfaceLayer | None) -> list[int]:
    """Of each part `SURFACE` where its triangles have maps, else 0."""
    if surface is None:
        return [0] * len(scene.parts)
    bounds = zip(scene.triangle_offsets[:-1], scene.triangle_offsets[1:], strict=True)
    return [SURFACE * bool(surface.resolution[first:end].any()) for first, end in bounds]


def sites_of(surface: SurfaceLayer, order: Int[np.ndarray, "triangles"]) -> UInt32[np.ndarray, "pairs 2"]:
    """Resolution and offset of triangles in the ``order`` in which they are drawn, and behind them the sites of all
    samples, two in a pair."""
    grids = np.stack([surface.resolution, surface.offset], -1)[order]
    return np.concatenate([grids, np.pad(surface.site, (0, len(surface.site) % 2)).reshape(-1, 2)])


def upload_surface(device: wgpu.GPUDevice, surface: SurfaceLayer | None) -> wgpu.GPUTexture:
    """All maps, a row of texels each; without them one texel."""
    light = np.zeros((1, 1, 4), np.float16) if surface is None else surface.light
    sites, texels = light.shape[:2]
    rows, layers = min(sites, _ROWS), -(-sites // _ROWS)
    texture = device.create_texture(
        size=(texels, rows, layers),
        format="rgba16float",
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
    )
    for layer in range(layers):
        some = np.ascontiguousarray(light[layer * _ROWS : (layer + 1) * _ROWS])
        device.queue.write_texture(
            {"texture": texture, "origin": (0, 0, layer)},
            some,
            {"bytes_per_row": 8 * texels, "rows_per_image": len(some)},
            (texels, len(some), 1),
        )
    return texture
