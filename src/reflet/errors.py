"""The one exception for anything a user can put right."""


class RefletError(Exception):
    """Bad input, said in one sentence: what was expected, what came, what to try.

    The command line prints it without a traceback and ends with exit status 2. It may be raised in any room.
    """


class RefletWarning(UserWarning):
    """Something was put right on the user's behalf, or will look other than asked; one sentence says what."""
