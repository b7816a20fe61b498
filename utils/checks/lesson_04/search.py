"""Visible checks of lesson 04: `insert` and `search` through `KdTree`, and `median_order`."""

import copy
import math
import operator
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.claims import MOST_OF_A_POINT
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.remembering import once
from utils.checks.vocabulary import (
    CheckFailed,
    WrongForm,
    as_array,
    assert_left_alone,
    assert_untouched,
    brief,
    call_each,
    frozen,
    needs,
    observe,
    reach,
)

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
# Nodes of a wrong tree that are looked through; it may have no end.
_MOST_NODES = 200
_SIDES = {"l": "left", "r": "right"}


class _Node:
    """A node of the right tree."""

    def __init__(self, point: list[float], index: int, arrival: int = 0) -> None:
        self.point, self.index, self.arrival = point, index, arrival
        self.left = self.right = None


def _in_turn(depth: int, dimensions: int) -> int:
    return depth % dimensions


def grown(
    points: ArrayLike,
    indices: Sequence[int] | None = None,
    axis_at: Callable[[int, int], int] = _in_turn,
    goes_left: Callable[[float, float], bool] = operator.lt,
) -> _Node | None:
    """The tree of points that arrive one after another; None without points.

    The first of them is the root and parts the others in two, which arrive on either side.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
    indices : sequence of int, optional
        By default 0, 1, 2, ...
    axis_at : callable, optional
        Takes the depth and the number of dimensions; returns the axis that is compared.
    goes_left : callable, optional
        Takes a coordinate of a point and that of the node where it is.

    Returns
    -------
    node or None
        With `point`, `index`, `left` and `right`.
    """
    points, rows = np.asarray(points).tolist(), range(len(points))
    nodes = [_Node(*one) for one in zip(points, indices or rows, rows, strict=True)]
    waiting = [(nodes, 0)] if nodes else []
    for (top, *others), depth in waiting:  # grows while it is walked
        axis = axis_at(depth, len(top.point))
        sides = {"left": [], "right": []}
        for one in others:
            smaller = goes_left(one.point[axis], top.point[axis])
            sides["left" if smaller else "right"].append(one)
        for name, part in sides.items():
            if part:
                setattr(top, name, part[0])
                waiting.append((part, depth + 1))
    return nodes[0] if nodes else None


def places_of(root: _Node | None) -> dict[str, _Node]:
    """The nodes of a tree by the way to them: "" is the root, "lr" to its left and then right.

    Parameters
    ----------
    root : node or None

    Returns
    -------
    dict of str to node
        Level by level.
    """
    waiting = [("", root)] if root is not None else []
    for way, node in waiting:  # grows while it is walked
        for letter, name in _SIDES.items():
            if getattr(node, name) is not None:
                waiting.append((way + letter, getattr(node, name)))
    return dict(waiting)


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


def _nodes_of(root: _Node | None) -> list[_Node]:
    nodes = [] if root is None else [root]
    for node in nodes:  # grows while it is walked
        nodes += [child for child in (node.left, node.right) if child is not None]
    return nodes


def planted(KdTree: Callable, root: _Node | None, as_lists: bool = False) -> object:
    """A tree of the student's class with the same nodes as a right one.

    The class of the lesson can be given its nodes ready-made, so that a slip in `insert` does not
    spoil `search`. A class without `plant` has to insert them.

    Parameters
    ----------
    KdTree : callable
    root : node or None
    as_lists : bool
        Whether points are lists and not arrays.

    Returns
    -------
    object
        Of the student's class.
    """
    tree = KdTree()
    points, left, right, indices = table_of(root)
    points = points if as_lists else np.array(points)
    plant = _method(tree, "plant")
    if plant:
        plant(points, left, right, indices)
        return tree
    call_each(tree.insert, zip(points, indices, strict=True))
    return tree


def _method(tree: object, name: str) -> Callable | None:
    """A method of a student's object, here or in the sandbox; None where there is none."""
    try:
        return getattr(tree, name)
    except Exception as error:
        if "AttributeError" in _names_of(error):
            return None
        raise


def _names_of(error: Exception) -> tuple[str, str]:
    """What an exception is called, here and in the sandbox, where it is reported."""
    return type(error).__name__, getattr(error, "type_name", "")


# ------------------------------------------------------------------------- what a tree must be


def assert_tree(
    tree: object,
    points: ArrayLike,
    indices: Sequence[int] | None = None,
    either_way: bool = False,
) -> None:
    """Points stand where they belong when they arrive one after another; indices do not count.

    Parameters
    ----------
    tree : object
        Of the student's class.
    points, indices
        As for `grown`.
    either_way : bool
        Whether the sides may be swapped, in all of the tree: for properties that have nothing to
        do with that.
    """
    if either_way and not _odd_in(tree, grown(points, indices, goes_left=operator.gt))[0]:
        return
    root = grown(points, indices)
    says, hint = _odd_in(tree, root)
    if says:
        raise CheckFailed(
            says[0].upper() + says[1:], given=_few(points), hint=hint, draw=_two_trees(tree, root)
        )


def _odd_in(tree: object, root: _Node | None) -> tuple[str, str]:
    """The first point in its order of arrival that is not in its place, and a hint, or nothing."""
    expected = places_of(root)
    yours = _looked_at(tree, expected)
    for way in sorted(expected, key=lambda way: expected[way].arrival):
        if way not in yours or not _same_point(yours[way][0], expected[way]):
            return _misplaced(tree, way, expected, yours), ""
    return _one_too_many(expected, yours)


def assert_indices(tree: object, points: ArrayLike, indices: Sequence[int]) -> None:
    """Each point has the index that was inserted with it, wherever it stands.

    Parameters
    ----------
    tree, points, indices
        As for `assert_tree`.
    """
    nodes = _nodes_of(grown(points, indices))
    for point, index in _looked_at(tree, places_of(nodes[0])).values():
        node = next((one for one in nodes if _same_point(point, one)), None)
        if node and not _is_number(index, node.index):
            raise CheckFailed(
                f"The node of the point {_exactly(node.point)} has another index than the one "
                "that came with it.",
                given=_few(points),
                yours=f"index {brief(index)}",
                expected=f"index {node.index}",
            )


def _is_number(value: object, expected: int) -> bool:
    return isinstance(value, (int, np.integer)) and bool(value == expected)


