"""The maps of a BRDF's lobes on the device: the host's side of `shaders/lobes.wgsl`."""

from dataclasses import dataclass

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.errors import RefletError
from reflet.reflectance.lobes.lobes import Lobes
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d
from reflet.render.maps.env_map_texture import FULL, EnvMapTexture, create_env_map, upload_env_map


@dataclass(frozen=True)
class BrdfMapTexture:
    """``slices``: the faces of all slices of all lobes, one after the other, in array layers, with mip levels."""

    slices: EnvMapTexture
    diffuse: EnvMapTexture


def upload_brdf_map(device: wgpu.GPUDevice, maps: BrdfMap3d) -> BrdfMapTexture:
    """16 bytes a texel, and a third more for mip levels. Raises RefletError for more layers than the device has."""
    images = [image for slices in maps.slices for image in slices] or [maps.diffuse]
    parameterization, size = images[0].parameterization, images[0].size
    check_layers(device, len(images) * parameterization.face_count)
    levels = [mip_images(image) for image in images]
    slices = create_env_map(device, parameterization, size, len(levels[0]), FULL, map_count=len(images))
    for number, image_levels in enumerate(levels):
        _write(slices, number * parameterization.face_count, image_levels)
    return BrdfMapTexture(slices, upload_env_map(device, (maps.diffuse,)))


def check_layers(device: wgpu.GPUDevice, layers: int) -> None:
    """Raises RefletError for more than the device has."""
    most = device.limits["max-texture-array-layers"]
    if layers > most:
        raise RefletError(
            f"The maps of this BRDF need {layers} texture layers, and the device has {most}; ask for fewer view angles "
            "or lobes, or for a parameterization of one face, such as octahedral."
        )


def _write(target: EnvMapTexture, first_layer: int, levels: tuple[EnvImage, ...]) -> None:
    for mip_level, level in enumerate(levels):
        faces, rows, columns, channels = level.texels.shape
        texels = np.ones((faces, rows, columns, 4), np.float32)
        texels[..., :channels] = level.texels
        target.device.queue.write_texture(
            {"texture": target.texture, "mip_level": mip_level, "origin": (0, 0, first_layer)},
            texels,
            {"bytes_per_row": texels.strides[1], "rows_per_image": rows},
            (columns, rows, faces),
        )


def lobe_table(lobes: Lobes) -> Float32[np.ndarray, "rows angles 4"]:
    """`table` of `lobes.wgsl`: the diffuse albedo and the cosine of each view angle, then each lobe's axis and side."""
    table = np.zeros((1 + len(lobes.lobes), len(lobes.cos_theta_o), 4), np.float32)
    table[0, :, :3], table[0, :, 3] = lobes.diffuse, lobes.cos_theta_o
    for row, lobe in zip(table[1:], lobes.lobes, strict=True):
        row[:, 0], row[:, 1] = lobe.axis_angle - lobe.side * np.arccos(lobes.cos_theta_o), lobe.side
    return table
