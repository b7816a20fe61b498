"""Slips in lesson 11."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_YAW = "quarter_turn[np.argmax(closeness_at(points, quarter_turn))]"
_POINTS = "straight = turned(points, -yaw)"
_CORNERS = "turned(np.array(corners), yaw)"

SLIPS = {
    "principal_axes": [
        Slip("axes in ascending order", "ascending[:, ::-1]", "ascending", USELESS),
        Slip("reorders rows instead of columns", "ascending[:, ::-1]", "ascending[::-1]", USELESS),
        Slip("returns the axes as rows", "return by_spread", "return by_spread.T", USELESS),
        Slip("not centred", "xyz - xyz.mean(axis=0)", "xyz", USELESS),
        Slip(
            "mean of each point's coordinates",
            "xyz.mean(axis=0)",
            "xyz.mean(axis=1)[:, None]",
            USELESS,
        ),
        Slip(
            "uses z-scores",
            "xyz - xyz.mean(axis=0)",
            "(xyz - xyz.mean(axis=0)) / (xyz.std(axis=0) + 1e-9)",
            USELESS,
        ),
        Slip("treats rows as variables", "centred.T @ centred", "centred @ centred.T", USELESS),
        Slip("ignores handedness", "by_spread[:, 2] *= -1", "pass", PARTLY),
        Slip("mirrors right-handed axes", "det(by_spread) < 0", "det(by_spread) > 0", PARTLY),
        Slip(
            "flips a row instead of a column",
            "by_spread[:, 2] *= -1",
            "by_spread[2] *= -1",
            USELESS,
        ),
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
            "returns nothing for right-handed axes",
            "        by_spread[:, 2] *= -1\n    return by_spread",
            "        by_spread[:, 2] *= -1\n        return by_spread",
            USELESS,
        ),
        Slip(
            "leaves singular vectors in rows",
            "np.linalg.eigh(centred.T @ centred / len(xyz))",
            "np.linalg.eigh(centred.T @ centred / len(xyz))[0], np.linalg.svd(centred)[2][::-1]",
            USELESS,
        ),
        Slip(
            "does not handle an empty cloud",
            "    if len(xyz) == 0:\n        return np.eye(3)\n",
            "",
            SMALL,
        ),
        Slip("columns shifted by one", "(axis=1), :3]", "(axis=1), 1:4]", USELESS),
        Slip("uses all four columns", "(axis=1), :3]", "(axis=1)]", PARTLY),
    ],
    "get_oriented_boxes": [
        Slip("turns by minus yaw twice", _CORNERS, _CORNERS.replace("yaw", "-yaw"), USELESS),
        Slip("turns by plus yaw twice", _POINTS, _POINTS.replace("-yaw", "yaw"), USELESS),
        Slip("does not turn the corners back", _CORNERS, "np.array(corners)", USELESS),
        Slip("never turns the points", _YAW, "0.0", USELESS),
        Slip(
            "chooses the rectangle with the smallest closeness", "np.argmax", "np.argmin", USELESS
        ),
        Slip(
            "chooses the largest rectangle",
            _YAW,
            "quarter_turn[np.argmax(floor_area_at(points, quarter_turn))]",
            USELESS,
        ),
        Slip(
            "uses the index as the angle",
            _YAW,
            "np.argmax(closeness_at(points, quarter_turn))",
            USELESS,
        ),
        Slip(
            "degrees instead of radians",
            _YAW,
            "np.degrees(quarter_turn[np.argmax(closeness_at(points, quarter_turn))])",
            USELESS,
        ),
        Slip(
            "uses the yaw of the first 3-D axis",
            _YAW,
            "np.arctan2(*principal_axes(points)[[1, 0], 0])",
            PARTLY,
        ),
        Slip(
            "takes the minimum before the turn",
            "straight.min(axis=0)",
            "points.min(axis=0)",
            USELESS,
        ),
        Slip("adds a box for label 0", "(cluster_labels > 0)", "(cluster_labels >= 0)", PARTLY),
        Slip(
            "wrong shape if there are no clusters",
            "np.array(boxes).reshape(-1, 8, 3)",
            "np.array(boxes)",
            SMALL,
        ),
        Slip(
            "tries only half of the angles",
            "quarter_turn = np.radians(np.arange(90))",
            "quarter_turn = np.radians(np.arange(45))",
            PARTLY,
        ),
        Slip(
            "uses the mean as the centre",
            "straight.min(axis=0), straight.max(axis=0)",
            "straight.mean(axis=0) - np.ptp(straight, axis=0) / 2, "
            "straight.mean(axis=0) + np.ptp(straight, axis=0) / 2",
            PARTLY,
        ),
        Slip(
            "cuts off the outermost points",
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
        Slip("columns shifted by one", "== label), :3]", "== label), 1:4]", USELESS),
        Slip(
            "computes a mask but does not use it",
            "points = cloud[measured & (cluster_labels == label), :3]",
            "chosen = measured & (cluster_labels == label)\n        points = cloud[:, :3]",
            USELESS,
        ),
        Slip(
            "roof at the height of the floor", "(bottom, top) for", "(bottom, bottom) for", PARTLY
        ),
    ],
}
