"""Environments that change from frame to frame, and materials in them."""

import numpy as np
import pytest
from map_scenes import analytic_levels

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.materials.material import Coated, GlossyGgx, GlossyPhong, Mirror
from reflet.reflectance.prefilter.ggx_levels import GEOMETRIC
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.maps.env_map_texture import EnvMapTexture

SIZE = 64
GREY = (0.5, 0.5, 0.5)


def lamp(towards: tuple[float, float, float], kind: Parameterization = CUBE) -> EnvImage:
    """A dim sky with a lamp some 10° wide."""
    axis = np.array(towards) / np.linalg.norm(towards)
    sky = np.array([0.2, 0.3, 0.5])
    return analytic_levels(kind, SIZE, lambda d: sky + 6.0 * np.exp(120.0 * (d @ axis - 1.0))[..., None] * GREY)[0]


def relative_error(shown: EnvMapTexture, image: EnvImage, kernel: Kernel, level: int = 0) -> float:
    """Sum of absolute differences to brute force over that, in 200 texels."""
    direction, valid = shown.parameterization.texel_directions(shown.size >> level)
    some = np.random.default_rng(1).choice(np.flatnonzero(valid), 200)
    expected = filtered_reference(image, kernel, direction.reshape(-1, 3)[some])
    texels = shown.read(level).texels[..., :3].reshape(-1, 3)[some]
    return float(np.abs(texels - expected).sum() / expected.sum())


@pytest.fixture(scope="module")
def live() -> LiveEnvironment:
    """One for all tests: what was shown before must leave no trace."""
    return LiveEnvironment(SIZE)


@pytest.mark.parametrize("kind", [CUBE, LatLong()], ids=str)
def test_maps_are_those_of_what_is_shown(live: LiveEnvironment, kind: Parameterization) -> None:
    for towards in ((0.3, 0.8, 0.5), (-1.0, 0.2, 0.1)):
        image = lamp(towards, kind)
        live.show(image)
        for exponent in (8.0, 60.0):
            maps = live.maps(GlossyPhong(exponent, GREY, GREY))
            # 37 taps leave 0.04 (test_probe_filter). Of light elsewhere or another exponent's lobe 0.2 and more is off.
            assert relative_error(maps.reflected, image, PhongKernel(exponent)) < 0.05
            assert maps.diffuse is not None
            assert relative_error(maps.diffuse, image, DiffuseKernel()) < 0.01
        maps = live.maps(GlossyGgx(metallic=1.0, perceptual_roughness=0.5))
        last = maps.reflected.texture.mip_level_count - 1
        kernel = GgxKernel(GEOMETRIC.roughness_of_level(last, last + 1) ** 2)
        assert relative_error(maps.reflected, image, kernel, last) < 0.05
        assert maps.roughness == 0.5


def test_a_mirror_shows_the_environment_itself(live: LiveEnvironment) -> None:
    live.show(lamp((0.0, 1.0, 0.0), LatLong()))
    maps = live.maps(Mirror())
    assert maps.reflected is live.environment
    assert maps.diffuse is None
    assert live.maps(Coated(1.5, GREY)).diffuse is not None


def test_a_sun_brighter_than_half_floats_stays_finite(live: LiveEnvironment) -> None:
    texels = np.full((1, SIZE, 2 * SIZE, 3), 0.1, np.float32)
    texels[0, 20, 40] = 1e6
    live.show(EnvImage(LatLong(), texels))
    for material in (GlossyPhong(5.0, GREY, GREY), GlossyGgx()):
        maps = live.maps(material)
        assert maps.diffuse is not None
        for each in (maps.reflected, maps.diffuse):
            radiance = each.read().texels.astype(float)
            assert np.isfinite(radiance).all()
            assert radiance[..., :3].min() > 0.09


def test_by_the_papers_method() -> None:
    live = LiveEnvironment(SIZE, by_paraboloids=True)
    image = lamp((0.3, 0.8, 0.5))
    live.show(image)
    for exponent in (40.0, 200.0):
        shown = live.maps(GlossyPhong(exponent)).reflected
        # test_phong_paraboloid: 0.06 on paraboloids; here a cube of as many rows is enlarged
        assert relative_error(shown, image, PhongKernel(exponent)) < 0.1


def test_refusals(live: LiveEnvironment) -> None:
    with pytest.raises(RefletError, match="16 rows"):
        LiveEnvironment(8)
    with pytest.raises(RefletError, match="power of two"):
        LiveEnvironment(48)
    with pytest.raises(RefletError, match="empty"):
        LiveEnvironment(16).maps(Mirror())
