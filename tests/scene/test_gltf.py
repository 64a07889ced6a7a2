import tracemalloc

import numpy as np
import pytest
from gltf_files import (
    FLOAT,
    SHORT,
    SQUARE,
    TRIANGLE,
    UNSIGNED_BYTE,
    UNSIGNED_INT,
    UNSIGNED_SHORT,
    Gltf,
    corners,
    only_mesh,
    read_and_told,
    told,
)

from reflet.errors import RefletError, RefletWarning
from reflet.scene.meshes.corners import corner_tangents, face_normals
from reflet.scene.readers.gltf.read import read_gltf


def test_missing_normals_are_flat_and_point_to_the_counter_clockwise_side(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    mesh = only_mesh(gltf.read(tmp_path))
    np.testing.assert_array_equal(corners(mesh)[0], TRIANGLE)
    np.testing.assert_array_equal(mesh.normals, np.tile(np.float32([0, 0, 1]), (3, 1)))


def test_no_material_is_a_mirror_and_a_material_without_values_is_rough_white_metal(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    mirror = gltf.read(tmp_path)[0].material
    assert (mirror.base_color, mirror.metallic, mirror.perceptual_roughness) == ((0.65,) * 3, 1.0, 0.0)
    gltf.json["materials"] = [{}]
    gltf.primitive["material"] = 0
    default = gltf.read(tmp_path)[0].material
    assert (default.base_color, default.metallic, default.perceptual_roughness) == ((1.0,) * 3, 1.0, 1.0)


@pytest.mark.parametrize(
    ("mode", "expected"), [(5, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]), (6, [[1, 2, 0], [2, 3, 0], [3, 4, 0]])]
)
def test_strips_and_fans(tmp_path, mode, expected):
    points = np.random.default_rng(0).random((5, 3)).astype(np.float32)
    gltf = Gltf().attribute("POSITION", points)
    gltf.primitive["mode"] = mode
    np.testing.assert_array_equal(corners(only_mesh(gltf.read(tmp_path))), points[np.array(expected)])


def test_interleaved_sparse_and_normalized_accessors(tmp_path):
    gltf = Gltf()
    packed = np.zeros(4, np.dtype([("position", "<f4", 3), ("uv", "<u2", 2)]))
    packed["position"], packed["uv"] = SQUARE, [[0, 0], [65535, 0], [65535, 65535], [0, 32768]]
    view = gltf.view(packed.tobytes(), byteStride=16)
    indices = gltf.view(np.array([2], np.uint16).tobytes())
    values = gltf.view(np.float32([5, 6, 7]).tobytes())
    substitutes = {"bufferView": indices, "componentType": UNSIGNED_SHORT}
    sparse = {"count": 1, "indices": substitutes, "values": {"bufferView": values}}
    common = {"bufferView": view, "count": 4}
    gltf.json["accessors"] = [
        {**common, "componentType": FLOAT, "type": "VEC3", "sparse": sparse},
        {**common, "byteOffset": 12, "componentType": UNSIGNED_SHORT, "type": "VEC2", "normalized": True},
    ]
    gltf.primitive["attributes"] = {"POSITION": 0, "TEXCOORD_0": 1}
    gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 2, 0, 2, 3], np.uint8), "SCALAR", UNSIGNED_BYTE)
    mesh = only_mesh(gltf.read(tmp_path))
    moved = SQUARE.copy()
    moved[2] = (5, 6, 7)
    order = [0, 1, 2, 0, 2, 3]
    np.testing.assert_array_equal(corners(mesh).reshape(-1, 3), moved[order])
    expected = np.float32([[0, 0], [1, 0], [1, 1], [0, 32768 / 65535]])
    np.testing.assert_array_equal(mesh.uv[mesh.triangles].reshape(-1, 2), expected[order])


