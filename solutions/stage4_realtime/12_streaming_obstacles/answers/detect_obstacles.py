# Answers to detect_obstacles; see grader/course/kept_answers.py.

# %% right: the functions of the lessons, pasted into cells of their own
import numpy as np
from collections import deque
from scipy.spatial import cKDTree

def drop_invalid(cloud):
    xyz = cloud[:, :3]
    return cloud[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)]

def crop_region(cloud, minimum, maximum):
    return cloud[((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

def remove_ego_returns(cloud, minimum, maximum):
    return cloud[~((cloud[:, :3] >= minimum) & (cloud[:, :3] <= maximum)).all(axis=1)]

def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= ground_level]
# ---- another cell ----
def voxel_grid(cloud, voxel_size=0.2):
    cells = np.floor(cloud[:, :3] / voxel_size).astype(int)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, which.ravel(), cloud)
    return sums / count[:, None]

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    neighbours = cKDTree(cloud[:, :3]).query_ball_point(cloud[:, :3], threshold)
    number = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        number += 1
        labels[start] = number
        queue = deque([start])
        while queue:
            for other in neighbours[queue.popleft()]:
                if labels[other] == 0:
                    labels[other] = number
                    queue.append(other)
    return labels

def filter_clusters(labels, min_num_points=100):
    _, which, count = np.unique(labels, return_inverse=True, return_counts=True)
    return np.where(count[which] < min_num_points, 0, labels)

def closeness(seen):
    away = np.minimum(seen - seen.min(axis=0), seen.max(axis=0) - seen).min(axis=1)
    return np.sum(1 / (away + 0.05))

def get_oriented_boxes(cloud, labels):
    boxes = []
    turns = [np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
             for a in np.radians(np.arange(90))]
    for label in np.unique(labels[labels > 0]):
        points = cloud[labels == label, :3]
        axes = max(turns, key=lambda turn: closeness(points[:, :2] @ turn.T))
        seen = points[:, :2] @ axes.T
        (a, c), (b, d) = seen.min(axis=0), seen.max(axis=0)
        floor = np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max())
                      for corner in floor])
    return np.array(boxes).reshape(-1, 8, 3)
# ---- another cell ----
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(25.0, 9.0, 1.0)):
    points = drop_invalid(cloud[:, :3])
    points = crop_region(points, minimum, maximum)
    points = remove_ego_returns(points, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    points = filter_ground(points, ground_level)
    if len(points) == 0:
        return np.empty((0, 8, 3))
    points = voxel_grid(points, 0.2)
    labels = euclidean_clustering_accelerated(points, threshold)
    return get_oriented_boxes(points, filter_clusters(labels, min_num_points))

# %% right: RANSAC for the road, components of a graph, eigenvectors
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

def road(points, rng, iterations=50, tolerance=0.15):
    best = np.zeros(len(points), dtype=bool)
    for _ in range(iterations if len(points) >= 3 else 0):
        a, b, c = points[rng.choice(len(points), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal)
        if length < 1e-9 or abs(normal[2]) < 0.9 * length:
            continue
        inliers = np.abs((points - a) @ (normal / length)) <= tolerance
        if inliers.sum() > best.sum():
            best = inliers
    return best

def detect_obstacles(cloud):
    rng = np.random.default_rng()
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1) & p.any(axis=1)]
    p = p[(p > (-10, -5, -2.5)).all(axis=1) & (p < (30, 6, 1)).all(axis=1)]
    p = p[~((p > (-1.5, -1.7, -1.0)).all(axis=1) & (p < (2.6, 1.7, -0.4)).all(axis=1))]
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    p = p[~road(p, rng)]
    if not len(p):
        return []
    i, j = cKDTree(p).query_pairs(0.55, output_type="ndarray").T
    n, labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)
    boxes = []
    for k in range(n):
        q = p[labels == k]
        if not 14 <= len(q) <= 2000:
            continue
        centre = q[:, :2].mean(0)
        axes = np.linalg.eigh(np.cov(q[:, :2].T))[1]
        flat = (q[:, :2] - centre) @ axes
        low, high = flat.min(0), flat.max(0)
        ring = np.array([low, (high[0], low[1]), high, (low[0], high[1])]) @ axes.T + centre
        boxes.append(np.vstack([np.column_stack([ring, np.full(4, z)])
                                for z in (q[:, 2].min(), q[:, 2].max())]))
    return boxes

# %% right: cells that touch, in plain Python; the smallest rectangle; corners of the roof first
import math
import numpy as np

def flood(cells):
    cells, groups = set(cells), []
    while cells:
        todo, group = [cells.pop()], []
        while todo:
            x, y = todo.pop()
            group.append((x, y))
            for u in (x - 1, x, x + 1):
                for v in (y - 1, y, y + 1):
                    if (u, v) in cells:
                        cells.remove((u, v))
                        todo.append((u, v))
        groups.append(group)
    return groups

def detect_obstacles(cloud, side=0.3):
    boxes, members = [], {}
    for x, y, z in np.asarray(cloud, dtype=float)[:, :3].tolist():
        near = -12 <= x <= 25 and -7 <= y <= 8 and -1.2 <= z <= 1 and (x, y, z) != (0, 0, 0)
        if near and not (-1.5 <= x <= 2.6 and -1.7 <= y <= 1.7):
            members.setdefault((math.floor(x / side), math.floor(y / side)), []).append((x, y, z))
    for group in flood(members):
        points = np.array([point for cell in group for point in members[cell]])
        if len(points) < 20:
            continue
        best = None
        for degrees in range(0, 90, 3):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            u, v = points[:, 0] * c + points[:, 1] * s, points[:, 1] * c - points[:, 0] * s
            area = np.ptp(u) * np.ptp(v)
            if best is None or area < best[0]:
                best = (area, c, s, u.min(), u.max(), v.min(), v.max())
        _, c, s, a, b, d, e = best
        boxes.append([[u * c - v * s, u * s + v * c, z]
                      for z in (points[:, 2].max(), points[:, 2].min())
                      for u, v in ((a, d), (b, d), (b, e), (a, e))])
    return np.array(boxes, dtype=np.float32).reshape(-1, 8, 3)

