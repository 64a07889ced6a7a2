"""Files around glTF documents as tools and people write them, and damaged ones."""

import base64
import gzip
import json
import random

import numpy as np
import pytest
from gltf_files import (
    SQUARE,
    TRIANGLE,
    UNSIGNED_BYTE,
    UNSIGNED_SHORT,
    Gltf,
    chunk,
    corners,
    glb,
    only_mesh,
    read_and_told,
)
from test_gltf_compressed import draco, ktx2, with_basis_texture

from reflet.errors import RefletError
from reflet.scene.readers.gltf.read import read_gltf


def triangle():
    gltf = Gltf().attribute("POSITION", TRIANGLE)
    gltf.json["nodes"][0]["name"] = "Höhe"
    return gltf


def parts_of_glb():
    gltf = triangle()
    gltf.json["buffers"] = [{"byteLength": len(gltf.data)}]
    return json.dumps(gltf.json).encode(), gltf.data


# -- JSON --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
@pytest.mark.parametrize("ascii_only", [False, True])
def test_text_in_every_encoding_of_editors(tmp_path, encoding, ascii_only):
    text = json.dumps({**json.loads(triangle().finished())}, ensure_ascii=ascii_only)
    (tmp_path / "a.gltf").write_bytes(text.encode(encoding))
    (part,) = read_gltf(tmp_path / "a.gltf")
    assert part.name == "Höhe"
    np.testing.assert_array_equal(corners(part.mesh)[0], TRIANGLE)


def test_names_that_cannot_be_printed_are_mended(tmp_path):
    gltf = triangle()
    gltf.json["nodes"][0]["name"] = "a\ud800b"
    (part,) = gltf.read(tmp_path)
    assert part.name == "a?b"


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"", "begins with '' and is no JSON"),
        (b"solid cube\nfacet", "begins with 'solid cube"),
        (b"<!DOCTYPE html>", "begins with '<!DOCTYPE html>'"),
        (gzip.compress(b"{}", mtime=0), "is no glTF 2.0 file"),
        (b"[1, 2]", "the document is no object"),
        (b"[" * 100_000, "is no JSON"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0", "git lfs pull"),
        (b'{"asset": {"version": "1.0"}, "scenes": {"a": {"nodes": []}}}', "npx gltf-pipeline -i .*a.gltf -o a-2.gltf"),
        (b'{"scenes": {"a": {"nodes": []}}}', "is glTF 1.0"),
        (b'{"asset": [2], "scenes": []}', "asset is no object"),
        (b'{"asset": {"version": "2.0"}, "nodes": {"a": 1}}', "nodes is no list"),
        (b'{"asset": {"version": "2.0"}, "nodes": ["a"]}', "an entry of nodes is no object"),
    ],
)
def test_what_is_no_document_is_refused(tmp_path, data, sentence):
    (tmp_path / "a.gltf").write_bytes(data)
    with pytest.raises(RefletError, match=sentence) as caught:
        read_gltf(tmp_path / "a.gltf")
    assert "\n" not in str(caught.value)


def test_a_document_without_anything_holds_no_parts(tmp_path):
    (tmp_path / "a.gltf").write_text('{"asset": {"version": "2.0"}}')
    assert read_gltf(tmp_path / "a.gltf") == []


# -- GLB ---------------------------------------------------------------------------------------------------------------


def test_the_bytes_tell_the_container_and_not_the_name(tmp_path):
    (tmp_path / "a.gltf").write_bytes(triangle().glb())
    (tmp_path / "b.glb").write_text(triangle().finished())
    for name in ("a.gltf", "b.glb"):
        np.testing.assert_array_equal(corners(only_mesh(read_gltf(tmp_path / name)))[0], TRIANGLE)


