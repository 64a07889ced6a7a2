"""Surface materials: glTF's metallic-roughness model."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Texture:
    """An 8-bit image, row 0 at the top; colour is sRGB where the material says so. Repeats in both directions unless
    ``clamp``. Filtered bilinearly, without mip levels."""

    pixels: UInt8[np.ndarray, "height width 4"]
    clamp: bool = False


@dataclass(frozen=True)
class Material:
    """glTF 2.0 metallic-roughness, with emission as radiance.

    ``base_color`` and ``emission`` are linear Rec. 709; emission includes KHR_materials_emissive_strength. The base
    colour texture and the emission texture are sRGB, the others linear; the metallic-roughness texture holds roughness
    in green and metallic in blue.
    """

    name: str = ""
    base_color: Vec3 = (1.0, 1.0, 1.0)
    metallic: float = 1.0
    perceptual_roughness: float = 1.0
    emission: Vec3 = (0.0, 0.0, 0.0)
    double_sided: bool = False
    base_color_texture_srgb: Texture | None = None
    metallic_roughness_texture: Texture | None = None
    normal_texture: Texture | None = None
    normal_scale: float = 1.0
    emission_texture_srgb: Texture | None = None


MIRROR = Material(name="mirror", base_color=(0.65, 0.65, 0.65), metallic=1.0, perceptual_roughness=0.0)
"""What a mesh with no material is made of."""


@dataclass(frozen=True)
class EnvironmentLight:
    """A lat-long picture of infinitely distant radiance, in the project's convention: +x in the middle,
    u = 1/2 + atan2(z, x)/2π, v = acos(y)/π from the top."""

    radiance: Float32[np.ndarray, "height width 3"]
