"""Visible checks of `insert`, through `KdTree`."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief_text,
    call_each,
    frozen,
    get_attribute_path,
    observe,
    precondition,
)
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_04.cases import ELEVEN_POINTS, chain_tree, diagonal_points
from utils.checks.lesson_04.trees import (
    MAX_NODES,
    assert_indices,
    assert_tree,
    build_tree,
    error_names,
)
from utils.checks.run_cache import once_per_run
from utils.geometry import grow_tree, nodes_by_path

# Comparing y at the root would put the second and third points on the wrong sides.
_TWO_LEVELS = frozen(np.array([[5.0, 5.0], [2.0, 8.0], [8.0, 3.0]]))
# Comparing x again on the second level would misplace the last four points.
_THREE_LEVELS = frozen(
    np.array([[5.0, 5.0], [2.0, 6.0], [8.0, 4.0], [1.0, 7.0], [3.0, 1.0], [7.0, 9.0], [9.0, 2.0]])
)
_DIAGONAL = frozen(diagonal_points([4, 2, 6, 1, 3, 5, 7]))


def _tree_of(KdTree: Callable, points: ArrayLike, indices: Sequence[int] | None = None) -> object:
    require_root(KdTree)
    tree = KdTree()
    indices = indices or range(len(points))
    call_each(tree.insert, zip(np.array(points), indices, strict=True))
    return tree


@once_per_run
def require_root(KdTree: Callable) -> None:
    """Assert that the first point becomes the root; otherwise raise `NotYet`.

    If the root is wrong, a walk down the tree may never end.
    """
    with precondition("the first point becomes the root"):
        first_is_root(KdTree)


@once_per_run
def _assert_sides(KdTree: Callable) -> None:
    with precondition("at the root, a smaller x goes left and a greater x goes right"):
        assert_tree(_tree_of(KdTree, _TWO_LEVELS), _TWO_LEVELS)


@once_per_run
def _assert_axes_alternate(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    with precondition("x is compared at the root and y one level below"):
        assert_tree(_tree_of(KdTree, _THREE_LEVELS), _THREE_LEVELS)


@visible_check(
    "insert",
    weight=2,
    title="Makes the first point the root",
    why="Every search starts at the root. A search of a tree without a root finds nothing.",
    hint="If tree.root is None, set tree.root = Node(point, index).",
)
def first_is_root(KdTree: Callable) -> None:
    tree = KdTree()
    if tree.root is not None:
        raise CheckFailed("The root of a new tree must be None.", yours=brief_text(tree.root))
    tree.insert(np.array([3.0, 1.0]), 7)
    assert_tree(tree, [[3.0, 1.0]], [7])


@visible_check(
    "insert",
    weight=2,
    title="Sends a smaller x left and a greater x right at the root",
    why="A search relies on this order when it skips half of the street.",
    hint="Compare point[0] with tree.root.point[0], because coordinate 0 is x. A smaller x belongs "
    "in tree.root.left, and any other x in tree.root.right.",
    slow="does the loop end once the point is attached to the tree? `return` or `break` ends a "
    "`while True:` loop.",
)
def compares_x_first(KdTree: Callable) -> None:
    assert_tree(_tree_of(KdTree, _TWO_LEVELS), _TWO_LEVELS)


@visible_check(
    "insert",
    weight=10,
    title="Compares y one level below the root",
    why="Cuts by x alone give strips, and each strip crosses the whole street.",
    hint="At each node, compare one coordinate only: point[depth % len(point)]. The depth is 0 at "
    "the root and grows by 1 with each step down.",
)
def axes_alternate(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    assert_tree(_tree_of(KdTree, _THREE_LEVELS), _THREE_LEVELS)


@visible_check(
    "insert",
    weight=6,
    title="Puts each of ten points in its place, down to the eighth level",
    why="A search looks for each point in one place only. A point in any other place is never "
    "found.",
    hint="Follow the point that the message names down the tree on paper: compare one coordinate "
    "at each node until you reach a free place.",
)
def places_ten_points(KdTree: Callable) -> None:
    _assert_axes_alternate(KdTree)
    # Point 6 is left out because it shares a coordinate; a later check covers equal coordinates.
    rows = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10]
    assert_tree(_tree_of(KdTree, ELEVEN_POINTS[rows], rows), ELEVEN_POINTS[rows], rows)


@visible_check(
    "insert",
    weight=5,
    title="Sends a point with an equal coordinate to the right",
    why="Walls and kerbs have many points with the same coordinate. search expects them on the "
    "right, and may miss a point on the left.",
    hint="Go left only if the coordinate is strictly smaller (<). Otherwise go right.",
)
def equal_goes_right(KdTree: Callable) -> None:
    points = diagonal_points([4, 4, 2, 2, 6, 4])
    assert_tree(_tree_of(KdTree, points), points)


@visible_check(
    "insert",
    weight=4,
    title="Works on points with three coordinates: compares x, y, z and then x again",
    why="The points of a scan have three coordinates. Without cuts by z, a search on a bridge "
    "also looks at the road below it.",
    hint="Use len(point), not 2, as the number of coordinates.",
)
def handles_three_coordinates(KdTree: Callable) -> None:
    _assert_axes_alternate(KdTree)
    points = [
        [5.0, 5.0, 5.0],
        [4.0, 1.0, 9.0],
        [3.0, 0.0, 9.0],
        [2.0, 0.0, 8.0],
        [1.0, -1.0, 8.5],
        [4.5, 0.5, 1.0],
    ]
    assert_tree(_tree_of(KdTree, points), points)


@visible_check(
    "insert",
    weight=4,
    title="Stores the index of each point in its node",
    why="The index tells you which row of the cloud a search has found. Points may be inserted in "
    "any order.",
    hint="Pass index to Node unchanged: Node(point, index).",
)
def keeps_the_index(KdTree: Callable) -> None:
    indices = [30, 10, 50, 20, 0, 40, 60]
    tree = _tree_of(KdTree, _DIAGONAL, indices)
    with precondition("every point is in its place"):
        assert_tree(tree, _DIAGONAL, indices, may_be_mirrored=True)
    assert_indices(tree, _DIAGONAL, indices)


@visible_check(
    "insert",
    weight=1,
    title="Accepts points as lists and tuples as well as arrays",
    why="Later cells insert lists, because insert is faster with Python's own numbers.",
    hint="Use point[axis] and len(point), which work for lists, tuples and arrays. Lists and "
    "tuples have no .shape, .size or .tolist().",
)
def accepts_lists_and_tuples(KdTree: Callable) -> None:
    require_root(KdTree)
    for kind in (list, tuple):
        tree = KdTree()
        points = map(kind, _DIAGONAL.tolist())
        call_each(tree.insert, zip(points, range(len(_DIAGONAL)), strict=True))
        assert_tree(tree, _DIAGONAL, may_be_mirrored=True)


@visible_check(
    "insert",
    weight=1,
    title="Keeps two trees separate",
    why="A car with two scanners needs a separate tree for each.",
    hint="Start every walk at tree.root, and do not store nodes in global variables.",
)
def keeps_trees_apart(KdTree: Callable) -> None:
    with precondition("every point is in its place"):
        assert_tree(_tree_of(KdTree, _DIAGONAL), _DIAGONAL, may_be_mirrored=True)
    trees = KdTree(), KdTree()
    for row, point in enumerate(_DIAGONAL.copy()):
        trees[row % 2].insert(point, row)
    for side, tree in enumerate(trees):
        assert_tree(tree, _DIAGONAL[side::2], list(range(side, 7, 2)), may_be_mirrored=True)


@visible_check(
    "insert",
    weight=1,
    title="Does not change the point",
    why="The point is a row of the cloud. Changing it moves an obstacle.",
    hint="Read point[axis], but assign only to the tree.",
)
def leaves_the_point(KdTree: Callable) -> None:
    require_root(KdTree)
    tree = KdTree()
    for index, point in enumerate(_DIAGONAL.copy()):
        assert_arguments_unchanged(observe(tree.insert, point, index), point, index)
    with precondition("every point is in its place"):
        assert_tree(tree, _DIAGONAL, may_be_mirrored=True)


@note_check(
    "insert",
    title="Works on a tree with more than a thousand levels",
    why="The sorted wall later in this lesson gives a tree with one level per point. A function "
    "that calls itself once per level raises a RecursionError on that tree; a loop does not.",
)
def inserts_into_deep_trees(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    try:
        tree = build_tree(KdTree, chain_tree(1200), as_lists=True)
        tree.insert(np.array([1200.0, 1200.0]), 1200)
    except Exception as error:
        if "RecursionError" not in error_names(error):
            raise
        raise CheckFailed(
            fixed(
                "The tree has 1200 levels. A function called itself once per level until Python "
                "stopped it with a RecursionError."
            )
        ) from None
    try:
        last = get_attribute_path(tree, ["root", *["right"] * 1200])
    except Exception as error:
        if "AttributeError" not in error_names(error):
            raise
        last = None  # the path is shorter
    if last is None:
        raise CheckFailed(
            fixed("A point that belongs below the last of 1200 levels is missing."),
            hint="Start at tree.root and walk down until there is no child.",
        )


def _student_indices_by_path(KdTree: Callable, points: np.ndarray) -> dict[str, object]:
    """Return the indices in a student's tree, keyed by the path to the node."""
    tree = KdTree()
    for index, point in enumerate(points):
        tree.insert(point, index)
        if index == 0 and tree.root is not None:
            assert_tree(tree, points[:1])  # a node below itself would make the loop endless
    found, pending = {}, [("", tree.root)]
    for path, node in pending:  # the list grows inside the loop
        if node is not None and len(found) < MAX_NODES:
            found[path] = node.index
            pending += [(path + "l", node.left), (path + "r", node.right)]
    return found