# %% right: scikit-learn, the whole scan, printing and warning
import warnings
import numpy as np
from sklearn.cluster import DBSCAN
from sklearn.decomposition import PCA

class Detector:
    def __init__(self, reach):
        self.reach = reach

    def select(self, cloud):
        xyz = np.array(cloud)[:, :3].astype(float)
        xyz = xyz[np.all(np.isfinite(xyz), axis=1)]
        distance = np.hypot(xyz[:, 0], xyz[:, 1])
        own = (np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75)
        return xyz[(distance < self.reach) & ~own & (xyz[:, 2] > -1.2)]

    def thin(self, xyz):
        cells = (np.floor(xyz * 5)).astype(int)
        return xyz[np.sort(np.unique(cells, axis=0, return_index=True)[1])]

    def box(self, points):
        pca = PCA(2).fit(points[:, :2])
        seen = pca.transform(points[:, :2])
        low, high = seen.min(0), seen.max(0)
        ring = pca.inverse_transform([low, (high[0], low[1]), high, (low[0], high[1])])
        floor = np.column_stack([ring, np.full(4, points[:, 2].min())])
        roof = np.column_stack([ring, np.full(4, points[:, 2].max())])
        return np.concatenate([floor, roof])
# ---- another cell ----
%matplotlib inline
def detect_obstacles(cloud, *, reach=20.0):
    warnings.warn("detecting")
    detector = Detector(reach)
    xyz = detector.thin(detector.select(cloud))
    print(len(xyz), "points")
    if len(xyz) < 5:
        return np.zeros((0, 8, 3))
    labels = DBSCAN(eps=0.4, min_samples=1).fit(xyz).labels_
    found = [detector.box(xyz[labels == label]) for label in set(labels.tolist())
             if (labels == label).sum() >= 12]
    return np.array(found) if found else np.zeros((0, 8, 3))

# %% right: a height map for the road, no thinning beyond it
import numpy as np
from scipy import ndimage

