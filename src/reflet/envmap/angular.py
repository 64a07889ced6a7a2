"""The angular map (light probes): the radius is the angle from the middle of the picture, which looks along -z."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.disc import corner_arcs, texels_from_corners
from reflet.envmap.parameterization import UV, Directions, Faces, Parameterization

_POINTS = 32  # of the quadrature along the edges of a quadrant: exact to rounding, the integrand is smooth
_POLE = 1e-3  # sines below this are taken as this: keeps the sampling rate finite behind


class Angular(Parameterization):
    """(x, y)·θ/(π·|(x, y)|) with θ the angle from -z [Debevec98]; u to the right (+x), v down (-y).

    What lies ahead of a camera looking along -z is in the middle, what lies behind it on the rim.
    """

    name = "angular"
    kind = 4

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class; +z goes to the rim's right end."""
        x, y, z = np.moveaxis(direction, -1, 0)
        ring = np.hypot(x, y)
        radius = np.arctan2(ring, -z) / np.pi
        at_axis = ring == 0.0
        safe = np.where(at_axis, 1.0, ring)
        cosine, sine = np.where(at_axis, 1.0, x / safe), np.where(at_axis, 0.0, y / safe)
        uv = np.stack([0.5 + 0.5 * radius * cosine, 0.5 - 0.5 * radius * sine], -1)
        return np.zeros(ring.shape, np.int64), uv

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """Outside the disc the angle grows on beyond π."""
        x, y = 2.0 * uv[..., 0] - 1.0, 1.0 - 2.0 * uv[..., 1]
        radius = np.hypot(x, y)
        # sin(πr)/r → π in the middle
        scale = np.pi * np.sinc(radius)
        direction = np.stack([scale * x, scale * y, -np.cos(np.pi * radius)], -1)
        return direction, radius <= 1.0

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "1 size size"]:
        """∮(1 - cos πr)·dφ around the texel's part inside the disc; dω = sin θ·dθ·dφ, θ = πr.

        There is no closed form along straight edges: Gauss-Legendre quadrature in the angle φ, where the edge at
        distance x has r = x/cos φ. On the arc the integrand is 2.
        """
        x, y, x_end, y_end, arc = corner_arcs(size)
        node, weight = np.polynomial.legendre.leggauss(_POINTS)

        def edge(distance: np.ndarray, length: np.ndarray) -> np.ndarray:
            half = 0.5 * np.arctan2(length, distance)
            radius = distance[..., None] / np.cos(half[..., None] * (1.0 + node))
            return ((1.0 - np.cos(np.pi * radius)) @ weight) * half

        return texels_from_corners(edge(x, y_end) + edge(y, x_end) + 2.0 * arc)[None]

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (1/4)·r·dr/(sin θ·dθ) = θ/(4π²·sin θ)."""
        ring = np.hypot(direction[..., 0], direction[..., 1])
        theta = np.arctan2(ring, -direction[..., 2])
        return np.asarray(np.where(theta < _POLE, 1.0, theta / np.maximum(ring, _POLE)) / (4.0 * np.pi**2))

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """The disc touches the border in four points only; there the nearest texel stands for its neighbour."""
        return face, np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)
