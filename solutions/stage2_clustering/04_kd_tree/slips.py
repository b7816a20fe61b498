"""Slips in lesson 04."""

from tests.slips import MISSING, PARTLY, SMALL, USELESS, Slip

_AXIS = "axis = depth % len(point)"
_SIDE = '"left" if point[axis] < parent.point[axis] else "right"'
_LEFT = "target[axis] - tolerance < split"
_RIGHT = "target[axis] + tolerance >= split"
_THEN_RIGHT = f"\n        if {_RIGHT}:\n            waiting.append("
_WAITS_LEFT = ":\n            waiting.append((node.left, depth + 1))\n        if "
_NEAR = "dist(node.point, target) <= tolerance"
_MIDDLE = "(len(rows) - 1) // 2"

SLIPS = {
    "insert": [
        Slip("equal coordinates go left", "point[axis] < parent", "point[axis] <= parent", PARTLY),
        Slip("the sides are swapped", "point[axis] < parent", "point[axis] > parent", USELESS),
        Slip("the depth does not grow", "child, depth + 1", "child, depth", USELESS),
        Slip("the root has depth 1", "tree.root, 0", "tree.root, 1", USELESS),
        Slip("2 instead of the number of axes", _AXIS, "axis = depth % 2", PARTLY),
        Slip("compares only x", _AXIS, "axis = 0", USELESS),
        Slip("replaces an existing child", "if child is None", "if True", USELESS),
        Slip("stores 0 as the index", "Node(point, index)", "Node(point, 0)", PARTLY),
        Slip("point and index are swapped", "Node(point, index)", "Node(index, point)", USELESS),
        Slip("the root is not set", "tree.root = newcomer", "root = newcomer", USELESS),
        Slip(
            "attaches only on the left",
            "setattr(parent, side,",
            'setattr(parent, "left",',
            USELESS,
        ),
        Slip(
            "inserts the first point twice",
            "tree.root = newcomer\n        return",
            "tree.root = newcomer",
            USELESS,
        ),
        Slip("attaches nothing", "setattr(parent, side, newcomer)", "child = newcomer", USELESS),
        Slip("no loop", "while True:", "if True:", USELESS),
        Slip(
            "the loop never ends",
            "setattr(parent, side, newcomer)\n            return",
            "setattr(parent, side, newcomer)",
            USELESS,
        ),
        Slip(
            "compares with another coordinate of the parent",
            "parent.point[axis]",
            "parent.point[axis - 1]",
            PARTLY,
        ),
        Slip("no [axis] after the parent's point", "parent.point[axis]", "parent.point", USELESS),
    ],
    "search": [
        Slip("> instead of >=", _RIGHT, "target[axis] + tolerance > split", SMALL),
        Slip("elif instead of if", f"if {_RIGHT}", f"elif {_RIGHT}", PARTLY),
        Slip(
            "the ends of the box are swapped",
            f"{_LEFT}{_WAITS_LEFT}target[axis] + tolerance",
            f"target[axis] + tolerance < split{_WAITS_LEFT}target[axis] - tolerance",
            USELESS,
        ),
        Slip(
            "the children are swapped",
            f"(node.left, depth + 1)){_THEN_RIGHT}(node.right,",
            f"(node.right, depth + 1)){_THEN_RIGHT}(node.left,",
            USELESS,
        ),
        Slip("no tolerance on the left", _LEFT, "target[axis] < split", PARTLY),
        Slip("no tolerance on the right", _RIGHT, "target[axis] >= split", PARTLY),
        Slip(
            "the depth does not grow on the left",
            "node.left, depth + 1",
            "node.left, depth",
            USELESS,
        ),
        Slip(
            "the depth does not grow on the right",
            "node.right, depth + 1",
            "node.right, depth",
            USELESS,
        ),
        Slip("break instead of continue", "continue", "break", USELESS),
        Slip(
            "squared distance",
            _NEAR,
            "dist(node.point, target) ** 2 <= tolerance",
            PARTLY,
        ),
        Slip("nothing is pruned on the left", f"if {_LEFT}", "if True", PARTLY),
        Slip(
            "searches only below near nodes",
            "        axis = depth % len(target)",
            "        else:\n            continue\n        axis = depth % len(target)",
            USELESS,
        ),
        Slip(
            "one if nested in the other",
            f"        if {_RIGHT}:\n            waiting.append((node.right, depth + 1))",
            f"            if {_RIGHT}:\n                waiting.append((node.right, depth + 1))",
            USELESS,
        ),
        Slip("2 instead of the number of axes", "% len(target)", "% 2", PARTLY),
        Slip(
            "returns points",
            "found.append(node.index)",
            "found.append(node.point)",
            USELESS,
        ),
        Slip("does not test for None", "node is None", "False", USELESS),
        Slip("return inside the loop", "    return found", "        return found", USELESS),
        Slip(
            "the height is left out",
            "dist(node.point, target)",
            "dist(node.point[:2], target[:2])",
            PARTLY,
        ),
        Slip(
            "nothing is pruned on either side",
            "target[axis] - tolerance < split:\n"
            "            waiting.append((node.left, depth + 1))\n"
            "        if target[axis] + tolerance >= split",
            "True:\n            waiting.append((node.left, depth + 1))\n        if True",
            MISSING,
        ),
        Slip("returns a generator", "return found", "return (index for index in found)", USELESS),
        Slip(
            "no [axis] after the node's point",
            "split = node.point[axis]",
            "split = node.point",
            USELESS,
        ),
    ],
    "median_order": [
        Slip("uses the upper median", _MIDDLE, "len(rows) // 2", SMALL),
        Slip(
            "starts with y", "(np.arange(len(points)), 0)", "(np.arange(len(points)), 1)", USELESS
        ),
        Slip(
            "sorts by x only", "points[rows, depth % points.shape[1]]", "points[rows, 0]", USELESS
        ),
        Slip("2 instead of the number of axes", "% points.shape[1]", "% 2", PARTLY),
        Slip(
            "positions instead of row numbers",
            'rows = rows[np.argsort(along, kind="stable")]',
            'rows = np.argsort(along, kind="stable")',
            USELESS,
        ),
        Slip("does not sort", 'rows = rows[np.argsort(along, kind="stable")]', "", USELESS),
        Slip(
            "the median is repeated",
            "rows[middle + 1:]",
            "rows[middle:] if middle else rows[1:]",
            USELESS,
        ),
        Slip("a row is lost", "rows[middle + 1:]", "rows[middle + 2:]", USELESS),
        Slip(
            "the depth does not grow on the right",
            "rows[middle + 1:], depth + 1",
            "rows[middle + 1:], depth",
            USELESS,
        ),
        Slip(
            "sorts in descending order",
            'rows[np.argsort(along, kind="stable")]',
            'rows[np.argsort(-along, kind="stable")]',
            SMALL,
        ),
        Slip("points instead of row numbers", "int(rows[middle])", "points[rows[middle]]", USELESS),
        Slip("does not test for an empty part", "len(rows) == 0", "False", USELESS),
        Slip("break instead of continue", "continue", "break", USELESS),
        Slip("return inside the loop", "    return order", "        return order", USELESS),
        Slip("missing parentheses", "(len(rows) - 1) // 2", "len(rows) - 1 // 2", USELESS),
        Slip(
            "omits the right half",
            "(rows[:middle], depth + 1), (rows[middle + 1:], depth + 1)",
            "(rows[:middle], depth + 1)",
            USELESS,
        ),
    ],
}
