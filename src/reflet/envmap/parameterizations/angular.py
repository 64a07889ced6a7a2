"""The angular map (light probes): the radius is the angle from the middle of the picture, which looks along -z."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.disc import corner_arcs, over_the_rim, texels_from_corners
from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization

_POINTS = 12  # of the quadrature from a quadrant's edge to its other end: exact to rounding
_POLE = 1e-3  # sines below this are taken as this: keeps the sampling rate finite behind


class Angular(Parameterization):
    """(x, y)·θ/(π·|(x, y)|) with θ the angle from -z [Debevec98]; u to the right (+x), v down (-y).

    What lies ahead of a camera looking along -z is in the middle, what lies behind it on the rim. Seen from inside.
    """

    name = "angular"
    kind = 4
    is_round = True

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

        On the arc the integrand is 2. Along straight edges there is no closed form: with dφ = x·dy/r² on the edge at x,
        it is x·(1 - cos πr)/r²·dy, an entire function of r² = x² + y², which Gauss-Legendre quadrature in y integrates
        to rounding.
        """
        x, _, _, y_end, arc = corner_arcs(size)
        edge = np.zeros(x.shape)
        for node, weight in zip(*np.polynomial.legendre.leggauss(_POINTS), strict=True):
            radius = np.hypot(x, 0.5 * (1.0 + node) * y_end)
            # (1 - cos πr)/r² = π²/2·(sin(πr/2)/(πr/2))²
            edge += weight * np.sinc(0.5 * radius) ** 2
        edge *= 0.25 * np.pi**2 * x * y_end
        return texels_from_corners(edge + edge.T + 2.0 * arc, size)[None]

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (1/4)·r·dr/(sin θ·dθ) = θ/(4π²·sin θ)."""
        ring = np.hypot(direction[..., 0], direction[..., 1])
        theta = np.arctan2(ring, -direction[..., 2])
        return np.asarray(np.where(theta < _POLE, 1.0, theta / np.maximum(ring, _POLE)) / (4.0 * np.pi**2))

    def axis_rates(self, direction: Directions) -> AxisRates:
        """1/2π along the radius, θ/(2π·sin θ) across."""
        ring = np.hypot(direction[..., 0], direction[..., 1])
        theta = np.arctan2(ring, -direction[..., 2])
        # In the middle θ and sin θ vanish alike; behind, only sin θ.
        with np.errstate(divide="ignore", invalid="ignore"):
            across = np.where(theta == 0.0, 1.0, theta / ring)
        return np.full(ring.shape, 0.5 / np.pi), across * (0.5 / np.pi)

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """The whole rim is +z: the neighbour lies on the other side of the disc."""
        return face, *over_the_rim(row, column, size)
