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
# ![A street seen from above. The points of each obstacle have their own colour, and a tight box surrounds each car, person and post at its own angle.](13_preview.png)
#
# In this lesson, you write the grid of lesson 10 and the boxes of lesson 11 as plain loops, and a compiler turns them into machine code. The result is exact, and it clusters a full scan in less than a hundredth of a second.
#
# The lesson is optional. You do not submit it, but your functions are checked.
#
# **After this lesson you can**
# - explain why a loop is slow in Python and fast when compiled, and how it differs from NumPy,
# - write code that the compiler accepts, and say what the first call costs,
# - join groups with union-find, and stop as soon as the answer is known.
#
# **You write** five small functions, and a sixth that is not checked. All packages are allowed, but Numba can compile only numbers, arrays, tuples, loops and NumPy. **You need** lessons 10 to 12. **Time:** (time), in three sittings of about 50, 50 and 40 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A compiler for Python loops
#
# *Numba translates a Python loop into machine code.*
#
# [Numba](https://numba.pydata.org) compiles a Python function at its first call. Colab has Numba. Elsewhere, run `pip install numba`. (The course tests the version in `requirements-compiled.txt`.) Without Numba, this notebook runs the same lines as plain Python, on one point in forty.

# %%
import os
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter, process_time

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from utils import check, load_cloud, plots, predict, ready

try:
    from numba import njit
except ImportError:
    def njit(function=None, **options):
        """Replace the compiler: return the function as it is."""
        return function or njit

is_compiled = njit.__module__.startswith("numba")
cloud = load_cloud("cloud.txt")[::1 if is_compiled else 40]
points = np.ascontiguousarray(cloud[:, :3])
print(f"{len(points):,} points;", "Numba is installed" if is_compiled else
      "Numba is NOT installed, so everything runs as plain Python, hundreds or thousands of times slower")


def milliseconds(function, *arguments, repeats=5):
    """Return the median processor time of several calls, in milliseconds."""
    times = []
    for _ in range(repeats):
        begin = process_time()
        function(*arguments)
        times.append(1000 * (process_time() - begin))
    return float(np.median(times))

# %% [markdown]
# ## The naive idea: just write the loop
#
# *At every step, Python has to find out what kind of object a number is.*
#
# In each round, RANSAC counts how many points are within 0.2 m of a plane. For each point, Python unpacks objects, looks up what `*` means for them, and packs the result into a new object.
#
# If you write `@njit` above a function, Numba compiles it. **In this lesson, run the check before you try your function.** The stop button does not stop compiled code. And if you read a row that does not exist, you get whatever is in memory behind the array. So `check` first runs your function as plain Python, and compiles it only if it is right.

# %%
level = np.array([0.0, 0.0, 1.0, 1.73])  # a, b, c, d: a level road
faster = predict("How many times faster is the compiled loop than the same loop in Python?",
                 choices=["about twice", "about 20 times", "more than 100 times"])

# %% nbgrader={"grade": false, "grade_id": "count_near", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def count_near(points, plane, tolerance):
    """Count the points (n, 3) within a tolerance of a plane (4,), point by point."""
    # 1. Start at zero, and go through the row numbers.
    # 2. Compute the distance |a x + b y + c z + d|, where points[i, 0] is x.
    # 3. Count the point if its distance is at most the tolerance.
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
# `for i in range(len(points)):` goes through the row numbers. `points[i, 0]`, `points[i, 1]` and `points[i, 2]` are the x, y and z of one point. They are single numbers, not arrays.
# </details>
# <details><summary>Hint 2</summary>
#
# Put `abs(...)` around the whole sum of three products and `plane[3]`, because this sum is negative below the plane.
# </details>
# <details><summary>Hint 3</summary>
#
# Set the count to 0 before the loop. In the loop, add 1 `if` the distance is `<=` the tolerance. Put `return` after the loop, with the same indentation as `for`.
# </details>

# %%
check(count_near)

# %%
def count_by_numpy(points, plane, tolerance):
    return np.count_nonzero(np.abs(points @ plane[:3] + plane[3]) <= tolerance)


if ready(count_near):
    as_python = getattr(count_near, "py_func", count_near)
    # `check` has compiled the function already, so compile it again to measure the time.
    first = milliseconds(njit(as_python), points, level, 0.2, repeats=1)
    same = count_near(points, level, 0.2) == count_by_numpy(points, level, 0.2)
    print(f"first call{', including compilation' * is_compiled}: {first:8.1f} ms; "
          f"{'the same number' if same else 'NOT the same number'} as NumPy")
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
                       f"{ratio:,.0f} times. Machine code adds and multiplies numbers, but Python "
                       "handles objects that contain them.")
    else:
        faster.compare("more than 100 times", "Numba is not installed, so this is the answer with "
                       "Numba.")

# %% [markdown]
# NumPy is also compiled. But it finishes each step for *all* points before it begins the next: products, sums, absolute values and comparisons. Each step writes an array to memory, and the next step reads it again. The compiled loop does all steps for one point at once and does not write any arrays.
#
# ## What the compiler needs
#
# *A variable must keep its type.*
#
# Numba compiles a function for the types of its arguments. Therefore:
#
# - A variable cannot be a number in one place and `None` in another.
# - Use arrays, numbers and tuples. You cannot use your own objects or `cKDTree`.
# - Functions that you call also need `@njit`.
# - Compiled code keeps the outside variables and functions that existed when it was compiled. If you change a function, rerun the cells of all functions that call it.
#
# **The first call is slow.** It takes about a thousand times as long as the second. `@njit(cache=True)` keeps the machine code on disk. A car must not compile when the first pedestrian appears, so it calls every function once before it drives.
#
# What does Numba say if it cannot compile a function?

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
# ## Union-find
#
# *Every cell points at a cell of its own piece, and the root of the piece points at itself.*
#
# Now you rewrite the clustering of lesson 10. Loops can join groups *one pair at a time*, can *stop* at the first close pair, and do not need a list of pairs.
#
# Each cell has a parent. At first, each cell is its own parent. If you follow the parents, you reach a **root**. Two cells with the same root are in the same piece. To join two pieces, let one root point at the other.
#
# On the way to the root, let each cell that you visit point at its grandparent. This *path halving* shortens the next search:

