"""The geometry of every object's distant surroundings, and how many shells divide them: chosen by trial.

The geometry decides how reflections move [Hakura01, sec. 4], so candidates are judged by how they show a static map at
viewpoints all around the sampled ones: on small pictures, against the traced distant layer. Of the candidates whose
pictures are within `_GAIN` of the best, the cheapest to look up is taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import KINDS, SHAPES, Geometry
from reflet.envmap.relief import FETCHES, Relief
from reflet.envmap.shapes import InfiniteSphere
from reflet.errors import RefletError
from reflet.infer.depth_gap import depth_gaps
from reflet.infer.fit_geometry import em_origin
from reflet.infer.fit_shells import fit_shells
from reflet.infer.shown import shown_rows
from reflet.pem.pem import MOST_SHELLS
from reflet.pipelines.baking.held_back import HeldBackView, display_psnr, trial_size
from reflet.pipelines.baking.probes import PROBE_SPP, STATIC_LOD_BIAS, seen_by
from reflet.progress import ProgressCallback, silent
from reflet.scene.bounds import reach
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import Shells, StaticProbe
from reflet.trace.tracer import Tracer

AUTO, RELIEF = "auto", Relief.kind
_GAIN = 0.3  # dB that a candidate must gain over cheaper ones


@dataclass(frozen=True)
class Trial:
    """One candidate: the kinds of its shells' geometries, nearest first, what a lookup costs in fetches, and the
    display PSNR of its static map, in dB over all trial pictures (`display_psnr`)."""

    kinds: tuple[str, ...]
    fetches: int
    psnr: float


@dataclass(frozen=True)
class DistantChoice:
    """How an object's distant surroundings are shown, and the trials that say why (none where it was asked for, or
    nothing is near).

    ``probe`` is the static env map of the trials, of `PROBE_SPP` rays a texel.
    """

    shells: Shells
    kinds: tuple[str, ...]
    trials: tuple[Trial, ...] = ()
    probe: StaticProbe | None = field(default=None, compare=False, repr=False)


def choose_distant(
    tracer: Tracer,
    space: ParameterSpace,
    views: Sequence[HeldBackView],
    distant: str,
    shell_count: int | None,
    progress: ProgressCallback = silent,
) -> list[DistantChoice]:
    """The choice for every object, by the `trial_views` of a space.

    ``distant`` is "auto", or the kind of geometry to take; "auto" and "relief" leave the number of shells open unless
    ``shell_count`` says it. Where surroundings have fewer gaps in depth than asked for, there are fewer shells; where
    all is infinitely far nothing is tried: by chance a hemisphere may look better, whose floor is not there. All is as
    `check_choice` allows.
    """
    count = len(tracer.scene.objects)
    origins = [em_origin(tracer.scene, item.parts) for item in tracer.scene.objects]
    if distant in SHAPES:
        return [DistantChoice(Shells(origin), (distant,)) for origin in origins]
    map_size = 1 << (trial_size(space) - 1).bit_length()  # as many rows as the picture, or a few more
    choices = []
    for number, origin in enumerate(origins):
        progress("choose shells", number, count)
        distance = tracer.distances(number, Shells(origin), size=map_size)[0]
        if distant == AUTO and not np.isfinite(distance).any():
            choices.append(DistantChoice(Shells(origin), (InfiniteSphere.kind,)))
            continue
        most = MOST_SHELLS if shell_count is None else shell_count
        gaps = depth_gaps(distance, reach(tracer.scene, number, origin), most - 1)
        fewest = 0 if shell_count is None else len(gaps)
        layouts = [Shells(origin, tuple(sorted(gaps[:used]))) for used in range(fewest, len(gaps) + 1)]
        choices.append(_best(tracer, number, layouts, distant, views, map_size))
    progress("choose shells", count, count)
    return choices


def check_choice(distant: str, shell_count: int | None) -> None:
    """Raises RefletError for a geometry that is none, for shells of a shape, and for more than `MOST_SHELLS`."""
    if distant not in (AUTO, *KINDS):
        raise RefletError(f"The distant geometry is one of {', '.join((AUTO, *KINDS))}; {distant} is none.")
    if shell_count is not None and not 1 <= shell_count <= MOST_SHELLS:
        raise RefletError(f"An object has 1 to {MOST_SHELLS} shells, not {shell_count}.")
    if distant in SHAPES and shell_count not in (None, 1):
        raise RefletError(f"Shells need their true distances; {distant} has none. Choose relief or auto, or one shell.")


def _best(
    tracer: Tracer,
    number: int,
    layouts: Sequence[Shells],
    distant: str,
    views: Sequence[HeldBackView],
    map_size: int,
) -> DistantChoice:
    """The best of all layouts, which have more shells one by one."""
    parts = tracer.scene.objects[number].parts
    if len(layouts) == 1 and len(_kinds(layouts[0], distant)) == 1:
        return DistantChoice(layouts[0], _kinds(layouts[0], distant)[0])
    trials: list[tuple[Trial, StaticProbe]] = []
    probes = [tracer.probe(number, layout, size=map_size, spp=PROBE_SPP) for layout in layouts if layout.count > 1]
    if layouts[0].count == 1:
        whole = probes[0].undivided() if probes else tracer.probe(number, layouts[0], size=map_size, spp=PROBE_SPP)
        probes.insert(0, whole)
    for probe in probes:
        seen = [seen_by(tracer.scene, parts, probe, shell) for shell in range(probe.layout.count)]
        for kinds in _kinds(probe.layout, distant):
            geometries = fit_shells(kinds, tracer.scene, parts, probe)
            fitted = tuple(geometry.kind for geometry in geometries)
            if any(trial.kinds == fitted and other is probe for trial, other in trials):
                continue  # where nothing is near, all are the sphere at infinity
            psnr = _score(probe, seen, geometries, parts, views)
            trials.append((Trial(fitted, sum(map(_fetches, geometries)), psnr), probe))
    enough = max(trial.psnr for trial, _ in trials) - _GAIN
    best, probe = min(
        ((trial, probe) for trial, probe in trials if trial.psnr >= enough), key=lambda t: (t[0].fetches, -t[0].psnr)
    )
    return DistantChoice(probe.layout, best.kinds, tuple(trial for trial, _ in trials), probe)


def _kinds(layout: Shells, distant: str) -> Sequence[tuple[str, ...]]:
    """Geometries to try. A near shell holds what stands about in its true places: it is a relief."""
    near = (RELIEF,) * (layout.count - 1)
    if distant == RELIEF:
        return [(*near, RELIEF)]
    last = ("infinite_sphere", "box", "ellipsoid", "hemisphere", RELIEF) if not near else ("box", RELIEF)
    return [(*near, kind) for kind in last]


def _fetches(geometry: Geometry) -> int:
    """Texture fetches of a lookup: that of the map, and a search's."""
    return 1 + (FETCHES if isinstance(geometry, Relief) else 0)


def _score(
    probe: StaticProbe,
    seen: Sequence[Float32[np.ndarray, "texels _"]],
    geometries: Sequence[Geometry],
    parts: Sequence[int],
    views: Sequence[HeldBackView],
) -> float:
    """Display PSNR in dB of an object over all views, which shows its shells as ``seen`` by its parts."""
    shells = [EnvMap(probe.chain, texels, geometry) for texels, geometry in zip(seen, geometries, strict=True)]
    return display_psnr(view.error(parts, shown_rows(view.gbuffer, shells, STATIC_LOD_BIAS)) for view in views)
