# Answers to ransac_line; see grader/course/kept_answers.py. Each brings its own helpers, under other names,
# so that it can stand beside any answer to the exercises before it.

# %% right: the functions of the exercises before, in another cell
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    return -dy / length, dx / length, (dy * p[0] - dx * p[1]) / length

def point_line_distance(points, line):
    return np.abs(points[:, 0] * line[0] + points[:, 1] * line[1] + line[2])

# ---- another cell ----
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask, most = None, np.zeros(len(points), bool), 0
    if len(points) >= 2:
        for round_ in range(max_iterations):
            i, j = rng.choice(len(points), 2, replace=False)
            candidate = line_through(points[i], points[j])
            if candidate is not None:
                mask = point_line_distance(points, candidate) <= distance_tolerance
                if mask.sum() > most:
                    best, best_mask, most = candidate, mask, mask.sum()
    return best, best_mask

# %% right: the hints followed to the letter
def line_through(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])

def point_line_distance(points, line):
    a, b, c = line
    value = a * points[:, 0] + b * points[:, 1] + c
    return np.abs(value)

# ---- another cell ----
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)  # takes a seed as well as a generator
    best_line = None
    best_mask = np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best_line, best_mask
    for _ in range(max_iterations):
        i, j = rng.choice(len(points), size=2, replace=False)
        candidate = line_through(points[i], points[j])
        if candidate is None:
            continue
        mask = point_line_distance(points, candidate) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best_line = candidate
            best_mask = mask
    return best_line, best_mask

# %% right: all samples at once
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    n = len(points)
    if n < 2:
        return None, np.zeros(n, dtype=bool)
    first = rng.integers(0, n, max_iterations)
    second = (first + rng.integers(1, n, max_iterations)) % n
    direction = points[second] - points[first]
    length = np.hypot(direction[:, 0], direction[:, 1])
    first, direction, length = (values[length > 0] for values in (first, direction, length))
    if not len(first):
        return None, np.zeros(n, dtype=bool)
    normals = np.stack([-direction[:, 1], direction[:, 0]], axis=1) / length[:, None]
    offsets = -(normals * points[first]).sum(axis=1)
    masks = np.abs(normals @ points.T + offsets[:, None]) <= distance_tolerance
    best = masks.sum(axis=1).argmax()
    return np.array([*normals[best], offsets[best]]), masks[best]

# %% right: plain Python, the module random seeded from rng, lists back
import math
import random

def ransac_line(points, max_iterations, distance_tolerance, rng):
    dice = random.Random(int(np.random.default_rng(rng).integers(2**31)))
    rows = [(float(x), float(y)) for x, y in points]
    best, best_mask = None, [False] * len(rows)
    for _ in range(max_iterations if len(rows) > 1 else 0):
        (px, py), (qx, qy) = dice.sample(rows, 2)
        base = math.hypot(qx - px, qy - py)
        if base == 0:
            continue
        a, b = (py - qy) / base, (qx - px) / base
        c = -a * px - b * py
        mask = [abs(a * x + b * y + c) <= distance_tolerance for x, y in rows]
        if sum(mask) > sum(best_mask):
            best, best_mask = [a, b, c], mask
    return [best, best_mask]

# %% right: MSAC, scored by the truncated squares
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask, least = None, np.zeros(len(points), dtype=bool), np.inf
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.permutation(len(points))[:2]]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        distance = np.abs((points - p) @ normal)
        cost = np.minimum(distance ** 2, distance_tolerance ** 2).sum()
        if cost < least:
            best, least = (normal[0], normal[1], -normal @ p), cost
            best_mask = distance <= distance_tolerance
    return best, best_mask

# %% right: LO-RANSAC, each new best line fitted anew to its inliers
def _distances(points, line):
    return np.abs(points @ np.array(line[:2]) + line[2])

def _fitted(points):
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre)[2][-1]
    return (*normal, -normal @ centre)

