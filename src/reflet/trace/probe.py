"""The environment seen from one point: the static env map that rivals show and inference starts from."""

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import AXES, texel_directions, texel_solid_angle
from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import ShellProbe, Shells, StaticProbe
from reflet.trace.peel import Met, first_met, gone_through, light_from, peeled
from reflet.trace.sampling import LANES, block_means, shifted_hammersley

Distances = Float32[np.ndarray, "6 size size"]


def static_probe(device: DeviceScene, object_index: int, shells: Shells, size: int, spp: int) -> StaticProbe:
    """The scene without one object, from its shells' origin: ``size``² texels a face, ``spp`` rays a texel.

    Other objects are seen, and mirror everything, the object taken away included. Rays spread evenly over each texel's
    square on its face.
    """
    chain = MipChain(size)
    # all that is seen, then shell by shell: near ones with their alpha
    maps = [np.zeros((chain.texel_count, 4), np.float32) for _ in range(shells.count + 1)]
    count = chain.offsets[1]
    step = max(LANES // spp, 1)
    for start in range(0, count, step):
        some = slice(start, min(start + step, count))
        for texels, light in zip(
            maps, _texel_light(device, object_index, shells, size, spp, start, some.stop - start), strict=True
        ):
            texels[some] = light
    for texels in maps:
        _fill_levels(chain, texels)
    distances = shell_distances(device, object_index, shells, size)
    return StaticProbe(
        texels=np.ascontiguousarray(maps[0][:, :3]),
        distance=np.min(distances, 0),
        layout=shells,
        shells=tuple(
            ShellProbe(texels if number < shells.count - 1 else np.ascontiguousarray(texels[:, :3]), distance)
            for number, (texels, distance) in enumerate(zip(maps[1:], distances, strict=True))
        ),
    )


def shell_distances(device: DeviceScene, object_index: int, shells: Shells, size: int) -> list[Distances]:
    """Metres from the origin to what the shells hold, along the directions of a cube's texels, or infinity."""
    directions = texel_directions(size).reshape(-1, 3).astype(np.float32)
    direction = mi.Vector3f(*(mi.Float(np.ascontiguousarray(directions[:, k])) for k in range(3)))
    met, everywhere = _seen(device, object_index, shells, direction), dr.full(mi.Bool, True, len(directions))
    found = [
        dr.select(shell.present, shell.distance, dr.inf)
        for shell in peeled(device, object_index, met, direction, everywhere, shells)
    ]
    dr.eval(found)
    return [distance.numpy().astype(np.float32).reshape(6, size, size) for distance in found]


def _texel_light(
    device: DeviceScene, object_index: int, shells: Shells, size: int, spp: int, start: int, count: int
) -> list[Float32[np.ndarray, "texels 4"]]:
    """Mean radiance and coverage of some of the finest texels: of all that is seen, and of each shell."""
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
    met, everywhere = _seen(device, object_index, shells, direction), dr.full(mi.Bool, True, count * spp)
    channels = [*light_from(device, met, direction, everywhere), dr.full(mi.Float, 1.0, count * spp)]
    if shells.count > 1:
        for shell in peeled(device, object_index, met, direction, everywhere, shells):
            channels += [*shell.light, dr.select(shell.present, mi.Float(1.0), 0.0)]
    means = block_means(channels, spp).reshape(count, -1, 4)
    return [means[:, 0], *(means[:, number] for number in range(1 if shells.count > 1 else 0, means.shape[1]))]


def _seen(device, object_index: int, shells: Shells, direction) -> Met:  # type: ignore[no-untyped-def]
    """What is met from the origin, which may lie inside of something: the stem of a lamp in its globe of glass. Backs
    that are nearer than the object is large are gone through, as long as nothing else is met."""
    eye = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in shells.origin))
    near = dr.opaque(mi.Float, device.reach(object_index, shells.origin))
    met = first_met(device, object_index, mi.Ray3f(eye, direction), mi.Bool(True), coherent=True)
    return gone_through(device, object_index, met, direction, eye, near)


def _fill_levels(chain: MipChain, texels: Float32[np.ndarray, "texels 4"]) -> None:
    """Coarser levels, as solid-angle weighted means of the finest."""
    for level in range(1, chain.level_count):
        fine = chain.level(texels, level - 1)
        half = fine.shape[1] // 2
        weight = texel_solid_angle(2 * half)[None, :, :, None]
        total = (fine * weight).reshape(6, half, 2, half, 2, 4).sum((2, 4))
        chain.level(texels, level)[:] = total / weight.reshape(1, half, 2, half, 2, 1).sum((2, 4))
