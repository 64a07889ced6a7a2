"""The maps of single viewpoints: of every layer at every sample of the parameter space."""

import time
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.env_map import EnvMap
from reflet.infer.infer_layer import infer_layer
from reflet.infer.records import Solution
from reflet.infer.solve import SolverSettings
from reflet.pem.pem import Layer, shell_number
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.base_maps import LOD_BIASES, Base
from reflet.pipelines.baking.probes import static_texels
from reflet.pipelines.baking.timings import log_timing, solution_statistics
from reflet.progress import ProgressCallback, silent
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import StaticProbe, TracedView
from reflet.trace.tracer import Tracer

_HELD = 0.1  # regularization that holds a viewpoint's maps to the base: with less they are worse elsewhere


def infer_viewpoints(
    tracer: Tracer,
    space: ParameterSpace,
    layers: Sequence[Layer],
    base: Base,
    probes: Sequence[StaticProbe],
    on_hull: Bool[np.ndarray, "triangles"],
    writer: PemWriter,
    *,
    spp: int,
    sample_count: int,
    progress: ProgressCallback = silent,
) -> None:
    """Writes the maps of all samples that are not there yet, inferred from ``spp`` rays a pixel and ``sample_count``
    sub-samples. Distant ones are held to the base where there is one, else they start from the static maps."""
    scene = tracer.scene
    shells = [probe.layout for probe in probes]
    for sample in range(space.sample_count):
        progress("viewpoints", sample, space.sample_count)
        if writer.has(sample):
            continue
        began = time.perf_counter()
        seed = sample_seed(sample)
        view = tracer.view(space.camera(sample), spp=spp, sample_count=sample_count, seed=seed, shells=shells)
        traced = time.perf_counter()
        held = [env_map.texels for env_map in base.maps]
        solutions = infer_view(
            scene,
            view,
            layers,
            held or static_texels(scene, layers, probes, view.layers.camera),
            on_hull,
            base.lod_bias,
            regularization=_HELD if held else None,
        )
        maps = [
            EnvMap(layer.chain, solution.texels, layer.geometry)
            for layer, solution in zip(layers, solutions, strict=True)
        ]
        inferred = time.perf_counter()
        writer.write_sample(sample, layers, maps, {"layers": [solution_statistics(solution) for solution in solutions]})
        log_timing(writer.folder, sample=sample, trace_seconds=traced - began, infer_seconds=inferred - traced)
        del view, solutions, maps
    progress("viewpoints", space.sample_count, space.sample_count)


def sample_seed(sample: int) -> int:
    """The random seed of one sample's rays: its own, whatever was traced before it."""
    return sample + 1


def infer_view(
    scene: Scene,
    view: TracedView,
    layers: Sequence[Layer],
    priors: Sequence[Float[np.ndarray, "texels _"]],
    on_hull: Bool[np.ndarray, "triangles"],
    lod_bias: float = LOD_BIASES["none"],
    *,
    regularization: float | None = None,
    single_layer: bool = False,
) -> list[Solution]:
    """The maps of all layers at one traced view.

    ``priors`` are those of the distant layers, in their order, to which ``regularization`` holds them (by default as
    `infer_layer` does). In a PEM of a ``single_layer`` the distant maps show the local reflections too.
    """
    gbuffer = gbuffer_from_visibility(scene, view.visibility)
    prior = iter(priors)
    solutions = []
    for number, layer in enumerate(layers):
        distant = layer.kind == "distant"
        solutions.append(
            infer_layer(
                "combined" if single_layer else layer.kind,
                gbuffer,
                view.layers,
                layer.parts,
                layer.geometry,
                layer.chain,
                lod_bias,
                shell=shell_number(layers, number),
                channels=layer.channels,
                prior=next(prior) if distant else None,
                on_hull=on_hull,
                map_from_world=layer.map_from_world(view.layers.camera),
                settings=SolverSettings(regularization) if distant and regularization is not None else None,
            )
        )
    return solutions
