"""Surface materials: glTF's metallic-roughness model, and glass."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float32, Float64, UInt8

Vec3 = tuple[float, float, float]
Wrap = Literal["repeat", "clamp", "mirror"]
AlphaMode = Literal["opaque", "mask", "blend"]

WRAPS: tuple[Wrap, ...] = ("repeat", "clamp", "mirror")  # in the order of their numbers on devices
REPEATS: tuple[Wrap, Wrap] = ("repeat", "repeat")
CLAMPS: tuple[Wrap, Wrap] = ("clamp", "clamp")


@dataclass(frozen=True)
class Texture:
    """An 8-bit image, row 0 at the top; colour is sRGB where the material says so. Filtered bilinearly, without mip
    levels.

    ``wraps`` say how it goes on beyond its edges, along u and along v: "mirror" repeats it, every other time mirrored.
    It is looked up by the mesh's texture coordinates number ``coordinates`` (`Mesh.uv_set`). ``encoded`` is
    the PNG, JPEG or WebP file that it came as, where there was one that every viewer shows these pixels of: scenes are
    written with it. It tells no texture from another.
    """

    pixels: UInt8[np.ndarray, "height width 4"]
    wraps: tuple[Wrap, Wrap] = REPEATS
    coordinates: int = 0
    encoded: bytes | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Refraction:
    """What lets light through: glass, water.

    ``index`` is that of the inside over that of the outside. Of the light that is not reflected, the share
    ``transmission`` goes through, tinted by the material's base colour at each surface; the rest makes the material
    diffuse. Inside, white light takes on ``attenuation_color`` over ``attenuation_distance`` metres, infinite where
    nothing is lost. A ``thin`` sheet has no inside: light goes straight through it, and what its two faces reflect to
    and fro is counted [Mitsuba's thin dielectric]; 2R/(1 + R) of it is reflected.
    """

    index: float = 1.5
    transmission: float = 1.0
    attenuation_color: Vec3 = (1.0, 1.0, 1.0)
    attenuation_distance: float = float("inf")
    thin: bool = False

    @property
    def absorption(self) -> Float64[np.ndarray, "3"]:
        """Of the inside, per metre: over t metres light is multiplied by exp(-absorption·t). [Beer52]"""
        if self.thin:
            return np.zeros(3)
        return -np.log(np.maximum(self.attenuation_color, LEAST_ATTENUATION)) / self.attenuation_distance


COAT_F0 = 0.04
"""Reflectance of a clear coat along its normal, of index 1.5."""

LEAST_ATTENUATION = 1e-6  # of a channel over the attenuation distance: black would be infinitely dense


@dataclass(frozen=True)
class Material:
    """glTF 2.0 metallic-roughness, with emission as radiance.

    ``base_color`` and ``emission`` are linear Rec. 709; emission includes KHR_materials_emissive_strength. The base
    colour texture and the emission texture are sRGB, the others linear; the metallic-roughness texture holds roughness
    in green and metallic in blue. What has ``refraction`` is no metal, whatever ``metallic`` says, and is seen from
    both sides: ``double_sided`` is then true.

    Alpha is ``alpha`` times that of the base colour texture and of the mesh's colours. Where ``alpha_mode`` is "mask"
    there is nothing where it is below ``alpha_cutoff``, and all where not; "blend" hides that share of what is behind.

    What is no metal reflects by its index ``ior`` [KHR_materials_ior], times ``specular`` and at normal incidence
    ``specular_color`` [KHR_materials_specular]; what has ``refraction`` by that one's index alone. A clear coat of
    index 1.5 covers the share ``clearcoat`` of what reflects and has no refraction, with a perceptual roughness and a
    normal map of its own [KHR_materials_clearcoat]: of their textures the first counts by red, the second by green.
    What is ``unlit`` sends its base colour as radiance, and has no diffuse light.
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
    refraction: Refraction | None = None
    alpha: float = 1.0
    alpha_mode: AlphaMode = "opaque"
    alpha_cutoff: float = 0.5
    ior: float = 1.5
    specular: float = 1.0
    specular_color: Vec3 = (1.0, 1.0, 1.0)
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.0
    clearcoat_texture: Texture | None = None
    clearcoat_roughness_texture: Texture | None = None
    clearcoat_normal_texture: Texture | None = None
    clearcoat_normal_scale: float = 1.0
    unlit: bool = False

    @property
    def emits(self) -> bool:
        """Whether it sends light of its own, as far as factors tell."""
        return self.unlit or any(self.emission)

    @property
    def reflects(self) -> bool:
        """Whether anything of it does: not what is unlit, nor what is matte."""
        shows = self.specular > 0.0 or self.metallic > 0.0 or self.clearcoat > 0.0 or self.refraction is not None
        return shows and not self.unlit

    @property
    def bends_normals(self) -> bool:
        """Whether it has normal maps, be it of its coat."""
        return self.normal_texture is not None or self.clearcoat_normal_texture is not None

    @property
    def cutoff(self) -> float:
        """What alpha is compared with: 0 of opaque materials, -1 of those that let through at random."""
        return {"opaque": 0.0, "mask": self.alpha_cutoff, "blend": -1.0}[self.alpha_mode]

    @property
    def dielectric_f0(self) -> Vec3:
        """Reflectance at normal incidence of what is no metal: (((n - 1)/(n + 1))² · colour, at most 1) · specular. An
        index of 0 stands for an infinite one, as glTF has it."""
        facing = 1.0 if self.ior == 0.0 else ((self.ior - 1.0) / (self.ior + 1.0)) ** 2
        r, g, b = (self.specular * min(facing * c, 1.0) for c in self.specular_color)
        return r, g, b

    @property
    def dielectric_f90(self) -> float:
        """... and along the surface."""
        return self.specular

    @property
    def textures(self) -> dict[str, Texture | None]:
        """All of them, by the names of their fields."""
        names = ("base_color_texture_srgb", "metallic_roughness_texture", "normal_texture", "emission_texture_srgb")
        coats = ("clearcoat_texture", "clearcoat_roughness_texture", "clearcoat_normal_texture")
        return {name: getattr(self, name) for name in names + coats}

    def __post_init__(self) -> None:
        if self.refraction is not None:
            object.__setattr__(self, "double_sided", True)


MIRROR = Material(name="mirror", base_color=(0.65, 0.65, 0.65), metallic=1.0, perceptual_roughness=0.0)
"""What a mesh with no material is made of."""


@dataclass(frozen=True)
class EnvironmentLight:
    """A lat-long picture of infinitely distant radiance, in the project's convention: +x in the middle,
    u = 1/2 + atan2(z, x)/2π, v = acos(y)/π from the top."""

    radiance: Float32[np.ndarray, "height width 3"]
