"""The base: maps of the distant layers that serve every viewpoint, static ones or the joint set."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from reflet.envmap.env_map import EnvMap
from reflet.envmap.lod import finer_lod_bias
from reflet.infer.shown import shown_rows
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.held_back import CLOSE_SAMPLES, HeldBackView, close_views, display_psnr
from reflet.pipelines.baking.joint_set import infer_joint_set, joint_points
from reflet.pipelines.baking.probes import STATIC_LOD_BIAS, static_texels
from reflet.pipelines.baking.timings import log_timing, solution_statistics
from reflet.progress import ProgressCallback, silent
from reflet.report.measures import SquaredError
from reflet.scene.views.framing import object_around
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import StaticProbe
from reflet.trace.tracer import Tracer

Kind = Literal["none", "static", "joint"]

# A map that many viewpoints share averages over its texels: finer lookups than those of one viewpoint's maps show more.
LOD_BIASES: dict[Kind, float] = {"none": -1.5, "joint": -2.0, "static": STATIC_LOD_BIAS}
TRACED_LOD_BIAS = -3.0  # of all maps where traced rays end
_ENOUGH = 38.0  # dB of static maps at which nothing is inferred: the edges of pictures of 64 samples have as much error
_GAIN = 0.2  # dB that the joint set must gain over static maps


@dataclass(frozen=True)
class Base:
    """Maps of all distant layers, in their order, none of the kind "none". ``statistics`` tell how it came to be."""

    kind: Kind
    maps: list[EnvMap] = field(default_factory=list)
    statistics: dict[str, Any] = field(default_factory=dict)

    @property
    def lod_bias(self) -> float:
        """Of lookups in it, and in maps that are differences from it."""
        return LOD_BIASES[self.kind]


@dataclass(frozen=True)
class BaseChoice:
    """Which kind serves best, by the display PSNR of both in dB at held-back viewpoints; the joint set is not inferred
    where static maps show enough."""

    kind: Kind
    static_psnr: float
    joint_psnr: float | None = None


def static_base(tracer: Tracer, layers: Sequence[Layer], probes: Sequence[StaticProbe]) -> Base:
    """The static maps of the distant ``layers``."""
    texels = static_texels(tracer.scene, layers, probes)
    return Base("static", [EnvMap(layer.chain, x, layer.geometry) for layer, x in zip(layers, texels, strict=True)])


def joint_base(
    tracer: Tracer,
    space: ParameterSpace,
    layers: Sequence[Layer],
    static: Base,
    probes: Sequence[StaticProbe],
    writer: PemWriter,
    *,
    joint_spacing_deg: float | None,
    spp: int,
    sample_count: int,
    progress: ProgressCallback = silent,
) -> Base:
    """The joint set of the distant ``layers``, from the static maps."""
    points = joint_points(space, joint_spacing_deg)
    points = [point for point in points if object_around(tracer.scene, space.orbit.camera(point)) is None]
    began = time.perf_counter()
    maps, solutions = infer_joint_set(
        tracer, space, points, layers, static.maps, [probe.layout for probe in probes], LOD_BIASES["joint"], writer,
        spp=spp, sample_count=sample_count, progress=progress,
    )  # fmt: skip
    log_timing(writer.folder, joint_seconds=time.perf_counter() - began, joint_viewpoints=len(points))
    joint = {"viewpoints": len(points), "layers": [solution_statistics(each) for each in solutions]}
    return Base("joint", maps, {"joint": joint})


def choose_base(
    tracer: Tracer,
    space: ParameterSpace,
    layers: Sequence[Layer],
    static: Base,
    infer_joint: Callable[[], Base],
    sample_count: int,
) -> Base:
    """The better one of ``static`` and what ``infer_joint`` gives, at held-back viewpoints, as traced rays look it up.

    On faceted meshes rows of facets' edges are noise, and inference does harm. Biases are for ``sample_count`` samples.
    """
    views = close_views(tracer, space)
    bias = finer_lod_bias(TRACED_LOD_BIAS, sample_count, CLOSE_SAMPLES)
    shows_static = _score(tracer, views, layers, static, bias)
    choice = BaseChoice("static", shows_static)
    best = static
    if shows_static < _ENOUGH:
        joint = infer_joint()
        shows_joint = _score(tracer, views, layers, joint, bias)
        best = joint if shows_joint > shows_static + _GAIN else static
        choice = BaseChoice(best.kind, shows_static, shows_joint)
    return Base(best.kind, best.maps, {**best.statistics, "base": asdict(choice)})


def _score(
    tracer: Tracer, views: Sequence[HeldBackView], layers: Sequence[Layer], base: Base, lod_bias: float
) -> float:
    """Display PSNR in dB of the error that maps add to that of true distant light, which rows' mean Fresnel terms and
    alphas make; of all objects."""
    error, least = SquaredError(), SquaredError()
    for item in tracer.scene.objects:
        shells = [each for each, layer in zip(base.maps, layers, strict=True) if layer.parts == item.parts]
        for view in views:
            error += view.error(item.parts, shown_rows(view.gbuffer, shells, lod_bias))
            least += view.error(item.parts, view.true_distant())
    return display_psnr([SquaredError(max(error.total - least.total, 0.0), error.values)])
