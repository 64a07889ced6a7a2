"""What the lobes of rough surfaces gather, at sites all over them and along directions all around.

A row is a texel of a site's map, traced like a pixel's (`reflet.trace.gloss.lobe_sums`): the site is looked at so that
it mirrors the viewer along the texel's direction. Normal maps are left out: what bends the mirrored ray in playback
bends the direction of the lookup.
"""

from collections.abc import Callable, Collection
from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32, Int32

from reflet.scene.surfaces.surface_layer import texel_directions
from reflet.trace.camera_rays import PLANE, SPACE
from reflet.trace.device_scene import DeviceScene
from reflet.trace.gloss.lobe_layers import lobe_samples
from reflet.trace.gloss.lobe_sums import lobe_rows, sum_lobes
from reflet.trace.layers import Shells, TracedSurface
from reflet.trace.light.mesh_colors import sites_of_parts
from reflet.trace.light.radiance import arrive
from reflet.trace.light.site_points import SitePoints
from reflet.trace.lobe import GlossyLobe
from reflet.trace.sampling import LANES, shifted_multiples
from reflet.trace.surface import dfg_at

BUDGET = 20_000  # of sites on large triangles; small ones have up to twice as many,
MOST_TEXELS = BUDGET * 16**2  # as long as their maps have no more: bounds files, and inference to 1 GB of memory
DEEPEST = 0.1  # sine of the angle below a surface's horizon to which directions have rows
LEAST_RISE = 0.05  # cosine from the normal of mirrored rays, and of ways to the viewer
_DISTANT, _LOCAL, _ALPHA = slice(6, 9), slice(9, 12), 15  # columns of `lobe_rows`


def trace_surface(
    device: DeviceScene,
    parts: Collection[int],
    *,
    spp: int,
    side: int,
    budget: int = BUDGET,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> TracedSurface:
    """Rows of the reflective parts of some indices, of ``spp`` samples each, for maps of ``side``² texels. The same
    ``seed`` gives the same bytes. ``progress`` is told (done, total)."""
    sites = sites_of_parts(device.scene, parts, budget, min(2 * budget, MOST_TEXELS // side**2), shared=True)
    owner = device.object_of_triangle[sites.triangle[sites.members[sites.starts[:-1]]]]
    points, number = SitePoints(device, sites), mi.UInt32(np.arange(len(owner), dtype=np.uint32))
    middle = points.at(number, mi.UInt32(0), mi.Float(0.5), mi.Float(0.5))
    at_middle, _ = arrive(device, middle.triangle, middle.uv, -middle.geometric, mi.Bool(True), mi.Bool(True))
    normal = np.asarray(middle.smooth).T
    directions = texel_directions(side)
    site, texel = (each.astype(np.int32) for each in np.nonzero(normal @ directions.T > -DEEPEST))
    mirrored = _risen(directions[texel], normal[site])
    rows = np.zeros((len(site), 7), np.float32)
    step, done = max(LANES // spp, 1), 0
    report = progress or (lambda done, total: None)
    report(0, len(site) * spp)
    for index in np.unique(owner):
        own = np.flatnonzero(owner[site] == index)
        for start in range(0, len(own), step):
            some = own[start : start + step]
            rows[some] = _traced(device, points, int(index), site[some], texel[some], mirrored[some], spp, side, seed)
            done += len(some) * spp
            report(done, len(site) * spp)
    return TracedSurface(
        side=side,
        resolution=sites.resolution,
        offset=sites.offset,
        site=sites.site.astype(np.uint32),
        object=owner.astype(np.int32),
        position=np.asarray(middle.position).T.astype(np.float32),
        normal=normal.astype(np.float32),
        roughness=np.sqrt(np.asarray(at_middle.lobe.alpha)).astype(np.float32),  # type: ignore[union-attr]
        row_site=site,
        row_texel=texel,
        mirrored=mirrored.astype(np.float32),
        local=np.ascontiguousarray(rows[:, :3]),
        alpha=np.ascontiguousarray(rows[:, 3]),
        distant=np.ascontiguousarray(rows[:, 4:]),
    )


def _traced(
    device: DeviceScene,
    points: SitePoints,
    index: int,
    site: Int32[np.ndarray, "rows"],
    texel: Int32[np.ndarray, "rows"],
    mirrored: np.ndarray,
    spp: int,
    side: int,
    seed: int,
) -> Float32[np.ndarray, "rows 7"]:
    """Local light, alpha and distant light of rows of one object."""
    count, opaque_seed = dr.opaque(mi.UInt32, spp), dr.opaque(mi.UInt32, seed)
    lane = dr.arange(mi.UInt32, len(site) * spp)
    row = lane // count
    sample = lane - row * count
    at = dr.gather(mi.UInt32, mi.UInt32(site.astype(np.uint32)), row)
    key = at * (side * side) + dr.gather(mi.UInt32, mi.UInt32(texel.astype(np.uint32)), row)
    place = shifted_multiples(sample, PLANE, key, ~opaque_seed)
    point = points.at(at, sample, *place)
    along = dr.gather(mi.Vector3f, mi.Float(mirrored.astype(np.float32).ravel()), row)
    towards = 2.0 * dr.dot(along, point.smooth) * point.smooth - along
    below = dr.maximum(LEAST_RISE - dr.dot(towards, point.geometric), 0.0)
    towards = dr.normalize(towards + below * point.geometric)

    surface, _ = arrive(device, point.triangle, point.uv, -towards, mi.Bool(True), mi.Bool(True))
    roughness = dr.sqrt(surface.lobe.alpha)  # type: ignore[union-attr]
    lobe = GlossyLobe(towards, point.smooth, point.geometric, roughness)
    a, b = dfg_at(device, lobe.n_dot_v, roughness)
    surface = replace(surface, lobe=lobe, mirrored=lobe.mirrored, albedo=a + b, coat=None)
    numbers = [*shifted_multiples(sample, PLANE, key, opaque_seed), *shifted_multiples(sample, SPACE, key, opaque_seed)]
    part, channels = lobe_samples(device, surface, numbers, index, Shells((0.0, 0.0, 0.0)))
    sums, counts = sum_lobes(part, np.zeros(len(device.scene.parts), np.int32), channels, spp, len(site), 1)
    values = lobe_rows(sums[:, 0], np.maximum(counts[:, 0], 1).astype(np.float64))
    return np.concatenate([values[:, _LOCAL], values[:, _ALPHA, None], values[:, _DISTANT]], 1).astype(np.float32)


def _risen(direction: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Unit directions, raised to `LEAST_RISE` above a surface."""
    rise = np.einsum("rc,rc->r", direction, normal)
    raised = direction + np.maximum(LEAST_RISE - rise, 0.0)[:, None] * normal
    return np.asarray(raised / np.linalg.norm(raised, axis=-1, keepdims=True))
