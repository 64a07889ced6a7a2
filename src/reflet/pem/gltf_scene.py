"""A scene as glTF 2.0: one node, mesh and primitive per part, in the parts' order, in world space, and behind them one
node per light without extent.

Plain meshes and all materials come back exactly as they were; coded meshes (`reflet.pem.mesh_codes`) as the scene that
`reflet.pem.compact` makes, their normals and tangents rounded. Which parts reflect, and the objects they form, glTF
cannot say: the vendor extension does (`reflet.pem.container`).
"""

from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32, Shaped
from PIL import Image

from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.files.pictures.png import decode_picture
from reflet.pem.arrays import FLOAT, SHORT, UNSIGNED_INT, BufferWriter
from reflet.pem.gltf_reflection import read_reflection, reflection_extensions
from reflet.pem.layout import SCENE, SCENE_BUFFER
from reflet.pem.mesh_codes import Packed, packed_directions, packed_floats, packed_triangles
from reflet.scene.material import Material, Refraction, Texture, Vec3, Wrap
from reflet.scene.meshes.mesh import MOST_UV, Mesh
from reflet.scene.punctual_light import PunctualLight
from reflet.scene.readers.gltf.accessors import Accessors
from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.container import Container
from reflet.scene.readers.gltf.document import open_document
from reflet.scene.readers.gltf.lights import LIGHTS, read_lights
from reflet.scene.readers.gltf.nodes import Nodes
from reflet.scene.readers.gltf.values import DamagedError
from reflet.scene.scene import Part, Scene

EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"
MESHOPT, QUANTIZATION = "EXT_meshopt_compression", "KHR_mesh_quantization"
WEBP = "EXT_texture_webp"
IOR, TRANSMISSION, VOLUME = "KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"
_VERTEX_DATA, _INDICES = 34962, 34963
_WRAPS: dict[Wrap, int] = {"repeat": 10497, "clamp": 33071, "mirror": 33648}
_MORE_UV = tuple(f"TEXCOORD_{number}" for number in range(1, MOST_UV))
_PICTURES = {b"\x89PNG": "png", b"\xff\xd8": "jpg", b"RIFF": "webp"}
_COMPONENTS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def write_scene(folder: Path, scene: Scene, *, coded: bool = False) -> dict[str, Any]:
    """Write the scene's buffer and textures into ``folder`` and return the glTF document that names them. Meshes that
    are to be ``coded`` come from `reflet.pem.compact`."""
    return _SceneWriter(folder, coded).write(scene)


def read_parts(folder: Path, document: dict[str, Any], reflective: set[int]) -> tuple[Part, ...]:
    """Read back the parts of a document made by `write_scene`; ``reflective`` holds indices of parts that reflect."""
    textures = [_read_texture(folder, document, texture) for texture in document.get("textures", [])]
    materials = [_read_material(item, textures) for item in document["materials"]]
    described = open_document(folder / SCENE, Container(document, None))
    accessors = Accessors(described, Buffers(described))
    try:
        parts = []
        for number, node in enumerate(node for node in document["nodes"] if "mesh" in node):
            primitive = document["meshes"][node["mesh"]]["primitives"][0]
            mesh = _read_mesh(accessors, primitive)
            parts.append(Part(node["name"], mesh, materials[primitive["material"]], number in reflective))
        return tuple(parts)
    except DamagedError as error:
        raise RefletError(
            f"{folder / SCENE} or its {SCENE_BUFFER} is truncated or damaged ({error}); copy both again, or bake again "
            "into a new folder."
        ) from None


def read_scene_lights(folder: Path, document: dict[str, Any]) -> tuple[PunctualLight, ...]:
    """Read back the lights without extent of a document made by `write_scene`."""
    described = open_document(folder / SCENE, Container(document, None))
    try:
        return tuple(read_lights(described, Nodes(described, Accessors(described, Buffers(described)))))
    except DamagedError as error:
        raise RefletError(f"{folder / SCENE} is damaged ({error}); copy it again, or bake again.") from None


def _read_mesh(accessors: Accessors, primitive: dict[str, Any]) -> Mesh:
    attributes = primitive["attributes"]

    def floats(name: str, width: int) -> Shaped[np.ndarray, "vertices width"]:
        return accessors.floats(attributes[name], (width,))

    mesh = Mesh(
        positions=floats("POSITION", 3),
        normals=floats("NORMAL", 3),
        triangles=accessors.indices(primitive["indices"]).reshape(-1, 3),
        uv=floats("TEXCOORD_0", 2) if "TEXCOORD_0" in attributes else None,
        tangents=floats("TANGENT", 4) if "TANGENT" in attributes else None,
        colors=floats("COLOR_0", 4) if "COLOR_0" in attributes else None,
        more_uv=tuple(floats(name, 2) for name in _MORE_UV if name in attributes),
    )
    arrays = (mesh.positions, mesh.normals, mesh.uv, mesh.tangents, mesh.colors, *mesh.more_uv)
    counts = {len(array) for array in arrays if array is not None}
    if len(counts) > 1 or mesh.triangles.max(initial=0) >= len(mesh.positions):
        raise DamagedError("a mesh names vertices that it does not have")
    return mesh


