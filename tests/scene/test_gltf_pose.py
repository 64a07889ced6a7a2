"""Where a glTF file's vertices stand: nodes, instances, skins, morph targets."""

import numpy as np
import pytest
from gltf_files import (
    FLOAT,
    SHORT,
    TRIANGLE,
    UNSIGNED_BYTE,
    UNSIGNED_SHORT,
    Gltf,
    corners,
    only_mesh,
    read_and_told,
    told,
)

from reflet.errors import RefletError, RefletWarning
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.meshes.corners import face_normals

UP = np.tile(np.float32([0, 0, 1]), (3, 1))
HALF = float(np.sqrt(0.5))
QUARTER_TURN = [0, 0, HALF, HALF]  # about z: x becomes y, y becomes -x


def matrices(*rows):
    """As a file stores them: columns first."""
    return np.stack(rows).transpose(0, 2, 1).astype(np.float32).reshape(len(rows), 16)


def moved(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def skinned(joints, weights, inverse_bind=None):
    """A triangle on a node that stands far off, which does not count, and two joints below a node of their own."""
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("NORMAL", UP)
    gltf.attribute("JOINTS_0", np.array(joints, np.uint8), "VEC4", UNSIGNED_BYTE)
    gltf.attribute("WEIGHTS_0", np.array(weights, np.float32), "VEC4")
    gltf.json["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0], "scale": [-5, 5, 5], "name": "body"},
        {"children": [2, 3], "translation": [1, 0, 0]},
        {"name": "hip"},
        {"name": "knee", "translation": [0, 0, 2], "rotation": QUARTER_TURN},
    ]
    gltf.json["scenes"] = [{"nodes": [0, 1]}]
    gltf.json["skins"] = [{"joints": [2, 3]}]
    if inverse_bind is not None:
        gltf.json["skins"][0]["inverseBindMatrices"] = gltf.accessor(inverse_bind, "MAT4")
    return gltf


def posed(gltf, folder):
    """The one mesh, of whose skin it is said how it is shown."""
    with pytest.warns(RefletWarning, match="skins are shown in the pose that the file gives their joints"):
        return only_mesh(gltf.read(folder))


def test_a_skin_follows_its_joints_and_not_the_node_that_holds_it(tmp_path):
    """Corner 0 with the hip, corner 1 with the knee, corner 2 half with each; weights count by their share."""
    weights = [[2, 0, 0, 0], [0, 0.5, 0, 0], [3, 3, 0, 0]]
    gltf = skinned([[0, 1, 0, 0]] * 3, weights, matrices(moved(-1, 0, 0), moved(0, 0, -1)))
    parts, words = read_and_told(gltf, tmp_path)
    # hip: p - x + x. Knee: down by 1, turned, up by 2, and 1 along x
    expected = [[0, 0, 0], [1, 1, 1], np.mean([[0, 1, 0], [0, 0, 1]], axis=0)]
    np.testing.assert_allclose(corners(only_mesh(parts))[0], expected, atol=1e-6)  # float32
    np.testing.assert_allclose(only_mesh(parts).normals, UP, atol=1e-6)
    assert words == ["a.gltf: skins are shown in the pose that the file gives their joints (1 of 4 nodes: body)."]


def test_further_joints_missing_matrices_and_weights_in_bytes(tmp_path):
    gltf = skinned([[0, 9, 9, 9]] * 3, [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]])  # unused joints may be anything
    gltf.attribute("JOINTS_1", np.array([[0, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]], np.uint16), "VEC4", UNSIGNED_SHORT)
    weights = np.array([[0, 0, 0, 0], [51, 0, 0, 0], [0, 0, 0, 0]], np.uint8)
    gltf.attribute("WEIGHTS_1", weights, "VEC4", UNSIGNED_BYTE)  # without "normalized", as some tools write them
    expected = [[1, 0, 0], [1, 1, 2], [1, 1, 0]]  # corner 2 has no weights and stays with its first joint
    np.testing.assert_allclose(corners(posed(gltf, tmp_path))[0], expected, atol=1e-6)


