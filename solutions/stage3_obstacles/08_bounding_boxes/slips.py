"""Slips in lesson 08."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_ROUND = "for label in np.unique(cluster_labels[measured & (cluster_labels > 0)]):"
_ENDS = "points.max(axis=0), points.min(axis=0)"

SLIPS = {
    "get_bounding_boxes": [
        Slip("one number for x, y and z", "points.max(axis=0)", "points.max()", USELESS),
        Slip("returns after one box", "    return np", "        return np", USELESS),
        Slip("the whole cloud", "measured & (cluster_labels == label)", "measured", USELESS),
        # The car collides with the last obstacle, which has no box.
        Slip("no last label", _ROUND, "for label in range(1, cluster_labels.max()):", USELESS),
        Slip(
            "all numbers up to the last",
            _ROUND,
            "for label in range(1, cluster_labels.max(initial=0) + 1):",
            PARTLY,
        ),
        Slip("no first label", _ROUND, "for label in np.unique(cluster_labels)[1:]:", PARTLY),
        Slip("noise boxed", _ROUND, "for label in np.unique(cluster_labels):", PARTLY),
        Slip(
            "by appearance",
            _ROUND,
            "for label in dict.fromkeys(cluster_labels[cluster_labels > 0].tolist()):",
            PARTLY,
        ),
        Slip(
            "starts at 0",
            _ENDS,
            "np.maximum(points.max(axis=0), 0), np.minimum(points.min(axis=0), 0)",
            PARTLY,
        ),
        Slip(
            "the first is never the largest",
            "points.max(axis=0)",
            "np.max(points[1:], axis=0, initial=-np.inf)",
            PARTLY,
        ),
        Slip("intensity in the corners", "label), :3]", "label)]", PARTLY),
        Slip("no form for none", ".reshape(-1, 8, 3)", "", SMALL),
        Slip(
            "one number for all, twice",
            "points.max(axis=0), points.min(axis=0)",
            "points.max(), points.min()",
            USELESS,
        ),
        Slip(
            "the other axis, twice",
            "points.max(axis=0), points.min(axis=0)",
            "points.max(axis=1), points.min(axis=1)",
            USELESS,
        ),
        Slip("rounded to centimetres", ".reshape(-1, 8, 3)", ".reshape(-1, 8, 3).round(2)", SMALL),
        Slip("no return", "return np.array", "boxes = np.array", USELESS),
    ],
}
