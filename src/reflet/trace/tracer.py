"""The ray tracer: one scene, ready to be looked at from anywhere."""

from collections.abc import Callable

from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera
from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import StaticProbe, TracedView
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.probe import static_probe
from reflet.trace.segmentation import segmented_layers
from reflet.trace.variant import use_variant
from reflet.trace.visible import visible_samples


class Tracer:
    """Traces one scene. Diffuse light is looked up in ``irradiance``, which is traced first where it is not given,
    with ``irradiance_spp`` paths a sample.

    ``progress`` is told (done, total) while irradiance is traced. Raises RefletError where the ray tracer cannot run.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        variant: str = "llvm_ad_rgb",
        irradiance: IrradianceMap | None = None,
        irradiance_spp: int = 512,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        use_variant(variant)
        self.scene = scene
        self._device = DeviceScene(scene)
        self.irradiance = irradiance or trace_irradiance(self._device, spp=irradiance_spp, progress=progress)
        self._device.set_irradiance(self.irradiance)

    def view(
        self, camera: Camera, *, spp: int = 64, sample_count: int = 16, seed: int = 0, surroundings: bool = False
    ) -> TracedView:
        """The segmented layers at ``spp`` samples a pixel, and what ``sample_count`` sub-samples a pixel see."""
        return TracedView(
            layers=segmented_layers(self._device, camera, spp, seed, surroundings),
            visibility=visible_samples(self._device, camera, sample_count),
        )

    def probe(
        self, object_index: int, origin: tuple[float, float, float], *, size: int = 256, spp: int = 16
    ) -> StaticProbe:
        """The environment from ``origin`` with one object taken away, ``spp`` rays for each of the finest texels."""
        return static_probe(self._device, object_index, origin, size, spp)
