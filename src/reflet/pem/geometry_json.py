"""Geometries in JSON: their kinds and fields; a relief's map in a binary file beside it."""

from pathlib import Path
from typing import Any

import numpy as np

from reflet.envmap.geometry import KINDS, Geometry
from reflet.envmap.relief import Relief
from reflet.pem.arrays import BufferWriter, read_array

_MAP = "inverseDistance"


def geometry_to_json(geometry: Geometry, buffer: BufferWriter, *, coded: bool = False) -> dict[str, Any]:
    """A geometry's kind and fields; a relief's half floats go into ``buffer``, as uint16."""
    if isinstance(geometry, Relief):
        return {
            "kind": geometry.kind,
            "lower": list(geometry.lower),
            "upper": list(geometry.upper),
            "origin": list(geometry.origin),
            _MAP: buffer.add(geometry.inverse_distance.view(np.uint16), "delta" if coded else None),
        }
    fields = {name: list(value) if isinstance(value, tuple) else value for name, value in vars(geometry).items()}
    return {"kind": geometry.kind, **fields}


def geometry_from_json(fields: dict[str, Any], folder: Path) -> Geometry:
    """The geometry that `geometry_to_json` described, its map read from ``folder``."""
    values: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in fields.items() if name != "kind"
    }
    if fields["kind"] == Relief.kind:
        return Relief(read_array(folder, values.pop(_MAP)).view(np.float16), **values)
    return KINDS[fields["kind"]](**values)