def _looked_at(tree: object, expected: dict[str, _Node]) -> dict[str, tuple[np.ndarray, object]]:
    """Point and index of a student's nodes by the way to them, no farther than it should go."""
    found, waiting = {}, [("", tree.root)]
    for way, node in waiting:  # grows while it is walked
        if node is None:
            continue
        point, index, left, right = (
            _attribute(node, name, way, expected) for name in ("point", "index", "left", "right")
        )
        point = as_array(point, what="a point", most=MOST_OF_A_POINT)
        if point.ndim == 0 and np.ndim(index) == 1:
            raise WrongForm(
                "Point and index are swapped: the point of a node is a number, and its index "
                "holds the coordinates.",
                yours=f"point {point:g}, index {brief(index)}",
                expected="Node(point, index): the point comes first",
            )
        point = point.ravel()
        found[way] = (point, index)
        if way in expected:
            waiting += [(way + "l", left), (way + "r", right)]
    return found


def _attribute(node: object, name: str, way: str, expected: dict[str, _Node]) -> object:
    try:
        return getattr(node, name)
    except Exception as error:
        if "AttributeError" not in _names_of(error):
            raise
        raise WrongForm(
            f"What stands {_place(way, expected)} has no attribute {name!r}: hang a Node into "
            "the tree, as given in the lesson.",
            yours=brief(node),
        ) from None


def _same_point(point: np.ndarray, node: _Node) -> bool:
    return point.shape == (len(node.point),) and all(
        abs(a - b) <= 1e-4 + 1e-5 * abs(b) for a, b in zip(point.tolist(), node.point, strict=True)
    )


def _misplaced(tree: object, way: str, expected: dict, yours: dict) -> str:
    """What became of a point that does not stand where it belongs."""
    node = expected[way]
    if not yours:
        return f"the tree is empty: tree.root is None after {_name(node)} was inserted."
    landed = _way_to(tree, node, expected)
    if landed is None:
        return f"{_name(node)} is not in the tree; it belongs {_place(way, expected)}."
    depth = next((d for d, (a, b) in enumerate(zip(way, landed, strict=False)) if a != b), None)
    if depth is None:
        return f"{_name(node)} belongs {_place(way, expected)}, where another point stands."
    other, axis = expected[way[:depth]], depth % len(node.point)
    smaller = "is smaller than" if way[depth] == "l" else "is not smaller than"
    return (
        f"{_name(node)} went {_SIDES[landed[depth]]} at {_name(other)} and should go "
        f"{_SIDES[way[depth]]}: at depth {depth} {'xyz'[axis]} is compared, and "
        f"{node.point[axis]:g} {smaller} {other.point[axis]:g}."
    )


def _way_to(tree: object, node: _Node, expected: dict[str, _Node]) -> str | None:
    """Where a point is in a student's tree, where it should not be; None where it is nowhere."""
    waiting = [("", tree.root)]
    for way, one in waiting:  # grows while it is walked
        if one is None:
            continue
        point = as_array(one.point, what="a point", most=MOST_OF_A_POINT).ravel()
        if _same_point(point, node) and not (way in expected and _same_point(point, expected[way])):
            return way
        if len(waiting) < _MOST_NODES:
            waiting += [(way + "l", one.left), (way + "r", one.right)]
    return None


def _one_too_many(expected: dict, yours: dict) -> tuple[str, str]:
    """A node where the tree should end, and a hint; two empty texts where there is none."""
    extra = next((way for way in yours if way not in expected), None)
    if extra is None:
        return "", ""
    for way, node in expected.items():
        if _same_point(yours[extra][0], node):
            says = f"{_name(node)} stands {_place(way, expected)} and once more "
            return f"{says}{_place(extra, expected)}.", "" if way else (
                "A point that has become the root is done: `return` before the walk begins."
            )
    return f"a node stands {_place(extra, expected)}, where the tree should end.", ""


def _place(way: str, expected: dict[str, _Node]) -> str:
    if not way:
        return "at the root"
    return f"to the {_SIDES[way[-1]]} of {_name(expected[way[:-1]])}"


def _name(node: _Node) -> str:
    return f"point {node.index} {_exactly(node.point)}"


def _exactly(point: Sequence[float]) -> str:
    """A point of any length, with all the digits that it was written with."""
    return "(" + ", ".join(f"{float(value):g}" for value in np.ravel(point)) + ")"


def _few(points: ArrayLike) -> str | None:
    """Points in their order, where they are few enough to read."""
    if len(points) > 7:
        return None
    several = len(points) > 1
    text = ", ".join(map(_exactly, points))
    return f"points {text} in this order" if several else f"point {text}"


def _two_trees(tree: object, expected: _Node | None) -> Callable:
    def draw() -> None:
        import matplotlib.pyplot as plt

        _, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
        utils.plots.kd_tree(tree.root, title="yours", axes=left)
        utils.plots.kd_tree(expected, title="expected", axes=right)

    return draw