class _SceneWriter:
    def __init__(self, folder: Path, coded: bool) -> None:
        self.folder = folder
        self.coded = coded
        self.unpacked = 0  # bytes of coded views when they are unpacked
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
        self.texture_numbers: dict[tuple[int, tuple[Wrap, Wrap]], int] = {}  # by their pixels' identity

    def write(self, scene: Scene) -> dict[str, Any]:
        for number, part in enumerate(scene.parts):
            self.document["meshes"].append({"name": part.name, "primitives": [self._primitive(part)]})
            self.document["nodes"].append({"name": part.name, "mesh": number})
            self.document["scenes"][0]["nodes"].append(number)
        if scene.lights:
            self._lights(scene.lights)
        self.buffer.write(self.folder)
        self.document["buffers"] = [{"uri": SCENE_BUFFER, "byteLength": self.buffer.length}]
        if self.coded:
            # the extension's stand-in for the unpacked views, which has no file
            self.document["buffers"].append({"byteLength": self.unpacked, "extensions": {MESHOPT: {"fallback": True}}})
            used = {*self.document.get("extensionsUsed", ()), MESHOPT, QUANTIZATION}
            required = {*self.document.get("extensionsRequired", ()), MESHOPT, QUANTIZATION}
            self.document |= {"extensionsUsed": sorted(used), "extensionsRequired": sorted(required)}
        return self.document

    def _lights(self, lights: Sequence[PunctualLight]) -> None:
        described = self.document.setdefault("extensions", {}).setdefault(LIGHTS, {"lights": []})["lights"]
        self.document["extensionsUsed"] = sorted({*self.document.get("extensionsUsed", ()), LIGHTS})
        for number, light in enumerate(lights):
            node = {"name": light.name, "matrix": _frame(light), "extensions": {LIGHTS: {"light": number}}}
            self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]))
            self.document["nodes"].append(node)
            described.append(_described(light))

    def _primitive(self, part: Part) -> dict[str, Any]:
        mesh = part.mesh
        attributes = {"POSITION": self._floats(mesh.positions, bounds=True), "NORMAL": self._directions(mesh.normals)}
        if mesh.uv is not None:
            attributes["TEXCOORD_0"] = self._floats(mesh.uv)
        if mesh.tangents is not None:
            attributes["TANGENT"] = self._directions(mesh.tangents)
        if mesh.colors is not None:
            attributes["COLOR_0"] = self._floats(mesh.colors)
        attributes |= {name: self._floats(uv) for name, uv in zip(_MORE_UV, mesh.more_uv, strict=False)}
        if self.coded:
            view = self._packed_view(packed_triangles(mesh), _INDICES)
        else:
            view = self._plain_view(mesh.triangles.reshape(-1), _INDICES)
        indices = self._accessor(view, UNSIGNED_INT, mesh.triangles.size, 1)
        return {"attributes": attributes, "indices": indices, "material": self._material(part.material)}

    def _floats(self, array: Float32[np.ndarray, "rows columns"], *, bounds: bool = False) -> int:
        view = self._packed_view(packed_floats(array)) if self.coded else self._plain_view(array)
        extremes = {"min": array.min(0).tolist(), "max": array.max(0).tolist()} if bounds else {}
        return self._accessor(view, FLOAT, *array.shape, **extremes)

    def _directions(self, array: Float32[np.ndarray, "rows columns"]) -> int:
        if not self.coded:
            return self._floats(array)
        return self._accessor(self._packed_view(packed_directions(array)), SHORT, *array.shape, normalized=True)

    def _plain_view(self, array: Shaped[np.ndarray, "..."], target: int = _VERTEX_DATA) -> dict[str, Any]:
        at = self.buffer.add(array)["byteOffset"]
        return {"buffer": 0, "byteOffset": at, "byteLength": array.nbytes, "target": target}

    def _packed_view(self, packed: Packed, target: int = _VERTEX_DATA) -> dict[str, Any]:
        length, at = packed.count * packed.stride, self.unpacked
        self.unpacked += length
        code = {
            "buffer": 0,
            "byteOffset": self.buffer.add_bytes(packed.data),
            "byteLength": len(packed.data),
            "byteStride": packed.stride,
            "count": packed.count,
            "mode": packed.mode,
            **({"filter": packed.filter} if packed.filter != "NONE" else {}),
        }
        stride = {"byteStride": packed.stride} if target == _VERTEX_DATA else {}
        return {
            "buffer": 1, "byteOffset": at, "byteLength": length, **stride, "target": target,
            "extensions": {MESHOPT: code},
        }  # fmt: skip

    def _accessor(self, view: dict[str, Any], kind: int, count: int, width: int, **more: Any) -> int:
        self.document["bufferViews"].append(view)
        self.document["accessors"].append(
            {
                "bufferView": len(self.document["bufferViews"]) - 1,
                "componentType": kind,
                "count": count,
                "type": _COMPONENTS[width],
                **more,
            }
        )
        return len(self.document["accessors"]) - 1

    def _material(self, material: Material) -> int:
        if id(material) in self.material_numbers:
            return self.material_numbers[id(material)]
        surface: dict[str, Any] = {
            "baseColorFactor": [*material.base_color, material.alpha],
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
        extensions |= reflection_extensions(material, self._texture)
        if material.alpha_mode != "opaque":
            out["alphaMode"] = material.alpha_mode.upper()
        if material.alpha_mode == "mask":
            out["alphaCutoff"] = material.alpha_cutoff
        if extensions:
            out["extensions"] = extensions
            self.document["extensionsUsed"] = sorted({*self.document.get("extensionsUsed", ()), *extensions})
        if material.double_sided:
            out["doubleSided"] = True
        self.document["materials"].append(out)
        return self.material_numbers.setdefault(id(material), len(self.document["materials"]) - 1)

    def _texture(self, texture: Texture) -> dict[str, Any]:
        key = id(texture.pixels), texture.wraps
        if key not in self.texture_numbers:
            images = self.document.setdefault("images", [])
            data = texture.encoded or _png(texture)
            kind = next(kind for begin, kind in _PICTURES.items() if data.startswith(begin))
            uri = f"textures/{len(images)}.{kind}"
            atomic_write(self.folder / uri, data)
            images.append({"uri": uri})
            samplers = self.document.setdefault("samplers", [])
            along, across = (_WRAPS[wrap] for wrap in texture.wraps)
            sampler = {"magFilter": 9729, "minFilter": 9729, "wrapS": along, "wrapT": across}
            if sampler not in samplers:
                samplers.append(sampler)
            textures = self.document.setdefault("textures", [])
            source: dict[str, Any] = {"source": len(images) - 1}
            if kind == "webp":  # which glTF itself does not know
                source = {"extensions": {WEBP: source}}
                for which in ("extensionsUsed", "extensionsRequired"):
                    self.document[which] = sorted({*self.document.get(which, ()), WEBP})
            textures.append({**source, "sampler": samplers.index(sampler)})
            self.texture_numbers[key] = len(textures) - 1
        coordinates = {"texCoord": texture.coordinates} if texture.coordinates else {}
        return {"index": self.texture_numbers[key], **coordinates}


def _frame(light: PunctualLight) -> list[float]:
    """World from node, by columns: the light shines along -z."""
    z = -np.asarray(light.direction, np.float64)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    columns = [x, np.cross(z, x), z, np.asarray(light.position or (0.0, 0.0, 0.0))]
    return [float(v) for column, w in zip(columns, (0.0, 0.0, 0.0, 1.0), strict=True) for v in (*column, w)]


def _described(light: PunctualLight) -> dict[str, Any]:
    strength = float(2.0 ** np.ceil(np.log2(max(light.intensity))))  # as of emission: nothing is rounded
    out: dict[str, Any] = {
        "type": "directional" if light.position is None else "point" if light.cone is None else "spot",
        "color": [channel / strength for channel in light.intensity],
        "intensity": strength,
    }
    if np.isfinite(light.range):
        out["range"] = light.range
    if light.cone is not None:
        out["spot"] = {"innerConeAngle": light.cone[0], "outerConeAngle": light.cone[1]}
    return out


def _png(texture: Texture) -> bytes:
    png = BytesIO()
    Image.fromarray(np.asarray(texture.pixels)).save(png, "PNG")
    return png.getvalue()


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


def _read_texture(folder: Path, document: dict[str, Any], texture: dict[str, Any]) -> Texture:
    source = texture.get("extensions", {}).get(WEBP, texture)["source"]
    path = folder / document["images"][source]["uri"]
    sampler = document["samplers"][texture["sampler"]]
    kinds = {code: wrap for wrap, code in _WRAPS.items()}
    try:
        data = path.read_bytes()
        return Texture(decode_picture(data, str(path)), (kinds[sampler["wrapS"]], kinds[sampler["wrapT"]]), 0, data)
    except (OSError, RefletError):
        raise RefletError(
            f"The texture {path} is missing or damaged; copy it again, or bake again into a new folder."
        ) from None


def _read_material(item: dict[str, Any], textures: list[Texture]) -> Material:
    surface = item["pbrMetallicRoughness"]
    strength = item.get("extensions", {}).get(EMISSIVE_STRENGTH, {}).get("emissiveStrength", 1.0)

    def texture(slot: dict[str, Any] | None) -> Texture | None:
        if slot is None:
            return None
        read = textures[slot["index"]]
        return replace(read, coordinates=slot["texCoord"]) if "texCoord" in slot else read

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
        alpha=float(surface["baseColorFactor"][3]),
        alpha_mode=item.get("alphaMode", "OPAQUE").lower(),
        alpha_cutoff=item.get("alphaCutoff", 0.5),
        **read_reflection(item.get("extensions", {}), texture),
    )


def _vec3(values: Any) -> Vec3:
    return (float(values[0]), float(values[1]), float(values[2]))
