"""Slips in lesson 03."""

from tests.slips import MISSING, PARTLY, SMALL, USELESS, Slip

_DISTANCE = "points[:, :3] @ normal + offset"
_BETTER = "np.count_nonzero(close) > np.count_nonzero(inliers)"
_DRAW = "rng.choice(len(points), 3, replace=False)"
_KEEP = "model, inliers = candidate, close"
_SVD = "points[:, :3] - centre, full_matrices=False"

SLIPS = {
    "plane_through": [
        Slip("d has the wrong sign", "-normal @ p", "normal @ p", USELESS),
        Slip("d is always 0", "(*normal, -normal @ p)", "(*normal, 0.0)", USELESS),
        Slip("returns only three numbers", "(*normal, -normal @ p)", "tuple(normal)", USELESS),
        Slip("not divided by the length", "normal = normal / length", "", PARTLY),
        Slip(
            "d not divided by the length",
            "return (*normal, -normal @ p)",
            "return (*normal, -normal @ p * length)",
            USELESS,
        ),
        Slip("points instead of sides", "q - p, r - p", "p, q", USELESS),
        Slip("p not subtracted from r", "r - p)", "r)", USELESS),
        Slip("one side used twice", "r - p)", "q - p)", USELESS),
        Slip("never returns None", "length < 1e-9", "False", PARTLY),
        Slip("compares with exactly 0", "length < 1e-9", "length == 0", SMALL),
        Slip("returns None for small triangles", "length < 1e-9", "length < 0.1", SMALL),
        Slip(
            "element-wise product instead of cross product",
            "np.cross(q - p, r - p)",
            "(q - p) * (r - p)",
            USELESS,
        ),
        Slip("returns a pair", "(*normal, -normal @ p)", "normal, -normal @ p", USELESS),
        Slip(
            "no return statement",
            "return (*normal, -normal @ p)",
            "plane = (*normal, -normal @ p)",
            USELESS,
        ),
        Slip(
            "dot product instead of cross product",
            "np.cross(q - p, r - p)",
            "np.dot(q - p, r - p)",
            USELESS,
        ),
    ],
    "point_plane_distance": [
        Slip("no absolute value", f"np.abs({_DISTANCE})", _DISTANCE, USELESS),
        Slip("d missing", " + offset)", ")", USELESS),
        Slip("d subtracted", "+ offset)", "- offset)", USELESS),
        Slip("d outside the parentheses", "normal + offset)", "normal) + offset", USELESS),
        Slip("squared distances", f"np.abs({_DISTANCE})", f"({_DISTANCE}) ** 2", USELESS),
        Slip(
            "multiplies all four columns",
            f"np.abs({_DISTANCE})",
            "np.abs(points @ np.asarray(plane))",
            USELESS,
        ),
        Slip("needs three columns", "points[:, :3]", "points", PARTLY),
        Slip(
            "only the largest distance",
            f"np.abs({_DISTANCE})",
            f"np.abs({_DISTANCE}).max()",
            USELESS,
        ),
        Slip("fails for a tuple", "np.asarray(plane[:3])", "plane[:3] * 1.0", SMALL),
        Slip(
            "divided by the length of (a, b, c, d)",
            f"np.abs({_DISTANCE})",
            f"np.abs({_DISTANCE}) / np.linalg.norm(plane)",
            USELESS,
        ),
        Slip(
            "absolute value of each product",
            f"np.abs({_DISTANCE})",
            "np.abs(points[:, :3] * normal).sum(axis=1) + offset",
            USELESS,
        ),
        Slip(
            "measures distances along z",
            "np.abs(points[:, :3] @ normal + offset)",
            "np.abs(points[:, :3] @ normal + offset) / abs(normal[2])",
            USELESS,
        ),
        Slip(
            "mask instead of distances",
            "np.abs(points[:, :3] @ normal + offset)",
            "np.abs(points[:, :3] @ normal + offset) <= 0.2",
            USELESS,
        ),
        Slip(
            "no return statement",
            "return np.abs(points[:, :3] @ normal + offset)",
            "distance = np.abs(points[:, :3] @ normal + offset)",
            USELESS,
        ),
        Slip(
            "return inside the loop",
            "return np.abs(points[:, :3] @ normal + offset)",
            "distances = []\n"
            "    for point in points[:, :3]:\n"
            "        distances.append(abs(point @ normal + offset))\n"
            "        return np.array(distances)",
            USELESS,
        ),
        Slip("columns shifted by one", "points[:, :3]", "points[:, 1:4]", USELESS),
        Slip("no [3] after the plane", "plane[3]", "plane", USELESS),
    ],
    "ransac_plane": [
        Slip("returns the last plane", f"if {_BETTER}", "if True", USELESS),
        Slip("returns the first plane", _BETTER, "model is None", USELESS),
        Slip(
            "returns the worst plane",
            _BETTER,
            "np.count_nonzero(close) < np.count_nonzero(inliers) or model is None",
            USELESS,
        ),
        Slip("keeps only the mask", _KEEP, "inliers = close", USELESS),
        Slip("keeps only the model", _KEEP, "model = candidate", USELESS),
        Slip(
            "outliers instead of inliers",
            "candidate) <= distance",
            "candidate) >= distance",
            USELESS,
        ),
        Slip(
            "inverted mask",
            "\n    return model, inliers",
            "\n    return model, ~inliers",
            USELESS,
        ),
        Slip("draws with replacement", _DRAW, "rng.integers(len(points), size=3)", SMALL),
        Slip("break instead of continue", "continue", "break", SMALL),
        Slip("does not test for None", "candidate is None", "False", SMALL),
        Slip("one round missing", "range(max_iterations)", "range(1, max_iterations)", SMALL),
        Slip("always runs fifty rounds", "range(max_iterations)", "range(50)", SMALL),
        Slip("fixed seed", "= np.random.default_rng(rng)", "= np.random.default_rng(0)", SMALL),
        Slip(
            "does not create a generator from a seed", "rng = np.random.default_rng(rng)", "", SMALL
        ),
        Slip("does not test for too few points", "len(points) < 3", "False", SMALL),
        Slip("rejects a cloud of three points", "len(points) < 3", "len(points) <= 3", SMALL),
        Slip("four columns in the sample", "points[sample, :3]", "points[sample]", PARTLY),
        Slip("fixed tolerance", "<= distance_tolerance", "<= 0.3", PARTLY),
        Slip(
            "returns the mask before the model",
            "\n    return model, inliers",
            "\n    return inliers, model",
            USELESS,
        ),
        Slip(
            "returns the last mask",
            "\n    return model, inliers",
            "\n    return model, close",
            USELESS,
        ),
        Slip(
            "return inside the loop",
            "\n    return model, inliers",
            "\n        return model, inliers",
            USELESS,
        ),
        Slip(
            "accepts any plane with an inlier",
            "np.count_nonzero(close) > np.count_nonzero(inliers)",
            "np.count_nonzero(close) > 0",
            USELESS,
        ),
        Slip(
            "draws only neighbouring rows",
            "rng.choice(len(points), 3, replace=False)",
            "rng.integers(len(points) - 2) + np.arange(3)",
            SMALL,
        ),
        Slip(
            "same sample in each round",
            "        sample =",
            "        rng = np.random.default_rng(0)\n        sample =",
            USELESS,
        ),
        Slip(
            "mask of zeros and ones",
            "\n    return model, inliers",
            "\n    return model, inliers.astype(int)",
            USELESS,
        ),
        Slip(
            "row numbers instead of a mask",
            "\n    return model, inliers",
            "\n    return model, np.flatnonzero(inliers)",
            USELESS,
        ),
        Slip("columns shifted by one", "points[sample, :3]", "points[sample, 1:4]", USELESS),
    ],
    "fit_plane": [
        Slip("not centred", "points[:, :3] - centre,", "points[:, :3],", USELESS),
        Slip("direction of largest spread", "by_spread[2]", "by_spread[0]", USELESS),
        Slip("direction of second largest spread", "by_spread[2]", "by_spread[1]", USELESS),
        Slip("column instead of row", "by_spread[2]", "by_spread[:, 2]", USELESS),
        Slip("d has the wrong sign", "-least @ centre", "least @ centre", USELESS),
        Slip("d is always 0", "-least @ centre", "0.0", USELESS),
        Slip(
            "uses all four columns",
            "centre = points[:, :3].mean(axis=0)\n    by_spread = np.linalg.svd(points[:, :3] -",
            "centre = points.mean(axis=0)\n    by_spread = np.linalg.svd(points -",
            PARTLY,
        ),
        Slip("mean of each row", "mean(axis=0)", "mean(axis=1)[:3]", USELESS),
        Slip("one mean for all columns", "mean(axis=0)", "mean() * np.ones(3)", USELESS),
        Slip(
            "uses the first result of the SVD",
            "full_matrices=False)[2]",
            "full_matrices=False)[0]",
            USELESS,
        ),
        Slip("computes full matrices", ", full_matrices=False", "", SMALL),
        Slip(
            "plane through the first three points",
            "    centre = points[:, :3].mean(axis=0)\n"
            "    by_spread = np.linalg.svd(points[:, :3] - centre, "
            "full_matrices=False)[2]\n"
            "    least = by_spread[2]\n"
            "    return (*least, -least @ centre)",
            "    return plane_through(*points[:3, :3])",
            MISSING,
        ),
        Slip(
            "errors measured along z",
            "    centre = points[:, :3].mean(axis=0)\n"
            "    by_spread = np.linalg.svd(points[:, :3] - centre, "
            "full_matrices=False)[2]\n"
            "    least = by_spread[2]\n"
            "    return (*least, -least @ centre)",
            "    a, b, c = np.linalg.lstsq(np.c_[points[:, :2], "
            "np.ones(len(points))], points[:, 2], rcond=None)[0]\n"
            "    length = np.sqrt(a * a + b * b + 1)\n"
            "    return a / length, b / length, -1 / length, c / length",
            PARTLY,
        ),
        Slip("no return statement", "return (*least", "plane = (*least", USELESS),
        Slip(
            "median instead of mean",
            "points[:, :3].mean(axis=0)",
            "np.median(points[:, :3], axis=0)",
            PARTLY,
        ),
        Slip(
            "columns shifted by one",
            "np.linalg.svd(points[:, :3]",
            "np.linalg.svd(points[:, 1:4]",
            USELESS,
        ),
        Slip("no [2] after the SVD", "full_matrices=False)[2]", "full_matrices=False)", USELESS),
        Slip(
            "all directions instead of the last",
            "least = by_spread[2]",
            "least = by_spread",
            USELESS,
        ),
    ],
    "iterations_needed": [
        Slip("rounded down", "math.ceil", "math.floor", SMALL),
        Slip("not rounded", "math.ceil", "float", SMALL),
        Slip("exponent missing", "inlier_ratio**sample_size", "inlier_ratio", USELESS),
        Slip(
            "product instead of power",
            "inlier_ratio**sample_size",
            "inlier_ratio * sample_size",
            USELESS,
        ),
        Slip("always samples three points", "inlier_ratio**sample_size", "inlier_ratio**3", PARTLY),
        Slip(
            "logarithm of confidence", "math.log(1 - confidence)", "math.log(confidence)", USELESS
        ),
        Slip(
            "inverted quotient",
            "math.log(1 - confidence) / math.log1p(-good_sample)",
            "math.log1p(-good_sample) / math.log(1 - confidence)",
            USELESS,
        ),
        Slip("logarithm of w^s", "math.log1p(-good_sample)", "math.log(good_sample)", USELESS),
        Slip(
            "no special case for 0",
            "    if good_sample <= 0:\n        return math.inf\n",
            "",
            SMALL,
        ),
        Slip("no special case for 1", "    if good_sample >= 1:\n        return 1\n", "", SMALL),
        Slip("returns 0 if there are no inliers", "return math.inf", "return 0", SMALL),
        Slip(
            "outliers instead of inliers",
            "inlier_ratio**sample_size",
            "(1 - inlier_ratio) ** sample_size",
            USELESS,
        ),
        Slip("one round too many", "math.ceil(", "1 + math.ceil(", SMALL),
        Slip(
            "wrong sign in the logarithm",
            "math.log1p(-good_sample)",
            "math.log1p(good_sample)",
            USELESS,
        ),
        Slip("large number instead of infinity", "return math.inf", "return 10**9", SMALL),
    ],
}
