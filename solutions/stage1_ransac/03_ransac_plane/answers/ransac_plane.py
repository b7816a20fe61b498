# Answers to ransac_plane; see grader/course/kept_answers.py. Each brings its own helpers, because the
# other exercises of the notebook may be unsolved.

# %% right: the hints followed to the letter
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (normal[0], normal[1], normal[2], -(normal @ p))

def point_plane_distance(points, plane):
    a, b, c, d = plane
    return np.abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model = None
    inliers = np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        i = rng.choice(len(points), 3, replace=False)
        plane = plane_through(*points[i, :3])
        if plane is None:
            continue
        near = point_plane_distance(points, plane) <= distance_tolerance
        if near.sum() > inliers.sum():
            model = plane
            inliers = near
    return model, inliers

# %% right: the loop of the lesson
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% right: refitted in the end, mask taken anew
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    xyz = np.asarray(points[:, :3], dtype=float)
    best, most = None, 0
    if len(xyz) >= 3:
        for _ in range(max_iterations):
            plane = plane_through(*xyz[rng.permutation(len(xyz))[:3]])
            if plane is not None:
                count = (point_plane_distance(xyz, plane) <= distance_tolerance).sum()
                if count > most:
                    best, most = plane, count
    if best is None:
        return None, np.zeros(len(xyz), dtype=bool)
    near = xyz[point_plane_distance(xyz, best) <= distance_tolerance]
    centre = near.mean(axis=0)
    normal = np.linalg.svd(near - centre, full_matrices=False)[2][2]
    refitted = np.append(normal, -normal @ centre)
    if (point_plane_distance(xyz, refitted) <= distance_tolerance).sum() >= most:
        best = refitted
    return tuple(best), point_plane_distance(xyz, best) <= distance_tolerance

# %% right: all samples at once, a list for a mask
import warnings

def ransac_plane(points, max_iterations, distance_tolerance, rng):
    warnings.warn("many planes at once")
    rng = np.random.default_rng(rng)
    n = len(points)
    if n < 3:
        return None, [False] * n
    xyz = points[:, :3]
    triples = np.argsort(rng.random((max_iterations, n)), axis=1)[:, :3]
    p, q, r = (xyz[triples[:, k]] for k in range(3))
    normals = np.cross(q - p, r - p)
    lengths = np.linalg.norm(normals, axis=1)
    good = lengths > 1e-9
    if not good.any():
        return None, [False] * n
    normals = normals[good] / lengths[good, None]
    offsets = -(normals * p[good]).sum(axis=1)
    masks = np.abs(normals @ xyz.T + offsets[:, None]) <= distance_tolerance
    k = masks.sum(axis=1).argmax()
    return [*normals[k].tolist(), float(offsets[k])], masks[k].tolist()

# %% right: plain Python, an upward normal, printing
import random

def ransac_plane(points, max_iterations, distance_tolerance, rng):
    seed = int(np.random.default_rng(rng).integers(2**31))
    chance = random.Random(seed)
    rows = [tuple(row[:3]) for row in points.tolist()]
    best, best_mask = None, np.zeros(len(rows), dtype=bool)
    if len(rows) < 3:
        print("too few")
        return best, best_mask
    for number in range(max_iterations):
        (px, py, pz), (qx, qy, qz), (rx, ry, rz) = chance.sample(rows, 3)
        ux, uy, uz, vx, vy, vz = qx - px, qy - py, qz - pz, rx - px, ry - py, rz - pz
        a, b, c = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        size = (a * a + b * b + c * c) ** 0.5
        if size < 1e-9:
            continue
        if c < 0:
            size = -size
        a, b, c = a / size, b / size, c / size
        d = -(a * px + b * py + c * pz)
        mask = [abs(a * x + b * y + c * z + d) <= distance_tolerance for x, y, z in rows]
        if sum(mask) > best_mask.sum():
            best, best_mask = (a, b, c, d), np.array(mask)
    return best, best_mask

