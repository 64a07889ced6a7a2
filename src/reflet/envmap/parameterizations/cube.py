"""The cube parameterization: the one face table of the project.

Faces come in the order px nx py ny pz nz with WebGPU's orientation. On every face ``s`` grows to the right and ``t``
downwards, both in [-1, 1], so that texel (row, column) of a face of N texels has its centre at
``s = (2·column + 1)/N - 1`` and ``t = (2·row + 1)/N - 1``.
"""

import numpy as np
from jaxtyping import Bool, Float, Int

from reflet.envmap.parameterizations.parameterization import NONE, UV, AxisRates, Directions, Faces, Parameterization

FACES = ("px", "nx", "py", "ny", "pz", "nz")

# direction = AXES[face, 0] + s·AXES[face, 1] + t·AXES[face, 2]
AXES = np.array(
    [
        [[1, 0, 0], [0, 0, -1], [0, -1, 0]],
        [[-1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
        [[0, -1, 0], [1, 0, 0], [0, 0, -1]],
        [[0, 0, 1], [1, 0, 0], [0, -1, 0]],
        [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
    ],
    dtype=np.float64,
)
AXES.setflags(write=False)


def direction_from_face(
    face: Int[np.ndarray, "*batch"], s: Float[np.ndarray, "*batch"], t: Float[np.ndarray, "*batch"]
) -> Float[np.ndarray, "*batch 3"]:
    """Direction through the point (s, t) of a cube face; its largest component is ±1 where |s|, |t| ≤ 1.

    Not normalized. Points beyond the face's edge (|s| or |t| > 1) give the direction on the extended face plane.
    """
    axes = AXES[face]
    return axes[..., 0, :] + s[..., None] * axes[..., 1, :] + t[..., None] * axes[..., 2, :]


def face_from_direction(
    direction: Float[np.ndarray, "*batch 3"],
) -> tuple[Int[np.ndarray, "*batch"], Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]:
    """Face index and (s, t) in [-1, 1] that a direction of any length (not zero) meets.

    Ties go to x before y before z, and to the positive face, as in the shaders.
    """
    magnitude = np.abs(direction)
    x, y, z = magnitude[..., 0], magnitude[..., 1], magnitude[..., 2]
    axis = np.where((x >= y) & (x >= z), 0, np.where(y >= z, 1, 2))
    major = np.take_along_axis(direction, axis[..., None], -1)[..., 0]
    face = 2 * axis + (major < 0)
    axes = AXES[face]
    scale = 1.0 / np.abs(major)
    s = np.einsum("...i,...i->...", direction, axes[..., 1, :]) * scale
    t = np.einsum("...i,...i->...", direction, axes[..., 2, :]) * scale
    return face, s, t


def texel_directions(size: int) -> Float[np.ndarray, "6 size size 3"]:
    """Unit directions of all texel centres of a cube of ``size``² texels a face."""
    centre = (2.0 * np.arange(size) + 1.0) / size - 1.0
    s, t = centre[None, :, None], centre[:, None, None]
    to_face, to_right, down = (AXES[:, None, None, k] for k in range(3))
    return (to_face + s * to_right + t * down) / np.sqrt(1.0 + s * s + t * t)


def texel_solid_angle(size: int) -> Float[np.ndarray, "size size"]:
    """Exact solid angle in steradians of each texel of one face (all faces are alike).

    The solid angle from the face's centre to (s, t) is atan(s·t / sqrt(s² + t² + 1)); a texel's is the alternating sum
    over its four corners. Six times the sum over the face is 4π.
    """
    edge = 2.0 * np.arange(size + 1) / size - 1.0
    s, t = edge[None, :], edge[:, None]
    corner = np.arctan2(s * t, np.sqrt(s * s + t * t + 1.0))
    return corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]


class Cube(Parameterization):
    """Six perspective pictures, [Heidrich00, sec. 2.2]; u = (1 + s)/2, v = (1 + t)/2 on every face.

    Seen from outside, all six: the left-handed orientation that graphics APIs prescribe.
    """

    name = "cube"
    kind = 0
    face_count = 6

    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """`face_from_direction`."""
        face, s, t = face_from_direction(direction)
        return face, np.stack([0.5 + 0.5 * s, 0.5 + 0.5 * t], -1)

    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """All of the map is valid."""
        direction = direction_from_face(face, 2.0 * uv[..., 0] - 1.0, 2.0 * uv[..., 1] - 1.0)
        return direction / np.linalg.norm(direction, axis=-1, keepdims=True), np.ones(face.shape, bool)

    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "6 size size"]:
        """The function of the same name, for all faces."""
        return np.broadcast_to(texel_solid_angle(size), (6, size, size))

    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """dA/dω = (1/4)/m³ with m the largest component: dω = ds·dt/(1 + s² + t²)^1.5."""
        return np.asarray(0.25 / np.abs(direction).max(-1) ** 3)

    def axis_rates(self, direction: Directions) -> AxisRates:
        """1/2m across and 1/2m² away from the face's middle, m the largest component: a central projection's."""
        largest = np.abs(direction).max(-1)
        return 0.5 / largest, 0.5 / largest**2

    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """The nearest texel of the neighbouring face; beyond a corner, where only three faces meet, none."""
        s, t = (2.0 * column + 1.0) / size - 1.0, (2.0 * row + 1.0) / size - 1.0
        # Just outside the edge, the nearest texel of the neighbouring face is the one that shares the edge.
        beyond = 1.0 + 1e-6
        on, s_on, t_on = face_from_direction(
            direction_from_face(face, np.clip(s, -beyond, beyond), np.clip(t, -beyond, beyond))
        )
        column_on, row_on = (np.clip(((c + 1.0) * (0.5 * size)).astype(np.int64), 0, size - 1) for c in (s_on, t_on))
        corner = (np.abs(s) > 1.0) & (np.abs(t) > 1.0)
        return np.where(corner, NONE, on), row_on, column_on


CUBE = Cube()
