"""What a PEM is compared with, of its own shells and of what others do; `compare` measures it."""

from collections.abc import Sequence
from dataclasses import replace

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.relief import Relief
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.pipelines.baking.base_maps import TRACED_LOD_BIAS
from reflet.pipelines.baking.probes import STATIC_LOD_BIAS, probe_size, shells_of, static_texels, trace_probes
from reflet.reflectance.prefilter.split_sum_map import SplitSumMap, split_sum_map
from reflet.scene.companions import traced_parts
from reflet.scene.roughness import as_mirrors
from reflet.scene.views.parameter_space import Axis, ParameterSpace
from reflet.trace.layers import StaticProbe
from reflet.trace.tracer import Tracer


def static_shells(pem: ParameterizedEnvironmentMap, tracer: Tracer) -> ParameterizedEnvironmentMap:
    """The PEM's shells as static maps alone, with or without tracing, shown as `bake` shows them."""
    layers = tuple(pem.layers[index] for index in pem.distant_layers)
    probes = trace_probes(tracer, shells_of(pem.scene, layers), probe_size(layers[0].chain))
    texels = static_texels(pem.scene, layers, probes, pem.space.orbit.camera())
    base = tuple(EnvMap(layer.chain, x, layer.geometry) for layer, x in zip(layers, texels, strict=True))
    space = ParameterSpace((Axis("azimuth_deg", ()),), pem.space.orbit)
    lod_bias = TRACED_LOD_BIAS if pem.most_hits else STATIC_LOD_BIAS
    return replace(pem, space=space, layers=layers, maps=[], base=base, lod_bias=lod_bias)


def as_if_smooth(pem: ParameterizedEnvironmentMap, variant: str) -> ParameterizedEnvironmentMap:
    """The PEM as static shells of perfect mirrors, whatever its parts' roughness, under the same diffuse light."""
    scene = as_mirrors(pem.scene)
    through = traced_parts(scene) if pem.most_hits else ()
    tracer = Tracer(scene, variant=variant, irradiance=pem.irradiance, through=through)
    return static_shells(replace(pem, scene=scene), tracer)


def engine_lights(layers: Sequence[Layer], probes: Sequence[StaticProbe]) -> list[SplitSumMap]:
    """For each object what a real-time engine takes for the light around: its undivided probe, on its layer's shape."""
    lights = []
    for layer, probe in zip(layers, probes, strict=True):
        assert not isinstance(layer.geometry, Relief)  # engines have none
        finest = probe.chain.level(probe.texels, 0)[..., :3]
        lights.append(split_sum_map(EnvImage(CUBE, finest), layer.geometry))
    return lights
