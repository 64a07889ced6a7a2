"""How lenses and curved mirrors lay the directions around their axis out in a round picture."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Angles = Float[np.ndarray, "*batch"]

EQUIDISTANT, EQUISOLID, STEREOGRAPHIC, ORTHOGRAPHIC = range(4)  # their numbers in compiled kernels


@dataclass(frozen=True)
class Projection:
    """How far from the middle of a round picture a direction is seen.

    ``radius`` maps the angle to the optical axis in radians to a distance, up to a factor; the picture shows directions
    up to ``widest_deg`` across. A mirror's picture is taken from the side it shows, hence is not reversed; a lens that
    looks the same way has +x on its left.
    """

    radius: Callable[[Angles], Angles]
    code: int  # its number in compiled kernels
    is_mirror: bool = False
    fov_deg: float = 180.0  # the angle across the picture where nothing else is said
    widest_deg: float = 360.0


PROJECTIONS: dict[str, Projection] = {
    "equidistant": Projection(lambda theta: theta, EQUIDISTANT),
    "equisolid": Projection(lambda theta: np.sin(0.5 * theta), EQUISOLID),
    "stereographic": Projection(lambda theta: np.tan(0.5 * theta), STEREOGRAPHIC, widest_deg=350.0),
    "orthographic": Projection(np.sin, ORTHOGRAPHIC, widest_deg=180.0),
    # Seen by an orthographic camera: z = (1 - x² - y²)/2 is the stereographic projection [Heidrich00, eq. 8], and on a
    # ball the normal halves the angle between the axis and the mirrored ray [Heidrich00, sec. 2.1].
    "paraboloid": Projection(lambda theta: np.tan(0.5 * theta), STEREOGRAPHIC, is_mirror=True, widest_deg=350.0),
    "mirror_ball": Projection(lambda theta: np.sin(0.5 * theta), EQUISOLID, is_mirror=True, fov_deg=360.0),
}
