# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 13 · Compiled loops
#
# The grid of lesson 10, union-find and the boxes of lesson 11 once more, as plain loops that a compiler turns into machine code: a full scan is clustered, exactly, in a few thousandths of a second.
#
# This lesson is for who wants it. Nothing in it is handed in or graded, and nothing needs it. What you write is checked all the same.
#
# **After this lesson you can**
# - say why a loop is slow in Python and fast when compiled, and what NumPy has to do with it,
# - write what the compiler wants, and know what the first call costs,
# - join groups by union-find, and stop as soon as the answer is known.
#
# **You write** five small functions. **You need** lessons 10 to 12. **Time:** (time)

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A compiler for the asking
#
# *The same text, read by another machine.*
#
# [Numba](https://numba.pydata.org) takes a Python function made of numbers, arrays and loops and compiles it when it is first called. Colab has it. Elsewhere `pip install numba` brings it; the course tests with the version in `requirements-compiled.txt`. Without it this notebook runs the very same lines as plain Python, on one point in forty.

# %%
from time import process_time

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from utils import check, load_cloud, plots, predict, ready

try:
    from numba import njit
except ImportError:
    def njit(function):
        """In place of the compiler: the function as it is."""
        return function

is_compiled = njit.__module__.startswith("numba")
cloud = load_cloud("cloud.txt")[::1 if is_compiled else 40]
points = np.ascontiguousarray(cloud[:, :3])
print(f"{len(points):,} points;", "Numba is here" if is_compiled else
      "Numba is NOT installed: what follows runs as plain Python, hundreds of times as slow")


def milliseconds(function, *arguments, repeats=5):
    """Processor time of a call, the middle one of some."""
    times = []
    for _ in range(repeats):
        begin = process_time()
        function(*arguments)
        times.append(1000 * (process_time() - begin))
    return float(np.median(times))

# %% [markdown]
# ## The naive idea: just write the loop
#
# *Python asks at every step what kind of thing a number is.*
#
# How many points lie within 0.2 m of a plane? RANSAC asks that in each round. As a loop it is seven lines. For each point, Python unpacks objects, looks up what `*` means for them, and packs the result into a new object.
#
# `@njit` above a function has it compiled. **Here the check comes before you try it.** Compiled, a loop without an end hears no stop button, and a row that is not there is read all the same: whatever lies in memory behind the array. So `check` runs your function as plain Python first, and has Numba compile it only when that is right. The cells below wait until it has passed.

# %%
level = np.array([0.0, 0.0, 1.0, 1.73])  # a, b, c, d: the road, if it were level
faster = predict("How many times as fast as the same loop in Python is the compiled one?",
                 choices=["about twice", "about 20 times", "more than 100 times"])

# %% nbgrader={"grade": false, "grade_id": "count_near", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def count_near(points, plane, tolerance):
    """How many points (n, 3) lie within a tolerance of a plane (4,); a loop, point by point."""
    # 1. Start at zero, and go through the numbers of the rows.
    # 2. The distance is |a x + b y + c z + d|, where points[i, 0] is x.
    # 3. Count it if it is at most the tolerance.
    # roughly 7 lines
    ### BEGIN SOLUTION
    count = 0
    for i in range(len(points)):
        distance = abs(plane[0] * points[i, 0] + plane[1] * points[i, 1]
                       + plane[2] * points[i, 2] + plane[3])
        if distance <= tolerance:
            count += 1
    return count
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `for i in range(len(points)):` goes through the numbers of the rows. Inside, `points[i, 0]`, `points[i, 1]` and `points[i, 2]` are the x, y and z of one point: single numbers, no arrays.
# </details>
# <details><summary>Hint 2</summary>
#
# `abs(...)` belongs around the whole sum, three products and `plane[3]`. Below the plane the sum is negative.
# </details>
# <details><summary>Hint 3</summary>
#
# Set the count to 0 before the loop, add 1 in it `if` the distance is `<=` the tolerance, and put `return` after it, as far to the left as `for`.
# </details>

