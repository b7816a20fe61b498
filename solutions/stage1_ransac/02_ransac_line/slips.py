"""Slips in lesson 02."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_VALUE = "a * points[:, 0] + b * points[:, 1] + c"
_BETTER = "inliers.sum() > best_inliers.sum()"
_DRAW = "rng.choice(len(points), size=2, replace=False)"
_KEEP = "best_line, best_inliers = line, inliers"

SLIPS = {
    "line_through": [
        Slip(
            "c with the wrong sign", "b, -(a * p[0] + b * p[1])", "b, a * p[0] + b * p[1]", USELESS
        ),
        Slip("turned without a sign", "a, b = -dy /", "a, b = dy /", USELESS),
        Slip(
            "the direction for the normal",
            "-dy / length, dx / length",
            "dx / length, dy / length",
            USELESS,
        ),
        Slip("not divided by the length", "-dy / length, dx / length", "-dy, dx", PARTLY),
        Slip("c without b", "(a * p[0] + b * p[1])", "(a * p[0])", USELESS),
        Slip("c from one coordinate", "b * p[1])", "b * p[0])", USELESS),
        Slip("a sign lost in c", "-(a * p[0] + b * p[1])", "-a * p[0] + b * p[1]", USELESS),
        Slip("p and q in one direction", "q[1] - p[1]", "p[1] - q[1]", USELESS),
        Slip("no None", "if not length > 0", "if length < 0", PARTLY),
        Slip("close points are none", "not length > 0", "length < 0.5", SMALL),
        Slip("upright lines are none", "not length > 0", "dx == 0", PARTLY),
        Slip("the squared length", "np.hypot(dx, dy)", "dx**2 + dy**2", PARTLY),
        Slip("a and b exchanged", "return a, b, -(a", "return b, a, -(a", USELESS),
        Slip("no return", "return a, b, -(a", "line = a, b, -(a", USELESS),
        Slip("None as soon as one way is 0", "not length > 0", "dx == 0 or dy == 0", PARTLY),
    ],
    "point_line_distance": [
        Slip("no absolute value", f"np.abs({_VALUE})", _VALUE, USELESS),
        Slip("c left out", " + c)", ")", USELESS),
        Slip("c subtracted", " + c)", " - c)", USELESS),
        Slip("c behind the bracket", "points[:, 1] + c)", "points[:, 1]) + c", USELESS),
        Slip("squared", f"np.abs({_VALUE})", f"({_VALUE}) ** 2", USELESS),
        Slip(
            "rows for columns",
            f"np.abs({_VALUE})",
            "np.abs(a * points[0] + b * points[1] + c)",
            USELESS,
        ),
        Slip(
            "x and y exchanged",
            "points[:, 0] + b * points[:, 1]",
            "points[:, 1] + b * points[:, 0]",
            USELESS,
        ),
        Slip("the sign of b", "+ b *", "- b *", USELESS),
        Slip("the largest alone", f"np.abs({_VALUE})", f"np.abs({_VALUE}).max()", USELESS),
        Slip(
            "divided by the length of all three",
            f"np.abs({_VALUE})",
            f"np.abs({_VALUE}) / np.linalg.norm(line)",
            USELESS,
        ),
        Slip(
            "return inside the loop",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "distances = []\n"
            "    for x, y in points[:, :2]:\n"
            "        distances.append(abs(a * x + b * y + c))\n"
            "        return np.array(distances)",
            USELESS,
        ),
        Slip(
            "no return",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "distance = np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            USELESS,
        ),
        Slip(
            "a mask for distances",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c) < 0.5",
            USELESS,
        ),
        Slip(
            "prints",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "print(np.abs(a * points[:, 0] + b * points[:, 1] + c))",
            USELESS,
        ),
        Slip(
            "adds before the product",
            "a * points[:, 0] + b * points[:, 1] + c",
            "a * (points[:, 0] + b * points[:, 1]) + c",
            USELESS,
        ),
    ],
    "ransac_line": [
        Slip("the last line", f"if {_BETTER}", "if True", USELESS),
        Slip(
            "the worst line",
            _BETTER,
            "inliers.sum() < best_inliers.sum() or best_line is None",
            USELESS,
        ),
        Slip("the first line", _BETTER, "best_line is None", USELESS),
        Slip("the line is not kept", _KEEP, "best_inliers = inliers", USELESS),
        Slip("the mask is not kept", _KEEP, "best_line = line", USELESS),
        Slip("outliers for inliers", "line) <= distance", "line) >= distance", USELESS),
        Slip("with replacement", _DRAW, "rng.integers(len(points), size=2)", SMALL),
        Slip("break for continue", "continue", "break", SMALL),
        Slip("None is not asked for", "line is None", "False", SMALL),
        Slip("a round is missing", "range(max_iterations)", "range(1, max_iterations)", SMALL),
        Slip("fifty rounds", "range(max_iterations)", "range(50)", SMALL),
        Slip("a seed of its own", "default_rng(rng)  #", "default_rng(0)  #", SMALL),
        Slip("no generator", "rng = np.random.default_rng(rng)  #", "#", SMALL),
        Slip("too few points are not asked for", "len(points) < 2", "False", SMALL),
        Slip("two points are too few", "len(points) < 2", "len(points) <= 2", SMALL),
        Slip("the squared tolerance", "<= distance_tolerance", "<= distance_tolerance**2", PARTLY),
        Slip("a tolerance of its own", "<= distance_tolerance", "<= 0.5", PARTLY),
        Slip(
            "the mask first",
            "\n    return best_line, best_inliers",
            "\n    return best_inliers, best_line",
            USELESS,
        ),
        Slip(
            "the last mask",
            "\n    return best_line, best_inliers",
            "\n    return best_line, inliers",
            USELESS,
        ),
        Slip(
            "return inside the loop",
            "\n    return best_line, best_inliers",
            "\n        return best_line, best_inliers",
            USELESS,
        ),
        Slip(
            "any inlier is enough",
            "inliers.sum() > best_inliers.sum()",
            "inliers.sum() > 0",
            USELESS,
        ),
        Slip(
            "neighbours alone",
            "rng.choice(len(points), size=2, replace=False)",
            "rng.integers(len(points) - 1) + np.array([0, 1])",
            SMALL,
        ),
        Slip(
            "the same sample each round",
            "        first, second =",
            "        rng = np.random.default_rng(0)\n        first, second =",
            USELESS,
        ),
        Slip(
            "row numbers for points",
            "line_through(points[first], points[second])",
            "line_through(first, second)",
            USELESS,
        ),
    ],
}
