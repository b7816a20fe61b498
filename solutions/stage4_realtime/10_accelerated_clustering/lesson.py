# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [sklearn.cluster, scipy.cluster, hdbscan, dbscan, open3d, pcl]
#     lent: [points_in_cells, join_cheaply, join_exactly, after_two_steps, measure_ways, time_steps, measure_thresholds, spring_the_trap, race]
# ---

# %% [markdown]
# # 10 · Clustering in real time
#
# ![Two views of a car from above. On the left, a dense web of lines connects its points. On the right, the points are divided into the cells of a grid, one point in each cell is marked, and a few short lines connect the marked points.](10_preview.png)
#
# Your function from lesson 05 clusters a scan correctly, one point at a time. But the scanner delivers ten scans a second. In this lesson, you find exactly the same clusters in about a tenth of a second, in three small steps.
#
# **After this lesson you can**
# - find out where an algorithm spends time and memory before you speed it up,
# - cluster fifty thousand points exactly, in three steps that leave few pairs to compare,
# - explain why the result is exact, and find an input that breaks a careless shortcut.
#
# **You write** three small functions (checked, not graded) and `euclidean_clustering_accelerated` (points), which calls them. **You need** lesson 05, and the idea of lesson 04 but not its code. **Time:** (time), in three sittings of 50, 45 and 20 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Fifty thousand points in a tenth of a second
#
# *A result that arrives after the next scan is out of date.*
#
# This is a full turn of the scanner without the road and the ego car. All other points are kept.

# %%
from math import dist
from time import process_time

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from utils import check, is_written, load_cloud, load_street, plots, predict, show_table
from utils.breaking import show_broken, tell_apart

cloud = load_cloud("cloud.txt")  # one row per return: x, y, z in metres, and intensity
ego_car = np.hypot(cloud[:, 0], cloud[:, 1]) < 2
obstacles = cloud[(cloud[:, 2] > -1.2) & ~ego_car]
xyz = obstacles[:, :3]
street = ((-20, 40), (-15, 15))  # limits of x and y, for pictures
plots.from_above(obstacles, limits=street, title=f"{len(obstacles):,} points to cluster");

# %% [markdown]
# Clustering begins with a search for neighbours: points that are closer to each other than the threshold, here half a metre. In lesson 05, you compared each point with all others.

# %%
seconds_guess = predict("How long does it take to compare each of these points with all others?",
                        choices=["a second or two", "a minute or two", "an hour or two"])
neighbours_guess = predict("How many neighbours within half a metre does a point have, on average?")

# %% [markdown]
# ## The naive idea: one search for every point
#
# *A tree makes each search fast, but there are still fifty thousand searches.*
#
# The next cells time two ways to find all neighbours. The first compares each point with all others. The second searches a [kd-tree](#Words-of-the-course). SciPy's `cKDTree` is the tree from lesson 04 in compiled code. Each way is timed on a sample of the points, and the time is scaled up. The cell measures processor time, which other programs hardly affect.

# %%
def neighbours_by_comparing(points, asked):
    """Return the rows of all points within half a metre of each point in `asked`."""
    return [np.flatnonzero(np.linalg.norm(points - point, axis=1) < 0.5) for point in asked]


def neighbours_by_tree(points, asked):
    """Return the same rows, but find them with a kd-tree."""
    tree = cKDTree(points)
    return [tree.query_ball_point(point, 0.5) for point in asked]

# %% tags=["folded"]
# @title A stopwatch (you need not read this)
def timed(work, *arguments):
    """Return the answer and the processor time in seconds, as a mean if the work is short."""
    begin, rounds, spent = process_time(), 0, 0.0
    while spent < 0.05:
        answer, rounds, spent = work(*arguments), rounds + 1, process_time() - begin
    return answer, spent / rounds


def seconds_of(work, *arguments):
    return timed(work, *arguments)[1]

# %%
finding = {}  # seconds to find the neighbours of all points
for find, share in ((neighbours_by_tree, 5), (neighbours_by_comparing, 300)):
    seconds = finding[find] = share * seconds_of(find, xyz, xyz[::share])
    print(f"{find.__name__:>23}: about {seconds:6.1f} s, {seconds / 0.1:5.0f} turns of the scanner")

seconds_guess.compare(
    "a second or two" if seconds < 8 else "a minute or two" if seconds < 900 else "an hour or two",
    f"{len(xyz):,} points times {len(xyz):,} points give {len(xyz) ** 2 / 1e9:.1f} billion "
    f"distances. NumPy needs about {1e9 * seconds / len(xyz) ** 2:.0f} nanoseconds for each.")

# %% [markdown]
# The tree is far faster, but still far too slow. And you must still join the neighbours into clusters, which takes additional time.
#
# ## All pairs at once
#
# *Compiled code can list and join all pairs, but the list is long.*
#
# Two SciPy functions find and join all pairs in compiled code. `query_pairs` lists all pairs of points that are within a given distance of each other. `connected_components` finds the [components](#Words-of-the-course) of a graph. Below, `components` calls `connected_components` for pairs of nodes. `join_all_pairs` calls `query_pairs` and then `components`:

# %%
def components(count, pairs):
    """Return the component of each of `count` nodes. Each row of `pairs` (m, 2) joins two."""
    pairs = np.reshape(pairs, (-1, 2)).astype(int, copy=False)
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


print("seven nodes, four pairs:", components(7, [(0, 2), (4, 0), (5, 2), (1, 3)]))


def join_all_pairs(points, threshold=0.5):
    pairs = cKDTree(points).query_pairs(threshold, output_type="ndarray")
    return components(len(points), pairs)


from_pairs, seconds = timed(join_all_pairs, xyz)
print(f"{len(xyz):,} points, {from_pairs.max() + 1} clusters, {seconds:.2f} s: "
      f"{seconds / 0.1:.0f} turns of the scanner")
listing = seconds_of(lambda: cKDTree(xyz).query_pairs(0.5, output_type="ndarray"))
print(f"listing the pairs alone: {listing:.2f} s")

# %% [markdown]
# This code is correct, short, and fast enough for many purposes. It takes about as long as the tree searches above, and often less. Most of its time goes into joining, because there are so many pairs.
#
# But it still takes many turns of the scanner, and each pair needs 16 bytes of memory. The number of pairs depends on the density and the threshold, so **count before you list**. With `return_length=True`, the tree only counts:

# %%
few, table = xyz[::20], []  # every twentieth point is enough for an estimate
for threshold in (0.25, 0.5, 1.0, 2.0):
    neighbours = cKDTree(xyz).query_ball_point(few, threshold, return_length=True) - 1
    pairs = 20 * neighbours.sum() / 2
    table.append((f"{threshold} m", f"{neighbours.mean():,.0f}", f"{pairs / 1e6:.1f} million",
                  f"{16 * pairs / 1e6:,.0f} MB"))
    if threshold == 0.5:
        close_pairs = round(pairs, -5)  # to the nearest hundred thousand
        neighbours_guess.compare(
            neighbours.mean(), "Points are dense near the scanner. The side of a parked car has "
            "thousands of returns, so each of them has hundreds of neighbours.")
show_table(["threshold", "neighbours per point", "pairs", "memory"], table)

# %% [markdown]
# If you double the threshold, the list becomes 2 to 3.5 times as long, although there are *fewer* clusters to find. Twice as many points in the same street give *four* times as many pairs.
#
# ## Nearly all pairs tell us nothing new
#
# *Joining n points takes n − 1 pairs. The list has more than a hundred times as many.*
#
# If a is near b and b is near c, then all three are in the same [cluster](#Words-of-the-course), and the distance from a to c tells us nothing new. Most pairs are in dense patches of the cloud. Can you find whole *groups* of points that belong together without measuring any distance?
#
# Divide space into cubes, called **cells**. Two points in a cube of side $s$ are never farther apart than its diagonal, $s\sqrt{3}$. If the threshold is $r$ and
#
# $$s = \frac{r}{\sqrt 3}$$
#
# then the diagonal is $r$, so **points that share a cell share a cluster**. The picture shows the same idea in the plane. The diagonal of a square is $s\sqrt2$, so there $s = r / \sqrt 2$:

