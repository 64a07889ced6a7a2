"""The dual paraboloid [Heidrich98]: two hemispheres, each seen in a mirror of the shape z = (1 - x² - y²)/2."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.disc import corner_arcs, texels_from_corners
from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization

FACES = ("front", "back")


class DualParaboloid(Parameterization):
    """Face 0 holds z ≥ 0, face 1 the rest; (x, y)/(1 + |z|), u to the right (+x), v down (-y) on both.

    That is (d + d₀)/(d + d₀)·d₀ with d₀ = (0, 0, ±1) [Heidrich00, eq. 8], the stereographic projection: angles are
    kept, texels at the rim see a quarter of the solid angle of those in the middle. Each hemisphere fills the disc
    of its face; beyond the disc the face goes on into the other hemisphere, at the point that inversion in the circle
    gives: (x, y) here is (x, y)/(x² + y²) there. Both are seen from +z: face 0 from outside, as in the mirror, face 1
    from inside.
    """

    name = "dual_paraboloid"
    kind = 2
    face_count = 2
    is_round = True

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class."""
        x, y, z = np.moveaxis(direction / np.linalg.norm(direction, axis=-1, keepdims=True), -1, 0)
        half = 0.5 / (1.0 + np.abs(z))
        return np.where(z >= 0.0, 0, 1), np.stack([0.5 + half * x, 0.5 - half * y], -1)

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """d = (2x, 2y, ±(1 - r²))/(1 + r²); valid inside the disc."""
        x, y = 2.0 * uv[..., 0] - 1.0, 1.0 - 2.0 * uv[..., 1]
        radius_squared = x * x + y * y
        z = np.where(face == 0, 1.0, -1.0) * (1.0 - radius_squared)
        direction = np.stack([2.0 * x, 2.0 * y, z], -1) / (1.0 + radius_squared)[..., None]
        return direction, radius_squared <= 1.0

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "2 size size"]:
        """∮2(x·dy - y·dx)/(1 + r²) around the texel's part inside the disc; dω = 4·dA/(1 + r²)² [Heidrich00, eq. 2].

        Along the edge at x the integrand is 2x/(1 + x² + y²), whose integral is an arc tangent; on the arc it is 1.
        """
        x, y, x_end, y_end, arc = corner_arcs(size)

        def edge(distance: np.ndarray, length: np.ndarray) -> np.ndarray:
            root = np.sqrt(1.0 + distance * distance)
            return 2.0 * distance / root * np.arctan(length / root)

        texels = texels_from_corners(edge(x, y_end) + edge(y, x_end) + arc, size)
        return np.broadcast_to(texels, (2, size, size))

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (1/4)·(1 + r²)²/4 with 1 + r² = 2/(1 + |z|)."""
        return np.asarray(0.25 / (1.0 + np.abs(direction[..., 2])) ** 2)

    def axis_rates(self, direction: Directions) -> AxisRates:
        """The same along all axes: 1/(2(1 + |z|))."""
        rate = 0.5 / (1.0 + np.abs(direction[..., 2]))
        return rate, rate

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """The other face's texel nearest to the inverse point. Where the disc touches the border it is the very one."""
        x, y = (2.0 * column + 1.0) / size - 1.0, (2.0 * row + 1.0) / size - 1.0
        outside = np.maximum(np.abs(x), np.abs(y)) > 1.0
        radius_squared = np.where(outside, x * x + y * y, 1.0)
        inverse_column, inverse_row = (
            np.clip(np.floor((c / radius_squared + 1.0) * (0.5 * size)).astype(np.int64), 0, size - 1) for c in (x, y)
        )
        return (
            np.where(outside, 1 - face, face),
            np.where(outside, inverse_row, row),
            np.where(outside, inverse_column, column),
        )