# %%
check(count_near)

# %%
def count_by_numpy(points, plane, tolerance):
    return np.count_nonzero(np.abs(points @ plane[:3] + plane[3]) <= tolerance)


if ready(count_near):
    as_python = getattr(count_near, "py_func", count_near)
    # Compiled once more: `check` has done it before.
    first = milliseconds(njit(as_python), points, level, 0.2, repeats=1)
    same = count_near(points, level, 0.2) == count_by_numpy(points, level, 0.2)
    print(f"first call{', with compiling' * is_compiled}: {first:8.1f} ms; "
          f"{'the same number' if same else 'NOT the same number'} as by NumPy")
    times = {"a loop in Python": 10 * milliseconds(as_python, points[::10], level, 0.2, repeats=1),
             "NumPy": milliseconds(count_by_numpy, points, level, 0.2)}
    if is_compiled:
        times["the loop, compiled"] = milliseconds(count_near, points, level, 0.2)
    for name, spent in times.items():
        print(f"{name:>26}: {spent:8.2f} ms")
    if is_compiled:
        ratio = times["a loop in Python"] / times["the loop, compiled"]
        faster.compare("about twice" if ratio < 6 else "about 20 times" if ratio < 100
                       else "more than 100 times",
                       f"{ratio:,.0f} times. Machine code adds and multiplies numbers; Python "
                       "handles objects that hold them.")

# %% [markdown]
# NumPy is compiled, too. But it does one step for *all* points before the next: products, then sums, then absolute values, then comparisons, and each writes an array to memory that the next reads again. The compiled loop does all steps for a point while it is at hand, and writes nothing.
#
# ## What the compiler wants
#
# *Types that stay what they are.*
#
# Numba looks at the types of the arguments, follows them through the function, and compiles for these. So
#
# - a variable keeps its type: not a number here and `None` there,
# - arrays, numbers, tuples; no dictionaries of this and that, no objects of your own, no `cKDTree`,
# - functions that are called are compiled, too: `@njit` above each,
# - names from outside are read once, when it compiles, and are constants from then on: who changes a function runs the cells of those that call it again, too,
# - other types mean compiling once more: `float32` in place of `float64` costs another first call.
#
# **The first call pays.** It takes about a thousand times as long as the second. `@njit(cache=True)` keeps the machine code on disk for the next start. A car that compiles when the first pedestrian comes is built wrong: call everything once, with a small cloud of the right types, before the engine starts.
#
# What does it say if it cannot?

# %%
@njit
def nearest_or_none(points, limit):
    if points[0, 0] < limit:
        return points[0, 0]
    return "too far"


if is_compiled:
    try:
        nearest_or_none(points, 1.0)
    except Exception as error:
        print(type(error).__name__, "\n" + "\n".join(str(error).splitlines()[:2]))

# %% [markdown]
# Now take the clustering of lesson 10 apart into loops. Three things that NumPy could not do make it shorter and faster: groups are joined *one pair at a time*, a comparison *stops* at the first close pair, and no list of pairs is ever written down.
#
# ## Union-find
#
# *Everybody points at somebody of their own group; who points at themselves is the root.*
#
# Each cell has a parent, itself at first. Following parents leads to a **root**, and two cells are in the same piece if they have the same one. To join two pieces, let the root of one point at the other. On the way to the root, each cell may as well point at its grandparent: so paths stay short.

# %% nbgrader={"grade": false, "grade_id": "root_of", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def root_of(parent, cell):
    """Follow the parents (m,) of a cell up to its root, and shorten the way for the next time."""
    # 1. While the cell is not its own parent:
    # 2.     let it point at its grandparent, and go there.
    # roughly 4 lines
    ### BEGIN SOLUTION
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return cell
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# A root is its own parent. So the loop goes on `while parent[cell] != cell`, and the cell at which it ends is the answer.
# </details>
# <details><summary>Hint 2</summary>
#
# The grandparent is `parent[parent[cell]]`. In each round do both: write it into `parent[cell]`, and then go there. Without the second half the loop never ends.
# </details>