def detect_obstacles(cloud, cell=0.25):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    with np.errstate(invalid="ignore"):
        keep = (np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] < 1)
        keep &= ~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))
    xyz = xyz[keep & np.isfinite(xyz).all(axis=1)]
    coarse = (np.floor(xyz[:, :2] / 2.0) + 40).astype(int)
    ground = np.full((80, 80), np.inf)
    np.minimum.at(ground, tuple(coarse.T), xyz[:, 2])
    height = xyz[:, 2] - np.minimum(ground[tuple(coarse.T)], -1.4)
    high = xyz[height > 0.45]
    fine = (np.floor(high[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((400, 400), dtype=bool)
    grid[tuple(fine.T)] = True
    components, count = ndimage.label(grid, structure=np.ones((3, 3)))
    labels = components[tuple(fine.T)]
    boxes = []
    for label in range(1, count + 1):
        points = high[labels == label]
        if len(points) < 30:
            continue
        angles = np.linspace(0, np.pi / 2, 46)[:-1]
        turn = np.stack([np.cos(angles), np.sin(angles)])
        u = points[:, :2] @ turn
        v = points[:, :2] @ np.stack([-turn[1], turn[0]])
        k = int(np.argmin((u.max(0) - u.min(0)) * (v.max(0) - v.min(0))))
        forward, left = turn[:, k], np.array([-turn[1, k], turn[0, k]])
        ring = [a * forward + b * left for a, b in (
            (u[:, k].min(), v[:, k].min()), (u[:, k].max(), v[:, k].min()),
            (u[:, k].max(), v[:, k].max()), (u[:, k].min(), v[:, k].max()))]
        low, top = points[:, 2].min(), points[:, 2].max()
        boxes.append([[*corner, z] for z in (low, top) for corner in ring])
    return np.reshape(boxes, (-1, 8, 3))

# %% right: thins first, then one level for the ground; DBSCAN's noise is dropped; the hull's rectangle
import numpy as np
from scipy.spatial import ConvexHull
from sklearn.cluster import DBSCAN

EGO = np.array([[-1.5, -1.7, -1.0], [2.6, 1.7, -0.4]])

def voxel_grid(points, size):
    cells, inverse = np.unique(np.floor(points / size), axis=0, return_inverse=True)
    sums = np.zeros(cells.shape)
    np.add.at(sums, inverse.ravel(), points)
    return sums / np.bincount(inverse.ravel())[:, None]

def hull_rectangle(xy):
    try:
        corners = xy[ConvexHull(xy).vertices]
    except Exception:  # all on a line
        corners = xy
    best = None
    for edge in np.roll(corners, -1, axis=0) - corners:
        if np.linalg.norm(edge) == 0:
            continue
        u = edge / np.linalg.norm(edge)
        v = np.array([-u[1], u[0]])
        a, b = corners @ u, corners @ v
        if best is None or np.ptp(a) * np.ptp(b) < best[0]:
            best = (np.ptp(a) * np.ptp(b), [s * u + t * v for s, t in (
                (a.min(), b.min()), (a.max(), b.min()), (a.max(), b.max()), (a.min(), b.max()))])
    return best[1] if best else [xy[0]] * 4

def detect_obstacles(cloud, threshold=0.6):
    p = np.array(cloud, dtype=float)[:, :3]
    p = p[np.isfinite(p).all(axis=1)]
    p = p[np.linalg.norm(p, axis=1) > 0.1]
    p = voxel_grid(p, 0.2) if len(p) else p
    p = p[~((p >= EGO[0]) & (p <= EGO[1])).all(axis=1)]
    p = p[(np.hypot(p[:, 0], p[:, 1]) <= 15) & (np.abs(p[:, 1]) < 8)]
    p = p[(p[:, 2] >= -1.2) & (p[:, 2] < 1.5)]
    if len(p) == 0:
        return np.zeros((0, 8, 3))
    labels = DBSCAN(eps=threshold, min_samples=5).fit_predict(p)
    boxes = []
    for label in range(labels.max() + 1):
        q = p[labels == label]
        if len(q) < 8:
            continue
        ring = hull_rectangle(q[:, :2])
        boxes.append([[x, y, z] for z in (q[:, 2].min(), q[:, 2].max()) for x, y in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: no voxel grid but every third return, the plane of lesson 03, principal axes
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

def plane_of_road(points, rng):
    best = None
    for _ in range(100):
        p, q, r = points[rng.integers(0, len(points), 3)]
        normal = np.cross(q - p, r - p)
        if np.linalg.norm(normal) < 1e-9:
            continue
        inliers = np.abs((points - p) @ normal / np.linalg.norm(normal)) < 0.15
        if best is None or inliers.sum() > best.sum():
            best = inliers
    if best is None:
        return None
    middle = points[best].mean(axis=0)
    normal = np.linalg.svd(points[best] - middle, full_matrices=False)[2][2]
    return normal * np.sign(normal[2]), middle

def detect_obstacles(cloud):
    xyz = cloud[:, :3].astype(np.float64)
    xyz = xyz[np.isfinite(xyz).all(axis=1) & (np.abs(xyz) > 1e-6).any(axis=1)]
    xyz = xyz[(xyz[:, 0] > -10) & (xyz[:, 0] < 14) & (np.abs(xyz[:, 1]) < 6) & (xyz[:, 2] < 1)][::3]
    xyz = xyz[~((xyz[:, 0] > -1.5) & (xyz[:, 0] < 2.6) & (np.abs(xyz[:, 1]) < 1.7))]
    if len(xyz) < 3:
        return np.empty((0, 8, 3))
    low = xyz[xyz[:, 2] < -1.0]  # or the side of a lorry wins
    plane = plane_of_road(low, np.random.default_rng(0)) if len(low) >= 3 else None
    if plane is not None:
        xyz = xyz[(xyz - plane[1]) @ plane[0] >= 0.25]
    if not len(xyz):
        return np.empty((0, 8, 3))
    near = cKDTree(xyz).query_pairs(0.4, output_type="ndarray")
    graph = csr_matrix((np.ones(len(near)), tuple(near.T)), shape=(len(xyz), len(xyz)))
    labels = connected_components(graph, directed=False)[1]
    boxes = []
    for k in np.flatnonzero(np.bincount(labels) >= 30):
        q = xyz[labels == k]
        deviation = q - q.mean(axis=0)
        first = np.linalg.svd(deviation[:, :2], full_matrices=False)[2][0]
        turn = np.array([[first[0], -first[1], 0], [first[1], first[0], 0], [0, 0, 1]])
        seen = deviation @ turn
        low, high = seen.min(axis=0), seen.max(axis=0)
        corners = [[x, y, z] for z in (low[2], high[2])
                   for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))]
        boxes.append(np.array(corners) @ turn.T + q.mean(axis=0))
    return np.reshape(boxes, (-1, 8, 3))

# %% right: a KD-tree of one's own and a flood through it, as in lessons 04 and 05
import numpy as np

class Node:
    def __init__(self, point, index):
        self.point, self.index, self.left, self.right = point, index, None, None

class KdTree:
    def __init__(self):
        self.root = None

    def insert(self, point, index):
        if self.root is None:
            self.root = Node(point, index)
            return
        node, depth = self.root, 0
        while True:
            side = "left" if point[depth % 3] < node.point[depth % 3] else "right"
            if getattr(node, side) is None:
                setattr(node, side, Node(point, index))
                return
            node, depth = getattr(node, side), depth + 1

    def search(self, target, tolerance):
        found, todo = [], [(self.root, 0)]
        while todo:
            node, axis = todo.pop()
            if node is None:
                continue
            x, y, z = node.point
            if (x - target[0]) ** 2 + (y - target[1]) ** 2 + (z - target[2]) ** 2 <= tolerance ** 2:
                found.append(node.index)
            if target[axis] - tolerance < node.point[axis]:
                todo.append((node.left, (axis + 1) % 3))
            if target[axis] + tolerance >= node.point[axis]:
                todo.append((node.right, (axis + 1) % 3))
        return found
# ---- another cell ----
def euclidean_clustering(cloud, threshold=0.5):
    points = [tuple(row) for row in cloud[:, :3].tolist()]
    tree = KdTree()
    for index in np.random.default_rng(0).permutation(len(points)).tolist():
        tree.insert(points[index], index)
    labels, number = [0] * len(points), 0
    for start in range(len(points)):
        if labels[start]:
            continue
        number += 1
        labels[start] = number
        todo = [start]
        while todo:
            for other in tree.search(points[todo.pop()], threshold):
                if not labels[other]:
                    labels[other] = number
                    todo.append(other)
    return np.array(labels, dtype=int)
# ---- another cell ----
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-12.0, -6.0, -3.0), maximum=(20.0, 7.5, 1.0)):
    points = cloud[np.isfinite(cloud[:, :3]).all(axis=1)][:, :3]
    points = points[((points >= minimum) & (points <= maximum)).all(axis=1)]
    points = points[~((points >= (-1.5, -1.7, -1.0)) & (points <= (2.6, 1.7, 0.0))).all(axis=1)]
    points = points[points[:, 2] >= ground_level]
    cells, which, count = np.unique(np.floor(points / 0.3), axis=0, return_inverse=True, return_counts=True)
    points = np.stack([np.bincount(which.ravel(), column, len(cells)) for column in points.T], axis=1)
    points = points / count[:, None]
    labels = euclidean_clustering(points, threshold)
    boxes = []
    for label in range(1, labels.max(initial=0) + 1):
        x, y, z = points[labels == label].T
        if len(x) < min_num_points:
            continue
        slope = 0.5 * np.arctan2(2 * np.cov(x, y)[0, 1], np.var(x) - np.var(y))
        c, s = np.cos(slope), np.sin(slope)
        u, v = c * x + s * y, c * y - s * x
        ring = [(c * a - s * b, s * a + c * b) for a, b in (
            (u.max(), v.max()), (u.min(), v.max()), (u.min(), v.min()), (u.max(), v.min()))]
        boxes.append([(*corner, height) for height in (z.min(), z.max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: all distances of one point at a time, in a small region
import numpy as np

def cluster(points, threshold):
    labels = np.zeros(len(points), dtype=int)
    while (labels == 0).any():
        front = np.flatnonzero(labels == 0)[:1]
        number = labels.max() + 1
        labels[front] = number
        while len(front):
            free = np.flatnonzero(labels == 0)
            close = np.zeros(len(free), dtype=bool)
            for point in points[front]:
                close |= ((points[free] - point) ** 2).sum(axis=1) < threshold ** 2
            front = free[close]
            labels[front] = number
    return labels

def detect_obstacles(cloud):
    p = np.asarray(cloud, dtype=float)[:, :3]
    p = p[np.isfinite(p).all(axis=1)]
    p = p[(np.abs(p[:, 0]) < 11) & (np.abs(p[:, 1]) < 6.5) & (p[:, 2] > -1.25) & (p[:, 2] < 0.5)]
    p = p[(p[:, 0] < -1.6) | (p[:, 0] > 2.6) | (np.abs(p[:, 1]) > 1.7)]
    _, first = np.unique((p // 0.25).astype(int), axis=0, return_index=True)
    p = p[first]
    labels = cluster(p, 0.7)
    result = np.zeros((0, 8, 3))
    for label in set(labels.tolist()):
        q = p[labels == label]
        if len(q) >= 6:
            mean = q[:, :2].mean(axis=0)
            values, vectors = np.linalg.eig((q[:, :2] - mean).T @ (q[:, :2] - mean))
            t = (q[:, :2] - mean) @ vectors
            (x0, y0), (x1, y1) = t.min(axis=0), t.max(axis=0)
            flat = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) @ vectors.T + mean
            box = np.vstack([np.c_[flat, np.full(4, q[:, 2].min())], np.c_[flat, np.full(4, q[:, 2].max())]])
            result = np.append(result, [box], axis=0)
    return result

# %% right: no drop_invalid: the region takes out what is not a number, the minimum what is at (0, 0, 0)
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5, minimum=10):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[(np.abs(p[:, 0] - 5) < 20) & (np.abs(p[:, 1] - 1) < 8) & (p[:, 2] < 1) & (p[:, 2] >= -1.2)]
    p = p[~((p >= (-1.5, -1.7, -1.0)) & (p <= (2.6, 1.7, -0.4))).all(axis=1)]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.flatnonzero(np.bincount(labels) >= minimum):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: the spare parts of the lesson, one for each step
import numpy as np
from sklearn.cluster import DBSCAN
from sklearn.decomposition import PCA
from sklearn.linear_model import RANSACRegressor

def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    points = cloud[:, :3]
    points = points[((points >= minimum) & (points <= maximum)).all(axis=1)]
    points = points[~((points >= (-1.5, -1.7, -1.0)) & (points <= (2.6, 1.7, -0.4))).all(axis=1)]
    low = points[points[:, 2] < ground_level]
    if len(low) >= 3:
        road = RANSACRegressor(residual_threshold=0.2, random_state=0).fit(low[:, :2], low[:, 2])
        points = points[points[:, 2] - road.predict(points[:, :2]) > 0.3]
    if len(points) == 0:
        return np.empty((0, 8, 3))
    points = points[np.unique(np.floor(points / 0.2), axis=0, return_index=True)[1]]
    labels = DBSCAN(eps=threshold, min_samples=1).fit_predict(points) + 1
    labels = labels * (np.bincount(labels) >= min_num_points)[labels]
    boxes = []
    for label in np.unique(labels[labels > 0]):
        cluster = points[labels == label]
        pca = PCA(2).fit(cluster[:, :2])
        (a, c), (b, d) = (side(pca.transform(cluster[:, :2]), axis=0) for side in (np.min, np.max))
        ring = pca.inverse_transform([[a, c], [b, c], [b, d], [a, d]])
        boxes.append([[x, y, z] for z in (cluster[:, 2].min(), cluster[:, 2].max()) for x, y in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: the hints to the letter, with functions in a student's words
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

def drop_invalid(cloud):
    good = ~np.isnan(cloud[:, :3]).any(axis=1) & ~np.isinf(cloud[:, :3]).any(axis=1)
    return cloud[good & (np.abs(cloud[:, :3]).sum(axis=1) > 0)]

def crop_region(cloud, minimum, maximum):
    for axis in range(3):
        cloud = cloud[(cloud[:, axis] >= minimum[axis]) & (cloud[:, axis] <= maximum[axis])]
    return cloud

def remove_ego_returns(cloud, minimum, maximum):
    away = np.zeros(len(cloud), dtype=bool)
    for axis in range(3):
        away |= (cloud[:, axis] < minimum[axis]) | (cloud[:, axis] > maximum[axis])
    return cloud[away]

def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, near = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations if len(points) > 2 else 0):
        p, q, r = points[rng.choice(len(points), 3, replace=False), :3]
        normal = np.cross(q - p, r - p)
        if np.linalg.norm(normal) > 1e-9:
            normal = normal / np.linalg.norm(normal)
            plane = (*normal, -normal @ p)
            mask = point_plane_distance(points, plane) <= distance_tolerance
            if mask.sum() > near.sum():
                best, near = plane, mask
    return best, near

def fit_plane(points):
    middle = points[:, :3].mean(axis=0)
    normal = np.linalg.eigh(np.cov(points[:, :3].T))[1][:, 0]
    return (*normal, -normal @ middle)
# ---- another cell ----
def voxel_grid(cloud, voxel_size=0.2):
    cells = {}
    for row, key in zip(cloud, map(tuple, np.floor(cloud[:, :3] / voxel_size).astype(int).tolist())):
        cells.setdefault(key, []).append(row)
    return np.array([np.mean(rows, axis=0) for rows in cells.values()])

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    pairs = KDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(cloud), len(cloud)))
    return connected_components(graph, directed=False)[1] + 1

def filter_clusters(labels, min_num_points=100):
    labels = labels.copy()
    for label in np.unique(labels):
        if (labels == label).sum() < min_num_points:
            labels[labels == label] = 0
    return labels

def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points[:, :3] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

def get_oriented_boxes(cloud, labels):
    boxes = []
    for label in np.unique(labels[labels > 0]):
        points = cloud[labels == label]
        yaws = np.radians(np.arange(90))
        yaw = min(yaws, key=lambda yaw: np.prod(np.ptp(turned(points, -yaw)[:, :2], axis=0)))
        low, high = turned(points, -yaw).min(axis=0), turned(points, -yaw).max(axis=0)
        around = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
        corners = [(x, y, z) for z in (low[2], high[2]) for x, y in around]
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)
# ---- another cell ----
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    points = drop_invalid(cloud[:, :3])
    points = crop_region(points, minimum, maximum)
    points = remove_ego_returns(points, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low = points[points[:, 2] < ground_level]
    plane, near = ransac_plane(low, 50, 0.2, 0)
    if plane is not None:
        plane = fit_plane(low[near])
        points = points[point_plane_distance(points, plane) > 0.3]
    if len(points) == 0:
        return np.empty((0, 8, 3))
    points = voxel_grid(points, 0.2)
    labels = euclidean_clustering_accelerated(points, threshold)
    labels = filter_clusters(labels, min_num_points)
    return get_oriented_boxes(points, labels)

# %% wrong: nothing is ever in the way
# loses: finds_cars, finds_people, leaves_the_road, test_fresh_streets, test_few_ghosts, test_city
# says: no box is over it
def detect_obstacles(cloud):
    return np.empty((0, 8, 3))

# %% wrong: one box around everything
# loses: finds_cars, turns_boxes, test_fresh_streets, test_city, test_turned_cars
# says: the box over it is
def detect_obstacles(cloud):
    xyz = cloud[np.isfinite(cloud).all(axis=1), :3]
    xyz = xyz[xyz[:, 2] > -1.2]
    if not len(xyz):
        return np.empty((0, 8, 3))
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    return np.array([[[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]])

# %% wrong: boxes of the road
# loses: finds_cars, leaves_the_road, test_fresh_streets, test_few_ghosts, test_empty_road
# says: have no box of their own
from scipy import ndimage

def detect_obstacles(cloud):
    return boxes_of_cells(cloud, lambda z: z < -1.2)
# ---- another cell ----
def boxes_of_cells(cloud, choose, cell=0.4, minimum=20, own=True):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & choose(xyz[:, 2])]
    if own:
        xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            x, y, z = (np.array([side.min(), side.max()]) for side in points.T)
            boxes.append([[x[i], y[j], z[k]] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the road stays in
# loses: finds_cars, turns_boxes, test_fresh_streets, test_city, test_empty_road
# says: Is the road gone?
from scipy import ndimage

def boxes_of_cells(cloud, choose, cell=0.3, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & choose(xyz[:, 2])]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            x, y, z = (np.array([side.min(), side.max()]) for side in points.T)
            boxes.append([[x[i], y[j], z[k]] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    return np.array(boxes).reshape(-1, 8, 3)

def detect_obstacles(cloud):
    return boxes_of_cells(cloud, lambda z: z > -9.0)

# %% wrong: one round of RANSAC, by luck a road in some scans
# loses: finds_cars, turns_boxes
# says: Is the road gone?
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

def drop_invalid(cloud):
    good = ~np.isnan(cloud[:, :3]).any(axis=1) & ~np.isinf(cloud[:, :3]).any(axis=1)
    return cloud[good & (np.abs(cloud[:, :3]).sum(axis=1) > 0)]

def crop_region(cloud, minimum, maximum):
    for axis in range(3):
        cloud = cloud[(cloud[:, axis] >= minimum[axis]) & (cloud[:, axis] <= maximum[axis])]
    return cloud

def remove_ego_returns(cloud, minimum, maximum):
    away = np.zeros(len(cloud), dtype=bool)
    for axis in range(3):
        away |= (cloud[:, axis] < minimum[axis]) | (cloud[:, axis] > maximum[axis])
    return cloud[away]

def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, near = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations if len(points) > 2 else 0):
        p, q, r = points[rng.choice(len(points), 3, replace=False), :3]
        normal = np.cross(q - p, r - p)
        if np.linalg.norm(normal) > 1e-9:
            normal = normal / np.linalg.norm(normal)
            plane = (*normal, -normal @ p)
            mask = point_plane_distance(points, plane) <= distance_tolerance
            if mask.sum() > near.sum():
                best, near = plane, mask
    return best, near

def fit_plane(points):
    middle = points[:, :3].mean(axis=0)
    normal = np.linalg.eigh(np.cov(points[:, :3].T))[1][:, 0]
    return (*normal, -normal @ middle)
# ---- another cell ----
def voxel_grid(cloud, voxel_size=0.2):
    cells = {}
    for row, key in zip(cloud, map(tuple, np.floor(cloud[:, :3] / voxel_size).astype(int).tolist())):
        cells.setdefault(key, []).append(row)
    return np.array([np.mean(rows, axis=0) for rows in cells.values()])

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    pairs = KDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(cloud), len(cloud)))
    return connected_components(graph, directed=False)[1] + 1

def filter_clusters(labels, min_num_points=100):
    labels = labels.copy()
    for label in np.unique(labels):
        if (labels == label).sum() < min_num_points:
            labels[labels == label] = 0
    return labels

def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points[:, :3] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

def get_oriented_boxes(cloud, labels):
    boxes = []
    for label in np.unique(labels[labels > 0]):
        points = cloud[labels == label]
        yaws = np.radians(np.arange(90))
        yaw = min(yaws, key=lambda yaw: np.prod(np.ptp(turned(points, -yaw)[:, :2], axis=0)))
        low, high = turned(points, -yaw).min(axis=0), turned(points, -yaw).max(axis=0)
        around = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
        corners = [(x, y, z) for z in (low[2], high[2]) for x, y in around]
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)
# ---- another cell ----
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    points = drop_invalid(cloud[:, :3])
    points = crop_region(points, minimum, maximum)
    points = remove_ego_returns(points, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low = points[points[:, 2] < ground_level]
    plane, near = ransac_plane(low, 1, 0.2, 0)
    if plane is not None:
        plane = fit_plane(low[near])
        points = points[point_plane_distance(points, plane) > 0.3]
    if len(points) == 0:
        return np.empty((0, 8, 3))
    points = voxel_grid(points, 0.2)
    labels = euclidean_clustering_accelerated(points, threshold)
    labels = filter_clusters(labels, min_num_points)
    return get_oriented_boxes(points, labels)

# %% wrong: boxes along the axes
# loses only: turns_boxes, test_turned_cars
# says: much larger than the cars
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            x, y, z = (np.array([side.min(), side.max()]) for side in points.T)
            boxes.append([[x[i], y[j], z[k]] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: its own car stays in, thinned to patches or not
# loses only: forgets_itself, test_own_car
# says: where the own car is
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5, minimum=10):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1) & p.any(axis=1)]
    p = p[(np.abs(p[:, 0] - 5) < 20) & (np.abs(p[:, 1] - 1) < 8) & (p[:, 2] < 1) & (p[:, 2] >= -1.2)]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.flatnonzero(np.bincount(labels) >= minimum):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the own car is thought to be smaller than it is
# loses only: forgets_itself, test_own_car
# says: the whole box of the own car
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5, minimum=10):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1) & p.any(axis=1)]
    p = p[(np.abs(p[:, 0] - 5) < 20) & (np.abs(p[:, 1] - 1) < 8) & (p[:, 2] < 1) & (p[:, 2] >= -1.2)]
    p = p[np.hypot(p[:, 0], p[:, 1]) > 2.0]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.flatnonzero(np.bincount(labels) >= minimum):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the minimum of lesson 09 on a thinned cloud
