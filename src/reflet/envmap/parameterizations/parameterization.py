"""What a parameterization is: how directions become texture coordinates.

A map is stored as one or more *faces*, all of ``size`` rows and ``aspect·size`` columns. A face's ``uv`` lies in
[0, 1]², origin top left; texel (row, column) has its centre at ``((column + 0.5)/columns, (row + 0.5)/rows)``. Geometry
and parameterization are independent of each other [Hakura01, sec. 4].
"""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float, Int

Directions = Float[np.ndarray, "*batch 3"]
UV = Float[np.ndarray, "*batch 2"]
AxisRates = tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]
Faces = Int[np.ndarray, "*batch"]

NONE = -1  # the face of a texel that is not there: beyond a corner of the cube


class Parameterization(ABC):
    """One way of laying all directions out flat. Instances hold nothing: two of one class are equal.

    A face shows the sphere of directions from inside, as a camera in its centre does, or from outside, as a globe, or
    a mirror, does: from inside, (∂d/∂u, ∂d/∂v, d) is right-handed. Each class says which.
    """

    name: ClassVar[str]
    kind: ClassVar[int]  # its number in compiled kernels and shaders
    face_count: ClassVar[int] = 1
    aspect: ClassVar[int] = 1  # columns over rows of a face
    is_round: ClassVar[bool] = False  # whether only the disc inscribed in each face is valid
    is_view_dependent: ClassVar[bool] = False  # whether a map serves only the viewing direction it was made for

    @abstractmethod
    def uv_from_direction(self, direction: Directions) -> tuple[Faces, UV]:
        """Face and uv of directions of any length but zero."""

    @abstractmethod
    def direction_from_uv(self, face: Faces, uv: UV) -> tuple[Directions, Bool[np.ndarray, "*batch"]]:
        """Unit directions, and whether `uv_from_direction` leads back to the same place.

        Where it does not, outside the disc of a round map, the direction is the map's own continuation.
        """

    @abstractmethod
    def texel_solid_angle(self, size: int) -> Float[np.ndarray, "faces size columns"]:
        """Exact solid angle in steradians of the valid part of each texel; the sum over a map is 4π."""

    @abstractmethod
    def sampling_rate(self, direction: Directions) -> Float[np.ndarray, "*batch"]:
        """Texels per steradian around unit directions, in a map of size 1; times size² in one of any size."""

    @abstractmethod
    def axis_rates(self, direction: Directions) -> AxisRates:
        """Texels per radian along the worst and the best axis around unit directions, in a map of size 1.

        These are the singular values of d(uv·texels)/d(direction); their product is the sampling rate. 0 and infinity
        at poles and rims are not clamped.
        """

    @abstractmethod
    def across_seams(self, face: Faces, row: Faces, column: Faces, size: int) -> tuple[Faces, Faces, Faces]:
        """Face, row and column of the texels at places up to one texel outside a face: their neighbours over the seam.

        Places inside are returned as they are. The face is `NONE` where there is no texel.
        """

    def shape(self, size: int) -> tuple[int, int, int]:
        """(faces, rows, columns) of a map of this size."""
        return self.face_count, size, self.aspect * size

    def texel_directions(
        self, size: int
    ) -> tuple[Float[np.ndarray, "faces size columns 3"], Bool[np.ndarray, "faces size columns"]]:
        """`direction_from_uv` of all texel centres."""
        faces, rows, columns = self.shape(size)
        face, v, u = np.meshgrid(
            np.arange(faces), (np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij"
        )
        return self.direction_from_uv(face, np.stack([u, v], -1))

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other)

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return self.name
