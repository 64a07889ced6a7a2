import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.cube import CUBE, texel_directions
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import write_env_image
from reflet.files.environment import read_environment
from reflet.files.pictures.exr import write_exr
from reflet.files.pictures.hdr import write_hdr
from reflet.files.pictures.openexr_layout import openexr_directions
from reflet.files.pictures.png import write_png


def seen(direction):
    """Radiance that tells directions and their mirror images apart."""
    return (1.0 + 0.5 * direction).astype(np.float32)


def latlong_directions(height):
    direction, _ = parameterization("latlong").texel_directions(height)
    return direction[0]


def test_plain_pictures_are_taken_as_they_are(tmp_path):
    picture = np.random.default_rng(3).integers(128, 256, (4, 8, 3)).astype(np.float32)
    write_exr(tmp_path / "a.exr", picture)
    write_hdr(tmp_path / "a.hdr", picture)
    np.testing.assert_array_equal(read_environment(tmp_path / "a.exr"), picture)
    np.testing.assert_array_equal(read_environment(tmp_path / "a.hdr"), picture)  # 128 to 255 are mantissas


def test_photographs_are_decoded_from_srgb(tmp_path):
    write_png(tmp_path / "a.png", np.full((4, 8, 3), 188, np.uint8))
    # IEC 61966-2-1 by hand: ((188/255 + 0.055)/1.055)^2.4
    np.testing.assert_allclose(read_environment(tmp_path / "a.png"), 0.502886, rtol=1e-5)


@pytest.mark.parametrize(("layout", "size"), [("latlong", (256, 128)), ("cube", (96, 576))])
def test_openexr_environments_become_ours(tmp_path, layout, size):
    write_exr(tmp_path / "a.exr", seen(openexr_directions(layout, *size)), layout)
    read = read_environment(tmp_path / "a.exr")
    # bilinear interpolation errs by step²/8 of a second derivative of 1/2 at most, here of steps of 2π/96 and twice
    np.testing.assert_allclose(read, seen(latlong_directions(len(read))), atol=1e-3)


def test_maps_of_other_kinds_are_resampled_as_finely(tmp_path):
    cube = EnvImage(CUBE, seen(texel_directions(64)))
    write_env_image(tmp_path / "a.ktx2", [cube], texel_format="float")
    read = read_environment(tmp_path / "a.ktx2")
    assert read.shape == (139, 278, 3)  # √(π·6·64²)/2 rows
    # where a filter is about a texel wide it errs by a few (2/64)²/8 of the second derivative
    np.testing.assert_allclose(read, seen(latlong_directions(len(read))), atol=1e-3)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_impossible_radiance_is_refused(tmp_path, value):
    picture = np.ones((4, 8, 3), np.float32)
    picture[1, 2, 0] = value
    write_exr(tmp_path / "a.exr", picture)
    with pytest.raises(RefletError, match="not finite"):
        read_environment(tmp_path / "a.exr")


def test_negative_radiance_gives_no_light_and_is_said(tmp_path):
    picture = np.ones((4, 8, 3), np.float32)
    picture[1, 2, 0] = -0.5
    write_exr(tmp_path / "a.exr", picture)
    with pytest.warns(RefletWarning, match="negative radiance, which is no light, and is taken as 0: 1 negative"):
        read = read_environment(tmp_path / "a.exr")
    np.testing.assert_array_equal(read, np.maximum(picture, 0.0))


def test_other_files_are_refused(tmp_path, capfd):
    write_exr(tmp_path / "square.exr", np.ones((8, 8, 3), np.float32))
    (tmp_path / "damaged.exr").write_bytes((tmp_path / "square.exr").read_bytes()[:300])
    (tmp_path / "a.jpg").write_bytes(b"")
    (tmp_path / "a.bmp").write_bytes(b"")
    refusals = {"square.exr": "does not tell", "damaged.exr": "not a readable OpenEXR", "a.jpg": "not a readable",
                "none.hdr": "does not exist", "none.exr": "does not exist", "a.bmp": "is BMP"}  # fmt: skip
    for name, sentence in refusals.items():
        with pytest.raises(RefletError, match=sentence):
            read_environment(tmp_path / name)
    shown = capfd.readouterr()
    assert shown.err == shown.out == ""  # the sentence is all that is said
