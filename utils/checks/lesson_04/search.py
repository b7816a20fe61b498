"""Visible checks of `search`, through `KdTree`."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from utils.checks.assertions import CheckFailed, assert_untouched, frozen, needs
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.lesson_04.cases import (
    BALANCED_ORDER,
    QUIZ,
    balanced_tree,
    chain_tree,
    distinct_points,
    is_off_corners,
    is_off_rim,
    nested_points,
)
from utils.checks.lesson_04.search_results import (
    as_indices,
    assert_found,
    assert_pruned,
    assert_same_tree,
)
from utils.checks.lesson_04.trees import build_tree
from utils.checks.run_cache import once
from utils.geometry import SIDES, TreeNode, grown, in_turn, places_of

# Distances from the target at which nodes cut, from 8 times the radius of the circle to a tenth.
_SIZES = frozen(np.concatenate([np.geomspace(8, 1.2, 15), np.geomspace(0.9, 0.1, 12)]))
# Any two of these points are at least a quarter of a metre apart along x and along y.
_SCATTERED_POINTS = frozen(4 * distinct_points(np.random.default_rng(46), 11, 2))


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
    root = grown(_SCATTERED_POINTS)
    tree = build_tree(KdTree, root)
    for point in _SCATTERED_POINTS:
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
    # The root is far from the target, but its cut is between two neighbours of the target.
    root = grown([[0.0, 3.0], [-0.5, 0.0], [0.5, 0.1]])
    for x in (0.1, -0.1):
        assert_found(build_tree(KdTree, root), root, np.array([x, 0.0]), 1.0)
    for target, tolerance in (([-6.0, 7.0], 3.0), ([-6.5, 7.5], 2.5)):
        assert_found(
            build_tree(KdTree, balanced_tree()), balanced_tree(), np.array(target), tolerance
        )


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
    points = nested_points(np.random.default_rng(3), np.geomspace(0.96, 0.5, 8), 2, is_off_rim, -1)
    root = grown(points)
    assert_found(build_tree(KdTree, root), root, np.zeros(2), 1.0)


@visible(
    "search",
    weight=6,
    title="The tolerance is the radius itself, whether small or large",
    why="Half a metre for a pedestrian, five metres for a lorry: a distance is compared with a "
    "distance.",
    hint="The sum of squares is not yet the distance: take its root, or math.dist.",
)
def takes_the_radius(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    points = nested_points(
        np.random.default_rng(4), [2.2, 1.6, 1.3, 0.9, 0.8, 0.7, 0.6, 0.3], 2, is_off_corners, -1
    )
    for tolerance in (0.3, 1.0, 3.0):
        root = grown(points * tolerance)
        assert_found(build_tree(KdTree, root), root, np.zeros(2), tolerance)


@noted(
    "search",
    title="A point at exactly the tolerance is found",
    why="Within means up to and including: write <=. Measured points hardly ever lie exactly "
    "there, so it costs nothing.",
)
def includes_the_border(KdTree: Callable) -> None:
    points = np.array([[0.0, 2.0], [1.0, 1.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grown(points)
    assert_found(build_tree(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


def finds_the_rim(KdTree: Callable) -> bool:
    """Return whether a search finds points at exactly the tolerance.

    A search that leaves them out does not show what it does where the box ends at a split.
    """
    try:
        includes_the_border(KdTree)
    except CheckFailed:
        return False
    return True


@visible(
    "search",
    weight=2,
    title="Goes right also where the box ends exactly at the split",
    why="A point with the coordinate of the split itself stands on the right. The search of a "
    "well-known course loses it, and only in some directions.",
    hint="Go right when target[axis] + tolerance >= split, with the equals sign.",
)
def reaches_the_split(KdTree: Callable) -> None:
    with needs("both sides are searched where the circle crosses the split"):
        looks_on_both_sides(KdTree)
    if not finds_the_rim(KdTree):
        return
    points = np.array([[2.0, 9.0], [-3.0, 3.0], [2.0, 2.0], [1.0, 3.0], [1.2, 2.5]])
    root = grown(points)
    assert_found(build_tree(KdTree, root), root, np.array([1.0, 2.0]), 1.0)


@visible(
    "search",
    weight=6,
    title="Takes three coordinates",
    why="Scans are three-dimensional: the axes go x, y, z, x, y, z, ... down the tree.",
    hint="The axis is depth % len(target), as in insert.",
)
def searches_space(KdTree: Callable) -> None:
    points = nested_points(np.random.default_rng(5), _SIZES, 3, is_off_corners)
    # Two of the last three are near the target as seen from above, and far above or below it.
    above = np.array([[0.3, 0.2, 5.0], [0.1, 0.4, 0.2], [0.6, -0.3, -4.0]])
    for root in (grown(points), grown(above)):
        assert_found(build_tree(KdTree, root), root, np.zeros(3), 1.0)


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
            assert_pruned(KdTree, balanced_tree(), np.array(target), 1.0, trap, decoy, place)


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
    assert_found(build_tree(KdTree, None), None, np.zeros(2), 1.0)
    root = grown([[1.0, 2.0]])
    assert_found(build_tree(KdTree, root), root, np.array([1.1, 2.0]), 0.5)
    assert_found(build_tree(KdTree, root), root, np.array([5.0, 5.0]), 1.0)


@visible(
    "search",
    weight=1,
    title="Names each point once",
    why="Where neighbours are counted, a point that is named twice counts twice.",
    hint="Note the index at one place only: when you come to its node.",
)
def names_each_once(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    yours = as_indices(build_tree(KdTree, balanced_tree()).search(np.array([-6.0, 7.0]), 3.0))
    repeated = sorted({index for index in yours if yours.count(index) > 1})
    if repeated:
        raise CheckFailed(
            f"Index {repeated[0]} is there {yours.count(repeated[0])} times.",
            given="target (-6, 7), tolerance 3",
            yours=_indices_text(yours),
            expected="each index once",
        )


def _indices_text(indices: list[int]) -> str:
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
        nested_points(np.random.default_rng(6), [3.0, 2.0, 0.8, 0.5, 0.3], 2, is_off_corners, -1)
    )
    for as_lists, target in ((True, [0.0, 0.0]), (True, np.zeros(2)), (False, (0.0, 0.0))):
        assert_found(build_tree(KdTree, root, as_lists), root, target, 1.0)


@visible(
    "search",
    weight=1,
    title="Leaves the tree and the target as they are",
    why="The same tree is asked again and again, and the target is a row of the cloud.",
    hint="Look, and write nothing: neither to a node nor to the target.",
)
def leaves_the_tree(KdTree: Callable) -> None:
    _assert_at_target(KdTree)
    order = list(BALANCED_ORDER)
    tree = build_tree(KdTree, balanced_tree())
    assert_untouched(tree.search, np.array([-6.0, 7.0]), 3.0)
    assert_same_tree(tree, QUIZ[order], order)


@noted(
    "search",
    title="Copes with a tree of a thousand levels",
    why="The last part of this lesson searches the tree of a sorted wall. A function that calls "
    "itself ends there in a RecursionError; a list of places that wait does not.",
)
def searches_deep_trees(KdTree: Callable) -> None:
    root = chain_tree(1200)
    assert_found(build_tree(KdTree, root), root, np.array([1199.0, 1199.0]), 0.5)


class _Split(NamedTuple):
    """A node on the path to another node, as a search sees it.

    Attributes
    ----------
    low, at, high : float
        Start of the box, target and end of the box along the axis of the split.
    split : float
        Coordinate of the node along this axis.
    is_near : bool
        Whether the point of the node is within the tolerance of the target.
    is_left : bool
        Whether the other node is on the left.
    """

    low: float
    at: float
    high: float
    split: float
    is_near: bool
    is_left: bool


def _visited(
    points: np.ndarray,
    target: np.ndarray,
    tolerance: float,
    rule: Callable[[_Split], bool],
    axis_at: Callable[[int, int], int] = in_turn,
    depth_of: Callable[[str], int] = len,
) -> set[int]:
    """Return the indices of the nodes that a search with this rule visits, near or not."""
    places = places_of(grown(points))

    def passes(path: str, depth: int) -> bool:
        axis = axis_at(depth_of(path[:depth]), len(target))
        return rule(_split(places[path[:depth]], axis, path[depth] == "l", target, tolerance))

    return {
        places[path].index
        for path in places
        if all(passes(path, depth) for depth in range(len(path)))
    }


def _split(
    node: TreeNode, axis: int, is_left: bool, target: np.ndarray, tolerance: float
) -> _Split:
    at, is_near = target[axis], math.dist(node.point, target) <= tolerance
    return _Split(at - tolerance, at, at + tolerance, node.point[axis], is_near, is_left)


def _reaches(node: _Split) -> bool:
    """Return whether at least a part of the box is on that side."""
    return node.low < node.split if node.is_left else node.high >= node.split


def _visits_by(rule: Callable, axis_at: Callable = in_turn, depth_of: Callable = len) -> Callable:
    """Return a prediction: the right points that a search with this rule visits."""
    return lambda right, points, target, tolerance: (
        right & _visited(points, target, tolerance, rule, axis_at, depth_of)
    )


def _until_first_gap(right: set, points: np.ndarray, target: np.ndarray, tolerance: float) -> set:
    """Predict the points found level by level before the first place without a node."""
    places, found, pending = places_of(grown(points)), set(), [""]
    for path in pending:  # the list grows inside the loop
        if path not in places:
            break
        node, axis = places[path], in_turn(len(path), len(target))
        found.add(node.index)
        pending += [
            path + letter
            for letter in SIDES
            if _reaches(_split(node, axis, letter == "l", target, tolerance))
        ]
    return right & found


# Either of two slips leads along a single path: an `else`, or an end at the first place without a
# node in a search that takes the newest place first.
_ONE_PATH = (
    "Write two ifs, one for each child, and no `else` or `elif`. Where no node is, `continue` "
    "with the next place: `break` and `return` end the whole search."
)


def _judged_by(is_near: Callable) -> Callable:
    """Return the prediction of a search that decides with `is_near` which points are near.

    `is_near` takes the absolute differences from the target, shape (k,), the tolerance and the
    depth.
    """

    def predict(right: set, points: np.ndarray, target: np.ndarray, tolerance: float) -> set:
        depths = {node.index: len(path) for path, node in places_of(grown(points)).items()}
        return {
            index
            for index in _visited(points, target, tolerance, _reaches)
            if is_near(np.abs(points[index] - target), tolerance, depths[index])
        }

    return predict


def _same_indices(answer: object, predicted: set[int]) -> bool:
    try:
        return set(as_indices(answer)) == predicted
    except CheckFailed:
        return False


def _grid_points(seed: int, k: int) -> np.ndarray:
    """Return points with whole-numbered coordinates, many of them equal and many on the rim."""
    return np.random.default_rng(seed).integers(-3, 4, (24, k)).astype(float)


mistakes(
    "search",
    Mistake(
        "Only the side on which the target itself lies is searched.",
        _visits_by(lambda node: (node.at < node.split) == node.is_left),
        "Where the circle crosses the split, both sides must be: two ifs, no else.",
    ),
    Mistake(
        "The search follows a single path: where the box reaches both sides, only the left one is "
        "searched.",
        _visits_by(lambda node: (node.low < node.split) == node.is_left),
        _ONE_PATH,
    ),
    Mistake(
        "The search follows a single path: where the box reaches both sides, only the right one "
        "is searched.",
        _visits_by(lambda node: (node.high >= node.split) != node.is_left),
        _ONE_PATH,
    ),
    Mistake(
        "The search ends at the first empty place that it comes to, though others still wait.",
        _until_first_gap,
        "`break` and `return` end the whole search; `continue` takes the next place.",
    ),
    Mistake(
        "The right side is asked only where the left one was taken.",
        _visits_by(lambda node: _reaches(node) and (node.is_left or node.low < node.split)),
        "Is the second `if` indented under the first? Both belong on the same level.",
    ),
    Mistake(
        "The left side is asked only where the right one was taken.",
        _visits_by(lambda node: _reaches(node) and (not node.is_left or node.high >= node.split)),
        "Is the second `if` indented under the first? Both belong on the same level.",
    ),
    Mistake(
        "The depth stays as it is on the way to a left child: it cuts along the same axis as its "
        "parent.",
        _visits_by(_reaches, depth_of=lambda path: path.count("r")),
        "Both children wait with depth + 1.",
    ),
    Mistake(
        "The depth stays as it is on the way to a right child: it cuts along the same axis as its "
        "parent.",
        _visits_by(_reaches, depth_of=lambda path: path.count("l")),
        "Both children wait with depth + 1.",
    ),
    Mistake(
        "The ends of the box are swapped: plus stands where minus is asked for, so that a side is "
        "searched only where the whole box lies on it.",
        _visits_by(lambda node: node.high < node.split if node.is_left else node.low >= node.split),
        "The box begins at target[axis] - tolerance, which decides about the left child; it ends "
        "at target[axis] + tolerance.",
    ),
    Mistake(
        "The sides are swapped: what decides about the left child is asked for the right one, and "
        "the other way round.",
        _visits_by(lambda node: _reaches(node._replace(is_left=not node.is_left))),
        "Smaller coordinates stand on the left: go there when the box begins below the split.",
    ),
    Mistake(
        "`>` stands where `>=` is asked for: where the box ends exactly at the split, the right "
        "side is left out.",
        _visits_by(lambda node: _reaches(node) and (node.is_left or node.high > node.split)),
        "What stands at the split itself stands on the right.",
    ),
    Mistake(
        "Both sides are searched below nodes that are near, and only the target's own side below "
        "all others.",
        _visits_by(lambda node: node.is_near or (node.at < node.split) == node.is_left),
        "Whether the node is near says nothing about its sides: ask whether the box reaches them.",
    ),
    Mistake(
        "The search ends at each node that is not near: nothing below it is looked at.",
        _visits_by(lambda node: node.is_near and _reaches(node)),
        "A node may be far and have neighbours of the target below it: ask about its sides in any "
        "case.",
    ),
    Mistake(
        "The tolerance is left out on the left: only what the target itself is below is searched.",
        _visits_by(lambda node: _reaches(node) and (not node.is_left or node.at < node.split)),
        "The box begins at target[axis] - tolerance.",
    ),
    Mistake(
        "The tolerance is left out on the right: only what the target itself is beyond is "
        "searched.",
        _visits_by(lambda node: _reaches(node) and (node.is_left or node.at >= node.split)),
        "The box ends at target[axis] + tolerance.",
    ),
    Mistake(
        "x and y take turns and z is never compared: 2 is written where len(target) is needed.",
        _visits_by(_reaches, lambda depth, k: depth % 2),
    ),
    Mistake(
        "x is compared at every level: the axis does not change on the way down.",
        _visits_by(_reaches, lambda depth, k: 0),
        "The axis is depth % len(target), and a child waits with depth + 1.",
    ),
    Mistake(
        "The turns begin with y: the root is treated as if it had depth 1.",
        _visits_by(_reaches, lambda depth, k: (depth + 1) % k),
        "The root has depth 0.",
    ),
    Mistake(
        "The box decides, not the circle: points in its corners are found, too.",
        _judged_by(lambda step, tolerance, depth: step.max() <= tolerance),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "The height is left out: points are near as seen from above, however high they are.",
        _judged_by(lambda step, tolerance, depth: np.linalg.norm(step[:2]) <= tolerance),
        "Compare the distance of all coordinates, math.dist(node.point, target).",
    ),
    Mistake(
        "The square of the distance is compared with the tolerance itself.",
        _judged_by(lambda step, tolerance, depth: step @ step <= tolerance),
        "Take the square root of the sum of squares, or math.dist.",
    ),
    Mistake(
        "One coordinate decides whether a point is near, the one that its node cuts.",
        _judged_by(lambda step, tolerance, depth: step[depth % len(step)] <= tolerance),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    Mistake(
        "Every node that the search comes to is found, whatever its distance.",
        _judged_by(lambda step, tolerance, depth: True),
        "Compare the distance, math.dist(node.point, target), with the tolerance.",
    ),
    cases=(
        (_grid_points(13, 2), np.zeros(2), 2.0),
        (_grid_points(12, 2), np.zeros(2), 3.0),
        (_grid_points(13, 3), np.zeros(3), 2.0),
        (_grid_points(52, 3), np.zeros(3), 3.0),
        (_grid_points(49, 2), np.full(2, 2.0), 1.0),
        (_grid_points(62, 2), np.zeros(2), 2.0),
        (_grid_points(64, 2), np.zeros(2), 2.0),
    ),
    right=lambda points, target, tolerance: {
        index for index, point in enumerate(points) if math.dist(point, target) <= tolerance
    },
    same=_same_indices,
    call=lambda KdTree, points, target, tolerance: build_tree(KdTree, grown(points)).search(
        target, tolerance
    ),
    class_name="KdTree",
)
