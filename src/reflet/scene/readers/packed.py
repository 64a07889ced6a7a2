"""Pictures of one number a pixel, packed as glTF's materials have them."""

import numpy as np
from jaxtyping import UInt8
from PIL import Image


def roughness_and_metal(
    roughness: UInt8[np.ndarray, "height width"] | None, metallic: UInt8[np.ndarray, "rows columns"] | None
) -> UInt8[np.ndarray, "h w 4"]:
    """glTF's metallic-roughness picture: roughness in green, metallic in blue, 255 where one is missing.

    The smaller picture is enlarged to the larger one's size.
    """
    given = [plane for plane in (roughness, metallic) if plane is not None]
    size = max(plane.shape[0] for plane in given), max(plane.shape[1] for plane in given)
    picture = np.full((*size, 4), 255, np.uint8)
    for place, plane in ((1, roughness), (2, metallic)):
        if plane is not None:
            picture[..., place] = resized(plane, size)
    return picture


def resized(plane: UInt8[np.ndarray, "height width"], size: tuple[int, int]) -> UInt8[np.ndarray, "h w"]:
    """The picture at another size (rows, columns), bilinear."""
    if plane.shape == size:
        return plane
    return np.asarray(Image.fromarray(plane).resize(size[::-1], Image.Resampling.BILINEAR))
