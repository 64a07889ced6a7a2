"""Small glTF files in the making, for the tests of their reader."""

import base64
import io
import json
import struct
import warnings

import numpy as np
from PIL import Image

from reflet.errors import RefletWarning
from reflet.scene.readers.gltf.read import read_gltf

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
FLOAT, BYTE, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5120, 5121, 5122, 5123, 5125


class Gltf:
    """A small glTF file in the making: one buffer as a data URI, one mesh, one node."""

    def __init__(self):
        self.data = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [{"primitives": [{"attributes": {}}]}], "accessors": [], "bufferViews": []}  # fmt: skip

    @property
    def primitive(self):
        return self.json["meshes"][0]["primitives"][0]

    def view(self, data, **fields):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **fields})
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, kind, component=FLOAT, **fields):
        view = self.view(np.ascontiguousarray(array).tobytes())
        entry = {"bufferView": view, "componentType": component, "count": len(array), "type": kind, **fields}
        self.json["accessors"].append(entry)
        return len(self.json["accessors"]) - 1

    def attribute(self, name, array, kind="VEC3", component=FLOAT, **fields):
        self.primitive["attributes"][name] = self.accessor(array, kind, component, **fields)
        return self

    def material(self, **fields):
        """The one material of the primitive."""
        self.json["materials"] = [fields]
        self.primitive["material"] = 0
        return self

    def texture(self, pixels):
        return self.picture(uri="data:image/png;base64," + base64.b64encode(png(pixels)).decode())

    def picture(self, **image):
        images, textures = self.json.setdefault("images", []), self.json.setdefault("textures", [])
        images.append(image)
        textures.append({"source": len(images) - 1})
        return len(textures) - 1

    def finished(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.json["buffers"] = [{"byteLength": len(self.data), "uri": uri}]
        return json.dumps(self.json)

    def read(self, folder, name="a.gltf"):
        (folder / name).write_text(self.finished())
        return read_gltf(folder / name)

    def glb(self):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json).encode()
        return glb(
            chunk(b"JSON", text + b" " * (-len(text) % 4)), chunk(b"BIN\0", self.data + b"\0" * (-len(self.data) % 4))
        )


def chunk(kind, data):
    return struct.pack("<I4s", len(data), kind) + data


def glb(*chunks, version=2, length=None):
    body = b"".join(chunks)
    return struct.pack("<4sII", b"glTF", version, 12 + len(body) if length is None else length) + body


def png(pixels):
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def read_and_told(gltf, folder):
    """The parts, and what is said while they are read."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parts = gltf.read(folder)
    return parts, [str(w.message) for w in caught if issubclass(w.category, RefletWarning)]


def told(gltf, folder):
    return read_and_told(gltf, folder)[1]


def only_mesh(parts):
    assert len(parts) == 1
    return parts[0].mesh


def corners(mesh):
    return mesh.positions[mesh.triangles]
