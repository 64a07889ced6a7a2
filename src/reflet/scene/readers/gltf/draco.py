"""Primitives compressed by Draco, KHR_draco_mesh_compression."""

from dataclasses import dataclass

import DracoPy
import numpy as np
from jaxtyping import UInt32

from reflet.scene.readers.gltf.buffers import Buffers
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, child, whole


@dataclass(frozen=True)
class DracoPrimitive:
    """Decoded attributes by their glTF names, as they are stored, and triangles."""

    attributes: dict[str, np.ndarray]
    triangles: UInt32[np.ndarray, "triangles 3"]


def decode_draco(packed: JsonObject, buffers: Buffers) -> DracoPrimitive:
    """What the extension's object of a primitive stands for. Raises DamagedError where it does not decode."""
    data = buffers.view(whole(packed.get("bufferView"), "bufferView")).data.tobytes()
    try:
        mesh = DracoPy.decode(data)
        by_id = {attribute["unique_id"]: attribute["data"] for attribute in mesh.attributes}
        triangles = np.array(mesh.faces, np.uint32).reshape(-1, 3)
    except Exception as error:  # the library has no class of its own for all that it raises
        raise DamagedError(f"Draco's data does not decode ({error or type(error).__name__})") from error
    attributes = {}
    for name, unique_id in child(packed, "attributes").items():
        found = by_id.get(unique_id)
        if found is None:
            raise DamagedError(f"Draco's data has no attribute {str(unique_id)[:20]}, {name[:20]} of the primitive")
        attributes[name] = np.asarray(found).reshape(len(found), -1)
    return DracoPrimitive(attributes, triangles)
