"""An env image laid flat, as one picture."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.padding import outside_disc
from reflet.files.pictures.cube_layouts import picture_from_faces


def flat_sheet(
    image: EnvImage,
) -> tuple[Float[np.ndarray, "height width channels"], Bool[np.ndarray, "height width"]]:
    """Radiance, a pixel a texel, and where directions lead to: not outside a round map's disc, nor beside a cross.

    The faces of a cube form a horizontal cross, as somebody inside sees them; those of other maps lie side by side.
    """
    parameterization = image.parameterization
    if parameterization != CUBE and not parameterization.is_round:
        sheet = picture_from_faces(image, None)
        return sheet, np.broadcast_to(np.array(True), sheet.shape[:2])
    valid = np.broadcast_to(~outside_disc(parameterization, image.size), parameterization.shape(image.size))
    shown = EnvImage(parameterization, valid[..., None].astype(np.float32))
    layout = "horizontal-cross" if parameterization == CUBE else None
    return picture_from_faces(image, layout), picture_from_faces(shown, layout)[..., 0] > 0.5
