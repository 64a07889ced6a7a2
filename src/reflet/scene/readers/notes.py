"""What a reader has to say about a file, said once for each kind, with how many and which."""

import warnings
from collections.abc import Hashable, Mapping
from pathlib import Path

from reflet.errors import RefletWarning

_SHOWN = 5


class Notes:
    """Collects what is shown otherwise than a file says, and says it in one RefletWarning for each kind.

    ``totals`` gives for each unit that is counted ("materials", "nodes") how many the file has.
    """

    def __init__(self, path: Path, totals: Mapping[str, int]) -> None:
        self._path, self._totals = path, totals
        self._members: dict[tuple[str, str], dict[Hashable, str]] = {}

    def add(self, what: str, unit: str, key: Hashable, name: str) -> None:
        """``what`` is said of one more ``unit``, called ``name``; equal keys count once."""
        self._members.setdefault((what, unit), {})[key] = name

    def say(self, level: int) -> None:
        """Warns of all that was collected; ``level`` is warnings.warn's stacklevel as the caller would give it."""
        for (what, unit), members in self._members.items():
            names = list(members.values())
            listed = ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
            total = self._totals[unit]  # fewer than the names where a file refers to what it does not have
            counted = f"{len(names)}{f' of {total}' if total >= len(names) else ''} {unit}: {listed}"
            warnings.warn(f"{self._path.name}: {what} ({counted}).", RefletWarning, stacklevel=level + 1)
