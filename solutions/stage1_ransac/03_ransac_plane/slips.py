"""Slips in lesson 03."""

from tests.slips import MISSING, PARTLY, SMALL, USELESS, Slip

_DISTANCE = "points[:, :3] @ normal + offset"
_BETTER = "np.count_nonzero(close) > np.count_nonzero(inliers)"
_DRAW = "rng.choice(len(points), 3, replace=False)"
_KEEP = "model, inliers = candidate, close"
_SVD = "points[:, :3] - centre, full_matrices=False"

SLIPS = {
    "plane_through": [
        Slip("d with the wrong sign", "-normal @ p", "normal @ p", USELESS),
        Slip("d left out", "(*normal, -normal @ p)", "(*normal, 0.0)", USELESS),
        Slip("only three numbers", "(*normal, -normal @ p)", "tuple(normal)", USELESS),
        Slip("not divided by the length", "normal = normal / length", "", PARTLY),
        Slip(
            "divided after d",
            "return (*normal, -normal @ p)",
            "return (*normal, -normal @ p * length)",
            USELESS,
        ),
        Slip("the points for the sides", "q - p, r - p", "p, q", USELESS),
        Slip("r as it is", "r - p)", "r)", USELESS),
        Slip("one side twice", "r - p)", "q - p)", USELESS),
        Slip("no None", "length < 1e-9", "False", PARTLY),
        Slip("exactly 0", "length < 1e-9", "length == 0", SMALL),
        Slip("small triangles are none", "length < 1e-9", "length < 0.1", SMALL),
        Slip(
            "a product for the cross product",
            "np.cross(q - p, r - p)",
            "(q - p) * (r - p)",
            USELESS,
        ),
        Slip("a pair", "(*normal, -normal @ p)", "normal, -normal @ p", USELESS),
        Slip(
            "no return", "return (*normal, -normal @ p)", "plane = (*normal, -normal @ p)", USELESS
        ),
        Slip("the scalar product", "np.cross(q - p, r - p)", "np.dot(q - p, r - p)", USELESS),
    ],
    "point_plane_distance": [
        Slip("no absolute value", f"np.abs({_DISTANCE})", _DISTANCE, USELESS),
        Slip("d left out", " + offset)", ")", USELESS),
        Slip("d subtracted", "+ offset)", "- offset)", USELESS),
        Slip("d behind the bracket", "normal + offset)", "normal) + offset", USELESS),
        Slip("squared", f"np.abs({_DISTANCE})", f"({_DISTANCE}) ** 2", USELESS),
        Slip(
            "all four columns",
            f"np.abs({_DISTANCE})",
            "np.abs(points @ np.asarray(plane))",
            USELESS,
        ),
        Slip("needs three columns", "points[:, :3]", "points", PARTLY),
        Slip("one number", f"np.abs({_DISTANCE})", f"np.abs({_DISTANCE}).max()", USELESS),
        Slip("takes arrays only", "np.asarray(plane[:3])", "plane[:3] * 1.0", SMALL),
        Slip(
            "divided by the length of all four",
            f"np.abs({_DISTANCE})",
            f"np.abs({_DISTANCE}) / np.linalg.norm(plane)",
            USELESS,
        ),
        Slip(
            "the absolute value of each product",
            f"np.abs({_DISTANCE})",
            "np.abs(points[:, :3] * normal).sum(axis=1) + offset",
            USELESS,
        ),
        Slip(
            "along z",
            "np.abs(points[:, :3] @ normal + offset)",
            "np.abs(points[:, :3] @ normal + offset) / abs(normal[2])",
            USELESS,
        ),
        Slip(
            "a mask for distances",
            "np.abs(points[:, :3] @ normal + offset)",
            "np.abs(points[:, :3] @ normal + offset) <= 0.2",
            USELESS,
        ),
        Slip(
            "no return",
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
    ],
    "ransac_plane": [
        Slip("the last plane", f"if {_BETTER}", "if True", USELESS),
        Slip("the first plane", _BETTER, "model is None", USELESS),
        Slip(
            "the worst plane",
            _BETTER,
            "np.count_nonzero(close) < np.count_nonzero(inliers) or model is None",
            USELESS,
        ),
        Slip("the model is not kept", _KEEP, "inliers = close", USELESS),
        Slip("the mask is not kept", _KEEP, "model = candidate", USELESS),
        Slip("outliers for inliers", "candidate) <= distance", "candidate) >= distance", USELESS),
        Slip(
            "the mask is turned around",
            "\n    return model, inliers",
            "\n    return model, ~inliers",
            USELESS,
        ),
        Slip("with replacement", _DRAW, "rng.integers(len(points), size=3)", SMALL),
        Slip("break for continue", "continue", "break", SMALL),
        Slip("None is not asked for", "candidate is None", "False", SMALL),
        Slip("a round is missing", "range(max_iterations)", "range(1, max_iterations)", SMALL),
        Slip("fifty rounds", "range(max_iterations)", "range(50)", SMALL),
        Slip(
            "a seed of its own", "= np.random.default_rng(rng)", "= np.random.default_rng(0)", SMALL
        ),
        Slip("no generator", "rng = np.random.default_rng(rng)", "", SMALL),
        Slip("too few points are not asked for", "len(points) < 3", "False", SMALL),
        Slip("three points are too few", "len(points) < 3", "len(points) <= 3", SMALL),
        Slip("four columns in the sample", "points[sample, :3]", "points[sample]", PARTLY),
        Slip("a tolerance of its own", "<= distance_tolerance", "<= 0.3", PARTLY),
        Slip(
            "the mask first",
            "\n    return model, inliers",
            "\n    return inliers, model",
            USELESS,
        ),
        Slip(
            "the last mask",
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
            "any inlier is enough",
            "np.count_nonzero(close) > np.count_nonzero(inliers)",
            "np.count_nonzero(close) > 0",
            USELESS,
        ),
        Slip(
            "three rows in a row",
            "rng.choice(len(points), 3, replace=False)",
            "rng.integers(len(points) - 2) + np.arange(3)",
            SMALL,
        ),
        Slip(
            "the same sample each round",
            "        sample =",
            "        rng = np.random.default_rng(0)\n        sample =",
            USELESS,
        ),
        Slip(
            "zeros and ones",
            "\n    return model, inliers",
            "\n    return model, inliers.astype(int)",
            USELESS,
        ),
        Slip(
            "row numbers for a mask",
            "\n    return model, inliers",
            "\n    return model, np.flatnonzero(inliers)",
            USELESS,
        ),
    ],
    "fit_plane": [
        Slip("not centred", "points[:, :3] - centre,", "points[:, :3],", USELESS),
        Slip("the largest spread", "by_spread[2]", "by_spread[0]", USELESS),
        Slip("the second direction", "by_spread[2]", "by_spread[1]", USELESS),
        Slip("a column", "by_spread[2]", "by_spread[:, 2]", USELESS),
        Slip("d with the wrong sign", "-least @ centre", "least @ centre", USELESS),
        Slip("d left out", "-least @ centre", "0.0", USELESS),
        Slip(
            "all four columns",
            "centre = points[:, :3].mean(axis=0)\n    by_spread = np.linalg.svd(points[:, :3] -",
            "centre = points.mean(axis=0)\n    by_spread = np.linalg.svd(points -",
            PARTLY,
        ),
        Slip("the mean of rows", "mean(axis=0)", "mean(axis=1)[:3]", USELESS),
        Slip("one mean for all", "mean(axis=0)", "mean() * np.ones(3)", USELESS),
        Slip("the first result", "full_matrices=False)[2]", "full_matrices=False)[0]", USELESS),
        Slip("full matrices", ", full_matrices=False", "", SMALL),
        Slip(
            "through the first three points",
            "    centre = points[:, :3].mean(axis=0)\n"
            "    by_spread = np.linalg.svd(points[:, :3] - centre, "
            "full_matrices=False)[2]\n"
            "    least = by_spread[2]\n"
            "    return (*least, -least @ centre)",
            "    return plane_through(*points[:3, :3])",
            MISSING,
        ),
        Slip(
            "errors along z",
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
        Slip("no return", "return (*least", "plane = (*least", USELESS),
        Slip(
            "the median for the mean",
            "points[:, :3].mean(axis=0)",
            "np.median(points[:, :3], axis=0)",
            PARTLY,
        ),
    ],
    "iterations_needed": [
        Slip("rounded down", "math.ceil", "math.floor", SMALL),
        Slip("not rounded", "math.ceil", "float", SMALL),
        Slip("no exponent", "inlier_ratio**sample_size", "inlier_ratio", USELESS),
        Slip(
            "a product for a power",
            "inlier_ratio**sample_size",
            "inlier_ratio * sample_size",
            USELESS,
        ),
        Slip("always a plane", "inlier_ratio**sample_size", "inlier_ratio**3", PARTLY),
        Slip("log of the confidence", "math.log(1 - confidence)", "math.log(confidence)", USELESS),
        Slip(
            "upside down",
            "math.log(1 - confidence) / math.log1p(-good_sample)",
            "math.log1p(-good_sample) / math.log(1 - confidence)",
            USELESS,
        ),
        Slip("log of w^s", "math.log1p(-good_sample)", "math.log(good_sample)", USELESS),
        Slip("no end at 0", "    if good_sample <= 0:\n        return math.inf\n", "", SMALL),
        Slip("no end at 1", "    if good_sample >= 1:\n        return 1\n", "", SMALL),
        Slip("0 without inliers", "return math.inf", "return 0", SMALL),
        Slip(
            "outliers for inliers",
            "inlier_ratio**sample_size",
            "(1 - inlier_ratio) ** sample_size",
            USELESS,
        ),
        Slip("one more", "math.ceil(", "1 + math.ceil(", SMALL),
        Slip(
            "the sign in the logarithm",
            "math.log1p(-good_sample)",
            "math.log1p(good_sample)",
            USELESS,
        ),
        Slip("a large number for infinity", "return math.inf", "return 10**9", SMALL),
    ],
}
