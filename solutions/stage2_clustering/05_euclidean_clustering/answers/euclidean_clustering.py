# Answers to euclidean_clustering; see grader/course/kept_answers.py.

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

# %% right: the hints followed to the letter
from collections import deque

def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    cluster = 0
    for start in range(len(cloud)):
        if labels[start] > 0:
            continue
        cluster = cluster + 1
        labels[start] = cluster
        queue = deque([start])
        while queue:
            i = queue.popleft()
            distances = np.linalg.norm(cloud[:, :3] - cloud[i, :3], axis=1)
            new = np.flatnonzero((distances < threshold) & (labels == 0))
            labels[new] = cluster
            queue.extend(new)
    return labels

# %% wrong: connected components of a sparse graph
# loses: separates_groups, test_course_cloud, test_fresh_streets
# says: not allowed in this lesson
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
# loses only: test_many_clusters
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
# loses: follows_chains, takes_a_long_wall, test_long_chain, test_fresh_streets
# says: Points that belong together
# told: balls instead of chains
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
# loses only: counts_from_one, takes_the_smallest, test_every_point
# says: not 1 to N
# told: start from 0
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
# loses only: follows_the_threshold, test_course_cloud, test_other_thresholds
# says: Take the root first
# told: The squared distance
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
# loses only: follows_the_threshold, test_course_cloud, test_other_thresholds
# says: belong together
# told: threshold ** 2
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
# loses only: ignores_intensity, test_intensity
# says: cloud[:, :3] are the coordinates
# told: a fourth coordinate
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
# loses: measures_alike
# says: are close along z
# told: The height is left out
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
# loses only: takes_a_long_wall, test_deep_chain
# says: RecursionError
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
# loses only: follows_the_threshold, test_other_thresholds, test_fresh
# says: Compare with the parameter threshold
# told: A fixed threshold
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

# %% wrong: one number for each cluster
# loses: separates_groups, test_course_cloud
# says: one label for each
# told: one number for each cluster
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
# told: All points have the same label
def euclidean_clustering(cloud, threshold=0.5):
    return np.ones(len(cloud), dtype=int)

# %% wrong: every point is its own cluster
# loses: separates_groups, follows_chains, test_course_cloud, test_fresh_streets
# says: Points that belong together
# told: nobody joins anybody
def euclidean_clustering(cloud, threshold=0.5):
    return np.arange(1, len(cloud) + 1)

# %% wrong: a hierarchy of SciPy
# loses: separates_groups, test_course_cloud
# says: not allowed in this lesson
from scipy.cluster.hierarchy import fclusterdata

def euclidean_clustering(cloud, threshold=0.5):
    if len(cloud) < 2:
        return np.ones(len(cloud), dtype=int)
    return fclusterdata(cloud[:, :3], threshold, criterion="distance", method="single")

# %% wrong: connected components, reached through the package
# loses: separates_groups, test_course_cloud
# says: not allowed in this lesson
import scipy.sparse as sparse
from scipy.spatial.distance import cdist

def euclidean_clustering(cloud, threshold=0.5):
    if len(cloud) == 0:
        return np.zeros(0, dtype=int)
    near = cdist(cloud[:, :3], cloud[:, :3]) < threshold
    return sparse.csgraph.connected_components(near, directed=False)[1] + 1

# %% wrong: each point as somebody before it
# loses: follows_chains, test_long_chain, test_fresh_streets
# says: Make one cluster complete
# told: clusters that meet later
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    current = 0
    for i in range(len(cloud)):
        gaps = np.linalg.norm(cloud[:i, :3] - cloud[i, :3], axis=1)
        near = np.flatnonzero(gaps < threshold)
        if len(near):
            labels[i] = labels[near[0]]
        else:
            current += 1
            labels[i] = current
    return labels

# %% wrong: labelled on leaving the queue
# loses: takes_a_dense_wall
# says: did not answer
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        waiting = deque([start])
        while waiting:
            point = waiting.popleft()
            labels[point] = cluster
            distance = np.linalg.norm(xyz - xyz[point], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            waiting.extend(newcomers)
    return labels

# %% wrong: the counter goes up at every point
# loses only: counts_from_one, test_every_point
# says: not 1 to N
# told: at every point
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        cluster += 1
        if labels[start] > 0:
            continue
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: returns after the first cluster
# loses: separates_groups, follows_chains, test_course_cloud
# says: ends too early
# told: keep the label 0
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
        return labels

# %% wrong: distances without an axis
# loses: separates_groups, follows_chains, test_course_cloud
# says: axis=1
# told: nobody joins anybody
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()])
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: distances along the wrong axis
# loses: separates_groups, follows_chains, test_course_cloud
# says: euclidean_clustering raised
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=0)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: append for extend
# loses: separates_groups, test_course_cloud
# says: extend puts in
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.append(newcomers)
    return labels

# %% wrong: no parentheses around the masks
# loses: separates_groups, test_course_cloud
# says: parentheses
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero(distance < threshold & labels == 0)
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: the ways along the axes added up
# loses: measures_alike, test_course_cloud
# says: root of
# told: are added up
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.abs(xyz - xyz[waiting.popleft()]).sum(axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: the longest way along an axis
# loses: measures_alike, test_fresh_streets
# says: root of
# told: Only the longest
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.abs(xyz - xyz[waiting.popleft()]).max(axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: distance 0 does not count
# loses only: joins_equal_points, test_extremes
# says: Equal points are at distance 0
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((0 < distance) & (distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def euclidean_clustering(points, radius=0.5):
    xyz = points[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < radius) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: default changed
# loses only: keeps_the_default
# says: Keep the first line
def euclidean_clustering(cloud, threshold=1.0):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: writes labels into the cloud
# loses only: leaves_its_input, test_input
# says: changed its input
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    cloud[:, 2] = labels
    return labels

# %% wrong: moves the cloud to its middle
# loses: takes_the_smallest
# says: can be empty
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3] - cloud[:, :3].min(axis=0)
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: forgets to return
# loses: separates_groups, test_course_cloud
# says: returned None
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)

# %% wrong: no cluster begins at the first point
# loses only: counts_from_one, takes_the_smallest, test_every_point
# says: begin at 0
# told: at the first point
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(1, len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: no cluster begins at the last point
# loses only: counts_from_one, takes_the_smallest, test_every_point
# says: go to the last
# told: at the last point
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz) - 1):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: empties the caller's intensities
# loses only: leaves_its_input, test_input
# says: changed its input
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.flatnonzero((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    cloud[:, 3:] = 0
    return labels

# %% wrong: a mask in the queue
# loses: separates_groups, test_course_cloud
# says: np.flatnonzero(mask) lists the numbers
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = (distance < threshold) & (labels == 0)
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels

# %% wrong: np.where gives a tuple
# loses: separates_groups, test_course_cloud
# says: np.flatnonzero gives the array itself
def euclidean_clustering(cloud, threshold=0.5):
    xyz = cloud[:, :3]
    labels = np.zeros(len(xyz), dtype=int)
    cluster = 0
    for start in range(len(xyz)):
        if labels[start] > 0:
            continue
        cluster += 1
        labels[start] = cluster
        waiting = deque([start])
        while waiting:
            distance = np.linalg.norm(xyz - xyz[waiting.popleft()], axis=1)
            newcomers = np.where((distance < threshold) & (labels == 0))
            labels[newcomers] = cluster
            waiting.extend(newcomers)
    return labels
