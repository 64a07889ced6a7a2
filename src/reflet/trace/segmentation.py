"""Segmented ray tracing: one picture as separate layers per reflective part [Hakura01, sec. 4]."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32, Int32
from numba import njit, prange

from reflet.scene.views.camera import Camera
from reflet.trace.camera_rays import CameraRays
from reflet.trace.device_scene import DeviceScene
from reflet.trace.gloss.lobe_layers import trace_lobes
from reflet.trace.gloss.lobe_sums import lobe_rows, sum_lobes
from reflet.trace.layers import SegmentedLayers, Shells
from reflet.trace.light.holes import closest
from reflet.trace.light.radiance import arrive, kept, leave, medium_after, pass_through, radiance, sent_on
from reflet.trace.peel import met_through, peeled
from reflet.trace.sampling import block_means
from reflet.trace.visible import candidates, first_seen

NOTHING = 0xFFFFFFFF
MANY_PARTS, FEW_PIXELS = 64, 256
CHANNELS = 16  # diffuse, fresnel, distant, local, combined (3 each), alpha; four more a shell follow


def segmented_layers(
    device: DeviceScene, camera: Camera, spp: int, seed: int | None, surroundings: bool, shells: Sequence[Shells]
) -> SegmentedLayers:
    """The layers of all reflective parts, at ``spp`` antialiasing samples a pixel.

    Samples are a shifted Hammersley set per pixel, from ``seed`` and the pixel alone: the same call gives the same
    bytes in any process; without a seed they are `sample_positions`. Without ``surroundings`` that image is black and
    only the objects' pixels are traced. ``shells`` divide the distant layer of each object. Of glass the distant layer
    and alpha are those of the mirrored ray, as of a mirror; all that comes through it is local light, over its
    reflectance, which it is multiplied by again in the end: so ``combined`` is what it truly shows, and what is
    inferred from the distant layer serves it like a mirror. Of rough parts: `reflet.trace.gloss.lobe_sums`. Implements
    [Hakura01, sec. 4]: the distant layer's mirrored ray passes through all parts of its own object, or through those
    that the device says.
    """
    rays = CameraRays(camera, spp, seed)
    most = max(each.count for each in shells)
    rows = [_object_rows(device, rays, index, each, most) for index, each in enumerate(shells)]
    pixel, part, values, share = (np.concatenate(column) for column in zip(*rows, strict=True))
    order = np.lexsort((part, pixel))
    pixel, part, values, share = pixel[order], part[order], values[order], share[order]
    diffuse, fresnel, distant, local, combined = (np.ascontiguousarray(values[:, 3 * k : 3 * k + 3]) for k in range(5))
    return SegmentedLayers(
        camera=camera,
        pixel=pixel,
        part=part,
        coverage=share,
        diffuse=diffuse,
        fresnel=fresnel,
        distant=distant,
        local=local,
        alpha=np.ascontiguousarray(values[:, 15]),
        combined=combined,
        shells=np.ascontiguousarray(values[:, CHANNELS:]).reshape(len(values), most, 4),
        surroundings=_surroundings(device, rays, surroundings),
    )


def _object_rows(
    device: DeviceScene, rays: CameraRays, index: int, shells: Shells, most: int
) -> tuple[np.ndarray, ...]:
    """Rows of one object: pixel, part, means of `CHANNELS` and of ``most`` shells, and coverage; by pixel and part."""
    channel_count = CHANNELS + 4 * most
    pixels = candidates(device, rays.camera, index)
    parts = np.array(device.scene.objects[index].parts, np.int32)
    slot_of_part = np.full(len(device.scene.parts), -1, np.int32)
    found = [(np.zeros(0, np.int32),) * 2 + (np.zeros((0, channel_count), np.float32), np.zeros(0, np.float32))]
    for batch in rays.batches(pixels):
        trace = trace_lobes if device.has_rough else _trace_batch
        part, channels = trace(device, rays, index, batch, shells)
        # sums are kept for each pixel and part: where parts are many, for few pixels and what they see at a time
        step = len(batch) if len(parts) <= MANY_PARTS else FEW_PIXELS
        for first in range(0, len(batch), step):
            pixel, span = batch[first : first + step], slice(first * rays.spp, (first + step) * rays.spp)
            some = parts if len(parts) <= MANY_PARTS else np.intersect1d(parts, part[span].astype(np.int32))
            slot_of_part[some] = np.arange(len(some))
            seen = [channel[span] for channel in channels]
            sum_up = sum_lobes if device.has_rough else _sum_by_part
            sums, counts = sum_up(part[span], slot_of_part, seen, rays.spp, len(pixel), len(some))
            at, slot = np.nonzero(counts)
            count = counts[at, slot].astype(np.float64)
            order = np.lexsort((some[slot], at))
            at, slot, count = at[order], slot[order], count[order]
            rows = lobe_rows(sums[at, slot], count) if device.has_rough else sums[at, slot] / count[:, None]
            means = np.zeros((len(at), channel_count), np.float32)  # where others have more shells
            means[:, : rows.shape[1]] = rows
            found.append((pixel[at], some[slot], means, (count / rays.spp).astype(np.float32)))
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


def _trace_batch(
    device: DeviceScene, rays: CameraRays, index: int, pixels: Int32[np.ndarray, "pixels"], shells: Shells
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Every sample's part (or `NOTHING`) and its layers: diffuse, fresnel, distant, local as x y z, alpha, and of each
    shell x y z and alpha."""
    own_index = dr.opaque(mi.UInt32, index)
    direction, seen = first_seen(device, rays, pixels)
    surface, _ = arrive(device, seen.triangle, seen.uv, direction, mi.Bool(True), seen.valid)
    active = surface.reflects & (surface.object == own_index)

    ray = leave(surface)
    met = closest(device, ray, active)
    at_met, light_met = arrive(device, met.triangle, met.uv, ray.d, active, met.valid)
    is_own = at_met.gone_through if device.through else at_met.object == own_index
    own = active & met.valid & is_own  # backs too: they are local, opaque and black
    medium = medium_after(surface, mi.Bool(False), 0.0)  # of the mirrored ray: glass may be seen from within
    local = light_met + sent_on(device, at_met, ray.d, own & at_met.reflects, medium)
    local *= kept(device, medium, met.t, met.valid)

    through = met_through(device, index, ray, met, own, active)
    seen_shells = list(peeled(device, index, through, ray.d, active, shells))
    distant = mi.Color3f(seen_shells[-1].light)
    for shell in reversed(seen_shells[:-1]):  # nothing is half transparent yet
        distant = dr.select(shell.present, shell.light, distant)

    alpha = dr.select(own, mi.Float(1.0), 0.0)
    local = dr.select(own, local, 0.0)
    if device.has_glass:
        passes = active & surface.passes
        beyond = radiance(device, pass_through(surface), passes, medium_after(surface, mi.Bool(True), 0.0))
        share = surface.transmittance * (1.0 / surface.fresnel - 1.0)
        local += dr.select(passes, share * beyond, 0.0)
    part = dr.select(active, surface.part, NOTHING)
    outputs = [*surface.glow, *surface.fresnel, *distant, *local, alpha]
    for shell in seen_shells:
        outputs += [*shell.light, dr.select(shell.present, mi.Float(1.0), 0.0)]
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
            for c in range(13, len(channels)):
                sums[p, slot, c + 3] += channels[c][k]


def _sum_by_part(
    part: np.ndarray, slot_of_part: np.ndarray, channels: list[np.ndarray], spp: int, pixels: int, parts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over each pixel's samples, apart for each part, in the samples' order: the same on every run."""
    sums, counts = np.zeros((pixels, parts, len(channels) + 3)), np.zeros((pixels, parts), np.int32)
    _sum_samples(part, slot_of_part, tuple(channels), spp, sums, counts)
    return sums, counts


def _surroundings(device: DeviceScene, rays: CameraRays, wanted: bool) -> Float32[np.ndarray, "height width 3"]:
    """Radiance of all that does not reflect, seen directly, times its share of the pixel; black unless wanted."""
    camera = rays.camera
    image = np.zeros((camera.height * camera.width, 3), np.float32)
    everywhere = mi.Bool(True)
    for batch in rays.batches(np.arange(len(image) if wanted else 0, dtype=np.int32)):
        direction, seen = first_seen(device, rays, batch)
        surface, light = arrive(device, seen.triangle, seen.uv, direction, everywhere, seen.valid)
        image[batch] = block_means(dr.select(surface.reflects, 0.0, light), rays.spp)
    return image.reshape(camera.height, camera.width, 3)
