"""What a Wavefront OBJ file says, as arrays; where it says nothing that can be used, a sentence naming the line.

Two passes over its bytes: the first one counts, so that the second writes into arrays of the right size. Neither needs
more memory than the file and these arrays.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, Int32, Int64, UInt8

from reflet.errors import RefletError
from reflet.scene.readers.obj.plain_text import decoded, quoted, read_text_bytes
from reflet.scene.readers.obj.scan import Count, Kind, ObjArrays, scan
from reflet.scene.readers.obj.tokens import Fault

_SENTENCES = {
    Fault.NO_NUMBER: "where numbers with decimal points were expected",
    Fault.NOT_FINITE: "which is no finite number",
    Fault.TOO_FEW: "which holds too few numbers",
    Fault.NO_INDEX: "where numbers of vertices were expected",
    Fault.ZERO_INDEX: "but vertices are counted from 1",
    Fault.BEFORE_FIRST: "which counts back to before the first vertex",
    Fault.BEYOND_LAST: "which refers to a vertex that is not there",
}
_LEFT_OUT = {
    Count.LINES: "lines",
    Count.POINTS: "points",
    Count.CURVES: "curves and free-form surfaces",
    Count.THIN_FACES: "faces of fewer than three corners",
    Count.COLORS: "vertex colours",
}


@dataclass(frozen=True)
class Statements:
    """Statements of one kind: their texts, each once, and of each statement its text, the faces before it and its place
    among the statements of all kinds."""

    texts: tuple[str, ...]
    text: Int64[np.ndarray, "statements"]
    face: Int64[np.ndarray, "statements"]
    place: Int64[np.ndarray, "statements"]

    def spread(self, values: Int[np.ndarray, "statements"], before: int, count: int) -> Int32[np.ndarray, "faces"]:
        """For each of ``count`` faces the value of the statement that holds there, ``before`` where none does yet."""
        ends = np.append(self.face, count)
        return np.repeat(np.append(before, values).astype(np.int32), np.diff(ends, prepend=0))

    def holding(self, count: int) -> Int64[np.ndarray, "holding"]:
        """The numbers of the statements that hold for any of ``count`` faces."""
        return np.flatnonzero(np.diff(np.append(self.face, count)))


@dataclass(frozen=True)
class ObjText:
    """Indices of ``corners`` (position, uv, normal) count from 0 and are -1 where a corner has none.

    Face f has the corners starts[f] to starts[f + 1] - 1, three or more. Texture coordinates run upwards, as in the
    file. ``names`` are those of objects and groups. ``oddities`` are phrases that say what was left out, with counts.
    """

    positions: Float[np.ndarray, "positions 3"]
    uv: Float[np.ndarray, "coordinates 2"]
    normals: Float[np.ndarray, "normals 3"]
    corners: Int32[np.ndarray, "corners 3"]
    starts: Int64[np.ndarray, "faces_and_one"]
    materials: Statements
    libraries: Statements
    objects: Statements
    names: Statements
    smoothing: Statements
    oddities: tuple[str, ...]


def read_obj_text(path: Path) -> ObjText:
    """Reads a file. Raises RefletError, naming the line, where it is missing, damaged or holds no faces."""
    data = read_text_bytes(path)
    counts = np.zeros(len(Count), np.int64)
    scan(data, None, counts)
    arrays = ObjArrays.of(counts)
    scan(data, arrays, counts)
    starts = np.append(arrays.starts[: counts[Count.FACES]], counts[Count.CORNERS])
    corners = arrays.corners[: counts[Count.CORNERS]]
    dangling = [] if counts[Count.ERROR] else _dangling(corners, counts, starts, arrays.lines)
    if counts[Count.ERROR]:
        number = int(counts[Count.ERROR_LINE])
        reason = _SENTENCES[Fault(counts[Count.ERROR])]
        raise _damaged(path, data, number, f", {reason}")
    if not counts[Count.FACES]:
        if counts[Count.UNKNOWN] and not counts[Count.POSITIONS]:
            raise _damaged(path, data, int(counts[Count.UNKNOWN_LINE]), "")
        held = ", ".join(f"{counts[place]} {what}" for place, what in _LEFT_OUT.items() if counts[place])
        held = f"{counts[Count.POSITIONS]} vertices" + (f", {held}" if held else "")
        raise RefletError(f"{path} holds no faces, only {held}; export it with its surfaces as polygons.")
    return ObjText(
        arrays.positions,
        arrays.uv,
        arrays.normals,
        corners,
        starts,
        materials=_statements(data, arrays, Kind.USEMTL),
        libraries=_statements(data, arrays, Kind.MTLLIB),
        objects=_statements(data, arrays, Kind.OBJECT),
        names=_statements(data, arrays, Kind.OBJECT, Kind.GROUP),
        smoothing=_statements(data, arrays, Kind.SMOOTHING),
        oddities=(*_oddities(data, counts), *dangling),
    )


def _dangling(
    corners: Int32[np.ndarray, "corners 3"],
    counts: Int64[np.ndarray, "counts"],
    starts: Int64[np.ndarray, "faces_and_one"],
    lines: Int32[np.ndarray, "faces"],
) -> list[str]:
    """Takes away indices of uv and normals that are not there, and says how many; a missing position is an error."""
    phrases = []
    beyond = corners[:, 0] >= counts[Count.POSITIONS]
    if beyond.any():
        face = np.searchsorted(starts, np.argmax(beyond), side="right") - 1
        counts[Count.ERROR], counts[Count.ERROR_LINE] = Fault.BEYOND_LAST, lines[face]
    for column, size, what in ((1, counts[Count.COORDINATES], "texture coordinates"),
                               (2, counts[Count.NORMALS], "normals")):  # fmt: skip
        beyond = corners[:, column] >= size
        if beyond.any():
            corners[beyond, column] = -1
            phrases.append(f"{what} that are not there ({np.count_nonzero(beyond)} corners) are left out")
    return phrases


def _oddities(data: UInt8[np.ndarray, "bytes"], counts: Int64[np.ndarray, "counts"]) -> list[str]:
    phrases = [f"{what} ({counts[place]}) are left out" for place, what in _LEFT_OUT.items() if counts[place]]
    if counts[Count.UNKNOWN]:
        number = int(counts[Count.UNKNOWN_LINE])
        first = f"the first is line {number}, {quoted(_line(data, number))}"
        phrases.append(f"lines of unknown kind ({counts[Count.UNKNOWN]}, {first}) are left out")
    if counts[Count.BAD_NORMALS]:
        phrases.append(f"normals that are no numbers ({counts[Count.BAD_NORMALS]}) are computed from the faces")
    if counts[Count.BAD_COORDINATES]:
        phrases.append(f"texture coordinates that are no numbers ({counts[Count.BAD_COORDINATES]}) are taken as 0")
    return phrases


def _damaged(path: Path, data: UInt8[np.ndarray, "bytes"], number: int, reason: str) -> RefletError:
    said = quoted(_line(data, number))
    return RefletError(f"{path} is no valid OBJ file: line {number} reads {said}{reason}; export it again.")


def _line(data: UInt8[np.ndarray, "bytes"], number: int) -> str:
    """The text of a line, counted from 1, or its beginning."""
    returns = data[:-1] == 13
    ends = data == 10
    ends[:-1] |= returns & (data[1:] != 10)
    start = 0 if number == 1 else int(np.flatnonzero(ends)[number - 2]) + 1
    return decoded(data[start : start + 400].tobytes().replace(b"\r", b"\n").split(b"\n", 1)[0])


def _statements(data: UInt8[np.ndarray, "bytes"], arrays: ObjArrays, *kinds: Kind) -> Statements:
    place = np.flatnonzero(np.isin(arrays.statements[:, 0], kinds))
    rows = arrays.statements[place]
    _, first, text = np.unique(arrays.hashes[place], return_index=True, return_inverse=True)
    texts = (data[rows[at, 1] : rows[at, 2]].tobytes() for at in first)
    joined = (decoded(name.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").replace(b"\\\r", b" ")) for name in texts)
    return Statements(tuple(joined), text.astype(np.int64), np.ascontiguousarray(rows[:, 3]), place)
