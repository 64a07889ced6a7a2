"""Importance sampling of all that emits: triangles by their power, the environment light by its radiance."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.holes import opacity
from reflet.trace.sampling import R2
from reflet.trace.surface import environment_radiance, luminance, sky_lookup, surface_at

BRIGHTER = 1.0 + 1e-6  # than the mean, beyond rounding
PROBES = 16  # points a triangle at which its emission is averaged for its share of the samples


@dataclass
class LightSample:
    """Directions towards emitters, their densities per steradian, and the radiance from there if nothing blocks.

    ``distance`` is how far the ray may go unblocked. ``surface`` is that of an emitting triangle, where there are any
    and ``on_triangle`` says that one was chosen.
    """

    direction: Any
    distance: Any
    density: Any
    radiance: Any
    surface: Any
    on_triangle: Any


class Emitters:
    """All emitters of a scene. Triangles and the environment, where both emit, get half of the samples each.

    ``compensated`` chooses directions of the environment by how much brighter than its mean they are, for use beside
    samples that see all of it well enough but what is bright [Karlik19]; an even sky then has no share.
    """

    def __init__(self, device: DeviceScene, compensated: bool = False) -> None:
        self.device = device
        power, area = _triangle_power(device)
        self.has_triangles = bool(power.any())
        light = device.scene.environment
        if light is not None:
            height, width = light.radiance.shape[:2]
            sine = np.sin((np.arange(height) + 0.5) * np.pi / height)[:, None]
            brightness = light.radiance.mean(-1, dtype=np.float64)
            if compensated:
                mean = float((brightness * sine).sum() / (width * sine.sum()))
                brightness = np.maximum(brightness - BRIGHTER * mean, 0.0)
            weight = brightness * sine
        self.has_environment = light is not None and bool(weight.any())
        self.any = self.has_triangles or self.has_environment
        self.environment_share = float(self.has_environment) / (1.0 + float(self.has_triangles))
        if self.has_triangles:
            lit = np.flatnonzero(power)
            chance = power / power.sum() * (1.0 - self.environment_share)
            self.triangles = mi.UInt32(lit.astype(np.uint32))
            self.choice = mi.DiscreteDistribution(mi.Float(power[lit].astype(np.float32)))
            self.density = mi.Float((chance / np.maximum(area, 1e-30)).astype(np.float32))
        if self.has_environment:
            self.pixel = mi.DiscreteDistribution(mi.Float((weight / weight.max()).ravel().astype(np.float32)))
            # Four wide, as pixels of the environment are.
            pixel_density = weight / weight.sum() * (height * width * self.environment_share)
            self.pixel_density = mi.Float(np.repeat(pixel_density.ravel(), 4).astype(np.float32))

    def sample(self, position, u, active) -> LightSample:  # type: ignore[no-untyped-def]
        """One emitter sample for each position; ``u`` are three uniform numbers in [0, 1)."""
        none = mi.Bool(False)
        direction, distance, density = mi.Vector3f(0.0, 1.0, 0.0), mi.Float(1.0), mi.Float(0.0)
        light = mi.Color3f(0.0)
        surface, on = None, none
        to_environment = active & (u[0] < self.environment_share) if self.has_environment else none
        if self.has_triangles:
            on = active & ~to_environment
            which = (u[0] - self.environment_share) / (1.0 - self.environment_share)
            triangle = dr.gather(mi.UInt32, self.triangles, self.choice.sample(which, on), on)
            root = dr.sqrt(u[1])
            uv = mi.Point2f(root * (1.0 - u[2]), root * u[2])
            point = _point_on(self.device, triangle, uv, on)
            away = mi.Vector3f(point - position)
            distance = dr.norm(away)
            direction = away / dr.maximum(distance, 1e-20)
            surface = surface_at(self.device, triangle, uv, direction, on)
            light = dr.select(surface.visible, surface.emission, 0.0) * opacity(self.device, triangle, uv, on)
            density = self.density_of_hit(triangle, surface.geometric_normal, direction, distance, surface.visible)
        if self.has_environment:
            out = self._sky_direction(u[0] / self.environment_share, u[1], u[2], to_environment)
            direction = dr.select(to_environment, out, direction)
            distance = dr.select(to_environment, dr.largest(mi.Float), distance)
            density = dr.select(to_environment, self.density_of_escape(out, to_environment), density)
            light = dr.select(to_environment, environment_radiance(self.device, out, to_environment), light)
        return LightSample(direction, distance, density, dr.select(density > 0.0, light, 0.0), surface, on)

    def density_of_hit(self, triangle, normal, direction, distance, active):  # type: ignore[no-untyped-def]
        """Density per steradian with which `sample` picks the point of a triangle that a ray ends on."""
        if not self.has_triangles:
            return mi.Float(0.0)
        density = dr.gather(mi.Float, self.density, triangle, active)
        density *= dr.square(distance) / dr.maximum(dr.abs(dr.dot(normal, direction)), 1e-6)
        return dr.select(active, density, 0.0)

    def density_of_escape(self, direction, active):  # type: ignore[no-untyped-def]
        """Density per steradian with which `sample` picks a direction of the environment."""
        if not self.has_environment:
            return mi.Float(0.0)
        sine = dr.safe_sqrt(1.0 - dr.square(direction.y))
        per_picture = sky_lookup(self.device, self.pixel_density, direction, active).x
        return per_picture / dr.maximum(2.0 * dr.square(dr.pi) * sine, 1e-6)

    def _sky_direction(self, which, u, v, active):  # type: ignore[no-untyped-def]
        """Directions whose density is as bilinear as the picture: a pixel by its flux, and a tent around its centre."""
        height, width = self.device.environment_size
        pixel = self.pixel.sample(dr.minimum(which, 1.0 - 2.0**-24), active)
        row = pixel // width
        jitter = mi.warp.square_to_tent(mi.Point2f(u, v))
        x = (mi.Float(pixel - row * width) + 0.5 + jitter.x) / width
        y = (mi.Float(row) + 0.5 + jitter.y) / height
        y = dr.select(y < 0.0, -y, dr.select(y > 1.0, 2.0 - y, y))  # beyond a pole the picture's rows repeat
        sin_phi, cos_phi = dr.sincos((x - 0.5) * dr.two_pi)
        sin_theta, cos_theta = dr.sincos(y * dr.pi)
        return mi.Vector3f(cos_phi * sin_theta, cos_theta, sin_phi * sin_theta)


def emitters_of(device: DeviceScene) -> Emitters:
    """The compensated emitters of a scene, found once. Not to be asked for first while a kernel's loop is recorded."""
    if device.emitters is None:
        device.emitters = Emitters(device, compensated=True)
    return device.emitters  # type: ignore[no-any-return]