def test_signed_normalized_integers_stop_at_minus_one(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    quantized = np.array([[0, 0, 32767], [0, 0, -32768], [32767, 0, 0]], np.int16)
    quantized = np.column_stack([quantized, np.zeros(3, np.int16)])  # padded to four bytes, as glTF asks
    view = gltf.view(quantized.tobytes(), byteStride=8)
    gltf.json["accessors"].append(
        {"bufferView": view, "componentType": SHORT, "count": 3, "type": "VEC3", "normalized": True}
    )
    gltf.primitive["attributes"]["NORMAL"] = 1
    np.testing.assert_array_equal(only_mesh(gltf.read(tmp_path)).normals, [[0, 0, 1], [0, 0, -1], [1, 0, 0]])


def test_transforms_reach_the_world_through_the_hierarchy(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    half = np.sqrt(0.5)
    gltf.json["nodes"] = [{"children": [1], "translation": [10, 0, 0], "rotation": [0, 0, half, half]},
                          {"mesh": 0, "scale": [2, 3, 4], "translation": [1, 0, 0]}]  # fmt: skip
    # scaled, moved by +x, turned 90° about z (x becomes y, y becomes -x), moved by 10
    expected = [[10, 1, 0], [10, 3, 0], [7, 1, 0]]
    np.testing.assert_allclose(corners(only_mesh(gltf.read(tmp_path)))[0], expected, atol=1e-6)  # float32


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (2, -0.5, 3), (-1, -2, -3)])
def test_fronts_stay_fronts_and_tangent_frames_follow_the_surface(tmp_path, scale):
    """Whatever the transform: normals face the counter-clockwise side, bitangents run up the image."""
    gltf = Gltf().attribute("POSITION", SQUARE).attribute("NORMAL", np.tile(np.float32([0, 0, 1]), (4, 1)))
    gltf.attribute("TANGENT", np.tile(np.float32([1, 0, 0, 1]), (4, 1)), "VEC4")
    gltf.attribute("TEXCOORD_0", np.float32([[0, 1], [1, 1], [1, 0], [0, 0]]), "VEC2")
    gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 2, 0, 2, 3], np.uint16), "SCALAR", UNSIGNED_SHORT)
    texture = gltf.texture(np.full((2, 2, 3), 128, np.uint8))
    gltf.json["materials"] = [{"normalTexture": {"index": texture}}]
    gltf.primitive["material"] = 0
    gltf.json["nodes"][0]["scale"] = scale
    mesh = only_mesh(gltf.read(tmp_path))
    front, _ = face_normals(corners(mesh).reshape(-1, 3))
    np.testing.assert_allclose(np.einsum("ti,tki->tk", front, mesh.normals[mesh.triangles]), 1.0, atol=1e-6)
    bitangent = mesh.tangents[:, 3:] * np.cross(mesh.normals, mesh.tangents[:, :3])
    up = np.array([0, np.sign(scale[1]), 0])  # the image's up is local +y
    np.testing.assert_allclose(bitangent, np.tile(up, (4, 1)), atol=1e-6)


@pytest.mark.parametrize("mirrored", [False, True])
def test_computed_tangents_agree_with_their_definition(mirrored):
    """On a tilted plane: the tangent is the direction of growing u, the bitangent that of falling v."""
    frame = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    frame *= np.linalg.det(frame)
    x, y, normal = frame.T
    plane = np.array([[0, 0], [2, 0], [0, 3], [2, 0], [2, 3], [0, 3]], float)
    uv = np.column_stack([(-1.0 if mirrored else 1.0) * plane[:, 0], 1.0 - plane[:, 1]])
    tangents = corner_tangents(plane @ np.stack([x, y]), np.tile(normal, (6, 1)), uv)
    np.testing.assert_allclose(tangents[:, :3], np.tile(-x if mirrored else x, (6, 1)), atol=1e-7)
    np.testing.assert_allclose(tangents[:, 3:] * np.cross(normal, tangents[:, :3]), np.tile(y, (6, 1)), atol=1e-7)


def test_texture_transform_is_baked_into_uv(tmp_path):
    """The extension's matrix, written out: u' = cos·sx·u + sin·sy·v + ox, v' = cos·sy·v - sin·sx·u + oy."""
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.attribute("TEXCOORD_1", np.float32([[0, 0], [1, 0], [0, 1]]), "VEC2")
    transform = {"offset": [0.25, 0.5], "rotation": np.pi / 2, "scale": [2, 3], "texCoord": 1}
    info = {"index": gltf.texture(np.zeros((2, 2, 3), np.uint8)), "extensions": {"KHR_texture_transform": transform}}
    gltf.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": info}}]
    gltf.primitive["material"] = 0
    np.testing.assert_allclose(only_mesh(gltf.read(tmp_path)).uv, [[0.25, 0.5], [0.25, -1.5], [3.25, 0.5]], atol=1e-6)


def test_emission_times_strength_and_textures_row_zero_first(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    pixels = np.random.default_rng(0).integers(0, 256, (3, 5, 4)).astype(np.uint8)
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 6.0}}
    gltf.json["materials"] = [{"emissiveFactor": [0.5, 0.25, 0], "extensions": strength, "doubleSided": True,
                               "emissiveTexture": {"index": gltf.texture(pixels)}}]  # fmt: skip
    gltf.primitive["material"] = 0
    with pytest.warns(RefletWarning, match="textures are left out where there are no coordinates"):
        material = gltf.read(tmp_path)[0].material
    assert material.emission == (3.0, 1.5, 0.0) and material.double_sided
    np.testing.assert_array_equal(material.emission_texture_srgb.pixels, pixels)


