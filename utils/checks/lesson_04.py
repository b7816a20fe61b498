"""Visible checks of lesson 04: `insert` and `search` through `KdTree`, and `median_order`."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.claims import MOST_OF_A_POINT
from utils.checks.core import visible
from utils.checks.vocabulary import CheckFailed, as_array, assert_untouched, brief, frozen

# The eleven points of the lesson.
QUIZ = frozen(
    np.array(
        [
            [-6.2, 7.0],
            [-6.3, 8.4],
            [-5.2, 7.1],
            [-5.7, 6.3],
            [7.2, 6.1],
            [8.0, 5.3],
            [7.2, 7.1],
            [0.2, -7.1],
            [1.7, -6.9],
            [-1.2, -7.2],
            [2.2, -8.9],
        ]
    )
)
# Inserted in this order they make a balanced tree.
_BALANCED = (7, 0, 3, 9, 1, 2, 5, 8, 10, 4, 6)


class _Node:
    """A node of the right tree."""

    def __init__(self, point: list[float], index: int) -> None:
        self.point, self.index = point, index
        self.left = self.right = None


def grown(points: ArrayLike, indices: Sequence[int] | None = None) -> _Node | None:
    """The right tree of points inserted one after another; None without points.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
    indices : sequence of int, optional
        By default 0, 1, 2, ...

    Returns
    -------
    node or None
        With `point`, `index`, `left` and `right`.
    """
    root = None
    indices = indices or range(len(points))
    for index, point in zip(indices, np.asarray(points).tolist(), strict=True):
        node, depth = root, 0
        while node is not None:
            axis = depth % len(point)
            side = "left" if point[axis] < node.point[axis] else "right"
            parent, node, depth = node, getattr(node, side), depth + 1
        if root is None:
            root = _Node(point, index)
        else:
            setattr(parent, side, _Node(point, index))
    return root


def table_of(root: _Node | None) -> tuple[list, list, list, list]:
    """The rows of a tree as `KdTree.plant` takes them.

    Parameters
    ----------
    root : node or None

    Returns
    -------
    points : list of list of float
    left, right : list of int
        Rows of the children; -1 where there is none.
    indices : list of int
    """
    nodes = _nodes_of(root)
    rows = {id(node): row for row, node in enumerate(nodes)}
    rows[id(None)] = -1
    return (
        [node.point for node in nodes],
        [rows[id(node.left)] for node in nodes],
        [rows[id(node.right)] for node in nodes],
        [node.index for node in nodes],
    )


def planted(KdTree: Callable, root: _Node | None) -> object:
    """A tree of the student's class with the same nodes as a right one.

    The class of the lesson can be given its nodes ready-made, so that a slip in `insert` does not
    spoil `search`. A class without `plant` has to insert them.

    Parameters
    ----------
    KdTree : callable
    root : node or None

    Returns
    -------
    object
        Of the student's class.
    """
    tree = KdTree()
    points, left, right, indices = table_of(root)
    plant = _method(tree, "plant")
    if plant:
        plant(points, left, right, indices)
        return tree
    for point, index in zip(points, indices, strict=True):
        tree.insert(point, index)
    return tree


def _method(tree: object, name: str) -> Callable | None:
    """A method of a student's object, here or in the sandbox; None where there is none."""
    try:
        return getattr(tree, name)
    except Exception as error:  # an AttributeError, or the judge's report of one
        if "AttributeError" in (type(error).__name__, getattr(error, "type_name", "")):
            return None
        raise


