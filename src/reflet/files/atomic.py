"""Files that appear whole or not at all."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from reflet.errors import RefletError

_REASONS = {
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
    reason = _REASONS.get(error.errno or 0, error.strerror or str(error))
    return RefletError(f"{path} cannot be written: {reason}.")


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path in the folder of ``path``, which becomes ``path`` when the block ends without an error.

    Missing folders are made. The temporary file has the same suffix, for writers that go by it, and begins with a dot.
    Its contents reach the disk before it is renamed, so a crash leaves either the old file or the new one. If the block
    raises, the temporary file is removed; an `OSError` becomes a RefletError that names ``path`` and the reason.
    """
    final = Path(path)
    temporary: Path | None = None
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{final.stem[:40]}.", suffix=".tmp" + final.suffix, dir=final.parent)
        temporary = Path(name)
        os.close(handle)
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)  # mkstemp made it readable for its owner only; a web server must read it too
        _sync(temporary)
        temporary.replace(final)
        temporary = None
        _sync(final.parent)
    except OSError as error:
        raise _refusal(final, error) from error
    finally:
        if temporary is not None:
            with suppress(OSError):
                temporary.unlink()


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
