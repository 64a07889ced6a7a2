"""Radiance along rays through a scene whose diffuse light is cached: mirrors, lobes and glass are followed, all else is
looked up.

**Lobes.** Where a surface is rough one ray follows its lobe and one looks for an emitter
(`reflet.trace.light.found_light`). The emitter that a lobe's ray ends on counts as far as the other one does not find
it, by the balance heuristic [VeachGuibas95]: a ray has the ``density`` per steradian that it was drawn with, infinite
where nothing was drawn.
"""

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.emitters import emitters_of
from reflet.trace.light.found_light import found_light
from reflet.trace.light.holes import blocked, closest
from reflet.trace.light.punctual import highlights
from reflet.trace.lobe import schlick
from reflet.trace.sampling import chances
from reflet.trace.surface import Surface, environment_radiance, surface_at

MAX_BOUNCES = 8  # mirrored rays followed after the first; what is left of 0.65 is 2 %
MAX_GLASS_BOUNCES = 64  # where there is glass: little is lost from bounce to bounce
LEAST_PICKED = 0.1  # of the rays that meet a coat, for it and for what is below


def radiance(device: DeviceScene, ray, active, medium=0.0, density=dr.inf):  # type: ignore[no-untyped-def]
    """Radiance that arrives along rays of unit direction; black where ``active`` is false.

    Up to `MAX_BOUNCES` mirrored rays are followed; what the last one's mirror reflects is black. Backs of single-sided
    faces are black. Rays that meet glass go on by reflection or refraction, at random by what is reflected; up to
    `MAX_GLASS_BOUNCES` of them; those that meet something rough go on at random in its lobe. They begin within what
    absorbs ``medium`` a metre. Of emitters that rays of this ``density`` end on it is the rays' share.
    """
    most = MAX_GLASS_BOUNCES if device.has_glass else MAX_BOUNCES
    looks = _looks(device)

    def bounce(lanes, ray, arriving, throughput, medium, left, density):  # type: ignore[no-untyped-def]
        hit = closest(device, ray, lanes)
        surface, light = arrive_drawn(device, hit.triangle, hit.uv, ray.d, lanes, hit.valid, hit.t, density)
        throughput = throughput * kept(device, medium, hit.t, hit.valid)
        lanes = surface.reflects & (left > 0)
        if looks:
            light += _lit(device, surface, ray.d, lanes)
        following, share, medium, density = goes_on(device, surface, ray.d, medium)
        return lanes, following, arriving + throughput * light, throughput * share, medium, left - 1, density

    start = (
        mi.Bool(active),
        mi.Ray3f(ray),
        mi.Color3f(0.0),
        mi.Color3f(1.0),
        mi.Color3f(medium),
        mi.UInt32(most),
        mi.Float(density),
    )
    return dr.while_loop(start, lambda lanes, *_: lanes, bounce, max_iterations=most + 1)[2]


def sent_on(device: DeviceScene, surface: Surface, direction, active, medium=0.0):  # type: ignore[no-untyped-def]
    """Radiance that a surface sends back along rays that met it by way of its mirror or lobe, or through it."""
    following, share, medium, density = goes_on(device, surface, direction, medium)
    light = share * radiance(device, following, active, medium, density)
    if _looks(device):
        light += _lit(device, surface, direction, active)
    return light


def goes_on(device: DeviceScene, surface: Surface, direction, medium):  # type: ignore[no-untyped-def]
    """The ray that goes on from a surface, the share of its radiance that counts, what absorbs it on its way, and its
    density.

    At glass and in lobes numbers decide that follow from the ray alone: the same rays always go the same ways.
    """
    ray, share, density = leave(surface), surface.fresnel, mi.Float(dr.inf)
    if device.has_glass:
        through = surface.passes & (chances(direction, surface.position, 0)[0] >= surface.fresnel.x)
        share = dr.select(through, surface.transmittance, dr.select(surface.passes, 1.0, surface.fresnel))
        ray, medium = _ray(surface, through), medium_after(surface, through, medium)
    if device.has_rough:
        point = mi.Point2f(*chances(direction, surface.position, 1))
        drawn, own, weight, v_dot_h = surface.lobe.draw(point)  # type: ignore[union-attr]
        above = dr.dot(drawn, surface.geometric_normal) > 0.0
        glossy = dr.select(above, weight * schlick(surface.f0, surface.f90, v_dot_h), 0.0)
        share = dr.select(surface.rough, glossy, share)
        density = dr.select(surface.rough, own, density)
        ray = mi.Ray3f(ray.o, dr.select(surface.rough, drawn, ray.d))
    if surface.coat is not None:
        coat = surface.coat
        picked = coat.fresnel / dr.maximum(coat.fresnel + dr.max(share), 1e-6)
        picked = dr.select(coat.fresnel > 0.0, dr.clip(picked, LEAST_PICKED, 1.0 - LEAST_PICKED), 0.0)
        by_coat = chances(direction, surface.position, 4)[0] < picked
        drawn, own, weight = coat.draw(mi.Point2f(*chances(direction, surface.position, 5)))
        above = dr.dot(drawn, surface.geometric_normal) > 0.0
        whole = dr.select(above, coat.fresnel * weight, 0.0) / dr.maximum(picked, LEAST_PICKED)
        share = dr.select(by_coat, mi.Color3f(whole), share / (1.0 - picked))
        density = dr.select(by_coat, own, density)
        ray = mi.Ray3f(ray.o, dr.select(by_coat, drawn, ray.d))
    return ray, share, medium, density


