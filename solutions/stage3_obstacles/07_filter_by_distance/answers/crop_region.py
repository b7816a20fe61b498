# Answers to crop_region; see grader/course/kept_answers.py.

# %% right: two tables and all
def crop_region(cloud, minimum, maximum):
    return cloud[np.all((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum), axis=1)]

# %% right: six comparisons
def crop_region(cloud, minimum, maximum):
    x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
    mask = (x >= minimum[0]) & (x <= maximum[0])
    mask &= (y >= minimum[1]) & (y <= maximum[1])
    mask &= (z >= minimum[2]) & (z <= maximum[2])
    return cloud[mask]

# %% right: a comprehension, a list of rows back
def crop_region(cloud, minimum, maximum):
    print("cropping")
    return [row for row in cloud.tolist()
            if all(low <= value <= high for value, low, high in zip(row, minimum, maximum))]

# %% right: axis after axis, single precision
import warnings

def crop_region(cloud, minimum, maximum):
    warnings.warn("cropping")
    cloud = cloud.astype(np.float32)
    for axis in range(3):
        cloud = cloud[cloud[:, axis] >= minimum[axis]]
        cloud = cloud[cloud[:, axis] <= maximum[axis]]
    return cloud

# %% right: what clip leaves alone is inside
def inside_of(points, low, high):
    return (np.clip(points, low, high) == points).sum(axis=1) == 3
# ---- another cell ----
def crop_region(cloud, minimum, maximum):
    return np.compress(inside_of(cloud[:, :3], minimum, maximum), cloud, axis=0)

# %% right: distance from the middle of the box
def crop_region(cloud, minimum, maximum):
    minimum, maximum = np.asarray(minimum), np.asarray(maximum)
    outside = np.abs(2 * cloud[:, :3] - (minimum + maximum)) > maximum - minimum
    return np.delete(cloud, np.flatnonzero(outside.any(axis=1)), axis=0)

# %% wrong: any instead of all
# loses only: cuts_on_four_sides, cuts_below_and_above, test_crop_streets, test_crop_other_boxes, test_crop_heights
# says: .all(axis=1), not .any
# told: One coordinate inside the box is enough
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).any(axis=1)]

# %% wrong: forgets the height
# loses only: cuts_below_and_above, test_crop_heights
# says: cloud[:, :3]
# told: Only x and y are compared
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :2] >= minimum[:2]) & (cloud[:, :2] <= maximum[:2])).all(axis=1)]

# %% wrong: only the upper corner
# loses: cuts_on_four_sides, cuts_below_and_above, test_crop_streets
# says: Join both
# told: Only maximum is compared
def crop_region(cloud, minimum, maximum):
    return cloud[(cloud[:, :3] <= maximum).all(axis=1)]

# %% wrong: only the lower corner
# loses: cuts_on_four_sides, cuts_below_and_above, test_crop_streets
# says: Join both
# told: Only minimum is compared
def crop_region(cloud, minimum, maximum):
    return cloud[(cloud[:, :3] >= minimum).all(axis=1)]

# %% wrong: keeps the outside
# loses: keeps_what_is_inside, test_crop_streets
# says: without ~
# told: the other way round
def crop_region(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: open box
# loses only: counts_the_faces, test_crop_faces
# says: missing
# told: Points on the faces go
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] > minimum) & (cloud[:, :3] < maximum)).all(axis=1)]

# %% wrong: the region is written into the function
# loses only: follows_the_corners, test_crop_other_boxes, test_crop_heights, test_crop_faces
# says: Compare with minimum and maximum
# told: The lesson's own region
def crop_region(cloud, minimum, maximum):
    minimum, maximum = (-10, -5, -2), (30, 6, 1)
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: counts the intensity as a coordinate
# loses: keeps_what_is_inside, test_crop_streets
# says: One side has x, y, z
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud >= minimum) & (cloud <= maximum)).all(axis=1)]

