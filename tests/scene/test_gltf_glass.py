"""Glass in glTF files: transmission, volume, index of refraction."""

import numpy as np
import pytest
from gltf_files import TRIANGLE, Gltf, read_and_told

from reflet.scene.material import Material, Refraction

CLEAR = {"KHR_materials_transmission": {"transmissionFactor": 1}}


def read(tmp_path, extensions, **surface):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    surface = {"metallicFactor": 0, "roughnessFactor": 0} | surface
    gltf.material(name="glass", pbrMetallicRoughness=surface, extensions=extensions)
    parts, words = read_and_told(gltf, tmp_path)
    return parts[0].material, words


@pytest.mark.parametrize(
    ("extensions", "expected"),
    [
        (CLEAR, Refraction(thin=True)),
        (CLEAR | {"KHR_materials_ior": {"ior": 1.33}}, Refraction(index=1.33, thin=True)),
        ({"KHR_materials_transmission": {"transmissionFactor": 0.25}}, Refraction(transmission=0.25, thin=True)),
        (CLEAR | {"KHR_materials_volume": {"thicknessFactor": 0}}, Refraction(thin=True)),
        (CLEAR | {"KHR_materials_volume": {"thicknessFactor": 2}}, Refraction()),
        (
            CLEAR | {"KHR_materials_volume": {
                "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.1, 0.5, 1],
            }},
            Refraction(attenuation_color=(0.1, 0.5, 1.0), attenuation_distance=0.5),
        ),
        # what has no inside attenuates nothing
        (
            CLEAR | {"KHR_materials_volume": {"attenuationDistance": 0.5, "attenuationColor": [0.1, 0.5, 1]}},
            Refraction(thin=True),
        ),
        ({"KHR_materials_transmission": {}}, None),
        ({"KHR_materials_volume": {"thicknessFactor": 2}}, None),
    ],
)  # fmt: skip
def test_extensions_make_glass_and_say_nothing(tmp_path, extensions, expected):
    material, words = read(tmp_path, extensions, baseColorFactor=[0.2, 0.4, 0.6, 1])
    assert material.refraction == expected and words == []
    assert material.double_sided == (expected is not None)
    assert material.base_color == (0.2, 0.4, 0.6)


def test_metals_let_nothing_through(tmp_path):
    material, words = read(tmp_path, CLEAR, metallicFactor=1)
    assert material.refraction is None and material.metallic == 1.0 and words == []
    material, words = read(tmp_path, CLEAR, metallicFactor=0.25)
    assert material.refraction == Refraction(thin=True) and material.metallic == 0.0
    assert words == ["a.gltf: what is partly metal and partly glass is shown as glass (1 of 1 materials: glass)."]


def test_textures_of_transmission_are_said_to_be_left_out(tmp_path):
    textured = {"KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": {"index": 0}}}
    material, words = read(tmp_path, textured)
    assert material.refraction == Refraction(transmission=0.5, thin=True)
    expected = "a.gltf: transmission textures are left out: light goes through alike (1 of 1 materials: glass)."
    assert words == [expected]


def test_an_index_below_one_is_none(tmp_path):
    """0 is glTF's word for what reflects everything."""
    material, words = read(tmp_path, CLEAR | {"KHR_materials_ior": {"ior": 0}})
    assert material.refraction is None
    assert words == ["a.gltf: an index of refraction below 1 lets no light through (1 of 1 materials: glass)."]


def test_attenuation_is_the_colour_at_its_distance():
    """And its square at twice that. [KHR_materials_volume: T(x) = c^(x/d)]"""
    volume = Refraction(attenuation_color=(0.1, 0.5, 1.0), attenuation_distance=0.5)
    np.testing.assert_allclose(np.exp(-volume.absorption * 1.0), [0.01, 0.25, 1.0], rtol=1e-12)
    assert not Refraction(attenuation_color=(0.1, 0.5, 1.0)).absorption.any()
    assert np.isfinite(Refraction(attenuation_color=(0.0, 0.0, 0.0), attenuation_distance=1.0).absorption).all()


def test_glass_is_seen_from_both_sides():
    assert Material(refraction=Refraction()).double_sided and not Material().double_sided
