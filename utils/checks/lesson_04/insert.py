"""Visible checks of `insert`, through `KdTree`."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief,
    call_each,
    frozen,
    needs,
    observe,
    reach,
)
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_04.cases import QUIZ, chain_tree, diagonal_points
from utils.checks.lesson_04.trees import (
    MAX_NODES,
    assert_indices,
    assert_tree,
    build_tree,
    error_names,
)
from utils.checks.run_cache import once
from utils.geometry import grown, places_of

# Points that x puts to other sides of the root than y would.
_SIDEWAYS = frozen(np.array([[5.0, 5.0], [2.0, 8.0], [8.0, 3.0]]))
# One level more. Comparing x again on the second level puts the last points elsewhere.
_THREE_LEVELS = frozen(
    np.array([[5.0, 5.0], [2.0, 6.0], [8.0, 4.0], [1.0, 7.0], [3.0, 1.0], [7.0, 9.0], [9.0, 2.0]])
)
_DIAGONAL = frozen(diagonal_points([4, 2, 6, 1, 3, 5, 7]))


def _inserted(KdTree: Callable, points: ArrayLike, indices: Sequence[int] | None = None) -> object:
    require_root(KdTree)
    tree = KdTree()
    indices = indices or range(len(points))
    call_each(tree.insert, zip(np.array(points), indices, strict=True))
    return tree


@once
def require_root(KdTree: Callable) -> None:
    """Assert that the first point becomes the root; raise `NotYet` if not.

    Without a right root, a walk down the tree may never end.
    """
    with needs("the first point becomes the root"):
        first_is_root(KdTree)


@once
def _assert_sides(KdTree: Callable) -> None:
    with needs("at the root, smaller x goes left and greater x right"):
        assert_tree(_inserted(KdTree, _SIDEWAYS), _SIDEWAYS)


@once
def _assert_turns(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    with needs("x decides at the root and y one level below"):
        assert_tree(_inserted(KdTree, _THREE_LEVELS), _THREE_LEVELS)


@visible(
    "insert",
    weight=2,
    title="The first point becomes the root",
    why="Every search begins at the root: a tree without one is empty.",
    hint="While tree.root is None there is nowhere to walk: tree.root = Node(point, index).",
)
def first_is_root(KdTree: Callable) -> None:
    tree = KdTree()
    if tree.root is not None:
        raise CheckFailed("A new tree is empty: its root is None.", yours=brief(tree.root))
    tree.insert(np.array([3.0, 1.0]), 7)
    assert_tree(tree, [[3.0, 1.0]], [7])


@visible(
    "insert",
    weight=2,
    title="At the root, smaller x goes left and greater x right",
    why="A search trusts this order when it leaves half of the street out.",
    hint="The root has depth 0, and number 0 of a point is x.",
    slow="does the walk end once the point is hung into the tree? `return`, or `break`, ends a "
    "`while True:` loop.",
)
def compares_x_first(KdTree: Callable) -> None:
    assert_tree(_inserted(KdTree, _SIDEWAYS), _SIDEWAYS)


@visible(
    "insert",
    weight=10,
    title="One level below the root, y decides",
    why="Cuts along x alone are strips, and a strip crosses the whole street.",
    hint="Compare only one coordinate at each node: number depth % len(point), with depth 0 "
    "at the root and one more at each step down.",
)
def axes_alternate(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    assert_tree(_inserted(KdTree, _THREE_LEVELS), _THREE_LEVELS)


@visible(
    "insert",
    weight=6,
    title="Grows a tree of ten points, eight levels deep",
    why="Every node must end up in the one place where a search will look for it.",
    hint="Follow the point that is named, with a pencil: which coordinate is compared at each "
    "node, and where is the first free place?",
)
def grows_the_quiz(KdTree: Callable) -> None:
    _assert_turns(KdTree)
    # Point 6 is left out because it shares a coordinate; a later check covers equal coordinates.
    rows = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10]
    assert_tree(_inserted(KdTree, QUIZ[rows], rows), QUIZ[rows], rows)


@visible(
    "insert",
    weight=5,
    title="Equal goes right",
    why="Walls and kerbs have many points with the very same coordinate. They need one rule, "
    "and search relies on the same one.",
    hint="Only strictly smaller (<) goes left; everything else goes right.",
)
def equal_goes_right(KdTree: Callable) -> None:
    points = diagonal_points([4, 4, 2, 2, 6, 4])
    assert_tree(_inserted(KdTree, points), points)


@visible(
    "insert",
    weight=4,
    title="Takes points with three coordinates: x, y, z and x again",
    why="A street is three-dimensional.",
    hint="Count the coordinates with len(point) and do not write 2 into the function.",
)
def takes_three(KdTree: Callable) -> None:
    _assert_turns(KdTree)
    points = [
        [5.0, 5.0, 5.0],
        [4.0, 1.0, 9.0],
        [3.0, 0.0, 9.0],
        [2.0, 0.0, 8.0],
        [1.0, -1.0, 8.5],
        [4.5, 0.5, 1.0],
    ]
    assert_tree(_inserted(KdTree, points), points)


@visible(
    "insert",
    weight=4,
    title="Keeps the index that comes with each point",
    why="The index says which row of the cloud was found; points may arrive in any order.",
    hint="Pass index on to Node as it is.",
)
def keeps_the_index(KdTree: Callable) -> None:
    indices = [30, 10, 50, 20, 0, 40, 60]
    tree = _inserted(KdTree, _DIAGONAL, indices)
    with needs("every point is where it belongs"):
        assert_tree(tree, _DIAGONAL, indices, either_way=True)
    assert_indices(tree, _DIAGONAL, indices)


@visible(
    "insert",
    weight=1,
    title="Takes points as lists and as tuples, too",
    why="Later cells insert the rows of an array, and lists where speed counts.",
    hint="point[axis] and len(point) serve every kind; .shape, .size and .tolist() are an array's.",
)
def takes_any_notation(KdTree: Callable) -> None:
    require_root(KdTree)
    for kind in (list, tuple):
        tree = KdTree()
        points = map(kind, _DIAGONAL.tolist())
        call_each(tree.insert, zip(points, range(len(_DIAGONAL)), strict=True))
        assert_tree(tree, _DIAGONAL, either_way=True)


@visible(
    "insert",
    weight=1,
    title="Two trees at the same time stay apart",
    why="A car with two scanners keeps a tree for each.",
    hint="All that is known about a tree hangs on its root: keep nothing outside.",
)
def keeps_trees_apart(KdTree: Callable) -> None:
    with needs("every point is where it belongs"):
        assert_tree(_inserted(KdTree, _DIAGONAL), _DIAGONAL, either_way=True)
    trees = KdTree(), KdTree()
    for row, point in enumerate(_DIAGONAL.copy()):
        trees[row % 2].insert(point, row)
    for side, tree in enumerate(trees):
        assert_tree(tree, _DIAGONAL[side::2], list(range(side, 7, 2)), either_way=True)


@visible(
    "insert",
    weight=1,
    title="Leaves the point as it is",
    why="The point is a row of the cloud: changing it moves an obstacle.",
    hint="Read point[axis], and write to the tree only.",
)
def leaves_the_point(KdTree: Callable) -> None:
    require_root(KdTree)
    tree = KdTree()
    for index, point in enumerate(_DIAGONAL.copy()):
        assert_arguments_unchanged(observe(tree.insert, point, index), point, index)
    with needs("every point is where it belongs"):
        assert_tree(tree, _DIAGONAL, either_way=True)


@noted(
    "insert",
    title="Copes with a tree of a thousand levels",
    why="The sorted wall below makes a tree as deep as it has points. A function that calls itself "
    "once per level ends there in a RecursionError; a loop does not.",
)
def copes_with_depth(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    try:
        tree = build_tree(KdTree, chain_tree(1200), as_lists=True)
        tree.insert(np.array([1200.0, 1200.0]), 1200)
    except Exception as error:
        if "RecursionError" not in error_names(error):
            raise
        raise CheckFailed(
            fixed(
                "The tree has 1200 levels, and a function called itself for each of them until "
                "Python stopped it (RecursionError)."
            )
        ) from None
    try:
        last = reach(tree, ["root", *["right"] * 1200])
    except Exception as error:
        if "AttributeError" not in error_names(error):
            raise
        last = None  # the path ends earlier
    if last is None:
        raise CheckFailed(
            fixed("A point that belongs below the last of 1200 levels is not there."),
            hint="Begin at tree.root, and walk until there is no child.",
        )


def _paths_in(KdTree: Callable, points: np.ndarray) -> dict[str, object]:
    """Return the indices in a student's tree, keyed by the path to the node."""
    tree = KdTree()
    for index, point in enumerate(points):
        tree.insert(point, index)
        if index == 0 and tree.root is not None:
            assert_tree(tree, points[:1])  # a node below itself would be endless
    found, pending = {}, [("", tree.root)]
    for path, node in pending:  # the list grows inside the loop
        if node is not None and len(found) < MAX_NODES:
            found[path] = node.index
            pending += [(path + "l", node.left), (path + "r", node.right)]
    return found


