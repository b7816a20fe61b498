# Answers to voxel_grid; see grader/variants.py.

# %% right: np.unique and np.add.at
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud.copy()
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count.reshape(-1, 1)

# %% right: a dictionary of lists, a list of lists back
def voxel_grid(cloud, voxel_size=0.2):
    cells = {}
    for row in cloud:
        key = tuple((row[:3] // voxel_size).astype(int))
        cells.setdefault(key, []).append(row)
    if not cells:
        return np.empty((0, cloud.shape[1]))
    return [list(np.mean(rows, axis=0)) for rows in cells.values()]

# %% right: bincount column by column
def voxel_grid(cloud, voxel_size=0.2):
    if not len(cloud):
        return np.zeros((0, cloud.shape[1]))
    cells = np.floor(cloud[:, :3] / voxel_size)
    which = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(which)
    return np.stack([np.bincount(which, weights=column) / count for column in cloud.T], axis=1)

# %% right: sort and reduce, in reverse order
def voxel_grid(cloud, voxel_size=0.2):
    if cloud.shape[0] == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(np.int64)
    order = np.lexsort(cells.T)
    cells, rows = cells[order], cloud[order].astype(float)
    start = np.r_[0, np.flatnonzero((np.diff(cells, axis=0) != 0).any(axis=1)) + 1]
    count = np.diff(np.r_[start, len(rows)])
    return (np.add.reduceat(rows, start, axis=0) / count[:, None])[::-1]

# %% right: running means in single precision
import math

def voxel_grid(cloud, voxel_size=0.2):
    means = {}
    for row in cloud.tolist():
        key = (math.floor(row[0] / voxel_size), math.floor(row[1] / voxel_size),
               math.floor(row[2] / voxel_size))
        count, mean = means.get(key, (0, np.zeros(len(row))))
        means[key] = (count + 1, mean + (np.array(row) - mean) / (count + 1))
    return np.array([mean for count, mean in means.values()],
                    dtype=np.float32).reshape(len(means), cloud.shape[1])

# %% wrong: rounds towards zero
# loses: floors_below_zero, test_voxels_of_course_cloud
# says: rows, expected
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = (cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: rounds to the nearest
# loses: one_point_per_cell, test_voxels_of_course_cloud
# says: Three points share one cell
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.round(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: the first point of each cell instead of the mean
# loses: one_point_per_cell, test_voxels_average_every_column
# says: should not be there
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.floor(cloud[:, :3] / voxel_size)
    return cloud[np.unique(cells, axis=0, return_index=True)[1]]

# %% wrong: the middle of each cell instead of the mean
# loses: one_point_per_cell, test_voxels_of_fresh_street
# says: columns
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.unique(np.floor(cloud[:, :3] / voxel_size), axis=0)
    return (cells + 0.5) * voxel_size

# %% wrong: cells in the plane only
# loses: test_voxels_of_fresh_street, test_voxels_of_course_cloud
# says: rows, expected
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :2] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: intensity takes part in the cell
# loses: test_voxels_average_every_column
# says: rows, expected
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud / voxel_size * np.array([1, 1, 1, 20])[:cloud.shape[1]]).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: the size is written into the function
# loses: follows_the_size, test_voxels_of_fresh_street
# says: rows, expected
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / 0.2).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: fails on an empty cloud
# loses: takes_nothing
# says: can be empty
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    cells -= cells.min(axis=0)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: sums without dividing
# loses: one_point_per_cell, test_voxels_of_course_cloud
# says: should not be there
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums

# %% wrong: moves its input
# loses: takes_nothing
# says: changed its input
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cloud[:, :3] /= voxel_size
    cells = np.floor(cloud[:, :3]).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    sums[:, :3] *= voxel_size
    return sums / count[:, None]
