# Answers to euclidean_clustering; see grader/variants.py.

# %% right: a queue and NumPy
from collections import deque

def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = deque([start])
        while queue:
            point = queue.popleft()
            distance = np.sqrt(((xyz - xyz[point]) ** 2).sum(axis=1))
            for neighbour in np.flatnonzero((distance < threshold) & (labels == 0)):
                labels[neighbour] = current
                queue.append(neighbour)
    return labels

# %% right: a stack in plain Python, a list back
def euclidean_clustering(cloud, threshold=0.5):
    points = [tuple(map(float, row[:3])) for row in cloud]
    labels = [0] * len(points)
    unlabelled = set(range(len(points)))
    number = 0
    while unlabelled:
        number += 1
        stack = [min(unlabelled)]
        unlabelled.discard(stack[0])
        while stack:
            i = stack.pop()
            labels[i] = number
            a, b, c = points[i]
            near = [j for j in unlabelled if (points[j][0] - a) ** 2 + (points[j][1] - b) ** 2
                    + (points[j][2] - c) ** 2 <= threshold ** 2]
            unlabelled.difference_update(near)
            stack += near
    return labels

# %% right: SciPy's neighbours, clusters numbered from the last point
from scipy.spatial import cKDTree

def euclidean_clustering(cloud, threshold=0.5):
    labels = np.full(len(cloud), -1)
    if len(cloud) == 0:
        return labels
    tree = cKDTree(cloud[:, :3])
    number = 0
    for start in reversed(range(len(cloud))):
        if labels[start] >= 0:
            continue
        number += 1
        todo = [start]
        labels[start] = number
        while todo:
            for neighbour in tree.query_ball_point(cloud[todo.pop(), :3], threshold):
                if labels[neighbour] < 0:
                    labels[neighbour] = number
                    todo.append(neighbour)
    return labels

# %% right: union and find
def euclidean_clustering(cloud, threshold=0.5):
    parent = list(range(len(cloud)))

    def find(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i in range(len(cloud)):
        near = np.linalg.norm(cloud[:i, :3] - cloud[i, :3], axis=1) < threshold
        for j in np.nonzero(near)[0]:
            parent[find(j)] = find(i)
    roots = [find(i) for i in range(len(cloud))]
    return np.unique(roots, return_inverse=True)[1] + 1

# %% right: a class with state, labels as floats
import sys
sys.setrecursionlimit(3000)

class Clusterer:
    def __init__(self, points, radius):
        self.points, self.radius = points, radius
        self.labels = np.zeros(len(points))

    def grow(self, seed, number):
        frontier = np.zeros(len(self.points), dtype=bool)
        frontier[seed] = True
        self.labels[seed] = number
        while frontier.any():
            fresh = np.zeros_like(frontier)
            for i in np.flatnonzero(frontier):
                fresh |= np.linalg.norm(self.points - self.points[i], axis=1) < self.radius
            frontier = fresh & (self.labels == 0)
            self.labels[frontier] = number
# ---- another cell ----
%%time
def euclidean_clustering(cloud, threshold=0.5):
    clusterer = Clusterer(np.array(cloud)[:, :3], threshold)
    number = 0
    for i in range(len(cloud)):
        if clusterer.labels[i] == 0:
            number += 1
            clusterer.grow(i, number)
    return clusterer.labels

# %% right: connected components of a sparse graph
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

def euclidean_clustering(cloud, threshold=0.5):
    n = len(cloud)
    if n == 0:
        return np.array([], dtype=int)
    i, j = cKDTree(cloud[:, :3]).query_pairs(threshold, output_type="ndarray").T
    graph = coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n))
    return connected_components(graph, directed=False)[1] + 1

# %% wrong: labels of eight bits
# loses: test_extremes
# says: different clusters have the same label
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(cloud), dtype=np.uint8)
    done = np.zeros(len(cloud), dtype=bool)
    current = 0
    for start in range(len(cloud)):
        if done[start]:
            continue
        current += 1
        done[start] = True
        todo = [start]
        while todo:
            point = todo.pop()
            labels[point] = current % 256
            distance = np.sqrt(((xyz - xyz[point]) ** 2).sum(axis=1))
            near = np.flatnonzero((distance < threshold) & ~done)
            done[near] = True
            todo += near.tolist()
    return labels

# %% wrong: compares with the first point of the cluster only
# loses: follows_chains, test_long_chain, test_fresh_streets
# says: Points that belong together
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start] == 0:
            current += 1
            near = np.linalg.norm(cloud[:, :3] - cloud[start, :3], axis=1) < threshold
            labels[near & (labels == 0)] = current
    return labels

