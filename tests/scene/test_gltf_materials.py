"""What a glTF file's materials look like: colours, textures, and words about what is shown otherwise."""

import base64
import io

import numpy as np
import pytest
from gltf_files import TRIANGLE, Gltf, only_mesh, png, read_and_told, told
from PIL import Image

from reflet.errors import RefletError
from reflet.scene.readers.gltf.materials.specular_glossiness import metallic_roughness

UV = np.float32([[0, 0], [1, 0], [0, 1]])


def textured(**fields):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV, "VEC2")
    return gltf.material(**fields)


def specular_glossiness(gltf, **fields):
    gltf.material(name="old", extensions={"KHR_materials_pbrSpecularGlossiness": fields})
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = ["KHR_materials_pbrSpecularGlossiness"]
    return gltf


# -- specular-glossiness -----------------------------------------------------------------------------------------------


def test_specular_glossiness_of_metals_dielectrics_and_between():
    diffuse = np.array([[0, 0, 0], [0.5, 0.25, 0.125], [0.3, 0.3, 0.3]], float)
    specular = np.array([[0.9, 0.6, 0.3], [0.04, 0.04, 0.04], [0.2, 0.2, 0.2]], float)
    base, metallic, roughness = metallic_roughness(diffuse, specular, np.array([1.0, 0.25, 0.5]))
    np.testing.assert_allclose(metallic[:2], [1, 0], atol=1e-12)
    np.testing.assert_allclose(base[:2], [specular[0], diffuse[1]], atol=1e-6)  # _EPSILON keeps from dividing by 0
    np.testing.assert_array_equal(roughness, [0, 0.75, 0.5])
    # in between, grey: the specular and the diffuse colour are those of the older model
    m, b = metallic[2], base[2, 0]
    # by hand: b = 0.3·0.8/0.96 + 0.2 - 0.08 = 0.37; m = (√(0.37² + 0.16·0.16) - 0.37)/0.08
    assert m == pytest.approx((np.sqrt(0.37**2 + 0.0256) - 0.37) / 0.08, abs=1e-12)
    assert b * m + 0.04 * (1 - m) == pytest.approx(0.2, abs=1e-9)
    assert b * (1 - m) == pytest.approx(0.3 * 0.8 / 0.96, abs=1e-9)


def test_specular_glossiness_factors_become_a_metallic_roughness_material(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    specular_glossiness(gltf, diffuseFactor=[0, 0, 0, 1], specularFactor=[0.9, 0.6, 0.3], glossinessFactor=0.75)
    parts, words = read_and_told(gltf, tmp_path)
    material = parts[0].material
    assert material.base_color == pytest.approx((0.9, 0.6, 0.3), abs=1e-6) and material.name == "old"
    assert material.metallic == pytest.approx(1.0, abs=1e-12) and material.perceptual_roughness == 0.25
    assert words == []


def test_specular_glossiness_textures_are_converted_texel_by_texel(tmp_path):
    """Left a yellow metal, half glossy; right a blue dielectric, matt. The diffuse picture is half as large."""
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV, "VEC2")
    diffuse = gltf.texture(np.array([[[0, 0, 0, 255], [0, 0, 188, 255]]], np.uint8))
    shine = np.array([[[255, 188, 0, 128]] * 2 + [[56, 56, 56, 0]] * 2] * 2, np.uint8)  # sRGB 56 is linear 0.0395
    specular_glossiness(
        gltf, diffuseTexture={"index": diffuse}, specularGlossinessTexture={"index": gltf.texture(shine)}
    )
    material = gltf.read(tmp_path)[0].material
    base, other = material.base_color_texture_srgb.pixels, material.metallic_roughness_texture.pixels
    assert (material.base_color, material.metallic, material.perceptual_roughness) == ((1.0,) * 3, 1.0, 1.0)
    assert base.shape == other.shape == (2, 4, 4)
    np.testing.assert_array_equal(base[:, :2], np.broadcast_to([255, 188, 0, 255], (2, 2, 4)))
    # strength 1 - 0.0395 over 0.96 brightens the diffuse colour by less than half a code
    np.testing.assert_array_equal(base[:, 2:], np.broadcast_to([0, 0, 188, 255], (2, 2, 4)))
    np.testing.assert_array_equal(other[0, :, 1], [127, 127, 255, 255])
    np.testing.assert_array_equal(other[0, :, 2], [255, 255, 0, 0])


# -- pictures ----------------------------------------------------------------------------------------------------------


