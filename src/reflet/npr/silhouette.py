"""Contours as a line of constant width in pixels [Heidrich00, sec. 4]."""

from dataclasses import dataclass

import numpy as np

from reflet.envmap.parameterizations.parameterization import Directions
from reflet.errors import RefletError
from reflet.npr.drawing import Color, Drawing, Pixel, ball_at, printed


@dataclass(frozen=True)
class Silhouette(Drawing):
    """Everything within ``width`` pixels of the contour is ink, whatever the size of the ball (`drawing`).

    The inner edge is as soft as a pixel. Between two levels the LOD blends a line that is too thin with one twice as
    thick: summed over the line's profile, the ink is 0.86 to 1.22 of the width, by where in its octave the radius lies.
    Balls of a radius below ``width`` are ink all over. Flat faces have no silhouette, for their normals do not turn,
    and where the view runs along a surface's straight direction (the ends of inner contours) the line swells.
    """

    width: float = 2.5
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0.5 <= self.width <= 64.0:
            raise RefletError(f"A silhouette is 0.5 to 64 pixels wide, not {self.width}.")

    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """See the class."""
        return printed(np.clip(self.width + 0.5 - ball_at(normal, pixel).depth, 0.0, 1.0), self.color)