def loosely_written():
    text, data = parts_of_glb()
    spaced = text + b" " * (-len(text) % 4)
    odd = text + b" " * (1 - len(text) % 4 + 4)  # one byte over a multiple of four
    yield "wrong length", glb(chunk(b"JSON", spaced), chunk(b"BIN\0", data), length=20)
    yield "length of 0", glb(chunk(b"JSON", spaced), chunk(b"BIN\0", data), length=0)
    yield "bytes behind", glb(chunk(b"JSON", spaced), chunk(b"BIN\0", data)) + b"\0\0\0 appended by a server"
    yield "no padding", glb(chunk(b"JSON", odd), chunk(b"BIN\0", data))
    yield "uncounted padding", glb(chunk(b"JSON", odd) + b"\0" * 3, chunk(b"BIN\0", data))
    yield "zeros for blanks", glb(chunk(b"JSON", text + b"\0" * (-len(text) % 4)), chunk(b"BIN\0", data))
    yield "byte-order mark", glb(chunk(b"JSON", b"\xef\xbb\xbf" + spaced), chunk(b"BIN\0", data))
    yield "a chunk between", glb(chunk(b"JSON", spaced), chunk(b"NEW\0", b"abcd"), chunk(b"BIN\0", data))
    yield "two chunks of bytes", glb(chunk(b"JSON", spaced), chunk(b"BIN\0", data), chunk(b"BIN\0", b"\1" * 36))


@pytest.mark.parametrize(("how", "data"), loosely_written())
def test_binary_files_that_are_loosely_written(tmp_path, how, data):
    (tmp_path / "a.glb").write_bytes(data)
    np.testing.assert_array_equal(corners(only_mesh(read_gltf(tmp_path / "a.glb")))[0], TRIANGLE, how)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (glb(chunk(b"JSON", b"{}"), version=1), "npx gltf-pipeline -i .*my model.glb' -o 'my model-2.glb'"),
        (glb(chunk(b"JSON", b"{}"), version=7), "version 7"),
        (glb(chunk(b"BIN\0", b"{}")), "no JSON chunk"),
        (glb(chunk(b"JSON", b"{}" + b" " * 90))[:60], "ends after 40 of the 92 bytes of its JSON"),
        (glb(chunk(b"JSON", b'{"asset":')), "is no JSON"),
    ],
)
def test_binary_files_that_are_none(tmp_path, data, sentence):
    (tmp_path / "my model.glb").write_bytes(data)
    with pytest.raises(RefletError, match=sentence) as caught:
        read_gltf(tmp_path / "my model.glb")
    assert "\n" not in str(caught.value)


# -- buffers -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "written",
    [
        lambda data: "data:;base64," + base64.b64encode(data).decode(),
        lambda data: "DATA:application/gltf-buffer;charset=utf-8;BASE64," + base64.b64encode(data).decode(),
        lambda data: "data:application/octet-stream;base64, " + base64.encodebytes(data).decode(),  # wrapped lines
        lambda data: "data:text/plain;base64," + base64.b64encode(data).decode().rstrip("="),
        lambda data: "data:x/y;base64," + base64.urlsafe_b64encode(data).decode(),
        lambda data: "data:x/y;base64," + base64.b64encode(data).decode().replace("+", "%2B").replace("=", "%3D"),
        lambda data: "data:x/y," + "".join(f"%{byte:02x}" for byte in data),
    ],
)
def test_data_uris_of_every_tool(tmp_path, written):
    gltf = triangle()
    points = np.frombuffer(gltf.data, np.uint8)
    gltf.view(bytes(range(248, 256)) + b"x")  # + and / in base64, and padding
    root = json.loads(gltf.finished())
    root["buffers"][0]["uri"] = written(gltf.data)
    (tmp_path / "a.gltf").write_text(json.dumps(root))
    np.testing.assert_array_equal(corners(only_mesh(read_gltf(tmp_path / "a.gltf")))[0].ravel().view(np.uint8), points)


