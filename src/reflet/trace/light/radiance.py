"""Radiance along rays through a scene whose diffuse light is cached: mirrors are followed, all else is looked up."""

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.surface import Surface, environment_radiance, surface_at

MAX_BOUNCES = 8  # mirrored rays followed after the first; what is left of 0.65 is 2 %


def radiance(device: DeviceScene, ray, active):  # type: ignore[no-untyped-def]
    """Radiance that arrives along rays of unit direction; black where ``active`` is false.

    Up to `MAX_BOUNCES` mirrored rays are followed; what the last one's mirror reflects is black. Backs of single-sided
    faces are black.
    """

    def bounce(lanes, ray, arriving, throughput, left):  # type: ignore[no-untyped-def]
        hit = device.all.ray_intersect_preliminary(ray, coherent=False, active=lanes)
        surface, light = arrive(device, hit.prim_index, hit.prim_uv, ray.d, lanes, hit.is_valid())
        lanes = surface.reflects & (left > 0)
        return lanes, leave(surface), arriving + throughput * light, throughput * surface.fresnel, left - 1

    start = (
        mi.Bool(active),
        mi.Ray3f(ray),
        mi.Color3f(0.0),
        mi.Color3f(1.0),
        mi.UInt32(MAX_BOUNCES),
    )
    return dr.while_loop(start, lambda lanes, *_: lanes, bounce, max_iterations=MAX_BOUNCES + 1)[2]


def arrive(device: DeviceScene, triangle, uv, direction, active, hits):  # type: ignore[no-untyped-def]
    """The surface that rays end on, and the radiance from there that does not come by a mirror.

    Of the ``active`` rays those that hit nothing see the environment.
    """
    surface = surface_at(device, triangle, uv, direction, active & hits)
    escaped = active & ~hits
    light = dr.select(escaped, environment_radiance(device, direction, escaped), surface.glow)
    return surface, light


def leave(surface: Surface):  # type: ignore[no-untyped-def]
    """The mirrored ray, from just off the surface."""
    origin = mi.Point3f(surface.position + surface.geometric_normal * surface.offset)
    return mi.Ray3f(origin, surface.mirrored)
