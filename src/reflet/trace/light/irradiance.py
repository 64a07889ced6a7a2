"""Diffuse light of a scene, traced once and cached on its surfaces, for every view to look up.

At each site irradiance is estimated from one emitter sample and one cosine-distributed ray at a time, combined by the
balance heuristic [VeachGuibas95]. What the ray meets is looked up in the cache itself: a few coarse passes settle all
bounces, sooner where what is still to come is foreseen [Aitken26], a long last one gathers. Lights without extent are
added at once (`reflet.trace.light.punctual`). So each sample costs two rays however many bounces light has taken, and
its noise is that of one bounce.
"""

from collections.abc import Callable
from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32

from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.bent_normals import gradient_of
from reflet.trace.light.emitters import Emitters
from reflet.trace.light.holes import blocked, closest
from reflet.trace.light.mesh_colors import SampleSites, sample_sites
from reflet.trace.light.punctual import direct_light
from reflet.trace.light.radiance import arrive, sent_on
from reflet.trace.light.site_points import SitePoints
from reflet.trace.sampling import LANES, block_means, shifts
from reflet.trace.surface import OFFSET, luminance

SETTLING_SPP = 4  # noise of single sites averages out over the rays of the next pass
LEAST_FORESEEN = 0.5  # of what a pass found: noise must not foresee less than no light
MOST_FORESEEN = 0.9  # of a bounce's light, in the next bounce: what a closed white room may promise
MOST_PASSES = 16
SETTLED = 3e-3  # passes end when the mean radiosity changes by less
CAUSTIC_LIMIT = 100.0  # radiance found by way of a mirror counts up to this times the mean radiosity
DIMENSIONS = 7  # two for the place, two for the ray, three for the emitter