# loses only: finds_people, test_people
# says: have no box of their own
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5, minimum=100):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1) & p.any(axis=1)]
    p = p[(np.abs(p[:, 0] - 5) < 20) & (np.abs(p[:, 1] - 1) < 8) & (p[:, 2] < 1) & (p[:, 2] >= -1.2)]
    p = p[~((np.abs(p[:, 0] - 0.55) < 2.1) & (np.abs(p[:, 1]) < 1.75))]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.flatnonzero(np.bincount(labels) >= minimum):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: lost returns at (0, 0, 0) stay in
# loses only: drops_invalid, test_dirty_scan
# says: around (0, 0, 0)
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75) & (xyz[:, 2] < -0.1))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: cars and walls are one cluster
# loses: finds_cars, turns_boxes, test_fresh_streets
# says: smaller than the gaps between things
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=5.0):
    p = cloud[np.isfinite(cloud[:, :3]).all(axis=1), :3]
    p = p[(p[:, 2] > -1.2) & (np.hypot(p[:, 0], p[:, 1]) < 25) & (np.hypot(p[:, 0], p[:, 1]) > 2.7)]
    p = p[np.unique(np.floor(p / 0.5), axis=0, return_index=True)[1]]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for k in range(labels.max() + 1):
        x, y, z = (np.array([side.min(), side.max()]) for side in p[labels == k].T)
        boxes.append([[x[i], y[j], z[k]] for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    return np.array(boxes)

# %% wrong: every cell of the voxel grid is an obstacle
# loses: finds_cars, leaves_the_road, turns_boxes, test_fresh_streets, test_few_ghosts
# says: boxes on it
def detect_obstacles(cloud):
    p = cloud[np.isfinite(cloud[:, :3]).all(axis=1), :3]
    p = p[(p[:, 2] > -1.2) & (np.hypot(p[:, 0], p[:, 1]) < 15) & (np.hypot(p[:, 0], p[:, 1]) > 2.7)]
    cells = np.unique(np.floor(p / 0.5), axis=0) * 0.5
    corners = np.array([[x, y, z] for z in (0, .5) for x, y in ((0, 0), (.5, 0), (.5, .5), (0, .5))])
    return cells[:, None] + corners

# %% wrong: cannot bear that nothing is left
# loses only: takes_an_empty_scan, test_empty_road, test_small_scans
# says: nothing to take the smallest
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = np.floor(xyz[:, :2] / cell).astype(int)
    fine -= fine.min(axis=0)
    grid = np.zeros(fine.max(axis=0) + 1, dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes)

# %% wrong: needs intensity
# loses only: takes_three_columns
# says: may have three columns
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    bright = cloud[:, 3] > 0.0
    xyz = cloud[bright, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: functions from another notebook, which the judge does not have
# loses: finds_cars, finds_people, test_fresh_streets
# says: paste what it needs into that notebook
def detect_obstacles(cloud, threshold=0.5, min_num_points=10):
    from utils import load_my_functions

    points = load_my_functions("06_filter_ground.ipynb").filter_ground(cloud)
    labels = load_my_functions("10_accelerated_clustering.ipynb").euclidean_clustering_accelerated(points)
    return load_my_functions("11_pca_boxes.ipynb").get_oriented_boxes(points, labels)

# %% wrong: returns that are not a number
# loses only: drops_invalid, test_dirty_scan
# says: raised ValueError
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[~(p[:, 2] < -1.2) & ~(np.abs(p[:, 1]) > 7) & ~(np.abs(p[:, 0]) > 15)]
    p = p[~((np.abs(p[:, 0] - 0.55) < 2.1) & (np.abs(p[:, 1]) < 1.75))]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.unique(labels):
        points = p[labels == label]
        if len(points) >= 10:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: boxes tilted in three dimensions
# loses only: stands_upright, turns_boxes, test_turned_cars
# says: stand upright
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points.mean(axis=0)
            axes = np.linalg.eigh(np.cov(points.T))[1]
            seen = (points - middle) @ axes
            ends = np.stack([seen.min(0), seen.max(0)])
            boxes.append([[ends[k >> d & 1, d] for d in range(3)] @ axes.T + middle for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: middles instead of boxes
# loses: finds_cars, stands_upright, test_city
# says: N boxes of 8 corners
def detect_obstacles(cloud):
    p = cloud[np.isfinite(cloud[:, :3]).all(axis=1), :3]
    p = p[p[:, 2] > -1.2]
    cells, which = np.unique(np.floor(p[:, :2] / 4), axis=0, return_inverse=True)
    return np.array([p[which.ravel() == k].mean(axis=0) for k in range(len(cells))])

# %% wrong: cleans its input
# loses only: leaves_the_cloud
# says: changed its input
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20):
    cloud[~np.isfinite(cloud).all(axis=1)] = 0.0
    xyz = cloud[:, :3]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: cars where cars usually stand
# loses: turns_boxes, leaves_the_road, finds_people, test_fresh_streets, test_few_ghosts, test_empty_road
# says: hold more road than obstacle
def detect_obstacles(cloud):
    car = np.array([[x, y, z] for z in (-1.6, -0.3) for x, y in ((2.1, .9), (-2.1, .9), (-2.1, -.9), (2.1, -.9))])
    rows = [(x, y, 0) for x in range(-12, 26, 5) for y in (-2.75, 0.4, 2.8, 5.15)
            if abs(x) > 4 or abs(y) > 2]
    return np.array(rows)[:, None] + car

# %% wrong: what filter_clusters took out gets a box of its own
# loses: finds_cars, finds_people, test_city
# says: the box over it is
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.5):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1)]
    p = p[~(p[:, 2] < -1.2) & ~(np.abs(p[:, 1]) > 7) & ~(np.abs(p[:, 0]) > 15)]
    p = p[~((np.abs(p[:, 0] - 0.55) < 2.1) & (np.abs(p[:, 1]) < 1.75))]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.2), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1] + 1
    labels = np.where(np.bincount(labels)[labels] < 30, 0, labels)
    boxes = []
    for label in np.unique(labels):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.svd(np.vstack([points[:, :2] - middle, np.zeros((2, 2))]))[2].T
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: left and right are clustered apart and share their labels
# loses: finds_cars, turns_boxes, test_fresh_streets, test_city
# says: the box over it is
from scipy import ndimage

