"""Light of lamps without extent: what arrives, what rough surfaces show of it, and how much of it surfaces get."""

from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.bent_normals import gradient_of
from reflet.trace.light.holes import blocked
from reflet.trace.light.mesh_colors import SampleSites
from reflet.trace.light.site_points import SitePoints
from reflet.trace.lobe import schlick
from reflet.trace.sampling import LANES, block_means, shifted_hammersley
from reflet.trace.surface import OFFSET, Surface, luminance

RAYS = 64  # of a site to each light


def arriving(device: DeviceScene, light, position, active):  # type: ignore[no-untyped-def]
    """The unit direction from positions towards a light of that number, its distance, and the irradiance on what faces
    it there if nothing is between."""
    rows = [dr.gather(mi.Vector4f, device.lights, 3 * mi.UInt32(light) + k, active) for k in range(3)]
    placed = rows[1].w > 0.5
    place = mi.Vector3f(rows[1].x, rows[1].y, rows[1].z)
    away = dr.select(placed, place - mi.Vector3f(position), place)
    distance = dr.maximum(dr.norm(away), 1e-9)
    towards = away / distance
    cone = dr.clip(dr.dot(mi.Vector3f(rows[2].x, rows[2].y, rows[2].z), towards) + rows[2].w, 0.0, 1.0)
    window = dr.maximum(1.0 - dr.square(dr.square(distance * rows[0].w)), 0.0)
    fades = dr.square(cone) * dr.select(placed, window / dr.square(distance), 1.0)
    reach = dr.select(placed, distance * (1.0 - 10.0 * OFFSET), dr.largest(mi.Float))
    return towards, reach, mi.Color3f(rows[0].x, rows[0].y, rows[0].z) * fades


def highlights(device: DeviceScene, surface: Surface, active) -> Any:  # type: ignore[no-untyped-def]
    """Radiance that rough surfaces and their coats send back along rays from lights without extent; mirrors show
    none."""
    if not (device.scene.lights and device.has_rough):
        return mi.Color3f(0.0)
    if surface.coat is not None:
        share = surface.coat.fresnel
        its = {"lobe": surface.coat.lobe, "rough": surface.coat.rough & (share > 0.0), "f0": share, "f90": share}
        above = replace(surface, coat=None, **its)
        return highlights(device, replace(surface, coat=None), active) + highlights(device, above, active)
    active = active & surface.rough
    origin = mi.Point3f(surface.position + surface.geometric_normal * surface.offset)
    count = dr.opaque(mi.UInt32, len(device.scene.lights))

    def step(light, radiance):  # type: ignore[no-untyped-def]
        towards, reach, irradiance = arriving(device, light, surface.position, active)
        shape, _, v_dot_h = surface.lobe.evaluate(towards)  # type: ignore[union-attr]
        share = shape * schlick(surface.f0, surface.f90, v_dot_h)
        lit = active & (dr.dot(surface.geometric_normal, towards) > 0.0) & (shape > 0.0) & (dr.max(irradiance) > 0.0)
        ray = mi.Ray3f(origin, towards)
        ray.maxt = reach
        lit &= ~blocked(device, ray, lit)
        return light + 1, radiance + dr.select(lit, share * irradiance, 0.0)

    start = dr.zeros(mi.UInt32, dr.width(active)), dr.zeros(mi.Color3f, dr.width(active))
    return dr.while_loop(start, lambda light, _: light < count, step)[1]


def direct_light(
    device: DeviceScene, sites: SampleSites, points: SitePoints, seed: int
) -> tuple[Float32[np.ndarray, "sites channels"], Float32[np.ndarray, "sites lights"]]:
    """At all sites irradiance/π from lights without extent, and where normals are bent its gradient, and the share of
    each light that nothing hides, the surface itself included. Means over points of each site's cell."""
    count, lights = len(sites.starts) - 1, len(device.scene.lights)
    direct = np.zeros((count, 6 if device.has_normal_maps else 3), np.float32)
    visibility = np.zeros((count, lights), np.float32)
    step = LANES // RAYS
    for light in range(lights):
        for start in range(0, count, step):
            some = slice(start, min(start + step, count))
            means = _from(device, points, dr.opaque(mi.UInt32, light), start, some.stop - start, seed)
            direct[some] += means[:, 1:]
            visibility[some, light] = means[:, 0]
    return direct, visibility


def _from(device, points, light, start: int, count: int, seed: int):  # type: ignore[no-untyped-def]
    """Of one light the share that is seen from some sites, irradiance/π there, and its gradient."""
    lane, each = dr.arange(mi.UInt32, count * RAYS), dr.opaque(mi.UInt32, RAYS)
    site = lane // each
    path = lane - site * each
    site += dr.opaque(mi.UInt32, start)
    point = points.at(site, path, *shifted_hammersley(path, each, site, dr.opaque(mi.UInt32, seed)))
    towards, reach, irradiance = arriving(device, light, point.position, mi.Bool(True))
    ray = mi.Ray3f(point.origin, towards)
    ray.maxt = reach
    seen = dr.dot(point.geometric, towards) > 0.0
    seen &= ~blocked(device, ray, seen)
    cosine = dr.maximum(dr.dot(point.smooth, towards), 0.0)
    lit = dr.select(seen, irradiance * (cosine * dr.inv_pi), 0.0)
    bent = [*(luminance(lit) * gradient_of(point.smooth, towards))] if device.has_normal_maps else []
    return block_means([dr.select(seen, mi.Float(1.0), 0.0), *lit, *bent], RAYS)
