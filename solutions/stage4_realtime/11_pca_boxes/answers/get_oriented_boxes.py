# Answers to get_oriented_boxes; see grader/course/kept_answers.py. The stub of principal_axes stands above
# them, so those that use it bring their own.

# %% right: the hints to the letter, principal axes in the plane
def principal_axes(points):
    q = points[:, :3] - points[:, :3].mean(axis=0)
    axes = np.linalg.eigh(q.T @ q)[1][:, ::-1].copy()
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return axes
# ---- another cell ----
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        first = principal_axes(points * [1, 1, 0])[:, 0]
        yaw = np.arctan2(first[1], first[0])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        floor = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
        corners = np.array([[x, y, z] for z in (low[2], high[2]) for x, y in floor])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: the smallest rectangle, trying whole degrees, single precision
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3].astype(np.float32)
        best = None
        for angle in np.radians(np.arange(90)):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            local = points[:, :2] @ turn
            low, high = local.min(axis=0), local.max(axis=0)
            area = np.prod(high - low)
            if best is None or area < best[0]:
                best = area, turn, low, high
        _, turn, low, high = best
        around = np.array([[low[0], low[1]], [low[0], high[1]], [high[0], high[1]],
                           [high[0], low[1]]]) @ turn.T
        boxes.append([[x, y, z] for z in (points[:, 2].min(), points[:, 2].max())
                      for x, y in around])
    return np.array(boxes, dtype=np.float32).reshape(len(boxes), 8, 3)

