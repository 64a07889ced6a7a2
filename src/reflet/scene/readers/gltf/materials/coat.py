"""Clear coats of glTF: KHR_materials_clearcoat."""

from collections.abc import Callable
from dataclasses import replace

from reflet.scene.material import Material, Texture
from reflet.scene.readers.gltf.materials.factors import Factors
from reflet.scene.readers.gltf.values import JsonObject, extension, json_object, number


def with_coat(
    material: Material, source: JsonObject, texture: Callable[[JsonObject | None], Texture | None], factors: Factors
) -> Material:
    """``material`` with the clear coat of ``source``; ``texture`` reads texture infos. Glass has none."""
    coat = extension(source, "KHR_materials_clearcoat") or {}
    share = factors.share(coat, "clearcoatFactor", 0.0)
    if share == 0.0:
        return material
    if material.refraction is not None:
        factors.note("the clear coat of glass is left out")
        return material
    infos = [
        None if coat.get(key) is None else json_object(coat[key], key)
        for key in ("clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture")
    ]
    shares, roughness, normals = map(texture, infos)
    return replace(
        material,
        clearcoat=share,
        clearcoat_roughness=factors.share(coat, "clearcoatRoughnessFactor", 0.0),
        clearcoat_texture=shares,
        clearcoat_roughness_texture=roughness,
        clearcoat_normal_texture=normals,
        clearcoat_normal_scale=1.0 if infos[2] is None else number(infos[2], "scale", 1.0),
    )
