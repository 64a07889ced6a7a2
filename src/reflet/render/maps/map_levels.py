"""Mip levels of env maps, made on the device."""

import numpy as np
import wgpu

from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mean_weights
from reflet.render.maps.env_map_texture import EnvMapTexture
from reflet.shaders.link import link


class MapLevels:
    """Fills the mip levels of one half-float map from the finest, as often as that changes; 4 bytes a texel more.

    The device's twin of `reflet.envmap.resampling.mip_reduction.mip_levels_from_finest`, but for the mean that this
    restores over all of a round map. The finest level holds the map's continuation outside its disc.
    """

    def __init__(self, device: wgpu.GPUDevice, env_map: EnvMapTexture) -> None:
        module = device.create_shader_module(code=link("map_levels.wgsl"))
        self._pipeline = device.create_compute_pipeline(
            layout="auto", compute={"module": module, "entry_point": "next_map_level"}
        )
        weights = _upload_weights(device, env_map.parameterization, env_map.size)
        self._steps = []
        for level in range(1, env_map.texture.mip_level_count):
            resources = [
                _level(env_map.texture, level - 1), _level(env_map.texture, level), _level(weights, level - 1)
            ]  # fmt: skip
            group = device.create_bind_group(
                layout=self._pipeline.get_bind_group_layout(0),
                entries=[{"binding": k, "resource": resource} for k, resource in enumerate(resources)],
            )
            self._steps.append((group, env_map.parameterization.shape(env_map.size >> level)))

    def fill(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Levels 1 and coarser."""
        compute_pass = encoder.begin_compute_pass()
        compute_pass.set_pipeline(self._pipeline)
        for group, (faces, rows, columns) in self._steps:
            compute_pass.set_bind_group(0, group)
            compute_pass.dispatch_workgroups(-(-columns // 8), -(-rows // 8), faces)
        compute_pass.end()


def _level(texture: wgpu.GPUTexture, mip_level: int) -> wgpu.GPUTextureView:
    return texture.create_view(dimension="2d-array", base_mip_level=mip_level, mip_level_count=1)


def _upload_weights(device: wgpu.GPUDevice, parameterization: Parameterization, size: int) -> wgpu.GPUTexture:
    faces, rows, columns = parameterization.shape(size)
    texture = device.create_texture(
        size=(columns, rows, faces),
        mip_level_count=size.bit_length(),
        format="r32float",
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
    )
    weights = np.array(mean_weights(parameterization, size))
    for mip_level in range(size.bit_length()):
        faces, rows, columns = weights.shape
        device.queue.write_texture(
            {"texture": texture, "mip_level": mip_level},
            np.ascontiguousarray(weights, np.float32),
            {"bytes_per_row": 4 * columns, "rows_per_image": rows},
            (columns, rows, faces),
        )
        if rows > 1:
            weights = weights.reshape(faces, rows // 2, 2, columns // 2, 2).sum((2, 4))
    return texture
