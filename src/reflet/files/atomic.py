"""Files that appear whole or not at all."""

import atexit
import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from reflet.errors import RefletError

REASONS = {
    errno.ENOSPC: "the disk is full; free some space or choose another folder",
    errno.EDQUOT: "the disk quota is used up; free some space or choose another folder",
    errno.EFBIG: "the system limits how large a file may grow; raise that limit or choose another folder",
    errno.EROFS: "the file system is read-only; choose another folder",
    errno.EACCES: "the folder may not be written to; choose another folder or change its permissions",
    errno.EPERM: "the folder may not be written to; choose another folder or change its permissions",
    errno.ENOTDIR: "a file stands where the folder should be; choose another folder",
    errno.EEXIST: "a file stands where the folder should be; choose another folder",
    errno.EISDIR: "a folder of that name exists; choose another name",
}


def _refusal(path: Path, error: OSError) -> RefletError:
    reason = REASONS.get(error.errno or 0, error.strerror or str(error))
    return RefletError(f"{path} cannot be written: {reason}.")


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path in the folder of ``path``, which becomes ``path`` when the block ends without an error.

    Missing folders are made. The temporary file has the same suffix, for writers that go by it, and begins with a dot.
    Its contents reach the disk before it is renamed, so a crash leaves either the old file or the new one. If the block
    raises, the temporary file is removed; an `OSError` becomes a RefletError that names ``path`` and the reason, and a
    RefletError that names the temporary file names ``path`` instead.
    """
    final = Path(path)
    temporary = final.parent / f".{final.stem[:40]}.{secrets.token_hex(4)}.tmp{final.suffix}"
    # Ctrl-C raises between any two instructions, here as well: the name is noted before the file is made.
    _unfinished.add(temporary)
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        _sync(temporary)
        temporary.replace(final)
        _sync(final.parent)
    except OSError as error:
        raise _refusal(final, error) from error
    except RefletError as error:
        raise RefletError(str(error).replace(str(temporary), str(final))) from error
    finally:
        _remove(temporary)


_unfinished: set[Path] = set()


def _remove(temporary: Path) -> None:
    with suppress(OSError):
        temporary.unlink(missing_ok=True)
    _unfinished.discard(temporary)


@atexit.register
def remove_unfinished() -> None:
    """Removes the temporary files whose own removal was interrupted; the process does so when it ends."""
    for temporary in tuple(_unfinished):
        _remove(temporary)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raises RefletError as `atomic_path` does where ``path`` could not be written: before hours of work, not after."""
    with suppress(_UnwrittenError), atomic_path(path):
        raise _UnwrittenError


class _UnwrittenError(Exception):
    """Leaves the block of `atomic_path` with nothing written."""


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def atomic_write(path: str | os.PathLike[str], data: bytes | memoryview) -> None:
    """Writes ``data`` as the file ``path``, whole or not at all. Raises RefletError as `atomic_path` does."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(data)
