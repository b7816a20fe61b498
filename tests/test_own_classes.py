"""A student's own class is judged instead of the class that the lesson provides."""

import json

import pytest

from grader.course.kept_answers import ANOTHER_CELL, answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from utils.checks import check
from utils.notebooks import slicing

LESSON = find_lesson("04_kd_tree")
RIGHT = {
    name: next(answer.source for answer in answers_to(name) if answer.right)
    for name in ("insert", "search", "median_order")
}
CLASS_LINE = "class KdTree:"  # a line of the cell with the lesson's classes
NOTHING = "# see the class"

NODE = """
class Node:
    def __init__(self, point, index):
        self.point, self.index, self.left, self.right = point, index, None, None
"""
# Methods that descend the tree in a loop.
INSERT = """
    def insert(self, point, index):
        new = Node(point, index)
        if self.root is None:
            self.root = new
            return
        node, depth = self.root, 0
        while True:
            axis = depth % len(point)
            side = "left" if point[axis] < node.point[axis] else "right"
            if getattr(node, side) is None:
                setattr(node, side, new)
                return
            node, depth = getattr(node, side), depth + 1
"""
SEARCH = """
    def search(self, target, tolerance):
        found, waiting = [], [(self.root, 0)]
        while waiting:
            node, depth = waiting.pop()
            if node is None:
                continue
            if dist(node.point, target) <= tolerance:
                found.append(node.index)
            axis = depth % len(target)
            if target[axis] - tolerance < node.point[axis]:
                waiting.append((node.left, depth + 1))
            if target[axis] + tolerance >= node.point[axis]:
                waiting.append((node.right, depth + 1))
        return found
"""
INIT = "    def __init__(self):\n        self.root = None\n"


def starting_with(action, method):
    """Return the source of a method with `action` as its first line."""
    head, rest = method.strip("\n").split("\n", 1)
    return f"{head}\n        {action}\n{rest}\n"


