"""Radiance along rays through a scene whose diffuse light is cached: mirrors are followed, all else is looked up."""

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.surface import Surface, environment_radiance, surface_at

MAX_BOUNCES = 8  # mirrored rays followed after the first; what is left of 0.65 is 2 %


@dr.syntax
def radiance(device: DeviceScene, origin, direction, active, bounces: int = MAX_BOUNCES):  # type: ignore[no-untyped-def]
    """Radiance that arrives along rays from ``origin`` in unit ``direction``; black where ``active`` is false.

    Up to ``bounces`` mirrored rays are followed; what the last one's mirror reflects is black. Backs of single-sided
    faces are black.
    """
    arriving = mi.Color3f(0.0)
    throughput = mi.Color3f(1.0)
    o, d = mi.Point3f(origin), mi.Vector3f(direction)
    lanes = mi.Bool(active)
    left = mi.UInt32(bounces)
    while lanes:
        hit = device.all.ray_intersect_preliminary(mi.Ray3f(o, d), coherent=False, active=lanes)
        surface, light = arrive(device, hit.prim_index, hit.prim_uv, d, lanes, hit.is_valid())
        arriving += throughput * light
        lanes &= surface.reflects & (left > 0)
        throughput *= surface.fresnel
        o, d = leave(surface)
        left -= 1
    return arriving


def arrive(device: DeviceScene, triangle, uv, direction, active, hits):  # type: ignore[no-untyped-def]
    """The surface that rays end on, and the radiance from there that does not come by a mirror.

    Of the ``active`` rays those that hit nothing see the environment.
    """
    surface = surface_at(device, triangle, uv, direction, active & hits)
    escaped = active & ~hits
    light = dr.select(escaped, environment_radiance(device, direction, escaped), surface.glow)
    return surface, light


def leave(surface: Surface):  # type: ignore[no-untyped-def]
    """Origin and direction of the mirrored ray."""
    return mi.Point3f(surface.position + surface.geometric_normal * surface.offset), surface.mirrored