# %% tags=["folded"]
# @title Draw path halving (you need not read this)
figure, panels = plt.subplots(2, 1, figsize=(8.5, 3.6), layout="compressed", facecolor="white")
states = {"Before: root 0 is six steps from cell 6": [0, 0, 1, 2, 3, 4, 5],
          "After root_of(parent, 6): three steps": [0, 0, 0, 2, 2, 4, 4]}
for axes, (title, parents) in zip(panels, states.items()):
    path = [6]
    while parents[path[-1]] != path[-1]:
        path.append(parents[path[-1]])
    for cell, its_parent in enumerate(parents):
        colour, width = ("#D55E00", 2.2) if cell in path else ("#57606A", 1.2)
        axes.text(cell, 0, str(cell), ha="center", va="center", fontsize=11, color="#1B1F24",
                  zorder=3, bbox={"boxstyle": "circle", "facecolor": "white", "edgecolor": colour})
        if cell != its_parent:
            bend = 0.45 if cell - its_parent > 1 else 0
            axes.annotate("", (its_parent, 0), (cell, 0), zorder=1, arrowprops={
                "arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 11, "shrinkB": 11,
                "connectionstyle": f"arc3,rad={bend if cell % 2 == 0 else -bend}"})
    axes.set(xlim=(-0.6, 6.6), ylim=(-0.6, 0.9))
    axes.set_title(title, loc="left", fontsize=12, fontweight="bold", pad=6)
    axes.set_axis_off()

# %% nbgrader={"grade": false, "grade_id": "root_of", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def root_of(parent, cell):
    """Follow the parents (m,) of a cell to its root, and shorten the path for the next time."""
    # 1. While the cell is not its own parent:
    # 2.     make it point at its grandparent, and go there.
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
# A root is its own parent. So the loop runs `while parent[cell] != cell`. Return the cell at which the loop ends.
# </details>
# <details><summary>Hint 2</summary>
#
# The grandparent is `parent[parent[cell]]`. In each round, write it into `parent[cell]`, and then set `cell` to it. Otherwise, the loop never ends.
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
# Change the parent of a *root*. If you change the parent of another cell, you cut this cell out of its piece, together with all cells that point at it.
# </details>
# <details><summary>Hint 2</summary>
#
# First get both roots from `root_of`. Make the `min` of the two roots the parent of the `max`. You need not return anything, because you change the array itself.
# </details>

# %%
check(unite)

# %% [markdown]
# **Try it on seven nodes.** The four pairs from lesson 10 join nodes 0, 2, 4 and 5, and also nodes 1 and 3. Node 6 stays alone.

# %%
if ready(root_of, unite):
    parent = np.arange(7)
    for a, b in ((0, 2), (4, 0), (5, 2), (1, 3)):
        unite(parent, a, b)
    print("roots:", [int(root_of(parent, node)) for node in range(7)],
          "  expected: [0, 1, 0, 1, 0, 0, 6]")

# %% [markdown]
# **A good place to stop.** Save the notebook. You can join pieces. In the second sitting, you put the compiled clustering together. When you come back, first run all cells above this one.

# %% [markdown]
# ## Stop at the first close pair
#
# *The loop ends as soon as the answer is known.*
#
# A scanner measures neighbours one after the other, so a few successive points are often in the same cell. Such a *run* is in the rows from `a` up to, but not including, `a_end`. Is any of its points closer than the threshold to a point of another run? `limit` is the square of the threshold, which saves square roots.

# %% nbgrader={"grade": false, "grade_id": "any_close", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def any_close(points, a, a_end, b, b_end, limit):
    """Return whether a point in rows a to a_end is closer than sqrt(limit) to one in b to b_end."""
    # 1. For each row of one run and each row of the other:
    # 2.     compute the square of their distance from three differences.
    # 3.     If it is below the limit, return True at once.
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
# Write a loop inside a loop. The outer loop has `i` in `range(a, a_end)`, and the inner loop has `j` in `range(b, b_end)`.
# </details>
# <details><summary>Hint 2</summary>
#
# Compute three differences, `x = points[i, 0] - ...` and so on. Compare `x * x + y * y + z * z` with `limit`.
# </details>
# <details><summary>Hint 3</summary>
#
# Put `return True` inside the `if`, where it ends both loops. Put `return False` after both loops, with the same indentation as the outer `for`.
# </details>

# %%
check(any_close)

# %%
if ready(any_close):
    row = np.outer([0.0, 0.2, 1.0, 0.6], [1.0, 0.0, 0.0])
    print("rows 0, 1 and 2, 3:", any_close(row, 0, 2, 2, 4, 0.5**2), any_close(row, 0, 2, 2, 4, 0.3**2),
          "  expected: True False")

# %% [markdown]
# ## The grid, sorted
#
# *You can sort numbers without comparing any two of them.*
#
# The cells are numbered as in lesson 10, and a *counting sort* sorts these numbers. It counts how often each number occurs. From the counts, it knows where each number begins in the sorted array:

# %% tags=["folded"]
# @title Draw a counting sort (you need not read this)
numbers = np.array([3, 1, 0, 3, 1, 2, 1])
counts = np.bincount(numbers)
starts = np.cumsum(counts) - counts
figure, axes = plt.subplots(figsize=(8.5, 3.6), layout="compressed", facecolor="white")
place = starts.copy()
for row, value in enumerate(numbers):
    colour = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")[value]
    axes.plot([row, place[value]], [1, 0], color=colour, lw=1.8, zorder=1)
    for x, y in ((row, 1), (place[value], 0)):
        axes.text(x, y, str(value), ha="center", va="center", fontsize=12, color="#1B1F24",
                  bbox={"boxstyle": "square", "facecolor": "white", "edgecolor": colour})
    place[value] += 1
