"""Slips in lesson 08."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_ROUND = "for label in np.unique(cluster_labels[measured & (cluster_labels > 0)]):"
_ENDS = "points.max(axis=0), points.min(axis=0)"

SLIPS = {
    "get_bounding_boxes": [
        Slip("one maximum for x, y and z", "points.max(axis=0)", "points.max()", USELESS),
        Slip("returns after one box", "    return np", "        return np", USELESS),
        Slip(
            "uses all points for each box",
            "measured & (cluster_labels == label)",
            "measured",
            USELESS,
        ),
        # Useless, because a car would collide with the last obstacle, which has no box.
        Slip(
            "skips the last label", _ROUND, "for label in range(1, cluster_labels.max()):", USELESS
        ),
        Slip(
            "loops over all numbers up to the last label",
            _ROUND,
            "for label in range(1, cluster_labels.max(initial=0) + 1):",
            PARTLY,
        ),
        Slip(
            "skips the first label", _ROUND, "for label in np.unique(cluster_labels)[1:]:", PARTLY
        ),
        Slip(
            "puts a box around the noise", _ROUND, "for label in np.unique(cluster_labels):", PARTLY
        ),
        Slip(
            "orders boxes by first occurrence",
            _ROUND,
            "for label in dict.fromkeys(cluster_labels[cluster_labels > 0].tolist()):",
            PARTLY,
        ),
        Slip(
            "minimum and maximum start at 0",
            _ENDS,
            "np.maximum(points.max(axis=0), 0), np.minimum(points.min(axis=0), 0)",
            PARTLY,
        ),
        Slip(
            "ignores the first point for the maximum",
            "points.max(axis=0)",
            "np.max(points[1:], axis=0, initial=-np.inf)",
            PARTLY,
        ),
        Slip("includes the intensity in the corners", "label), :3]", "label)]", PARTLY),
        Slip("wrong shape if there are no clusters", ".reshape(-1, 8, 3)", "", SMALL),
        Slip(
            "one minimum and one maximum for x, y and z",
            "points.max(axis=0), points.min(axis=0)",
            "points.max(), points.min()",
            USELESS,
        ),
        Slip(
            "axis=1 instead of axis=0",
            "points.max(axis=0), points.min(axis=0)",
            "points.max(axis=1), points.min(axis=1)",
            USELESS,
        ),
        Slip("rounds to centimetres", ".reshape(-1, 8, 3)", ".reshape(-1, 8, 3).round(2)", SMALL),
        Slip("no return statement", "return np.array", "boxes = np.array", USELESS),
        Slip("columns shifted by one", "== label), :3]", "== label), 1:4]", USELESS),
        Slip(
            "computes a mask but does not use it",
            "points = cloud[measured & (cluster_labels == label), :3]",
            "chosen = measured & (cluster_labels == label)\n        points = cloud[:, :3]",
            USELESS,
        ),
        Slip(
            "no [:, None] after the numbers of the corners",
            "np.arange(8)[:, None]",
            "np.arange(8)",
            USELESS,
        ),
    ],
}
