"""Plain env maps on the device: the host's side of `shaders/env_map.wgsl`, and of `within.wgsl` where they are near."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import wgpu
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Geometry, pack
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import InfiniteSphere
from reflet.errors import RefletError
from reflet.render.device.textures import check_size, upload_reliefs

FULL, HALF = "rgba32float", "rgba16float"
_UNIFORM = np.dtype(
    [("map_from_world", "f4", (3, 4)), ("size", "f4"), ("max_lod", "f4"), ("lod_bias", "f4"), ("roughness", "f4")]
)


@dataclass(frozen=True)
class EnvMapTexture:
    """An env map with its mip levels, one array layer a face."""

    device: wgpu.GPUDevice
    parameterization: Parameterization
    size: int  # rows of a face
    texture: wgpu.GPUTexture
    levels_a_size: int = 1  # one after the other in the layers of a mip level
    geometry: Geometry = field(default_factory=InfiniteSphere)  # in world space
    relief: wgpu.GPUTextureView | None = None  # of that geometry, if it is one

    @property
    def is_near(self) -> bool:
        """Whether lookups depend on where rays start."""
        return not isinstance(self.geometry, InfiniteSphere)

    @property
    def by_hardware(self) -> bool:
        """Whether the hardware's cube sampler serves: of cubes in half float, which all devices can filter."""
        return self.parameterization == CUBE and self.texture.format == HALF and self.levels_a_size == 1

    @property
    def level_count(self) -> int:
        """Levels of all sizes."""
        return int(self.levels_a_size * self.texture.mip_level_count)

    def read(self, mip_level: int = 0, number: int = 0) -> EnvImage:
        """One level, back from the device; of several maps in a row the ``number``-th."""
        size = self.size >> mip_level
        faces, rows, columns = self.parameterization.shape(size)
        channel = np.dtype(np.float16 if self.texture.format == HALF else np.float32)
        data = self.device.queue.read_texture(
            {"texture": self.texture, "mip_level": mip_level, "origin": (0, 0, number * faces)},
            {"bytes_per_row": 4 * channel.itemsize * columns, "rows_per_image": rows},
            (columns, rows, faces),
        )
        return EnvImage(self.parameterization, np.frombuffer(data, channel).reshape(faces, rows, columns, 4).copy())


def create_env_map(
    device: wgpu.GPUDevice,
    parameterization: Parameterization,
    size: int,
    level_count: int,
    texture_format: str,
    usage: int = 0,
    map_count: int = 1,
) -> EnvMapTexture:
    """An empty env map, or several of one kind, one after the other in the texture's layers.

    ``usage`` is what it serves beside lookups and copies.
    """
    faces, rows, columns = parameterization.shape(size)
    check_size(device, columns, rows, "A map")
    texture = device.create_texture(
        size=(columns, rows, map_count * faces),
        mip_level_count=level_count,
        format=texture_format,
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST | wgpu.TextureUsage.COPY_SRC | usage,
    )
    return EnvMapTexture(device, parameterization, size, texture)


