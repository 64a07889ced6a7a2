"""The host's side of the shaders' bind groups: `shaders/frame.wgsl` and `shaders/part.wgsl` describe them."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
import wgpu
from jaxtyping import Float

from reflet.envmap.geometry import pack
from reflet.errors import RefletError
from reflet.pem.pem import MOST_SHELLS, Layer
from reflet.scene.material import WRAPS, Texture
from reflet.scene.roughness import is_rough
from reflet.scene.scene import Part
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import sample_positions

Shown = Literal["diffuse", "fresnel", "distant", "local"]
SWITCHES: dict[Shown, int] = {"diffuse": 1, "fresnel": 2, "distant": 4, "local": 8}
OBJECT_ONLY = 16
HIDE_SHELL = 32  # the nearest; the others' bits follow
BY_ORIGIN = HIDE_SHELL << MOST_SHELLS

TRIANGLE_ON_HULL = 1

REFLECTIVE, DOUBLE_SIDED, HAS_LOCAL = 1, 2, 4
BASE_COLOR_TEXTURE, METALLIC_ROUGHNESS_TEXTURE, NORMAL_TEXTURE, EMISSION_TEXTURE = 8, 16, 32, 64
COLORS, MORE_UV, HOLES, UNLIT = 128, 256, 512, 4096
METAL, OFF_HULL, REFRACTIVE, THIN, ROUGH, SURFACE = 1024, 2048, 8192, 16384, 32768, 65536
COAT, COAT_TEXTURES = 131072, 262144

LARGEST_BLEND = 8  # samples of the parameter space in one lookup; behind them in the frame's arrays stands the base

FRAME = np.dtype(
    [
        ("clip_from_world", "f4", (4, 4)), ("eye", "f4", 3), ("lod_bias", "f4"),
        ("ray_corner", "f4", 3), ("texture_lod_bias", "f4"), ("ray_dx", "f4", 3), ("width", "f4"),
        ("ray_dy", "f4", 3), ("height", "f4"), ("sub_samples", "f4", (64, 4)), ("blend", "f4", (LARGEST_BLEND + 1, 4)),
        ("blend_count", "u4"), ("switches", "u4"), ("padding", "u4", 2), ("eye_rest", "f4", 4),
        ("rows", "f4", (3, 4)), ("rows_rest", "f4", (3, 4)), ("map_from_world", "f4", (LARGEST_BLEND + 1, 3, 4)),
    ]
)  # fmt: skip
_LAYER = np.dtype(
    [("geometry", "f4", 12), ("size", "f4"), ("max_lod", "f4"), ("parameterization", "u4"), ("padding", "f4")]
)
PART = np.dtype(
    [
        ("distant", _LAYER, MOST_SHELLS), ("local", _LAYER), ("base_color", "f4", 3), ("metallic", "f4"),
        ("emission", "f4", 3), ("normal_scale", "f4"), ("bits", "u4"), ("shell_count", "u4"),
        ("transmission", "f4"), ("perceptual_roughness", "f4"), ("absorption", "f4", 3), ("index", "f4"),
        ("sampling", "u4"), ("extras", "u4"), ("alpha", "f4"), ("cutoff", "f4"),
        ("dielectric_f0", "f4", 3), ("dielectric_f90", "f4"), ("coat", "f4"), ("coat_roughness", "f4"),
        ("coat_normal_scale", "f4"), ("coat_sampling", "u4"), ("coat_pictures", "u4", (3, 4)),
    ]
)  # fmt: skip
HIT_MATERIAL = np.dtype(
    [
        ("base_color", "f4", 3), ("metallic", "f4"), ("emission", "f4", 3), ("normal_scale", "f4"),
        ("bits", "u4"), ("transmission", "f4"), ("sampling", "u4"), ("extras", "u4"),
        ("absorption", "f4", 3), ("index", "f4"), ("alpha", "f4"), ("cutoff", "f4"),
        ("perceptual_roughness", "f4"), ("coat", "u4"),
        ("dielectric_f0", "f4", 3), ("dielectric_f90", "f4"), ("pictures", "u4", (4, 4)),
    ]
)  # fmt: skip

# The near plane's distance as a share of the target's. Depth is floating and reversed, so it may be small.
_NEAR_SHARE = 1e-3


@dataclass(frozen=True)
class Blended:
    """A sample of the parameter space as a frame shows it, or the base."""

    slot: int  # in the arrays of maps
    weight: float  # of the samples; the base's is its share of the distant light
    map_from_world: Float[np.ndarray, "3 3"]  # the frame of its view-dependent maps


def frame_uniform(
    camera: Camera, sample_count: int, lod_bias: float, blend: Sequence[Blended], base: Blended, switches: int
) -> np.ndarray:
    """`FRAME` of a picture."""
    frame = np.zeros((), FRAME)
    clip_from_world = camera.clip_from_world(1.0, 2.0)
    # Reversed depth with an infinite far plane: near/distance, which floats resolve evenly at all distances.
    clip_from_world[2] = 0.0, 0.0, 0.0, _NEAR_SHARE * np.linalg.norm(np.subtract(camera.target, camera.position))
    frame["clip_from_world"] = clip_from_world.T
    corner, dx, dy = camera.ray_basis()
    frame["eye"], frame["ray_corner"], frame["ray_dx"], frame["ray_dy"] = camera.position, corner, dx, dy
    frame["eye_rest"][:3] = camera.position - frame["eye"].astype(np.float64)
    pixel_from_view = np.linalg.inv(np.stack([dx, dy, corner], -1))
    frame["rows"][:, :3] = pixel_from_view
    frame["rows_rest"][:, :3] = pixel_from_view - frame["rows"][:, :3].astype(np.float64)
    frame["lod_bias"], frame["texture_lod_bias"] = lod_bias, -0.5 * np.log2(sample_count)
    frame["width"], frame["height"] = camera.width, camera.height
    positions = sample_positions(sample_count)[: len(frame["sub_samples"])]
    frame["sub_samples"][: len(positions), :2] = positions
    for k, each in (*enumerate(blend), (LARGEST_BLEND, base)):
        frame["blend"][k, :2] = each.weight, each.slot
        frame["map_from_world"][k, :, :3] = each.map_from_world.T  # by columns
    frame["blend_count"], frame["switches"] = len(blend), switches
    return frame


def switch_bits(
    shown: Collection[Shown], object_only: bool, shells: Collection[int] | None, by_origin: bool = False
) -> int:
    """The frame's switches; ``shells`` are the numbers of the shells shown, all where None."""
    strange = set(shells or ()) - set(range(MOST_SHELLS))
    if strange:
        raise RefletError(f"Shells have the numbers 0 to {MOST_SHELLS - 1}, the nearest first, not {min(strange)}.")
    hidden = () if shells is None else set(range(MOST_SHELLS)) - set(shells)
    bits = sum(SWITCHES[name] for name in set(shown)) + OBJECT_ONLY * object_only + BY_ORIGIN * by_origin
    return bits + sum(HIDE_SHELL << shell for shell in hidden)


