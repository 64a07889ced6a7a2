"""The lat-long parameterization: u is the azimuth, v the angle from +y; +x in the middle."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization

_POLE = 1e-3  # sines below this are taken as this: keeps the sampling rate finite at the poles


class LatLong(Parameterization):
    """u = 1/2 + atan2(z, x)/2π, v = acos(y)/π. Twice as wide as high; a row at a pole is but a point.

    Seen from inside: +z lies to the right of +x.
    """

    name = "latlong"
    kind = 1
    aspect = 2

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class; v follows from atan2 too, which keeps it exact near the poles."""
        x, y, z = np.moveaxis(direction, -1, 0)
        u = 0.5 + np.arctan2(z, x) / (2.0 * np.pi)
        v = np.arctan2(np.hypot(x, z), y) / np.pi
        return np.zeros(u.shape, np.int64), np.stack([u, v], -1)

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """All of the map is valid."""
        phi, theta = (uv[..., 0] - 0.5) * (2.0 * np.pi), uv[..., 1] * np.pi
        ring = np.sin(theta)
        direction = np.stack([ring * np.cos(phi), np.cos(theta), ring * np.sin(phi)], -1)
        return direction, np.ones(phi.shape, bool)

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "1 size columns"]:
        """Δφ·(cos θ₀ - cos θ₁), by the sine of half differences: no cancellation at the poles."""
        theta = np.pi * (np.arange(size) + 0.5) / size
        row = (np.pi / size) * 2.0 * np.sin(theta) * np.sin(0.5 * np.pi / size)
        return np.broadcast_to(row[None, :, None], self.shape(size))

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (2·1)/(2π·π·sin θ)."""
        ring = np.hypot(direction[..., 0], direction[..., 2])
        return np.asarray(1.0 / (np.pi**2 * np.maximum(ring, _POLE)))

    def axis_rates(self, direction: Directions) -> AxisRates:
        """1/π along the meridians, 1/(π·sin θ) along the parallels."""
        ring = np.hypot(direction[..., 0], direction[..., 2])
        with np.errstate(divide="ignore"):
            return np.full(ring.shape, 1.0 / np.pi), np.asarray(1.0 / (np.pi * ring))

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """Around in u; over a pole half way around, in the same row."""
        beyond = (row < 0) | (row >= size)
        row = np.where(row < 0, -1 - row, np.where(row >= size, 2 * size - 1 - row, row))
        return face, row, np.mod(column + size * beyond, 2 * size)