def labels_of(xyz, cell=0.3):
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    return ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]

def detect_obstacles(cloud, minimum=20):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    left, right = xyz[xyz[:, 1] > 0], xyz[xyz[:, 1] <= 0]
    xyz, labels = np.vstack([left, right]), np.append(labels_of(left), labels_of(right))
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: small clusters stay
# loses only: ignores_rain, test_rain
# says: Single returns in the air
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1) & xyz.any(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 8) & (xyz[:, 2] > -1.2)]
    xyz = xyz[~((np.abs(xyz[:, 0] - 0.55) < 2.1) & (np.abs(xyz[:, 1]) < 1.75))]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.svd(np.vstack([points[:, :2] - middle, np.zeros((2, 2))]), full_matrices=False)[2].T
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the ground level is that of a map, 0
# loses: finds_cars, turns_boxes, test_fresh_streets, test_city, test_turned_cars
# says: no box is over it
from scipy import ndimage

def detect_obstacles(cloud, cell=0.3, minimum=20, ground_level=0.0):
    xyz = np.asarray(cloud, dtype=float)[:, :3]
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    xyz = xyz[(np.abs(xyz[:, 0] - 5) < 20) & (np.abs(xyz[:, 1] - 1) < 12) & (xyz[:, 2] > ground_level)]
    fine = (np.floor(xyz[:, :2] / cell) + 200).astype(int)
    grid = np.zeros((500, 500), dtype=bool)
    grid[tuple(fine.T)] = True
    labels = ndimage.label(grid, structure=np.ones((3, 3)))[0][tuple(fine.T)]
    boxes = []
    for label in np.unique(labels):
        points = xyz[labels == label]
        if len(points) >= minimum:
            middle = points[:, :2].mean(axis=0)
            axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
            a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
            ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
            boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: threshold far below the distance between points
