"""Slips in lesson 02."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_VALUE = "a * points[:, 0] + b * points[:, 1] + c"
_BETTER = "inliers.sum() > best_inliers.sum()"
_DRAW = "rng.choice(len(points), size=2, replace=False)"
_KEEP = "best_line, best_inliers = line, inliers"

SLIPS = {
    "line_through": [
        Slip(
            "c has the wrong sign", "b, -(a * p[0] + b * p[1])", "b, a * p[0] + b * p[1]", USELESS
        ),
        Slip("swaps dx and dy without changing a sign", "a, b = -dy /", "a, b = dy /", USELESS),
        Slip(
            "direction instead of normal",
            "-dy / length, dx / length",
            "dx / length, dy / length",
            USELESS,
        ),
        Slip("not divided by the length", "-dy / length, dx / length", "-dy, dx", PARTLY),
        Slip("b missing from c", "(a * p[0] + b * p[1])", "(a * p[0])", USELESS),
        Slip("c uses the x of p twice", "b * p[1])", "b * p[0])", USELESS),
        Slip(
            "wrong sign in one term of c", "-(a * p[0] + b * p[1])", "-a * p[0] + b * p[1]", USELESS
        ),
        Slip("dy measured from q to p", "q[1] - p[1]", "p[1] - q[1]", USELESS),
        Slip("never returns None", "if not length > 0", "if length < 0", PARTLY),
        Slip("returns None for close points", "not length > 0", "length < 0.5", SMALL),
        Slip("returns None if dx is 0", "not length > 0", "dx == 0", PARTLY),
        Slip("divided by the squared length", "np.hypot(dx, dy)", "dx**2 + dy**2", PARTLY),
        Slip("a and b swapped", "return a, b, -(a", "return b, a, -(a", USELESS),
        Slip("no return statement", "return a, b, -(a", "line = a, b, -(a", USELESS),
        Slip("returns None if dx or dy is 0", "not length > 0", "dx == 0 or dy == 0", PARTLY),
        Slip("no [1] after a point", "q[1] - p[1]", "q[1] - p", USELESS),
    ],
    "point_line_distance": [
        Slip("no absolute value", f"np.abs({_VALUE})", _VALUE, USELESS),
        Slip("c missing", " + c)", ")", USELESS),
        Slip("c subtracted", " + c)", " - c)", USELESS),
        Slip("c outside the parentheses", "points[:, 1] + c)", "points[:, 1]) + c", USELESS),
        Slip("squared distances", f"np.abs({_VALUE})", f"({_VALUE}) ** 2", USELESS),
        Slip(
            "rows instead of columns",
            f"np.abs({_VALUE})",
            "np.abs(a * points[0] + b * points[1] + c)",
            USELESS,
        ),
        Slip(
            "x and y swapped",
            "points[:, 0] + b * points[:, 1]",
            "points[:, 1] + b * points[:, 0]",
            USELESS,
        ),
        Slip("b has the wrong sign", "+ b *", "- b *", USELESS),
        Slip("only the largest distance", f"np.abs({_VALUE})", f"np.abs({_VALUE}).max()", USELESS),
        Slip(
            "divided by the length of (a, b, c)",
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
            "no return statement",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "distance = np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            USELESS,
        ),
        Slip(
            "mask instead of distances",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c) < 0.5",
            USELESS,
        ),
        Slip(
            "prints instead of returning",
            "return np.abs(a * points[:, 0] + b * points[:, 1] + c)",
            "print(np.abs(a * points[:, 0] + b * points[:, 1] + c))",
            USELESS,
        ),
        Slip(
            "adds before multiplying",
            "a * points[:, 0] + b * points[:, 1] + c",
            "a * (points[:, 0] + b * points[:, 1]) + c",
            USELESS,
        ),
    ],
    "ransac_line": [
        Slip("returns the last line", f"if {_BETTER}", "if True", USELESS),
        Slip(
            "returns the worst line",
            _BETTER,
            "inliers.sum() < best_inliers.sum() or best_line is None",
            USELESS,
        ),
        Slip("returns the first line", _BETTER, "best_line is None", USELESS),
        Slip("keeps only the mask", _KEEP, "best_inliers = inliers", USELESS),
        Slip("keeps only the line", _KEEP, "best_line = line", USELESS),
        Slip("outliers instead of inliers", "line) <= distance", "line) >= distance", USELESS),
        Slip("draws with replacement", _DRAW, "rng.integers(len(points), size=2)", SMALL),
        Slip("break instead of continue", "continue", "break", SMALL),
        Slip("does not test for None", "line is None", "False", SMALL),
        Slip("one round missing", "range(max_iterations)", "range(1, max_iterations)", SMALL),
        Slip("always runs fifty rounds", "range(max_iterations)", "range(50)", SMALL),
        Slip("fixed seed", "default_rng(rng)  #", "default_rng(0)  #", SMALL),
        Slip(
            "does not create a generator from a seed",
            "rng = np.random.default_rng(rng)  #",
            "#",
            SMALL,
        ),
        Slip("does not test for too few points", "len(points) < 2", "False", SMALL),
        Slip("rejects a cloud of two points", "len(points) < 2", "len(points) <= 2", SMALL),
        Slip("squared tolerance", "<= distance_tolerance", "<= distance_tolerance**2", PARTLY),
        Slip("fixed tolerance", "<= distance_tolerance", "<= 0.5", PARTLY),
        Slip(
            "returns the mask before the line",
            "\n    return best_line, best_inliers",
            "\n    return best_inliers, best_line",
            USELESS,
        ),
        Slip(
            "returns the last mask",
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
            "accepts any line with an inlier",
            "inliers.sum() > best_inliers.sum()",
            "inliers.sum() > 0",
            USELESS,
        ),
        Slip(
            "draws only neighbouring rows",
            "rng.choice(len(points), size=2, replace=False)",
            "rng.integers(len(points) - 1) + np.array([0, 1])",
            SMALL,
        ),
        Slip(
            "same sample in each round",
            "        first, second =",
            "        rng = np.random.default_rng(0)\n        first, second =",
            USELESS,
        ),
        Slip(
            "row numbers instead of points",
            "line_through(points[first], points[second])",
            "line_through(first, second)",
            USELESS,
        ),
        Slip("all points instead of the second", "points[second]", "points", USELESS),
    ],
}
