# Answers to get_bounding_boxes; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels)
    names = names[names > 0]
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        for k in range(8):
            boxes[row, k] = [high[0] if k & 1 else low[0], high[1] if k & 2 else low[1],
                             high[2] if k & 4 else low[2]]
    return boxes

# %% right: lists of lists, corners cyclic
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in sorted(set(cluster_labels.tolist()) - {0}):
        x, y, z = zip(*[row[:3] for row, label in zip(cloud.tolist(), cluster_labels)
                        if label == name])
        around = [(min(x), min(y)), (max(x), min(y)), (max(x), max(y)), (min(x), max(y))]
        boxes.append([[a, b, c] for c in (min(z), max(z)) for a, b in around])
    return boxes

# %% right: itertools.product in single precision, with a helper in another cell
from itertools import product

def corners_of(points):
    return list(product(*zip(points.max(axis=0), points.min(axis=0))))
# ---- another cell ----
def get_bounding_boxes(cloud, cluster_labels):
    xyz = np.asarray(cloud, dtype=np.float32)[:, :3]
    found = [corners_of(xyz[cluster_labels == k]) for k in np.unique(cluster_labels) if k > 0]
    return np.array(found, dtype=np.float32).reshape(len(found), 8, 3)

# %% right: sort by label and reduce, no loop
def get_bounding_boxes(cloud, cluster_labels):
    order = np.argsort(cluster_labels, kind="stable")
    order = order[cluster_labels[order] > 0]
    if len(order) == 0:
        return np.zeros((0, 8, 3))
    xyz, sorted_labels = cloud[order, :3], cluster_labels[order]
    start = np.r_[0, np.flatnonzero(np.diff(sorted_labels)) + 1]
    low = np.minimum.reduceat(xyz, start, axis=0)
    high = np.maximum.reduceat(xyz, start, axis=0)
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return low[:, None] + bits * (high - low)[:, None]

# %% right: a dictionary of running extremes, printing and warning
import warnings

def get_bounding_boxes(cloud, cluster_labels):
    warnings.warn("slow")
    extremes = {}
    for point, label in zip(cloud[:, :3], cluster_labels):
        if label <= 0:
            continue
        low, high = extremes.get(label, (point, point))
        extremes[label] = np.minimum(low, point), np.maximum(high, point)
    print(len(extremes), "boxes")
    boxes = np.empty((len(extremes), 8, 3))
    for row, label in enumerate(sorted(extremes)):
        low, high = extremes[label]
        boxes[row] = np.array(np.meshgrid(*zip(low, high), indexing="ij")).reshape(3, 8).T
    return boxes

# %% right: elif, started from the first point
class Box:
    def __init__(self, point):
        self.low, self.high = list(point), list(point)

    def add(self, point):
        for axis in range(3):
            if point[axis] < self.low[axis]:
                self.low[axis] = point[axis]
            elif point[axis] > self.high[axis]:
                self.high[axis] = point[axis]

    def corners(self):
        ends = (self.low, self.high)
        return [[ends[a][0], ends[b][1], ends[c][2]] for a in (1, 0) for b in (1, 0)
                for c in (0, 1)]

def get_bounding_boxes(cloud, cluster_labels):
    boxes = {}
    for row, label in zip(cloud, cluster_labels):
        if label > 0 and label not in boxes:
            boxes[label] = Box(row[:3])
        if label > 0:
            boxes[label].add(row[:3])
    return np.array([boxes[label].corners() for label in sorted(boxes)]).reshape(-1, 8, 3)

# %% wrong: minimum and maximum with elif
# loses only: takes_points_in_any_order, takes_few_points, test_any_order_of_points, test_few_points
# says: Both questions must be asked of every point
# told: `elif` asks about the maximum
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        low, high = [np.inf] * 3, [-np.inf] * 3
        for point in cloud[cluster_labels == name]:
            for axis in range(3):
                if point[axis] < low[axis]:
                    low[axis] = point[axis]
                elif point[axis] > high[axis]:
                    high[axis] = point[axis]
        for k in range(8):
            boxes[row, k] = [high[a] if k & 2**a else low[a] for a in range(3)]
    return boxes

