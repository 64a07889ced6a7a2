"""Reading glTF 2.0 (.gltf, .glb) into parts in world space."""

import struct
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Integer
from pygltflib import GLTF2, Primitive
from pygltflib import Material as GltfMaterial

from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import MIRROR, Material, Texture
from reflet.scene.meshes.corners import corner_tangents, crease_normals, weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf_data import GltfData
from reflet.scene.scene import Part

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_CLAMP, _MIRRORED_REPEAT = 33071, 33648

_HONOURED = {
    "KHR_materials_emissive_strength",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "EXT_texture_webp",
}
# these change nothing in the picture of a mirror, or of a diffuse surface
_HARMLESS = {"FB_ngon_encoding", "KHR_xmp", "KHR_xmp_json_ld", "KHR_materials_ior", "KHR_materials_specular"}
_CONSEQUENCES = {
    "KHR_lights_punctual": "its point, spot and directional lights are left out",
    "KHR_materials_transmission": "transparent surfaces are shown opaque",
    "KHR_materials_volume": "transparent surfaces are shown opaque",
    "KHR_materials_clearcoat": "coats are left out",
    "KHR_materials_iridescence": "iridescent surfaces keep their base colour",
    "KHR_materials_anisotropy": "reflections are the same in all directions",
    "KHR_materials_sheen": "sheen is left out",
    "KHR_materials_unlit": "unlit surfaces are lit",
    "KHR_materials_variants": "the default variant is shown",
    "KHR_materials_pbrSpecularGlossiness": "its metallic-roughness fallback is shown",
}


def read_gltf(path: str | Path) -> list[Part]:
    """The triangle meshes of a file's default scene, one part per node and primitive, none marked reflective yet.

    Names are those of node or mesh, with the material's behind where a mesh has several primitives; they need not be
    unique. Primitives without a material become mirrors of F0 = 0.65. What is not honoured is said in a RefletWarning
    each; what a file requires and is not supported, and files that are damaged, raise RefletError.
    """
    path = Path(path)
    try:
        gltf = GLTF2().load(str(path))
        if gltf is None:
            raise RefletError(f"{path} is no glTF 2.0 file; export it again.")
        _check_extensions(gltf, path)
        return _Reader(gltf, path).parts()
    except OSError as error:
        raise RefletError(f"{path} cannot be read ({error.strerror or error}); check the name.") from error
    except (IndexError, KeyError, TypeError, AttributeError, ValueError, struct.error, RecursionError) as error:
        raise RefletError(f"{path} is no valid glTF 2.0 file ({error}); export it again.") from error


def _check_extensions(gltf: GLTF2, path: Path) -> None:
    known = _HONOURED | _HARMLESS
    for name in gltf.extensionsRequired or []:
        if name not in known and name not in _CONSEQUENCES:
            raise RefletError(f"{path} requires {name}, which reflet cannot read; export it without.")
    for name in sorted(set(gltf.extensionsUsed or []) - known):
        consequence = _CONSEQUENCES.get(name, "what it adds is left out")
        warnings.warn(f"{path.name} uses {name}, which is not honoured: {consequence}.", RefletWarning, stacklevel=3)


@dataclass(frozen=True)
class _TextureUse:
    """How one texture of a material looks texture coordinates up."""

    coordinates: int
    transform: tuple[float, float, float, float, float]  # offset, rotation, scale
    mirrored: bool


