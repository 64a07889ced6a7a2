"""Factors of glTF materials, put within their range; whatever was beyond it is said."""

from reflet.scene.readers.gltf.values import JsonObject, number, numbers
from reflet.scene.readers.notes import Notes

_UNBOUNDED = float("inf")


class Factors:
    """Those of one material, number ``index`` of the file."""

    def __init__(self, notes: Notes, index: int, name: str) -> None:
        self._notes, self._index, self._name = notes, index, name

    def share(self, parent: JsonObject, key: str, default: float) -> float:
        """A number from 0 to 1."""
        return self._within((number(parent, key, default),), key)[0]

    def shares(self, parent: JsonObject, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Numbers from 0 to 1, as many as ``default`` has."""
        return self._within(numbers(parent, key, default), key)

    def amount(self, parent: JsonObject, key: str, default: float) -> float:
        """A number that is not negative."""
        return self._within((number(parent, key, default),), key, _UNBOUNDED)[0]

    def amounts(self, parent: JsonObject, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
        """Numbers that are not negative, as many as ``default`` has."""
        return self._within(numbers(parent, key, default), key, _UNBOUNDED)

    def note(self, what: str) -> None:
        """``what`` is said of this material."""
        self._notes.add(what, "materials", self._index, self._name)

    def _within(self, values: tuple[float, ...], key: str, highest: float = 1.0) -> tuple[float, ...]:
        if min(values) < 0.0 or max(values) > highest:
            beyond = "below 0 or above 1 is taken as the nearer of them" if highest == 1.0 else "below 0 is taken as 0"
            self.note(f"{key} {beyond}")
        return tuple(min(max(value, 0.0), highest) for value in values)
