"""Mitsuba's BSDFs and area lights as metallic-roughness materials."""

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.scene.material import Material, Refraction, Vec3
from reflet.trace.mitsuba_files.mitsuba_doubts import Doubts
from reflet.trace.mitsuba_files.mitsuba_nodes import Node
from reflet.trace.mitsuba_files.mitsuba_textures import Color, Values

READABLE = (
    "diffuse, twosided, conductor, roughconductor, plastic, roughplastic, principled, principledthin, dielectric, "
    "thindielectric, roughdielectric, mask, blendbsdf, bumpmap, normalmap, null"
)
_BLACK: dict[str, Any] = {"base_color": (0.0, 0.0, 0.0), "metallic": 0.0, "perceptual_roughness": 1.0}
_NOTHING = 1e-3  # opacity of what is not there


@dataclass(frozen=True)
class ShapeMaterial:
    """A shape's material, and how its textures lie on the mesh: texture coordinates = ``texture_from_mesh`` · uv."""

    material: Material
    texture_from_mesh: Float[np.ndarray, "3 3"] | None = None


def material_of(shape: Node, name: str, textured: bool, doubts: Doubts) -> ShapeMaterial | None:
    """The material of a shape: its BSDF, and the radiance of its area light; None if it cannot be seen.

    Textures of shapes without texture coordinates (not ``textured``) are replaced by their mean. What looks other than
    in Mitsuba goes into ``doubts``. Raises RefletError for BSDFs that have no counterpart.
    """
    values = Values(name, textured, doubts)
    bsdf, double_sided = _bare(shape.child("bsdf") or Node("bsdf", "diffuse", "", {}), values)
    light = shape.child("emitter")
    if bsdf is None and light is None:
        return None
    fields = dict(_BLACK) if bsdf is None else _surface(bsdf, values)
    colors = [fields.pop("color")] if "color" in fields else []
    if colors:
        fields |= {"base_color": colors[0].factor, "base_color_texture_srgb": colors[0].picture}
    if light is not None:
        colors.append(values.color(light, "radiance", 1.0, unbounded=True))
        fields |= {"emission": colors[-1].factor, "emission_texture_srgb": colors[-1].picture}
    own = bsdf.id if bsdf is not None else ""
    material = Material(name=own or name, **({"double_sided": double_sided} | fields))
    return ShapeMaterial(material, _placement([color for color in colors if color.picture], values))


def _bare(bsdf: Node, values: Values) -> tuple[Node | None, bool]:
    """What is inside of BSDFs that hold others, None where it lets all light through; and whether it has two sides."""
    double_sided = False
    while True:
        inner = bsdf.of_kind("bsdf")
        if bsdf.plugin == "null":
            return None, double_sided
        if bsdf.plugin not in ("twosided", "mask", "bumpmap", "normalmap", "blendbsdf"):
            return bsdf, double_sided
        if len(inner) < (2 if bsdf.plugin == "blendbsdf" else 1):
            raise RefletError(f"The BSDF {bsdf.plugin} of {values.name} holds too few others; put them into it.")
        chosen = inner[0]
        match bsdf.plugin:
            case "twosided":
                double_sided = True
                if len(inner) > 1:
                    values.doubts.add("Both sides are shown as the front is", values.name)
            case "mask":
                opacity = values.number(bsdf, "opacity", 0.5)
                if opacity < _NOTHING:
                    return None, double_sided
                if opacity < 1.0 - _NOTHING:
                    values.doubts.add("Partly transparent shapes are shown opaque", values.name)
            case "blendbsdf":
                chosen = inner[values.number(bsdf, "weight", 0.5) > 0.5]
                values.doubts.add("Of two blended materials the heavier one is shown alone", values.name)
            case _:
                values.doubts.add("Bump and normal maps are left out", values.name)
        bsdf = chosen