def _paths(points: np.ndarray, **rule: Callable) -> dict[str, int]:
    return {path: node.index for path, node in places_of(grown(points, **rule)).items()}


def _replace_children_of_root(right: dict[str, int], points: np.ndarray) -> dict[str, int]:
    """Return the tree in which each point replaces a child of the root."""
    sides = {"l" if x < points[0, 0] else "r": row for row, x in enumerate(points[:, 0]) if row}
    return {**sides, "": 0}


mistakes(
    "insert",
    Mistake(
        "x is compared at every level: the axis does not change on the way down.",
        lambda right, points: _paths(points, axis_at=lambda depth, k: 0),
        "The axis is depth % len(point), and depth grows by 1 at each step down.",
    ),
    Mistake(
        "The turns begin with y: the root is treated as if it had depth 1.",
        lambda right, points: _paths(points, axis_at=lambda depth, k: (depth + 1) % k),
        "The root has depth 0.",
    ),
    Mistake(
        "x and y take turns and z is never compared: 2 is written where len(point) is needed.",
        lambda right, points: _paths(points, axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "`<=` stands where `<` is asked for: an equal coordinate goes left.",
        lambda right, points: _paths(points, goes_left=operator.le),
        "Only strictly smaller goes left.",
    ),
    Mistake(
        "The sides are swapped: greater goes left, and smaller or equal right.",
        lambda right, points: _paths(points, goes_left=operator.gt),
    ),
    Mistake(
        "The sides are swapped: greater or equal goes left, and smaller right.",
        lambda right, points: _paths(points, goes_left=operator.ge),
    ),
    Mistake(
        "Each point is hung below the root, in the place of the one that hung there before.",
        _replace_children_of_root,
        "Is there a child on that side already? Then go on from the child.",
    ),
    Mistake(
        "Nothing is ever hung into the tree: it stays empty.",
        lambda right, points: {},
        "A local variable that gets a Node is not part of the tree: set tree.root, node.left or "
        "node.right.",
    ),
    cases=(
        (QUIZ[:7].copy(),),
        (np.array([[3.0, 2.0], [3.0, 1.0], [1.0, 4.0], [1.0, 4.0], [5.0, 1.0], [0.0, 4.0]]),),
        (np.array([[2.0, 2.0], [0.0, 1.0], [0.0, 1.0], [2.0, 5.0], [2.0, 5.0], [1.0, 0.0]]),),
        (np.array([[4, 4, 4], [3, 3, 5], [2, 2, 6], [1, 1, 5], [1.5, 1, 7], [3.5, 0, 1.0]]),),
        (np.array([[0, 0, 0], [2, 1, 5], [1, 2, 3], [4, 5, 2], [3, 6, 4], [5, 0.5, 1.0]]),),
    ),
    right=_paths,
    same=operator.eq,
    call=_paths_in,
    class_name="KdTree",
)
