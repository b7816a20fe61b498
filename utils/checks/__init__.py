"""The visible checks, which a student runs in a notebook with ``check(my_function)``.

The judge runs the same checks, unchanged, on a proxy for the function in the sandbox.
"""

from utils.checks.assertions import CheckFailed
from utils.checks.core import check, checks_of
from utils.checks.outcomes import Check

__all__ = ["Check", "CheckFailed", "check", "checks_of"]
