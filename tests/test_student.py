"""Calls into the sandbox: a student's objects, the places of exceptions, and interrupts."""

import numpy as np
import pytest

from grader.sandbox import Limits
from grader.sandbox.error_descriptions import describe_error
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.student import CALL_TIMEOUT, StudentProxy
from utils.checks.assertions import call_each, get_attribute_path

TREE = """
import numpy as np

class Node:
    def __init__(self, point, index):
        self.point, self.index, self.left, self.right = point, index, None, None

class KdTree:
    def __init__(self):
        self.root, self.count = None, 0

    def insert(self, point, index):
        node = Node(np.asarray(point), index)
        node.left, self.root = self.root, node
        self.count += 1

    def search(self, target, tolerance):
        if tolerance < 0:
            raise ValueError("negative tolerance")
        return [self.root.index] if self.root else []

    def die(self):
        import os
        os._exit(3)
"""


@pytest.fixture
def student(sandbox):
    with StudentProxy(Program((TREE,), ("KdTree",)), sandbox, Limits(call_seconds=5)) as proxy:
        yield proxy


def test_attributes_and_methods_of_a_remote_object_can_be_used(student):
    tree = student.KdTree()
    assert tree.root is None
    assert tree.search([0, 0], 1.0) == []
    tree.insert(np.array([1.0, 2.0]), 7)
    tree.insert(np.array([3.0, 4.0]), 8)
    assert tree.count == 2
    assert tree.search(target=[0, 0], tolerance=1.0) == [8]
    assert tree.root.point.tolist() == [3.0, 4.0]
    assert tree.root.left.index == 7
    assert tree.root.left.left is None


def test_remote_objects_are_distinct(student):
    first, second = student.KdTree(), student.KdTree()
    first.insert([0, 0], 1)
    assert (first.count, second.count) == (1, 0)


def test_errors_name_the_method(student):
    tree = student.KdTree()
    with pytest.raises(StudentError, match="search raised ValueError: negative tolerance"):
        tree.search([0, 0], -1.0)
    with pytest.raises(StudentError, match="no attribute 'balance'"):
        tree.balance()


def test_an_object_is_lost_with_its_process(student):
    tree = student.KdTree()
    with pytest.raises(StudentStopped, match="os._exit"):
        tree.die()
    with pytest.raises(StudentStopped, match="its objects are lost"):
        tree.search([0, 0], 1.0)
    assert student.KdTree().root is None


def test_a_thousand_calls_are_quick(student):
    tree = student.KdTree()
    for number in range(1000):
        tree.insert([number, 0.0], number)
    assert tree.count == 1000


def test_sequences_are_transferred_as_lists(sandbox):
    source = (
        "from collections import deque\nimport array\n"
        "def f(kind): return {'range': range(3), 'deque': deque([0, 1, 2]),"
        " 'array': array.array('d', [0, 1, 2])}[kind]"
    )
    with StudentProxy(Program((source,), ("f",)), sandbox) as proxy:
        for kind in ("range", "deque", "array"):
            assert list(proxy.f(kind)) == [0, 1, 2]


def test_walking_a_tree_takes_few_requests(student):
    tree = student.KdTree()
    for number in range(30):
        tree.insert([number, 0.0], number)
    calls_before, seen, node = student._calls, [], tree.root
    while node is not None:
        seen.append((node.index, node.point.tolist(), node.right))
        node = node.left
    assert seen == [(number, [number, 0.0], None) for number in reversed(range(30))]
    assert student._calls - calls_before <= len(seen) // 5


def test_many_calls_are_one_request_that_ends_at_the_first_failure(student):
    tree, points = student.KdTree(), np.arange(8.0).reshape(4, 2)
    calls_before = student._calls
    call_each(tree.insert, [(point, row) for row, point in enumerate(points)])
    assert student._calls == calls_before + 1
    assert (tree.count, tree.root.index) == (4, 3)
    assert tree.root.left.point.tolist() == [4.0, 5.0]
    with pytest.raises(StudentError, match="missing 1 required positional argument"):
        call_each(tree.insert, [(points[0], 4), (points[1],), (points[2], 6)])
    assert tree.count == 5


def test_methods_of_a_new_object_are_known_and_looked_up_when_called(student):
    tree = student.KdTree()
    calls_before = student._calls
    search, _, root = tree.search, tree.insert, tree.root
    assert (student._calls, root) == (calls_before, None)
    assert search([0, 0], 1.0) == []
    assert student._calls == calls_before + 1


def test_a_path_of_attributes_is_one_request(student):
    tree = student.KdTree()
    call_each(tree.insert, [([row, 0.0], row) for row in range(300)])
    calls_before = student._calls
    assert get_attribute_path(tree, ["root", *["left"] * 299]).index == 0
    assert get_attribute_path(tree, ["root", *["left"] * 300]) is None
    with pytest.raises(StudentError, match="AttributeError"):
        get_attribute_path(tree, ["root", *["left"] * 301])
    assert student._calls <= calls_before + 4


def test_calls_and_attribute_paths_work_on_local_objects():
    class Local:
        def __init__(self):
            self.seen = []

        def note(self, point, index):
            self.seen.append((point, index))
            point[0] = 9

    points, local = np.zeros((2, 2)), Local()
    call_each(local.note, zip(points, [3, 4], strict=True))
    assert [index for _, index in local.seen] == [3, 4] and not points.any()
    assert get_attribute_path(local, ["note", "__func__", "__name__"]) == "note"


