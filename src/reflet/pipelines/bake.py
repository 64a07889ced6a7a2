"""The bake: from a scene to the folder of a parameterized environment map.

Order of work: irradiance of the diffuse surroundings; for each object its static env map, from which the geometries are
fitted; then viewpoint by viewpoint the traced layers, the G-buffer and the inference of every layer's map. Random
numbers depend on the sample alone, so a bake that was killed and resumed equals an undisturbed one byte for byte; only
``timings.jsonl``, a line for every sample, differs.
"""

import json
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
import psutil
from jaxtyping import Bool

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import KINDS, SHAPES, Ellipsoid, Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import parameterization as parameterization_of
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import valid_texels
from reflet.errors import RefletError
from reflet.infer.fit_geometry import em_origin, fit
from reflet.infer.fit_local import TRIALS, fit_local_ellipsoid
from reflet.infer.infer_layer import infer_layer
from reflet.infer.prior import prior_texels
from reflet.infer.records import Solution
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.progress import ProgressCallback, silent
from reflet.scene.fingerprint import fingerprint
from reflet.scene.holdable_light import with_holdable_light
from reflet.scene.scene import Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.framing import check_camera, frame_orbit
from reflet.scene.views.parameter_space import ParameterSpace, orbit_space
from reflet.trace.layers import StaticProbe, TracedView
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

LOD_BIAS = -1.5
PROBE_SPP = 64
FIT_IMAGE_SIZE, FIT_MAP_SIZE, FIT_SPP, FIT_ELEVATION_DEG = 192, 64, 16, 10.0  # of the fit of local shapes
IRRADIANCE_SPP = 4  # paths for each sample of diffuse light, times the rays of a pixel: all views see its noise
TIMINGS = "timings.jsonl"
_PREPARATIONS = 3  # what is told of what comes before the rays: the scene's fingerprint, its hulls, its tables


