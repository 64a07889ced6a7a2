"""The environment seen from one point: the static env map that rivals show and inference starts from."""

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import AXES, texel_directions, texel_solid_angle
from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import StaticProbe
from reflet.trace.light.radiance import arrive, leave, radiance
from reflet.trace.sampling import LANES, block_means, shifted_hammersley


def static_probe(
    device: DeviceScene, object_index: int, origin: tuple[float, float, float], size: int, spp: int
) -> StaticProbe:
    """The scene without one object, from ``origin`` in metres: ``size``² texels a face, ``spp`` rays a texel.

    Other objects are seen, and mirror everything, the object taken away included. Rays spread evenly over each texel's
    square on its face.
    """
    chain = MipChain(size)
    texels = np.zeros((chain.texel_count, 3), np.float32)
    finest = texels[: chain.offsets[1]]
    step = max(LANES // spp, 1)
    for start in range(0, len(finest), step):
        count = min(step, len(finest) - start)
        light = _texel_light(device, object_index, origin, size, spp, start, count)
        finest[start : start + count] = block_means(light, spp)
    for level in range(1, chain.level_count):
        fine = chain.level(texels, level - 1)
        half = fine.shape[1] // 2
        weight = texel_solid_angle(2 * half)[None, :, :, None]
        total = (fine * weight).reshape(6, half, 2, half, 2, 3).sum((2, 4))
        chain.level(texels, level)[:] = total / weight.reshape(1, half, 2, half, 2, 1).sum((2, 4))
    return StaticProbe(origin, texels, _distances(device, object_index, origin, size))


def _texel_light(device, object_index, origin, size, spp, start, count):  # type: ignore[no-untyped-def]
    """Radiance of every ray of some of the finest texels."""
    lane = dr.arange(mi.UInt32, count * spp)
    rays, faces = dr.opaque(mi.UInt32, spp), dr.opaque(mi.UInt32, size)
    slot = lane // rays
    ray = lane - slot * rays
    texel = slot + dr.opaque(mi.UInt32, start)
    row = texel // faces
    column = texel - row * faces
    face = row // faces
    row -= face * faces
    x, y = shifted_hammersley(ray, rays, texel, mi.UInt32(0))
    s = (mi.Float(column) + x) * 2.0 / mi.Float(faces) - 1.0
    t = (mi.Float(row) + y) * 2.0 / mi.Float(faces) - 1.0
    table = mi.Float(AXES.astype(np.float32).ravel())
    axes = [dr.gather(mi.Vector3f, table, face * 3 + k) for k in range(3)]
    direction = dr.normalize(axes[0] + axes[1] * s + axes[2] * t)
    surface, light, _ = _first_hit(device, object_index, origin, direction)
    if len(device.scene.objects) > 1:
        light += dr.select(surface.reflects, surface.fresnel * radiance(device, leave(surface), surface.reflects), 0.0)
    return light


def _first_hit(device, object_index, origin, direction):  # type: ignore[no-untyped-def]
    others, number = device.without_object(object_index)
    eye = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in origin))
    everywhere = mi.Bool(True)
    if others is None:
        hit = dr.zeros(mi.PreliminaryIntersection3f, dr.width(direction))
        hit.t = dr.full(mi.Float, dr.inf, dr.width(direction))
        triangle = mi.UInt32(0)
    else:
        hit = others.ray_intersect_preliminary(mi.Ray3f(eye, direction), coherent=True, active=everywhere)
        triangle = dr.gather(mi.UInt32, number, hit.prim_index, hit.is_valid())
    surface, light = arrive(device, triangle, hit.prim_uv, direction, everywhere, hit.is_valid())
    return surface, light, hit.t


def _distances(device, object_index, origin, size) -> np.ndarray:  # type: ignore[no-untyped-def]
    directions = texel_directions(size).reshape(-1, 3).astype(np.float32)
    direction = mi.Vector3f(*(mi.Float(np.ascontiguousarray(directions[:, k])) for k in range(3)))
    _, _, distance = _first_hit(device, object_index, origin, direction)
    return distance.numpy().astype(np.float32).reshape(6, size, size)
