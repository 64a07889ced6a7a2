"""A lamp at infinity: a soft disc of light that environments get added.

With x = |d − l|² = 2(1 − cos θ), θ between a direction and the lamp's, dω = π·dx: solid angles are linear in x. The
disc's edge is a smoothstep in x, from half of what belongs to its radius to once and a half. Steps that are odd about
their middle leave the integral alone: the lamp has the solid angle of a disc with a sharp edge, 2π(1 − cos radius).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError


@dataclass(frozen=True)
class Lamp:
    """``direction`` of any length leads to its middle; ``radius_deg`` is from 1 to 60; ``radiance`` is added.

    The device's twin is `shaders/lamp.wgsl`. Raises RefletError for what is out of range.
    """

    direction: tuple[float, float, float]
    radius_deg: float = 8.0
    radiance: tuple[float, float, float] = (20.0, 20.0, 20.0)

    def __post_init__(self) -> None:
        if not 1.0 <= self.radius_deg <= 60.0:
            raise RefletError(f"A lamp's radius is 1° to 60°, not {self.radius_deg:g}°.")
        if not 0.0 < float(np.linalg.norm(self.direction)) < np.inf:
            raise RefletError(f"A lamp needs a direction, and {self.direction} is none.")
        if not (np.isfinite(self.radiance).all() and min(self.radiance) >= 0.0):
            raise RefletError(f"A lamp's radiance is finite and not negative; {self.radiance} came.")

    @property
    def unit_direction(self) -> Float[np.ndarray, "3"]:
        """Of length 1."""
        return np.array(self.direction) / np.linalg.norm(self.direction)

    @property
    def square_chord(self) -> float:
        """x at its radius."""
        return float(4.0 * np.sin(np.radians(self.radius_deg) / 2.0) ** 2)

    def share(self, direction: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch"]:
        """Of its radiance that comes from a unit direction: 1 in the disc, 0 outside."""
        x = np.square(direction - self.unit_direction).sum(-1) / self.square_chord
        step = np.clip(1.5 - x, 0.0, 1.0)
        return np.asarray(step * step * (3.0 - 2.0 * step))
