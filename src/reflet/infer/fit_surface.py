"""Local light on rough surfaces, as far as maps of distant light do not show it.

Of a texel of a site's map, seen along its direction, playback makes L + (1 - alpha)·D̂, D̂ what it looks up in the
distant maps. With T = (1 - traced alpha)·distant, the light that arrives past the object,

    1 - alpha = min(lum T/lum D̂, `MOST_GAIN`),   L = local + T - (1 - alpha)·D̂.

So what is wrong in D̂ is made up for as well: shells seen from elsewhere than from their origin, lobes that are wider
there than here. By a factor, as far as luminance goes: between texels D̂ has lamps that sums would leave dark rings
around. What is noise of single texels is taken out: sites are averaged with those that they share an edge with, the
less the more their maps differ.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Float32, Int64

from reflet.envmap.env_map import EnvMap
from reflet.envmap.facts import LUMINANCE
from reflet.envmap.lod import lobe_spread
from reflet.infer.shown import shown_by_object
from reflet.reflectance.materials.material import dfg_lookup
from reflet.scene.surfaces.gbuffer import Lookups
from reflet.scene.surfaces.surface_layer import SurfaceLayer, neighbours
from reflet.trace.layers import TracedSurface

MOST_GAIN = 2.0  # what is brighter is added
_ROUNDS = 2  # of averages: more take detail away
_AT_ONCE = 1 << 14  # edges: bounds the memory to some tens of MB


def fit_surface(traced: TracedSurface, shells_of: Sequence[Sequence[EnvMap]], lod_bias: float) -> SurfaceLayer:
    """The layer that playback shows the ``traced`` light with over distant maps, the shells of each object."""
    normal = traced.normal[traced.row_site].astype(np.float64)
    mirrored = traced.mirrored.astype(np.float64)
    cosine = np.clip(np.einsum("rc,rc->r", normal, mirrored), 0.0, 1.0)
    roughness = traced.roughness[traced.row_site].astype(np.float64)
    lobe = dfg_lookup(cosine, roughness)
    peak = mirrored + lobe[:, 2:3] * (normal - mirrored)
    peak /= np.linalg.norm(peak, axis=-1, keepdims=True)
    spread = lobe_spread(roughness * lobe[:, 3]).astype(np.float32)
    lookups = Lookups(
        sample=np.arange(len(cosine), dtype=np.int32),
        weight=np.ones(len(cosine), np.float32),
        position=np.broadcast_to(traced.position[traced.row_site], (3, len(cosine), 3)),  # of pixels without extent
        direction=np.broadcast_to(peak.astype(np.float32), (3, len(cosine), 3)),
        spread=spread,
    )
    shown = shown_by_object(lookups, traced.object[traced.row_site], shells_of, lod_bias)
    past = (1.0 - traced.alpha[:, None]) * traced.distant
    gain = np.minimum(past @ LUMINANCE / np.maximum(shown @ LUMINANCE, 1e-9), MOST_GAIN).astype(np.float32)[:, None]
    texels = np.concatenate([traced.local + past - gain * shown, 1.0 - gain], 1)
    maps = np.zeros((len(traced.position), traced.side**2, 4), np.float32)
    known = np.zeros(maps.shape[:2], bool)
    maps[traced.row_site, traced.row_texel] = texels
    known[traced.row_site, traced.row_texel] = True
    rows_of_site = np.maximum(np.bincount(traced.row_site, minlength=len(maps)), 1)
    brightness = np.bincount(traced.row_site, np.square(traced.local + past).sum(-1), len(maps)) / rows_of_site
    maps = _smoothed(_filled(maps, known, traced.side), brightness, edges_of(traced))
    return SurfaceLayer(traced.resolution, traced.offset, traced.site, maps.astype(np.float16))


def _filled(
    maps: Float32[np.ndarray, "sites texels 4"], known: Bool[np.ndarray, "sites texels"], side: int
) -> Float32[np.ndarray, "sites texels 4"]:
    """Maps whose unknown texels, far below the horizon, are the means of known neighbours, again and again."""
    near, known = neighbours(side), known.copy()
    while not known.all():
        count = known[:, near].sum(-1)
        new = ~known & (count > 0)
        if not new.any():
            break
        sums = sum((maps * known[..., None])[:, near[:, beside]] for beside in range(4))
        maps[new] = sums[new] / count[new, None]
        known |= new
    return maps


def edges_of(traced: TracedSurface | SurfaceLayer) -> Int64[np.ndarray, "edges 2"]:
    """Pairs of different sites that share an edge of a small triangle of a grid."""
    resolutions = np.unique(traced.resolution[traced.resolution > 0])
    none = np.zeros((0, 2), np.int64)
    pairs = np.concatenate([none, *(_edges_of_grid(traced, int(resolution)) for resolution in resolutions)])
    pairs = np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1)
    return np.unique(pairs, axis=0)


def _edges_of_grid(traced: TracedSurface | SurfaceLayer, resolution: int) -> Int64[np.ndarray, "edges 2"]:
    i, j = np.nonzero(np.add.outer(np.arange(resolution), np.arange(resolution)) < resolution)
    entry = i * (2 * resolution + 3 - i) // 2 + j
    right = entry + resolution + 1 - i
    inner = np.concatenate([np.stack(pair, -1) for pair in ((entry, right), (entry, entry + 1), (right, entry + 1))])
    first = traced.offset[traced.resolution == resolution].astype(np.int64)
    return traced.site[first[:, None, None] + inner].reshape(-1, 2).astype(np.int64)


def _smoothed(
    maps: Float32[np.ndarray, "sites texels 4"],
    brightness: Float[np.ndarray, "sites"],
    edges: Int64[np.ndarray, "edges 2"],
) -> Float32[np.ndarray, "sites texels 4"]:
    """Bilateral means over the edges; the median difference of neighbours, in proportion to the ``brightness`` (the
    square of all that arrives) there, says what noise is."""
    flat = maps.reshape(len(maps), -1)
    lit = np.maximum(brightness[edges].sum(1), 1e-30)
    spans = [slice(start, start + _AT_ONCE) for start in range(0, len(edges), _AT_ONCE)]
    for _ in range(_ROUNDS):
        parts = ((edges[some], lit[some]) for some in spans)
        squared = [np.square(flat[some[:, 0]] - flat[some[:, 1]]).mean(1) / its for some, its in parts]
        noise = float(np.median(np.concatenate(squared))) if squared else 0.0
        if noise == 0.0:
            break
        weight = np.exp(-np.concatenate(squared) / (2.0 * noise)).astype(np.float32)
        both = np.concatenate([edges, edges[:, ::-1]]).T
        beside = sp.csr_matrix((np.tile(weight, 2), (both[0], both[1])), shape=(len(flat),) * 2)
        flat = (flat + beside @ flat) / (1.0 + beside.sum(1).A1[:, None])
    return flat.reshape(maps.shape)
