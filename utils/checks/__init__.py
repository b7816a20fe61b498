"""Checks that a student sees: ``check(my_function)`` in a notebook.

The same checks run unchanged in the judge, where the function is a proxy into the sandbox.
"""

from utils.checks.assertions import CheckFailed
from utils.checks.core import check, checks_of
from utils.checks.outcomes import Check

__all__ = ["Check", "CheckFailed", "check", "checks_of"]
