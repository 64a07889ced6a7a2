"""What the command ``reflet`` runs: `reflet.cli.main` in a process of its own.

Most of the standard library, too, is imported where Ctrl-C is heard.
"""

import os
import signal
import sys

from reflet.cli.interruption import hear_again, interrupted


def main() -> None:
    """Runs one command and ends the process with `reflet.cli.main`'s statuses. Ctrl-C never ends in a traceback."""
    try:
        sys.unraisablehook = hear_again
        _keep_compiled_functions()
        from reflet.cli.main import main as run

        run()
    except (Exception, KeyboardInterrupt) as error:  # while modules are loaded
        if not interrupted(error):
            raise
        print("Stopped.", file=sys.stderr)
        sys.exit(130)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is said and done; what is left takes no time


def _keep_compiled_functions() -> None:
    """numba keeps them beside their sources or in the home folder, and gives up where neither may be written. Then they
    last as long as this command."""
    import atexit
    from pathlib import Path
    from tempfile import TemporaryDirectory

    places = (Path(__file__).parents[1], Path(os.environ.get("XDG_CACHE_HOME") or "~").expanduser())
    if "NUMBA_CACHE_DIR" not in os.environ and not any(os.access(place, os.W_OK) for place in places):
        folder = TemporaryDirectory(prefix="reflet-compiled-")
        atexit.register(folder.cleanup)
        os.environ["NUMBA_CACHE_DIR"] = folder.name
