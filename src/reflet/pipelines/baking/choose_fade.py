"""How fast playback fades from the samples' distant maps to the base: chosen at viewpoints beside the samples.

Maps of a viewpoint hold more of what shows there than the base, and less elsewhere.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float32

from reflet.envmap.env_map import EnvMap
from reflet.infer.shown import shown_rows
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.held_back import STEEPEST_DEG, HeldBackView, held_back_views
from reflet.progress import ProgressCallback, silent
from reflet.report.measures import SquaredError
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.tracer import Tracer

_FADES_DEG = (2.0, 3.0, 4.5, 7.0, 10.0, 15.0, 22.0, 33.0, 50.0)
_AWAY_DEG = (4.0, 9.0, 18.0)  # elevation of the views beyond the sampled ones
_SPP, _SAMPLE_COUNT = 16, 16
_SEED = 450_000


def choose_fade(
    tracer: Tracer,
    space: ParameterSpace,
    layers: Sequence[Layer],
    base: Sequence[EnvMap],
    lod_bias: float,
    writer: PemWriter,
    progress: ProgressCallback = silent,
) -> float:
    """The displacement in degrees at which nothing of the samples' maps should be left (`PEM.fade_deg`).

    The one of some ten whose pictures differ least from the traced ones, over views up to 18° above the highest sample,
    or below the lowest one where that is too steep. ``base`` holds the maps of the distant layers; the samples' are
    those that ``writer`` has written.
    """
    progress("fade", 0, len(_AWAY_DEG) + 1)
    views = held_back_views(
        tracer,
        space,
        _places(space),
        image_size=space.orbit.image_size,
        spp=_SPP,
        sample_count=_SAMPLE_COUNT,
        seed=_SEED,
    )
    distant = [number for number, layer in enumerate(layers) if layer.kind == "distant"]
    totals = [SquaredError()] * len(_FADES_DEG)
    for number, view in enumerate(views):
        progress("fade", number + 1, len(_AWAY_DEG) + 1)
        maps = {sample: writer.read_sample(sample, layers) for sample in space.blend_weights(view.point)}
        away = space.displacement_deg(view.point)
        for item in tracer.scene.objects:
            own = [index for index in distant if layers[index].parts == item.parts]
            here = {sample: [of_sample[index] for index in own] for sample, of_sample in maps.items()}
            everywhere = [base[distant.index(index)] for index in own]
            shown = _samples_rows(view, here, space, lod_bias), shown_rows(view.gbuffer, everywhere, lod_bias)
            for k, fade in enumerate(_FADES_DEG):
                share = np.float32(min(away / fade, 1.0))
                totals[k] += view.error(item.parts, (1.0 - share) * shown[0] + share * shown[1])
    progress("fade", len(_AWAY_DEG) + 1, len(_AWAY_DEG) + 1)
    return min(zip(_FADES_DEG, totals, strict=True), key=lambda tried: tried[1].total)[0]


def _places(space: ParameterSpace) -> list[tuple[float, float]]:
    """Azimuth and elevation of the views from the middle sample."""
    middle = space.middle_point()["elevation_deg"]
    elevations = [point.get("elevation_deg", middle) for point in space.points()]
    low, high = min(elevations) - middle, max(elevations) - middle
    above = middle + high + max(_AWAY_DEG) <= STEEPEST_DEG
    return [(0.0, high + away if above else low - away) for away in _AWAY_DEG]


def _samples_rows(
    view: HeldBackView, maps: Mapping[int, Sequence[EnvMap]], space: ParameterSpace, lod_bias: float
) -> Float32[np.ndarray, "rows 3"]:
    """What the samples' maps alone show at a view, blended."""
    weights = space.blend_weights(view.point)
    shown = (
        np.float32(weights[sample]) * shown_rows(view.gbuffer, shells, lod_bias) for sample, shells in maps.items()
    )
    return np.asarray(np.sum(list(shown), axis=0, dtype=np.float32))
