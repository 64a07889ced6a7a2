"""The parameterized environment map itself."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Geometry
from reflet.scene.irradiance import IrradianceMap
from reflet.scene.parameter_space import ParameterSpace
from reflet.scene.scene import Scene


@dataclass(frozen=True)
class Layer:
    """One map that every sample of the parameter space holds.

    ``parts`` (indices into the scene's parts) are the parts that look it up. A distant map has 3 channels, a local one
    4 (premultiplied radiance and alpha) and is composited over the distant map of the same part. Every reflective part
    has exactly one distant layer and at most one local layer. A single-layer PEM has no local layers.
    """

    name: str
    kind: Literal["distant", "local"]
    parts: tuple[int, ...]
    geometry: Geometry
    size: int


@dataclass(frozen=True)
class ParameterizedEnvironmentMap:
    """Env maps for every sample of a parameter space, with the scene they belong to.

    ``maps[sample][layer]`` is the env map of one layer at one sample, in the order of ``layers``; the sequence may read
    from disk when asked. ``on_hull`` flags the scene's triangles whose fronts lie on their object's convex hull: they
    look up the distant layer only. The maps were inferred for ``sample_count`` sub-samples a pixel and an LOD shifted
    by ``lod_bias``, and are to be shown so. ``static_maps``, where given, hold each object's static env map, seen from
    the object's centre: the prior of inference, and what a viewer shows until the first sample has arrived.
    """

    scene: Scene
    irradiance: IrradianceMap
    space: ParameterSpace
    layers: tuple[Layer, ...]
    maps: Sequence[tuple[EnvMap, ...]]
    on_hull: Bool[np.ndarray, "triangles"]
    lod_bias: float
    sample_count: int
    statistics: dict[str, Any] = field(default_factory=dict)
    static_maps: tuple[EnvMap, ...] = ()