# %%
check(root_of)

# %% nbgrader={"grade": false, "grade_id": "unite", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def unite(parent, a, b):
    """Join the pieces of two cells: the larger root points at the smaller."""
    # roughly 2 lines
    ### BEGIN SOLUTION
    a, b = root_of(parent, a), root_of(parent, b)
    parent[max(a, b)] = min(a, b)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# What is written is the parent of a *root*. Who changes the parent of another cell takes it away from its piece, with all that hangs on it.
# </details>
# <details><summary>Hint 2</summary>
#
# Ask `root_of` for both roots first. `min` of the two stays a root, and `max` of the two gets it for its parent. Nothing is returned: the array is changed.
# </details>

# %%
check(unite)

# %% [markdown]
# **Try it on seven nodes.** The four pairs of lesson 10 join 0, 2, 4 and 5, and 1 and 3; 6 stays alone.

# %%
if ready(root_of, unite):
    parent = np.arange(7)
    for a, b in ((0, 2), (4, 0), (5, 2), (1, 3)):
        unite(parent, a, b)
    print("roots:", [int(root_of(parent, node)) for node in range(7)],
          "  expected: [0, 1, 0, 1, 0, 0, 6]")

# %% [markdown]
# ## Stop at the first
#
# *The quickest comparison is the one that need not be made.*
#
# Sorted by cell, the points of a cell stand side by side: those of cell a in the rows from `a` up to, but without, `a_end`. Are any two points of two cells closer than the threshold? `limit` is its square, which saves a root for each pair.

# %% nbgrader={"grade": false, "grade_id": "any_close", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def any_close(points, a, a_end, b, b_end, limit):
    """Whether a point in rows a to a_end and one in rows b to b_end are closer than sqrt(limit)."""
    # 1. For each row of the one and each row of the other:
    # 2.     the square of their distance, from three differences.
    # 3.     Below the limit? That is the answer: return it at once.
    # roughly 8 lines
    ### BEGIN SOLUTION
    for i in range(a, a_end):
        for j in range(b, b_end):
            x = points[i, 0] - points[j, 0]
            y = points[i, 1] - points[j, 1]
            z = points[i, 2] - points[j, 2]
            if x * x + y * y + z * z < limit:
                return True
    return False
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# A loop in a loop: `i` in `range(a, a_end)`, and for each of them `j` in `range(b, b_end)`. `range` leaves out its end by itself.
# </details>
# <details><summary>Hint 2</summary>
#
# Three differences, `x = points[i, 0] - ...` and so on; then `x * x + y * y + z * z` against `limit`, without a root.
# </details>
# <details><summary>Hint 3</summary>
#
# `return True` stands inside the `if`, and ends both loops at once. `return False` stands as far to the left as the outer `for`: only after all pairs the answer is no.
# </details>

# %%
check(any_close)

# %%
if ready(any_close):
    row = np.outer([0.0, 0.2, 1.0, 0.6], [1.0, 0.0, 0.0])
    print("rows 0, 1 and 2, 3:", any_close(row, 0, 2, 2, 4, 0.5**2), any_close(row, 0, 2, 2, 4, 0.3**2),
          "  expected: True False")

# %% [markdown]
# **A good place to stop.** All that the compiled clustering needs of you is written. What follows puts it together, and turns to boxes. If you come back later, run all cells above this one first.
#
# ## The grid, sorted
#
# *Numbers can be sorted without comparing any two of them.*
#
# Cells are numbered as in lesson 10, with two empty ones at the end of each column, so that neighbours of one column are never taken for those of the next. To bring the points in their order takes no comparisons: *counting sort* counts how many have each last digit, which tells where each goes; then the same for the digit before. A digit here has 11 bits. These functions are yours to read and use.

