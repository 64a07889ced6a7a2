"""What picture files say of themselves beside their pixels: strings by name."""

import os
import re
from itertools import takewhile
from pathlib import Path

import OpenEXR
from PIL import Image

from reflet.files.pictures.exr import quiet
from reflet.files.pictures.panorama import panorama_notes

_HEADER_LIMIT = 1 << 16  # bytes of a .hdr file's header
_XMP = "XML:com.adobe.xmp"  # the text of a .png with that
_SIZE = re.compile("[-+][XY] ")  # how its last line begins


def read_notes(path: str | os.PathLike[str]) -> dict[str, str]:
    """String attributes of .exr, text of .png, variables of .hdr with their names in lower case, and of .png, .jpg and
    .webp the panorama's place and pose (`panorama_notes`).

    A file that cannot be understood says nothing: whoever reads its pixels says why.
    """
    suffix = Path(path).suffix.lower()
    try:
        if suffix == ".exr":
            with quiet(), OpenEXR.File(os.fspath(path), header_only=True) as file:
                header = file.parts[0].header
                return {key: str(value) for key, value in header.items() if isinstance(value, str)}
        if suffix in (".png", ".jpg", ".jpeg", ".webp"):
            with Image.open(path) as image:
                info = image.info
            xmp = info.get("xmp") or info.get(_XMP) or b""
            said = panorama_notes(xmp.decode("utf-8", "replace") if isinstance(xmp, bytes) else str(xmp))
            if suffix == ".png":
                said |= {str(key): value for key, value in info.items() if isinstance(value, str) and key != _XMP}
            return said
        if suffix == ".hdr":
            with open(path, "rb") as picture:
                lines = picture.read(_HEADER_LIMIT).decode("latin-1").splitlines()
            lines = list(takewhile(lambda line: line.strip() and not _SIZE.match(line), lines))
            pairs = (line.partition("=") for line in lines if "=" in line and not line.startswith("#"))
            return {key.strip().lower(): value.strip() for key, _, value in pairs}
    except (OSError, RuntimeError, ValueError, TypeError, SyntaxError, IndexError, Image.DecompressionBombError):
        return {}
    return {}
