"""The one exception for anything a user can put right."""


class RefletError(Exception):
    """Bad input, said in one sentence: what was expected, what came, what to try.

    The command line prints it without a traceback and ends with exit status 2. It may be raised in any room.
    """