# %% tags=["folded"]
# @title One car: all pairs of neighbours, and the cells (you need not read this)
x, y = xyz[:, 0], xyz[:, 1]
car = xyz[(x > 5) & (x < 10) & (y > -5) & (y < 0.5), :2]
car = car[np.random.default_rng(2).choice(len(car), min(250, len(car)), replace=False)]
web = cKDTree(car).query_pairs(0.5, output_type="ndarray")
side = 0.5 / np.sqrt(2)
first_in_cell = {}
for row, cell in enumerate(map(tuple, np.floor(car / side))):
    first_in_cell.setdefault(cell, row)  # the first point represents its cell
representatives = np.array(list(first_in_cell.values()), dtype=int)

figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 5.2), layout="compressed")
window = ((5, 9.6), (-4.2, 0.3))
plots.graph(car, web, limits=window, axes=left, title=f"{len(car)} points")
plots.graph(car, limits=window, axes=right, title=f"{len(representatives)} cells")
right.get_legend().remove()
right.plot(*car[representatives].T, "s", markersize=9, markerfacecolor="none", color="black")
right.set_xticks(np.arange(np.ceil(5 / side), 9.6 / side) * side, minor=True)
right.set_yticks(np.arange(np.ceil(-4.2 / side), 0.3 / side) * side, minor=True)
right.grid(False)
right.grid(which="minor", color="black", alpha=0.4, linewidth=0.8)  # behind the squares

# %% [markdown]
# From now on, you cluster *cells* instead of points, because there are far fewer. One point of each cell is its **representative**, marked with a square.
#
# ## Step 1 · Which points share a cell?
#
# *Three whole numbers identify a cell.*
#
# For a threshold of 0.5 m, a cell in space is 0.5 / √3 = 0.289 m wide. Along one axis, a point at 1.2 m is in cell 4, because 1.2 / 0.289 = 4.15 is rounded down. Sorting single numbers is several times faster than sorting rows, so the folded function `as_numbers` from lesson 06 turns each row into one number. `np.unique` then finds the different numbers, and on request it returns two more arrays:

# %% tags=["folded"]
# @title Turn each row into one number (you need not read this)
def as_numbers(rows):
    """Return one whole number for each row of whole numbers; only equal rows share a number."""
    rows = np.asfortranarray(rows)  # stored column by column, which is faster here
    rows = rows - rows.min(axis=0)
    extent = rows.max(axis=0) + 1
    if not np.log2(extent).sum() < 62:  # too many different rows for whole numbers
        return np.unique(rows, axis=0, return_inverse=True)[1].ravel()
    return np.ravel_multi_index(rows.T.astype(int), extent.astype(int))

# %%
rows = np.array([[4, 1], [0, 2], [4, 1], [4, 0]])
numbers, first, which = np.unique(as_numbers(rows), return_index=True, return_inverse=True)
print("a number for each row:           ", as_numbers(rows))
print("the different numbers, sorted:   ", numbers)
print("row where each first occurs:     ", first)
print("so these are the different rows: ", rows[first].tolist())
print("place of each row among these:   ", which)

# %% nbgrader={"grade": false, "grade_id": "points_in_cells", "locked": false, "schema_version": 3, "solution": true, "task": false}
def points_in_cells(points, threshold):
    """Assign points to cells so small that all points of a cell belong together.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        x, y, z in metres; at least one point.
    threshold : float
        Two points closer than this belong together, in metres.

    Returns
    -------
    cells : ndarray, shape (m, 3)
        The different cells, each as three whole numbers.
    first : ndarray of int, shape (m,)
        The row of the first point in each cell: its representative.
    cell_of_point : ndarray of int, shape (n,)
        For each point, the row of its cell in `cells`.
    """
    # 1. Compute the side of a cell whose diagonal is the threshold.
    # 2. Find the cell of each point along x, y and z: round down, even below zero.
    # 3. Find the different cells, `first` and `cell_of_point` with np.unique, as above.
    # roughly 3 lines
    ### BEGIN SOLUTION
    cells = np.floor(points / (threshold / np.sqrt(3)))
    _, first, cell_of_point = np.unique(as_numbers(cells), return_index=True, return_inverse=True)
    return cells[first], first, cell_of_point
    ### END SOLUTION

# %% [markdown]
# <details><summary>A hint for step 1</summary>
#
# `np.floor(points / side)` does step 2 for all points at once. Use the result in place of `rows` above. Then `rows[first]` are the different cells. Do not replace `np.floor` with `.astype(int)`, because that rounds −0.4 to 0.
# </details>
#
# **Try it on seven points**, called a to g, which are all at z = 0. Point a is in row 0 of the array, and point g is in row 6. With a threshold of √3 m, a cell is 1 m wide, so the coordinates of a point show its cell.

# %% tags=["folded"]
# @title Seven points, and how they are drawn (you need not read this)
seven = np.array([[0.1, 0.2, 0], [1.2, 0.9, 0], [2.7, 0.5, 0], [2.95, 0.3, 0], [4.6, 0.2, 0],
                  [6.1, 0.7, 0], [-0.4, 2.6, 0]])
letters = np.array(list("abcdefg"))  # the names of the points, in the order of the rows


def show_both(name, yours, expected):
    """Print an answer and the expected one, and return whether they agree."""
    verdict = "agrees" if yours == expected else "differs"
    print(f"{name:>18}: {yours}\n{'expected':>18}: {expected}   <- {verdict}")
    return yours == expected


def draw_seven(cells, first, joined=(), still_open=(), pieces=(), close=(), title=None):
    """Draw the points in their cells, with lines for pairs and colours for pieces."""
    axes = plots.graph(seven[:, :2], names=letters, limits=((-1.3, 7.3), (-0.3, 3.3)), title=title)
    axes.set_xticks(range(-1, 8))
    axes.set_yticks(range(0, 4))
    axes.get_legend().remove()
    colours = {piece: f"C{number}" for number, piece in enumerate(dict.fromkeys(pieces))}
    for number, (left, low) in enumerate(cells[:, :2]):
        colour = colours[pieces[number]] if len(pieces) else "#56B4E9"
        axes.add_patch(plt.Rectangle((left, low), 1, 1, facecolor=colour, alpha=0.25,
                                     edgecolor="black"))
        axes.text(left + 0.96, low + 0.94, f"cell {number}", ha="right", va="top", fontsize=9.5)
    axes.plot(*seven[first, :2].T, "s", markersize=13, markerfacecolor="none", color="black")
    for pairs, line in ((joined, "-"), (still_open, ":")):
        for a, b in pairs:
            axes.plot(*seven[first[[a, b]], :2].T, line, color="#D55E00", linewidth=2.2, zorder=1.5)
    for a, b in close:
        axes.plot(*seven[[a, b], :2].T, ":", color="black", linewidth=2.2, zorder=1.5)
    return axes


def groups_of(label):
    """Return lists of the rows that have the same label."""
    return [np.flatnonzero(label == one).tolist() for one in dict.fromkeys(label.tolist())]

# %%
cells, first, cell_of_point = points_in_cells(seven, np.sqrt(3))
show_both("cells, x and y", cells[:, :2].astype(int).tolist(),
          [[-1, 2], [0, 0], [1, 0], [2, 0], [4, 0], [6, 0]])
show_both("representatives", letters[first].tolist(), ["g", "a", "b", "c", "e", "f"])
show_both("cells of a to g", cell_of_point.tolist(), [1, 2, 3, 3, 4, 5, 0])
draw_seven(cells, first, title="Seven points in six cells");

# %% [markdown]
# Points c and d share cell 3, and point c represents both. If your point g is in a different cell, check how you round negative numbers.

# %%
check(points_in_cells)

# %% [markdown]
# ## Which cells belong together?
#
# *First join without measuring, then with one distance for each pair of cells, and only then point by point.*
#
# Two points that are closer than $r = s\sqrt3 \approx 1.73\,s$ are at most **two cells apart** along each axis. So the neighbours of a cell are all in the block of $5 \times 5 \times 5$ cells around it. A kd-tree of the cells finds these neighbours if it measures the largest coordinate difference (`p=np.inf`) instead of the usual distance:

# %%
five = np.array([[0, 0, 0], [1, 0, 0], [2, 2, 1], [4, 0, 0], [0, 0, 3]])
print(cKDTree(five).query_pairs(2, p=np.inf, output_type="ndarray"))

