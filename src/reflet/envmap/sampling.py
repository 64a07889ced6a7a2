"""How evenly a parameterization samples the sphere of directions: by area, and along its worst and best axis.

All rates are those of maps with equal numbers of texels, relative to a map that would spread them evenly: N texels see
N/4π a steradian and sqrt(N/4π) a radian there. Texels outside the discs of round maps do not count, for nothing looks
them up.

The papers say of the sphere map that its rate goes to zero towards the viewing direction [Heidrich98, sec. 2;
Heidrich00, sec. 2.1]. By area it is constant: with the angle θ to +z the map's radius is sin(θ/2), Lambert's equal-area
projection. It is the rate along the radius, cos(θ/2), that goes to zero, and the rate across, 1/cos(θ/2), that grows
without bound: its texels see ever longer and thinner pieces of the sphere.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.parameterizations.parameterization import Parameterization

# The direction around which each map is laid out: the middle of the picture, or where its parallels close.
_AXES = {
    "cube": (0, 0, 1),
    "latlong": (0, 1, 0),
    "dual_paraboloid": (0, 0, 1),
    "gazing_ball": (0, 0, 1),
    "angular": (0, 0, -1),
    "octahedral": (0, 1, 0),
    "equal_area_octahedral": (0, 1, 0),
}


@dataclass(frozen=True)
class SamplingRates:
    """Rates around directions at ``angle`` from ``axis`` (radians, rows) and around it (columns); 1 is even.

    ``area`` is relative texels a steradian, ``least`` and ``most`` are relative texels a radian along the worst and the
    best axis. The extremes are over the whole sphere: the grid, and the axes, edges and corners where rates peak.
    """

    parameterization: str
    axis: tuple[int, int, int]
    angle: Float[np.ndarray, "angles"]
    area: Float[np.ndarray, "angles azimuths"]
    least: Float[np.ndarray, "angles azimuths"]
    most: Float[np.ndarray, "angles azimuths"]
    area_extremes: tuple[float, float]
    axis_extremes: tuple[float, float]
    longest_texel: float  # largest ratio of a texel's length to its width, as the sphere sees it

    @property
    def area_ratio(self) -> float:
        """Largest over smallest rate by area."""
        return self.area_extremes[1] / self.area_extremes[0]

    @property
    def cost(self) -> float:
        """How many times the texels of an even map it takes to resolve as much everywhere along every axis."""
        return 1.0 / self.axis_extremes[0] ** 2 if self.axis_extremes[0] > 0.0 else float("inf")


def analyze(parameterization: Parameterization, angles: int = 180, azimuths: int = 360) -> SamplingRates:
    """The rates on a grid of ``angles`` × ``azimuths`` directions, at the middle of each cell."""
    axis = np.array(_AXES[parameterization.name], float)
    angle = np.pi * (np.arange(angles) + 0.5) / angles
    azimuth = 2.0 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    side = np.roll(axis, 1)
    around = np.cos(azimuth)[:, None] * side + np.sin(azimuth)[:, None] * np.cross(axis, side)
    grid = np.cos(angle)[:, None, None] * axis + np.sin(angle)[:, None, None] * around
    area, least, most = _relative_rates(parameterization, grid)

    peaks = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), -1).reshape(-1, 3)
    peaks = peaks[np.any(peaks != 0.0, -1)]
    at_peaks = _relative_rates(parameterization, peaks / np.linalg.norm(peaks, axis=-1, keepdims=True))
    all_area, all_least, all_most = (
        np.concatenate([a.ravel(), b]) for a, b in zip((area, least, most), at_peaks, strict=True)
    )
    with np.errstate(divide="ignore"):
        longest = all_most / all_least
    return SamplingRates(
        parameterization=parameterization.name,
        axis=_AXES[parameterization.name],
        angle=angle,
        area=area,
        least=least,
        most=most,
        area_extremes=(float(all_area.min()), float(all_area.max())),
        axis_extremes=(float(all_least.min()), float(all_most.max())),
        longest_texel=float(longest.max()),
    )


def _relative_rates(
    parameterization: Parameterization, direction: Float[np.ndarray, "*batch 3"]
) -> tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]:
    """By area, along the worst axis, along the best, over those of an even map of as many texels."""
    even = valid_texels(parameterization) / (4.0 * np.pi)
    least, most = parameterization.axis_rates(direction)
    # The product says more than `sampling_rate`, which is clamped at poles; only 0 times infinity says nothing.
    with np.errstate(invalid="ignore"):
        area = least * most
    area = np.where(np.isnan(area), parameterization.sampling_rate(direction), area)
    return area / even, least / np.sqrt(even), most / np.sqrt(even)


def valid_texels(parameterization: Parameterization) -> float:
    """The texels that directions lead to in a map of size 1: its area, or that of its discs."""
    faces, rows, columns = parameterization.shape(1)
    return faces * rows * columns * (np.pi / 4.0 if parameterization.is_round else 1.0)
