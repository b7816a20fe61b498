"""Slips in lesson 06."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_CELL = "np.floor(cloud[:, :3] / voxel_size)"

SLIPS = {
    "filter_ground": [
        Slip("the other way round", "2] >=", "2] <", USELESS),
        Slip("the level with another sign", "2] >= ", "2] >= -", USELESS),
        Slip("heights without sign", "cloud[:, 2]", "np.abs(cloud[:, 2])", USELESS),
        Slip("y for z", "[:, 2]", "[:, 1]", USELESS),
        Slip("the last column", "[:, 2]", "[:, -1]", USELESS),
        Slip("a row for a column", "[:, 2]", "[2]", USELESS),
        Slip("the mask", "return cloud[stands_above]", "return stands_above", USELESS),
        Slip("a level of zero", "2] >= ground_level", "2] >= 0", USELESS),
        Slip("a fixed level", "2] >= ground_level", "2] >= -1.2", PARTLY),
        Slip("places alone", "cloud[stands_above]", "cloud[stands_above, :3]", SMALL),
        Slip(
            "from the lowest up", "cloud[stands_above]", "np.sort(cloud[stands_above], 0)", USELESS
        ),
        Slip("another default", "=-1.2", "=-1.73", SMALL),
        Slip("no default", "=-1.2", "", SMALL),
        Slip("rounded", "cloud[:, 2] >=", "cloud[:, 2].round(1) >=", PARTLY),
        Slip(
            "row numbers in a tuple",
            "return cloud[stands_above]",
            "return np.where(stands_above)",
            USELESS,
        ),
        Slip("no return", "return cloud[stands_above]", "cloud = cloud[stands_above]", USELESS),
    ],
    "voxel_grid": [
        Slip(
            "the last row of each cell",
            "np.add.at(sums, rank, cloud)",
            "sums[rank] += cloud",
            USELESS,
        ),
        Slip("sums", "return sums / count[:, None]", "return sums", USELESS),
        Slip("counts as a row", "count[:, None]", "count", USELESS),
        Slip(
            "no numbers",
            "np.unique(as_numbers(cell_of_point),",
            "np.unique(cell_of_point,",
            USELESS,
        ),
        Slip("multiplied", "[:, :3] / voxel_size", "[:, :3] * voxel_size", USELESS),
        Slip("no size", "cloud[:, :3] / voxel_size", "cloud[:, :3]", USELESS),
        Slip("sums of whole numbers", "cloud.shape[1]))", "cloud.shape[1]), dtype=int)", USELESS),
        Slip("a fixed size", "[:, :3] / voxel_size", "[:, :3] / 0.2", PARTLY),
        Slip("intensity in the cell", "cloud[:, :3] / voxel_size", "cloud / voxel_size", SMALL),
        Slip(
            "columns without floor",
            "cloud[:, :3] / voxel_size",
            "cloud[:, :2] / voxel_size",
            PARTLY,
        ),
        Slip("rounds towards zero", _CELL, "np.trunc(cloud[:, :3] / voxel_size)", SMALL),
        Slip("rounds to the nearest", "np.floor(cloud", "np.round(cloud", SMALL),
        Slip(
            "from the lowest corner",
            "np.floor(cloud[:, :3] /",
            "np.floor((cloud[:, :3] - cloud[:, :3].min(axis=0)) /",
            SMALL,
        ),
        Slip(
            "places alone",
            "rank, cloud)",
            "rank, cloud[:, :3] @ np.eye(3, sums.shape[1]))",
            SMALL,
        ),
        Slip(
            "no empty cloud",
            "    if len(cloud) == 0:\n        return cloud\n",
            "    cloud[0]\n",
            SMALL,
        ),
        Slip(
            "the first point of each cell",
            "return sums / count[:, None]",
            "return cloud[np.unique(as_numbers(cell_of_point), return_index=True)[1]]",
            PARTLY,
        ),
        Slip("sums for cells", "as_numbers(cell_of_point)", "cell_of_point.sum(axis=1)", PARTLY),
        Slip(
            "mirrored cells",
            "np.floor(cloud[:, :3] / voxel_size)",
            "np.floor(np.abs(cloud[:, :3]) / voxel_size)",
            SMALL,
        ),
        Slip(
            "the last cell is forgotten",
            "return sums / count[:, None]",
            "return (sums / count[:, None])[:-1]",
            USELESS,
        ),
    ],
}
