"""Which material each face of an OBJ file has, out of all .mtl files that it names."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Int32

from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import MIRROR
from reflet.scene.readers.obj.mtl import MaterialFile, PlacedMaterial
from reflet.scene.readers.obj.plain_text import listed, name_of
from reflet.scene.readers.obj.statements import ObjText
from reflet.scene.readers.resources import find_resource


def materials_of(text: ObjText, path: Path) -> tuple[list[PlacedMaterial], Int32[np.ndarray, "faces"]]:
    """Materials, and the number of each face's. Number 0 is a mirror, for faces that have none.

    A name means the material of the nearest mtllib line before it that has one so called, else of the next line behind
    it; of several files in one line it is the first. Names that no file has are mirrors, with a RefletWarning, and
    what the materials say and is not honoured is said in others.
    """
    used = text.materials.holding(len(text.starts) - 1)
    # how many mtllib lines stand before each usemtl line: with its text, all that its meaning depends on
    before = np.searchsorted(text.libraries.place, text.materials.place[used])
    libraries = _Libraries(text, path)
    materials, numbers = [PlacedMaterial(MIRROR)], {"": 0}
    number_of: dict[tuple[int, int], int] = {}
    meanings = list(zip(text.materials.text[used].tolist(), before.tolist(), strict=True))
    for meaning in dict.fromkeys(meanings):
        name = name_of(text.materials.texts[meaning[0]])
        file, known = libraries.find(name, meaning[1]) if name else (None, None)
        key = f"{file.path}\n{known}" if file and known is not None else name
        if key not in numbers:
            numbers[key] = len(materials)
            placed = PlacedMaterial(replace(MIRROR, name=name))
            materials.append(file.material(known) if file and known is not None else placed)
        number_of[meaning] = numbers[key]
    libraries.warn()
    of_statement = np.zeros(len(text.materials.text), np.int32)
    of_statement[used] = [number_of[meaning] for meaning in meanings]
    return materials, text.materials.spread(of_statement, 0, len(text.starts) - 1)


class _Libraries:
    """The .mtl files of all mtllib lines, each read once and only when a name is looked for."""

    def __init__(self, text: ObjText, path: Path) -> None:
        self._path = path
        self._lines = text.libraries.texts
        self._places = [np.flatnonzero(text.libraries.text == k) for k in range(len(self._lines))]
        self._files: dict[int, list[MaterialFile]] = {}
        self._opened: dict[Path, MaterialFile] = {}
        self._missing: list[str] = []
        self._lost: list[str] = []

    def find(self, name: str, before: int) -> tuple[MaterialFile | None, str | None]:
        """The file that has the material, for a usemtl line behind ``before`` mtllib lines, and its name there."""
        holders = {line: [file for file in self._opened_files(line) if file.find(name) is not None]
                   for line in range(len(self._lines))}  # fmt: skip
        lines = [line for line, files in holders.items() if files]
        if not lines:
            self._missing.append(name)
            return None, None
        files = holders[min(lines, key=lambda line: self._distance(line, before))]
        if len(files) > 1:
            text = f"{self._path.name}: material {name} is in {files[0].path.name} and {files[1].path.name}"
            warnings.warn(f"{text}; the first one is used.", RefletWarning, stacklevel=5)
        return files[0], files[0].find(name)

    def _distance(self, line: int, before: int) -> tuple[int, int]:
        """Less for nearer lines; all that stand behind are farther than those before."""
        places = self._places[line]
        at = int(np.searchsorted(places, before))
        return (0, before - int(places[at - 1])) if at else (1, int(places[0]))

    def warn(self) -> None:
        """Says what is missing, and what the files say and is not honoured."""
        for sentence in self._lost:
            text = f"{self._path.name}: {sentence.rstrip('.')}; until then its materials are mirrors."
            warnings.warn(text, RefletWarning, stacklevel=4)
        if self._missing:
            names = listed(list(dict.fromkeys(self._missing)))
            held = "which no .mtl file defines" if self._lines else "but no mtllib line names a file that has them"
            text = f"{self._path.name} uses materials, {held}; they are mirrors: {names}."
            warnings.warn(text, RefletWarning, stacklevel=4)
        for file in self._opened.values():
            file.warn()

    def _opened_files(self, line: int) -> list[MaterialFile]:
        if line not in self._files:
            files = []
            for path in self._paths(self._lines[line]):
                try:
                    if path not in self._opened:
                        self._opened[path] = MaterialFile(path)
                    files.append(self._opened[path])
                except RefletError as error:
                    self._lost.append(str(error))
            self._files[line] = files
        return self._files[line]

    def _paths(self, statement: str) -> list[Path]:
        """The files that a mtllib line names: one name with blanks, or several names."""
        folder, whole = self._path.parent, name_of(statement)
        alone = _found(folder, whole)
        if alone is not None:
            return [alone]
        paths: list[Path] = []
        for name in re.split(r"(?<=\.mtl)\s+", whole, flags=re.IGNORECASE):
            words = [name] if _found(folder, name) or not any(_found(folder, w) for w in name.split()) else name.split()
            for word in words:
                try:
                    paths.append(find_resource(folder, word))
                except RefletError as error:
                    self._lost.append(str(error))
        return paths


def _found(folder: Path, name: str) -> Path | None:
    try:
        return find_resource(folder, name)
    except RefletError:
        return None
