"""The maps of a measured BRDF's lobes as files for the web viewer."""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32

from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.errors import RefletError
from reflet.files.textures.env_texture import texture_from_maps
from reflet.files.textures.ktx2_container import write_texture
from reflet.pem.arrays import BufferWriter
from reflet.reflectance.lobes.brdf_taps import brdf_taps
from reflet.reflectance.lobes.lobe_taps import LobeTaps
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d
from reflet.render.maps.brdf_map_texture import lobe_table

_MOST_LAYERS = 256  # of a texture, in every browser


def write_brdf_map(folder: Path, uri: str, maps: BrdfMap3d, buffer: BufferWriter) -> dict[str, Any]:
    """Write all slices into one file, ``uri`` in ``folder``; the lobes' table, and the taps that the viewer filters
    other light with, into ``buffer``. The description of all.

    The file is a 2D array in half float with all mip levels, its layers those of
    `reflet.render.maps.brdf_map_texture.upload_brdf_map`: 11 bytes a texel. The diffuse map is not written. Raises
    RefletError for more layers than browsers take.
    """
    images = [image for slices in maps.slices for image in slices] or [maps.diffuse]
    shape = images[0].parameterization
    if len(images) * shape.face_count > _MOST_LAYERS:
        raise RefletError(
            f"The maps of this BRDF need {len(images) * shape.face_count} texture layers, and browsers take "
            f"{_MOST_LAYERS}; ask for fewer view angles or lobes, or for a parameterization of one face."
        )
    write_texture(folder / uri, texture_from_maps([mip_images(image) for image in images]))
    return {
        "uri": uri,
        "parameterization": shape.name,
        "size": images[0].size,
        "slices": len(images),
        "lobes": buffer.add(lobe_table(maps.lobes)),
        "taps": [buffer.add(listed_taps(lobe)) for lobe in brdf_taps(maps.lobes)],
    }


def listed_taps(lobe: LobeTaps) -> Float32[np.ndarray, "taps 7"]:
    """Direction around +z, blur in radians, weights of red, green and blue."""
    weight = np.broadcast_to(lobe.weight.reshape(len(lobe.blur), -1), (len(lobe.blur), 3))
    return np.concatenate([lobe.direction, lobe.blur[:, None], weight], 1).astype(np.float32)
