"""The path traced glossy sphere reflects what its BRDF says."""

import numpy as np
import pytest

from reflet.scene.material import EnvironmentLight
from reflet.scene.views.camera import Camera
from reflet.trace.references.glossy_reference import GlossySphere, albedo

CAMERA = Camera((0.0, 0.0, 40.0), (0.0, 0.0, 0.0), fov_deg=3.0, width=24, height=24)


@pytest.mark.parametrize("alpha", [0.09, 0.5, 1.0])
def test_a_sphere_in_a_furnace_shows_its_albedo(alpha: float) -> None:
    furnace = GlossySphere(EnvironmentLight(np.ones((8, 16, 3), np.float32)))
    picture = furnace.picture(CAMERA, alpha, spp=256)[..., 0]
    # So far away that rays are parallel: n·v is the height over the picture's plane.
    place = ((np.arange(24) + 0.5) / 12.0 - 1.0) * 40.0 * np.tan(np.radians(1.5))
    square = 1.0 - place[:, None] ** 2 - place[None, :] ** 2
    inside = square > 0.2
    wanted = albedo(np.sqrt(square[inside]), alpha)
    # 256 samples of standard deviation 0.3 at most leave 2 %; their mean over 300 pixels a tenth of a per cent.
    np.testing.assert_allclose(picture[inside], wanted, atol=0.08)
    assert picture[inside].mean() == pytest.approx(wanted.mean(), abs=4e-3)
    assert picture[0, 0] == 0.0  # nothing behind
