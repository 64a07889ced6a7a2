"""Rays that pass through what is nearer: the shells of the distant surroundings, hit by hit."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import Shells
from reflet.trace.light.holes import blocked, closest
from reflet.trace.light.radiance import arrive_drawn, sent_on
from reflet.trace.surface import OFFSET, surface_at

ENDLESS = 1e30  # metres: what is farther away is the environment


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
class Drawn:
    """Where rays begin, and with what ``density`` per steradian they were drawn."""

    origin: Any
    density: Any


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
    hit = closest(device, ray, active, coherent=coherent, without=(others, number))
    return Met(hit.valid, hit.triangle, hit.uv, mi.Point3f(dr.select(hit.valid, ray.o + ray.d * hit.t, 0.0)))


def met_through(device: DeviceScene, index: int, ray, met, hidden, active) -> Met:  # type: ignore[no-untyped-def]
    """What ``active`` rays meet without object ``index``: what they have ``met`` where it does not hide that."""
    behind = first_met(device, index, ray, hidden)
    return Met(
        active & dr.select(hidden, behind.valid, met.valid),
        dr.select(hidden, behind.triangle, met.triangle),
        mi.Point2f(dr.select(hidden, behind.uv, met.uv)),
        mi.Point3f(dr.select(hidden, behind.position, ray.o + ray.d * dr.select(met.valid, met.t, 0.0))),
    )


def light_from(device: DeviceScene, met: Met, direction, active, drawn: Drawn | None = None):  # type: ignore[no-untyped-def]
    """Radiance that arrives from what is met, the environment where that is nothing; other objects, where they are met,
    mirror on. Of emitters only the share of rays that were ``drawn``."""
    distance, density = (1.0, dr.inf) if drawn is None else (met.distance(drawn.origin), drawn.density)
    surface, light = arrive_drawn(device, met.triangle, met.uv, direction, active, met.valid, distance, density)
    if len(device.scene.objects) > 1 and not device.through:
        goes_on = active & surface.reflects
        light += dr.select(goes_on, sent_on(device, surface, direction, goes_on), 0.0)
    return light


def peeled(  # type: ignore[no-untyped-def]
    device: DeviceScene, index: int, met: Met, direction, active, shells: Shells, drawn: Drawn | None = None
) -> Iterator[ShellLight]:
    """The shells along rays through object ``index``, the nearest first, from what they meet first."""
    origin = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in shells.origin))
    ends = [dr.opaque(mi.Float, float(end)) for end in shells.ends]
    for number in range(shells.count):
        if number:
            met = _beyond(device, index, met, direction, active, origin, ends[number - 1])
        distance = met.distance(origin)
        present = active & (distance < ends[number]) if number < len(ends) else mi.Bool(active)
        light = light_from(device, met, direction, present, drawn)
        yield ShellLight(dr.select(present, light, 0.0), present, distance)


def seen_through(  # type: ignore[no-untyped-def]
    device: DeviceScene, index: int, ray, distance, active, shells: Shells
) -> Iterator[Any]:
    """For each shell whether light from ``distance`` metres along rays through object ``index`` comes from there or
    beyond, and from nothing else that is not nearer than the shell's beginning."""
    if shells.count == 1:
        others, number = device.without_object(index)
        yield active if others is None else active & ~blocked(device, ray, active, (others, number))
        return
    origin = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in shells.origin))
    reach = dr.select(distance < ENDLESS, dr.norm(ray.o + ray.d * distance - origin), dr.inf)
    met = first_met(device, index, ray, active)
    for number in range(shells.count):
        if number:
            begin = dr.opaque(mi.Float, float(shells.ends[number - 1]))
            active = active & (reach >= begin)
            met = _beyond(device, index, met, ray.d, active, origin, begin)
        yield active & ~(met.valid & (dr.norm(met.position - ray.o) < ray.maxt))


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
