"""Env images as the pictures of a texture and back: which parameterization a texture holds, and which texels."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletError
from reflet.files.map_kinds import expected_shape, unknown_kind
from reflet.files.pictures.cube_layouts import faces_from_picture, layout_of
from reflet.files.textures.packed_floats import R11G11B10_MAX, RGB9E5_MAX
from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture

KEY = "RefletParameterization"

_FORMATS = {
    "half": {3: "rgba16f", 4: "rgba16f"},  # graphics systems have no rgb16f
    "float": {3: "rgba32f", 4: "rgba32f"},
    "rgb9e5": {3: "rgb9e5"},
    "r11g11b10f": {3: "r11g11b10f"},
}
TEXEL_FORMAT_CHOICES = tuple(_FORMATS)
"""What textures can be written in."""
_MOST = {
    "half": (HALF_MAX, "half floats"),
    "rgb9e5": (RGB9E5_MAX, "rgb9e5"),
    "r11g11b10f": (min(R11G11B10_MAX), "r11g11b10f"),
}


def metadata_of(laid_out: Parameterization) -> dict[str, bytes]:
    """The key-value pairs of a KTX 2.0 file."""
    return {"KTXorientation": b"rd", "KTXwriter": b"reflet", KEY: laid_out.name.encode()}


def holdable(levels: Sequence[EnvImage], texel_format: str) -> tuple[EnvImage, ...]:
    """The levels with light that is too bright for ``texel_format`` spread, and a RefletWarning where there was any."""
    if texel_format not in _MOST:
        return tuple(levels)
    most, name = _MOST[texel_format]
    return held(levels, most, name, "Stored as float (--texel-format float) it stays as it is.")


def texture_from_levels(levels: Sequence[EnvImage], texel_format: str = "half", *, zstd: bool = False) -> Texture:
    """The levels encoded as ``texel_format``, one of `TEXEL_FORMAT_CHOICES`; three channels in four get alpha 1.

    Light that is too bright for the format is spread (`holdable`). Raises RefletError for alpha in a format that holds
    none, and where each level is not half the one before.
    """
    finest = levels[0]
    channels = finest.texels.shape[3]
    if texel_format not in _FORMATS:
        raise RefletError(f"Texels are stored as {', '.join(_FORMATS)}; {texel_format} is none of them.")
    if any(level.texels.shape[3] != channels for level in levels):
        raise RefletError("Some mip levels have alpha and others have none; give all of them 3 channels, or 4.")
    if channels not in _FORMATS[texel_format]:
        raise RefletError(f"{texel_format} holds no alpha; store the map as half or float.")
    form = TEXEL_FORMATS[_FORMATS[texel_format][channels]]
    for k, level in enumerate(levels):
        if (level.parameterization, level.size) != (finest.parameterization, max(finest.size >> k, 1)):
            raise RefletError(f"Mip level {k} should be half of level {k - 1}, not {level.size} rows.")
    levels = holdable(levels, texel_format)
    return Texture(
        form,
        finest.size,
        finest.texels.shape[2],
        finest.parameterization == CUBE,
        tuple(form.encode(_with_channels(level.texels, form.channels)) for level in levels),
        metadata_of(finest.parameterization),
        alpha_is_premultiplied=channels == 4,
        supercompression="zstd" if zstd else None,
    )


def texture_from_slices(slices: Sequence[EnvImage], texel_format: str = "half", *, zstd: bool = False) -> Texture:
    """Maps of one face and of one size as the layers of a 2D array; otherwise as `texture_from_levels`."""
    return texture_from_maps([[image] for image in slices], texel_format, zstd=zstd)


def texture_from_maps(maps: Sequence[Sequence[EnvImage]], texel_format: str = "half", *, zstd: bool = False) -> Texture:
    """Maps of one kind and size, each by its mip levels, as layers of a 2D array: one after the other, a layer a face.

    Raises RefletError as `texture_from_levels` does.
    """
    each = iter(holdable([level for levels in maps for level in levels], texel_format))
    textures = [texture_from_levels([next(each) for _ in levels], texel_format, zstd=zstd) for levels in maps]
    levels = zip(*(texture.levels for texture in textures), strict=True)
    return replace(textures[0], is_cube=False, levels=tuple(np.concatenate(level) for level in levels))


def _with_channels(texels: np.ndarray, channels: int) -> np.ndarray:
    if texels.shape[3] == channels:
        return texels
    out = np.ones((*texels.shape[:3], channels), np.float32)
    out[..., : texels.shape[3]] = texels
    return out


def kind_of_texture(texture: Texture) -> Parameterization | None:
    """What the file says that it holds, else what its shape tells; None where neither does."""
    named = PARAMETERIZATIONS.get(as_text(texture.metadata.get(KEY, b"")))
    if named is not None:
        return named
    if texture.is_cube:
        return CUBE
    shape = (texture.image_count, texture.rows, texture.columns)
    guesses = (PARAMETERIZATIONS["latlong"], PARAMETERIZATIONS["dual_paraboloid"], CUBE)
    guess = next((guess for guess in guesses if guess.shape(texture.rows) == shape), None)
    return CUBE if guess is None and cube_layout(texture) else guess


def cube_layout(texture: Texture) -> str | None:
    """How a single picture holds a cube: a strip or a cross, as pictures have them (`cube_layouts`)."""
    return layout_of(CUBE, texture.rows, texture.columns) if texture.image_count == 1 else None


def as_text(value: bytes) -> str:
    """A value of a container's metadata; of binary ones their length."""
    text = value.decode("utf-8", "replace")
    return text if all(c.isprintable() or c in "\n\t" for c in text) and "\ufffd" not in text else f"{len(value)} bytes"


