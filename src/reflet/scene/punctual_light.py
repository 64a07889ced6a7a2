"""Lights without extent: points, cones of light, and lamps so far away that their rays are parallel.

What they are is glTF's KHR_lights_punctual. Radiance has the scale of the environment's: 1 lux on a white diffuse
surface shows the radiance 1/π, and so does 1 candela a metre away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

from reflet.scene.material import Vec3

LEAST_FADE = 1e-3  # of the cosines between which a cone fades: an edge that is sharper would divide by nothing


@dataclass(frozen=True)
class PunctualLight:
    """A light at ``position``, or, where that is None, infinitely far away, which shines along the unit vector
    ``direction``.

    ``intensity`` is linear red, green and blue in candela, or in lux on what faces a light that is infinitely far away.
    From ``range`` metres on there is nothing of it. With ``cone``, the angles in radians from ``direction`` at which it
    begins to fade and is gone, it is a spot; without, a position shines all around.
    """

    name: str
    intensity: Vec3
    position: Vec3 | None = None
    direction: Vec3 = (0.0, 0.0, -1.0)
    range: float = float("inf")
    cone: tuple[float, float] | None = None


def packed(lights: Sequence[PunctualLight]) -> Float32[np.ndarray, "lights 3 4"]:
    """What tracer and shader know of each light, four numbers at a time: intensity and 1/range; position and 1, or the
    direction towards it and 0; scale·axis and offset, with which a cone lets through the square of clamp(scale·axis·l +
    offset, 0, 1), l the direction towards the light."""
    out = np.zeros((len(lights), 3, 4), np.float32)
    for row, light in zip(out, lights, strict=True):
        axis = -np.asarray(light.direction, np.float64)
        row[0] = *light.intensity, 1.0 / light.range
        row[1] = (*axis, 0.0) if light.position is None else (*light.position, 1.0)
        row[2, 3] = 1.0
        if light.cone is not None:
            inner, outer = np.cos(light.cone)
            scale = 1.0 / max(float(inner - outer), LEAST_FADE)
            row[2] = *(scale * axis), -scale * outer
    return out