def _indices_by_path(points: np.ndarray, **rule: Callable) -> dict[str, int]:
    """Return the indices of a tree built by a right or wrong rule, keyed by path."""
    return {path: node.index for path, node in nodes_by_path(grow_tree(points, **rule)).items()}


def _replace_children_of_root(right: dict[str, int], points: np.ndarray) -> dict[str, int]:
    """Predict the tree in which each point replaces a child of the root."""
    sides = {"l" if x < points[0, 0] else "r": row for row, x in enumerate(points[:, 0]) if row}
    return {**sides, "": 0}


declare_mistakes(
    "insert",
    Mistake(
        "x is compared at every level; the axis should change at each step down.",
        lambda right, points: _indices_by_path(points, axis_at=lambda depth, k: 0),
        "The axis is depth % len(point), and depth grows by 1 with each step down.",
    ),
    Mistake(
        "y is compared at the root, as if the root had depth 1; it should be x.",
        lambda right, points: _indices_by_path(points, axis_at=lambda depth, k: (depth + 1) % k),
        "The root has depth 0, so its axis is x.",
    ),
    Mistake(
        "z is never compared, because the function uses 2 instead of len(point).",
        lambda right, points: _indices_by_path(points, axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "The function uses `<=` instead of `<`, so an equal coordinate goes left.",
        lambda right, points: _indices_by_path(points, goes_left=operator.le),
        "Go left only if the coordinate is strictly smaller.",
    ),
    Mistake(
        "The sides are swapped: a greater coordinate goes left, and a smaller or equal one goes "
        "right.",
        lambda right, points: _indices_by_path(points, goes_left=operator.gt),
    ),
    Mistake(
        "The sides are swapped: a greater or equal coordinate goes left, and a smaller one goes "
        "right.",
        lambda right, points: _indices_by_path(points, goes_left=operator.ge),
    ),
    Mistake(
        "Each point becomes a child of the root and replaces the child that was there before.",
        _replace_children_of_root,
        "If there is already a child on that side, continue from that child.",
    ),
    Mistake(
        "No point is ever attached to the tree, so it stays empty.",
        lambda right, points: {},
        "Assigning a Node to a local variable does not attach it. Set tree.root, node.left or "
        "node.right.",
    ),
    cases=(
        (ELEVEN_POINTS[:7].copy(),),
        (np.array([[3.0, 2.0], [3.0, 1.0], [1.0, 4.0], [1.0, 4.0], [5.0, 1.0], [0.0, 4.0]]),),
        (np.array([[2.0, 2.0], [0.0, 1.0], [0.0, 1.0], [2.0, 5.0], [2.0, 5.0], [1.0, 0.0]]),),
        (np.array([[4, 4, 4], [3, 3, 5], [2, 2, 6], [1, 1, 5], [1.5, 1, 7], [3.5, 0, 1.0]]),),
        (np.array([[0, 0, 0], [2, 1, 5], [1, 2, 3], [4, 5, 2], [3, 6, 4], [5, 0.5, 1.0]]),),
    ),
    right=_indices_by_path,
    is_same=operator.eq,
    call=_student_indices_by_path,
    class_name="KdTree",
)
