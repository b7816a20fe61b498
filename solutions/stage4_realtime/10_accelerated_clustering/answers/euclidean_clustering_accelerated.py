# Answers to euclidean_clustering_accelerated; see grader/course/kept_answers.py.

# %% right: rows of cells, a KD-tree of cells and a loop over what is open
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% right: the hints followed to the letter, in three steps
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    numbers, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, which
# ---- another cell ----
def join_cheaply(points, cells, first, threshold):
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    a, b = points[first[pairs[:, 0]]], points[first[pairs[:, 1]]]
    small = np.linalg.norm(a - b, axis=1) < threshold
    label = components(len(cells), pairs[small])
    return pairs, label
# ---- another cell ----
def join_exactly(points, cell_of_point, pairs, label, threshold):
    differs = label[pairs[:, 0]] != label[pairs[:, 1]]
    open_pairs = pairs[differs]
    p, q, pair_of_q = on_floors(points, cell_of_point, open_pairs, threshold)
    distances, nearest = cKDTree(p).query(q)
    near = distances < threshold
    pieces = label[open_pairs[pair_of_q[near]]]
    return components(label.max() + 1, pieces)[label]
# ---- another cell ----
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    pieces = label[cell_of_point]
    names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% right: three steps, with rows for cells and a loop over open pairs
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    found, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return found, first, which.ravel()
# ---- another cell ----
def join_cheaply(points, cells, first, threshold):
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    a, b = points[first[pairs[:, 0]]], points[first[pairs[:, 1]]]
    small = np.linalg.norm(a - b, axis=1) < threshold
    label = components(len(cells), pairs[small])
    return pairs, label
# ---- another cell ----
def points_of_each_cell(points, cell_of_point):
    sizes = np.bincount(cell_of_point)
    return np.split(points[np.argsort(cell_of_point)], np.cumsum(sizes)[:-1])


def join_exactly(points, cell_of_point, pairs, label, threshold):
    members = points_of_each_cell(points, cell_of_point)
    label = label.copy()
    differs = label[pairs[:, 0]] != label[pairs[:, 1]]
    for a, b in pairs[differs]:
        if label[a] == label[b]:
            continue
        distances, nearest = cKDTree(members[a]).query(members[b])
        if distances.min() < threshold:
            label[label == label[b]] = label[a]
    return label
# ---- another cell ----
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    pieces = label[cell_of_point]
    names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% right: dictionary of cells and union-find in plain Python, a list back