def test_pictures_that_cannot_be_read_leave_the_factors(tmp_path):
    gltf = textured(
        name="paint",
        pbrMetallicRoughness={"baseColorFactor": [1, 0, 0, 1], "baseColorTexture": {"index": 0}},
        normalTexture={"index": 1},
        emissiveTexture={"index": 2},
    )
    gltf.picture(uri="gone.png")
    gltf.picture(uri="data:image/png;base64," + base64.b64encode(b"no picture").decode())
    gltf.json["textures"].append({"extensions": {"EXT_future": {"source": 0}}})
    gltf.texture(np.zeros((1, 1, 3), np.uint8))  # a fourth one that nothing is wrong with
    parts, words = read_and_told(gltf, tmp_path)
    material = parts[0].material
    assert material.base_color == (1.0, 0.0, 0.0)
    assert material.base_color_texture_srgb is material.normal_texture is material.emission_texture_srgb is None
    assert len(words) == 2 and "EXT_future" in words[1]
    for said in ("(3 of 4 textures: ", f"gone.png is not in {tmp_path}", "image number 1 is not a readable picture",
                 "a texture names no picture"):  # fmt: skip
        assert said in words[0]


def test_a_texture_that_is_not_there_leaves_the_factors(tmp_path):
    parts, words = read_and_told(textured(normalTexture={"index": 2}), tmp_path)
    assert parts[0].material.normal_texture is None
    assert words[0].endswith("show their factors alone (1 textures: it refers to entry 2 of its 0 textures).")


def test_the_bytes_of_a_picture_tell_what_it_is(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (3, 5, 4)).astype(np.uint8)
    gltf = textured(normalTexture={"index": 0})
    gltf.picture(bufferView=gltf.view(png(pixels)), mimeType="image/jpeg")
    np.testing.assert_array_equal(gltf.read(tmp_path)[0].material.normal_texture.pixels, pixels)
    (tmp_path / "My Picture.PNG").write_bytes(png(pixels))
    gltf.json["images"] = [{"uri": "my%20picture.png", "mimeType": "application/octet-stream"}]
    np.testing.assert_array_equal(gltf.read(tmp_path)[0].material.normal_texture.pixels, pixels)


def test_the_first_source_that_can_be_read_is_taken(tmp_path):
    pixels = np.full((2, 2, 4), 200, np.uint8)
    webp = io.BytesIO()
    Image.fromarray(pixels).save(webp, "WEBP", lossless=True)
    for data, expected in ((webp.getvalue(), 200), (b"RIFFbroken", 100)):
        gltf = textured(normalTexture={"index": 0})
        gltf.texture(np.full((2, 2, 4), 100, np.uint8))
        gltf.json["images"].append({"bufferView": gltf.view(data), "mimeType": "image/webp"})
        gltf.json["textures"][0]["extensions"] = {"EXT_texture_webp": {"source": 1}}
        parts, words = read_and_told(gltf, tmp_path)
        assert parts[0].material.normal_texture.pixels[0, 0, 0] == expected and words == []


def test_a_sampler_that_is_not_there_repeats(tmp_path):
    gltf = textured(normalTexture={"index": 0})
    gltf.texture(np.zeros((1, 1, 3), np.uint8))
    gltf.json["textures"][0]["sampler"] = 3
    parts, (word,) = read_and_told(gltf, tmp_path)
    assert parts[0].material.normal_texture.wraps == ("repeat", "repeat")
    assert (
        "textures whose sampler is not there repeat (1 of 1 textures: it refers to entry 3 of its 0 samplers)" in word
    )


def test_coordinates_that_are_missing_or_no_numbers(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.material(normalTexture={"index": gltf.texture(np.zeros((1, 1, 3), np.uint8)), "texCoord": 1})
    gltf.attribute("TEXCOORD_0", UV, "VEC2")
    parts, words = read_and_told(gltf, tmp_path)
    assert only_mesh(parts).uv is None and "no coordinates" in words[0]
    gltf.attribute("TEXCOORD_1", np.float32([[np.nan, 0], [1, np.inf], [0, 1]]), "VEC2")
    parts, words = read_and_told(gltf, tmp_path)
    assert np.isfinite(only_mesh(parts).uv).all() and "count as 0" in words[0]


# -- words -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "cutoff", "factor", "texel", "seen"),
    [
        ("OPAQUE", None, 0.2, 10, "opaque"),
        ("BLEND", None, 1.0, 255, "opaque"),  # as many exporters mark everything
        ("BLEND", None, 1.0, 254, "blend"),
        ("BLEND", None, 0.9, 255, "blend"),
        ("MASK", None, 1.0, 128, "opaque"),
        ("MASK", None, 1.0, 127, "mask"),
        ("MASK", 0.1, 1.0, 127, "opaque"),
    ],
)
def test_only_what_is_seen_through_is_no_longer_opaque(tmp_path, mode, cutoff, factor, texel, seen):
    gltf = textured(name="glass", alphaMode=mode)
    picture = gltf.texture(np.array([[[9, 9, 9, 255], [9, 9, 9, texel]]], np.uint8))
    color = {"baseColorFactor": [1, 1, 1, factor], "baseColorTexture": {"index": picture}}
    gltf.json["materials"][0]["pbrMetallicRoughness"] = color
    if cutoff is not None:
        gltf.json["materials"][0]["alphaCutoff"] = cutoff
    parts, words = read_and_told(gltf, tmp_path)
    material = parts[0].material
    assert (material.alpha_mode, material.alpha) == (seen, factor) and words == []
    assert material.alpha_cutoff == (0.5 if cutoff is None else cutoff)


