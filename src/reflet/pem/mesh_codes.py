"""Arrays of meshes in the codes of EXT_meshopt_compression, which glTF readers unpack."""

from dataclasses import dataclass
from typing import Literal

import meshopt
import numpy as np
from jaxtyping import Float32, UInt32

from reflet.scene.meshes.mesh import Mesh

DIRECTION_BITS = 14  # of each of two octahedral coordinates: 12 and 13 show in reflections (up to 0.1 dB of them)
_MANTISSA = 2**23


@dataclass(frozen=True)
class Packed:
    """Bytes of a buffer view: ``count`` elements of ``stride`` bytes, by the extension's mode and filter."""

    data: bytes
    count: int
    stride: int
    mode: Literal["ATTRIBUTES", "TRIANGLES", "INDICES"]
    filter: Literal["NONE", "EXPONENTIAL", "OCTAHEDRAL"] = "NONE"


def on_grid(values: Float32[np.ndarray, "rows columns"], exponent: int) -> Float32[np.ndarray, "rows columns"]:
    """Each value's nearest multiple of two to the exponent; `packed_floats` holds them if they are below 2²³ steps."""
    return np.ldexp(np.rint(np.ldexp(values.astype(np.float64), -exponent)), exponent).astype(np.float32)


def packed_floats(values: Float32[np.ndarray, "rows columns"]) -> Packed:
    """Floats on a grid (`on_grid`), exactly, as whole numbers of its steps."""
    _, largest = np.frexp(np.abs(values).max(initial=0.0))
    exponent = int(np.clip(largest - 23, -100, 100))  # what the filter allows
    steps = np.rint(np.ldexp(values.astype(np.float64), -exponent)).astype(np.int64)
    bits = int(np.bitwise_or.reduce(steps, axis=None))
    spare = (bits & -bits).bit_length() - 1 if bits else 0
    words = ((exponent + spare) << 24) | ((steps >> spare) & 0xFFFFFF)
    return _packed((words & 0xFFFFFFFF).astype(np.uint32), "EXPONENTIAL")


def packed_directions(values: Float32[np.ndarray, "rows columns"]) -> Packed:
    """Unit vectors, of 3 components or with a sign as the fourth, as normalized int16 of 4."""
    four = np.zeros((len(values), 4), np.float32)
    four[:, : values.shape[1]] = values
    return _packed(meshopt.encode_filter_oct(four, 8, DIRECTION_BITS), "OCTAHEDRAL")


def packed_triangles(mesh: Mesh) -> Packed:
    """A mesh's triangles in their order; corners come back as `as_decoded` says.

    The denser code may begin with another corner. Where a triangle's corners differ in handedness its first one counts
    (CONVENTIONS.md): such meshes take the code that keeps it.
    """
    indices = np.ascontiguousarray(mesh.triangles, np.uint32).reshape(-1)
    mode: Literal["TRIANGLES", "INDICES"] = "INDICES" if _has_mixed_handedness(mesh) else "TRIANGLES"
    return Packed(meshopt.encode_gltf_buffer(indices, mode), len(indices), 4, mode)


def as_decoded(mesh: Mesh) -> UInt32[np.ndarray, "triangles 3"]:
    """The triangles as readers will see them."""
    packed = packed_triangles(mesh)
    indices = meshopt.decode_gltf_buffer(packed.data, packed.count, packed.stride, packed.mode)
    return np.ascontiguousarray(indices).view(np.uint32).reshape(-1, 3)


def _has_mixed_handedness(mesh: Mesh) -> bool:
    if mesh.tangents is None:
        return False
    signs = mesh.tangents[:, 3][mesh.triangles]
    return bool((signs != signs[:, :1]).any())


def _packed(rows: np.ndarray, filter_: Literal["EXPONENTIAL", "OCTAHEDRAL"]) -> Packed:
    rows = np.ascontiguousarray(rows)
    data = rows.view(np.uint8).reshape(len(rows), -1)
    return Packed(meshopt.encode_gltf_buffer(data, "ATTRIBUTES"), len(rows), data.shape[1], "ATTRIBUTES", filter_)
