"""The scene on the device: vertices, triangles, mesh colours, materials."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

import numpy as np
import wgpu

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.relief import Relief
from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.errors import RefletError
from reflet.pem.pem import MOST_SHELLS, Layer, ParameterizedEnvironmentMap
from reflet.reflectance.materials.material import dfg_table
from reflet.render.device.textures import (
    ADDRESS_MODES,
    create_map_array,
    map_array_view,
    upload_picture,
    upload_reliefs,
)
from reflet.render.playback.hit_buffers import bvh_words, drawn_directions, hit_materials
from reflet.render.playback.layouts import (
    DOUBLE_SIDED,
    FRAME,
    HAS_LOCAL,
    OFF_HULL,
    REFLECTIVE,
    REFRACTIVE,
    TRIANGLE_ON_HULL,
    coat_pictures_of,
    frame_layout,
    part_layout,
    part_uniform,
)
from reflet.render.playback.picture_atlas import picture_atlas
from reflet.render.playback.punctual_lights import light_words, lit
from reflet.render.playback.stacks import Stack
from reflet.render.playback.surface_maps import sites_of, surface_bits, upload_surface
from reflet.render.playback.vertex_table import vertex_table
from reflet.scene.bvh.build import build_bvh
from reflet.scene.companions import traced_parts
from reflet.scene.material import CLAMPS, REPEATS, WRAPS, Texture
from reflet.scene.roughness import is_rough
from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap


@dataclass(frozen=True)
class Draw:
    """Some triangles of one part that are drawn alike, and what pipelines may take for granted of them; ``traced`` is
    what those of programs that trace may, empty where no ray may meet anything."""

    part: int
    first: int
    count: int
    bits: int
    constants: Mapping[str, float]
    traced: Mapping[str, float]

    @property
    def double_sided(self) -> bool:
        """Whether backs are shaded like fronts."""
        return bool(self.bits & DOUBLE_SIDED)


class SceneBuffers:
    """All of a PEM but its maps, and the bind groups of its draw calls."""

    def __init__(
        self,
        device: wgpu.GPUDevice,
        pem: ParameterizedEnvironmentMap,
        stacks: Sequence[Stack],
    ) -> None:
        self._device, self._pem = device, pem
        self._stacks = stacks
        # parts may be thousands
        self._stack_of_part: dict[tuple[int, str], int] = {
            (part, stack.kind): i for i, stack in enumerate(stacks) for part in stack.parts
        }
        self._pictures: dict[tuple[int, bool], wgpu.GPUTexture] = {}
        self._reliefs: dict[int | None, wgpu.GPUTextureView] = {}  # by stack
        self._samplers = {(u, v): _sampler(device, ADDRESS_MODES[u], ADDRESS_MODES[v]) for u in WRAPS for v in WRAPS}
        self._no_map = create_map_array(device, MipChain(1, CUBE), 1)  # six layers: any view fits
        self.frame_uniform = device.create_buffer(
            size=FRAME.itemsize, usage=wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        )
        scene, colours = pem.scene, pem.irradiance
        # Triangles on the hull come first in their part, so that they can be drawn without local maps.
        part_of_triangle = np.repeat(np.arange(len(scene.parts)), np.diff(scene.triangle_offsets))
        order = np.lexsort((~pem.on_hull, part_of_triangle))
        grids = np.stack([colours.resolution, colours.offset], -1)[order]
        self._surface_bits = surface_bits(scene, pem.surface)
        if pem.surface is not None:
            grids = np.concatenate([grids, sites_of(pem.surface, order)])
        vertices, self._extras = vertex_table(scene)
        buffers = [vertices, _triangles(scene, pem.on_hull, order), grids, _radiosity(scene, colours)]
        drawn_number = np.empty(len(order), np.int64)
        drawn_number[order] = np.arange(len(order))
        *met, pictures, self._hit_bits = self._what_rays_meet(drawn_number)
        environment = upload_picture(device, _environment(scene), "rgba16float", mip_mapped=True)
        self.frame_group = device.create_bind_group(
            layout=frame_layout(device),
            entries=[
                {"binding": 0, "resource": {"buffer": self.frame_uniform}},
                *({"binding": 1 + i, "resource": {"buffer": self._storage(b)}} for i, b in enumerate(buffers)),
                {"binding": 5, "resource": environment.create_view()},
                {"binding": 6, "resource": _sampler(device, "repeat", "clamp-to-edge")},
                *({"binding": 7 + i, "resource": {"buffer": self._storage(b)}} for i, b in enumerate(met)),
                {"binding": 10, "resource": pictures.create_view(dimension="2d-array")},
                {"binding": 11, "resource": upload_picture(device, _table(scene), "rgba16float", False).create_view()},
                {"binding": 12, "resource": upload_surface(device, pem.surface).create_view(dimension="2d-array")},
                {"binding": 13, "resource": {"buffer": self._storage(light_words(scene, colours))}},
            ],
        )
        self._coats = [
            picture_atlas(device, coat_pictures_of(part)) if part.is_coated else None for part in scene.parts
        ]
        self._no_coat, _ = picture_atlas(device, ())
        parts = [self._part_uniform(i) for i in range(len(scene.parts))]
        self._part_uniforms = [
            device.create_buffer_with_data(data=data.tobytes(), usage=wgpu.BufferUsage.UNIFORM) for data in parts
        ]
        self._any_bits = reduce(or_, (int(data["bits"]) for data in parts), OFF_HULL)
        draws = [draw for i, data in enumerate(parts) for draw in self._draws_of(i, data)]
        # Reflective parts first: what they hide of the room is then never shaded.
        self.draws = sorted(draws, key=lambda draw: not draw.bits & REFLECTIVE)

    def part_groups(self, arrays: Sequence[wgpu.GPUTexture]) -> list[wgpu.GPUBindGroup]:
        """The bind groups of all parts; ``arrays`` are the maps of the stacks."""
        groups = []
        for i, part in enumerate(self._pem.scene.parts):
            distant, local = (self._stack_of_part.get((i, kind)) for kind in ("distant", "local"))
            material = part.material
            base_color, emission = material.base_color_texture_srgb, material.emission_texture_srgb
            resources = [
                {"buffer": self._part_uniforms[i]},
                self._picture(base_color, srgb=True),
                self._picture(material.metallic_roughness_texture, srgb=False),
                self._picture(material.normal_texture, srgb=False),
                self._picture(emission, srgb=True),
                self._picture_sampler(base_color),
                self._picture_sampler(emission),
                self._maps(arrays, distant, cubes=True),
                self._maps(arrays, local, cubes=True),
                self._samplers[CLAMPS],
                self._maps(arrays, distant, cubes=False),
                self._maps(arrays, local, cubes=False),
                self._reliefs_of(distant),
                (self._no_coat if (coat := self._coats[i]) is None else coat[0]).create_view(dimension="2d-array"),
            ]
            entries = [{"binding": k, "resource": resource} for k, resource in enumerate(resources)]
            groups.append(self._device.create_bind_group(layout=part_layout(self._device), entries=entries))
        return groups

    def _what_rays_meet(
        self, drawn_number: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, wgpu.GPUTexture, int]:
        """The tree, directions, materials, their pictures and bits; of a PEM that is not traced next to nothing."""
        scene = self._pem.scene
        if not self._pem.most_hits:
            none = np.zeros(0, np.uint32)
            return none, none, *hit_materials(self._device, [], [], [])
        bvh = self._pem.bvh or build_bvh(scene, self._pem.on_hull)
        words, directions = bvh_words(scene, bvh, drawn_number), drawn_directions(scene, bvh, drawn_number)
        met = traced_parts(scene, bvh.companions)
        parts = [scene.parts[number] for number in met]
        extras, bits = ([of_part[number] for number in met] for of_part in (self._extras, self._surface_bits))
        return words, directions, *hit_materials(self._device, parts, extras, bits)

    def _maps(self, arrays: Sequence[wgpu.GPUTexture], stack: int | None, *, cubes: bool) -> wgpu.GPUTextureView:
        """A stack's maps if they are cubes, or if they are not; else a map of one black texel."""
        if stack is not None:
            parameterization = self._stacks[stack].chain.parameterization
            if (parameterization == CUBE) is cubes:
                return map_array_view(arrays[stack], parameterization)
        return self._no_map.create_view(dimension="cube-array" if cubes else "2d-array")

    def _reliefs_of(self, stack: int | None) -> wgpu.GPUTextureView:
        """The reliefs of a stack, uploaded once; an infinitely far one where a layer has another geometry."""
        if stack not in self._reliefs:
            layers = [] if stack is None else [self._pem.layers[i] for i in self._stacks[stack].layers]
            self._reliefs[stack] = upload_reliefs(self._device, _inverse_distances(layers))
        return self._reliefs[stack]

    def _layers_of(self, part: int, kind: str) -> list[Layer]:
        """The layers of this kind that a part looks up, the nearest first."""
        stack = self._stack_of_part.get((part, kind))
        return [] if stack is None else [self._pem.layers[i] for i in self._stacks[stack].layers]

    def _part_uniform(self, part: int) -> np.ndarray:
        local = self._layers_of(part, "local")
        shells, extras = self._layers_of(part, "distant"), self._extras[part]
        data = part_uniform(self._pem.scene.parts[part], shells, local[0] if local else None, extras)
        data["bits"] |= self._surface_bits[part]
        if (coat := self._coats[part]) is not None:
            for k, picture in enumerate(coat_pictures_of(self._pem.scene.parts[part])):
                if picture is not None:
                    data["coat_pictures"][k] = coat[1][id(picture.pixels)]
        return data

    def _draws_of(self, part: int, data: np.ndarray) -> list[Draw]:
        first, end = self._pem.scene.triangle_offsets[part : part + 2]
        bits = int(data["bits"])
        constants = {
            "PART_SAMPLING": int(data["sampling"]),
            "ANY_BITS": self._any_bits,
            "LIGHT_COUNT": lit(self._pem.scene, self._pem.irradiance),
            "SHELL_COUNT": int(data["shell_count"]),
            **{f"DISTANT_KIND_{shell}": float(data["distant"]["geometry"][shell, 0]) for shell in range(MOST_SHELLS)},
            "LOCAL_KIND": float(data["local"]["geometry"][0]),
            "DISTANT_PARAMETERIZATION": int(data["distant"]["parameterization"][0]),
            "LOCAL_PARAMETERIZATION": int(data["local"]["parameterization"]),
        }
        hits = self._pem.most_hits if bits & REFLECTIVE else 0
        traced = {"MOST_HITS": hits, "HIT_BITS": self._hit_bits} if hits else {}
        on_hull = int(self._pem.on_hull[first:end].sum()) if bits & HAS_LOCAL or hits else 0
        # The hull's mirrors see other objects and companions alone; what goes through glass always meets its own.
        sees_others = len(self._pem.scene.objects) > 1 or self._pem.companions
        of_hull = traced if sees_others or bits & REFRACTIVE else {}
        draws = [
            Draw(part, first, on_hull, bits & ~HAS_LOCAL, constants, of_hull),
            Draw(part, first + on_hull, end - first - on_hull, bits | OFF_HULL, constants, traced),
        ]
        return [draw for draw in draws if draw.count]

    def _storage(self, data: np.ndarray) -> wgpu.GPUBuffer:
        # A binding may not be empty, a scene without mesh colours is allowed.
        contents = np.ascontiguousarray(data).tobytes() or bytes(16)
        return self._device.create_buffer_with_data(data=contents, usage=wgpu.BufferUsage.STORAGE)

    def _picture(self, texture: Texture | None, srgb: bool) -> wgpu.GPUTextureView:
        key = (0 if texture is None else id(texture.pixels), srgb)
        if key not in self._pictures:
            pixels = np.full((1, 1, 4), 255, np.uint8) if texture is None else texture.pixels
            texture_format = "rgba8unorm-srgb" if srgb else "rgba8unorm"
            self._pictures[key] = upload_picture(self._device, pixels, texture_format, mip_mapped=srgb)
        return self._pictures[key].create_view()

    def _picture_sampler(self, texture: Texture | None) -> wgpu.GPUSampler:
        return self._samplers[REPEATS if texture is None else texture.wraps]


