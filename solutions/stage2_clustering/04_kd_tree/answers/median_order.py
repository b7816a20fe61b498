# Answers to median_order of lesson 04; see grader/course/kept_answers.py.

# %% right: the hints followed to the letter
def median_order(points):
    order = []
    parts = [(np.arange(len(points)), 0)]
    while parts:
        rows, depth = parts.pop()
        if len(rows) == 0:
            continue
        axis = depth % points.shape[1]
        values = points[rows, axis]
        rows = rows[np.argsort(values)]
        m = (len(rows) - 1) // 2
        order.append(rows[m])
        parts.append((rows[:m], depth + 1))
        parts.append((rows[m + 1:], depth + 1))
    return order

# %% right: a function that calls itself
def median_order(points, rows=None, depth=0):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
    m = (len(rows) - 1) // 2
    return [rows[m]] + median_order(points, rows[:m], depth + 1) \
        + median_order(points, rows[m + 1:], depth + 1)

# %% right: level by level, an array back
def median_order(points):
    points = np.array(points, dtype=float)
    order, parts, axis = [], [np.arange(len(points))], 0
    while parts:
        halves = []
        for part in parts:
            if not part.size:
                continue
            part = part[np.lexsort((part, points[part, axis]))]
            middle = (part.size - 1) // 2
            order.append(part[middle])
            halves += [part[:middle], part[middle + 1:]]
        parts, axis = halves, (axis + 1) % points.shape[1]
    return np.array(order, dtype=np.int64)

# %% right: plain Python lists and sorted
def median_order(points):
    rows_of = [list(map(float, row)) for row in points]
    order = []

    def take(rows, depth):
        if rows:
            axis = depth % len(rows_of[0])
            rows = sorted(rows, key=lambda row: rows_of[row][axis])
            half = (len(rows) + 1) // 2 - 1
            order.append(rows[half])
            take(rows[half + 1:], depth + 1)
            take(rows[:half], depth + 1)

    take(list(range(len(points))), 0)
    return order

# %% right: statistics.median_low, a tuple back, printing
from statistics import median_low

def median_order(points):
    print("ordering", len(points), "points")
    k = points.shape[1]
    result, stack = [], [(list(range(len(points))), 0)]
    while stack:
        rows, axis = stack.pop()
        if not rows:
            continue
        low = median_low([points[r, axis] for r in rows])
        top = next(r for r in rows if points[r, axis] == low)
        result.append(top)
        rest = [r for r in rows if r != top]
        following = (axis + 1) % k
        stack.append(([r for r in rest if points[r, axis] < low], following))
        stack.append(([r for r in rest if points[r, axis] >= low], following))
    return tuple(result)

# %% right: np.argpartition and a class
class Halver:
    def __init__(self, points):
        self.points, self.order = np.asarray(points, dtype=np.float64), []

    def halve(self, rows, depth):
        if len(rows) == 0:
            return
        along = self.points[rows, depth % self.points.shape[1]]
        m = (len(rows) - 1) // 2
        rows = rows[np.argpartition(along, m)]
        self.order.append(float(rows[m]))
        self.halve(rows[:m], depth + 1)
        self.halve(rows[m + 1:], depth + 1)
# ---- another cell ----
def median_order(points):
    halver = Halver(points)
    halver.halve(np.arange(len(points)), 0)
    return [int(row) for row in halver.order]

# %% wrong: the upper median
# loses only: takes_the_lower, test_lower_medians
# says: not the lower median
# told: the upper one comes first
def median_order(points, rows=None, depth=0):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
    m = len(rows) // 2
    return [rows[m]] + median_order(points, rows[:m], depth + 1) \
        + median_order(points, rows[m + 1:], depth + 1)

# %% wrong: always along x
# loses only: takes_turns, takes_the_lower, takes_three_axes, least_depth, test_depth, test_medians, test_lower_medians, test_median_extremes
# says: along y
# told: x decides in every part
def median_order(points, rows=None):
    if rows is None:
        rows = np.argsort(points[:, 0])
    if len(rows) == 0:
        return []
    m = (len(rows) - 1) // 2
    return [rows[m]] + median_order(points, rows[:m]) + median_order(points, rows[m + 1:])

# %% wrong: places within the part instead of rows
# loses: names_every_row, least_depth, test_depth
# says: exactly once
def median_order(points):
    order, parts = [], [(np.arange(len(points)), 0)]
    while parts:
        rows, depth = parts.pop()
        if len(rows) == 0:
            continue
        rows = np.argsort(points[rows, depth % points.shape[1]])
        m = (len(rows) - 1) // 2
        order.append(rows[m])
        parts += [(rows[:m], depth + 1), (rows[m + 1:], depth + 1)]
    return order

# %% wrong: sorted by x
# loses: starts_with_the_median, halves_every_part, least_depth, test_depth, test_medians
# says: not the median along x
# told: sorted by x, and that is all
def median_order(points):
    return np.argsort(points[:, 0])

# %% wrong: returns the points
# loses: names_every_row, test_depth
# says: row numbers
def median_order(points, depth=0):
    if len(points) == 0:
        return []
    points = points[np.argsort(points[:, depth % points.shape[1]])]
    m = (len(points) - 1) // 2
    return [points[m]] + median_order(points[:m], depth + 1) \
        + median_order(points[m + 1:], depth + 1)

# %% wrong: the median itself is handed on and comes again
# loses: names_every_row, test_depth
# says: exactly once
def median_order(points):
    order, parts = [], [(np.arange(len(points)), 0)]
    while parts:
        rows, depth = parts.pop()
        if len(rows) == 0:
            continue
        rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
        m = (len(rows) - 1) // 2
        order.append(rows[m])
        if len(rows) > 1:
            parts += [(rows[:m], depth + 1), (rows[m:], depth + 1)]
        if depth > 30:
            break
    return order

