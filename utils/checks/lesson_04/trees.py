"""A student's tree: planted ready-made, and what must stand where."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    brief,
    call_each,
    frozen,
    needs,
    reach,
)
from utils.checks.run_cache import once
from utils.checks.size_limits import MOST_OF_A_POINT
from utils.geometry import SIDES, Node, grown, places_of, table_of
from utils.remote_objects import Remote, RemoteError, RemoteStopped

# Nodes of a wrong tree that are looked through; it may have no end.
MOST_NODES = 200
# In the plane and in space: no point twice, many coordinates equal.
_SAMPLES = frozen(
    tuple(
        np.random.default_rng(7).permutation(list(np.ndindex((3,) * k)))[:9].astype(float)
        for k in (2, 3)
    )
)


def planted(KdTree: Callable, root: Node | None, as_lists: bool = False) -> object:
    """A tree of the student's class with the same nodes as a right one.

    The class of the lesson is given its nodes ready-made, so that a slip in `insert` does not
    spoil `search`. One that knows more about a tree than the lesson's inserts them.

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
    plant = method_of(tree, "plant")
    if plant and _is_planted(KdTree):
        plant(points, left, right, indices)
        return tree
    call_each(tree.insert, zip(points, indices, strict=True))
    return tree


def planted_with(KdTree: Callable, root: Node, places: dict[int, Sequence[float]]) -> object:
    """A tree of the student's class with some points where no right tree has them.

    Parameters
    ----------
    KdTree : callable
    root : node
        A right tree.
    places : dict of int to sequence of float
        By index, the points that some of its nodes have instead of their own.

    Returns
    -------
    object
        Of the student's class.
    """
    tree = KdTree()
    points, left, right, indices = table_of(root)
    plant = method_of(tree, "plant")
    if not plant or not _is_planted(KdTree):
        tree = planted(KdTree, root)
        with needs("every point is where it belongs"):
            assert_tree(tree, points, indices)
        if _are_moved(tree, root, places):
            return tree
        if not plant:
            raise CheckFailed(
                "The point of a node cannot be changed, so nobody can see whether search goes by "
                "it.",
                hint="Let `point` be an attribute that can be set, as the lesson's Node does.",
            )
        tree = KdTree()
        plant = tree.plant
    points = [places.get(index, point) for index, point in zip(indices, points, strict=True)]
    plant(np.array(points), left, right, indices)
    return tree


def _are_moved(tree: object, root: Node, places: dict[int, Sequence[float]]) -> bool:
    """Give nodes other points; whether that can be done."""
    for way, node in places_of(root).items():
        if node.index in places:
            names = ["root", *(SIDES[letter] for letter in way), "__setattr__"]
            try:
                reach(tree, names)("point", np.array(places[node.index]))
            except Exception as error:
                if not _is_readable_only(error):
                    raise
                return False
    return True


def _is_readable_only(error: Exception) -> bool:
    return not {"AttributeError", "FrozenInstanceError"}.isdisjoint(error_names(error))


def _is_planted(KdTree: Callable) -> bool:
    """Whether trees of a class that can plant are planted, and not inserted node by node."""
    try:
        _assert_knows_more(KdTree)
        _assert_inserts(KdTree)
    except CheckFailed:
        return True
    return False


@once
def _assert_knows_more(KdTree: Callable) -> None:
    """A tree of one point, or its node, holds more than the lesson's, or is of another kind."""
    try:
        tree, ready = KdTree(), KdTree()
        tree.insert(np.zeros(2), 0)
        kind = _kind_of_root(tree)
        if kind == "NoneType" or type(kind) is not str:
            raise CheckFailed("Nothing is at the root.")
        ready.plant(np.zeros((1, 2)), [-1], [-1], [0])
        same = kind == _kind_of_root(ready)
        fields = [reach(tree, [*of, "__dict__", "__len__"])() for of in ([], ["root"])]
    except _of_the_student(KdTree):
        return
    if same and fields == [1, 4]:
        raise CheckFailed("A tree knows its root, and a node the four things of the lesson.")


def _kind_of_root(tree: object) -> object:
    return reach(tree, ["root", "__class__", "__qualname__"])


@once
def _assert_inserts(KdTree: Callable) -> None:
    """What is inserted stands where it belongs, so that a tree can be made so."""
    for points in _SAMPLES:
        indices = list(range(len(points)))[::-1]  # not those of a count
        try:
            tree = KdTree()
            call_each(tree.insert, zip(points.copy(), indices, strict=True))
            assert_tree(tree, points, indices)
            assert_indices(tree, points, indices)
        except _of_the_student(KdTree):
            raise CheckFailed("Nothing can be inserted.") from None


def _of_the_student(KdTree: Callable) -> type[Exception] | tuple[type[Exception], ...]:
    """What a student's code may raise, or make of its process, when it is asked."""
    return (RemoteError, RemoteStopped) if isinstance(KdTree, Remote) else Exception


def method_of(tree: object, name: str) -> Callable | None:
    """A method of a student's object, here or in the sandbox; None where there is none."""
    try:
        return getattr(tree, name)
    except Exception as error:
        if "AttributeError" in error_names(error):
            return None
        raise


def error_names(error: Exception) -> tuple[str, str]:
    """What an exception is called, here and in the sandbox, where it is reported."""
    return type(error).__name__, getattr(error, "type_name", "")


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
            says[0].upper() + says[1:],
            given=few_points(points),
            hint=hint,
            draw=_two_trees(tree, root),
        )