# %% [markdown]
# Cells 0, 1 and 2 are within two steps of each other. Cells 3 and 4 are too far from cell 0, but they are two steps from cell 2.
#
# Neighbouring cells do not always belong together. If two cells are two steps apart, their points may be nearly $3s$ apart along each axis. So you measure, in two steps:
#
# - **Cheap.** Are the two *representatives* closer than $r$? Then join the cells. This takes one distance for each pair of cells. Cells that are joined, directly or through others, form a **piece**.
# - **Exact.** Even if two representatives are farther apart than $r$, two other points of their cells may be close. But you need not measure cells that are already in the same piece. Two neighbouring cells in *different* pieces are called an **open pair**. Only open pairs are compared point by point.
#
# The picture shows two open pairs, again in the plane, for a threshold of 0.5 m:

# %% tags=["folded"]
# @title Two pairs of cells whose representatives are far apart (you need not read this)
one = np.array([[0.05, 0.20], [0.12, 0.06], [0.30, 0.12]])  # the first represents its cell
figure, panels = plt.subplots(2, 1, figsize=(8.5, 5.4), layout="compressed")
for axes, shift, verdict in ((panels[0], 0.0, "join"), (panels[1], 0.1, "stay apart")):
    other = np.array([[0.97, 0.25], [0.75 + shift, 0.14]])
    closest = np.array([one[2], other[1]])
    plots.graph(np.vstack([one, other]), limits=((-0.05, 1.1), (0, 0.35)), axes=axes,
                title=f"Representatives {dist(one[0], other[0]):.2f} m apart, closest pair "
                      f"{dist(*closest):.2f} m: {verdict}")
    axes.get_legend().remove()
    axes.plot(*np.array([one[0], other[0]]).T, "s", markersize=11, markerfacecolor="none",
              color="black")
    axes.plot(*closest.T, color="black", linestyle=":")
    axes.set_xticks(np.arange(4) * side, ["0", "s", "2s", "3s"])
    axes.set_yticks([])
    axes.set_xlabel("x, in sides of a cell")
    axes.set_ylabel("")
    axes.grid(True, axis="x", color="black", linewidth=0.8)

# %% [markdown]
# ## Step 2 · The cheap join
#
# *One distance between representatives decides most pairs of cells.*
#
# Do this by eye first, in the picture of the seven points. Which cells are at most two steps apart? Join those whose representatives are closer than √3 ≈ 1.73 m. Then count the open pairs.

# %%
puzzle = predict("Seven points, six cells: how many open pairs are left?")

# %% nbgrader={"grade": false, "grade_id": "join_cheaply", "locked": false, "schema_version": 3, "solution": true, "task": false}
def join_cheaply(points, cells, first, threshold):
    """Join neighbouring cells whose representatives are close.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    cells : ndarray, shape (m, 3)
        From step 1, like `first`.
    first : ndarray of int, shape (m,)
    threshold : float

    Returns
    -------
    pairs : ndarray of int, shape (k, 2)
        All pairs of cells at most two steps apart along each axis, joined or not.
    label : ndarray of int, shape (m,)
        For each cell, the number of its piece.
    """
    # 1. Find all pairs of cells at most two steps apart, as with the five cells above.
    # 2. For each pair, compute the distance between the two representatives.
    # 3. Keep the pairs with a small distance. The components that they form are the pieces.
    # roughly 3 lines
    ### BEGIN SOLUTION
    pairs = cKDTree(cells).query_pairs(2, p=np.inf, output_type="ndarray")
    gap = np.linalg.norm(points[first[pairs[:, 0]]] - points[first[pairs[:, 1]]], axis=1)
    return pairs, components(len(cells), pairs[gap < threshold])
    ### END SOLUTION

# %% [markdown]
# <details><summary>A hint for step 2</summary>
#
# `pairs[:, 0]` and `pairs[:, 1]` are two arrays of cell numbers. `first[...]` turns cell numbers into rows of `points`, and `points[...]` turns these rows into coordinates. Subtract the two arrays of coordinates and take `np.linalg.norm(..., axis=1)`. A mask then keeps the rows of `pairs` with a small distance.
# </details>

# %%
pairs, label = join_cheaply(seven, cells, first, np.sqrt(3))
differs = label[pairs[:, 0]] != label[pairs[:, 1]]
pairs_agree = show_both("neighbouring cells", sorted(pairs.tolist()),
                        [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [3, 4], [4, 5]])
pieces_agree = show_both("pieces", groups_of(label), [[0], [1, 2, 3], [4, 5]])
if pairs_agree and pieces_agree:
    puzzle.compare(differs.sum(), "Seven pairs of cells are neighbours. Three are joined: 1 with "
                   "2, 2 with 3, and 4 with 5. Cells 1 and 3 are then in the same piece as well, "
                   "through cell 2. Three open pairs are left.")
draw_seven(cells, first, pairs[~differs], pairs[differs],
           title="Solid lines: same piece. Dotted lines: open pairs");

# %%
check(join_cheaply)

# %% [markdown]
# **On the street.** After two steps, the picture is nearly right.

# %%
def after_two_steps(points, threshold=0.5):
    """Return labels after steps 1 and 2, and the numbers of cells, pairs and open pairs."""
    grid, first, where = points_in_cells(points, threshold)
    near, piece = join_cheaply(points, grid, first, threshold)
    differs = piece[near[:, 0]] != piece[near[:, 1]]
    return piece[where] + 1, len(grid), len(near), int(differs.sum())

# %%
nearly, cell_count, pair_count, open_count = after_two_steps(xyz)
print(f"{len(xyz):,} points in {cell_count:,} cells; {pair_count:,} pairs of neighbouring cells, "
      f"of which {open_count:,} ({open_count / pair_count:.1%}) are open")
print(f"{nearly.max()} pieces so far; there should be {from_pairs.max() + 1} clusters")

# %% [markdown]
# How many pairs did you save? Each bar counts the pairs that one way must look at. Each vertical line stands for ten times as many pairs as the line before it.

# %%
axes = plots.compare({"all pairs of points": len(xyz) * (len(xyz) - 1) // 2,
                      "pairs of neighbouring points": close_pairs,
                      "pairs of neighbouring cells": pair_count,
                      "open pairs of cells": open_count},
                     label="number of pairs", title="Each idea leaves far fewer pairs")
axes.set(xscale="log", xlim=(1, 1e11))
axes.set_xticks(10.0 ** np.arange(12));

# %% tags=["folded"]
# @title Draw the pieces, with rings around torn clusters (you need not read this)
def ring_parts(axes, points, whole, parts):
    """Draw rings around the smaller parts of torn clusters in `whole`, without overlaps."""
    found = []
    for name in np.unique(whole):
        mine = np.flatnonzero(whole == name)
        names, sizes = np.unique(parts[mine], return_counts=True)
        for part in names[np.argsort(sizes)[:-1]]:
            chosen = points[mine[parts[mine] == part], :2]
            middle = np.median(chosen, axis=0)
            spread = np.quantile(np.linalg.norm(chosen - middle, axis=1), 0.9)
            found.append([*middle, min(max(0.8, spread), 2)])
    drawn = []
    for ring in sorted(found, key=lambda ring: -ring[2]):
        if all(dist(ring[:2], other[:2]) > ring[2] + other[2] for other in drawn):
            drawn.append(ring)
            plots.ring(axes, *ring[:2], radius=ring[2])


def with_other_colours(points, whole, parts):
    """Return the labels `whole`, with a new one for each smaller part of a torn cluster.

    Its colour is the one, of seven, whose nearest other point is farthest away.
    """
    labels = whole.copy()
    for name in np.unique(whole):
        mine = np.flatnonzero(whole == name)
        names, sizes = np.unique(parts[mine], return_counts=True)
        for part in names[np.argsort(sizes)[:-1]]:
            chosen = mine[parts[mine] == part]
            away = np.linalg.norm(points[:, :2] - np.median(points[chosen, :2], axis=0), axis=1)
            away[chosen] = np.inf
            new = labels.max() + 1 + np.arange(7)
            labels[chosen] = max(new, key=lambda label: away[labels % 7 == label % 7].min())
    return labels


far = ((20, 40), (-7, 7))
seen = (x > 20) & (x < 40) & (np.abs(y) < 7)
here = len(np.unique(nearly[seen]))
coloured = with_other_colours(xyz[seen], from_pairs[seen] + 1, nearly[seen])
axes = plots.clusters(obstacles[seen], coloured, limits=far,
                      title=f"{here} pieces after two steps: rings show torn clusters")
axes.get_legend().remove()
ring_parts(axes, xyz[seen], from_pairs[seen], nearly[seen])