for value, (count, start) in enumerate(zip(counts, starts)):
    axes.text(start + (count - 1) / 2, -0.25, f"count of {value}: {count}\nbegins at place {start}",
              ha="center", va="top", fontsize=10, color="#1B1F24")
axes.set(xlim=(-0.7, 6.7), ylim=(-0.7, 1.2))
axes.set_title("Counts say where each number begins; equal numbers keep their order", loc="left",
               fontsize=12, fontweight="bold", pad=6)
axes.set_axis_off()

# %% [markdown]
# Large numbers are sorted digit by digit, beginning with the last digit. In the next cell, a digit has 11 bits.

# %%
@njit
def ascending(numbers):
    """Return the order that sorts whole numbers >= 0; equal numbers keep their order."""
    n, largest, shift = len(numbers), numbers.max(), 0
    order, other = np.arange(n), np.empty(n, np.int64)
    while largest >> shift:  # there are digits left
        place = np.zeros(2049, np.int64)
        for i in range(n):
            place[((numbers[i] >> shift) & 2047) + 1] += 1
        for digit in range(2048):
            place[digit + 1] += place[digit]
        for i in range(n):
            digit = (numbers[order[i]] >> shift) & 2047  # drop `shift` bits, keep the next 11
            other[place[digit]] = order[i]
            place[digit] += 1
        order, other = other, order
        shift += 11
    return order

# %% [markdown]
# **Write `starts_of`.** A group is a series of equal successive values. The function finds the runs of points, and later the cells in the sorted runs. In the list below, groups begin at 0, 3 and 5, and the list has 6 values. So the answer is 0, 3, 5 and 6.

# %%
def starts_of(values):
    """Return where each group of equal successive values begins; the last number is n."""
    starts = [0]
    # Go through the rows from 1. If a value differs from the value before it, append its row.
    # roughly 3 lines
    return [*starts, len(values)]


print("starts:", starts_of([7, 7, 7, 2, 2, 7]), "  expected: [0, 3, 5, 6]")

# %% [markdown]
# <details><summary>An answer</summary>
#
# ```python
#     for i in range(1, len(values)):
#         if values[i] != values[i - 1]:
#             starts.append(i)
# ```
# </details>
#
# The next cell replaces your function with a compiled one that stores the starts in an array. It sorts runs instead of single points, because a run in `cloud.txt` has four points on average.

# %% tags=["folded"]
# @title Sort runs of points into cells (you need not read this)
@njit
def cell_range(values, side):
    """Return the smallest and the largest cell along one axis, as whole floats."""
    low = high = values[0]
    for value in values:
        if not abs(value) < np.inf:  # a wrong row number would crash Python itself
            raise ValueError("Some coordinates are not finite: drop these rows (lesson 01)")
        low, high = min(low, value), max(high, value)
    return np.floor(low / side), np.floor(high / side)


@njit
def starts_of(values):
    """Return where each group of equal successive values begins; the last number is n."""
    starts, count = np.empty(len(values) + 1, np.int64), 0
    for i in range(len(values)):
        if i == 0 or values[i] != values[i - 1]:
            starts[count] = i
            count += 1
    starts[count] = len(values)
    return starts[:count + 1]


@njit(nogil=True)
def sort_by_cell(points, side):
    """Find runs of successive points in the same cell, and sort the runs by cell.

    Returns
    -------
    order : the runs, cell by cell
    runs : (r, 2), the first row and the end of each run, in this order
    starts : (m + 1,), where each cell begins in this order; the last number is r
    numbers : (m,), the numbers of the cells in ascending order
    next_x, next_y : how much the number grows from one cell to the next along x and along y
    """
    low_x, high_x = cell_range(points[:, 0], side)
    low_y, high_y = cell_range(points[:, 1], side)
    low_z, high_z = cell_range(points[:, 2], side)
    if (high_x - low_x + 6) * (high_y - low_y + 6) * (high_z - low_z + 6) > 2.0**62:
        raise ValueError("There are too many cells for 64-bit numbers: drop far points (lesson 07)")
    next_y = np.int64(high_z - low_z) + 5
    next_x = (np.int64(high_y - low_y) + 5) * next_y
    number = np.empty(len(points), np.int64)
    for i in range(len(number)):
        x = np.int64(np.floor(points[i, 0] / side) - low_x)
        y = np.int64(np.floor(points[i, 1] / side) - low_y)
        z = np.int64(np.floor(points[i, 2] / side) - low_z)
        number[i] = x * next_x + y * next_y + z
    run_starts = starts_of(number)
    number = number[run_starts[:-1]]
    order = ascending(number)
    runs = np.empty((len(order), 2), np.int64)
    for i in range(len(order)):
        runs[i, 0], runs[i, 1] = run_starts[order[i]], run_starts[order[i] + 1]
    number = number[order]
    starts = starts_of(number)
    return order, runs, starts, number[starts[:-1]], next_x, next_y

# %% [markdown]
# The neighbours of a cell are in 25 columns of cells along z. You need to visit each pair of columns only once, so 13 columns are enough: the cell's own column, and half of the others.
#
# To compare two columns, `join_by_first_points` walks up the first column. A pointer in the second column follows, so it never moves back. From the pointer on, at most five cells are within two steps along z. This is the window of the cell.

# %% tags=["folded"]
# @title Draw the columns and the pointer (you need not read this)
figure, (above, profile) = plt.subplots(1, 2, figsize=(8.5, 4.4), layout="compressed",
                                        facecolor="white", gridspec_kw={"width_ratios": (1, 1.2)})


