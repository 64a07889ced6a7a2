"""Round maps as photographs have them: black in the corners, or not."""

import numpy as np
import pytest
from env_image_files import ANGULAR

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.exr import write_exr
from reflet.files.pictures.hdr import write_hdr


@pytest.mark.parametrize("name", ["gazing_ball", "angular", "dual_paraboloid"])
def test_photographs_with_black_corners(tmp_path, name):
    """Texels on the rim count by their part inside the disc: with their centres outside they must not stay black."""
    laid_out = PARAMETERIZATIONS[name]
    direction, inside = laid_out.texel_directions(32)
    sky = 1.0 + 0.5 * direction
    write_hdr(tmp_path / "ball.hdr", np.concatenate(np.where(inside[..., None], sky, 0.0).astype(np.float32), 1))
    read = read_env_image(tmp_path / "ball.hdr", laid_out)
    # Continued from texels nearby, 0.2 rad wide, half of which is a slope of ½ per radian off by at most; the gazing
    # ball's last ones reach 0.7 rad to -z and as far beyond.
    np.testing.assert_allclose(read.texels, sky, atol=0.5 if name == "gazing_ball" else 0.1)
    np.testing.assert_allclose(read.texels[inside], sky[inside], rtol=2.0**-7)  # what is inside stays, to the format


def test_corners_that_go_on_are_kept(tmp_path):
    image = EnvImage(ANGULAR, np.exp(ANGULAR.texel_directions(32)[0]).astype(np.float32))
    write_exr(tmp_path / "map.exr", image.texels[0])
    np.testing.assert_array_equal(read_env_image(tmp_path / "map.exr", ANGULAR).texels, image.texels)
