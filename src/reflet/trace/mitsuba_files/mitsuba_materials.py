"""Mitsuba's BSDFs and area lights as metallic-roughness materials."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8

from reflet.errors import RefletError
from reflet.scene.material import Material, Texture
from reflet.scene.readers.packed import resized, roughness_and_metal
from reflet.trace.mitsuba_files.mitsuba_doubts import Doubts
from reflet.trace.mitsuba_files.mitsuba_nodes import Node
from reflet.trace.mitsuba_files.mitsuba_reflection import BLACK, Reflection, reflection_of
from reflet.trace.mitsuba_files.mitsuba_textures import Amount, Color, NormalMap, Values

_NOTHING = 1e-3  # opacity of what is not there


@dataclass(frozen=True)
class ShapeMaterial:
    """A shape's material, and how its textures lie on the mesh: texture coordinates = ``texture_from_mesh`` · uv."""

    material: Material
    texture_from_mesh: Float[np.ndarray, "3 3"] | None = None


@dataclass(frozen=True)
class _Inside:
    """What BSDFs that hold others hold: None where it lets all light through."""

    bsdf: Node | None
    double_sided: bool
    opacity: Amount
    normals: NormalMap | None = None


def material_of(shape: Node, name: str, textured: bool, doubts: Doubts) -> ShapeMaterial | None:
    """The material of a shape: its BSDF, and the radiance of its area light; None if it cannot be seen.

    Textures of shapes without texture coordinates (not ``textured``) are replaced by their mean. What looks other than
    in Mitsuba goes into ``doubts``. Raises RefletError for BSDFs that have no counterpart.
    """
    values = Values(name, textured, doubts)
    inside = _inside(shape.child("bsdf") or Node("bsdf", "diffuse", "", {}), values)
    light = shape.child("emitter")
    if inside.bsdf is None and light is None:
        return None
    surface = BLACK if inside.bsdf is None else reflection_of(inside.bsdf, values)
    laid: list[Color | Amount | NormalMap] = [surface.color, surface.roughness, surface.metallic, inside.opacity]
    fields: dict[str, Any] = {"double_sided": inside.double_sided} | _mapped(surface) | surface.others
    fields |= _with_opacity(surface.color, Amount(1.0) if inside.bsdf is None else inside.opacity)
    if inside.normals is not None and inside.bsdf is not None:
        laid.append(inside.normals)
        fields["normal_texture"] = inside.normals.picture
    if light is not None:
        radiance = values.color(light, "radiance", 1.0, unbounded=True)
        laid.append(radiance)
        fields |= {"emission": radiance.factor, "emission_texture_srgb": radiance.picture}
    own = inside.bsdf.id if inside.bsdf is not None else ""
    material = Material(name=own or name, **fields)
    return ShapeMaterial(material, _placement([each for each in laid if each.picture is not None], values))


def _inside(bsdf: Node, values: Values) -> _Inside:
    double_sided, opacity, normals = False, Amount(1.0), None
    while bsdf.plugin in ("twosided", "mask", "bumpmap", "normalmap", "blendbsdf"):
        inner = bsdf.of_kind("bsdf")
        if len(inner) < (2 if bsdf.plugin == "blendbsdf" else 1):
            raise RefletError(f"The BSDF {bsdf.plugin} of {values.name} holds too few others; put them into it.")
        chosen = inner[0]
        match bsdf.plugin:
            case "twosided":
                double_sided = True
                if len(inner) > 1:
                    values.doubts.add("Both sides are shown as the front is", values.name)
            case "mask":
                opacity = _times(opacity, values.amount(bsdf, "opacity", 0.5), values)
            case "blendbsdf":
                weight = values.amount(bsdf, "weight", 0.5)
                chosen = inner[weight.mean > 0.5]
                if "null" in (inner[0].plugin, inner[1].plugin):
                    chosen = inner[inner[0].plugin == "null"]
                    share = weight if chosen is inner[1] else weight.turned_by(_complement)
                    opacity = _times(opacity, share, values)
                elif _NOTHING < weight.mean < 1.0 - _NOTHING:
                    values.doubts.add("Of two blended materials the heavier one is shown alone", values.name)
            case "normalmap":
                normals = normals or values.normals(bsdf)
            case _:
                values.doubts.add("Bump maps are left out", values.name)
        bsdf = chosen
    hidden = bsdf.plugin == "null" or opacity.mean < _NOTHING
    return _Inside(None if hidden else bsdf, double_sided, opacity, normals)


def _complement(share: Any) -> Any:
    return 1.0 - share


def _times(opacity: Amount, other: Amount, values: Values) -> Amount:
    """Of two pictures the second counts as its mean."""
    if opacity.picture is not None and other.picture is not None:
        values.doubts.add("Of masks within masks the inner one's texture counts as its mean", values.name)
    textured, factor = (opacity, other.mean) if opacity.picture is not None else (other, opacity.mean)
    return textured.turned_by(lambda share: share * factor)


def _mapped(surface: Reflection) -> dict[str, Any]:
    """Roughness and metal: factors, or 1 beside the texture that holds them."""
    amounts = {"perceptual_roughness": surface.roughness, "metallic": surface.metallic}
    fields: dict[str, Any] = {key: amount.mean if amount.picture is None else 1.0 for key, amount in amounts.items()}
    pictured = [amount for amount in amounts.values() if amount.picture is not None]
    if pictured:
        packed = roughness_and_metal(*(_codes(amount) for amount in amounts.values()))
        fields["metallic_roughness_texture"] = Texture(packed, pictured[0].wraps)
    return fields


def _codes(amount: Amount) -> UInt8[np.ndarray, "height width"] | None:
    return None if amount.picture is None else np.round(amount.picture * 255.0).astype(np.uint8)


def _with_opacity(color: Color, opacity: Amount) -> dict[str, Any]:
    """Base colour and alpha: of what is either there or not a mask, else a blend."""
    fields: dict[str, Any] = {"base_color": color.factor, "base_color_texture_srgb": color.picture}
    codes = _codes(opacity)
    if codes is None:
        return fields | ({"alpha": opacity.mean, "alpha_mode": "blend"} if opacity.mean < 1.0 - _NOTHING else {})
    pixels = np.full((1, 1, 4), 255, np.uint8) if color.picture is None else color.picture.pixels
    size = max(pixels.shape[0], codes.shape[0]), max(pixels.shape[1], codes.shape[1])
    pixels = np.dstack([*(resized(pixels[..., k], size) for k in range(3)), resized(codes, size)])
    wraps = opacity.wraps if color.picture is None else color.picture.wraps
    either = bool(np.isin(codes, (0, 255)).all())
    return fields | {"base_color_texture_srgb": Texture(pixels, wraps), "alpha_mode": "mask" if either else "blend"}


def _placement(laid: list[Color | Amount | NormalMap], values: Values) -> Float[np.ndarray, "3 3"] | None:
    """How the first texture lies; all of a mesh's lie like it."""
    if not laid:
        return None
    first, *others = (np.eye(3) if each.texture_from_mesh is None else each.texture_from_mesh for each in laid)
    if any(not np.allclose(first, other) for other in others):
        values.doubts.add(
            "Textures of one shape that are placed differently are all placed like the first", values.name
        )
    return None if np.array_equal(first, np.eye(3)) else first
