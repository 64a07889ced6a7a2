"""Irradiance over all surfaces, as mesh colours; where normal maps bend normals, its first-order harmonics.

Every triangle carries its own regular grid of samples [Yuksel10]: with resolution R there are (R+1)(R+2)/2 of them, at
the barycentric coordinates (i/R, j/R) of its second and third vertex, i + j ≤ R. Sample (i, j) of a triangle is entry
``offset + i·(2R + 3 - i)/2 + j``. Between samples irradiance is linear in each small triangle. No texture coordinates
are needed, a large wall gets many samples, a small triangle those of its three vertices (R = 1). The samples of a
double-sided triangle's back follow those of its front, in the same order.

**Bent normals.** A radiosity is that of a surface of the interpolated normal n. One of another unit normal m, as a
normal map bends it, shows

    radiosity·max(1 + gradient·(m - n)/Y, 0),

Y being the luminance of the radiosity: a first-order function of m [Ramamoorthi01], exact at n. Its gradient is that
which comes closest to what m sees of the hemisphere above n, for light from any direction and m up to 60° from n
(`gradient_of`). One for all channels is 0.5 dB from three.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32, UInt8, UInt32


@dataclass(frozen=True)
class IrradianceMap:
    """Irradiance/π (the radiance that a perfectly white diffuse surface would show) of a scene's faces.

    ``resolution`` and ``offset`` have one entry per triangle of the scene; a triangle of resolution 0 has no samples
    and no irradiance (perfect mirrors). ``gradient`` is that of its luminance by the normal, in the world, for each
    sample, 0 where nothing bends normals; or it has no rows at all. Where the scene has lights without extent,
    ``visibility`` is the share of each of them that is seen from each sample, 255 where nothing hides it; else it is
    empty.
    """

    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    radiosity: Float32[np.ndarray, "samples 3"]
    gradient: Float32[np.ndarray, "bent_samples 3"] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    visibility: UInt8[np.ndarray, "lit_samples lights"] = field(default_factory=lambda: np.zeros((0, 0), np.uint8))