# ----------------------------------------------------------------------- what a search must find


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
        raise WrongForm(
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
    where = dict(zip(indices, points, strict=True))
    expected = {index for index in where if math.dist(where[index], target) <= tolerance}
    yours = set(as_indices(tree.search(copy.copy(target), tolerance)))
    if yours == expected:
        return
    missing, extra = sorted(expected - yours), sorted(yours - expected)
    unknown = [index for index in extra if index not in where]
    parts = []
    if missing:
        parts.append(f"Not found: {_first(missing, where, target)}")
    if unknown:
        parts.append(f"Found: index {unknown[0]}, which the tree does not hold")
    elif extra:
        parts.append(f"Found, but farther than {tolerance:g}: {_first(extra, where, target)}")
    raise CheckFailed(
        f"{'. '.join(parts)}.",
        given=f"target {_exactly(target)}, tolerance {tolerance:g}",
        yours=_indices(yours),
        expected=_indices(expected),
        draw=_drawn(root, target, tolerance, yours & set(where), "What your search found"),
    )


def _first(indices: list[int], where: dict[int, list[float]], target: Sequence[float]) -> str:
    one = indices[0]
    text = f"{len(indices)} points, for example point " if len(indices) > 1 else "point "
    return f"{text}{one} at {_exactly(where[one])}, {math.dist(where[one], target):.3g} away"


def _indices(found: set[int]) -> str:
    return f"{sorted(found)}" if len(found) <= 8 else f"{len(found)} indices"


def _drawn(
    root: _Node | None, target: Sequence[float], tolerance: float, found: set[int], title: str
) -> Callable | None:
    """Draw a search in the plane; in space and without points there is nothing to draw."""
    if root is None or len(target) != 2:
        return None
    points, _, _, indices = table_of(root)
    rows = {index: row for row, index in enumerate(sorted(indices))}
    reach = [np.subtract(target, tolerance), np.add(target, tolerance)]
    corners = np.vstack([*points, *reach])
    pad = 0.08 * np.ptp(corners, axis=0).max()
    limits = np.column_stack([corners.min(axis=0) - pad, corners.max(axis=0) + pad])
    return lambda: utils.plots.kd_search(
        np.array(points)[np.argsort(indices)],
        root,
        target,
        tolerance,
        found=[rows[index] for index in found],
        title=title,
        limits=limits,
    )


def assert_pruned(
    KdTree: Callable,
    root: _Node,
    target: Sequence[float],
    tolerance: float,
    trap: int,
    decoy: int,
    place: Sequence[float],
    as_given: bool = False,
) -> None:
    """A search leaves a region alone that cannot hold a neighbour, and follows the splits.

    Two leaves are moved to where no right tree has them. What else is found is not looked at.

    Parameters
    ----------
    KdTree : callable
    root : node
        A right tree.
    target : sequence of float
    tolerance : float
    trap : int
        Index of a leaf in a region beyond the tolerance. It is moved to the target: only a search
        that looks into the region finds it.
    decoy : int
        Index of the leaf in whose region the target lies. Every search that goes by the splits
        comes to it; whoever sorts out nodes in wrong places, to compare with the others, does not.
    place : sequence of float
        Where it is moved: within the tolerance, and beyond a split.
    as_given : bool
        Whether the class must be the lesson's, which plants; in a notebook it may be another.
    """
    if not _method(KdTree(), "plant"):
        if as_given:
            raise CheckFailed("KdTree cannot plant a tree: leave the class as the lesson gives it.")
        # Inserted, the nodes would stand where they may be found.
        assert_found(planted(KdTree, root), root, target, tolerance)
        return
    points, left, right, indices = table_of(root)
    rows = indices.index(trap), indices.index(decoy)
    assert all(left[row] == right[row] == -1 for row in rows)
    assert math.dist(place, target) < tolerance
    points = np.array(points)
    points[rows, :] = target, place
    tree = KdTree()
    tree.plant(points, left, right, indices)
    answer = as_indices(tree.search(copy.copy(target), tolerance))
    if trap in answer:
        raise CheckFailed(
            "search looked into a region that lies entirely beyond the tolerance.",
            given=f"target {_exactly(target)}, tolerance {tolerance:g}",
            yours=f"asks node {trap}",
            expected="leaves its whole region out",
            draw=_drawn(root, target, tolerance, {trap}, f"Node {trap} is beyond the box"),
        )
    if decoy not in answer:
        raise CheckFailed(
            "A node was left out that a search meets when it goes by the splits, on the target's "
            "own side of each.",
            hint="The splits alone decide where to go: no other test may leave nodes out.",
        )


def regions_of(root: _Node) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The region that each node of a right tree falls into.

    Parameters
    ----------
    root : node

    Returns
    -------
    dict of int to tuple of numpy.ndarray
        By index: its lowest and its highest corner, both (k,), in part infinite.
    """
    places = places_of(root)
    regions = {}
    for way, node in places.items():
        low, high = np.full((2, len(node.point)), [[-np.inf], [np.inf]])
        for depth, letter in enumerate(way):
            axis, split = depth % len(low), places[way[:depth]].point[depth % len(low)]
            if letter == "l":
                high[axis] = min(high[axis], split)
            else:
                low[axis] = max(low[axis], split)
        regions[node.index] = (low, high)
    return regions


def nested(
    rng: np.random.Generator,
    sizes: Sequence[float],
    k: int,
    allowed: Callable[[np.ndarray], bool],
    lowest: float = -1.5,
) -> np.ndarray:
    """Points about the origin, in an order in which each cuts off what lies beyond it.

    Inserted so they make a tree without branches: the origin, and all who follow, lie to the left
    of each. Whoever searches around the origin on one side alone finds all.

    Parameters
    ----------
    rng : numpy.random.Generator
    sizes : sequence of float
        How far from the origin each cuts, descending.
    k : {2, 3}
    allowed : callable
        Takes a point, shape (k,): whether it may be one.
    lowest : float
        The smallest coordinate of a point, in sizes of its own.

    Returns
    -------
    numpy.ndarray, shape (len(sizes), k)
    """
    points = []
    while len(points) < len(sizes):
        size = sizes[len(points)]
        point = rng.uniform(lowest * size, size, k).round(3)
        point[len(points) % k] = round(size, 3)
        if allowed(point):
            points.append(point)
    return np.array(points)


def off_the_corners(points: np.ndarray) -> np.ndarray:
    """Clear of the unit circle's rim, and not in a corner of the square around it."""
    far = np.linalg.norm(points, axis=-1)
    return (far < 0.99) | (np.abs(points).max(axis=-1) > 1.01)


def off_the_rim(point: np.ndarray) -> bool:
    """Clear of the unit circle's rim."""
    return abs(np.linalg.norm(point) - 1) > 0.02 and abs(np.abs(point).max() - 1) > 0.01


# -------------------------------------------------------------------------- what an order must be


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
        raise WrongForm(
            "The order is a flat list of row numbers (whole numbers), not of points.",
            yours=brief(order),
            expected=f"the numbers 0 to {n - 1}",
        )
    strange = [row for row in order.tolist() if not 0 <= row < n]
    missing = [row for row in range(n) if row not in set(order.tolist())]
    if strange or missing or len(order) != n:
        odd = f"{strange[0]} is no row number" if strange else "some rows are there more than once"
        text = f"row {missing[0]} is missing" if missing else odd
        raise CheckFailed(
            f"Each row number from 0 to n - 1 must occur exactly once; {text}.",
            yours=brief(order),
            expected=f"each of 0 to {n - 1}" if n > 1 else "[0]" if n else "[]",
        )
    return order


def _order_of(answer: object, points: np.ndarray) -> np.ndarray:
    with needs("each row is named exactly once"):
        return as_order(answer, len(points))


def assert_shallow(answer: object, points: np.ndarray) -> None:
    """Inserting points in this order gives a tree of the least depth.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    root = grown(points[order], order.tolist())
    depth, least = max(map(len, places_of(root)), default=-1) + 1, len(points).bit_length()
    if depth > least:
        raise CheckFailed(
            f"Inserted in this order, {len(points)} points give a tree of depth "
            f"{depth}; medians give {least}.",
            given=_few(points),
            yours=f"depth {depth}",
            expected=f"depth {least}",
            draw=_tree_of(order, points),
        )


def assert_lower_medians(answer: object, points: np.ndarray) -> None:
    """In every part of the tree the lower median along its axis stands on top.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    odd = next(_not_on_top(points, order), None)
    if odd is None:
        return
    values, depth, axis, median = odd
    letter = "xyz"[axis]
    first = "The first point of the order"
    if depth:
        first = f"In a part at depth {depth}, the point that comes first"
    raise CheckFailed(
        f"{first} is not the {'lower ' * (len(values) % 2 == 0)}median of the {len(values)} points "
        f"along {letter}.",
        given=f"{letter} of these points, sorted: {_values(np.sort(values))}",
        yours=f"{letter} = {values[0]:g}",
        expected=f"{letter} = {median:g}",
        draw=_tree_of(order, points),
    )


def _not_on_top(
    points: np.ndarray,
    order: np.ndarray,
    axis_at: Callable[[int, int], int] = _in_turn,
    place: Callable[[int], int] = lambda m: (m - 1) // 2,
) -> Iterator[tuple]:
    """Each part whose first point is not the one at a place (of how many) along an axis.

    As its coordinates along the axis in the order of the rows, depth, axis, and the coordinate
    that should come first.
    """
    waiting = [(order, 0)] if len(order) else []
    for rows, depth in waiting:  # grows while it is walked
        axis = axis_at(depth, points.shape[1])
        values = np.asarray(points, dtype=float)[rows, axis]
        wanted = np.sort(values)[place(len(values))]
        if values[0] != wanted:
            yield values, depth, axis, wanted
        smaller = values[1:] < values[0]
        waiting += [
            (part, depth + 1) for part in (rows[1:][smaller], rows[1:][~smaller]) if len(part)
        ]


# The right turns, and others that leave halves as they are.
_TURNS = (
    _in_turn,
    lambda depth, k: 0,
    lambda depth, k: 1,
    lambda depth, k: (depth + 1) % k,
    lambda depth, k: depth % 2,
)


def assert_halves(answer: object, points: np.ndarray) -> None:
    """The lower median is on top of every part, if perhaps along other axes than it should be.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2) or (n, 3)
    """
    order = _order_of(answer, points)
    if all(next(_not_on_top(points, order, turns), None) for turns in _TURNS):
        assert_lower_medians(order, points)


def _values(values: np.ndarray) -> str:
    return ", ".join(f"{value:g}" for value in values[:8]) + ", ..." * (len(values) > 8)


def _tree_of(order: np.ndarray, points: np.ndarray) -> Callable:
    root = grown(points[order], order.tolist())
    return lambda: utils.plots.kd_tree(root, title="The tree of your order")


def distinct(rng: np.random.Generator, n: int, k: int) -> np.ndarray:
    """Points of which no two share a coordinate, in random order.

    Parameters
    ----------
    rng : numpy.random.Generator
    n, k : int

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return (np.stack([rng.permutation(4 * n)[:n] for _ in range(k)], axis=1) - 2 * n) / 16 + 0.01


def along_the_diagonal(values: ArrayLike, k: int = 2) -> np.ndarray:
    """Points with equal coordinates: whichever is compared, the tree is the same.

    Parameters
    ----------
    values : array_like, shape (n,)
    k : {2, 3}

    Returns
    -------
    numpy.ndarray, shape (n, k)
    """
    return np.repeat(np.array(values, dtype=float)[:, None], k, axis=1)


# ---------------------------------------------------------------------------------- insert

# Where x decides at the root, and y would decide otherwise.
_SIDEWAYS = frozen(np.array([[5.0, 5.0], [2.0, 8.0], [8.0, 3.0]]))
# Two levels more. Whoever compares x again on the second puts the last ones elsewhere.
_TWO_TURNS = frozen(
    np.array([[5.0, 5.0], [2.0, 6.0], [8.0, 4.0], [1.0, 7.0], [3.0, 1.0], [7.0, 9.0], [9.0, 2.0]])
)
_DIAGONAL = frozen(along_the_diagonal([4, 2, 6, 1, 3, 5, 7]))


def _inserted(KdTree: Callable, points: ArrayLike, indices: Sequence[int] | None = None) -> object:
    assert_root(KdTree)
    tree = KdTree()
    indices = indices or range(len(points))
    call_each(tree.insert, zip(np.array(points), indices, strict=True))
    return tree


@once
def assert_root(KdTree: Callable) -> None:
    """The first point becomes the root; where not, a walk down the tree may never end.

    Parameters
    ----------
    KdTree : callable
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
        assert_tree(_inserted(KdTree, _TWO_TURNS), _TWO_TURNS)


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
    weight=3,
    title="At the root, smaller x goes left and greater x right",
    why="A search trusts this order when it leaves half of the street out.",
    hint="The root has depth 0, and number 0 of a point is x.",
)
def compares_x_first(KdTree: Callable) -> None:
    assert_tree(_inserted(KdTree, _SIDEWAYS), _SIDEWAYS)