# %% [markdown]
# The cheap step leaves about one pair in fifty open. Without the exact step, clusters stay torn where points are sparse. Each ring is around a piece that is separated from the rest of its cluster, so its colour differs from the colour of the rest.
#
# **A good place to stop.** Save the notebook. You have the grid and the cheap join. When you come back, run all cells from the top.
#
# ## Step 3 · The exact join
#
# *Compare point by point, but only pairs that are still open.*
#
# Now `label` holds the piece of each cell, and only open pairs are left to measure.
#
# What is the smallest distance between two groups of points, `p` and `q`? For each point of `q`, `cKDTree(p).query(q)` finds the nearest point of `p`. It returns two arrays: the distances, and the rows of these nearest points. It does not store a table of all distances, so it also works for thirty thousand points. For a few points, such a table is faster. `smallest_distance` chooses between these two ways:

# %%
p, q = seven[:4], seven[4:]
distances, nearest = cKDTree(p).query(q)
print("from e, f, g to the nearest of a to d:", distances.round(2), "  these are", letters[nearest])


def smallest_distance(p, q):
    """Return the smallest distance between a point of p, shape (k, 3), and one of q, (l, 3)."""
    if len(p) * len(q) <= 100:
        return np.linalg.norm(p[:, np.newaxis] - q, axis=2).min()
    return cKDTree(p).query(q)[0].min()


print(f"smallest distance: {smallest_distance(p, q):.2f} m")

# %% [markdown]
# Find this distance for each open pair, in a loop. The loop follows three rules:
#
# - **Relabel the whole piece.** If a point of cell `i` is close to a point of cell `j`, all cells in the piece of `j` get the label of `i`: `label[label == label[j]] = label[i]`.
# - **Compare the labels again before you measure.** The loop may have joined the two pieces in the meantime.
# - **Change a copy of `label`**, so that you can run the cell below twice.
#
# `points_by_cell` gives you the points of each cell:

# %%
def points_by_cell(points, cell_of_point):
    """Return a list with one array for each cell: its points, shape (k, 3)."""
    points, ends = points[np.argsort(cell_of_point)], np.cumsum(np.bincount(cell_of_point))
    return [points[start:end] for start, end in zip([0, *ends], ends)]


for cell, inside in enumerate(points_by_cell(seven, cell_of_point)):
    print(f"cell {cell}:", inside.tolist())
print("open pairs of cells:", pairs[differs].tolist())

# %% nbgrader={"grade": false, "grade_id": "join_exactly", "locked": false, "schema_version": 3, "solution": true, "task": false}
def join_exactly(points, cell_of_point, pairs, label, threshold):
    """Join two pieces if a point of one is closer than the threshold to a point of the other.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    cell_of_point : ndarray of int, shape (n,)
        From step 1.
    pairs : ndarray of int, shape (k, 2)
        From step 2, like `label`.
    label : ndarray of int, shape (m,)
    threshold : float

    Returns
    -------
    ndarray of int, shape (m,)
        For each cell, the number of its piece. There may be gaps in the numbers.
    """
    # 1. Get the points of each cell, and copy the labels.
    # 2. For each open pair, check that its two labels still differ, and that the smallest
    #    distance between the points of its two cells is below the threshold.
    # 3. If both are true, relabel one of the two pieces.
    # roughly 5 lines
    ### BEGIN SOLUTION
    inside, label = points_by_cell(points, cell_of_point), label.copy()
    for i, j in pairs[label[pairs[:, 0]] != label[pairs[:, 1]]]:
        if label[i] != label[j] and smallest_distance(inside[i], inside[j]) < threshold:
            label[label == label[j]] = label[i]
    return label
    ### END SOLUTION

# %% [markdown]
# <details><summary>A hint for step 3</summary>
#
# `pairs[mask]` are the open pairs. Compute the mask in the same way as `differs` for the seven points. `for i, j in pairs[mask]:` goes through the open pairs. After `inside = points_by_cell(points, cell_of_point)`, the points of the two cells are `inside[i]` and `inside[j]`.
# </details>

# %%
exact = join_exactly(seven, cell_of_point, pairs, label, np.sqrt(3))
show_both("pieces", groups_of(exact), [[0], [1, 2, 3, 4, 5]])
draw_seven(cells, first, pieces=exact.tolist(), close=[(3, 4)],
           title=f"Dotted: points d and e are {dist(seven[3], seven[4]):.2f} m apart. "
                 "Same colour: same piece");

# %%
check(join_exactly)

# %% [markdown]
# ## Exercise · `euclidean_clustering_accelerated` (points)
#
# *Find exactly the same clusters as in lesson 05.*
#
# Put the three steps together. A scan of 50,000 points must take well under ten seconds. A dense heap of tens of thousands of points, such as a wall right in front of the sensor, must neither fill the memory nor take minutes. The three steps meet these demands, but you may use any other method that meets them. The clouds contain no NaN rows.
#
# - **Allowed:** NumPy, `scipy.spatial`, `scipy.sparse` with `connected_components`, the other packages named at the end of this notebook, and helper functions of your own.
# - **Not allowed:** libraries that do the clustering: `sklearn.cluster`, `scipy.cluster`, `hdbscan`, `dbscan`, `open3d`, `pcl`.
#
# One thing is new. The numbers of the pieces have gaps, but the clusters get the labels 1, 2, 3 and so on, in the order in which they first appear in the cloud. (You lose no points for another order, or for the gaps that the exact step leaves, if the labels start at 1 and group the same points.) `np.unique` helps again:

# %%
pieces = np.array([7, 3, 7, 5])  # the pieces of four points
names, start, which = np.unique(pieces, return_index=True, return_inverse=True)
print("different pieces:", names, "  first seen in row:", start, "  piece of each point:", which)
print("ranks of", start, "are", np.argsort(np.argsort(start)), "   labels should be [1 2 1 3]")

# %% [markdown]
# Piece 7 is first seen in row 0, so it has rank 0. Piece 3 is next, and piece 5 is last. The first `argsort` lists the pieces in this order, and the second finds the place of each piece in the list. The label of a piece is its rank plus 1.

# %% nbgrader={"grade": false, "grade_id": "euclidean_clustering_accelerated", "locked": false, "schema_version": 3, "solution": true, "task": false}
def euclidean_clustering_accelerated(cloud, threshold=0.5):
    """Group the points of a cloud into clusters of connected neighbours, quickly.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity. May be empty.
    threshold : float
        Two points closer than this belong together, in metres.

    Returns
    -------
    ndarray of int, shape (n,)
        The label of each point, from 1 to the number of clusters, in the order in which
        the clusters first appear in the cloud.
    """
    # 1. Use x, y and z only; an empty cloud has no labels.
    # 2. Call your three steps, one line each.
    # 3. Give each point the piece of its cell.
    # 4. Number them 1, 2, ... in order of first appearance.
    # roughly 8 lines
    ### BEGIN SOLUTION
    points = np.asarray(cloud)[:, :3]
    if len(points) == 0:
        return np.zeros(0, dtype=int)
    cells, first, cell_of_point = points_in_cells(points, threshold)
    pairs, label = join_cheaply(points, cells, first, threshold)
    label = join_exactly(points, cell_of_point, pairs, label, threshold)
    _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
    return np.argsort(np.argsort(start))[which] + 1
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Each step uses the results of the steps before it. Take `cloud[:, :3]` first, because intensity is not a coordinate.
# </details>
# <details><summary>Hint 2</summary>
#
# `label` has one entry for each cell. `label[cell_of_point]` has one entry for each point, like `pieces` above. For an empty cloud, return `np.zeros(0, dtype=int)` at once.
# </details>
# <details><summary>Hint 3</summary>
#
# Treat `label[cell_of_point]` like `pieces` above. Compute the ranks of `start`, use `[which]` to get one rank for each point, and add 1.
# </details>

# %% [markdown]
# **Look before you check.** Six of the seven points belong together. On the street, each car and each wall should have one colour, not many.

# %%
print("seven points:", euclidean_clustering_accelerated(seven, np.sqrt(3)),
      "  expected: [1 1 1 1 1 1 2]")
labels, seconds = timed(euclidean_clustering_accelerated, obstacles)
if is_written(euclidean_clustering_accelerated):
    print(f"{labels.max()} clusters of {len(obstacles):,} points in {seconds:.2f} s: "
          f"{seconds / 0.1:.1f} turns of the scanner")
plots.clusters(obstacles, labels, names=True, limits=street, title="Your clusters");

