"""The comparison: a PEM beside ray tracing and the methods it replaces, at viewpoints of its own.

Every view is ray traced once, at many samples a pixel and with other random numbers than the bake's. All methods are
drawn by the same renderer, at the same samples a pixel, from maps of the same size, and measured on the same pixels:
those that the object covers by more than half in the reference.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32

from reflet.envmap.env_map import EnvMap
from reflet.envmap.mip_chain import MipChain
from reflet.files.pictures.exr import write_exr
from reflet.infer.fit_geometry import em_origin
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.pipelines.baking.base_maps import LOD_BIASES
from reflet.pipelines.baking.plan_layers import fit_local_layers, plan_distant_layers, plan_local_layers
from reflet.pipelines.baking.probes import probe_size, static_texels, trace_probes
from reflet.pipelines.baking.viewpoints import infer_view, sample_seed
from reflet.pipelines.rivals import as_if_smooth, engine_lights, static_shells
from reflet.progress import ProgressCallback, silent
from reflet.render.device.device import adapter_name
from reflet.render.playback.layouts import Shown
from reflet.render.playback.renderer import ALL_SHOWN, Renderer
from reflet.report.comparison import Comparison, Exhibit, Viewpoint
from reflet.report.measures import EXPOSURE, PIXELS_PER_DEGREE, bounding_box, squared_error
from reflet.report.tally import Tally
from reflet.scene.roughness import is_rough
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace, orbit_space
from reflet.scene.views.sample_pattern import QUICKLY, Samples
from reflet.trace.compose import compose, object_radiance, object_under_distant
from reflet.trace.layers import Shells, StaticProbe
from reflet.trace.tracer import Tracer

MOST_SAMPLES = 3
REFERENCE_SEED = 1_000_000  # far above any sample's
_ANGLES = ("azimuth_deg", "elevation_deg")
HIGHEST_DEG = 89.0  # a camera at the zenith has no upright picture
_ORBIT_SPACING_DEG = 2.0  # of viewpoints that stand for samples
_DOME_BESIDE_DEG, _DOME_ELEVATIONS_DEG = 20.0, (12.0, 52.0)
GEOMETRIES = {"infinite": "infinite_sphere", "sphere": "sphere", "ellipsoid": "ellipsoid", "box": "box"}

Radiance = Float32[np.ndarray, "height width 3"]


@dataclass(frozen=True)
class _Reference:
    """The ray-traced object at one viewpoint: its radiance where it covers anything, and its share of each pixel."""

    view: Viewpoint
    camera: Camera
    radiance: Radiance
    coverage: Float32[np.ndarray, "height width"]

    @property
    def mask(self) -> Bool[np.ndarray, "height width"]:
        return self.coverage > 0.5


def compare(
    pem: ParameterizedEnvironmentMap,
    *,
    samples: Samples | None = None,
    reference_spp: int = 256,
    trace_spp: int | None = None,
    variant: str = "llvm_ad_rgb",
    rivals: bool = True,
    images: str | Path | None = None,
    progress: ProgressCallback = silent,
) -> Comparison:
    """Measures a PEM and its rivals at up to three samples, halfway between them, 10° and 20° above them, and at twelve
    viewpoints of a dome around them.

    Where the PEM has no samples, viewpoints of its orbit stand for them. ``samples`` a pixel are shown (as
    `Renderer.frame` takes them; by default 16, and 64 where those disagree; maps alone with those that they were
    inferred for). Rivals are inferred at the same samples from the same layers (``trace_spp`` defaults to the bake's),
    among them the paper's layers where the PEM traces its own mesh; static maps are seen from the object's centre. Two
    show what roughness is worth: "engine" is such a map looked up as real-time engines do (`SplitSumMap`), with the ray
    tracer's diffuse light and where nothing is of glass, "mirror" plays rough parts as mirrors. The reference has
    ``reference_spp`` samples a pixel. Without ``rivals`` only what the PEM's own maps show is measured, in a third of
    the time. With ``images`` the pictures behind each number are written into that folder:
    ``<where>-<view>-<what>.exr`` with what = reference, mask, or a method (radiance of the object, zero where the mask
    is), and reference-picture and played-picture (everything). Holds about 20 bytes a pixel and view, and the rivals'
    maps.
    """
    samples = samples or QUICKLY
    traces = pem.most_hits > 0
    trace_spp = trace_spp or int(pem.statistics.get("spp", 64))
    folder = Path(images) if images is not None else None
    progress("prepare", 0, 2)
    tracer = Tracer(pem.scene, variant=variant, irradiance=pem.irradiance, through=pem.traced_parts)
    progress("prepare", 1, 2)
    space = _compared_space(pem.space)
    orbit = _subspace(space, _samples(space))
    azimuths = orbit.axes[0].values
    views = _views(orbit)
    tally = Tally()
    pictures: dict[str, dict[str, Radiance]] = {view.where: {} for view in views}
    references = []
    whole: tuple[Radiance, Radiance] | None = None

    def measure(method: str, reference: _Reference, image: Radiance) -> None:
        tally.add(reference.view, method, reference.radiance, image, reference.mask)
        if reference.view.number == 0:
            pictures[reference.view.where][method] = image
        if folder:
            _write(folder, reference, method, image)

    renderer, static = Renderer(pem), Renderer(static_shells(pem, tracer))
    of_maps = samples if isinstance(samples, int) else None  # of maps alone: those that they were inferred for
    wholes: list[tuple[str, Renderer, Collection[Shown], Samples | None]] = [
        ("traced" if traces else "layered", renderer, ALL_SHOWN, samples),
        *([("traced-static", static, ALL_SHOWN, samples)] if traces else []),
        ("static-shells", static, ALL_SHOWN - {"local"}, of_maps),
    ]
    distant_layers: list[tuple[str, Renderer, float | None]] = [
        ("distant-only", renderer, None),
        *([("distant-only-joint", renderer, 1.0)] if "joint" in pem.statistics else []),
        ("distant-only-static", static, None),
    ]
    progress("prepare", 2, 2)
    for number, view in enumerate(views):
        progress("reference and PEM", number, len(views))
        camera = _camera(orbit.orbit, view)
        layers = tracer.view(
            camera, spp=reference_spp, sample_count=1, seed=REFERENCE_SEED + number, surroundings=True
        ).layers
        reference = _Reference(view, camera, *object_radiance(layers))
        references.append(reference)
        for method, drawn_by, shown, of_method in wholes:
            image = drawn_by.frame(camera, what="object", samples=of_method, layers=shown)
            measure(method, reference, straight(image))
        for method, drawn_by, base in distant_layers:
            distant = straight(drawn_by.layer_image(camera, "distant", samples=of_maps, base=base))
            measure(method, reference, object_under_distant(layers, distant))
        wanted = whole is None or (view.where, view.number) == ("between", 0)
        if wanted or folder:
            pair = compose(layers), renderer.frame(camera, samples=samples)[..., :3]
            whole = pair if wanted else whole
        if folder:
            _write(folder, reference, "reference", reference.radiance)
            write_exr(folder / f"{view.name}-mask.exr", reference.mask[..., None].astype(np.float32))
            for what, picture in zip(("reference-picture", "played-picture"), pair, strict=True):
                write_exr(folder / f"{view.name}-{what}.exr", picture)
        del layers
    progress("reference and PEM", len(views), len(views))
    adapter = adapter_name(renderer.device)
    del renderer, static, wholes, distant_layers
    noise = _noise_floor(tracer, references[0], reference_spp)
    if pem.companions or (traces and len(pem.scene.objects) > 1):  # rivals' rays pass through their own object alone
        tracer = Tracer(pem.scene, variant=variant, irradiance=pem.irradiance)
    if rivals:
        undivided = _undivided(pem, tracer)
        for method, rival in _rivals(pem, space, tracer, undivided, trace_spp, variant, progress):
            renderer = Renderer(rival)
            for reference in references:
                image = straight(renderer.frame(reference.camera, what="object", samples=samples))
                measure(method, reference, image)
            del renderer
        if not any(part.reflective and part.material.refraction for part in pem.scene.parts):
            lights = engine_lights(undivided.static["box"], undivided.probes)
            for reference in references:
                measure("engine", reference, tracer.split_sum(reference.camera, lights))

    spacing = azimuths[1] - azimuths[0] if len(azimuths) > 1 else 0.0
    elevations = {view.where: view.elevation_deg for view in views}
    exhibits = tuple(
        _exhibit(reference, pictures[reference.view.where]) for reference in references if reference.view.number == 0
    )
    context: dict[str, Any] = {
        "objects": [item.name for item in pem.scene.objects],
        "adapter": adapter,
        "samples": str(samples),
        "reference_spp": reference_spp,
        "trace_spp": trace_spp,
        "exposure": EXPOSURE,
        "pixels_per_degree": PIXELS_PER_DEGREE,
        "image_size": pem.space.orbit.image_size,
        "parameterization": pem.layers[0].parameterization.name,
        "em_size": max(layer.size for layer in pem.layers),
        "lod_bias": pem.lod_bias,
        "reference_noise_psnr_display": noise,
    }
    assert whole is not None  # there is at least one view
    return Comparison(tally.results(spacing, elevations), tuple(tally.views), exhibits, context, *whole)


def _compared_space(space: ParameterSpace) -> ParameterSpace:
    """The space, with as many samples as are compared if it has none."""
    return space if space.sample_count else orbit_space(space.orbit, MOST_SAMPLES, _ORBIT_SPACING_DEG)


def _samples(space: ParameterSpace) -> list[int]:
    """The samples compared: the first ones along the azimuth, so that neighbours are among them."""
    points = space.points()
    others = {name: value for name, value in points[0].items() if name != "azimuth_deg"}
    return [sample for sample, point in enumerate(points) if others.items() <= point.items()][:MOST_SAMPLES]


def _subspace(space: ParameterSpace, samples: Sequence[int]) -> ParameterSpace:
    """The given samples alone, as an orbit."""
    points = space.points()
    azimuths = tuple(points[sample].get("azimuth_deg", space.orbit.azimuth_deg) for sample in samples)
    first = points[samples[0]]
    orbit = replace(
        space.orbit,
        azimuth_deg=azimuths[0],
        elevation_deg=first.get("elevation_deg", space.orbit.elevation_deg),
        distance=first.get("distance", space.orbit.distance),
    )
    return ParameterSpace((Axis("azimuth_deg", azimuths),), orbit)


def _views(space: ParameterSpace) -> list[Viewpoint]:
    """All viewpoints around the samples of an orbit, place by place."""
    orbit, azimuths = space.orbit, space.axes[0].values
    halfway = [0.5 * (a + b) for a, b in pairwise(azimuths)]
    level, highest = orbit.elevation_deg, max(HIGHEST_DEG, orbit.elevation_deg)
    plan = {
        "sample": [(azimuth, level) for azimuth in azimuths],
        "between": [(azimuth, level) for azimuth in halfway],
        "above-10": [(azimuth, min(level + 10.0, highest)) for azimuth in azimuths],
        "above-20": [(azimuth, min(level + 20.0, highest)) for azimuth in azimuths],
        "dome": dome_points(azimuths),
    }
    return [
        Viewpoint(where, number, *point, space.displacement_deg(dict(zip(_ANGLES, point, strict=True))))
        for where, points in plan.items()
        for number, point in enumerate(points)
    ]


def _camera(orbit: Orbit, view: Viewpoint) -> Camera:
    return orbit.camera(dict(zip(_ANGLES, (view.azimuth_deg, view.elevation_deg), strict=True)))


def dome_points(azimuths: Sequence[float]) -> list[tuple[float, float]]:
    """Azimuth and elevation of seeded random viewpoints, one in each cell of a grid of 4 × 3: up to 20° beside the
    sampled azimuths, at elevations from 12° to 52°."""
    columns, rows = 4, 3
    across = np.linspace(min(azimuths) - _DOME_BESIDE_DEG, max(azimuths) + _DOME_BESIDE_DEG, columns + 1)
    up = np.linspace(*_DOME_ELEVATIONS_DEG, rows + 1)
    share = np.random.default_rng(7).random((columns * rows, 2))
    return [
        (
            float(across[k // rows] + share[k, 0] * (across[1] - across[0])),
            float(up[k % rows] + share[k, 1] * (up[1] - up[0])),
        )
        for k in range(columns * rows)
    ]


def straight(image: Float32[np.ndarray, "height width 4"]) -> Radiance:
    """Radiance without the coverage it was multiplied by; zero where nothing is covered."""
    return image[..., :3] / np.maximum(image[..., 3:], np.float32(1e-6))


def _noise_floor(tracer: Tracer, reference: _Reference, spp: int) -> float:
    """Display PSNR in dB of one reference against the truth.

    Two references differ by twice the variance of one: by 3.01 dB more than one and the truth.
    """
    layers = tracer.view(reference.camera, spp=spp, sample_count=1, seed=2 * REFERENCE_SEED).layers
    again, _ = object_radiance(layers)
    return squared_error(reference.radiance, again, reference.mask).psnr + 10.0 * float(np.log10(2.0))


@dataclass(frozen=True)
class _Undivided:
    """The surroundings of each object seen from its middle, and its distant layer on each of `GEOMETRIES`."""

    probes: list[StaticProbe]
    static: dict[str, tuple[Layer, ...]]


def _undivided(pem: ParameterizedEnvironmentMap, tracer: Tracer) -> _Undivided:
    chain = pem.layers[pem.distant_layers[0]].chain
    undivided = [Shells(em_origin(pem.scene, item.parts)) for item in pem.scene.objects]
    probes = trace_probes(tracer, undivided, probe_size(chain))
    static = {
        short: plan_distant_layers(pem.scene, probes, [(kind,)] * len(probes), chain)
        for short, kind in GEOMETRIES.items()
    }
    return _Undivided(probes, static)


def _rivals(
    pem: ParameterizedEnvironmentMap,
    space: ParameterSpace,
    tracer: Tracer,
    undivided: _Undivided,
    spp: int,
    variant: str,
    progress: ProgressCallback,
) -> Iterator[tuple[str, ParameterizedEnvironmentMap]]:
    """The paper's layers where the PEM traces its own mesh instead, and single-layer PEMs of every geometry, inferred
    at the samples compared; then static maps, and the PEM's shells as mirrors would show them if any part is rough."""
    chain, probes, static = pem.layers[pem.distant_layers[0]].chain, undivided.probes, undivided.static
    samples = _samples(space)
    papers = replace(pem, space=_subspace(space, samples), base=(), lod_bias=LOD_BIASES["none"], most_hits=0)
    plans = {f"single-{short}": plan for short, plan in static.items()}
    if pem.most_hits:
        local = plan_local_layers(pem.scene, probes, pem.on_hull, "ellipsoid", MipChain(max(chain.size // 2, 1)))
        local = fit_local_layers(tracer, papers.space, local, pem.on_hull, None, papers.lod_bias, progress)
        plans = {"layered": (*static["box"], *local), **plans}
    maps: dict[str, list[tuple[EnvMap, ...]]] = {method: [] for method in plans}
    for number, sample in enumerate(samples):
        progress("rivals", number, len(samples))
        view = tracer.view(space.camera(sample), spp=spp, sample_count=pem.sample_count, seed=sample_seed(sample))
        for method, plan in plans.items():
            priors = static_texels(pem.scene, plan, probes, view.layers.camera)
            single = method != "layered"
            solutions = infer_view(pem.scene, view, plan, priors, pem.on_hull, single_layer=single)
            maps[method].append(_env_maps(plan, [solution.texels for solution in solutions]))
        del view
    progress("rivals", len(samples), len(samples))
    for method, plan in plans.items():
        yield method, replace(papers, layers=plan, maps=maps.pop(method))
    one = _subspace(space, samples[:1])
    for short in ("infinite", "box"):
        shown = static_texels(pem.scene, static[short], probes, space.camera(samples[0]))
        maps_shown = [_env_maps(static[short], shown)]
        yield f"static-{short}", replace(papers, space=one, layers=static[short], maps=maps_shown)
    if any(map(is_rough, pem.scene.parts)):
        yield "mirror", as_if_smooth(pem, variant)


def _env_maps(plan: Sequence[Layer], texels: Sequence[Float32[np.ndarray, "_ _"]]) -> tuple[EnvMap, ...]:
    return tuple(EnvMap(layer.chain, x, layer.geometry) for layer, x in zip(plan, texels, strict=True))


def _exhibit(reference: _Reference, pictures: dict[str, Radiance]) -> Exhibit:
    """The first view of a place, cut out around the object."""
    box = bounding_box(reference.coverage > 0.0)
    return Exhibit(
        where=reference.view.where,
        azimuth_deg=reference.view.azimuth_deg,
        elevation_deg=reference.view.elevation_deg,
        reference=reference.radiance[box],
        coverage=reference.coverage[box],
        pictures={method: picture[box] for method, picture in pictures.items()},
    )


def _write(folder: Path, reference: _Reference, what: str, image: Radiance) -> None:
    """One picture of the object, zero where it is not measured."""
    write_exr(folder / f"{reference.view.name}-{what}.exr", np.where(reference.mask[..., None], image, np.float32(0.0)))