# %% wrong: two dimensions are written into the function
# loses only: takes_three_axes, test_depth[space, test_medians[three, test_medians_of_street
# says: along z
# told: z is left out
def median_order(points, rows=None, depth=0):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % 2])]
    m = (len(rows) - 1) // 2
    return [rows[m]] + median_order(points, rows[:m], depth + 1) \
        + median_order(points, rows[m + 1:], depth + 1)

# %% wrong: children before their parent
# loses: starts_with_the_median, halves_every_part, test_medians
# says: not the median
# told: stands between its two parts
def median_order(points, rows=None, depth=0):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
    m = (len(rows) - 1) // 2
    return median_order(points, rows[:m], depth + 1) + [rows[m]] \
        + median_order(points, rows[m + 1:], depth + 1)

# %% wrong: the worksheet's order, the largest first
# loses: starts_with_the_median, least_depth, test_depth, test_medians
# says: not the median
# told: the largest first
def median_order(points):
    return np.argsort(-points[:, 0])

# %% wrong: sorts its input
# loses only: leaves_its_input, test_median_input
# says: changed its input
def median_order(points):
    again = points.copy()
    order = []

    def take(rows, depth):
        if len(rows):
            rows = rows[np.argsort(again[rows, depth % again.shape[1]])]
            m = (len(rows) - 1) // 2
            order.append(rows[m])
            take(rows[:m], depth + 1)
            take(rows[m + 1:], depth + 1)

    take(np.arange(len(points)), 0)
    if points.flags.writeable:
        points.sort(axis=0)
    return order

# %% wrong: fails without points
# loses only: takes_the_smallest
# says: of nothing there is none
def median_order(points):
    def take(rows, depth):
        rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
        m = (len(rows) - 1) // 2
        order = [rows[m]]
        if m > 0:
            order += take(rows[:m], depth + 1)
        if m + 1 < len(rows):
            order += take(rows[m + 1:], depth + 1)
        return order
    return take(np.arange(len(points)), 0)

# %% wrong: the median comes after its halves
# loses: starts_with_the_median, halves_every_part, test_halves, test_medians
# says: not the median
# told: stands after its two parts
def median_order(points, rows=None, depth=0):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
    m = (len(rows) - 1) // 2
    return median_order(points, rows[:m], depth + 1) \
        + median_order(points, rows[m + 1:], depth + 1) + [rows[m]]

# %% wrong: the first axis is y
# loses: starts_with_the_median, takes_turns, least_depth, test_medians
# says: not the median along x
# told: The turns begin with y
def median_order(points, rows=None, depth=1):
    if rows is None:
        rows = np.arange(len(points))
    if len(rows) == 0:
        return []
    rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
    m = (len(rows) - 1) // 2
    return [rows[m]] + median_order(points, rows[:m], depth + 1) \
        + median_order(points, rows[m + 1:], depth + 1)

# %% wrong: parts by comparing, so that equal points are lost
# loses only: takes_equal_points
# says: exactly once
def median_order(points):
    order, parts = [], [(np.arange(len(points)), 0)]
    while parts:
        rows, depth = parts.pop()
        if len(rows) == 0:
            continue
        along = points[rows, depth % points.shape[1]]
        middle = np.sort(along)[(len(rows) - 1) // 2]
        order.append(rows[along == middle][0])
        parts += [(rows[along < middle], depth + 1), (rows[along > middle], depth + 1)]
    return order

# %% wrong: forgets to return
# loses: names_every_row, takes_the_smallest, test_depth
# says: returned None
def median_order(points):
    order, parts = [], [(np.arange(len(points)), 0)]
    while parts:
        rows, depth = parts.pop()
        if len(rows):
            rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
            m = (len(rows) - 1) // 2
            order.append(rows[m])
            parts += [(rows[:m], depth + 1), (rows[m + 1:], depth + 1)]

# %% wrong: the median first and the rest as it came
# loses: halves_every_part, takes_turns, least_depth, test_halves, test_depth
# says: In a part at depth 1
def median_order(points):
    if len(points) == 0:
        return []
    first = np.argsort(points[:, 0])[(len(points) - 1) // 2]
    return [first] + [row for row in range(len(points)) if row != first]

# %% wrong: the order of arrival
# loses: starts_with_the_median, halves_every_part, least_depth, test_depth, test_medians
# says: not the median along x
# told: in the order in which they came
def median_order(points):
    return list(range(len(points)))

# %% wrong: stub left in place
# loses: names_every_row, least_depth, test_depth
# says: is not started
def median_order(points):
    raise NotImplementedError

# %% wrong: the depth grows on the left only
# loses: halves_every_part, test_medians
# says: Both parts wait with depth + 1
# told: The rows after a median
def median_order(points):
    order, waiting = [], [(np.arange(len(points)), 0)]
    while waiting:
        rows, depth = waiting.pop()
        if len(rows) == 0:
            continue
        rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
        middle = (len(rows) - 1) // 2
        order.append(int(rows[middle]))
        waiting += [(rows[:middle], depth + 1), (rows[middle + 1:], depth)]
    return order

# %% wrong: ends at the first part without rows
# loses: names_every_row, test_medians
# says: is skipped, and ends nothing
def median_order(points):
    order, waiting = [], [(np.arange(len(points)), 0)]
    while waiting:
        rows, depth = waiting.pop()
        if len(rows) == 0:
            break
        rows = rows[np.argsort(points[rows, depth % points.shape[1]])]
        middle = (len(rows) - 1) // 2
        order.append(int(rows[middle]))
        waiting += [(rows[:middle], depth + 1), (rows[middle + 1:], depth + 1)]
    return order