from itertools import product

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = [tuple(map(float, row[:3])) for row in cloud]
    side = threshold / 3 ** 0.5
    cells = {}
    for i, (x, y, z) in enumerate(points):
        cells.setdefault((int(x // side), int(y // side), int(z // side)), []).append(i)
    parent = {cell: cell for cell in cells}

    def find(cell):
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    around = [step for step in product(range(-2, 3), repeat=3) if step > (0, 0, 0)]
    limit = threshold * threshold
    array = np.array(points).reshape(-1, 3)
    for (x, y, z), mine in cells.items():
        for a, b, c in around:
            other = (x + a, y + b, z + c)
            if other not in cells or find(other) == find((x, y, z)):
                continue
            theirs = cells[other]
            p, q = points[mine[0]], points[theirs[0]]
            near = (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2 < limit
            if not near:
                near = cKDTree(array[mine]).query(array[theirs])[0].min() < threshold
            if near:
                parent[find(other)] = find((x, y, z))
    labels, numbers = [0] * len(points), {}
    for cell, mine in cells.items():
        number = numbers.setdefault(find(cell), len(numbers) + 1)
        for i in mine:
            labels[i] = number
    return labels

# %% right: packed keys, sorted, and a queue over cells
from collections import deque

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    n = len(cloud)
    if n == 0:
        return np.array([], dtype=np.int32)
    xyz = np.asarray(cloud[:, :3], dtype=float)
    grid = np.floor((xyz - xyz.min(axis=0)) / (threshold / np.sqrt(3.0001))).astype(np.int64) + 2
    width = grid.max(axis=0) + 3
    keys = (grid[:, 0] * width[1] + grid[:, 1]) * width[2] + grid[:, 2]
    order = np.argsort(keys, kind="stable")
    names, starts = np.unique(keys[order], return_index=True)
    members = np.split(order, starts[1:])
    row_of = {key: row for row, key in enumerate(names.tolist())}
    steps = [(a * width[1] + b) * width[2] + c for a in range(-2, 3) for b in range(-2, 3)
             for c in range(-2, 3) if (a, b, c) != (0, 0, 0)]
    steps = [int(step) for step in steps]
    piece = np.zeros(len(names), dtype=int)
    trees = {}
    for start in range(len(names)):
        if piece[start]:
            continue
        piece[start] = piece.max() + 1
        waiting = deque([start])
        while waiting:
            here = waiting.popleft()
            key = int(names[here])
            for there in (row_of.get(key + step) for step in steps):
                if there is None or piece[there]:
                    continue
                p, q = xyz[members[here]], xyz[members[there]]
                if np.linalg.norm(p[0] - q[0]) >= threshold:
                    if here not in trees:
                        trees[here] = cKDTree(p)
                    if trees[here].query(q)[0].min() >= threshold:
                        continue
                piece[there] = piece[start]
                waiting.append(there)
    labels = np.empty(n, dtype=np.int32)
    for row, rows in enumerate(members):
        labels[rows] = piece[row]
    return labels

# %% right: neighbours of representatives, labels as floats, printing
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    print("clustering", len(cloud), "points")
    if len(cloud) < 1:
        return np.zeros(0)
    points = np.array(cloud, dtype=np.float64)[:, :3]
    _, first, which = np.unique(np.floor(points / (0.57 * threshold)), axis=0, return_index=True,
                                return_inverse=True)
    which = which.reshape(-1)
    tree = cKDTree(points[first])
    label = components(len(first), tree.query_pairs(threshold * 0.9999999, output_type="ndarray"))
    # Every point is closer than the threshold to its representative: three of them bridge all.
    far = tree.query_pairs(3 * threshold, output_type="ndarray")
    order = np.argsort(which, kind="stable")
    ends = np.cumsum(np.bincount(which))
    for a, b in far[label[far[:, 0]] != label[far[:, 1]]].tolist():
        if label[a] == label[b]:
            continue
        p = points[order[ends[a - 1] if a else 0:ends[a]]]
        q = points[order[ends[b - 1] if b else 0:ends[b]]]
        if (np.maximum(p.min(axis=0) - q.max(axis=0), q.min(axis=0) - p.max(axis=0)) > threshold) \
                .any():
            continue
        if len(p) * len(q) > 4000:
            close = cKDTree(p).query(q)[0].min() < threshold
        else:
            close = (np.linalg.norm(p[:, None] - q[None], axis=2) < threshold).any()
        if close:
            label = np.where(label == label[b], label[a], label)
    return label[which] + 1.0

# %% right: a class with a helper in another cell
class Cells:
    def __init__(self, points, side):
        self.points = points
        cells, self.first, self.of_point = np.unique(
            np.floor(points / side).astype(int), axis=0, return_index=True, return_inverse=True)
        self.of_point = self.of_point.ravel()
        self.pairs = cKDTree(cells).query_pairs(2.5, p=np.inf, output_type="ndarray")
        self.sizes = np.bincount(self.of_point)
        self.rows = np.argsort(self.of_point, kind="stable")
        self.start = np.cumsum(self.sizes) - self.sizes

    def inside(self, cell):
        begin = self.start[cell]
        return self.points[self.rows[begin:begin + self.sizes[cell]]]
# ---- another cell ----
%%time
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if not len(cloud):
        return []
    grid = Cells(np.asarray(cloud)[:, :3].astype(float), threshold * 0.577)
    a, b = grid.pairs.reshape(-1, 2).T
    near = np.sum((grid.points[grid.first[a]] - grid.points[grid.first[b]]) ** 2, axis=1) \
        < threshold ** 2
    extra, count = [], len(grid.sizes)
    label = components(count, grid.pairs[near])
    for i, j in grid.pairs[label[a] != label[b]]:
        tree = cKDTree(grid.inside(i))
        if np.isfinite(tree.query(grid.inside(j), distance_upper_bound=threshold)[0]).any():
            extra.append((i, j))
    joined_pairs = np.vstack([grid.pairs[near]] + [np.array(extra).reshape(-1, 2)])
    return (components(count, joined_pairs)[grid.of_point] + 1).tolist()

# %% wrong: labels of eight bits
# loses: test_many_clusters
# says: different clusters have the same label
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    return (np.unique(label[cell_of_point], return_inverse=True)[1].ravel() + 1).astype(np.uint8)

# %% wrong: the queue of lesson 05
# loses: is_quick, test_whole_scan, test_dense_walls
# says: Comparing each point with all others
from collections import deque

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start]:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            gaps = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            fresh = np.flatnonzero((gaps < threshold) & (labels == 0))
            labels[fresh] = cluster
            waiting.extend(fresh)
    return labels

# %% wrong: a list of all pairs
# loses only: takes_a_heap, takes_two_heaps, test_dense_walls, test_heaps, test_touching_heaps
# says: no pair of points inside has to be listed
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    pairs = cKDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray")
    return components(len(cloud), pairs) + 1

# %% wrong: a queue that asks a KD-tree for every point
# loses: takes_a_heap, takes_two_heaps, test_dense_walls, test_heaps, test_touching_heaps
# says: no pair of points inside has to be listed
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    if len(cloud) == 0:
        return labels
    points = cloud[:, :3]
    tree, cluster = cKDTree(points), 0
    for start in range(len(points)):
        if labels[start]:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = [start]
        while waiting:
            near = np.array(tree.query_ball_point(points[waiting.pop()], threshold))
            fresh = near[labels[near] == 0]
            labels[fresh] = cluster
            waiting.extend(fresh.tolist())
    return labels

# %% wrong: representatives only
# loses: compares_the_points, test_crowded_cells, test_touching_heaps
# says: compare all their points
# told: stay apart, also where other points
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    _, first, which = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                return_index=True, return_inverse=True)
    label = components(len(first), cKDTree(points[first]).query_pairs(threshold,
                                                                      output_type="ndarray"))
    return label[which.ravel()] + 1

# %% wrong: neighbouring cells joined without measuring
# loses: parts_what_is_apart, test_fresh_streets, test_crowded_cells
# says: Neighbours may be close
# told: without measuring
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, which = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                             return_inverse=True)
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    return components(len(cells), pairs)[which.ravel()] + 1

# %% wrong: side of a cell = threshold
# loses: parts_what_is_apart, test_fresh_streets
# says: The side is threshold / sqrt(3)
# told: Cells have the side threshold:
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, which = np.unique(np.floor(points / threshold), axis=0, return_index=True,
                                    return_inverse=True)
    which = which.ravel()
    pairs = cKDTree(cells).query_pairs(1, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(which), np.cumsum(np.bincount(which))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if cKDTree(points[members[a]]).query(points[members[b]])[0].min() < threshold:
            label[label == label[b]] = label[a]
    return label[which] + 1

# %% wrong: only the 26 cells around a cell
# loses: joins_across_borders, test_fresh_streets
# says: corners included
# told: Only the next cell
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, which = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                    return_index=True, return_inverse=True)
    which = which.ravel()
    pairs = cKDTree(cells).query_pairs(1, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(which), np.cumsum(np.bincount(which))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if cKDTree(points[members[a]]).query(points[members[b]])[0].min() < threshold:
            label[label == label[b]] = label[a]
    return label[which] + 1

# %% wrong: rounds towards zero
# loses: parts_around_the_sensor
# says: rounds down on both sides
# told: rounded towards 0
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, which = np.unique((points / (threshold / np.sqrt(3))).astype(int), axis=0,
                                    return_index=True, return_inverse=True)
    which = which.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(which), np.cumsum(np.bincount(which))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if cKDTree(points[members[a]]).query(points[members[b]])[0].min() < threshold:
            label[label == label[b]] = label[a]
    return label[which] + 1

# %% wrong: rounds the height alone towards zero
# loses: parts_around_the_sensor
# says: rounds towards 0
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    side = threshold / np.sqrt(3)
    x, y, z = points.T
    cells, first, which = np.unique(np.column_stack([x // side, y // side, np.trunc(z / side)]),
                                    axis=0, return_index=True, return_inverse=True)
    which = which.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(which), np.cumsum(np.bincount(which))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if cKDTree(points[members[a]]).query(points[members[b]])[0].min() < threshold:
            label[label == label[b]] = label[a]
    return label[which] + 1

# %% wrong: intensity is a coordinate
# loses: ignores_intensity
# says: cloud[:, :3] are the coordinates
# told: a fourth coordinate
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    return components(len(cloud), cKDTree(cloud).query_pairs(threshold, output_type="ndarray")) + 1

# %% wrong: thins the cloud to centroids first
# loses: compares_the_points, test_crowded_cells, test_whole_scan
# says: belong
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    _, which, count = np.unique(np.floor(points / 0.2), axis=0, return_inverse=True,
                                return_counts=True)
    which = which.ravel()
    sums = np.zeros((len(count), 3))
    np.add.at(sums, which, points)
    middles = sums / count[:, None]
    pairs = cKDTree(middles).query_pairs(threshold, output_type="ndarray")
    return components(len(middles), pairs)[which] + 1

# %% wrong: the threshold is written into the function
# loses: follows_the_threshold, test_other_thresholds
# says: Compare with the parameter threshold
# told: A fixed threshold
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    pairs = cKDTree(cloud[:, :3]).query_pairs(0.5, output_type="ndarray")
    return components(len(cloud), pairs) + 1

# %% wrong: the exact step keeps the default
# loses: follows_the_threshold, test_other_thresholds
# says: Points that belong together have different labels
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < 0.5:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: labels from 0
# loses: counts_from_one
# says: not 1 to N
# told: start from 0
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    pairs = cKDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray")
    return components(len(cloud), pairs)

# %% wrong: fails on an empty cloud
# loses: takes_the_smallest
# says: can be empty
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3] - cloud[:, :3].min(axis=0)
    pairs = cKDTree(points).query_pairs(threshold, output_type="ndarray")
    return components(len(cloud), pairs) + 1

# %% wrong: a library does the whole exercise
# loses: separates_groups, test_course_cloud, test_whole_scan
# says: not allowed in this lesson
from sklearn.cluster import DBSCAN

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    return DBSCAN(eps=threshold, min_samples=1).fit(cloud[:, :3]).labels_ + 1

# %% wrong: a parallel library does the whole exercise
# loses: separates_groups, test_course_cloud, test_whole_scan
# says: not allowed in this lesson
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    import open3d
    shell = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud[:, :3]))
    return np.array(shell.cluster_dbscan(threshold, 1)) + 1

# %% wrong: everything is one cluster
# loses: separates_groups, parts_what_is_apart, test_course_cloud, test_heaps
# says: Points of different clusters
# told: All points have the same label
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    return np.ones(len(cloud), dtype=int)

# %% wrong: stub left in place
# loses: separates_groups, takes_the_smallest, test_whole_scan
# says: is not started
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    raise NotImplementedError

# %% wrong: one given line
# loses only: takes_a_heap, takes_two_heaps, test_dense_walls, test_heaps, test_touching_heaps
# says: no pair of points inside has to be listed
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    return join_all_pairs(cloud[:, :3], threshold) + 1

# %% wrong: the exact step as a table of distances
# loses only: takes_two_heaps, test_touching_heaps
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = np.linalg.norm(
                points[members[a]][:, None] - points[members[b]][None], axis=2).min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: side of a square's diagonal
# loses only: parts_what_is_apart, test_hardly_apart
# says: In space the diagonal
# told: threshold / sqrt(2)
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(2))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: every cell a cluster
# loses: follows_chains, test_course_cloud
# says: Join neighbouring cells
# told: Each cell is a cluster
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    cells = np.floor(cloud[:, :3] / (threshold / np.sqrt(3)))
    if len(cells) == 0:
        return np.zeros(0, dtype=int)
    return np.unique(cells, axis=0, return_inverse=True)[1].ravel() + 1

