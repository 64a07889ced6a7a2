"""Segmented ray tracing: one picture as separate layers per reflective part [Hakura01, sec. 4]."""

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Bool, Float32, Int32
from numba import njit, prange

from reflet.scene.camera import Camera
from reflet.scene.sample_pattern import sample_positions
from reflet.scene.visibility import Visibility
from reflet.trace.device_scene import DeviceScene
from reflet.trace.footprint import covered_pixels
from reflet.trace.layers import SegmentedLayers
from reflet.trace.radiance import arrive, leave, radiance
from reflet.trace.sampling import LANES, block_means, shifted_hammersley
from reflet.trace.surface import environment_radiance

NOTHING = 0xFFFFFFFF
CHANNELS = 16  # diffuse, fresnel, distant, local, combined (3 each), alpha


def segmented_layers(
    device: DeviceScene, camera: Camera, spp: int, seed: int, surroundings: bool = True
) -> SegmentedLayers:
    """The layers of all reflective parts, at ``spp`` antialiasing samples a pixel.

    Samples are a shifted Hammersley set per pixel, from ``seed`` and the pixel alone: the same call gives the same
    bytes in any process. Without ``surroundings`` that image is black and only the objects' pixels are traced.
    Implements [Hakura01, sec. 4]: the distant layer's mirrored ray passes through all parts of its own object.
    """
    view = _View(device, camera, spp, seed)
    rows = [_object_rows(view, index) for index in range(len(device.scene.objects))]
    pixel, part, values, share = (np.concatenate(column) for column in zip(*rows, strict=True))
    order = np.lexsort((part, pixel))
    pixel, part, values, share = pixel[order], part[order], values[order], share[order]
    return SegmentedLayers(
        camera=camera,
        pixel=pixel,
        part=part,
        coverage=share,
        diffuse=values[:, 0:3],
        fresnel=values[:, 3:6],
        distant=values[:, 6:9],
        local=values[:, 9:12],
        alpha=values[:, 15],
        combined=values[:, 12:15],
        surroundings=_surroundings(view) if surroundings else np.zeros((camera.height, camera.width, 3), np.float32),
    )


