# Answers to point_plane_distance; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return np.abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

# %% right: a matrix product
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) + plane[3])

# %% right: column by column
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

# %% right: a loop in plain Python
def point_plane_distance(points, plane):
    print("measuring")
    a, b, c, d = plane
    return np.array([abs(a * p[0] + b * p[1] + c * p[2] + d) for p in points.tolist()])

# %% right: divides by the length of the normal once more
def point_plane_distance(points, plane):
    plane = np.array(plane, dtype=float)
    homogeneous = np.column_stack([points[:, :3], np.ones(len(points))])
    return np.abs(homogeneous @ plane) / np.linalg.norm(plane[:3])

# %% right: single precision, from a point of the plane
import warnings

def foot(plane):
    return -plane[3] * np.array(plane[:3])
# ---- another cell ----
def point_plane_distance(points, plane):
    warnings.warn("measuring")
    gaps = np.einsum("ij,j->i", points[:, :3] - foot(plane), np.array(plane[:3]))
    return np.sqrt(gaps ** 2).astype(np.float32)

# %% wrong: no absolute value
# loses only: forgets_the_sign, takes_abs_last, test_both_sides
# says: distances are not right
# told: No absolute value is taken
def point_plane_distance(points, plane):
    return points[:, :3] @ np.asarray(plane[:3]) + plane[3]

# %% wrong: d is missing
# loses only: adds_d, takes_abs_last, test_offset_planes, test_both_sides_anywhere
# says: distances are not right
# told: d is missing
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]))

# %% wrong: d is subtracted
# loses only: adds_d, takes_abs_last, test_offset_planes, test_both_sides_anywhere
# says: distances are not right
# told: d is subtracted
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) - plane[3])

# %% wrong: whole rows times the plane
# loses only: ignores_intensity, test_four_columns
# says: are others than without it
# told: Whole rows are multiplied
def point_plane_distance(points, plane):
    plane = np.asarray(plane)
    if points.shape[1] == 4:
        return np.abs(points @ plane)
    return np.abs(points @ plane[:3] + plane[3])

# %% wrong: squared
# loses: measures_distances, test_distances_in_the_course_cloud
# says: distances are not right
# told: squares of the distances
def point_plane_distance(points, plane):
    return (points[:, :3] @ np.asarray(plane[:3]) + plane[3]) ** 2

# %% wrong: a column
# loses: measures_distances, takes_few_points, test_distances_in_the_course_cloud
# says: A column (n, 1) is a table
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]).reshape(3, 1) + plane[3])

# %% wrong: only the height
# loses: measures_distances, test_distances_in_the_course_cloud
# says: distances are not right
def point_plane_distance(points, plane):
    return np.abs(points[:, 2] * plane[2] + plane[3])

# %% wrong: only the first three columns exist
# loses only: ignores_intensity, test_four_columns
# says: One side has x, y, z, the other has intensity
def point_plane_distance(points, plane):
    return np.abs((points * np.asarray(plane[:3])).sum(axis=1) + plane[3])

# %% wrong: one distance for all
# loses: measures_distances, takes_few_points, test_distances_in_the_course_cloud
# says: an axis= is missing
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) + plane[3]).sum()

# %% wrong: absolute value of each term
# loses: measures_distances, test_distances_in_the_course_cloud
# says: distances are not right
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return np.abs(a * points[:, 0]) + np.abs(b * points[:, 1]) + np.abs(c * points[:, 2] + d)

# %% wrong: zeros
# loses: measures_distances, forgets_the_sign, ignores_intensity, takes_few_points
# says: distances are not right
def point_plane_distance(points, plane):
    return np.zeros(len(points))

# %% wrong: absolute value before d is added
# loses only: takes_abs_last, test_both_sides_anywhere
# says: distances are not right
# told: and d is added after that
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3])) + plane[3]

# %% wrong: absolute value of the products and of d
# loses only: adds_d, takes_abs_last, test_offset_planes, test_both_sides_anywhere
# says: distances are not right
# told: are taken apart and then added
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3])) + abs(plane[3])

# %% wrong: absolute value of each product, then d
# loses: measures_distances, test_distances_in_the_course_cloud
# says: distances are not right
# told: of each product
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0]) + abs(b * points[:, 1]) + abs(c * points[:, 2]) + d

# %% wrong: absolute value of all four
# loses: measures_distances, test_distances_in_the_course_cloud
# says: distances are not right
# told: of c z and of d
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0]) + abs(b * points[:, 1]) + abs(c * points[:, 2]) + abs(d)

# %% wrong: divided by the length of all four numbers
# loses only: adds_d, takes_abs_last, test_offset_planes, test_both_sides_anywhere
# says: distances are not right
# told: the length of all four numbers
def point_plane_distance(points, plane):
    plane = np.asarray(plane)
    return np.abs(points[:, :3] @ plane[:3] + plane[3]) / np.linalg.norm(plane)

# %% wrong: writes into the cloud
# loses only: leaves_cloud_and_plane
# says: changed its input
def point_plane_distance(points, plane):
    xyz = points[:, :3]
    xyz *= np.asarray(plane[:3])
    return np.abs(xyz.sum(axis=1) + plane[3])

# %% wrong: takes no tuple
# loses only: takes_a_tuple
# says: no attribute 'dot'
def point_plane_distance(points, plane):
    return np.abs(plane[:3].dot(points[:, :3].T) + plane[3])

# %% wrong: not for an empty cloud
# loses only: takes_few_points
# says: raised
def point_plane_distance(points, plane):
    table = np.concatenate([p[None, :3] for p in points])
    return np.abs(table @ np.asarray(plane[:3]) + plane[3])

# %% wrong: parameters renamed
# loses only: keeps_points_and_plane
# says: another name
def point_plane_distance(cloud, model):
    return np.abs(cloud[:, :3] @ np.asarray(model[:3]) + model[3])

# %% wrong: a list back
# loses only: gives_an_array
# says: they are no array
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return [abs(a * p[0] + b * p[1] + c * p[2] + d) for p in points.tolist()]
