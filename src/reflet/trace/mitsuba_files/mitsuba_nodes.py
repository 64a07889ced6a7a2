"""What a Mitsuba XML file says, before any of it is built: plugins, their values and their children."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from reflet.errors import RefletError


@dataclass(frozen=True)
class Node:
    """A plugin of the file: ``kind`` is shape, bsdf, texture, emitter, sensor…; names of files are absolute."""

    kind: str
    plugin: str
    id: str
    values: dict[str, Any] = field(default_factory=dict)
    children: dict[str, "Node"] = field(default_factory=dict)

    def child(self, kind: str) -> "Node | None":
        """The first child of a kind."""
        return next((child for child in self.children.values() if child.kind == kind), None)

    def described(self, *, children: bool = True) -> dict[str, Any]:
        """The dictionary that Mitsuba builds the plugin from."""
        described = {"type": self.plugin} | self.values
        if children:
            described |= {name: child.described() for name, child in self.children.items()}
        return described


def read_nodes(path: str | Path) -> list[Node]:
    """The children of the file's scene, with references and included files resolved. Raises RefletError, in one
    sentence, for what Mitsuba cannot parse."""
    path = Path(path)
    try:
        config = mi.parser.ParserConfig(mi.variant())
        state = mi.parser.parse_file(config, str(path))
        mi.parser.transform_upgrade(config, state)
        mi.parser.transform_resolve_references(config, state)
    except RuntimeError as error:
        said = " ".join(str(error).split())
        raise RefletError(f"Mitsuba cannot read {path}; it says: {said[:300]}") from error

    def build(index: int) -> Node:
        properties = state.nodes[index].props
        values: dict[str, Any] = {}
        children: dict[str, Node] = {}
        for key in list(properties.keys()):
            value = properties[key]
            if type(value).__name__ == "ResolvedReference":
                children[key] = build(value.index())
            else:
                values[key] = _plain(key, value, path)
        kind = state.nodes[index].type.name.lower()
        return Node(kind, properties.plugin_name(), properties.id(), values, children)

    return list(build(0).children.values())


def _plain(key: str, value: Any, path: Path) -> Any:
    """The value as `mi.load_dict` takes it."""
    if key == "filename":
        file = path.parent / value
        if not file.is_file():
            raise RefletError(f"{path} refers to {file}, which is not there.")
        return str(file)
    if "Color" in type(value).__name__:
        return {"type": "rgb", "value": [float(v) for v in np.ravel(value)]}
    if hasattr(value, "wavelengths"):
        if value.is_uniform():
            return float(value.values[0])
        return {"type": "spectrum", "value": list(zip(value.wavelengths, value.values, strict=True))}
    return value
