"""The extensions of glTF: which are honoured, which change nothing, and what is shown otherwise without the rest."""

from collections.abc import Iterator
from pathlib import Path

from reflet.errors import RefletError
from reflet.scene.readers.gltf.container import conversion
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.values import JsonObject, array, child, json_object, text

_HONOURED = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "MSFT_texture_dds",
}
_HARMLESS = {  # these change nothing in a picture of the file as it stands
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_ngon_encoding",
    "KHR_animation_pointer",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",  # a node's own mesh is the finest
}
_CONVERTIBLE = {"KHR_blend", "KHR_materials_common", "KHR_techniques_webgl"}  # older looks, which gltf-pipeline turns
_LEFT_OUT = "what it adds is left out"
_CONSEQUENCES = {
    "EXT_lights_image_based": "its environment is left out",
    "KHR_materials_anisotropy": "reflections are the same in all directions",
    "KHR_materials_diffuse_transmission": "transparent surfaces are shown opaque",
    "KHR_materials_dispersion": "glass bends all colours alike",
    "KHR_materials_iridescence": "iridescent surfaces keep their base colour",
    "KHR_materials_sheen": "sheen is left out",
    "KHR_materials_variants": "the default variant is shown",
}
_WITHOUT_EFFECT: dict[str, dict[str, object]] = {  # of a material's extension; whatever differs from this is lost
    "KHR_materials_anisotropy": {"anisotropyStrength": 0},
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0},
    "KHR_materials_dispersion": {"dispersion": 0},
    "KHR_materials_iridescence": {"iridescenceFactor": 0},
    "KHR_materials_sheen": {"sheenColorFactor": [0, 0, 0]},
}
_KINDS = ("materials", "nodes", "meshes", "textures", "images", "scenes", "animations")


def check_required(root: JsonObject, path: Path) -> None:
    """Raises RefletError for an extension that the file cannot do without and reflet cannot read.

    Without the extensions of materials and lights a mesh is still a mesh: what they do is noted, and left out.
    """
    for name in map(str, array(root, "extensionsRequired")):
        if name in _CONVERTIBLE:
            raise RefletError(f"{path} requires {name}, which reflet cannot read; convert it with: {conversion(path)}")
        if name not in _HONOURED | _HARMLESS and "_materials_" not in name and "_lights_" not in name:
            raise RefletError(f"{path} requires {name[:60]}, which reflet cannot read; export it without.")


def note_extensions(document: Document) -> None:
    """Notes where the file uses extensions that are not honoured, and what that means."""
    for kind in _KINDS:
        for index, item in enumerate(array(document.root, kind)):
            name = text(json_object(item, kind), "name") or f"number {index}"
            for used, value in _used(item):
                known = used in _HONOURED or used in _HARMLESS
                if not known and not _has_no_effect(used, value):
                    consequence = _CONSEQUENCES.get(used, _LEFT_OUT)
                    document.notes.add(f"{used} is not honoured: {consequence}", kind, index, name)


def note_what_stands_still(document: Document) -> None:
    """Notes animations, which are not played, and cameras, which are not looked through."""
    for index, item in enumerate(array(document.root, "animations")):
        name = text(json_object(item, "animations"), "name") or f"number {index}"
        what = "animations are not played, and everything stands as the file's nodes do"
        document.notes.add(what, "animations", index, name)
    for index, item in enumerate(array(document.root, "cameras")):
        name = text(json_object(item, "cameras"), "name") or f"number {index}"
        document.notes.add("cameras are left out", "cameras", index, name)


def _used(value: object) -> Iterator[tuple[str, JsonObject]]:
    """Name and object of every extension within a part of the document."""
    pending = [value]
    while pending:
        at = pending.pop()
        if isinstance(at, dict):
            for name, used in child(at, "extensions").items():
                yield name, used if isinstance(used, dict) else {}
            pending += [inner for key, inner in at.items() if key != "extras" and isinstance(inner, dict | list)]
        elif isinstance(at, list):
            pending += [inner for inner in at if isinstance(inner, dict | list)]


def _has_no_effect(name: str, value: JsonObject) -> bool:
    neutral = _WITHOUT_EFFECT.get(name)
    return neutral is not None and all(value.get(key, default) == default for key, default in neutral.items())
