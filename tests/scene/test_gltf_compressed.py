"""Meshes in Draco's and meshoptimizer's codes and pictures in Basis Universal's; each made with the library itself."""

import base64
import zlib

import DracoPy
import meshopt
import numpy as np
import pytest
from gltf_files import (
    BYTE,
    FLOAT,
    SQUARE,
    TRIANGLE,
    UNSIGNED_INT,
    UNSIGNED_SHORT,
    Gltf,
    corners,
    only_mesh,
    read_and_told,
)

from reflet.errors import RefletError

ORDER = np.array([0, 1, 2, 0, 2, 3], np.uint32)
UV = np.float32([[0, 0], [1, 0], [1, 1], [0, 1]])
UP = np.tile(np.float32([0, 0, 1]), (4, 1))


# -- Draco -------------------------------------------------------------------------------------------------------------


def draco(points=SQUARE, **generic):
    """A square in Draco's code alone: positions have number 3, normals 2, texture coordinates 1, as DracoPy counts."""
    gltf = Gltf()
    data = DracoPy.encode(
        points.astype(np.float64), ORDER.reshape(-1, 3), normals=UP.astype(np.float64), tex_coord=UV.astype(np.float64),
        quantization_bits=16, preserve_order=True, **generic,
    )  # fmt: skip
    ids = {a["attribute_type"]: a["unique_id"] for a in DracoPy.decode(data).attributes}
    accessor = {"componentType": FLOAT, "count": 4}  # without buffer views: the code is all there is
    gltf.json["accessors"] = [
        {**accessor, "type": "VEC3"}, {**accessor, "type": "VEC3"}, {**accessor, "type": "VEC2"},
        {"componentType": UNSIGNED_INT, "count": 6, "type": "SCALAR"},
    ]  # fmt: skip
    packed = {"bufferView": gltf.view(data), "attributes": {"POSITION": ids[0], "NORMAL": ids[1], "TEXCOORD_0": ids[3]}}
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    gltf.json["meshes"] = [
        {"primitives": [{"attributes": attributes, "indices": 3, "extensions": {"KHR_draco_mesh_compression": packed}}]}
    ]
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    return gltf


def test_draco(tmp_path):
    gltf = draco()
    gltf.json["nodes"][0]["translation"] = [0, 0, 3]
    parts, words = read_and_told(gltf, tmp_path)
    mesh = only_mesh(parts)
    # 16 bits over an extent of 1 round to 8e-6
    np.testing.assert_allclose(corners(mesh).reshape(-1, 3), SQUARE[ORDER] + np.float32([0, 0, 3]), atol=1e-5)
    np.testing.assert_allclose(mesh.uv[mesh.triangles].reshape(-1, 2), UV[ORDER], atol=1e-5)
    np.testing.assert_allclose(mesh.normals, UP, atol=0.01)  # octahedral, of few bits
    assert words == []


def test_draco_that_does_not_decode_is_refused(tmp_path):
    gltf = draco()
    packed = gltf.primitive["extensions"]["KHR_draco_mesh_compression"]
    gltf.json["bufferViews"][0]["byteLength"] = 20
    with pytest.raises(RefletError, match="in part a, Draco's data does not decode"):
        gltf.read(tmp_path)
    gltf = draco()
    packed = gltf.primitive["extensions"]["KHR_draco_mesh_compression"]
    packed["attributes"]["NORMAL"] = 17
    with pytest.raises(RefletError, match="Draco's data has no attribute 17, NORMAL of the primitive"):
        gltf.read(tmp_path)


# -- meshoptimizer -----------------------------------------------------------------------------------------------------


def packed_view(gltf, data, count, stride, mode, name="EXT_meshopt_compression", **more):
    """A compressed buffer view, whose own buffer, the second one, does not exist: it may, for readers without."""
    at = gltf.json["bufferViews"][gltf.view(data)]
    packed = {**at, "byteStride": stride, "count": count, "mode": mode, **more}
    at.update(buffer=1, byteOffset=0, byteLength=count * stride, extensions={name: packed})
    return gltf.json["bufferViews"].index(at)


@pytest.mark.parametrize(
    ("name", "version"),
    [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 0), ("KHR_meshopt_compression", 1)],
)
@pytest.mark.parametrize("mode", ["TRIANGLES", "INDICES"])
def test_meshopt(tmp_path, name, mode, version):
    gltf = Gltf()
    vertices = np.column_stack([SQUARE, UV]).astype(np.float32)  # interleaved, 20 bytes each
    view = packed_view(gltf, meshopt.encode_gltf_buffer(vertices, "ATTRIBUTES", version), 4, 20, "ATTRIBUTES", name)
    where = packed_view(gltf, meshopt.encode_gltf_buffer(ORDER, mode), 6, 2, mode, name)
    gltf.json["accessors"] = [
        {"bufferView": view, "componentType": FLOAT, "count": 4, "type": "VEC3"},
        {"bufferView": view, "byteOffset": 12, "componentType": FLOAT, "count": 4, "type": "VEC2"},
        {"bufferView": where, "componentType": UNSIGNED_SHORT, "count": 6, "type": "SCALAR"},
    ]
    gltf.primitive.update(attributes={"POSITION": 0, "TEXCOORD_0": 1}, indices=2)
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = [name]
    parts, words = read_and_told(gltf, tmp_path)
    mesh = only_mesh(parts)
    triangles = sorted(np.roll(t, -int(np.lexsort(t.T)[0]), axis=0).tolist() for t in corners(mesh))  # from any corner
    assert triangles == sorted(SQUARE[t].tolist() for t in ORDER.reshape(-1, 3))
    at = {tuple(p): uv for p, uv in zip(mesh.positions.tolist(), mesh.uv.tolist(), strict=True)}
    assert at == {tuple(p): uv for p, uv in zip(SQUARE.tolist(), UV.tolist(), strict=True)}
    assert words == []


