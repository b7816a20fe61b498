# Answers to fit_plane; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    _, _, directions = np.linalg.svd(points[:, :3] - centre, full_matrices=False)
    normal = directions[-1]
    d = -(normal @ centre)
    return (*normal, d)

# %% right: SVD of the centred points
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ centre)

# %% right: eigenvectors of the covariance matrix
def fit_plane(points):
    print("fitting")
    xyz = np.array(points[:, :3], dtype=float)
    values, vectors = np.linalg.eigh(np.cov(xyz.T))
    a, b, c = vectors[:, 0]
    return a, b, c, -float(vectors[:, 0] @ xyz.mean(axis=0))

# %% right: PCA of a library
from sklearn.decomposition import PCA

def fit_plane(points):
    pca = PCA(3).fit(points[:, :3])
    return [float(value) for value in (*pca.components_[2], -pca.components_[2] @ pca.mean_)]

# %% right: eigenvalues of the scatter matrix, unsorted, in single precision
import warnings

def scatter(xyz):
    return xyz.T @ xyz
# ---- another cell ----
def fit_plane(points):
    warnings.warn("careful")
    centre = np.sum(points[:, :3], axis=0, dtype=float) / len(points)
    values, vectors = np.linalg.eig(scatter(points[:, :3] - centre))
    normal = vectors[:, np.argmin(values)]
    return np.array([*normal, -(normal * centre).sum()])

# %% right: SVD of the table turned over, upward normal
def fit_plane(points):
    xyz = points[:, :3].astype(float)
    mean = np.average(xyz, axis=0)
    u, s, vt = np.linalg.svd((xyz - mean).T, full_matrices=False)
    n = u[:, np.argmin(s)]
    n = n if n[2] > 0 else -n
    return (n[0], n[1], n[2], -np.inner(n, mean))

# %% wrong: not centred
# loses: fits_a_road, fits_far_away, test_fit_any_direction
# says: lies nearer to them
# told: not centred
def fit_plane(points):
    xyz = points[:, :3]
    normal = np.linalg.svd(xyz, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ xyz.mean(axis=0))

# %% wrong: the direction of largest spread
# loses: fits_a_road, fits_a_wall, test_fit_any_direction
# says: lies nearer to them
# told: direction of largest spread
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][0]
    return np.append(normal, -normal @ centre)

# %% wrong: a column of V instead of a row
# loses: fits_a_road, test_fit_any_direction
# says: lies nearer to them
# told: a column of the SVD's third result
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][:, 2]
    return np.append(normal, -normal @ centre)

# %% wrong: solves for z
# loses only: fits_a_wall, test_fit_any_direction
# says: lies nearer to them
# told: not square to the plane
def fit_plane(points):
    xyz = points[:, :3]
    a, b, d = np.linalg.lstsq(np.column_stack([xyz[:, :2], np.ones(len(xyz))]), xyz[:, 2],
                              rcond=None)[0]
    normal = np.array([a, b, -1.0, d])
    return normal / np.linalg.norm(normal[:3])

# %% wrong: a normal of another length
# loses only: fit_has_a_unit_normal, fits_a_wall, test_fit_any_direction
# says: not 1
# told: (a, b, -1) is not divided
def fit_plane(points):
    xyz = points[:, :3]
    a, b, d = np.linalg.lstsq(np.column_stack([xyz[:, :2], np.ones(len(xyz))]), xyz[:, 2],
                              rcond=None)[0]
    return np.array([a, b, -1.0, d])

# %% wrong: the plane through the first three points
# loses: fits_a_road, test_fit_any_direction
# says: lies nearer to them
# told: Only the first three points
def fit_plane(points):
    p, q, r = points[:3, :3]
    normal = np.cross(q - p, r - p)
    normal = normal / np.linalg.norm(normal)
    return np.append(normal, -normal @ p)

# %% wrong: intensity as a fourth direction
# loses only: fits_without_intensity, test_fit_course_cloud
# says: A plane is four numbers
def fit_plane(points):
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ centre)

# %% wrong: moves the cloud to its mean
# loses only: leaves_the_points_where_they_are
# says: changed its input
def fit_plane(points):
    xyz = points[:, :3]
    centre = xyz.mean(axis=0)
    xyz -= centre
    normal = np.linalg.svd(xyz, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ centre)

# %% wrong: the sign of d
# loses only: goes_through_the_mean, test_fit_offset
# says: away from the plane
# told: The sign of d is wrong
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][-1]
    return np.append(normal, normal @ centre)

# %% wrong: covariance of rows instead of columns
# loses: fits_a_road, test_fit_any_direction
# says: A plane is four numbers
def fit_plane(points):
    xyz = points[:, :3]
    values, vectors = np.linalg.eigh(np.cov(xyz))
    normal = vectors[:, 0]
    return np.append(normal, 0.0)

# %% wrong: a flat road for everybody
# loses: fits_a_road, fits_a_wall, fits_far_away, test_fit_any_direction
# says: lies nearer to them
def fit_plane(points):
    return (0.0, 0.0, 1.0, -points[:, 2].mean())

# %% wrong: d is 0
# loses only: goes_through_the_mean, test_fit_offset
# says: away from the plane
# told: d is 0
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][-1]
    return np.append(normal, 0.0)

# %% wrong: the second row
# loses: fits_a_road, test_fit_any_direction
# says: lies nearer to them
# told: second largest spread
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][1]
    return np.append(normal, -normal @ centre)

# %% wrong: the last direction of all four columns
# loses: fits_without_intensity, test_fit_course_cloud
# says: lies nearer to them
def fit_plane(points):
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][-1][:3]
    normal = normal / np.linalg.norm(normal)
    return np.append(normal, -normal @ centre[:3])

# %% wrong: the third direction of all four columns
# loses: fits_without_intensity
# says: lies nearer to them
def fit_plane(points):
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][2][:3]
    normal = normal / np.linalg.norm(normal)
    return np.append(normal, -normal @ centre[:3])

# %% wrong: twice the length
# loses only: fit_has_a_unit_normal
# says: has length 2, not 1
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = 2 * np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ centre)

# %% wrong: more than three points
# loses only: fits_three_points, test_fit_small
# says: returned None
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    if len(points) > 3:
        normal = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2][-1]
        return np.append(normal, -normal @ centre)

# %% wrong: parameter renamed
# loses only: keeps_points
# says: another name
def fit_plane(cloud):
    centre = cloud[:, :3].mean(axis=0)
    normal = np.linalg.svd(cloud[:, :3] - centre, full_matrices=False)[2][-1]
    return np.append(normal, -normal @ centre)

# %% wrong: full matrices
# loses only: fits_many_points
# says: not enough memory for the plane
def fit_plane(points):
    centre = points[:, :3].mean(axis=0)
    normal = np.linalg.svd(points[:, :3] - centre)[2][2]
    return (*normal, -normal @ centre)
