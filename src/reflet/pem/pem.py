"""The parameterized environment map itself."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import ParameterSpace


@dataclass(frozen=True)
class Layer:
    """One map that every sample of the parameter space holds.

    ``parts`` (indices into the scene's parts) are the parts that look it up. A distant map has 3 channels, a local one
    4 (premultiplied radiance and alpha) and is composited over the distant map of the same part. Every reflective part
    has exactly one distant layer and at most one local layer. A single-layer PEM has no local layers. ``size`` is the
    number of rows of a map's face.
    """

    name: str
    kind: Literal["distant", "local"]
    parts: tuple[int, ...]
    geometry: Geometry
    size: int
    parameterization: Parameterization = CUBE

    @property
    def chain(self) -> MipChain:
        """The order of a map's texels."""
        return MipChain(self.size, self.parameterization)

    def map_from_world(self, camera: Camera) -> Float[np.ndarray, "3 3"]:
        """The rotation of lookup directions into the frame of the map that was inferred at ``camera``.

        The frame is the world's, but for view-dependent parameterizations: there the map's +x is the camera's right,
        +y its up, and +z points back from what it looks at, so that the gazing ball's rim, where the map has no
        resolution, lies straight ahead, where mirrors that the camera sees send next to none of its rays.
        """
        return camera.view_from_world() if self.parameterization.is_view_dependent else np.eye(3)


@dataclass(frozen=True)
class ParameterizedEnvironmentMap:
    """Env maps for every sample of a parameter space, with the scene they belong to.

    ``maps[sample][layer]`` is the env map of one layer at one sample, in the order of ``layers``; the sequence may read
    from disk when asked. ``on_hull`` flags the scene's triangles whose fronts lie on their object's convex hull: they
    look up the distant layer only. The maps were inferred for ``sample_count`` sub-samples a pixel and an LOD shifted
    by ``lod_bias``, and are to be shown so. ``static_maps``, where given, hold each object's static env map, seen from
    the object's centre: the prior of inference, a cube whatever the layers' parameterization.
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