def test_meshopt_filters(tmp_path):
    """Normals in octahedral form, positions with exponents of their own."""
    gltf = Gltf()
    normals = np.random.default_rng(5).normal(size=(3, 4)).astype(np.float32)
    normals[:, 3] = 1
    normals[:, :3] /= np.linalg.norm(normals[:, :3], axis=1, keepdims=True)
    turned = meshopt.encode_gltf_buffer(meshopt.encode_filter_oct(normals, 4, 8), "ATTRIBUTES")
    points = meshopt.encode_gltf_buffer(meshopt.encode_filter_exp(TRIANGLE * 0.75, 24), "ATTRIBUTES")
    gltf.json["accessors"] = [
        {"bufferView": packed_view(gltf, points, 3, 12, "ATTRIBUTES", filter="EXPONENTIAL"),
         "componentType": FLOAT, "count": 3, "type": "VEC3"},
        {"bufferView": packed_view(gltf, turned, 3, 4, "ATTRIBUTES", filter="OCTAHEDRAL"),
         "componentType": BYTE, "count": 3, "type": "VEC3", "normalized": True},
    ]  # fmt: skip
    gltf.primitive["attributes"] = {"POSITION": 0, "NORMAL": 1}
    mesh = only_mesh(gltf.read(tmp_path))
    np.testing.assert_array_equal(corners(mesh)[0], TRIANGLE * 0.75)
    np.testing.assert_allclose(mesh.normals, normals[:, :3], atol=0.02)  # 8 bits a component


def test_meshopt_that_does_not_decode_is_refused(tmp_path):
    data = meshopt.encode_gltf_buffer(TRIANGLE, "ATTRIBUTES")
    for changes, sentence in (
        ({"byteLength": 9}, "buffer view 0 does not decompress"),
        ({"mode": "POINTS"}, "mode must be"),
        ({"filter": "OCTAHEDRAL"}, "rows are 4 or 8 bytes"),
        ({"count": 10**8}, "cannot hold 100000000 elements"),
    ):
        gltf = Gltf()
        view = packed_view(gltf, data, 3, 12, "ATTRIBUTES")
        gltf.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"].update(changes)
        gltf.json["accessors"] = [{"bufferView": view, "componentType": FLOAT, "count": 3, "type": "VEC3"}]
        gltf.primitive["attributes"] = {"POSITION": 0}
        with pytest.raises(RefletError, match=sentence):
            gltf.read(tmp_path)


# -- Basis Universal ---------------------------------------------------------------------------------------------------

# 8×8 texels, red above and blue below, with green added on the left; encoded by basis_universal 2.5
KTX2 = {
    "etc1s": "c-mX-9TK5nWU!l;ONxsD2pEBw1BzjQ5ea7iu?`SV0b&&(-T_t91*M%B5qgk;4wPnM&|p~1$i%?RjBJNJob?|F<bgEMS>;8UC8<RWPKm{"
    "t#R{Q$nPsU(#fdozMtX(@3=Awl8w`Q!Sdq*|b}tM_IZOf59cP%t5AcAQ0!N}vI1E(5Y!=B{MkWJR2N1g<rBP`=)0$PQRxvRgbb)C96yM7*17e;-lYoIB"
    "nANaFkU<UT0+3ma3=9C&dnbt",
    "uastc": "c-mX-9TK5nWU!l;ONxsD2pEBw1BzjQ5sE<|1Bi8icnXw82M3_E0~!re%fz6;u#Az3fti_sK>)6+9?tp?1oA){=&bUh%#ze12B*a0%wmPm"
    "yv(xHqT<9H1tUE}0|o{bkS?G$aY?QR@ky+3{o;}g5B`5fxJR6U>t{SuD<gu>@bf?O0cIE<0MdsbYX",
}  # fmt: skip


def ktx2(code):
    return zlib.decompress(base64.b85decode(KTX2[code]))


def with_basis_texture(data):
    gltf = Gltf().attribute("POSITION", TRIANGLE).attribute("TEXCOORD_0", UV[:3], "VEC2")
    gltf.material(pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    gltf.json["images"] = [{"bufferView": gltf.view(data), "mimeType": "image/ktx2"}]
    gltf.json["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    gltf.json["extensionsRequired"] = gltf.json["extensionsUsed"] = ["KHR_texture_basisu"]
    return gltf


@pytest.mark.parametrize("code", KTX2)
def test_basis_universal_pictures(tmp_path, code):
    parts, words = read_and_told(with_basis_texture(ktx2(code)), tmp_path)
    expected = np.zeros((8, 8, 4), np.uint8)
    expected[:4, :, 0], expected[4:, :, 2], expected[:, :4, 1], expected[..., 3] = 200, 200, 80, 255
    pixels = parts[0].material.base_color_texture_srgb.pixels
    np.testing.assert_allclose(pixels.astype(int), expected, atol=4)  # ETC1S has 5 bits a colour
    assert words == []


def test_basis_universal_that_does_not_decode_leaves_the_factors(tmp_path):
    other = bytearray(ktx2("uastc"))
    other[12:16] = (37).to_bytes(4, "little")  # VK_FORMAT_R8G8B8A8_UNORM, which glTF does not know
    for data in (ktx2("etc1s")[:100], bytes(other)):
        parts, words = read_and_told(with_basis_texture(data), tmp_path)
        assert parts[0].material.base_color_texture_srgb is None
        assert "no KTX 2 picture in Basis Universal code" in words[0] and "factors alone" in words[0]
