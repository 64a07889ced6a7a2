"""What real-time engines would show of a scene's objects, with the ray tracer's own surfaces and diffuse light."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.reflectance.prefilter.split_sum_map import SplitSumMap
from reflet.scene.views.camera import Camera
from reflet.trace.camera_rays import CameraRays
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.punctual import highlights
from reflet.trace.light.radiance import arrive
from reflet.trace.visible import candidates, first_seen


def split_sum_view(
    device: DeviceScene, camera: Camera, lights: Sequence[SplitSumMap], sample_count: int
) -> Float32[np.ndarray, "height width 3"]:
    """Radiance of the objects, the mean over those of a pixel's ``sample_count`` sub-samples that see one; 0 elsewhere.

    Of each object ``lights`` has the map that its mirrored rays look up; what these find is multiplied by what the
    surface reflects of white light, f0·A + B of rough ones. Lights without extent are shown as they are. Nothing comes
    through glass.
    """
    rays = CameraRays(camera, sample_count, seed=None)
    seen_by = [candidates(device, camera, index) for index in range(len(device.scene.objects))]
    image = np.zeros((camera.height * camera.width, 3))
    for batch in rays.batches(np.unique(np.concatenate(seen_by))):
        direction, hit = first_seen(device, rays, batch)
        surface, _ = arrive(device, hit.triangle, hit.uv, direction, mi.Bool(True), hit.valid)
        roughness = mi.Float(0.0)
        if surface.lobe is not None:
            roughness = dr.select(surface.rough, dr.sqrt(surface.lobe.alpha), 0.0)
        number = dr.select(surface.reflects, mi.Int32(surface.object), -1).numpy()
        glow, share, position, mirrored = (
            np.stack([axis.numpy() for axis in vector], -1)
            for vector in (
                surface.glow + highlights(device, surface, hit.valid),
                surface.fresnel,
                surface.position,
                surface.mirrored,
            )
        )
        of_all = np.broadcast_to(roughness.numpy(), number.shape)
        shown = np.zeros(glow.shape)
        for index, light in enumerate(lights):
            own = number == index
            shown[own] = glow[own] + share[own] * light.radiance(position[own], mirrored[own], of_all[own])
        sums = shown.reshape(len(batch), sample_count, 3).sum(1)
        counts = (number.reshape(len(batch), sample_count) >= 0).sum(1)
        image[batch] = sums / np.maximum(counts, 1)[:, None]
    return image.reshape(camera.height, camera.width, 3).astype(np.float32)
