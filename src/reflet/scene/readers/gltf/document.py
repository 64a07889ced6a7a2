"""A parsed glTF document with its file and what there is to say about it."""

from dataclasses import dataclass
from pathlib import Path

from reflet.scene.readers.gltf.container import Container
from reflet.scene.readers.gltf.values import DamagedError, JsonObject, children, json_object
from reflet.scene.readers.notes import Notes

_COUNTED = ("meshes", "nodes", "materials", "textures", "images", "animations", "cameras", "scenes")


@dataclass(frozen=True)
class Document:
    """What all parts of the reader look things up in."""

    path: Path
    root: JsonObject
    blob: memoryview | None
    notes: Notes

    def item(self, kind: str, index: int) -> JsonObject:
        """Entry ``index`` of the document's list ``kind``, "nodes" for instance. Raises DamagedError without it."""
        entries = self.root.get(kind)
        if not isinstance(entries, list) or index >= len(entries):
            count = len(entries) if isinstance(entries, list) else 0
            raise DamagedError(f"it refers to entry {index} of its {count} {kind}")
        return json_object(entries[index], f"entry {index} of {kind}")


def open_document(path: Path, container: Container) -> Document:
    """The document of a file that was read."""
    root = container.root
    totals = {kind: len(children(root, kind)) for kind in _COUNTED}
    totals["primitives"] = sum(len(children(mesh, "primitives")) for mesh in children(root, "meshes"))
    return Document(path, root, container.blob, Notes(path, totals))