def bake(
    scene: Scene,
    out: str | Path,
    space: ParameterSpace | None = None,
    *,
    parameterization: str = "cube",
    em_size: int | None = None,
    local_size: int | None = None,
    spp: int = 64,
    sample_count: int = 16,
    distant: str = "box",
    local: str = "ellipsoid",
    variant: str = "llvm_ad_rgb",
    resume: bool = False,
    progress: ProgressCallback = silent,
) -> Path:
    """Bakes a scene into the folder ``out``, and returns that folder.

    ``space`` holds the viewpoints (default: three of them 2° apart, framing the object). ``parameterization`` names how
    maps lay directions out (`reflet.envmap.parameterizations.by_name`). The faces of distant maps have ``em_size`` rows
    (by default about as many texels in all as a cube of 256), those of local ones ``local_size`` (by default half as
    many: they hold less, and finer ones show other viewpoints worse). They are inferred for ``sample_count``
    sub-samples a pixel from layers traced at ``spp`` samples a pixel. ``distant`` and ``local`` name geometries
    (`reflet.envmap.geometry`). An environment too bright for half floats is dealt with as `with_holdable_light` says.
    ``resume`` goes on with an unfinished bake of the same parameters. Raises RefletError for anything that can be put
    right.
    """
    for layer, kind, kinds in (("distant", distant, KINDS), ("local", local, SHAPES)):
        if kind not in kinds:
            raise RefletError(f"The {layer} geometry is one of {', '.join(kinds)}; {kind} is none.")
    progress("prepare", 0, _PREPARATIONS)
    scene = with_holdable_light(scene)
    laid_out = parameterization_of(parameterization)
    em_size = em_size or default_size(laid_out)
    chains = {"distant": MipChain(em_size, laid_out), "local": MipChain(local_size or max(em_size // 2, 1), laid_out)}
    if spp < 1:
        raise RefletError(f"At least one ray a pixel is traced, not {spp}.")
    space = space or orbit_space(frame_orbit(scene), views=3, spacing_deg=2.0)
    _check_memory(
        max(chain.texel_count for chain in chains.values()),
        space.orbit.image_size**2 * sample_count,
        scene.triangle_offsets[-1],
    )
    for sample in range(space.sample_count):
        check_camera(scene, space.camera(sample))
    use_variant(variant)  # what cannot trace is refused before anything is written
    parameters = {
        "scene": fingerprint(scene),
        "space": asdict(space),
        "parameterization": parameterization,
        "em_size": em_size,
        "local_size": chains["local"].size,
        "spp": spp,
        "sample_count": sample_count,
        "lod_bias": LOD_BIAS,
        "distant": distant,
        "local": local,
        "variant": variant,
    }
    writer = PemWriter(out, parameters, resume=resume)
    if writer.finished:
        progress("prepare", _PREPARATIONS, _PREPARATIONS)
        return writer.folder

    progress("prepare", 1, _PREPARATIONS)
    on_hull = hull_triangles(scene)
    progress("prepare", 2, _PREPARATIONS)
    tracer = _tracer_with_irradiance(scene, variant, spp, writer, progress)
    probes = trace_probes(tracer, probe_size(chains["distant"]), writer, progress)
    layers = plan_layers(scene, probes, on_hull, distant, local, chains)
    layers = fit_local_layers(tracer, space, layers, on_hull, writer, progress)
    for sample in range(space.sample_count):
        progress("viewpoints", sample, space.sample_count)
        if writer.has(sample):
            continue
        began = time.perf_counter()
        view = tracer.view(space.camera(sample), spp=spp, sample_count=sample_count, seed=sample_seed(sample))
        traced = time.perf_counter()
        solutions = infer_view(scene, view, layers, probes, on_hull)
        maps = [
            EnvMap(layer.chain, solution.texels, layer.geometry)
            for layer, solution in zip(layers, solutions, strict=True)
        ]
        inferred = time.perf_counter()
        writer.write_sample(sample, layers, maps, {"layers": [_statistics(solution) for solution in solutions]})
        _log(writer.folder, sample=sample, trace_seconds=traced - began, infer_seconds=inferred - traced)
        del view, solutions, maps
    progress("viewpoints", space.sample_count, space.sample_count)
    progress("write", 0, 1)
    writer.finish(
        scene=scene,
        irradiance=tracer.irradiance,
        space=space,
        layers=layers,
        on_hull=on_hull,
        lod_bias=LOD_BIAS,
        sample_count=sample_count,
        statistics={"spp": spp},
    )
    progress("write", 1, 1)
    return writer.folder


def default_size(parameterization: Parameterization) -> int:
    """Rows, a power of two, of a map that holds about as many texels as a cube of 256."""
    return equal_sampling_size(parameterization, 256**2 * valid_texels(CUBE), power_of_two=True)


def probe_size(chain: MipChain) -> int:
    """The size of a cube that holds no fewer texels than the maps whose prior it becomes; their own if they are cubes.

    A power of two, like any.
    """
    texels = chain.size**2 * valid_texels(chain.parameterization)
    return int(2 ** max(np.ceil(0.5 * np.log2(texels / valid_texels(CUBE)) - 1e-9), 0.0))


def sample_seed(sample: int) -> int:
    """The random seed of one sample's rays: its own, whatever was traced before it."""
    return sample + 1


def trace_probes(
    tracer: Tracer, size: int, writer: PemWriter | None = None, progress: ProgressCallback = silent
) -> list[StaticProbe]:
    """The static env map of every object, seen from its EM origin; kept in the writer's state where one is given."""
    probes = []
    objects = tracer.scene.objects
    for number, item in enumerate(objects):
        progress("static maps", number, len(objects))
        state = writer.load_state(f"static-{number}") if writer else None
        if state is not None:
            origin = state["origin"].tolist()
            probes.append(StaticProbe((origin[0], origin[1], origin[2]), state["texels"], state["distance"]))
            continue
        probe = tracer.probe(number, em_origin(tracer.scene, item.parts), size=size, spp=PROBE_SPP)
        if writer:
            writer.save_state(
                f"static-{number}", origin=np.array(probe.origin), texels=probe.texels, distance=probe.distance
            )
        probes.append(probe)
    progress("static maps", len(objects), len(objects))
    return probes


def plan_layers(
    scene: Scene,
    probes: Sequence[StaticProbe],
    on_hull: Bool[np.ndarray, "triangles"],
    distant: str,
    local: str,
    chains: dict[str, MipChain],
) -> tuple[Layer, ...]:
    """One distant layer for each object, and a local one for each of its parts that is not all on the convex hull."""
    layers = []
    for item, probe in zip(scene.objects, probes, strict=True):
        geometry = fit(distant, scene, item.parts, probe)
        layers.append(_layer("distant", item.name, item.parts, geometry, chains))
        for part in item.parts:
            if on_hull[scene.triangle_offsets[part] : scene.triangle_offsets[part + 1]].all():
                continue
            # Hemisphere and box around a part make no sense without what lies beyond it: they are fitted to the room.
            around = None if local in ("ellipsoid", "sphere", "infinite_sphere") else probe
            geometry = fit(local, scene, (part,), around)
            layers.append(_layer("local", scene.parts[part].name, (part,), geometry, chains))
    return tuple(layers)


def _layer(
    kind: Literal["distant", "local"], of: str, parts: tuple[int, ...], geometry: Geometry, chains: dict[str, MipChain]
) -> Layer:
    return Layer(f"{of} {kind}", kind, parts, geometry, chains[kind].size, chains[kind].parameterization)


def fit_local_layers(
    tracer: Tracer,
    space: ParameterSpace,
    layers: tuple[Layer, ...],
    on_hull: Bool[np.ndarray, "triangles"],
    writer: PemWriter,
    progress: ProgressCallback = silent,
) -> tuple[Layer, ...]:
    """The layers with their local ellipsoids fitted to small pictures of what the parts reflect of their object.

    The pictures are taken at the middle sample, where maps are tried, at the first one, and above the middle, so that
    the shapes hold off the samples too. What was fitted is kept in the writer's state.
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
            state = writer.load_state(f"shape-{number}")
            if state is None:
                chain = MipChain(min(layer.size, FIT_MAP_SIZE))
                geometry = fit_local_ellipsoid(
                    geometry,
                    views,
                    layer.parts[0],
                    on_hull,
                    LOD_BIAS,
                    chain,
                    progress=partial(_trial, progress, done, steps),
                )
                state = {"centre": np.array(geometry.centre), "radii": np.array(geometry.radii)}
                writer.save_state(f"shape-{number}", **state)
            centre, radii = (tuple(state[name].tolist()) for name in ("centre", "radii"))
            geometry = Ellipsoid(centre, radii, centre)
            done += TRIALS
            progress("local shapes", done, steps)
        fitted.append(replace(layer, geometry=geometry))
    return tuple(fitted)


def _trial(progress: ProgressCallback, before: int, steps: int, trial: int) -> None:
    progress("local shapes", before + trial, steps)


def infer_view(
    scene: Scene,
    view: TracedView,
    layers: Sequence[Layer],
    probes: Sequence[StaticProbe],
    on_hull: Bool[np.ndarray, "triangles"],
    lod_bias: float = LOD_BIAS,
    *,
    single_layer: bool = False,
) -> list[Solution]:
    """The maps of all layers at one traced view. Distant ones start from their object's static map.

    In a PEM of a ``single_layer`` the distant maps show the local reflections too.
    """
    gbuffer = gbuffer_from_visibility(scene, view.visibility)
    solutions = []
    for layer in layers:
        map_from_world = layer.map_from_world(view.layers.camera)
        prior = None
        if layer.kind == "distant":
            probe = probes[scene.object_of_part[layer.parts[0]]]
            prior = prior_texels(probe.chain, probe.texels, layer.chain, map_from_world)
        solutions.append(
            infer_layer(
                "combined" if single_layer else layer.kind,
                gbuffer,
                view.layers,
                layer.parts,
                layer.geometry,
                layer.chain,
                lod_bias,
                prior=prior,
                on_hull=on_hull,
                map_from_world=map_from_world,
            )
        )
    return solutions


def _check_memory(texels: int, sub_samples: int, triangles: int) -> None:
    """Raises RefletError where inference would not fit into the memory that is free.

    A solve holds about nine vectors of four float32 a texel, the G-buffer 72 bytes a sub-sample, a rendering matrix
    about as much again. Tables and trees of the scene take up to 700 bytes a triangle (benchmarks/large_meshes.py).
    """
    needed, free = 144 * texels + 144 * sub_samples + 700 * triangles, psutil.virtual_memory().available
    if needed > free:
        raise RefletError(
            f"This bake takes about {needed / 2**30:.0f} GiB of memory, {free / 2**30:.0f} GiB are free; choose smaller"
            " maps (--em-size) or pictures (--image-size), or a mesh of fewer triangles."
        )


def _tracer_with_irradiance(
    scene: Scene, variant: str, spp: int, writer: PemWriter, progress: ProgressCallback
) -> Tracer:
    """A tracer whose irradiance is traced once and kept, so that a resumed bake has the very same."""
    state = writer.load_state("irradiance")
    if state is not None:
        tracer = Tracer(scene, variant=variant, irradiance=IrradianceMap(**state))
        progress("prepare", _PREPARATIONS, _PREPARATIONS)
        return tracer

    def report(done: int, total: int) -> None:
        if done == 0:  # the tables are ready
            progress("prepare", _PREPARATIONS, _PREPARATIONS)
        progress("diffuse light", done, total)

    tracer = Tracer(scene, variant=variant, irradiance_spp=IRRADIANCE_SPP * spp, progress=report)
    writer.save_state("irradiance", **vars(tracer.irradiance))
    return tracer


def _statistics(solution: Solution) -> dict[str, Any]:
    """A solution without its texels."""
    return {
        "iterations": solution.iterations,
        "relative_residual": solution.relative_residual,
        "seen_share": solution.seen_share,
    }


def _log(folder: Path, **entry: float) -> None:
    """Appends a line to the bake's timings, which play no part in its result."""
    with suppress(OSError), (folder / TIMINGS).open("a") as file:
        file.write(json.dumps(entry) + "\n")