# %% wrong: the exact step without what it found
# loses: compares_the_points, test_crowded_cells, test_touching_heaps
# says: compare all their points
# told: stay apart, also where other points
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[b] == label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: only the one cell is renamed
# loses: test_crowded_cells
# says: have different labels
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[b] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: open pairs compared without their floors
# loses: clusters_the_seven
# says: have the same label
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    numbers, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, which
# ---- another cell ----
def join_cheaply(points, cells, first, threshold):
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    a, b = points[first[pairs[:, 0]]], points[first[pairs[:, 1]]]
    small = np.linalg.norm(a - b, axis=1) < threshold
    label = components(len(cells), pairs[small])
    return pairs, label
# ---- another cell ----
def join_exactly(points, cell_of_point, pairs, label, threshold):
    differs = label[pairs[:, 0]] != label[pairs[:, 1]]
    open_pairs = pairs[differs]
    p, q, pair_of_q = on_floors(points, cell_of_point, open_pairs, threshold)
    distances, nearest = cKDTree(p[:, :3]).query(q[:, :3])
    near = distances < threshold
    pieces = label[open_pairs[pair_of_q[near]]]
    return components(label.max() + 1, pieces)[label]
# ---- another cell ----
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    pieces = label[cell_of_point]
    names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: squared distance against plain threshold