# %% wrong: minimum and maximum started at zero
# loses only: starts_anywhere, takes_few_points, test_anywhere, test_course_scan, test_fresh_street, test_any_order_of_points, test_few_points
# says: Start from the first point
# told: Minimum and maximum start at 0
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        low, high = np.zeros(3), np.zeros(3)
        for point in cloud[cluster_labels == name, :3]:
            low, high = np.minimum(low, point), np.maximum(high, point)
        for k in range(8):
            boxes[row, k] = [high[a] if k & 2**a else low[a] for a in range(3)]
    return boxes

# %% wrong: a box around label 0, too
# loses only: leaves_noise_alone, takes_nothing, test_noise, test_none, test_course_scan, test_fresh_street
# says: 4 boxes for 3 clusters
# told: Label 0 gets a box
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: counts labels from 1 to the largest, gaps or not
# loses only: allows_gaps, test_gaps, test_course_scan, test_fresh_street
# says: raised ValueError
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in range(1, cluster_labels.max(initial=0) + 1):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: range stops before the last label
# loses: reaches_from_min_to_max, one_box_for_each_label, test_course_scan
# says: 0 boxes for 1 cluster
# told: The last label gets no box
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in range(1, cluster_labels.max(initial=0)):
        points = cloud[cluster_labels == name, :3]
        if len(points) == 0:
            continue
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: boxes in order of first appearance
# loses only: follows_the_labels, test_order_of_labels, test_course_scan, test_fresh_street
# says: right boxes in another order
# told: in which the labels first occur
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in dict.fromkeys(cluster_labels.tolist()):
        if name == 0:
            continue
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: two corners only
# loses: reaches_from_min_to_max, test_fresh_street
# says: 2 corners for each box; a box has 8
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    return np.array([[cloud[cluster_labels == k, :3].min(axis=0),
                      cloud[cluster_labels == k, :3].max(axis=0)] for k in names]
                    ).reshape(-1, 2, 3)

# %% wrong: corners in columns
# loses: reaches_from_min_to_max, test_fresh_street
# says: each corner must be a row
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 3, 8))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        for k in range(8):
            boxes[row, :, k] = [high[a] if k & 2**a else low[a] for a in range(3)]
    return boxes

# %% wrong: an empty road gives shape (0,)
# loses only: takes_nothing, test_none
# says: the array keeps its form
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes)

# %% wrong: bits of x and y confused, some corners twice
# loses: reaches_from_min_to_max, test_course_scan
# says: some corners twice and others not at all
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        for k in range(8):
            boxes[row, k] = [high[0] if k & 1 else low[0], high[1] if k & 3 else low[1],
                             high[2] if k & 4 else low[2]]
    return boxes

# %% wrong: one maximum for all axes
# loses: reaches_from_min_to_max, test_course_scan
# says: has other ends along
# told: axis=0 is missing
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(), points.max()
        for k in range(8):
            boxes[row, k] = [high if k & 2**a else low for a in range(3)]
    return boxes

# %% wrong: intensity in the corners
# loses only: ignores_intensity, test_intensity, test_course_scan, test_fresh_street
# says: leave the intensity out
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, cloud.shape[1]))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name]
        low, high = points.min(axis=0), points.max(axis=0)
        for k in range(8):
            boxes[row, k] = [high[a] if k & 2**a else low[a] for a in range(cloud.shape[1])]
    return boxes

# %% wrong: mean and two standard deviations
# loses: reaches_from_min_to_max, test_course_scan
# says: has other ends along
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        points = cloud[cluster_labels == name, :3]
        low = points.mean(axis=0) - 2 * points.std(axis=0)
        high = points.mean(axis=0) + 2 * points.std(axis=0)
        for k in range(8):
            boxes[row, k] = [high[a] if k & 2**a else low[a] for a in range(3)]
    return boxes

