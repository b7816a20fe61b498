# Answers to voxel_grid; see grader/course/kept_answers.py.

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

# %% right: the hints followed to the letter
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size)
    different, which, counts = np.unique(as_numbers(cells), return_inverse=True, return_counts=True)
    number_of_cells = len(counts)
    sums = np.zeros((number_of_cells, cloud.shape[1]))
    np.add.at(sums, which, cloud)
    return sums / counts[:, None]

# %% wrong: rounds towards zero
# loses only: floors_below_zero, test_voxels_all_around
# says: fewer rows than
# told: rounded towards zero
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = (cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: rounds to the nearest
# loses only: begins_at_multiples, test_voxel_borders
# says: np.floor, not np.round
# told: rounded to the nearest
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.round(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: counts cells from the corner of the cloud
# loses only: begins_at_multiples, test_voxel_borders
# says: Take no minimum off
# told: lowest corner of the cloud
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor((cloud[:, :3] - cloud[:, :3].min(axis=0)) / voxel_size)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: the first point of each cell instead of the mean
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: not the mean of the points
# told: The first point of each cell
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.floor(cloud[:, :3] / voxel_size)
    return cloud[np.unique(cells, axis=0, return_index=True)[1]]

# %% wrong: a dictionary that keeps the last point
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: not the mean of the points
# told: The last point of each cell
def voxel_grid(cloud, voxel_size=0.2):
    cells = {}
    for row in cloud:
        cells[tuple(np.floor(row[:3] / voxel_size))] = row
    return np.array(list(cells.values())).reshape(-1, cloud.shape[1])

# %% wrong: adds with +=
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: adds every row
# told: only the last row
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    sums[which.ravel()] += cloud
    return sums / count[:, None]

# %% wrong: the middle of each cell instead of the mean
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: divide by the counts
# told: the middles of the cells
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.unique(np.floor(cloud[:, :3] / voxel_size), axis=0)
    return (cells + 0.5) * voxel_size

# %% wrong: the numbers of the cells
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: divide by the counts
# told: the numbers of the cells
def voxel_grid(cloud, voxel_size=0.2):
    return np.unique(np.floor(cloud[:, :3] / voxel_size), axis=0)

# %% wrong: cells in the plane only
# loses: cuts_in_three_directions, test_voxels_of_fresh_street, test_voxels_of_course_cloud
# says: fewer rows than
# told: z is left out
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :2] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: intensity takes part in the cell
# loses only: ignores_the_intensity, test_voxels_of_bright_points
# says: more rows than
# told: The intensity takes part
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: the size is written into the function
# loses only: follows_the_size, test_voxel_sizes
# says: Divide by voxel_size
# told: A fixed size of 0.2
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / 0.2).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: forgets the size
# loses: one_point_per_cell, follows_the_size, test_voxel_sizes
# says: fewer rows than
# told: voxel_size is left out
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3]).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: multiplies with the size
# loses: one_point_per_cell, follows_the_size, test_voxel_sizes
# says: fewer rows than
# told: are multiplied
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] * voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: default changed
# loses only: keeps_the_size
# says: are not the same
def voxel_grid(cloud, voxel_size=0.5):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: parameters renamed
# loses only: names_its_parameters
# says: another name
def voxel_grid(cloud, size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: drops the intensity
# loses only: averages_the_intensity, test_voxels_average_the_intensity
# says: do not have the columns
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return (sums / count[:, None])[:, :3]

# %% wrong: intensity of the first point
# loses only: averages_the_intensity, test_voxels_average_the_intensity
# says: not the mean of the cell's
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, first = np.unique(cells, axis=0, return_index=True)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    means = sums / count[:, None]
    means[:, 3:] = cloud[first, 3:]
    return means

# %% wrong: takes four columns only
# loses only: thins_three_columns, test_voxels_of_other_clouds
# says: raised ValueError
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), 4))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: fails on an empty cloud
# loses only: thins_the_smallest
# says: can be empty
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    lowest = cells.min(axis=0)
    cells -= lowest
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

# %% wrong: sums without dividing
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: not the mean of the points
# told: not divided by the counts
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums

# %% wrong: divides by the counts as a row
# loses: one_point_per_cell, test_voxels_of_course_cloud
# says: counts[:, None]
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count

# %% wrong: moves its input
# loses only: leaves_the_cloud, test_voxels_input
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

# %% wrong: merges nothing
# loses: one_point_per_cell, averages_each_cell, test_voxels_of_course_cloud
# says: more rows than
# told: Nothing is merged
def voxel_grid(cloud, voxel_size=0.2):
    return cloud

# %% wrong: sums of whole numbers
# loses only: averages_each_cell, averages_the_intensity, test_voxels_of_course_cloud, test_voxels_of_fresh_street, test_voxels_average
# says: cut off at every addition
# told: whole numbers
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    different, which, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(different), cloud.shape[1]), dtype=int)
    np.add.at(sums, which.ravel(), cloud)
    return sums / counts[:, None]

# %% wrong: an empty list for an empty cloud
# loses only: thins_the_smallest
# says: has lost its columns
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return []
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    different, which, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(different), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / counts[:, None]

# %% wrong: np.unique takes the rows apart
# loses: one_point_per_cell, test_voxels_of_course_cloud
# says: takes rows apart without axis=0
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    different, which, counts = np.unique(cells, return_inverse=True, return_counts=True)
    sums = np.zeros((len(different), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / counts[:, None]

# %% right: rounded up, where only a border differs
def voxel_grid(cloud, voxel_size=0.2):
    if len(cloud) == 0:
        return cloud
    cells = np.ceil(cloud[:, :3] / voxel_size).astype(int)
    different, which, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(different), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / counts[:, None]
