"""Geometries: what stands for the environment's distances when an env map is looked up [Hakura01, sec. 4].

`shapes` are given by a few numbers, a `relief` by a map of distances. Every geometry packs into the same twelve floats
(`pack`), which shaders and kernels share: ``[kind, a.xyz, c, b.xyz, 0, origin.xyz]``, with a, b the corners of the box
(of a relief's, where the search starts) or centre and radii, and c the floor's height or a relief's `Relief.limit`.
"""

import numpy as np
from jaxtyping import Float

from reflet.envmap.relief import Relief
from reflet.envmap.shapes import Box, Ellipsoid, Hemisphere, InfiniteSphere, Points, Sphere

INFINITE_SPHERE, SPHERE, ELLIPSOID, BOX, HEMISPHERE, RELIEF = range(6)

Shape = InfiniteSphere | Sphere | Ellipsoid | Box | Hemisphere
Geometry = Shape | Relief
SHAPES: dict[str, type] = {g.kind: g for g in (InfiniteSphere, Sphere, Ellipsoid, Box, Hemisphere)}
KINDS: dict[str, type] = {**SHAPES, Relief.kind: Relief}


def lookup_directions(geometry: Geometry, p: Points, r: Points) -> Points:
    """Lookup directions of samples and, behind them, of their neighbours: (3, n, 3) of any length.

    A relief's neighbours meet the plane through the sample's own hit (`Relief.lookup_directions`); other geometries
    meet each ray alone.
    """
    return geometry.lookup_directions(p, r) if isinstance(geometry, Relief) else geometry.lookup_direction(p, r)


def pack(geometry: Geometry) -> Float[np.ndarray, "12"]:
    """The twelve float32 that shaders and compiled kernels read; see the module's text."""
    out = np.zeros(12, np.float32)
    match geometry:
        case InfiniteSphere():
            out[0] = INFINITE_SPHERE
        case Box():
            out[0], out[1:4], out[5:8], out[9:12] = BOX, geometry.lower, geometry.upper, geometry.origin
        case Hemisphere():
            out[0], out[1:4], out[4] = HEMISPHERE, geometry.centre, geometry.floor
            out[5:8], out[9:12] = geometry.radii, geometry.origin
        case Relief():
            out[0], out[1:4], out[4] = RELIEF, geometry.lower, geometry.limit
            out[5:8], out[9:12] = geometry.upper, geometry.origin
        case Ellipsoid():
            out[0] = SPHERE if isinstance(geometry, Sphere) else ELLIPSOID
            out[1:4], out[5:8], out[9:12] = geometry.centre, geometry.radii, geometry.origin
    return out
