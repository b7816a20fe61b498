"""Slips in lesson 12."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_CENTRES = "current.mean(axis=1)[:, None] - previous.mean(axis=1)"
_CROSSED_OUT = "distances[row, :] = distances[:, column] = np.inf"
_PLANE = """\
    low = by_columns(points[points[:, 2] < ground_level])
    plane, near = ransac_plane(low, 50, 0.2, 0)
    if plane is not None:
        points = points[point_plane_distance(points, fit_plane(low[near])) > 0.3]
"""
_EGO = """\
    points = remove_ego_returns(by_columns(points), (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
"""

SLIPS = {
    "detect_obstacles": [
        Slip("keeps the road", _PLANE, "", USELESS),
        Slip("keeps only the road", "low[near])) > 0.3", "low[near])) < 0.3", USELESS),
        Slip("fits the plane to all returns", "ransac_plane(low,", "ransac_plane(points,", USELESS),
        Slip("keeps the ego car", _EGO, "", PARTLY),
        Slip(
            "ignores the result of filter_clusters",
            "labels = filter_clusters(labels",
            "filter_clusters(labels",
            PARTLY,
        ),
        Slip("a minimum of 100 points", "(labels, min_num_points)", "(labels, 100)", PARTLY),
        Slip(
            "a threshold of two metres",
            "accelerated(points, threshold)",
            "accelerated(points, 2.0)",
            USELESS,
        ),
        Slip("a region that ends at 8 m", "maximum)\n", "(8.0, 9.0, 1.0))\n", SMALL),
        Slip(
            "axis-aligned boxes",
            "return get_oriented_boxes(points, labels)",
            """\
boxes = []
    for label in np.unique(labels[labels > 0]):
        mine = points[labels == label]
        low, high = mine.min(axis=0), mine.max(axis=0)
        floor = [(high[0], high[1]), (low[0], high[1]), (low[0], low[1]), (high[0], low[1])]
        boxes.append([(x, y, z) for z in (low[2], high[2]) for x, y in floor])
    return np.array(boxes).reshape(-1, 8, 3)""",
            PARTLY,
        ),
        Slip(
            "works only on clouds with intensities", "cloud[:, :3]", "cloud[:, [0, 1, 2, 3]]", SMALL
        ),
        Slip(
            "removes too large a box for the ego car", "(2.6, 1.7, -0.4)", "(4.0, 4.0, 4.0)", SMALL
        ),
        Slip(
            "a region only 7 m wide",
            "minimum, maximum)\n",
            "(-15.0, -3.5, -3.0), (35.0, 3.5, 1.0))\n",
            SMALL,
        ),
        Slip(
            "removes large clusters",
            "labels = filter_clusters(labels, min_num_points)",
            "labels = filter_clusters(labels, min_num_points)\n"
            "    labels = np.where(np.bincount(labels)[labels] > 400, 0, labels)",
            SMALL,
        ),
        Slip(
            "a threshold of one metre",
            "accelerated(points, threshold)",
            "accelerated(points, 1.0)",
            SMALL,
        ),
        Slip(
            "fits the plane to the high points",
            "points[points[:, 2] < ground_level]",
            "points[points[:, 2] > ground_level]",
            USELESS,
        ),
        Slip("columns shifted by one", "cloud[:, :3]", "cloud[:, 1:4]", USELESS),
        Slip("3 instead of 0.3", "> 0.3]", "> 3]", USELESS),
        Slip(
            "voxels of 2 m instead of 0.2 m",
            "voxel_grid(points, 0.2)",
            "voxel_grid(points, 2)",
            USELESS,
        ),
        Slip(
            "a box 17 m wide for the ego car",
            "(-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)",
            "(-1.5, -8.5, -1.0), (2.6, 8.5, -0.4)",
            SMALL,
        ),
        Slip(
            "a box 15 m long for the ego car",
            "(-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)",
            "(-7.5, -1.7, -1.0), (7.5, 1.7, -0.4)",
            SMALL,
        ),
    ],
    "match_boxes": [
        Slip(
            "exchanges rows and columns",
            "partners[row] = column",
            "partners[column] = row",
            USELESS,
        ),
        Slip(
            "matches the other way round",
            f"{_CENTRES}, axis=2)\n    partners = np.full(len(current), -1)",
            "previous.mean(axis=1)[:, None] - current.mean(axis=1), axis=2)\n"
            "    partners = np.full(len(previous), -1)",
            USELESS,
        ),
        Slip(
            "takes the mean over the wrong axis",
            _CENTRES,
            _CENTRES.replace("axis=1", "axis=2"),
            PARTLY,
        ),
        Slip("compares first corners", _CENTRES, "current[:, 0][:, None] - previous[:, 0]", PARTLY),
        Slip("does not cross out the column", _CROSSED_OUT, "distances[row, :] = np.inf", PARTLY),
        Slip("does not cross out the row", _CROSSED_OUT, "distances[:, column] = np.inf", SMALL),
        Slip(
            "ignores max_distance",
            "distances.min() <= max_distance",
            "distances.min() < np.inf",
            PARTLY,
        ),
        Slip("a fixed maximum distance", "<= max_distance", "<= 1.5", PARTLY),
        Slip(
            "compares squared distances",
            f"np.linalg.norm({_CENTRES}, axis=2)",
            f"(({_CENTRES}) ** 2).sum(axis=2)",
            PARTLY,
        ),
        Slip("0 for new boxes", "np.full(len(current), -1)", "np.zeros(len(current), int)", PARTLY),
        Slip(
            "an answer as long as `previous`",
            "np.full(len(current), -1)",
            "np.full(len(previous), -1)",
            PARTLY,
        ),
        Slip("does not handle an empty list of boxes", "distances.size and ", "", SMALL),
        Slip("return inside the loop", "    return partners", "        return partners", USELESS),
        Slip(
            "compares only x",
            "current.mean(axis=1)[:, None] - previous.mean(axis=1)",
            "(current.mean(axis=1)[:, None] - previous.mean(axis=1))[..., :1]",
            PARTLY,
        ),
        Slip(
            "the comparison with max_distance is reversed",
            "<= max_distance",
            ">= max_distance",
            USELESS,
        ),
        Slip("no return statement", "return partners", "pairs = partners", USELESS),
        Slip("no [:, None] after the centres", "axis=1)[:, None] -", "axis=1) -", USELESS),
        Slip(
            "index and value exchanged", "partners[row] = column", "partners[column] = row", USELESS
        ),
    ],
}
