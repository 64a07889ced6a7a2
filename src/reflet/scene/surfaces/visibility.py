"""Which triangle each sub-sample of a picture sees: all that the tracer or the rasterizer needs to say.

Everything else about a sample follows exactly from the triangle and the camera (see `reflet.scene.surfaces.gbuffer`),
so that it does not depend on who found the triangle.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int32, UInt32

from reflet.scene.views.camera import Camera


@dataclass(frozen=True)
class Visibility:
    """Sub-samples that see the front (or either side, if double-sided) of a reflective part.

    Ordered by pixel (row·width + column), then by ``sub_sample``, an index into `sample_positions(sample_count)`.
    ``triangle`` numbers the scene's triangles through all parts.
    """

    camera: Camera
    sample_count: int
    pixel: Int32[np.ndarray, "samples"]
    sub_sample: Int32[np.ndarray, "samples"]
    triangle: UInt32[np.ndarray, "samples"]
