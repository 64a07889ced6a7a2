"""The space a PEM is sampled over: named axes, and the camera at each of its points.

A point is a mapping from axis names to coordinates. Samples form the grid of all axes' values; they are numbered in C
order, the last axis fastest. An orbit is a space with the one axis ``azimuth_deg``; adding ``elevation_deg`` or
``distance`` to the axes makes it two- or three-dimensional, and nothing else changes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import prod

import numpy as np

from reflet.errors import RefletError
from reflet.scene.views.camera import Camera, Vec3

VIEW_AXES = ("azimuth_deg", "elevation_deg", "distance")


@dataclass(frozen=True)
class Axis:
    """One named axis with its increasing sample coordinates; without any, the space has no samples.

    An axis is open, or closed: then it repeats after ``period``, and the last sample is the first one's neighbour.
    """

    name: str
    values: tuple[float, ...]
    period: float | None = None

    def __post_init__(self) -> None:
        if any(b <= a for a, b in zip(self.values, self.values[1:], strict=False)):
            raise RefletError(f"Axis {self.name} needs its coordinates in increasing order, not {self.values}.")
        if self.period is not None and not (len(self.values) > 1 and self.period > self.values[-1] - self.values[0]):
            raise RefletError(
                f"Axis {self.name} repeats after {self.period:g}: it needs two coordinates or more within less than "
                f"that, the first not said twice, not {self.values}."
            )

    def coordinate(self, point: Mapping[str, float]) -> float:
        """A point's coordinate: on a closed axis from the first sample to less than a period on; of all equivalent
        azimuths on an open one the closest to its range."""
        x = float(point[self.name])
        if self.period is not None:
            return self.values[0] + (x - self.values[0]) % self.period
        if self.name == "azimuth_deg":
            x += 360.0 * round((0.5 * (self.values[0] + self.values[-1]) - x) / 360.0)
        return x

    def bracket(self, x: float) -> list[tuple[int, float]]:
        """Numbers and positive weights, of sum 1, of the one or two samples about a `coordinate`; outside an open axis
        its end."""
        count = len(self.values)
        values = np.array([*self.values, *([] if self.period is None else [self.values[0] + self.period])])
        low = int(np.clip(np.searchsorted(values, x, side="right") - 1, 0, max(len(values) - 2, 0)))
        high = min(low + 1, len(values) - 1)
        step = values[high] - values[low]
        t = float(np.clip((x - values[low]) / step, 0.0, 1.0)) if step > 0.0 else 0.0
        return [(i % count, w) for i, w in ((low, 1.0 - t), (high, t)) if w > 0.0]

    def closest(self, x: float) -> float:
        """The `coordinate` in the sampled range that is the closest to x, which on a closed axis is x."""
        if self.period is not None:
            return x
        return float(np.clip(x, self.values[0], self.values[-1]))


@dataclass(frozen=True)
class Orbit:
    """Viewpoints around a target. The offset from the target is
    distance·(cos φ cos θ, sin θ, -sin φ cos θ) with azimuth φ and elevation θ."""

    target: Vec3
    azimuth_deg: float
    elevation_deg: float
    distance: float
    fov_deg: float = 36.0
    image_size: int = 512

    def camera(self, point: Mapping[str, float] | None = None) -> Camera:
        """The camera at a point; coordinates that the point lacks are the orbit's own."""
        at = {name: (point or {}).get(name, getattr(self, name)) for name in VIEW_AXES}
        if not at["distance"] > 0.0:
            raise RefletError(f"The camera's distance must be positive, not {at['distance']}.")
        phi, theta = np.radians(at["azimuth_deg"]), np.radians(at["elevation_deg"])
        offset = np.array([np.cos(phi) * np.cos(theta), np.sin(theta), -np.sin(phi) * np.cos(theta)])
        position = np.asarray(self.target) + at["distance"] * offset
        return Camera(
            position=(float(position[0]), float(position[1]), float(position[2])),
            target=self.target,
            fov_deg=self.fov_deg,
            width=self.image_size,
            height=self.image_size,
        )

    def point_of(self, camera: Camera) -> dict[str, float]:
        """The point whose camera stands where ``camera`` does, azimuth in [-180, 180]."""
        x, y, z = np.subtract(camera.position, self.target)
        distance = float(np.sqrt(x * x + y * y + z * z))
        return {
            "azimuth_deg": float(np.degrees(np.arctan2(-z, x))),
            "elevation_deg": float(np.degrees(np.arcsin(y / distance))),
            "distance": distance,
        }


@dataclass(frozen=True)
class ParameterSpace:
    """Axes and the orbit they vary."""

    axes: tuple[Axis, ...]
    orbit: Orbit

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if len(set(names)) < len(names):
            raise RefletError(f"Each axis can be given once; they are {', '.join(names)}.")

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of samples along each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def sample_count(self) -> int:
        """Number of samples."""
        return prod(self.shape)

    def points(self) -> list[dict[str, float]]:
        """All sample points, in order."""
        names = [axis.name for axis in self.axes]
        return [dict(zip(names, values, strict=True)) for values in product(*(axis.values for axis in self.axes))]

    def camera(self, sample: int) -> Camera:
        """The camera of one sample."""
        return self.orbit.camera(self.points()[sample])

    def middle_point(self) -> dict[str, float]:
        """The middle sample's point with all coordinates of a view; the orbit's own where there are no samples."""
        points = self.points()
        return {name: getattr(self.orbit, name) for name in VIEW_AXES} | (points[len(points) // 2] if points else {})

    def displacement_deg(self, point: Mapping[str, float]) -> float:
        """How far a point's camera stands from the sampled range: the distance between it and the camera of the
        closest point of the range, over that one's distance from the target, as an angle. Needs samples."""
        closest = {axis.name: axis.closest(axis.coordinate(point)) for axis in self.axes}
        here, there = self.orbit.camera(point), self.orbit.camera(closest)
        gap = np.linalg.norm(np.subtract(here.position, there.position))
        return float(np.degrees(gap / np.linalg.norm(np.subtract(there.position, self.orbit.target))))

    def blend_weights(self, point: Mapping[str, float]) -> dict[int, float]:
        """Multilinear weights of the samples around a point: at most 2^axes of them, all positive, their sum 1.

        None where the space has no samples. Outside the grid the closest border is taken; closed axes have none.
        """
        if not self.sample_count:
            return {}
        brackets = [axis.bracket(axis.coordinate(point)) for axis in self.axes]
        return {
            int(np.ravel_multi_index([i for i, _ in corner], self.shape)): float(prod(w for _, w in corner))
            for corner in product(*brackets)
        }


def orbit_space(orbit: Orbit, views: int, spacing_deg: float) -> ParameterSpace:
    """``views`` viewpoints on a circle around the target, ``spacing_deg`` apart, the first at the orbit's azimuth. The
    circle is closed where the last of them is no farther than that from the first.

    Raises RefletError for less than no view, a spacing that is not positive, or more than one turn.
    """
    if views < 0 or not spacing_deg > 0.0 or (views - 1) * spacing_deg >= 360.0:
        raise RefletError(
            f"{views} views {spacing_deg:g} degrees apart do not fit an orbit; choose no view or more, a positive "
            "spacing, and less than one turn in all."
        )
    values = tuple(orbit.azimuth_deg + i * spacing_deg for i in range(views))
    closed = views > 1 and views * spacing_deg >= 360.0 * (1.0 - 1e-9)
    return ParameterSpace((Axis("azimuth_deg", values, 360.0 if closed else None),), orbit)
