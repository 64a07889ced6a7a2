"""A room with windows, sketched in ink, as polished things mirror it [Heidrich00, sec. 4]."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.parameterizations.parameterization import Directions
from reflet.errors import RefletError
from reflet.npr.drawing import Color, Drawing, Pixel, printed
from reflet.npr.noise import chance, tremor

Vector = Float[np.ndarray, "3"]
Line = tuple[Vector, Vector, float]  # from, to, and how thick
Share = Float[np.ndarray, "directions"]

_ROOM = np.array([1.0, 0.62, 1.1])  # half its width, height and depth; the thing hangs in its middle
_UP = np.array([0.0, 1.0, 0.0])
# Of each wall: which way is right, which way it lies, and its window's middle and half extent, right and up.
_WALLS = (
    ((1, 0, 0), (0, 0, 1), (-0.42, 0.1), (0.4, 0.36)),
    ((-1, 0, 0), (0, 0, -1), (0.0, 0.1), (0.5, 0.36)),
    ((0, 0, 1), (-1, 0, 0), (0.25, 0.1), (0.4, 0.36)),
    ((0, 0, -1), (1, 0, 0), (-0.1, 0.1), (0.4, 0.36)),
)
_PANES = (2, 2)  # across and up
_BAR = 0.022  # of glazing bars and frames: half their width
_FRAME = 0.05  # of a window's frame: how far around it
_GLINTS = ((0.3, 0.1), (0.46, 0.035))  # white strokes down a window: where, and how wide, in its widths
_OVERSHOOT = 0.05  # of a line's length, at most: a hand does not stop at corners
_STRAY = 0.006  # radians: how far it strays
_TAPER = 0.08  # of a line's length: from its thin end to its full width


@dataclass(frozen=True)
class Window(Drawing):
    """What a mirror shows of the room around the viewer, who looks along -z: four walls, each with a window.

    Panes are ink, but for a few glints; bars are paper, and never thinner than the lines around windows and along the
    room's edges: ``width`` pixels, on things of any size.
    """

    width: float = 1.5
    seed: int = 1
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0.25 <= self.width <= 64.0:
            raise RefletError(f"Lines are 0.25 to 64 pixels wide, not {self.width}.")

    def colors(self, normal: Directions, pixel: Pixel) -> Color:
        """The mirrored direction, 2·n.z·n - z, turns twice as far as n."""
        mirrored = 2.0 * normal[..., 2:] * normal - np.array([0.0, 0.0, 1.0])
        return self.room(mirrored, 2.0 * pixel)

    def room(self, direction: Directions, pixel: Pixel) -> Color:
        """The room itself, in unit directions that turn by ``pixel`` radians from one pixel to the next."""
        flat, step = direction.reshape(-1, 3), pixel.ravel()
        ink = np.zeros(len(flat))
        key = 0
        for right, out, middle, extent in _WALLS:
            u, w = np.array(right, np.float64), np.array(out, np.float64)
            self._glaze(ink, flat, step, key, u, w, np.array(middle), np.array(extent))
            for start, end, thickness in _lines(u, w, np.array(middle), np.array(extent)):
                key += 1
                self._draw(ink, flat, step, key, start, end, thickness)
            key += 1
        return printed(ink.reshape(pixel.shape), self.color)

    def _glaze(
        self, ink: Share, direction: np.ndarray, step: Share, key: int, u: Vector, w: Vector, middle: np.ndarray,
        extent: np.ndarray,
    ) -> None:  # fmt: skip
        """Fills the panes of the window in the wall that lies at ``w``."""
        away = abs(w @ _ROOM)
        chosen = np.flatnonzero(direction @ w > 0.2)
        d, step = direction[chosen], step[chosen]
        length = away / (d @ w)  # to the wall
        a, b = length * (d @ u) - middle[0], length * (d @ _UP) - middle[1]
        # Obliquely seen, a length on the wall is foreshortened along one axis only: the mean of the two.
        p = step * length**1.5 / away**0.5
        near = (np.abs(a) < extent[0] + p) & (np.abs(b) < extent[1] + p)
        chosen, a, b, p = chosen[near], a[near], b[near], p[near]
        bar = np.maximum(_BAR, 0.4 * self.width * p)
        glass = np.zeros(len(chosen))
        size = 2.0 * extent / np.array(_PANES)
        for column in range(_PANES[0]):
            for row in range(_PANES[1]):
                pane = key * 100 + column * 10 + row
                x, y = a + extent[0] - column * size[0], b + extent[1] - row * size[1]
                x = x + _STRAY * tremor(self.seed, pane, 0.4 * y / size[1])
                y = y + _STRAY * tremor(self.seed, pane + 50, 0.4 * x / size[0])
                share = _covered(x, bar, size[0] - bar, p) * _covered(y, bar, size[1] - bar, p)
                glass = np.maximum(glass, share)
        for at, wide in _GLINTS:
            slanted = 0.5 * (a - 0.7 * b) / extent[0] + 0.5 + _STRAY * tremor(self.seed, key + 90, 0.3 * b / extent[1])
            glass *= 1.0 - _covered(slanted, at, at + wide, 0.5 * p / extent[0])
        ink[chosen] = np.maximum(ink[chosen], glass)

    def _draw(
        self, ink: Share, direction: np.ndarray, step: Share, key: int, start: Vector, end: Vector, thickness: float
    ) -> None:
        """Draws a straight line of the room: an arc of a great circle."""
        first, last = start / np.linalg.norm(start), end / np.linalg.norm(end)
        angle = float(np.arccos(first @ last))
        axis = np.cross(first, last) / np.sin(angle)
        middle = (first + last) / np.linalg.norm(first + last)
        margin = angle * _OVERSHOOT + self.width * thickness * float(step.max()) + 4.0 * _STRAY
        chosen = np.flatnonzero(direction @ middle > np.cos(min(0.5 * angle + margin, np.pi)))
        d, step = direction[chosen], step[chosen]
        along = np.arctan2(d @ np.cross(axis, first), d @ first) / angle
        across = np.arcsin(np.clip(d @ axis, -1.0, 1.0)) - _STRAY * tremor(self.seed, key, 0.4 * along)
        before, after = _OVERSHOOT * chance(self.seed, key, 1), _OVERSHOOT * chance(self.seed, key, 2)
        from_ends = np.minimum(along + before, 1.0 + after - along)
        pressure = np.sqrt(np.clip(from_ends / _TAPER, 0.0, 1.0))
        half = 0.5 * self.width * thickness * pressure
        line = np.clip(half + 0.5 - np.abs(across) / step, 0.0, np.minimum(2.0 * half, 1.0))
        ink[chosen] = np.maximum(ink[chosen], line)


def _covered(x: Share, low: float | Share, high: float | Share, pixel: Share) -> Share:
    """Share of a pixel around x that lies between low and high."""
    return np.maximum(np.clip((high - x) / pixel + 0.5, 0.0, 1.0) - np.clip((low - x) / pixel + 0.5, 0.0, 1.0), 0.0)


def _lines(u: Vector, w: Vector, middle: np.ndarray, extent: np.ndarray) -> list[Line]:
    """A wall's left edge, its upper and lower one with the skirting, and the frame around its window."""
    away, half = w * _ROOM, abs(u @ _ROOM)

    def at(x: float, y: float) -> Vector:
        return away + x * u + y * _UP

    height = float(_ROOM[1])
    lines = [
        (at(-half, -height), at(-half, height), 1.0),
        (at(-half, height), at(half, height), 1.0),
        (at(-half, -height), at(half, -height), 1.0),
        (at(-half, 0.1 - height), at(half, 0.1 - height), 0.8),
    ]
    left, right = middle[0] - extent[0] - _FRAME, middle[0] + extent[0] + _FRAME
    low, high = middle[1] - extent[1] - _FRAME, middle[1] + extent[1] + _FRAME
    corners = [at(left, low), at(right, low), at(right, high), at(left, high)]
    return lines + [(corners[k], corners[(k + 1) % 4], 1.2) for k in range(4)]
