"""What glTF says of how a material reflects beside colour, metal and roughness: KHR_materials_ior, _specular and
_unlit."""

from dataclasses import replace

import numpy as np

from reflet.files.srgb import linear_from_srgb
from reflet.scene.material import Material, Vec3
from reflet.scene.readers.gltf.images import Textures
from reflet.scene.readers.gltf.materials.factors import Factors
from reflet.scene.readers.gltf.values import JsonObject, extension, json_object, number

_SPECULAR = "KHR_materials_specular"


def with_reflection(material: Material, source: JsonObject, textures: Textures, factors: Factors) -> Material:
    """``material`` as these extensions of ``source`` have it; their textures count as their mean.

    An index below 1 that is not 0, which stands for an infinite one, is taken as 1. Glass reflects by the index that
    its refraction has.
    """
    index = number(extension(source, "KHR_materials_ior") or {}, "ior", 1.5)
    if index != 0.0 and index < 1.0:
        factors.note("an index of refraction below 1 is taken as 1")
        index = 1.0
    specular = extension(source, _SPECULAR) or {}
    tint = _vec3(factors.amounts(specular, "specularColorFactor", (1.0, 1.0, 1.0)))
    r, g, b = (a * b for a, b in zip(tint, _mean(specular, "specularColorTexture", textures, factors), strict=True))
    out = replace(
        material,
        ior=index,
        specular=factors.share(specular, "specularFactor", 1.0)
        * _mean(specular, "specularTexture", textures, factors, channel=3),
        specular_color=(r, g, b),
        unlit=extension(source, "KHR_materials_unlit") is not None,
    )
    if material.refraction is None:
        return out
    if (out.specular, out.specular_color) != (1.0, (1.0, 1.0, 1.0)):
        factors.note("glass reflects as its index of refraction says, whatever KHR_materials_specular does")
    return replace(out, ior=1.5, specular=1.0, specular_color=(1.0, 1.0, 1.0))


def _mean(parent: JsonObject, key: str, textures: Textures, factors: Factors, channel: int | None = None):  # type: ignore[no-untyped-def]
    """Of one linear channel of a texture, or of its sRGB colour; 1 where there is none."""
    info = parent.get(key)
    texture = None if info is None else textures.texture(json_object(info, key))
    if texture is None:
        return 1.0 if channel is not None else (1.0, 1.0, 1.0)
    factors.note(f"{key} counts as its mean")
    pixels = texture.pixels
    if channel is not None:
        return float(pixels[..., channel].mean()) / 255.0
    linear = linear_from_srgb(np.arange(256) / 255.0)
    return _vec3(tuple(linear[pixels[..., :3]].mean(axis=(0, 1)).tolist()))


def _vec3(values: tuple[float, ...]) -> Vec3:
    return values[0], values[1], values[2]
