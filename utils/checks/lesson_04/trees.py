"""Build a student's tree from given nodes, and assert that points are in their places."""

import operator
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    brief_text,
    call_each,
    frozen,
    get_attribute_path,
    precondition,
)
from utils.checks.run_cache import once_per_run
from utils.checks.size_limits import MAX_NUMBERS_PER_POINT
from utils.geometry import SIDES, TreeNode, grow_tree, nodes_by_path, tree_as_lists
from utils.remote_objects import RemoteError, RemoteProxy, RemoteStopped

# At most this many nodes of a wrong tree are visited, because it may contain a cycle.
MAX_NODES = 200
# Points in the plane and in space. No point occurs twice, but many coordinates are equal.
_SAMPLES = frozen(
    tuple(
        np.random.default_rng(7).permutation(list(np.ndindex((3,) * k)))[:9].astype(float)
        for k in (2, 3)
    )
)


def build_tree(KdTree: Callable, root: TreeNode | None, as_lists: bool = False) -> object:
    """Return a tree of the student's class with the same nodes as a correct tree.

    The lesson's class receives its nodes ready-made, so that a mistake in `insert` does not affect
    `search`. If a student's class stores more than the lesson's, the points are inserted.

    Parameters
    ----------
    KdTree : callable
        The student's class.
    root : node or None
        A correct tree.
    as_lists : bool
        Whether points are lists instead of arrays.

    Returns
    -------
    object
        Instance of the student's class.
    """
    tree = KdTree()
    points, left, right, indices = tree_as_lists(root)
    points = points if as_lists else np.array(points)
    plant = method_of(tree, "plant")
    if plant and _uses_plant(KdTree):
        plant(points, left, right, indices)
        return tree
    call_each(tree.insert, zip(points, indices, strict=True))
    return tree


def build_tree_with(KdTree: Callable, root: TreeNode, places: dict[int, Sequence[float]]) -> object:
    """Return a tree of the student's class in which some points are out of place.

    Parameters
    ----------
    KdTree : callable
        The student's class.
    root : node
        A correct tree.
    places : dict of int to sequence of float
        New points of some nodes, keyed by the index of the node.

    Returns
    -------
    object
        Instance of the student's class.

    Raises
    ------
    CheckFailed
        If the class cannot build such a tree.
    """
    tree = KdTree()
    points, left, right, indices = tree_as_lists(root)
    plant = method_of(tree, "plant")
    if not plant or not _uses_plant(KdTree):
        tree = build_tree(KdTree, root)
        with precondition("every point is in its place"):
            assert_tree(tree, points, indices)
        if _move_points(tree, root, places):
            return tree
        if not plant:
            raise CheckFailed(
                "The point of a node cannot be changed, so this check cannot test whether search "
                "follows the splits.",
                hint="Make `point` an attribute that can be set, as in the lesson's Node.",
            )
        tree = KdTree()
        plant = tree.plant
    points = [places.get(index, point) for index, point in zip(indices, points, strict=True)]
    plant(np.array(points), left, right, indices)
    return tree


def _move_points(tree: object, root: TreeNode, places: dict[int, Sequence[float]]) -> bool:
    """Set the points of some nodes; return whether the nodes allow it."""
    for path, node in nodes_by_path(root).items():
        if node.index in places:
            names = ["root", *(SIDES[letter] for letter in path), "__setattr__"]
            try:
                get_attribute_path(tree, names)("point", np.array(places[node.index]))
            except Exception as error:
                if not _is_read_only(error):
                    raise
                return False
    return True


def _is_read_only(error: Exception) -> bool:
    return not {"AttributeError", "FrozenInstanceError"}.isdisjoint(error_names(error))


def _uses_plant(KdTree: Callable) -> bool:
    """Return whether a class with a `plant` method should use it instead of inserting points."""
    try:
        _assert_stores_more(KdTree)
        _assert_inserts(KdTree)
    except CheckFailed:
        return True
    return False


@once_per_run
def _assert_stores_more(KdTree: Callable) -> None:
    """Assert that a tree or its nodes store more than the lesson's, or have another class."""
    try:
        tree, ready_made = KdTree(), KdTree()
        tree.insert(np.zeros(2), 0)
        root_class = _root_class(tree)
        if root_class == "NoneType" or type(root_class) is not str:
            raise CheckFailed("The root is missing.")
        ready_made.plant(np.zeros((1, 2)), [-1], [-1], [0])
        same_class = root_class == _root_class(ready_made)
        field_counts = [
            get_attribute_path(tree, [*owner, "__dict__", "__len__"])() for owner in ([], ["root"])
        ]
    except _student_errors(KdTree):
        return
    if same_class and field_counts == [1, 4]:
        raise CheckFailed("The tree and its nodes store nothing more than those of the lesson.")


def _root_class(tree: object) -> object:
    return get_attribute_path(tree, ["root", "__class__", "__qualname__"])


