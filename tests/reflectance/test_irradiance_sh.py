"""Order-2 irradiance against closed forms and against the whole integral."""

from pathlib import Path

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.spherical_harmonics import radiance_from_harmonics
from reflet.files.pictures.hdr import read_hdr
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.prefilter.irradiance_sh import (
    diffuse_map_from_harmonics,
    irradiance_harmonics,
    polynomial_coefficients,
)
from reflet.reflectance.prefilter.prefilter import prefiltered

HDR = Path(__file__).parents[2].parent / "shared" / "data" / "hdr"


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_what_lies_in_the_first_bands_is_exact(name: str) -> None:
    parameterization = PARAMETERIZATIONS[name]
    x, y, z = np.moveaxis(parameterization.texel_directions(64)[0], -1, 0)
    image = EnvImage(parameterization, np.stack([0 * x + 0.7, 1.0 + 0.5 * z, 1.0 + x * y], -1))
    normal = CUBE.texel_directions(8)[0]
    irradiance = radiance_from_harmonics(irradiance_harmonics(image), normal)
    expected = np.stack(
        [0 * normal[..., 0] + 0.7, 1.0 + normal[..., 2] / 3.0, 1.0 + normal[..., 0] * normal[..., 1] / 4.0], -1
    )
    # Texels of one radiance each blur by a twentieth of a radian; the gazing ball's reach 20° at its rim.
    np.testing.assert_allclose(irradiance, expected, atol=2e-3 if name == "gazing_ball" else 5e-4)


def test_a_sun_in_a_black_sky() -> None:
    image = EnvImage(CUBE, np.zeros((6, 64, 64, 1)))
    image.texels[4, 31:33, 31:33] = np.pi / (4.0 * CUBE.texel_solid_angle(64)[4, 31, 31])
    cosine = np.linspace(-1.0, 1.0, 401)
    normal = np.stack([np.sqrt(1.0 - cosine**2), 0.0 * cosine, cosine], -1)
    irradiance = radiance_from_harmonics(irradiance_harmonics(image), normal)[:, 0]
    # A texel is 1.8°: its spread lowers the bands by 1e-4.
    np.testing.assert_allclose(irradiance, 0.25 + 0.5 * cosine + 5.0 / 32.0 * (3.0 * cosine**2 - 1.0), atol=1e-3)
    assert np.abs(irradiance - np.maximum(cosine, 0.0)).max() == pytest.approx(3.0 / 32.0, abs=1e-3)
    assert irradiance.min() == pytest.approx(-19.0 / 480.0, abs=1e-3)
    assert diffuse_map_from_harmonics(irradiance_harmonics(image), CUBE, 8).texels.min() == 0.0


def test_polynomials_for_shaders() -> None:
    coefficients = np.random.default_rng(0).normal(size=(9, 3))
    normal = CUBE.texel_directions(4)[0]
    x, y, z = np.moveaxis(normal, -1, 0)
    one = np.ones_like(x)
    terms = np.stack([one, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y], -1)
    by_polynomials = terms @ polynomial_coefficients(coefficients)
    np.testing.assert_allclose(by_polynomials, radiance_from_harmonics(coefficients, normal), atol=1e-12)


@pytest.mark.skipif(not HDR.is_dir(), reason="no shared data")
@pytest.mark.parametrize(
    ("name", "rms", "largest"), [("kloppenheim_05", 0.03, 0.09), ("venice_sunset", 0.01, 0.03)], ids=["sun", "dusk"]
)
def test_error_on_real_light(name: str, rms: float, largest: float) -> None:
    """As a share of the brightest irradiance: below what a single sun would leave (0.036 and 0.094)."""
    image = EnvImage(PARAMETERIZATIONS["latlong"], read_hdr(HDR / f"{name}_1k.hdr")[None])
    whole = prefiltered(image, DiffuseKernel(), CUBE, 16).texels
    error = (diffuse_map_from_harmonics(irradiance_harmonics(image), CUBE, 16).texels - whole) / whole.max()
    assert np.sqrt(np.mean(error**2)) < rms
    assert np.abs(error).max() < largest
