"""Damage to valid files, the same on every run."""

from collections.abc import Iterator

import numpy as np

NUMBERS = (0, 1, 2, 7, 127, 32768, 1 << 16, 1 << 20, (1 << 28) + 1, (1 << 31) - 1, 1 << 31, (1 << 32) - 1)
"""What is put in a header for its own numbers."""


def damaged(data: bytes, header: int, rng: np.random.Generator, count: int = 100) -> Iterator[bytes]:
    """Truncations everywhere in the first ``header`` bytes and here and there after them, flipped bits there and
    anywhere, bytes put in, taken out, swapped and made up; about 8·``count`` files."""
    yield from (data[: int(kept)] for kept in np.linspace(0, header, min(header, count), endpoint=False))
    yield from (data[: int(kept)] for kept in rng.integers(header, len(data), count))
    yield data[:-1]
    for end in (header, len(data)):
        for _ in range(count):
            changed = np.frombuffer(data, np.uint8).copy()
            at = rng.integers(0, end, rng.integers(1, 5))
            changed[at] ^= (1 << rng.integers(0, 8, len(at))).astype(np.uint8)
            yield changed.tobytes()
    for _ in range(count):
        at, length = int(rng.integers(0, len(data))), int(rng.integers(1, 40))
        yield data[:at] + rng.bytes(length) + data[at:]
        yield data[:at] + data[at + length :]
        yield data[:at] + rng.bytes(length) + data[at + length :]
        yield data[:header] + rng.bytes(int(rng.integers(0, 2 * len(data))))
    yield data + bytes(1000)


def with_text_numbers(data: bytes, header: int) -> Iterator[bytes]:
    """Every run of digits in the header replaced by each of `NUMBERS`, and by others that no number is."""
    import re

    for found in re.finditer(rb"\d+", data[:header]):
        for number in (*(b"%d" % n for n in NUMBERS), b"", b"-3", b"1e9", b"9" * 300, b"nan"):
            yield data[: found.start()] + number + data[found.end() :]


def with_binary_numbers(data: bytes, header: int) -> Iterator[bytes]:
    """Every four bytes of the header, at any offset, replaced by each of `NUMBERS`, little-endian."""
    for at in range(header - 3):
        for number in NUMBERS:
            yield data[:at] + number.to_bytes(4, "little") + data[at + 4 :]
