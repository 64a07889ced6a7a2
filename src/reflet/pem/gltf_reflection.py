"""How materials reflect beside colour, metal and roughness, in the glTF of `reflet.pem.gltf_scene`."""

from typing import Any

from reflet.scene.material import Material

IOR, SPECULAR = "KHR_materials_ior", "KHR_materials_specular"
CLEARCOAT, UNLIT = "KHR_materials_clearcoat", "KHR_materials_unlit"
_PLAIN = Material()


def reflection_extensions(material: Material) -> dict[str, Any]:
    """What differs from glTF's defaults. Glass has its index in its refraction."""
    out: dict[str, Any] = {}
    if material.refraction is None and material.ior != _PLAIN.ior:
        out[IOR] = {"ior": material.ior}
    if (material.specular, material.specular_color) != (_PLAIN.specular, _PLAIN.specular_color):
        out[SPECULAR] = {"specularFactor": material.specular, "specularColorFactor": list(material.specular_color)}
    if material.clearcoat:
        out[CLEARCOAT] = {
            "clearcoatFactor": material.clearcoat, "clearcoatRoughnessFactor": material.clearcoat_roughness,
        }  # fmt: skip
    if material.unlit:
        out[UNLIT] = {}
    return out


def read_reflection(extensions: dict[str, Any]) -> dict[str, Any]:
    """Fields of a material whose extensions `reflection_extensions` made."""
    fields: dict[str, Any] = {"unlit": UNLIT in extensions}
    if "KHR_materials_transmission" not in extensions and IOR in extensions:
        fields["ior"] = extensions[IOR]["ior"]
    if SPECULAR in extensions:
        red, green, blue = extensions[SPECULAR]["specularColorFactor"]
        fields |= {"specular": extensions[SPECULAR]["specularFactor"], "specular_color": (red, green, blue)}
    if CLEARCOAT in extensions:
        coat = extensions[CLEARCOAT]
        fields |= {
            "clearcoat": coat["clearcoatFactor"], "clearcoat_roughness": coat["clearcoatRoughnessFactor"],
        }  # fmt: skip
    return fields
