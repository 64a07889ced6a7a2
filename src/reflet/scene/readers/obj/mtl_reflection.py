"""How the materials of a .mtl file reflect, and what of the light they let through."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import UInt8

from reflet.files.srgb import linear_from_srgb
from reflet.scene.material import Material, Refraction, Texture, Vec3
from reflet.scene.readers.obj.mtl_textures import channel_of, parse_texture
from reflet.scene.readers.obj.mtl_values import WHITE, MtlValues
from reflet.scene.readers.packed import resized, roughness_and_metal

_PLAIN_SPECULAR = 0.5  # Ks of what reflects as its index says
_OF_PBR = ("pr", "pm", "pc", "ps", "map_pr", "map_pm", "map_orm", "map_rma")


def surface_fields(values: MtlValues) -> dict[str, Any]:
    """Roughness and metal, their texture, index and specular."""
    packed, has_roughness, has_metal = _packed(values)
    model = _model(values)
    roughness = values.share("pr")
    if roughness is None and not has_roughness and values.has("ns"):
        # the lobe of a Phong exponent N has alpha² = 2/(N + 2), and alpha is the square of what artists set
        roughness = (2.0 / (max(values.number("ns") or 0.0, 0.0) + 2.0)) ** 0.25
    mirrors = model in (3, 5, 6, 7, 8)
    index = values.number("ni")
    if index is not None and index < 1.0:
        values.note("Ni below 1 is taken as 1.5")
    # tools write 1 for whatever is not glass
    fields: dict[str, Any] = {"ior": index} if index is not None and index > 1.0 else {}
    return fields | _specular(values, model, fields.get("ior", 1.5)) | {
        "metallic": values.factor(values.share("pm"), float(has_metal), has_metal),
        "perceptual_roughness": values.factor(roughness, 0.0 if mirrors and not has_roughness else 1.0, has_roughness),
        "metallic_roughness_texture": packed,
    }  # fmt: skip


def _model(values: MtlValues) -> int:
    """The illumination model; 2, highlights, where physical materials are described or none is given."""
    given = values.number("illum")
    if given is None or values.has(*_OF_PBR):
        return 2
    if given == 0.0:
        values.note("illum 0, colour without light, is taken as illum 1")
    return int(given)


def _specular(values: MtlValues, model: int, index: float) -> dict[str, Any]:
    """Ks as Blender means it, 0.5 of what reflects as its index says; in models that mirror without Fresnel's law it is
    the reflectance along the normal itself."""
    if model in (0, 1):
        return {"specular": 0.0}
    tint = values.color("ks", 1.0)
    picture = values.picture("map_ks")
    if picture is not None:
        values.note("map_Ks counts as its mean")
        code = picture[0][..., :3].astype(np.float64) / 255.0
        mean = linear_from_srgb(code).mean((0, 1))
        given = values.factor(tint, WHITE, True)
        tint = float(given[0] * mean[0]), float(given[1] * mean[1]), float(given[2] * mean[2])
    if tint is None:
        return {}
    unit = ((index - 1.0) / (index + 1.0)) ** 2 if model in (3, 8) else _PLAIN_SPECULAR
    red, green, blue = (channel / unit for channel in tint)
    most = max(red, green, blue)
    if model in (3, 8) and most > 0.0:
        return {"specular_color": (red, green, blue)}
    share = min(most, 1.0)
    if share == 0.0:
        return {"specular": 0.0}
    return {"specular": share, "specular_color": (red / share, green / share, blue / share)}


def _packed(values: MtlValues) -> tuple[Texture | None, bool, bool]:
    """glTF's metallic-roughness texture, and whether it holds a roughness and whether it says what is metallic."""
    lines = values.lines
    both = values.has("map_pr") and values.has("map_pm")
    one = both and parse_texture(lines["map_pr"].value).name == parse_texture(lines["map_pm"].value).name
    # a coloured picture that is roughness and metal is packed as glTF's
    roughness = values.plane({"map_pr": "g" if one else "", "map_orm": "g", "map_rma": "r"})
    metallic = values.plane({"map_pm": "b" if one else "", "map_orm": "b", "map_rma": "g"})
    if roughness is None and metallic is None:
        return None, False, False
    texture = Texture(roughness_and_metal(roughness, metallic), values.placed[-1].wraps)
    return texture, roughness is not None, metallic is not None


def coat_fields(values: MtlValues) -> dict[str, Any]:
    """The clear coat of Pc and Pcr and their textures."""
    share, roughness = _grey(values, "map_pc"), _grey(values, "map_pcr")
    return {
        "clearcoat": values.factor(values.share("pc"), float(share is not None), share is not None),
        "clearcoat_texture": share,
        "clearcoat_roughness": values.factor(values.share("pcr"), float(roughness is not None), roughness is not None),
        "clearcoat_roughness_texture": roughness,
    }


def _grey(values: MtlValues, word: str) -> Texture | None:
    plane = values.plane({word: ""})
    if plane is None:
        return None
    return Texture(np.dstack([plane, plane, plane, np.full_like(plane, 255)]), values.placed[-1].wraps)


def with_transparency(material: Material, values: MtlValues) -> Material:
    """``material`` as glass (illum 6 and 7 with an index), or with the alpha of d, Tr, map_d and map_Tr."""
    index = values.number("ni") or 1.0
    if _model(values) in (6, 7) and index > 1.0:
        tint: Vec3 = values.color("tf", 1.0) or WHITE
        return replace(material, base_color=tint, base_color_texture_srgb=None, refraction=Refraction(index=index))
    base = None if material.base_color_texture_srgb is None else material.base_color_texture_srgb
    opacity = values.share("d")
    if opacity is None and (through := values.share("tr")) is not None:
        opacity = 1.0 - through
    shares = _opacity_picture(values)
    if opacity == 0.0:
        values.note("what d or Tr would hide altogether is shown")
        opacity = 1.0
    opacity = 1.0 if opacity is None else opacity
    if shares is not None and (shares < 255).any():
        pixels = np.full((1, 1, 4), 255, np.uint8) if base is None else base.pixels
        size = max(pixels.shape[0], shares.shape[0]), max(pixels.shape[1], shares.shape[1])
        pixels = np.dstack([*(resized(pixels[..., k], size) for k in range(3)), resized(shares, size)])
        wraps = values.placed[-1].wraps if base is None else base.wraps
        material = replace(material, base_color_texture_srgb=Texture(pixels, wraps))
        if opacity == 1.0 and np.isin(shares, (0, 255)).all():
            return replace(material, alpha_mode="mask")
        return replace(material, alpha_mode="blend", alpha=opacity)
    if opacity == 1.0:
        return material
    if base is not None and (base.pixels[..., 3] < 255).any():  # its own alpha says nothing here
        pixels = base.pixels.copy()
        pixels[..., 3] = 255
        material = replace(material, base_color_texture_srgb=replace(base, pixels=pixels, encoded=None))
    return replace(material, alpha_mode="blend", alpha=opacity)


def _opacity_picture(values: MtlValues) -> UInt8[np.ndarray, "height width"] | None:
    """Of map_d, or of map_Tr turned over: the alpha of pictures that have one, else how bright they are."""
    for word in ("map_d", "map_tr"):
        found = values.picture(word)
        if found is not None:
            pixels, statement = found
            values.placed.append(statement)
            own = "m" if (pixels[..., 3] < 255).any() else ""
            plane = channel_of(pixels, statement.channel or own)
            return 255 - plane if word == "map_tr" and (statement.channel or own) != "m" else plane
    return None