# loses: finds_cars, turns_boxes, test_turned_cars
# says: boxes on it
from scipy.spatial import cKDTree
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

def detect_obstacles(cloud, threshold=0.12, minimum=4):
    p = np.array(cloud[:, :3], dtype=float)
    p = p[np.isfinite(p).all(axis=1)]
    p = p[~(p[:, 2] < -1.2) & ~(np.abs(p[:, 1]) > 7) & ~(np.abs(p[:, 0]) > 15)]
    p = p[~((np.abs(p[:, 0] - 0.55) < 2.1) & (np.abs(p[:, 1]) < 1.75))]
    if len(p) == 0:
        return np.empty((0, 8, 3))
    p = p[np.unique(np.floor(p / 0.1), axis=0, return_index=True)[1]]
    i, j = cKDTree(p).query_pairs(threshold, output_type="ndarray").T
    labels = connected_components(coo_matrix((np.ones(len(i)), (i, j)), (len(p), len(p))), False)[1]
    boxes = []
    for label in np.flatnonzero(np.bincount(labels) >= minimum):
        points = p[labels == label]
        middle = points[:, :2].mean(axis=0)
        axes = np.linalg.eigh(np.cov(points[:, :2].T))[1]
        a, b = ((points[:, :2] - middle) @ axes).min(0), ((points[:, :2] - middle) @ axes).max(0)
        ring = np.array([a, (b[0], a[1]), b, (a[0], b[1])]) @ axes.T + middle
        boxes.append([[*corner, z] for z in (points[:, 2].min(), points[:, 2].max()) for corner in ring])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: stub left in place