# loses: follows_the_threshold
# says: Take the root first
# told: The squared distance
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    threshold = threshold ** 0.5
    points = cloud[:, :3]
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: forgets the height
# loses: measures_in_space, test_fresh_streets
# says: z among them
# told: The height is left out
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3] * [1, 1, 0]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def euclidean_clustering_accelerated(points, radius=0.5):
    points, threshold = points[:, :3], radius
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: default changed
# loses only: keeps_the_default
# says: Keep the first line
def euclidean_clustering_accelerated(cloud, threshold=1.0):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: sorts the cloud
# loses only: leaves_its_input
# says: changed its input
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3].copy()
    cloud.sort(axis=0)
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = np.unique(np.floor(points / (threshold / np.sqrt(3))), axis=0,
                                            return_index=True, return_inverse=True)
    cell_of_point = cell_of_point.ravel()
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    label = components(len(cells), pairs[gap < threshold])
    members = np.split(np.argsort(cell_of_point), np.cumsum(np.bincount(cell_of_point))[:-1])
    for a, b in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[a] != label[b]:
            closest = cKDTree(points[members[a]]).query(points[members[b]])[0].min()
            if closest < threshold:
                label[label == label[b]] = label[a]
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: a step is still a stub
# loses: separates_groups, takes_a_heap, test_whole_scan
# says: points_in_cells
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(cloud[:, :3], threshold)
    pairs, label = join_cheaply(cloud[:, :3], cells, first, threshold)
    return label[cell_of_point] + 1