# %%
@njit
def ascending(numbers):
    """The rows in which whole numbers from 0 on ascend; equal ones keep their order."""
    n, largest, shift = len(numbers), numbers.max(), 0
    order, other = np.arange(n), np.empty(n, np.int64)
    while largest >> shift:
        place = np.zeros(2049, np.int64)
        for i in range(n):
            place[((numbers[i] >> shift) & 2047) + 1] += 1
        for digit in range(2048):
            place[digit + 1] += place[digit]
        for i in range(n):
            digit = (numbers[order[i]] >> shift) & 2047
            other[place[digit]] = order[i]
            place[digit] += 1
        order, other = other, order
        shift += 11
    return order


@njit
def sort_by_cell(points, side):
    """Sort points into cells.

    Returns
    -------
    order : the rows of the points, cell by cell
    points : the points in that order
    starts : (m + 1,), where each cell begins in that order, and at last where all end
    numbers : (m,), the cells' numbers, ascending
    next_x, next_y : by how much the number grows one cell farther along x and along y
    """
    n = len(points)
    low, high = points[0].copy(), points[0].copy()
    for i in range(n):
        for axis in range(3):
            if not abs(points[i, axis]) < np.inf:  # a wrong row number would crash Python itself
                raise ValueError("Some coordinates are no numbers: drop these rows (lesson 01)")
            low[axis] = min(low[axis], points[i, axis])
            high[axis] = max(high[axis], points[i, axis])
    low, high = np.floor(low / side), np.floor(high / side)
    if (high - low + 6).prod() > 2.0**62:
        raise ValueError("There are more cells than numbers: drop what is far away (lesson 07)")
    next_y = np.int64(high[2] - low[2]) + 5
    next_x = (np.int64(high[1] - low[1]) + 5) * next_y
    number = np.empty(n, np.int64)
    for i in range(n):
        x = np.int64(np.floor(points[i, 0] / side) - low[0])
        y = np.int64(np.floor(points[i, 1] / side) - low[1])
        z = np.int64(np.floor(points[i, 2] / side) - low[2])
        number[i] = x * next_x + y * next_y + z
    order = ascending(number)
    starts, numbers, count = np.empty(n + 1, np.int64), np.empty(n, np.int64), 0
    in_order = np.empty((n, 3))
    for i in range(n):
        for axis in range(3):
            in_order[i, axis] = points[order[i], axis]
        if i == 0 or number[order[i]] != number[order[i - 1]]:
            starts[count], numbers[count] = i, number[order[i]]
            count += 1
    starts[count] = n
    return order, in_order, starts[:count + 1], numbers[:count], next_x, next_y

# %% [markdown]
# The cells at most two steps away lie in 25 columns, of which 13 are enough: each pair need be met only once. As the numbers ascend, so do those of the neighbours, and one finger for each column moves up along with the cell. First the cheap question: a pair for which the answer is no is noted. Then, for those noted that are still apart, the exact one, if the boxes around their points are near enough at all. Where two cells hold thousands of points, a kd-tree is better: such pairs are handed back.

# %%
@njit
def boxes_of(points, starts):
    """Smallest and largest x, y, z of the points of each cell, two arrays (m, 3)."""
    low, high = points[starts[:-1]], points[starts[:-1]]
    for cell in range(len(low)):
        for i in range(starts[cell] + 1, starts[cell + 1]):
            for axis in range(3):
                low[cell, axis] = min(low[cell, axis], points[i, axis])
                high[cell, axis] = max(high[cell, axis], points[i, axis])
    return low, high


@njit
def are_near(low, high, a, b, limit):
    """Whether the boxes of two cells are closer than sqrt(limit)."""
    square = 0.0
    for axis in range(3):
        gap = max(low[a, axis] - high[b, axis], low[b, axis] - high[a, axis], 0.0)
        square += gap * gap
    return square < limit