# %% wrong: labels from 0
# loses: counts_from_one
# says: not 1 to N
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.full(len(cloud), -1)
    current = -1
    for start in range(len(cloud)):
        if labels[start] >= 0:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop(0)
            distance = np.linalg.norm(cloud[:, :3] - cloud[point, :3], axis=1)
            for neighbour in np.flatnonzero((distance < threshold) & (labels < 0)):
                labels[neighbour] = current
                queue.append(neighbour)
    return labels

# %% wrong: squared distance against plain threshold
# loses: follows_the_threshold, test_other_thresholds
# says: its square
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop()
            squared = ((cloud[:, :3] - cloud[point, :3]) ** 2).sum(axis=1)
            near = np.flatnonzero((squared < threshold) & (labels == 0))
            labels[near] = current
            queue.extend(near)
    return labels

# %% wrong: plain distance against squared threshold
# loses: follows_the_threshold, separates_groups, test_other_thresholds
# says: belong together
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop()
            distance = np.linalg.norm(cloud[:, :3] - cloud[point, :3], axis=1)
            near = np.flatnonzero((distance < threshold ** 2) & (labels == 0))
            labels[near] = current
            queue.extend(near)
    return labels

# %% wrong: intensity is a coordinate
# loses: ignores_intensity
# says: a fourth column
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop()
            near = np.flatnonzero((np.linalg.norm(cloud - cloud[point], axis=1) < threshold)
                                  & (labels == 0))
            labels[near] = current
            queue.extend(near)
    return labels

# %% wrong: forgets the height
# loses: ignores_intensity
# says: Points of different clusters
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop()
            distance = np.linalg.norm(cloud[:, :2] - cloud[point, :2], axis=1)
            near = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[near] = current
            queue.extend(near)
    return labels

# %% wrong: recursion
# loses: test_long_chain
# says: use a queue and a loop
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)

    def grow(point, number):
        labels[point] = number
        distance = np.linalg.norm(cloud[:, :3] - cloud[point, :3], axis=1)
        for neighbour in np.flatnonzero(distance < threshold):
            if labels[neighbour] == 0:
                grow(neighbour, number)

    number = 0
    for start in range(len(cloud)):
        if labels[start] == 0:
            number += 1
            grow(start, number)
    return labels

# %% wrong: the threshold is written into the function
# loses: follows_the_threshold, test_other_thresholds
# says: written into the function
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        if labels[start]:
            continue
        current += 1
        labels[start] = current
        queue = [start]
        while queue:
            point = queue.pop()
            distance = np.linalg.norm(cloud[:, :3] - cloud[point, :3], axis=1)
            near = np.flatnonzero((distance < 0.5) & (labels == 0))
            labels[near] = current
            queue.extend(near)
    return labels

# %% wrong: lists of points instead of labels
# loses: separates_groups, test_course_cloud
# says: one label for each
def euclidean_clustering(cloud, threshold=0.5):
    left, clusters = list(range(len(cloud))), []
    while left:
        cluster, queue = [], [left.pop(0)]
        while queue:
            point = queue.pop()
            cluster.append(point)
            near = [j for j in left
                    if np.linalg.norm(cloud[j, :3] - cloud[point, :3]) < threshold]
            left = [j for j in left if j not in near]
            queue += near
        clusters.append(cluster)
    return np.arange(len(clusters)) + 1

# %% wrong: a library does the whole exercise
# loses: separates_groups, test_course_cloud, test_fresh_streets
# says: not allowed in this lesson
from sklearn.cluster import DBSCAN

def euclidean_clustering(cloud, threshold=0.5):
    return DBSCAN(eps=threshold, min_samples=1).fit(cloud[:, :3]).labels_ + 1

# %% wrong: a library, imported where nobody looks
# loses: separates_groups, test_course_cloud, test_fresh_streets
# says: not allowed in this lesson
import importlib

def euclidean_clustering(cloud, threshold=0.5):
    tools = importlib.import_module("scipy.cluster" + ".hierarchy")
    return tools.fclusterdata(cloud[:, :3], threshold, criterion="distance", method="single")

# %% wrong: a cluster never ends
# loses: separates_groups, test_course_cloud
# says: a loop that never ends
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for start in range(len(cloud)):
        current += 1
        queue = [start]
        while queue:
            point = queue.pop(0)
            labels[point] = current
            distance = np.linalg.norm(cloud[:, :3] - cloud[point, :3], axis=1)
            queue.extend(np.flatnonzero(distance < threshold))
    return labels

# %% wrong: everything is one cluster
# loses: separates_groups, counts_from_one, test_course_cloud, test_fresh_streets
# says: Points of different clusters
def euclidean_clustering(cloud, threshold=0.5):
    return np.ones(len(cloud), dtype=int)

# %% wrong: every point is its own cluster
# loses: separates_groups, follows_chains, test_course_cloud, test_fresh_streets
# says: Points that belong together
def euclidean_clustering(cloud, threshold=0.5):
    return np.arange(1, len(cloud) + 1)
