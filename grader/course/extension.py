"""Additions of a course to the grader, in the optional file ``extension/registry.py``."""

import importlib
from collections.abc import Collection

from grader.course.paths import PROJECT


def extension_constant(name: str) -> Collection:
    """Return a constant of ``extension/registry.py``, or an empty tuple if it is not defined.

    Parameters
    ----------
    name : str
        ``COMMANDS``: functions that add a command to ``python -m grader``. ``REPORT_LINKS``:
        functions that take a `Course` and return the links in its report, as pairs (address,
        text). ``OPTIONAL_PACKAGES``: pairs (path, text). A standalone notebook contains the
        folder or file at the path only if the notebook contains the text.
    """
    if not (PROJECT / "extension" / "registry.py").exists():
        return ()
    return getattr(importlib.import_module("extension.registry"), name, ())