# %% right: stops early when it has seen enough
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    n = len(points)
    model, inliers, needed, tried = None, np.zeros(n, dtype=bool), max_iterations, 0
    while n >= 3 and tried < min(needed, max_iterations):
        tried += 1
        sample = points[rng.choice(n, size=3, replace=False)]
        candidate = plane_through(sample[0, :3], sample[1, :3], sample[2, :3])
        if candidate is None:
            continue
        mask = point_plane_distance(points, candidate) <= distance_tolerance
        if mask.sum() > inliers.sum():
            model, inliers = candidate, mask
            ratio = min(mask.mean(), 0.8) ** 3 / 4
            needed = np.log(1e-13) / np.log(1 - ratio)
    return model, inliers

# %% right: a class, single precision
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
class Search:
    def __init__(self, points, tolerance):
        self.points, self.tolerance = np.float32(points[:, :3]), tolerance
        self.model, self.mask = None, np.zeros(len(points), dtype=bool)

    def offer(self, sample):
        plane = plane_through(*self.points[sample].astype(float))
        if plane is not None:
            plane = plane.astype(np.float32)
            mask = point_plane_distance(self.points, plane) <= self.tolerance
            if mask.sum() > self.mask.sum():
                self.model, self.mask = plane, mask
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng, search = np.random.default_rng(rng), Search(points, distance_tolerance)
    for _ in range(max_iterations if len(points) > 2 else 0):
        search.offer(rng.choice(len(points), 3, replace=False))
    return search.model, search.mask

# %% wrong: the last sample wins
# loses: finds_the_plane, test_any_direction, test_many_outliers
# says: A plane with many more points near it exists
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        model, inliers = candidate, near
    return model, inliers

# %% wrong: keeps the worst
# loses: finds_the_plane, test_streets
# says: A plane with many more points near it exists
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if model is None or near.sum() < inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: refits the plane and keeps the old mask
# loses: mask_belongs_to_model, follows_the_tolerance, test_masks, test_tolerances
# says: The mask does not belong to the returned model
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    if model is None:
        return model, inliers
    centre = points[inliers, :3].mean(axis=0)
    normal = np.linalg.svd(points[inliers, :3] - centre, full_matrices=False)[2][2]
    return np.append(normal, -normal @ centre), inliers

# %% wrong: no guard against a line
# loses only: survives_degenerate_samples, finds_nothing_on_a_line, test_forms, test_degenerate
# says: Something in this line is None
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: waits for ever for a good sample
# loses: finds_nothing_on_a_line
# says: is there a loop that never ends?
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = None
        while candidate is None:
            candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: draws with replacement
# loses only: draws_three_rows, test_three_points
# says: In some runs there was none
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.integers(0, len(points), 3), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: always the same samples
# loses only: follows_the_generator
# says: does not depend on rng
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(42)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: NumPy's global random numbers
# loses only: follows_the_generator
# says: The same seed gave two different planes
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[np.random.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: takes generators only
# loses only: takes_a_seed
# says: rng may be a whole number
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: a tolerance of its own
# loses only: follows_the_tolerance, includes_the_edge, test_tolerances, test_edge
# says: away from the returned plane is an inlier
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= 0.2
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: a thousand iterations for everybody
# loses only: tries_no_more
# says: More are tried than allowed
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(1000):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: ten iterations at most
# loses: tries_enough, test_any_direction
# says: A plane with many more points near it exists
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(min(max_iterations, 10)):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: indices instead of a mask
# loses: mask_belongs_to_model, follows_the_tolerance, finds_nothing_on_a_line, test_masks, test_tolerances
# says: must be a mask
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, np.flatnonzero(inliers)

# %% wrong: the model alone
# loses: finds_the_plane, gives_up_politely, test_streets
# says: Return two things
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model

# %% wrong: inliers first
# loses: finds_the_plane, test_streets
# says: the model comes first
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return inliers, model

# %% wrong: outliers for inliers
# loses: mask_belongs_to_model, follows_the_tolerance, finds_nothing_on_a_line, test_masks, test_tolerances
# says: mask does not belong
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, ~inliers

# %% wrong: four columns in the sample
# loses only: searches_without_intensity, test_streets, test_forms
# says: np.cross takes x, y, z
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False)])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: fails for few points
# loses only: gives_up_politely, test_few_points
# says: look at len(points) first
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: roads only
# loses only: finds_a_wall, test_streets, test_any_direction, test_few_points
# says: A plane with many more points
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None or abs(candidate[2]) < 0.9:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: every point is an inlier of a flat road
# loses: finds_the_plane, mask_belongs_to_model, survives_degenerate_samples, searches_without_intensity, test_streets
# says: A plane with many more points near it exists
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    if len(points) < 3:
        return None, np.zeros(len(points), dtype=bool)
    return (0.0, 0.0, 1.0, -points[:, 2].mean()), np.ones(len(points), dtype=bool)

