"""What Mitsuba's BSDFs reflect and let through, as fields of metallic-roughness materials."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.errors import RefletError
from reflet.scene.material import Refraction, Vec3
from reflet.trace.mitsuba_files.mitsuba_nodes import Node
from reflet.trace.mitsuba_files.mitsuba_textures import Amount, Color, Values

READABLE = (
    "diffuse, twosided, conductor, roughconductor, plastic, roughplastic, principled, principledthin, dielectric, "
    "thindielectric, roughdielectric, mask, blendbsdf, bumpmap, normalmap, null"
)
BRUSHED = "Brushed surfaces are shown as rough along as across"
_SMOOTH, _NO_METAL = Amount(0.0), Amount(0.0)
_ANGLES = 512  # of light that a surface's inside reflects


@dataclass(frozen=True)
class Reflection:
    """A surface: colour, perceptual roughness and metal, each with its texture, and other fields of the material."""

    color: Color
    roughness: Amount
    metallic: Amount
    others: dict[str, Any] = field(default_factory=dict)


BLACK = Reflection(Color((0.0, 0.0, 0.0)), Amount(1.0), _NO_METAL, {"specular": 0.0})
"""What neither reflects nor lets through."""


def reflection_of(bsdf: Node, values: Values) -> Reflection:
    """Of a BSDF that holds no others. Raises RefletError where it has no counterpart."""
    match bsdf.plugin:
        case "diffuse":
            return replace(BLACK, color=values.color(bsdf, "reflectance", 0.5))
        case "conductor" | "roughconductor":
            return Reflection(_metal(bsdf, values), _roughness(bsdf, values), Amount(1.0))
        case "plastic" | "roughplastic":
            return _plastic(bsdf, values)
        case "principled" | "principledthin":
            return _principled(bsdf, values)
        case "dielectric" | "thindielectric" | "roughdielectric":
            return _glass(bsdf, values)
    raise RefletError(
        f"The BSDF {bsdf.plugin} of {values.name} has no counterpart; put one of these in its place: {READABLE}."
    )


def _roughness(bsdf: Node, values: Values) -> Amount:
    """The perceptual roughness of Mitsuba's alpha; of two alphas, that of their mean. None of smooth BSDFs."""
    if not bsdf.plugin.startswith("rough"):
        return _SMOOTH
    if bsdf.values.get("distribution", "beckmann") != "ggx" and bsdf.plugin != "roughdielectric":
        values.doubts.add("Beckmann's microfacets are shown as GGX's, whose highlights have longer tails", values.name)
    along = {"alpha_u", "alpha_v"} & ({*bsdf.values} | {*bsdf.children})
    alphas = [values.amount(bsdf, key, 0.1) for key in sorted(along) or ["alpha"]]
    if len(alphas) == 1:
        return alphas[0].turned_by(np.sqrt)
    if all(alpha.picture is None for alpha in alphas) and alphas[0].mean == alphas[1].mean:
        return alphas[0].turned_by(np.sqrt)
    values.doubts.add(BRUSHED, values.name)
    return Amount(((alphas[0].mean + alphas[1].mean) / 2.0) ** 0.5)


def _plastic(bsdf: Node, values: Values) -> Reflection:
    """A dielectric over diffuse. Light that its inside throws back onto the pigment is coloured once more if
    ``nonlinear`` [Mitsuba's plastic]: of constant light, base colour is what then leaves of what gets in."""
    index = _index(bsdf, "plastic", values)
    turn: Callable[[Any], Any] = partial(_often_coloured, kept=_kept_inside(index))
    color = values.color(bsdf, "diffuse_reflectance", 0.5, function=turn if bsdf.values.get("nonlinear") else _same)
    others = {"ior": max(index, 1.0 / index)} | _specular(bsdf, values)
    return Reflection(color, _roughness(bsdf, values), _NO_METAL, others)


def _same(linear: Any) -> Any:
    return linear


def _often_coloured(linear: Any, kept: float) -> Any:
    return linear * (1.0 - kept) / (1.0 - linear * kept)


def _kept_inside(index: float) -> float:
    """The share of diffuse light from the inside that a surface of this index reflects."""
    cosine = (np.arange(_ANGLES, dtype=np.float32) + 0.5) / _ANGLES
    reflected = np.array(mi.fresnel(mi.Float(cosine), mi.Float(1.0 / index))[0], np.float64)
    return float((2.0 * cosine * reflected).mean())


def _specular(bsdf: Node, values: Values) -> dict[str, Any]:
    """``specular_reflectance``, by which the whole reflection is multiplied."""
    tint = values.color(bsdf, "specular_reflectance", 1.0)
    if tint.picture is not None:
        values.doubts.add("Textures of specular_reflectance count as their mean", values.name)
        tint = Values(values.name, False, values.doubts).color(bsdf, "specular_reflectance", 1.0)
    most = min(max(tint.factor), 1.0)
    if most <= 0.0 or tint.factor == (most, most, most):
        return {"specular": most}
    values.doubts.add("Coloured reflections of plastics are white along the surface", values.name)
    r, g, b = (channel / most for channel in tint.factor)
    return {"specular": most, "specular_color": (r, g, b)}


