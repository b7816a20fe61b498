"""What a course adds to the grader in ``extension/registry.py``, if it has that file."""

import importlib
from collections.abc import Collection

from grader.course.paths import PROJECT


def course_constant(name: str) -> Collection:
    """Return a constant of the course's own module, or an empty tuple.

    Parameters
    ----------
    name : str
        ``COMMANDS``: functions that add a command to ``python -m grader``. ``REPORT_LINKS``:
        functions that return (address, link text) of pages for the report on a `Course`.
        ``OPTIONAL_PACKAGES``: (folder, text) of each package that a standalone notebook has only
        if its code contains the text.
    """
    if not (PROJECT / "extension" / "registry.py").exists():
        return ()
    return getattr(importlib.import_module("extension.registry"), name, ())