def base_state(share: float) -> int:
    """What pipelines may take for granted of the base's share of the distant light: none, some, or all."""
    return int(share > 0.0) + int(share >= 1.0)


def part_uniform(part: Part, shells: Sequence[Layer], local: Layer | None, extras: int) -> np.ndarray:
    """`PART` of one part and the layers it looks up, the nearest shell first; ``extras`` is where the extras of its
    vertices lie (`vertex_table`)."""
    out = np.zeros((), PART)
    out["shell_count"] = len(shells)
    places = [*zip(out["distant"], shells, strict=False), *([] if local is None else [(out["local"], local)])]
    for place, layer in places:
        place["geometry"] = pack(layer.geometry)
        place["size"], place["max_lod"] = layer.size, layer.chain.level_count - 1
        place["parameterization"] = layer.parameterization.kind
    fill_material(out, part, extras)
    out["bits"] |= HAS_LOCAL * (local is not None)
    if part.is_coated:
        material = part.material
        out["coat"], out["coat_roughness"] = material.clearcoat, material.clearcoat_roughness
        out["coat_normal_scale"] = material.clearcoat_normal_scale
        out["coat_sampling"] = _sampling(coat_pictures_of(part))
    return out


def fill_material(entry: np.ndarray | np.void, part: Part, extras: int) -> None:
    """What `PART` and `HIT_MATERIAL` have in common."""
    material = part.material
    entry["base_color"], entry["metallic"] = material.base_color, material.metallic
    entry["emission"], entry["normal_scale"] = material.emission, material.normal_scale
    entry["perceptual_roughness"] = material.perceptual_roughness
    entry["bits"], entry["extras"] = part_bits(part), extras
    entry["alpha"], entry["cutoff"] = material.alpha, material.cutoff
    entry["dielectric_f0"], entry["dielectric_f90"] = material.dielectric_f0, material.dielectric_f90
    entry["sampling"] = _sampling(pictures_of(part))
    if part.reflective and material.refraction is not None:
        entry["transmission"], entry["index"] = material.refraction.transmission, material.refraction.index
        entry["absorption"] = material.refraction.absorption