@njit
def join_cells(points, starts, numbers, next_x, next_y, limit, crowd):
    """Join cells; returns the parents (m,), and pairs of cells too crowded to compare."""
    count, still_open, too_many = len(numbers), [(0, 0)], [(0, 0)]
    parent = np.arange(count)
    for column in range(13):  # (0, 0), (0, 1), (0, 2), (1, -2), ..., (2, 2)
        step = (column + 2) // 5 * next_x + ((column + 2) % 5 - 2) * next_y
        b_first = 0
        for a in range(count):
            middle = numbers[a] + step
            b_first = max(b_first, a + 1)
            while b_first < count and numbers[b_first] < middle - 2:
                b_first += 1
            b = b_first
            while b < count and numbers[b] <= middle + 2:
                if parent[a] != parent[b]:
                    if any_close(points, starts[a], starts[a] + 1, starts[b], starts[b] + 1, limit):
                        unite(parent, a, b)
                    else:
                        still_open.append((a, b))
                b += 1
    low, high = boxes_of(points, starts)
    for cell in range(count):  # now each points at its root, for a while
        parent[cell] = root_of(parent, cell)
    for a, b in still_open[1:]:
        if (parent[a] != parent[b] and root_of(parent, a) != root_of(parent, b)
                and are_near(low, high, a, b, limit)):
            if (starts[a + 1] - starts[a]) * (starts[b + 1] - starts[b]) > crowd:
                too_many.append((a, b))
            elif any_close(points, starts[a], starts[a + 1], starts[b], starts[b + 1], limit):
                unite(parent, a, b)
    return parent, too_many[1:]


@njit
def numbered(parent, order, starts):
    """Labels 1, 2, ... of the points, by first appearance."""
    root, number = np.empty(len(order), np.int64), np.zeros(len(parent), np.int64)
    for cell in range(len(parent)):
        mine = root_of(parent, cell)
        for i in range(starts[cell], starts[cell + 1]):
            root[order[i]] = mine
    labels, last = np.empty(len(order), np.int64), 0
    for i in range(len(order)):
        if number[root[i]] == 0:
            last += 1
            number[root[i]] = last
        labels[i] = number[root[i]]
    return labels


def cluster_compiled(cloud, threshold=0.5):
    """The clusters of lessons 05 and 10, with the same numbers."""
    points = np.ascontiguousarray(cloud[:, :3], dtype=float)
    if not len(points):
        return np.zeros(0, int)
    side = threshold / np.sqrt(3) * (1 - 1e-6)  # a little less, against rounding
    order, points, starts, numbers, next_x, next_y = sort_by_cell(points, side)
    parent, too_many = join_cells(points, starts, numbers, next_x, next_y, threshold**2, 50_000)
    for a, b in too_many:  # heaps of points: lesson 10's way
        if root_of(parent, a) != root_of(parent, b):
            p, q = points[starts[a]:starts[a + 1]], points[starts[b]:starts[b + 1]]
            if np.ptp(p, axis=0).max() > np.ptp(q, axis=0).max():
                p, q = q, p  # the tree around the smaller: sooner asked
            if cKDTree(p).query(q, distance_upper_bound=threshold)[0].min() < threshold:
                unite(parent, a, b)
    return numbered(parent, order, starts)

# %% [markdown]
# **Look before you time.** Are these the clusters, to the last point? `join_all_pairs` of lesson 10 is slow, and sure.

# %%
def join_all_pairs(points, threshold=0.5):
    """The number of each point's cluster, from a list of all pairs of neighbours."""
    pairs = cKDTree(points).query_pairs(threshold, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=2 * (len(points),))
    return connected_components(graph, directed=False)[1]


def same_clusters(labels, others):
    """Whether two labellings group the points alike, whatever the numbers."""
    combinations = np.unique(np.stack([labels, others]), axis=1).shape[1]
    return combinations == len(np.unique(labels)) == len(np.unique(others))


if ready(root_of, unite, any_close):
    obstacles = points[(points[:, 2] > -1.2) & (np.hypot(points[:, 0], points[:, 1]) > 2)]
    labels = cluster_compiled(obstacles)
    same = same_clusters(labels, join_all_pairs(obstacles))
    print(f"{labels.max()} clusters of {len(obstacles):,} points, "
          f"{'the same' if same else 'NOT the same'} as from all pairs")
    plots.clusters(obstacles, labels, limits=((-20, 40), (-15, 15)),
                   title="Clusters by loops and union-find")

