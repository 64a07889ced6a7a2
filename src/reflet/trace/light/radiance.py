"""Radiance along rays through a scene whose diffuse light is cached: mirrors and glass are followed, all else is looked
up."""

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.surface import Surface, environment_radiance, surface_at

MAX_BOUNCES = 8  # mirrored rays followed after the first; what is left of 0.65 is 2 %
MAX_GLASS_BOUNCES = 64  # where there is glass: little is lost from bounce to bounce


def radiance(device: DeviceScene, ray, active, medium=0.0):  # type: ignore[no-untyped-def]
    """Radiance that arrives along rays of unit direction; black where ``active`` is false.

    Up to `MAX_BOUNCES` mirrored rays are followed; what the last one's mirror reflects is black. Backs of single-sided
    faces are black. Rays that meet glass go on by reflection or refraction, at random by what is reflected; up to
    `MAX_GLASS_BOUNCES` of them. They begin within what absorbs ``medium`` a metre.
    """
    most = MAX_GLASS_BOUNCES if device.has_glass else MAX_BOUNCES

    def bounce(lanes, ray, arriving, throughput, medium, left):  # type: ignore[no-untyped-def]
        hit = device.all.ray_intersect_preliminary(ray, coherent=False, active=lanes)
        surface, light = arrive(device, hit.prim_index, hit.prim_uv, ray.d, lanes, hit.is_valid())
        throughput = throughput * kept(device, medium, hit.t, hit.is_valid())
        lanes = surface.reflects & (left > 0)
        following, share, medium = goes_on(device, surface, ray.d, medium)
        return lanes, following, arriving + throughput * light, throughput * share, medium, left - 1

    start = (
        mi.Bool(active),
        mi.Ray3f(ray),
        mi.Color3f(0.0),
        mi.Color3f(1.0),
        mi.Color3f(medium),
        mi.UInt32(most),
    )
    return dr.while_loop(start, lambda lanes, *_: lanes, bounce, max_iterations=most + 1)[2]


def sent_on(device: DeviceScene, surface: Surface, direction, active, medium=0.0):  # type: ignore[no-untyped-def]
    """Radiance that a surface sends back along rays that met it by way of its mirror, or through it."""
    following, share, medium = goes_on(device, surface, direction, medium)
    return share * radiance(device, following, active, medium)


def goes_on(device: DeviceScene, surface: Surface, direction, medium):  # type: ignore[no-untyped-def]
    """The ray that goes on from a surface, the share of its radiance that counts, and what absorbs it on its way.

    At glass a number decides that follows from the ray alone: the same rays always go the same ways.
    """
    if not device.has_glass:
        return leave(surface), surface.fresnel, medium
    through = surface.passes & (_chance(direction, surface.position) >= surface.fresnel.x)
    share = dr.select(through, surface.transmittance, dr.select(surface.passes, 1.0, surface.fresnel))
    return _ray(surface, through), share, medium_after(surface, through, medium)


def medium_after(surface: Surface, through, medium):  # type: ignore[no-untyped-def]
    """What absorbs a ray, per metre, that goes ``through`` glass or is mirrored there."""
    inside = surface.passes & (through ^ surface.back)
    return dr.select(inside, surface.absorption, dr.select(through, mi.Color3f(0.0), mi.Color3f(medium)))


def kept(device: DeviceScene, medium, distance, hits):  # type: ignore[no-untyped-def]
    """The share of light that is left after some metres, all where rays go on for ever: such glass is not closed."""
    if not device.has_glass:
        return mi.Color3f(1.0)
    return dr.select(hits, dr.exp(-mi.Color3f(medium) * distance), 1.0)


def _chance(direction, position):  # type: ignore[no-untyped-def]
    """Numbers in [0, 1), as if random: a ray that is mirrored to and fro meets glass in the same direction again, but
    elsewhere."""
    u, v, w = (dr.reinterpret_array(mi.UInt32, axis) for axis in direction)
    x, y, z = (dr.reinterpret_array(mi.UInt32, axis) for axis in position)
    first, _ = mi.sample_tea_32(u, v, 4)
    second, _ = mi.sample_tea_32(x ^ w, y, 4)
    bits, _ = mi.sample_tea_32(first ^ z, second, 4)
    return mi.Float(bits >> 8) * 2.0**-24


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


def pass_through(surface: Surface):  # type: ignore[no-untyped-def]
    """The refracted ray of glass, from just beyond the surface."""
    return _ray(surface, mi.Bool(True))


def _ray(surface: Surface, through):  # type: ignore[no-untyped-def]
    offset = surface.geometric_normal * dr.select(through, -surface.offset, surface.offset)
    return mi.Ray3f(mi.Point3f(surface.position + offset), dr.select(through, surface.refracted, surface.mirrored))
