"""Textures on the device: pictures with mip levels, arrays of maps."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import wgpu
from jaxtyping import Float, Shaped

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.errors import RefletError
from reflet.scene.material import Wrap
from reflet.shaders.link import link

ADDRESS_MODES: dict[Wrap, str] = {"repeat": "repeat", "clamp": "clamp-to-edge", "mirror": "mirror-repeat"}

_USAGE = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST


def check_size(device: wgpu.GPUDevice, width: int, height: int, what: str) -> None:
    """Raises `RefletError` where a texture is larger than the device takes."""
    largest = device.limits["max-texture-dimension-2d"]
    if max(width, height) > largest:
        raise RefletError(f"{what} of {width}×{height} is larger than this device takes: at most {largest}×{largest}.")


def upload_picture(
    device: wgpu.GPUDevice, pixels: Shaped[np.ndarray, "height width 4"], texture_format: str, mip_mapped: bool
) -> wgpu.GPUTexture:
    """A 2D texture; its mip levels, if asked for, are filtered on the device."""
    height, width = pixels.shape[:2]
    check_size(device, width, height, "A texture")
    level_count = max(width, height).bit_length() if mip_mapped else 1
    texture = device.create_texture(
        size=(width, height, 1),
        mip_level_count=level_count,
        format=texture_format,
        usage=_USAGE | (wgpu.TextureUsage.RENDER_ATTACHMENT if mip_mapped else 0),
    )
    data = np.ascontiguousarray(pixels)
    device.queue.write_texture(
        {"texture": texture}, data, {"bytes_per_row": data.strides[0], "rows_per_image": height}, (width, height, 1)
    )
    _fill_mip_levels(device, texture, level_count)
    return texture


def _fill_mip_levels(device: wgpu.GPUDevice, texture: wgpu.GPUTexture, level_count: int) -> None:
    if level_count == 1:
        return
    module = device.create_shader_module(code=link("mipmap.wgsl"))
    pipeline = device.create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "vertex_mipmap"},
        primitive={"topology": "triangle-list"},
        fragment={"module": module, "entry_point": "next_level", "targets": [{"format": texture.format}]},
    )
    sampler = device.create_sampler(mag_filter="linear", min_filter="linear")
    views = [texture.create_view(base_mip_level=level, mip_level_count=1) for level in range(level_count)]
    encoder = device.create_command_encoder()
    for finer, coarser in pairwise(views):
        group = device.create_bind_group(
            layout=pipeline.get_bind_group_layout(0),
            entries=[{"binding": 0, "resource": finer}, {"binding": 1, "resource": sampler}],
        )
        target = {"view": coarser, "load_op": "clear", "store_op": "store"}
        render_pass = encoder.begin_render_pass(color_attachments=[target])
        render_pass.set_pipeline(pipeline)
        render_pass.set_bind_group(0, group)
        render_pass.draw(3)
        render_pass.end()
    device.queue.submit([encoder.finish()])


def create_map_array(
    device: wgpu.GPUDevice, chain: MipChain, slots: int, texture_format: str = "rgba16float"
) -> wgpu.GPUTexture:
    """An array of maps with all mip levels, empty; each face of each slot is an array layer."""
    faces, rows, columns = chain.level_shape(0)
    check_size(device, columns, rows, "A map")
    return device.create_texture(
        size=(columns, rows, faces * slots), mip_level_count=chain.level_count, format=texture_format, usage=_USAGE
    )


def upload_reliefs(
    device: wgpu.GPUDevice, inverse_distances: Sequence[Float[np.ndarray, "6 size size"]]
) -> wgpu.GPUTextureView:
    """The cubes of reliefs' half floats, all of one size, as shaders search them."""
    size, layers = inverse_distances[0].shape[-1], 6 * len(inverse_distances)
    texture = device.create_texture(size=(size, size, layers), format="r16float", usage=_USAGE)
    device.queue.write_texture(
        {"texture": texture},
        np.concatenate(inverse_distances),
        {"bytes_per_row": 2 * size, "rows_per_image": size},
        (size, size, layers),
    )
    return texture.create_view(dimension="cube-array")


def write_map(
    device: wgpu.GPUDevice,
    texture: wgpu.GPUTexture,
    slot: int,
    chain: MipChain,
    texels: Float[np.ndarray, "texels 4"],
) -> None:
    """Writes one map with all its mip levels into an array; ``texels`` have the texture's own float type."""
    for mip_level in range(chain.level_count):
        faces, rows, columns = chain.level_shape(mip_level)
        level = np.ascontiguousarray(chain.level(texels, mip_level))
        device.queue.write_texture(
            {"texture": texture, "mip_level": mip_level, "origin": (0, 0, faces * slot)},
            level,
            {"bytes_per_row": level.strides[1], "rows_per_image": rows},
            (columns, rows, faces),
        )


def half_texels(texels: Float[np.ndarray, "texels channels"]) -> Float[np.ndarray, "texels 4"]:
    """Texels as the device holds them: half float, four channels, alpha 1 where there was none."""
    out = np.ones((len(texels), 4), np.float16)
    out[:, : texels.shape[1]] = np.clip(texels, -HALF_MAX, HALF_MAX)
    return out


def map_array_view(texture: wgpu.GPUTexture, parameterization: Parameterization) -> wgpu.GPUTextureView:
    """The view that shaders look maps up in: cubes have a texture kind of their own."""
    return texture.create_view(dimension="cube-array" if parameterization == CUBE else "2d-array")
