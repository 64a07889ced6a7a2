"""An env image laid flat, as one picture."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.cube import CUBE, FACES
from reflet.envmap.env_image import EnvImage

# where each face of a cube lies, (row, column): neighbours in the picture are neighbours on the cube
CROSS = {"py": (0, 1), "nx": (1, 0), "pz": (1, 1), "px": (1, 2), "nz": (1, 3), "ny": (2, 1)}


def flat_sheet(
    image: EnvImage,
) -> tuple[Float[np.ndarray, "height width channels"], Bool[np.ndarray, "height width"]]:
    """Radiance, a pixel a texel, and where directions lead to: not outside a round map's disc, nor beside the cross.

    The faces of a cube form a horizontal cross, those of other maps lie side by side.
    """
    _, valid = image.parameterization.texel_directions(image.size)
    if image.parameterization != CUBE:
        return np.concatenate(list(image.texels), 1), np.concatenate(list(valid), 1)
    size, channels = image.size, image.texels.shape[-1]
    sheet, shown = np.zeros((3 * size, 4 * size, channels), image.texels.dtype), np.zeros((3 * size, 4 * size), bool)
    for face, texels in zip(FACES, image.texels, strict=True):
        row, column = CROSS[face]
        place = np.s_[row * size : (row + 1) * size, column * size : (column + 1) * size]
        sheet[place], shown[place] = texels, True
    return sheet, shown
