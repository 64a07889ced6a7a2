"""The joint set: maps of the distant layers inferred from viewpoints all around the object together.

A map of one viewpoint holds what shows there best, and is worse than the static map elsewhere. Rows of many viewpoints
in one least-squares problem give the map that serves them all, and those between. Nothing of these viewpoints is stored
but the rows of their matrices, on disk while the bake runs, from where the solver reads them block by block.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.infer.infer_layer import infer_map, layer_rows
from reflet.infer.records import Rows, Solution
from reflet.infer.solve import SolverSettings
from reflet.pem.pem import Layer, shell_number
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.stored_rows import StoredRows, row_arrays
from reflet.progress import ProgressCallback, silent
from reflet.scene.scene import Scene
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import Shells, TracedView
from reflet.trace.tracer import Tracer

SPACING_DEG, COARSE_SPACING_DEG = 20.0, 40.0  # of the viewpoints beside the sampled ones, and of all others
_BELOW_DEG, _ABOVE_DEG = -10.0, 30.0  # elevation of the dome beside the sampled one's
_BESIDE_DEG = 20.0  # azimuth beyond the sampled ones that counts as beside them
_STEEPEST_DEG = 80.0
_MOST_SAMPLED = 3
_SAMPLED_WEIGHT = 8.0  # of their rows: 1 dB more there, and nothing lost elsewhere
_SETTINGS = SolverSettings(regularization=0.02)
_SEED = 500_000


def joint_points(space: ParameterSpace, spacing_deg: float | None = None) -> list[dict[str, float]]:
    """The viewpoints of the joint set: all around, from 10° below to 30° above the sampled elevations.

    Beside the sampled azimuths, up to 20° away, they are about `SPACING_DEG` apart, in azimuth and elevation;
    elsewhere, and everywhere where there are no samples or they go all the way round, `COARSE_SPACING_DEG`. A set of
    the one side alone would be worse on the other than the static map. ``spacing_deg`` replaces both. Last come up to
    `_MOST_SAMPLED` of the samples, unless they go all the way round: where these are, most is looked at, and their rows
    count `_SAMPLED_WEIGHT` times.
    """
    middle, points = space.middle_point(), space.points()
    azimuths = [point.get("azimuth_deg", middle["azimuth_deg"]) for point in points]
    elevations = [point.get("elevation_deg", middle["elevation_deg"]) for point in points] or [middle["elevation_deg"]]
    low, high = np.clip((min(elevations) + _BELOW_DEG, max(elevations) + _ABOVE_DEG), -_STEEPEST_DEG, _STEEPEST_DEG)
    fine, coarse = spacing_deg or SPACING_DEG, spacing_deg or COARSE_SPACING_DEG
    first, last = (min(azimuths) - _BESIDE_DEG, max(azimuths) + _BESIDE_DEG) if azimuths else (0.0, 360.0)
    if last - first > 360.0 - fine:
        beside, others = np.zeros(0), middle["azimuth_deg"] + _evenly(0.0, 360.0, coarse)[:-1]
    else:
        beside, others = _evenly(first, last, fine), _evenly(last, first + 360.0, coarse)[1:-1]
    around = [
        {**middle, "azimuth_deg": float(azimuth), "elevation_deg": float(elevation)}
        for columns, spacing in ((beside, fine), (others, coarse))
        for elevation in _evenly(float(low), float(high), spacing)
        for azimuth in columns
    ]
    if not len(beside):
        return around
    numbers = np.unique(np.linspace(0, len(points) - 1, _MOST_SAMPLED).round().astype(int))
    return around + [{**middle, **points[number]} for number in numbers]


def _evenly(first: float, last: float, spacing: float) -> np.ndarray:
    """Both ends, and numbers between them about ``spacing`` apart; one number where the ends are the same."""
    return np.linspace(first, last, max(round((last - first) / spacing), last > first) + 1)


def infer_joint_set(
    tracer: Tracer,
    space: ParameterSpace,
    points: Sequence[dict[str, float]],
    layers: Sequence[Layer],
    static_maps: Sequence[EnvMap],
    shells: Sequence[Shells],
    lod_bias: float,
    writer: PemWriter,
    *,
    spp: int,
    sample_count: int,
    progress: ProgressCallback = silent,
) -> tuple[list[EnvMap], list[Solution]]:
    """A map of each distant layer of ``layers`` from the views at ``points``, and what inference says of them.

    The priors are ``static_maps``. What is done is kept in the writer's state: rows by viewpoint, then the texels.
    Needs disk space of about 8 bytes a tap, and memory for one viewpoint's rows beside that of a solve.
    """
    names = [[_name(number, index) for number in range(len(points))] for index in range(len(layers))]
    sampled = [{**space.middle_point(), **point} for point in space.points()]
    if not all(writer.has_state(_solved(index)) for index in range(len(layers))):
        for number, point in enumerate(points):
            progress("joint set", number, len(points) + 1)
            if writer.has_state(names[-1][number]):
                continue
            camera = space.orbit.camera(point)
            view = tracer.view(camera, spp=spp, sample_count=sample_count, seed=_SEED + number, shells=shells)
            weight = np.float32(_SAMPLED_WEIGHT if point in sampled else 1.0)
            for index, block in enumerate(_view_rows(tracer.scene, view, layers, lod_bias)):
                weighted = replace(block, weights=weight * block.weights)
                writer.save_state(names[index][number], **row_arrays(weighted))
            del view
    progress("joint set", len(points), len(points) + 1)
    maps, solutions = [], []
    for index, (layer, static) in enumerate(zip(layers, static_maps, strict=True)):
        solution = _load_solution(writer, index)
        if solution is None:
            rows = StoredRows(writer, names[index], layer.chain.texel_count)
            solution = infer_map(rows, static.texels, layer.chain, _SETTINGS)
            writer.save_state(_solved(index), **{name: np.asarray(value) for name, value in vars(solution).items()})
        maps.append(EnvMap(layer.chain, solution.texels, layer.geometry))
        solutions.append(solution)
    writer.drop_state(name for of_layer in names for name in of_layer)
    progress("joint set", len(points) + 1, len(points) + 1)
    return maps, solutions


def _solved(layer: int) -> str:
    return f"joint-{layer}"


def _load_solution(writer: PemWriter, layer: int) -> Solution | None:
    state = writer.load_state(_solved(layer))
    if state is None:
        return None
    return Solution(
        state["texels"], int(state["iterations"]), float(state["relative_residual"]), float(state["seen_share"])
    )


def _name(view: int, layer: int) -> str:
    return f"rows-{view}-{layer}"


def _view_rows(scene: Scene, view: TracedView, layers: Sequence[Layer], lod_bias: float) -> Iterator[Rows]:
    gbuffer = gbuffer_from_visibility(scene, view.visibility)
    for number, layer in enumerate(layers):
        yield layer_rows(
            "distant",
            gbuffer,
            view.layers,
            layer.parts,
            layer.geometry,
            layer.chain,
            lod_bias,
            shell=shell_number(layers, number),
            channels=layer.channels,
        )
