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
        Slip("`<=` for `<`", "cluster < min", "cluster <= min", SMALL),
        Slip("the large ones go", "cluster < min", "cluster >= min", USELESS),
        Slip("labels for sizes", "size_of_its_cluster < min", "cluster_labels < min", USELESS),
        Slip("-1 for noise", "min_num_points, 0,", "min_num_points, -1,", SMALL),
        Slip(
            "points deleted",
            "np.where(size_of_its_cluster < min_num_points, 0, cluster_labels)",
            "cluster_labels[size_of_its_cluster >= min_num_points]",
            USELESS,
        ),
        Slip("a minimum of its own", "cluster < min_num_points", "cluster < 100", USELESS),
        Slip(
            "closes the gap in the loop",
            _COUNT,
            _loop(read="labels", more="\n            labels[labels > label] -= 1"),
            USELESS,
        ),
        Slip("the last label left out", _COUNT, _loop(end="cluster_labels.max()"), PARTLY),
        Slip(
            "index for label",
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
        Slip("sizes for labels", "0, cluster_labels)", "0, size_of_its_cluster)", USELESS),
        Slip("largest of nothing", _COUNT, _loop(), SMALL),
        Slip(
            "large clusters are removed as well",
            "size_of_its_cluster < min_num_points,",
            "(size_of_its_cluster < min_num_points) | (size_of_its_cluster > 1000),",
            PARTLY,
        ),
        Slip("the sizes without their rows", "size[row]", "size", USELESS),
        Slip("no return", "return np.where", "labels = np.where", USELESS),
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
