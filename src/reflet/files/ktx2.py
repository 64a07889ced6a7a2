"""KTX 2.0 maps in half float with every mip level stored: the files that hold a PEM's maps.

Only what the project writes is read back: uncompressed RGBA of half floats with a full mip chain. A cube is a cube
texture, whose faces lie in the order +X -X +Y -Y +Z -Z, row 0 at the top: the project's own (`reflet.envmap.cube`), so
that nothing is converted. Maps of one face are 2D textures, those of several are 2D arrays with a layer a face; the key
RefletParameterization names what they are. Implements the Khronos Texture File Format 2.0 and the Khronos Data Format
1.3.
"""

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float16

from reflet.envmap.cube import CUBE
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterization import Parameterization
from reflet.envmap.parameterizations import parameterization
from reflet.errors import RefletError
from reflet.files.atomic import atomic_write

IDENTIFIER = b"\xabKTX 20\xbb\r\n\x1a\n"
HALF_MAX = 65504.0

_VK_FORMAT_R16G16B16A16_SFLOAT = 97
_HEADER = struct.Struct("<12s 9I 4I 2Q")  # identifier; format to supercompression; DFD and KVD; supercompression data
_LEVEL = struct.Struct("<3Q")  # offset, length, uncompressed length
_TEXEL_BYTES = 8  # also the alignment of a level: the least common multiple of a texel's size and 4


@dataclass(frozen=True)
class Ktx2Map:
    """An opened file. ``levels`` are memory maps, finest first: nothing is read until asked."""

    chain: MipChain
    levels: tuple[Float16[np.ndarray, "_ _ _ 4"], ...]

    def texels(self) -> Float16[np.ndarray, "texels 4"]:
        """All levels as one flat vector in the order of `MipChain`, read from the file."""
        return np.concatenate([level.reshape(-1, 4) for level in self.levels])


def write_ktx2(path: Path, chain: MipChain, texels: Float[np.ndarray, "texels channels"]) -> None:
    """Write a map with all its mip levels, atomically; equal texels give equal bytes.

    ``texels`` have 3 channels (alpha becomes 1) or 4 (premultiplied by alpha, and marked so). Values are clamped to
    ±65504, the range of half floats, and rounded to nearest. Raises RefletError where a texel is not a number or the
    file cannot be written.
    """
    if np.isnan(texels).any():
        raise RefletError(f"The map {path} holds values that are not numbers; nothing was written.")
    half = np.ones((len(texels), 4), "<f2")
    half[:, : texels.shape[1]] = np.clip(texels, -HALF_MAX, HALF_MAX)
    descriptor, metadata = (
        _data_format_descriptor(premultiplied=texels.shape[1] == 4),
        _metadata(chain.parameterization),
    )
    descriptor_at = _HEADER.size + _LEVEL.size * chain.level_count
    metadata_at = descriptor_at + len(descriptor)
    position = metadata_at + len(metadata)
    index: dict[int, bytes] = {}
    body: list[bytes] = []
    for mip_level in reversed(range(chain.level_count)):  # the format wants the coarsest level first
        data = chain.level(half, mip_level).tobytes()
        padding = -position % _TEXEL_BYTES
        index[mip_level] = _LEVEL.pack(position + padding, len(data), len(data))
        body += [bytes(padding), data]
        position += padding + len(data)
    _, rows, columns = chain.level_shape(0)
    layers, faces = _layers_and_faces(chain.parameterization)
    header = _HEADER.pack(
        IDENTIFIER,
        *(_VK_FORMAT_R16G16B16A16_SFLOAT, 2, columns, rows, 0, layers, faces, chain.level_count, 0),
        *(descriptor_at, len(descriptor), metadata_at, len(metadata)),
        *(0, 0),
    )
    levels = b"".join(index[mip_level] for mip_level in range(chain.level_count))
    atomic_write(path, b"".join([header, levels, descriptor, metadata, *body]))