OWN_CLASSES = {
    "private helpers that call each other": """
class KdTree:
    def __init__(self):
        self.root = None
    def _free_place(self, point):
        parent, side, node, depth = self, "root", self.root, 0
        while node is not None:
            parent, side = node, self._side(node, point, depth)
            node, depth = getattr(node, side), depth + 1
        return parent, side
    def _side(self, node, point, depth):
        axis = depth % len(point)
        return "left" if point[axis] < node.point[axis] else "right"
    def insert(self, point, index):
        parent, side = self._free_place(point)
        setattr(parent, side, Node(point, index))
    def _search(self, node, target, tolerance, depth):
        if node is None:
            return
        if dist(node.point, target) <= tolerance:
            yield node.index
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            yield from self._search(node.left, target, tolerance, depth + 1)
        if target[axis] + tolerance >= node.point[axis]:
            yield from self._search(node.right, target, tolerance, depth + 1)
    def search(self, target, tolerance):
        return list(self._search(self.root, target, tolerance, 0))
""",
    "a size, and nothing to search while it is 0": f"""
class KdTree:
    def __init__(self):
        self.root, self.size = None, 0
    def __len__(self):
        return self.size
{starting_with("self.size += 1", INSERT)}
{starting_with("if len(self) == 0: return []", SEARCH)}
""",
    "nodes that keep their axis": f"""
from dataclasses import dataclass
@dataclass(eq=False)
class Node:
    point: list
    index: int
    axis: int = 0
    left: object = None
    right: object = None
    def side_of(self, point):
        return "left" if point[self.axis] < self.point[self.axis] else "right"
class KdTree:
{INIT}
    def insert(self, point, index):
        parent, side, node, depth = self, "root", self.root, 0
        while node is not None:
            parent, side, depth = node, node.side_of(point), depth + 1
            node = getattr(node, side)
        setattr(parent, side, Node(point, index, depth % len(point)))
    def search(self, target, tolerance):
        found, waiting = [], [self.root]
        while waiting:
            node = waiting.pop()
            if node is None:
                continue
            if dist(node.point, target) <= tolerance:
                found.append(node.index)
            if target[node.axis] - tolerance < node.point[node.axis]:
                waiting.append(node.left)
            if target[node.axis] + tolerance >= node.point[node.axis]:
                waiting.append(node.right)
        return found
""",
    "slots": f"""
class Node:
    __slots__ = ("point", "index", "left", "right")
    def __init__(self, point, index):
        self.point, self.index, self.left, self.right = point, index, None, None
class KdTree:
    __slots__ = ("root",)
{INIT}{INSERT}{SEARCH}
""",
    "a nested class for nodes, which do the work": """
class KdTree:
    class Node:
        def __init__(self, point, index, depth):
            self.point, self.index, self.depth = point, index, depth
            self.left = self.right = None
        @property
        def axis(self):
            return self.depth % len(self.point)
        def is_left(self, point):
            return point[self.axis] < self.point[self.axis]
    def __init__(self):
        self.root = None
    def insert(self, point, index):
        if self.root is None:
            self.root = self.Node(point, index, 0)
            return
        node = self.root
        while True:
            side = "left" if node.is_left(point) else "right"
            if getattr(node, side) is None:
                setattr(node, side, self.Node(point, index, node.depth + 1))
                return
            node = getattr(node, side)
    def search(self, target, tolerance):
        found, waiting = [], [self.root]
        for node in waiting:
            if node is None:
                continue
            if dist(node.point, target) <= tolerance:
                found.append(node.index)
            split = node.point[node.axis]
            if target[node.axis] - tolerance < split:
                waiting.append(node.left)
            if target[node.axis] + tolerance >= split:
                waiting.append(node.right)
        return found
""",
    "an additional base class": f"""
class Tree:
{INIT}
    def is_empty(self):
        return self.root is None
class Searchable(Tree):
{SEARCH}
class KdTree(Searchable):
{INSERT.replace("self.root is None", "self.is_empty()")}
""",
    "static and class methods": f"""
class KdTree:
{INIT}
    @staticmethod
    def axis_at(depth, point):
        return depth % len(point)
    @classmethod
    def side(cls, point, node, depth):
        axis = cls.axis_at(depth, point)
        return "left" if point[axis] < node.point[axis] else "right"
    def insert(self, point, index):
        parent, side, node, depth = self, "root", self.root, 0
        while node is not None:
            parent, side, depth = node, self.side(point, node, depth), depth + 1
            node = getattr(node, side)
        setattr(parent, side, Node(point, index))
{SEARCH.replace("depth % len(target)", "KdTree.axis_at(depth, target)")}
""",
    "a function and a constant next to the class": f"""
SIDES = {{True: "left", False: "right"}}
# ---- another cell ----
def side_of(point, node, depth):
    axis = depth % len(point)
    return SIDES[bool(point[axis] < node.point[axis])]
# ---- another cell ----
class KdTree:
    KIND = "left or right"
{INIT}
    def insert(self, point, index):
        parent, side, node, depth = self, "root", self.root, 0
        while node is not None:
            parent, side, depth = node, side_of(point, node, depth), depth + 1
            node = getattr(node, side)
        setattr(parent, side, Node(point, index))
{SEARCH}
""",
    "data classes with a count and a cached property": f"""
from dataclasses import dataclass, field
from functools import cached_property
@dataclass(slots=False)
class Node:
    point: list
    index: int
    left: "Node | None" = None
    right: "Node | None" = None
    @cached_property
    def place(self):
        return tuple(float(value) for value in self.point)
@dataclass
class KdTree:
    root: Node | None = None
    indices: list[int] = field(default_factory=list)
{starting_with("self.indices.append(index)", INSERT)}
{starting_with("if not self.indices: return []", SEARCH)}
""",
    "properties in front of private attributes": f"""
class Node:
    def __init__(self, point, index):
        self._point, self.index, self._below = point, index, [None, None]
    @property
    def point(self): return self._point
    @point.setter
    def point(self, value): self._point = value
    @property
    def left(self): return self._below[0]
    @left.setter
    def left(self, node): self._below[0] = node
    @property
    def right(self): return self._below[1]
    @right.setter
    def right(self, node): self._below[1] = node
class KdTree:
    def __init__(self): self._root = None
    @property
    def root(self): return self._root
    @root.setter
    def root(self, node): self._root = node
{INSERT}{SEARCH}
""",
    "a subclass of the lesson's class": f"""
class KdTree(KdTree):
    def __init__(self):
        super().__init__()
        self.depths = {{}}
{starting_with("self.depths[index] = 0", INSERT)}
    def axis(self, depth, target):
        return depth % len(target)
{SEARCH.replace("depth % len(target)", "self.axis(depth, target)")}
""",
    "nodes that compare and print": f"""
class Node:
    def __init__(self, point, index, *, depth):
        self.point, self.index, self.depth = tuple(point), index, depth
        self.left = self.right = None
    def __repr__(self):
        return f"Node({{self.point}})"
    def __eq__(self, other):
        return self.point == other.point
    __hash__ = None
class KdTree:
    '''A tree that counts its levels.'''
    def __init__(self):
        self.root, self.levels = None, 0
    def insert(self, point, index):
        parent, side, node, depth = self, "root", self.root, 0
        while node is not None:
            axis = depth % len(point)
            parent, side = node, "left" if point[axis] < node.point[axis] else "right"
            node, depth = getattr(node, side), depth + 1
        setattr(parent, side, Node(point, index, depth=depth))
        self.levels = max(self.levels, depth + 1)
{SEARCH}
""",
    "methods attached later": f"""
class KdTree:
{INIT}
def insert_into(tree, point, index):
    parent, side, node, depth = tree, "root", tree.root, 0
    while node is not None:
        axis = depth % len(point)
        parent, side = node, "left" if point[axis] < node.point[axis] else "right"
        node, depth = getattr(node, side), depth + 1
    setattr(parent, side, Node(point, index))
KdTree.insert = insert_into
KdTree._far = lambda self, node, target, tolerance: dist(node.point, target) > tolerance
def find(self, target, tolerance):
    found, waiting = [], [(self.root, 0)]
    while waiting:
        node, depth = waiting.pop()
        if node is None:
            continue
        if not self._far(node, target, tolerance):
            found.append(node.index)
        axis = depth % len(target)
        if target[axis] - tolerance < node.point[axis]:
            waiting.append((node.left, depth + 1))
        if target[axis] + tolerance >= node.point[axis]:
            waiting.append((node.right, depth + 1))
    return found
setattr(KdTree, "search", find)
""",
}
# Places for the class: the cell of the lesson's class, the first answer's cell, or a new cell.
PLACES = ("instead of the lesson's class", "in the cell of the answer", "in a new cell")