def test_colours_of_vertices_may_be_seen_through(tmp_path):
    for alpha, mode in ((1.0, "opaque"), (0.5, "blend")):
        gltf = Gltf().attribute("POSITION", TRIANGLE).material(alphaMode="BLEND")
        gltf.attribute("COLOR_0", np.float32([[0, 1, 1, 1], [1, 1, 1, 1], [1, 1, 1, alpha]]), "VEC4")
        assert gltf.read(tmp_path)[0].material.alpha_mode == mode


def test_how_dielectrics_reflect(tmp_path):
    """By index and by KHR_materials_specular: its colour at normal incidence, its factor at all angles."""
    specular = {"specularFactor": 0.5, "specularColorFactor": [1, 0.5, 30]}
    for extensions, f0, f90 in (
        ({}, (0.04,) * 3, 1.0),
        ({"KHR_materials_ior": {"ior": 1.33}}, ((0.33 / 2.33) ** 2,) * 3, 1.0),
        ({"KHR_materials_ior": {"ior": 0}}, (1.0,) * 3, 1.0),
        (
            {"KHR_materials_specular": specular},
            (0.02, 0.01, 0.5),
            0.5,
        ),
    ):
        material = textured(extensions=extensions).read(tmp_path)[0].material
        assert material.dielectric_f0 == pytest.approx(f0, abs=1e-12) and material.dielectric_f90 == f90


def test_coats_and_unlit_surfaces_are_kept(tmp_path):
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25}}
    parts, words = read_and_told(textured(name="a", extensions=coat | {"KHR_materials_unlit": {}}), tmp_path)
    material = parts[0].material
    assert (material.clearcoat, material.clearcoat_roughness, material.unlit) == (0.5, 0.25, True)
    assert words == []


def test_coats_have_textures_of_their_own(tmp_path):
    """Each lies as it says, and bumps have tangents though nothing else is bumpy; glass has no coat."""
    gltf = textured(name="a")
    picture = gltf.texture(np.uint8([[[255, 188, 0, 51], [255, 188, 0, 255]]]))
    turned = {"KHR_texture_transform": {"rotation": 0.5}}
    coat = {
        "clearcoatFactor": 1.5,
        "clearcoatTexture": {"index": picture},
        "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": {"index": picture, "extensions": turned},
        "clearcoatNormalTexture": {"index": picture, "scale": 0.7},
    }
    gltf.json["materials"][0]["extensions"] = {"KHR_materials_clearcoat": coat}
    parts, words = read_and_told(gltf, tmp_path)
    material, mesh = parts[0].material, parts[0].mesh
    assert (material.clearcoat, material.clearcoat_roughness, material.clearcoat_normal_scale) == (1.0, 0.5, 0.7)
    places = [material.textures[f"clearcoat_{name}texture"].coordinates for name in ("", "roughness_", "normal_")]
    assert places[0] == places[2] != places[1]
    assert mesh.tangents is not None and material.normal_texture is None
    assert words == ["a.gltf: clearcoatFactor below 0 or above 1 is taken as the nearer of them (1 of 1 materials: a)."]
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    gltf.json["materials"][0]["extensions"] |= glass | {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}
    gltf.json["materials"][0]["pbrMetallicRoughness"] = {"metallicFactor": 0}
    parts, words = read_and_told(gltf, tmp_path)
    assert parts[0].material.clearcoat == 0.0
    assert "a.gltf: the clear coat of glass is left out (1 of 1 materials: a)." in words


def test_textures_that_lie_in_more_than_four_ways_are_left_out(tmp_path):
    gltf = textured(name="a")
    picture = gltf.texture(np.uint8([[[255, 188, 0, 51]]]))

    def lying(angle):
        return {"index": picture, "extensions": {"KHR_texture_transform": {"rotation": angle}}}

    names = ("clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture")
    coat = {name: lying(0.1 * k) for k, name in enumerate(names, 3)}
    gltf.json["materials"][0] |= {
        "pbrMetallicRoughness": {"baseColorTexture": lying(0.1)}, "normalTexture": lying(0.2),
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, **coat}},
    }  # fmt: skip
    parts, words = read_and_told(gltf, tmp_path)
    assert parts[0].material.clearcoat_roughness_texture is not None
    assert parts[0].material.clearcoat_normal_texture is None
    assert words == ["a.gltf: textures that lie otherwise than 4 others are left out (1 of 1 materials: a)."]


