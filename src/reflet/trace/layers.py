"""What segmented ray tracing hands on. Imports nothing heavy."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int32, UInt32

from reflet.envmap.mip_chain import MipChain
from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.camera import Camera


@dataclass(frozen=True)
class Shells:
    """How an object's distant surroundings are divided: by distance from ``origin``, at ``ends`` in metres, increasing.

    A ray's light in a shell is that of its first hit beyond the shell's beginning, with all nearer ones taken away,
    where this hit lies before the shell's end; the last shell has no end, and what is infinitely far belongs to it.
    """

    origin: tuple[float, float, float]
    ends: tuple[float, ...] = ()

    @property
    def count(self) -> int:
        """Number of shells."""
        return len(self.ends) + 1


@dataclass(frozen=True)
class SegmentedLayers:
    """The layers of all reflective parts in one picture [Hakura01, sec. 4, Figure 4].

    One row per pixel and reflective part seen there, ordered by pixel, then part. Each layer is the mean over the row's
    samples that see the front of the part, ``coverage`` their share of all the pixel's samples; so the picture is
    ``surroundings + Σ coverage·(diffuse + fresnel·(local + (1 - alpha)·distant))``. Radiance is linear Rec. 709;
    ``local`` is premultiplied by ``alpha``. ``surroundings`` (radiance times its own coverage) holds everything that
    does not reflect, seen directly. ``combined`` is the mean of fresnel·(local + (1 - alpha)·distant) taken sample by
    sample: what the reflection truly shows. Of glass ``distant`` and ``alpha`` are those of the mirrored ray too, and
    ``local`` holds all that comes through, over ``fresnel``. Of what is rough light is averaged by the surface's lobe,
    ``alpha``, of shells too, is the share of the luminance behind that is hidden, and ``fresnel`` is the directional
    albedo; ``combined`` has Fresnel's term within the average. ``shells`` is the distant layer shell by shell, the
    nearest first: premultiplied radiance and alpha (`Shells`); zero where another object has more of them.
    """

    camera: Camera
    pixel: Int32[np.ndarray, "rows"]
    part: Int32[np.ndarray, "rows"]
    coverage: Float32[np.ndarray, "rows"]
    diffuse: Float32[np.ndarray, "rows 3"]
    fresnel: Float32[np.ndarray, "rows 3"]
    distant: Float32[np.ndarray, "rows 3"]
    local: Float32[np.ndarray, "rows 3"]
    alpha: Float32[np.ndarray, "rows"]
    combined: Float32[np.ndarray, "rows 3"]
    shells: Float32[np.ndarray, "rows shells 4"]
    surroundings: Float32[np.ndarray, "height width 3"]


@dataclass(frozen=True)
class TracedView:
    """All that one viewpoint gives to inference."""

    layers: SegmentedLayers
    visibility: Visibility


@dataclass(frozen=True)
class StaticProbe:
    """The environment seen from one point with one object taken away: the static env map and its distances.

    ``texels`` hold radiance at all mip levels of a cube (finest traced, the others solid-angle weighted means), ordered
    as `MipChain` says; ``distance`` is in metres along the unit direction of each finest texel's centre, infinite
    where the ray leaves the scene. ``layout`` says how ``shells`` divide it: each as seen with the nearer ones taken
    away.
    """

    texels: Float32[np.ndarray, "texels 3"]
    distance: Float32[np.ndarray, "6 size size"]
    layout: Shells
    shells: tuple["ShellProbe", ...]

    @property
    def origin(self) -> tuple[float, float, float]:
        """Where it is seen from, in metres."""
        return self.layout.origin

    @property
    def chain(self) -> MipChain:
        """The order of the texels."""
        return MipChain(self.distance.shape[1])

    def undivided(self) -> "StaticProbe":
        """The same in one shell."""
        whole = ShellProbe(self.texels, self.distance)
        return StaticProbe(self.texels, self.distance, Shells(self.origin), (whole,))


@dataclass(frozen=True)
class ShellProbe:
    """One shell of a `StaticProbe`: ``texels`` of 4 channels, premultiplied radiance and alpha (the last shell's of 3),
    and ``distance``, infinite where the shell is empty."""

    texels: Float32[np.ndarray, "texels channels"]
    distance: Float32[np.ndarray, "6 size size"]


@dataclass(frozen=True)
class TracedSurface:
    """What the lobes of rough parts gather at sites on them, along directions of their maps.

    ``resolution``, ``offset`` and ``site`` are those of a `SurfaceLayer`, whose maps have ``side``² texels; sites lie
    at ``position`` on surfaces of ``normal`` and perceptual ``roughness``, which belong to an ``object``. A row is one
    texel of one site's map: light as in `SegmentedLayers`, where the site mirrors the viewer along ``mirrored``.
    """

    side: int
    resolution: UInt32[np.ndarray, "triangles"]
    offset: UInt32[np.ndarray, "triangles"]
    site: UInt32[np.ndarray, "samples"]
    object: Int32[np.ndarray, "sites"]
    position: Float32[np.ndarray, "sites 3"]
    normal: Float32[np.ndarray, "sites 3"]
    roughness: Float32[np.ndarray, "sites"]
    row_site: Int32[np.ndarray, "rows"]
    row_texel: Int32[np.ndarray, "rows"]
    mirrored: Float32[np.ndarray, "rows 3"]
    local: Float32[np.ndarray, "rows 3"]
    alpha: Float32[np.ndarray, "rows"]
    distant: Float32[np.ndarray, "rows 3"]
