"""Maps drawn by hand, and what each of their mip levels must hold [Heidrich00, sec. 4].

A map is looked up by the normal n as the viewer sees it, +z towards the eye. On level l a texel is as wide as the step
g, in radians, that n takes over a pixel where that level is read: the LOD rule says so. (A cube's counts texels along
the face; around the contour the two differ by 2^(1/4) at most.) A filtered level would hold lines of fixed width in
*texels of the finest level*; a drawn one may hold whatever looks right at a pixel of g. That is all a level has to
know, for g tells how large the thing is in the picture.

Take a ball with a radius of R pixels. At the angle a over the contour, sin a = n.z, one pixel across the picture is
1/sin a pixels along the surface, seen so obliquely, and n turns by

    g = 1/(R·sin a),  so that  R = 1/(g·sin a),

and the contour lies x = R·(1 - cos a) pixels away. Any surface that bends more across its contour than along it is such
a ball there; near the contour nearly all do, for the oblique view multiplies the bend. So every level is a picture of
balls, each direction of the radius for which it is read, and whatever a drawing puts at a distance of x pixels from the
contour comes out at x pixels, on things of any size, at any distance: the line of a silhouette (`silhouette`), rows of
strokes (`hatching`).

The levels reach from balls of a pixel to R = 1/(g·sin a) at the finest: with sin a = √(2x/R) at x pixels from the
contour, R = 1/(2x·g²). Dual paraboloids of 256 rows have g = 1/128 there, good for lines of 2 px on balls of 4000 px,
octahedral maps g near 1/70, for 1200 px.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.parameterization import Directions, Parameterization

Pixel = Float[np.ndarray, "*batch"]
Color = Float[np.ndarray, "*batch 3"]


class Drawing(ABC):
    """Something to see on a surface. Colours are shares of white light, linear, in [0, 1]."""

    @abstractmethod
    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """Colours for unit normals in the viewer's frame that turn by ``pixel`` radians from one pixel to the next."""


@dataclass(frozen=True)
class Overprint(Drawing):
    """Drawings printed one over the other: their product, so that ink stays ink and white paper is nothing."""

    drawings: tuple[Drawing, ...]

    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """See the class."""
        return np.prod([each.colors(normal, pixel) for each in self.drawings], axis=0)


def drawn_levels(drawing: Drawing, parameterization: Parameterization, size: int) -> tuple[EnvImage, ...]:
    """The drawing as a map by the viewer's normal, with each mip level drawn for itself, finest first; float32.

    ``size`` is a power of two; RefletError says so where it is not. 0.2 kB a texel of the finest level are in use
    meanwhile.
    """
    levels = []
    for rows in MipChain(size, parameterization).level_sizes:
        normal, _ = parameterization.texel_directions(rows)
        pixel = 1.0 / (rows * np.sqrt(parameterization.sampling_rate(normal)))
        levels.append(EnvImage(parameterization, drawing.colors(normal, pixel).astype(np.float32)))
    return tuple(levels)


@dataclass(frozen=True)
class Ball:
    """Where normals lie on the ball that they are read for: all lengths in pixels."""

    radius: Pixel  # of the ball
    depth: Pixel  # distance from the contour into the ball; 0 on its back
    azimuth: Pixel  # around the contour, radians from +x towards +y


def ball_at(normal: Directions, pixel: Pixel) -> Ball:
    """See the top of the file.

    The outermost pixel's middle is half a pixel from the contour, at sin a = 1/√R = g; what lies beyond counts as that.
    """
    sine = np.maximum(normal[..., 2], 0.0)
    radius = 1.0 / (pixel * np.maximum(sine, pixel))
    depth = radius * sine**2 / (1.0 + np.sqrt(1.0 - np.minimum(sine, 1.0) ** 2))
    return Ball(radius, depth, np.arctan2(normal[..., 1], normal[..., 0]))


def printed(ink: Float[np.ndarray, "*batch"], color: Sequence[float]) -> Color:
    """White paper with a share of ink of this colour in [0, 1]."""
    return 1.0 - ink[..., None] * (1.0 - np.asarray(color))
