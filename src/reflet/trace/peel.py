"""Rays that pass through what is nearer: the shells of the distant surroundings, hit by hit."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import Shells
from reflet.trace.light.radiance import arrive, sent_on
from reflet.trace.surface import OFFSET, surface_at


@dataclass
class Met:
    """What rays meet: the scene's ``triangle``, barycentrics ``uv`` and ``position`` of a hit, where ``valid``."""

    valid: Any
    triangle: Any
    uv: Any
    position: Any

    def distance(self, origin: Any) -> Any:
        """Metres from a point; infinite where nothing is met."""
        return dr.select(self.valid, dr.norm(self.position - origin), dr.inf)


@dataclass
class ShellLight:
    """One shell along rays: ``light`` from there where it is ``present``, and its ``distance`` from the origin."""

    light: Any
    present: Any
    distance: Any


def first_met(device: DeviceScene, index: int, ray, active, coherent: bool = False) -> Met:  # type: ignore[no-untyped-def]
    """What rays meet that pass through object ``index``, or what the device says."""
    others, number = device.without_object(index)
    if others is None:
        nothing = dr.zeros(mi.Bool, dr.width(ray.d))
        return Met(nothing, mi.UInt32(0), mi.Point2f(0.0), mi.Point3f(0.0))
    hit = others.ray_intersect_preliminary(ray, coherent=coherent, active=active)
    valid = active & hit.is_valid()
    triangle = dr.gather(mi.UInt32, number, hit.prim_index, valid)
    return Met(valid, triangle, mi.Point2f(hit.prim_uv), mi.Point3f(dr.select(valid, ray.o + ray.d * hit.t, 0.0)))


def light_from(device: DeviceScene, met: Met, direction, active):  # type: ignore[no-untyped-def]
    """Radiance that arrives from what is met, the environment where that is nothing; other objects, where they are met,
    mirror on."""
    surface, light = arrive(device, met.triangle, met.uv, direction, active, met.valid)
    if len(device.scene.objects) > 1 and not device.through:
        goes_on = active & surface.reflects
        light += dr.select(goes_on, sent_on(device, surface, direction, goes_on), 0.0)
    return light


def peeled(device: DeviceScene, index: int, met: Met, direction, active, shells: Shells) -> Iterator[ShellLight]:  # type: ignore[no-untyped-def]
    """The shells along rays through object ``index``, the nearest first, from what they meet first."""
    origin = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in shells.origin))
    ends = [dr.opaque(mi.Float, float(end)) for end in shells.ends]
    for number in range(shells.count):
        if number:
            met = _beyond(device, index, met, direction, active, origin, ends[number - 1])
        distance = met.distance(origin)
        present = active & (distance < ends[number]) if number < len(ends) else mi.Bool(active)
        yield ShellLight(dr.select(present, light_from(device, met, direction, present), 0.0), present, distance)


def gone_through(device: DeviceScene, index: int, met: Met, direction, origin, reach) -> Met:  # type: ignore[no-untyped-def]
    """What rays meet behind backs of single-sided faces that they meet first, nearer than ``reach`` to the origin."""

    def on_a_back(met):  # type: ignore[no-untyped-def]
        surface = surface_at(device, met.triangle, met.uv, direction, met.valid)
        return met.valid & ~surface.visible & (met.distance(origin) < reach)

    return _on(device, index, met, direction, reach, on_a_back)


def _beyond(device, index, met, direction, active, origin, begin) -> Met:  # type: ignore[no-untyped-def]
    """The first hit at least ``begin`` metres from the origin."""
    return _on(device, index, met, direction, begin, lambda met: active & (met.distance(origin) < begin))


def _on(device, index, met, direction, extent, passes) -> Met:  # type: ignore[no-untyped-def]
    """The first hit that rays do not pass. They go on just behind what they met, however often; ``extent`` is a least
    length in metres, by which rounding is judged."""

    def step(lanes, valid, triangle, uv, position):  # type: ignore[no-untyped-def]
        on = position + direction * (OFFSET * dr.maximum(dr.max(dr.abs(position)), extent))
        following = first_met(device, index, mi.Ray3f(on, direction), lanes)
        return lanes & passes(following), following.valid, following.triangle, following.uv, following.position

    start = passes(met), mi.Bool(met.valid), mi.UInt32(met.triangle), mi.Point2f(met.uv), mi.Point3f(met.position)
    _, *found = dr.while_loop(start, lambda lanes, *_: lanes, step)
    return Met(*found)