def notebook(own, place, answers=()):
    """Return the text of a notebook for lesson 04 with a class at one of `PLACES`."""
    answers = {"insert": NOTHING, "search": NOTHING} | dict(answers)
    if place == "in a new cell":
        answers = {}
    if place == "in the cell of the answer":
        answers["insert"] = own
    text = json.loads(fill_in(LESSON, {"median_order": RIGHT["median_order"]} | answers))
    if place != "in the cell of the answer":
        index = next(n for n, cell in enumerate(text["cells"]) if CLASS_LINE in source_of(cell))
        cells = own.split(ANOTHER_CELL)
        if "class KdTree(KdTree)" in own:
            cells.insert(0, source_of(text["cells"][index]))
        elif "class Node:" not in own:
            cells.insert(0, NODE)
        code_cell = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
        text["cells"][index : index + 1] = [
            {**code_cell, "id": f"own-{number}", "source": cell}
            for number, cell in enumerate(cells)
        ]
    return json.dumps(text)


def source_of(cell):
    return "".join(cell["source"])


def judge_text(text, sandbox, folder, **more):
    """Judge a notebook given as text; return the results by exercise, and the verdict."""
    path = folder / f"{LESSON.name}.ipynb"
    path.write_text(text, "utf-8")
    verdict = judge(path, 7, sandbox, LESSON, **more)
    return {exercise.name: exercise for exercise in verdict.exercises}, verdict


def load_class(text):
    """Return the class KdTree after running all the definitions in the notebook."""
    cells = [source_of(cell) for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    namespace = {"__name__": "__main__"}
    for statement in slicing.slice_for(["KdTree"], slicing.parse_notebook(cells)[0]):
        exec(slicing.compile_statement(statement, f"code cell {statement.cell}"), namespace)
    return namespace["KdTree"]


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("style", OWN_CLASSES)
def test_right_classes_earn_everything_in_the_judge(style, place, sandbox, tmp_path):
    results, verdict = judge_text(notebook(OWN_CLASSES[style], place), sandbox, tmp_path)
    assert [
        (result.name, t.message)
        for result in results.values()
        for t in result.tests
        if not t.passed
    ] == []
    assert verdict.score == verdict.max_score


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES[:2])
@pytest.mark.parametrize("style", OWN_CLASSES)
def test_right_classes_pass_in_the_notebook(style, place):
    KdTree = load_class(notebook(OWN_CLASSES[style], place))
    for exercise in ("insert", "search"):
        check(KdTree, exercise=exercise)