def assert_tree(tree: object, points: ArrayLike, indices: Sequence[int] | None = None) -> None:
    """A tree holds points as inserting them one after another must place them.

    Parameters
    ----------
    tree : object
        Of the student's class.
    points, indices
        As for `grown`.
    """
    expected = grown(points, indices)
    waiting = [(tree.root, expected, "the root")]
    while waiting:
        yours, node, place = waiting.pop()
        if node is None:
            if yours is not None:
                raise CheckFailed(
                    f"There is a node at {place}, where the tree ends.",
                    yours=_name(yours),
                    expected="None",
                    draw=_side_by_side(tree, expected),
                )
            continue
        if yours is None:
            raise CheckFailed(
                f"Nothing is at {place}, where the point {_exactly(node.point)} belongs.",
                yours="None",
                expected=_name(node),
                draw=_side_by_side(tree, expected),
            )
        point, index, left, right = (
            _attribute(yours, attribute, place) for attribute in ("point", "index", "left", "right")
        )
        point = as_array(point, what="a point", most=MOST_OF_A_POINT).ravel()
        if point.shape != np.shape(node.point) or not np.allclose(point, node.point, atol=1e-4):
            raise CheckFailed(
                f"Another point than expected is at {place}.",
                yours=_name(yours),
                expected=_name(node),
                draw=_side_by_side(tree, expected),
            )
        if not isinstance(index, (int, np.integer)) or index != node.index:
            raise CheckFailed(
                f"The node at {place} has the right point and the wrong index.",
                yours=_name(yours),
                expected=_name(node),
            )
        waiting += [
            (right, node.right, f"the right of {_name(node)}"),
            (left, node.left, f"the left of {_name(node)}"),
        ]


def _attribute(node: object, name: str, place: str) -> object:
    try:
        return getattr(node, name)
    except Exception:
        raise CheckFailed(
            f"What stands at {place} has no attribute {name!r}: hang a Node into "
            "the tree, as given in the lesson.",
            yours=brief(node),
        ) from None


def as_indices(answer: object) -> list[int]:
    """What a search returned as a sorted list of whole numbers.

    Parameters
    ----------
    answer : object

    Returns
    -------
    list of int
    """
    array = as_array(list(answer) if isinstance(answer, set) else answer, what="a list of indices")
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise CheckFailed(
            "search returns the indices of the points it found, in one flat list.",
            yours=brief(answer),
            expected="whole numbers, such as [0, 3]",
        )
    return sorted(array.tolist())


def assert_found(
    tree: object, root: _Node | None, target: Sequence[float], tolerance: float
) -> None:
    """A search finds exactly the points of a right tree that lie within the tolerance.

    Parameters
    ----------
    tree : object
        Of the student's class, with the nodes of the right tree.
    root : node or None
        The right tree.
    target : sequence of float
    tolerance : float
    """
    points, _, _, indices = table_of(root)
    expected = sorted(
        index
        for index, point in zip(indices, points, strict=True)
        if math.dist(point, target) <= tolerance
    )
    yours = as_indices(tree.search(target, tolerance))
    if yours == expected:
        return
    missing, extra = sorted(set(expected) - set(yours)), sorted(set(yours) - set(expected))
    where = dict(zip(indices, points, strict=True))
    parts = []
    if missing:
        parts.append(f"Not found: {_first(missing, where, target)}")
    if extra:
        parts.append(f"Found, but farther than {tolerance:g}: {_first(extra, where, target)}")
    message = ". ".join(parts) or "Some indices are there more than once"
    raise CheckFailed(
        f"{message}.",
        yours=f"{len(yours)} indices",
        expected=f"{len(expected)} indices",
        draw=_missed(points, indices, root, target, tolerance, yours),
    )


