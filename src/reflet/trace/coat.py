"""Clear coats, where rays meet them: a second lobe above what parts are made of [KHR_materials_clearcoat]."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.scene.material import COAT_F0
from reflet.scene.roughness import LEAST_ROUGHNESS
from reflet.trace.device_scene import DeviceScene
from reflet.trace.lobe import GlossyLobe, schlick
from reflet.trace.textured import normal_mapped, texture_at, unit


@dataclass
class Coat:
    """Of many hits. ``fresnel`` is the share of light that the coat takes away from what is below, 0 where there is
    none; it sends back what its ``lobe`` gathers times that: nothing of what bounces between its microfacets. Where not
    ``rough`` it is a mirror."""

    fresnel: Any
    lobe: GlossyLobe
    rough: Any

    def draw(self, point):  # type: ignore[no-untyped-def]
        """A direction, its density per steradian, infinite of mirrors, and its weight."""
        direction, density, weight, _ = self.lobe.draw(point)
        direction = dr.select(self.rough, direction, self.lobe.mirrored)
        return direction, dr.select(self.rough, density, dr.inf), dr.select(self.rough, weight, 1.0)


def coat_at(device: DeviceScene, part, corners, weights, texcoords, normal, geometric, direction, reflects) -> Coat:  # type: ignore[no-untyped-def]
    """The coats of ``part`` between three ``corners``; ``normal`` is interpolated, ``geometric`` faces the ray along
    ``direction``. There is none but where a part ``reflects``."""
    table = dr.gather(mi.Vector4f, device.part_coat, part, reflects)
    slots = dr.gather(mi.Vector4u, device.part_coat_textures, part, reflects)
    coated = reflects & (table.x > 0.0)
    share = table.x * texture_at(device, slots.x, texcoords, coated, srgb=False).x
    roughness = table.y * texture_at(device, slots.y, texcoords, coated, srgb=False).y
    if device.has_normal_maps:
        normal = normal_mapped(device, corners, weights, normal, slots.z, texcoords, table.z, coated)
    normal = unit(normal, geometric)
    normal = dr.select(dr.dot(normal, geometric) < 0.0, -normal, normal)
    lobe = GlossyLobe(-direction, normal, geometric, roughness)
    fresnel = dr.select(coated, share * schlick(COAT_F0, 1.0, lobe.n_dot_v), 0.0)
    return Coat(fresnel, lobe, roughness >= LEAST_ROUGHNESS)