def levels_in_texture(
    path: Path, texture: Texture, parameterization: Parameterization | None
) -> tuple[tuple[EnvImage, ...], list[str]]:
    """The decoded mip levels, finest first, and what is in doubt about them.

    Levels that are no map of their own (1×1 of a lat-long map) are left out. ``parameterization`` outweighs what the
    file says. Raises RefletError where the kind of map is not known, or the texture's shape does not suit it.
    """
    laid_out = parameterization or kind_of_texture(texture)
    images, rows, columns = texture.image_count, texture.rows, texture.columns
    what = f"{columns}×{rows} texels" + (
        "" if images == 1 else f" on {images} {'faces' if texture.is_cube else 'layers'}"
    )
    if laid_out is None:
        fitting = [name for name, each in PARAMETERIZATIONS.items() if each.shape(rows) == (images, rows, columns)]
        raise RefletError(unknown_kind(path, what, fitting))
    layout = cube_layout(texture) if laid_out == CUBE else None
    if layout is not None:
        (picture,) = as_radiance([texture.decode(0)[0]])
        said = f"{path} holds the faces of a cube as a {layout} of pictures; mip levels, if it has any, are left out."
        return (faces_from_picture(picture, CUBE, layout),), [said]
    decoded = []
    for mip_level in range(len(texture.levels)):
        shape = texture.level_shape(mip_level)
        if (images, *shape) != laid_out.shape(shape[0]):
            break
        decoded.append(texture.decode(mip_level))
    if not decoded:
        raise RefletError(f"{path} is {what}, which is no {laid_out} map; {expected_shape(laid_out)}.")
    doubts = []
    if parameterization is None and laid_out == CUBE and not texture.is_cube and KEY not in texture.metadata:
        doubts.append(f"{path} holds six square layers that it does not call a cube; they are taken as one's faces.")
    return tuple(EnvImage(laid_out, texels) for texels in as_radiance(decoded)), doubts


def as_radiance(levels: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Grey as three equal channels; alpha that is 1 everywhere is left out."""
    channels = levels[0].shape[-1] if levels else 0
    if channels == 1:
        return [np.repeat(texels, 3, axis=-1) for texels in levels]
    if channels == 4 and all((texels[..., 3] == 1.0).all() for texels in levels):
        levels = [texels[..., :3] for texels in levels]
    return [np.ascontiguousarray(texels) for texels in levels]
