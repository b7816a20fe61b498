"""Slips that are visible in the source of a function, whatever the function should do."""

import linecache

import numpy as np
import pytest

from utils.checks import check
from utils.checks.code_slips import find_code_slip
from utils.checks.core import ChecksFailed

PRINTS = """
def near(cloud):
    print(cloud[:2])
"""
IN_A_LOOP = """
def near(cloud):
    found = []
    for row in cloud:
        found.append(row)
        return found
"""
AFTER_CONTINUE = """
def near(cloud):
    found = []
    for row in cloud:
        if row[0] > 3:
            continue
        found.append(row)
        return found
"""
KEEPS_VALUES = """
def near(cloud, found=[]):
    found.append(cloud[0])
    return found
"""
READS_ANOTHER = """
def near(cloud):
    return obstacles[:2]
"""
CODE_WITHOUT_SLIPS = {
    "prints and returns": "def near(cloud):\n    print(1)\n    return cloud\n",
    "generates": "def near(cloud):\n    print(1)\n    yield cloud\n",
    "returns from an endless loop": "def near(cloud):\n    while True:\n        return cloud\n",
    "continues": "def near(cloud):\n    for row in cloud:\n        if row[0]:\n"
    "            continue\n"
    "        return row\n",
    "returns after finding something": "def near(cloud):\n    for row in cloud:\n"
    "        if row[0]:\n            return row\n",
    "reads a default list": "def near(cloud, axes=[0, 1]):\n    return cloud[:, axes]\n",
    "a constant next to the parameter": "def near(cloud):\n    return cloud + obstacles\n",
    "a helper of the notebook": "def near(cloud):\n    return helper()\n",
    "an inner function returns in its loop": "def near(cloud):\n    print(cloud)\n"
    "    return [row for row in cloud]\n",
}


def define(source, name="near", **names):
    """Define a function as in a notebook cell, so that its source can be read."""
    file = f"<cell {abs(hash(source))}>"
    linecache.cache[file] = (len(source), None, source.splitlines(True), file)
    names = {"np": np, "obstacles": np.ones((3, 4)), "helper": len, **names}
    exec(compile(source, file, "exec"), names)
    return names[name]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (PRINTS, "prints its result and returns nothing"),
        (IN_A_LOOP, "`return` is inside a loop"),
        (AFTER_CONTINUE, "`return` is inside a loop"),
        (KEEPS_VALUES, "The default value of `found` is created only once"),
        (
            READS_ANOTHER,
            "variable `obstacles` but not its parameter `cloud`",
        ),
    ],
)
def test_a_slip_is_found_in_the_source(source, words):
    slip = find_code_slip(define(source), returned_none=True)
    assert words in slip.description and slip.hint


@pytest.mark.parametrize("title", CODE_WITHOUT_SLIPS)
def test_no_slip_is_found_in_harmless_code(title):
    assert find_code_slip(define(CODE_WITHOUT_SLIPS[title]), returned_none=True) is None


def test_a_function_without_source_has_no_slip():
    for function in (len, np.ndarray, eval("lambda cloud: print(cloud)")):
        assert find_code_slip(function, returned_none=True) is None


def test_a_function_without_a_return_value_may_print():
    assert find_code_slip(define(PRINTS), returned_none=False) is None


def test_the_check_shows_the_slip_with_the_first_failure(capsys):
    source = PRINTS.replace("near", "horizontal_distance")
    with pytest.raises(ChecksFailed):
        check(define(source, "horizontal_distance"))
    shown = capsys.readouterr().out
    assert "What your code does: The function prints its result and returns nothing." in shown
    assert shown.count("returns nothing") == 1


SEARCH_PRINTS = """
class KdTree:
    root = None

    def plant(self, points, left, right, indices=None):
        pass

    def insert(self, point, index):
        insert(self, point, index)

    def search(self, target, tolerance):
        return search(self, target, tolerance)


def insert(tree, point, index):
    pass


def search(tree, target, tolerance):
    print([3])
"""


def test_a_slip_is_found_in_a_function_that_a_method_calls(capsys):
    with pytest.raises(ChecksFailed):
        check(define(SEARCH_PRINTS, "KdTree"), "search")
    assert "The function prints its result and returns nothing." in capsys.readouterr().out


def test_a_method_is_checked_through_its_class():
    with pytest.raises(TypeError, match=r'check\(KdTree, exercise="search"\)'):
        check(define(SEARCH_PRINTS, "search"))


def test_an_exception_is_explained_by_the_slip(capsys):
    source = "def horizontal_distance(cloud):\n    return obstacles[:, 9]\n"
    with pytest.raises(ChecksFailed):
        check(define(source, "horizontal_distance"))
    shown = capsys.readouterr().out
    assert "IndexError" in shown and "uses the notebook's variable `obstacles`" in shown
