# Answers to filter_by_distance; see grader/course/kept_answers.py.

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
# loses only: ignores_height, test_heights, test_course_cloud
# says: rows missing
# told: The height is counted in
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.linalg.norm(cloud[:, :3], axis=1) <= distance]

# %% wrong: distance as a 4-D norm
# loses only: ignores_height, ignores_intensity, test_heights, test_intensities, test_course_cloud
# says: columns 0 and 1 only
# told: Height and intensity are counted in
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.linalg.norm(cloud, axis=1) <= distance]

# %% wrong: a square instead of a circle
# loses only: draws_a_circle, test_turned, test_course_cloud, test_fresh_street
# says: rows too many
# told: that is a square, not a circle
def filter_by_distance(cloud, distance=10.0):
    return cloud[(np.abs(cloud[:, 0]) <= distance) & (np.abs(cloud[:, 1]) <= distance)]

# %% wrong: squared and plain distance confused
# loses: keeps_what_is_near, test_course_cloud
# says: rows missing
# told: a root is missing
def filter_by_distance(cloud, distance=10.0):
    return cloud[cloud[:, 0] ** 2 + cloud[:, 1] ** 2 <= distance]

# %% wrong: the square on the wrong side
# loses: keeps_what_is_near, test_course_cloud
# says: too many
# told: square of `distance`
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance**2]

# %% wrong: x and y added
# loses only: draws_a_circle, test_turned, test_course_cloud, test_fresh_street
# says: missing
# told: x and y are added up
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.abs(cloud[:, 0]) + np.abs(cloud[:, 1]) <= distance]

# %% wrong: only x, without its sign in mind
# loses: keeps_what_is_near, looks_all_around, test_fresh_street
# says: too many
# told: Only x is compared, with its sign
def filter_by_distance(cloud, distance=10.0):
    return cloud[cloud[:, 0] <= distance]

# %% wrong: only x, on both sides
# loses: keeps_what_is_near, test_fresh_street
# says: too many
# told: everything beside us stays
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.abs(cloud[:, 0]) <= distance]

# %% wrong: x and y with their signs
# loses: looks_all_around, draws_a_circle, test_fresh_street
# says: too many
# told: with their signs
def filter_by_distance(cloud, distance=10.0):
    return cloud[(cloud[:, 0] <= distance) & (cloud[:, 1] <= distance)]

# %% wrong: one distance for all
# loses: keeps_what_is_near, test_fresh_street
# says: axis=1
# told: There is one distance for the whole cloud
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.linalg.norm(cloud[:, :2]) <= distance]

# %% wrong: math on whole columns
# loses: keeps_what_is_near, test_fresh_street
# says: np.sqrt
def filter_by_distance(cloud, distance=10.0):
    import math
    return cloud[math.sqrt(cloud[:, 0] ** 2 + cloud[:, 1] ** 2) <= distance]

# %% wrong: a power that is none
# loses: keeps_what_is_near, test_fresh_street
# says: x**2 is the square
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.sqrt(cloud[:, 0] ^ 2 + cloud[:, 1] ^ 2) <= distance]

# %% wrong: ten metres written into the function
# loses only: follows_the_distance, test_other_distances
# says: Compare with `distance`
# told: A fixed distance of 10 m
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= 10]

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def filter_by_distance(points, max_distance=10.0):
    return points[np.hypot(points[:, 0], points[:, 1]) <= max_distance]

# %% wrong: default changed
# loses only: keeps_the_default
# says: too many
def filter_by_distance(cloud, distance=20.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]

# %% wrong: keeps the far points
# loses: keeps_what_is_near, test_course_cloud
# says: which comparison
# told: the other way round
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > distance]

# %% wrong: intensity is cut off
# loses only: keeps_the_columns, test_columns
# says: does not have the columns of the cloud
def filter_by_distance(cloud, distance=10.0):
    cloud = cloud[:, :3]
    return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]