class _Reader:
    def __init__(self, gltf: GLTF2, path: Path) -> None:
        self.gltf, self.path, self.data = gltf, path, GltfData(gltf, path)
        self._textures: dict[int, Texture] = {}
        self._materials: dict[int, tuple[Material, _TextureUse | None]] = {}

    def _warn(self, text: str) -> None:
        warnings.warn(f"{self.path.name}: {text}.", RefletWarning, stacklevel=4)

    # -- nodes ---------------------------------------------------------------------------------------------------------

    def parts(self) -> list[Part]:
        gltf = self.gltf
        if gltf.scenes:
            pending = [(node, np.eye(4)) for node in gltf.scenes[gltf.scene or 0].nodes or []]
        else:
            children = {child for node in gltf.nodes for child in node.children or []}
            pending = [(node, np.eye(4)) for node in range(len(gltf.nodes)) if node not in children]
        pending.reverse()
        parts, visited = [], 0
        while pending:
            index, world_from_parent = pending.pop()
            visited += 1
            if visited > len(gltf.nodes):
                raise RefletError(f"{self.path} has nodes that contain themselves; export it again.")
            node = gltf.nodes[index]
            world_from_node = world_from_parent @ _local_matrix(node)
            pending.extend((child, world_from_node) for child in reversed(node.children or []))
            if node.mesh is not None:
                if node.skin is not None:
                    self._warn(f"node {node.name or index} is skinned; it is shown in its rest pose")
                parts.extend(self._mesh_parts(node.mesh, node.name, world_from_node))
        return parts

    def _mesh_parts(self, index: int, node_name: str | None, world_from_node: Float[np.ndarray, "4 4"]) -> list[Part]:
        mesh, parts = self.gltf.meshes[index], []
        name = node_name or mesh.name or self.path.stem
        for number, primitive in enumerate(mesh.primitives):
            if (_TRIANGLES if primitive.mode is None else primitive.mode) < _TRIANGLES:
                self._warn(f"{name} has points or lines, which are left out")
                continue
            if primitive.targets:
                self._warn(f"{name} has morph targets; it is shown without")
            material, use = self._material(primitive.material)
            part_name = name if len(mesh.primitives) == 1 else f"{name}_{material.name or number}"
            geometry = self._primitive_mesh(primitive, part_name, material, use, world_from_node)
            parts.append(Part(part_name, geometry, material))
        return parts

    # -- geometry ------------------------------------------------------------------------------------------------------

    def _primitive_mesh(
        self,
        primitive: Primitive,
        name: str,
        material: Material,
        use: _TextureUse | None,
        world_from_node: Float[np.ndarray, "4 4"],
    ) -> Mesh:
        attributes = primitive.attributes
        if attributes.POSITION is None:
            raise RefletError(f"Part {name} of {self.path} has no positions; export it again.")
        local = self.data.accessor(attributes.POSITION).astype(np.float64)
        if primitive.indices is None:
            indices = np.arange(len(local))
        else:
            indices = self.data.accessor(primitive.indices)[:, 0].astype(np.int64)
        triangles = _triangles(indices, _TRIANGLES if primitive.mode is None else primitive.mode)
        if triangles.size and triangles.max() >= len(local):
            raise RefletError(
                f"Part {name} of {self.path} refers to vertex {triangles.max()} of {len(local)}; export it again."
            )
        linear = world_from_node[:3, :3]
        positions = local @ linear.T + world_from_node[:3, 3]
        mirrored = bool(np.linalg.det(linear) < 0.0)
        if mirrored:  # [glTF 2.0, 3.7.4]: the winding turns with the sign of the determinant
            triangles = triangles[:, ::-1]
        uv = None
        coordinates = getattr(attributes, f"TEXCOORD_{use.coordinates if use else 0}", None)
        if coordinates is not None:
            uv = _transform_uv(self.data.accessor(coordinates).astype(np.float64), use)
            if use is not None and use.mirrored and (uv.min() < 0.0 or uv.max() > 1.0):
                self._warn(f"{name} repeats its texture mirrored; it is repeated as it is")
        if attributes.COLOR_0 is not None:
            self._warn(f"{name} has vertex colours, which are left out")
        if attributes.NORMAL is None:
            normals, tangents = None, None  # [glTF 2.0, 3.7.2.1]: flat normals, and given tangents are ignored
        else:
            # cofactors are the inverse transpose times the determinant, and exist for singular matrices too
            a, b, c = linear
            cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)]) * (-1.0 if mirrored else 1.0)
            normals = _unit(self.data.accessor(attributes.NORMAL).astype(np.float64) @ cofactors.T)
            tangents = self._tangents(attributes.TANGENT, linear, mirrored)
        needs_tangents = material.normal_texture is not None and uv is not None
        if normals is not None and (tangents is not None or not needs_tangents):
            return Mesh(
                positions.astype(np.float32),
                normals.astype(np.float32),
                np.ascontiguousarray(triangles, dtype=np.uint32),
                None if uv is None else uv.astype(np.float32),
                tangents.astype(np.float32) if needs_tangents and tangents is not None else None,
            )
        corner = triangles.ravel()
        at = positions[corner]
        corner_normals = crease_normals(at, 0.0) if normals is None else normals[corner]
        corner_uv = None if uv is None else uv[corner]
        return weld(
            at,
            corner_normals,
            corner_uv,
            corner_tangents(at, corner_normals, corner_uv) if needs_tangents and corner_uv is not None else None,
        )

    def _tangents(
        self, accessor: int | None, linear: Float[np.ndarray, "3 3"], mirrored: bool
    ) -> Float[np.ndarray, "vertices 4"] | None:
        if accessor is None:
            return None
        given = self.data.accessor(accessor).astype(np.float64)
        # cross(M n, M t) turns over with the determinant's sign while M b does not: the handedness must follow
        return np.column_stack([_unit(given[:, :3] @ linear.T), given[:, 3] * (-1.0 if mirrored else 1.0)])

    # -- materials -----------------------------------------------------------------------------------------------------

    def _material(self, index: int | None) -> tuple[Material, _TextureUse | None]:
        if index is None:
            return MIRROR, None
        if index not in self._materials:
            self._materials[index] = self._read_material(self.gltf.materials[index], index)
        return self._materials[index]

    def _read_material(self, source: GltfMaterial, index: int) -> tuple[Material, _TextureUse | None]:
        name = source.name or f"material_{index}"
        if source.alphaMode in ("BLEND", "MASK"):
            self._warn(f"material {name} has transparent texels; it is shown opaque")
        pbr = source.pbrMetallicRoughness
        base = pbr and pbr.baseColorTexture
        rough = pbr and pbr.metallicRoughnessTexture
        bumps, glow = source.normalTexture, source.emissiveTexture
        uses = [self._use(info) for info in (base, rough, bumps, glow) if info is not None]
        if len(set(uses)) > 1:
            self._warn(f"the textures of material {name} are placed differently; all are placed like the first")
        strength = (source.extensions or {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        color = (pbr and pbr.baseColorFactor) or [1.0, 1.0, 1.0, 1.0]
        emission = source.emissiveFactor or [0.0, 0.0, 0.0]
        material = Material(
            name=name,
            base_color=(float(color[0]), float(color[1]), float(color[2])),
            metallic=1.0 if not pbr or pbr.metallicFactor is None else float(pbr.metallicFactor),
            perceptual_roughness=1.0 if not pbr or pbr.roughnessFactor is None else float(pbr.roughnessFactor),
            emission=(float(emission[0]) * strength, float(emission[1]) * strength, float(emission[2]) * strength),
            double_sided=bool(source.doubleSided),
            base_color_texture_srgb=self._texture(base),
            metallic_roughness_texture=self._texture(rough),
            normal_texture=self._texture(bumps),
            normal_scale=1.0 if not bumps or bumps.scale is None else bumps.scale,
            emission_texture_srgb=self._texture(glow),
        )
        return material, uses[0] if uses else None

    def _use(self, info: object) -> _TextureUse:
        extension = (getattr(info, "extensions", None) or {}).get("KHR_texture_transform", {})
        offset, scale = extension.get("offset", (0.0, 0.0)), extension.get("scale", (1.0, 1.0))
        coordinates = extension.get("texCoord", getattr(info, "texCoord", None) or 0)
        sampler = self.gltf.textures[info.index].sampler  # type: ignore[attr-defined]
        wraps = () if sampler is None else (self.gltf.samplers[sampler].wrapS, self.gltf.samplers[sampler].wrapT)
        transform = (offset[0], offset[1], extension.get("rotation", 0.0), scale[0], scale[1])
        return _TextureUse(coordinates, transform, _MIRRORED_REPEAT in wraps)

    def _texture(self, info: object | None) -> Texture | None:
        if info is None:
            return None
        index: int = info.index  # type: ignore[attr-defined]
        if index not in self._textures:
            texture = self.gltf.textures[index]
            image = (texture.extensions or {}).get("EXT_texture_webp", {}).get("source", texture.source)
            if image is None:
                raise RefletError(f"Texture {index} of {self.path} has no picture that can be read; use PNG or JPEG.")
            clamp = False
            if texture.sampler is not None:
                sampler = self.gltf.samplers[texture.sampler]
                clamp = sampler.wrapS == sampler.wrapT == _CLAMP
            self._textures[index] = Texture(self.data.image(image), clamp)
        return self._textures[index]


def _local_matrix(node: object) -> Float[np.ndarray, "4 4"]:
    """parent_from_node, from the node's matrix (column-major in the file) or its translation, rotation and scale."""
    if node.matrix:  # type: ignore[attr-defined]
        return np.asarray(node.matrix, np.float64).reshape(4, 4).T  # type: ignore[attr-defined]
    x, y, z, w = node.rotation or (0.0, 0.0, 0.0, 1.0)  # type: ignore[attr-defined]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.asarray(node.scale or (1.0, 1.0, 1.0))  # type: ignore[attr-defined]
    matrix[:3, 3] = node.translation or (0.0, 0.0, 0.0)  # type: ignore[attr-defined]
    return matrix


def _triangles(indices: Integer[np.ndarray, "indices"], mode: int) -> Integer[np.ndarray, "triangles 3"]:
    """Triangles of a list, strip or fan [glTF 2.0, 3.7.2.1]."""
    if mode == _TRIANGLES:
        if len(indices) % 3:
            raise ValueError(f"{len(indices)} indices are no whole triangles")
        return indices.reshape(-1, 3)
    i = np.arange(max(len(indices) - 2, 0))
    if mode == _FAN:
        return np.column_stack([indices[i + 1], indices[i + 2], np.broadcast_to(indices[:1], i.shape)])
    odd = i % 2
    return np.column_stack([indices[i], indices[i + 1 + odd], indices[i + 2 - odd]])


def _transform_uv(uv: Float[np.ndarray, "vertices 2"], use: _TextureUse | None) -> Float[np.ndarray, "vertices 2"]:
    """KHR_texture_transform: scale, then rotate counter-clockwise in the image, then shift."""
    if use is None:
        return uv
    x, y, angle, scale_x, scale_y = use.transform
    u, v = uv[:, 0] * scale_x, uv[:, 1] * scale_y
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([cos * u + sin * v + x, cos * v - sin * u + y])


def _unit(vectors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)
