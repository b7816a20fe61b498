"""Slips in lesson 05."""

from tests.slips import BODY, NAIVE, PARTLY, SMALL, USELESS, Slip

_NEAR = "np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)"

SLIPS = {
    "euclidean_clustering": [
        Slip("no point joins the queue", "            waiting.extend(newcomers)\n", "", USELESS),
        Slip("the queue starts empty", "deque([start])", "deque()", USELESS),
        Slip("one distance for the whole cloud", ", axis=1)", ")", USELESS),
        Slip("returns after one cluster", "    return labels", "        return labels", USELESS),
        Slip("squares the threshold", "distance < threshold", "distance < threshold ** 2", PARTLY),
        Slip("no square root", _NEAR, f"{_NEAR} ** 2", PARTLY),
        Slip("a fixed threshold", "distance < threshold", "distance < 0.5", PARTLY),
        Slip("uses intensity as a coordinate", "cloud[:, :3]", "cloud", PARTLY),
        Slip("ignores the height", "cloud[:, :3]", "cloud[:, :2]", PARTLY),
        Slip("labels start at 0", "return labels", "return labels - 1", SMALL),
        Slip(
            "increases the counter at every point",
            "        if labels[start] > 0:\n            continue\n        cluster += 1\n",
            "        cluster += 1\n        if labels[start] > 0:\n            continue\n",
            SMALL,
        ),
        Slip("the counter does not grow", "        cluster += 1\n", "", USELESS),
        Slip("skips the first point", "range(len(xyz))", "range(1, len(xyz))", SMALL),
        Slip("skips the last point", "range(len(xyz))", "range(len(xyz) - 1)", SMALL),
        Slip("8-bit labels", "dtype=int", "dtype=np.uint8", SMALL),
        Slip("uses only y and z", "cloud[:, :3]", "cloud[:, 1:3]", USELESS),
        Slip("uses the last three columns", "cloud[:, :3]", "cloud[:, -3:]", PARTLY),
        Slip("uses only x", "cloud[:, :3]", "cloud[:, :1]", USELESS),
        Slip("break instead of continue", "continue", "break", USELESS),
        Slip("if instead of while", "while waiting", "if waiting", USELESS),
        Slip(
            "uses the balls from the lesson",
            BODY,
            "    return balls(cloud, threshold)",
            NAIVE,
        ),
        Slip("twice the threshold", "distance < threshold", "distance < 2 * threshold", PARTLY),
        Slip("joins distant points", "distance < threshold", "distance > threshold", USELESS),
        Slip(
            "labels small clusters as noise",
            "return labels",
            "return np.where(np.bincount(labels)[labels] < 3, 0, labels)",
            PARTLY,
        ),
        Slip("labels nothing", BODY, "    return np.zeros(len(cloud), dtype=int)", NAIVE),
    ],
}