# loses: finds_cars, finds_people, test_fresh_streets, test_small_scans
# says: is not started
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    raise NotImplementedError

# %% wrong: a region that ends at 8 m
# loses only: looks_far_enough, test_reach
# says: Where does your region of interest end?
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

def drop_invalid(cloud):
    good = ~np.isnan(cloud[:, :3]).any(axis=1) & ~np.isinf(cloud[:, :3]).any(axis=1)
    return cloud[good & (np.abs(cloud[:, :3]).sum(axis=1) > 0)]

def crop_region(cloud, minimum, maximum):
    for axis in range(3):
        cloud = cloud[(cloud[:, axis] >= minimum[axis]) & (cloud[:, axis] <= maximum[axis])]
    return cloud

def remove_ego_returns(cloud, minimum, maximum):
    away = np.zeros(len(cloud), dtype=bool)
    for axis in range(3):
        away |= (cloud[:, axis] < minimum[axis]) | (cloud[:, axis] > maximum[axis])
    return cloud[away]

def point_plane_distance(points, plane):
    a, b, c, d = plane
    return abs(a * points[:, 0] + b * points[:, 1] + c * points[:, 2] + d)

def ransac_plane(points, max_iterations, distance_tolerance, rng):
    rng = np.random.default_rng(rng)
    best, near = None, np.zeros(len(points), dtype=bool)
    for _ in range(max_iterations if len(points) > 2 else 0):
        p, q, r = points[rng.choice(len(points), 3, replace=False), :3]
        normal = np.cross(q - p, r - p)
        if np.linalg.norm(normal) > 1e-9:
            normal = normal / np.linalg.norm(normal)
            plane = (*normal, -normal @ p)
            mask = point_plane_distance(points, plane) <= distance_tolerance
            if mask.sum() > near.sum():
                best, near = plane, mask
    return best, near