def test_glb_and_truncated_glb(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    np.testing.assert_array_equal(corners(only_mesh(read_gltf(tmp_path / "a.glb")))[0], TRIANGLE)
    data = (tmp_path / "a.glb").read_bytes()
    for kept in (0, 3, 15, len(data) // 2, len(data) - 12):
        (tmp_path / "b.glb").write_bytes(data[:kept])
        with pytest.raises(RefletError, match=r"b\.glb"):
            read_gltf(tmp_path / "b.glb")


def test_what_is_not_honoured_is_said_once_each_and_what_is_required_is_refused(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["extensionsUsed"] = ["EXT_lights_image_based", "KHR_materials_iridescence", "KHR_materials_sheen"]
    gltf.json["nodes"] = [{"mesh": 0}, {"extensions": {"EXT_lights_image_based": {"light": 0}}, "name": "lamp"}]
    film = {"extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 1}}}
    none = {"extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 0}}}  # changes nothing
    gltf.json["materials"] = [{"name": "soap", **film}, {"name": "wood", **none}, {"name": "oil", **film}]
    left_out = [
        "a.gltf: KHR_materials_iridescence is not honoured: iridescent surfaces keep their base colour "
        "(2 of 3 materials: soap, oil).",
        "a.gltf: EXT_lights_image_based is not honoured: its environment is left out (1 of 2 nodes: lamp).",
    ]
    assert told(gltf, tmp_path) == left_out
    gltf.json["extensionsRequired"] = ["KHR_gaussian_splatting"]
    with pytest.raises(RefletError, match=r"requires KHR_gaussian_splatting, .*; export it without"):
        gltf.read(tmp_path)
    gltf.json["extensionsRequired"] = ["KHR_techniques_webgl"]
    with pytest.raises(RefletError, match=r"convert it with: npx gltf-pipeline -i .*a\.gltf -o a-2\.gltf"):
        gltf.read(tmp_path)
    gltf.json["extensionsRequired"] = ["KHR_materials_unlit", "ACME_materials_velvet", "EXT_lights_ies"]
    parts, words = read_and_told(gltf, tmp_path)
    assert len(parts) == 1 and words == left_out  # a mesh is a mesh without them


def test_broken_files_are_refused_in_one_sentence(tmp_path):
    broken = []
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 7], np.uint16), "SCALAR", UNSIGNED_SHORT)
    broken.append((gltf, "vertex 7 of 3"))
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["accessors"][0]["count"] = 30
    broken.append((gltf, "ends behind"))
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"] = [{"children": [1]}, {"children": [0], "mesh": 0}]
    broken.append((gltf, "contain themselves"))
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"][0]["mesh"] = 4
    broken.append((gltf, "entry 4 of its 1 meshes"))
    for gltf, sentence in broken:
        with pytest.raises(RefletError, match=sentence) as caught:
            gltf.read(tmp_path)
        assert "\n" not in str(caught.value)
    (tmp_path / "text.gltf").write_text("nothing of the kind")
    with pytest.raises(RefletError):
        read_gltf(tmp_path / "text.gltf")


def test_memory_stays_within_three_times_the_arrays_of_the_file(tmp_path):
    """The file's bytes, the mesh, and blocks of rows in between: no float64 copy of the whole."""
    size = 700
    x, y = np.meshgrid(np.arange(size, dtype=np.float32), np.arange(size, dtype=np.float32))
    gltf = Gltf().attribute("POSITION", np.stack([x, y, 0 * x], -1).reshape(-1, 3))
    gltf.attribute("NORMAL", np.tile(np.float32([0, 0, 1]), (size * size, 1)))
    i = np.arange(size * size, dtype=np.uint32).reshape(size, size)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    triangles = np.stack([a, b, c, a, c, d], -1).reshape(-1)
    gltf.attribute("TEXCOORD_0", np.stack([x, y], -1).reshape(-1, 2), "VEC2")
    gltf.primitive["indices"] = gltf.accessor(triangles, "SCALAR", UNSIGNED_INT)
    gltf.json["nodes"][0]["scale"] = [-2, 2, 2]
    (tmp_path / "a.glb").write_bytes(gltf.glb())
    tracemalloc.start()
    try:
        mesh = only_mesh(read_gltf(tmp_path / "a.glb"))
        kept, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(mesh.triangles) == 2 * (size - 1) ** 2
    assert kept < 1.1 * len(gltf.data)  # the file's bytes are let go
    assert peak < 3 * len(gltf.data)
