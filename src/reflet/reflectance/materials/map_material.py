"""A map shown as it is: no lighting, but colours looked up by how the surface is turned [Heidrich00, sec. 4]."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from reflet.reflectance.materials.material import BLACK, WHITE, Cosine, SurfaceMaterial, Weights


class Lookup(IntEnum):
    """The direction by which a surface looks up a map; the number is its own in shaders.

    The first two are directions of the world. The others are seen from the viewer: +z points to the eye, from each
    place on the surface anew, +x to the picture's right; so that n.z = 0 is the contour, exactly. A gazing ball looked
    up by view_reflection is the sphere map of old, whose picture is a ball that the viewer sees ("matcap").
    """

    REFLECTION = 0
    NORMAL = 1
    VIEW_REFLECTION = 2
    VIEW_NORMAL = 3


@dataclass(frozen=True)
class MapMaterial(SurfaceMaterial):
    """What the map holds in the direction of ``lookup``.

    A pixel reads the mip level on which a texel is as wide as the pixel's footprint is long, for whatever number of
    samples: levels may differ from each other, drawn by hand.
    """

    kind = 0  # a mirror's, in all but the direction
    lookup: Lookup = Lookup.VIEW_NORMAL

    def weights(self, n_dot_v: Cosine) -> Weights:
        """All of the map, nothing else."""
        ones = np.ones_like(n_dot_v)[..., None]
        return ones * np.asarray(WHITE), ones * np.asarray(BLACK)
