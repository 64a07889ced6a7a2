"""Words and numbers in the bytes of an OBJ file, compiled. Places are indices into the bytes."""

from enum import IntEnum

import numpy as np
from numba import njit


class Fault(IntEnum):
    """What is wrong with a line."""

    NO_NUMBER = 1
    NOT_FINITE = 2
    TOO_FEW = 3
    NO_INDEX = 4
    ZERO_INDEX = 5
    BEFORE_FIRST = 6
    BEYOND_LAST = 7


_OFFSET, _PRIME = np.uint64(0xCBF29CE484222325), np.uint64(0x100000001B3)
_TAB, _FEED, _NEWLINE, _RETURN, _BLANK, NUMBER_SIGN, _PLUS, _MINUS, _POINT, _SLASH, _ZERO, _NINE, _BACKSLASH, _END = (
    9, 12, 10, 13, 32, 35, 43, 45, 46, 47, 48, 57, 92, 26,
)  # fmt: skip
_POWERS = 10.0 ** np.arange(23)  # these are exact
_LARGEST = float(np.finfo(np.float32).max)


@njit(cache=True)
def fnv_hash(data, start, end):
    """The bytes' 64-bit FNV-1a hash [Fowler, Noll and Vo]."""
    value = _OFFSET
    for at in range(start, end):
        value = (value ^ np.uint64(data[at])) * _PRIME
    return value


@njit(cache=True)
def line_break(data, at):
    """Length of the line end at a place: 0, 1 or 2."""
    if at >= len(data) or (data[at] != _NEWLINE and data[at] != _RETURN):
        return 0
    return 2 if data[at] == _RETURN and at + 1 < len(data) and data[at + 1] == _NEWLINE else 1


@njit(cache=True)
def _is_blank(byte):
    return byte in (_BLANK, _END) or (_TAB <= byte <= _FEED and byte != _NEWLINE)


@njit(cache=True)
def past_blanks(data, at):
    """The next place that is no blank, and the line ends that were passed because a backslash stood before them."""
    passed = 0
    while at < len(data):
        if _is_blank(data[at]):
            at += 1
        elif data[at] == _BACKSLASH and line_break(data, at + 1):
            at += 1 + line_break(data, at + 1)
            passed += 1
        else:
            break
    return at, passed


@njit(cache=True)
def past_token(data, at):
    while at < len(data) and not _is_blank(data[at]) and not line_break(data, at):
        if data[at] == _BACKSLASH and line_break(data, at + 1):
            break
        at += 1
    return at


@njit(cache=True)
def past_value(data, at):
    """As `past_token`, but a comment may follow at once: # ends a value, save in Microsoft's 1.#QNAN."""
    end = past_token(data, at)
    while at < end and (data[at] != NUMBER_SIGN or (at > 0 and data[at - 1] == _POINT)):
        at += 1
    return at


@njit(cache=True)
def at_end(data, at):
    """Whether the statement ends here: at a line end or a comment."""
    return at >= len(data) or data[at] == NUMBER_SIGN or data[at] == _NEWLINE or data[at] == _RETURN


@njit(cache=True)
def _digits(data, at, mantissa, scale):
    """Digits from ``at`` on behind those of a mantissa; beyond 18 they only count."""
    count = 0
    while at + count < len(data) and _ZERO <= data[at + count] <= _NINE:
        if mantissa < 10**17:
            mantissa = mantissa * 10 + np.int64(data[at + count] - _ZERO)
        else:
            scale += 1
        count += 1
    return at + count, count, mantissa, scale


