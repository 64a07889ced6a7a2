"""What glTF says of light that goes through a material: KHR_materials_transmission, _volume and _ior."""

from dataclasses import replace

from reflet.scene.material import Material, Refraction
from reflet.scene.readers.gltf.values import JsonObject, extension, number, numbers
from reflet.scene.readers.notes import Notes

_TRANSMISSION = "KHR_materials_transmission"
_METAL = 0.5  # what is more metallic than this lets nothing through


def with_glass(material: Material, source: JsonObject, notes: Notes, index: int) -> Material:
    """``material`` with the refraction that ``source``, material ``index`` of the file, gives it; as it was where
    nothing goes through. Metals let nothing through, nor does what has no index of refraction, or one below 1."""
    share, metallic = _share(source), _metallic(material)
    if share == 0.0 or metallic > _METAL:
        return material
    refractive_index = number(extension(source, "KHR_materials_ior") or {}, "ior", 1.5)
    if refractive_index < 1.0:
        notes.add("an index of refraction below 1 lets no light through", "materials", index, material.name)
        return material
    if metallic > 0.0:
        notes.add("what is partly metal and partly glass is shown as glass", "materials", index, material.name)
    if "transmissionTexture" in (extension(source, _TRANSMISSION) or {}):
        notes.add("transmission textures are left out: light goes through alike", "materials", index, material.name)
    volume = extension(source, "KHR_materials_volume") or {}
    thin = number(volume, "thicknessFactor", 0.0) <= 0.0
    distance = number(volume, "attenuationDistance", float("inf"))
    red, green, blue = (min(max(c, 0.0), 1.0) for c in numbers(volume, "attenuationColor", (1.0, 1.0, 1.0)))
    attenuates = not thin and 0.0 < distance < float("inf")
    refraction = Refraction(
        index=refractive_index,
        transmission=share,
        attenuation_color=(red, green, blue) if attenuates else (1.0, 1.0, 1.0),
        attenuation_distance=distance if attenuates else float("inf"),
        thin=thin,
    )
    return replace(material, metallic=0.0, refraction=refraction)


def _share(source: JsonObject) -> float:
    return min(max(number(extension(source, _TRANSMISSION) or {}, "transmissionFactor", 0.0), 0.0), 1.0)


def _metallic(material: Material) -> float:
    texture = material.metallic_roughness_texture
    return material.metallic * (1.0 if texture is None else float(texture.pixels[..., 2].mean()) / 255.0)