# %% wrong: takes four columns only
# loses only: takes_three_columns, test_kinds_of_clouds
# says: names than there are values
def filter_by_distance(cloud, distance=10.0):
    x, y, z, intensity = cloud.T
    return cloud[np.hypot(x, y) <= distance]

# %% wrong: returns the distances
# loses: keeps_what_is_near, test_course_cloud
# says: Index the whole cloud
# told: are the distances
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    return d[d <= distance]

# %% wrong: returns the mask
# loses: keeps_what_is_near, test_course_cloud
# says: This is a mask
def filter_by_distance(cloud, distance=10.0):
    return np.hypot(cloud[:, 0], cloud[:, 1]) <= distance

# %% wrong: rows for columns
# loses: keeps_what_is_near, test_course_cloud
# says: a column of the cloud is cloud[:, 0]
def filter_by_distance(cloud, distance=10.0):
    return cloud[np.sqrt(cloud[0] ** 2 + cloud[1] ** 2) <= distance]

# %% wrong: the mask where columns are chosen
# loses: keeps_what_is_near, test_course_cloud
# says: Points are rows: cloud[mask]
def filter_by_distance(cloud, distance=10.0):
    mask = np.hypot(cloud[:, 0], cloud[:, 1]) <= distance
    return cloud[:, mask]

# %% wrong: zeroes what is far in place
# loses: keeps_what_is_near, leaves_its_input, test_course_cloud
# says: values changed
# told: Far rows are set to 0
def filter_by_distance(cloud, distance=10.0):
    cloud[np.hypot(cloud[:, 0], cloud[:, 1]) > distance] = 0
    return cloud

# %% wrong: measures into its input
# loses only: leaves_its_input, test_input
# says: changed its input
def filter_by_distance(cloud, distance=10.0):
    kept = cloud[np.hypot(cloud[:, 0], cloud[:, 1]) <= distance]
    cloud[:, 2] = 0
    return kept

# %% wrong: sorts by distance
# loses only: keeps_the_order, test_order
# says: another order
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    order = np.argsort(d)
    return cloud[order[d[order] <= distance]]

# %% wrong: fails where nothing is left
# loses only: takes_the_smallest, test_small
# says: can be empty
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    near = cloud[d <= distance]
    print("nearest", near[:, 0].min())
    return near

# %% wrong: returns the cloud as it is
# loses: keeps_what_is_near, takes_the_smallest, leaves_its_input, test_small
# says: too many
# told: Nothing is removed
def filter_by_distance(cloud, distance=10.0):
    return cloud

# %% right: the hints followed to the letter
def filter_by_distance(cloud, distance=10.0):
    d = np.hypot(cloud[:, 0], cloud[:, 1])
    return cloud[d <= distance]

# %% wrong: x and z
# loses: keeps_what_is_near, test_course_cloud
# says: Column 2 is the height
# told: x and z make the distance
def filter_by_distance(cloud, distance=10.0):
    along_the_road = np.hypot(cloud[:, 0], cloud[:, 2])
    return cloud[along_the_road <= distance]

# %% wrong: y and z
# loses: keeps_what_is_near, test_course_cloud
# says: Column 2 is the height
# told: y and z make the distance
def filter_by_distance(cloud, distance=10.0):
    along_the_road = np.hypot(cloud[:, 1], cloud[:, 2])
    return cloud[along_the_road <= distance]

# %% wrong: x and y added up
# loses: looks_all_around, draws_a_circle, test_course_cloud
# says: take the root
# told: with their signs: it takes
def filter_by_distance(cloud, distance=10.0):
    along_the_road = cloud[:, 0] + cloud[:, 1]
    return cloud[along_the_road <= distance]

# %% wrong: the norm of two columns
# loses: keeps_what_is_near, test_course_cloud
# says: axis=1 goes along a row
def filter_by_distance(cloud, distance=10.0):
    along_the_road = np.linalg.norm(cloud[:, :2], axis=0)
    return cloud[along_the_road <= distance]