def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    points = np.asarray(points, dtype=float)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), 2, replace=False)]
        length = np.hypot(*(q - p))
        if length == 0:
            continue
        a, b = (p[1] - q[1]) / length, (q[0] - p[0]) / length
        candidate = (a, b, -a * p[0] - b * p[1])
        mask = _distances(points, candidate) <= distance_tolerance
        if mask.sum() <= best_mask.sum():
            continue
        best, best_mask = candidate, mask
        refined = _fitted(points[mask])
        refined_mask = _distances(points, refined) <= distance_tolerance
        if refined_mask.sum() >= mask.sum():
            best, best_mask = refined, refined_mask
    return best, best_mask

# %% right: stops early when 99.9 % sure, single precision
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    n = len(points)
    best, best_mask = None, np.zeros(n, dtype=bool)
    if n < 2:
        return best, best_mask
    points = np.asarray(points, dtype=np.float32)
    needed, done = max_iterations, 0
    while done < min(needed, max_iterations):
        done += 1
        i, j = rng.choice(n, size=2, replace=False)
        d = points[j] - points[i]
        length = np.sqrt(d @ d)
        if length == 0:
            continue
        normal = np.array([-d[1], d[0]]) / length
        offset = -(normal @ points[i])
        mask = np.abs(points @ normal + offset) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = np.append(normal, offset), mask
            bad = 1 - mask.mean() ** 2
            needed = np.log(0.001) / np.log(bad) if bad > 0 else 0
    return best, best_mask

# %% right: a class, numbers 0 and 1 for the mask, chatty
class Search:
    def __init__(self, points, tolerance):
        self.points, self.tolerance = points, tolerance
        self.line, self.inliers = None, np.zeros(len(points), dtype=int)

    def offer(self, i, j):
        p, q = self.points[i], self.points[j]
        length = np.linalg.norm(q - p)
        if length > 0:
            a, b = (q[1] - p[1]) / length, (p[0] - q[0]) / length
            c = -(a * p[0] + b * p[1])
            near = abs(a * self.points[:, 0] + b * self.points[:, 1] + c) <= self.tolerance
            if near.sum() > self.inliers.sum():
                self.line, self.inliers = (a, b, c), near.astype(int)

def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    search = Search(points, distance_tolerance)
    for _ in range(max_iterations):
        if len(points) > 1:
            search.offer(*rng.choice(len(points), size=2, replace=False))
    print(search.line)
    return search.line, search.inliers

# %% wrong: draws with replacement
# loses only: draws_different_points, test_two_points
# says: In some runs there was none
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.integers(len(points), size=2)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the last line, not the best
# loses: finds_the_line, test_fresh_lines, test_many_outliers
# says: holds fewer inliers after
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    line, mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return line, mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        line, mask = (*normal, -normal @ p), np.abs((points - p) @ normal) <= distance_tolerance
    return line, mask

# %% wrong: return inside the loop
# loses: finds_the_line, draws_as_often_as_told, test_fresh_lines, test_iterations_count
# says: With 1 round instead of 60 the answers are the same
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
        return best, best_mask
    return best, best_mask

# %% wrong: the mask is not replaced, only the line
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: Each run returned a line, and not one inlier
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best = (*normal, -normal @ p)
    return best, best_mask

# %% wrong: a new generator in each round
# loses: finds_the_line, draws_as_often_as_told, test_fresh_lines
# says: With 1 round instead of 60 the answers are the same
def ransac_line(points, max_iterations, distance_tolerance, rng):
    first = np.random.default_rng(rng).integers(1000)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        rng = np.random.default_rng(first)
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the line with the fewest inliers
# loses: finds_the_line, test_fresh_lines, test_course_cloud_wall
# says: The line was found in
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    fewest = len(points) + 1
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() < fewest:
            best, best_mask, fewest = (*normal, -normal @ p), mask, mask.sum()
    return best, best_mask

# %% wrong: the mask of the last round with the line of the best
# loses: marks_its_own_inliers, test_own_inliers
# says: The mask does not belong to the line.
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, mask, most = None, np.zeros(len(points), dtype=bool), 0
    if len(points) < 2:
        return best, mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > most:
            best, most = (*normal, -normal @ p), mask.sum()
    return best, mask