def fit_plane(points):
    middle = points[:, :3].mean(axis=0)
    normal = np.linalg.eigh(np.cov(points[:, :3].T))[1][:, 0]
    return (*normal, -normal @ middle)
# ---- another cell ----
def voxel_grid(cloud, voxel_size=0.2):
    cells = {}
    for row, key in zip(cloud, map(tuple, np.floor(cloud[:, :3] / voxel_size).astype(int).tolist())):
        cells.setdefault(key, []).append(row)
    return np.array([np.mean(rows, axis=0) for rows in cells.values()])

def euclidean_clustering_accelerated(cloud, threshold=0.5):
    pairs = KDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(cloud), len(cloud)))
    return connected_components(graph, directed=False)[1] + 1

def filter_clusters(labels, min_num_points=100):
    labels = labels.copy()
    for label in np.unique(labels):
        if (labels == label).sum() < min_num_points:
            labels[labels == label] = 0
    return labels

def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return points[:, :3] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

def get_oriented_boxes(cloud, labels):
    boxes = []
    for label in np.unique(labels[labels > 0]):
        points = cloud[labels == label]
        yaws = np.radians(np.arange(90))
        yaw = min(yaws, key=lambda yaw: np.prod(np.ptp(turned(points, -yaw)[:, :2], axis=0)))
        low, high = turned(points, -yaw).min(axis=0), turned(points, -yaw).max(axis=0)
        around = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
        corners = [(x, y, z) for z in (low[2], high[2]) for x, y in around]
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)
# ---- another cell ----
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(8.0, 9.0, 1.0)):
    points = drop_invalid(cloud[:, :3])
    points = crop_region(points, minimum, maximum)
    points = remove_ego_returns(points, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low = points[points[:, 2] < ground_level]
    plane, near = ransac_plane(low, 50, 0.2, 0)
    if plane is not None:
        plane = fit_plane(low[near])
        points = points[point_plane_distance(points, plane) > 0.3]
    if len(points) == 0:
        return np.empty((0, 8, 3))
    points = voxel_grid(points, 0.2)
    labels = euclidean_clustering_accelerated(points, threshold)
    labels = filter_clusters(labels, min_num_points)
    return get_oriented_boxes(points, labels)
