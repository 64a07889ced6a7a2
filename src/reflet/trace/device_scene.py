"""A scene as flat arrays on the ray tracing device.

All triangles form one mesh, so that a hit's primitive index is the scene's triangle number, and every property of a
surface is a gather from a table: one kernel serves every material, and nothing of it is compiled per scene.
"""

from collections.abc import Collection, Sequence
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Bool

from reflet.files.srgb import linear_from_srgb
from reflet.reflectance.materials.material import dfg_table
from reflet.scene.bounds import reach
from reflet.scene.material import WRAPS
from reflet.scene.punctual_light import packed
from reflet.scene.roughness import LEAST_ROUGHNESS
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap

NO_TEXTURE = 0xFFFFFFFF
DOUBLE_SIDED, GONE_THROUGH, UNLIT = 1, 2, 4  # flags of a part; its object's index + 1 follows in the bits above
OBJECT_SHIFT = 3
_ALL = -1  # in place of an object's index


class DeviceScene:
    """Tables of a scene's triangles, parts and textures, and the acceleration structures that rays meet.

    Records are four floats wide where they are gathered, which the device fetches in one packet. Distant light is what
    mirrored rays meet that pass through their own object, or, where there are, ``through`` parts of these indices,
    among them all that reflect: what these show is then local.
    """

    def __init__(self, scene: Scene, through: Collection[int] = ()) -> None:
        self.scene, self.through = scene, frozenset(through)
        meshes = [part.mesh for part in scene.parts]
        starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
        self.positions = np.concatenate([mesh.positions for mesh in meshes])
        uv = _attribute([mesh.uv for mesh in meshes], starts, 2)
        normals = np.concatenate([mesh.normals for mesh in meshes])
        triangles = [mesh.triangles + np.uint32(start) for mesh, start in zip(meshes, starts[:-1], strict=True)]
        self.triangles = np.concatenate(triangles)
        self.part_of_triangle = np.repeat(np.arange(len(meshes), dtype=np.uint32), np.diff(scene.triangle_offsets))
        self.object_of_triangle = np.array(scene.object_of_part, np.int32)[self.part_of_triangle]

        self.corners = mi.UInt32(np.column_stack([self.triangles, self.part_of_triangle]).ravel())
        self.position_u = _floats(np.column_stack([self.positions, uv[:, 0]]))
        self.normal_v = _floats(np.column_stack([normals, uv[:, 1]]))
        # Asked for at triangles with normal maps alone.
        self.tangents = _floats(
            _attribute([mesh.tangents for mesh in meshes], starts if self.has_normal_maps else starts[:1], 4)
        )
        self.has_colors = any(mesh.colors is not None for mesh in meshes)
        if self.has_colors:
            colors = [mesh.colors if mesh.colors is not None else np.ones((len(mesh.positions), 4)) for mesh in meshes]
            self.colors = _floats(np.concatenate(colors))
        sets = range(max(len(mesh.more_uv) for mesh in meshes))
        more = [[mesh.more_uv[k] if k < len(mesh.more_uv) else None for mesh in meshes] for k in sets]
        self.more_uv = [_floats(_attribute(each, starts, 2)) for each in more]
        self._upload_materials()
        self._upload_environment()
        self.lights = _floats(packed(scene.lights) if scene.lights else np.zeros(4))
        self.all = mi.load_dict({"type": "scene", "mesh": self._mesh(self.triangles)})
        self._without: dict[int, tuple[mi.Scene | None, mi.UInt32]] = {}
        self._reaches: dict[tuple[int, tuple[float, float, float]], float] = {}
        self.emitters: Any = None  # of `emitters_of`, found once
        none = np.zeros(len(self.triangles), np.uint32)
        self.set_irradiance(IrradianceMap(none, none, np.zeros((1, 3), np.float32)))

    def without_object(self, index: int) -> tuple["mi.Scene | None", "mi.UInt32"]:
        """The scene that lacks one object, or all that rays go ``through``, and the scene's triangle number of each of
        its triangles.

        The scene is None where nothing else is left.
        """
        index = _ALL if self.through else index
        if index not in self._without:
            own = self.object_of_triangle == index
            if self.through:
                own = np.isin(self.part_of_triangle, list(self.through))
            kept = np.flatnonzero(~own).astype(np.uint32)
            scene = mi.load_dict({"type": "scene", "mesh": self._mesh(self.triangles[kept])}) if len(kept) else None
            self._without[index] = scene, mi.UInt32(kept)
        return self._without[index]

    def reach(self, index: int, origin: tuple[float, float, float]) -> float:
        """`reflet.scene.bounds.reach`, found once: a probe is traced in many batches."""
        key = index, origin
        if key not in self._reaches:
            self._reaches[key] = reach(self.scene, index, origin)
        return self._reaches[key]

    def set_irradiance(self, irradiance: IrradianceMap) -> None:
        """Take these mesh colours for all surfaces from now on."""
        self.radiosity_grid = mi.UInt32(np.column_stack([irradiance.resolution, irradiance.offset]).ravel())
        none = 0 if len(irradiance.radiosity) else 1  # a gather that nothing takes part in needs a value all the same
        self.radiosity = _floats(np.pad(irradiance.radiosity, ((0, none), (0, 1))))
        self.has_gradients = self.has_normal_maps and len(irradiance.gradient) > 0
        if self.has_gradients:
            self.gradient = _floats(np.pad(irradiance.gradient, ((0, 0), (0, 1))))

    @cached_property
    def has_bent_normals(self) -> Bool[np.ndarray, "parts"]:
        """Which parts have a normal map that applies."""
        return np.array([part.has_normal_map for part in self.scene.parts])

    @cached_property
    def has_normal_maps(self) -> bool:
        """Whether any part has, be it of its coat."""
        return bool(self.has_bent_normals.any()) or any(
            part.material.clearcoat_normal_texture is not None and part.mesh.tangents is not None
            for part in self.scene.parts
        )

    def _mesh(self, triangles: np.ndarray) -> "mi.Mesh":
        seen = np.zeros(len(self.positions), bool)
        seen[triangles] = True
        used = np.flatnonzero(seen)
        renumbered = (np.cumsum(seen, dtype=np.uint32) - np.uint32(1))[triangles]
        mesh = mi.Mesh("mesh", len(used), len(triangles), has_vertex_normals=False, has_vertex_texcoords=False)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = self.positions[used].ravel()
        parameters["faces"] = renumbered.ravel()
        parameters.update()
        return mesh

    def _upload_materials(self) -> None:
        texels: list[np.ndarray] = []
        headers: list[tuple[int, int, int, int]] = []
        known: dict[int, int] = {}

        def slot(texture) -> int:  # type: ignore[no-untyped-def]
            if texture is None:
                return NO_TEXTURE
            if id(texture) not in known:
                height, width = texture.pixels.shape[:2]
                along, across = map(WRAPS.index, texture.wraps)
                known[id(texture)] = len(headers)
                headers.append(
                    (sum(len(t) for t in texels), width, height, along | across << 2 | texture.coordinates << 4)
                )
                texels.append(np.ascontiguousarray(texture.pixels).view(np.uint32).ravel())
            return known[id(texture)]

        colors, emissions, slots, flags, glass, absorption = [], [], [], [], [], []
        alphas, dielectrics, coats, coat_slots = [], [], [], []
        for number, (part, owner) in enumerate(zip(self.scene.parts, self.scene.object_of_part, strict=True)):
            m = part.material
            normal_texture = m.normal_texture if part.has_normal_map else None
            textured = part.mesh.uv is not None
            colors.append((*m.base_color, m.metallic))
            emissions.append((*m.emission, m.normal_scale))
            alphas.append((m.alpha, m.cutoff))
            dielectrics.append((*m.dielectric_f0, m.dielectric_f90))
            four = (m.base_color_texture_srgb, m.metallic_roughness_texture, normal_texture, m.emission_texture_srgb)
            slots.append([slot(texture if textured else None) for texture in four])
            passed = GONE_THROUGH * (number in self.through)
            flags.append(DOUBLE_SIDED * m.double_sided | passed | UNLIT * m.unlit | (owner + 1) << OBJECT_SHIFT)
            refraction = m.refraction if owner >= 0 else None
            kind = (0, 0, 0) if refraction is None else (refraction.index, refraction.transmission, refraction.thin)
            glass.append((*kind, 0))
            absorption.append((0,) * 4 if refraction is None else (*refraction.absorption, 0))
            coats.append((part.is_coated * m.clearcoat, m.clearcoat_roughness, m.clearcoat_normal_scale, 0))
            bumps = m.clearcoat_normal_texture if part.mesh.tangents is not None else None
            coat = (m.clearcoat_texture, m.clearcoat_roughness_texture, bumps, None)
            coat_slots.append([slot(texture if textured and part.is_coated else None) for texture in coat])
        self.has_glass = any(index > 0 for index, *_ in glass)
        self.part_glass, self.part_absorption = _floats(np.array(glass)), _floats(np.array(absorption))
        self.has_holes = any(part.material.alpha_mode != "opaque" for part in self.scene.parts)
        self.part_alpha = _floats(np.array(alphas))
        self.part_dielectric = _floats(np.array(dielectrics))
        self.has_coats = any(part.is_coated for part in self.scene.parts)
        if self.has_coats:
            self.part_coat = _floats(np.array(coats))
            self.part_coat_textures = mi.UInt32(np.array(coat_slots, np.uint32).ravel())
        roughest = [_greatest_roughness(part) for part in self.scene.parts]
        self.has_rough = self.has_coats or max(roughest, default=0.0) >= LEAST_ROUGHNESS
        if self.has_rough:
            self.part_roughness = _floats(np.array([part.material.perceptual_roughness for part in self.scene.parts]))
            albedos = mi.TensorXf(np.ascontiguousarray(dfg_table()[..., :2]))
            self.dfg = mi.Texture2f(albedos, use_accel=False, wrap_mode=dr.WrapMode.Clamp)  # exact on every device
        self.part_color_metallic = _floats(np.array(colors))
        self.part_emission_scale = _floats(np.array(emissions))
        self.part_textures = mi.UInt32(np.array(slots, np.uint32).ravel())
        self.part_flags = mi.UInt32(np.array(flags, np.uint32))
        self.has_textures = bool(headers)
        self.texture_headers = mi.UInt32(np.array(headers or [(0, 1, 1, 0)], np.uint32).ravel())
        self.texels = mi.UInt32(np.concatenate(texels) if texels else np.zeros(1, np.uint32))
        self.linear_from_srgb = mi.Float(linear_from_srgb(np.arange(256) / 255.0).astype(np.float32))

    def _upload_environment(self) -> None:
        light = self.scene.environment
        self.environment_size = (0, 0) if light is None else light.radiance.shape[:2]
        if light is not None:
            self.environment = _floats(np.dstack([light.radiance, np.zeros(light.radiance.shape[:2])]))


def _greatest_roughness(part: Part) -> float:
    """Of what reflects by lobes; 0 of all else."""
    material = part.material
    if not part.reflective or material.refraction is not None:
        return 0.0
    texture = material.metallic_roughness_texture if part.mesh.uv is not None else None
    most = 1.0 if texture is None else float(texture.pixels[..., 1].max()) / 255.0
    return material.perceptual_roughness * most


def _attribute(parts: Sequence[np.ndarray | None], starts: np.ndarray, width: int) -> np.ndarray:
    """An attribute of all vertices, zero in parts that lack it. Part k begins at ``starts[k]``, the last number is that
    of all vertices."""
    table = np.zeros((max(int(starts[-1]), 1), width), np.float32)
    for values, start in zip(parts, starts[:-1], strict=False):
        if values is not None:
            table[start : start + len(values)] = values
    return table


def _floats(table: np.ndarray) -> "mi.Float":
    return mi.Float(np.ascontiguousarray(table, np.float32).ravel())
