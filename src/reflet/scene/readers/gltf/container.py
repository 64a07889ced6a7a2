"""What holds a glTF document: a .gltf file is JSON, a .glb file JSON and bytes. The bytes tell which, not the name."""

import codecs
import json
import shlex
from dataclasses import dataclass
from pathlib import Path

from reflet.errors import RefletError
from reflet.files.unreadable import unreadable
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, child, json_object

_MAGIC, _JSON, _BIN = b"glTF", b"JSON", b"BIN\0"
_GIT_LFS = b"version https://git-lfs"


@dataclass(frozen=True)
class Container:
    """A parsed document and, from a .glb file, the bytes of its first buffer."""

    root: JsonObject
    blob: memoryview | None


def read_container(path: Path) -> Container:
    """The document in a file, whichever of the two kinds it is.

    Raises RefletError for files that cannot be read, are no glTF, or are of another version than 2; DamagedError for
    broken ones.
    """
    try:
        data = memoryview(path.read_bytes())
    except OSError as error:
        raise unreadable(path, error) from error
    if bytes(data[:4]) == _MAGIC:
        version = int.from_bytes(data[4:8], "little")
        if version == 1:
            raise _version_one(path)
        if version != 2:
            raise DamagedError(f"its header says version {version} of binary glTF, of which there are 1 and 2")
        document, blob = _chunks(data)
    else:
        if bytes(data[: len(_GIT_LFS)]) == _GIT_LFS:
            raise RefletError(f"{path} is a pointer of Git LFS, not the file itself; fetch it with: git lfs pull")
        document, blob = data, None
    root = _parsed(bytes(document), path)
    if isinstance(root.get("scenes"), dict) or str(child(root, "asset").get("version", "2.0")).startswith(("0", "1")):
        raise _version_one(path)
    return Container(root, blob)


def _version_one(path: Path) -> RefletError:
    return RefletError(f"{path} is glTF 1.0, and reflet reads 2.0; convert it with: {conversion(path)}")


def conversion(path: Path) -> str:
    """The command that turns an older file's document and looks into those of today."""
    return shlex.join(["npx", "gltf-pipeline", "-i", str(path), "-o", f"{path.stem}-2{path.suffix}"])


def _chunks(data: memoryview) -> tuple[memoryview, memoryview | None]:
    """JSON and bytes of a .glb file, by the lengths of its chunks: the length of the whole is often wrong.

    Further chunks and whatever follows are passed over. Some tools leave padding out of a chunk's length.
    """
    document, blob, start = None, None, 12
    while start + 8 <= len(data) and (document is None or blob is None):
        if bytes(data[start + 4 : start + 8]) not in (_JSON, _BIN) and start % 4:
            start += -start % 4
            continue
        length, kind = int.from_bytes(data[start : start + 4], "little"), bytes(data[start + 4 : start + 8])
        chunk = data[start + 8 : start + 8 + length]
        if kind == _JSON and document is None:
            if len(chunk) < length:
                raise DamagedError(f"it ends after {len(chunk)} of the {length} bytes of its JSON")
            document = chunk
        elif kind == _BIN and blob is None:
            blob = chunk
        start += 8 + length
    if document is None:
        raise DamagedError("it has no JSON chunk")
    return document, blob


def _parsed(data: bytes, path: Path) -> JsonObject:
    try:
        return json_object(json.loads(_decoded(data).strip("\0 \t\r\n")), "the document")
    except (ValueError, RecursionError) as error:
        begins = data[:16].decode("ascii", "backslashreplace")
        raise RefletError(
            f"{path} is no glTF 2.0 file: it begins with {begins!r} and is no JSON ({error}); export it again."
        ) from error


def _decoded(data: bytes) -> str:
    """The text, in any of the encodings that editors save it in; glTF asks for UTF-8 without a byte-order mark."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    if data[1:2] == b"\0" or data[:1] == b"\0":
        return data.decode("utf-16-le" if data[1:2] == b"\0" else "utf-16-be")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
