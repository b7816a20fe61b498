# Answers to drop_invalid; see grader/variants.py.

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

# %% wrong: drops zeros only
# loses: drops_what_is_not_finite, test_fresh_street_cleaned
# says: too many
def drop_invalid(cloud):
    return cloud[~(cloud[:, :3] == 0).all(axis=1)]

# %% wrong: drops NaN only
# loses: drops_the_origin, drops_what_is_not_finite, test_course_cloud_cleaned
# says: too many
def drop_invalid(cloud):
    return cloud[~np.isnan(cloud[:, :3]).any(axis=1)]

# %% wrong: infinite ranges stay
# loses: drops_what_is_not_finite, test_course_cloud_cleaned
# says: too many
def drop_invalid(cloud):
    bad = np.isnan(cloud[:, :3]).any(axis=1) | (cloud[:, :3] == 0).all(axis=1)
    return cloud[~bad]

# %% wrong: any zero coordinate counts as lost
# loses: keeps_good_points, drops_the_origin, test_fresh_street_cleaned
# says: missing, for example (0.00, 5.00
def drop_invalid(cloud):
    good = np.isfinite(cloud[:, :3]).all(axis=1) & (cloud[:, :3] != 0).all(axis=1)
    return cloud[good]

# %% wrong: all columns must be zero
# loses: drops_the_origin, test_course_cloud_cleaned
# says: too many, for example (0.00, 0.00, 0.00)
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud[:, :3]).all(axis=1) & ~(cloud == 0).all(axis=1)]

# %% wrong: intensity must be finite, too
# loses: ignores_intensity
# says: Look at cloud[:, :3] only
def drop_invalid(cloud):
    return cloud[np.isfinite(cloud).all(axis=1) & (cloud[:, :3] != 0).any(axis=1)]

# %% wrong: the sum of the coordinates is zero
# loses: keeps_good_points
# says: missing, for example
def drop_invalid(cloud):
    total = cloud[:, :3].sum(axis=1)
    return cloud[np.isfinite(total) & (total != 0)]

# %% wrong: compares with NaN
# loses: drops_the_origin, drops_what_is_not_finite, test_course_cloud_cleaned
# says: one row per point
def drop_invalid(cloud):
    return cloud[cloud != np.nan]

# %% wrong: only rows that are lost altogether
# loses: drops_what_is_not_finite, test_fresh_street_cleaned
# says: too many
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).any(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: repairs instead of dropping
# loses: drops_what_is_not_finite, leaves_the_scan
# says: changed its input
def drop_invalid(cloud):
    cloud[~np.isfinite(cloud)] = 0.0
    return cloud[(cloud[:, :3] != 0).any(axis=1)]

# %% wrong: drops what is near
# loses: test_near_points_stay, keeps_good_points
# says: missing
def drop_invalid(cloud):
    length = np.linalg.norm(cloud[:, :3], axis=1)
    return cloud[np.isfinite(length) & (length > 0.5)]

# %% wrong: loses the intensity
# loses: drops_the_origin, test_course_cloud_cleaned
# says: expected 4 columns
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return xyz[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)]

# %% wrong: equal points only once, and sorted
# loses: drops_the_origin, test_columns_and_precision_cleaned
# says: another order
def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return np.unique(cloud[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)], axis=0)

# %% wrong: returns the mask
# loses: drops_the_origin, keeps_good_points, test_course_cloud_cleaned
# says: expected 4 columns
def drop_invalid(cloud):
    return np.isfinite(cloud[:, :3]).all(axis=1) & (cloud[:, :3] != 0).any(axis=1)

# %% wrong: returns the cloud as it is
# loses: drops_the_origin, drops_what_is_not_finite, test_course_cloud_cleaned
# says: too many
def drop_invalid(cloud):
    return cloud

# %% wrong: stub left in place
# loses: drops_the_origin, test_course_cloud_cleaned, leaves_the_scan
# says: still raises NotImplementedError
def drop_invalid(cloud):
    raise NotImplementedError
