"""What rays truly meet: surfaces that are masked or half transparent let them through, straight on."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import DeviceScene
from reflet.trace.sampling import chances
from reflet.trace.surface import OFFSET, alpha_at

_SALT = 9  # other numbers than those that glass and lobes take


@dataclass
class Hit:
    """The scene's ``triangle``, barycentrics ``uv`` and distance ``t`` of what rays meet, where ``valid``."""

    valid: Any
    triangle: Any
    uv: Any
    t: Any


def closest(
    device: DeviceScene,
    ray: Any,
    active: Any,
    *,
    coherent: bool = False,
    without: "tuple[mi.Scene, mi.UInt32] | None" = None,
    threshold: Callable[[Any], Any] | None = None,
) -> Hit:
    """The first surface that rays do not go through: of all that there is, or of `DeviceScene.without_object`.

    Masked surfaces let through what meets them where their alpha is below their cutoff; blended ones at random, a share
    of 1 - alpha: where ``threshold`` of a triangle's number, else a number that follows from ray and place, is alpha or
    above it.
    """
    scene, number = (device.all, None) if without is None else without

    def next_hit(ray, lanes) -> Hit:  # type: ignore[no-untyped-def]
        hit = scene.ray_intersect_preliminary(ray, coherent=coherent, active=lanes)
        valid = lanes & hit.is_valid()
        triangle = mi.UInt32(hit.prim_index if number is None else dr.gather(mi.UInt32, number, hit.prim_index, valid))
        return Hit(valid, triangle, mi.Point2f(hit.prim_uv), mi.Float(hit.t))

    if not device.has_holes:
        return next_hit(ray, active)

    def step(lanes, passed, valid, triangle, uv, t):  # type: ignore[no-untyped-def]
        onward = mi.Ray3f(ray.o + ray.d * passed, ray.d)
        onward.maxt = ray.maxt - passed
        hit = next_hit(onward, lanes)
        place = onward.o + ray.d * dr.select(hit.valid, hit.t, 0.0)
        drawn = chances(ray.d, place, _SALT)[0] if threshold is None else threshold(hit.triangle)
        alpha, cutoff = alpha_at(device, hit.triangle, hit.uv, hit.valid)
        met = dr.select(cutoff < 0.0, alpha > drawn, alpha >= cutoff)
        gone = hit.valid & ~met
        t = dr.select(lanes, passed + hit.t, t)
        triangle, uv = dr.select(lanes, hit.triangle, triangle), dr.select(lanes, hit.uv, uv)
        valid = dr.select(lanes, hit.valid & met, valid)
        beyond = passed + hit.t + OFFSET * dr.maximum(dr.max(dr.abs(place)), hit.t)
        return gone & (beyond < ray.maxt), dr.select(gone, beyond, passed), valid, triangle, uv, t

    start = mi.Bool(active), mi.Float(0.0), mi.Bool(False), mi.UInt32(0), mi.Point2f(0.0), mi.Float(dr.inf)
    _, _, valid, triangle, uv, t = dr.while_loop(start, lambda lanes, *_: lanes, step)
    return Hit(valid, triangle, uv, t)


def blocked(device: DeviceScene, ray: Any, active: Any, without: "tuple[mi.Scene, mi.UInt32] | None" = None) -> Any:
    """Whether anything stands within a ray's reach, of all or of `DeviceScene.without_object`."""
    if device.has_holes:
        return closest(device, ray, active, without=without).valid
    scene = device.all if without is None else without[0]
    return scene.ray_test(ray, False, active)


def opacity(device: DeviceScene, triangle: Any, uv: Any, active: Any) -> Any:
    """The share of rays that do not go through a surface there."""
    if not device.has_holes:
        return mi.Float(1.0)
    alpha, cutoff = alpha_at(device, triangle, uv, active)
    return dr.select(cutoff < 0.0, alpha, dr.select(alpha >= cutoff, 1.0, 0.0))
