"""Slips in lesson 11."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_YAW = "quarter_turn[np.argmax(closeness_at(points, quarter_turn))]"
_POINTS = "straight = turned(points, -yaw)"
_CORNERS = "turned(np.array(corners), yaw)"

SLIPS = {
    "principal_axes": [
        Slip("axes in ascending order", "ascending[:, ::-1]", "ascending", USELESS),
        Slip("rows reordered, not columns", "ascending[:, ::-1]", "ascending[::-1]", USELESS),
        Slip("axes in rows", "return by_spread", "return by_spread.T", USELESS),
        Slip("not centred", "xyz - xyz.mean(axis=0)", "xyz", USELESS),
        Slip(
            "mean over each point's coordinates",
            "xyz.mean(axis=0)",
            "xyz.mean(axis=1)[:, None]",
            USELESS,
        ),
        Slip(
            "z-score",
            "xyz - xyz.mean(axis=0)",
            "(xyz - xyz.mean(axis=0)) / (xyz.std(axis=0) + 1e-9)",
            USELESS,
        ),
        Slip("rows used as variables", "centred.T @ centred", "centred @ centred.T", USELESS),
        Slip("handedness ignored", "by_spread[:, 2] *= -1", "pass", PARTLY),
        Slip("right-handed axes mirrored", "det(by_spread) < 0", "det(by_spread) > 0", PARTLY),
        Slip("a row flipped", "by_spread[:, 2] *= -1", "by_spread[2] *= -1", USELESS),
        Slip(
            "determinant of the unordered axes", "det(by_spread) < 0", "det(ascending) < 0", PARTLY
        ),
        Slip(
            "correlation instead of covariance",
            "centred.T @ centred / len(xyz)",
            "np.corrcoef(centred.T)",
            USELESS,
        ),
        Slip(
            "no return for right-handed axes",
            "        by_spread[:, 2] *= -1\n    return by_spread",
            "        by_spread[:, 2] *= -1\n        return by_spread",
            USELESS,
        ),
        Slip(
            "singular vectors of the rows",
            "np.linalg.eigh(centred.T @ centred / len(xyz))",
            "np.linalg.eigh(centred.T @ centred / len(xyz))[0], np.linalg.svd(centred)[2][::-1]",
            USELESS,
        ),
        Slip(
            "no special case for no points",
            "    if len(xyz) == 0:\n        return np.eye(3)\n",
            "",
            SMALL,
        ),
    ],
    "get_oriented_boxes": [
        Slip("turned by minus yaw twice", _CORNERS, _CORNERS.replace("yaw", "-yaw"), USELESS),
        Slip("turned by plus yaw twice", _POINTS, _POINTS.replace("-yaw", "yaw"), USELESS),
        Slip("corners not turned back", _CORNERS, "np.array(corners)", USELESS),
        Slip("not turned at all", _YAW, "0.0", USELESS),
        Slip("the rectangle with the smallest closeness", "np.argmax", "np.argmin", USELESS),
        Slip(
            "the largest rectangle",
            _YAW,
            "quarter_turn[np.argmax(floor_area_at(points, quarter_turn))]",
            USELESS,
        ),
        Slip("index used as angle", _YAW, "np.argmax(closeness_at(points, quarter_turn))", USELESS),
        Slip(
            "degrees instead of radians",
            _YAW,
            "np.degrees(quarter_turn[np.argmax(closeness_at(points, quarter_turn))])",
            USELESS,
        ),
        Slip(
            "yaw of the first axis in space",
            _YAW,
            "np.arctan2(*principal_axes(points)[[1, 0], 0])",
            PARTLY,
        ),
        Slip("minimum before the turn", "straight.min(axis=0)", "points.min(axis=0)", USELESS),
        Slip("a box for label 0", "(cluster_labels > 0)", "(cluster_labels >= 0)", PARTLY),
        Slip(
            "wrong shape without clusters",
            "np.array(boxes).reshape(-1, 8, 3)",
            "np.array(boxes)",
            SMALL,
        ),
        Slip(
            "half of the angles tried",
            "quarter_turn = np.radians(np.arange(90))",
            "quarter_turn = np.radians(np.arange(45))",
            PARTLY,
        ),
        Slip(
            "mean used as the centre",
            "straight.min(axis=0), straight.max(axis=0)",
            "straight.mean(axis=0) - np.ptp(straight, axis=0) / 2, "
            "straight.mean(axis=0) + np.ptp(straight, axis=0) / 2",
            PARTLY,
        ),
        Slip(
            "the outermost points cut off",
            "straight.min(axis=0), straight.max(axis=0)",
            "np.quantile(straight, 0.01, axis=0), np.quantile(straight, 0.99, axis=0)",
            PARTLY,
        ),
        Slip(
            "return inside the loop",
            "    return np.array(boxes)",
            "        return np.array(boxes)",
            USELESS,
        ),
    ],
}
