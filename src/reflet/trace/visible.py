"""What a picture's sub-samples see."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Bool, Float32, Int32

from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.camera import Camera
from reflet.trace.camera_rays import CameraRays
from reflet.trace.device_scene import DeviceScene
from reflet.trace.footprint import covered_pixels
from reflet.trace.light.holes import Hit, closest
from reflet.trace.light.radiance import arrive
from reflet.trace.sampling import threshold

NOTHING = 0xFFFFFFFF


def candidates(device: DeviceScene, camera: Camera, index: int) -> Int32[np.ndarray, "pixels"]:
    """Pixels that one object may cover."""
    return np.flatnonzero(_covered(device, camera, index)).astype(np.int32)


def _covered(device: DeviceScene, camera: Camera, index: int) -> Bool[np.ndarray, "height width"]:
    covered = np.zeros((camera.height, camera.width), np.bool_)
    for part in device.scene.objects[index].parts:
        first, end = device.scene.triangle_offsets[part : part + 2]
        covered |= covered_pixels(camera, device.positions, device.triangles[first:end])
    return covered


def first_seen(device: DeviceScene, rays: CameraRays, pixels: Int32[np.ndarray, "pixels"]) -> tuple[Any, Hit]:
    """Unit directions of all samples of some pixels, and what they see first."""
    pixel, sample, direction = rays.antialiased(pixels)
    ray = mi.Ray3f(rays.eye, direction)
    hit = closest(device, ray, mi.Bool(True), coherent=True, threshold=lambda t: threshold(pixel, sample, t))
    return direction, hit


def covered_share(device: DeviceScene, camera: Camera, sample_count: int) -> Float32[np.ndarray, "height width"]:
    """The share of each pixel's sub-samples, at the positions of playback, that see any part, reflective or not."""
    rays = CameraRays(camera, sample_count, seed=None)
    pixels = np.arange(camera.height * camera.width, dtype=np.int32)
    sees = [first_seen(device, rays, batch)[1].valid.numpy() for batch in rays.batches(pixels)]
    share = np.concatenate(sees).reshape(camera.height, camera.width, sample_count).mean(-1)
    return share.astype(np.float32)


def visible_samples(device: DeviceScene, camera: Camera, sample_count: int) -> Visibility:
    """Which reflective triangle each sub-sample of the picture sees, at exactly the positions of playback."""
    covered = np.zeros((camera.height, camera.width), np.bool_)
    for index in range(len(device.scene.objects)):
        covered |= _covered(device, camera, index)
    pixels = np.flatnonzero(covered).astype(np.int32)
    rays = CameraRays(camera, sample_count, seed=None)
    found = []
    for batch in rays.batches(pixels):
        direction, hit = first_seen(device, rays, batch)
        surface, _ = arrive(device, hit.triangle, hit.uv, direction, mi.Bool(True), hit.valid)
        found.append(dr.select(surface.reflects, hit.triangle, NOTHING).numpy())
    triangle = np.concatenate(found) if found else np.zeros(0, np.uint32)
    sees = np.flatnonzero(triangle != NOTHING)
    return Visibility(
        camera=camera,
        sample_count=sample_count,
        pixel=pixels[sees // sample_count],
        sub_sample=(sees % sample_count).astype(np.int32),
        triangle=triangle[sees],
    )