def test_textures_of_reflection_count_as_their_mean(tmp_path):
    gltf = textured(name="a")
    picture = gltf.texture(np.uint8([[[255, 188, 0, 51], [255, 188, 0, 255]]]))  # sRGB 188 is linear 0.503
    both = {"specularTexture": {"index": picture}, "specularColorTexture": {"index": picture}}
    gltf.json["materials"][0]["extensions"] = {"KHR_materials_specular": both}
    parts, words = read_and_told(gltf, tmp_path)
    material = parts[0].material
    assert material.specular == pytest.approx(0.6) and material.specular_color == pytest.approx(
        (1, 0.5029, 0), abs=1e-4
    )
    assert [word.split(" (")[0] for word in words] == [
        "a.gltf: specularColorTexture counts as its mean", "a.gltf: specularTexture counts as its mean",
    ]  # fmt: skip


def test_factors_beyond_their_range_are_put_within_it_in_a_sentence(tmp_path):
    gltf = textured(
        name="odd", emissiveFactor=[-1, 0.5, 2], alphaMode="SOLID",
        pbrMetallicRoughness={"metallicFactor": 1.5, "roughnessFactor": -0.1, "baseColorFactor": [2, 0.5, -1, 3]},
        extensions={"KHR_materials_ior": {"ior": 0.7}},
    )  # fmt: skip
    parts, words = read_and_told(gltf, tmp_path)
    material = parts[0].material
    assert (material.metallic, material.perceptual_roughness, material.base_color) == (1.0, 0.0, (1.0, 0.5, 0.0))
    assert (material.emission, material.alpha, material.ior) == ((0.0, 0.5, 2.0), 1.0, 1.0)
    nearer = "below 0 or above 1 is taken as the nearer of them"
    assert words == [
        f"a.gltf: {what} (1 of 1 materials: odd)."
        for what in (
            f"baseColorFactor {nearer}", f"metallicFactor {nearer}", f"roughnessFactor {nearer}",
            "emissiveFactor below 0 is taken as 0", "an alphaMode that there is not is taken as OPAQUE",
            "an index of refraction below 1 is taken as 1",
        )
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("extension", "value", "said"),
    [
        ("KHR_materials_ior", {"ior": 1.5}, None),
        ("KHR_materials_ior", {"ior": 2.4}, None),
        ("KHR_materials_specular", {"specularFactor": 1.0}, None),
        ("KHR_materials_specular", {"specularColorFactor": [1, 0, 0]}, None),
        ("KHR_materials_transmission", {}, None),
        ("KHR_materials_dispersion", {"dispersion": 0.3}, "glass bends all colours alike"),
        ("KHR_materials_diffuse_transmission", {"diffuseTransmissionFactor": 1}, "shown opaque"),
        ("KHR_materials_unlit", {}, None),
        ("KHR_materials_sheen", {"sheenColorFactor": [0.1, 0, 0]}, "sheen is left out"),
        ("ACME_sparkle", {"much": 3}, "what it adds is left out"),
    ],
)
def test_extensions_of_materials_are_named_where_they_matter(tmp_path, extension, value, said):
    gltf = Gltf().attribute("POSITION", TRIANGLE).material(name="stone", extensions={extension: value})
    words = told(gltf, tmp_path)
    if said is None:
        assert words == []
    else:
        (word,) = words
        assert word.startswith(f"a.gltf: {extension} is not honoured: ") and said in word
        assert word.endswith("(1 of 1 materials: stone).")


def test_many_names_are_counted_not_listed(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["materials"] = [
        {"name": f"m{i}", "extensions": {"KHR_materials_dispersion": {"dispersion": 1}}} for i in range(8)
    ]
    assert told(gltf, tmp_path)[0].endswith(
        "glass bends all colours alike (8 of 8 materials: m0, m1, m2, m3, m4 and 3 more)."
    )


def test_values_that_are_none_are_refused_in_one_sentence(tmp_path):
    for fields, sentence in (
        ({"pbrMetallicRoughness": {"baseColorFactor": [1, 2]}}, "baseColorFactor has 2 of 4 numbers"),
        ({"pbrMetallicRoughness": {"metallicFactor": "shiny"}}, "metallicFactor has 'shiny' where a number belongs"),
        ({"pbrMetallicRoughness": []}, "pbrMetallicRoughness is no object"),
        ({"normalTexture": {"index": -1}}, "index is -1, no whole number"),
    ):
        gltf = Gltf().attribute("POSITION", TRIANGLE).material(**fields)
        with pytest.raises(RefletError, match=sentence) as caught:
            gltf.read(tmp_path)
        assert "\n" not in str(caught.value)
