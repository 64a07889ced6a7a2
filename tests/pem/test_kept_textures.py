"""Textures stay the files they came as, where every viewer shows them alike."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from small_pem import small_pem

from reflet.pem.container import open_pem, save_pem
from reflet.scene.fingerprint import fingerprint
from reflet.scene.readers.gltf.read import read_gltf


def _picture(kind, **options):
    """An encoded picture of 5×3 smooth pixels, and what comes of it."""
    data = io.BytesIO()
    ramp = np.linspace(40, 200, 5 * 3 * 3).reshape(5, 3, 3).astype(np.uint8)
    Image.fromarray(ramp).convert(options.pop("mode", "RGB")).save(data, kind, **options)
    return data.getvalue()


EXIF = Image.Exif()
EXIF[0x0112] = 6  # to be turned
PICTURES = {
    "png": (_picture("PNG"), True),
    "jpg": (_picture("JPEG"), True),
    "webp": (_picture("WEBP"), True),
    "grey": (_picture("JPEG", mode="L"), True),
    "turned": (_picture("JPEG", exif=EXIF), False),
    "cmyk": (_picture("JPEG", mode="CMYK"), False),
    "16 bits": (_picture("PNG", mode="I;16"), False),
    "tiff": (_picture("TIFF"), False),
    "moving": (
        _picture("WEBP", save_all=True, append_images=[Image.new("RGB", (3, 5))], lossless=True),
        False,
    ),
}


@pytest.mark.parametrize("name", PICTURES)
def test_textures_stay_as_they_came(tmp_path, name):
    """Where every viewer shows them as they are read here; else PNG, of the very pixels."""
    data, kept = PICTURES[name]
    (tmp_path / "picture").write_bytes(data)
    pem = small_pem(views=0)
    save_pem(tmp_path / "first", pem, codec="none")
    document = json.loads((tmp_path / "first" / "scene.gltf").read_text())
    document["images"] = [{"uri": "../picture"} for _ in document["images"]]
    (tmp_path / "first" / "scene.gltf").write_text(json.dumps(document))
    read = {part.name: part for part in read_gltf(tmp_path / "first" / "scene.gltf")}
    texture = read["room"].material.base_color_texture_srgb
    assert (texture.encoded == data) == kept
    room = pem.scene.parts[2]
    room = replace(room, material=replace(room.material, base_color_texture_srgb=texture))
    scene = replace(pem.scene, parts=(*pem.scene.parts[:2], room, *pem.scene.parts[3:]))
    save_pem(tmp_path / "second", replace(pem, scene=scene))
    back = open_pem(tmp_path / "second").scene.parts[2].material.base_color_texture_srgb
    np.testing.assert_array_equal(back.pixels, texture.pixels)
    (file,) = (tmp_path / "second" / "textures").glob("1.*")
    assert file.suffix == f".{name}" if name in ("png", "jpg", "webp") else ".jpg" if kept else ".png"
    assert (file.read_bytes() == data) == kept
    assert fingerprint(scene) == fingerprint(
        replace(scene, parts=tuple(replace(part, material=_unencoded(part.material)) for part in scene.parts))
    )
    seen = {part.name: part for part in read_gltf(tmp_path / "second" / "scene.gltf")}
    np.testing.assert_array_equal(seen["room"].material.base_color_texture_srgb.pixels, texture.pixels)


def _unencoded(material):
    texture = material.base_color_texture_srgb
    return replace(material, base_color_texture_srgb=texture and replace(texture, encoded=None))