def draw_cell(axes, x, y, colour="white", text=""):
    axes.add_patch(plt.Rectangle((x - 0.45, y - 0.45), 0.9, 0.9, facecolor=colour, edgecolor="#57606A"))
    axes.text(x, y, text, ha="center", va="center", fontsize=11, color="#1B1F24")


for x in range(3):
    for y in range(-2, 3):
        draw_cell(above, x, y, "#56B4E9" if x or y >= 0 else "white", "cell" if x == y == 0 else "")
for x in (-2, -1):
    for y in range(-2, 3):
        draw_cell(above, x, y)
above.set_xlabel("x (cells)")
above.set_ylabel("y (cells)")
above.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6), aspect="equal")
above.set_title("From above: 13 of 25 columns", loc="left", fontsize=12, fontweight="bold", pad=6)

first_column, second_column = (0, 1, 3, 4, 6, 8), (0, 1, 2, 4, 5, 7, 8)  # heights of occupied cells
now = 4
window = [height for height in second_column if abs(height - now) <= 2]
for height in first_column:
    draw_cell(profile, 0, height, "#E69F00" if height == now else "white", str(height))
for height in second_column:
    draw_cell(profile, 3, height, "#56B4E9" if height in window else "white", str(height))
for height in window:
    profile.plot([0.5, 2.5], [now, height], color="#57606A", lw=1, zorder=0)
profile.add_patch(plt.Rectangle((2.4, now - 2.5), 1.2, 5, fill=False, edgecolor="#D55E00", ls="--", lw=1.6))
profile.annotate("pointer", (3.65, window[0]), (4.4, window[0]), va="center", fontsize=11,
                 arrowprops={"arrowstyle": "-|>", "color": "#D55E00"}, color="#1B1F24")
profile.text(3.75, now + 2, "window:\nfive cells", va="center", fontsize=11, color="#1B1F24")
profile.text(-0.65, now, "cell", ha="right", va="center", fontsize=11, color="#1B1F24")
profile.set(xlim=(-2, 6), ylim=(-0.9, 8.9), xticks=[0, 3], xticklabels=["first column", "second column"],
            ylabel="z (cells)")
profile.set_title("From the side: two columns", loc="left", fontsize=12, fontweight="bold", pad=6)
for axes in (above, profile):
    axes.spines[["top", "right"]].set_visible(False)

# %% [markdown]
# On the right, only occupied cells have a number. When the first column reaches cell 6, the pointer moves up to 4.
#
# `join_cells` first compares one point of each cell. Then, for pairs that are still apart, `any_close` compares all points if the boxes around them are close enough. For crowded cells, a kd-tree is faster, so `join_cells` returns their pairs. `cluster_compiled` makes the cells smaller by a millionth, because of rounding. Lesson 10 leaves this factor out. It matters only if two points are a threshold apart to 16 digits.

# %% tags=["folded"]
# @title Define boxes around cells, and number the clusters (you need not read this)
@njit
def count_points(runs):
    """Return the number of points in some runs (k, 2)."""
    count = 0
    for begin, end in runs:
        count += end - begin
    return count


@njit
def points_of(points, runs):
    """Return the points in some runs."""
    found, count = np.empty((count_points(runs), 3)), 0
    for begin, end in runs:
        for i in range(begin, end):
            for axis in range(3):
                found[count, axis] = points[i, axis]
            count += 1
    return found


@njit
def box_of(points, runs):
    """Return the smallest and the largest x, y, z of the points in some runs."""
    low, high = points[runs[0, 0]].copy(), points[runs[0, 0]].copy()
    for begin, end in runs:
        for i in range(begin, end):
            for axis in range(3):
                low[axis] = min(low[axis], points[i, axis])
                high[axis] = max(high[axis], points[i, axis])
    return low, high


@njit
def are_near(low, high, a, b, limit):
    """Return whether the boxes of two cells are closer than sqrt(limit)."""
    square = 0.0
    for axis in range(3):
        gap = max(low[a, axis] - high[b, axis], low[b, axis] - high[a, axis], 0.0)
        square += gap * gap
    return square < limit


@njit
def any_runs_close(points, runs, others, limit):
    """Return whether a point of some runs is closer than sqrt(limit) to one of the others."""
    for a, a_end in runs:
        for b, b_end in others:
            if any_close(points, a, a_end, b, b_end, limit):
                return True
    return False


@njit(nogil=True)
def numbered(parent, order, runs, starts):
    """Return labels 1, 2, ... of the points, in order of first appearance."""
    root, end = np.empty(len(order), np.int64), np.empty(len(order), np.int64)
    for cell in range(len(parent)):
        mine = root_of(parent, cell)
        for i in range(starts[cell], starts[cell + 1]):
            root[order[i]], end[order[i]] = mine, runs[i, 1]
    number, last = np.zeros(len(parent), np.int64), 0
    labels, row = np.empty(end[-1], np.int64), 0
    for run in range(len(order)):
        if number[root[run]] == 0:
            last += 1
            number[root[run]] = last
        labels[row:end[run]] = number[root[run]]
        row = end[run]
    return labels

