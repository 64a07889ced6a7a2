"""Materials of glTF: metallic-roughness, and specular-glossiness turned into it."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from reflet.scene.material import MIRROR, AlphaMode, Material, Texture, Vec3
from reflet.scene.meshes.mesh import MOST_UV
from reflet.scene.readers.gltf.document import Document
from reflet.scene.readers.gltf.images import Textures
from reflet.scene.readers.gltf.materials.coat import with_coat
from reflet.scene.readers.gltf.materials.factors import Factors
from reflet.scene.readers.gltf.materials.glass import with_glass
from reflet.scene.readers.gltf.materials.reflecting import with_reflection
from reflet.scene.readers.gltf.materials.specular_glossiness import converted_textures, metallic_roughness
from reflet.scene.readers.gltf.values import (
    JsonObject,
    child,
    extension,
    index_or_none,
    json_object,
    number,
    numbers,
    text,
)

_SPECULAR_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"


@dataclass(frozen=True)
class Placement:
    """How a texture lies: the file's texture coordinates of this number, by KHR_texture_transform."""

    coordinates: int = 0
    transform: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 1.0, 1.0)  # offset, rotation, scale


@dataclass(frozen=True)
class ReadMaterial:
    """A material, and how its textures lie: those whose ``coordinates`` are k like ``placements[k]``."""

    material: Material
    placements: tuple[Placement, ...] = ()


class Materials:
    """Reads each material once, and notes what is shown otherwise than it says."""

    def __init__(self, document: Document, textures: Textures) -> None:
        self._document, self._textures = document, textures
        self._read: dict[int, ReadMaterial] = {}

    def material(self, index: int | None) -> ReadMaterial:
        """Material ``index``; without one a mirror."""
        if index is None:
            return ReadMaterial(MIRROR)
        if index not in self._read:
            self._read[index] = self._read_material(index)
        return self._read[index]

    def _read_material(self, index: int) -> ReadMaterial:
        source = self._document.item("materials", index)
        name = text(source, "name") or f"material_{index}"
        older = extension(source, _SPECULAR_GLOSSINESS)
        pbr = child(source, "pbrMetallicRoughness")
        factors = Factors(self._document.notes, index, name)
        bumps, placed = _info(source, "normalTexture"), _Placed(self._textures, factors)
        material = self._newer(pbr, placed, factors) if older is None else self._older(older, placed, factors)
        strength = number(extension(source, "KHR_materials_emissive_strength") or {}, "emissiveStrength", 1.0)
        emission = np.maximum(np.array(factors.amounts(source, "emissiveFactor", (0.0, 0.0, 0.0))) * strength, 0.0)
        material = replace(
            material,
            name=name,
            emission=_vec3(emission),
            double_sided=source.get("doubleSided") is True,
            normal_texture=placed.texture(bumps),
            normal_scale=1.0 if bumps is None else number(bumps, "scale", 1.0),
            emission_texture_srgb=placed.texture(_info(source, "emissiveTexture")),
        )
        material = with_glass(material, source, self._document.notes, index)
        material = with_reflection(_with_alpha_mode(material, source, factors), source, self._textures, factors)
        material = with_coat(material, source, placed.texture, factors)
        return ReadMaterial(material, tuple(placed.placements))

    def _newer(self, pbr: JsonObject, placed: "_Placed", factors: Factors) -> Material:
        r, g, b, alpha = factors.shares(pbr, "baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        return Material(
            base_color=(r, g, b),
            alpha=alpha,
            metallic=factors.share(pbr, "metallicFactor", 1.0),
            perceptual_roughness=factors.share(pbr, "roughnessFactor", 1.0),
            base_color_texture_srgb=placed.texture(_info(pbr, "baseColorTexture")),
            metallic_roughness_texture=placed.texture(_info(pbr, "metallicRoughnessTexture")),
        )

    def _older(self, older: JsonObject, placed: "_Placed", factors: Factors) -> Material:
        *color, alpha = factors.shares(older, "diffuseFactor", (1.0, 1.0, 1.0, 1.0))
        diffuse = np.array([color])
        specular = np.array([factors.shares(older, "specularFactor", (1.0, 1.0, 1.0))])
        glossiness = factors.share(older, "glossinessFactor", 1.0)
        textures = [placed.texture(_info(older, key)) for key in ("diffuseTexture", "specularGlossinessTexture")]
        given = [texture for texture in textures if texture is not None]
        if not given:
            base, metallic, roughness = metallic_roughness(diffuse, specular, np.array([glossiness]))
            return Material(
                base_color=_vec3(base[0]), alpha=alpha, metallic=float(metallic[0]),
                perceptual_roughness=float(roughness[0]),
            )  # fmt: skip
        diffuse_srgb, specular_srgb = (None if texture is None else texture.pixels for texture in textures)
        base_texture, other_texture = converted_textures(
            diffuse_srgb, specular_srgb, (diffuse[0], specular[0], glossiness)
        )
        if given[0].coordinates != given[-1].coordinates or given[0].wraps != given[-1].wraps:
            factors.note("specular and glossiness that lie otherwise than the diffuse colour are placed like it")
        return Material(
            alpha=alpha,
            base_color_texture_srgb=replace(given[0], pixels=base_texture, encoded=None),
            metallic_roughness_texture=replace(given[0], pixels=other_texture, encoded=None),
        )


class _Placed:
    """The textures of one material, and how they lie."""

    def __init__(self, textures: Textures, factors: Factors) -> None:
        self._textures, self._factors = textures, factors
        self.placements: list[Placement] = []

    def texture(self, info: JsonObject | None) -> Texture | None:
        """What a texture info stands for."""
        texture = self._textures.texture(info)
        if info is None or texture is None:
            return None
        placement = _placement(info)
        if placement not in self.placements and len(self.placements) == MOST_UV:
            self._factors.note(f"textures that lie otherwise than {MOST_UV} others are left out")
            return None
        if placement not in self.placements:
            self.placements.append(placement)
        number = self.placements.index(placement)
        return texture if number == 0 else replace(texture, coordinates=number)


def _placement(info: JsonObject) -> Placement:
    placing = extension(info, "KHR_texture_transform") or {}
    coordinates = index_or_none(placing, "texCoord")
    if coordinates is None:
        coordinates = index_or_none(info, "texCoord") or 0
    offset, scale = numbers(placing, "offset", (0.0, 0.0)), numbers(placing, "scale", (1.0, 1.0))
    return Placement(coordinates, (offset[0], offset[1], number(placing, "rotation", 0.0), scale[0], scale[1]))


def _info(parent: JsonObject, key: str) -> JsonObject | None:
    return None if parent.get(key) is None else json_object(parent[key], key)


def _with_alpha_mode(material: Material, source: JsonObject, factors: Factors) -> Material:
    """``material`` with what glTF says of its alpha."""
    modes: dict[str, AlphaMode] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
    given = source.get("alphaMode", "OPAQUE")
    if given not in modes:
        factors.note("an alphaMode that there is not is taken as OPAQUE")
    mode = modes.get(str(given), "opaque")
    return replace(material, alpha_mode=mode, alpha_cutoff=factors.amount(source, "alphaCutoff", 0.5))


def _vec3(values: Float[np.ndarray, "3"]) -> Vec3:
    return float(values[0]), float(values[1]), float(values[2])
