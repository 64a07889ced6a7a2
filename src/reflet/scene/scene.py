"""The scene: parts, the reflective objects they form, and the light around them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.punctual_light import PunctualLight


@dataclass(frozen=True)
class Part:
    """A mesh with one material and a name that is unique in its scene.

    A reflective part mirrors, as smoothly as its roughness says; its reflectance at normal incidence is its base colour
    where metallic, its dielectric_f0 where not, its remaining, diffuse colour base_color·(1 - metallic). Where its
    material has a refraction it is glass: ((n - 1)/(n + 1))² at normal incidence, and diffuse as far as nothing is let
    through.
    """

    name: str
    mesh: Mesh
    material: Material
    reflective: bool = False

    @property
    def has_normal_map(self) -> bool:
        """Whether a normal texture bends its normals: one without texture coordinates or tangents cannot."""
        placed = self.mesh.uv is not None and self.mesh.tangents is not None
        return placed and self.material.normal_texture is not None

    @property
    def is_coated(self) -> bool:
        """Whether a clear coat reflects above what it is made of."""
        material = self.material
        return self.reflective and material.clearcoat > 0.0 and material.refraction is None and not material.unlit


@dataclass(frozen=True)
class ReflectiveObject:
    """Reflective parts that touch one another; ``parts`` are indices into `Scene.parts`."""

    name: str
    parts: tuple[int, ...]


@dataclass(frozen=True)
class Scene:
    """All parts in world space. Triangles are numbered through all parts, in the parts' order. ``floor`` are the
    indices of those that were put beneath the others (`reflet.scene.floor`), one after the other."""

    parts: tuple[Part, ...]
    objects: tuple[ReflectiveObject, ...]
    environment: EnvironmentLight | None = None
    lights: tuple[PunctualLight, ...] = ()
    floor: tuple[int, ...] = ()

    @cached_property
    def triangle_offsets(self) -> tuple[int, ...]:
        """Number of the first triangle of each part, and at the end the number of all triangles."""
        return tuple(np.cumsum([0] + [len(part.mesh.triangles) for part in self.parts]).tolist())

    @cached_property
    def object_of_part(self) -> tuple[int, ...]:
        """Index of the object that each part belongs to, -1 for parts that do not reflect."""
        owner = {p: o for o, item in enumerate(self.objects) for p in item.parts}
        return tuple(owner.get(p, -1) for p in range(len(self.parts)))
