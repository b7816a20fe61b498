"""Slips in lesson 05."""

from tests.slips import BODY, NAIVE, PARTLY, SMALL, USELESS, Slip

_NEAR = "np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)"

SLIPS = {
    "euclidean_clustering": [
        Slip("no point joins the queue", "            waiting.extend(newcomers)\n", "", USELESS),
        Slip("the queue begins empty", "deque([start])", "deque()", USELESS),
        Slip("one length for all", ", axis=1)", ")", USELESS),
        Slip("returns after one cluster", "    return labels", "        return labels", USELESS),
        Slip("threshold squared", "distance < threshold", "distance < threshold ** 2", PARTLY),
        Slip("no root", _NEAR, f"{_NEAR} ** 2", PARTLY),
        Slip("a fixed threshold", "distance < threshold", "distance < 0.5", PARTLY),
        Slip("intensity is a place", "cloud[:, :3]", "cloud", PARTLY),
        Slip("no height", "cloud[:, :3]", "cloud[:, :2]", PARTLY),
        Slip("labels from 0", "return labels", "return labels - 1", SMALL),
        Slip(
            "counts every point",
            "        if labels[start] > 0:\n            continue\n        cluster += 1\n",
            "        cluster += 1\n        if labels[start] > 0:\n            continue\n",
            SMALL,
        ),
        Slip("the first point is left out", "range(len(xyz))", "range(1, len(xyz))", SMALL),
        Slip("the last point is left out", "range(len(xyz))", "range(len(xyz) - 1)", SMALL),
        Slip("labels of eight bits", "dtype=int", "dtype=np.uint8", SMALL),
        Slip("y and z alone", "cloud[:, :3]", "cloud[:, 1:3]", USELESS),
        Slip("x alone", "cloud[:, :3]", "cloud[:, :1]", USELESS),
        Slip("break for continue", "continue", "break", USELESS),
        Slip("if for while", "while waiting", "if waiting", USELESS),
        Slip(
            "the lesson's balls",
            BODY,
            "    return balls(cloud, threshold)",
            NAIVE,
        ),
        Slip("twice the threshold", "distance < threshold", "distance < 2 * threshold", PARTLY),
        Slip("the far points", "distance < threshold", "distance > threshold", USELESS),
        Slip(
            "small clusters become noise",
            "return labels",
            "return np.where(np.bincount(labels)[labels] < 3, 0, labels)",
            PARTLY,
        ),
        Slip("nothing has a label", BODY, "    return np.zeros(len(cloud), dtype=int)", NAIVE),
    ],
}
