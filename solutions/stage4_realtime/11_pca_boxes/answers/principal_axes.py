# Answers to principal_axes; see grader/course/kept_answers.py.

# %% right: eigenvectors of the covariance
def principal_axes(points):
    q = points[:, :3]
    if len(q) == 0:
        return np.eye(3)
    q = q - q.mean(axis=0)
    _, axes = np.linalg.eigh(q.T @ q)
    axes = axes[:, ::-1].copy()
    if np.linalg.det(axes) < 0:
        axes[:, 2] = -axes[:, 2]
    return axes

# %% right: singular vectors of the covariance, third axis by the cross product
def principal_axes(points):
    if len(points) < 2:
        return [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    u, _, _ = np.linalg.svd(np.cov(points[:, :3], rowvar=False))
    return np.stack([u[:, 0], u[:, 1], np.cross(u[:, 0], u[:, 1])], axis=1).tolist()

# %% right: singular vectors of the points, padded when there are few
def principal_axes(points):
    xyz = np.vstack([points[:, :3], np.zeros((0, 3))])
    if len(xyz) < 3:
        xyz = np.vstack([xyz, np.repeat(xyz.mean(axis=0, keepdims=True) if len(xyz) else
                                        np.zeros((1, 3)), 3, axis=0)])
    rows = np.linalg.svd(xyz - xyz.mean(axis=0), full_matrices=False)[2]
    return (rows if np.linalg.det(rows) > 0 else -rows).T

# %% right: np.linalg.eig, sorted by hand, printing and warning
import warnings

def principal_axes(points):
    warnings.warn("eig is for general matrices")
    if not len(points):
        return np.identity(3)
    centred = points[:, :3] - np.mean(points[:, :3], axis=0)
    values, vectors = np.linalg.eig(np.dot(centred.T, centred))
    order = np.argsort(values.real)[::-1]
    vectors = np.linalg.qr(vectors.real[:, order])[0]
    print("variances", values)
    vectors[:, 0] *= np.linalg.det(vectors)
    return vectors

# %% right: Jacobi rotations in plain Python, with a helper in another cell
import math

def covariance(rows):
    n = len(rows)
    mean = [sum(row[a] for row in rows) / n for a in range(3)]
    return [[sum((row[a] - mean[a]) * (row[b] - mean[b]) for row in rows) / n
             for b in range(3)] for a in range(3)]
# ---- another cell ----
class Jacobi:
    def __init__(self, matrix):
        self.m = [list(row) for row in matrix]
        self.v = [[float(a == b) for b in range(3)] for a in range(3)]

    def rotate(self, p, q):
        m, v = self.m, self.v
        if abs(m[p][q]) < 1e-300:
            return
        angle = 0.5 * math.atan2(2 * m[p][q], m[q][q] - m[p][p])
        c, s = math.cos(angle), math.sin(angle)
        for k in range(3):
            m[k][p], m[k][q] = c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]
        for k in range(3):
            m[p][k], m[q][k] = c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]
        for k in range(3):
            v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]

def principal_axes(points):
    rows = points[:, :3].tolist()
    if not rows:
        return np.eye(3)
    solver = Jacobi(covariance(rows))
    for _ in range(12):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            solver.rotate(p, q)
    order = sorted(range(3), key=lambda a: -solver.m[a][a])
    axes = [[solver.v[k][a] for a in order] for k in range(3)]
    if np.linalg.det(np.array(axes)) < 0:
        axes = [[-x for x in row] for row in axes]
    return axes

# %% right: single precision, with a figure on the way
import matplotlib.pyplot as plt

def principal_axes(points):
    q = np.asarray(points, dtype=np.float64)[:, :3]
    plt.figure()
    plt.plot(q[:, 0], q[:, 1], ".")
    plt.close("all")
    q = q - q.sum(axis=0) / max(len(q), 1)
    values, axes = np.linalg.eigh((q.T @ q).astype(np.float32))
    axes = axes[:, np.argsort(-values)]
    return np.column_stack([axes[:, 0], axes[:, 1],
                            np.cross(axes[:, 0], axes[:, 1])]).astype(np.float32)

# %% wrong: np.cov of rows instead of columns
# loses: finds_the_directions, test_any_turn, test_scanned
# says: takes rows for variables
def principal_axes(points):
    if len(points) < 2:
        return np.eye(3)
    _, axes = np.linalg.eigh(np.cov(points[:, :3]))
    return axes[:, ::-1]

# %% wrong: columns left in ascending order
# loses only: orders_by_spread, finds_vehicles, test_order, test_scanned
# says: not in the order of the spread
# told: order of increasing spread
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    _, axes = np.linalg.eigh(q.T @ q)
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1
    return axes

# %% wrong: np.linalg.eig left unsorted
# loses only: orders_by_spread, finds_vehicles, test_order, test_scanned, test_few_points
# says: not in the order of the spread
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    _, axes = np.linalg.eig(q.T @ q)
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1
    return axes

# %% wrong: left-handed at times
# loses only: stays_right_handed, test_handed
# says: flip the sign of one column
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    return np.linalg.eigh(q.T @ q)[1][:, ::-1]

