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
        texts = text.libraries.texts
        self._statements = list(texts) if len(texts) == 1 else [texts[k] for k in text.libraries.text]
        self._files: dict[str, list[MaterialFile]] = {}
        self._opened: dict[Path, MaterialFile] = {}
        self._missing: list[str] = []
        self._lost: list[str] = []

    def find(self, name: str, before: int) -> tuple[MaterialFile | None, str | None]:
        """The file that has the material, for a usemtl line behind ``before`` mtllib lines, and its name there."""
        nearest = [*reversed(self._statements[:before]), *self._statements[before:]]
        for statement in dict.fromkeys(nearest):
            holders = [file for file in self._opened_files(statement) if file.find(name) is not None]
            if len(holders) > 1:
                both = f"{holders[0].path.name} and {holders[1].path.name}"
                text = f"{self._path.name}: material {name} is in {both}; the first one is used."
                warnings.warn(text, RefletWarning, stacklevel=5)
            if holders:
                return holders[0], holders[0].find(name)
        self._missing.append(name)
        return None, None

    def warn(self) -> None:
        """Says what is missing, and what the files say and is not honoured."""
        for sentence in self._lost:
            text = f"{self._path.name}: {sentence.rstrip('.')}; until then its materials are mirrors."
            warnings.warn(text, RefletWarning, stacklevel=4)
        if self._missing:
            names = listed(list(dict.fromkeys(self._missing)))
            held = "which no .mtl file defines" if self._statements else "but no mtllib line names a file that has them"
            text = f"{self._path.name} uses materials, {held}; they are mirrors: {names}."
            warnings.warn(text, RefletWarning, stacklevel=4)
        for file in self._opened.values():
            file.warn()

    def _opened_files(self, statement: str) -> list[MaterialFile]:
        if statement not in self._files:
            files = []
            for path in self._paths(statement):
                try:
                    if path not in self._opened:
                        self._opened[path] = MaterialFile(path)
                    files.append(self._opened[path])
                except RefletError as error:
                    self._lost.append(str(error))
            self._files[statement] = files
        return self._files[statement]

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
