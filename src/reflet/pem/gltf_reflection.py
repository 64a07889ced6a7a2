"""How materials reflect beside colour, metal and roughness, in the glTF of `reflet.pem.gltf_scene`."""

from collections.abc import Callable
from typing import Any

from reflet.scene.material import Material, Texture

IOR, SPECULAR = "KHR_materials_ior", "KHR_materials_specular"
CLEARCOAT, UNLIT = "KHR_materials_clearcoat", "KHR_materials_unlit"
_COAT_TEXTURES = ("clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture")
_PLAIN = Material()


def reflection_extensions(material: Material, texture: Callable[[Texture], dict[str, Any]]) -> dict[str, Any]:
    """What differs from glTF's defaults; ``texture`` makes texture infos. Glass has its index in its refraction."""
    out: dict[str, Any] = {}
    if material.refraction is None and material.ior != _PLAIN.ior:
        out[IOR] = {"ior": material.ior}
    if (material.specular, material.specular_color) != (_PLAIN.specular, _PLAIN.specular_color):
        out[SPECULAR] = {"specularFactor": material.specular, "specularColorFactor": list(material.specular_color)}
    if material.clearcoat:
        out[CLEARCOAT] = _coat(material, texture)
    if material.unlit:
        out[UNLIT] = {}
    return out


def _coat(material: Material, texture: Callable[[Texture], dict[str, Any]]) -> dict[str, Any]:
    coat: dict[str, Any] = {
        "clearcoatFactor": material.clearcoat, "clearcoatRoughnessFactor": material.clearcoat_roughness,
    }  # fmt: skip
    for name, of_coat in zip(_COAT_TEXTURES, _coat_textures(material), strict=True):
        if of_coat is not None:
            coat[name] = texture(of_coat)
    if material.clearcoat_normal_texture is not None:
        coat[_COAT_TEXTURES[2]]["scale"] = material.clearcoat_normal_scale
    return coat


def _coat_textures(material: Material) -> tuple[Texture | None, ...]:
    return material.clearcoat_texture, material.clearcoat_roughness_texture, material.clearcoat_normal_texture


def read_reflection(
    extensions: dict[str, Any], texture: Callable[[dict[str, Any] | None], Texture | None]
) -> dict[str, Any]:
    """Fields of a material whose extensions `reflection_extensions` made; ``texture`` reads texture infos."""
    fields: dict[str, Any] = {"unlit": UNLIT in extensions}
    if "KHR_materials_transmission" not in extensions and IOR in extensions:
        fields["ior"] = extensions[IOR]["ior"]
    if SPECULAR in extensions:
        red, green, blue = extensions[SPECULAR]["specularColorFactor"]
        fields |= {"specular": extensions[SPECULAR]["specularFactor"], "specular_color": (red, green, blue)}
    if CLEARCOAT in extensions:
        coat = extensions[CLEARCOAT]
        shares, roughness, normals = (texture(coat.get(name)) for name in _COAT_TEXTURES)
        fields |= {
            "clearcoat": coat["clearcoatFactor"], "clearcoat_roughness": coat["clearcoatRoughnessFactor"],
            "clearcoat_texture": shares, "clearcoat_roughness_texture": roughness, "clearcoat_normal_texture": normals,
            "clearcoat_normal_scale": coat[_COAT_TEXTURES[2]]["scale"] if normals is not None else 1.0,
        }  # fmt: skip
    return fields