# %% nbgrader={"grade": true, "grade_id": "test_euclidean_clustering_accelerated", "locked": true, "points": 30, "schema_version": 3, "solution": false, "task": false}
check(euclidean_clustering_accelerated)

# %% [markdown]
# Are these *exactly* the clusters from all pairs? Put the two labels of each point side by side. If the clusters are the same, each label on one side is always next to the same label on the other side. Then there are as many different pairs of labels as there are labels on each side.

# %%
def same_clusters(labels, others):
    """Return whether two arrays of labels form the same groups, even if the numbers differ."""
    combinations = np.unique(np.stack([labels, others]), axis=1).shape[1]
    return combinations == len(np.unique(labels)) == len(np.unique(others))


print(f"{len(np.unique(labels))} labels from you, {from_pairs.max() + 1} from all pairs:",
      "the same clusters" if same_clusters(labels, from_pairs) else "not the same clusters")
print("without the exact step:",
      "the same clusters" if same_clusters(nearly, from_pairs) else "not the same clusters")

# %% [markdown]
# **A good place to stop.** Save the notebook. Your clustering is exact. Next, you measure how its time grows, and look for inputs that break it. When you come back, run all cells from the top.
#
# ## Theory against practice: four ways on one chart
#
# *The slope of a line is the exponent of n. A faster computer only moves the line down.*
#
# The next cells thin the scan to different sizes and cluster it in four ways. This takes about ten seconds.

# %% tags=["folded"]
# @title Four ways, and their times at growing sizes (you need not read this)
def clusters_by(find):
    """Return a function that finds neighbours point by point and joins all pairs."""
    def way(points):
        near = find(points, points)
        rows = np.arange(len(points)).repeat([len(found) for found in near])
        return components(len(points), np.column_stack([rows, np.concatenate(near)]))
    return way


ways = {"compare with all": clusters_by(neighbours_by_comparing),
        "a tree, point by point": clusters_by(neighbours_by_tree),
        "all pairs": join_all_pairs}
if is_written(euclidean_clustering_accelerated):
    ways["yours"] = euclidean_clustering_accelerated
else:
    print("Your line will be missing, because you have not written the function yet.")
everything = cloud[~ego_car, :3]  # the largest size includes the road
series = {name: ([], []) for name in ways}  # sizes and seconds
agree = []  # whether two ways found the same clusters


def measure_ways():
    """Time all ways at growing sizes until they take half a second, and compare the clusters."""
    rng = np.random.default_rng(10)
    for n in (500, 1000, 2000, 4000, 8000, 20_000, len(xyz), len(everything)):
        sample = everything if n > len(xyz) else rng.permutation(xyz)[:n]
        found = []
        for name, way in ways.items():
            sizes, times = series[name]
            if not times or times[-1] < 0.5:
                answer, seconds = timed(way, sample)
                found.append(answer)
                sizes.append(n)
                times.append(seconds)
        agree.extend(same_clusters(found[0], other) for other in found[1:])

# %%
measure_ways()
print(f"compared {len(agree)} times: {'always' if all(agree) else 'NOT always'} the same clusters")
axes = plots.timing(series, title=f"{len(ways)} ways to the same clusters")
axes.axhline(0.1, color="black", linestyle=":")
axes.text(0.01, 0.11, "one turn of the scanner", ha="left", va="bottom",
          transform=axes.get_yaxis_transform());

# %% tags=["folded"]
# @title Print the times for all obstacles (you need not read this)
table = []
only_found = {"compare with all": neighbours_by_comparing,
              "a tree, point by point": neighbours_by_tree}
for name, (n, seconds) in series.items():
    if n[-1] >= len(xyz):
        spent, part = seconds[n.index(len(xyz))], ""
    else:  # too slow for all obstacles, so take the time from the first section
        spent, part = finding[only_found[name]], " (only finding neighbours)"
    spent = float(f"{spent:.2g}")
    table.append((f"{name}{part}", f"{spent:g} s", f"{spent / 0.1:g}"))
show_table(["all obstacles", "time", "turns of the scanner"], table)
if "yours" in series and series["yours"][0][-1] == len(everything):
    spent = series["yours"][1][-1]
    print(f"yours, with the road: {spent:.2f} s,", "less than one turn"
          if spent < 0.1 else "more than one turn")

# %% [markdown]
# A straight dashed line is fitted to the markers of each way. The legend gives its slope, which is the exponent of n.
#
# - **Compare with all.** In theory, this time grows as n². The exponent is smaller here, because each call of NumPy also takes a fixed time, which matters for small n.
# - **A tree, point by point.** The markers bend upwards, because each search returns more neighbours as the cloud becomes denser.
# - **All pairs.** Compiled code makes this way several times as fast. The markers rise slowly at first, and about as n² at the end, so the fitted exponent is between 1 and 2. In a sample of 500 points, there is only about one pair for each point. Most of the time goes into other work, which grows about as n. In the whole scan, there are more than a hundred pairs for each point. Most of the time goes into the pairs, whose number grows as n².
# - **Yours.** This line is the flattest, because a denser cloud mostly puts more points into the same cells. On such data, its exponent can even be below 1. For a few thousand points, however, listing all pairs is fastest.
#
# ## A threshold that grows
#
# *Far away, the beams are farther apart, so 0.5 m is too small there.*
#
# In lesson 05, every car beyond 40 m was in pieces. Beyond 40 m, there are few points, so you can list all pairs and give each pair a threshold of its own. Change the line with `limit`, so that the threshold is 0.2 m at the sensor and grows by 2 cm with each metre of distance. This task has no check. What does the larger threshold repair, and what does it cost?

# %%
def cluster_far(points):
    """Return the label of each point; the threshold may depend on the distance."""
    a, b = cKDTree(points).query_pairs(2.0, output_type="ndarray").T
    gap = np.linalg.norm(points[a] - points[b], axis=1)
    distance = np.hypot(points[a, 0], points[a, 1])  # from the sensor, one for each pair
    limit = 0.5 + 0 * distance  # change this line
    return components(len(points), np.column_stack([a, b])[gap < limit]) + 1

# %% tags=["folded"]
# @title Draw the cars beyond 40 m (you need not read this)
scan, truth = load_street()  # `truth` says what each return hit
is_far = (scan[:, 2] > -1.2) & (np.hypot(scan[:, 0], scan[:, 1]) > 40)
far_points, far_objects = scan[is_far, :3], truth["objects"][is_far]
far_labels = cluster_far(far_points)
on_car = truth["class_names"][truth["classes"][is_far]] == "car"
cars, returns = np.unique(far_objects[on_car], return_counts=True)
pieces = [set(far_labels[far_objects == car].tolist()) for car in cars[returns >= 10]]
torn = sum(len(names) > 1 for names in pieces)
shared = sum(any(names & others for others in pieces if others is not names) for names in pieces)
print(f"{len(pieces)} cars with at least ten returns: {torn} in pieces, "
      f"{shared} in a cluster with another car")
axes = plots.clusters(far_points[on_car], far_labels[on_car], limits=((38, 76), (-4, 9)),
                      title="Each colour and marker is one of your clusters")
axes.get_legend().remove()

# %% [markdown]
# <details><summary>An answer</summary>
#
# Write `limit = 0.2 + 0.02 * distance`. Only one of the five cars is still in pieces. One of its returns, at (56.0, 3.5), is now in the cluster of the car behind it, so two cars share a cluster. A growing threshold tears fewer distant cars, but it also joins some of them.
# </details>
#
# ## The trap: two heaps
#
# *Test the case that your shortcut does not cover.*
#
# Usually a cell holds a handful of points. But a wet wall just in front of the sensor, or several merged scans, can put thousands of points into one cell. Comparing all of them with each other is the old problem again. So the next cells cluster two heaps, first a little *more* than the threshold apart, then a little less.
#
# **Estimate before you run it.** With 20,000 points in each heap, a list of all pairs could fill your computer's memory. So the cell first tries heaps of 1,000 points and then of 3,000. With three times as many points, the time may be four times as long. If it is nine times as long, your function compares all pairs.

# %%
def two_heaps(n, gap):
    """Return two heaps of n points each, 20 cm wide, with a gap (m) between them."""
    heap = np.random.default_rng(11).uniform(0, 0.2, (n, 3))
    return np.vstack([heap, heap[:, [1, 2, 0]] + [0.2 + gap, 0, 0]])