# %% wrong: and instead of &
# loses: keeps_what_is_inside, test_crop_streets
# says: Combine masks with & and |
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[(xyz >= minimum).all(axis=1) and (xyz <= maximum).all(axis=1)]

# %% wrong: & without parentheses
# loses: keeps_what_is_inside, test_crop_streets
# says: parentheses
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[(xyz >= minimum & xyz <= maximum).all(axis=1)]

# %% wrong: all of the columns
# loses: keeps_what_is_inside, test_crop_streets
# says: one value for each column
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[((xyz >= minimum) & (xyz <= maximum)).all(axis=0)]

# %% wrong: the table itself for a mask
# loses: keeps_what_is_inside, test_crop_streets
# says: .all(axis=1) makes one of each row
def crop_region(cloud, minimum, maximum):
    inside = (cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)
    return cloud[inside]

# %% wrong: cuts off the intensity
# loses only: crops_all_columns, test_crop_columns
# says: does not have the columns of the cloud
def crop_region(cloud, minimum, maximum):
    cloud = cloud[:, :3]
    return cloud[((cloud >= minimum) & (cloud <= maximum)).all(axis=1)]

# %% wrong: adds to the corners as tuples
# loses only: takes_any_corners, test_crop_input
# says: raised TypeError
def crop_region(cloud, minimum, maximum):
    more = cloud.shape[1] - 3
    low, high = minimum + (-np.inf,) * more, maximum + (np.inf,) * more
    return cloud[((cloud >= low) & (cloud <= high)).all(axis=1)]

# %% wrong: parameters renamed
# loses only: names_the_corners
# says: another name
def crop_region(cloud, low, high):
    return cloud[((cloud[:, :3] >= low) & (cloud[:, :3] <= high)).all(axis=1)]

# %% wrong: sorted by x
# loses only: crops_in_order, test_crop_order
# says: another order
def crop_region(cloud, minimum, maximum):
    kept = cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]
    return kept[np.argsort(kept[:, 0])]

# %% wrong: takes four columns only
# loses only: crops_three_columns, test_crop_kinds_of_clouds
# says: names than there are values
def crop_region(cloud, minimum, maximum):
    x, y, z, intensity = cloud.T
    xyz = np.column_stack([x, y, z])
    return cloud[((xyz >= minimum) & (xyz <= maximum)).all(axis=1)]

# %% wrong: moves points to the border instead of removing them
# loses: keeps_what_is_inside, crops_the_smallest, test_crop_streets
# says: values changed
# told: moved to the border
def crop_region(cloud, minimum, maximum):
    cloud[:, :3] = np.clip(cloud[:, :3], minimum, maximum)
    return cloud

# %% wrong: works on its input
# loses only: crops_a_copy, test_crop_input
# says: changed its input
def crop_region(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    kept = cloud[inside]
    cloud[~inside] = 0
    return kept

# %% wrong: returns the cloud as it is
# loses: keeps_what_is_inside, counts_the_faces, crops_the_smallest, test_crop_small
# says: too many
# told: Nothing is removed
def crop_region(cloud, minimum, maximum):
    return cloud

# %% right: the hints followed to the letter
def crop_region(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return cloud[inside]

# %% wrong: one answer for the whole cloud
# loses: keeps_what_is_inside, test_crop_streets
# says: for each row
# told: There is one answer
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) & (xyz <= maximum)).all()
    return cloud[inside]

# %% wrong: one comparison is enough
# loses: keeps_what_is_inside, test_crop_streets
# says: With | one of them is enough
# told: Nothing is removed
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) | (xyz <= maximum)).all(axis=1)
    return cloud[inside]

# %% wrong: minimum and maximum exchanged
# loses: keeps_what_is_inside, test_crop_streets
# says: Are the two exchanged
# told: no point counts as inside
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= maximum) & (xyz <= minimum)).all(axis=1)
    return cloud[inside]
