"""Mirrored rays followed from mirror to mirror as playback follows them: what verification compares it with."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32, UInt32

from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.holes import closest
from reflet.trace.light.radiance import kept, medium_after
from reflet.trace.surface import surface_at
from reflet.trace.variant import use_variant

FIRST_HITS = 4  # that are told


@dataclass(frozen=True)
class FollowedRays:
    """What mirrored rays meet. ``triangles`` are 1 + the scene's numbers of the first four; 0 for none. Of what arrives
    at the surface that they leave, ``light`` is what those that are met send of their own, ``throughput`` the share of
    the distant light from where the ray ends."""

    triangles: UInt32[np.ndarray, "rays 4"]
    light: Float32[np.ndarray, "rays 3"]
    throughput: Float32[np.ndarray, "rays 3"]


class RayFollower:
    """Follows rays through the meshes of some parts of a scene, its `traced_parts`."""

    def __init__(
        self, scene: Scene, irradiance: IrradianceMap, parts: Collection[int], *, variant: str = "llvm_ad_rgb"
    ) -> None:
        use_variant(variant)
        kept_parts = sorted(parts)
        offsets = np.array(scene.triangle_offsets)
        numbers = [np.arange(offsets[part], offsets[part + 1]) for part in kept_parts]
        self._number = np.concatenate(numbers).astype(np.uint32)
        index = {part: k for k, part in enumerate(kept_parts)}
        objects = tuple(
            ReflectiveObject(item.name, tuple(index[part] for part in item.parts)) for item in scene.objects
        )
        alone = Scene(tuple(_mirror(scene.parts[part]) for part in kept_parts), objects)
        self._device = DeviceScene(alone)
        grids = irradiance.resolution[self._number], irradiance.offset[self._number]
        self._device.set_irradiance(replace(irradiance, resolution=grids[0], offset=grids[1]))

    def follow(
        self,
        eye: tuple[float, float, float],
        position: Float32[np.ndarray, "rays 3"],
        direction: Float32[np.ndarray, "rays 3"],
        triangle: UInt32[np.ndarray, "rays"],
        most_hits: int,
    ) -> FollowedRays:
        """Rays that leave ``position`` on the scene's ``triangle`` along ``direction``, mirrored there from ``eye``.

        They are mirrored on by mirrors; through glass they go, unless it reflects everything (CONVENTIONS.md). After
        ``most_hits`` they end as if there were no more.
        """
        device, count = self._device, len(position)
        yes, no = dr.full(mi.Bool, True, count), dr.full(mi.Bool, False, count)
        sight = position.astype(np.float64) - eye
        sight /= np.linalg.norm(sight, axis=1, keepdims=True)
        view = mi.Ray3f(mi.Point3f(*_axes(np.broadcast_to(eye, position.shape))), mi.Vector3f(*_axes(sight)))
        here = mi.UInt32(np.searchsorted(self._number, triangle).astype(np.uint32))
        first = closest(device, view, yes, coherent=True, threshold=lambda seen: dr.select(seen == here, -1.0, 2.0))
        surface = surface_at(device, here, first.uv, view.d, yes)
        throughput, light = mi.Color3f(1.0), mi.Color3f(0.0)
        medium = mi.Color3f(medium_after(surface, no, 0.0))
        ray = mi.Ray3f(
            mi.Point3f(*_axes(position)) + surface.geometric_normal * surface.offset, mi.Vector3f(*_axes(direction))
        )
        going = yes
        met = np.zeros((count, FIRST_HITS), np.uint32)
        for k in range(most_hits):
            hit = closest(device, ray, going)
            valid = going & hit.valid
            surface = surface_at(device, hit.triangle, hit.uv, ray.d, valid)
            throughput *= dr.select(valid, kept(device, medium, hit.t, valid), 1.0)
            light += dr.select(valid, throughput * surface.glow, 0.0)
            through = surface.passes & (surface.fresnel.x < 1.0)
            share = dr.select(through, mi.Color3f(surface.transmittance), surface.fresnel)
            throughput *= dr.select(valid, dr.select(surface.reflects, share, 0.0), 1.0)
            medium = dr.select(valid, medium_after(surface, through, medium), medium)
            side = surface.geometric_normal * dr.select(through, -surface.offset, surface.offset)
            onward = dr.select(through, surface.refracted, surface.mirrored) if device.has_glass else surface.mirrored
            ray = mi.Ray3f(mi.Point3f(surface.position + side), mi.Vector3f(onward))
            if k < FIRST_HITS:
                hits = np.broadcast_to(valid.numpy(), count)
                met[hits, k] = self._number[hit.triangle.numpy()[hits]] + np.uint32(1)
            going = surface.reflects
            dr.eval(throughput, light, medium, ray, going)
        return FollowedRays(met, _table(light, count), _table(throughput, count))


def _mirror(part: Part) -> Part:
    """The part as playback follows rays: mirrored, whatever its roughness and its coat."""
    return replace(part, material=replace(part.material, perceptual_roughness=0.0, clearcoat=0.0))


def _axes(table: Float[np.ndarray, "rays 3"]) -> list["mi.Float"]:
    return [mi.Float(np.ascontiguousarray(table[:, axis], np.float32)) for axis in range(3)]


def _table(values, count: int) -> Float32[np.ndarray, "rays 3"]:  # type: ignore[no-untyped-def]
    return np.stack([np.broadcast_to(channel.numpy(), count) for channel in values], -1).astype(np.float32)
