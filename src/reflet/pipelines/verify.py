"""The check that the graphics system looks maps up as inference believed."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.sparse as sp

from reflet.envmap.relief import Relief
from reflet.infer.records import RenderingMatrix
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.verify_bounces import Bounces, verify_bounces
from reflet.pipelines.verify_surface import SurfaceLookups, verify_surface
from reflet.progress import ProgressCallback, silent
from reflet.render.device.device import adapter_name, filters_exactly
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.test_renderings import measured_rendering_matrices
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.surfaces.visibility import Visibility
from reflet.trace.tracer import Tracer

# Largest difference of a weight. Software adapters filter in float: what is left is float32 geometry. Graphics cards
# round the three fractions of a trilinear weight to 8 bits, up to 1/512 each.
EXACT_TOLERANCE = 1e-4
CARD_TOLERANCE = 1e-2
RELIEF_STRAYS = 5e-3  # of rows: by the edge of a gap a rounding may send a search to its other side; 0.2 % measured
LEAST_SHARE = 0.99  # of sub-samples in which tracer and rasterizer see the same triangle


@dataclass(frozen=True)
class Verification:
    """Measured against analytic rendering matrix, and mirrored rays as drawn against traced ones.

    ``max_difference`` is the largest difference of a weight over all layers, but for the share ``strays`` of a relief's
    rows, those that differ most; ``test_renderings`` the number of pictures drawn to measure it, ``compared_share`` the
    share of the tracer's sub-samples that see the same triangle in the rasterizer: only those are compared. ``agrees``
    tells whether the difference is at most ``tolerance``, which depends on the kind of adapter, and the share at least
    0.99; and what ``bounces`` say, where rays are traced, and ``surface``, where light lies on surfaces.
    """

    max_difference: float
    adapter: str
    test_renderings: int
    compared_share: float
    tolerance: float
    agrees: bool
    strays: float
    bounces: Bounces | None = None
    surface: SurfaceLookups | None = None

    def __str__(self) -> str:
        verdict = "agrees with" if self.agrees else "differs from"
        but = f" but for {self.strays:.1%} of those pixels that reliefs are looked up for" if self.strays else ""
        return (
            f"The rendering matrix measured on {self.adapter} {verdict} the analytic one: largest difference "
            f"{self.max_difference:.2e} (allowed {self.tolerance:.0e}) over {self.compared_share:.2%} of the "
            f"sub-samples{but}, {self.test_renderings} test renderings."
        ) + "".join(f"\n{more}" for more in (self.bounces, self.surface) if more)


def verify(
    pem: ParameterizedEnvironmentMap,
    *,
    sample: int = 0,
    renderer: Renderer | None = None,
    variant: str = "llvm_ad_rgb",
    progress: ProgressCallback = silent,
) -> Verification:
    """Compares the two rendering matrices of every layer at one sample of the parameter space, or at the orbit's own
    point where it has none.

    The analytic ones follow from the ray tracer's visibility, the measured ones from what the adapter draws. Where
    mirrored rays are traced, their ways are compared as well (`verify_bounces`): lookups at their ends are by the same
    code as those of the first surface. So are lookups of light on surfaces (`verify_surface`).
    """
    steps = 3 + bool(pem.most_hits) + (pem.surface is not None)
    progress("prepare", 0, steps)
    renderer = renderer or Renderer(pem)
    progress("prepare", 1, steps)
    camera = pem.space.camera(sample) if pem.space.sample_count else pem.space.orbit.camera()
    tracer = Tracer(pem.scene, variant=variant, irradiance=pem.irradiance)
    progress("prepare", 2, steps)
    traced = tracer.view(camera, spp=1, sample_count=pem.sample_count).visibility
    common = common_samples(traced, rasterized_visibility(renderer, camera, pem.sample_count))
    gbuffer = gbuffer_from_visibility(pem.scene, common)
    part_of_sample = gbuffer.row_part[gbuffer.row_of_sample]
    progress("prepare", 3, steps)
    bounces = verify_bounces(pem, camera, variant=variant) if pem.most_hits else None
    if bounces:
        progress("prepare", 4, steps)
    surface = verify_surface(pem, camera) if pem.surface else None
    progress("prepare", steps, steps)
    worst, drawn, left_out = 0.0, 0, 0.0
    for kind in sorted({layer.kind for layer in pem.layers}):
        measured, renderings = measured_rendering_matrices(
            renderer, common, kind, partial(progress, f"{kind} test renderings")
        )
        drawn += renderings
        for i, matrix in measured.items():
            layer = pem.layers[i]
            select = np.isin(part_of_sample, layer.parts)
            if kind == "local":
                select &= ~pem.on_hull[gbuffer.triangle]
            analytic = rendering_matrix(
                gbuffer, layer.chain, layer.geometry, pem.lod_bias, select, layer.map_from_world(camera)
            )
            strays = RELIEF_STRAYS if isinstance(layer.geometry, Relief) else 0.0
            worst, left_out = max(worst, largest_difference(analytic, matrix, strays)), max(left_out, strays)
    share = len(common.pixel) / max(len(traced.pixel), 1)
    tolerance = EXACT_TOLERANCE if filters_exactly(renderer.device) else CARD_TOLERANCE
    agrees = (
        worst <= tolerance and share >= LEAST_SHARE and all(each is None or each.agrees for each in (bounces, surface))
    )
    return Verification(
        worst, adapter_name(renderer.device), drawn, share, tolerance, agrees, left_out, bounces, surface
    )


def common_samples(a: Visibility, b: Visibility) -> Visibility:
    """The sub-samples that see the same triangle in both; in the order of ``a``."""

    def keys(v: Visibility) -> np.ndarray:
        place = v.pixel.astype(np.int64) * v.sample_count + v.sub_sample
        return place << 32 | v.triangle.astype(np.int64)

    same = np.isin(keys(a), keys(b), assume_unique=True)
    return replace(a, pixel=a.pixel[same], sub_sample=a.sub_sample[same], triangle=a.triangle[same])


def largest_difference(a: RenderingMatrix, b: RenderingMatrix, strays: float = 0.0) -> float:
    """The largest difference between weights of the same row and texel, but for a share of the rows, the worst ones."""
    worst = np.abs(_sparse(a) - _sparse(b)).max(axis=1).toarray().ravel()
    kept = len(worst) - int(strays * len(worst))
    return float(np.partition(worst, kept - 1)[kept - 1]) if kept else 0.0


def _sparse(matrix: RenderingMatrix) -> sp.csr_matrix:
    shape = len(matrix.starts) - 1, matrix.texel_count
    return sp.csr_matrix((matrix.weights, matrix.columns, matrix.starts), shape=shape)
