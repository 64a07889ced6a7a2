"""What tells one scene from another."""

import hashlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from reflet.scene.scene import Scene


def fingerprint(scene: Scene) -> str:
    """32 hexadecimal digits that change with anything in the scene: geometry, materials, textures, names, light."""
    digest = hashlib.blake2b(digest_size=16)
    _feed(digest, scene)
    return digest.hexdigest()


def _feed(digest: "hashlib.blake2b", value: Any) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value):
        digest.update(type(value).__name__.encode())
        for item in (item for item in fields(value) if item.compare):
            _feed(digest, getattr(value, item.name))
    elif isinstance(value, tuple):
        digest.update(f"({len(value)}".encode())
        for item in value:
            _feed(digest, item)
    else:
        digest.update(f"{value!r};".encode())
