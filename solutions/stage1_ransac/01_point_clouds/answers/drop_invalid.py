# Answers to drop_invalid; see grader/course/kept_answers.py.

# %% right: two masks
def drop_invalid(cloud):
    finite = np.all(np.isfinite(cloud[:, :3]), axis=1)
    zero = np.all(cloud[:, :3] == 0, axis=1)
    return cloud[finite & np.logical_not(zero)]

# %% right: a loop, a list of lists back
import math

def drop_invalid(cloud):
    kept = []
    for row in cloud.tolist():
        if not all(map(math.isfinite, row[:3])):
            continue
        if row[0] == row[1] == row[2] == 0:
            continue
        kept.append(row)
    return kept

# %% right: deletes the bad rows
def drop_invalid(cloud):
    x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
    lost = ~np.isfinite(x) | ~np.isfinite(y) | ~np.isfinite(z)
    lost |= (x == 0) & (y == 0) & (z == 0)
    return np.delete(cloud, np.flatnonzero(lost), axis=0)

# %% right: by the length of the coordinates, single precision
def drop_invalid(cloud):
    length = np.abs(cloud[:, :3]).sum(axis=1)
    return cloud[np.isfinite(length) & (length > 0)].astype(np.float32)

# %% right: in two steps, with any and isnan
def drop_invalid(cloud):
    print("dropping")
    bad = np.isnan(cloud[:, :3]) | np.isinf(cloud[:, :3])
    rest = cloud[~bad.any(axis=1)]
    return rest[rest[:, :3].any(axis=1)]

# %% right: a helper and a generator of indices
def is_point(x, y, z, *intensity):
    return np.isfinite([x, y, z]).all() and (x, y, z) != (0, 0, 0)

def drop_invalid(cloud):
    rows = [index for index, row in enumerate(cloud) if is_point(*row)]
    return cloud[np.array(rows, dtype=int)]

# %% right: works on a copy
def drop_invalid(cloud):
    work = np.array(cloud, copy=True)
    work[np.isinf(work)] = np.nan
    work[(work[:, 0] == 0) & (work[:, 1] == 0) & (work[:, 2] == 0)] = np.nan
    return cloud[~np.isnan(work[:, :3]).any(axis=1)]

# %% right: the hints followed to the letter
def drop_invalid(cloud):
    finite = np.isfinite(cloud[:, :3]).all(axis=1)
    zero = (cloud[:, :3] == 0).all(axis=1)
    return cloud[finite & ~zero]

# %% wrong: drops zeros only
# loses only: drops_nan, drops_what_is_infinite, test_
# says: too many
# told: only those at (0, 0, 0) go
def drop_invalid(cloud):
    return cloud[~(cloud[:, :3] == 0).all(axis=1)]

# %% wrong: drops what is not finite only
# loses: drops_the_origin, drops_bright_ones, test_course_cloud_cleaned
# says: too many
# told: Returns at (0, 0, 0) stay.
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud[:, :3]).all(axis=1)]

# %% wrong: drops NaN only
# loses: drops_the_origin, drops_what_is_infinite, test_course_cloud_cleaned
# says: too many
# told: those at (0, 0, 0), too
def drop_invalid(cloud):
    return cloud[~np.isnan(cloud[:, :3]).any(axis=1)]

# %% wrong: infinite ranges stay
# loses only: drops_what_is_infinite, test_infinite_returns_go
# says: too many
# told: Rows with an infinite coordinate stay; those with NaN go.
def drop_invalid(cloud):
    bad = np.isnan(cloud[:, :3]).any(axis=1) | (cloud[:, :3] == 0).all(axis=1)
    return cloud[~bad]

# %% wrong: any zero coordinate counts as lost
# loses only: keeps_points_with_a_zero, test_points_with_a_zero_stay
# says: rows missing
# told: as soon as one of its coordinates is 0
def drop_invalid(cloud):
    good = np.isfinite(cloud[:, :3]).all(axis=1) & (cloud[:, :3] != 0).all(axis=1)
    return cloud[good]

# %% wrong: all columns must be zero
# loses only: drops_bright_ones, test_bright_returns_go
# says: rows too many
# told: only if its intensity is 0
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud[:, :3]).all(axis=1) & ~(cloud == 0).all(axis=1)]

# %% wrong: intensity must be finite, too
# loses only: allows_missing_intensity
# says: missing
# told: because their intensity is not finite
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud).all(axis=1) & (cloud[:, :3] != 0).any(axis=1)]

# %% wrong: intensity has a say in both masks
# loses only: allows_missing_intensity, drops_bright_ones, test_bright_returns_go
# says: too many
# told: as if it were a coordinate
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud).all(axis=1) & ~(cloud == 0).all(axis=1)]

# %% wrong: the sum of the coordinates is zero
# loses only: keeps_points_with_a_zero
# says: 1 row missing
# told: add up to 0
def drop_invalid(cloud):
    total = cloud[:, :3].sum(axis=1)
    return cloud[np.isfinite(total) & (total != 0)]

