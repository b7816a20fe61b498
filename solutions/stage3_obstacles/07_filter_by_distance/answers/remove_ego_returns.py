# Answers to remove_ego_returns; see grader/course/kept_answers.py.

# %% right: inside, inverted
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return cloud[~inside]

# %% right: outside in one coordinate at least
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] < minimum) | (cloud[:, :3] > maximum)).any(axis=1)]

# %% right: a loop in plain Python, a list back
def remove_ego_returns(cloud, minimum, maximum):
    print("this is our own car")
    kept = []
    for row in cloud:
        if not all(minimum[k] <= row[k] <= maximum[k] for k in range(3)):
            kept.append(list(row))
    return kept

# %% right: np.delete, with a warning
import warnings

def remove_ego_returns(cloud, minimum, maximum):
    warnings.warn("careful")
    xyz = cloud[:, :3]
    ours = np.where((xyz >= minimum).all(axis=1) & (xyz <= maximum).all(axis=1))[0]
    return np.delete(cloud, ours, axis=0)

# %% right: single precision and a helper
def inside_of(points, low, high):
    return np.logical_and.reduce([(points[:, k] >= low[k]) & (points[:, k] <= high[k])
                                  for k in range(3)])
# ---- another cell ----
def remove_ego_returns(cloud, minimum, maximum):
    cloud = np.asarray(cloud, dtype="float32")
    return cloud[np.logical_not(inside_of(cloud, minimum, maximum))]

# %% right: six comparisons joined by or
def remove_ego_returns(cloud, minimum, maximum):
    x, y, z = cloud.T[:3]
    return cloud[(x < minimum[0]) | (x > maximum[0]) | (y < minimum[1]) | (y > maximum[1])
                 | (z < minimum[2]) | (z > maximum[2])]

# %% wrong: outside in all three coordinates
# loses only: keeps_ahead_and_beside, keeps_above_and_below, test_remove_from_streets, test_remove_other_boxes, test_remove_heights
# says: .any(axis=1)
# told: in x and in y and in z
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[((xyz < minimum) | (xyz > maximum)).all(axis=1)]

# %% wrong: keeps our own car
# loses: removes_our_own, test_remove_from_streets
# says: ~inside
# told: the other way round
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: a column of air above the car goes, too
# loses only: keeps_above_and_below, test_remove_from_streets, test_remove_heights
# says: missing
# told: above or below the box
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :2] >= minimum[:2]) & (cloud[:, :2] <= maximum[:2])).all(axis=1)]

# %% wrong: a circle around the sensor
# loses: removes_our_own, test_remove_from_streets
# says: missing
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > 3.0]

# %% wrong: an ego box written into the function
# loses only: follows_the_ego_box, removes_the_faces, test_remove_other_boxes, test_remove_heights, test_remove_faces
# says: by their names
# told: The lesson's own box
def remove_ego_returns(cloud, minimum, maximum):
    minimum, maximum = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
    return cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: open box
# loses only: removes_the_faces, test_remove_faces
# says: too many
# told: Points on the faces stay
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] > minimum) & (cloud[:, :3] < maximum)).all(axis=1)]

# %% wrong: removes the rows with both corners swapped
# loses: removes_our_own, test_remove_from_streets
# says: too many
# told: Nothing is removed
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] >= maximum) & (cloud[:, :3] <= minimum)).all(axis=1)]

# %% wrong: inverts before joining
# loses: removes_our_own, test_remove_from_streets
# says: which | joins
# told: every point counts as inside
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] < minimum) & (cloud[:, :3] > maximum)).any(axis=1)]

# %% wrong: zeroes our own returns instead of removing them
# loses: removes_our_own, frees_the_smallest, test_remove_from_streets
# says: values changed
# told: are set to 0
def remove_ego_returns(cloud, minimum, maximum):
    cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)] = 0
    return cloud

# %% wrong: cuts off the intensity
# loses only: leaves_all_columns, test_remove_columns
# says: does not have the columns of the cloud
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return xyz[~((xyz >= minimum) & (xyz <= maximum)).all(axis=1)]

# %% wrong: removes duplicates, too
# loses only: leaves_the_order, test_remove_order, test_remove_kinds_of_clouds, test_remove_from_streets
# says: another order
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return np.unique(cloud[~inside], axis=0)

# %% wrong: returns the mask
# loses: removes_our_own, test_remove_from_streets
# says: This is a mask
def remove_ego_returns(cloud, minimum, maximum):
    return ~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)

# %% wrong: not instead of ~
# loses: removes_our_own, test_remove_from_streets
# says: turn one round with ~
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return cloud[not inside]

# %% wrong: parameters renamed
# loses only: names_the_ego_box
# says: another name
def remove_ego_returns(cloud, low, high):
    return cloud[~((cloud[:, :3] >= low) & (cloud[:, :3] <= high)).all(axis=1)]

# %% wrong: works on its input
# loses only: frees_a_copy, test_remove_input
# says: changed its input
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    kept = cloud[~inside]
    cloud[inside] = 0
    return kept

# %% wrong: fails where nothing is left
# loses only: frees_the_smallest, test_remove_small
# says: can be empty
def remove_ego_returns(cloud, minimum, maximum):
    kept = cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]
    print("lowest", kept[:, 2].min())
    return kept

# %% wrong: returns the cloud as it is
# loses: removes_our_own, frees_the_smallest, frees_a_copy
# says: too many
# told: Nothing is removed
def remove_ego_returns(cloud, minimum, maximum):
    return cloud

# %% right: the hints followed to the letter
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return cloud[~inside]

# %% wrong: one answer for the whole cloud
# loses: removes_our_own, test_remove_from_streets
# says: for each row
# told: There is one answer
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) & (xyz <= maximum)).all()
    return cloud[~inside]

# %% wrong: one comparison is enough
# loses: removes_our_own, test_remove_from_streets
# says: which & joins
# told: every point counts as inside
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) | (xyz <= maximum)).all(axis=1)
    return cloud[~inside]

# %% wrong: minimum and maximum exchanged
# loses: removes_our_own, test_remove_from_streets
# says: are the two exchanged
# told: Nothing is removed
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz >= maximum) & (xyz <= minimum)).all(axis=1)
    return cloud[~inside]

# %% wrong: minimum is not compared
# loses only: keeps_ahead_and_beside, keeps_above_and_below, test_remove_from_streets, test_remove_other_boxes, test_remove_heights
# says: Join both
# told: what lies before minimum goes
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    inside = ((xyz <= maximum)).all(axis=1)
    return cloud[~inside]
