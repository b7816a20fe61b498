# Answers to filter_by_distance; see grader/variants.py.

# %% right: hypot in one line
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]

# %% right: squares compared with a square
def filter_by_distance(cloud, distance=10.0):
    x, y = cloud[:, 0], cloud[:, 1]
    return cloud[x * x + y * y < distance * distance]

# %% right: a loop in plain Python, a list of lists back
import math

def filter_by_distance(cloud, distance=10.0):
    print("looking at", len(cloud), "points")
    kept = []
    for row in cloud.tolist():
        if math.sqrt(row[0] ** 2 + row[1] ** 2) <= distance:
            kept.append(row)
    return kept

# %% right: the norm of the first two columns, far rows deleted
import warnings

def filter_by_distance(cloud, distance=10.0):
    warnings.warn("far points go")
    far = np.where(np.linalg.norm(cloud[:, :2], axis=1) > distance)[0]
    return np.delete(cloud, far, axis=0)

# %% right: single precision, with a helper in another cell
import numpy

def length_on_the_road(points):
    return numpy.abs(points[:, 0] + 1j * points[:, 1])
# ---- another cell ----
def filter_by_distance(cloud, distance=10.0):
    cloud = np.float32(cloud)
    return np.compress(length_on_the_road(cloud) <= distance, cloud, axis=0)

# %% right: a picture on the way
import matplotlib.pyplot as plt

def filter_by_distance(cloud, distance=10.0):
    d = np.sqrt(np.sum(np.square(cloud[:, :2]), axis=1))
    plt.hist(d)
    plt.show()
    plt.close("all")
    return cloud.take(np.flatnonzero(d <= distance), axis=0)

# %% wrong: distance as a 3-D norm
# loses: ignores_height, test_height_and_intensity, test_course_cloud
# says: The height is counted in: that is the 3-D distance.
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.linalg.norm(cloud[:, :3], axis=1) <= distance]

# %% wrong: distance as a 4-D norm
# loses: ignores_height, ignores_intensity, test_height_and_intensity
# says: Height and intensity are counted in: that is the length of the row.
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.linalg.norm(cloud, axis=1) <= distance]

# %% wrong: a square instead of a circle
# loses: keeps_what_is_near, test_turned_and_mixed, test_course_cloud
# says: This is a square, not a circle
def filter_by_distance(cloud, distance=10.0):
    return cloud[(np.abs(cloud[:, 0]) <= distance) & (np.abs(cloud[:, 1]) <= distance)]

# %% wrong: squared and plain distance confused
# loses: keeps_what_is_near, test_course_cloud
# says: The squared distance is compared with the plain one.
def filter_by_distance(cloud, distance=10.0):
    return cloud[cloud[:, 0] ** 2 + cloud[:, 1] ** 2 <= distance]

# %% wrong: only x, without its sign in mind
# loses: keeps_what_is_near, test_fresh_street
# says: Only x is compared.
def filter_by_distance(cloud, distance=10.0):
    return cloud[cloud[:, 0] <= distance]

# %% wrong: ten metres written into the function
# loses: follows_the_distance, test_other_distances
# says: comes from the parameter
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= 10]

# %% wrong: parameters renamed
# loses: follows_the_distance
# says: A parameter was renamed
def filter_by_distance(points, max_distance=10.0):
    return points[np.hypot(points[:, 0], points[:, 1]) <= max_distance]

# %% wrong: default changed
# loses: follows_the_distance, test_course_cloud
# says: too many
def filter_by_distance(cloud, distance=20.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]

# %% wrong: keeps the far points
# loses: keeps_what_is_near, test_course_cloud
# says: the comparison is the wrong way round
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > distance]

# %% wrong: intensity is cut off
# loses: keeps_what_is_near, test_course_cloud
# says: expected 4 columns
def filter_by_distance(cloud, distance=10.0):
    cloud = cloud[:, :3]
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]

# %% wrong: returns the distances
# loses: keeps_what_is_near, test_course_cloud
# says: expected 4 columns
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    return d[d <= distance]

# %% wrong: zeroes what is far in place
# loses: keeps_what_is_near, leaves_its_input, test_course_cloud
# says: values changed
def filter_by_distance(cloud, distance=10.0):
    cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > distance] = 0
    return cloud

# %% wrong: sorts by distance
# loses: keeps_what_is_near, test_turned_and_mixed
# says: another order
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    order = np.argsort(d)
    return cloud[order[d[order] <= distance]]

# %% wrong: fails on an empty cloud
# loses: takes_every_shape, test_small_and_single
# says: can be empty
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    if d.min() > distance:
        return None
    return cloud[d <= distance]

# %% wrong: returns the cloud as it is
# loses: keeps_what_is_near, takes_every_shape, leaves_its_input, test_small_and_single
# says: too many
def filter_by_distance(cloud, distance=10.0):
    return cloud
