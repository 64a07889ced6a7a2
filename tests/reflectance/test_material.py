"""Materials by their weights, and the maps they ask for."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.reflectance.brdfs.dfg import dfg
from reflet.reflectance.brdfs.fresnel import fresnel_dielectric
from reflet.reflectance.materials.material import (
    Coated,
    Conductor,
    Dielectric,
    DielectricOverDiffuse,
    GlossyGgx,
    GlossyPhong,
    Mirror,
    SurfaceMaterial,
    dfg_table,
)
from reflet.reflectance.materials.material_maps import EnvironmentMaps, prepare

COSINE = np.linspace(0.0, 1.0, 65)
LATLONG, CUBE = PARAMETERIZATIONS["latlong"], PARAMETERIZATIONS["cube"]


def reflected_of_white(material: SurfaceMaterial) -> np.ndarray:
    specular, diffuse = material.weights(COSINE)
    assert specular.shape == diffuse.shape == (*COSINE.shape, 3)
    return specular + diffuse


@pytest.mark.parametrize(
    "material",
    [
        Mirror(),
        Coated(1.5),
        Coated(5.0),
        GlossyPhong(20.0, (0.3, 0.4, 0.5), (0.7, 0.6, 0.5)),
        *(
            GlossyGgx((1.0, 1.0, 1.0), metallic, roughness)
            for metallic in (0.0, 0.5, 1.0)
            for roughness in (0.0, 0.3, 1.0)
        ),
    ],
    ids=repr,
)
def test_white_surfaces_keep_all_light(material: SurfaceMaterial) -> None:
    np.testing.assert_allclose(reflected_of_white(material), 1.0, atol=1e-6)  # float32 of the split sum's table


@pytest.mark.parametrize("roughness", [0.05, 0.4, 1.0])
@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
def test_ggx_never_adds_light(metallic: float, roughness: float) -> None:
    given = reflected_of_white(GlossyGgx((0.9, 0.5, 0.0), metallic, roughness))
    assert given.min() >= 0.0 and given.max() <= 1.0 + 1e-6


@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("rough", [0.1, 0.5, 0.97, 1.0])
def test_ggx_is_the_split_sum(rough: float, metallic: float) -> None:
    """What is partly metal is a mixture of a metal and a dielectric, at the ends of the table as within."""
    for cosine in (0.05, 0.2, 0.6, 1.0):
        a, b = dfg(np.array([cosine]), rough**2, samples=1 << 14)[0]
        paint, metal = ((f0 * a + b) * (1.0 + f0 * (1.0 / (a + b) - 1.0)) for f0 in (0.04, 0.5))
        specular, diffuse = GlossyGgx((0.5, 0.5, 0.5), metallic, rough).weights(np.array(cosine))
        # A table of 32×48 half floats, made of 2048 samples, linear in between.
        np.testing.assert_allclose(specular, paint + metallic * (metal - paint), rtol=4e-3)
        np.testing.assert_allclose(diffuse, 0.5 * (1.0 - metallic) * (1.0 - paint), atol=1e-3)


def test_the_table_goes_from_mirror_to_roughness_1() -> None:
    table = dfg_table()
    np.testing.assert_array_equal(table, table.astype(np.float16))  # as devices hold it
    cosine = np.linspace(0.0, 1.0, table.shape[1]) ** 2
    # float16 of values up to 1; at the horizon sampled half vectors miss some of a mirror's light
    np.testing.assert_allclose(table[0, 2:, 0], 1.0 - (1.0 - cosine[2:]) ** 5, atol=1e-3)
    np.testing.assert_allclose(table[0, 2:, 2], 0.0, atol=1e-2)
    a, b = dfg(cosine[2:], 1.0, samples=1 << 14).T
    np.testing.assert_allclose(table[-1, 2:, :2].sum(-1), a + b, rtol=2e-3)


def test_combinations_of_figure_8() -> None:
    fresnel, albedo = fresnel_dielectric(COSINE, 1.5)[:, None], (0.2, 0.5, 0.8)
    for material, diffuse in (
        (Dielectric(1.5), 0.0 * COSINE[:, None] * np.array(albedo)),
        (DielectricOverDiffuse(1.5, albedo), np.tile(albedo, (65, 1))),
        (Coated(1.5, albedo), (1.0 - fresnel) * np.array(albedo)),
    ):
        specular, below = material.weights(COSINE)
        np.testing.assert_allclose(specular, np.repeat(fresnel, 3, 1))
        np.testing.assert_allclose(below, diffuse)
    # Straight on glass reflects ((1.5 - 1)/(1.5 + 1))² = 4 %; at the horizon everything does.
    np.testing.assert_allclose(Dielectric(1.5).weights(np.array([1.0, 0.0]))[0][:, 0], [0.04, 1.0], atol=1e-12)


def test_a_conductor_without_absorption_is_a_dielectric() -> None:
    metal = Conductor((1.5, 2.0, 3.0), (0.0, 0.0, 0.0)).weights(COSINE)[0]
    for channel, index in enumerate((1.5, 2.0, 3.0)):
        np.testing.assert_allclose(metal[:, channel], fresnel_dielectric(COSINE, index), atol=1e-12)


def test_what_materials_ask_for() -> None:
    direction, _ = LATLONG.texel_directions(48)  # no power of two, and an alpha
    texels = np.concatenate([1.0 + 0.5 * direction, np.ones((*direction.shape[:-1], 1))], -1).astype(np.float32)
    maps = EnvironmentMaps(EnvImage(LATLONG, texels), size=32, parameterization=CUBE)
    mirror = maps.maps(Mirror())
    assert mirror.diffuse is None and mirror.roughness is None
    assert [level.size for level in mirror.reflected] == [32, 16, 8, 4, 2, 1]
    assert mirror.reflected[0].texels.shape[-1] == 3
    phong = maps.maps(GlossyPhong(8.0))
    normal, _ = CUBE.texel_directions(32)
    # L = 1 + d/2 keeps (N + 1)/(N + 2) of its contrast; half a percent for the 48 rows it was given in.
    np.testing.assert_allclose(phong.reflected[0].texels, 1.0 + 0.5 * 0.9 * normal, atol=5e-3)
    assert phong.diffuse is not None
    normal, _ = CUBE.texel_directions(phong.diffuse.size)
    np.testing.assert_allclose(phong.diffuse.texels, 1.0 + normal / 3.0, atol=5e-3)
    assert maps.maps(GlossyPhong(8.0)).reflected is phong.reflected  # kept
    smooth, rough = (maps.maps(GlossyGgx(perceptual_roughness=r)) for r in (0.0, 1.0))
    assert smooth.reflected is rough.reflected
    assert (smooth.roughness, rough.roughness) == (0.0, 1.0)


def test_prepare_serves_one_material() -> None:
    white = EnvImage(CUBE, np.ones((6, 8, 8, 3), np.float32))
    maps = prepare(Coated(1.5), white)
    assert maps.diffuse is not None
    np.testing.assert_allclose(maps.diffuse.texels, 1.0, rtol=5e-4)  # the white furnace's bound


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Dielectric(0.0), "index of refraction"),
        (lambda: Coated(1.5, (1.2, 0.0, 0.0)), "share of light"),
        (lambda: GlossyPhong(-1.0), "exponent"),
        (lambda: GlossyGgx(metallic=2.0), "metallic"),
        (lambda: Conductor((0.0, 1.0, 1.0), (1.0, 1.0, 1.0)), "n > 0"),
        (lambda: Mirror((float("nan"), 0.0, 0.0)), "share of light"),
    ],
)
def test_what_no_material_can_be(make, words: str) -> None:
    with pytest.raises(RefletError, match=words):
        make()
