"""Slips in lesson 09."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_COUNT = """\
_, row, size = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    size_of_its_cluster = size[row]
    return np.where(size_of_its_cluster < min_num_points, 0, cluster_labels)"""
_LOOP = """\
labels = cluster_labels.copy()
    for label in range(1, {end}):
        if np.sum({read} == label) < min_num_points:
            labels[{read} == label] = 0{more}
    return labels"""


def _loop(end="cluster_labels.max() + 1", read="cluster_labels", more=""):
    return _LOOP.format(end=end, read=read, more=more)


SLIPS = {
    "filter_clusters": [
        Slip("`<=` instead of `<`", "cluster < min", "cluster <= min", SMALL),
        Slip("removes the large clusters", "cluster < min", "cluster >= min", USELESS),
        Slip(
            "compares labels instead of sizes",
            "size_of_its_cluster < min",
            "cluster_labels < min",
            USELESS,
        ),
        Slip("writes -1 for noise", "min_num_points, 0,", "min_num_points, -1,", SMALL),
        Slip(
            "deletes the points",
            "np.where(size_of_its_cluster < min_num_points, 0, cluster_labels)",
            "cluster_labels[size_of_its_cluster >= min_num_points]",
            USELESS,
        ),
        Slip("a fixed minimum of 100", "cluster < min_num_points", "cluster < 100", USELESS),
        Slip(
            "renumbers labels inside the loop",
            _COUNT,
            _loop(read="labels", more="\n            labels[labels > label] -= 1"),
            USELESS,
        ),
        Slip("skips the last label", _COUNT, _loop(end="cluster_labels.max()"), PARTLY),
        Slip(
            "uses the index as the label",
            _COUNT,
            """\
labels = cluster_labels.copy()
    _, how_many = np.unique(cluster_labels, return_counts=True)
    for label, count in enumerate(how_many):
        if count < min_num_points:
            labels[cluster_labels == label] = 0
    return labels""",
            USELESS,
        ),
        Slip(
            "returns sizes instead of labels",
            "0, cluster_labels)",
            "0, size_of_its_cluster)",
            USELESS,
        ),
        Slip("fails on an empty array", _COUNT, _loop(), SMALL),
        Slip(
            "also removes large clusters",
            "size_of_its_cluster < min_num_points,",
            "(size_of_its_cluster < min_num_points) | (size_of_its_cluster > 1000),",
            PARTLY,
        ),
        Slip("`size` instead of `size[row]`", "size[row]", "size", USELESS),
        Slip("no return statement", "return np.where", "labels = np.where", USELESS),
        Slip(
            "return inside the loop",
            "    _, row, size = np.unique(cluster_labels, return_inverse=True, "
            "return_counts=True)\n"
            "    size_of_its_cluster = size[row]\n"
            "    return np.where(size_of_its_cluster < min_num_points, 0, "
            "cluster_labels)",
            "    labels = cluster_labels.copy()\n"
            "    for label in np.unique(cluster_labels):\n"
            "        if (cluster_labels == label).sum() < min_num_points:\n"
            "            labels[cluster_labels == label] = 0\n"
            "        return labels",
            USELESS,
        ),
    ],
}