@once_per_run
def _assert_inserts(KdTree: Callable) -> None:
    """Assert that inserted points are in their places, so that a tree can be built by inserting."""
    for points in _SAMPLES:
        # In descending order, because a class that numbers points itself would store 0, 1, 2, ...
        indices = list(range(len(points)))[::-1]
        try:
            tree = KdTree()
            call_each(tree.insert, zip(points.copy(), indices, strict=True))
            assert_tree(tree, points, indices)
            assert_indices(tree, points, indices)
        except _student_errors(KdTree):
            raise CheckFailed("Points cannot be inserted.") from None


def _student_errors(KdTree: Callable) -> type[Exception] | tuple[type[Exception], ...]:
    """Return the exceptions that a student's code may raise, here or in the sandbox."""
    return (RemoteError, RemoteStopped) if isinstance(KdTree, RemoteProxy) else Exception


def method_of(tree: object, name: str) -> Callable | None:
    """Return a method of a student's object, here or in the sandbox; None if there is none."""
    try:
        return getattr(tree, name)
    except Exception as error:
        if "AttributeError" in error_names(error):
            return None
        raise


def error_names(error: Exception) -> tuple[str, str]:
    """Return the name of an exception's class, and the name that the sandbox reported."""
    return type(error).__name__, getattr(error, "type_name", "")


def assert_tree(
    tree: object,
    points: ArrayLike,
    indices: Sequence[int] | None = None,
    may_be_mirrored: bool = False,
) -> None:
    """Assert that points inserted in order are in their places; stored indices are not compared.

    Parameters
    ----------
    tree : object
        Instance of the student's class.
    points, indices
        As for `grow_tree`.
    may_be_mirrored : bool
        Whether left and right may be swapped in the whole tree, for properties that do not depend
        on the sides.
    """
    mirrored = grow_tree(points, indices, goes_left=operator.gt)
    if may_be_mirrored and not _describe_first_misplaced_node(tree, mirrored)[0]:
        return
    root = grow_tree(points, indices)
    message, hint = _describe_first_misplaced_node(tree, root)
    if message:
        raise CheckFailed(
            message[0].upper() + message[1:],
            input_text=few_points_text(points),
            hint=hint,
            draw=_draw_two_trees(tree, root),
        )


def _describe_first_misplaced_node(tree: object, root: TreeNode | None) -> tuple[str, str]:
    """Return a message about the first point out of place, and a hint; both may be empty."""
    expected = nodes_by_path(root)
    yours = _nodes_by_path(tree, expected)
    for path in sorted(expected, key=lambda path: expected[path].input_row):
        if path not in yours or not _same_point(yours[path][0], expected[path]):
            return _describe_misplaced_node(tree, path, expected, yours)
    return _describe_extra_node(expected, yours)


def assert_indices(tree: object, points: ArrayLike, indices: Sequence[int]) -> None:
    """Assert that each point has the index that was inserted with it, wherever the point is.

    Parameters
    ----------
    tree, points, indices
        As for `assert_tree`.
    """
    places = nodes_by_path(grow_tree(points, indices))
    for point, index in _nodes_by_path(tree, places).values():
        node = next((other for other in places.values() if _same_point(point, other)), None)
        if node and not _is_number(index, node.index):
            raise CheckFailed(
                f"The node of the point {exact_text(node.point)} does not have the index that was "
                "inserted with it.",
                input_text=few_points_text(points),
                yours=f"index {brief_text(index)}",
                expected=f"index {node.index}",
            )


def _is_number(value: object, expected: int) -> bool:
    return isinstance(value, (int, np.integer)) and bool(value == expected)


def _nodes_by_path(
    tree: object, expected: dict[str, TreeNode]
) -> dict[str, tuple[np.ndarray, object]]:
    """Return point and index of a student's nodes, keyed by path.

    The walk ends one level below the expected tree.
    """
    found, pending = {}, [("", tree.root)]
    for path, node in pending:  # the list grows inside the loop
        if node is None:
            continue
        point, index, left, right = (
            _read_attribute(node, name, path, expected)
            for name in ("point", "index", "left", "right")
        )
        point = as_array(point, description="a point", max_count=MAX_NUMBERS_PER_POINT)
        if point.ndim == 0 and np.ndim(index) == 1:
            raise WrongForm(
                "Point and index are swapped: the point of a node is a number, and its index "
                "contains the coordinates.",
                yours=f"point {point:g}, index {brief_text(index)}",
                expected="Node(point, index): the point comes first",
            )
        point = point.ravel()
        found[path] = (point, index)
        if path in expected:
            pending += [(path + "l", left), (path + "r", right)]
    return found


def _read_attribute(node: object, name: str, path: str, expected: dict[str, TreeNode]) -> object:
    try:
        return getattr(node, name)
    except Exception as error:
        if "AttributeError" not in error_names(error):
            raise
        raise WrongForm(
            f"The object {_place_text(path, expected)} has no attribute {name!r}: build the tree "
            "from Node objects, as defined in the lesson.",
            yours=brief_text(node),
        ) from None


