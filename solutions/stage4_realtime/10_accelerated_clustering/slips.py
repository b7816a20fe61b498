"""Slips in lesson 10, most of them in its three steps."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_SIDE = "cells, first, cell_of_point = points_in_cells(points, threshold)"
_CHEAP = "join_cheaply(points, cells, first, threshold)"
_EXACT = "    label = join_exactly(points, cell_of_point, pairs, label, threshold)\n"
_RANKS = "np.argsort(np.argsort(start))[which] + 1"

SLIPS = {
    "euclidean_clustering_accelerated": [
        Slip(
            "cell side equal to the threshold",
            _SIDE,
            _SIDE.replace("(points, threshold)", "(points, threshold * np.sqrt(3))"),
            PARTLY,
        ),
        Slip(
            "rounds towards zero",
            _SIDE,
            "cells, first, cell_of_point = np.unique((points / (threshold / np.sqrt(3)))"
            ".astype(int), axis=0, return_index=True, return_inverse=True)\n"
            "    cell_of_point = cell_of_point.ravel()",
            PARTLY,
        ),
        Slip(
            "mistakes rows of cells for rows of points",
            _CHEAP,
            "join_cheaply(points, cells, np.arange(len(points)), threshold)",
            USELESS,
        ),
        Slip(
            "compares cells instead of points",
            _CHEAP,
            "join_cheaply(cells, cells, np.arange(len(cells)), threshold)",
            SMALL,
        ),
        Slip(
            "searches only adjacent cells",
            _CHEAP,
            f'{_CHEAP}\n    pairs = cKDTree(cells).query_pairs(1, p=np.inf, output_type="ndarray")',
            PARTLY,
        ),
        Slip("exact step missing", _EXACT, "", USELESS),
        Slip(
            "ignores the result of the exact step",
            "    label = join_exactly(points",
            "    join_exactly(points",
            USELESS,
        ),
        Slip(
            "a fixed threshold in the exact step",
            "pairs, label, threshold)\n    _,",
            "pairs, label, 0.5)\n    _,",
            PARTLY,
        ),
        Slip("labels start at 0", _RANKS, "np.argsort(np.argsort(start))[which]", SMALL),
        Slip("labels of cells instead of points", _RANKS, "label + 1", USELESS),
        Slip(
            "uses intensity as a coordinate", "np.asarray(cloud)[:, :3]", "np.asarray(cloud)", SMALL
        ),
        Slip(
            "a fixed threshold for the cells",
            _SIDE,
            _SIDE.replace("(points, threshold)", "(points, 0.5)"),
            PARTLY,
        ),
        Slip(
            "a fixed threshold for the cheap step",
            "first, threshold)\n    label",
            "first, 0.5)\n    label",
            SMALL,
        ),
        Slip(
            "returns one label per cell",
            "label[cell_of_point], return_index",
            "label, return_index",
            USELESS,
        ),
        Slip("no return statement", "return np.argsort", "labels = np.argsort", USELESS),
        Slip(
            "columns shifted by one",
            "np.asarray(cloud)[:, :3]",
            "np.asarray(cloud)[:, 1:4]",
            USELESS,
        ),
        Slip(
            "label[first] instead of label[cell_of_point]",
            "label[cell_of_point]",
            "label[first]",
            USELESS,
        ),
        Slip("one label per cluster", "(start))[which]", "(start))", USELESS),
    ],
}
