"""The plainest light there is: a sky, a ground and a sun without shadows, for scenes that move."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class SkyLight:
    """Uniform radiance from above and from below, and a distant sun; nothing shades anything else.

    ``sky`` and ``ground`` are radiance; ``sun`` is what a white diffuse surface shows that faces ``towards_sun``, a
    unit vector: irradiance/π.
    """

    sky: Vec3 = (1.0, 1.0, 1.0)
    ground: Vec3 = (0.4, 0.4, 0.4)
    sun: Vec3 = (0.0, 0.0, 0.0)
    towards_sun: Vec3 = (0.0, 1.0, 0.0)

    def irradiance_over_pi(self, normal: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
        """What a white diffuse surface of this unit normal shows.

        A surface tilted by θ from the vertical sees the share (1 + cos θ)/2 of its cosine-weighted hemisphere above the
        horizon: half of the disc that Nusselt's projection makes, and half of the disc foreshortened.
        """
        up = 0.5 + 0.5 * normal[..., 1:2]
        facing = np.maximum(normal @ np.asarray(self.towards_sun), 0.0)[..., None]
        return np.asarray(up * self.sky + (1.0 - up) * np.asarray(self.ground) + facing * np.asarray(self.sun))


OVERCAST = SkyLight()
