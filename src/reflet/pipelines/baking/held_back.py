"""Viewpoints that nothing is inferred from: by what is shown there, a bake chooses."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32

from reflet.infer.infer_layer import common_rows
from reflet.report.measures import SquaredError, tone_map
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.framing import object_around
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import SegmentedLayers
from reflet.trace.tracer import Tracer

PERFECT = 99.0  # dB, where nothing differs
STEEPEST_DEG = 85.0  # elevation: beyond it azimuth means little
_TRIAL_PLACES = ((-13.0, 7.0), (17.0, -6.0), (5.0, 22.0))  # azimuth and elevation from the middle sample
_TRIAL_IMAGE_SIZE, _TRIAL_SPP, _TRIAL_SAMPLE_COUNT = 256, 16, 16
_TRIAL_SEED = 400_000
_CLOSE_SIZE, CLOSE_SAMPLES = 128, 64
_CLOSE_SEED = 430_000


@dataclass(frozen=True)
class HeldBackView:
    """A traced view at a point of the parameter space."""

    point: Mapping[str, float]
    gbuffer: GBuffer
    layers: SegmentedLayers

    def error(self, parts: Sequence[int], shown: Float32[np.ndarray, "rows 3"]) -> SquaredError:
        """Display error of some parts where the G-buffer's rows show this distant light under the true local layer.

        Over the rows that cover more than half of their pixel.
        """
        traced = self.layers
        rows, at = common_rows(self.gbuffer, traced)
        counts = np.isin(traced.part[at], parts) & (traced.coverage[at] > 0.5)
        rows, at = rows[counts], at[counts]
        seen = traced.local[at] + (1.0 - traced.alpha[at, None]) * shown[rows]
        pictures = [traced.diffuse[at] + light for light in (traced.combined[at], traced.fresnel[at] * seen)]
        difference = np.subtract(*(tone_map(picture) for picture in pictures))
        return SquaredError(float((difference**2).sum()), difference.size)

    def true_distant(self) -> Float32[np.ndarray, "rows 3"]:
        """What maps at their best would show: the traced distant layer, at the G-buffer's rows."""
        rows, at = common_rows(self.gbuffer, self.layers)
        distant = np.zeros((len(self.gbuffer.row_pixel), 3), np.float32)
        distant[rows] = self.layers.distant[at]
        return distant


def trial_views(tracer: Tracer, space: ParameterSpace) -> list[HeldBackView]:
    """Small pictures all around the sampled viewpoints, by which what serves them all is chosen."""
    return held_back_views(
        tracer,
        space,
        _TRIAL_PLACES,
        image_size=trial_size(space),
        spp=_TRIAL_SPP,
        sample_count=_TRIAL_SAMPLE_COUNT,
        seed=_TRIAL_SEED,
    )


def close_views(tracer: Tracer, space: ParameterSpace) -> list[HeldBackView]:
    """The middles of full pictures at the same places, of `CLOSE_SAMPLES` rays and sub-samples a pixel: what shows in
    a finished picture."""
    orbit = space.orbit
    size = min(orbit.image_size, _CLOSE_SIZE)
    half = np.tan(np.radians(orbit.fov_deg / 2.0)) * size / orbit.image_size
    cut_out = replace(orbit, fov_deg=float(2.0 * np.degrees(np.arctan(half))))
    return held_back_views(
        tracer,
        replace(space, orbit=cut_out),
        _TRIAL_PLACES,
        image_size=size,
        spp=CLOSE_SAMPLES,
        sample_count=CLOSE_SAMPLES,
        seed=_CLOSE_SEED,
    )


def trial_size(space: ParameterSpace) -> int:
    """Pixels along an edge of the trials' pictures."""
    return min(space.orbit.image_size, _TRIAL_IMAGE_SIZE)


def display_psnr(shown: Iterable[SquaredError]) -> float:
    """Display PSNR in dB of all that is shown together, at most `PERFECT`; 0 where that is nothing."""
    error = sum(shown, SquaredError())
    return min(error.psnr, PERFECT) if error.values else 0.0


def held_back_views(
    tracer: Tracer,
    space: ParameterSpace,
    places: Iterable[tuple[float, float]],
    *,
    image_size: int,
    spp: int,
    sample_count: int,
    seed: int,
) -> list[HeldBackView]:
    """Views beside the middle sample, at degrees of azimuth and elevation from it, but those inside of objects."""
    orbit, middle = replace(space.orbit, image_size=image_size), space.middle_point()
    views = []
    for number, (azimuth, elevation) in enumerate(places):
        point = {
            **middle,
            "azimuth_deg": middle["azimuth_deg"] + azimuth,
            "elevation_deg": float(np.clip(middle["elevation_deg"] + elevation, -STEEPEST_DEG, STEEPEST_DEG)),
        }
        camera = orbit.camera(point)
        if object_around(tracer.scene, camera) is None:
            view = tracer.view(camera, spp=spp, sample_count=sample_count, seed=seed + number)
            views.append(HeldBackView(point, gbuffer_from_visibility(tracer.scene, view.visibility), view.layers))
    return views
