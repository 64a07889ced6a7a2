"""Values of a glTF document, checked as they are read: whatever a damaged file holds there instead is one sentence."""

import math
from typing import Any

JsonObject = dict[str, Any]

_LARGEST = 2**40  # no index, count or offset of a file that fits into memory is larger


class DamagedError(Exception):
    """What a file promises and does not keep, as the middle of a sentence; the reader names the file around it."""


def json_object(value: object, what: str) -> JsonObject:
    """The value, which must be a JSON object; ``what`` names it in the sentence where it is none."""
    if not isinstance(value, dict):
        raise DamagedError(f"{what} is no object")
    return value


def child(parent: JsonObject, key: str) -> JsonObject:
    """The object under ``key``; an empty one where there is none."""
    value = parent.get(key)
    return {} if value is None else json_object(value, key)


def children(parent: JsonObject, key: str) -> list[JsonObject]:
    """The objects listed under ``key``; none where it is missing."""
    return [json_object(value, f"an entry of {key}") for value in array(parent, key)]


def array(parent: JsonObject, key: str) -> list[Any]:
    """The list under ``key``; an empty one where there is none."""
    value = parent.get(key)
    if value is None:
        return []
    if not isinstance(value, list):
        raise DamagedError(f"{key} is no list")
    return value


def extension(parent: JsonObject, name: str) -> JsonObject | None:
    """What the object says under the extension ``name``; None where it does not use it."""
    value = child(parent, "extensions").get(name)
    return None if value is None else json_object(value, name)


def whole(value: object, what: str) -> int:
    """The value, which must be a whole number that is not negative. Some tools write 3.0."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= _LARGEST:
        raise DamagedError(f"{what} is {_shown(value)}, no whole number from 0 to 2⁴⁰")
    return value


def index_or_none(parent: JsonObject, key: str) -> int | None:
    """The index under ``key``; None where there is none."""
    value = parent.get(key)
    return None if value is None else whole(value, key)


def number(parent: JsonObject, key: str, default: float) -> float:
    """The finite number under ``key``."""
    return default if parent.get(key) is None else _finite(parent[key], key)


def numbers(parent: JsonObject, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """The finite numbers listed under ``key``, as many as ``default`` has."""
    values = array(parent, key) or default
    if len(values) < len(default):
        raise DamagedError(f"{key} has {len(values)} of {len(default)} numbers")
    return tuple(_finite(value, key) for value in values[: len(default)])


def text(parent: JsonObject, key: str) -> str:
    """The text under ``key`` as it can be printed; empty where there is none."""
    value = parent.get(key)
    return value.encode("utf-8", "replace").decode() if isinstance(value, str) else ""


def _finite(value: object, what: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise DamagedError(f"{what} has {_shown(value)} where a number belongs")
    return float(value)


def _shown(value: object) -> str:
    return repr(value)[:40]
