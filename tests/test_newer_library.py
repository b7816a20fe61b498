"""Names that only a newer standard library has are distinguished from names that do not exist."""

import ast
import importlib
import sys

import pytest

from grader.sandbox.inside import newer_library
from grader.sandbox.inside.newer_library import ADDED_IN, newer_names

USES = {
    "import itertools\nitertools.batched(a, 2)": "itertools.batched",
    "import itertools as it\ndef f(a):\n    return list(it.batched(a, 2))": "itertools.batched",
    "from itertools import chain, batched as pairs": "itertools.batched",
    "def f(a):\n    from math import sumprod\n    return sumprod(a, a)": "math.sumprod",
    "import collections.abc\ndef f(a: collections.abc.Buffer): pass": "collections.abc.Buffer",
    "from collections.abc import Buffer": "collections.abc.Buffer",
    "import collections.abc as c\nc.Buffer": "collections.abc.Buffer",
    "import typing\nclass A:\n    @typing.override\n    def f(self): pass": "typing.override",
    "import compression.zstd": "compression",
    "import compression.zstd as z\nz.compress(a)": "compression",
    "from compression import zstd": "compression",
    "from string.templatelib import Template": "string.templatelib",
    "from concurrent import interpreters": "concurrent.interpreters",
    "import heapq\ntry:\n    heapq.heappush_max(a, 1)\nfinally:\n    pass": "heapq.heappush_max",
}
UNCERTAIN_USES = [
    "import itertools\nitertools.chain(a)",
    "from .itertools import batched",
    "itertools.batched(a, 2)",
    "import tools as itertools\nitertools.batched(a, 2)",
    "x = a.batched(3)",
    "try:\n    from itertools import batched\nexcept ImportError:\n    batched = None",
    "import math\nif hasattr(math, 'sumprod'):\n    math.sumprod(a, a)",
    "import math, sys\nif sys.version_info >= (3, 12):\n    math.sumprod(a, a)",
    "import math\ntry:\n    math.sumprod(a, a)\nexcept AttributeError:\n    pass",
]


@pytest.fixture(autouse=True)
def oldest_python(monkeypatch):
    """Let the module treat all newer names as absent, whichever Python runs the tests."""
    monkeypatch.setattr(newer_library, "RUNNING_VERSION", (3, 11))


def reasons(source, *more):
    return {reason for _, reason in newer_names(ast.parse(source).body, *more)}


@pytest.mark.parametrize("name", ADDED_IN)
def test_a_listed_name_exists_exactly_from_its_version_on(name):
    module, _, member = name.rpartition(".")
    try:
        found = hasattr(importlib.import_module(module), member) if module else False
    except ImportError:
        found = False
    if not found:
        try:
            importlib.import_module(name)
            found = True
        except ImportError:
            found = False
    assert found == (sys.version_info[:2] >= ADDED_IN[name])


@pytest.mark.parametrize("source, name", USES.items())
def test_a_newer_name_is_found_however_it_is_imported(source, name):
    version = ".".join(map(str, ADDED_IN[name]))
    assert reasons(source) == {f"uses {name}, which needs Python {version} or later"}


@pytest.mark.parametrize("source", UNCERTAIN_USES)
def test_code_that_may_work_without_the_name_is_not_reported(source):
    assert reasons(source) == set()


def test_the_version_that_ran_the_code_decides():
    source = "from math import fma"
    assert reasons(source, (3, 12)) == set(), "it failed there as well"
    assert reasons(source, (3, 13)) == reasons(source)


def test_a_students_module_may_have_any_name():
    assert reasons("from compression import zip", (), {"compression"}) == set()


def test_the_place_of_the_statement_is_reported():
    nodes = ast.parse("import math\nx = 1\ny = math.fma(1, 2, 3)").body
    assert [place for place, _ in newer_names(nodes)] == [2]
