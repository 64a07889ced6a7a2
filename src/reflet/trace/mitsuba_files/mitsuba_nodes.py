"""What a Mitsuba XML file says, before any of it is built: plugins, their values and their children."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from reflet.errors import RefletError
from reflet.scene.readers.resources import find_resource


@dataclass(frozen=True)
class Node:
    """A plugin of the file: ``kind`` is shape, bsdf, texture, emitter, sensor…; names of files are absolute.

    ``missing`` says, in one sentence, which file of the plugin is not there.
    """

    kind: str
    plugin: str
    id: str
    values: dict[str, Any] = field(default_factory=dict)
    children: dict[str, "Node"] = field(default_factory=dict)
    missing: str = ""

    def of_kind(self, kind: str) -> "list[Node]":
        """The children of a kind, in the file's order."""
        return [child for child in self.children.values() if child.kind == kind]

    def child(self, kind: str) -> "Node | None":
        """The first child of a kind."""
        return next(iter(self.of_kind(kind)), None)

    def described(self, *, children: bool = True) -> dict[str, Any]:
        """The dictionary that Mitsuba builds the plugin from."""
        described = {"type": self.plugin} | self.values
        if children:
            described |= {name: child.described() for name, child in self.children.items()}
        return described

    def built(self, name: str, *, children: bool = True) -> Any:
        """Mitsuba's own object. Raises RefletError where a file is missing or Mitsuba refuses the plugin."""
        if self.missing:
            raise RefletError(f"{name}: {self.missing}")
        with _in_a_sentence(f"Mitsuba cannot make {name}"):
            return mi.load_dict(self.described(children=children))


def read_nodes(path: str | Path) -> list[Node]:
    """The children of the file's scene, with references and included files resolved.

    Files are looked for in the folders of ``<path>`` elements, the last of them first, and in the scene's own. Raises
    RefletError, in one sentence, for what Mitsuba cannot parse.
    """
    path = Path(path)
    of_mitsuba = len(mi.file_resolver())
    with _searching(path.resolve().parent) as resolver, _in_a_sentence(f"Mitsuba cannot read {path}"):
        config = mi.parser.ParserConfig(mi.variant())
        state = mi.parser.parse_file(config, str(path))
        mi.parser.transform_upgrade(config, state)
        mi.parser.transform_resolve_references(config, state)
        folders = [Path(str(resolver[i])) for i in range(len(resolver))]

    def build(index: int) -> Node:
        properties = state.nodes[index].props
        values: dict[str, Any] = {}
        children: dict[str, Node] = {}
        missing = ""
        for key in list(properties.keys()):
            value = properties[key]
            if type(value).__name__ == "ResolvedReference":
                children[key] = build(value.index())
            elif key == "filename":
                values[key], missing = _file(str(value), folders, len(folders) - of_mitsuba)
            else:
                values[key] = _plain(value)
        kind = state.nodes[index].type.name.lower()
        return Node(kind, properties.plugin_name(), properties.id(), values, children, missing)

    return list(build(0).children.values())


@contextmanager
def _searching(folder: Path) -> Iterator[mi.FileResolver]:
    """Mitsuba looks for files in this folder first; what `<path>` elements add holds for one scene only."""
    before = mi.file_resolver()
    meanwhile = mi.FileResolver(before)
    meanwhile.prepend(str(folder))
    mi.set_file_resolver(meanwhile)
    try:
        yield meanwhile
    finally:
        mi.set_file_resolver(before)


@contextmanager
def _in_a_sentence(what: str) -> Iterator[None]:
    try:
        yield
    except RuntimeError as error:
        said = re.sub(r"\[\w+\.(cpp|h):\d+\] ", "", " ".join(str(error).split()))
        said = re.sub(r"^(Error while loading|At|While loading) .*?(?=\(line|failed|Found)", "", said)
        raise RefletError(f"{what}; it says: {said[:300].rstrip('.!')}. Put that right in the file.") from error


def _file(name: str, folders: list[Path], own: int) -> tuple[str, str]:
    """The file that is meant, and what to say if there is none. In the scene's ``own`` folders, which come first, its
    name may be written in other ways (`find_resource`)."""
    for folder in folders:
        if (folder / name).is_file():
            return str(folder / name), ""
    said = ""
    for folder in folders[:own]:
        try:
            return str(find_resource(folder, name)), ""
        except RefletError as error:
            said = said or str(error)
    return name, said


def _plain(value: Any) -> Any:
    """The value as `mi.load_dict` takes it."""
    if "Color" in type(value).__name__:
        return {"type": "rgb", "value": [float(v) for v in np.ravel(value)]}
    if hasattr(value, "wavelengths"):
        if value.is_uniform():
            return float(value.values[0])
        return {"type": "spectrum", "value": list(zip(value.wavelengths, value.values, strict=True))}
    return value