# %% wrong: rows of cells taken for rows of points
# loses: clusters_the_seven, parts_behind_a_heap, clusters_the_street, test_fresh_streets, test_whole_scan
# says: rows of points
# told: taken for rows of points
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    numbers, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, which
# ---- another cell ----
def join_cheaply(points, cells, first, threshold):
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    small = np.linalg.norm(a - b, axis=1) < threshold
    label = components(len(cells), pairs[small])
    return pairs, label
# ---- another cell ----
def join_exactly(points, cell_of_point, pairs, label, threshold):
    differs = label[pairs[:, 0]] != label[pairs[:, 1]]
    open_pairs = pairs[differs]
    p, q, pair_of_q = on_floors(points, cell_of_point, open_pairs, threshold)
    distances, nearest = cKDTree(p).query(q)
    near = distances < threshold
    pieces = label[open_pairs[pair_of_q[near]]]
    return components(label.max() + 1, pieces)[label]
# ---- another cell ----
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    pieces = label[cell_of_point]
    names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1

# %% wrong: cells are compared in place of points
# loses: follows_the_threshold, test_other_thresholds
# says: and not cells
# told: from cell to cell, in cells
def points_in_cells(points, threshold):
    rows = np.floor(points / (threshold / np.sqrt(3)))
    numbers, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
    return rows[first], first, which
# ---- another cell ----
def join_cheaply(points, cells, first, threshold):
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    a, b = cells[pairs[:, 0]], cells[pairs[:, 1]]
    small = np.linalg.norm(a - b, axis=1) < threshold
    label = components(len(cells), pairs[small])
    return pairs, label
# ---- another cell ----
def join_exactly(points, cell_of_point, pairs, label, threshold):
    differs = label[pairs[:, 0]] != label[pairs[:, 1]]
    open_pairs = pairs[differs]
    p, q, pair_of_q = on_floors(points, cell_of_point, open_pairs, threshold)
    distances, nearest = cKDTree(p).query(q)
    near = distances < threshold
    pieces = label[open_pairs[pair_of_q[near]]]
    return components(label.max() + 1, pieces)[label]
# ---- another cell ----
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    points = cloud[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    pieces = label[cell_of_point]
    names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1