def read_ktx2(path: Path) -> Ktx2Map:
    """Open a map written by `write_ktx2`. Raises RefletError where the file is missing, foreign or truncated."""
    path = Path(path)
    try:
        size_on_disk = path.stat().st_size
        with path.open("rb") as file:
            head = file.read(_HEADER.size)
            if not head.startswith(IDENTIFIER):
                raise RefletError(f"{path} is not a KTX 2.0 file; expected a map that reflet has written.")
            if len(head) < _HEADER.size:
                raise RefletError(_truncated(path))
            fields = _HEADER.unpack(head)
            kind, _, width, height, depth, layers, faces, level_count, compression = fields[1:10]
            index = file.read(_LEVEL.size * min(level_count, 32))
            file.seek(fields[12])
            metadata = file.read(min(fields[13], size_on_disk))
    except OSError as error:
        raise RefletError(f"The map {path} cannot be read: {error.strerror}.") from None
    if (kind, depth, compression) != (_VK_FORMAT_R16G16B16A16_SFLOAT, 0, 0) or faces not in (1, 6):
        raise RefletError(f"{path} is not a map of half-float RGBA texels, the one KTX 2.0 form of a PEM's maps.")
    found = re.search(rb"RefletParameterization\0(\w+)\0", metadata)
    laid_out = parameterization(found[1].decode()) if found else CUBE
    if (layers, faces) != _layers_and_faces(laid_out):
        raise RefletError(f"{path} is not a {laid_out} map: it has {layers} layers and {faces} faces.")
    if width != laid_out.aspect * height or height < 1 or height & (height - 1) or level_count != height.bit_length():
        raise RefletError(
            f"{path} should hold all mip levels of a {laid_out} map whose size is a power of two, "
            f"not {level_count} of {width}×{height}."
        )
    chain = MipChain(height, laid_out)
    if len(index) < _LEVEL.size * level_count:
        raise RefletError(_truncated(path))
    levels = []
    for mip_level, (offset, length, _) in enumerate(_LEVEL.iter_unpack(index)):
        shape = (*chain.level_shape(mip_level), 4)
        if length != 2 * np.prod(shape) or offset + length > size_on_disk:
            raise RefletError(_truncated(path))
        levels.append(np.memmap(path, "<f2", "r", offset, shape))
    return Ktx2Map(chain, tuple(levels))


def _layers_and_faces(laid_out: Parameterization) -> tuple[int, int]:
    if laid_out == CUBE:
        return 0, 6
    return (laid_out.face_count if laid_out.face_count > 1 else 0), 1


def _truncated(path: Path) -> str:
    return f"{path} is truncated or damaged; copy it again or bake it again with --resume."


def _data_format_descriptor(*, premultiplied: bool) -> bytes:
    """One basic descriptor block: four 16-bit floating-point samples, linear, Rec. 709 primaries."""
    linear, bt709, rgbsda = 1, 1, 1
    samples = b""
    for number, channel in enumerate((0, 1, 2, 15)):  # red, green, blue, alpha
        floating_and_signed = 0xC0
        one, minus_one = 0x3F800000, 0xBF800000
        samples += struct.pack("<HBB4x2I", 16 * number, 15, channel | floating_and_signed, minus_one, one)
    block = struct.pack(
        "<IHH4B4x8B", 0, 2, 24 + len(samples), rgbsda, bt709, linear, premultiplied, _TEXEL_BYTES, *[0] * 7
    )
    return struct.pack("<I", 4 + len(block) + len(samples)) + block + samples


def _metadata(laid_out: Parameterization) -> bytes:
    """Key-value pairs, sorted, each padded to 4 bytes."""
    pairs = {"KTXorientation": "rd", "KTXwriter": "reflet", "RefletParameterization": laid_out.name}
    out = b""
    for key, value in pairs.items():
        pair = key.encode() + b"\0" + value.encode() + b"\0"
        out += struct.pack("<I", len(pair)) + pair + bytes(-len(pair) % 4)
    return out