def _inverse_distances(layers: Sequence[Layer]) -> list[np.ndarray]:
    """The reliefs of some layers, at least one; all 0, infinitely far, in place of other geometries."""
    reliefs = [layer.geometry.inverse_distance for layer in layers if isinstance(layer.geometry, Relief)]
    sizes = {relief.shape[-1] for relief in reliefs}
    if len(sizes) > 1:
        raise RefletError(
            f"The reliefs of {', '.join(layer.name for layer in layers)} have {' and '.join(map(str, sorted(sizes)))} "
            "rows, and have to be of one size; bake the PEM again."
        )
    none = np.zeros((6, *2 * (min(sizes, default=1),)), np.float16)
    return [it.geometry.inverse_distance if isinstance(it.geometry, Relief) else none for it in layers] or [none]


def _sampler(device: wgpu.GPUDevice, u: str, v: str) -> wgpu.GPUSampler:
    return device.create_sampler(
        address_mode_u=u, address_mode_v=v, mag_filter="linear", min_filter="linear", mipmap_filter="linear"
    )


def _triangles(scene: Scene, on_hull: np.ndarray, order: np.ndarray) -> np.ndarray:
    first_vertex = np.cumsum([0] + [len(part.mesh.positions) for part in scene.parts])
    out = np.empty((scene.triangle_offsets[-1], 4), np.uint32)
    corners = [part.mesh.triangles + first for part, first in zip(scene.parts, first_vertex, strict=False)]
    out[:, :3] = np.concatenate(corners)
    out[:, 3] = 2 * np.arange(len(out)) + np.where(on_hull, TRIANGLE_ON_HULL, 0)
    return out[order]


def _radiosity(scene: Scene, colours: IrradianceMap) -> np.ndarray:
    """Of all samples, and behind it, where normals are bent, their gradients; 0 where there are none."""
    if not any(part.has_normal_map for part in scene.parts):
        return colours.radiosity
    gradient = colours.gradient if len(colours.gradient) else np.zeros_like(colours.radiosity)
    return np.concatenate([colours.radiosity, gradient])


def _table(scene: Scene) -> np.ndarray:
    """`dfg_table` where a part is rough."""
    none = np.zeros((1, 1, 4), np.float16)
    return dfg_table().astype(np.float16) if any(is_rough(part) for part in scene.parts) else none


def _environment(scene: Scene) -> np.ndarray:
    if scene.environment is None:
        return np.zeros((1, 1, 4), np.float16)
    radiance = scene.environment.radiance
    out = np.ones((*radiance.shape[:2], 4), np.float16)
    out[..., :3] = np.clip(radiance, 0.0, HALF_MAX)
    return out
