"""What is said of files that the system does not let one read."""

import errno
import os

from reflet.errors import RefletError

_REASONS = {
    errno.ENOENT: "does not exist; check the name",
    errno.ENOTDIR: "does not exist: a file stands where a folder is named; check the name",
    errno.ENAMETOOLONG: "has a name longer than the system takes; check the name",
    errno.EISDIR: "is a folder; name a file in it",
    errno.EACCES: "may not be read; change its permissions or copy it elsewhere",
    errno.EPERM: "may not be read; change its permissions or copy it elsewhere",
    errno.EIO: "cannot be read from its disk; copy it again",
}


def unreadable(path: str | os.PathLike[str], error: OSError) -> RefletError:
    """The sentence for a file or folder that could not be opened or read."""
    reason = _REASONS.get(error.errno or 0)
    return RefletError(f"{path} {reason}." if reason else f"{path} cannot be read ({error.strerror or error}).")


def check_is_file(path: str | os.PathLike[str]) -> None:
    """Raises RefletError where ``path`` is no file that may be read, for libraries that do not say why they fail."""
    try:
        with open(path, "rb"):
            pass
    except OSError as error:
        raise unreadable(path, error) from error
