"""The comparison: a PEM beside ray tracing and the methods it replaces, at viewpoints of its own.

Every view is ray traced once, at many samples a pixel and with other random numbers than the bake's. All methods are
drawn by the same renderer, at the same samples a pixel, from maps of the same size, and measured on the same pixels:
those that the object covers by more than half in the reference.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32

from reflet.envmap.env_map import EnvMap
from reflet.envmap.mip_chain import MipChain
from reflet.files.pictures.exr import write_exr
from reflet.infer.fit_geometry import fit
from reflet.infer.prior import prior_texels
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.pipelines.bake import infer_view, probe_size, sample_seed, trace_probes
from reflet.progress import ProgressCallback, silent
from reflet.render.device.device import adapter_name
from reflet.render.playback.renderer import Renderer
from reflet.report.comparison import Comparison, Exhibit
from reflet.report.measures import EXPOSURE, PIXELS_PER_DEGREE, bounding_box, squared_error
from reflet.report.tally import Tally
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.trace.compose import compose
from reflet.trace.layers import SegmentedLayers, StaticProbe
from reflet.trace.tracer import Tracer

MOST_SAMPLES = 3
REFERENCE_SEED = 1_000_000  # far above any sample's
HIGHEST_DEG = 89.0  # a camera at the zenith has no upright picture
GEOMETRIES = {"infinite": "infinite_sphere", "sphere": "sphere", "ellipsoid": "ellipsoid", "box": "box"}

Radiance = Float32[np.ndarray, "height width 3"]


@dataclass(frozen=True)
class _View:
    """A viewpoint, and the place it stands for with its number there."""

    where: str
    number: int
    azimuth_deg: float
    elevation_deg: float
    camera: Camera

    @property
    def name(self) -> str:
        return f"{self.where}-{self.number}"


@dataclass(frozen=True)
class _Reference:
    """The ray-traced object at one view: its radiance where it covers anything, and its share of each pixel."""

    view: _View
    radiance: Radiance
    coverage: Float32[np.ndarray, "height width"]

    @property
    def mask(self) -> Bool[np.ndarray, "height width"]:
        return self.coverage > 0.5


def compare(
    pem: ParameterizedEnvironmentMap,
    *,
    samples: int | None = None,
    reference_spp: int = 256,
    trace_spp: int | None = None,
    variant: str = "llvm_ad_rgb",
    images: str | Path | None = None,
    progress: ProgressCallback = silent,
) -> Comparison:
    """Measures a PEM and its rivals at up to three samples, halfway between them, and 10° and 20° above them.

    ``samples`` a pixel are shown (default: those that the maps were inferred for). Rivals are inferred at the same
    samples from the same layers (``trace_spp`` defaults to the bake's); static maps are seen from the object's centre.
    The reference has ``reference_spp`` samples a pixel. With ``images`` the pictures behind each number are written
    into that folder: ``<where>-<view>-<what>.exr`` with what = reference, mask, or a method (radiance of the object,
    zero where the mask is), and reference-picture and layered-picture (everything). Holds about 20 bytes a pixel and
    view, and the rivals' maps.
    """
    samples = samples or pem.sample_count
    trace_spp = trace_spp or int(pem.statistics.get("spp", 64))
    folder = Path(images) if images is not None else None
    progress("prepare", 0, 2)
    tracer = Tracer(pem.scene, variant=variant, irradiance=pem.irradiance)
    progress("prepare", 1, 2)
    orbit = _subspace(pem.space, _samples(pem.space))
    azimuths = orbit.axes[0].values
    views = _views(orbit.orbit, azimuths)
    tally = Tally()
    pictures: dict[str, dict[str, Radiance]] = {view.where: {} for view in views}
    references = []
    whole: tuple[Radiance, Radiance] | None = None

    def measure(method: str, reference: _Reference, image: Radiance) -> None:
        tally.add(reference.view.where, method, reference.radiance, image, reference.mask)
        if reference.view.number == 0:
            pictures[reference.view.where][method] = image
        if folder:
            _write(folder, reference, method, image)

    renderer = Renderer(pem)
    progress("prepare", 2, 2)
    for number, view in enumerate(views):
        progress("reference and layered", number, len(views))
        layers = tracer.view(
            view.camera, spp=reference_spp, sample_count=1, seed=REFERENCE_SEED + number, surroundings=True
        ).layers
        reference = _Reference(view, *object_radiance(layers))
        references.append(reference)
        measure("layered", reference, straight(renderer.frame(view.camera, what="object", samples=samples)))
        distant = straight(renderer.layer_image(view.camera, "distant", samples=samples))
        measure("distant-only", reference, object_under_distant(layers, distant))
        traced, shown = compose(layers), renderer.frame(view.camera, samples=samples)[..., :3]
        if whole is None or (view.where, view.number) == ("between", 0):
            whole = traced, shown
        if folder:
            _write(folder, reference, "reference", reference.radiance)
            write_exr(folder / f"{view.name}-mask.exr", reference.mask[..., None].astype(np.float32))
            write_exr(folder / f"{view.name}-reference-picture.exr", traced)
            write_exr(folder / f"{view.name}-layered-picture.exr", shown)
        del layers
    progress("reference and layered", len(views), len(views))
    adapter = adapter_name(renderer.device)
    del renderer
    noise = _noise_floor(tracer, references[0], reference_spp)
    for method, rival in _rivals(pem, tracer, trace_spp, progress):
        renderer = Renderer(rival)
        for reference in references:
            image = straight(renderer.frame(reference.view.camera, what="object", samples=samples))
            measure(method, reference, image)
        del renderer

    spacing = azimuths[1] - azimuths[0] if len(azimuths) > 1 else 0.0
    elevations = {view.where: view.elevation_deg for view in views}
    exhibits = tuple(
        _exhibit(reference, pictures[reference.view.where]) for reference in references if reference.view.number == 0
    )
    context: dict[str, Any] = {
        "objects": [item.name for item in pem.scene.objects],
        "adapter": adapter,
        "samples": samples,
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
    return Comparison(tally.results(spacing, elevations), exhibits, context, *whole)


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


def _views(orbit: Orbit, azimuths: Sequence[float]) -> list[_View]:
    """All viewpoints, place by place."""
    halfway = [0.5 * (a + b) for a, b in pairwise(azimuths)]
    plan = {
        "sample": (azimuths, 0.0),
        "between": (halfway, 0.0),
        "above-10": (azimuths, 10.0),
        "above-20": (azimuths, 20.0),
    }
    views = []
    for where, (angles, rise) in plan.items():
        for number, azimuth in enumerate(angles):
            elevation = min(orbit.elevation_deg + rise, max(HIGHEST_DEG, orbit.elevation_deg))
            camera = orbit.camera({"azimuth_deg": azimuth, "elevation_deg": elevation})
            views.append(_View(where, number, azimuth, elevation, camera))
    return views


def object_radiance(layers: SegmentedLayers) -> tuple[Radiance, Float32[np.ndarray, "height width"]]:
    """Radiance of the object alone, mean over what covers each pixel, and that coverage."""
    return _mean_over_parts(layers, layers.diffuse + layers.combined)


def object_under_distant(layers: SegmentedLayers, distant: Radiance) -> Radiance:
    """The object with its traced local layer over a distant layer that comes from maps."""
    seen = distant.reshape(-1, 3)[layers.pixel]
    values = layers.diffuse + layers.fresnel * (layers.local + (1.0 - layers.alpha[:, None]) * seen)
    return _mean_over_parts(layers, values)[0]


def _mean_over_parts(
    layers: SegmentedLayers, values: Float32[np.ndarray, "rows 3"]
) -> tuple[Radiance, Float32[np.ndarray, "height width"]]:
    """Per pixel, the mean of the rows' values by coverage, and the sum of the coverages."""
    height, width = layers.surroundings.shape[:2]
    coverage = np.bincount(layers.pixel, layers.coverage, height * width)
    sums = [np.bincount(layers.pixel, layers.coverage * values[:, channel], height * width) for channel in range(3)]
    radiance = np.stack(sums, -1) / np.maximum(coverage, 1e-9)[:, None]
    return (
        radiance.astype(np.float32).reshape(height, width, 3),
        coverage.astype(np.float32).reshape(height, width),
    )


def straight(image: Float32[np.ndarray, "height width 4"]) -> Radiance:
    """Radiance without the coverage it was multiplied by; zero where nothing is covered."""
    return image[..., :3] / np.maximum(image[..., 3:], np.float32(1e-6))


def _noise_floor(tracer: Tracer, reference: _Reference, spp: int) -> float:
    """Display PSNR in dB of one reference against the truth.

    Two references differ by twice the variance of one: by 3.01 dB more than one and the truth.
    """
    layers = tracer.view(reference.view.camera, spp=spp, sample_count=1, seed=2 * REFERENCE_SEED).layers
    again, _ = object_radiance(layers)
    return squared_error(reference.radiance, again, reference.mask).psnr + 10.0 * float(np.log10(2.0))


def _rivals(
    pem: ParameterizedEnvironmentMap, tracer: Tracer, spp: int, progress: ProgressCallback
) -> Iterator[tuple[str, ParameterizedEnvironmentMap]]:
    """Single-layer PEMs of every geometry, inferred at the samples compared, then static maps."""
    chain = next(layer.chain for layer in pem.layers if layer.kind == "distant")
    probes = trace_probes(tracer, probe_size(chain))
    plans = {short: _one_layer(pem, probes, kind, chain) for short, kind in GEOMETRIES.items()}
    samples = _samples(pem.space)
    maps: dict[str, list[tuple[EnvMap, ...]]] = {short: [] for short in GEOMETRIES}
    for number, sample in enumerate(samples):
        progress("rivals", number, len(samples))
        view = tracer.view(pem.space.camera(sample), spp=spp, sample_count=pem.sample_count, seed=sample_seed(sample))
        for short, plan in plans.items():
            solutions = infer_view(pem.scene, view, plan, probes, pem.on_hull, pem.lod_bias, single_layer=True)
            maps[short].append(_env_maps(plan, [solution.texels for solution in solutions]))
        del view
    progress("rivals", len(samples), len(samples))
    space = _subspace(pem.space, samples)
    for short, plan in plans.items():
        yield f"single-{short}", replace(pem, space=space, layers=plan, maps=maps.pop(short))
    for short in ("infinite", "box"):
        frames = [layer.map_from_world(pem.space.camera(samples[0])) for layer in plans[short]]
        texels = [prior_texels(p.chain, p.texels, chain, frame) for p, frame in zip(probes, frames, strict=True)]
        static = _env_maps(plans[short], texels)
        yield (
            f"static-{short}",
            replace(pem, space=_subspace(pem.space, samples[:1]), layers=plans[short], maps=[static]),
        )


def _one_layer(
    pem: ParameterizedEnvironmentMap, probes: Sequence[StaticProbe], kind: str, chain: MipChain
) -> tuple[Layer, ...]:
    """One layer for each object, fitted to what is around it."""
    return tuple(
        Layer(
            item.name,
            "distant",
            item.parts,
            fit(kind, pem.scene, item.parts, probe),
            chain.size,
            chain.parameterization,
        )
        for item, probe in zip(pem.scene.objects, probes, strict=True)
    )


def _env_maps(plan: Sequence[Layer], texels: Sequence[Float32[np.ndarray, "texels 3"]]) -> tuple[EnvMap, ...]:
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