# %% tags=["folded"]
# @title Small heaps first, large ones only if they will not take long (you need not read this)
def spring_the_trap(way, most=20_000):
    """Time a function on small heaps, and on large ones only if they will not take long."""
    times = []
    for n in (1_000, 3_000):
        times.append(seconds_of(way, two_heaps(n, 0.51)))
        print(f"{n:>6,} points in each heap: {times[-1]:7.3f} s")
    exponent = np.log(times[1] / times[0]) / np.log(3)
    expected = times[1] * (most / 3_000) ** max(exponent, 1)
    print(f"The time grows as n to the power of {exponent:.1f}. {most:,} points will take about "
          f"{expected:.1f} s; a list of all pairs would take {16 * most ** 2 / 1e9:.1f} GB.")
    if exponent > 1.6 or expected > 20:
        print("Stopped: the time grows as if you compared all pairs. Use a kd-tree instead.")
        return
    for gap in (0.51, 0.49):
        answer, seconds = timed(way, two_heaps(most, gap))
        found = len(np.unique(answer))
        print(f"{gap} m between the heaps: {found} cluster{'s' if found > 1 else ''} in "
              f"{seconds:.3f} s")

# %%
print("all pairs")
spring_the_trap(join_all_pairs)
if is_written(euclidean_clustering_accelerated):
    print("\nyours")
    spring_the_trap(euclidean_clustering_accelerated)

# %% [markdown]
# ## Common mistakes
#
# *Most give a fast answer that is nearly right.*
#
# | mistake | what you see |
# |---|---|
# | side of a cell = threshold | some objects merge although they are up to 1.7 thresholds apart |
# | neighbouring cells joined without measuring | objects merge everywhere, as with a threshold about 1.6 times as large |
# | representatives only, no exact step | objects are torn where points are sparse; if the cloud moves by 10 cm, some of them are whole and some others are torn |
# | only the 26 cells around a cell are searched | pairs two cells apart are missed, and one object in five is torn |
# | `.astype(int)` without `np.floor` | cells around the sensor are twice as wide |
# | `label[j] = label[i]` | only one cell changes its label, and the rest of its piece keeps the old one |
# | a list of all pairs | the clusters are right, until the memory is full |
# | the points thinned first | the clusters are right for the thinned cloud, but not for the full cloud |
#
# The pictures show the first three mistakes. Compare the colours inside each ring with the first picture. The first two mistakes give an object the colour of a larger neighbour, so the two are merged. The third mistake gives a part of an object a colour of its own, so the object is torn.

# %% tags=["folded"]
# @title Three mistakes on the street (you need not read this)
def grid_of(side):
    """Return the different cells of this side, the first point in each, and each point's cell."""
    names, place, which = np.unique(
        np.floor(xyz / side), axis=0, return_index=True, return_inverse=True)
    return names, place, which.ravel()


right = from_pairs + 1
_, place, which = grid_of(0.5)  # points that share such a cell are joined, even if far apart
same_cell = np.column_stack([from_pairs, from_pairs[place][which]])
names, place, where = grid_of(0.5 / np.sqrt(3))
touching = cKDTree(names).query_pairs(2, p=np.inf, output_type="ndarray")
wrong = {"Right": right,
         "Side of a cell = threshold": components(right.max(), same_cell)[from_pairs] + 1,
         "Joined without measuring": components(len(names), touching)[where] + 1,
         "Representatives only": join_all_pairs(xyz[place])[where] + 1}
seen = (x > 22) & (x < 44) & (np.abs(y) < 8)
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.4), layout="compressed")
for (title, found), axes in zip(wrong.items(), grid.flat):
    plots.clusters(obstacles[seen], found[seen], like=right[seen], limits=((22, 44), (-8, 8)),
                   axes=axes)
    axes.get_legend().remove()
    axes.set_xticks(range(25, 45, 5))
    axes.set_title(f"{title}: {found.max()} in all", loc="left", fontsize=11, fontweight="bold")
    ring_parts(axes, xyz[seen], right[seen], found[seen])  # torn
    ring_parts(axes, xyz[seen], found[seen], right[seen])  # merged

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(euclidean_clustering_accelerated)

# %% [markdown]
# ## In practice
#
# Libraries call the threshold *tolerance* or *eps*.
#
# ```python
# labels = sklearn.cluster.DBSCAN(eps=0.5, min_samples=1).fit_predict(xyz)     # scikit-learn
# labels = np.array(point_cloud.cluster_dbscan(eps=0.5, min_points=1))         # Open3D
# extraction.setClusterTolerance(0.5); extraction.extract(indices);            // PCL, in C++
# ```
#
# - Many scanners deliver their points as an image, with rows and columns. One pass over this image then finds all neighbours.
# - Some libraries are not exact and do not say so. Take the points (0.042, 1.027, −0.947), (0.645, 0.226, −0.078), (0.288, 0.269, −0.423) and (0.055, 0.609, −0.429). At a threshold of 0.5, the package `dbscan` 1.0.0 separates two of them, although they are only 0.498 apart. Keep a slow but safe version, and compare which points it groups together.
#
# ## Summary
#
# - Measure first. Here, most of the time went into pairs that tell us nothing new.
# - Points in a cell of side $r/\sqrt3$ belong together without measuring. Cells more than two steps apart are never neighbours.
# - Join without measuring first, then cheaply, and compare points only for pairs that are still open. The result is fast *and* exact.
# - Test the case that your shortcut does not cover, and estimate the cost before you run it.
#
# **Sources.** Cells of side $r/\sqrt{d}$ for DBSCAN: [Gunawan 2013](https://research.tue.nl/en/studentTheses/a-faster-algorithm-for-dbscan) (in the plane), [Gan and Tao 2015](https://doi.org/10.1145/2723372.2737792). The parallel, exact algorithm behind the `dbscan` package: [Wang, Gu and Shun 2020](https://doi.org/10.1145/3318464.3380582). Connected components: [SciPy](https://docs.scipy.org/doc/scipy/reference/generated/scipy.sparse.csgraph.connected_components.html). Clustering in the scanner's image: [Bogoslavskyi and Stachniss 2016](https://doi.org/10.1109/IROS.2016.7759050).
#
# **Next:** 11 · Boxes that turn

# %% [markdown]
# ## If you want more
#
# ### One tree for all open pairs
#
# *About 15 minutes.* Your loop handles more than a thousand open pairs one by one. A single tree can handle all of them at once, if it keeps the pairs apart.
#
# Think of a building with one floor for each cell. Each point gets a fourth coordinate, the height of its floor. The floors are two thresholds apart, so points on different floors are never close. For each open pair, the points of the fuller cell stay at home on their own floor (array `p`). The points of the other cell visit this floor (array `q`). In a crowded cell, points that are a threshold or more away from the other cell's bounding box are skipped.

# %%
def on_floors(points, cell_of_point, open_pairs, threshold):
    """Return the points of open pairs of cells, with one cell visiting the floor of the other.

    From cells with a hundred points or more, take only points that may be close to the other.

    Returns
    -------
    p, q : ndarray, shape (k, 4) and (l, 4)
        Points at home, and points on a visit: x, y, z, height of the floor.
    pair_of_q : ndarray of int, shape (l,)
        For each point of `q`, the row of the open pair for which it visits.
    """
    order, sizes = np.argsort(cell_of_point), np.bincount(cell_of_point)
    by_cell, ends = points[order], np.cumsum(sizes)
    low, high = (each.reduceat(by_cell, ends - sizes) for each in (np.minimum, np.maximum))

    def near(cells, others):
        many = sizes[cells]
        pair = np.repeat(np.arange(len(cells)), many)
        # The points of a cell are the last rows of by_cell before its end.
        rows = np.arange(len(pair)) + np.repeat(ends[cells] - np.cumsum(many), many)
        in_box = np.clip(by_cell[rows], low[others][pair], high[others][pair])
        close = np.linalg.norm(by_cell[rows] - in_box, axis=1) < threshold
        comes = close | (many[pair] < 100)
        return rows[comes], pair[comes]

    most_first = np.argsort(-sizes[open_pairs], axis=1, kind="stable")
    hosts, guests = np.take_along_axis(open_pairs, most_first, axis=1).T
    at_home = np.unique(near(hosts, guests)[0])
    visiting, pair = near(guests, hosts)
    p = np.column_stack([by_cell[at_home], 2 * threshold * cell_of_point[order[at_home]]])
    return p, np.column_stack([by_cell[visiting], 2 * threshold * hosts[pair]]), pair