# %%
if ready(root_of, unite, any_close):
    for name, some in (("all obstacles", obstacles), ("the whole scan", points)):
        print(f"{name:>15}, {len(some):,} points: {milliseconds(cluster_compiled, some):6.1f} ms")
    two_heaps = np.random.default_rng(1).uniform(0, 0.2, (2, len(points) // 6, 3))
    two_heaps[1, :, 0] += 0.71
    found = cluster_compiled(two_heaps.reshape(-1, 3))
    print(f"two heaps of {len(found) // 2:,} points: {found.max()} clusters, "
          f"{milliseconds(cluster_compiled, two_heaps.reshape(-1, 3)):.1f} ms")

# %% [markdown]
# ## Boxes
#
# *Keep ninety rulers at the points, and read all of them at the end.*
#
# The smallest rectangle of lesson 11 projects all points onto 90 directions and keeps the smallest and the largest along each. NumPy writes the table of all projections; a loop needs the 90 extremes only. (The closest rectangle asks each point for its nearest side, and so goes twice over all of them.) `cosines` and `sines` stand outside: for the compiler they are constants.

# %%
turns = np.radians(np.arange(90))
cosines, sines = np.cos(turns), np.sin(turns)

# %% nbgrader={"grade": false, "grade_id": "snuggest_turn", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def snuggest_turn(points):
    """The number of the turn (0 to 89) at which the rectangle around points has least area."""
    # 1. Four arrays of 90: smallest and largest along each direction, and across it.
    # 2. For each point and each turn: along is x cos + y sin, across is y cos - x sin.
    # 3. The area of each turn is a product of two differences; argmin() finds the least.
    # roughly 12 lines
    ### BEGIN SOLUTION
    back, front = np.full(90, np.inf), np.full(90, -np.inf)
    right, left = np.full(90, np.inf), np.full(90, -np.inf)
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        for turn in range(90):
            along = x * cosines[turn] + y * sines[turn]
            across = y * cosines[turn] - x * sines[turn]
            back[turn], front[turn] = min(back[turn], along), max(front[turn], along)
            right[turn], left[turn] = min(right[turn], across), max(left[turn], across)
    return ((front - back) * (left - right)).argmin()
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Before the first point, the smallest along each direction is `np.inf` and the largest `-np.inf`: `np.full(90, np.inf)` is 90 of them. With zeros our own sensor, at (0, 0), would count as a point of every car.
# </details>
# <details><summary>Hint 2</summary>
#
# Two loops: over the points, and inside over the 90 turns. Inside, `along` and `across` are two numbers, and each of the four arrays keeps, at `[turn]`, what `min` or `max` says of its old value and the new one.
# </details>
# <details><summary>Hint 3</summary>
#
# After both loops, subtract whole arrays: largest minus smallest along, times largest minus smallest across, are 90 areas. `.argmin()` of them is the number of the turn.
# </details>

# %%
check(snuggest_turn)

# %%
if ready(snuggest_turn):
    corners = np.array([[2.0, 1, 0], [-2, 1, 0], [-2, -1, 0], [2, -1, 0]])
    leaning = np.column_stack([corners[:, 0] * cosines[30] - corners[:, 1] * sines[30],
                               corners[:, 0] * sines[30] + corners[:, 1] * cosines[30],
                               corners[:, 2]])
    print("turn of a rectangle that leans by 30°:", snuggest_turn(leaning), "  expected: 30")

# %% [markdown]
# ## The whole detector
#
# *One pass where NumPy makes ten.*
#
# The steps of lesson 12 in loops. Drop, crop and remove become one pass. The rounds of RANSAC count, and keep nothing. The samples are drawn by the same generator as in lesson 03, so that the road is the same.

# %%
@njit
def useful_points(cloud, minimum, maximum, car_low, car_high):
    """x, y, z of the valid returns in the region of interest that do not come from our own car."""
    kept, count = np.empty((len(cloud), 3)), 0
    for i in range(len(cloud)):
        x, y, z = cloud[i, 0], cloud[i, 1], cloud[i, 2]
        inside = (minimum[0] <= x <= maximum[0] and minimum[1] <= y <= maximum[1]
                  and minimum[2] <= z <= maximum[2])  # no comparison with NaN is true
        own = (car_low[0] <= x <= car_high[0] and car_low[1] <= y <= car_high[1]
               and car_low[2] <= z <= car_high[2])
        if inside and not own and (x != 0 or y != 0 or z != 0):
            kept[count, 0], kept[count, 1], kept[count, 2] = x, y, z
            count += 1
    return kept[:count]


@njit
def best_plane(points, samples, tolerance):
    """Of the planes through samples of three rows (k, 3), that with most points near it."""
    best, most = np.zeros(4), 0
    for p, q, r in samples:
        normal = np.cross(points[q] - points[p], points[r] - points[p])
        length = np.sqrt((normal**2).sum())
        if not length > 1e-9:
            continue
        normal /= length
        plane = np.append(normal, -(normal * points[p]).sum())
        count = count_near(points, plane, tolerance)
        if count > most:
            best, most = plane, count
    return best, most


@njit
def away(point, plane):
    """Distance of a point from a plane."""
    return abs(plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3])


@njit
def scatter(points, plane, tolerance):
    """Mean of the points near a plane, and the sums of the products of their deviations."""
    mean, spread, count = np.zeros(3), np.zeros((3, 3)), 0
    for point in points:
        if away(point, plane) <= tolerance:
            for axis in range(3):
                mean[axis] += point[axis]
            count += 1
    mean /= count
    for point in points:
        if away(point, plane) <= tolerance:
            for row in range(3):
                for column in range(3):
                    spread[row, column] += ((point[row] - mean[row])
                                            * (point[column] - mean[column]))
    return mean, spread


@njit
def far_from(points, plane, distance):
    """The points farther than a distance from a plane."""
    kept, count = np.empty((len(points), 3)), 0
    for point in points:
        if away(point, plane) > distance:
            for axis in range(3):
                kept[count, axis] = point[axis]
            count += 1
    return kept[:count]


@njit
def voxel_means(points, side):
    """The mean of the points of each cell."""
    _, points, starts, numbers, _, _ = sort_by_cell(points, side)
    means = np.zeros((len(numbers), 3))
    for cell in range(len(numbers)):
        for axis in range(3):
            for i in range(starts[cell], starts[cell + 1]):
                means[cell, axis] += points[i, axis]
            means[cell, axis] /= starts[cell + 1] - starts[cell]
    return means


@njit
def oriented_boxes(points, labels, least):
    """Boxes (N, 8, 3) around the clusters with at least so many points, in the order of labels."""
    order = ascending(labels)
    boxes, count, first = np.empty((labels.max(), 8, 3)), 0, 0
    for i in range(1, len(order) + 1):
        if i < len(order) and labels[order[i]] == labels[order[first]]:
            continue
        if i - first >= least:
            mine = points[order[first:i]]
            turn = snuggest_turn(mine)
            cosine, sine = cosines[turn], sines[turn]
            along, across = (mine[:, 0] * cosine + mine[:, 1] * sine,
                             mine[:, 1] * cosine - mine[:, 0] * sine)
            for corner in range(8):
                a = along.max() if corner % 4 in (0, 3) else along.min()
                b = across.max() if corner % 4 < 2 else across.min()
                boxes[count, corner] = (a * cosine - b * sine, a * sine + b * cosine,
                                        mine[:, 2].max() if corner > 3 else mine[:, 2].min())
            count += 1
        first = i
    return boxes[:count]


def detect_compiled(cloud, threshold=0.5, least=10, ground_level=-1.2,
                    minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    """The boxes of lesson 12, with its parameters."""
    points = useful_points(cloud, minimum, maximum, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low, rng = points[points[:, 2] < ground_level], np.random.default_rng(0)
    if len(low) >= 3:
        samples = np.array([rng.choice(len(low), 3, replace=False) for _ in range(50)])
        plane, count = best_plane(low, samples, 0.2)
        if count:
            mean, spread = scatter(low, plane, 0.2)
            normal = np.linalg.eigh(spread)[1][:, 0]
            points = far_from(points, np.append(normal, -normal @ mean), 0.3)
    if not len(points):
        return np.zeros((0, 8, 3))
    points = voxel_means(points, 0.2)
    return oriented_boxes(points, cluster_compiled(points, threshold), least)

# %% [markdown]
# Paste your `detect_obstacles` here, with all that it calls, to race against it. Without it the compiled one runs alone. Its boxes hold the same points, and so have the same floors and roofs; they stand otherwise if yours are not the smallest rectangles.

# %% tags=["earlier"]
# Paste your detector of lesson 12 here, and the functions that it calls.
### BEGIN SOLUTION
# from 01_point_clouds: drop_invalid
# from 03_ransac_plane: ransac_plane, fit_plane, point_plane_distance
# from 06_filter_ground: voxel_grid
# from 07_filter_by_distance: crop_region, remove_ego_returns
# from 09_filter_clusters: filter_clusters
# from 10_accelerated_clustering: euclidean_clustering_accelerated
# from 11_pca_boxes: get_oriented_boxes
# from 12_streaming_obstacles: detect_obstacles
### END SOLUTION

# %%
if ready(count_near, root_of, unite, any_close, snuggest_turn):
    first = milliseconds(detect_compiled, cloud, repeats=1)
    boxes, second = detect_compiled(cloud), milliseconds(detect_compiled, cloud)
    print(f"{len(boxes)} boxes; the first frame took {first:,.0f} ms"
          f"{', with compiling' * is_compiled}; another takes {second:.1f} ms")
    plots.boxes(boxes, cloud=points[points[:, 2] > -1.2], limits=((-15, 35), (-9, 11)),
                title="Boxes by loops")
    pasted = globals().get("detect_obstacles")
    if pasted:
        others = pasted(cloud)
        print(f"lesson 12 takes {milliseconds(pasted, cloud):.1f} ms")
        if len(others) == len(boxes):
            apart = np.abs(others[:, [0, 4], 2] - boxes[:, [0, 4], 2]).max()
            print(f"floors and roofs of its boxes differ by {apart:.1g} m at most")
        else:
            print(f"it finds {len(others)} boxes")

# %% [markdown]
# Does more speed mean better driving? A frame comes every 100 ms. What the detector leaves can go into what lesson 12 wished for: more points kept, finer voxels, two frames compared.
#
# ## In practice
#
# - Real detectors are compiled ahead of time, in C++ or CUDA, for the reason you measured: not because Python's idea is worse, but because each step stands alone.
# - Compiled or not, the method decides first: comparing all with all, compiled, still takes the square of the points. Lesson 10 beats that in plain NumPy.
# - Numba can spread a loop over all processors (`prange`) and skip the strict order of sums (`fastmath`). Both change which of two nearly equal answers you get.
#
# ## Summary
#
# - Python handles objects; compiled code handles numbers, one point at a time, and stops when it knows enough.
# - The compiler wants types that stay, and is paid at the first call.
# - Union-find joins pairs as they come; counting sort orders cells without comparing.
# - Same clusters, to the last point: speed that changes the answer is no speed.
#
# ## If you want more
#
# 1. Put `@njit(parallel=True)` and `prange` into `count_near`. How much is won on your machine, and from how many points on?
# 2. Convert the cloud to `float32`. Which answers change?
# 3. `@njit(cache=True)`: how long does the first call take after a restart?
#
# **Sources.** [Numba: a LLVM-based Python JIT compiler](https://doi.org/10.1145/2833157.2833162) (Lam, Pitrou and Seibert 2015). Union-find with short ways: [Tarjan and van Leeuwen 1984](https://doi.org/10.1145/62.2160).

# %% [markdown] tags=["footer"]
# (footer)
