"""Hatching near silhouettes: rows of strokes along the contour, denser towards it [Heidrich00, sec. 4].

The rows lie at fixed distances from the contour, in pixels (`drawing`). They follow it, for only so can a map hold
them: seen obliquely, a texel is 1/sin a times as long along the contour as a pixel, and a stroke across it would blur
to grey.

Row j, ``spacing``·j pixels deep, is of rank q where j is an odd multiple of 2^q: half of all rows have rank 0, a
quarter have rank 1. The higher the rank, the farther from the contour a row may be drawn: where the surface turns to
the viewer the gaps double, and double again. When the thing grows to twice its size, row 2j comes to lie where row j
was. So whatever depends on chance asks for j/2^floor(log2 R), which then stays the same: two neighbouring levels hold
the same strokes, the finer one others between them, and the LOD blends strokes with themselves.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from reflet.envmap.parameterizations.parameterization import Directions
from reflet.errors import RefletError
from reflet.npr.drawing import Color, Drawing, Pixel, ball_at, printed
from reflet.npr.noise import chance, tremor

_RANKS = (0.5, 0.64, 0.74, 0.82)  # n·v up to which rows of each rank are drawn
_LIGHT = 2.2  # azimuth in radians, upper left: there rows reach less far, on the other side farther
_CONTRAST = 0.35  # by this share
_DEEPEST = 0.8  # n·v: around the point that faces the viewer rows would be rings
_STROKES = 10  # around the contour
_GAP = 0.12  # of a stroke's place, at most, left out at either end
_TAPER = 0.3  # of a stroke's place: from its thin end to its full width
_FADE = 0.12  # in n·v: a row thins out towards the last it is drawn at
_STRAY = 0.3  # of the spacing: how far the hand strays
_CHANGE = 0.7  # of an octave of sizes: after this share of it, strokes change over to the next one's
_LARGEST = 20  # balls have fewer than 2^20 pixels

Row = Int[np.ndarray, "*batch"]
Share = Float[np.ndarray, "*batch"]


@dataclass(frozen=True)
class Hatching(Drawing):
    """Strokes ``width`` pixels thick in rows ``spacing`` pixels apart where they are densest, at the contour."""

    width: float = 1.4
    spacing: float = 2.5
    seed: int = 1
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0.25 <= self.width <= self.spacing <= 64.0:
            raise RefletError(
                "Strokes are at least 0.25 pixels wide and lie at least that far apart, at most 64 pixels; not "
                f"{self.width} wide and {self.spacing} apart."
            )

    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """See the top of the file."""
        ball = ball_at(normal, pixel)
        octaves = np.clip(np.log2(ball.radius), 0.0, _LARGEST - 1.0)
        turns = ball.azimuth / (2.0 * np.pi) + 0.5
        facing = np.maximum(normal[..., 2], 0.0)
        shade = 1.0 - _CONTRAST * np.cos(ball.azimuth - _LIGHT)
        stray = _STRAY * self.spacing * tremor(self.seed, 0, turns)
        ink = np.zeros(facing.shape)
        for rank, reach in enumerate(_RANKS):
            apart = self.spacing * 2.0**rank
            last = rank == len(_RANKS) - 1
            # Odd multiples; of the last rank all.
            row = np.round(ball.depth / apart) if last else 2.0 * np.floor(0.5 * ball.depth / apart) + 1.0
            away = ball.depth - apart * row - stray
            number = row.astype(np.int64) << rank
            deepest = np.minimum(reach * shade, _DEEPEST)
            half = 0.5 * self.width * self._pressure(number, octaves, turns, facing, deepest)
            ink = np.maximum(ink, np.clip(half + 0.5 - np.abs(away), 0.0, np.minimum(2.0 * half, 1.0)))
        return printed(ink, self.color)

    def _pressure(self, row: Row, octaves: Share, turns: Share, facing: Share, reach: Share) -> Share:
        """Thickness of a row's strokes, 0 between them to 1; those of one octave of sizes give way to the next's."""
        whole = np.floor(octaves)
        mixed = np.clip((octaves - whole - _CHANGE) / (1.0 - _CHANGE), 0.0, 1.0)
        before, after = (
            self._strokes(row << (_LARGEST - whole.astype(np.int64) - k), turns, facing, reach) for k in (0, 1)
        )
        return (1.0 - mixed) * before + mixed * after

    def _strokes(self, key: Row, turns: Share, facing: Share, reach: Share) -> Share:
        place = _STROKES * (turns + chance(self.seed, key, 100))
        stroke = np.floor(place).astype(np.int64) % _STROKES
        along = place - np.floor(place)
        start, end, far = (chance(self.seed, key, stroke, k) for k in range(3))
        from_ends = np.minimum(along - _GAP * start, 1.0 - _GAP * end - along)
        fade = reach * (0.8 + 0.4 * far) - facing
        return np.sqrt(np.clip(from_ends / _TAPER, 0.0, 1.0) * np.clip(fade / _FADE, 0.0, 1.0))