def visible_samples(device: DeviceScene, camera: Camera, sample_count: int) -> Visibility:
    """Which reflective triangle each sub-sample of the picture sees, at exactly the positions of `sample_positions`."""
    pattern = sample_positions(sample_count).astype(np.float32)
    px, py = mi.Float(pattern[:, 0]), mi.Float(pattern[:, 1])
    pixels = np.flatnonzero(_candidates(device, camera, device.object_of_triangle >= 0)).astype(np.int32)
    view = _View(device, camera, sample_count, 0)
    found = []
    for start in range(0, len(pixels), LANES // sample_count):
        batch = pixels[start : start + LANES // sample_count]
        lane = dr.arange(mi.UInt32, len(batch) * sample_count)
        pixel = dr.gather(mi.UInt32, mi.UInt32(batch), lane // sample_count)
        sub = lane % sample_count
        direction = view.direction(pixel, dr.gather(mi.Float, px, sub), dr.gather(mi.Float, py, sub))
        hit = device.all.ray_intersect_preliminary(mi.Ray3f(view.eye, direction), coherent=True, active=mi.Bool(True))
        surface, _ = arrive(device, hit.prim_index, hit.prim_uv, direction, mi.Bool(True), hit.is_valid())
        found.append(dr.select(surface.reflects, hit.prim_index, NOTHING).numpy())
    triangle = np.concatenate(found) if found else np.zeros(0, np.uint32)
    sees = np.flatnonzero(triangle != NOTHING)
    return Visibility(
        camera=camera,
        sample_count=sample_count,
        pixel=pixels[sees // sample_count],
        sub_sample=(sees % sample_count).astype(np.int32),
        triangle=triangle[sees],
    )


class _View:
    """Camera rays of one picture. All that changes from view to view is opaque, so that kernels are compiled once."""

    def __init__(self, device: DeviceScene, camera: Camera, spp: int, seed: int) -> None:
        self.device, self.camera, self.spp = device, camera, spp
        self.eye = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in camera.position))
        self.corner, self.dx, self.dy = (
            mi.Vector3f(*(dr.opaque(mi.Float, float(c)) for c in axis)) for axis in camera.ray_basis()
        )
        self.width = dr.opaque(mi.UInt32, camera.width)
        self.seed = dr.opaque(mi.UInt32, seed)
        self.count = dr.opaque(mi.UInt32, spp)

    def direction(self, pixel, x, y):  # type: ignore[no-untyped-def]
        """Unit directions through points (x, y) of pixels, measured from each pixel's top left corner."""
        row = pixel // self.width
        x, y = mi.Float(pixel - row * self.width) + x, mi.Float(row) + y
        return dr.normalize(self.corner + x * self.dx + y * self.dy)

    def antialiased(self, pixels: Int32[np.ndarray, "pixels"]):  # type: ignore[no-untyped-def]
        """Unit directions of all samples of some pixels, pixel by pixel."""
        lane = dr.arange(mi.UInt32, len(pixels) * self.spp)
        slot = lane // self.count
        sample = lane - slot * self.count
        pixel = dr.gather(mi.UInt32, mi.UInt32(pixels), slot)
        return self.direction(pixel, *shifted_hammersley(sample, self.count, pixel, self.seed))

    def batches(self, pixels: Int32[np.ndarray, "pixels"]) -> list[Int32[np.ndarray, "batch"]]:
        """Pixels in groups whose samples are at most `LANES`."""
        step = max(LANES // self.spp, 1)
        return [pixels[start : start + step] for start in range(0, len(pixels), step)]


def _candidates(device: DeviceScene, camera: Camera, chosen: Bool[np.ndarray, "triangles"]) -> np.ndarray:
    return covered_pixels(camera, device.positions, device.triangles[chosen]).ravel()


def _object_rows(view: _View, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows of one object: pixel, part, `CHANNELS` means and coverage, by pixel and then part."""
    device = view.device
    pixels = np.flatnonzero(_candidates(device, view.camera, device.object_of_triangle == index)).astype(np.int32)
    parts = np.array(device.scene.objects[index].parts, np.int32)
    slot_of_part = np.full(len(device.scene.parts), -1, np.int32)
    slot_of_part[parts] = np.arange(len(parts))
    found = [(np.zeros(0, np.int32),) * 2 + (np.zeros((0, CHANNELS), np.float32), np.zeros(0, np.float32))]
    for batch in view.batches(pixels):
        part, channels = _trace_batch(view, index, batch)
        sums, counts = _sum_by_part(part, slot_of_part, channels, view.spp, len(batch), len(parts))
        at, slot = np.nonzero(counts)
        count = counts[at, slot].astype(np.float64)
        order = np.lexsort((parts[slot], at))
        at, slot, count = at[order], slot[order], count[order]
        means = (sums[at, slot] / count[:, None]).astype(np.float32)
        found.append((batch[at], parts[slot], means, (count / view.spp).astype(np.float32)))
    pixel, part, means, share = (np.concatenate(column) for column in zip(*found, strict=True))
    return pixel, part, means, share


def _trace_batch(view: _View, index: int, pixels: Int32[np.ndarray, "pixels"]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Every sample's part (or `NOTHING`) and its layers: diffuse, fresnel, distant, local as x y z, and alpha."""
    device = view.device
    own_index = dr.opaque(mi.UInt32, index)
    others, number = device.without_object(index)
    direction = view.antialiased(pixels)
    seen = device.all.ray_intersect_preliminary(mi.Ray3f(view.eye, direction), coherent=True, active=mi.Bool(True))
    surface, _ = arrive(device, seen.prim_index, seen.prim_uv, direction, mi.Bool(True), seen.is_valid())
    active = surface.reflects & (surface.object == own_index)
    origin, mirrored = leave(surface)

    ray = mi.Ray3f(origin, mirrored)
    met = device.all.ray_intersect_preliminary(ray, coherent=False, active=active)
    at_met, light_met = arrive(device, met.prim_index, met.prim_uv, mirrored, active, met.is_valid())
    # A back of the own object is local too, and black; whose it is, its part tells.
    owner = dr.gather(mi.UInt32, device.part_flags, at_met.part, active & met.is_valid()) >> 1
    own = active & met.is_valid() & (owner == own_index + 1)
    local = light_met + at_met.fresnel * radiance(device, *leave(at_met), own & at_met.reflects)

    distant = dr.select(own, environment_radiance(device, mirrored, own), light_met)
    behind = None
    if others is not None:
        through = others.ray_intersect_preliminary(ray, coherent=False, active=own)
        triangle = dr.gather(mi.UInt32, number, through.prim_index, own & through.is_valid())
        behind, light = arrive(device, triangle, through.prim_uv, mirrored, own, through.is_valid())
        distant = dr.select(own, light, light_met)
    if behind is not None and len(device.scene.objects) > 1:
        # Other objects mirror on, met first or behind the own one.
        goes_on = at_met.reflects & ~own
        distant += dr.select(goes_on, at_met.fresnel * radiance(device, *leave(at_met), goes_on), 0.0)
        distant += dr.select(own, behind.fresnel * radiance(device, *leave(behind), behind.reflects), 0.0)

    alpha = dr.select(own, mi.Float(1.0), 0.0)
    local = dr.select(own, local, 0.0)
    part = dr.select(active, surface.part, NOTHING)
    outputs = [*surface.glow, *surface.fresnel, *distant, *local, alpha]
    dr.eval(part, *outputs)
    return part.numpy(), [channel.numpy() for channel in outputs]


@njit(parallel=True, cache=True)
def _sum_samples(part, slot_of_part, channels, spp, sums, counts):  # type: ignore[no-untyped-def]
    for p in prange(len(counts)):
        for k in range(p * spp, (p + 1) * spp):
            if part[k] == NOTHING:
                continue
            slot = slot_of_part[part[k]]
            counts[p, slot] += 1
            alpha = channels[12][k]
            for c in range(3):
                fresnel, distant, local = channels[3 + c][k], channels[6 + c][k], channels[9 + c][k]
                sums[p, slot, c] += channels[c][k]
                sums[p, slot, 3 + c] += fresnel
                sums[p, slot, 6 + c] += distant
                sums[p, slot, 9 + c] += local
                sums[p, slot, 12 + c] += fresnel * (local + (1.0 - alpha) * distant)
            sums[p, slot, 15] += alpha


def _sum_by_part(
    part: np.ndarray, slot_of_part: np.ndarray, channels: list[np.ndarray], spp: int, pixels: int, parts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over each pixel's samples, apart for each part, in the samples' order: the same on every run."""
    sums, counts = np.zeros((pixels, parts, CHANNELS)), np.zeros((pixels, parts), np.int32)
    _sum_samples(part, slot_of_part, tuple(channels), spp, sums, counts)
    return sums, counts


def _surroundings(view: _View) -> Float32[np.ndarray, "height width 3"]:
    """Radiance of everything that does not reflect, seen directly, times its share of the pixel."""
    camera = view.camera
    image = np.zeros((camera.height * camera.width, 3), np.float32)
    everywhere = mi.Bool(True)
    for batch in view.batches(np.arange(len(image), dtype=np.int32)):
        direction = view.antialiased(batch)
        ray = mi.Ray3f(view.eye, direction)
        seen = view.device.all.ray_intersect_preliminary(ray, coherent=True, active=everywhere)
        surface, light = arrive(view.device, seen.prim_index, seen.prim_uv, direction, everywhere, seen.is_valid())
        image[batch] = block_means(dr.select(surface.reflects, 0.0, light), view.spp)
    return image.reshape(camera.height, camera.width, 3)
