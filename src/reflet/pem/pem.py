"""The parameterized environment map itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Geometry
from reflet.envmap.lod import finer_lod_bias
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.relief import Relief
from reflet.scene.bvh.bvh import Bvh
from reflet.scene.companions import traced_parts
from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SurfaceLayer
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import ParameterSpace

MOST_SHELLS = 3  # of one object
MOST_HITS = 64  # of a mirrored ray


@dataclass(frozen=True)
class Layer:
    """One map that every sample of the parameter space holds.

    ``parts`` (indices into the scene's parts) are the parts that look it up; the parts of an object share its distant
    layers. These are its *shells*: layer by layer what lies between the distances ``begin`` and ``end``, in metres from
    the EM origin, with all that is nearer taken away. Each reflective part has one to `MOST_SHELLS` of them, the
    nearest first and the last without end, of one ``size`` and ``parameterization``; and at most one local layer, which
    is composited over them. A single-layer PEM has no local layers. ``size`` is the number of rows of a map's face.
    """

    name: str
    kind: Literal["distant", "local"]
    parts: tuple[int, ...]
    geometry: Geometry
    size: int
    parameterization: Parameterization = CUBE
    begin: float = 0.0
    end: float = inf

    def __post_init__(self) -> None:
        if self.kind == "local" and isinstance(self.geometry, Relief):
            raise ValueError("the geometry of a local layer is a shape, not a relief")

    @property
    def channels(self) -> Literal[3, 4]:
        """3 of a last shell, which hides all behind it, else 4: premultiplied radiance and alpha."""
        return 3 if self.kind == "distant" and self.end == inf else 4

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


def shell_number(layers: Sequence[Layer], index: int) -> int:
    """Which shell of its object a distant layer is, counted from the nearest."""
    return sum(layer.kind == "distant" and layer.parts == layers[index].parts for layer in layers[:index])


@dataclass(frozen=True)
class ParameterizedEnvironmentMap:
    """Env maps for every sample of a parameter space, with the scene they belong to.

    ``maps[sample][layer]`` is the env map of one layer at one sample, in the order of ``layers``; the sequence may read
    from disk when asked, and is empty where the space has no samples. ``base`` holds a map of each distant layer, in
    their order, that serves every viewpoint; it may be empty where there are samples. As the camera leaves the samples,
    playback fades to it, fully at ``fade_deg`` of displacement (`ParameterSpace.displacement_deg`). ``on_hull`` flags
    the scene's triangles whose fronts lie on their object's convex hull: they look up the distant layers only. The maps
    were inferred for ``sample_count`` sub-samples a pixel and an LOD shifted by ``lod_bias``, and are to be shown so.

    Mirrored rays may meet the meshes of reflective parts up to ``most_hits`` times and are mirrored on there, and end
    on those of their companions; where it is 0 local light is that of local layers, if there are any. What rough parts
    mirror of their object is in ``surface``. ``bvh`` is the
    tree that they are traced by; without it playback builds one.
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
    base: tuple[EnvMap, ...] = ()
    fade_deg: float = 0.0
    most_hits: int = 0
    bvh: Bvh | None = None
    surface: SurfaceLayer | None = None

    def lod_bias_at(self, samples: int) -> float:
        """What the LOD is shifted by in a picture of ``samples`` a pixel: where rays are traced, more of them see finer
        levels."""
        return finer_lod_bias(self.lod_bias, self.sample_count, samples) if self.most_hits else self.lod_bias

    @cached_property
    def traced_parts(self) -> tuple[int, ...]:
        """Indices of the parts that mirrored rays may meet, none where they are not traced."""
        if not self.most_hits:
            return ()
        return traced_parts(self.scene, None if self.bvh is None else self.bvh.companions)

    @cached_property
    def companions(self) -> tuple[int, ...]:
        """Those of them that do not reflect."""
        return tuple(part for part in self.traced_parts if not self.scene.parts[part].reflective)

    @property
    def distant_layers(self) -> list[int]:
        """Indices of the distant layers."""
        return [index for index, layer in enumerate(self.layers) if layer.kind == "distant"]

    def base_share(self, point: Mapping[str, float]) -> float:
        """How much of the distant light comes from ``base`` at a point of the space, from 0 to 1."""
        if not self.base:
            return 0.0
        if not self.space.sample_count:
            return 1.0
        away = self.space.displacement_deg(point)
        return min(away / self.fade_deg, 1.0) if self.fade_deg > 0.0 else float(away > 0.0)
