"""Cool-to-warm shading of technical illustration [Gooch98]."""

from dataclasses import dataclass

import numpy as np

from reflet.envmap.parameterizations.parameterization import Directions
from reflet.npr.drawing import Color, Drawing, Pixel

Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Gooch(Drawing):
    """w·warm + (1 - w)·cool with w = (1 + l·n)/2. Implements [Gooch98, eq. 2].

    l points to the light, in the viewer's frame: upper left in front of the thing. Towards it the surface is warm,
    away from it cool, and neither black nor white, which stay free for lines and highlights. The colours are the
    paper's, a mixture of blue (0, 0, b) and yellow (y, y, 0) with shares of the surface's own colour:
    cool = blue + α·color, warm = yellow + β·color. They are mixed as display values, as in the paper, and clipped at 1.
    ``shine`` adds white by the highlight (n·h)^exponent, h half way between light and viewer.
    """

    color: Rgb = (0.75, 0.75, 0.75)
    blue: float = 0.45
    yellow: float = 0.4
    alpha: float = 0.25
    beta: float = 0.6
    shine: float = 0.7
    exponent: float = 40.0
    light: tuple[float, float, float] = (-0.5, 0.65, 0.57)

    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """See the class; smooth, so that the pixel does not matter."""
        return np.asarray(linear(self.display(normal)))

    def display(self, normal: Directions) -> Color:
        """The same as display values."""
        light = np.asarray(self.light) / np.linalg.norm(self.light)
        color = np.asarray(self.color)
        cool = np.array([0.0, 0.0, self.blue]) + self.alpha * color
        warm = np.array([self.yellow, self.yellow, 0.0]) + self.beta * color
        share = 0.5 * (1.0 + normal @ light)[..., None]
        half = light + np.array([0.0, 0.0, 1.0])
        highlight = np.maximum(normal @ (half / np.linalg.norm(half)), 0.0)[..., None] ** self.exponent
        tone = np.clip(share * warm + (1.0 - share) * cool, 0.0, 1.0)
        return tone + (1.0 - tone) * (self.shine * highlight)


def linear(display: Color) -> Color:
    """Linear light of display values in [0, 1] (sRGB)."""
    return np.where(display <= 0.04045, display / 12.92, ((np.maximum(display, 0.04045) + 0.055) / 1.055) ** 2.4)
