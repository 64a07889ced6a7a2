"""The static env maps of a scene's objects, kept in the state of an unfinished bake, and as layers show them."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Float32

from reflet.envmap.lod import roughness_of_level
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.sampling import valid_texels
from reflet.infer.fit_geometry import em_origin
from reflet.infer.prior import lobe_levels, mirrors, prior_texels
from reflet.pem.pem import Layer, shell_number
from reflet.pem.writer import PemWriter
from reflet.progress import ProgressCallback, silent
from reflet.scene.roughness import is_rough, least_roughness, most_roughness, share_smoother
from reflet.scene.scene import Scene
from reflet.scene.views.camera import Camera
from reflet.trace.layers import ShellProbe, Shells, StaticProbe
from reflet.trace.tracer import Tracer

PROBE_SPP = 16  # more show nothing: pictures average many texels
_FINE = 2  # the level that the least lobes to filter for read: they are interpolated with the one that is finer
_SHARP = 0.75  # share of the mirrored light
STATIC_LOD_BIAS = -2.5  # static maps are filtered once already: finer lookups show more of them


def probe_size(chain: MipChain) -> int:
    """The size of a cube that holds no fewer texels than the maps whose prior it becomes; their own if they are cubes.

    A power of two, like any.
    """
    texels = chain.size**2 * valid_texels(chain.parameterization)
    return int(2 ** max(np.ceil(0.5 * np.log2(texels / valid_texels(CUBE)) - 1e-9), 0.0))


def trace_probes(
    tracer: Tracer,
    shells: Sequence[Shells],
    size: int,
    writer: PemWriter | None = None,
    progress: ProgressCallback = silent,
    known: Sequence[StaticProbe | None] = (),
) -> list[StaticProbe]:
    """The static env map of every object in its shells; kept in the writer's state where one is given.

    Those that are ``known``, of `PROBE_SPP` rays a texel, are not traced again if they are of this size.
    """
    probes = []
    for number, layout in enumerate(shells):
        progress("static maps", number, len(shells))
        state = writer.load_state(f"static-{number}") if writer else None
        if state is None:
            probe = known[number] if known else None
            if probe is None or probe.chain.size != size:
                probe = tracer.probe(number, layout, size=size, spp=PROBE_SPP)
            if writer:
                writer.save_state(f"static-{number}", **_arrays(probe))
        else:
            probe = _probe(layout, state)
        probes.append(probe)
    progress("static maps", len(shells), len(shells))
    return probes


def static_texels(
    scene: Scene, layers: Sequence[Layer], probes: Sequence[StaticProbe], camera: Camera | None = None
) -> list[Float[np.ndarray, "texels _"]]:
    """The static map of every distant layer, laid out as its maps are; view-dependent ones as at ``camera``."""
    texels = []
    for number, layer in enumerate(layers):
        if layer.kind == "distant":
            probe = probes[scene.object_of_part[layer.parts[0]]]
            shell = seen_by(scene, layer.parts, probe, shell_number(layers, number))
            frame = np.eye(3) if camera is None else layer.map_from_world(camera)
            texels.append(prior_texels(probe.chain, shell, layer.chain, frame))
    return texels


def seen_by(
    scene: Scene, parts: Sequence[int], probe: StaticProbe, shell: int
) -> Float32[np.ndarray, "texels channels"]:
    """A shell of a probe as some parts look it up: its levels filtered by their lobes, where any of them is rough.

    Where others mirror, or are smooth here and there, level 0 stays as it is for them, and nearly all that they read.
    Where most of what is mirrored is sharp, coarse levels stay means: bumps read them, and tails of lobes would veil
    what they show. All levels stay where that is of mirrors.
    """
    texels, looking = probe.shells[shell].texels, [scene.parts[p] for p in parts]
    if not any(map(is_rough, looking)):
        return texels
    fine, least, most = roughness_of_level(_FINE, probe.chain.size), least_roughness(looking), most_roughness(looking)
    is_sharp = share_smoother(looking, fine) > _SHARP
    if mirrors(probe.chain, least):
        return texels if is_sharp else lobe_levels(probe.chain, texels, fine, most)
    return lobe_levels(probe.chain, texels, least, min(most, fine) if is_sharp else most)


def shells_of(scene: Scene, layers: Sequence[Layer]) -> list[Shells]:
    """How the distant layers of a PEM divide the surroundings of each object."""
    out = []
    for item in scene.objects:
        ends = [layer.end for layer in layers if layer.kind == "distant" and layer.parts == item.parts]
        out.append(Shells(em_origin(scene, item.parts), tuple(ends[:-1])))
    return out


def _arrays(probe: StaticProbe) -> dict[str, np.ndarray]:
    out = {"texels": probe.texels, "distance": probe.distance}
    for number, shell in enumerate(probe.shells):
        out |= {f"texels-{number}": shell.texels, f"distance-{number}": shell.distance}
    return out


def _probe(layout: Shells, state: dict[str, np.ndarray]) -> StaticProbe:
    shells = tuple(ShellProbe(state[f"texels-{number}"], state[f"distance-{number}"]) for number in range(layout.count))
    return StaticProbe(state["texels"], state["distance"], layout, shells)
