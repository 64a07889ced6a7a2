"""A cube as six files: what they are called and where they are."""

import os
import re
from collections.abc import Iterable
from pathlib import Path

from reflet.envmap.parameterizations.cube import FACES
from reflet.errors import RefletError
from reflet.files.unreadable import unreadable

NAMES = (
    FACES,
    ("posx", "negx", "posy", "negy", "posz", "negz"),
    ("right", "left", "top", "bottom", "front", "back"),
)
"""What the files may be called, in the order of the faces: a name alone, or after a word and one of - _ . or space."""

PLACEHOLDER = "{face}"


def six_files(path: Path, suffixes: Iterable[str]) -> tuple[Path, ...] | None:
    """The files, in the order of the faces, that a folder holds or a name with ``{face}`` in it means.

    None for any other path. Raises RefletError where there are none, or several such sets.
    """
    if PLACEHOLDER in path.name:
        for names in NAMES:
            files = named_files(path, names)
            if all(file.is_file() for file in files):
                return files
    elif path.is_dir():
        found = _in_folder(path, frozenset(suffixes))
        if found is not None:
            return found
    else:
        return None
    raise RefletError(
        f"{path} does not name the six files of a cube; call them px nx py ny pz nz, posx … negz, or right left top "
        "bottom front back."
    )


def named_files(path: Path, names: tuple[str, ...] = FACES) -> tuple[Path, ...]:
    """What a name with ``{face}`` in it means."""
    return tuple(path.with_name(path.name.replace(PLACEHOLDER, name)) for name in names)


def _in_folder(folder: Path, suffixes: frozenset[str]) -> tuple[Path, ...] | None:
    try:
        entries = sorted(os.listdir(folder))
    except OSError as error:
        raise unreadable(folder, error) from error
    cubes: dict[tuple[str, str, int], dict[int, Path]] = {}
    for path in (folder / entry for entry in entries):
        for kind, names in enumerate(NAMES):
            found = re.fullmatch(rf"(|.*[-_. ])({'|'.join(names)})", path.stem.lower())
            if found and path.suffix.lower() in suffixes:
                cubes.setdefault((found[1], path.suffix, kind), {})[names.index(found[2])] = path
    whole = [faces for faces in cubes.values() if len(faces) == 6]
    if len(whole) > 1:
        said = " and ".join(faces[0].name for faces in whole[:2])
        raise RefletError(f"{folder} holds several cubes ({said}); say which by a name with {PLACEHOLDER} in it.")
    return tuple(whole[0][face] for face in range(6)) if whole else None
