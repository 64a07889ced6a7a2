"""The ray tracer: one scene, ready to be looked at from anywhere."""

from collections.abc import Callable, Collection, Sequence

import numpy as np
from jaxtyping import Float32

from reflet.reflectance.prefilter.split_sum_map import SplitSumMap
from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SIDES
from reflet.scene.views.camera import Camera
from reflet.trace.device_scene import DeviceScene
from reflet.trace.gloss.surface_light import BUDGET, trace_surface
from reflet.trace.layers import Shells, StaticProbe, TracedSurface, TracedView
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.probe import shell_distances, static_probe
from reflet.trace.references.split_sum import split_sum_view
from reflet.trace.segmentation import segmented_layers
from reflet.trace.variant import use_variant
from reflet.trace.visible import visible_samples


class Tracer:
    """Traces one scene. Diffuse light is looked up in ``irradiance``, which is traced first where it is not given,
    with ``irradiance_spp`` paths a sample. Distant light is that of rays that pass through their own object, or, where
    there are, ``through`` the parts of these indices, among them all that reflect (`traced_parts`).

    ``progress`` is told (done, total) while irradiance is traced. Raises RefletError where the ray tracer cannot run.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        variant: str = "llvm_ad_rgb",
        irradiance: IrradianceMap | None = None,
        irradiance_spp: int = 512,
        through: Collection[int] = (),
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        use_variant(variant)
        self.scene = scene
        self._device = DeviceScene(scene, through)
        self.irradiance = irradiance or trace_irradiance(self._device, spp=irradiance_spp, progress=progress)
        self._device.set_irradiance(self.irradiance)

    def view(
        self,
        camera: Camera,
        *,
        spp: int = 64,
        sample_count: int = 16,
        seed: int | None = 0,
        surroundings: bool = False,
        shells: Sequence[Shells] | None = None,
    ) -> TracedView:
        """The segmented layers at ``spp`` samples a pixel, and what ``sample_count`` sub-samples a pixel see.

        ``shells`` divide the distant layers of all objects, by default into one shell each. Samples lie at random, from
        ``seed``; if None, where playback has those of ``spp`` (1, 4, 16 or 64): what it shows cannot be truer.
        """
        shells = shells or [Shells((0.0, 0.0, 0.0))] * len(self.scene.objects)
        return TracedView(
            layers=segmented_layers(self._device, camera, spp, seed, surroundings, shells),
            visibility=visible_samples(self._device, camera, sample_count),
        )

    def split_sum(
        self, camera: Camera, lights: Sequence[SplitSumMap], *, sample_count: int = 16
    ) -> Float32[np.ndarray, "height width 3"]:
        """The objects as real-time engines would show them: `split_sum_view`."""
        return split_sum_view(self._device, camera, lights, sample_count)

    def probe(self, object_index: int, shells: Shells, *, size: int = 256, spp: int = 16) -> StaticProbe:
        """The environment from the shells' origin with one object, or all, taken away, ``spp`` rays a finest texel."""
        return static_probe(self._device, object_index, shells, size, spp)

    def surface(
        self,
        parts: Collection[int],
        *,
        spp: int = 32,
        side: int = SIDES[0],
        budget: int = BUDGET,
        progress: Callable[[int, int], None] | None = None,
    ) -> TracedSurface:
        """What lobes gather all over the parts of some indices, ``spp`` rays for each of ``side``² directions of each
        site, about ``budget`` sites in all. ``progress`` is told (done, total)."""
        return trace_surface(self._device, parts, spp=spp, side=side, budget=budget, progress=progress)

    def distances(
        self, object_index: int, shells: Shells, *, size: int = 256
    ) -> list[Float32[np.ndarray, "6 size size"]]:
        """The distances alone of such a probe's shells."""
        return shell_distances(self._device, object_index, shells, size)
