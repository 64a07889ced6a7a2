"""Panoramas that are not whole are put in their place, and what is black is said by its share of all directions."""

import io
import warnings

import numpy as np
import pytest
from PIL import Image

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import file_facts, read_env_image
from reflet.files.pictures.hdr import write_hdr
from reflet.files.pictures.panorama import crop_of

LATLONG, CUBE = PARAMETERIZATIONS["latlong"], PARAMETERIZATIONS["cube"]


def gpano(as_elements=False, **properties):
    """XMP as stitching programs write it, in either of its two forms."""
    if as_elements:
        said = "".join(f"<GPano:{name}>{value}</GPano:{name}>" for name, value in properties.items())
        return f'<x:xmpmeta><rdf:Description xmlns:GPano="http://ns.google.com/">{said}</rdf:Description></x:xmpmeta>'
    said = " ".join(f'GPano:{name}="{value}"' for name, value in properties.items())
    return f'<x:xmpmeta><rdf:Description xmlns:GPano="http://ns.google.com/" {said}/></x:xmpmeta>'


def crop_xmp(full, cropped, left, top, as_elements=False, **more):
    return gpano(
        as_elements,
        FullPanoWidthPixels=full[0],
        FullPanoHeightPixels=full[1],
        CroppedAreaImageWidthPixels=cropped[0],
        CroppedAreaImageHeightPixels=cropped[1],
        CroppedAreaLeftPixels=left,
        CroppedAreaTopPixels=top,
        **more,
    )


def photograph(path, xmp, height=16, width=64, value=128):
    """One grey: nothing that JPEG's compression could change."""
    picture = Image.fromarray(np.full((height, width, 3), value, np.uint8))
    buffer = io.BytesIO()
    if path.suffix == ".png":
        from PIL.PngImagePlugin import PngInfo

        info = PngInfo()
        info.add_itxt("XML:com.adobe.xmp", xmp)
        picture.save(buffer, "PNG", pnginfo=info)
    else:
        picture.save(buffer, {".jpg": "JPEG", ".webp": "WebP"}[path.suffix], xmp=xmp.encode(), quality=100)
    path.write_bytes(buffer.getvalue())
    return path


GREY = ((128 / 255 + 0.055) / 1.055) ** 2.4


@pytest.mark.parametrize("as_elements", [False, True])
@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp"])
def test_a_crop_is_put_in_its_place(tmp_path, suffix, as_elements):
    """All the way around, from 45° above to 45° below the horizon: sin 45° of all directions are there."""
    path = photograph(tmp_path / f"a{suffix}", crop_xmp((64, 32), (64, 16), 0, 8, as_elements))
    with pytest.warns(RefletWarning, match="rows 8 to 23 and columns 0 to 63 of 64×32; the rest, 29.3 %, is black"):
        image = read_env_image(path)
    assert image.parameterization == LATLONG
    expected = np.zeros((1, 32, 64, 3), np.float32)
    expected[:, 8:24] = GREY
    np.testing.assert_allclose(image.texels, expected, rtol=1e-5)  # floats
    assert file_facts(path).parameterization == LATLONG


def test_a_crop_of_a_picture_that_was_scaled_since(tmp_path):
    """Half the size that its XMP speaks of; a quarter of the way around, beginning at three eighths."""
    path = photograph(tmp_path / "a.png", crop_xmp((128, 64), (32, 32), 48, 16), 16, 16)
    with pytest.warns(RefletWarning, match="rows 8 to 23 and columns 24 to 39 of 64×32; the rest, 82.3 %, is black"):
        texels = read_env_image(path).texels
    assert (texels[0, 8:24, 24:40] > 0.2).all()
    assert np.count_nonzero(texels) == 16 * 16 * 3


def test_a_whole_panorama_is_as_it_is(tmp_path):
    path = photograph(tmp_path / "a.png", crop_xmp((8192, 4096), (8192, 4096), 0, 0), 8, 16)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_env_image(path).size == 8


@pytest.mark.parametrize(
    "notes",
    [("x", "1", "0", "0"), ("0", "0", "0", "0"), ("nan", "64", "0", "0"), ("64", "64", "-5", "0"),
     ("64", "128", "0", "0"), ("1e99", "64", "0", "0"), ("64", "64", "0", "31")],
)  # fmt: skip
def test_places_that_make_no_sense_are_none(notes):
    names = ("FullPanoWidthPixels", "CroppedAreaImageWidthPixels", "CroppedAreaLeftPixels", "CroppedAreaTopPixels")
    crop = crop_of({f"GPano:{name}": value for name, value in zip(names, notes, strict=True)}, 16, 64)
    # a picture of 16 rows that begins in row 31 of 32 is moved up; the rest is nothing
    assert crop is None if notes[3] == "0" else crop.top == 16


@pytest.mark.parametrize(
    ("properties", "said"),
    [
        ({"PoseHeadingDegrees": "90.5"}, "looks 90.5° from north in its middle, .* reflet convert --turn turns it"),
        ({"PosePitchDegrees": "-12", "PoseRollDegrees": "3"}, "camera pitched -12° and rolled 3°; that is not undone"),
        ({"ProjectionType": "cylindrical"}, "its projection is cylindrical; it is taken as lat-long"),
    ],
)
def test_what_is_not_honoured_is_said(tmp_path, properties, said):
    path = photograph(tmp_path / "a.jpg", gpano(**properties), 8, 16)
    with pytest.warns(RefletWarning, match=said) as warned:
        read_env_image(path)
    assert len(warned) == 1


def test_a_camera_that_stood_upright_is_no_doubt(tmp_path):
    path = photograph(
        tmp_path / "a.jpg",
        gpano(PoseHeadingDegrees="0.0", PosePitchDegrees="0.2", PoseRollDegrees="x", ProjectionType="equirectangular"),
        8,
        16,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_env_image(path)


def test_a_strip_called_lat_long_lies_in_the_middle(tmp_path):
    """Rows of radiance 1 from 30° above to 30° below the horizon: half of all directions."""
    write_hdr(tmp_path / "a.hdr", np.ones((16, 96, 3), np.float32))
    with pytest.warns(RefletWarning, match="rows 16 to 31 and columns 0 to 95 of 96×48; the rest, 50 %, is black"):
        texels = read_env_image(tmp_path / "a.hdr", LATLONG).texels
    assert (texels[0, 16:32] == 1.0).all()
    assert np.count_nonzero(texels) == 16 * 96 * 3
    assert read_env_image(tmp_path / "a.hdr").parameterization == CUBE  # six squares beside each other
    write_hdr(tmp_path / "b.hdr", np.ones((16, 17, 3), np.float32))
    with pytest.raises(RefletError, match="no latlong map; it is twice as wide as high, or wider; cut off"):
        read_env_image(tmp_path / "b.hdr", LATLONG)