def trace_irradiance(
    device: DeviceScene,
    *,
    spp: int = 512,
    budget: int = 150_000,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> IrradianceMap:
    """Irradiance/π on all surfaces that show diffuse light, about ``budget`` samples of ``spp`` paths each, or more
    samples of as many paths in all where triangles are small.

    Each sample is the mean over its own cell of the triangle, which keeps shadows' edges smooth. Mirrors cast shadows
    and reflect light onto other surfaces; such caustics are clamped at `CAUSTIC_LIMIT` times the mean radiosity.
    What is traced is that of interpolated normals, and, where the scene has normal maps, its gradient. The same
    ``seed`` gives the same bytes. ``progress`` is told (done, total).
    """
    sites = sample_sites(device.scene, budget)
    gatherer = _Gatherer(device, sites, seed)
    share = min(1.0, budget / max(len(sites.starts) - 1, 1))
    spp, settling = max(round(spp * share), 1), max(round(SETTLING_SPP * share), 1)
    total = spp + MOST_PASSES * settling
    report = progress or (lambda done, total: None)
    report(0, total)
    shared = np.zeros((len(sites.starts) - 1, 6 if device.has_normal_maps else 3), np.float32)
    means = [0.0]  # of what was published last, and then of what passes made of it
    limit = np.inf
    for done in range(1, MOST_PASSES + 1):
        gatherer.publish(shared)
        shared = gatherer.gather(np.arange(settling) + spp, limit)
        means.append(float(shared[:, :3].mean(dtype=np.float64)) if len(shared) else 0.0)
        report(done * settling, total)
        if abs(means[-1] - means[-2]) <= SETTLED * means[-1]:
            break
        limit = CAUSTIC_LIMIT * means[-1]
        if len(means) == 3:
            factor = _foreseen(*means)
            shared, means = shared * np.float32(factor), [means[-1] * factor]
    gatherer.publish(shared)
    shared = gatherer.gather(np.arange(spp), limit, lambda share: report(total - round(spp * (1.0 - share)), total))
    report(total, total)
    return gatherer.publish(shared)


def _foreseen(first: float, second: float, third: float) -> float:
    """Where three successive means lead, over the third: each change is the same share of the one before [Aitken26]."""
    share = min(max((third - second) / (second - first), 0.0), MOST_FORESEEN)
    return max(1.0 + share / (1.0 - share) * (third - second) / third, LEAST_FORESEEN)


class _Gatherer:
    """Gathers light at all sites from what is published on the scene's surfaces."""

    def __init__(self, device: DeviceScene, sites: SampleSites, seed: int) -> None:
        self.device, self.sites = device, sites
        self.emitters = Emitters(device)
        self.seed = seed
        self.points = SitePoints(device, sites)
        self.direct, self.visibility = direct_light(device, sites, self.points, seed)
        self.bent = device.has_bent_normals[device.part_of_triangle[sites.triangle]]

    def publish(self, shared: Float32[np.ndarray, "sites channels"]) -> IrradianceMap:
        """Make these values of all sites, and the gradients that may follow, what surfaces show from now on."""
        samples = shared[self.sites.site] if len(shared) else np.zeros((1, 3), np.float32)
        radiosity, gradient = np.split(samples, [3], 1)
        gradients = {"gradient": gradient * self.bent[:, None]} if gradient.size else {}
        result = IrradianceMap(self.sites.resolution, self.sites.offset, np.ascontiguousarray(radiosity), **gradients)
        if len(shared) and self.visibility.shape[1]:
            seen = np.rint(255.0 * self.visibility[self.sites.site]).astype(np.uint8)
            result = replace(result, visibility=seen)
        self.device.set_irradiance(result)
        return result

    def gather(
        self, numbers: np.ndarray, caustic_limit: float, progress: Callable[[float], None] | None = None
    ) -> Float32[np.ndarray, "sites channels"]:
        """Irradiance/π at all sites, and where normals are bent its gradient, from the paths with these indices in the
        sequence of random numbers."""
        sites, paths = len(self.sites.starts) - 1, len(numbers)
        table = mi.Float(_sequence(int(numbers.max()) + 1)[numbers].ravel())
        limit = dr.opaque(mi.Float, min(caustic_limit, 3e38))
        result = self.direct.copy()
        step = max(LANES // paths, 1)
        for start in range(0, sites, step):
            count = min(step, sites - start)
            light = self._paths(dr.opaque(mi.UInt32, start), count, paths, table, limit)
            result[start : start + count] += block_means(light, paths)
            if progress:
                progress((start + count) / sites)
        return result

    def _paths(self, start, count: int, paths: int, table, limit):  # type: ignore[no-untyped-def]
        """Radiance estimates of ``paths`` paths at each of ``count`` sites from ``start``; the channels of `gather`."""
        device = self.device
        lane = dr.arange(mi.UInt32, count * paths)
        per_site = dr.opaque(mi.UInt32, paths)
        site = lane // per_site
        path = lane - site * per_site
        site += start
        u = _numbers(table, path, site, self.seed)

        point = self.points.at(site, path, u[0], u[1])
        origin, geometric, normal = point.origin, point.geometric, point.smooth

        drawn = self.emitters.sample(origin, u[4:7], mi.Bool(True))
        cosine = dr.dot(normal, drawn.direction)
        usable = (cosine > 0.0) & (dr.dot(geometric, drawn.direction) > 0.0) & (drawn.density > 0.0)
        ray = mi.Ray3f(origin, drawn.direction)
        ray.maxt = drawn.distance * (1.0 - 10.0 * OFFSET)
        usable &= ~blocked(device, ray, usable)
        chance = cosine * dr.inv_pi
        found = dr.select(usable, drawn.radiance * (chance / (drawn.density + chance)), 0.0)

        direction = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(mi.Point2f(u[2], u[3])))
        chance = dr.dot(normal, direction) * dr.inv_pi
        above = dr.dot(geometric, direction) > 0.0
        hit = closest(device, mi.Ray3f(origin, direction), above)
        hits = hit.valid
        surface, seen = arrive(device, hit.triangle, hit.uv, direction, above, hits)
        by_sampling = self.emitters.density_of_hit(
            hit.triangle, surface.geometric_normal, direction, hit.t, surface.visible
        )
        emitted = dr.select(surface.visible, surface.emission, 0.0)
        light = seen - emitted + emitted * (chance / dr.maximum(chance + by_sampling, 1e-20))
        if self.emitters.has_environment:
            escaped = above & ~hits
            by_sampling = self.emitters.density_of_escape(direction, escaped)
            light -= dr.select(escaped, seen * (by_sampling / dr.maximum(chance + by_sampling, 1e-20)), 0.0)
        if device.scene.objects:
            caustic = sent_on(device, surface, direction, surface.reflects)
            light += dr.select(surface.reflects, dr.minimum(caustic, limit), 0.0)
        if not device.has_normal_maps:
            return light + found
        gradient = luminance(light) * gradient_of(normal, direction)
        gradient += luminance(found) * gradient_of(normal, drawn.direction)
        return *(light + found), *gradient


def _sequence(count: int) -> Float[np.ndarray, "count dimensions"]:
    """Multiples of powers of 1/φ modulo 1, φ^(d+1) = φ + 1: evenly spread however many are taken, as good as Sobol's
    points here once every site shifts them."""
    phi = 1.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (DIMENSIONS + 1))
    powers = phi ** -np.arange(1.0, DIMENSIONS + 1)
    return ((np.arange(count)[:, None] + 0.5) * powers % 1.0).astype(np.float32)


def _numbers(table, path, site, seed: int):  # type: ignore[no-untyped-def]
    """Uniform numbers in [0, 1): the sequence's, shifted around by an offset of the site's own."""
    numbers = []
    for d in range(DIMENSIONS):
        x = dr.gather(mi.Float, table, path * DIMENSIONS + d) + shifts(site, mi.UInt32(seed * DIMENSIONS + d))
        numbers.append(dr.minimum(x - dr.floor(x), 1.0 - 2.0**-24))
    return numbers
