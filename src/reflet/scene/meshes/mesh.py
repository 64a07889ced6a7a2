"""A triangle mesh in world space."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt32


@dataclass(frozen=True)
class Mesh:
    """Indexed triangles, counter-clockwise seen from their front. Positions in metres, normals of unit length.

    ``uv`` are texture coordinates with origin top left; ``tangents`` carry glTF's handedness in their fourth
    component. Either may be missing.
    """

    positions: Float32[np.ndarray, "vertices 3"]
    normals: Float32[np.ndarray, "vertices 3"]
    triangles: UInt32[np.ndarray, "triangles 3"]
    uv: Float32[np.ndarray, "vertices 2"] | None = None
    tangents: Float32[np.ndarray, "vertices 4"] | None = None