@visible(
    "insert",
    weight=3,
    title="One level below the root, y decides",
    why="Cuts along x alone are strips, and a strip crosses the whole street.",
    hint="Compare only one coordinate at each node: number depth % len(point), with depth 0 "
    "at the root and one more at each step down.",
)
def axes_alternate(KdTree: Callable) -> None:
    _assert_sides(KdTree)
    assert_tree(_inserted(KdTree, _TWO_TURNS), _TWO_TURNS)


@visible(
    "insert",
    weight=3,
    title="Grows a tree of ten points, eight levels deep",
    why="Every node must end up in the one place where a search will look for it.",
    hint="Follow the point that is named, with a pencil: which coordinate is compared at each "
    "node, and where is the first free place?",
)
def grows_the_quiz(KdTree: Callable) -> None:
    _assert_turns(KdTree)
    # Without point 6, which has a coordinate of another one: what happens then is asked below.
    rows = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10]
    assert_tree(_inserted(KdTree, QUIZ[rows], rows), QUIZ[rows], rows)


@visible(
    "insert",
    weight=2,
    title="Equal goes right",
    why="Walls and kerbs have many points with the very same coordinate. They need one rule, "
    "and search relies on the same one.",
    hint="Only strictly smaller (<) goes left; everything else goes right.",
)
def equal_goes_right(KdTree: Callable) -> None:
    points = along_the_diagonal([4, 4, 2, 2, 6, 4])
    assert_tree(_inserted(KdTree, points), points)


