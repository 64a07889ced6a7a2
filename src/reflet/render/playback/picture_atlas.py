"""Pictures of materials in one array texture, which `shaders/bilinear.wgsl` looks up."""

from collections.abc import Iterable

import numpy as np
import wgpu

from reflet.render.device.textures import check_size
from reflet.render.playback.atlas import atlas_of
from reflet.scene.material import Texture

_USAGE = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST


def picture_atlas(
    device: wgpu.GPUDevice, textures: Iterable[Texture | None]
) -> tuple[wgpu.GPUTexture, dict[int, tuple[int, int, int, int]]]:
    """The texture, rgba8unorm as stored, one texel where there are none; and by the identities of their pixels where
    pictures lie: column, row, layer, width + 65536 height."""
    pictures = {id(texture.pixels): texture for texture in textures if texture is not None}
    sizes = [picture.pixels.shape[1::-1] for picture in pictures.values()]
    atlas = atlas_of(sizes)
    check_size(device, *atlas.size[:2], "A texture")
    out = device.create_texture(size=atlas.size, format="rgba8unorm", usage=_USAGE)
    place_of = {}
    for (key, picture), place, (width, height) in zip(pictures.items(), atlas.places, sizes, strict=True):
        place_of[key] = (*place, width | height << 16)
        pixels = np.ascontiguousarray(picture.pixels)
        layout = {"bytes_per_row": 4 * width, "rows_per_image": height}
        device.queue.write_texture({"texture": out, "origin": place}, pixels, layout, (width, height, 1))
    return out, place_of
