"""The lines of a Wavefront .mtl file, by material, and the numbers in them."""

from dataclasses import dataclass
from pathlib import Path

from reflet.errors import RefletError
from reflet.scene.readers.obj.plain_text import lines, name_of, quoted, read_text_bytes


@dataclass(frozen=True)
class MtlLine:
    """A statement: the file and the line where it stands, the whole line, and what stands behind its keyword."""

    path: Path
    number: int
    text: str
    value: str

    def numbers(self) -> list[float]:
        """Its numbers, one to three. Raises RefletError, with the line, where it holds none."""
        try:
            values = [float(word) for word in self.value.split("#")[0].removeprefix("-halo").split()[:3]]
        except ValueError:
            values = []
        if not values or not all(abs(value) < 1e30 for value in values):
            raise RefletError(
                f"{self.path} is no valid material file: line {self.number} reads {quoted(self.text)}, where numbers "
                "with decimal points were expected; export it again."
            )
        return values


@dataclass(frozen=True)
class MtlLines:
    """Of each material its lines by keyword, in small letters; of lines that say the same the last one stays.

    ``stray`` are lines with keywords not asked for, or before the first material; ``doubled`` materials that are
    defined more than once, of which the last definition stays.
    """

    materials: dict[str, dict[str, MtlLine]]
    stray: list[MtlLine]
    doubled: list[str]


def read_mtl_lines(path: Path, keywords: set[str]) -> MtlLines:
    """Reads a file. Raises RefletError where it cannot be read."""
    found = MtlLines({}, [], [])
    current: dict[str, MtlLine] | None = None
    for number, text in lines(read_text_bytes(path).tobytes()):
        word, value = (*text.split(None, 1), "", "")[:2]
        line, word = MtlLine(path, number, text, value.strip()), word.lower()
        if word == "newmtl":
            name, current = name_of(value), {}
            if name in found.materials:
                found.doubled.append(name)
            found.materials[name] = current
        elif word and not word.startswith("#"):
            if current is None or word not in keywords:
                found.stray.append(line)
            else:
                current[word] = line
    return found