def _same_point(point: np.ndarray, node: TreeNode) -> bool:
    return point.shape == (len(node.point),) and all(
        abs(a - b) <= 1e-4 + 1e-5 * abs(b) for a, b in zip(point.tolist(), node.point, strict=True)
    )


def _describe_misplaced_node(
    tree: object, path: str, expected: dict, yours: dict
) -> tuple[str, str]:
    """Return a message about a point that is not in its place, and a hint, which may be empty."""
    node = expected[path]
    if not yours:
        return f"the tree is empty: tree.root is None after {_node_name(node)} was inserted.", ""
    actual = _path_to(tree, node, expected)
    if actual is None:
        return _describe_missing_node(path, expected, yours)
    depth = next((d for d, (a, b) in enumerate(zip(path, actual, strict=False)) if a != b), None)
    if depth is None:
        return (
            f"{_node_name(node)} belongs {_place_text(path, expected)}, but another point is "
            "there.",
            "",
        )
    parent, axis = expected[path[:depth]], depth % len(node.point)
    smaller = "is smaller than" if path[depth] == "l" else "is not smaller than"
    return (
        f"{_node_name(node)} goes {SIDES[actual[depth]]} at {_node_name(parent)} but should go "
        f"{SIDES[path[depth]]}: at depth {depth}, {'xyz'[axis]} is compared, and "
        f"{node.point[axis]:g} {smaller} {parent.point[axis]:g}."
    ), ""


def _describe_missing_node(path: str, expected: dict, yours: dict) -> tuple[str, str]:
    """Return a message about a missing point and its place, and a hint, which may be empty."""
    text = (
        f"{_node_name(expected[path])} is not in the tree; it belongs {_place_text(path, expected)}"
    )
    if path not in yours:
        return f"{text}, but no node is there.", (
            "Every path through insert must attach the new node to tree.root, node.left or "
            "node.right. Storing it in a local or global variable does not attach it."
        )
    found = next(
        (other for other in expected if _same_point(yours[path][0], expected[other])), None
    )
    if found is None:
        return f"{text}.", ""
    text = f"{text}, but {_node_name(expected[found])} is there."
    if found and found[:-1] == path[:-1]:
        return text, (
            f"{_node_name(expected[found]).capitalize()} belongs on the {SIDES[found[-1]]}: does "
            "each branch attach the new node on its own side, node.left or node.right?"
        )
    return text, "Do not replace a child that is already there; continue from it."


def _path_to(tree: object, node: TreeNode, expected: dict[str, TreeNode]) -> str | None:
    """Return the path to a misplaced point in a student's tree; None if it is missing."""
    pending = [("", tree.root)]
    for path, current in pending:  # the list grows inside the loop
        if current is None:
            continue
        point = as_array(
            current.point, description="a point", max_count=MAX_NUMBERS_PER_POINT
        ).ravel()
        if _same_point(point, node) and not (
            path in expected and _same_point(point, expected[path])
        ):
            return path
        if len(pending) < MAX_NODES:
            pending += [(path + "l", current.left), (path + "r", current.right)]
    return None


def _describe_extra_node(expected: dict, yours: dict) -> tuple[str, str]:
    """Return a message about a surplus node, and a hint; both are empty if there is none."""
    extra = next((path for path in yours if path not in expected), None)
    if extra is None:
        return "", ""
    for path, node in expected.items():
        if _same_point(yours[extra][0], node):
            message = f"{_node_name(node)} is in the tree twice: {_place_text(path, expected)} and "
            return f"{message}{_place_text(extra, expected)}.", (
                "Use `return` to end the walk as soon as the point is attached to the tree."
                if path
                else "Use `return` after the point has become the root, before the walk begins."
            )
    return f"there is a node {_place_text(extra, expected)}, where the tree should end.", ""


def _place_text(path: str, expected: dict[str, TreeNode]) -> str:
    if not path:
        return "at the root"
    return f"to the {SIDES[path[-1]]} of {_node_name(expected[path[:-1]])}"


def _node_name(node: TreeNode) -> str:
    return f"point {node.index} {exact_text(node.point)}"


def exact_text(point: Sequence[float]) -> str:
    """Return a point with any number of coordinates as text, not rounded to centimetres."""
    return "(" + ", ".join(f"{float(value):g}" for value in np.ravel(point)) + ")"


def few_points_text(points: ArrayLike) -> str | None:
    """Return points as text, in the given order; None if there are more than seven."""
    if len(points) > 7:
        return None
    is_plural = len(points) > 1
    text = ", ".join(map(exact_text, points))
    return f"points {text} in this order" if is_plural else f"point {text}"


def _draw_two_trees(tree: object, expected: TreeNode | None) -> Callable:
    def draw() -> None:
        import matplotlib.pyplot as plt

        _, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
        utils.plots.kd_tree(tree.root, title="yours", axes=left)
        utils.plots.kd_tree(expected, title="expected", axes=right)

    return draw
