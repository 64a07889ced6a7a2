"""A cube as six files: what tools call them, and where they are.

The names of a set are in the order px nx py ny pz nz of pictures seen from inside, px to the right of pz (see
`cube_layouts`), and every set's pictures go on into each other as those do. Game engines of Quake's line call what is
to the right of ``rt`` ``ft``, and draw ``up`` and ``dn`` for one who looks towards ``rt`` before raising or lowering
his head: ``rt`` is pz and ``ft`` px.
"""

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from reflet.envmap.parameterizations.cube import FACES
from reflet.errors import RefletError
from reflet.files.unreadable import unreadable

_NUMBERS = ("0", "1", "2", "3", "4", "5")
NAMES = (
    FACES,
    ("posx", "negx", "posy", "negy", "posz", "negz"),
    ("xpos", "xneg", "ypos", "yneg", "zpos", "zneg"),
    ("+x", "-x", "+y", "-y", "+z", "-z"),
    ("x+", "x-", "y+", "y-", "z+", "z-"),
    ("right", "left", "top", "bottom", "front", "back"),
    ("right", "left", "up", "down", "front", "back"),
    ("r", "l", "u", "d", "f", "b"),
    ("ft", "bk", "up", "dn", "rt", "lf"),
    ("c00", "c01", "c02", "c03", "c04", "c05"),
    _NUMBERS,
)
"""What the files may be called, in any case: a name alone, or behind a word. One letter needs - _ . or a space between,
a digit no digit before it."""

PLACEHOLDER = "{face}"

_SAID = "px nx py ny pz nz, posx … negz, +x … -z, right left top bottom front back, ft bk up dn rt lf, or 0 … 5"
_ENOUGH = 3  # files of a set by which it is one that is not whole


@dataclass(frozen=True)
class SixFiles:
    """The files in the order px nx py ny pz nz, and what is in doubt about that."""

    paths: tuple[Path, ...]
    doubts: tuple[str, ...]


@dataclass(frozen=True)
class _Set:
    """Files that belong together: what stands before the faces' names, the suffix, and the number in `NAMES`."""

    head: str
    suffix: str
    kind: int


_Sets = dict[_Set, dict[int, Path]]


def six_files(path: Path, suffixes: Iterable[str]) -> SixFiles | None:
    """The files that a folder holds or a name with ``{face}`` in it means; None for any other path.

    Raises RefletError where there are none, or several such sets.
    """
    if PLACEHOLDER in path.name:
        head, _, tail = path.name.partition(PLACEHOLDER)
        pattern = re.compile(rf"{re.escape(head)}(?P<face>.+){re.escape(tail)}", re.IGNORECASE)
        found: _Sets = {}
        for name in _names_in(path.parent):
            match = pattern.fullmatch(name)
            for kind, face in _faces_called(match["face"]) if match else ():
                found.setdefault(_Set("", "", kind), {})[face] = path.with_name(name)
        return _the_whole_one(path, found)
    if path.is_dir():
        return _the_whole_one(path, _sets_in(path, frozenset(suffixes)))
    return None


def names_a_face(path: Path) -> bool:
    """Whether a file's name may be that of a cube's face."""
    return any(True for _ in _readings(path.stem.lower()))


def siblings_of(path: Path, suffixes: Iterable[str]) -> SixFiles | None:
    """The six files of which ``path`` is one by its name; None where it stands alone, or beside few others.

    Raises RefletError where some of the six are missing, but not most; numbers that are not whole are no cube.
    """
    sets = _sets_in(path.parent, frozenset(suffixes))
    mine = {
        key: faces
        for key, faces in sets.items()
        if path in faces.values() and len(faces) >= (6 if NAMES[key.kind] == _NUMBERS else _ENOUGH)
    }
    return _the_whole_one(path, mine) if mine else None


def named_files(path: Path, names: tuple[str, ...] = FACES) -> tuple[Path, ...]:
    """What a name with ``{face}`` in it means."""
    return tuple(path.with_name(path.name.replace(PLACEHOLDER, name)) for name in names)


def _faces_called(word: str) -> Iterator[tuple[int, int]]:
    """(kind, face) of every set that has this word for a name."""
    for kind, names in enumerate(NAMES):
        if word.lower() in names:
            yield kind, names.index(word.lower())


def _readings(stem: str) -> Iterator[tuple[str, int, int]]:
    """(head, kind, face) of all that a file's name in lower case may mean."""
    for kind, names in enumerate(NAMES):
        before = {"0": r".*[^0-9]", "r": r".*[-_. ]"}.get(names[0], ".*")
        found = re.fullmatch(rf"(|{before})({'|'.join(map(re.escape, names))})", stem)
        if found:
            yield found[1], kind, names.index(found[2])


def _names_in(folder: Path) -> list[str]:
    try:
        return sorted(os.listdir(folder))
    except OSError as error:
        raise unreadable(folder, error) from error


def _sets_in(folder: Path, suffixes: frozenset[str]) -> _Sets:
    sets: _Sets = {}
    for path in (folder / name for name in _names_in(folder)):
        if path.suffix.lower() in suffixes:
            for head, kind, face in _readings(path.stem.lower()):
                sets.setdefault(_Set(head, path.suffix.lower(), kind), {})[face] = path
    return sets


def _the_whole_one(path: Path, sets: _Sets) -> SixFiles:
    """The one set that has all six. Raises RefletError where there is none, or several."""
    whole = {key: faces for key, faces in sets.items() if len(faces) == 6}
    if len(whole) > 1:
        said = " and ".join(faces[0].name for faces in list(whole.values())[:2])
        raise RefletError(f"{path} holds several cubes ({said}); say which by a name with {PLACEHOLDER} in it.")
    if not whole:
        key, most = max(sets.items(), key=lambda item: len(item[1]), default=(None, {}))
        if key is not None and len(most) >= _ENOUGH:
            lacking = " ".join(name for face, name in enumerate(NAMES[key.kind]) if face not in most)
            raise RefletError(
                f"{path} does not name six files of a cube: beside {most[min(most)].name} those called {lacking} are "
                "missing."
            )
        raise RefletError(f"{path} does not name the six files of a cube; call them {_SAID}.")
    (key, faces) = next(iter(whole.items()))
    doubts: tuple[str, ...] = ()
    if NAMES[key.kind][0] == "0":
        doubts = (f"{path}: the files 0 1 2 3 4 5 are taken as px nx py ny pz nz.",)
    return SixFiles(tuple(faces[face] for face in range(6)), doubts)
