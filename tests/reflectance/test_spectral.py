"""From refractive indices to colours."""

from pathlib import Path

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.files.ior_file import read_spectral_index
from reflet.reflectance.brdfs.fresnel import fresnel_conductor
from reflet.reflectance.brdfs.spectral import (
    WAVELENGTHS,
    SpectralIndex,
    d65,
    f0_rgb,
    index_rgb,
    matching_functions,
    rgb_from_reflectance,
)

IOR = Path(__file__).parents[2].parent / "shared" / "data" / "ior"
needs_data = pytest.mark.skipif(not IOR.is_dir(), reason="no shared data")

# Measured metals (Johnson and Christy; Rakić) in linear Rec. 709 as tables for artists give them.
KNOWN = {
    "Au_Johnson": (1.0, 0.75, 0.35),
    "Ag_Johnson": (0.98, 0.98, 0.97),
    "Cu_Johnson": (0.94, 0.63, 0.53),
    "Al_Rakic": (0.91, 0.92, 0.92),
}


def test_white_has_the_illuminants_chromaticity() -> None:
    xyz = (d65(WAVELENGTHS)[:, None] * matching_functions(WAVELENGTHS)).sum(0)
    # The standard's white; the fit of the matching functions errs by about 1 % of their peaks, less in integrals.
    np.testing.assert_allclose(xyz[:2] / xyz.sum(), [0.3127, 0.3290], atol=2e-4)


def test_grey_stays_grey() -> None:
    np.testing.assert_allclose(rgb_from_reflectance(np.full(len(WAVELENGTHS), 0.3)), 0.3, rtol=1e-12)


@needs_data
@pytest.mark.parametrize("metal", KNOWN)
def test_known_metals(metal: str) -> None:
    index = read_spectral_index(IOR / f"{metal}.yml")
    # Published values differ among themselves by up to 0.04 with illuminant and interpolation.
    np.testing.assert_allclose(f0_rgb(index), KNOWN[metal], atol=0.035)


@needs_data
@pytest.mark.parametrize("metal", KNOWN)
def test_an_index_for_each_channel_stands_for_the_spectrum_at_all_angles(metal: str) -> None:
    index = read_spectral_index(IOR / f"{metal}.yml")
    n, k = index_rgb(index)
    cosine = np.linspace(0.02, 0.98, 33)
    n_all, k_all = index.at(WAVELENGTHS)
    spectral = np.clip(rgb_from_reflectance(fresnel_conductor(cosine, n_all[:, None], k_all[:, None])), 0.0, 1.0)
    # A third of 8 bits: gold's green spans the edge of its absorption, where no single index fits all angles.
    np.testing.assert_allclose(fresnel_conductor(cosine[:, None], n, k), spectral, atol=0.008)


def test_a_constant_index_is_found_again() -> None:
    table = SpectralIndex(np.array([300.0, 900.0]), np.array([0.8, 0.8]), np.array([2.5, 2.5]))
    n, k = index_rgb(table)
    np.testing.assert_allclose(n, 0.8, rtol=1e-5)  # the solver's default tolerance is 1e-8 on a squared sum
    np.testing.assert_allclose(k, 2.5, rtol=1e-5)


def test_reading(tmp_path: Path) -> None:
    path = tmp_path / "glass.yml"
    path.write_text("DATA:\n  - type: tabulated n\n    data: |\n        0.3 1.6\n        0.8 1.5\n")
    index = read_spectral_index(path)
    assert index.wavelength.tolist() == [300.0, 800.0]
    assert index.n.tolist() == [1.6, 1.5]
    assert index.k.tolist() == [0.0, 0.0]
    path.write_text("DATA:\n  - type: tabulated nk\n    data: |\n        0.3 1.6 0.0\n        0.8 1.5\n")
    with pytest.raises(RefletError, match="3 numbers"):
        read_spectral_index(path)
    path.write_text("DATA:\n  - type: formula 2\n    coefficients: 0 1 2\n")
    with pytest.raises(RefletError, match="tabulated"):
        read_spectral_index(path)
    path.write_text("DATA:\n  - type: tabulated n\n    data: |\n        0.5 1.6\n        0.8 1.5\n")
    with pytest.raises(RefletError, match="380 to 780"):
        read_spectral_index(path)