def test_buffers_beside_the_file_are_found_or_missed_in_one_sentence(tmp_path):
    gltf = triangle()
    root = json.loads(gltf.finished())
    root["buffers"][0]["uri"] = r"Bin\My%20Data.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(root))
    with pytest.raises(RefletError, match=r"My%20Data\.bin is not in "):
        read_gltf(tmp_path / "a.gltf")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "my data.bin").write_bytes(gltf.data)
    np.testing.assert_array_equal(corners(only_mesh(read_gltf(tmp_path / "a.gltf")))[0], TRIANGLE)
    (tmp_path / "bin" / "my data.bin").write_bytes(gltf.data[:-1])
    with pytest.raises(RefletError, match="buffer view 0 ends at byte 36 of a buffer of 35"):
        read_gltf(tmp_path / "a.gltf")
    root["buffers"][0] = {"byteLength": 36}
    (tmp_path / "a.gltf").write_text(json.dumps(root))
    with pytest.raises(RefletError, match="buffer 0 has neither a name nor a chunk"):
        read_gltf(tmp_path / "a.gltf")


def test_elements_need_not_be_aligned_and_numbers_may_be_written_as_floats(tmp_path):
    gltf = Gltf()
    gltf.view(b"\0" + TRIANGLE.tobytes())
    gltf.json["accessors"] = [
        {"bufferView": 0.0, "byteOffset": 1.0, "componentType": 5126.0, "count": 3.0, "type": "VEC3"}
    ]
    gltf.primitive["attributes"]["POSITION"] = 0
    np.testing.assert_array_equal(corners(only_mesh(gltf.read(tmp_path)))[0], TRIANGLE)


def test_normalized_bytes_and_plain_shorts(tmp_path):
    gltf = Gltf().attribute("POSITION", np.array(TRIANGLE * 300, np.uint16), component=UNSIGNED_SHORT)
    uv = np.array([[0, 255], [51, 0], [255, 102]], np.uint8)
    gltf.attribute("TEXCOORD_0", uv, "VEC2", UNSIGNED_BYTE, normalized=True)
    mesh = only_mesh(gltf.read(tmp_path))
    np.testing.assert_array_equal(corners(mesh)[0], TRIANGLE * 300)
    np.testing.assert_array_equal(mesh.uv, uv.astype(np.float32) / np.float32(255))


# -- primitives --------------------------------------------------------------------------------------------------------


def test_primitives_of_nothing_and_of_too_much(tmp_path):
    gltf = Gltf().attribute("POSITION", TRIANGLE[:0])
    mesh = only_mesh(gltf.read(tmp_path))
    assert mesh.triangles.shape == (0, 3)
    gltf = Gltf().attribute("POSITION", np.concatenate([TRIANGLE, TRIANGLE[:2]]))
    parts, words = read_and_told(gltf, tmp_path)
    np.testing.assert_array_equal(corners(only_mesh(parts)), TRIANGLE[None])
    assert words == ["a.gltf: corners that make no whole triangle are left out (1 of 1 primitives: 2 of a)."]
    gltf.json["meshes"][0]["primitives"] += [{"attributes": {}}, {"attributes": {"POSITION": 0}, "mode": 1}]
    parts, words = read_and_told(gltf, tmp_path)
    assert len(parts) == 1 and [word.split(": ", 1)[1] for word in words[1:]] == [
        "what has no positions is left out (1 of 3 primitives: a_mirror).",
        "points and lines are left out (1 of 3 primitives: a_mirror).",
    ]
    gltf.json["meshes"][0]["primitives"][0]["mode"] = 9
    with pytest.raises(RefletError, match="a primitive has mode 9"):
        gltf.read(tmp_path)


