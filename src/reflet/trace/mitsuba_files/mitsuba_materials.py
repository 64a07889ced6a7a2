"""Mitsuba's BSDFs and area lights as metallic-roughness materials."""

import warnings
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import Material, Texture, Vec3
from reflet.trace.mitsuba_files.mitsuba_nodes import Node

PROCEDURAL_SIZE = 256  # pixels along each edge of a texture that has no pixels of its own
READABLE = "diffuse, twosided, conductor, roughconductor, plastic, roughplastic, principled, dielectric"
Colour = tuple[Vec3, Texture | None]


def material_of(shape: Node, name: str, textured: bool) -> Material:
    """The material of a shape: its BSDF, and the radiance of its area light.

    Textures of shapes without texture coordinates (not ``textured``) are replaced by their mean. Raises RefletError for
    BSDFs that have no counterpart.
    """
    bsdf = shape.child("bsdf") or Node("bsdf", "diffuse", "", {})
    double_sided = bsdf.plugin == "twosided"
    if double_sided:
        inner = bsdf.child("bsdf")
        if inner is None:
            raise RefletError(f"The twosided BSDF of {name} holds no other; put one into it.")
        bsdf = inner
    fields = _surface(bsdf, name, textured)
    light = shape.child("emitter")
    if light is not None:
        radiance, picture = _colour(light, "radiance", 1.0, textured, unbounded=True)
        fields |= {"emission": radiance, "emission_texture_srgb": picture}
    return Material(name=bsdf.id or name, **({"double_sided": double_sided} | fields))


def _surface(bsdf: Node, name: str, textured: bool) -> dict[str, Any]:
    match bsdf.plugin:
        case "diffuse":
            color, picture = _colour(bsdf, "reflectance", 0.5, textured)
            return {
                "base_color": color,
                "base_color_texture_srgb": picture,
                "metallic": 0.0,
                "perceptual_roughness": 1.0,
            }
        case "conductor" | "roughconductor":
            roughness = np.sqrt(_number(bsdf, "alpha", 0.1)) if bsdf.plugin == "roughconductor" else 0.0
            warnings.warn(
                f"Conductor {bsdf.id or name} reflects by Schlick's approximation from its reflectance at normal "
                "incidence, brighter at grazing angles than Mitsuba's.",
                RefletWarning,
                stacklevel=5,
            )
            return {
                "base_color": _facing_reflectance(bsdf),
                "metallic": 1.0,
                "perceptual_roughness": float(roughness),
            }
        case "plastic" | "roughplastic":
            color, picture = _colour(bsdf, "diffuse_reflectance", 0.5, textured)
            roughness = np.sqrt(_number(bsdf, "alpha", 0.1)) if bsdf.plugin == "roughplastic" else 0.0
            return {
                "base_color": color,
                "base_color_texture_srgb": picture,
                "metallic": 0.0,
                "perceptual_roughness": float(roughness),
            }
        case "principled":
            color, picture = _colour(bsdf, "base_color", 0.5, textured)
            return {
                "base_color": color,
                "base_color_texture_srgb": picture,
                "metallic": _number(bsdf, "metallic", 0.0),
                "perceptual_roughness": _number(bsdf, "roughness", 0.5),
            }
        case "dielectric" | "thindielectric" | "roughdielectric":
            warnings.warn(f"{name} is of glass and becomes opaque and black.", RefletWarning, stacklevel=5)
            return {
                "base_color": (0.0, 0.0, 0.0),
                "metallic": 0.0,
                "perceptual_roughness": 0.0,
                "double_sided": True,
            }
    raise RefletError(f"The BSDF {bsdf.plugin} of {name} has no counterpart; those that can be read are {READABLE}.")


def _facing_reflectance(bsdf: Node) -> Vec3:
    """A conductor's reflectance at normal incidence, its tint included, as Mitsuba's smooth one has it."""
    kept = ("material", "eta", "k", "specular_reflectance")
    values = {key: value for key, value in bsdf.values.items() if key in kept}
    children = {key: child for key, child in bsdf.children.items() if key in kept}
    smooth = mi.load_dict(Node("bsdf", "conductor", "", values, children).described())
    facing: Any = dr.zeros(mi.SurfaceInteraction3f)
    facing.wi = mi.Vector3f(0.0, 0.0, 1.0)
    facing.sh_frame = mi.Frame3f(mi.Vector3f(0.0, 0.0, 1.0))
    _, weight = smooth.sample(mi.BSDFContext(), facing, mi.Float(0.5), mi.Point2f(0.5))
    red, green, blue = (float(channel.numpy()[0]) for channel in weight)
    return red, green, blue


def _number(node: Node, key: str, default: float) -> float:
    """A scalar parameter, or the mean of its texture."""
    return float(np.mean(_evaluated(node, key, default)))


def _colour(node: Node, key: str, default: float, textured: bool, unbounded: bool = False) -> Colour:
    """A colour as constant factor and sRGB picture; the factor is 1 unless the picture is brighter (``unbounded``)."""
    linear = _evaluated(node, key, default)
    mean = linear.reshape(-1, 3).mean(0)
    if linear.shape[:2] == (1, 1) or not textured:
        return (float(mean[0]), float(mean[1]), float(mean[2])), None
    brightest = float(linear.max()) if unbounded else 1.0
    linear = np.clip(linear / max(brightest, 1e-9), 0.0, 1.0)
    code = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    pixels = np.full((*linear.shape[:2], 4), 255, np.uint8)
    pixels[..., :3] = np.round(code * 255.0)
    clamp = node.children[key].values.get("wrap_mode") == "clamp"
    return (brightest, brightest, brightest), Texture(pixels, clamp)


def _evaluated(node: Node, key: str, default: float) -> np.ndarray:
    """Linear values (height, width, 3) of a parameter: one pixel, or a texture's at its own pixels' centres."""
    described: Any = node.children[key].described() if key in node.children else node.values.get(key, default)
    if isinstance(described, int | float):
        return np.full((1, 1, 3), float(described))
    if isinstance(described, dict) and described["type"] == "rgb":
        return np.asarray(described["value"], np.float64).reshape(1, 1, 3)
    texture = mi.load_dict(described)
    width = height = 1
    if key in node.children and texture.is_spatially_varying():
        width, height = (max(int(size), 1) for size in texture.resolution())
        if width == height == 1:
            width = height = PROCEDURAL_SIZE
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    at: Any = dr.zeros(mi.SurfaceInteraction3f, width * height)
    at.uv = mi.Point2f(np.stack([u.ravel(), v.ravel()]).astype(np.float32))
    channels = [np.broadcast_to(channel.numpy(), width * height) for channel in texture.eval(at)]
    return np.stack(channels, -1).astype(np.float64).reshape(height, width, 3)