def _point_on(device: DeviceScene, triangle, uv, active):  # type: ignore[no-untyped-def]
    corners = dr.gather(mi.Vector4u, device.corners, triangle, active)
    a, b, c = (dr.gather(mi.Vector4f, device.position_u, corners[k], active) for k in range(3))
    point = a * (1.0 - uv.x - uv.y) + b * uv.x + c * uv.y
    return mi.Point3f(point.x, point.y, point.z)


def _triangle_power(device: DeviceScene) -> tuple[np.ndarray, np.ndarray]:
    """Area times mean luminance of the emission, and area, of every triangle that emits; zeros for the others."""
    area, power = np.zeros(len(device.triangles)), np.zeros(len(device.triangles))
    emits = np.array([part.material.emits for part in device.scene.parts])[device.part_of_triangle]
    lit = np.flatnonzero(emits).astype(np.uint32)
    if len(lit):
        corners = device.positions[device.triangles[lit]].astype(np.float64)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area[lit] = np.linalg.norm(cross, axis=-1) / 2.0
        # Points of the R2 sequence, folded into the triangle.
        x, y = (np.arange(PROBES)[:, None] * R2 + 0.5).T % 1.0
        x, y = np.where(x + y > 1.0, 1.0 - x, x), np.where(x + y > 1.0, 1.0 - y, y)
        uv = mi.Point2f(*(mi.Float(np.tile(c, len(lit)).astype(np.float32)) for c in (x, y)))
        triangle = mi.UInt32(np.repeat(lit, PROBES))
        surface = surface_at(device, triangle, uv, mi.Vector3f(0.0, 1.0, 0.0), mi.Bool(True))
        emission = surface.emission * opacity(device, triangle, uv, mi.Bool(True))
        power[lit] = luminance(emission).numpy().reshape(-1, PROBES).mean(-1) * area[lit]
    return power, area
