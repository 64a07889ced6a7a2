"""Colours of pictures that are not plain sRGB: profiles are applied, the rest is told."""

import io
import os
from collections.abc import Mapping
from typing import Any

from PIL import Image, ImageCms

_HEAD = 1 << 18  # bytes in which a picture says how it is coded
_GAIN_MAPS = (b"http://ns.adobe.com/hdr-gain-map/", b"urn:iso:std:iso:ts:21496")
_FOR_DISPLAYS = {16: "PQ", 18: "HLG"}  # transfer functions of a PNG's cICP chunk
_SRGB_GAMMA = 0.45455


def in_srgb(image: Image.Image) -> tuple[Image.Image, str | None]:
    """The picture in RGB or RGBA of sRGB, its colour profile applied; and what is wrong with that, if anything is.

    Colours that sRGB does not have become the nearest at its border.
    """
    has_alpha = "A" in image.getbands() or "transparency" in image.info
    mode = "RGBA" if has_alpha else "RGB"
    profile = image.info.get("icc_profile")
    if not profile:
        return image.convert(mode), None
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        if "srgb" in ImageCms.getProfileDescription(source).lower():
            return image.convert(mode), None
        colors = image if image.mode in ("RGB", "L", "CMYK") else image.convert("RGB")
        out = ImageCms.profileToProfile(
            colors,
            source,
            ImageCms.createProfile("sRGB"),
            renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
            outputMode="RGB",
        )
        if out is None:
            raise ImageCms.PyCMSError("no transform")
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return image.convert(mode), "has a colour profile that cannot be applied; its colours are taken as sRGB"
    if has_alpha:
        out.putalpha(image.convert("RGBA").getchannel("A"))
    return out, None


def doubts_of_encoding(path: str | os.PathLike[str], data: bytes, info: Mapping[Any, Any]) -> list[str]:
    """Sentences about how an encoded picture is coded, where that is not sRGB and is not honoured."""
    head = data[:_HEAD]
    doubts = []
    if any(name in head for name in _GAIN_MAPS):
        doubts.append(
            f"{path} has a gain map for its brightest parts, which is not applied; save it as .exr or .hdr instead."
        )
    chunk = head.find(b"cICP")
    if data.startswith(b"\x89PNG") and 0 < chunk < len(head) - 6 and head[chunk + 5] in _FOR_DISPLAYS:
        name = _FOR_DISPLAYS[head[chunk + 5]]
        doubts.append(f"{path} is coded for HDR displays ({name}) and is taken as sRGB; save it as .exr or .hdr.")
    elif not {"srgb", "icc_profile"} & set(info) and abs(info.get("gamma", _SRGB_GAMMA) - _SRGB_GAMMA) > 0.02:
        doubts.append(f"{path} says that its gamma is {1.0 / max(info['gamma'], 1e-5):.3g}; it is taken as sRGB.")
    return doubts