def _looks(device: DeviceScene) -> bool:
    """Whether rough surfaces look for light."""
    return device.has_rough and (emitters_of(device).any or bool(device.scene.lights))


def coat_light(device: DeviceScene, surface: Surface, numbers, active):  # type: ignore[no-untyped-def]
    """Radiance that coats send back along rays that met them, by five uniform ``numbers``; black without any."""
    coat = surface.coat
    if coat is None:
        return mi.Color3f(0.0)
    drawn, density, weight = coat.draw(mi.Point2f(*numbers[:2]))
    coated = active & (coat.fresnel > 0.0)
    above = coated & (dr.dot(drawn, surface.geometric_normal) > 0.0)
    seen = radiance(device, mi.Ray3f(leave(surface).o, drawn), above, 0.0, density)
    return coat.fresnel * weight * seen + _found_by_coat(device, surface, numbers[2:], coated)


def _found_by_coat(device: DeviceScene, surface: Surface, numbers, active):  # type: ignore[no-untyped-def]
    """Of emitters that are looked for."""
    if not emitters_of(device).any:
        return mi.Color3f(0.0)
    found = found_light(device, surface, numbers, active, surface.coat)
    wanted = found.lit & found.above
    hidden = blocked(device, found.ray, wanted)
    return dr.select(wanted & ~hidden, surface.coat.fresnel * found.light, 0.0)  # type: ignore[union-attr]


def _lit(device: DeviceScene, surface: Surface, direction, active):  # type: ignore[no-untyped-def]
    """Radiance that rough surfaces send back along rays, from emitters looked for and lights without extent."""
    light = highlights(device, surface, active)
    if not emitters_of(device).any:
        return light
    numbers = chances(direction, surface.position, 2) + chances(direction, surface.position, 3)
    found = found_light(device, surface, numbers[:3], active)
    hidden = blocked(device, found.ray, found.lit & found.above)
    share = schlick(surface.f0, surface.f90, found.v_dot_h)
    light += dr.select(found.lit & found.above & ~hidden, share * found.light, 0.0)
    if surface.coat is not None:
        light += _found_by_coat(device, surface, numbers[:3], active & (surface.coat.fresnel > 0.0))
    return light


def medium_after(surface: Surface, through, medium):  # type: ignore[no-untyped-def]
    """What absorbs a ray, per metre, that goes ``through`` glass or is mirrored there."""
    inside = surface.passes & (through ^ surface.back)
    return dr.select(inside, surface.absorption, dr.select(through, mi.Color3f(0.0), mi.Color3f(medium)))


def kept(device: DeviceScene, medium, distance, hits):  # type: ignore[no-untyped-def]
    """The share of light that is left after some metres, all where rays go on for ever: such glass is not closed."""
    if not device.has_glass:
        return mi.Color3f(1.0)
    return dr.select(hits, dr.exp(-mi.Color3f(medium) * distance), 1.0)


def arrive(device: DeviceScene, triangle, uv, direction, active, hits):  # type: ignore[no-untyped-def]
    """The surface that rays end on, and the radiance from there that does not come by a mirror.

    Of the ``active`` rays those that hit nothing see the environment.
    """
    surface = surface_at(device, triangle, uv, direction, active & hits)
    escaped = active & ~hits
    light = dr.select(escaped, environment_radiance(device, direction, escaped), surface.glow)
    return surface, light


def arrive_drawn(device: DeviceScene, triangle, uv, direction, active, hits, distance, density):  # type: ignore[no-untyped-def]
    """`arrive` by rays drawn with some ``density`` that end after ``distance`` metres: of emitters only their share."""
    surface, light = arrive(device, triangle, uv, direction, active, hits)
    if device.has_rough and emitters_of(device).any:
        emitters = emitters_of(device)
        other = emitters.density_of_hit(triangle, surface.geometric_normal, direction, distance, surface.visible)
        emitted = dr.select(surface.visible, surface.emission, 0.0)
        light -= emitted * (other / dr.maximum(density + other, 1e-20))
        if emitters.has_environment:
            escaped = active & ~hits
            other = emitters.density_of_escape(direction, escaped)
            light -= dr.select(escaped, light * (other / dr.maximum(density + other, 1e-20)), 0.0)
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
