"""Rotations of environments and scenes: about the vertical, or from another axis up to +y."""

from types import MappingProxyType

import numpy as np
from jaxtyping import Float

Rotation = Float[np.ndarray, "3 3"]

UNTURNED: Rotation = np.eye(3)
UNTURNED.setflags(write=False)
_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_Z_UP.setflags(write=False)

SOURCE_FROM_UPRIGHT = MappingProxyType({"y": UNTURNED, "z": _Z_UP})
"""By the axis that points up in a source: +z becomes +y, +y becomes -z, and +x stays, as exporters to glTF have it."""


def turn_about_vertical(degrees: float) -> Rotation:
    """``source_from_result`` of an environment turned counter-clockwise, seen from above."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
