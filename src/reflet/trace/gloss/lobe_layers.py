"""Samples of rough parts, where a scene has any: light that their lobes gather, for `reflet.trace.gloss.lobe_sums`.

Every sample follows one ray of its surface's lobe, drawn by visible normals [Heitz14], with the weight w = G2/G1, and
looks for one emitter. Of both, the balance heuristic takes its share [VeachGuibas95]. Mirrors are lobes of one
direction and of weight 1.
"""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Int32

from reflet.errors import RefletError
from reflet.trace.camera_rays import CameraRays
from reflet.trace.device_scene import DeviceScene
from reflet.trace.gloss.lobe_sums import (
    EMITTERS_SHELLS,
    HIDDEN,
    LIT,
    LIT_OWN,
    MOST_SHELLS,
    NOTHING,
    RAYS_SHELLS,
    ROUGH,
)
from reflet.trace.layers import Shells
from reflet.trace.light.emitters import emitters_of
from reflet.trace.light.found_light import found_light
from reflet.trace.light.holes import blocked, closest
from reflet.trace.light.punctual import highlights
from reflet.trace.light.radiance import (
    arrive,
    arrive_drawn,
    coat_light,
    kept,
    leave,
    medium_after,
    pass_through,
    radiance,
    sent_on,
)
from reflet.trace.lobe import schlick
from reflet.trace.peel import Drawn, met_through, peeled, seen_through
from reflet.trace.surface import Surface
from reflet.trace.visible import first_seen

LEAST_WEIGHT = 1e-6  # of samples that leave the lobe's hemisphere, whose rays are mirrored: no row is without light


def trace_lobes(
    device: DeviceScene, rays: CameraRays, index: int, pixels: Int32[np.ndarray, "pixels"], shells: Shells
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Every sample's part (or `NOTHING`), and its flags and channels.

    Raises RefletError for more than `MOST_SHELLS` shells.
    """
    if shells.count > MOST_SHELLS:
        raise RefletError(f"Rough parts are traced with at most {MOST_SHELLS} shells, not {shells.count}.")
    direction, seen = first_seen(device, rays, pixels)
    surface, _ = arrive(device, seen.triangle, seen.uv, direction, mi.Bool(True), seen.valid)
    return lobe_samples(device, surface, rays.numbers(pixels), index, shells)


def lobe_samples(device: DeviceScene, surface: Surface, numbers, index: int, shells: Shells) -> tuple[np.ndarray, list]:  # type: ignore[no-untyped-def]
    """The same of surfaces that are seen, of object ``index`` where they reflect, by five uniform ``numbers`` each."""
    own_index = dr.opaque(mi.UInt32, index)
    active = surface.reflects & (surface.object == own_index)
    rough = active & surface.rough

    drawn, density, weight, v_dot_h = surface.lobe.draw(mi.Point2f(*numbers[:2]))  # type: ignore[union-attr]
    weight = dr.select(rough, dr.maximum(weight, LEAST_WEIGHT), 1.0)
    shown = dr.select(rough, schlick(surface.f0, surface.f90, v_dot_h), surface.fresnel)
    follows = rough & (weight > LEAST_WEIGHT)
    below = follows & (dr.dot(drawn, surface.geometric_normal) <= 0.0)
    start = leave(surface)
    ray = mi.Ray3f(start.o, dr.select(follows, drawn, start.d))
    origin = Drawn(ray.o, dr.select(follows, density, dr.inf))

    above = active & ~below
    met = closest(device, ray, above)
    at_met, light_met = arrive_drawn(device, met.triangle, met.uv, ray.d, above, met.valid, met.t, origin.density)
    is_own = at_met.gone_through if device.through else at_met.object == own_index
    own = above & met.valid & is_own
    medium = medium_after(surface, mi.Bool(False), 0.0)
    local = light_met + sent_on(device, at_met, ray.d, own & at_met.reflects, medium)
    local = dr.select(own, local * kept(device, medium, met.t, met.valid), 0.0)

    hidden = own | (active & below)  # below its surface the object hides what its lobe would show
    through = met_through(device, index, ray, met, hidden, active)
    beyond = list(peeled(device, index, through, ray.d, active, shells, origin))
    if device.has_glass:
        passes = active & surface.passes
        light = radiance(device, pass_through(surface), passes, medium_after(surface, mi.Bool(True), 0.0))
        local += dr.select(passes, surface.transmittance * (1.0 / surface.fresnel - 1.0) * light, 0.0)

    flags = _flag(hidden, HIDDEN) | _flag(rough, ROUGH)
    for number, shell in enumerate(beyond):
        flags |= _flag(shell.present, 1 << RAYS_SHELLS + number)
    found, shown_found, flags_found = _emitters(device, index, surface, numbers[2:], active, shells)
    flags |= flags_found
    part = dr.select(active, surface.part, NOTHING)
    albedo = dr.select(rough, surface.albedo, 1.0)
    glow = surface.glow + highlights(device, surface, active)  # playback reckons these: no map can hold them
    glow += coat_light(device, surface, numbers, active)  # rows are of the lobe below
    outputs = [*glow, *surface.fresnel, weight, albedo, *local, *shown, *found, *shown_found]
    for shell in beyond:
        outputs += [*shell.light]
    dr.eval(part, flags, *outputs)
    return part.numpy(), [flags.numpy(), *(channel.numpy() for channel in outputs)]


def _emitters(device: DeviceScene, index: int, surface, numbers, active, shells: Shells) -> tuple[Any, Any, Any]:  # type: ignore[no-untyped-def]
    """What one emitter for each rough hit adds to its lobe's light, the same as reflected, and its flags."""
    emitters = emitters_of(device)
    if not emitters.any:
        none = dr.zeros(mi.Color3f, dr.width(surface.position))
        return none, none, mi.UInt32(0)
    found = found_light(device, surface, numbers, active)
    own = mi.Bool(False)
    if emitters.has_triangles:
        is_own = found.surface.gone_through if device.through else found.surface.object == dr.opaque(mi.UInt32, index)
        own = found.on_triangle & is_own
    seen = list(seen_through(device, index, found.ray, found.distance, found.lit & ~own, shells))
    flags = mi.UInt32(0)
    for number, unblocked in enumerate(seen):
        flags |= _flag(unblocked, 1 << EMITTERS_SHELLS + number)
    wanted = found.above & ((found.lit & own) | seen[0])
    free = wanted & ~blocked(device, found.ray, wanted)
    flags |= _flag(free & ~own, LIT) | _flag(free & own, LIT_OWN)
    return found.light, found.light * schlick(surface.f0, surface.f90, found.v_dot_h), flags


def _flag(which, bit: int):  # type: ignore[no-untyped-def]
    return dr.select(which, mi.UInt32(bit), mi.UInt32(0))
