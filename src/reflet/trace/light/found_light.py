"""Light samples of rough surfaces: one emitter is chosen for each, whatever the lobe."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.trace.coat import Coat
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.emitters import emitters_of
from reflet.trace.surface import OFFSET, Surface


@dataclass
class FoundLight:
    """An emitter for each of many rough hits. ``light`` is its radiance times the lobe's D·V·n·l over the density of
    both ways to find it, if nothing lies along ``ray``, which ends ``distance`` metres away. Where not ``lit`` there is
    none; ``above`` tells that it is above the geometric surface. ``surface`` is that of an emitting triangle, where
    ``on_triangle``."""

    ray: Any
    distance: Any
    light: Any
    v_dot_h: Any
    lit: Any
    above: Any
    surface: Any
    on_triangle: Any


def found_light(  # type: ignore[no-untyped-def]
    device: DeviceScene, surface: Surface, numbers, active, coat: Coat | None = None
) -> FoundLight:
    """One emitter for each rough hit, or for each rough ``coat``, by three uniform ``numbers`` in [0, 1); the scene
    must have rough parts."""
    lobe = surface.lobe if coat is None else coat.lobe
    active = active & (surface.rough if coat is None else coat.rough)
    origin = mi.Point3f(surface.position + surface.geometric_normal * surface.offset)
    emitter = emitters_of(device).sample(origin, numbers, active)
    shape, density, v_dot_h = lobe.evaluate(emitter.direction)  # type: ignore[union-attr]
    lit = active & (emitter.density > 0.0) & (shape > 0.0)
    light = emitter.radiance * (shape / dr.maximum(emitter.density + density, 1e-20))
    lit &= dr.max(light) > 0.0
    ray = mi.Ray3f(origin, emitter.direction)
    ray.maxt = emitter.distance * (1.0 - 10.0 * OFFSET)
    above = dr.dot(surface.geometric_normal, emitter.direction) > 0.0
    return FoundLight(
        ray=ray,
        distance=emitter.distance,
        light=dr.select(lit, light, 0.0),
        v_dot_h=v_dot_h,
        lit=lit,
        above=above,
        surface=emitter.surface,
        on_triangle=emitter.on_triangle,
    )
