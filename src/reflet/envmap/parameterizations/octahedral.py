"""The octahedral parameterization: the directions' octahedron, its lower half folded outward into a square."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization

_Corners = Float[np.ndarray, "cells cells"]


class Octahedral(Parameterization):
    """p = d/(|x| + |y| + |z|) seen from above: +y in the middle, +x right, +z down, -y in the corners [Engelhardt08].

    Where y < 0 the point (p.x, p.z) is mirrored at the square's diagonal edge of its quadrant: (1 - |p.z|, 1 - |p.x|)
    with the signs of p.x and p.z. Seen from outside, all of it.
    """

    name = "octahedral"
    kind = 5

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class."""
        x, y, z = np.moveaxis(direction / np.abs(direction).sum(-1, keepdims=True), -1, 0)
        s = np.where(y >= 0.0, x, np.copysign(1.0 - np.abs(z), x))
        t = np.where(y >= 0.0, z, np.copysign(1.0 - np.abs(x), z))
        return np.zeros(s.shape, np.int64), np.stack([0.5 + 0.5 * s, 0.5 + 0.5 * t], -1)

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """All of the map is valid."""
        s, t = 2.0 * uv[..., 0] - 1.0, 2.0 * uv[..., 1] - 1.0
        y = 1.0 - np.abs(s) - np.abs(t)
        x = np.where(y >= 0.0, s, np.copysign(1.0 - np.abs(t), s))
        z = np.where(y >= 0.0, t, np.copysign(1.0 - np.abs(s), t))
        direction = np.stack([x, y, z], -1)
        return direction / np.linalg.norm(direction, axis=-1, keepdims=True), np.ones(s.shape, bool)

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "1 size size"]:
        """Texels, cut where they cross the octahedron's edges, are flat triangles seen from its centre.

        Whole texels of an even size, quarter ones of an odd size, never cross the axes; each is two triangles. Scratch
        memory: three times the result, of odd sizes twelve times.
        """
        half = size if size % 2 else size // 2  # cells along an edge of one quadrant
        s = np.arange(half + 1) / half
        t = s[:, None]
        y = 1.0 - s - t
        squared_norm = (s + np.minimum(y, 0.0)) ** 2 + y * y + (t + np.minimum(y, 0.0)) ** 2
        right, down = squared_norm[:-1, 1:], squared_norm[1:, :-1]
        quadrant = _triangle(squared_norm[:-1, :-1], right, down, half) + _triangle(
            squared_norm[1:, 1:], right, down, half
        )
        upper = np.concatenate([quadrant[:, ::-1], quadrant], 1)
        cells = np.concatenate([upper[::-1], upper])
        return (cells.reshape(size, 2, size, 2).sum((1, 3)) if size % 2 else cells)[None]

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (1/4)·|p|³, for the faces of the octahedron project onto the square's plane: dω = dA/|p|³."""
        return np.asarray(0.25 / np.abs(direction).sum(-1) ** 3)

    def axis_rates(self, direction: Directions) -> AxisRates:
        """From the gradients of p.x and p.z: (n·x̂ - x·σ)/n², with n = |x| + |y| + |z| and σ the signs of d."""
        x, _, z = np.moveaxis(np.abs(direction), -1, 0)
        n = np.abs(direction).sum(-1)
        squares = 0.25 * (2.0 * n * n - 2.0 * n * (x + z) + 3.0 * (x * x + z * z)) / n**4
        return rates_from_squares(squares, self.sampling_rate(direction))

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """Each half of an edge meets the other half, mirrored at the edge's middle; see `fold`."""
        return face, *fold(row, column, size)


def _triangle(a: _Corners, b: _Corners, c: _Corners, half: int) -> _Corners:
    """Solid angle of triangles on the octahedron with legs of h = 1/half on the map; squared norms of corners.

    2·atan(det(a, b, c)/(|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)) [VanOosterom83]. On the octahedron's faces the
    triangles are equilateral with edges of √2·h, so that a·b = (|a|² + |b|²)/2 - h², and det is h². Nothing cancels.
    """
    square = 1.0 / half**2
    norm_a, norm_b, norm_c = np.sqrt(a), np.sqrt(b), np.sqrt(c)
    below = norm_a * norm_b * norm_c
    below += (0.5 * (a + b) - square) * norm_c
    below += (0.5 * (b + c) - square) * norm_a
    below += (0.5 * (c + a) - square) * norm_b
    return 2.0 * np.arctan2(square, below)


def rates_from_squares(squares: Float[np.ndarray, "*batch"], area: Float[np.ndarray, "*batch"]) -> AxisRates:
    """Singular values of a 2×2 matrix, least first, from the sum of its squares and its determinant."""
    most = np.sqrt(0.5 * (squares + np.sqrt(np.maximum(squares * squares - 4.0 * area * area, 0.0))))
    return area / most, most


def fold(row: Faces, column: Faces, size: int) -> tuple[Faces, Faces]:
    """Rows and columns up to one texel outside an octahedral map, brought inside over its edges."""
    over = (column < 0) | (column >= size)
    column = np.where(column < 0, -1 - column, np.where(column >= size, 2 * size - 1 - column, column))
    row = np.where(over, size - 1 - row, row)
    over = (row < 0) | (row >= size)
    row = np.where(row < 0, -1 - row, np.where(row >= size, 2 * size - 1 - row, row))
    return row, np.where(over, size - 1 - column, column)