def _surface(bsdf: Node, values: Values) -> dict[str, Any]:
    """Fields of the material; ``color`` stands for base colour and its texture."""
    match bsdf.plugin:
        case "diffuse":
            return {"color": values.color(bsdf, "reflectance", 0.5), "metallic": 0.0, "perceptual_roughness": 1.0}
        case "conductor" | "roughconductor":
            roughness = _roughness(bsdf, values) if bsdf.plugin == "roughconductor" else 0.0
            return {"color": _metal(bsdf, values), "metallic": 1.0, "perceptual_roughness": roughness}
        case "plastic" | "roughplastic":
            roughness = _roughness(bsdf, values) if bsdf.plugin == "roughplastic" else 0.0
            color = values.color(bsdf, "diffuse_reflectance", 0.5)
            return {"color": color, "metallic": 0.0, "perceptual_roughness": roughness}
        case "principled" | "principledthin":
            _doubt_principled(bsdf, values)
            return {
                "color": values.color(bsdf, "base_color", 0.5),
                "metallic": values.number(bsdf, "metallic", 0.0) if bsdf.plugin == "principled" else 0.0,
                "perceptual_roughness": values.number(bsdf, "roughness", 0.5),
            }
        case "dielectric" | "thindielectric" | "roughdielectric":
            return _glass(bsdf, values)
    raise RefletError(
        f"The BSDF {bsdf.plugin} of {values.name} has no counterpart; put one of these in its place: {READABLE}."
    )


def _roughness(bsdf: Node, values: Values) -> float:
    """The perceptual roughness of Mitsuba's alpha; of two alphas, that of their mean."""
    along = {"alpha_u", "alpha_v"} & ({*bsdf.values} | {*bsdf.children})
    alphas = [values.number(bsdf, key, 0.1) for key in sorted(along) or ["alpha"]]
    if len(set(alphas)) > 1:
        values.doubts.add("Brushed metals are shown as rough along as across", values.name)
    return max(sum(alphas) / len(alphas), 0.0) ** 0.5


def _glass(bsdf: Node, values: Values) -> dict[str, Any]:
    indices = {key: value for key, value in bsdf.values.items() if key in ("int_ior", "ext_ior")}
    smooth = Node("bsdf", "dielectric", "", indices).built(f"the glass of {values.name}")
    if values.color(bsdf, "specular_reflectance", 1.0) != Color((1.0, 1.0, 1.0)):
        values.doubts.add("Glass reflects as much as its index of refraction says", values.name)
    return {
        "color": values.color(bsdf, "specular_transmittance", 1.0),
        "metallic": 0.0,
        "perceptual_roughness": _roughness(bsdf, values) if bsdf.plugin == "roughdielectric" else 0.0,
        "refraction": Refraction(index=float(mi.traverse(smooth)["eta"]), thin=bsdf.plugin == "thindielectric"),
    }


def _doubt_principled(bsdf: Node, values: Values) -> None:
    for key, what in (
        ("spec_trans", "Glass of principled materials becomes opaque"),
        ("clearcoat", "Clear coats of principled materials are left out"),
        ("sheen", "The sheen of principled materials is left out"),
    ):
        if (key in bsdf.values or key in bsdf.children) and values.number(bsdf, key, 0.0) > 0.0:
            values.doubts.add(what, values.name)


def _metal(bsdf: Node, values: Values) -> Color:
    """A conductor's reflectance at normal incidence, as Mitsuba's smooth one has it, times its tint."""
    kept = ("material", "eta", "k")
    if bsdf.values.get("material") == "none":
        facing: Vec3 = (1.0, 1.0, 1.0)
    else:
        described = {key: value for key, value in bsdf.values.items() if key in kept}
        children = {key: child for key, child in bsdf.children.items() if key in kept}
        smooth = Node("bsdf", "conductor", "", described, children).built(f"the conductor of {values.name}")
        at: Any = dr.zeros(mi.SurfaceInteraction3f)
        at.wi = mi.Vector3f(0.0, 0.0, 1.0)
        at.sh_frame = mi.Frame3f(mi.Vector3f(0.0, 0.0, 1.0))
        _, weight = smooth.sample(mi.BSDFContext(), at, mi.Float(0.5), mi.Point2f(0.5))
        red, green, blue = (float(channel.numpy()[0]) for channel in weight)
        facing = (red, green, blue)
        values.doubts.add(
            "Conductors reflect by Schlick's approximation from their reflectance at normal incidence, other than "
            "Mitsuba's at grazing angles",
            values.name,
        )
    tint = values.color(bsdf, "specular_reflectance", 1.0)
    r, g, b = (a * t for a, t in zip(facing, tint.factor, strict=True))
    return replace(tint, factor=(r, g, b))


def _placement(colors: list[Color], values: Values) -> Float[np.ndarray, "3 3"] | None:
    """How the first texture lies; all of a mesh's lie like it."""
    if not colors:
        return None
    first, *others = (np.eye(3) if color.texture_from_mesh is None else color.texture_from_mesh for color in colors)
    if any(not np.allclose(first, other) for other in others):
        values.doubts.add(
            "Textures of one shape that are placed differently are all placed like the first", values.name
        )
    return None if np.array_equal(first, np.eye(3)) else first
