"""Alpha of env maps in files: kept, premultiplied where they have it straight, and left out where it hides all."""

from contextlib import nullcontext

import numpy as np
import pytest
from env_image_files import LATLONG, STEP, random_image

from reflet.envmap.env_image import EnvImage
from reflet.errors import RefletWarning
from reflet.files.env_image_file import read_env_image, write_env_image
from reflet.files.pictures.png import write_png


@pytest.mark.parametrize("suffix", [".exr", ".ktx2", ".ktx", ".dds"])
def test_alpha_is_kept(tmp_path, suffix):
    image = random_image(LATLONG, channels=4)
    write_env_image(tmp_path / f"map{suffix}", [image])
    read = read_env_image(tmp_path / f"map{suffix}").texels
    np.testing.assert_allclose(read, image.texels, rtol=0, atol=STEP[suffix])
    image.texels[..., 3] = 1.0  # says nothing
    write_env_image(tmp_path / f"map{suffix}", [image])
    assert read_env_image(tmp_path / f"map{suffix}").texels.shape[3] == 3


def test_png_alpha_is_straight_and_ours_premultiplied(tmp_path):
    image = EnvImage(LATLONG, np.full((1, 2, 4, 4), (0.5, 0.25, 0.0, 0.5), np.float32))
    write_env_image(tmp_path / "map.png", [image])
    # one code of alpha, and of color, in 255
    np.testing.assert_allclose(read_env_image(tmp_path / "map.png").texels, image.texels, rtol=0, atol=1 / 255)


@pytest.mark.parametrize("suffix", [".exr", ".png", ".ktx2", ".dds"])
def test_an_alpha_that_hides_everything_is_not_meant(tmp_path, suffix):
    """Tools that know no alpha leave it 0: the light would be lost, silently where alpha is straight."""
    image = random_image(LATLONG, channels=4)
    image.texels[..., 3] = 0.0
    path = tmp_path / f"map{suffix}"
    if suffix == ".png":
        write_png(path, np.full((4, 8, 4), (255, 255, 255, 0), np.uint8))
        image = EnvImage(LATLONG, np.ones((1, 4, 8, 4), np.float32))
    else:
        write_env_image(path, [image])
    in_8_bits = pytest.warns(RefletWarning, match="holds no radiance above 1: 100 %")
    with (
        pytest.warns(RefletWarning, match="has an alpha of 0 everywhere, which is left out; its colours are kept"),
        in_8_bits if suffix == ".png" else nullcontext(),
    ):
        read = read_env_image(path)
    np.testing.assert_allclose(read.texels, image.texels[..., :3], rtol=0, atol=STEP[suffix])
