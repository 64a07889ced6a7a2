"""Materials of the older specular-glossiness model, KHR_materials_pbrSpecularGlossiness, as metallic-roughness ones."""

import numpy as np
from jaxtyping import Float, UInt8

from reflet.files.srgb import linear_from_srgb, srgb_from_linear

_DIELECTRIC = 0.04  # what a surface that is no metal reflects at normal incidence
_EPSILON = 1e-6

Colors = Float[np.ndarray, "*shape 3"]
Values = Float[np.ndarray, "*shape"]


def metallic_roughness(diffuse: Colors, specular: Colors, glossiness: Values) -> tuple[Colors, Values, Values]:
    """base_color, metallic and perceptual_roughness of linear diffuse and specular colours and a glossiness in [0, 1].

    Khronos's own conversion [KhronosSpecularGlossiness]: metallic solves that the brightness of both models' diffuse
    and specular colours agrees; the base colour then comes from the diffuse colour where there is little metal and from
    the specular one where there is much.
    """
    strength = 1.0 - specular.max(axis=-1)
    metallic = _metallic(_brightness(diffuse), _brightness(specular), strength)
    m = metallic[..., None]
    from_diffuse = diffuse * (strength[..., None] / (1.0 - _DIELECTRIC) / np.maximum(1.0 - m, _EPSILON))
    from_specular = (specular - _DIELECTRIC * (1.0 - m)) / np.maximum(m, _EPSILON)
    base_color = np.clip(from_diffuse + (from_specular - from_diffuse) * m**2, 0.0, 1.0)
    return base_color, metallic, 1.0 - glossiness


def _brightness(color: Colors) -> Values:
    """As perceived, by Khronos's weights."""
    return np.sqrt(np.square(color) @ np.array([0.299, 0.587, 0.114]))


def _metallic(diffuse: Values, specular: Values, strength: Values) -> Values:
    b = diffuse * strength / (1.0 - _DIELECTRIC) + specular - 2.0 * _DIELECTRIC
    root = np.sqrt(np.maximum(b**2 - 4.0 * _DIELECTRIC * (_DIELECTRIC - specular), 0.0))
    return np.where(specular < _DIELECTRIC, 0.0, np.clip((root - b) / (2.0 * _DIELECTRIC), 0.0, 1.0))


def converted_textures(
    diffuse_srgb: UInt8[np.ndarray, "h w 4"] | None,
    specular_srgb: UInt8[np.ndarray, "k l 4"] | None,
    factors: tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"], float],
) -> tuple[UInt8[np.ndarray, "m n 4"], UInt8[np.ndarray, "m n 4"]]:
    """The base colour texture (sRGB, the diffuse one's alpha kept) and the metallic-roughness texture.

    ``specular_srgb`` holds glossiness in its alpha, linear. ``factors`` are those of diffuse and specular colour and of
    glossiness, all in the textures that come out. Both take the larger texture's size, the other one's nearest texel.
    """
    given = [texture for texture in (diffuse_srgb, specular_srgb) if texture is not None]
    height, width = max(t.shape[0] for t in given), max(t.shape[1] for t in given)
    white = np.full((1, 1, 4), 255, np.uint8)
    diffuse = _sized(white if diffuse_srgb is None else diffuse_srgb, height, width)
    specular = _sized(white if specular_srgb is None else specular_srgb, height, width)
    base, other = np.empty((height, width, 4), np.uint8), np.zeros((height, width, 4), np.uint8)
    decode = linear_from_srgb(np.arange(256) / 255.0)
    for row in range(height):  # a row at a time: in floats a picture is sixteen times as large
        color, metallic, roughness = metallic_roughness(
            decode[diffuse[row, :, :3]] * factors[0],
            decode[specular[row, :, :3]] * factors[1],
            specular[row, :, 3] / 255.0 * factors[2],
        )
        base[row, :, :3] = np.rint(255.0 * srgb_from_linear(color))
        base[row, :, 3] = diffuse[row, :, 3]
        other[row, :, 1], other[row, :, 2] = np.rint(255.0 * roughness), np.rint(255.0 * metallic)
    other[..., 3] = 255
    return base, other


def _sized(texture: UInt8[np.ndarray, "h w 4"], height: int, width: int) -> UInt8[np.ndarray, "k l 4"]:
    rows = np.arange(height) * texture.shape[0] // height
    columns = np.arange(width) * texture.shape[1] // width
    return texture if texture.shape[:2] == (height, width) else texture[rows[:, None], columns]