def test_positions_and_normals_that_are_no_numbers(tmp_path):
    points = np.concatenate([SQUARE, [[np.nan, 0, 0], [np.inf, 1, 1]]]).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (6, 1))
    normals[1] = np.nan
    gltf = Gltf().attribute("POSITION", points).attribute("NORMAL", normals)
    gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 2, 0, 2, 4, 0, 2, 3], np.uint8), "SCALAR", UNSIGNED_BYTE)
    parts, words = read_and_told(gltf, tmp_path)
    mesh = only_mesh(parts)
    np.testing.assert_array_equal(corners(mesh), SQUARE[[[0, 1, 2], [0, 2, 3]]])
    assert np.isfinite(mesh.positions).all() and np.isfinite(mesh.normals).all()
    assert [word.split(": ", 1)[1] for word in words] == [
        "triangles whose corners are no numbers (NaN or infinite) are left out (1 of 1 primitives: 1 of 3 in a).",
        "normals that are no numbers give way to those of the faces (1 of 1 primitives: a).",
    ]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"type": "VEC2"}, "accessor 0 is of type VEC2, not VEC3"),
        ({"type": None}, "accessor 0 is of type None, not VEC3"),
        ({"componentType": 5130}, "component type 5130"),
        ({"count": -1}, "count is -1, no whole number"),
        ({"count": 2.5}, "count is 2.5, no whole number"),
        ({"byteOffset": 4}, "ends behind buffer view 0, at byte 40 of 36"),
        ({"count": 2}, "TEXCOORD_0 has 3 elements for 2 vertices"),
        ({"bufferView": None, "count": 10**9}, "accessor 0 has 1000000000 elements and no bytes"),
        ({"byteOffset": 3 * 10**9}, "ends behind buffer view 0, at byte 3000000036 of 36"),  # files may be that large
        ({"bufferView": 3}, "entry 3 of its 2 bufferViews"),
    ],
)
def test_accessors_that_break_their_promises(tmp_path, change, sentence):
    gltf = triangle().attribute("TEXCOORD_0", TRIANGLE[:, :2], "VEC2")
    gltf.json["accessors"][0].update(change)
    with pytest.raises(RefletError, match=sentence):
        gltf.read(tmp_path)


# -- damage ------------------------------------------------------------------------------------------------------------


def rich_files():
    """Binary files in which most of the reader has something to do."""
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("NORMAL", np.tile(np.float32([0, 0, 1]), (3, 1)))
    gltf.attribute("TEXCOORD_0", np.float32([[0, 0], [1, 0], [0, 1]]), "VEC2")
    gltf.attribute("COLOR_0", np.full((3, 4), 200, np.uint8), "VEC4", UNSIGNED_BYTE, normalized=True)
    gltf.attribute("JOINTS_0", np.zeros((3, 4), np.uint8), "VEC4", UNSIGNED_BYTE)
    gltf.attribute("WEIGHTS_0", np.float32([[1, 0, 0, 0]] * 3), "VEC4")
    gltf.primitive["indices"] = gltf.accessor(np.array([0, 1, 2], np.uint16), "SCALAR", UNSIGNED_SHORT)
    gltf.primitive["targets"] = [{"POSITION": gltf.accessor(TRIANGLE, "VEC3")}]
    gltf.json["meshes"][0]["weights"] = [0.5]
    gltf.json["skins"] = [
        {"joints": [1], "inverseBindMatrices": gltf.accessor(np.eye(4, dtype="f4").reshape(1, 16), "MAT4")}
    ]
    gltf.json["nodes"] = [{"mesh": 0, "skin": 0, "children": [1]}, {"rotation": [0, 0, 0, 1], "scale": [1, 2, 1]}]
    gltf.material(normalTexture={"index": gltf.texture(np.full((2, 2, 3), 128, np.uint8))}, alphaMode="BLEND")
    return [gltf.glb(), draco().glb(), with_basis_texture(ktx2("etc1s")).glb()]


@pytest.mark.filterwarnings("ignore::reflet.errors.RefletWarning")
def test_damaged_files_are_read_or_refused_in_one_sentence(tmp_path):
    """Truncated, with bits flipped, and with numbers and words of the document exchanged."""
    path, chance = tmp_path / "a.glb", random.Random(8)
    refused = 0
    for data in rich_files():
        for attempt in range(80):
            damaged = bytearray(data)
            if attempt % 5 == 0:
                damaged = damaged[: chance.randrange(len(data))]
            else:
                start = 20 if attempt % 2 else 0  # the header counts little
                for _ in range(chance.randint(1, 3)):
                    at = chance.randrange(start, len(damaged))
                    if damaged[at : at + 1].isdigit():
                        damaged[at] = ord(chance.choice("0123456789-"))
                    else:
                        damaged[at] ^= 1 << chance.randrange(8)
            path.write_bytes(damaged)
            try:
                read_gltf(path)
            except RefletError as error:
                refused += 1
                assert "\n" not in str(error) and "a.glb" in str(error), error
    assert 100 < refused < 220  # most damage is told, and some changes nothing that counts
