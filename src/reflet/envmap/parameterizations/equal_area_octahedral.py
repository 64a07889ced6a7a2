"""The equal-area octahedral parameterization: all texels see the same solid angle."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.octahedral import fold, rates_from_squares
from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization


class EqualAreaOctahedral(Parameterization):
    """Each octant fills a triangle evenly; laid out as the octahedral map: +y in the middle [Clarberg08].

    In the octant of positive x, z: with r = sqrt(1 - |y|) and φ = atan2(z, x)·2/π in [0, 1], (s, t) = (r·(1 - φ), r·φ);
    where y < 0 mirrored at the diagonal: (1 - t, 1 - s). Seen from outside.
    """

    name = "equal_area_octahedral"
    kind = 6

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class. 1 - |y| = (x² + z²)/(1 + |y|), which loses nothing near ±y."""
        x, y, z = np.moveaxis(direction / np.linalg.norm(direction, axis=-1, keepdims=True), -1, 0)
        radius = np.sqrt((x * x + z * z) / (1.0 + np.abs(y)))
        phi = np.arctan2(np.abs(z), np.abs(x)) * (2.0 / np.pi)
        t = radius * phi
        s = radius - t
        s, t = np.where(y >= 0.0, s, 1.0 - t), np.where(y >= 0.0, t, 1.0 - s)
        uv = np.stack([0.5 + 0.5 * np.copysign(s, x), 0.5 + 0.5 * np.copysign(t, z)], -1)
        return np.zeros(s.shape, np.int64), uv

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """All of the map is valid. x² + z² = 1 - y² = r²(2 - r²) with 1 - |y| = r²."""
        s, t = 2.0 * uv[..., 0] - 1.0, 2.0 * uv[..., 1] - 1.0
        height = 1.0 - np.abs(s) - np.abs(t)
        radius = 1.0 - np.abs(height)
        at_axis = radius == 0.0
        phi = (0.25 * np.pi) * np.where(at_axis, 1.0, (np.abs(t) - np.abs(s)) / np.where(at_axis, 1.0, radius) + 1.0)
        ring = radius * np.sqrt(2.0 - radius * radius)
        x, z = np.copysign(ring * np.cos(phi), s), np.copysign(ring * np.sin(phi), t)
        y = np.copysign(1.0 - radius * radius, height)
        return np.stack([x, y, z], -1), np.ones(s.shape, bool)

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "1 size size"]:
        """4π/size², all alike."""
        return np.full((1, size, size), 4.0 * np.pi / size**2)

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """1/4π."""
        return np.full(direction.shape[:-1], 0.25 / np.pi)

    def axis_rates(self, direction: Directions) -> AxisRates:
        """From dr/dθ = cos(θ/2)/√2 and r·dφ/sin θ = (2/π)/(√2·cos(θ/2)), θ the angle to the nearer of ±y."""
        x, y, z = np.moveaxis(np.abs(direction), -1, 0)
        square = 0.5 * (1.0 + y)  # of cos(θ/2)
        phi = np.arctan2(z, x) * (2.0 / np.pi)
        # The axis y itself has no azimuth; there φ = 0 stands for any, though the octants' seams meet.
        squares = 0.125 * (square * ((1.0 - phi) ** 2 + phi**2) + 2.0 * (2.0 / np.pi) ** 2 / square)
        return rates_from_squares(squares, self.sampling_rate(direction))

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """As the octahedral map's."""
        return face, *fold(row, column, size)
