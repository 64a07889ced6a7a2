"""Ctrl-C, in whatever shape it comes."""

import signal
import sys


def interrupted(error: BaseException | None) -> bool:
    """Whether an error comes of Ctrl-C: libraries that load their own make an ImportError of KeyboardInterrupt."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def hear_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Ctrl-C again, soon, where nobody could catch the first.

    Python raises KeyboardInterrupt between any two instructions: also in a destructor, or in what LLVM calls back when
    it has compiled a function. From there no exception gets out, and the work would go on as if nothing had been said.
    """
    import threading

    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        # to the main thread itself, so that it wakes from waiting
        again = threading.Timer(0.05, signal.pthread_kill, (threading.main_thread().ident, signal.SIGINT))
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(unraisable)
