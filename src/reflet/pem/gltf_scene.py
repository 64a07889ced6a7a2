"""A scene as glTF 2.0: one node, mesh and primitive per part, in the parts' order, in world space.

Positions, normals, texture coordinates, tangents and materials come back exactly as they were. Which parts reflect, and
the objects they form, glTF cannot say: the vendor extension does (`reflet.pem.container`).
"""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped
from PIL import Image

from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.pem.arrays import FLOAT, UNSIGNED_INT, BufferWriter, read_array
from reflet.pem.layout import SCENE_BUFFER
from reflet.scene.material import Material, Refraction, Texture, Vec3
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene

EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"
IOR, TRANSMISSION, VOLUME = "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"
_VERTEX_DATA, _INDICES = 34962, 34963
_REPEAT, _CLAMP = 10497, 33071
_COMPONENTS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def write_scene(folder: Path, scene: Scene) -> dict[str, Any]:
    """Write the scene's buffer and textures into ``folder`` and return the glTF document that names them."""
    return _SceneWriter(folder).write(scene)


def read_parts(folder: Path, document: dict[str, Any], reflective: set[int]) -> tuple[Part, ...]:
    """Read back the parts of a document made by `write_scene`; ``reflective`` holds indices of parts that reflect."""
    textures = [_read_texture(folder, document, texture) for texture in document.get("textures", [])]
    materials = [_read_material(item, textures) for item in document["materials"]]
    parts = []
    for number, node in enumerate(document["nodes"]):
        primitive = document["meshes"][node["mesh"]]["primitives"][0]
        arrays = {name: _read_accessor(folder, document, at) for name, at in primitive["attributes"].items()}
        mesh = Mesh(
            positions=arrays["POSITION"],
            normals=arrays["NORMAL"],
            triangles=_read_accessor(folder, document, primitive["indices"]).reshape(-1, 3),
            uv=arrays.get("TEXCOORD_0"),
            tangents=arrays.get("TANGENT"),
        )
        parts.append(Part(node["name"], mesh, materials[primitive["material"]], number in reflective))
    return tuple(parts)


class _SceneWriter:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.buffer = BufferWriter(SCENE_BUFFER)
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "reflet"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
        }
        self.material_numbers: dict[int, int] = {}  # by identity: arrays do not compare cheaply
        self.texture_numbers: dict[int, int] = {}

    def write(self, scene: Scene) -> dict[str, Any]:
        for number, part in enumerate(scene.parts):
            self.document["meshes"].append({"name": part.name, "primitives": [self._primitive(part)]})
            self.document["nodes"].append({"name": part.name, "mesh": number})
            self.document["scenes"][0]["nodes"].append(number)
        self.buffer.write(self.folder)
        self.document["buffers"] = [{"uri": SCENE_BUFFER, "byteLength": self.buffer.length}]
        return self.document

    def _primitive(self, part: Part) -> dict[str, Any]:
        mesh = part.mesh
        attributes = {
            "POSITION": self._accessor(mesh.positions, _VERTEX_DATA, bounds=True),
            "NORMAL": self._accessor(mesh.normals, _VERTEX_DATA),
        }
        if mesh.uv is not None:
            attributes["TEXCOORD_0"] = self._accessor(mesh.uv, _VERTEX_DATA)
        if mesh.tangents is not None:
            attributes["TANGENT"] = self._accessor(mesh.tangents, _VERTEX_DATA)
        indices = self._accessor(mesh.triangles.reshape(-1), _INDICES)
        return {"attributes": attributes, "indices": indices, "material": self._material(part.material)}

    def _accessor(self, array: Shaped[np.ndarray, "..."], target: int, *, bounds: bool = False) -> int:
        data = self.buffer.add(array)
        self.document["bufferViews"].append(
            {"buffer": 0, "byteOffset": data["byteOffset"], "byteLength": array.nbytes, "target": target}
        )
        accessor = {
            "bufferView": len(self.document["bufferViews"]) - 1,
            "componentType": data["componentType"],
            "count": len(array),
            "type": _COMPONENTS[1 if array.ndim == 1 else array.shape[1]],
        }
        if bounds:
            accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        self.document["accessors"].append(accessor)
        return len(self.document["accessors"]) - 1

    def _material(self, material: Material) -> int:
        if id(material) in self.material_numbers:
            return self.material_numbers[id(material)]
        surface: dict[str, Any] = {
            "baseColorFactor": [*material.base_color, 1.0],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.perceptual_roughness,
        }
        out: dict[str, Any] = {"name": material.name, "pbrMetallicRoughness": surface}
        extensions = {} if material.refraction is None else _refraction_extensions(material.refraction)
        if material.base_color_texture_srgb is not None:
            surface["baseColorTexture"] = self._texture(material.base_color_texture_srgb)
        if material.metallic_roughness_texture is not None:
            surface["metallicRoughnessTexture"] = self._texture(material.metallic_roughness_texture)
        if material.normal_texture is not None:
            out["normalTexture"] = {**self._texture(material.normal_texture), "scale": material.normal_scale}
        if material.emission_texture_srgb is not None:
            out["emissiveTexture"] = self._texture(material.emission_texture_srgb)
        if any(material.emission):
            # A power of two divides without rounding, so that factor times strength is the emission again, exactly.
            strength = max(1.0, float(2.0 ** np.ceil(np.log2(max(material.emission)))))
            out["emissiveFactor"] = [e / strength for e in material.emission]
            if strength > 1.0:
                extensions[EMISSIVE_STRENGTH] = {"emissiveStrength": strength}
        if extensions:
            out["extensions"] = extensions
            self.document["extensionsUsed"] = sorted({*self.document.get("extensionsUsed", ()), *extensions})
        if material.double_sided:
            out["doubleSided"] = True
        self.document["materials"].append(out)
        return self.material_numbers.setdefault(id(material), len(self.document["materials"]) - 1)

    def _texture(self, texture: Texture) -> dict[str, int]:
        if id(texture) not in self.texture_numbers:
            images = self.document.setdefault("images", [])
            uri = f"textures/{len(images)}.png"
            png = BytesIO()
            Image.fromarray(np.asarray(texture.pixels)).save(png, "PNG")
            atomic_write(self.folder / uri, png.getvalue())
            images.append({"uri": uri})
            samplers = self.document.setdefault("samplers", [])
            wrap = _CLAMP if texture.clamp else _REPEAT
            sampler = {"magFilter": 9729, "minFilter": 9729, "wrapS": wrap, "wrapT": wrap}
            if sampler not in samplers:
                samplers.append(sampler)
            textures = self.document.setdefault("textures", [])
            textures.append({"source": len(images) - 1, "sampler": samplers.index(sampler)})
            self.texture_numbers[id(texture)] = len(textures) - 1
        return {"index": self.texture_numbers[id(texture)]}


