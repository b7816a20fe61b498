# Answers to filter_ground; see grader/course/kept_answers.py.

# %% right: a mask in one line
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= ground_level]

# %% right: a loop over rows, a list of rows back
def filter_ground(cloud, ground_level=-1.2):
    kept = []
    for row in cloud:
        if row[2] > ground_level:
            kept.append(list(row))
    if not kept:
        return np.zeros((0, cloud.shape[1]))
    return kept

# %% right: np.delete, printing and warning all the way
import warnings

def filter_ground(cloud, ground_level=-1.2):
    print("filtering", len(cloud), "points")
    warnings.warn("this is only a drill")
    low = np.where(cloud[:, 2] < ground_level)[0]
    return np.delete(cloud, low, axis=0)

# %% right: single precision, with a helper in a cell of its own
%matplotlib inline
LEVEL = -1.2

def heights(points):
    return points.T[2]
# ---- another cell ----
!echo hello
def filter_ground(cloud, ground_level=LEVEL):
    cloud = np.asarray(cloud, dtype=np.float32)
    return np.compress(heights(cloud) >= ground_level, cloud, axis=0)

# %% right: it draws a figure on the way
import matplotlib.pyplot as plt

def filter_ground(cloud, ground_level=-1.2):
    above = np.flatnonzero(~(cloud[:, 2] < ground_level))
    plt.figure()
    plt.plot(cloud[:, 0], cloud[:, 2], ".")
    plt.show()
    plt.close("all")
    return cloud.take(above, axis=0)

# %% right: a comprehension kept as an array
def filter_ground(cloud, ground_level=-1.2):
    return np.array([p for p in cloud if p[2] >= ground_level]).reshape(-1, cloud.shape[1])

# %% right: the hints followed to the letter
def filter_ground(cloud, ground_level=-1.2):
    mask = cloud[:, 2] >= ground_level
    return cloud[mask]

# %% wrong: keeps the road instead
# loses: keeps_what_stands_above, test_course_cloud, test_fresh_street
# says: missing
# told: the other way round
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] < ground_level]

# %% wrong: the level is written into the function
# loses only: follows_the_level, test_other_levels
# says: Compare with ground_level
# told: A fixed level of -1.2
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= -1.2]

# %% wrong: the zero of a map
# loses: keeps_what_stands_above, follows_the_level, test_course_cloud
# says: missing
# told: A fixed level of 0
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] > 0]

# %% wrong: looks at y instead of z
# loses: keeps_what_stands_above, test_course_cloud
# says: too many
# told: Column 1
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 1] >= ground_level]

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def filter_ground(points, level=-1.2):
    return points[points[:, 2] >= level]

# %% wrong: default changed to the lab sheet's example
# loses only: keeps_the_default
# says: missing
def filter_ground(cloud, ground_level=1.0):
    return cloud[cloud[:, 2] >= ground_level]

# %% wrong: intensity is cut off
# loses only: keeps_the_columns, test_columns
# says: does not have the columns of the cloud
def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= ground_level][:, :3]

# %% wrong: takes four columns only
# loses only: takes_three_columns, test_kinds_of_clouds
# says: names than there are values
def filter_ground(cloud, ground_level=-1.2):
    x, y, z, intensity = cloud.T
    return cloud[z >= ground_level]

# %% wrong: nothing for nothing
# loses only: takes_the_smallest, test_small
# says: returned None
def filter_ground(cloud, ground_level=-1.2):
    kept = cloud[cloud[:, 2] >= ground_level]
    if len(kept) > 0:
        return kept

# %% wrong: changes its input
# loses only: leaves_its_input, test_input
# says: changed its input
def filter_ground(cloud, ground_level=-1.2):
    kept = cloud[cloud[:, 2] >= ground_level].copy()
    cloud[cloud[:, 2] < ground_level] = 0.0
    return kept

# %% wrong: sets the road to zero
# loses: keeps_what_stands_above, test_course_cloud
# says: holds only the rows
# told: are set to 0
def filter_ground(cloud, ground_level=-1.2):
    cloud[cloud[:, 2] < ground_level] = 0.0
    return cloud

# %% wrong: returns the mask
# loses: keeps_what_stands_above, test_course_cloud
# says: This is a mask
def filter_ground(cloud, ground_level=-1.2):
    return cloud[:, 2] >= ground_level

# %% wrong: the mask where columns are chosen
# loses: keeps_what_stands_above, test_course_cloud
# says: Points are rows: cloud[mask]
def filter_ground(cloud, ground_level=-1.2):
    mask = cloud[:, 2] >= ground_level
    return cloud[:, mask]

# %% wrong: returns the heights
# loses: keeps_what_stands_above, test_course_cloud
# says: Index the whole cloud
# told: are the heights
def filter_ground(cloud, ground_level=-1.2):
    z = cloud[:, 2]
    return z[z >= ground_level]

# %% wrong: heights without their sign
# loses: keeps_what_stands_above, follows_the_level, test_course_cloud
# says: too many
# told: without their sign
def filter_ground(cloud, ground_level=-1.2):
    return cloud[np.abs(cloud[:, 2]) >= ground_level]

# %% wrong: absolute height and absolute level
# loses: keeps_what_stands_above, test_course_cloud
# says: missing
def filter_ground(cloud, ground_level=-1.2):
    return cloud[np.abs(cloud[:, 2]) <= np.abs(ground_level)]

# %% wrong: forgets to return
# loses: keeps_what_stands_above, test_course_cloud, takes_the_smallest
# says: returned None
def filter_ground(cloud, ground_level=-1.2):
    kept = cloud[cloud[:, 2] >= ground_level]

# %% wrong: sorts by height
# loses only: keeps_the_order, test_order
# says: another order
def filter_ground(cloud, ground_level=-1.2):
    kept = cloud[cloud[:, 2] >= ground_level]
    return kept[np.argsort(kept[:, 2])]

# %% wrong: stub left in place
# loses: keeps_what_stands_above, test_course_cloud, leaves_its_input
# says: is not started
def filter_ground(cloud, ground_level=-1.2):
    raise NotImplementedError

# %% wrong: returns the cloud as it is
# loses: keeps_what_stands_above, takes_the_smallest, leaves_its_input, test_course_cloud
# says: too many
# told: Nothing is removed
def filter_ground(cloud, ground_level=-1.2):
    return cloud

# %% wrong: the level with the other sign
# loses: keeps_what_stands_above, test_course_cloud
# says: acts as 1.2
# told: with the other sign
def filter_ground(cloud, ground_level=-1.2):
    mask = cloud[:, 2] >= -ground_level
    return cloud[mask]

# %% wrong: the last column
# loses: keeps_what_stands_above, test_course_cloud
# says: whatever comes behind it
# told: The last column
def filter_ground(cloud, ground_level=-1.2):
    mask = cloud[:, -1] >= ground_level
    return cloud[mask]
