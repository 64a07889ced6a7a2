"""Irradiance over all surfaces, as mesh colours.

Every triangle carries its own regular grid of samples [Yuksel10]: with resolution R there are (R+1)(R+2)/2 of them, at
the barycentric coordinates (i/R, j/R) of its second and third vertex, i + j ≤ R. Sample (i, j) of a triangle is entry
``offset + i·(2R + 3 - i)/2 + j``. Between samples irradiance is linear in each small triangle. No texture coordinates
are needed, a large wall gets many samples, a small triangle those of its three vertices (R = 1). The samples of a
double-sided triangle's back follow those of its front, in the same order.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt32


@dataclass(frozen=True)
class IrradianceMap:
    """Irradiance/π (the radiance that a perfectly white diffuse surface would show) of a scene's faces.

    ``resolution`` and ``offset`` have one entry per triangle of the scene; a triangle of resolution 0 has no samples
    and no irradiance (perfect mirrors).
    """

    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    radiosity: Float32[np.ndarray, "samples 3"]