# %% wrong: no absolute value
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: The line was found in
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = (points - p) @ normal <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the tolerance is squared
# loses only: marks_its_own_inliers, test_own_inliers, test_moved_and_scaled, test_course_cloud_wall
# says: and not squared
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance ** 2
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the normal is not normalised
# loses: marks_its_own_inliers, test_own_inliers
# says: of the line but not marked
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: refitted at the end, the old mask returned
# loses only: marks_its_own_inliers, test_own_inliers, finds_upright_walls, test_upright
# says: The mask does not belong to the line.
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    if best is not None:
        slope, height = np.polyfit(points[best_mask, 0], points[best_mask, 1], 1)
        length = np.hypot(slope, 1)
        best = (slope / length, -1 / length, height / length)
    return best, best_mask

# %% wrong: ten rounds, whatever is asked
# loses only: draws_as_often_as_told, test_many_outliers
# says: found in
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(10):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: a thousand rounds, whatever is asked
# loses only: draws_no_more_than_told, test_iterations_count
# says: can hardly do that
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(1000):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: a seed of its own
# loses only: follows_its_rng
# says: gave 20 times the same line
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(42)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: global dice instead of rng
# loses only: repeats_with_its_seed, takes_a_seed
# says: The same seed gave two different answers
def ransac_line(points, max_iterations, distance_tolerance, rng):
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[np.random.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: without the line that makes a generator of a seed
# loses only: takes_a_seed
# says: rng may be a whole number: begin with rng = np.random.default_rng(rng)
def ransac_line(points, max_iterations, distance_tolerance, rng):
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: a generator of the seed in each round
# loses only: takes_a_seed
# says: made anew from the same seed in each round
def ransac_line(points, max_iterations, distance_tolerance, rng):
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        drawn = np.random.default_rng(rng)
        p, q = points[drawn.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: indices instead of a mask
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: These are row numbers
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_inliers = None, np.zeros(0, dtype=int)
    if len(points) < 2:
        return best, best_inliers
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        inliers = np.flatnonzero(np.abs((points - p) @ normal) <= distance_tolerance)
        if len(inliers) > len(best_inliers):
            best, best_inliers = (*normal, -normal @ p), inliers
    return best, best_inliers

# %% wrong: mask first, then the line
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: in the wrong order
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best_mask, best
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = np.array([*normal, -normal @ p]), mask
    return best_mask, best

# %% wrong: returns the line only
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: must return two things
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, most = None, 0
    if len(points) < 2:
        return best
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        count = (np.abs((points - p) @ normal) <= distance_tolerance).sum()
        if count > most:
            best, most = np.array([*normal, -normal @ p]), count
    return best

# %% wrong: slope and intercept inside
# loses only: finds_upright_walls, test_upright
# says: No slope
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        (px, py), (qx, qy) = points[rng.choice(len(points), size=2, replace=False)]
        if px == qx:
            continue
        slope = (qy - py) / (qx - px)
        length = np.hypot(slope, 1)
        line = slope / length, -1 / length, (py - slope * px) / length
        mask = np.abs(points @ line[:2] + line[2]) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = line, mask
    return best, best_mask

# %% wrong: does not ask for None
# loses only: survives_equal_points, answers_for_equal_points, test_many_equal_points
# says: cannot be taken apart
def _line(p, q):
    length = np.hypot(*(q - p))
    if length == 0:
        return None
    return (p[1] - q[1]) / length, (q[0] - p[0]) / length, (p[0] * q[1] - p[1] * q[0]) / length

def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        i, j = rng.choice(len(points), size=2, replace=False)
        a, b, c = _line(points[i], points[j])
        mask = np.abs(a * points[:, 0] + b * points[:, 1] + c) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (a, b, c), mask
    return best, best_mask

# %% wrong: fails for fewer than two points
# loses only: answers_for_too_few, test_too_few
# says: raised ValueError
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: shuffles the points
# loses: leaves_its_input
# says: changed its input
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        rng.shuffle(points)
        p, q = points[:2]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if normal.any():
            normal = normal / np.linalg.norm(normal)
            line = (*normal, -normal @ p)
            count = (np.abs(points @ line[:2] + line[2]) <= distance_tolerance).sum()
            if best is None or count > most:
                best, most = line, count
    if best is not None:
        best_mask = np.abs(points @ best[:2] + best[2]) <= distance_tolerance
    return best, best_mask

# %% wrong: least squares through all points
# loses: finds_the_line, test_fresh_lines, repeats_with_its_seed
# says: The line was found in
def ransac_line(points, max_iterations, distance_tolerance, rng):
    if len(points) < 2:
        return None, np.zeros(len(points), dtype=bool)
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre)[2][-1]
    return (*normal, -normal @ centre), np.abs((points - centre) @ normal) <= distance_tolerance

# %% wrong: always no line
# loses: finds_the_line, marks_its_own_inliers, answers_for_too_few, test_too_few
# says: In 12 of them the answer was None
def ransac_line(points, max_iterations, distance_tolerance, rng):
    return None, np.zeros(len(points), dtype=bool)

# %% wrong: draws, and does nothing with it
# loses: finds_the_line, test_fresh_lines
# says: In 12 of them the answer was None
def ransac_line(points, max_iterations, distance_tolerance, rng):
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
    return best, best_mask

# %% wrong: gives up after equal points
# loses only: survives_equal_points, test_many_equal_points
# says: `break` gives up
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            break
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the two points in one array
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: This line gives a function more or fewer values than it takes
def _line(p, q):
    length = np.hypot(*(q - p))
    return (p[1] - q[1]) / length, (q[0] - p[0]) / length, (p[0] * q[1] - p[1] * q[0]) / length

def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations):
        chosen = rng.choice(len(points), size=2, replace=False)
        a, b, c = _line(points[chosen])
        mask = np.abs(a * points[:, 0] + b * points[:, 1] + c) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (a, b, c), mask
    return best, best_mask

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def ransac_line(points, rounds, tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(rounds):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the points instead of a mask
# loses: finds_the_line, marks_its_own_inliers, test_fresh_lines
# says: These are points
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, points[best_mask]
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, points[best_mask]

# %% wrong: stub left in place
# loses: finds_the_line, test_fresh_lines, leaves_its_input
# says: is not started
def ransac_line(points, max_iterations, distance_tolerance, rng):
    raise NotImplementedError

# %% wrong: one round is missing
# loses only: draws_as_often_as_told, test_iterations_count
# says: With max_iterations=2 there is one: a round is missing
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(1, max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: two points are too few
# loses only: answers_for_too_few, test_too_few
# says: Two points are enough for a sample
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) <= 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the last point is never drawn
# loses only: draws_from_all_points, answers_for_too_few, test_too_few
# says: the one in row 3 was in no sample
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points) - 1, size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: the first point is never drawn
# loses only: draws_from_all_points, answers_for_too_few, test_too_few
# says: the one in row 0 was in no sample
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(np.arange(1, len(points)), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: a point at the threshold is no inlier
# loses only: includes_the_border, test_border
# says: exactly distance_tolerance from the line is not marked
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) < distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: fifty rounds, whatever is asked
# loses only: draws_no_more_than_told, test_iterations_count
# says: can hardly do that
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(50):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) <= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask

# %% wrong: outliers for inliers
# loses: finds_the_line, test_fresh_lines
# says: farther from the line than the threshold
def ransac_line(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, best_mask = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best, best_mask
    for _ in range(max_iterations):
        p, q = points[rng.choice(len(points), size=2, replace=False)]
        normal = np.array([p[1] - q[1], q[0] - p[0]])
        if not normal.any():
            continue
        normal = normal / np.linalg.norm(normal)
        mask = np.abs((points - p) @ normal) >= distance_tolerance
        if mask.sum() > best_mask.sum():
            best, best_mask = (*normal, -normal @ p), mask
    return best, best_mask