def _index(bsdf: Node, plugin: str, values: Values) -> float:
    """The index of refraction of the inside over that of the outside, by numbers or by names of materials."""
    indices = {key: value for key, value in bsdf.values.items() if key in ("int_ior", "ext_ior")}
    smooth = Node("bsdf", plugin, "", indices).built(f"the {bsdf.plugin} of {values.name}")
    return float(mi.traverse(smooth)["eta"])


def _glass(bsdf: Node, values: Values) -> Reflection:
    if values.color(bsdf, "specular_reflectance", 1.0) != Color((1.0, 1.0, 1.0)):
        values.doubts.add("Glass reflects as much as its index of refraction says", values.name)
    glass = Refraction(index=_index(bsdf, "dielectric", values), thin=bsdf.plugin == "thindielectric")
    tint = values.color(bsdf, "specular_transmittance", 1.0)
    return Reflection(tint, _roughness(bsdf, values), _NO_METAL, {"refraction": glass})


def _metal(bsdf: Node, values: Values) -> Color:
    """A conductor's reflectance at normal incidence, as Mitsuba's smooth one has it, times its tint."""
    kept = ("material", "eta", "k")
    described = {key: value for key, value in bsdf.values.items() if key in kept}
    children = {key: child for key, child in bsdf.children.items() if key in kept}
    facing: Vec3 = (1.0, 1.0, 1.0)
    if (described or children) and described.get("material") != "none":
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


# -- principled --------------------------------------------------------------------------------------------------------


def _principled(bsdf: Node, values: Values) -> Reflection:
    thin = bsdf.plugin == "principledthin"
    for key, what in (
        ("sheen", "The sheen of principled materials is left out"),
        ("anisotropic", BRUSHED),
        ("flatness", "The flatness of principled materials is left out"),
        ("diff_trans", "Diffuse light that shines through thin sheets is left out"),
    ):
        if _says(bsdf, key) and values.number(bsdf, key, 0.0) > 0.0:
            values.doubts.add(what, values.name)
    metallic = _NO_METAL if thin else values.amount(bsdf, "metallic", 0.0)
    roughness, index = values.amount(bsdf, "roughness", 0.5), _principled_index(bsdf, values)
    through = values.number(bsdf, "spec_trans", 0.0) if _says(bsdf, "spec_trans") else 0.0
    if through >= 0.5 and metallic.mean < 0.5:
        if through < 1.0:
            values.doubts.add(
                "Principled materials of which some is glass are clear, and diffuse for the rest", values.name
            )
        # light is coloured wherever it enters or leaves a solid, and once by a sheet
        tint = values.color(bsdf, "base_color", 0.5, function=_same if thin else np.sqrt)
        glass = Refraction(index=index, transmission=min(through, 1.0), thin=thin)
        return Reflection(tint, roughness, _NO_METAL, {"refraction": glass})
    if through > 0.0 and metallic.mean < 1.0:
        values.doubts.add("Principled materials that are glass for less than a half are shown opaque", values.name)
    if metallic.mean < 1.0:
        values.doubts.add(
            "Diffuse light of principled materials is Lambert's beneath what reflects, other than Mitsuba's at grazing "
            "angles",
            values.name,
        )
    others = {"ior": max(index, 1.0 / index)} | _tint(bsdf, values) | _coat(bsdf, values)
    return Reflection(
        values.color(bsdf, "base_color", 0.5), roughness, metallic, others | ({"double_sided": True} if thin else {})
    )


def _principled_index(bsdf: Node, values: Values) -> float:
    """By ``eta``, or by ``specular``, which is the reflectance at normal incidence over 0.08."""
    if _says(bsdf, "eta") or bsdf.plugin == "principledthin":
        return max(values.number(bsdf, "eta", 1.5), 1e-3)
    facing = min(max(0.08 * values.number(bsdf, "specular", 0.5), 0.0), 0.99) ** 0.5
    return (1.0 + facing) / (1.0 - facing)


def _tint(bsdf: Node, values: Values) -> dict[str, Any]:
    """``spec_tint``: what of the reflection has the base colour's hue, as of luminance 1."""
    share = min(max(values.number(bsdf, "spec_tint", 0.0), 0.0), 1.0)
    mean = np.array(Values(values.name, False, values.doubts).color(bsdf, "base_color", 0.5).factor)
    luminance = float(mean @ np.array([0.212671, 0.715160, 0.072169]))
    if share == 0.0 or luminance <= 0.0:
        return {}
    r, g, b = (1.0 - share + share * mean / luminance).tolist()
    return {"specular_color": (r, g, b)}


def _coat(bsdf: Node, values: Values) -> dict[str, Any]:
    """The clear coat, whose microfacets are GTR1's; of GGX as bright in its middle."""
    share = values.number(bsdf, "clearcoat", 0.0)
    if share <= 0.0:
        return {}
    values.doubts.add("Clear coats have GGX's highlights, as bright in their middle as Mitsuba's", values.name)
    narrow = 0.1 + (0.001 - 0.1) * min(max(values.number(bsdf, "clearcoat_gloss", 0.0), 0.0), 1.0)
    alpha = (narrow**2 * np.log(narrow**-2) / (1.0 - narrow**2)) ** 0.5
    return {"clearcoat": min(share, 1.0), "clearcoat_roughness": float(alpha**0.5)}


def _says(bsdf: Node, key: str) -> bool:
    return key in bsdf.values or key in bsdf.children