# %% right: the hints to the letter, the smallest rectangle
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        angles = np.radians(np.arange(90))
        yaw = angles[np.argmin(floor_area_at(points, angles))]
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = []
        for z in (low[2], high[2]):
            corners.append([low[0], low[1], z])
            corners.append([high[0], low[1], z])
            corners.append([high[0], high[1], z])
            corners.append([low[0], high[1], z])
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: the hints to the letter, the closest rectangle
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        angles = np.radians(np.arange(90))
        yaw = angles[np.argmax(closeness_at(points, angles))]
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = []
        for z in (low[2], high[2]):
            corners.append([low[0], low[1], z])
            corners.append([high[0], low[1], z])
            corners.append([high[0], high[1], z])
            corners.append([low[0], high[1], z])
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: one angle after another, from -45 to 45 degrees in halves
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for label in sorted(set(cluster_labels.tolist()) - {0}):
        points = cloud[cluster_labels == label]
        yaw = min(np.radians(np.arange(-45, 45, 0.5)), key=lambda one: floor_area_at(points, one))
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = [(x, y, z) for z in (low[2], high[2])
                   for x, y in ((low[0], low[1]), (low[0], high[1]),
                                (high[0], high[1]), (high[0], low[1]))]
        boxes.append(turned(np.array(corners), yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: covariance by hand in plain Python, corners in binary order, lists back
import math

def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in sorted(set(cluster_labels.tolist())):
        if name <= 0:
            continue
        rows = [row[:3] for row, label in zip(cloud.tolist(), cluster_labels) if label == name]
        n = len(rows)
        mx, my = sum(r[0] for r in rows) / n, sum(r[1] for r in rows) / n
        sxx = sum((r[0] - mx) ** 2 for r in rows)
        syy = sum((r[1] - my) ** 2 for r in rows)
        sxy = sum((r[0] - mx) * (r[1] - my) for r in rows)
        yaw = 0.5 * math.atan2(2 * sxy, sxx - syy)
        c, s = math.cos(yaw), math.sin(yaw)
        along = [c * (r[0] - mx) + s * (r[1] - my) for r in rows]
        across = [-s * (r[0] - mx) + c * (r[1] - my) for r in rows]
        box = []
        for k in range(8):
            a = max(along) if k & 1 else min(along)
            b = max(across) if k & 2 else min(across)
            z = max(r[2] for r in rows) if k & 4 else min(r[2] for r in rows)
            box.append([mx + c * a - s * b, my + s * a + c * b, z])
        boxes.append(box)
    return boxes

# %% right: edges of the convex hull, a plain box where there is none
from scipy.spatial import ConvexHull, QhullError

def get_oriented_boxes(cloud, cluster_labels):
    print("rotating calipers")
    boxes = []
    for name in np.unique(cluster_labels):
        if name == 0:
            continue
        points = np.asarray(cloud[cluster_labels == name, :3], dtype=float)
        try:
            hull = points[ConvexHull(points[:, :2]).vertices, :2]
            edges = np.roll(hull, -1, axis=0) - hull
            angles = np.arctan2(edges[:, 1], edges[:, 0])
        except (QhullError, ValueError):
            angles = [0.0]
        best = min(angles, key=lambda a: np.prod(np.ptp(turned(points, -a)[:, :2], axis=0)))
        local = turned(points, -best)
        low, high = local.min(axis=0), local.max(axis=0)
        x, y = [low[0], high[0], high[0], low[0]], [low[1], low[1], high[1], high[1]]
        corners = np.column_stack([x * 2, y * 2, [low[2]] * 4 + [high[2]] * 4])
        boxes.append(turned(corners, best))
    return np.array(boxes).reshape(-1, 8, 3)

# %% right: an L-shape fitted by closeness
class LShape:
    def __init__(self, xy):
        self.xy = xy

    def in_frame(self, yaw):
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        return self.xy @ turn, turn

    def closeness(self, yaw):
        local, _ = self.in_frame(yaw)
        near = np.minimum(local - local.min(axis=0), local.max(axis=0) - local).min(axis=1)
        return np.sum(1 / np.maximum(near, 0.05))

def get_oriented_boxes(cloud, cluster_labels):
    boxes = np.zeros((len(set(cluster_labels[cluster_labels > 0].tolist())), 8, 3))
    for row, name in enumerate(sorted(set(cluster_labels[cluster_labels > 0].tolist()))):
        points = cloud[cluster_labels == name, :3]
        fit = LShape(points[:, :2])
        yaw = max(np.radians(np.arange(90)), key=fit.closeness)
        local, turn = fit.in_frame(yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        around = np.array([low, [high[0], low[1]], high, [low[0], high[1]]]) @ turn.T
        boxes[row, :, :2] = np.vstack([around, around])
        boxes[row, :4, 2], boxes[row, 4:, 2] = points[:, 2].min(), points[:, 2].max()
    return boxes

# %% right: the roof first, corners in zigzag, a heading by halving
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        x, y = (points[:, :2] - points[:, :2].mean(axis=0)).T
        yaw = np.angle(np.mean((x + 1j * y) ** 2)) / 2
        local = turned(points, -yaw)
        (x, y, z), (to_x, to_y, to_z) = local.min(axis=0), local.max(axis=0)
        corners = np.array([(a, b, c) for c in (to_z, z) for a in (x, to_x) for b in (y, to_y)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the yaw of the first axis in space
# loses only: looks_from_above, test_tall_things
# says: is not turned with its cluster
import warnings

def get_oriented_boxes(cloud, cluster_labels):
    warnings.warn("three dimensions are one too many")
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points - points.mean(axis=0)
        first = np.linalg.eigh(q.T @ q)[1][:, 2]
        u = first[:2] / np.hypot(*first[:2]) if np.hypot(*first[:2]) > 1e-6 else np.array([1., 0])
        v = np.array([-u[1], u[0]])
        a, b, z = points[:, :2] @ u, points[:, :2] @ v, points[:, 2]
        boxes.append([np.append(i * u + j * v, k) for k in (z.max(), z.min())
                      for i, j in ((a.min(), b.min()), (a.max(), b.min()), (a.max(), b.max()),
                                   (a.min(), b.max()))])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: axis-aligned boxes as in lesson 08
# loses only: turns_with_the_cluster, is_no_larger_than_needed, looks_from_above, test_any_heading, test_scanned_vehicles, test_tall_things, test_fresh_street
# says: is not turned with its cluster
# told: The boxes are not turned at all
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        low, high = points.min(axis=0), points.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: a box in space, flattened afterwards
# loses: looks_from_above, test_fresh_street, test_tall_things
# says: does not contain all of its points
from scipy.spatial.transform import Rotation

def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points - points.mean(axis=0)
        axes = np.linalg.eigh(q.T @ q)[1][:, ::-1].copy()
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        turn = Rotation.from_matrix(axes)
        own = turn.inv().apply(points)
        size, middle = np.ptp(own, axis=0), turn.apply((own.max(axis=0) + own.min(axis=0)) / 2)
        upright = Rotation.from_euler("Z", turn.as_euler("ZYX")[0])
        half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size[:2]
        flat = upright.apply(np.column_stack([half, np.zeros(4)])) + middle
        floor, roof = flat.copy(), flat.copy()
        floor[:, 2], roof[:, 2] = points[:, 2].min(), points[:, 2].max()
        boxes.append(np.vstack([floor, roof]))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the box leans with its points
# loses: stands_upright, test_scanned_vehicles, test_upright
# says: is tilted
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points - points.mean(axis=0)
        axes = np.linalg.eigh(q.T @ q)[1][:, ::-1]
        own = points @ axes
        low, high = own.min(axis=0), own.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(corners @ axes.T)
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: corners turned back the wrong way
# loses: contains_all_points, turns_with_the_cluster, looks_from_above, test_any_heading
# says: does not contain all of its points
# told: they must be turned back
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        _, axes = np.linalg.eigh(np.atleast_2d(np.cov(points[:, :2].T, bias=True)))
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, -yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: turned by plus yaw first, then by minus yaw
# loses only: turns_with_the_cluster, is_no_larger_than_needed, looks_from_above, test_any_heading, test_scanned_vehicles, test_tall_things, test_fresh_street
# says: is not turned with its cluster
# told: built for minus the heading
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, -yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: yaw in degrees
# loses: turns_with_the_cluster, test_any_heading
# says: The yaw, in radians
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.degrees(np.arctan2(axes[1, 1], axes[0, 1]))
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: arctan2 with x and y swapped
# loses: turns_with_the_cluster, test_any_heading
# says: is not turned with its cluster
# told: built for minus the heading
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[0, 1], axes[1, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: a row of the axes taken for a column
# loses: turns_with_the_cluster, test_any_heading
# says: is not turned with its cluster
# told: built for minus the heading
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 0], axes[1, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: all points for every label
# loses: contains_all_points, test_fresh_street
# says: the points of one label
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        q = cloud[:, :2] - cloud[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(cloud, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: heading by regression
# loses: turns_with_the_cluster, test_any_heading
# says: is not turned with its cluster
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        yaw = np.arctan(np.polyfit(points[:, 0], points[:, 1], 1)[0]) if len(points) > 2 else 0.0
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: two standard deviations on each side of the mean
# loses: reaches_floor_and_roof, test_any_heading, test_upright
# says: is not at the height of its
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low = local.mean(axis=0) - 2 * local.std(axis=0)
        high = local.mean(axis=0) + 2 * local.std(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: percentiles leave points outside
# loses: contains_all_points, test_any_heading, test_scanned_vehicles
# says: does not contain all of its points
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = np.percentile(local, 2, axis=0), np.percentile(local, 98, axis=0)
        low[2], high[2] = local[:, 2].min(), local[:, 2].max()
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the floor is the road, not the lowest point
# loses only: reaches_floor_and_roof, test_upright
# says: The floor of the box of label
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        low[2] = -1.73
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: boxes in order of first appearance
# loses only: follows_the_labels, test_order_of_labels
# says: another order than the labels
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in dict.fromkeys(cluster_labels[cluster_labels > 0].tolist()):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: a convex hull where there is none
# loses: takes_small_clusters, test_round_and_few
# says: QhullError
from scipy.spatial import ConvexHull

def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        hull = points[ConvexHull(points[:, :2]).vertices, :2]
        edges = np.roll(hull, -1, axis=0) - hull
        angles = np.arctan2(edges[:, 1], edges[:, 0])
        yaw = min(angles, key=lambda a: np.prod(np.ptp(turned(points, -a)[:, :2], axis=0)))
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: looks from above by flattening the cloud itself
# loses: leaves_cloud_and_labels, reaches_floor_and_roof
# says: changed its input
def get_oriented_boxes(cloud, cluster_labels):
    heights = cloud[:, 2].copy()
    cloud[:, 2] = 0
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: only the floor
# loses: contains_all_points, test_any_heading
# says: 4 corners for each box; a box has 8
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(4)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 4, 3)

# %% wrong: one huge box for each
# loses: contains_all_points, turns_with_the_cluster, takes_small_clusters, stands_upright, test_any_heading, test_fresh_street, test_round_and_few
# says: covers far more ground
def get_oriented_boxes(cloud, cluster_labels):
    count = len(np.unique(cluster_labels[cluster_labels > 0]))
    corners = [[100 if k & 2**a else -100 for a in range(3)] for k in range(8)]
    return np.tile(np.array(corners, dtype=float), (count, 1, 1))

# %% wrong: zeros of the right shape
# loses: contains_all_points, turns_with_the_cluster, takes_small_clusters, leaves_cloud_and_labels, test_any_heading, test_many, test_none
# says: does not contain all of its points
def get_oriented_boxes(cloud, cluster_labels):
    return np.zeros((len(np.unique(cluster_labels[cluster_labels > 0])), 8, 3))

# %% wrong: stub left in place
# loses: contains_all_points, test_any_heading
# says: is not started
def get_oriented_boxes(cloud, cluster_labels):
    raise NotImplementedError

# %% wrong: turned by plus yaw both times
# loses: contains_all_points, is_no_larger_than_needed, test_any_heading
# says: does not contain all of its points
# told: both turned by plus yaw
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: corners not turned back
# loses: contains_all_points, turns_with_the_cluster, test_any_heading
# says: does not contain all of its points
# told: The corners are not turned back
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        boxes.append([[high[a] if k & 2**a else low[a] for a in range(3)] for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: a box for label 0, too
# loses only: leaves_noise_alone, takes_nothing, test_noise, test_none
# says: 3 boxes for 2 clusters
# told: Label 0 gets a box
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(np.nan_to_num(q.T @ q))
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: an empty road gives shape (0,)
# loses only: takes_nothing, test_none
# says: the array keeps its form
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        q = points[:, :2] - points[:, :2].mean(axis=0)
        _, axes = np.linalg.eigh(q.T @ q)
        yaw = np.arctan2(axes[1, 1], axes[0, 1])
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes)

# %% wrong: the largest rectangle instead of the smallest
# loses only: turns_with_the_cluster, is_no_larger_than_needed, looks_from_above, test_any_heading, test_scanned_vehicles, test_tall_things, test_fresh_street
# says: is not turned with its cluster
# told: the largest that touch their points
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        angles = np.radians(np.arange(90))
        yaw = angles[np.argmax(floor_area_at(points, angles))]
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the number of the smallest area taken for its angle
# loses only: turns_with_the_cluster, is_no_larger_than_needed, looks_from_above, test_any_heading, test_scanned_vehicles, test_tall_things, test_fresh_street
# says: is not turned with its cluster
# told: taken for an angle
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        angles = np.radians(np.arange(90))
        yaw = np.argmin(floor_area_at(points, angles))
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: half of the angles are never tried
# loses: turns_with_the_cluster, test_any_heading
# says: is not turned with its cluster
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        angles = np.radians(np.arange(45))
        yaw = angles[np.argmin(floor_area_at(points, angles))]
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the smallest rectangle, turned by plus yaw both times
# loses: contains_all_points, is_no_larger_than_needed, test_any_heading
# says: does not contain all of its points
# told: both turned by plus yaw
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        angles = np.radians(np.arange(90))
        yaw = angles[np.argmin(floor_area_at(points, angles))]
        local = turned(points, yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(turned(corners, yaw))
    return np.array(boxes).reshape(-1, 8, 3)

# %% wrong: the smallest rectangle, corners not turned back
# loses: contains_all_points, turns_with_the_cluster, test_any_heading
# says: does not contain all of its points
# told: The corners are not turned back
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for name in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == name, :3]
        angles = np.radians(np.arange(90))
        yaw = angles[np.argmin(floor_area_at(points, angles))]
        local = turned(points, -yaw)
        low, high = local.min(axis=0), local.max(axis=0)
        corners = np.array([[high[a] if k & 2**a else low[a] for a in range(3)]
                            for k in range(8)])
        boxes.append(corners)
    return np.array(boxes).reshape(-1, 8, 3)
