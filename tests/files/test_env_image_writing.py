"""What map files take: floats of any width, and sentences about the rest."""

import numpy as np
import pytest
from env_image_files import ANGULAR, LATLONG, STEP, random_image, random_levels

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import read_env_image, read_levels, read_light, write_env_image


class Unchecked:
    """What a caller may hand over as an EnvImage: nothing checks its texels before they are written."""

    def __init__(self, laid_out, texels):
        self.image = object.__new__(EnvImage)
        object.__setattr__(self.image, "parameterization", laid_out)
        object.__setattr__(self.image, "texels", texels)


@pytest.mark.parametrize("suffix", STEP)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.int32, bool, np.complex64])
def test_texels_that_are_no_floats_are_refused(tmp_path, suffix, dtype):
    """255 of 8 bits may be white or radiance 255."""
    image = Unchecked(LATLONG, np.ones((1, 4, 8, 3), dtype)).image
    with pytest.raises(RefletError, match=f"linear radiance in floats, and {np.dtype(dtype)} came; decode sRGB"):
        write_env_image(tmp_path / f"map{suffix}", [image])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", STEP)
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, ">f4"])
def test_floats_of_any_width_and_order_are_written(tmp_path, suffix, dtype):
    """Views in another order of memory, too: read back to the step of the format."""
    values = (0.9 * np.random.default_rng(2).random((1, 8, 3, 16))).astype(np.float16)
    texels = values.astype(dtype).transpose(0, 1, 3, 2)[:, ::-1]
    write_env_image(tmp_path / f"map{suffix}", [Unchecked(LATLONG, texels).image])
    expected = values.astype(np.float32).transpose(0, 1, 3, 2)[:, ::-1]
    np.testing.assert_allclose(read_env_image(tmp_path / f"map{suffix}").texels, expected, rtol=0, atol=STEP[suffix])


@pytest.mark.parametrize("suffix", STEP)
def test_other_texels_that_cannot_be_written(tmp_path, suffix):
    path = tmp_path / f"map{suffix}"
    for texels, said in (
        (np.ones((1, 4, 8, 1), np.float32), "3 channels, or 4 with alpha, and 1 came"),
        (np.ones((1, 4, 8, 5), np.float32), "3 channels, or 4 with alpha, and 5 came"),
        (np.ones((1, 4, 8), np.float32), r"an array of shape \(1, 4, 8\) came"),
        (np.full((1, 4, 8, 3), 1e300), "not finite everywhere as 32-bit floats"),
    ):
        with pytest.raises(RefletError, match=said):
            write_env_image(path, [Unchecked(LATLONG, texels).image])
    with pytest.raises(RefletError, match="no mip level to write"):
        write_env_image(path, [])
    assert not list(tmp_path.iterdir())


def test_levels_with_and_without_alpha_are_refused(tmp_path):
    with pytest.raises(RefletError, match="Some mip levels have alpha and others have none"):
        write_env_image(tmp_path / "map.ktx2", [random_image(CUBE), random_image(CUBE, 4, channels=4)])


def test_negative_radiance_is_kept_where_it_can_be(tmp_path):
    """Conversion is no judge of it; .hdr refuses, formats of the graphics system without a sign show black."""
    image = EnvImage(LATLONG, np.full((1, 2, 4, 3), -0.25, np.float32))
    for suffix in (".exr", ".ktx2", ".ktx", ".dds"):
        write_env_image(tmp_path / f"map{suffix}", [image])
        with pytest.warns(RefletWarning, match=r"negative radiance, which is kept: 8 negative \(100 % of"):
            assert read_env_image(tmp_path / f"map{suffix}").texels.min() == -0.25
        with pytest.warns(RefletWarning, match=r"negative radiance, which is no light, and is taken as 0: 8 negative"):
            assert read_light(tmp_path / f"map{suffix}").texels.max() == 0.0
        with pytest.warns(RefletWarning, match="repaired"):
            assert read_levels(tmp_path / f"map{suffix}", repair=True)[0].texels.max() == 0.0
    write_env_image(tmp_path / "map.ktx2", [image], texel_format="rgb9e5")
    assert read_env_image(tmp_path / "map.ktx2").texels.max() == 0.0
    with pytest.raises(RefletError, match="--repair makes it 0"):
        write_env_image(tmp_path / "map.hdr", [image])


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("map.jpg", {}, r"ends in one of .hdr .exr .png .ktx2 .ktx .dds"),
        ("map", {}, "no format that can be written"),
        ("map.hdr", {"layout": "spiral"}, "spiral came"),
        ("map.ktx2", {"layout": "vertical-strip"}, "layout vertical-strip is for pictures"),
        ("map.ktx", {"zstd": True}, r"only .ktx2 can"),
        ("map.hdr", {"texel_format": "half"}, "cannot be stored as half"),
        ("map.exr", {"texel_format": "rgb9e5"}, "cannot be stored as rgb9e5"),
        ("map.ktx2", {"texel_format": "int"}, "stored as half, float, rgb9e5, r11g11b10f; int is none"),
        ("{face}.exr", {"layout": "vertical-strip"}, "six files"),
        ("map.hdr", {"layout": "openexr"}, "cannot be laid out as OpenEXR does"),
    ],
)
def test_what_cannot_be_written(tmp_path, name, changes, said):
    with pytest.raises(RefletError, match=said):
        write_env_image(tmp_path / name, [random_image(CUBE)], **changes)
    assert not list(tmp_path.iterdir())


def test_more_that_cannot_be_written(tmp_path):
    cube, alpha = random_image(CUBE), random_image(LATLONG, channels=4)
    for name, levels, changes, said in (
        ("map.exr", random_levels(CUBE), {}, "one mip level, not 4"),
        ("map.hdr", [alpha], {}, "holds no alpha"),
        ("map.ktx2", [alpha], {"texel_format": "rgb9e5"}, "holds no alpha"),
        ("map.ktx2", [cube, cube], {}, "Mip level 1 should be half of level 0, not 8 rows"),
        ("{face}.exr", [alpha], {}, "six files, which are a cube"),
        ("map.exr", [random_image(ANGULAR)], {"layout": "openexr"}, "cannot be laid out as OpenEXR does"),
    ):
        with pytest.raises(RefletError, match=said):
            write_env_image(tmp_path / name, levels, **changes)
    assert not list(tmp_path.iterdir())