def _odd_in(tree: object, root: Node | None) -> tuple[str, str]:
    """The first point in its order of arrival that is not in its place, and a hint, or nothing."""
    expected = places_of(root)
    yours = _looked_at(tree, expected)
    for way in sorted(expected, key=lambda way: expected[way].arrival):
        if way not in yours or not _same_point(yours[way][0], expected[way]):
            return _misplaced(tree, way, expected, yours)
    return _one_too_many(expected, yours)


def assert_indices(tree: object, points: ArrayLike, indices: Sequence[int]) -> None:
    """Each point has the index that was inserted with it, wherever it stands.

    Parameters
    ----------
    tree, points, indices
        As for `assert_tree`.
    """
    places = places_of(grown(points, indices))
    for point, index in _looked_at(tree, places).values():
        node = next((one for one in places.values() if _same_point(point, one)), None)
        if node and not _is_number(index, node.index):
            raise CheckFailed(
                f"The node of the point {exact_text(node.point)} has another index than the one "
                "that came with it.",
                given=few_points(points),
                yours=f"index {brief(index)}",
                expected=f"index {node.index}",
            )


def _is_number(value: object, expected: int) -> bool:
    return isinstance(value, (int, np.integer)) and bool(value == expected)


def _looked_at(tree: object, expected: dict[str, Node]) -> dict[str, tuple[np.ndarray, object]]:
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


def _attribute(node: object, name: str, way: str, expected: dict[str, Node]) -> object:
    try:
        return getattr(node, name)
    except Exception as error:
        if "AttributeError" not in error_names(error):
            raise
        raise WrongForm(
            f"What stands {_place(way, expected)} has no attribute {name!r}: hang a Node into "
            "the tree, as given in the lesson.",
            yours=brief(node),
        ) from None


def _same_point(point: np.ndarray, node: Node) -> bool:
    return point.shape == (len(node.point),) and all(
        abs(a - b) <= 1e-4 + 1e-5 * abs(b) for a, b in zip(point.tolist(), node.point, strict=True)
    )


def _misplaced(tree: object, way: str, expected: dict, yours: dict) -> tuple[str, str]:
    """What became of a point that does not stand where it belongs, and a hint, or nothing."""
    node = expected[way]
    if not yours:
        return f"the tree is empty: tree.root is None after {_name(node)} was inserted.", ""
    landed = _way_to(tree, node, expected)
    if landed is None:
        return _missing(way, expected, yours)
    depth = next((d for d, (a, b) in enumerate(zip(way, landed, strict=False)) if a != b), None)
    if depth is None:
        return f"{_name(node)} belongs {_place(way, expected)}, where another point stands.", ""
    other, axis = expected[way[:depth]], depth % len(node.point)
    smaller = "is smaller than" if way[depth] == "l" else "is not smaller than"
    return (
        f"{_name(node)} went {SIDES[landed[depth]]} at {_name(other)} and should go "
        f"{SIDES[way[depth]]}: at depth {depth} {'xyz'[axis]} is compared, and "
        f"{node.point[axis]:g} {smaller} {other.point[axis]:g}."
    ), ""


def _missing(way: str, expected: dict, yours: dict) -> tuple[str, str]:
    """What stands in the place of a point that stands nowhere, and a hint, or nothing."""
    says = f"{_name(expected[way])} is not in the tree; it belongs {_place(way, expected)}"
    if way not in yours:
        return f"{says}, where nothing stands.", ""
    there = next((one for one in expected if _same_point(yours[way][0], expected[one])), None)
    if there is None:
        return f"{says}.", ""
    says = f"{says}, where {_name(expected[there])} stands."
    if there and there[:-1] == way[:-1]:
        return says, (
            f"{_name(expected[there]).capitalize()} belongs to the {SIDES[there[-1]]}: does each "
            "branch hang the new node on its own side, node.left or node.right?"
        )
    return says, "A child that is there stays there: the walk goes on from it."


def _way_to(tree: object, node: Node, expected: dict[str, Node]) -> str | None:
    """Where a point is in a student's tree, where it should not be; None where it is nowhere."""
    waiting = [("", tree.root)]
    for way, one in waiting:  # grows while it is walked
        if one is None:
            continue
        point = as_array(one.point, what="a point", most=MOST_OF_A_POINT).ravel()
        if _same_point(point, node) and not (way in expected and _same_point(point, expected[way])):
            return way
        if len(waiting) < MOST_NODES:
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
            return f"{says}{_place(extra, expected)}.", (
                "A point that has been hung into the tree is done: `return`, and the walk ends."
                if way
                else "A point that has become the root is done: `return` before the walk begins."
            )
    return f"a node stands {_place(extra, expected)}, where the tree should end.", ""


def _place(way: str, expected: dict[str, Node]) -> str:
    if not way:
        return "at the root"
    return f"to the {SIDES[way[-1]]} of {_name(expected[way[:-1]])}"


def _name(node: Node) -> str:
    return f"point {node.index} {exact_text(node.point)}"


def exact_text(point: Sequence[float]) -> str:
    """A point of any length, with all the digits that it was written with."""
    return "(" + ", ".join(f"{float(value):g}" for value in np.ravel(point)) + ")"


def few_points(points: ArrayLike) -> str | None:
    """Points in their order, where they are few enough to read."""
    if len(points) > 7:
        return None
    several = len(points) > 1
    text = ", ".join(map(exact_text, points))
    return f"points {text} in this order" if several else f"point {text}"


def _two_trees(tree: object, expected: Node | None) -> Callable:
    def draw() -> None:
        import matplotlib.pyplot as plt

        _, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
        utils.plots.kd_tree(tree.root, title="yours", axes=left)
        utils.plots.kd_tree(expected, title="expected", axes=right)

    return draw