def pictures_of(part: Part) -> tuple[Texture | None, ...]:
    """Base colour, metallic-roughness, normals and emission, as far as the part's mesh can be textured by them."""
    material, has_uv = part.material, part.mesh.uv is not None
    return (
        material.base_color_texture_srgb if has_uv else None,
        material.metallic_roughness_texture if has_uv else None,
        material.normal_texture if part.has_normal_map else None,
        material.emission_texture_srgb if has_uv else None,
    )


def coat_pictures_of(part: Part) -> tuple[Texture | None, ...]:
    """Likewise of its clear coat: its share, its roughness, its normals; none where it has no coat."""
    material, mesh = part.material, part.mesh
    placed = part.is_coated and mesh.uv is not None
    return (
        material.clearcoat_texture if placed else None,
        material.clearcoat_roughness_texture if placed else None,
        material.clearcoat_normal_texture if placed and mesh.tangents is not None else None,
    )


def _sampling(textures: Sequence[Texture | None]) -> int:
    """A byte for each: how it wraps, and its set of texture coordinates."""
    bits = 0
    for k, texture in enumerate(textures):
        if texture is not None:
            along, across = map(WRAPS.index, texture.wraps)
            bits |= (along | across << 2 | texture.coordinates << 4) << 8 * k
    return bits


def part_bits(part: Part) -> int:
    """What a part's own bits say, whatever it looks up."""
    bits = REFLECTIVE * part.reflective + DOUBLE_SIDED * part.material.double_sided
    bits |= HOLES * (part.material.alpha_mode != "opaque") | UNLIT * part.material.unlit
    bits |= COLORS * (part.mesh.colors is not None) | MORE_UV * bool(part.mesh.more_uv)
    present = (BASE_COLOR_TEXTURE, METALLIC_ROUGHNESS_TEXTURE, NORMAL_TEXTURE, EMISSION_TEXTURE)
    for texture, bit in zip(pictures_of(part), present, strict=True):
        bits |= bit * (texture is not None)
    refraction = part.material.refraction if part.reflective else None
    if refraction is not None:
        return bits | REFRACTIVE | THIN * refraction.thin | METAL * (refraction.transmission >= 1.0)
    bits |= ROUGH * is_rough(part) | COAT * part.is_coated
    bits |= COAT_TEXTURES * any(texture is not None for texture in coat_pictures_of(part))
    return bits | METAL * (part.material.metallic == 1.0 and not bits & METALLIC_ROUGHNESS_TEXTURE)


@cache
def frame_layout(device: wgpu.GPUDevice) -> wgpu.GPUBindGroupLayout:
    """Bind group 0."""
    both = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    fragment = wgpu.ShaderStage.FRAGMENT
    storage = {"type": "read-only-storage"}
    return device.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": both, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": both, "buffer": storage},
            {"binding": 2, "visibility": both, "buffer": storage},
            {"binding": 3, "visibility": fragment, "buffer": storage},
            {"binding": 4, "visibility": fragment, "buffer": storage},
            {"binding": 5, "visibility": fragment, "texture": {"sample_type": "float", "view_dimension": "2d"}},
            {"binding": 6, "visibility": fragment, "sampler": {"type": "filtering"}},
            *({"binding": binding, "visibility": fragment, "buffer": storage} for binding in (7, 8, 9)),
            {"binding": 10, "visibility": fragment, "texture": {"sample_type": "float", "view_dimension": "2d-array"}},
            {"binding": 11, "visibility": fragment, "texture": {"sample_type": "float", "view_dimension": "2d"}},
            {"binding": 12, "visibility": fragment, "texture": {"sample_type": "float", "view_dimension": "2d-array"}},
            {"binding": 13, "visibility": fragment, "buffer": storage},
        ]
    )


@cache
def part_layout(device: wgpu.GPUDevice) -> wgpu.GPUBindGroupLayout:
    """Bind group 1."""
    fragment = wgpu.ShaderStage.FRAGMENT

    def texture(binding: int, dimension: str) -> dict:
        sampled = {"sample_type": "float", "view_dimension": dimension}
        return {"binding": binding, "visibility": fragment, "texture": sampled}

    def sampler(binding: int) -> dict:
        return {"binding": binding, "visibility": fragment, "sampler": {"type": "filtering"}}

    return device.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": fragment, "buffer": {"type": "uniform"}},
            *(texture(binding, "2d") for binding in (1, 2, 3, 4)),
            sampler(5),
            sampler(6),
            texture(7, "cube-array"),
            texture(8, "cube-array"),
            sampler(9),
            texture(10, "2d-array"),
            texture(11, "2d-array"),
            texture(12, "cube-array"),
            texture(13, "2d-array"),
        ]
    )
