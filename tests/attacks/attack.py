"""Helpers for attacks: run hostile code in the sandbox and read its report.

The hostile code really runs, and its function reports what it achieved. The tests read this report
and also check for effects on the grader.
"""

import os
import textwrap
import time

import numpy as np
import pytest

from grader.sandbox import SANDBOXES, Limits
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import INSTALLED_PACKAGES, Program
from grader.sandbox.student import StudentProxy
from tests.prerequisites import PATIENCE

SANDBOX = SANDBOXES[os.environ.get("ATTACKED", "bubblewrap")]
MEBIBYTE = 2**20
SHORT = {"start_seconds": 8.0, "call_seconds": 1.0, "total_seconds": 20.0, "restarts": 0}
CLOUD = np.arange(12.0).reshape(3, 4)
SEED = 20_170_405

needs_namespaces = pytest.mark.skipif(
    SANDBOX.name != "bubblewrap", reason="bubblewrap; run without the variable ATTACKED"
)


def with_attacks(names, attacks):
    """Parametrize a test; `attacks` maps the description of each attack to its arguments."""
    attacks = {
        description: values if isinstance(values, tuple) else (values,)
        for description, values in attacks.items()
    }
    return pytest.mark.parametrize(
        names, [pytest.param(*values, id=description) for description, values in attacks.items()]
    )


def function(body, name="f", parameters="*arguments"):
    """Return the source code of a function with the given body."""
    return f"def {name}({parameters}):\n" + textwrap.indent(body.strip("\n"), "    ") + "\n"


def attack(source, forbidden=(), packages=INSTALLED_PACKAGES, modules=None, **limits):
    """Return a proxy for a student whose notebook has one cell, which defines `f`."""
    program = Program(
        (source,), ("f",), modules=modules or {}, forbidden=tuple(forbidden), packages=packages
    )
    return StudentProxy(program, SANDBOX, Limits(**{**SHORT, **limits}))


def outcome_of(source, *arguments, **options):
    """Call `f` in the sandbox and return its answer as the judge receives it."""
    with attack(source, **options) as student:
        return student.f(*arguments)


def stopped_by(source, *arguments, calls=3, **limits):
    """Call `f` until the sandbox stops it; return the sandbox's message, or fail."""
    start = time.monotonic()
    with attack(source, **limits) as student, pytest.raises(StudentStopped) as stopped:
        for _ in range(calls):
            student.f(*arguments)
    assert time.monotonic() - start < PATIENCE
    return str(stopped.value)


# Code that holds memory, in its own process or in child processes.
HOLD_MEMORY = """
import ctypes, mmap, os, threading, time
def hold(megabytes):
    block = mmap.mmap(-1, megabytes * 2**20)
    for page in range(0, len(block), 4096):
        block[page] = 1
    return block
def children(number, megabytes, then=lambda block: time.sleep(60)):
    for _ in range(number):
        if os.fork() == 0:
            then(hold(megabytes))
            os._exit(0)
"""
