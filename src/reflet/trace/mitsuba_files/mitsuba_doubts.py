"""What of a Mitsuba scene will look other than in Mitsuba."""

import warnings

from reflet.errors import RefletWarning

_MOST_NAMES = 8


class Doubts:
    """Collects the names that a sentence is true of, so that each is said once, with how many there are."""

    def __init__(self) -> None:
        self._names: dict[str, list[str]] = {}

    def add(self, what: str, name: str) -> None:
        """``what`` is the sentence without its full stop, such as "Clear coats are left out"."""
        names = self._names.setdefault(what, [])
        if name not in names:
            names.append(name)

    def say(self) -> None:
        """One RefletWarning for each sentence."""
        for what, names in self._names.items():
            more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
            listed = ", ".join(names[:_MOST_NAMES]) + more
            warnings.warn(f"{what}: {listed}.", RefletWarning, stacklevel=4)
