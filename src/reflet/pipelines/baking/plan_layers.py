"""The layers that a bake fills: the distant shells of every object, and the local layers of its parts."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np
from jaxtyping import Bool

from reflet.envmap.geometry import Ellipsoid, Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.infer.fit_geometry import fit
from reflet.infer.fit_local import TRIALS, fit_local_ellipsoid
from reflet.infer.fit_shells import fit_shells
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.progress import ProgressCallback, silent
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import StaticProbe
from reflet.trace.tracer import Tracer

FIT_IMAGE_SIZE, FIT_MAP_SIZE, FIT_SPP, FIT_ELEVATION_DEG = 192, 64, 16, 10.0  # of the fit of local shapes
_SHELL_NAMES = {1: ("distant",), 2: ("near", "far"), 3: ("near", "middle", "far")}


def plan_distant_layers(
    scene: Scene, probes: Sequence[StaticProbe], kinds: Sequence[tuple[str, ...]], chain: MipChain
) -> tuple[Layer, ...]:
    """The shells of each object's probe as layers, of geometries of these kinds, nearest first."""
    layers = []
    for item, probe, of_object in zip(scene.objects, probes, kinds, strict=True):
        ends = (0.0, *probe.layout.ends, inf)
        geometries = fit_shells(of_object, scene, item.parts, probe)
        for number, (name, geometry) in enumerate(zip(_SHELL_NAMES[len(geometries)], geometries, strict=True)):
            reach = {"begin": ends[number], "end": ends[number + 1]}
            layers.append(
                Layer(
                    f"{item.name} {name}", "distant", item.parts, geometry, chain.size, chain.parameterization, **reach
                )
            )
    return tuple(layers)


def plan_local_layers(
    scene: Scene, probes: Sequence[StaticProbe], on_hull: Bool[np.ndarray, "triangles"], local: str, chain: MipChain
) -> tuple[Layer, ...]:
    """A local layer of each reflective part that is not all on the convex hull."""
    layers = []
    for item, probe in zip(scene.objects, probes, strict=True):
        for part in item.parts:
            if on_hull[scene.triangle_offsets[part] : scene.triangle_offsets[part + 1]].all():
                continue
            # Hemisphere and box around a part make no sense without what lies beyond it: they are fitted to the room.
            around = None if local in ("ellipsoid", "sphere", "infinite_sphere") else probe
            geometry: Geometry = fit(local, scene, (part,), around)
            name = f"{scene.parts[part].name} local"
            layers.append(Layer(name, "local", (part,), geometry, chain.size, chain.parameterization))
    return tuple(layers)


def fit_local_layers(
    tracer: Tracer,
    space: ParameterSpace,
    layers: tuple[Layer, ...],
    on_hull: Bool[np.ndarray, "triangles"],
    writer: PemWriter | None,
    lod_bias: float,
    progress: ProgressCallback = silent,
) -> tuple[Layer, ...]:
    """The layers with their local ellipsoids fitted to small pictures of what the parts reflect of their object.

    The pictures are taken at the middle sample, where maps are tried, at the first one, and above the middle, so that
    the shapes hold off the samples too. What was fitted is kept in the writer's state, where one is given.
    """
    points = space.points()
    middle = points[len(points) // 2]
    above = middle.get("elevation_deg", space.orbit.elevation_deg) + FIT_ELEVATION_DEG
    small = replace(space.orbit, image_size=min(space.orbit.image_size, FIT_IMAGE_SIZE))
    to_fit = [layer.kind == "local" and type(layer.geometry) is Ellipsoid for layer in layers]
    steps, done = TRIALS * sum(to_fit), 0
    progress("local shapes", 0, steps)
    views = []
    for at in (middle, points[0], {**middle, "elevation_deg": min(above, 80.0)}):
        view = tracer.view(small.camera(at), spp=FIT_SPP, sample_count=4, seed=0)
        views.append((gbuffer_from_visibility(tracer.scene, view.visibility), view.layers))
    fitted = []
    for number, layer in enumerate(layers):
        geometry = layer.geometry
        if to_fit[number] and type(geometry) is Ellipsoid:
            state = writer.load_state(f"shape-{number}") if writer else None
            if state is None:
                chain = MipChain(min(layer.size, FIT_MAP_SIZE))
                geometry = fit_local_ellipsoid(
                    geometry,
                    views,
                    layer.parts[0],
                    on_hull,
                    lod_bias,
                    chain,
                    progress=partial(_trial, progress, done, steps),
                )
                state = {"centre": np.array(geometry.centre), "radii": np.array(geometry.radii)}
                if writer:
                    writer.save_state(f"shape-{number}", **state)
            centre, radii = (tuple(state[name].tolist()) for name in ("centre", "radii"))
            geometry = Ellipsoid(centre, radii, centre)
            done += TRIALS
            progress("local shapes", done, steps)
        fitted.append(replace(layer, geometry=geometry))
    return tuple(fitted)


def _trial(progress: ProgressCallback, before: int, steps: int, trial: int) -> None:
    progress("local shapes", before + trial, steps)