def upload_env_map(device: wgpu.GPUDevice, source: EnvMap | Sequence[EnvImage]) -> EnvMapTexture:
    """An env map with its geometry; or mip levels alone, which are infinitely far.

    Levels come finest first, each half as large as the one before, or as many of each size; one is enough. Half-float
    texels stay half float, all others become float32.
    """
    if isinstance(source, EnvMap):
        near = source.geometry
        relief = upload_reliefs(device, [near.inverse_distance]) if isinstance(near, Relief) else None
        return replace(upload_env_map(device, source.images), geometry=near, relief=relief)
    levels = source
    finest = levels[0]
    sizes = [level.size for level in levels]
    a_size = sizes.count(finest.size)
    if (
        any(level.parameterization != finest.parameterization for level in levels)
        or sizes != [finest.size >> k // a_size for k in range(len(levels))]
        or len(levels) % a_size
    ):
        raise RefletError(
            f"Mip levels of one parameterization were expected, each half as large as the last; sizes {sizes} came."
        )
    half = finest.texels.dtype == np.float16
    mip_count, texture_format = len(levels) // a_size, HALF if half else FULL
    env_map = create_env_map(device, finest.parameterization, finest.size, mip_count, texture_format, map_count=a_size)
    env_map = replace(env_map, levels_a_size=a_size)
    write_levels(env_map, levels)
    return env_map


def write_levels(env_map: EnvMapTexture, levels: Sequence[EnvImage]) -> None:
    """Fills a map with all its levels, finest first. Half-float ones hold no more than 65504."""
    dtype = np.float16 if env_map.texture.format == HALF else np.float32
    for number, level in enumerate(levels):
        faces, rows, columns, channels = level.texels.shape
        texels = np.ones((faces, rows, columns, 4), dtype)
        texels[..., :channels] = np.minimum(level.texels, np.finfo(dtype).max)
        mip_level, of_size = divmod(number, env_map.levels_a_size)
        env_map.device.queue.write_texture(
            {"texture": env_map.texture, "mip_level": mip_level, "origin": (0, 0, of_size * faces)},
            texels,
            {"bytes_per_row": texels.strides[1], "rows_per_image": rows},
            (columns, rows, faces),
        )


def env_map_layout(device: wgpu.GPUDevice, near: bool = False) -> wgpu.GPUBindGroupLayout:
    """Bind group 1; with a geometry of maps that are ``near``."""
    fragment = wgpu.ShaderStage.FRAGMENT
    faces = {"sample_type": "unfilterable-float", "view_dimension": "2d-array"}
    cube, cubes = ({"sample_type": "float", "view_dimension": kind} for kind in ("cube", "cube-array"))
    kinds = [{"buffer": {"type": "uniform"}}, {"texture": faces}, {"texture": cube}, {"sampler": {"type": "filtering"}}]
    if near:
        kinds += [{"buffer": {"type": "uniform"}}, {"texture": cubes}]
    return device.create_bind_group_layout(
        entries=[{"binding": k, "visibility": fragment, **kind} for k, kind in enumerate(kinds)]
    )


def env_map_group(
    device: wgpu.GPUDevice,
    layout: wgpu.GPUBindGroupLayout,
    env_map: EnvMapTexture,
    map_from_world: Float[np.ndarray, "3 3"] | None = None,
    lod_bias: float = 0.0,
    roughness: float | None = None,
    near: bool = False,
) -> wgpu.GPUBindGroup:
    """Bind group 1 of a map that is turned: ``map_from_world``, a rotation, by default none.

    ``roughness`` is the perceptual_roughness of lookups in a map whose levels are filtered for it (`ggx_levels`).
    ``near`` is the layout's: programs that look up directions, not rays, leave the geometry out.
    """
    uniform = np.zeros((), _UNIFORM)
    uniform["map_from_world"][:, :3] = np.eye(3) if map_from_world is None else np.transpose(map_from_world)
    uniform["size"], uniform["max_lod"] = env_map.size, env_map.level_count - 1
    uniform["lod_bias"], uniform["roughness"] = lod_bias, -1.0 if roughness is None else roughness
    unused = create_env_map(device, CUBE, 1, 1, HALF).texture
    resources = [
        {"buffer": device.create_buffer_with_data(data=uniform.tobytes(), usage=wgpu.BufferUsage.UNIFORM)},
        env_map.texture.create_view(dimension="2d-array"),
        env_map.texture.create_view(dimension="cube") if env_map.by_hardware else unused.create_view(dimension="cube"),
        device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear"),
    ]
    if near:
        packed = device.create_buffer_with_data(data=pack(env_map.geometry).tobytes(), usage=wgpu.BufferUsage.UNIFORM)
        resources += [{"buffer": packed}, env_map.relief or unused.create_view(dimension="cube-array")]
    entries = [{"binding": k, "resource": resource} for k, resource in enumerate(resources)]
    return device.create_bind_group(layout=layout, entries=entries)
