# Answers to remove_ego_returns; see grader/variants.py.

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
# loses: removes_our_own, keeps_what_shares_a_coordinate, test_remove_from_streets
# says: Only rows that are outside in x and in y and in z are left
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[((xyz < minimum) | (xyz > maximum)).all(axis=1)]

# %% wrong: keeps our own car
# loses: removes_our_own, test_remove_from_streets
# says: These are the rows inside the box
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: a column of air above the car goes, too
# loses: keeps_what_shares_a_coordinate, test_remove_other_boxes
# says: what is above or below the box is no part of it
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :2] >= minimum[:2]) & (cloud[:, :2] <= maximum[:2])).all(axis=1)]

# %% wrong: a circle around the sensor
# loses: removes_our_own, test_remove_from_streets
# says: missing
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > 3.0]

# %% wrong: an ego box written into the function
# loses: follows_the_ego_box, test_remove_other_boxes
# says: All six numbers come from minimum and maximum
def remove_ego_returns(cloud, minimum, maximum):
    minimum, maximum = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
    return cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: removes the rows with both corners swapped
# loses: removes_our_own, test_remove_from_streets
# says: too many
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] >= maximum) & (cloud[:, :3] <= minimum)).all(axis=1)]

# %% wrong: inverts before joining
# loses: removes_our_own, test_remove_from_streets
# says: missing
def remove_ego_returns(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] < minimum) & (cloud[:, :3] > maximum)).any(axis=1)]

# %% wrong: zeroes our own returns instead of removing them
# loses: removes_our_own, removes_from_every_shape, test_remove_from_streets
# says: values changed
def remove_ego_returns(cloud, minimum, maximum):
    cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)] = 0
    return cloud

# %% wrong: cuts off the intensity
# loses: removes_our_own, test_remove_from_streets
# says: expected 4 columns
def remove_ego_returns(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return xyz[~((xyz >= minimum) & (xyz <= maximum)).all(axis=1)]

# %% wrong: removes duplicates, too
# loses: removes_our_own, test_remove_small
# says: another order
def remove_ego_returns(cloud, minimum, maximum):
    inside = ((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)
    return np.unique(cloud[~inside], axis=0)

# %% wrong: returns the cloud as it is
# loses: removes_our_own, keeps_what_shares_a_coordinate, removes_from_every_shape
# says: too many
def remove_ego_returns(cloud, minimum, maximum):
    return cloud
