"""Slips in lesson 06."""

from tests.slips import PARTLY, SMALL, USELESS, Slip

_CELL = "np.floor(cloud[:, :3] / voxel_size)"

SLIPS = {
    "filter_ground": [
        Slip("the comparison is reversed", "2] >=", "2] <", USELESS),
        Slip("the sign of the level is flipped", "2] >= ", "2] >= -", USELESS),
        Slip("absolute values of the heights", "cloud[:, 2]", "np.abs(cloud[:, 2])", USELESS),
        Slip("y instead of z", "[:, 2]", "[:, 1]", USELESS),
        Slip("the last column instead of z", "[:, 2]", "[:, -1]", USELESS),
        Slip("a row instead of a column", "[:, 2]", "[2]", USELESS),
        Slip("returns the mask", "return cloud[stands_above]", "return stands_above", USELESS),
        Slip("a fixed level of 0", "2] >= ground_level", "2] >= 0", USELESS),
        Slip("a fixed level of -1.2", "2] >= ground_level", "2] >= -1.2", PARTLY),
        Slip("drops the intensity", "cloud[stands_above]", "cloud[stands_above, :3]", SMALL),
        Slip(
            "sorts each column", "cloud[stands_above]", "np.sort(cloud[stands_above], 0)", USELESS
        ),
        Slip("a different default", "=-1.2", "=-1.73", SMALL),
        Slip("no default", "=-1.2", "", SMALL),
        Slip("rounds the heights", "cloud[:, 2] >=", "cloud[:, 2].round(1) >=", PARTLY),
        Slip(
            "returns row numbers in a tuple",
            "return cloud[stands_above]",
            "return np.where(stands_above)",
            USELESS,
        ),
        Slip(
            "no return statement",
            "return cloud[stands_above]",
            "cloud = cloud[stands_above]",
            USELESS,
        ),
        Slip(
            "computes a mask but does not use it",
            "return cloud[stands_above]",
            "return cloud",
            USELESS,
        ),
    ],
    "voxel_grid": [
        Slip(
            "adds only the last row of each cell",
            "np.add.at(sums, rank, cloud)",
            "sums[rank] += cloud",
            USELESS,
        ),
        Slip("returns the sums", "return sums / count[:, None]", "return sums", USELESS),
        Slip("does not turn the counts into a column", "count[:, None]", "count", USELESS),
        Slip(
            "np.unique without as_numbers",
            "np.unique(as_numbers(cell_of_point),",
            "np.unique(cell_of_point,",
            USELESS,
        ),
        Slip("multiplies by the size", "[:, :3] / voxel_size", "[:, :3] * voxel_size", USELESS),
        Slip("does not divide by the size", "cloud[:, :3] / voxel_size", "cloud[:, :3]", USELESS),
        Slip("integer sums", "cloud.shape[1]))", "cloud.shape[1]), dtype=int)", USELESS),
        Slip("a fixed size of 0.2", "[:, :3] / voxel_size", "[:, :3] / 0.2", PARTLY),
        Slip(
            "includes the intensity in the cell index",
            "cloud[:, :3] / voxel_size",
            "cloud / voxel_size",
            SMALL,
        ),
        Slip(
            "ignores z",
            "cloud[:, :3] / voxel_size",
            "cloud[:, :2] / voxel_size",
            PARTLY,
        ),
        Slip("rounds towards zero", _CELL, "np.trunc(cloud[:, :3] / voxel_size)", SMALL),
        Slip("rounds to the nearest integer", "np.floor(cloud", "np.round(cloud", SMALL),
        Slip(
            "starts cells at the lowest corner",
            "np.floor(cloud[:, :3] /",
            "np.floor((cloud[:, :3] - cloud[:, :3].min(axis=0)) /",
            SMALL,
        ),
        Slip(
            "drops the intensity",
            "rank, cloud)",
            "rank, cloud[:, :3] @ np.eye(3, sums.shape[1]))",
            SMALL,
        ),
        Slip(
            "fails on an empty cloud",
            "    if len(cloud) == 0:\n        return cloud\n",
            "    cloud[0]\n",
            SMALL,
        ),
        Slip(
            "returns the first point of each cell",
            "return sums / count[:, None]",
            "return cloud[np.unique(as_numbers(cell_of_point), return_index=True)[1]]",
            PARTLY,
        ),
        Slip(
            "groups by the sum of the cell indices",
            "as_numbers(cell_of_point)",
            "cell_of_point.sum(axis=1)",
            PARTLY,
        ),
        Slip(
            "ignores signs",
            "np.floor(cloud[:, :3] / voxel_size)",
            "np.floor(np.abs(cloud[:, :3]) / voxel_size)",
            SMALL,
        ),
        Slip(
            "drops the last cell",
            "return sums / count[:, None]",
            "return (sums / count[:, None])[:-1]",
            USELESS,
        ),
        Slip("columns shifted by one", "np.floor(cloud[:, :3]", "np.floor(cloud[:, 1:4]", USELESS),
    ],
}
