"""One pass over the bytes of an OBJ file, compiled: it counts statements, or writes them into arrays."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from jaxtyping import Float, Int32, Int64, UInt8, UInt64
from numba import njit

from reflet.scene.readers.obj.tokens import (
    NUMBER_SIGN,
    Fault,
    at_end,
    fnv_hash,
    line_break,
    past_blanks,
    past_token,
    past_value,
    read_corner,
    read_numbers,
    statement_end,
)


class Kind(IntEnum):
    """Kinds of lines. Those up to SMOOTHING hold for the faces behind them."""

    USEMTL = 0
    MTLLIB = 1
    OBJECT = 2
    GROUP = 3
    SMOOTHING = 4
    POSITION = 5
    COORDINATES = 6
    NORMAL = 7
    FACE = 8
    LINE = 9
    POINT = 10
    CURVE = 11
    SILENT = 12
    UNKNOWN = 13


class Count(IntEnum):
    """Places in the array of counts. ERROR is a `Fault` or 0, ERROR_LINE and UNKNOWN_LINE count lines from 1."""

    POSITIONS = 0
    COORDINATES = 1
    NORMALS = 2
    CORNERS = 3
    FACES = 4
    STATEMENTS = 5
    COLORS = 6
    THIN_FACES = 7
    LINES = 8
    POINTS = 9
    CURVES = 10
    UNKNOWN = 11
    UNKNOWN_LINE = 12
    BAD_NORMALS = 13
    BAD_COORDINATES = 14
    ERROR = 15
    ERROR_LINE = 16


@dataclass(frozen=True)
class ObjArrays:
    """What a pass over a file fills. Positions, uv and normals as they stand there, other numbers from 0.

    ``corners`` are indices of position, uv and normal, -1 where absent; ``starts`` the first corner and ``lines`` the
    line of each face. A row of ``statements`` is kind, first byte, byte behind the last one, and faces before it;
    ``hashes`` are those of the bytes.
    """

    positions: Float[np.ndarray, "positions 3"]
    uv: Float[np.ndarray, "coordinates 2"]
    normals: Float[np.ndarray, "normals 3"]
    corners: Int32[np.ndarray, "corners 3"]
    starts: Int64[np.ndarray, "faces"]
    lines: Int32[np.ndarray, "faces"]
    statements: Int64[np.ndarray, "statements 4"]
    hashes: UInt64[np.ndarray, "statements"]

    @classmethod
    def of(cls, counts: Int64[np.ndarray, "counts"]) -> "ObjArrays":
        """Arrays of the sizes that a first pass counted."""
        faces, statements = counts[Count.FACES], counts[Count.STATEMENTS]
        return cls(
            np.zeros((counts[Count.POSITIONS], 3)),
            np.zeros((counts[Count.COORDINATES], 2)),
            np.zeros((counts[Count.NORMALS], 3)),
            np.zeros((counts[Count.CORNERS], 3), np.int32),
            np.zeros(faces, np.int64),
            np.zeros(faces, np.int32),
            np.zeros((statements, 4), np.int64),
            np.zeros(statements, np.uint64),
        )


_WORDS = {
    "usemtl": Kind.USEMTL, "mtllib": Kind.MTLLIB, "o": Kind.OBJECT, "g": Kind.GROUP, "s": Kind.SMOOTHING,
    "v": Kind.POSITION, "vt": Kind.COORDINATES, "vn": Kind.NORMAL, "f": Kind.FACE, "fo": Kind.FACE,
    "l": Kind.LINE, "p": Kind.POINT, "curv": Kind.CURVE, "curv2": Kind.CURVE, "surf": Kind.CURVE,
} | dict.fromkeys(
    # what belongs to curves and surfaces, and what shows nothing
    ("vp", "cstype", "deg", "bmat", "step", "parm", "trim", "hole", "scrv", "sp", "end", "con", "cdc", "cdp", "bzp",
     "bsp", "res", "mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech", "stech"),
    Kind.SILENT,
)  # fmt: skip


def _word_hashes() -> UInt64[np.ndarray, "words"]:
    with np.errstate(over="ignore"):  # the hash runs over by design
        hashes = [fnv_hash.py_func(np.frombuffer(word.encode(), np.uint8), 0, len(word)) for word in _WORDS]
    return np.array(hashes, np.uint64)


_HASHES = _word_hashes()
_KINDS = np.array([int(kind) for kind in _WORDS.values()])


@njit(cache=True)
def _kind_of(data, start, end, hashes, kinds):
    if end - start == 1 and data[start] == 118:  # v
        return Kind.POSITION.value
    if end - start == 1 and data[start] == 102:  # f
        return Kind.FACE.value
    value = fnv_hash(data, start, end)
    for word in range(len(hashes)):
        if hashes[word] == value:
            return kinds[word]
    return Kind.UNKNOWN.value


@njit(cache=True)
def _scan(
    data, fill, hashes, kinds, counts, positions, uv, normals, corners, starts, lines, statements, statement_hashes
):
    at, line = 0, 1
    row, corner, sizes = np.zeros(3), np.zeros(3, np.int64), np.zeros(3, np.int64)
    while at < len(data):
        first_line = line
        at, passed = past_blanks(data, at)
        line += passed
        if not at_end(data, at):
            end = past_token(data, at)
            kind = _kind_of(data, at, end, hashes, kinds)
            fault = 0
            at = end
            if Kind.POSITION.value <= kind <= Kind.NORMAL.value:
                column = kind - Kind.POSITION.value
                row[:] = 0.0
                at, count, passed, fault = read_numbers(data, at, row[: 2 if column == 1 else 3], fill)
                line += passed
                if count < (1 if column == 1 else 3) and fault != Fault.NO_NUMBER.value:
                    fault = Fault.TOO_FEW.value
                if column > 0 and fault == Fault.NOT_FINITE.value:
                    counts[Count.BAD_COORDINATES.value if column == 1 else Count.BAD_NORMALS.value] += 1
                    row[:] = 0.0
                    fault = 0
                if column == 0 and count >= 6:
                    counts[Count.COLORS.value] += 1
                if fill:
                    table = positions if column == 0 else (uv if column == 1 else normals)
                    for k in range(table.shape[1]):
                        table[sizes[column], k] = row[k]
                sizes[column] += 1
            elif kind == Kind.FACE.value:
                first, n = counts[Count.CORNERS.value], counts[Count.CORNERS.value]
                while fault == 0:
                    at, passed = past_blanks(data, at)
                    line += passed
                    if at_end(data, at):
                        break
                    if fill:
                        at, fault = read_corner(data, at, sizes, corner)
                        if n < len(corners):  # the first pass counted no corners of thin faces
                            for k in range(3):
                                corners[n, k] = corner[k]
                    else:
                        at = past_value(data, at)
                    n += 1
                if n - first < 3:
                    counts[Count.THIN_FACES.value] += 1
                elif fault == 0:
                    if fill:
                        starts[counts[Count.FACES.value]] = first
                        lines[counts[Count.FACES.value]] = first_line
                    counts[Count.FACES.value] += 1
                    counts[Count.CORNERS.value] = n
            elif kind <= Kind.SMOOTHING.value:
                start, passed = past_blanks(data, at)
                line += passed
                at, passed, last = statement_end(data, start)
                line += passed
                if fill:
                    statements[counts[Count.STATEMENTS.value], 0] = kind
                    statements[counts[Count.STATEMENTS.value], 1] = start
                    statements[counts[Count.STATEMENTS.value], 2] = last
                    statements[counts[Count.STATEMENTS.value], 3] = counts[Count.FACES.value]
                    statement_hashes[counts[Count.STATEMENTS.value]] = fnv_hash(data, start, last)
                counts[Count.STATEMENTS.value] += 1
            elif kind == Kind.LINE.value:
                counts[Count.LINES.value] += 1
            elif kind == Kind.POINT.value:
                counts[Count.POINTS.value] += 1
            elif kind == Kind.CURVE.value:
                counts[Count.CURVES.value] += 1
            elif kind == Kind.UNKNOWN.value:
                counts[Count.UNKNOWN.value] += 1
                if counts[Count.UNKNOWN.value] == 1:
                    counts[Count.UNKNOWN_LINE.value] = first_line
            if fault:
                counts[Count.ERROR.value], counts[Count.ERROR_LINE.value] = fault, first_line
                break
        if at < len(data) and data[at] == NUMBER_SIGN:  # no backslash continues a comment, which may end in a path
            while at < len(data) and not line_break(data, at):
                at += 1
        else:
            at, passed, _ = statement_end(data, at)
            line += passed
        at += line_break(data, at)
        line += 1
    counts[Count.POSITIONS.value : Count.NORMALS.value + 1] = sizes


def scan(data: UInt8[np.ndarray, "bytes"], arrays: "ObjArrays | None", counts: Int64[np.ndarray, "counts"]) -> None:
    """Counts the statements of a file, and writes them into ``arrays`` if there are any. Stops at the first fault,
    which only a pass that writes can find."""
    target = ObjArrays.of(np.zeros(len(Count), np.int64)) if arrays is None else arrays
    counts[:] = 0
    _scan(data, arrays is not None, _HASHES, _KINDS, counts, target.positions, target.uv, target.normals,
          target.corners, target.starts, target.lines, target.statements, target.hashes)  # fmt: skip
