"""How textures of a glTF file lie on a mesh, how they go on beyond their edges, and what colours vertices have."""

import numpy as np
import pytest
from gltf_files import FLOAT, SQUARE, TRIANGLE, UNSIGNED_BYTE, UNSIGNED_SHORT, Gltf, only_mesh, read_and_told, told

from reflet.scene.surface_mean import surface_mean

UV = np.float32([[0, 0], [1, 0], [0, 1]])
WHITE = np.full((1, 1, 3), 255, np.uint8)


# -- colours of vertices -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["bytes", "bytes not marked as fractions", "shorts", "floats"])
def test_colours_of_vertices_are_kept_in_any_type(tmp_path, kind):
    gltf = Gltf().attribute("POSITION", TRIANGLE).material(pbrMetallicRoughness={"baseColorFactor": [0.5, 1, 1, 1]})
    expected = np.float32([[1.0, 0.2, 0.0, 0.6], [0.0, 1.0, 0.4, 1.0], [0.2, 0.0, 0.8, 0.0]])
    if kind == "floats":
        gltf.attribute("COLOR_0", expected, "VEC4", FLOAT)
    elif kind == "shorts":
        gltf.attribute("COLOR_0", np.rint(65535 * expected).astype(np.uint16), "VEC4", UNSIGNED_SHORT, normalized=True)
    else:
        code = np.rint(255 * expected).astype(np.uint8)
        gltf.attribute("COLOR_0", code, "VEC4", UNSIGNED_BYTE, normalized=kind == "bytes")
    parts, words = read_and_told(gltf, tmp_path)
    np.testing.assert_allclose(parts[0].mesh.colors, expected, atol=1e-7)  # fifths are codes of 8 and 16 bits
    assert parts[0].material.base_color == (0.5, 1.0, 1.0) and words == []


def test_colours_without_alpha_are_opaque_and_white_ones_are_none(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("COLOR_0", np.float32([[0.5, 1, 1], [1, 1, 1], [0, 0, 1]]))
    np.testing.assert_array_equal(only_mesh(gltf.read(tmp_path)).colors[:, 3], 1.0)
    white = Gltf().attribute("POSITION", TRIANGLE).attribute("COLOR_0", np.ones((3, 3), np.float32))
    assert only_mesh(white.read(tmp_path)).colors is None


def test_colours_that_are_none_are_put_right_in_a_sentence(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.attribute("COLOR_0", np.float32([[2.0, 0.5, -1.0], [np.nan, 0.25, 0.0], [1.0, np.inf, 0.0]]))
    parts, words = read_and_told(gltf, tmp_path)
    np.testing.assert_array_equal(parts[0].mesh.colors[:, :3], [[1.0, 0.5, 0.0], [1.0, 0.25, 0.0], [1.0, 1.0, 0.0]])
    assert words == [
        "a.gltf: vertex colours that are no numbers count as white (1 of 1 primitives: a).",
        "a.gltf: vertex colours below 0 or above 1 are taken as the nearer of them (1 of 1 primitives: a).",
    ]


def test_colours_go_with_their_vertices_where_these_are_shared_anew(tmp_path):
    """Flat normals and computed tangents make new vertices: each corner keeps its colour and all its coordinates."""
    colors = np.random.default_rng(0).uniform(0, 1, (4, 4)).astype(np.float32)
    for normals in (False, True):
        gltf = Gltf().attribute("POSITION", SQUARE).attribute("COLOR_0", colors, "VEC4")
        gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 2, 0, 2, 3], np.uint8), "SCALAR", UNSIGNED_BYTE)
        gltf.attribute("TEXCOORD_0", SQUARE[:, :2], "VEC2").attribute("TEXCOORD_1", 2 * SQUARE[:, :2], "VEC2")
        gltf.material(
            pbrMetallicRoughness={"baseColorTexture": {"index": gltf.texture(WHITE)}},
            **({"normalTexture": {"index": 0, "texCoord": 1}} if normals else {}),
        )
        mesh = only_mesh(gltf.read(tmp_path))
        assert (mesh.tangents is not None) == normals and len(mesh.more_uv) == normals
        for corner, vertex in zip([0, 1, 2, 0, 2, 3], mesh.triangles.ravel(), strict=True):
            np.testing.assert_array_equal(mesh.colors[vertex], colors[corner])
            np.testing.assert_array_equal(mesh.positions[vertex], SQUARE[corner])
            np.testing.assert_array_equal(mesh.uv[vertex], SQUARE[corner, :2])
            if normals:
                np.testing.assert_array_equal(mesh.more_uv[0][vertex], 2 * SQUARE[corner, :2])


