"""The surface layer of a bake: local light on parts whose lobes are wide."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.infer.fit_surface import edges_of, fit_surface
from reflet.infer.infer_surface import infer_surface, surface_rows
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.base_maps import Base
from reflet.pipelines.baking.stored_rows import StoredRows, row_arrays
from reflet.progress import ProgressCallback, silent
from reflet.scene.roughness import has_wide_lobes, narrowest_wide_lobes
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer, side_for
from reflet.scene.views.framing import object_around
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.tracer import Tracer

_TRACED_SHARE = 2  # of a pixel's rays one in so many is traced for one of the fewest directions of a site
VIEWPOINTS = 96  # all around, 18° apart
_LOWEST_DEG, _HIGHEST_DEG = -15.0, 80.0  # their elevations
_IMAGE_SIZE, _SAMPLE_COUNT, _SHARE = 256, 4, 2  # of their pictures: wide lobes show little that is smaller
_MOST_SAMPLED = 3
_GOLDEN_DEG = 180.0 * (3.0 - np.sqrt(5.0))
_SEED = 600_000


def surface_points(space: ParameterSpace) -> list[dict[str, float]]:
    """`VIEWPOINTS` evenly over the directions, on a spiral, at the middle distance; last up to three of the samples, or
    the orbit's own viewpoint where there are none: it is looked at most."""
    middle, points = space.middle_point(), space.points()
    low, high = np.sin(np.radians((_LOWEST_DEG, _HIGHEST_DEG)))
    number = np.arange(VIEWPOINTS)
    elevations = np.degrees(np.arcsin(low + (high - low) * (number + 0.5) / VIEWPOINTS))
    around = [
        {**middle, "azimuth_deg": float(azimuth), "elevation_deg": float(elevation)}
        for azimuth, elevation in zip(middle["azimuth_deg"] + _GOLDEN_DEG * number, elevations, strict=True)
    ]
    chosen = np.unique(np.linspace(0, max(len(points) - 1, 0), _MOST_SAMPLED).round().astype(int))
    return around + ([{**middle, **points[each]} for each in chosen] if points else [middle])


def bake_surface(
    tracer: Tracer,
    space: ParameterSpace,
    layers: Sequence[Layer],
    base: Base,
    lod_bias: float,
    spp: int,
    writer: PemWriter,
    *,
    inferred: bool,
    progress: ProgressCallback = silent,
) -> SurfaceLayer | None:
    """Local light of parts whose lobes are wide, beside the base's maps of the distant ``layers``. None without any.

    Traced at sites all over them, and, where ``inferred``, corrected by pictures from `surface_points`. All is kept in
    the writer's state, rows of pictures too: about 2 MB each.
    """
    scene = tracer.scene
    parts = [number for number, part in enumerate(scene.parts) if has_wide_lobes(part)]
    if not parts or not base.maps:
        return None
    state = writer.load_state("surface")
    if state is not None:
        return SurfaceLayer(**state)
    shells_of = [
        [env_map for env_map, layer in zip(base.maps, layers, strict=True) if layer.parts == item.parts]
        for item in scene.objects
    ]
    surface = _traced(tracer, parts, shells_of, lod_bias, spp, writer, progress)
    if inferred:
        names = _rows(tracer, space, surface, shells_of, lod_bias, spp, writer, progress)
        texels = surface.light.shape[0] * surface.light.shape[1]
        surface = infer_surface(StoredRows(writer, names, texels), surface, edges_of(surface))
        writer.drop_state([*names, "surface-traced"])
        progress("rough surfaces", len(names) + 1, len(names) + 1)
    writer.save_state("surface", **vars(surface))
    return surface


def _traced(
    tracer: Tracer,
    parts: Sequence[int],
    shells_of: Sequence[Sequence[EnvMap]],
    lod_bias: float,
    spp: int,
    writer: PemWriter,
    progress: ProgressCallback,
) -> SurfaceLayer:
    state = writer.load_state("surface-traced")
    if state is not None:
        return SurfaceLayer(**state)
    side = side_for(min(narrowest_wide_lobes(tracer.scene.parts[part]) for part in parts))
    few = max(spp * SIDES[0] ** 2 // (_TRACED_SHARE * side**2), 1)  # as many in all, however many directions
    traced = tracer.surface(parts, spp=few, side=side, progress=partial(progress, "light on surfaces"))
    surface = fit_surface(traced, shells_of, lod_bias)
    writer.save_state("surface-traced", **vars(surface))
    return surface


def _rows(
    tracer: Tracer,
    space: ParameterSpace,
    surface: SurfaceLayer,
    shells_of: Sequence[Sequence[EnvMap]],
    lod_bias: float,
    spp: int,
    writer: PemWriter,
    progress: ProgressCallback,
) -> list[str]:
    """The names of all rows in the writer's state, once they are there."""
    orbit = replace(space.orbit, image_size=min(space.orbit.image_size, _IMAGE_SIZE))
    cameras = [orbit.camera(point) for point in surface_points(space)]
    cameras = [camera for camera in cameras if object_around(tracer.scene, camera) is None]
    names = [f"surface-rows-{number}" for number in range(len(cameras))]
    for number, (name, camera) in enumerate(zip(names, cameras, strict=True)):
        progress("rough surfaces", number, len(names) + 1)
        if not writer.has_state(name):
            view = tracer.view(camera, spp=max(spp // _SHARE, 1), sample_count=_SAMPLE_COUNT, seed=_SEED + number)
            writer.save_state(name, **row_arrays(surface_rows(tracer.scene, view, surface, shells_of, lod_bias)))
    progress("rough surfaces", len(names), len(names) + 1)
    return names
