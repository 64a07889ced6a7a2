"""Local light on rough surfaces, inferred from pictures of them: a parameterized texture map [Hakura00].

Light at a site's texels is only what its lobes gather just there. What playback makes of it between sites and between
texels is the rendering matrix's to say, so pictures from all around correct it: by least squares, as maps are inferred.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32, Int64

from reflet.envmap.env_map import EnvMap
from reflet.infer.infer_layer import common_rows
from reflet.infer.records import RenderingMatrix, Rows
from reflet.infer.shown import shown_by_object
from reflet.infer.solve import SolverSettings, solve
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.surfaces.surface_layer import SurfaceLayer
from reflet.scene.surfaces.surface_taps import TAPS, seen_from, surface_taps
from reflet.trace.layers import TracedView

_SETTINGS = SolverSettings(regularization=0.2, rounds=(12,))
_STAYING = 0.25  # of a texel's own change in the penalty, beside those of what neighbouring sites differ by
_DARKEST = 1e-3  # reflectance by which reflected light is divided


def surface_rows(
    scene: Scene, view: TracedView, surface: SurfaceLayer, shells_of: Sequence[Sequence[EnvMap]], lod_bias: float
) -> Rows:
    """What the pixels of one view ask of the radiance in ``surface``, over the distant maps of each object.

    They show L + (1 - alpha)·D̂, and should what arrives there by way of the lobe, Fresnel's term within it: the target
    is that less what alphas let pass. An error counts as much as it shows: by coverage, reflectance F and, as displays
    saturate, 1/(1 + F·b)², b the brightest channel.
    """
    gbuffer = gbuffer_from_visibility(scene, view.visibility)
    rough = (surface.resolution[gbuffer.triangle] > 0) & (gbuffer.roughness > TRACED_ROUGHNESS)
    chosen = np.flatnonzero(rough)
    b, back = seen_from(scene, gbuffer, view.visibility.camera.position)
    texels, weights = surface_taps(surface, gbuffer.triangle[chosen], b[chosen], back[chosen], gbuffer.mirrored[chosen])
    count = len(gbuffer.row_pixel)
    samples = np.maximum(np.bincount(gbuffer.row_of_sample, minlength=count), 1)
    row = gbuffer.row_of_sample[chosen]
    alpha = np.einsum("nk,nk->n", weights, surface.light.reshape(-1, 4)[texels, 3].astype(np.float32))
    (lookups,) = gbuffer.lookups
    owner = np.asarray(scene.object_of_part)[gbuffer.row_part][gbuffer.row_of_sample]
    passing = (1.0 - alpha)[:, None] * shown_by_object(lookups, owner, shells_of, lod_bias)[chosen]
    passed = np.stack([np.bincount(row, passing[:, c], count) for c in range(3)], -1) / samples[:, None]
    matrix = sp.csr_matrix(
        ((weights / samples[row, None]).ravel(), (np.repeat(row, TAPS), texels.ravel())),
        shape=(count, surface.light.shape[0] * surface.light.shape[1]),
    )
    matrix.sum_duplicates()

    layers, whole = view.layers, np.bincount(row, minlength=count) == samples
    rows, traced = common_rows(gbuffer, layers)
    rows, traced = rows[whole[rows]], traced[whole[rows]]
    fresnel = layers.fresnel[traced]
    arrives = layers.combined[traced] / np.maximum(fresnel, _DARKEST)
    shown = fresnel.max(1) / (1.0 + layers.combined[traced].max(1))
    matrix = matrix[rows]
    return Rows(
        RenderingMatrix(
            matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data.astype(np.float32),
            matrix.shape[1],
        ),
        (arrives - passed[rows]).astype(np.float32),
        (layers.coverage[traced] * shown**2).astype(np.float32),
    )  # fmt: skip


def infer_surface(rows: Collection[Rows], surface: SurfaceLayer, edges: Int64[np.ndarray, "edges 2"]) -> SurfaceLayer:
    """The layer whose radiance shows all blocks of rows best; ``surface`` is the prior, and its alphas stay.

    ``edges`` are pairs of neighbouring sites, whose radiance changes by nearly the same.
    """
    penalty = _SitePenalty.of(edges, *surface.light.shape[:2])
    prior = surface.light[..., :3].reshape(-1, 3).astype(np.float32)
    solution = solve(rows, prior, np.full(3, np.inf), penalty, _SETTINGS, lower=-np.inf)
    radiance = solution.texels.reshape(*surface.light.shape[:2], 3)
    return replace(surface, light=np.concatenate([radiance, surface.light[..., 3:]], -1).astype(np.float16))


@dataclass(frozen=True)
class _SitePenalty:
    """Σ over edges of (d_i - d_j)², texel by texel, + `_STAYING`·Σ d² (`reflet.infer.solve.Penalty`)."""

    laplacian: sp.csr_matrix
    texels: int

    @classmethod
    def of(cls, edges: Int64[np.ndarray, "edges 2"], sites: int, texels: int) -> "_SitePenalty":
        both = np.concatenate([edges, edges[:, ::-1]]).T
        beside = sp.csr_matrix((np.ones(both.shape[1], np.float32), (both[0], both[1])), shape=(sites, sites))
        return cls((sp.diags(beside.sum(1).A1.astype(np.float32)) - beside).tocsr(), texels)

    def gradient(self, d: Float[np.ndarray, "channels texels"]) -> Float32[np.ndarray, "channels texels"]:
        of_sites = d.reshape(len(d), self.laplacian.shape[0], -1)
        out = np.stack([self.laplacian @ channel for channel in of_sites]).reshape(d.shape)
        return (out + np.float32(_STAYING) * d).astype(np.float32)

    def diagonal(self) -> Float32[np.ndarray, "texels"]:
        return np.repeat(self.laplacian.diagonal() + _STAYING, self.texels).astype(np.float32)
