# Answers to crop_region; see grader/variants.py.

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
# loses: keeps_what_is_inside, test_crop_streets
# says: One coordinate within the box is enough here
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).any(axis=1)]

# %% wrong: forgets the height
# loses: keeps_what_is_inside, test_crop_other_boxes
# says: Only x and y are compared
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :2] >= minimum[:2]) & (cloud[:, :2] <= maximum[:2])).all(axis=1)]

# %% wrong: only the upper corner
# loses: keeps_what_is_inside, test_crop_streets
# says: Only maximum is compared.
def crop_region(cloud, minimum, maximum):
    return cloud[(cloud[:, :3] <= maximum).all(axis=1)]

# %% wrong: keeps the outside
# loses: keeps_what_is_inside, test_crop_streets
# says: the mask is the wrong way round
def crop_region(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: open box
# loses: faces_are_inside
# says: missing
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] > minimum) & (cloud[:, :3] < maximum)).all(axis=1)]

# %% wrong: the region is written into the function
# loses: follows_the_corners, test_crop_other_boxes
# says: Use the parameters minimum and maximum
def crop_region(cloud, minimum, maximum):
    minimum, maximum = (-10, -5, -2), (30, 6, 1)
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

# %% wrong: counts the intensity as a coordinate
# loses: keeps_what_is_inside, test_crop_streets
# says: (n, 4) minus (3,) does not
def crop_region(cloud, minimum, maximum):
    return cloud[((cloud >= minimum) & (cloud <= maximum)).all(axis=1)]

# %% wrong: and instead of &
# loses: keeps_what_is_inside, test_crop_streets
# says: For arrays use a mask with & and |
def crop_region(cloud, minimum, maximum):
    xyz = cloud[:, :3]
    return cloud[(xyz >= minimum).all(axis=1) and (xyz <= maximum).all(axis=1)]

# %% wrong: cuts off the intensity
# loses: keeps_what_is_inside, test_crop_streets
# says: expected 4 columns
def crop_region(cloud, minimum, maximum):
    cloud = cloud[:, :3]
    return cloud[((cloud >= minimum) & (cloud <= maximum)).all(axis=1)]

# %% wrong: parameters renamed
# loses: follows_the_corners
# says: A parameter was renamed
def crop_region(cloud, low, high):
    return cloud[((cloud[:, :3] >= low) & (cloud[:, :3] <= high)).all(axis=1)]

# %% wrong: moves points to the border instead of removing them
# loses: keeps_what_is_inside, crops_every_shape, test_crop_streets
# says: values changed
def crop_region(cloud, minimum, maximum):
    cloud[:, :3] = np.clip(cloud[:, :3], minimum, maximum)
    return cloud

# %% wrong: returns the cloud as it is
# loses: keeps_what_is_inside, faces_are_inside, crops_every_shape, test_crop_small
# says: too many
def crop_region(cloud, minimum, maximum):
    return cloud