# %%
@njit
def join_by_first_points(parent, first, numbers, next_x, next_y, limit):
    """Join cells whose first points are close; return the other pairs of neighbours."""
    column, still_open = numbers // next_y, [(0, 0)]
    starts = starts_of(column)
    column = column[starts[:-1]]
    for x in range(3):  # columns of the same x, of the next x, and of the one after it
        for cell in range(len(parent)):  # make each cell point at its root
            parent[cell] = root_of(parent, cell)
        other_first = 0
        for mine in range(len(column)):
            middle = column[mine] + x * (next_x // next_y)
            while other_first < len(column) and column[other_first] < middle - 2:
                other_first += 1
            other = max(other_first, mine)
            while other < len(column) and column[other] <= middle + 2:
                step = (column[other] - column[mine]) * next_y
                b_first, b_end = starts[other], starts[other + 1]
                for a in range(starts[mine], starts[mine + 1]):
                    while b_first < b_end and numbers[b_first] < numbers[a] + step - 2:
                        b_first += 1
                    b = max(b_first, a + 1)
                    while b < b_end and numbers[b] <= numbers[a] + step + 2:
                        if parent[a] != parent[b] and root_of(parent, a) != root_of(parent, b):
                            if any_close(first, a, a + 1, b, b + 1, limit):
                                unite(parent, a, b)
                            else:
                                still_open.append((a, b))
                        b += 1
                other += 1
    return still_open[1:]


@njit(nogil=True)
def join_cells(points, runs, starts, numbers, next_x, next_y, limit, crowd):
    """Join cells; return the parents (m,), and the pairs of cells with too many points."""
    count, too_many = len(numbers), [(0, 0)]
    parent, first = np.arange(count), points[runs[starts[:-1], 0]]
    still_open = join_by_first_points(parent, first, numbers, next_x, next_y, limit)
    low, high, has_box = np.empty((count, 3)), np.empty((count, 3)), np.zeros(count, np.bool_)
    for cell in range(count):
        parent[cell] = root_of(parent, cell)
    for a, b in still_open:
        if parent[a] == parent[b] or root_of(parent, a) == root_of(parent, b):
            continue
        for cell in (a, b):
            if not has_box[cell]:
                low[cell], high[cell] = box_of(points, runs[starts[cell]:starts[cell + 1]])
                has_box[cell] = True
        if are_near(low, high, a, b, limit):
            of_a, of_b = runs[starts[a]:starts[a + 1]], runs[starts[b]:starts[b + 1]]
            if count_points(of_a) * count_points(of_b) > crowd:
                too_many.append((a, b))
            elif any_runs_close(points, of_a, of_b, limit):
                unite(parent, a, b)
    return parent, too_many[1:]


def cluster_compiled(cloud, threshold=0.5):
    """Return the clusters of lessons 05 and 10, with the same labels."""
    points = np.ascontiguousarray(cloud[:, :3], dtype=float)
    if not len(points):
        return np.zeros(0, int)
    side = threshold / np.sqrt(3) * (1 - 1e-6)  # a little less, because of rounding
    order, runs, starts, numbers, next_x, next_y = sort_by_cell(points, side)
    parent, too_many = join_cells(points, runs, starts, numbers, next_x, next_y, threshold**2,
                                  50_000)
    for a, b in too_many:  # compare crowded cells as in lesson 10
        if root_of(parent, a) != root_of(parent, b):
            p, q = (points_of(points, runs[starts[cell]:starts[cell + 1]]) for cell in (a, b))
            if np.ptp(p, axis=0).max() > np.ptp(q, axis=0).max():
                p, q = q, p  # a tree of the smaller cell is faster
            if cKDTree(p).query(q, distance_upper_bound=threshold)[0].min() < threshold:
                unite(parent, a, b)
    return numbered(parent, order, runs, starts)

# %% [markdown]
# **Look before you measure the time.** Are the clusters the same for every single point? `join_all_pairs` from lesson 10 is slow but reliable.

# %%
def join_all_pairs(points, threshold=0.5):
    """Return the label of each point, from a list of all pairs of neighbours."""
    pairs = cKDTree(points).query_pairs(threshold, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=2 * (len(points),))
    return connected_components(graph, directed=False)[1]


def same_clusters(labels, others):
    """Return whether two arrays of labels form the same groups, even if the numbers differ."""
    combinations = np.unique(np.stack([labels, others]), axis=1).shape[1]
    return combinations == len(np.unique(labels)) == len(np.unique(others))


if ready(root_of, unite, any_close):
    obstacles = points[(points[:, 2] > -1.2) & (np.hypot(points[:, 0], points[:, 1]) > 2)]
    print("This compiles all functions above, which takes about 10 seconds." * is_compiled)
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
# **A good place to stop.** Save the notebook. The compiled clustering works. In the third sitting, you write the boxes. When you come back, first run all cells above this one.

# %% [markdown]
# ## Boxes
#
# *Update the extremes of ninety rectangles point by point, and compare the areas at the end.*
#
# The smallest rectangle of lesson 11 needs the smallest and the largest projection onto each of 90 directions. NumPy writes a table of all projections, but a loop stores only these extremes.

# %%
turns = np.radians(np.arange(90))
cosines, sines = np.cos(turns), np.sin(turns)

# %% nbgrader={"grade": false, "grade_id": "snuggest_turn", "locked": false, "schema_version": 3, "solution": true, "task": false}
@njit
def snuggest_turn(points):
    """Return the turn, 0 to 89, whose rectangle around the points has the smallest area."""
    # 1. Make four arrays of 90: smallest and largest along each direction, and across it.
    # 2. For each point and each turn, along is x cos + y sin, and across is y cos - x sin.
    #    Update the four arrays.
    # 3. The area of each turn is a product of two differences. Find the smallest with argmin().
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
# Before the first point, the smallest value along each direction is `np.inf` and the largest is `-np.inf`. `np.full(90, np.inf)` makes an array of 90 such values. If you start with zeros, the sensor at (0, 0) counts as a point of every car.
# </details>
# <details><summary>Hint 2</summary>
#
# Write a loop over the points, and inside it a loop over the 90 turns. In the inner loop, `along` and `across` are two numbers. At `[turn]`, store the `min` or `max` of the old value and the new one in each of the four arrays.
# </details>
# <details><summary>Hint 3</summary>
#
# After both loops, (largest minus smallest along) times (largest minus smallest across) is an array of 90 areas. Return its `.argmin()`, the index of the turn.
# </details>

# %%
check(snuggest_turn)

# %%
if ready(snuggest_turn):
    corners = np.array([[2.0, 1, 0], [-2, 1, 0], [-2, -1, 0], [2, -1, 0]])
    leaning = np.column_stack([corners[:, 0] * cosines[30] - corners[:, 1] * sines[30],
                               corners[:, 0] * sines[30] + corners[:, 1] * cosines[30],
                               corners[:, 2]])
    print("turn of a rectangle turned by 30°:", snuggest_turn(leaning), "  expected: 30")

# %% [markdown]
# ## The whole detector
#
# *One pass over the points replaces several NumPy steps.*
#
# The next cell contains the steps of lesson 12. A single pass drops invalid returns, crops the region and removes the ego car. The rounds of RANSAC use your `count_near` to count inliers, and the random samples are those of lesson 12.

# %% tags=["folded"]
# @title Define the steps of the detector as loops (you need not read this)
@njit
def useful_points(cloud, minimum, maximum, car_low, car_high):
    """Return x, y, z of the valid returns in the region of interest, without the ego car."""
    kept, count = np.empty((len(cloud), 3)), 0
    for i in range(len(cloud)):
        x, y, z = cloud[i, 0], cloud[i, 1], cloud[i, 2]
        inside = (minimum[0] <= x <= maximum[0] and minimum[1] <= y <= maximum[1]
                  and minimum[2] <= z <= maximum[2])  # false for NaN
        own = (car_low[0] <= x <= car_high[0] and car_low[1] <= y <= car_high[1]
               and car_low[2] <= z <= car_high[2])
        if inside and not own and (x != 0 or y != 0 or z != 0):
            kept[count, 0], kept[count, 1], kept[count, 2] = x, y, z
            count += 1
    return kept[:count]


@njit
def best_plane(points, samples, tolerance):
    """Return the plane with the most points near it; `samples` (k, 3) are rows of three points."""
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
    """Return the distance of a point from a plane."""
    return abs(plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3])


