"""A triangle mesh in world space."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Integer, UInt32

MOST_UV = 4  # sets of texture coordinates of one mesh: as many as a material has textures, but for those of a coat


@dataclass(frozen=True)
class Mesh:
    """Indexed triangles, counter-clockwise seen from their front. Positions in metres, normals of unit length.

    ``uv`` are texture coordinates with origin top left, ``more_uv`` up to `MOST_UV` - 1 further sets of them, for
    textures that lie differently; ``tangents`` carry glTF's handedness in their fourth component. ``colors`` are linear
    red, green, blue and alpha from 0 to 1, which the material's base colour and alpha are multiplied by. Any of them
    may be missing.
    """

    positions: Float32[np.ndarray, "vertices 3"]
    normals: Float32[np.ndarray, "vertices 3"]
    triangles: UInt32[np.ndarray, "triangles 3"]
    uv: Float32[np.ndarray, "vertices 2"] | None = None
    tangents: Float32[np.ndarray, "vertices 4"] | None = None
    colors: Float32[np.ndarray, "vertices 4"] | None = None
    more_uv: tuple[Float32[np.ndarray, "vertices 2"], ...] = ()

    def uv_set(self, number: int) -> Float32[np.ndarray, "vertices 2"] | None:
        """Texture coordinates number 0 (``uv``), 1, …; None where the mesh has none."""
        return (self.uv, *self.more_uv)[number]

    def picked(self, vertices: Integer[np.ndarray, "picked"], triangles: UInt32[np.ndarray, "triangles 3"]) -> "Mesh":
        """The mesh of these vertices, in this order, and of triangles between them."""
        uv, tangents, colors = (
            None if values is None else values[vertices] for values in (self.uv, self.tangents, self.colors)
        )
        more_uv = tuple(uv[vertices] for uv in self.more_uv)
        return Mesh(self.positions[vertices], self.normals[vertices], triangles, uv, tangents, colors, more_uv)
