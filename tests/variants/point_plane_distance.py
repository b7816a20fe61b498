# Answers to point_plane_distance; see grader/variants.py.

# %% right: a matrix product
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) + plane[3])

# %% right: column by column
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

# %% right: a loop in plain Python, a list back
def point_plane_distance(points, plane):
    print("measuring")
    a, b, c, d = plane
    return [abs(a * p[0] + b * p[1] + c * p[2] + d) for p in points.tolist()]

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
# loses: measures_distances, forgets_the_sign, test_distances_in_the_course_cloud
# says: Some are negative
def point_plane_distance(points, plane):
    return points[:, :3] @ np.asarray(plane[:3]) + plane[3]

# %% wrong: d is missing
# loses: measures_distances, test_distances_in_the_course_cloud
# says: d is missing
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]))

# %% wrong: d is subtracted
# loses: measures_distances, test_distances_in_the_course_cloud
# says: d is subtracted
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) - plane[3])

# %% wrong: whole rows times the plane
# loses: ignores_intensity, test_distances_of_small_clouds
# says: distances are wrong
def point_plane_distance(points, plane):
    plane = np.asarray(plane)
    if points.shape[1] == 4:
        return np.abs(points @ plane)
    return np.abs(points @ plane[:3] + plane[3])

# %% wrong: squared
# loses: measures_distances, test_distances_in_the_course_cloud
# says: squares of the distances
def point_plane_distance(points, plane):
    return (points[:, :3] @ np.asarray(plane[:3]) + plane[3]) ** 2

# %% wrong: a column
# loses: measures_distances, one_number_per_point, test_distances_in_the_course_cloud
# says: another shape
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]).reshape(3, 1) + plane[3])

# %% wrong: only the height
# loses: measures_distances, test_distances_survive_motion
# says: distances are wrong
def point_plane_distance(points, plane):
    return np.abs(points[:, 2] * plane[2] + plane[3])

# %% wrong: only the first three columns exist
# loses: ignores_intensity, test_distances_in_the_course_cloud
# says: The shapes do not fit
def point_plane_distance(points, plane):
    return np.abs((points * np.asarray(plane[:3])).sum(axis=1) + plane[3])

# %% wrong: one distance for all
# loses: measures_distances, one_number_per_point, test_distances_in_the_course_cloud
# says: another shape
def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ np.asarray(plane[:3]) + plane[3]).sum()

# %% wrong: absolute value of each term
# loses: measures_distances, test_distances_survive_motion
# says: distances are wrong
def point_plane_distance(points, plane):
    a, b, c, d = plane
    return np.abs(a * points[:, 0]) + np.abs(b * points[:, 1]) + np.abs(c * points[:, 2] + d)

# %% wrong: zeros
# loses: measures_distances, forgets_the_sign, ignores_intensity, one_number_per_point
# says: distances are wrong
def point_plane_distance(points, plane):
    return np.zeros(len(points))
