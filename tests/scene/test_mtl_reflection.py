"""How materials of OBJ files reflect and let light through: exact values, kind by kind."""

import numpy as np
import pytest
from mtl_files import row, square

from reflet.scene.material import Refraction


def silent(folder, lines):
    part, said = square(folder, f"newmtl m\n{lines}\n")
    assert said == []
    return part.material


@pytest.mark.parametrize(
    ("lines", "facing", "grazing"),
    [
        ("Kd 1 1 1", [0.04] * 3, 1.0),  # nothing said: index 1.5
        ("Ks 0.5 0.5 0.5", [0.04] * 3, 1.0),  # Blender's plain one
        ("Ks 0.25 0.25 0.25", [0.02] * 3, 0.5),
        ("Ks 1 1 1", [0.08] * 3, 1.0),
        ("Ks 0.5 0.25 0", [0.04, 0.02, 0.0], 1.0),
        ("Ks 0 0 0\nNs 100", [0.0] * 3, 0.0),
        ("Ni 2", [1 / 9] * 3, 1.0),
        ("Ni 2\nKs 0.25", [1 / 18] * 3, 0.5),
        ("Ni 1.0\nKs .5 .5 .5", [0.04] * 3, 1.0),  # what tools write of all that is opaque
        ("illum 1\nKs 1 1 1", [0.0] * 3, 0.0),
        ("illum 1\nKs .5 .5 .5\nPr 0.2", [0.04] * 3, 1.0),  # physical words outweigh the old model
        ("illum 3\nKs 0.8 0.6 0.4", [0.8, 0.6, 0.4], 1.0),  # mirrors without Fresnel's law along the normal
        ("illum 8\nKs 0.8 0.6 0.4\nNi 1.3", [0.8, 0.6, 0.4], 1.0),
        ("illum 5\nNi 2", [1 / 9] * 3, 1.0),
    ],
)
def test_reflectance_of_what_is_no_metal(tmp_path, lines, facing, grazing):
    material = silent(tmp_path, lines)
    np.testing.assert_allclose(material.dielectric_f0, facing, rtol=1e-12, atol=1e-15)
    assert material.dielectric_f90 == grazing and material.metallic == 0.0
    assert material.reflects == (grazing > 0.0)


@pytest.mark.parametrize(
    ("lines", "roughness"),
    [("illum 3\nKs 1 1 1", 0.0), ("illum 5\nNs 30", 0.5), ("illum 2", 1.0), ("illum 3\nPm 1", 1.0)],
)
def test_models_that_mirror_do_so_sharply_unless_they_say_how_rough(tmp_path, lines, roughness):
    assert silent(tmp_path, lines).perceptual_roughness == roughness


def test_the_mean_of_a_specular_texture(tmp_path):
    row(tmp_path / "ks.png", (255, 255, 255), (0, 0, 0))
    part, said = square(tmp_path, "newmtl m\nKs .5 .5 .5\nmap_Ks ks.png\n")
    assert said == ["a.mtl: map_Ks counts as its mean (m)."]
    np.testing.assert_allclose(part.material.dielectric_f0, 0.02, rtol=1e-12)


def test_clear_coats(tmp_path):
    material = silent(tmp_path, "Pc 0.5\nPcr 0.25")
    assert (material.clearcoat, material.clearcoat_roughness) == (0.5, 0.25)
    row(tmp_path / "coat.png", (51, 51, 51), (204, 204, 204))
    row(tmp_path / "packed.png", (1, 51, 2), (1, 204, 2))
    material = silent(tmp_path, "map_Pc coat.png\nmap_Pcr -imfchan g packed.png")
    assert (material.clearcoat, material.clearcoat_roughness) == (1.0, 1.0)
    for texture in (material.clearcoat_texture, material.clearcoat_roughness_texture):
        assert texture.pixels[0, :, :2].tolist() == [[51, 51], [204, 204]]


@pytest.mark.parametrize("line", ["d 0.25", "Tr 0.75", "d -halo 0.25", "d 0.25\nTr 0.5", "illum 9\nd 0.25\nNi 1.5"])
def test_dissolved_surfaces_are_blended(tmp_path, line):
    material = silent(tmp_path, line)
    assert (material.alpha, material.alpha_mode, material.refraction) == (0.25, "blend", None)


def alphas(material):
    return material.base_color_texture_srgb.pixels[0, :, 3].tolist()


def test_textures_of_opacity(tmp_path):
    row(tmp_path / "holes.png", (255, 255, 255), (0, 0, 0))
    row(tmp_path / "soft.png", (255, 255, 255), (128, 128, 128))
    row(tmp_path / "leaf.png", (10, 20, 30, 255), (40, 50, 60, 0))
    row(tmp_path / "full.png", (255, 255, 255))
    material = silent(tmp_path, "Kd .5 .5 .5\nmap_d holes.png")
    assert (material.alpha_mode, alphas(material), material.base_color) == ("mask", [255, 0], (0.5, 0.5, 0.5))
    assert (material.base_color_texture_srgb.pixels[..., :3] == 255).all()
    material = silent(tmp_path, "map_d soft.png\nd 0.5")
    assert (material.alpha_mode, alphas(material), material.alpha) == ("blend", [255, 128], 0.5)
    material = silent(tmp_path, "map_Tr soft.png")
    assert (material.alpha_mode, alphas(material)) == ("blend", [0, 127])
    material = silent(tmp_path, "map_Kd leaf.png\nmap_d leaf.png")
    assert (material.alpha_mode, alphas(material)) == ("mask", [255, 0])
    assert material.base_color_texture_srgb.pixels[0, :, :3].tolist() == [[10, 20, 30], [40, 50, 60]]
    assert silent(tmp_path, "map_d full.png").alpha_mode == "opaque"
    # alpha of a colour's picture that no line speaks of does not count
    assert silent(tmp_path, "map_Kd leaf.png").alpha_mode == "opaque"
    assert alphas(silent(tmp_path, "map_Kd leaf.png\nd 0.5")) == [255, 255]


@pytest.mark.parametrize("model", [6, 7])
def test_refracting_models_are_glass(tmp_path, model):
    material = silent(tmp_path, f"illum {model}\nKd 0 0 0\nNi 1.33\nTf 0.5 0.75 1")
    assert material.refraction == Refraction(index=1.33) and material.base_color == (0.5, 0.75, 1.0)
    assert material.perceptual_roughness == 0.0
    # Maya writes model 4 and Ni 1 of all that is opaque
    assert silent(tmp_path, "illum 4\nTf 1 1 1\nNi 1").refraction is None
    assert silent(tmp_path, f"illum {model}\nNi 1").refraction is None
