"""What the command ``reflet`` runs: `reflet.cli.main` in a process of its own."""

import os
import signal
import sys
import threading
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory


def main() -> None:
    """Runs one command and ends the process with `reflet.cli.main`'s statuses. Ctrl-C never ends in a traceback."""
    sys.unraisablehook = _hear_again
    try:
        with _place_for_compiled_functions():
            from reflet.cli.main import main as run

            run()
    except KeyboardInterrupt:  # while modules are loaded
        print("Stopped.", file=sys.stderr)
        sys.exit(130)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is said and done; what is left takes no time


def _hear_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Ctrl-C again, soon, where nobody could catch the first.

    Python raises KeyboardInterrupt between any two instructions: also in a destructor, or in what LLVM calls back when
    it has compiled a function. From there no exception gets out, and the work would go on as if nothing had been said.
    """
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        # to the main thread itself, so that it wakes from waiting
        again = threading.Timer(0.05, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT))
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(unraisable)


@contextmanager
def _place_for_compiled_functions():  # type: ignore[no-untyped-def]
    """numba keeps them beside their sources or in the home folder, and gives up where neither may be written: then they
    last as long as this command."""
    places = (Path(__file__).parents[1], Path(os.environ.get("XDG_CACHE_HOME") or "~").expanduser())
    if "NUMBA_CACHE_DIR" in os.environ or any(os.access(place, os.W_OK) for place in places):
        yield
    else:
        with TemporaryDirectory(prefix="reflet-compiled-") as folder:
            os.environ["NUMBA_CACHE_DIR"] = folder
            yield