@visible(
    "insert",
    weight=2,
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
    weight=1,
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
    assert_root(KdTree)
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
    assert_root(KdTree)
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
    assert_root(KdTree)
    tree = KdTree()
    for index, point in enumerate(_DIAGONAL.copy()):
        assert_left_alone(observe(tree.insert, point, index), point, index)
    with needs("every point is where it belongs"):
        assert_tree(tree, _DIAGONAL, either_way=True)


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
    _assert_sides(KdTree)
    tree = planted(KdTree, _chain(1200), as_lists=True)
    try:
        tree.insert(np.array([1200.0, 1200.0]), 1200)
    except Exception as error:
        if "RecursionError" not in _names_of(error):
            raise
        raise CheckFailed(
            "The tree has 1200 levels, and a function called itself for each of them until Python "
            "stopped it (RecursionError)."
        ) from None
    try:
        last = reach(tree, ["root", *["right"] * 1200])
    except Exception as error:
        if "AttributeError" not in _names_of(error):
            raise
        last = None  # the way ends before
    if last is None:
        raise CheckFailed(
            "A point that belongs below the last of 1200 levels is not there.",
            hint="Begin at tree.root, and walk until there is no child.",
        )


def _chain(count: int) -> _Node:
    """A tree of points that arrived in sorted order; no node has a left child."""
    root = last = _Node([0.0, 0.0], 0)
    for row in range(1, count):
        last.right = last = _Node([float(row), float(row)], row)
    return root


def _ways_in(KdTree: Callable, points: np.ndarray) -> dict[str, object]:
    """Index by the way to a node, in a student's tree."""
    tree = KdTree()
    for index, point in enumerate(points):
        tree.insert(point, index)
        if index == 0 and tree.root is not None:
            assert_tree(tree, points[:1])  # below itself, there would be no end
    found, waiting = {}, [("", tree.root)]
    for way, node in waiting:  # grows while it is walked
        if node is not None and len(found) < _MOST_NODES:
            found[way] = node.index
            waiting += [(way + "l", node.left), (way + "r", node.right)]
    return found


def _ways(points: np.ndarray, **rule: Callable) -> dict[str, int]:
    return {way: node.index for way, node in places_of(grown(points, **rule)).items()}


def _below_the_root(right: dict[str, int], points: np.ndarray) -> dict[str, int]:
    """As if each point took the place of a child of the root."""
    sides = {"l" if x < points[0, 0] else "r": row for row, x in enumerate(points[:, 0]) if row}
    return {**sides, "": 0}


mistakes(
    "insert",
    Mistake(
        "x is compared at every level: the axis does not change on the way down.",
        lambda right, points: _ways(points, axis_at=lambda depth, k: 0),
        "The axis is depth % len(point), and depth grows by 1 at each step down.",
    ),
    Mistake(
        "The turns begin with y: the root is treated as if it had depth 1.",
        lambda right, points: _ways(points, axis_at=lambda depth, k: (depth + 1) % k),
        "The root has depth 0.",
    ),
    Mistake(
        "x and y take turns and z is never compared: 2 is written where len(point) is needed.",
        lambda right, points: _ways(points, axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "`<=` stands where `<` is asked for: an equal coordinate goes left.",
        lambda right, points: _ways(points, goes_left=operator.le),
        "Only strictly smaller goes left.",
    ),
    Mistake(
        "The sides are swapped: greater goes left, and smaller or equal right.",
        lambda right, points: _ways(points, goes_left=operator.gt),
    ),
    Mistake(
        "The sides are swapped: greater or equal goes left, and smaller right.",
        lambda right, points: _ways(points, goes_left=operator.ge),
    ),
    Mistake(
        "Each point is hung below the root, in the place of the one that hung there before.",
        _below_the_root,
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
    right=_ways,
    same=operator.eq,
    ask=_ways_in,
    through="KdTree",
)


# ---------------------------------------------------------------------------------- search

# How far from the target each node cuts: from a tree far larger than the circle down to a tenth.
_FROM_AFAR = frozen(np.concatenate([np.geomspace(8, 1.2, 15), np.geomspace(0.9, 0.1, 12)]))
# Any two of them are a quarter of a metre apart along x, and along y.
_SPREAD = frozen(4 * distinct(np.random.default_rng(46), 11, 2))


def _balanced() -> _Node:
    return grown(QUIZ[list(_BALANCED)], _BALANCED)


@once
def _assert_at_target(KdTree: Callable) -> None:
    with needs("the point at the target is found"):
        finds_the_target(KdTree)


@visible(
    "search",
    weight=3,
    title="Finds the point at the target, wherever in the tree it stands",
    why="What is near? Clustering asks that a hundred thousand times per scan.",
    hint="At each node do two things: compare the distance of its point with the tolerance, "
    "and decide for each side whether to go on there.",
)
def finds_the_target(KdTree: Callable) -> None:
    root = grown(_SPREAD)
    tree = planted(KdTree, root)
    for point in _SPREAD:
        assert_found(tree, root, point + [0.03, -0.02], 0.1)


@visible(
    "search",
    weight=5,
    title="Looks on both sides where the circle crosses the split",
    why="A pedestrian may stand exactly where the tree was cut in two. A search of "
    "the target's own side alone sees half of them.",
    hint="Left and right are two separate questions (two ifs, no else): does the box reach "
    "below the split? Does it reach the split or beyond it?",
)
def looks_on_both_sides(KdTree: Callable) -> None:
    # The root is far away, and its cut goes between two neighbours.
    root = grown([[0.0, 3.0], [-0.5, 0.0], [0.5, 0.1]])
    for x in (0.1, -0.1):
        assert_found(planted(KdTree, root), root, np.array([x, 0.0]), 1.0)
    for target, tolerance in (([-6.0, 7.0], 3.0), ([-6.5, 7.5], 2.5)):
        assert_found(planted(KdTree, _balanced()), _balanced(), np.array(target), tolerance)


@visible(
    "search",
    weight=3,
    title="Measures a circle, not a square",
    why="The corner of a box is 1.4 times as far away as its side (1.7 times in space): "
    "points that are not neighbours join two obstacles into one.",
    hint="The box only decides where to look. A point counts when its distance, the square "
    "root of the sum of squares, is at most tolerance.",
)
def measures_a_circle(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    points = nested(np.random.default_rng(3), np.geomspace(0.96, 0.5, 8), 2, off_the_rim, -1)
    root = grown(points)
    assert_found(planted(KdTree, root), root, np.zeros(2), 1.0)


@visible(
    "search",
    weight=3,
    title="The tolerance is the radius itself, whether small or large",
    why="Half a metre for a pedestrian, five metres for a lorry: a distance is compared with a "
    "distance.",
    hint="The sum of squares is not yet the distance: take its root, or math.dist.",
)
def takes_the_radius(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    points = nested(
        np.random.default_rng(4), [2.2, 1.6, 1.3, 0.9, 0.8, 0.7, 0.6, 0.3], 2, off_the_corners, -1
    )
    for tolerance in (0.3, 1.0, 3.0):
        root = grown(points * tolerance)
        assert_found(planted(KdTree, root), root, np.zeros(2), tolerance)


@visible(
    "search",
    weight=2,
    title="A point at exactly the tolerance is found",
    why="Within means up to and including.",
    hint="Compare the distance with <=.",
)
def includes_the_border(KdTree: Callable) -> None:
    points = np.array([[0.0, 2.0], [1.0, 1.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grown(points)
    assert_found(planted(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


@visible(
    "search",
    weight=2,
    title="Goes right also where the box ends exactly at the split",
    why="A point with the coordinate of the split itself stands on the right. The search of a "
    "well-known course loses it, and only in some directions.",
    hint="Go right when target[axis] + tolerance >= split, with the equals sign.",
)
def reaches_the_split(KdTree: Callable) -> None:
    with needs("a point at exactly the tolerance is found"):
        includes_the_border(KdTree)
    with needs("both sides are searched where the circle crosses the split"):
        looks_on_both_sides(KdTree)
    points = np.array([[2.0, 9.0], [-3.0, 3.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grown(points)
    assert_found(planted(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


@visible(
    "search",
    weight=2,
    title="Takes three coordinates",
    why="Scans are three-dimensional: the axes go x, y, z, x, y, z, ... down the tree.",
    hint="The axis is depth % len(target), as in insert.",
)
def searches_space(KdTree: Callable) -> None:
    points = nested(np.random.default_rng(5), _FROM_AFAR, 3, off_the_corners)
    root = grown(points)
    assert_found(planted(KdTree, root), root, np.zeros(3), 1.0)


@visible(
    "search",
    weight=8,
    title="Leaves regions out that cannot hold a neighbour",
    why="This is what a tree is for. A search that looks at every node is a slow way of "
    "comparing with all.",
    hint="Before you go on to a child, compare the split, node.point[axis], with the ends of "
    "the box, target[axis] - tolerance and target[axis] + tolerance.",
)
def leaves_regions_out(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    for target, decoy, place, traps in (
        ([-0.3, 9.0], 2, [0.5, 9.0], (9, 10)),
        ([-2.0, 6.5], 9, [-2.0, 7.3], (6, 10)),
    ):
        for trap in traps:
            assert_pruned(KdTree, _balanced(), np.array(target), 1.0, trap, decoy, place)


@visible(
    "search",
    weight=1,
    title="Takes an empty tree, and finds nothing where nothing is",
    why="After filtering, a scan may hold no point at all.",
    hint="With root None the answer is an empty list. With a list of places still to visit, "
    "skip those that are None.",
)
def takes_an_empty_tree(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    assert_found(planted(KdTree, None), None, np.zeros(2), 1.0)
    root = grown([[1.0, 2.0]])
    assert_found(planted(KdTree, root), root, np.array([1.1, 2.0]), 0.5)
    assert_found(planted(KdTree, root), root, np.array([5.0, 5.0]), 1.0)


@visible(
    "search",
    weight=1,
    title="Names each point once",
    why="Where neighbours are counted, a point that is named twice counts twice.",
    hint="Note the index at one place only: when you come to its node.",
)
def names_each_once(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    yours = as_indices(planted(KdTree, _balanced()).search(np.array([-6.0, 7.0]), 3.0))
    twice = sorted({index for index in yours if yours.count(index) > 1})
    if twice:
        raise CheckFailed(
            f"Index {twice[0]} is there {yours.count(twice[0])} times.",
            given="target (-6, 7), tolerance 3",
            yours=_listed(yours),
            expected="each index once",
        )


def _listed(indices: list[int]) -> str:
    return f"{indices}" if len(indices) <= 12 else f"{len(indices)} indices"


@visible(
    "search",
    weight=1,
    title="Takes targets and points as lists, tuples and arrays",
    why="Later cells grow trees of lists, where Python's own numbers are quicker.",
    hint="math.dist(p, q) serves every kind; p - q wants arrays: np.asarray(p) - q.",
)
def takes_any_target(KdTree: Callable) -> None:
    root = grown(
        nested(np.random.default_rng(6), [3.0, 2.0, 0.8, 0.5, 0.3], 2, off_the_corners, -1)
    )
    for as_lists, target in ((True, [0.0, 0.0]), (True, np.zeros(2)), (False, (0.0, 0.0))):
        assert_found(planted(KdTree, root, as_lists), root, target, 1.0)


@visible(
    "search",
    weight=1,
    title="Leaves the tree and the target as they are",
    why="The same tree is asked again and again, and the target is a row of the cloud.",
    hint="Look, and write nothing: neither to a node nor to the target.",
)
def leaves_the_tree(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    order = list(_BALANCED)
    tree = planted(KdTree, _balanced())
    assert_untouched(tree.search, np.array([-6.0, 7.0]), 3.0)
    assert_same_tree(tree, QUIZ[order], order)


def assert_same_tree(tree: object, points: np.ndarray, indices: list[int]) -> None:
    """A search left a tree as it was.

    Parameters
    ----------
    tree : object
    points, indices
        As for `grown`.
    """
    try:
        assert_tree(tree, points, indices)
        assert_indices(tree, points, indices)
    except CheckFailed as error:
        raise CheckFailed(
            f"The tree is another one after the search. {error.message}", draw=error.draw
        ) from None


@noted(
    "search",
    title="Copes with a tree of a thousand levels",
    why="The last part of this lesson searches the tree of a sorted wall. A function that calls "
    "itself ends there in a RecursionError; a list of places that wait does not.",
)
def searches_deep_trees(KdTree: Callable) -> None:
    root = _chain(1200)
    assert_found(planted(KdTree, root), root, np.array([1199.0, 1199.0]), 0.5)


class _Split(NamedTuple):
    """A node on the way to another one, as a search sees it.

    low, at and high are where the box begins, where the target is and where the box ends along
    the axis of the split; is_left is the side of the other one.
    """

    low: float
    at: float
    high: float
    split: float
    is_near: bool
    is_left: bool


def _entered(
    points: np.ndarray,
    target: np.ndarray,
    tolerance: float,
    rule: Callable[[_Split], bool],
    axis_at: Callable[[int, int], int] = _in_turn,
) -> set[int]:
    """Indices of the nodes to which a rule lets a search come, whatever it thinks of them."""
    places = places_of(grown(points))

    def passes(way: str, depth: int) -> bool:
        node, axis = places[way[:depth]], axis_at(depth, len(target))
        at, is_near = target[axis], math.dist(node.point, target) <= tolerance
        ends = at - tolerance, at, at + tolerance
        return rule(_Split(*ends, node.point[axis], is_near, way[depth] == "l"))

    return {
        places[way].index for way in places if all(passes(way, depth) for depth in range(len(way)))
    }


def _reached(one: _Split) -> bool:
    """Whether the box lies on that side, or in part."""
    return one.low < one.split if one.is_left else one.high >= one.split


def _limited(rule: Callable, axis_at: Callable = _in_turn) -> Callable:
    """What is found of the right points where the search goes by a rule of its own."""
    return lambda right, points, target, tolerance: (
        right & _entered(points, target, tolerance, rule, axis_at)
    )


def _measured(is_near: Callable) -> Callable:
    """What is found where nearness is another: of a step (k,), the tolerance and the depth."""

    def predict(right: set, points: np.ndarray, target: np.ndarray, tolerance: float) -> set:
        depths = {node.index: len(way) for way, node in places_of(grown(points)).items()}
        return {
            index
            for index in _entered(points, target, tolerance, _reached)
            if is_near(np.abs(points[index] - target), tolerance, depths[index])
        }

    return predict


def _same_indices(answer: object, predicted: set[int]) -> bool:
    try:
        return set(as_indices(answer)) == predicted
    except CheckFailed:
        return False


def _scattered(seed: int, k: int) -> np.ndarray:
    """Points with whole-numbered coordinates, many of them equal and many on the rim."""
    return np.random.default_rng(seed).integers(-3, 4, (24, k)).astype(float)


mistakes(
    "search",
    Mistake(
        "Only the side on which the target itself lies is searched.",
        _limited(lambda one: (one.at < one.split) == one.is_left),
        "Where the circle crosses the split, both sides must be: two ifs, no else.",
    ),
    Mistake(
        "The right side is searched only where the left one is not: `else` or `elif` parts two "
        "questions that both have to be asked, or a `return` ends all at the first empty place.",
        _limited(lambda one: (one.low < one.split) == one.is_left),
        "Write two ifs, one for each child. Where no node is, take the next place.",
    ),
    Mistake(
        "The left side is searched only where the right one is not: `else` or `elif` parts two "
        "questions that both have to be asked, or a `return` ends all at the first empty place.",
        _limited(lambda one: (one.high >= one.split) != one.is_left),
        "Write two ifs, one for each child. Where no node is, take the next place.",
    ),
    Mistake(
        "The ends of the box are swapped: plus stands where minus is asked for, so that a side is "
        "searched only where the whole box lies on it.",
        _limited(lambda one: one.high < one.split if one.is_left else one.low >= one.split),
        "The box begins at target[axis] - tolerance, which decides about the left child; it ends "
        "at target[axis] + tolerance.",
    ),
    Mistake(
        "The sides are swapped: what decides about the left child is asked for the right one, and "
        "the other way round.",
        _limited(lambda one: _reached(one._replace(is_left=not one.is_left))),
        "Smaller coordinates stand on the left: go there when the box begins below the split.",
    ),
    Mistake(
        "`>` stands where `>=` is asked for: where the box ends exactly at the split, the right "
        "side is left out.",
        _limited(lambda one: _reached(one) and (one.is_left or one.high > one.split)),
        "What stands at the split itself stands on the right.",
    ),
    Mistake(
        "Both sides are searched below nodes that are near, and only the target's own side below "
        "all others.",
        _limited(lambda one: one.is_near or (one.at < one.split) == one.is_left),
        "Whether the node is near says nothing about its sides: ask whether the box reaches them.",
    ),
    Mistake(
        "The search ends at each node that is not near: nothing below it is looked at.",
        _limited(lambda one: one.is_near and _reached(one)),
        "A node may be far and have neighbours of the target below it: ask about its sides in any "
        "case.",
    ),
    Mistake(
        "The tolerance is left out on the left: only what the target itself is below is searched.",
        _limited(lambda one: _reached(one) and (not one.is_left or one.at < one.split)),
        "The box begins at target[axis] - tolerance.",
    ),
    Mistake(
        "The tolerance is left out on the right: only what the target itself is beyond is "
        "searched.",
        _limited(lambda one: _reached(one) and (one.is_left or one.at >= one.split)),
        "The box ends at target[axis] + tolerance.",
    ),
    Mistake(
        "x and y take turns and z is never compared: 2 is written where len(target) is needed.",
        _limited(_reached, lambda depth, k: depth % 2),
    ),
    Mistake(
        "x is compared at every level: the axis does not change on the way down.",
        _limited(_reached, lambda depth, k: 0),
        "The axis is depth % len(target), and a child waits with depth + 1.",
    ),
    Mistake(
        "The turns begin with y: the root is treated as if it had depth 1.",
        _limited(_reached, lambda depth, k: (depth + 1) % k),
        "The root has depth 0.",
    ),
    Mistake(
        "`<` stands where `<=` is asked for: a point at exactly the tolerance is not found.",
        _measured(lambda step, tolerance, depth: np.linalg.norm(step) < tolerance),
    ),
    Mistake(
        "The box decides, not the circle: points in its corners are found, too.",
        _measured(lambda step, tolerance, depth: step.max() <= tolerance),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "The square of the distance is compared with the tolerance itself.",
        _measured(lambda step, tolerance, depth: step @ step <= tolerance),
        "Take the square root of the sum of squares, or math.dist.",
    ),
    Mistake(
        "One coordinate decides whether a point is near, the one that its node cuts.",
        _measured(lambda step, tolerance, depth: step[depth % len(step)] <= tolerance),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "Every node that the search comes to is found, whatever its distance.",
        _measured(lambda step, tolerance, depth: True),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    cases=(
        (_scattered(13, 2), np.zeros(2), 2.0),
        (_scattered(12, 2), np.zeros(2), 3.0),
        (_scattered(13, 3), np.zeros(3), 2.0),
        (_scattered(52, 3), np.zeros(3), 3.0),
        (_scattered(49, 2), np.full(2, 2.0), 1.0),
    ),
    right=lambda points, target, tolerance: {
        index for index, point in enumerate(points) if math.dist(point, target) <= tolerance
    },
    same=_same_indices,
    ask=lambda KdTree, points, target, tolerance: planted(KdTree, grown(points)).search(
        target, tolerance
    ),
    through="KdTree",
)


# ---------------------------------------------------------------------------- median_order

# Of 7 and 15 points every part has one in the middle.
_SEVEN = frozen(distinct(np.random.default_rng(51), 7, 2))


@once
def _assert_medians(median_order: Callable) -> None:
    with needs("the median of x, then of y comes first in every part"):
        assert_lower_medians(median_order(_SEVEN.copy()), _SEVEN)


@once
def _assert_halves(median_order: Callable) -> None:
    with needs("the median comes first in every part"):
        assert_halves(median_order(_SEVEN.copy()), _SEVEN)


@visible(
    "median_order",
    weight=2,
    title="Names every row exactly once",
    why="A point that is left out is an obstacle that no search will find.",
    hint="np.argsort of a part gives places within the part: rows[np.argsort(...)] leads back to "
    "row numbers. The median goes into the order, and into neither of the two parts that wait.",
)
def names_every_row(median_order: Callable) -> None:
    for points in (QUIZ[:5], _SEVEN):
        as_order(median_order(points.copy()), len(points))


@visible(
    "median_order",
    weight=3,
    title="Starts with the median along x",
    why="Only a median halves: any other first point leaves more on one side.",
    hint="Sort the rows by x. Of m rows, the one in the middle stands at place (m - 1) // 2.",
)
def starts_with_the_median(median_order: Callable) -> None:
    for points in (QUIZ[[5, 0, 8]], QUIZ[:3], QUIZ[[6, 9, 1, 7, 3]], _SEVEN):
        order = _order_of(median_order(points.copy()), points)
        x, median = points[order[0], 0], np.median(points[:, 0])
        if x != median:
            raise CheckFailed(
                "The first point of the order is not the median along x.",
                given=f"x of the {len(points)} points, sorted: {_values(np.sort(points[:, 0]))}",
                yours=f"x = {x:g}",
                expected=f"x = {median:g}",
            )


@visible(
    "median_order",
    weight=4,
    title="The median comes first in every part, before both halves",
    why="One bad split near the root doubles the work of every search below it.",
    hint="A part gives its median to the order and two parts that wait: the rows before it and "
    "the rows after it.",
)
def halves_every_part(median_order: Callable) -> None:
    rng = np.random.default_rng(47)
    for n in (3, 7, 15):
        points = distinct(rng, n, 2)
        assert_halves(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=3,
    title="The median is that of x at first, then of y, then of x again",
    why="insert compares x and y in turn. A median of the other one halves nothing.",
    hint="The parts of one level are sorted along another axis: depth % points.shape[1].",
)
def takes_turns(median_order: Callable) -> None:
    _assert_halves(median_order)
    rng = np.random.default_rng(42)
    for n in (3, 7, 15):
        points = distinct(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=2,
    title="Of two in the middle, the lower one comes first",
    why="The same points should make the same tree for everyone.",
    hint="Of m sorted rows the lower median stands at place (m - 1) // 2; m // 2 is the upper "
    "one when m is even.",
)
def takes_the_lower(median_order: Callable) -> None:
    _assert_medians(median_order)
    rng = np.random.default_rng(43)
    for n in (2, 4, 6):
        points = distinct(rng, n, 2)
        assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=2,
    title="Takes points with three coordinates: x, y, z and x again",
    why="A street is three-dimensional.",
    hint="Count the coordinates with points.shape[1] and do not write 2 into the function.",
)
def takes_three_axes(median_order: Callable) -> None:
    _assert_medians(median_order)
    points = distinct(np.random.default_rng(44), 31, 3)
    assert_lower_medians(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=3,
    title="The tree has the least depth possible",
    why="Depth is the price of every insertion and every search: 17 levels for a hundred "
    "thousand points, or a hundred thousand.",
    hint="Print the depth of the tree of your order for 3, 7 and 15 points: it should be 2, 3 "
    "and 4.",
)
def least_depth(median_order: Callable) -> None:
    rng = np.random.default_rng(45)
    for n in (3, 7, 15, 40, 64):
        points = distinct(rng, n, 2)
        assert_shallow(median_order(points.copy()), points)


@visible(
    "median_order",
    weight=1,
    title="Takes no points, and one point",
    why="Filters leave nothing now and then.",
    hint="A part without rows adds nothing to the order.",
)
def takes_the_smallest(median_order: Callable) -> None:
    _assert_halves(median_order)
    as_order(median_order(np.empty((0, 2))), 0)
    as_order(median_order(np.array([[1.0, 2.0, 3.0]])), 1)


@visible(
    "median_order",
    weight=1,
    title="Takes points with equal coordinates",
    why="Recordings hold the same point twice, and walls the same coordinate many times.",
    hint="Part the sorted rows by their place, before and after the median, not by comparing "
    "coordinates.",
)
def takes_equal_points(median_order: Callable) -> None:
    _assert_halves(median_order)
    for points in (np.ones((5, 2)), np.repeat(QUIZ[:4], 3, axis=0)):
        as_order(median_order(points.copy()), len(points))


@visible(
    "median_order",
    weight=1,
    title="Leaves its input untouched",
    why="The order names rows of the cloud as it was: sorting the cloud makes it a lie.",
    hint="Sort row numbers, not points.",
)
def leaves_its_input(median_order: Callable) -> None:
    _assert_halves(median_order)
    assert_untouched(median_order, QUIZ)


def _each_on_top(**rule: Callable) -> Callable:
    """Whether an order has in every part the point on top that a rule names."""
    return lambda *_: lambda points, order: next(_not_on_top(points, order, **rule), None) is None


def _halves_before_and_after(points: np.ndarray, order: np.ndarray) -> bool:
    """Whether the median stands between its two parts, again and again."""
    waiting = [(order, 0)]
    for rows, depth in waiting:  # grows while it is walked
        middle = (len(rows) - 1) // 2
        values = points[rows, depth % points.shape[1]]
        before, after = values[:middle], values[middle + 1 :]
        if not (before < values[middle]).all() or not (after > values[middle]).all():
            return False
        parts = rows[:middle], rows[middle + 1 :]
        waiting += [(part, depth + 1) for part in parts if len(part)]
    return True


mistakes(
    "median_order",
    Mistake(
        "Of two points in the middle, the upper one comes first.",
        _each_on_top(place=lambda m: m // 2),
        "The lower one stands at place (number of rows - 1) // 2.",
    ),
    Mistake(
        "x decides in every part: the axis does not change from level to level.",
        _each_on_top(axis_at=lambda depth, k: 0),
        "The axis is depth % points.shape[1], and a part's parts have depth + 1.",
    ),
    Mistake(
        "The turns begin with y.",
        _each_on_top(axis_at=lambda depth, k: (depth + 1) % k),
        "The first part has depth 0: x.",
    ),
    Mistake(
        "x and y take turns and z is left out: 2 is written where points.shape[1] is needed.",
        _each_on_top(axis_at=lambda depth, k: depth % 2),
    ),
    Mistake(
        "The rows are sorted by x, and that is all.",
        _each_on_top(axis_at=lambda depth, k: 0, place=lambda m: 0),
        "A sorted order makes a tree that is a list. Take the median first, then go on with each "
        "half.",
    ),
    Mistake(
        "The rows are sorted by x, the largest first.",
        _each_on_top(axis_at=lambda depth, k: 0, place=lambda m: m - 1),
        "The median is the one in the middle, not the largest.",
    ),
    Mistake(
        "The rows stay in the order in which they came.",
        lambda *_: lambda points, order: bool((np.diff(order) == 1).all()),
    ),
    Mistake(
        "Each median stands between its two parts; it should come before both.",
        lambda *_: _halves_before_and_after,
        "What comes first is on top: [median] + smaller ones + others.",
    ),
    Mistake(
        "Each median stands after its two parts; it should come before both.",
        lambda *_: lambda points, order: next(_not_on_top(points, order[::-1]), None) is None,
        "What comes first is on top: [median] + smaller ones + others.",
    ),
    cases=tuple(
        (distinct(np.random.default_rng(50), len(order), k), np.array(order))
        for k, order in (
            (2, [5, 0, 1, 4, 3, 2]),
            (3, [7, 0, 2, 9, 4, 6, 3, 8, 10, 1, 5]),
            (3, [2, 0, 1, 3, 10, 11, 5, 7, 9, 8, 4, 6]),
        )
    ),
    right=lambda points, order: (points, order),
    same=lambda answer, predicted: predicted(*answer),
    ask=lambda median_order, points, order: (points, as_order(median_order(points), len(points))),
)