def assert_pruned(
    KdTree: Callable,
    root: _Node,
    trap: int | None,
    target: Sequence[float],
    tolerance: float,
    decoy: int | None = None,
) -> None:
    """A search leaves a region alone that cannot hold a neighbour, and looks into one that can.

    Parameters
    ----------
    KdTree : callable
    root : node
        A right tree.
    trap : int or None
        Index of a leaf in a region beyond the tolerance. It is moved to the target, where no
        right tree has it: only a search that looks into the region finds it.
    target : sequence of float
    tolerance : float
    decoy : int, optional
        Index of a leaf in a region that the tolerance reaches; see `leaves_within_reach`. It is
        moved to the target, too, and every search that follows the splits finds it. Whoever sorts
        out nodes that stand in the wrong place, to compare with all others, does not.
    """
    if not _method(KdTree(), "plant"):  # inserted, the node would stand where it may be found
        assert_found(planted(KdTree, root), root, target, tolerance)
        return
    nodes = _nodes_of(root)
    moved = [node for node in nodes if node.index in (trap, decoy)]
    assert all(node.left is None and node.right is None for node in moved)
    expected = sorted(
        node.index
        for node in nodes
        if node.index != trap
        and (node.index == decoy or math.dist(node.point, target) <= tolerance)
    )
    places = [node.point for node in moved]
    for node in moved:
        node.point = list(target)
    try:
        tree = planted(KdTree, root)
    finally:
        for node, place in zip(moved, places, strict=True):
            node.point = place
    answer = as_indices(tree.search(target, tolerance))
    if answer == expected:
        return
    if trap is not None and trap in answer:
        raise CheckFailed(
            "search looked into a region that lies entirely beyond the tolerance. "
            "It finds the right points, but it asks nodes that it could skip.",
            yours="looks there",
            expected="leaves the whole region out",
        )
    raise CheckFailed(
        "Not all points within the tolerance were found, on the paths that the splits leave open.",
        yours=f"{len(answer)} indices",
        expected=f"{len(expected)} indices",
    )


def leaves_within_reach(root: _Node, target: Sequence[float], tolerance: float) -> list[int]:
    """Indices of leaves that a search must look at, though the target lies beyond a split.

    Parameters
    ----------
    root : node
        A right tree.
    target : sequence of float
    tolerance : float

    Returns
    -------
    list of int
        In ascending order. The tolerance reaches their regions by a clear margin.
    """
    leaves, waiting = [], [(root, 0, (0.0,) * len(target), False)]
    while waiting:
        node, depth, gaps, beyond = waiting.pop()
        if node is None or math.hypot(*gaps) > 0.8 * tolerance:
            continue
        if beyond and node.left is None and node.right is None:
            leaves.append(node.index)
        axis = depth % len(target)
        gap = target[axis] - node.point[axis]
        for child, far in ((node.left, gap), (node.right, -gap)):
            wider = [*gaps[:axis], max(gaps[axis], far), *gaps[axis + 1 :]]
            waiting.append((child, depth + 1, tuple(wider), beyond or far > 0.05 * tolerance))
    return sorted(leaves)


def _nodes_of(root: _Node | None) -> list[_Node]:
    nodes = [] if root is None else [root]
    for node in nodes:  # grows while it is walked
        nodes += [child for child in (node.left, node.right) if child is not None]
    return nodes


def as_order(answer: object, n: int) -> np.ndarray:
    """An answer as a permutation of range(n).

    Parameters
    ----------
    answer : object
    n : int

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    order = as_array(answer, what="a list of row numbers")
    if order.size == 0:
        order = order.astype(int).ravel()
    if order.ndim != 1 or order.dtype.kind not in "iu":
        raise CheckFailed(
            "The order is a flat list of row numbers (whole numbers), not of points.",
            yours=brief(order),
            expected=f"the numbers 0 to {n - 1}",
        )
    if len(order) != n or not np.array_equal(np.sort(order), np.arange(n)):
        repeated = len(order) - len(np.unique(order))
        raise CheckFailed(
            "Each row number from 0 to n - 1 must occur exactly once.",
            yours=f"{len(order)} numbers, {repeated} of them repeated",
            expected=f"{n} different numbers",
        )
    return order


def assert_shallow(answer: object, points: np.ndarray) -> None:
    """Inserting points in this order gives a tree of the least depth.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = as_order(answer, len(points))
    root = grown(points[order], order.tolist())
    depth, least = _depth(root), len(points).bit_length()
    if depth > least:
        raise CheckFailed(
            f"Inserted in this order, {len(points)} points give a tree of depth "
            f"{depth}; medians give {least}.",
            yours=f"depth {depth}",
            expected=f"depth {least}",
            draw=lambda: utils.plots.kd_tree(root, title="The tree of your order"),
        )


