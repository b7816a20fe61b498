"""Exit statuses, and the base class of errors that the command line shows without a traceback."""

SUCCESS, FAULT, USAGE_ERROR = 0, 1, 2


class UserError(Exception):
    """A problem that the user can solve, in any command; `str()` is the sentence to show.

    Attributes
    ----------
    exit_status : int
        Exit status of the command.
    is_multiline : bool
        Whether the message may have several lines. Otherwise, a line break can only come from a
        name, and is replaced.
    """

    exit_status = USAGE_ERROR
    is_multiline = False