# %% wrong: labels changed in place
# loses only: leaves_its_input, test_input
# says: changed its input
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    while cluster_labels.max(initial=0) > 0:
        name = cluster_labels[cluster_labels > 0].min()
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
        cluster_labels[cluster_labels == name] = 0
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: parameters renamed
# loses only: keeps_the_names
# says: another name
def get_bounding_boxes(points, labels):
    boxes = []
    for name in np.unique(labels[labels > 0]):
        chosen = points[labels == name, :3]
        low, high = chosen.min(axis=0), chosen.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: zeros of the right shape
# loses: reaches_from_min_to_max, leaves_noise_alone, leaves_its_input, takes_nothing, test_course_scan, test_few_points, test_many
# says: has other ends along
def get_bounding_boxes(cloud, cluster_labels):
    return np.zeros((len(np.unique(cluster_labels[cluster_labels > 0])), 8, 3))

# %% wrong: one box around everything
# loses: one_box_for_each_label, test_course_scan, test_fresh_street
# says: box for
def get_bounding_boxes(cloud, cluster_labels):
    low, high = cloud[:, :3].min(axis=0), cloud[:, :3].max(axis=0)
    return np.array([[[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)]])

# %% wrong: stub left in place
# loses: reaches_from_min_to_max, test_course_scan, takes_nothing
# says: is not started
def get_bounding_boxes(cloud, cluster_labels):
    raise NotImplementedError

# %% wrong: elif, the maximum first
# loses only: takes_points_in_any_order, takes_few_points, test_any_order_of_points, test_few_points
# says: Both questions must be asked of every point
# told: `elif` asks about the minimum
def get_bounding_boxes(cloud, cluster_labels):
    names = np.unique(cluster_labels[cluster_labels > 0])
    boxes = np.zeros((len(names), 8, 3))
    for row, name in enumerate(names):
        low, high = [np.inf] * 3, [-np.inf] * 3
        for point in cloud[cluster_labels == name]:
            for axis in range(3):
                if point[axis] > high[axis]:
                    high[axis] = point[axis]
                elif point[axis] < low[axis]:
                    low[axis] = point[axis]
        for k in range(8):
            boxes[row, k] = [high[a] if k & 2**a else low[a] for a in range(3)]
    return boxes

# %% wrong: only the maximum started at zero
# loses: starts_anywhere, test_anywhere, test_course_scan, test_fresh_street
# says: Start from the first point
# told: The maximum starts at 0
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        low, high = np.full(3, np.inf), np.zeros(3)
        for point in cloud[cluster_labels == name, :3]:
            low, high = np.minimum(low, point), np.maximum(high, point)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: started once for all labels
# loses: one_box_for_each_label, test_course_scan, test_many
# says: has other ends along x
# told: not started afresh
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        for point in cloud[cluster_labels == name, :3]:
            low, high = np.minimum(low, point), np.maximum(high, point)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: first and 99th percentile
# loses: reaches_from_min_to_max, test_course_scan
# says: has other ends along
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        low, high = np.percentile(cloud[cluster_labels == name, :3], [1, 99], axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: the corners from three nested loops, as the text offers
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1])
                      for x in (low[0], high[0])])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: returns after the first box
# loses: one_box_for_each_label, test_course_scan
# says: ends too early
# told: Only the first label
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
        return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: drops the first label, be it 0 or not
# loses: reaches_from_min_to_max, one_box_for_each_label, test_gaps
# says: noise need not occur
# told: The first label is left out
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels)[1:]:
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: sorts the labels alone
# loses: follows_the_labels, leaves_its_input, test_course_scan, test_input
# says: a sorted list beside them
# told: The labels are sorted
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    cluster_labels.sort()
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: all points in every box
# loses: one_box_for_each_label, test_course_scan
# says: with that label alone
# told: All points count
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[:, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: one maximum alone for all axes
# loses: reaches_from_min_to_max, test_course_scan
# says: other ends along y
# told: One maximum serves
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), np.full(3, points.max())
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: empties the rows of noise
# loses only: leaves_its_input, test_input
# says: changed its input
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    cloud[cluster_labels == 0] = 0
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: gives noise another label
# loses only: leaves_its_input, test_input
# says: changed its input
def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    cluster_labels[cluster_labels == 0] = -1
    return np.array(boxes).reshape(-1, 8, 3)
