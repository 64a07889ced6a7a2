"""The bake: from a scene to the folder of a parameterized environment map.

Order of work: irradiance of the diffuse surroundings; for each object how its distant light is shown, by trial, and its
static env maps; the base, static or inferred from viewpoints all around; then, for viewpoints with maps of their own,
the traced layers, the G-buffer and the inference of every layer's map. Random numbers depend on the sample alone, so a
bake that was killed and resumed equals an undisturbed one byte for byte; only ``timings.jsonl``, a line for every
sample, differs.
"""

from collections.abc import Collection
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, Literal

import psutil

from reflet.envmap.geometry import SHAPES
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import parameterization as parameterization_of
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import valid_texels
from reflet.errors import RefletError
from reflet.pem.map_files import check_chain, codec_named
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking.base_maps import TRACED_LOD_BIAS, Base, choose_base, joint_base, static_base
from reflet.pipelines.baking.choose_distant import AUTO, DistantChoice, check_choice, choose_distant
from reflet.pipelines.baking.choose_fade import choose_fade
from reflet.pipelines.baking.held_back import trial_views
from reflet.pipelines.baking.plan_layers import fit_local_layers, plan_distant_layers, plan_local_layers
from reflet.pipelines.baking.probes import probe_size, trace_probes
from reflet.pipelines.baking.rough_parts import bake_surface
from reflet.pipelines.baking.viewpoints import infer_viewpoints
from reflet.progress import ProgressCallback, silent
from reflet.scene.companions import traced_parts
from reflet.scene.fingerprint import fingerprint
from reflet.scene.holdable_light import with_holdable_light
from reflet.scene.roughness import has_wide_lobes, is_rough
from reflet.scene.scene import Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.framing import check_camera, frame_orbit
from reflet.scene.views.parameter_space import Axis, ParameterSpace, orbit_space
from reflet.trace.gloss.surface_light import MOST_TEXELS
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

