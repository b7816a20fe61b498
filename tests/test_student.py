"""Objects of a student's class answer from inside as they would outside."""

import numpy as np
import pytest

from grader.sandbox import Limits
from grader.sandbox.program import Program
from grader.sandbox.student import Student, StudentError, StudentStopped

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
    with Student(Program((TREE,), ("KdTree",)), sandbox, Limits(call_seconds=5)) as proxy:
        yield proxy


def test_attributes_and_methods_answer(student):
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


def test_two_objects_are_two(student):
    first, second = student.KdTree(), student.KdTree()
    first.insert([0, 0], 1)
    assert (first.count, second.count) == (1, 0)


def test_errors_name_the_method(student):
    tree = student.KdTree()
    with pytest.raises(StudentError, match="search raised ValueError: negative tolerance"):
        tree.search([0, 0], -1.0)
    with pytest.raises(StudentError, match="no attribute 'balance'"):
        tree.balance()


def test_an_object_is_gone_with_its_process(student):
    tree = student.KdTree()
    with pytest.raises(StudentStopped, match="os._exit"):
        tree.die()
    with pytest.raises(StudentStopped, match="is gone"):
        tree.search([0, 0], 1.0)
    assert student.KdTree().root is None


def test_a_thousand_calls_are_quick(student):
    tree = student.KdTree()
    for number in range(1000):
        tree.insert([number, 0.0], number)
    assert tree.count == 1000


def test_whatever_numpy_reads_as_a_list_crosses_as_a_list(sandbox):
    source = (
        "from collections import deque\nimport array\n"
        "def f(kind): return {'range': range(3), 'deque': deque([0, 1, 2]),"
        " 'array': array.array('d', [0, 1, 2])}[kind]"
    )
    with Student(Program((source,), ("f",)), sandbox) as proxy:
        for kind in ("range", "deque", "array"):
            assert list(proxy.f(kind)) == [0, 1, 2]
