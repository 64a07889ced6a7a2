"""The gazing ball (OpenGL's sphere map): what an orthographic viewer at +z sees in a small mirror ball."""

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.parameterizations.disc import over_the_rim, rectangle_in_disc
from reflet.envmap.parameterizations.parameterization import UV, AxisRates, Directions, Faces, Parameterization


class GazingBall(Parameterization):
    """(x, y) of the halfway vector h between a direction and +z [Heidrich00, sec. 2.1].

    With h = (d + ẑ)/|d + ẑ|, u = (1 + h.x)/2 and v = (1 - h.y)/2. The whole rim is one direction, -z, and around it the
    map has next to no resolution along the radius: the map serves viewers near +z, whose mirrored rays seldom go there.
    By area it is nonetheless even: dω = 4·dA on the unit disc, the azimuthal equal-area projection of Lambert. Seen
    from outside, as in the mirror.
    """

    name = "gazing_ball"
    kind = 3
    is_round = True
    is_view_dependent = True

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """See the class. |h.xy| = sin(θ/2) and h.z = cos(θ/2), θ the angle to +z; -z goes to the rim's right end."""
        x, y, z = np.moveaxis(direction / np.linalg.norm(direction, axis=-1, keepdims=True), -1, 0)
        ring = np.hypot(x, y)
        radius = np.sin(0.5 * np.arctan2(ring, z))
        at_axis = ring == 0.0
        safe = np.where(at_axis, 1.0, ring)
        cosine, sine = np.where(at_axis, 1.0, x / safe), np.where(at_axis, 0.0, y / safe)
        uv = np.stack([0.5 + 0.5 * radius * cosine, 0.5 - 0.5 * radius * sine], -1)
        return np.zeros(ring.shape, np.int64), uv

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """d = 2(h·ẑ)h - ẑ; outside the disc at radius r, past -z, that of the other side at 2 - r."""
        x, y = 2.0 * uv[..., 0] - 1.0, 1.0 - 2.0 * uv[..., 1]
        radius = np.hypot(x, y)
        scale = np.where(radius > 1.0, 1.0 - 2.0 / np.maximum(radius, 1.0), 1.0)
        x, y = scale * x, scale * y
        height = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
        direction = np.stack([2.0 * height * x, 2.0 * height * y, 2.0 * height * height - 1.0], -1)
        return direction, radius <= 1.0

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "1 size size"]:
        """Four times the texel's area inside the unit disc."""
        return 4.0 * rectangle_in_disc(size)[None]

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """(1/4)/4: the same everywhere; along the radius it falls to 0 at the rim, and rises across."""
        return np.full(direction.shape[:-1], 1.0 / 16.0)

    def axis_rates(self, direction: Directions) -> AxisRates:
        """cos(θ/2)/4 along the radius sin(θ/2), 1/(4·cos(θ/2)) across; θ the angle to +z."""
        ring = np.hypot(direction[..., 0], direction[..., 1])
        cosine = np.sin(
            0.5 * np.arctan2(ring, -direction[..., 2])
        )  # of θ/2: the sine of half the rest, exact at the rim
        with np.errstate(divide="ignore"):
            return 0.25 * cosine, np.asarray(0.25 / cosine)

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """The whole rim is -z: the neighbour lies on the other side of the disc."""
        return face, *over_the_rim(row, column, size)
