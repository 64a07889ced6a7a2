"""Fitting the ellipsoid of a local layer to what the part truly mirrors of its own object.

Local geometry is near: where an ellipsoid is off, one texel is asked for several values, at one viewpoint already and
the more so at others. So the shape is chosen by its outcome: a small map is inferred at one viewpoint, shown at
several, and the ellipsoid's radii and centre are moved until what it shows is closest to the traced pictures.
"""

from collections.abc import Callable, Sequence
from itertools import count

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.geometry import Ellipsoid
from reflet.envmap.mip_chain import MipChain
from reflet.infer.infer_layer import common_rows, infer_layer, looking_up
from reflet.infer.product import multiply
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.infer.solve import SolverSettings
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.trace.layers import SegmentedLayers

_SETTINGS = SolverSettings(regularization=0.02, rounds=(6,))
TRIALS = 60  # small inferences that one shape takes
_FIRST_STEP = 0.15  # of the radii: how far the search looks at first


def fit_local_ellipsoid(
    start: Ellipsoid,
    views: Sequence[tuple[GBuffer, SegmentedLayers]],
    part: int,
    on_hull: Bool[np.ndarray, "triangles"],
    lod_bias: float,
    chain: MipChain,
    progress: Callable[[int], None] = lambda trial: None,
) -> Ellipsoid:
    """The ellipsoid near ``start`` whose local map of ``part``, inferred at the first view, shows all views best.

    Small pictures and maps do (192² pixels of 4 sub-samples, ``chain`` of 64²): a part's few thousand rows settle six
    numbers. The views should span what the map is to be shown from, so that parallax counts. Deterministic; sixty small
    inferences, `TRIALS`, of whose numbers ``progress`` hears. Returns ``start`` where the first view does not see the
    part reflect its object.
    """
    gbuffer, layers = views[0]
    if not looking_up(gbuffer, (part,), on_hull).any() or not layers.alpha[layers.part == part].any():
        return start

    def ellipsoid(q: Float[np.ndarray, "6"]) -> Ellipsoid:
        x, y, z = (float(v) for v in q[3:])
        a, b, c = (float(v) for v in np.exp(q[:3]))
        return Ellipsoid((x, y, z), (a, b, c), (x, y, z))

    trials = count()

    def error(q: Float[np.ndarray, "6"]) -> float:
        progress(next(trials))
        shape = ellipsoid(q)
        solution = infer_layer(
            "local", gbuffer, layers, (part,), shape, chain, lod_bias, on_hull=on_hull, settings=_SETTINGS
        )
        return sum(_error(solution.texels, shape, *view, part, on_hull, lod_bias, chain) for view in views)

    first = np.concatenate([np.log(start.radii), start.centre])
    steps = np.concatenate([np.full(3, _FIRST_STEP), _FIRST_STEP * np.array(start.radii)])
    simplex = np.vstack([first, first + np.diag(steps)])
    options = {"maxfev": TRIALS, "initial_simplex": simplex}
    from scipy.optimize import minimize  # here, for most bakes need none of it: 0.2 s

    return ellipsoid(minimize(error, first, method="Nelder-Mead", options=options).x)


def _error(
    texels: Float[np.ndarray, "texels 4"],
    shape: Ellipsoid,
    gbuffer: GBuffer,
    layers: SegmentedLayers,
    part: int,
    on_hull: Bool[np.ndarray, "triangles"],
    lod_bias: float,
    chain: MipChain,
) -> float:
    """Squared differences of incident light, compressed as 1 - exp(-b) so that lights do not decide alone."""
    select = looking_up(gbuffer, (part,), on_hull)
    shown = multiply(rendering_matrix(gbuffer, chain, shape, lod_bias, select), texels)
    rows, traced = common_rows(gbuffer, layers)
    own = gbuffer.row_part[rows] == part
    rows, traced = rows[own], traced[own]
    distant, alpha = layers.distant[traced], layers.alpha[traced, None]
    truth = layers.local[traced] + (1.0 - alpha) * distant
    seen = shown[rows, :3] + (1.0 - shown[rows, 3:]) * distant
    return float((layers.coverage[traced, None] * (np.exp(-truth) - np.exp(-seen)) ** 2).sum(dtype=np.float64))