def join_on_floors(points, cell_of_point, pairs, label, threshold):
    """Join pieces like `join_exactly`, with one tree for all open pairs."""
    apart = label[pairs[:, 0]] != label[pairs[:, 1]]
    p, q, pair_of_q = on_floors(points, cell_of_point, pairs[apart], threshold)
    distances, _ = cKDTree(p).query(q, distance_upper_bound=threshold)
    touching = pairs[apart][pair_of_q[distances < threshold]]
    return components(label.max() + 1, label[touching])[label]


print("pieces:", groups_of(join_on_floors(seven, cell_of_point, pairs, label, np.sqrt(3))))

# %% tags=["folded"]
# @title Two storeys: the open pairs of the seven points (you need not read this)
p, q, _ = on_floors(seven, cell_of_point, pairs[differs], np.sqrt(3))
gaps, nearest = cKDTree(p).query(q)
figure, axes = plt.subplots(figsize=(8.5, 3.9), layout="compressed")


def place(x, y, height):
    """Return where to draw a point: y runs to the back, and the height of the floor upwards."""
    return x + 0.4 * y, 0.4 * y + 0.28 * height


for height in np.unique(p[:, 3]):
    floor = [place(x, y, height) for x, y in ((-1, -0.3), (7, -0.3), (7, 3), (-1, 3))]
    axes.add_patch(plt.Polygon(floor, facecolor="#56B4E9", alpha=0.18, edgecolor="black"))
    axes.text(*place(6.9, -0.15, height), f"floor of cell {height / np.sqrt(12):.0f}", ha="right")
for (x, y, _, height), near, gap in zip(q, p[nearest], gaps):
    ends = np.array([place(x, y, height), place(near[0], near[1], near[3])])
    axes.plot(*ends.T, "-" if gap < np.sqrt(3) else ":", color="#D55E00", linewidth=2)
    left = ends[0, 0] < ends[1, 0]
    axes.annotate(f"{gap:.2f} m", ends.mean(axis=0), (-4 if left else 2, 6), color="#D55E00",
                  textcoords="offset points", ha="right" if left else "left")
for rows, style, name in ((p, "o", "at home, in p"), (q, "s", "on a visit, in q")):
    axes.plot(*place(rows[:, 0], rows[:, 1], rows[:, 3]), style, color="black", markersize=7,
              markerfacecolor="black" if style == "o" else "white", label=name)
    for row in rows:
        letter = letters[(seven == row[:3]).all(axis=1)][0]
        axes.annotate(letter, place(row[0], row[1], row[3]), (-5, 7), textcoords="offset points")
axes.legend(loc="center right")
axes.set_axis_off()
axes.set_title("Two storeys: only points d and e are close", loc="left", fontweight="bold");

# %% [markdown]
# Compare the two ways on the street:

# %%
def time_steps(points, threshold=0.5):
    """Print how long each step takes, and how long step 3 takes with one tree."""
    (grid, first, where), one = timed(points_in_cells, points, threshold)
    (near, piece), two = timed(join_cheaply, points, grid, first, threshold)
    _, three = timed(join_exactly, points, where, near, piece, threshold)
    _, tree = timed(join_on_floors, points, where, near, piece, threshold)
    for step, seconds in zip(("1 cells", "2 cheap", "3 exact"), (one, two, three)):
        print(f"step {step}: {1000 * seconds:4.0f} ms, {seconds / (one + two + three):4.0%}")
    print(f"step 3 with one tree: {1000 * tree:4.0f} ms")

# %%
if all(map(is_written, (points_in_cells, join_cheaply, join_exactly))):
    time_steps(xyz)
else:
    print("Write the three steps first. Then this cell measures them.")

# %% [markdown]
# ### A faster version
#
# *Two hours or more.* Most of the remaining time goes into sorting and into trees. These ideas need less of both:
#
# 1. **Runs instead of points.** Consecutive points of a scan often share a cell. Sort and label such a run as a whole.
# 2. **No tree of cells.** Sort the cells by `(x * Y + y) * Z + z`. Then the cells of a column, and of columns next to each other, are consecutive, and a few binary searches in one array find the neighbours of all cells.
# 3. **Few pairs of cells.** Join each cell with only three neighbours at first. Then nine out of ten pairs of neighbouring cells are already in the same piece.
# 4. **Boxes first.** Before the exact step, discard pairs of cells whose bounding boxes are too far apart.
# 5. **No tree of points.** Compare the points of many small pairs of cells at once, in batches. Use a kd-tree only for large pairs.
#
# Unfold the next cell if you want to write such a version. The cell after it measures your version.

# %% nbgrader={"grade": false, "grade_id": "clustering_at_full_speed", "locked": false, "schema_version": 3, "solution": true, "task": false} tags=["folded"]
# @title An optional faster version (not graded)
def clustering_at_full_speed(cloud, threshold=0.5):
    """Return the same labels as `euclidean_clustering_accelerated`, but faster.

    Parameters and result are the same.
    """
    # 1. Turn each cell into one number, and sort the runs of points by it.
    # 2. Join each cell with three neighbours, which you find by binary search.
    # 3. Do the cheap join, only for neighbouring cells that are still in different pieces.
    # 4. Discard open pairs whose bounding boxes are too far apart.
    # 5. Compare points: those of small pairs in batches, those of large pairs with a kd-tree.
    # roughly 110 lines
    ### BEGIN SOLUTION
    # The same three steps, without a tree of cells; only large heaps need a tree of points.
    xyz = np.array(np.asarray(cloud)[:, :3].T, dtype=float, order="C")  # three long rows
    if not (xyz.size and threshold > 0):
        return np.arange(1, len(cloud) + 1)
    if not np.isfinite(xyz).all():  # a point with NaN is alone
        group, finite = np.arange(len(cloud)), np.isfinite(xyz).all(axis=0)
        group[finite] = len(cloud) + clustering_at_full_speed(xyz[:, finite].T, threshold)
        return numbered_by_appearance(group)

    # Cells: a little smaller than r / sqrt(3), because of rounding. Consecutive points of a scan
    # often share a cell, so sort and label such runs instead of points.
    key, strides = number_cells(xyz, threshold / np.sqrt(3) * (1 - 1e-6))
    runs = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    lengths = np.diff(runs, append=len(key))
    keys, order, cell = sort_keys(key[runs])
    first = np.empty(len(keys), dtype=int)
    first[cell[::-1]] = runs[::-1]  # the last value written is the first point of the cell
    first = xyz.take(first, axis=1)

    # Cheap: join each cell with three neighbours, and then with neighbours in other pieces.
    cells = np.arange(len(keys))
    b = [cells + 1, *(np.searchsorted(keys, keys + stride - 1) for stride in strides)]
    a, b = np.tile(cells, 3), np.concatenate(b).clip(max=len(keys) - 1)
    label = joined(cells, a, b, squared_distance(first, a, b) < threshold**2)
    a, b = pairs_to_measure(keys, strides, label)
    label = joined(label, a, b, squared_distance(first, a, b) < threshold**2)

    # Exact: only open pairs, and only if the boxes around their points are close.
    sizes = np.bincount(cell, lengths).astype(int)
    several = sizes > 1
    is_open = (label[a] != label[b]) & (several[a] | several[b])
    a, b = a[is_open], b[is_open]
    used = np.zeros(len(keys), dtype=bool)
    used[a] = used[b] = True
    order = order[used[cell[order]]]
    xyz = xyz.take(spans(runs[order], lengths[order]), axis=1)  # the points of used cells, sorted
    sizes *= used
    starts = np.cumsum(sizes) - sizes
    low, high = np.empty((2, 3, len(keys)))
    low[:, used] = np.minimum.reduceat(xyz, starts[used], axis=1)
    high[:, used] = np.maximum.reduceat(xyz, starts[used], axis=1)
    gap = np.maximum(low[:, a] - high[:, b], low[:, b] - high[:, a]).clip(0)
    near = (gap**2).sum(axis=0) < threshold**2
    few = sizes[a] * sizes[b] <= 5_000
    label = join_by_comparing(label, a[near & few], b[near & few], xyz, starts, sizes, threshold)
    label = join_by_tree(label, a[near & ~few], b[near & ~few], xyz, starts, sizes, threshold)
    return np.repeat(numbered_by_appearance(label[cell]), lengths)