def test_a_cycle_of_objects_can_be_walked_without_end(sandbox):
    source = """class Ring:
    def __init__(self): self.next, self.name = self, 1"""
    with StudentProxy(Program((source,), ("Ring",)), sandbox) as proxy:
        ring = proxy.Ring()
        for _ in range(50):
            ring = ring.next
            assert ring.name == 1


def test_attributes_are_read_again_after_a_call(student):
    tree = student.KdTree()
    assert (tree.root, tree.count) == (None, 0)
    tree.insert([0.0, 0.0], 3)
    assert (tree.root.index, tree.count) == (3, 1)


ODD = """
import numpy as np

class Hidden:
    __dict__ = property(lambda self: 7)

class OwnSize:
    def __len__(self): return 1 / 0
    def __array__(self): return 1 / 0

class Odd:
    class_wide = 5
    def __init__(self, kind):
        self.first = 1
        if kind == "many": self.__dict__.update({f"a{n}": n for n in range(99)})
        if kind == "large": self.large = np.zeros(10**6)
        if kind == "own size": self.own = OwnSize()
        if kind == "no text": self.__dict__[3] = 4
        if kind == "no dictionary": self.__class__ = type("Other", (Hidden, Odd), {})
        if kind == "lists": self.list = [object()] * 3
    @property
    def computed(self): return self.first + 1
"""


@pytest.mark.parametrize(
    "kind", ["plain", "many", "large", "own size", "no text", "no dictionary", "lists"]
)
def test_unusual_attributes_next_to_a_requested_one_are_harmless(sandbox, kind):
    with StudentProxy(Program((ODD,), ("Odd",)), sandbox) as proxy:
        odd = proxy.Odd(kind)
        assert (odd.first, odd.computed, odd.class_wide, odd.first) == (1, 2, 5, 1)


FINISHED = """
def finished(line):
    a, b = line
    return a + b
"""
CALLS_IT = """
def helper(number):
    return finished(number)

def answer(number):
    total = 1
    return total + helper(number)
"""


def test_an_exception_is_placed_at_the_call_in_the_exercise(sandbox):
    """An exception in another exercise's function is reported at the call in this exercise."""
    program = Program((FINISHED, CALLS_IT), ("finished", "answer"))
    with StudentProxy(program, sandbox, Limits(call_seconds=5)) as student:
        student.exercise = "answer"
        with pytest.raises(StudentError) as caught:
            student.answer(7)
        error = caught.value
        assert (error.place, error.line) == ("code cell 1, line 3", "a, b = line")
        assert error.call_place == "code cell 2, line 3"
        assert describe_error(error) == (
            "answer raised TypeError (code cell 2, line 3: `return finished(number)`, which calls "
            "code cell 1, line 3: `a, b = line`)."
        )
        # The message about a hidden test contains only the place of the call, not the code.
        assert error.safe_sentence == "answer raised TypeError (code cell 2, line 3)."
        student.exercise = "finished"
        with pytest.raises(StudentError) as caught:
            student.finished(7)
        assert caught.value.call_place is None and caught.value.shown_place == "code cell 1, line 3"


@pytest.mark.parametrize("lines", [3, 70])
def test_a_long_exercise_does_not_reveal_the_calling_line(sandbox, lines):
    padded = CALLS_IT.replace("    total = 1\n", "    total = 1\n" * lines)
    program = Program((FINISHED, padded), ("finished", "answer"))
    with StudentProxy(program, sandbox, Limits(call_seconds=5)) as student:
        student.exercise = "answer"
        with pytest.raises(StudentError) as caught:
            student.answer(7)
    assert (caught.value.call_place is None) == (lines > 60)
    assert (caught.value.shown_place is None) == (lines > 60)


LOOPS = """
def works(cloud):
    while True:
        pass

def sleeps(cloud):
    import time
    while True:
        time.sleep(1)

def holds_on(cloud):
    while True:
        try:
            cloud += 1
        except BaseException:
            pass

def answers(cloud):
    return id(works)
"""


def test_an_interrupted_function_can_be_called_again(sandbox):
    program = Program((LOOPS,), ("works", "sleeps", "holds_on", "answers"))
    with StudentProxy(program, sandbox, Limits(call_seconds=1)) as student:
        student.interrupts_after = 0.05
        process = student.answers(1)
        for _ in range(3):
            with pytest.raises(StudentError) as caught:
                student.works(1)
            assert caught.value.type_name == CALL_TIMEOUT
        assert student.answers(1) == process
        with pytest.raises((StudentError, StudentStopped)):
            student.holds_on(1)
        with pytest.raises(StudentStopped):
            student.sleeps(1)
        student.interrupts_after = None
        with pytest.raises(StudentStopped):
            student.works(1)


@pytest.mark.parametrize("edited", ["f", ""])
def test_the_imports_of_a_function_do_not_count_as_a_call_of_its_edits(sandbox, edited):
    """With an edit, a call has so little time that an import would be interrupted."""
    source = """
import sys
def f():
    is_imported = "colorsys" in sys.modules
    from colorsys import rgb_to_hsv
    return is_imported
"""
    program = Program((source,), ("f",))
    with StudentProxy(program, sandbox, edited=edited) as student:
        assert student.f() is bool(edited)


def test_a_notebook_that_is_too_large_to_send_is_not_accused(sandbox):
    program = Program(("x = 1",), ("f",), {"big": "7" * 2**24})
    words = "larger than the judge can send to the sandbox"
    with StudentProxy(program, sandbox) as student, pytest.raises(StudentStopped, match=words):
        student.f()