def assert_lower_medians(answer: object, points: np.ndarray) -> None:
    """In every part of the tree the lower median along its axis stands on top.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = as_order(answer, len(points))
    points = np.asarray(points, dtype=float)
    waiting = [(order, 0)]
    while waiting:
        rows, depth = waiting.pop()
        if not len(rows):
            continue
        axis = depth % points.shape[1]
        values = points[rows, axis]
        first, median = values[0], np.sort(values)[(len(values) - 1) // 2]
        if first != median:
            some = ", ".join(f"{value:.2f}" for value in np.sort(values)[:8])
            some += ", ..." if len(values) > 8 else ""
            raise CheckFailed(
                f"At depth {depth}, among {len(rows)} points, the first to be inserted is not the "
                f"lower median along {'xyz'[axis]}. Sorted they are {some}.",
                yours=f"{'xyz'[axis]} = {first:.2f}",
                expected=f"{'xyz'[axis]} = {median:.2f}",
            )
        smaller = values[1:] < first
        waiting += [(rows[1:][smaller], depth + 1), (rows[1:][~smaller], depth + 1)]


# ---------------------------------------------------------------------------------- insert


def _inserted(KdTree: Callable, points: ArrayLike, indices: Sequence[int] | None = None) -> object:
    tree = KdTree()
    for index, point in zip(indices or range(len(points)), np.array(points), strict=True):
        tree.insert(point, index)
    return tree


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
    weight=4,
    title="Smaller goes left, greater goes right, first by x and then by y",
    why="A search trusts this order when it leaves half of the street out.",
    hint="Compare only one coordinate at each node: number depth % len(point), with depth 0 "
    "at the root and one more at each step down.",
)
def axes_alternate(KdTree: Callable) -> None:
    # Comparing x again at the second level, or y at the first, puts the last three elsewhere.
    assert_tree(
        _inserted(
            KdTree,
            [[5.0, 5.0], [2.0, 6.0], [8.0, 4.0], [1.0, 7.0], [3.0, 1.0], [7.0, 9.0], [9.0, 2.0]],
        ),
        [[5.0, 5.0], [2.0, 6.0], [8.0, 4.0], [1.0, 7.0], [3.0, 1.0], [7.0, 9.0], [9.0, 2.0]],
    )


@visible(
    "insert",
    weight=3,
    title="Grows the tree of the eleven points of this lesson",
    why="Every node must end up in the one place where a search will look for it.",
    hint="Draw your tree beside the lesson's with plots.kd_tree(tree.root). At which node do "
    "they part, and which coordinate was compared there?",
)
def grows_the_quiz(KdTree: Callable) -> None:
    assert_tree(_inserted(KdTree, QUIZ), QUIZ)


@visible(
    "insert",
    weight=2,
    title="Equal goes right",
    why="Walls and kerbs have many points with the very same coordinate. They need one rule, "
    "and search relies on the same one.",
    hint="Only strictly smaller (<) goes left; everything else goes right.",
)
def equal_goes_right(KdTree: Callable) -> None:
    points = [[2.0, 2.0], [2.0, 1.0], [2.0, 1.0], [1.0, 3.0], [1.0, 3.0], [2.0, 2.0]]
    assert_tree(_inserted(KdTree, points), points)


@visible(
    "insert",
    weight=2,
    title="Takes points with three coordinates, in any notation, and keeps any index",
    why="A street is three-dimensional, and the index says which row of the cloud was found.",
    hint="Count the coordinates with len(point) and do not write 2 into the function. Pass "
    "index on to Node as it is.",
)
def takes_three(KdTree: Callable) -> None:
    points = [
        [5.0, 5.0, 5.0],
        [4.0, 1.0, 9.0],
        [3.0, 0.0, 9.0],
        [2.0, 0.0, 8.0],
        [1.0, -1.0, 8.5],
        [4.5, 0.5, 1.0],
    ]
    indices = [30, 10, 50, 20, 0, 40]
    assert_tree(_inserted(KdTree, points, indices), points, indices)
    tree = KdTree()
    for point, index in zip(points, indices, strict=True):
        tree.insert(tuple(point), index)
    assert_tree(tree, points, indices)


@visible(
    "insert",
    weight=2,
    title="Copes with a tree of a thousand levels",
    why="Points that arrive in sorted order, as along a wall, make a tree as deep as it has "
    "points, and Python ends a function that calls itself a thousand times.",
    hint="Walk down with a loop: while there is a child on the right side, it becomes the "
    "current node. No function needs to call itself.",
)
def copes_with_depth(KdTree: Callable) -> None:
    deep = grown([[0.0, 0.0]])
    last = deep
    for row in range(1, 1200):
        last.right = _Node([float(row), float(row)], row)
        last = last.right
    planted(KdTree, deep).insert([1200.0, 1200.0], 1200)
    assert_tree(_inserted(KdTree, QUIZ[:3]), QUIZ[:3])


# ---------------------------------------------------------------------------------- search


def _balanced() -> _Node:
    return grown(QUIZ[list(_BALANCED)], _BALANCED)


@visible(
    "search",
    weight=4,
    title="Finds the four points around (-6, 7)",
    why="This is the question that clustering asks a hundred thousand times per scan: who is near?",
    hint="At each node do two things: compare the distance of its point with the tolerance, "
    "and decide for each side whether to go on there.",
)
def finds_the_quiz(KdTree: Callable) -> None:
    assert_found(planted(KdTree, _balanced()), _balanced(), [-6.0, 7.0], 3.0)


@visible(
    "search",
    weight=4,
    title="Looks on both sides where the circle crosses the split",
    why="A pedestrian may stand exactly where the tree was cut in two. Whoever looks only on "
    "the target's own side sees half of them.",
    hint="Left and right are two separate questions (two ifs, no else): does the box reach "
    "below the split? Does it reach the split or beyond it?",
)
def looks_on_both_sides(KdTree: Callable) -> None:
    root = _balanced()
    tree = planted(KdTree, root)
    for target in ([0.0, -7.0], [7.3, 6.3], [-5.7, 7.05], [1.0, -8.0]):
        assert_found(tree, root, target, 2.5)


@visible(
    "search",
    weight=3,
    title="Finds a point at exactly the tolerance",
    why="Within means up to and including. The search of a well-known course loses these "
    "points, and only in some directions.",
    hint="A point with the coordinate of the split itself lies on the right. So go right when "
    "target[axis] + tolerance >= split, with the equals sign, and compare the distance "
    "with <=.",
)
def includes_the_border(KdTree: Callable) -> None:
    # Four points at a distance of exactly 3. The first two rows cut at their very coordinates.
    points = np.array(
        [
            [4.0, 9.0],
            [-5.0, 5.0],
            [4.0, 2.0],
            [1.0, 5.0],
            [-2.0, 2.0],
            [1.0, -1.0],
            [4.1, 2.0],
            [1.0, 5.1],
            [-2.1, 2.0],
            [1.0, -1.1],
        ]
    )
    for order in (range(10), [1, 0, 4, 8, 5, 9, 2, 6, 3, 7], [5, 4, 0, 1, 3, 2, 9, 8, 7, 6]):
        root = grown(points[list(order)], list(order))
        assert_found(planted(KdTree, root), root, [1.0, 2.0], 3.0)


@visible(
    "search",
    weight=3,
    title="Measures a circle, not a square, and the radius is tolerance itself",
    why="The corner of a box is 1.4 times as far away as its side (1.7 times in space): "
    "neighbours that are none join obstacles that are two.",
    hint="The box only decides where to look. A point counts when its distance, the square "
    "root of the sum of squares, is at most tolerance.",
)
def measures_a_circle(KdTree: Callable) -> None:
    points = np.array(
        [
            [0.0, 0.0],
            [1.9, 1.9],
            [-1.9, 1.9],
            [1.2, -1.2],
            [0.0, 1.9],
            [2.3, 0.0],
            [-1.2, 1.2],
            [-0.4, 0.2],
        ]
    )
    root = grown(points)
    tree = planted(KdTree, root)
    for tolerance in (0.5, 1.5, 2.0, 3.0):
        assert_found(tree, root, [0.1, 0.1], tolerance)


@visible(
    "search",
    weight=2,
    title="Takes three coordinates, lists and arrays",
    why="Scans are three-dimensional: the axes go x, y, z, x, y, z, ... down the tree.",
    hint="The axis is depth % len(target), as in insert.",
)
def searches_space(KdTree: Callable) -> None:
    rng = np.random.default_rng(4)
    root = grown(rng.uniform(-3, 3, (60, 3)).round(2))
    tree = planted(KdTree, root)
    assert_found(tree, root, [0.501, 0.201, -0.302], 1.5)
    assert_found(tree, root, np.array([-1.203, 1.004, 0.702]), 2.0)


@visible(
    "search",
    weight=3,
    title="Leaves regions out that cannot hold a neighbour",
    why="This is what a tree is for. A search that asks every node is a slow way of "
    "comparing with all.",
    hint="Before you go on to a child, compare the split, node.point[axis], with the ends of "
    "the box, target[axis] - tolerance and target[axis] + tolerance.",
)
def leaves_regions_out(KdTree: Callable) -> None:
    for trap, target in ((6, [-6.0, 7.0]), (10, [-6.0, 7.0]), (2, [7.0, 6.0]), (9, [7.0, 6.0])):
        assert_pruned(KdTree, _balanced(), trap, target, 2.0)
    points = np.random.default_rng(43).permutation(np.arange(60)).reshape(30, 2) / 4
    root, target = grown(points), points[3] + 0.1
    decoys = leaves_within_reach(root, target, 4.0)
    for decoy in decoys[:3]:
        assert_pruned(KdTree, root, None, target, 4.0, decoy)


@visible(
    "search",
    weight=1,
    title="Takes an empty tree, and finds nothing where nothing is",
    why="After filtering, a scan may hold no point at all.",
    hint="With root None the answer is an empty list. With a list of places still to visit, "
    "skip those that are None.",
)
def takes_an_empty_tree(KdTree: Callable) -> None:
    assert_found(planted(KdTree, None), None, [0.0, 0.0], 1.0)
    root = grown([[1.0, 2.0]])
    assert_found(planted(KdTree, root), root, [1.0, 2.0], 0.0)
    assert_found(planted(KdTree, root), root, [5.0, 5.0], 1.0)


# ---------------------------------------------------------------------------- median_order


@visible(
    "median_order",
    weight=2,
    title="Names every row exactly once",
    why="A point that is left out is an obstacle that nobody will find.",
    hint="The median comes first; then all smaller ones and all others, each part in the "
    "same way. Nothing is left over, and nothing is added.",
)
def names_every_row(median_order: Callable) -> None:
    as_order(median_order(QUIZ.copy()), len(QUIZ))


@visible(
    "median_order",
    weight=3,
    title="Starts with the lower median along x",
    why="Only a median halves: any other first point leaves more on one side.",
    hint="Sort the rows by x. Of m rows, the lower median stands at place (m - 1) // 2.",
)
def starts_with_the_median(median_order: Callable) -> None:
    for points in (QUIZ, QUIZ[:4], np.array([[4.0, 0.0], [1.0, 9.0]]), QUIZ[[5, 0, 8]]):
        order = as_order(median_order(points.copy()), len(points))
        x = np.sort(points[:, 0])
        median = x[(len(x) - 1) // 2]
        if points[order[0], 0] != median:
            raise CheckFailed(
                "The first point of the order is not the lower median along x. Sorted by x: "
                f"{', '.join(f'{value:g}' for value in x)}.",
                yours=f"x = {points[order[0], 0]:g}",
                expected=f"x = {median:g}",
            )


@visible(
    "median_order",
    weight=4,
    title="Takes the lower median along y, then x again, in every part",
    why="One bad split near the root doubles the work of every search below it.",
    hint="The parts of one level are sorted along another axis: depth % points.shape[1]. Mind "
    "that sorting a part gives places within the part: rows[np.argsort(...)] leads back "
    "to rows of points.",
)
def medians_everywhere(median_order: Callable) -> None:
    rng = np.random.default_rng(41)
    for n in (3, 4, 7, 20):
        points = rng.permutation(np.arange(2 * n)).reshape(n, 2) / 4
        assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=3,
    title="The tree has the least depth possible, in the plane and in space",
    why="Depth is the price of every insertion and every search: 17 levels for a hundred "
    "thousand points, or a hundred thousand.",
    hint="Print the depth of the tree of your order for 3, 7 and 15 points: it should be 2, 3 "
    "and 4.",
)
def least_depth(median_order: Callable) -> None:
    rng = np.random.default_rng(42)
    for n, k in ((3, 2), (7, 2), (15, 2), (40, 2), (31, 3), (64, 3)):
        points = rng.permutation(np.arange(k * n)).reshape(n, k) / 4
        assert_shallow(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=1,
    title="Takes no points, one point and equal points, and leaves its input untouched",
    why="Filters leave nothing now and then, and recordings hold the same point twice.",
    hint="A part without rows adds nothing to the order. Do not sort points itself: sort row "
    "numbers.",
)
def takes_the_smallest(median_order: Callable) -> None:
    as_order(median_order(np.empty((0, 2))), 0)
    as_order(median_order(np.array([[1.0, 2.0, 3.0]])), 1)
    as_order(median_order(np.ones((5, 2))), 5)
    assert_untouched(median_order, QUIZ)
    assert_lower_medians(median_order(QUIZ.copy()), QUIZ)


def _depth(root: _Node | None) -> int:
    level, depth = [root] if root is not None else [], 0
    while level:
        level = [child for node in level for child in (node.left, node.right) if child is not None]
        depth += 1
    return depth


def _exactly(point: Sequence[float]) -> str:
    """A point of any length, with all the digits that it was written with."""
    return "(" + ", ".join(f"{float(value):g}" for value in np.ravel(point)) + ")"


def _name(node: object) -> str:
    try:
        return f"point {node.index} {_exactly(node.point)}"
    except Exception:
        return brief(node)


def _first(indices: list[int], where: dict[int, list[float]], target: Sequence[float]) -> str:
    one = indices[0]
    text = f"{len(indices)} points, for example " if len(indices) > 1 else "point "
    if one not in where:
        return f"index {one}, which the tree does not hold"
    return f"{text}{one} at {_exactly(where[one])}, {math.dist(where[one], target):g} away"


def _side_by_side(tree: object, expected: _Node | None) -> Callable:
    def draw() -> None:
        import matplotlib.pyplot as plt

        _, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
        utils.plots.kd_tree(tree.root, title="yours", axes=left)
        utils.plots.kd_tree(expected, title="expected", axes=right)

    return draw


def _missed(
    points: list[list[float]],
    indices: list[int],
    root: _Node | None,
    target: Sequence[float],
    tolerance: float,
    yours: list[int],
) -> Callable | None:
    """Draw a search in the plane; in space there is nothing to draw."""
    if len(target) != 2:
        return None
    rows = np.argsort(indices)
    known = set(yours) & set(indices)
    return lambda: utils.plots.kd_search(
        np.array(points)[rows],
        root,
        target,
        tolerance,
        found=[np.flatnonzero(np.sort(indices) == index)[0] for index in known],
        title="What your search found",
    )
