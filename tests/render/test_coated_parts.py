"""Clear coats of PEMs: what is shown of a white room, and that what is below is as ever."""

from dataclasses import replace

import numpy as np
import pytest
from test_gloss import albedo, furnace, shown

from reflet.reflectance.brdfs.dfg import dfg
from reflet.scene.material import Material

COAT = Material("coat", (0.5, 0.5, 0.5), 1.0, 0.4, clearcoat=1.0)


def over(below: np.ndarray, cosine: np.ndarray, roughness: float, share: float = 1.0) -> np.ndarray:
    some = np.linspace(0.3, 1.0, 64) ** 2
    kept = np.interp(cosine, some, dfg(some, roughness**2, 1 << 13).sum(1))
    fresnel = share * (0.04 + 0.96 * (1.0 - cosine) ** 5)
    return (1.0 - fresnel) * below + fresnel * kept


@pytest.mark.parametrize("most_hits", [0, 3])
@pytest.mark.parametrize("roughness", [0.0, 0.15, 0.6, 1.0])
def test_white_light_shows_the_albedo(roughness: float, most_hits: int) -> None:
    """Over metal, paint and black."""
    coats = [replace(COAT, clearcoat_roughness=roughness, **below) for below in
             ({}, {"base_color": (0.0,) * 3, "metallic": 0.0}, {"clearcoat": 0.3})]  # fmt: skip
    for material, (radiance, cosine) in zip(coats, shown(furnace(*coats, most_hits=most_hits)), strict=True):
        below = albedo(0.5 if material.metallic else 0.04, cosine, 0.4)
        wanted = over(below, cosine, roughness, material.clearcoat)[:, None]
        if most_hits:  # some rays meet other balls, which are darker
            np.testing.assert_allclose(np.median(radiance / wanted), 1.0, rtol=5e-3)
        else:
            np.testing.assert_allclose(radiance, np.repeat(wanted, 3, 1), rtol=5e-3)