def test_joints_that_mirror_turn_the_winding_and_the_frame(tmp_path):
    gltf = skinned([[0, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    gltf.json["nodes"][2]["scale"] = [-1, 2, 1]
    mesh = posed(gltf, tmp_path)
    front, _ = face_normals(corners(mesh).reshape(-1, 3))
    np.testing.assert_allclose(front, [[0, 0, 1]], atol=1e-6)
    np.testing.assert_allclose(mesh.normals, UP, atol=1e-6)
    assert sorted(corners(mesh)[0].tolist()) == [[0, 0, 0], [1, 0, 0], [1, 2, 0]]


def test_a_skin_that_cannot_be_followed(tmp_path):
    gltf = skinned([[0, 5, 0, 0]] * 3, [[1, 1, 0, 0]] * 3)
    with pytest.raises(RefletError, match="joint 5 of 2"):
        gltf.read(tmp_path)
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"] = [{"mesh": 0, "skin": 0, "translation": [5, 0, 0]}]
    gltf.json["skins"] = [{"joints": [0]}]
    parts, words = read_and_told(gltf, tmp_path)
    assert "what has a skin but no joints stands as its node does (1 of 1 nodes: node 0)" in words[0]
    np.testing.assert_array_equal(corners(only_mesh(parts))[0], TRIANGLE + np.float32([5, 0, 0]))


@pytest.mark.parametrize(("of_mesh", "of_node", "share"), [(None, None, 0), ([0.5], None, 0.5), ([0.5], [2.0], 2)])
def test_morph_targets_count_by_their_default_weights(tmp_path, of_mesh, of_node, share):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("NORMAL", UP)
    shift, lean = np.float32([[0, 0, 3], [0, 0, 0], [0, 4, 0]]), np.float32([[1, 0, 0]] * 3)
    gltf.primitive["targets"] = [{"POSITION": gltf.accessor(shift, "VEC3"), "NORMAL": gltf.accessor(lean, "VEC3")}]
    if of_mesh:
        gltf.json["meshes"][0]["weights"] = of_mesh
    if of_node:
        gltf.json["nodes"][0]["weights"] = of_node
    parts, words = read_and_told(gltf, tmp_path)
    np.testing.assert_array_equal(corners(only_mesh(parts))[0], TRIANGLE + np.float32(share) * shift)
    normal = np.array([share, 0, 1]) / np.hypot(share, 1)
    np.testing.assert_allclose(only_mesh(parts).normals, np.tile(normal, (3, 1)), atol=1e-6)
    assert words == []


def test_accessors_without_a_view_are_zero(tmp_path):
    """As exporters write targets that move nothing, alone or with a few sparse elements."""
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["accessors"].append({"componentType": FLOAT, "count": 3, "type": "VEC3"})
    gltf.primitive["targets"] = [{"POSITION": 1}]
    gltf.json["meshes"][0]["weights"] = [1]
    np.testing.assert_array_equal(corners(only_mesh(gltf.read(tmp_path)))[0], TRIANGLE)
    places = gltf.view(np.array([2], np.uint8).tobytes())
    values = gltf.view(np.float32([0, 0, 5]).tobytes())
    gltf.json["accessors"][1]["sparse"] = {
        "count": 1, "values": {"bufferView": values},
        "indices": {"bufferView": places, "componentType": UNSIGNED_BYTE},
    }  # fmt: skip
    expected = TRIANGLE + np.float32([[0, 0, 0], [0, 0, 0], [0, 0, 5]])
    np.testing.assert_array_equal(corners(only_mesh(gltf.read(tmp_path)))[0], expected)


def test_morph_targets_move_before_joints_do(tmp_path):
    gltf = skinned([[1, 0, 0, 0]] * 3, [[1, 0, 0, 0]] * 3)
    gltf.primitive["targets"] = [{"POSITION": gltf.accessor(np.float32([[1, 0, 0]] * 3), "VEC3")}]
    gltf.json["meshes"][0]["weights"] = [1]
    expected = [[1, 1, 2], [1, 2, 2], [0, 1, 2]]
    np.testing.assert_allclose(corners(posed(gltf, tmp_path))[0], expected, atol=1e-6)


def test_every_instance_is_a_part_of_its_own(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    turns = np.array([[0, 0, 0, 32767], [0, 0, 23170, 23170]], np.int16)
    attributes = {
        "TRANSLATION": gltf.accessor(np.float32([[1, 0, 0], [0, 5, 0]]), "VEC3"),
        "ROTATION": gltf.accessor(turns, "VEC4", SHORT, normalized=True),
        "SCALE": gltf.accessor(np.float32([[2, 2, 2], [1, 1, 1]]), "VEC3"),
    }
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    gltf.json["nodes"] = [{"mesh": 0, "translation": [0, 0, 7], "extensions": instancing, "name": "leaf"}]
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    parts, words = read_and_told(gltf, tmp_path)
    assert words == []
    first, second = (corners(part.mesh)[0] for part in parts)
    np.testing.assert_allclose(first, [[1, 0, 7], [3, 0, 7], [1, 2, 7]], atol=1e-6)
    np.testing.assert_allclose(second, [[0, 5, 7], [0, 6, 7], [-1, 5, 7]], atol=1e-6)  # quaternions count by direction
    scene = assemble(parts, environment=EnvironmentLight(np.ones((2, 4, 3), np.float32)))
    assert [part.name for part in scene.parts] == ["leaf", "leaf_2"]
    attributes["SCALE"] = gltf.accessor(np.float32([[2, 2, 2]]), "VEC3")
    with pytest.raises(RefletError, match="different counts"):
        gltf.read(tmp_path)


def test_hidden_nodes_are_left_out_with_all_below_them(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}}
    gltf.json["nodes"] = [{"children": [1], **hidden}, {"mesh": 0, "name": "below"}, {"mesh": 0, "name": "beside"}]
    gltf.json["scenes"] = [{"nodes": [0, 2]}]
    parts, words = read_and_told(gltf, tmp_path)
    assert [part.name for part in parts] == ["beside"] and words == []


def test_the_scene_that_is_shown(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"] = [{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "children": [2]}, {"mesh": 0, "name": "c"}]
    gltf.json["scenes"] = [{"nodes": [0]}, {"nodes": [2, 1, 1], "name": "second"}]
    gltf.json["scene"] = 1
    parts, words = read_and_told(gltf, tmp_path)
    assert [part.name for part in parts] == ["b", "c"]  # a child that is listed too is shown once
    assert words == ["a.gltf: only the scene it opens with is shown (1 of 2 scenes: second)."]
    gltf.json["scene"] = 4
    parts, words = read_and_told(gltf, tmp_path)
    assert [part.name for part in parts] == ["a"] and "the first is shown (1 of 2 scenes: number 5)" in words[0]
    del gltf.json["scenes"], gltf.json["scene"]
    assert [part.name for part in gltf.read(tmp_path)] == ["a", "b", "c"]
    gltf.json["scenes"] = [{}]
    assert gltf.read(tmp_path) == []  # which assembling refuses


def test_trees_that_are_none_are_refused(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    for nodes, sentence in (
        ([{"children": [2]}, {"children": [2]}, {"mesh": 0}], "node 2 is a child of two nodes, 0 and 1"),
        ([{"mesh": 0}, {"children": [1]}], "contain themselves"),
        ([{"children": [7]}], "entry 7 of its 1 nodes"),
        ([{"mesh": 0, "translation": [0, float("nan"), 0]}], "translation has nan where a number belongs"),
        ([{"mesh": 0, "matrix": [1, 0, 0]}], "matrix has 3 of 16 numbers"),
    ):
        gltf.json["nodes"] = nodes
        with pytest.raises(RefletError, match=sentence):
            gltf.read(tmp_path)


def test_a_quaternion_turns_whatever_its_length(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"][0]["rotation"] = [0, 0, 3, 3]
    expected = [[0, 0, 0], [0, 1, 0], [-1, 0, 0]]
    np.testing.assert_allclose(corners(only_mesh(gltf.read(tmp_path)))[0], expected, atol=1e-6)
    gltf.json["nodes"][0]["rotation"] = [0, 0, 0, 0]
    np.testing.assert_array_equal(corners(only_mesh(gltf.read(tmp_path)))[0], TRIANGLE)


def test_animations_and_cameras_are_counted(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["animations"] = [{"name": "walk", "channels": [], "samplers": []}, {"channels": [], "samplers": []}]
    gltf.json["cameras"] = [{"type": "perspective", "name": "front"}]
    assert told(gltf, tmp_path) == [
        "a.gltf: animations are not played, and everything stands as the file's nodes do "
        "(2 of 2 animations: walk, number 1).",
        "a.gltf: cameras are left out (1 of 1 cameras: front).",
    ]


def test_blocks_of_vertices_meet_without_a_gap(tmp_path):
    """Large meshes go through their transforms in blocks."""
    points = np.random.default_rng(2).random((70001, 3)).astype(np.float32)
    gltf = Gltf().attribute("POSITION", points[: 70001 // 3 * 3]).attribute("NORMAL", points[: 70001 // 3 * 3])
    gltf.json["nodes"][0]["scale"] = [2, 2, 2]
    mesh = only_mesh(gltf.read(tmp_path))
    np.testing.assert_array_equal(mesh.positions, 2 * points[: len(mesh.positions)])
    lengths = np.linalg.norm(mesh.normals, axis=1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-6)
    del gltf.primitive["attributes"]["NORMAL"]
    flat = only_mesh(gltf.read(tmp_path))
    np.testing.assert_array_equal(corners(flat), 2 * points[: len(flat.positions)].reshape(-1, 3, 3))
    np.testing.assert_allclose(flat.normals[::3], face_normals(corners(flat).reshape(-1, 3))[0], atol=1e-7)