TRACED = "traced"
LOCALS = (TRACED, *SHAPES)
MIRROR_HITS = 5  # mirrors that a ray may meet: more show nothing but in deep cavities
GLASS_HITS = 12  # where there is glass, of which a ray meets both sides
IRRADIANCE_SPP = 4  # paths for each sample of diffuse light, times the rays of a pixel: all views see its noise
STATIC_IRRADIANCE_SPP = 2  # of static bakes, which take seconds
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
    distant: str = AUTO,
    shells: int | None = None,
    static: bool = False,
    joint_spacing_deg: float | None = None,
    local: str = TRACED,
    variant: str = "llvm_ad_rgb",
    codec: str = "av1",
    resume: bool = False,
    progress: ProgressCallback = silent,
) -> Path:
    """Bakes a scene into the folder ``out``, and returns that folder.

    ``space`` holds the viewpoints that have maps of their own (default: none where local light is traced, else three of
    them 2° apart), and the orbit that frames the object. ``parameterization`` names how
    maps lay directions out (`reflet.envmap.parameterizations.by_name`). The faces of distant maps have ``em_size`` rows
    (by default about as many texels in all as a cube of 256), those of local ones ``local_size`` (by default half as
    many: they hold less, and finer ones show other viewpoints worse). They are inferred for ``sample_count``
    sub-samples a pixel from layers traced at ``spp`` samples a pixel.

    ``distant`` names the geometry of the distant layer (`reflet.envmap.geometry`): with "relief" it is divided into
    ``shells`` and with "auto" all of it is chosen (`choose_distant`). Its base, which serves all viewpoints, is
    inferred from viewpoints at most ``joint_spacing_deg`` apart all around (`joint_points`); the samples' maps differ
    from it as far as they show more. ``local`` light is "traced" through the mirrors' own meshes in playback, and the
    base then static where that shows more (`choose_base`), and where any part is rough, unless ``joint_spacing_deg`` is
    given; or it is of layers around each part, on the shape that ``local`` names. With such layers a shape as geometry
    is the paper's way: a map a viewpoint, and no base. ``static`` bakes static maps only, for all viewpoints, without
    any inference; a space without samples the base only. An environment too bright for half floats is dealt with as
    `with_holdable_light` says.
    ``codec`` makes all files small, or, "none", plain.
    ``resume`` goes on with an unfinished bake of the same parameters. Raises RefletError for anything that can be put
    right.
    """
    check_choice(distant, shells)
    if local not in LOCALS:
        raise RefletError(f"Local light is traced, or has one of the geometries {', '.join(SHAPES)}; {local} is none.")
    progress("prepare", 0, _PREPARATIONS)
    scene = with_holdable_light(scene)
    laid_out = parameterization_of(parameterization)
    em_size = em_size or default_size(laid_out)
    chain, local_chain = MipChain(em_size, laid_out), MipChain(local_size or max(em_size // 2, 1), laid_out)
    if spp < 1:
        raise RefletError(f"At least one ray a pixel is traced, not {spp}.")
    if joint_spacing_deg is not None and not joint_spacing_deg > 0.0:
        raise RefletError(f"Viewpoints of the joint set are a positive angle apart, not {joint_spacing_deg:g} degrees.")
    traced = local == TRACED
    space = space or orbit_space(frame_orbit(scene), views=default_views(local), spacing_deg=2.0)
    wanted: Literal["none", "static", "joint", "best"]
    wanted = "best" if traced and joint_spacing_deg is None else "joint"
    if wanted == "best" and any(map(is_rough, scene.parts)):
        wanted = "static"  # its levels are filtered by the lobe; what is inferred from traced lobes has their noise
    if static:
        space, wanted = ParameterSpace((Axis("azimuth_deg", ()),), space.orbit), "static"
    elif laid_out.is_view_dependent or (distant in SHAPES and space.sample_count and not traced):
        wanted = "none"
    if laid_out.is_view_dependent and not space.sample_count:
        raise RefletError(
            f"A {laid_out.name} serves one viewpoint only; choose another parameterization, or a viewpoint."
        )
    _check_memory(
        max(chain.texel_count, local_chain.texel_count),
        space.orbit.image_size**2 * sample_count,
        scene.triangle_offsets[-1],
        MOST_TEXELS if traced and any(map(has_wide_lobes, scene.parts)) else 0,
    )
    for each in (chain, local_chain):
        check_chain(each, codec_named(codec))
    for point in space.points() or [{}]:
        check_camera(scene, space.orbit.camera(point))
    use_variant(variant)  # what cannot trace is refused before anything is written
    parameters = {
        "scene": fingerprint(scene),
        "space": asdict(space),
        "parameterization": parameterization,
        "em_size": em_size,
        "local_size": local_chain.size,
        "spp": spp,
        "sample_count": sample_count,
        "distant": distant,
        "shells": shells,
        "base": wanted,
        "joint_spacing_deg": joint_spacing_deg,
        "local": local,
        "variant": variant,
    }
    writer = PemWriter(out, parameters, codec=codec, resume=resume)
    if writer.finished:
        progress("prepare", _PREPARATIONS, _PREPARATIONS)
        return writer.folder

    progress("prepare", 1, _PREPARATIONS)
    on_hull = hull_triangles(scene)
    progress("prepare", 2, _PREPARATIONS)
    paths = spp * (STATIC_IRRADIANCE_SPP if static else IRRADIANCE_SPP)
    through = traced_parts(scene) if traced else ()
    tracer = _tracer_with_irradiance(scene, variant, paths, through, writer, progress)
    views = [] if distant in SHAPES else trial_views(tracer, space)
    choices = choose_distant(tracer, space, views, distant, shells, progress)
    layouts = [choice.shells for choice in choices]
    probes = trace_probes(tracer, layouts, probe_size(chain), writer, progress, [choice.probe for choice in choices])
    distant_layers = plan_distant_layers(scene, probes, [choice.kinds for choice in choices], chain)

    work: dict[str, Any] = {"spp": spp, "sample_count": sample_count, "progress": progress}
    joint: dict[str, Any] = {"joint_spacing_deg": joint_spacing_deg, **work}
    base = Base("none") if wanted == "none" else static_base(tracer, distant_layers, probes)
    if wanted == "joint":
        base = joint_base(tracer, space, distant_layers, base, probes, writer, **joint)
    elif wanted == "best":
        infer_joint = partial(joint_base, tracer, space, distant_layers, base, probes, writer, **joint)
        base = choose_base(tracer, space, distant_layers, base, infer_joint, sample_count)

    local_layers: tuple[Layer, ...] = ()
    if space.sample_count and not traced:
        local_layers = plan_local_layers(scene, probes, on_hull, local, local_chain)
        local_layers = fit_local_layers(tracer, space, local_layers, on_hull, writer, base.lod_bias, progress)
    layers = distant_layers + local_layers
    infer_viewpoints(tracer, space, layers, base, probes, on_hull, writer, **work)
    fade_deg = 0.0
    if base.maps and space.sample_count:
        fade_deg = choose_fade(tracer, space, layers, base.maps, base.lod_bias, writer, progress)
    lod_bias = TRACED_LOD_BIAS if traced else base.lod_bias
    surface = None
    if traced:
        surface = bake_surface(
            tracer, space, distant_layers, base, lod_bias, spp, writer, inferred=not static, progress=progress
        )
    glass = any(part.reflective and part.material.refraction for part in scene.parts)
    statistics = {"spp": spp, "distant": [_told(choice) for choice in choices], **base.statistics}
    progress("write", 0, 1)
    writer.finish(
        scene=scene,
        irradiance=tracer.irradiance,
        space=space,
        layers=layers,
        on_hull=on_hull,
        lod_bias=lod_bias,
        sample_count=sample_count,
        statistics=statistics,
        base=base.maps,
        fade_deg=fade_deg,
        most_hits=(GLASS_HITS if glass else MIRROR_HITS) if traced else 0,
        surface=surface,
    )
    progress("write", 1, 1)
    return writer.folder


def default_views(local: str) -> int:
    """How many viewpoints have maps of their own: traced local light needs none."""
    return 0 if local == TRACED else 3


def default_size(parameterization: Parameterization) -> int:
    """Rows, a power of two, of a map that holds about as many texels as a cube of 256."""
    return equal_sampling_size(parameterization, 256**2 * valid_texels(CUBE), power_of_two=True)


def _check_memory(texels: int, sub_samples: int, triangles: int, on_surfaces: int) -> None:
    """Raises RefletError where inference would not fit into the memory that is free.

    A solve holds about fourteen vectors of four float32 a texel, of maps or ``on_surfaces``, the G-buffer 72 bytes a
    sub-sample, a rendering matrix about as much again. Tables and trees of the scene take up to 700 bytes a triangle
    (benchmarks/large_meshes.py).
    """
    needed = 224 * max(texels, on_surfaces) + 144 * sub_samples + 700 * triangles
    free = psutil.virtual_memory().available
    if needed > free:
        raise RefletError(
            f"This bake takes about {needed / 2**30:.0f} GiB of memory, {free / 2**30:.0f} GiB are free; choose smaller"
            " maps (--em-size) or pictures (--image-size), or a mesh of fewer triangles"
            + ("; or --local ellipsoid, which keeps no light on rough surfaces." if on_surfaces else ".")
        )


def _tracer_with_irradiance(
    scene: Scene, variant: str, paths: int, through: Collection[int], writer: PemWriter, progress: ProgressCallback
) -> Tracer:
    """A tracer whose irradiance is traced once and kept, so that a resumed bake has the very same."""
    state = writer.load_state("irradiance")
    if state is not None:
        tracer = Tracer(scene, variant=variant, through=through, irradiance=IrradianceMap(**state))
        progress("prepare", _PREPARATIONS, _PREPARATIONS)
        return tracer

    def report(done: int, total: int) -> None:
        if done == 0:  # the tables are ready
            progress("prepare", _PREPARATIONS, _PREPARATIONS)
        progress("diffuse light", done, total)

    tracer = Tracer(scene, variant=variant, through=through, irradiance_spp=paths, progress=report)
    writer.save_state("irradiance", **vars(tracer.irradiance))
    return tracer


def _told(choice: DistantChoice) -> dict[str, Any]:
    """A choice with its trials, as statistics say it."""
    trials = [asdict(trial) for trial in choice.trials]
    return {"kinds": list(choice.kinds), "ends": list(choice.shells.ends), "trials": trials}