def _refraction_extensions(refraction: Refraction) -> dict[str, Any]:
    """What is not ``thin`` is as thick as its mesh: the volume's own thickness only says that there is one."""
    out = {IOR: {"ior": refraction.index}, TRANSMISSION: {"transmissionFactor": refraction.transmission}}
    if refraction.thin:
        return out
    volume: dict[str, Any] = {"thicknessFactor": 1.0}
    if np.isfinite(refraction.attenuation_distance):
        volume["attenuationColor"] = list(refraction.attenuation_color)
        volume["attenuationDistance"] = refraction.attenuation_distance
    return out | {VOLUME: volume}


def _read_refraction(extensions: dict[str, Any]) -> Refraction | None:
    if TRANSMISSION not in extensions:
        return None
    volume = extensions.get(VOLUME, {})
    return Refraction(
        index=extensions[IOR]["ior"],
        transmission=extensions[TRANSMISSION]["transmissionFactor"],
        attenuation_color=_vec3(volume.get("attenuationColor", (1.0, 1.0, 1.0))),
        attenuation_distance=volume.get("attenuationDistance", float("inf")),
        thin=VOLUME not in extensions,
    )


def _read_accessor(folder: Path, document: dict[str, Any], number: int) -> Shaped[np.ndarray, "..."]:
    accessor = document["accessors"][number]
    if accessor["componentType"] not in (UNSIGNED_INT, FLOAT):
        raise RefletError(
            f"{folder} was changed by another program: its meshes are no longer stored as reflet does; bake again "
            "into a new folder."
        )
    view = document["bufferViews"][accessor["bufferView"]]
    components = next(n for n, name in _COMPONENTS.items() if name == accessor["type"])
    return read_array(
        folder,
        {
            "uri": document["buffers"][view["buffer"]]["uri"],
            "byteOffset": view.get("byteOffset", 0) + accessor.get("byteOffset", 0),
            "componentType": accessor["componentType"],
            "shape": [accessor["count"]] + ([components] if components > 1 else []),
        },
    )


def _read_texture(folder: Path, document: dict[str, Any], texture: dict[str, int]) -> Texture:
    path = folder / document["images"][texture["source"]]["uri"]
    try:
        with Image.open(path) as image:
            pixels = np.array(image.convert("RGBA"))
    except OSError:
        raise RefletError(
            f"The texture {path} is missing or damaged; copy it again, or bake again into a new folder."
        ) from None
    return Texture(pixels, clamp=document["samplers"][texture["sampler"]]["wrapS"] == _CLAMP)


def _read_material(item: dict[str, Any], textures: list[Texture]) -> Material:
    surface = item["pbrMetallicRoughness"]
    strength = item.get("extensions", {}).get(EMISSIVE_STRENGTH, {}).get("emissiveStrength", 1.0)

    def texture(slot: dict[str, Any] | None) -> Texture | None:
        return None if slot is None else textures[slot["index"]]

    normal = item.get("normalTexture")
    return Material(
        name=item["name"],
        base_color=_vec3(surface["baseColorFactor"]),
        metallic=surface["metallicFactor"],
        perceptual_roughness=surface["roughnessFactor"],
        emission=_vec3([e * strength for e in item.get("emissiveFactor", (0.0, 0.0, 0.0))]),
        double_sided=item.get("doubleSided", False),
        base_color_texture_srgb=texture(surface.get("baseColorTexture")),
        metallic_roughness_texture=texture(surface.get("metallicRoughnessTexture")),
        normal_texture=texture(normal),
        normal_scale=normal["scale"] if normal else 1.0,
        emission_texture_srgb=texture(item.get("emissiveTexture")),
        refraction=_read_refraction(item.get("extensions", {})),
    )


def _vec3(values: Any) -> Vec3:
    return (float(values[0]), float(values[1]), float(values[2]))