def number_cells(xyz, side):
    """Return the key of each point's cell, and how much keys grow from a cell to the next."""
    low = xyz.min(axis=1)
    extent = np.floor((xyz.max(axis=1) - low) / side) + 3  # the last two cells of a row are empty
    if np.prod(extent) > 2**62:  # too wide for one number: close gaps of more than two cells
        xyz, low, side = np.floor(xyz / side), np.zeros(3), 1
        for row in xyz:
            values, rank = np.unique(row, return_inverse=True)
            row[:] = np.cumsum(np.diff(values, prepend=values[0]).clip(0, 3))[rank]
        extent = xyz.max(axis=1) + 3
    extent = extent.astype(np.int32 if np.prod(extent) < 2**31 else np.int64)
    key = np.zeros(xyz.shape[1], dtype=extent.dtype)
    for row, start, length in zip(xyz, low, extent):
        key = key * length + ((row - start) / side).astype(key.dtype)
    return key, (extent[1] * extent[2], extent[2])


def sort_keys(key):
    """Return the different keys, sorted, the order of the given keys, and the rank of each."""
    order = np.lexsort(key.view(np.uint16).reshape(len(key), -1).T)  # by digits, lowest first
    key, rank = key[order], np.empty_like(order)
    new = np.append(True, key[1:] != key[:-1])
    rank[order] = np.cumsum(new) - 1
    return key[new], order, rank


def pairs_to_measure(keys, strides, label):
    """Return all pairs of cells in different pieces and at most two steps apart, among others."""
    slab, column = strides
    # The cells of five columns next to each other are consecutive: find all of them at once.
    middles, reach = [0, slab, 2 * slab], 2 * column + 2
    if len(keys) > 8 * np.count_nonzero(np.diff(keys // column, prepend=-1)):
        middles = [x * slab + y * column for x in range(3) for y in range(-2, 3)]  # high columns
        reach, middles = 2, [middle for middle in middles if middle >= 0]
    part, found = np.cumsum(np.append(False, label[1:] != label[:-1])), []
    for middle in middles:
        low = np.searchsorted(keys, keys + max(middle - reach, 0)).clip(max=len(keys) - 1)
        high = np.searchsorted(keys, keys + (middle + reach), side="right")
        mixed = (part[low] != part[high - 1]) | (label[low] != label)  # more than one piece
        low, count = low[mixed], (high - low)[mixed]
        a, b = np.repeat(np.flatnonzero(mixed), count), spans(low, count)
        apart = label[a] != label[b]
        found.append([a[apart], b[apart]])
    return np.concatenate(found, axis=1)


def spans(starts, counts):
    """Return `count` consecutive numbers from each start, in one array."""
    ends = np.cumsum(counts)
    return np.arange(counts.sum()) + np.repeat(starts - ends + counts, counts)


def joined(label, a, b, near):
    """Return labels after the pieces of cells a are joined with those of cells b, where near."""
    return components(label.max() + 1, np.column_stack([label[a[near]], label[b[near]]]))[label]


def join_by_comparing(label, a, b, xyz, starts, sizes, threshold):
    """Join cells that hold two points closer than the threshold; compare all, in batches."""
    work = sizes[a] * sizes[b]
    batch = np.cumsum(work) // 500_000
    for chosen in (batch == number for number in np.unique(batch)):
        i, j, count = a[chosen], b[chosen], work[chosen]
        pair = np.repeat(np.arange(len(i)), count)
        place = spans(np.zeros_like(count), count)
        p, q = starts[i][pair] + place // sizes[j][pair], starts[j][pair] + place % sizes[j][pair]
        near = np.unique(pair[squared_distance(xyz, p, q) < threshold**2])
        label = joined(label, i, j, near)
    return label


def join_by_tree(label, a, b, xyz, starts, sizes, threshold):
    """Do the same for cells with many points, with one kd-tree for each pair of pieces."""
    while len(apart := np.flatnonzero(label[a] != label[b])):
        a, b = a[apart], b[apart]
        ends = np.sort([label[a], label[b]], axis=0)
        same = (ends == ends[:, :1]).all(axis=0)
        cells = np.unique([a[same], b[same]])
        rows = spans(starts[cells], sizes[cells])
        mine = np.repeat(label[cells] == label[a[0]], sizes[cells])
        # Put the smaller group into the tree: the centre of a shell is equally close to all of it.
        smaller, larger = sorted((xyz[:, rows[mine]].T, xyz[:, rows[~mine]].T),
                                 key=lambda side: np.ptp(side, axis=0).max())
        distance, _ = cKDTree(smaller).query(larger, distance_upper_bound=threshold)
        if distance.min() < threshold:
            label = joined(label, a, b, [0])
        a, b = a[~same], b[~same]
    return label


def squared_distance(xyz, p, q):
    """Return squared distances between columns p and q of an array with three rows."""
    return sum((row.take(p) - row.take(q)) ** 2 for row in xyz)


def numbered_by_appearance(group):
    """Return numbers 1, 2, ... for groups, in order of first appearance."""
    first = np.full(group.max() + 1, len(group))
    first[group[::-1]] = np.arange(len(group))[::-1]  # the last value written is the first row
    number = np.empty_like(first)
    number[np.argsort(first, kind="stable")] = np.arange(1, len(first) + 1)
    return number[group]
    ### END SOLUTION

# %%
def race():
    """Print the times of the three steps and of the fast version, and whether they agree."""
    rivals = (euclidean_clustering_accelerated, clustering_at_full_speed)
    for name, points in (("all obstacles", xyz), ("with the road", everything)):
        answers, seconds = zip(*(timed(way, points) for way in rivals))
        same = same_clusters(*answers)
        print(f"{name}, {len(points):,} points: {1000 * seconds[0]:.0f} ms with the three steps, "
              f"{1000 * seconds[1]:.0f} ms at full speed, {'' if same else 'NOT '}the same clusters")

# %%
if is_written(clustering_at_full_speed) and is_written(euclidean_clustering_accelerated):
    race()
    spring_the_trap(clustering_at_full_speed)
else:
    print("You need not write the fast version. The course's own version takes less than a "
          "quarter of the time of the three steps.")

# %% [markdown]
# In lesson 13, `notebooks/optional/13_compiled_loops.ipynb`, you write this grid as loops, and [Numba](https://numba.pydata.org) compiles them. Do not use Numba in the graded function, because the grader does not have it.

# %% [markdown]
# ### How the threshold changes the time
#
# *About 3 minutes.*

# %%
wider = predict("Will your clustering take more or less time at 1.0 m than at 0.5 m?",
                choices=["more", "about the same", "less"])

# %%
third = obstacles[::3]  # every third point
thresholds = np.array([0.2, 0.3, 0.5, 0.7, 1.0])
to_time = {"all pairs": join_all_pairs}
if is_written(euclidean_clustering_accelerated):
    to_time["yours"] = euclidean_clustering_accelerated
times = {}


def measure_thresholds():
    """Time each function at each threshold, in milliseconds."""
    for name, way in to_time.items():
        times[name] = np.array([1000 * seconds_of(way, third[:, :3], t) for t in thresholds])

# %%
measure_thresholds()
axes = plots.curves({}, {name: (thresholds, spent) for name, spent in times.items()},
                    across="threshold (m)", up="time (ms)",
                    title=f"{len(third):,} points at different thresholds")
axes.set_yscale("log")
axes.yaxis.set_major_locator(plt.LogLocator(subs=(1, 2, 5)))
axes.yaxis.set_major_formatter("{x:g}")
axes.minorticks_off()
if "yours" in times:
    change = times["yours"][4] / times["yours"][2]
    wider.compare("more" if change > 1.1 else "less" if change < 0.9 else "about the same",
                  "A larger threshold gives larger cells, so there are fewer cells and fewer open "
                  "pairs. A list of all pairs of points becomes longer instead.")

# %% [markdown]
# ### Breaking it on purpose
#
# *About 15 minutes. A good test is the smallest input that separates a right version from a wrong one.*
#
# Three colleagues have made clustering faster, but their versions are wrong. Here are the results for fourteen points at a threshold of 0.8 m. What is wrong with A, B and C?

# %%
show_broken(euclidean_clustering_accelerated)

# %% [markdown]
# For each version, write a cloud for which its result differs from yours. Use as few rows as you can. The best cloud catches only one of the three. When a cloud catches a version, you see what this version does wrong.

# %%
# For A, B and C, write a list of points [x, y, z]: A=[[...], [...]].
tell_apart(euclidean_clustering_accelerated, A=None, B=None, C=None)

# %% [markdown] tags=["footer"]
# (footer)
