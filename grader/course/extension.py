"""Additions of a course to the grader, from the optional file ``extension/registry.py``."""

import importlib
from collections.abc import Collection

from grader.course.paths import PROJECT


def course_constant(name: str) -> Collection:
    """Return a constant of the course's own module, or an empty tuple.

    Parameters
    ----------
    name : str
        ``COMMANDS``: functions that add a command to ``python -m grader``. ``REPORT_LINKS``:
        functions that return pairs (address, link text) of pages for the report on a `Course`.
        ``OPTIONAL_PACKAGES``: pairs (folder, text). A standalone notebook contains the package in
        the folder only if its code contains the text.
    """
    if not (PROJECT / "extension" / "registry.py").exists():
        return ()
    return getattr(importlib.import_module("extension.registry"), name, ())