@njit
def scatter(points, plane, tolerance):
    """Return the mean of the points near a plane, and the summed products of their deviations."""
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
    """Return the points that are farther than a distance from a plane."""
    kept, count = np.empty((len(points), 3)), 0
    for point in points:
        if away(point, plane) > distance:
            for axis in range(3):
                kept[count, axis] = point[axis]
            count += 1
    return kept[:count]


@njit
def voxel_means(points, side):
    """Return the mean of the points of each cell."""
    _, runs, starts, numbers, _, _ = sort_by_cell(points, side)
    means = np.zeros((len(numbers), 3))
    for cell in range(len(numbers)):
        count = 0
        for run in range(starts[cell], starts[cell + 1]):
            count += runs[run, 1] - runs[run, 0]
            for i in range(runs[run, 0], runs[run, 1]):
                for axis in range(3):
                    means[cell, axis] += points[i, axis]
        for axis in range(3):
            means[cell, axis] /= count
    return means


@njit
def oriented_boxes(points, labels, least):
    """Return boxes (N, 8, 3) of clusters with at least `least` points, in the order of labels."""
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
                    minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0), find_plane=best_plane):
    """Detect boxes as in lesson 12, with its parameters."""
    points = useful_points(cloud, minimum, maximum, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low, rng = points[points[:, 2] < ground_level], np.random.default_rng(0)
    if len(low) >= 3:
        samples = np.array([rng.choice(len(low), 3, replace=False) for _ in range(50)])
        plane, count = find_plane(low, samples, 0.2)
        if count:
            mean, spread = scatter(low, plane, 0.2)
            normal = np.linalg.eigh(spread)[1][:, 0]
            points = far_from(points, np.append(normal, -normal @ mean), 0.3)
    if not len(points):
        return np.zeros((0, 8, 3))
    points = voxel_means(points, 0.2)
    return oriented_boxes(points, cluster_compiled(points, threshold), least)

# %% [markdown]
# To race against this detector, paste your `detect_obstacles` into the next cell, with all functions that it calls. The floors and roofs of the boxes should be the same. The yaws differ if your boxes are not the smallest rectangles.
#
# With Numba, the box of the lorry at (16, 4) leans by 15°. Its points form a thin L, and the smallest rectangle around a thin L can be at an angle (lesson 11). This is not your mistake.

# %% tags=["earlier"]
# Paste your detector from lesson 12 here, and the functions that it calls.
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
    print("This compiles the detector, which takes about 15 seconds." * is_compiled)
    first = milliseconds(detect_compiled, cloud, repeats=1)
    boxes, second = detect_compiled(cloud), milliseconds(detect_compiled, cloud)
    print(f"{len(boxes)} boxes; the first frame took {first:,.0f} ms of processor time"
          f"{', including compilation' * is_compiled}; the next one takes {second:.1f} ms")
    plots.boxes(boxes, cloud=points[points[:, 2] > -1.2], limits=((-15, 35), (-9, 11)),
                title="Boxes by loops")
    pasted = globals().get("detect_obstacles")
    if pasted:
        others = pasted(cloud)
        print(f"lesson 12 takes {milliseconds(pasted, cloud):.1f} ms")
        if len(others) == len(boxes):
            apart = np.abs(others[:, [0, 4], 2] - boxes[:, [0, 4], 2]).max()
            print(f"the floors and roofs of its boxes differ by at most {apart:.1g} m")
        else:
            print(f"it finds {len(others)} boxes")

# %% [markdown]
# A new frame comes only every 100 ms. You can use the remaining time for smaller voxels, or to compare two frames.

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(unite)

# %% [markdown]
# ## In practice
#
# - Real detectors are compiled ahead of time, in C++ or CUDA.
# - The method matters more than the compiler. A compiled loop over all pairs of points is slower than lesson 10 in plain NumPy.
# - Numba can spread a loop over all processors (`prange`) and change the order of sums (`fastmath`). With either option, the result may change if two answers are nearly equal.
#
# ## Summary
#
# - Python handles objects, but compiled code handles numbers. A loop can stop as soon as it knows the answer.
# - The compiler needs types that do not change, and the first call includes the time to compile.
# - Union-find joins pairs as they come. Counting sort orders cells without comparing them.
#
# ## If you want more
#
# ### A detector with a memory
#
# *Remember what to try first, but never what to answer.*
#
# In every frame, the detector searches for the road from scratch, although the road has hardly moved. What may the detector remember without changing a single box?
#
# Test it on a difficult stream. Frames 0 to 4 are from the city of lesson 12. Frame 5 is empty, and frame 6 contains only NaN. Then the car is on a ramp, so the whole street is tilted by 3°.

# %%
from utils import scenes, show_table

stream = [frame.cloud[::1 if is_compiled else 40] for frame in scenes.city_block(frames=12)]
stream[5], stream[6] = stream[5][:0], np.full_like(stream[6], np.nan)
ramp = np.radians(3)
tilt = np.array([[np.cos(ramp), 0, -np.sin(ramp)], [0, 1, 0], [np.sin(ramp), 0, np.cos(ramp)]])
stream[7:] = [scan[:, :3] @ tilt for scan in stream[7:]]


def detect_stream(scans, search):
    """Yield the boxes of each scan, and how many distances the search for the road computed.

    `search` is called like `best_plane`, and also gets the road that it found in the last frame.
    """
    road, computed = np.zeros(4), 0

    def find_plane(low, samples, tolerance):
        nonlocal road, computed
        road, count, computed = search(low, samples, tolerance, road)
        return road, count

    for scan in scans:
        computed = 0
        yield detect_compiled(scan, find_plane=find_plane), computed

# %% [markdown]
# **The naive idea** is to search in the first frame only, and then to trust the road of the last frame:

# %%
def search_from_scratch(low, samples, tolerance, road):
    return *best_plane(low, samples, tolerance), len(samples) * len(low)


def trust_last(low, samples, tolerance, road):
    return (road, len(low), 0) if road.any() else search_from_scratch(low, samples, tolerance, road)


if ready(count_near, root_of, unite, any_close, snuggest_turn):
    expected = [detect_compiled(scan) for scan in stream]
    for number, (boxes, _) in enumerate(detect_stream(stream, trust_last)):
        same = "the" if np.array_equal(boxes, expected[number]) else "NOT the"
        print(f"frame {number:2}: {len(boxes):2} boxes, {same} {len(expected[number])} of a new search")

# %% [markdown]
# The old plane is good enough to look right in the city, but it changes boxes. On the ramp, it is wrong, and nothing tells the detector.
#
# **An exact idea.** A *miss* is a point that is farther from a plane than the tolerance. RANSAC needs the sample with the fewest misses.
#
# - *Give up early.* A sample that already has as many misses as the best sample before it cannot win, so the count can end.
# - *Begin with the likely misses.* The points that the last road misses are on kerbs and obstacles, and most samples also miss them. If you count them first, most samples give up earlier.
#
# To keep the rest fast, the points are counted in blocks of 128. The memory changes only the order of the blocks, and the number of misses does not depend on this order. So the boxes are the same, whatever the detector remembers.

# %%
@njit
def likely_misses_first(points, road, tolerance):
    """Return where the blocks of 128 points begin, those with the fewest points near a road first."""
    starts = np.arange(0, len(points), 128)
    near = [count_near(points[start:start + 128], road, tolerance) for start in starts]
    return starts[np.argsort(np.array(near), kind="mergesort")]


@njit
def misses_below(points, starts, plane, tolerance, limit):
    """Count the points that a plane misses, block by block, but give up at the limit.

    Also return how many points were visited.
    """
    missed, visited = 0, 0
    for start in starts:
        block = points[start:start + 128]
        missed += len(block) - count_near(block, plane, tolerance)
        visited += len(block)
        if missed >= limit:
            break
    return missed, visited


@njit
def fewest_misses(points, samples, tolerance, starts):
    """Return plane and count as `best_plane` does, and the number of distances computed."""
    best, fewest, computed = np.zeros(4), len(points), 0
    for sample in samples:
        # The best plane of three points is the plane through them.
        plane, count = best_plane(points[sample], np.array([[0, 1, 2]]), tolerance)
        if count:
            missed, visited = misses_below(points, starts, plane, tolerance, fewest)
            computed += visited
            if missed < fewest:
                best, fewest = plane, missed
    return best, len(points) - fewest, computed

# %%
def give_up_early(low, samples, tolerance, road):
    return fewest_misses(low, samples, tolerance, np.arange(0, len(low), 128))


def remember_road(low, samples, tolerance, road):
    starts = likely_misses_first(low, road, tolerance)
    plane, count, computed = fewest_misses(low, samples, tolerance, starts)
    return plane, count, computed + len(low)


def detect_all(search):
    return [*detect_stream(stream, search)]


if ready(count_near, root_of, unite, any_close, snuggest_turn):
    searches = {"search from scratch": search_from_scratch, "give up early": give_up_early,
                "give up early, remember the road": remember_road}
    found = {name: detect_all(search) for name, search in searches.items()}
    # In turn, so that other programs slow down all searches alike; the least time is the fairest.
    spent = np.min([[milliseconds(detect_all, search, repeats=1) for search in searches.values()]
                    for _ in range(9 if is_compiled else 1)], axis=0) / len(stream)
    rows, lines = [], {}
    for (name, frames), time in zip(found.items(), spent):
        same = sum(np.array_equal(boxes, alone) for (boxes, _), alone in zip(frames, expected))
        lines[name] = range(len(stream)), [computed / 1e6 for _, computed in frames]
        rows.append([name, f"{same} of {len(stream)}", f"{np.mean(lines[name][1]):.2f}", f"{time:.1f}"])
    show_table(["search", "frames with the same boxes", "million distances per frame", "ms per frame"],
               rows)
    axes = plots.curves(lines, across="frame", up="distances (millions)",
                        title="Distances that the search for the road computes")
    axes.axvline(7, color="black", linestyle=":")
    axes.text(7.1, axes.get_ylim()[1], "the ramp begins", va="top")
    axes.text(5.5, 0, "no points\n", ha="center", va="bottom")

# %% [markdown]
# The boxes of all frames are the same. Where the ramp begins, the memory is wrong, so it does not save anything. In the next frame, the memory is right again.
#
# Most of the gain comes from giving up early, which needs no memory. The whole frame gains less, because the search is only one of its steps. The cells of the voxel grid are not worth remembering. In 0.1 s, the car drives half a metre, and then more than half of the occupied cells are new.
#
# ### Three tasks
#
# Each task takes about 20 minutes.
#
# 1. Use `@njit(parallel=True)` and `prange` in `count_near`. How many points must a cloud have before the parallel version is faster?
# 2. Convert the cloud to `float32`. Which answers change?
# 3. With `@njit(cache=True)`, how long does the first call take after a restart?
#
# ### Several processors
#
# *Each processor clusters one slab of the scene.*
#
# Python lets only one thread work at a time, unless that thread runs a function that was compiled with `nogil=True`. So you can cut the cloud along x into as many slabs as there are processors, and call `cluster_compiled` for all slabs at once.
#
# Two points in different slabs may be neighbours. Therefore, a slab also gets *guests*: the points that are less than a threshold beyond its end. Each guest is at home in another slab. When all slabs are finished, each guest joins its cluster here and its cluster at home.

# %% tags=["folded"]
# @title Cluster the slabs of a cloud in parallel (you need not read this)
@njit(nogil=True)
def slab_of(cloud, start, end, beyond):
    """Find the points with x from `start` to `end`, and then those up to `beyond`.

    Returns
    -------
    rows : their rows; count : the number of rows before `end`; points : their x, y, z
    """
    own, guests, count, others = np.empty(len(cloud), np.int64), np.empty(len(cloud), np.int64), 0, 0
    for i in range(len(cloud)):
        if start <= cloud[i, 0] < end:
            own[count] = i
            count += 1
        elif end <= cloud[i, 0] < beyond:
            guests[others] = i
            others += 1
    rows = np.concatenate((own[:count], guests[:others]))
    points = np.empty((len(rows), 3))
    for i in range(len(rows)):
        for axis in range(3):
            points[i, axis] = cloud[rows[i], axis]
    return rows, count, points


@njit(nogil=True)
def point_at_first(parent, rows, count, labels):
    """Let each row of a slab point at the first row of its cluster.

    Returns
    -------
    guests, hosts : the guests of each cluster, and the first row of that cluster
    """
    first = np.full(len(rows) + 1, -1)
    for i in range(count):
        if first[labels[i]] < 0:
            first[labels[i]] = rows[i]
        parent[rows[i]] = first[labels[i]]
    guests, hosts = rows[count:], first[labels[count:]]
    return guests[hosts >= 0], hosts[hosts >= 0]


@njit
def numbered_by_first(parent, guests, hosts):
    """Join guests to hosts; return labels 1, 2, ... of the points, in order of first appearance."""
    for i in range(len(guests)):
        unite(parent, guests[i], hosts[i])
    labels, last = np.empty(len(parent), np.int64), 0
    for i in range(len(parent)):  # a parent is an earlier row, or the row itself
        if parent[i] == i:
            last += 1
            labels[i] = last
        else:
            labels[i] = labels[parent[i]]
    return labels


processors = os.cpu_count() if is_compiled else 1  # threads of plain Python wait for each other


def cluster_in_parallel(cloud, threshold=0.5, threads=processors):
    """Return the same labels as `cluster_compiled`, computed by several threads."""
    slabs = min(threads, len(cloud) // 10_000)
    if slabs < 2 or not np.isfinite(cloud[:, 0]).all():  # which raises an error
        return cluster_compiled(cloud, threshold)
    some = np.sort(cloud[::100, 0])
    ends = [-np.inf, *some[np.arange(1, slabs) * len(some) // slabs], np.inf]
    parent = np.empty(len(cloud), np.int64)

    def join_slab(start, end):
        rows, count, points = slab_of(cloud, start, end, end + 1.01 * threshold)
        return point_at_first(parent, rows, count, cluster_compiled(points, threshold))

    with ThreadPoolExecutor(slabs) as pool:
        pairs = [*pool.map(join_slab, ends[:-1], ends[1:])]
    return numbered_by_first(parent, *(np.concatenate(rows) for rows in zip(*pairs)))

# %% [markdown]
# `milliseconds` adds up the processor time of all threads, so a clock must tell whether you wait less:

# %%
if ready(root_of, unite, any_close):
    same = np.array_equal(cluster_in_parallel(points), cluster_compiled(points))
    print(f"The labels are {'the same' if same else 'NOT the same'}.")
    for function in (cluster_compiled, cluster_in_parallel):
        waits = []
        for _ in range(9):
            begin = perf_counter()
            function(points)
            waits.append(1000 * (perf_counter() - begin))
        print(f"{function.__name__:>20}: {np.median(waits):6.1f} ms on the clock, "
              f"{milliseconds(function, points):6.1f} ms of processor time")

# %% [markdown]
# **Sources.** [Numba: a LLVM-based Python JIT compiler](https://doi.org/10.1145/2833157.2833162) (Lam, Pitrou and Seibert 2015). Union-find with path halving: [Tarjan and van Leeuwen 1984](https://doi.org/10.1145/62.2160).

# %% [markdown] tags=["footer"]
# (footer)
