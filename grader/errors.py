"""The base class of errors that the command line shows without a traceback."""


class UserError(Exception):
    """A problem that the user can solve, in any command; `str()` is the sentence to show."""