# %% wrong: compares with NaN
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: one row per point
# told: in one long row
def drop_invalid(cloud):
    return cloud[cloud != np.nan]

# %% wrong: asks number by number, not row by row
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: one row per point
# told: in one long row
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud) & (cloud != 0)]

# %% wrong: asks number by number what is finite
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: one row per point
# told: in one long row
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud)]

# %% wrong: only rows that are lost altogether
# loses: drops_nan, drops_what_is_infinite, test_fresh_street_cleaned
# says: too many
# told: only if all three coordinates are not
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).any(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: no axis in either mask
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: expected 4 columns
# told: axis=1 is missing in both
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all() & ~(xyz == 0).all()]

# %% wrong: no axis in the mask of what is finite
# loses: drops_nan, drops_what_is_infinite, test_course_cloud_cleaned
# says: missing
# told: One lost row and all rows go
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all() & ~(xyz == 0).all(axis=1)]

# %% wrong: no axis in the mask of zeros
# loses: drops_the_origin, test_course_cloud_cleaned
# says: too many
# told: Returns at (0, 0, 0) stay.
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all(axis=1) & ~(xyz == 0).all()]

# %% wrong: along the wrong axis
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: axis=1 goes along a row
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all(axis=0) & ~(xyz == 0).all(axis=0)]

# %% wrong: repairs instead of dropping
# loses: drops_nan, leaves_the_scan
# says: changed its input
def drop_invalid(cloud):
    cloud[~np.isfinite(cloud)] = 0.0
    return cloud[(cloud[:, :3] != 0).any(axis=1)]

# %% wrong: marks the lost ones in its input
# loses only: leaves_the_scan
# says: changed its input
def drop_invalid(cloud):
    cloud[(cloud[:, :3] == 0).all(axis=1)] = np.nan
    return cloud[np.isfinite(cloud[:, :3]).all(axis=1)]

# %% wrong: drops what is near
# loses only: keeps_near_points, test_near_points_stay
# says: missing
def drop_invalid(cloud):
    length = np.linalg.norm(cloud[:, :3], axis=1)
    return cloud[np.isfinite(length) & (length > 0.5)]

# %% wrong: loses the intensity
# loses only: keeps_the_intensity, test_order_and_precision_cleaned
# says: does not have the columns of the cloud
# told: without the intensity
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return xyz[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: needs four columns
# loses only: takes_three_columns, test_three_columns_cleaned
# says: more or fewer names than
def drop_invalid(cloud):
    x, y, z, intensity = cloud.T
    finite = np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
    return cloud[finite & ~((x == 0) & (y == 0) & (z == 0))]

# %% wrong: takes all but the last column for coordinates
# loses only: takes_three_columns, test_three_columns_cleaned
# says: Of the same rows without their intensity, others are left
def drop_invalid(cloud):
    xyz = cloud[:, :-1]
    return cloud[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: stacks what is left
# loses only: takes_an_empty_scan
# says: raised ValueError
def drop_invalid(cloud):
    return np.vstack([row for row in cloud if np.isfinite(row[:3]).all() and row[:3].any()])

# %% wrong: equal points only once, and sorted
# loses only: keeps_the_order, test_order_and_precision_cleaned
# says: another order
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return np.unique(cloud[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)], axis=0)

# %% wrong: returns the mask
# loses: drops_the_origin, keeps_points_with_a_zero, test_course_cloud_cleaned
# says: This is a mask
def drop_invalid(cloud):
    return np.isfinite(cloud[:, :3]).all(axis=1) & (cloud[:, :3] != 0).any(axis=1)

# %% wrong: keeps the lost ones
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: missing
# told: that stay, and the points that go
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all(axis=1) & (xyz == 0).all(axis=1)]

# %% wrong: forgets to return
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: returned None
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    cloud = cloud[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: returns the cloud as it is
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: too many
# told: Nothing is dropped
def drop_invalid(cloud):
    return cloud

# %% wrong: stub left in place
# loses: drops_the_origin, test_course_cloud_cleaned, leaves_the_scan
# says: is not started
def drop_invalid(cloud):
    raise NotImplementedError

# %% wrong: the masks are joined by an or
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: with `|` one is enough
# told: Nothing is dropped
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all(axis=1) | ~(xyz == 0).all(axis=1)]

# %% wrong: the mask is turned around
# loses: drops_the_origin, drops_nan, test_course_cloud_cleaned
# says: missing
# told: It is the lost returns that come back
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[~(np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1))]

# %% wrong: not all is taken for none
# loses: drops_nan, drops_what_is_infinite, test_course_cloud_cleaned
# says: too many
# told: only if all three coordinates are NaN
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[~np.isnan(xyz).all(axis=1) & ~(xyz == 0).all(axis=1)]