# -- how textures lie --------------------------------------------------------------------------------------------------


def placed(**transform):
    return {"index": 0, "extensions": {"KHR_texture_transform": transform}}


def test_each_texture_lies_as_it_says(tmp_path):
    """Four textures, three ways: the first and the last share one."""
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV, "VEC2")
    gltf.attribute("TEXCOORD_1", 0.25 * UV, "VEC2").texture(WHITE)
    gltf.material(
        pbrMetallicRoughness={
            "baseColorTexture": placed(offset=[0.5, 0.0]),
            "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
        },
        normalTexture=placed(scale=[3, 2], texCoord=1),
        emissiveTexture=placed(offset=[0.5, 0.0]),
    )
    parts, words = read_and_told(gltf, tmp_path)
    material, mesh = parts[0].material, parts[0].mesh
    numbers = [texture.coordinates for texture in material.textures.values() if texture is not None]
    assert numbers == [0, 1, 2, 0] and len(mesh.more_uv) == 2 and words == []
    np.testing.assert_allclose(mesh.uv_set(0)[mesh.triangles[0]], UV + [0.5, 0.0])
    np.testing.assert_allclose(mesh.uv_set(1)[mesh.triangles[0]], 0.25 * UV)
    np.testing.assert_allclose(mesh.uv_set(2)[mesh.triangles[0]], 0.25 * UV * [3, 2])
    assert material.normal_texture.pixels is material.base_color_texture_srgb.pixels


def test_textures_without_their_coordinates_are_left_out_and_the_others_stay(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV, "VEC2")
    gltf.texture(WHITE)
    gltf.material(
        pbrMetallicRoughness={"baseColorTexture": {"index": 0, "texCoord": 3}}, emissiveTexture={"index": 0},
        emissiveFactor=[1, 1, 1],
    )  # fmt: skip
    parts, words = read_and_told(gltf, tmp_path)
    material, mesh = parts[0].material, parts[0].mesh
    assert material.base_color_texture_srgb is None and material.emission_texture_srgb is not None
    np.testing.assert_array_equal(mesh.uv_set(material.emission_texture_srgb.coordinates), UV)
    assert words == ["a.gltf: textures are left out where there are no coordinates for them (1 of 1 primitives: a)."]


@pytest.mark.parametrize(
    ("codes", "wraps"),
    [
        ((33648, 10497), ("mirror", "repeat")),
        ((33071, 33648), ("clamp", "mirror")),
        ((10497, 33071), ("repeat", "clamp")),
    ],
)
def test_pictures_go_on_along_each_axis_as_their_sampler_says(tmp_path, codes, wraps):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", 2 * UV, "VEC2")
    gltf.material(normalTexture={"index": gltf.texture(WHITE)})
    gltf.json["samplers"] = [{"wrapS": codes[0], "wrapT": codes[1]}]
    gltf.json["textures"][0]["sampler"] = 0
    parts, words = read_and_told(gltf, tmp_path)
    assert parts[0].material.normal_texture.wraps == wraps and words == []


def test_a_way_to_wrap_that_there_is_not_repeats(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV, "VEC2")
    gltf.material(normalTexture={"index": gltf.texture(WHITE)})
    gltf.json["samplers"], gltf.json["textures"][0]["sampler"] = [{"wrapS": 7}], 0
    assert told(gltf, tmp_path) == ["a.gltf: textures that wrap in no way of glTF's repeat (1 of 1 textures: 7)."]


def test_the_mean_of_a_material_follows_its_own_coordinates_and_wraps(tmp_path):
    """Green, the roughness, is 0 in the picture's left half, which the first set of coordinates shows alone, and 1 in
    its right half; the second set shows u from 1 to 2: the left half when it repeats, the right half when mirrored."""
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV * np.float32([0.5, 1]), "VEC2")
    gltf.attribute("TEXCOORD_1", UV * np.float32([0.5, 1]) + np.float32([1, 0]), "VEC2")
    halves = np.zeros((1, 2, 3), np.uint8)
    halves[0, 1] = 255
    gltf.texture(halves)
    for codes, expected in ((10497, 0.0), (33648, 1.0), (33071, 1.0)):
        gltf.json["samplers"], gltf.json["textures"][0]["sampler"] = [{"wrapS": codes}], 0
        gltf.material(
            pbrMetallicRoughness={"metallicRoughnessTexture": {"index": 0, "texCoord": 1}},
            emissiveTexture={"index": 0},
        )
        (part,) = gltf.read(tmp_path)
        assert surface_mean(part) == (expected, expected)