@njit(cache=True)
def _number(data, at):
    """A number's value, the place behind it, and a `Fault` or 0. Within one unit in the last place of a float64."""
    start, negative = at, data[at] == _MINUS
    if negative or data[at] == _PLUS:
        at += 1
    at, whole, mantissa, scale = _digits(data, at, np.int64(0), 0)
    fraction = 0
    if at < len(data) and data[at] == _POINT:
        at, fraction, mantissa, dropped = _digits(data, at + 1, mantissa, 0)
        scale += dropped - fraction
    if whole + fraction == 0:
        letter = data[at] | 32 if at < len(data) else 0  # nan, inf, -nan(ind)
        second = data[at + 1] | 32 if at + 1 < len(data) else 0
        names = (letter == 110 and second == 97) or (letter == 105 and second == 110)
        return 0.0, past_value(data, start), Fault.NOT_FINITE.value if names else Fault.NO_NUMBER.value
    if at < len(data) and data[at] | 32 in (100, 101):  # Fortran writes d
        sign, after = 1, at + 1
        if after < len(data) and (data[after] == _MINUS or data[after] == _PLUS):
            sign = -1 if data[after] == _MINUS else 1
            after += 1
        after, count, exponent, _ = _digits(data, after, np.int64(0), 0)
        if count:
            at, scale = after, scale + sign * min(exponent, 100000)
    end = past_value(data, at)
    if at < end:
        return 0.0, end, Fault.NOT_FINITE.value if data[at] == NUMBER_SIGN else Fault.NO_NUMBER.value
    value = float(mantissa)
    if 0 <= scale <= 22:
        value = value * _POWERS[scale]
    elif -22 <= scale < 0:
        value = value / _POWERS[-scale]
    else:  # beyond these all powers of ten are rounded; nothing as large or small as that is a float32
        value = value * 10.0 ** max(min(scale, 60), -90)
    return (-value if negative else value), end, 0 if value <= _LARGEST else Fault.NOT_FINITE.value


@njit(cache=True)
def _index(data, at):
    """An integer and the place behind it, the same place where there is none. Large ones are clamped to 31 bits."""
    start, negative = at, at < len(data) and data[at] == _MINUS
    if negative or (at < len(data) and data[at] == _PLUS):
        at += 1
    at, count, value, scale = _digits(data, at, np.int64(0), 0)
    if not count:
        return np.int64(0), start
    value = np.int64(2**31 - 1) if scale or value >= 2**31 else value
    return (-value if negative else value), at


@njit(cache=True)
def read_numbers(data, at, row, fill):
    """Numbers of a statement into ``row``: the place behind, their count, line ends passed, and a `Fault` or 0.

    Numbers beyond the row's length are counted but not read. Not finite ones are told, all others read on.
    """
    count, lines, fault = 0, 0, 0
    while True:
        at, passed = past_blanks(data, at)
        lines += passed
        if at_end(data, at):
            return at, count, lines, fault
        if count < len(row) and fill:
            value, at, problem = _number(data, at)
            if problem:
                fault = problem if fault == 0 or problem == Fault.NO_NUMBER.value else fault
            row[count] = value
        else:
            at = past_value(data, at)
        count += 1


@njit(cache=True)
def read_corner(data, at, sizes, corner):
    """A corner, position/uv/normal: the place behind it and a `Fault` or 0. Negative indices count from ``sizes``."""
    corner[:] = -1
    for column in range(3):
        value, after = _index(data, at)
        if after == at and column == 0:
            return at, Fault.NO_INDEX.value
        if after > at and value != 0:
            corner[column] = value - 1 if value > 0 else sizes[column] + value
            if corner[column] < 0:
                return at, Fault.BEFORE_FIRST.value
        elif after > at and column == 0:
            return at, Fault.ZERO_INDEX.value
        at = after
        if at < len(data) and data[at] == _SLASH:
            at += 1
        else:
            break
    if past_value(data, at) == at:
        return at, 0
    return at, Fault.NO_INDEX.value


@njit(cache=True)
def statement_end(data, at):
    """The place of the line end behind ``at``, the line ends passed, and the place behind the last letter."""
    lines, last = 0, at
    while at < len(data) and not line_break(data, at):
        if data[at] == _BACKSLASH and line_break(data, at + 1):
            at += 1 + line_break(data, at + 1)
            lines += 1
        else:
            last = last if _is_blank(data[at]) else at + 1
            at += 1
    return at, lines, last
