"""A scene's materials as plugins of Mitsuba's, for the path traced reference."""

from typing import Any

import mitsuba as mi
import numpy as np

from reflet.errors import RefletError
from reflet.files.srgb import linear_from_srgb
from reflet.scene.material import Material, Refraction, Texture, Vec3
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part
from reflet.trace.references.gltf_bsdf import register_gltf
from reflet.trace.references.mirror_bsdf import register_mirror
from reflet.trace.references.placed_texture import placed_texture

KINDS = ("mirrors", "gltf")
INFINITE_INDEX = 1e9  # stands for one
_BLACK: dict[str, Any] = {"type": "diffuse", "reflectance": 0.0}


class MaterialPlugins:
    """BSDFs of parts, as `PathReference` says; parts of one whole material share theirs.

    Raises RefletError unless ``kind`` is one of `KINDS`.
    """

    def __init__(self, kind: str, single_scattering: bool) -> None:
        if kind not in KINDS:
            raise RefletError(f"The reference's materials are one of {', '.join(KINDS)}, not {kind!r}.")
        register_mirror()
        register_gltf()
        self._whole, self._single_scattering = kind == "gltf", single_scattering
        self._made: dict[tuple[int, bool, int, bool, bool], tuple[Material, mi.BSDF]] = {}

    def bsdf(self, part: Part) -> "mi.BSDF":
        """The part's own, or that of another part of the same material."""
        if not self._whole:
            return mi.load_dict(_with_holes(_mirror_or_diffuse(part), part))
        mesh = part.mesh
        key = id(part.material), mesh.uv is not None, len(mesh.more_uv), mesh.colors is not None, self.bumpy(part)
        if key not in self._made:
            glass = part.material.refraction
            described = self._gltf(part) if glass is None else _glass(glass, part.material.base_color, part)
            if part.material.unlit:
                described = _BLACK
            self._made[key] = part.material, mi.load_dict(_with_holes(described, part))
        return self._made[key][1]

    def bumpy(self, part: Part) -> bool:
        """Whether the part's BSDF reads tangents."""
        placed = part.mesh.uv is not None and part.mesh.tangents is not None
        return self._whole and placed and part.material.bends_normals

    def absorbs(self, part: Part) -> bool:
        """Whether light is lost within the part."""
        refraction = part.material.refraction
        return (part.reflective or self._whole) and refraction is not None and bool(refraction.absorption.any())

    def _gltf(self, part: Part) -> dict[str, Any]:
        material = part.material
        described = {
            "type": "reflet_gltf",
            "base_color": part_color(part, material.base_color),
            "metallic": _channel(material.metallic, material.metallic_roughness_texture, 2, part.mesh),
            "perceptual_roughness": _channel(
                material.perceptual_roughness, material.metallic_roughness_texture, 1, part.mesh
            ),
            "double_sided": material.double_sided,
            "single_scattering": self._single_scattering,
            "ior": material.ior or INFINITE_INDEX,
            "specular": material.specular,
            "specular_color": mi.ScalarColor3f(material.specular_color),
        }
        if material.clearcoat > 0.0:
            described |= _coat(material, part.mesh)
        if part.has_normal_map and material.normal_texture is not None:
            bumps = material.normal_texture
            described["normal"] = placed_texture(bumps, bumps.pixels[..., :3] / 255.0, part.mesh)
            described["normal_scale"] = float(material.normal_scale)
        return described


def _mirror_or_diffuse(part: Part) -> dict[str, Any]:
    material = part.material
    color = part_color(part, material.base_color)
    if part.reflective and material.refraction is not None:
        return _glass(material.refraction, material.base_color, part)
    if part.reflective:
        return {
            "type": "reflet_mirror",
            "base_color": color,
            "metallic": _channel(material.metallic, material.metallic_roughness_texture, 2, part.mesh),
            "double_sided": material.double_sided,
            "f0": mi.ScalarColor3f(material.dielectric_f0),
            "f90": material.dielectric_f90,
            "unlit": material.unlit,
        }
    if material.unlit:
        return _BLACK
    diffuse = {"type": "diffuse", "reflectance": color}
    return {"type": "twosided", "bsdf": diffuse} if material.double_sided else diffuse


def _glass(refraction: Refraction, base_color: Vec3, part: Part) -> dict[str, Any]:
    """Mitsuba's own; without the diffuse light of what lets only some of it through."""
    r, g, b = (refraction.transmission * c for c in base_color)
    tint = part_color(part, (r, g, b))
    kind = "thindielectric" if refraction.thin else "dielectric"
    return {"type": kind, "int_ior": refraction.index, "ext_ior": 1.0, "specular_transmittance": tint}


def _with_holes(described: dict[str, Any], part: Part) -> dict[str, Any]:
    """The BSDF where alpha says that there is something; light goes straight through elsewhere."""
    material, mesh = part.material, part.mesh
    if material.alpha_mode == "opaque":
        return described
    texture = None if mesh.uv is None else material.base_color_texture_srgb
    alpha = np.ones((1, 1, 1)) if texture is None else texture.pixels[..., 3:] / 255.0
    cutoff = material.alpha_cutoff if material.alpha_mode == "mask" else None
    opacity = placed_texture(texture, alpha * material.alpha, mesh, tinted=True, cutoff=cutoff)
    return {"type": "mask", "opacity": opacity, "bsdf": described}


def radiance_of(part: Part) -> dict[str, Any]:
    """What a part sends of its own."""
    material = part.material
    if material.unlit:
        return part_color(part, material.base_color)
    return color_texture(material.emission, material.emission_texture_srgb, part.mesh)


def part_color(part: Part, factor: Vec3) -> dict[str, Any]:
    """A factor times the material's base colour texture and the mesh's colours."""
    return color_texture(factor, part.material.base_color_texture_srgb, part.mesh, tinted=True)


def color_texture(factor: Vec3, texture: Texture | None, mesh: Mesh, *, tinted: bool = False) -> dict[str, Any]:
    """A colour, which may exceed 1, times its sRGB texture, and times the mesh's colours if it is to be ``tinted``."""
    if texture is None or mesh.uv is None:
        if tinted and mesh.colors is not None:
            return placed_texture(None, np.asarray(factor).reshape(1, 1, 3), mesh, tinted=True)
        return {"type": "srgb", "color": [float(c) for c in factor], "unbounded": True}
    code = texture.pixels[..., :3].astype(np.float64) / 255.0
    linear = linear_from_srgb(code)
    return placed_texture(texture, linear * np.asarray(factor), mesh, tinted=tinted)


def _coat(material: Material, mesh: Mesh) -> dict[str, Any]:
    described: dict[str, Any] = {
        "clearcoat": _channel(material.clearcoat, material.clearcoat_texture, 0, mesh),
        "clearcoat_roughness": _channel(material.clearcoat_roughness, material.clearcoat_roughness_texture, 1, mesh),
    }
    bumps = material.clearcoat_normal_texture
    if bumps is not None and mesh.uv is not None and mesh.tangents is not None:
        described["clearcoat_normal"] = placed_texture(bumps, bumps.pixels[..., :3] / 255.0, mesh)
        described["clearcoat_normal_scale"] = float(material.clearcoat_normal_scale)
    return described


def _channel(factor: float, texture: Texture | None, channel: int, mesh: Mesh) -> dict[str, Any]:
    if texture is None or mesh.uv is None:
        return {"type": "uniform", "value": float(factor)}
    return placed_texture(texture, texture.pixels[..., channel : channel + 1] / 255.0 * factor, mesh)