# %% wrong: the sign of the determinant before the order of the columns
# loses only: stays_right_handed, test_handed
# says: turning the order of three columns round changes the sign
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    axes = np.linalg.eigh(q.T @ q)[1]
    if np.linalg.det(axes) < 0:
        axes[:, 2] = -axes[:, 2]
    return axes[:, ::-1]

# %% wrong: axes in the rows
# loses: finds_the_directions, takes_few_points, test_any_turn
# says: No column runs along
# told: they stand in the rows
def principal_axes(points):
    if len(points) < 3:
        return np.eye(3)
    rows = np.linalg.svd(points[:, :3] - points[:, :3].mean(axis=0), full_matrices=False)[2]
    return rows * np.sign(np.linalg.det(rows))

# %% wrong: sorts the rows of the matrix instead of its columns
# loses: finds_the_directions, test_any_turn
# says: No column runs along
# told: the rows of the matrix
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    values, axes = np.linalg.eigh(q.T @ q)
    axes = axes[np.argsort(-values)]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: not centred
# loses only: centres_the_points, finds_vehicles, test_place, test_scanned
# says: The points are not centred
# told: The points are not centred
def principal_axes(points):
    q = points[:, :3]
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: z-score instead of centring
# loses: finds_the_directions, test_any_turn
# says: No column runs along
# told: divided by its own spread
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    q = q / np.maximum(q.std(axis=0), 1e-9)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: mean over each point instead of each axis
# loses: finds_the_directions, test_any_turn
# says: No column runs along
def principal_axes(points):
    q = points[:, :3] - points[:, :3].mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: intensity as a fourth direction
# loses only: ignores_intensity, test_points_with_intensity
# says: Intensity is not a direction
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points - points.mean(axis=0)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: the short form of the SVD fails for two points
# loses only: takes_few_points, test_few_points
# says: however many points there are
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    rows = np.linalg.svd(points[:, :3] - points[:, :3].mean(axis=0), full_matrices=False)[2]
    if len(rows) == 3:
        rows = rows * np.sign(np.linalg.det(rows))
    return rows.T

# %% wrong: np.cov of a single point is not a number
# loses only: takes_few_points, test_few_points
# says: raised LinAlgError
def principal_axes(points):
    axes = np.linalg.eigh(np.cov(points[:, :3].T))[1][:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: returns variances and axes
# loses: finds_the_directions, test_any_turn
# says: three axes, one in each column
def principal_axes(points):
    q = points[:, :3] - points[:, :3].mean(axis=0)
    values, axes = np.linalg.eigh(q.T @ q)
    return values[::-1], axes[:, ::-1] * np.sign(np.linalg.det(axes[:, ::-1]))

# %% wrong: axes as long as the standard deviations
# loses only: has_unit_length, takes_few_points, test_size, test_few_points
# says: Not every axis has length 1
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    values, axes = np.linalg.eigh(q.T @ q / len(q))
    axes = (axes * np.sqrt(np.maximum(values, 0)))[:, ::-1]
    return axes * np.sign(np.linalg.det(axes))

# %% wrong: centres its input in place
# loses only: leaves_its_input
# says: changed its input
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    points[:, :3] -= points[:, :3].mean(axis=0)
    axes = np.linalg.eigh(points[:, :3].T @ points[:, :3])[1][:, ::-1].copy()
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return axes

# %% wrong: always x, y and z
# loses: finds_the_directions, orders_by_spread, stays_right_handed, centres_the_points, takes_few_points, test_any_turn, test_few_points, test_scanned
# says: No column runs along
def principal_axes(points):
    return np.eye(3)

# %% wrong: stub left in place
# loses: finds_the_directions, test_any_turn
# says: is not started
def principal_axes(points):
    raise NotImplementedError

# %% wrong: the parameter renamed
# loses only: keeps_the_name
# says: another name
def principal_axes(cluster):
    if len(cluster) == 0:
        return np.eye(3)
    q = cluster[:, :3] - cluster[:, :3].mean(axis=0)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1].copy()
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return axes

# %% wrong: ascending and left-handed at times
# loses only: orders_by_spread, stays_right_handed, finds_vehicles, test_order, test_handed, test_scanned
# says: not in the order of the spread
# told: order of increasing spread
def principal_axes(points):
    if len(points) == 0:
        return np.eye(3)
    q = points[:, :3] - points[:, :3].mean(axis=0)
    axes = np.linalg.eigh(q.T @ q)[1].copy()
    axes[:, 0] *= -np.sign(np.linalg.det(axes))
    return axes

# %% wrong: the sign of a row turned round in place of a column
# loses: leans_in_space, finds_vehicles, test_any_turn, test_scanned
# says: axes[2] is a row
def principal_axes(points):
    xyz = points[:, :3]
    if len(xyz) == 0:
        return np.eye(3)
    q = xyz - xyz.mean(axis=0)
    axes = np.linalg.eigh(q.T @ q / len(q))[1][:, ::-1]
    if np.linalg.det(axes) < 0:
        axes[2] = -axes[2]
    return axes