# %% wrong: finds nothing, ever
# loses: finds_the_plane, mask_belongs_to_model, follows_the_tolerance, tries_enough, tries_no_more, survives_degenerate_samples, gives_up_politely, searches_without_intensity, follows_the_generator, test_streets, test_three_points
# says: none was found: the model is None
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    return None, np.zeros(len(points), dtype=bool)

# %% wrong: the mask of the last sample
# loses: mask_belongs_to_model, follows_the_tolerance, test_masks, test_tolerances
# says: The mask does not belong to the returned model
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers, most = None, np.zeros(len(points), dtype=bool), 0
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        inliers = near
        if near.sum() > most:
            model, most = candidate, near.sum()
    return model, inliers

# %% wrong: the model of the last sample
# loses: finds_the_plane, test_streets, test_many_outliers
# says: A plane with many more points near it exists
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            inliers = near
        model = candidate
    return model, inliers

# %% wrong: break for continue
# loses only: survives_degenerate_samples, test_degenerate
# says: go on with the next sample
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            break
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: an unseeded generator
# loses only: follows_the_generator
# says: The same seed gave two different planes
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng()
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: the first sample after all
# loses: finds_the_plane, test_any_direction
# says: A plane with many more points near it exists
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
        return model, inliers

# %% wrong: a seed of its own for whole numbers
# loses only: takes_a_seed
# says: The seed 3, given twice
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    if isinstance(rng, int):
        rng = np.random.default_rng()
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: lowers the cloud in place
# loses only: leaves_the_cloud
# says: changed its input
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    points[:, 2] -= 0.01
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    if model is not None:
        model[3] -= 0.01 * model[2]
    return model, inliers

# %% wrong: parameters renamed
# loses only: keeps_the_names_of_ransac
# says: another name
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: the normal is made long in the end
# loses only: model_has_a_unit_normal, includes_the_edge, test_edge
# says: has length
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return (None if model is None else model / abs(model[3])), inliers

# %% wrong: one round is missing
# loses only: tries_enough, test_rounds
# says: With max_iterations=2 there is one: a round is missing
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations - 1):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: three points are too few
# loses only: gives_up_politely, test_few_points
# says: Three points are enough for a sample
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) <= 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: the last point is never drawn
# loses only: draws_from_all_rows, gives_up_politely, test_few_points
# says: the one in row 4 was in no sample
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points) - 1, 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: a point at the threshold is no inlier
# loses only: includes_the_edge, test_edge
# says: exactly distance_tolerance from the plane is no inlier
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) < distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers

# %% wrong: fifty rounds, whatever is asked
# loses: tries_no_more
# says: More are tried than allowed
def plane_through(p, q, r):
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    return np.append(normal, -normal @ p) / length

def point_plane_distance(points, plane):
    return np.abs(points[:, :3] @ plane[:3] + plane[3])
# ---- another cell ----
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(50):
        candidate = plane_through(*points[rng.choice(len(points), 3, replace=False), :3])
        if candidate is None:
            continue
        near = point_plane_distance(points, candidate) <= distance_tolerance
        if near.sum() > inliers.sum():
            model, inliers = candidate, near
    return model, inliers
