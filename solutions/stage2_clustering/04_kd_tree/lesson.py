# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [scipy.spatial, sklearn]
#     given: [Node, KdTree]
#     lent: [grow, trace, levels, cost_of, measure, search_the_scan]
# ---

# %% [markdown]
# # 04 · The kd-tree
#
# ![A street from above, cut by straight lines into smaller and smaller rectangles. A small circle surrounds a pedestrian. Nearly all rectangles are hatched, because the search never entered them.](04_preview.png)
#
# Which points are near a given point? Clustering asks this for every point of a scan, about a hundred thousand times, and ten scans arrive every second. Your kd-tree will answer without comparing all points, and it will not miss any.
#
# **After this lesson you can**
# - build a kd-tree, both by hand on paper and in code,
# - search a kd-tree within a radius, and explain why each branch was visited or skipped,
# - balance a kd-tree, and show by counting how much work this saves.
#
# **You write** `insert` (points), `search` (points) and `median_order` (points). **You need** lesson 01 and the basics of Python classes. **Time:** (time: 120), in three sittings of about 40, 35 and 45 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## What is near the lamp post?
#
# Here is one scan without the road and without the [ego car](#Words-of-the-course), which carries the scanner. A lamp post is four metres ahead and four metres to the right. Which [returns](#Words-of-the-course) are within half a metre of a point in the middle of the post?

# %%
from dataclasses import dataclass
from math import dist
from time import process_time

import matplotlib.pyplot as plt
import numpy as np

from utils import check, is_written, load_cloud, plots, predict, show_table
from utils.replays import play, walk
from utils.visits import depth_of, place_of, watched

# One row per return: x forward, y left, z up in metres from the sensor, and intensity.
cloud = load_cloud("cloud.txt")
ego_car = np.hypot(cloud[:, 0], cloud[:, 1]) < 2
obstacles = cloud[(cloud[:, 2] > -1.2) & ~ego_car, :3]
post, half_a_metre = np.array([4.3, -4.3, -0.4]), 0.5

begin = process_time()
for _ in range(100):  # one run is too short to measure
    is_near = np.linalg.norm(obstacles - post, axis=1) <= half_a_metre
seconds = (process_time() - begin) / 100
print(f"{is_near.sum()} of {len(obstacles):,} points are near. "
      f"To find them, we computed {len(obstacles):,} distances in {1000 * seconds:.1f} ms.")
print(f"The same question for every point needs {len(obstacles) ** 2:,} distances, "
      f"or about {seconds * len(obstacles) / 60:.1f} minutes.")

# %% [markdown]
# Every search has to look at the points that are near. How many points will a search of your tree look at in all? The end of the lesson has the answer.

# %%
few = predict(f"Your finished tree holds all {len(obstacles):,} points. How many of them will a "
              f"search look at to find the {is_near.sum()} near ones?")

# %% [markdown]
# ## The naive idea: sort by x
#
# If the points are sorted by x, all neighbours of the lamp post are in one short piece of the list, from $x - 0.5$ to $x + 0.5$. A binary search finds both ends of this piece in a few steps. No other point can be near.

# %%
in_strip = np.abs(obstacles[:, 0] - post[0]) <= half_a_metre
street = ((-10, 25), (-12, 12))  # x from, to; y from, to
axes = plots.kept_and_removed(obstacles, in_strip, limits=street,
                              title=f"{in_strip.sum():,} points to compare, to find "
                                    f"{is_near.sum()} neighbours")
axes.add_patch(plt.Circle(post[:2], half_a_metre, fill=False, linewidth=1.5, zorder=9))
axes.axvspan(post[0] - half_a_metre, post[0] + half_a_metre, alpha=0.25)
axes.annotate("the lamp post", post[:2], xytext=(8, -6.5), zorder=9,
              arrowprops={"arrowstyle": "-"})
for axis, name in enumerate("xyz"):
    strip = np.abs(obstacles[:, axis] - post[axis]) <= half_a_metre
    print(f"sorted by {name}: {strip.sum():6,} points to compare, "
          f"{strip.sum() / is_near.sum():5.1f} for each neighbour")

# %% [markdown]
# The strip crosses the whole street. A cyclist, a house front and, beyond the picture, a hedge are in it, because they are as far *ahead* as the post. Sorting by y or z has the same problem. We want the *square* where two strips cross, but one list cannot be sorted by both x and y.
#
# ## The idea: x and y take turns
#
# A **kd-tree** is a tree of points with $k$ dimensions. Each point becomes a *node*, which cuts a region in two (the place of the cut is called the *split*):
#
# - The first node, the *root*, cuts the whole space by x. Points with a smaller x go to the left, and all others go to the right.
# - Its children cut these two sides by y. Again, smaller goes left, and everything else goes right. On a map, this left side is below the cut, and the right side is above it.
# - The third level cuts by x again, and so on. In three dimensions, the axes are x, y, z, x, y, z, ...
#
# The root has depth 0, and its children have depth 1. At depth $d$, the axis is $d \bmod k$, which is `depth % len(point)` in Python. A node without children is a *leaf*.
#
# `@dataclass` writes the `__init__` of both classes. `Node(point, index)` makes a leaf, and `KdTree()` makes an empty tree.

# %%
@dataclass(eq=False, repr=False)
class Node:
    """A point in the tree: its position, its row in the cloud, and its two children."""

    point: list
    index: int
    left: object = None  # or another node
    right: object = None


@dataclass(eq=False, repr=False)
class KdTree:
    """A kd-tree. Its methods call the functions that you write in this lesson."""

    root: object = None  # or the first node

    def insert(self, point, index):
        insert(self, point, index)

    def search(self, target, tolerance):
        return search(self, target, tolerance)


# %% tags=["folded"]
# @title Make finished trees for the pictures (you need not read this)
def plant(self, points, left, right, indices=None):
    """Build a finished tree from a table. left[i] and right[i] are rows, or -1 for none."""
    nodes = [Node(p, i) for p, i in zip(points, indices or range(len(points)))]
    for node, low, high in zip(nodes, left, right):
        node.left = nodes[low] if low >= 0 else None
        node.right = nodes[high] if high >= 0 else None
    self.root = nodes[0] if nodes else None


KdTree.plant = plant  # the checks also use it


def first_of(count):
    """Return the tree of the first `count` of the eight points, inserted in their order."""
    sides = (1, -1, 3, -1, -1, 7, -1, -1), (2, 4, 5, 6, -1, -1, -1, -1)
    left, right = [[row if row < count else -1 for row in side[:count]] for side in sides]
    tree = KdTree()
    tree.plant(eight[:count].tolist(), left, right)
    return tree


def better_of_seven():
    """Return a tree of the seven points with row 3 as its root."""
    order, tree = [3, 0, 2, 1, 4, 6, 5], KdTree()
    tree.plant(seven[order].tolist(), [1, 3, 5, -1, -1, -1, -1], [2, 4, 6, -1, -1, -1, -1], order)
    return tree


# %% [markdown]
# Here seven points arrive one after another. The numbers are their rows in the array.

# %%
seven = np.array([[-1.0, 2], [-6, -3], [6, 5], [3, -4], [-4, 7], [4, 8], [8, -7]])
eight = np.vstack([seven, [2, 5]])  # one more point for later
window = ((-10, 10), (-10, 10))
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9), layout="compressed")
for count, axes in zip((1, 2, 4, 7), grid.flat):
    plots.kd_splits(seven[:count], first_of(count).root, limits=window, axes=axes,
                    title=f"after {count} point{'s' * (count > 1)}")

# %% [markdown]
# Follow point 6, which is at (8, -7). It starts at the root and answers one question at each node:
#
# | at node | question | answer | next |
# |---|---|---|---|
# | 0, cuts x at -1 | is 8 smaller than -1? | no | right, to node 2 |
# | 2, cuts y at 5 | is -7 smaller than 5? | yes | left, to node 3 |
# | 3, cuts x at 3 | is 8 smaller than 3? | no | right, where the place is free |
#
# The other points do not move. Now an eighth point arrives, at (2, 5). Find its place with pencil and paper.

# %%
where = predict("Where does (2, 5) go?",
                choices=["left of 3", "left of 5", "right of 4", "right of 5"])

# %%
where.compare(place_of(first_of(8).root, 7),
              "At node 0, the point goes right, because 2 is not smaller than -1. Node 2 cuts y at 5, "
              "and 5 is not smaller than 5. An equal point goes right, to node 5, which cuts x at 4. "
              "There, 2 is smaller, so the point goes left, where the place is free.")
plots.kd_tree(first_of(8).root, title="The same tree as a diagram, with row 7 at (2, 5)");

# %% [markdown]
# ## Exercise 1 · `insert` (points)
#
# `tree.insert(point, index)` calls your function with the tree as its first argument. Use a loop. A later cell grows a tree of a thousand levels, in which a function that calls itself once per level usually stops with a `RecursionError`.
#
# In this lesson, you must not use `scipy.spatial` or scikit-learn, because they contain finished kd-trees. The end of the notebook lists all the packages that you may use.

# %% nbgrader={"grade": false, "grade_id": "insert", "locked": false, "schema_version": 3, "solution": true, "task": false}
def insert(tree, point, index):
    """Insert a point into a kd-tree.

    Parameters
    ----------
    tree : KdTree
        The tree to change. Its `root` is a Node, or None if the tree is empty.
    point : sequence of k floats
        x, y or x, y, z in metres.
    index : int
        The row of the point in its cloud.
    """
    # 1. Make the new node. If the tree is empty, the new node becomes the root, and you are done.
    # 2. Otherwise, start at the root, at depth 0.
    # 3. The axis is depth % len(point). Strictly smaller goes left, everything else goes right.
    # 4. If there is a child on that side, move to it, one level deeper, and repeat step 3.
    # 5. If that side is free, the new node becomes that child, and you are done.
    # roughly 14 lines
    ### BEGIN SOLUTION
    newcomer = Node(point, index)
    if tree.root is None:
        tree.root = newcomer
        return
    parent, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] < parent.point[axis] else "right"
        child = getattr(parent, side)
        if child is None:
            setattr(parent, side, newcomer)
            return
        parent, depth = child, depth + 1
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Two variables change on the way down: the current node and its depth. Use a `while True:` loop, and `return` after you attach the new node.
# </details>
# <details><summary>Hint 2</summary>
#
# If the point is smaller along the axis, look at `node.left`. If that is `None`, put the new node there and return. Otherwise, move to it. For all other points, do the same with `node.right`.
# </details>
# <details><summary>Hint 3</summary>
#
# In the loop, compute `axis = depth % len(point)`. In the branch `if point[axis] < node.point[axis]:`, check whether `node.left` is `None`. If it is, put the new node there and return. Otherwise, write `node = node.left`. The `else:` branch does the same with `node.right`. At the end of the loop, add 1 to the depth.
# </details>

# %% [markdown]
# **A tiny tree first.** On paper, (5, 5) is the root, (2, 8) goes left because its x is smaller, and (7, 3) goes right. `grow` makes a tree with your function. If a cell never finishes, your loop has no way out. Stop the cell with ■.

# %%
def grow(points, order=None):
    """Return a kd-tree of points, inserted in this order of rows (first to last by default)."""
    points, tree = np.asarray(points).tolist(), KdTree()  # Python's own numbers are faster
    for row in range(len(points)) if order is None else order:
        tree.insert(points[row], row)
    return tree


# %%
tiny = grow([[5, 5], [2, 8], [7, 3]])
for index in range(3):
    print(f"row {index}: {place_of(tiny.root, index)}")
print("expected: the root, left of 0, right of 0")

# %% [markdown]
# **Look before you check.** Your tree of the eight points should look exactly like the tree above.

# %%
by_arrival = grow(eight)
plots.kd_tree(by_arrival.root, title="Your tree");

# %% nbgrader={"grade": true, "grade_id": "test_insert", "locked": true, "points": 15, "schema_version": 3, "solution": false, "task": false}
check(KdTree, exercise="insert")

# %% [markdown]
# **A good place to stop.** You can grow a tree. Save the notebook. In the next sitting (35 minutes), you search the tree.

# %% [markdown]
# ## Searching: which branches can be left out?
#
# *If you have just opened the notebook, run all the cells above. `insert` sends smaller points to the left and all others to the right.*
#
# We want all the points whose distance from a target is at most a radius $r$ (the parameter `tolerance`). They are inside a circle around the target, and the circle is inside a **box**, drawn dotted below. Look at a node that cuts at the coordinate $s$. If $t$ is the target's coordinate along the same axis, the box reaches from $t - r$ to $t + r$. Decide about each side separately:
#
# $$\text{search the left branch if } t - r < s$$
#
# $$\text{search the right branch if } t + r \ge s$$
#
# If the box does not reach one side of the cut, no point there can be near. The search leaves out, or *prunes*, the whole branch. If the box reaches across the cut, the search must visit both sides.
#
# **Why is there an equals sign only on the right?** `insert` puts a point with exactly the coordinate $s$ on the right. If $t + r = s$, this point may be at a distance of exactly $r$, and "at most $r$" includes it. With `>`, you would lose this neighbour, but only if the box ends exactly at the cut.
#
# Try it on the seven points, within 4 m of (-3, 4). We use a better tree, which has row 3 as its root. The last sitting explains its order.

# %%
better, target, radius = better_of_seven(), [-3, 4], 4
figure, (plane, diagram) = plt.subplots(1, 2, figsize=(8.5, 4.9), layout="compressed")
plots.kd_search(seven, better.root, target, radius, limits=window, axes=plane,
                title="Before the search")
plots.kd_tree(better.root, axes=diagram, title="The better tree")
plt.show()
pruned = predict("Which branch is pruned?",
                 choices=["none", "left of node 0", "right of node 3",
                          "right of node 3 and left of node 0"])

# %% [markdown]
# Squares mark the nodes that the search visits, and the points that it finds are green. Pruned branches are hatched on the map and crossed out in the tree.

# %%
looked_at, near_ones = [3, 0, 1, 4], [i for i in range(7) if dist(seven[i], target) <= radius]
reached = {"right of node 3": target[0] + radius >= seven[3, 0],
           "left of node 0": target[1] - radius < seven[0, 1]}
never = [branch for branch in reached if not reached[branch]]
pruned.compare(" and ".join(never) or "none",
               "At node 3, the box ends at x = 1 and the cut is at 3, so no point to the right can "
               "be near. At node 0, the box reaches from y = 0 to 8, across the cut at 2, so the "
               "search takes both sides. Node 1 is far away, but the search has to look at it, "
               "because the box reaches into its region.")
figure, (plane, diagram) = plt.subplots(1, 2, figsize=(8.5, 4.9), layout="compressed")
plots.kd_search(seven, better.root, target, radius, looked_at, found=near_ones, limits=window,
                axes=plane, title="After the search")
plots.kd_tree(better.root, visited=looked_at, found=near_ones, axes=diagram,
              title="The same in the tree");

# %% [markdown]
# | at node | box along its axis | left branch? | right branch? | the point itself |
# |---|---|---|---|---|
# | 3, cuts x at 3 | -7 to 1 | yes | **no: three nodes pruned** | far |
# | 0, cuts y at 2 | 0 to 8 | yes | yes | near |
# | 1, cuts x at -6 | -7 to 1 | no node there | no node there | far |
# | 4, cuts x at -4 | -7 to 1 | no node there | no node there | near |
#
# The *box* decides where the search continues, but the *circle* decides which points it finds. A corner of the box is 1.41 radii away from the target (1.73 in three dimensions).
#
# ## Exercise 2 · `search` (points)
#
# Return the indices of all points within `tolerance`, in any order. Sometimes both branches must be searched, so keep a list of places that you still have to visit, each with its depth. `math.dist(p, q)`, imported above as `dist`, is the distance between two points. A `search` that calls itself is also right, but in the tree of a thousand levels it usually stops with a `RecursionError`.

# %% nbgrader={"grade": false, "grade_id": "search", "locked": false, "schema_version": 3, "solution": true, "task": false}
def search(tree, target, tolerance):
    """Find the points of a kd-tree within a distance of a target.

    Parameters
    ----------
    tree : KdTree
        A tree that `insert` has built. It is not changed.
    target : sequence of k floats
        x, y or x, y, z in metres.
    tolerance : float
        Radius in metres. A point at exactly this distance is found.

    Returns
    -------
    list of int
        The indices of the points found, in any order.
    """
    # 1. Start with one waiting place, the root at depth 0, and an empty list of results.
    # 2. While places wait, take one of them. If it is None, go on to the next.
    # 3. If its point is within the tolerance of the target, note its index.
    # 4. If the box reaches below the split along this node's axis, let the left child wait.
    # 5. If the box reaches the split or goes beyond it, let the right child wait as well.
    # roughly 12 lines
    ### BEGIN SOLUTION
    found, waiting = [], [(tree.root, 0)]
    while waiting:
        node, depth = waiting.pop()
        if node is None:
            continue
        if dist(node.point, target) <= tolerance:
            found.append(node.index)
        axis = depth % len(target)
        split = node.point[axis]
        if target[axis] - tolerance < split:
            waiting.append((node.left, depth + 1))
        if target[axis] + tolerance >= split:
            waiting.append((node.right, depth + 1))
    return found
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Start with a search that leaves nothing out. It puts both children of every node into the list. Then add the two conditions, one for each child.
# </details>
# <details><summary>Hint 2</summary>
#
# Start with `waiting = [(tree.root, 0)]`, then write `while waiting:` and `node, depth = waiting.pop()`. Compare `target[axis]`, minus or plus the tolerance, with `node.point[axis]`. Use `if` twice and never `else`, because both conditions can be true.
# </details>
# <details><summary>Hint 3</summary>
#
# Let the left child wait if `target[axis] - tolerance` is smaller than the split. Let the right child wait if `target[axis] + tolerance` is greater than or equal to it. Both wait with `depth + 1`. A node is found if `dist(node.point, target)` is at most the tolerance, whether or not its children wait.
# </details>

# %% [markdown]
# **A tiny search first.** `trace` runs your search in the better tree above and notes which nodes it looks at.

# %%
def trace(tree, target, tolerance):
    """Return the nodes that a search looks at, in order, and the indices that it finds."""
    with watched(tree) as visited:
        found = tree.search(target, tolerance)
    return visited, [] if found is None else sorted(found)


# %%
visited, found = trace(better, target, radius)
print(f"found {found}, expected {near_ones}")
print(f"looked at {sorted(visited)}, expected {sorted(looked_at)}")

# %% [markdown]
# **Look before you check.** The player shows *your* search within 4 m of (2, -1), in the tree that your `insert` makes from fifteen points. A ring marks the current node, and dotted regions have not been reached yet. At the end, three points must be green, and four branches must be pruned (hatched). If a step is wrong, the player starts there and says why.

# %%
fifteen = np.array([[-6, 0], [1, -2], [4, -1], [-2, 5], [-1, 1], [-7, 3], [-3, -9], [3, -7],
                    [-9, -5], [-8, 6], [7, -6], [-4, -3], [6, 4], [5, 8], [0, 9]])
yard = grow(fifteen)
play(walk(yard.root, [2, -1], 4, *trace(yard, [2, -1], 4)))

# %% nbgrader={"grade": true, "grade_id": "test_search", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(KdTree, exercise="search")

# %% [markdown]
# ## Play: how much is left out?
#
# Here are 120 points of the street, seen from above and inserted in random order. Move the circle and change its radius. Even a search that finds nothing looks at some nodes, because it has to walk down to the place where a point would be.

# %%
from utils.by_hand import Drawing, drag_circle
from utils.plots.regions import pruned_regions

rng = np.random.default_rng(4)
near = obstacles[(np.abs(obstacles[:, 0] - 7.5) < 17) & (np.abs(obstacles[:, 1]) < 11), :2]
one_per_metre = np.unique(np.floor(near), axis=0, return_index=True)[1]
flat = np.round(near[rng.permutation(one_per_metre)[:120]], 2)
garden = grow(flat)

view = ((-13, 29), (-12, 12))


def search_around(x, y, radius):
    visited, found = trace(garden, [x, y], radius)
    labels = np.zeros(len(flat), dtype=int)
    labels[visited], labels[found] = 1, 3
    return Drawing(f"looked at {len(visited)} of {len(flat)} points", labels=labels,
                   names={0: "not looked at", 1: "far", 3: "found"},
                   rectangles={"pruned": pruned_regions(garden.root, visited, view)})


drag_circle(search_around, (8.8, -0.3, 2.0), flat, limits=view)

# %%
# The same for two radii, with the cuts of the tree.
def draw_search(x, radius, axes):
    visited, found = trace(garden, [x, -0.3], radius)
    plots.kd_search(flat, garden.root, [x, -0.3], radius, visited, found=found, names=False,
                    limits=view, axes=axes, title=f"within {radius:.1f} m of x = {x:.1f} m")


figure, panels = plt.subplots(2, 1, figsize=(8.5, 11), layout="compressed")
for metres, axes in zip((2.0, 8.0), panels):
    draw_search(8.8, metres, axes)

# %% [markdown]
# **A good place to stop.** You can insert and search. Save the notebook. In the last sitting (45 minutes), you choose the *order* in which the points arrive, and count how much work this saves.

# %% [markdown]
# ## Balance: the order of arrival shapes the tree
#
# *If you have just opened the notebook, run all the cells above. `insert` grows a tree, and `search` prunes the branches that the box does not reach.*
#
# A thousand points need at least ten levels, because nine full levels hold only $2^9 - 1 = 511$ points. The actual number depends on the order in which the points arrive. We try random points, and a wall whose points arrive one after the other along a [beam](#Words-of-the-course), so that x and y rise. Then we shuffle the points of the wall.

# %%
def levels(points, order=None):
    """Return the number of levels of the tree that your insert grows."""
    return depth_of(grow(points, order).root)


# %%
thousand = rng.uniform(0, 10, (1000, 2))
wall = np.column_stack([np.linspace(0, 10, 1000), np.linspace(5, 6, 1000)])
for name, rows in {"random order": thousand, "along a wall, end to end": wall,
                   "the same wall, shuffled": rng.permutation(wall)}.items():
    print(f"{name:>25}: {levels(rows):4d} levels")

# %% [markdown]
# The sorted wall turns the tree into a list, because every point goes to the right of the one before. Searching this list is hardly better than comparing all points. Shuffling helps. But how do we get the best tree every time?
#
# A tree has the fewest levels if every node has as many nodes to its left as to its right. So the root must be the **median** along x, because half of the other points have a smaller x. In each half, the median along y comes next. This continues in every part, along the axis of its level.

# %%
root_row = predict("The better tree has row 3 as its root, which is the median along x. Which row "
                   "would be the root if we cut by y first? The rows are "
                   + ", ".join(f"{row} ({x:g}, {y:g})" for row, (x, y) in enumerate(seven)),
                   choices=["row 0", "row 2", "row 5", "row 6", "row 3"])

# %%
middle_y = np.median(seven[:, 1])
root_row.compare(f"row {np.flatnonzero(seven[:, 1] == middle_y)[0]}",
                 f"The median of y is {middle_y:g}, because three points have a smaller y and three "
                 "have a greater one. Row 3 is the median along x. Row 6 has the greatest x, so no "
                 "point could go to its right.")
figure, panels = plt.subplots(2, 1, figsize=(8.5, 8), layout="compressed")
for title, order, axes in (("medians first", [3, 0, 2, 1, 4, 6, 5], panels[0]),
                           ("greatest x first, then medians", [6, 0, 1, 3, 5, 4, 2], panels[1])):
    one = grow(seven, order)
    plots.kd_tree(one.root, title=f"{title}: {depth_of(one.root)} levels", axes=axes)

# %% [markdown]
# If the root is the point with the greatest x, its right side stays empty, and the tree has one more level.
#
# If the number of points is even, two of them are in the middle, and we take the *lower* one. Among $m$ sorted points, this is the one at place $\lfloor (m - 1) / 2 \rfloor$, counted from 0. The tree then has $\lfloor \log_2 n \rfloor + 1$ levels, as long as no coordinate occurs twice.
#
# ## Exercise 3 · `median_order` (points)
#
# Return the order in which to insert the points, as a list of row numbers. You do not need a tree for this. The sorted points before the median will go left, and the points after it will go right.

# %% nbgrader={"grade": false, "grade_id": "median_order", "locked": false, "schema_version": 3, "solution": true, "task": false}
def median_order(points):
    """Return an order in which points make a balanced kd-tree.

    Parameters
    ----------
    points : ndarray, shape (n, k)
        n points with k = 2 or 3 coordinates in metres. n may be 0.

    Returns
    -------
    list of int
        Each row number from 0 to n - 1 once. In every part of the tree, the lower median along
        the current axis comes before all other points of that part.
    """
    # 1. Start with one waiting part, all rows at depth 0, and an empty order.
    # 2. While parts wait, take one of them. If it has no rows, go on to the next.
    # 3. Sort its rows by their coordinate along the axis of this depth.
    # 4. The row at place (number of rows - 1) // 2 comes next in the order.
    # 5. Let the rows before it and the rows after it wait as two parts, one level deeper.
    # roughly 11 lines
    ### BEGIN SOLUTION
    order, waiting = [], [(np.arange(len(points)), 0)]
    while waiting:
        rows, depth = waiting.pop()
        if len(rows) == 0:
            continue
        along = points[rows, depth % points.shape[1]]
        rows = rows[np.argsort(along, kind="stable")]
        middle = (len(rows) - 1) // 2
        order.append(int(rows[middle]))
        waiting += [(rows[:middle], depth + 1), (rows[middle + 1:], depth + 1)]
    return order
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Work with row numbers, not with points. Start with `np.arange(len(points))`. `points[rows, axis]` is one coordinate of those rows.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.argsort(values)` returns the places of the sorted values *within the part*. To get sorted row numbers, use it as an index: `rows[np.argsort(values)]`.
# </details>
# <details><summary>Hint 3</summary>
#
# After sorting, compute `m = (len(rows) - 1) // 2`. Append `rows[m]` to the order. Add `rows[:m]` and `rows[m + 1:]` to the list of parts, both with `depth + 1`. Use a list of pairs and a `while` loop, as in `search`. A function that calls itself is also fine, because a balanced tree is never deep.
# </details>

# %% [markdown]
# **Four points first.** They are already sorted by x. The lower median, at place 1, is row 1. Row 0 is to its left, and rows 2 and 3 are to its right. Their y coordinates are 3 and 6, so their lower median is row 2.

# %%
four = np.array([[1, 8], [2, 5], [6, 3], [9, 6]])
print(f"your order: {np.asarray(median_order(four)).tolist()}")
print("expected:   [1, 0, 2, 3]; also right: [1, 2, 0, 3] and [1, 2, 3, 0]")

# %% [markdown]
# **Look before you check.** The fifteen points should now make four full levels, with row 4 at the top.

# %%
medians_first = grow(fifteen, median_order(fifteen))
figure, panels = plt.subplots(2, 1, figsize=(8.5, 12), height_ratios=[2, 3], layout="compressed")
plots.kd_tree(medians_first.root, axes=panels[0],
              title=f"{depth_of(medians_first.root)} levels; by arrival {depth_of(yard.root)}")
plots.kd_splits(fifteen, medians_first.root, limits=window, axes=panels[1],
                title="Each cut halves its part");

# %% nbgrader={"grade": true, "grade_id": "test_median_order", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(median_order)

# %% [markdown]
# ## Theory against practice: count the visits
#
# The time of a search depends on the machine, but the number of nodes that it looks at does not. We draw 125 to 8,000 points of the scan, and take at least fifty of them as targets. For each target, we search for the five nearest points. We do this three times for each of four orders of arrival. The last order is an artificial wall along which x, y and z all rise.

# %% tags=["folded"]
# @title Count the nodes of a search for five neighbours (you need not read this)
ORDERS = {
    "medians first": lambda points: points[median_order(points)],
    "random order": lambda points: points,
    "sorted by x": lambda points: points[np.argsort(points[:, 0])],
    "a sorted wall": lambda points: np.sort(points, axis=0),
}


def five_nearest(points, targets):
    """Return, for each target, the radius that just holds its five nearest points."""
    return np.sort(np.linalg.norm(points - targets[:, None], axis=2), axis=1)[:, 4] + 1e-9


def cost_of(name, n):
    """Return the nodes that a search in a tree of n points looks at, averaged over three draws."""
    looks = []
    for draw in range(3):
        points = np.random.default_rng((n, draw)).choice(obstacles, n, replace=False)
        points = ORDERS[name](points)
        tree, targets = grow(points), points[::n // 50]
        with watched(tree) as visited:
            for target, metres in zip(targets.tolist(), five_nearest(points, targets)):
                visited.clear()
                tree.search(target, metres)
                looks.append(len(visited))
    return np.mean(looks)


# %%
counts = np.array([125, 250, 500, 1000, 2000, 4000, 8000])
counts = counts[counts <= len(obstacles)]  # your own cloud may be smaller
# A tree that is a list takes long to grow, so the wall stops at 1,000 points.
costs = {name: np.array([cost_of(name, n) for n in counts if n <= 1000 or "wall" not in name])
         for name in ORDERS}
axes = plots.curves({"all points": (counts, counts),
                     "levels of the best tree": (counts, [int(n).bit_length() for n in counts])},
                    {name: (counts[:len(cost)], cost) for name, cost in costs.items()},
                    across="points in the tree", up="nodes looked at in one search",
                    title="Nodes that a search looks at to find five points")
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xticks(counts, [f"{n:,}" for n in counts])
axes.minorticks_off()
slopes = {name: np.polyfit(np.log(counts[:len(cost)]), np.log(cost), 1)[0]
          for name, cost in costs.items()}
show_table(["order", "nodes looked at", "slope", "added by each doubling"],
           [(name, f"{cost[-1]:.0f} of {counts[len(cost) - 1]:,}", f"{slopes[name]:.1f}",
             f"{np.diff(cost).mean():.1f}") for name, cost in costs.items()])

# %% [markdown]
# A slope of $k$ means that the number of nodes grows like $n^k$. In the sorted wall, a search looks at half of all nodes, and the slope is 1, as if there were no tree. With medians first, each doubling adds only a few nodes. Averaged over the seven sizes, a random order costs a fifth more nodes, so in practice people often just shuffle the points. Sorting by x wastes the cuts by x, but not the cuts by y and z.
#
# ### And on the clock?
#
# Your tree runs in Python and makes one comparison at a time. NumPy compares all points, but in compiled code.

# %% tags=["folded"]
# @title Measure times (you need not read this)
def seconds_of(work):
    """Return the time that the processor spends on some work. Short work is repeated."""
    begin, runs = process_time(), 0
    while process_time() - begin < 0.05:
        work()
        runs += 1
    return (process_time() - begin) / runs


def measure(n):
    """Put into `clock` the seconds to build and search a tree of n points, and NumPy's seconds."""
    points = np.random.default_rng(n).choice(obstacles, n, replace=False)
    building = seconds_of(lambda: grow(points, median_order(points)))
    tree, targets = grow(points, median_order(points)), points[::n // 50]
    questions = list(zip(targets.tolist(), five_nearest(points, targets)))
    yours = seconds_of(lambda: [tree.search(*one) for one in questions]) / len(questions)
    clock[n] = building, yours, seconds_of(
        lambda: np.linalg.norm(points - post, axis=1) <= half_a_metre)


clock = {}

# %%
if all(map(is_written, (insert, search, median_order))):
    for n in counts.tolist():
        measure(n)
    building, yours, numpys = np.transpose(list(clock.values()))
    axes = plots.timing({"your tree": (counts, yours), "NumPy, all points": (counts, numpys)},
                        fit=False, title="One search in a finished tree")
    gain = numpys[-1] - yours[-1]
    print(f"Building the tree of {n:,} points took {1000 * building[-1]:.0f} ms. "
          + (f"It pays off after {building[-1] / gain:,.0f} searches." if gain > 0 else
             "At this size NumPy is still faster, so the tree does not pay off."))
else:
    print("Nothing to measure yet: this cell needs your own insert, search and median_order.")

# %% [markdown]
# NumPy's time grows with the number of points, while your search slows down far less. Where the lines cross, the better algorithm overtakes the faster language. For a single question, a tree does not pay off, because you have to build it first. But clustering asks a question for every point, here 8,000 times. Compare this with the number of searches printed above. A compiled kd-tree, such as SciPy's in lesson 10, pays off much earlier.
#
# ### The lamp post again
#
# Let us put the lesson's first question to a tree of all obstacle points.

# %%
def search_the_scan(target, tolerance):
    """Search a tree of all obstacle points; return its levels, nodes visited, points found."""
    tree = grow(obstacles, median_order(obstacles))
    with watched(tree) as visited:
        found = tree.search(target, tolerance)
    return depth_of(tree.root), len(visited), len(found)


# %%
height, visits, matches = search_the_scan(post, half_a_metre)
print(f"{height} levels for {len(obstacles):,} points; found {matches} of {is_near.sum()}")
few.compare(visits,
            f"The search has to look at the {matches} that are near. The others are nodes on the "
            "way down and points in regions that the box reaches. It never touches the rest.")

# %% [markdown]
# The formula $\lfloor \log_2 n \rfloor + 1$ promises 16 levels. The printed number is higher, because many coordinates are equal, and an equal point always goes right. For example, all 1,653 points of the horizontal beam have z = 0. If you moved every point by a random fraction of a millimetre, the tree would have 16 levels.
#
# ## Common mistakes
#
# | mistake | what you see |
# |---|---|
# | the box decides, not the circle | points in the corners are found, but they are not neighbours |
# | `if ... else` instead of two `if` | points beyond a cut are missing |
# | `>` instead of `>=` for the right side | a point at exactly the radius is missing, but only in some directions |
# | `<=` instead of `<` in `insert` | equal points go left, and `search` misses them |
# | the axis is always 0 | all cuts are parallel, so the regions are strips again |
# | the squared distance is compared with the radius | 0.5 acts like 0.71, and 3 like 1.73 |
# | no conditions in `search` | the results are right, but nothing is hatched, because the search visits every node |
# | `insert` calls itself | a `RecursionError` at the sorted wall |

# %% tags=["folded"]
# @title Draw four of these mistakes (you need not read this)
cases = [("the box decides", seven, better, [-1.5, 4.5], 3.0, [0, 4], None),
         ("if ... else", seven, better, [1, 4], 5.2, [0], [3, 0, 1]),
         ("> instead of >=", eight, first_of(8), [2, 1], 4.0, [0], None),
         ("no condition", seven, better, [-3, 4], 4.0, [0, 4], list(range(7)))]
figure, panels = plt.subplots(2, 2, figsize=(8.5, 9), layout="compressed")
for (title, points, one, centre, metres, finds, visited), axes in zip(cases, panels.flat):
    plots.kd_search(points, one.root, centre, metres, visited, found=finds, limits=window,
                    legend=False, axes=axes, title=title)
    right_ones = [i for i in range(len(points)) if dist(points[i], centre) <= metres]
    for wrong in set(finds) ^ set(right_ones):
        plots.ring(axes, *points[wrong], radius=0.75,
                   text=f"{wrong}: {'missing' if wrong in right_ones else 'not near'}")
    looks = f"; looks at {len(visited)} of {len(points)} nodes" if visited else ""
    print(f"{title:>15}: finds {finds}, should find {right_ones}{looks}")

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(KdTree, exercise="search")

# %% [markdown]
# ## In practice
#
# - Real trees keep 10 to 40 points in each leaf and compare the target with all of them. They also cut the longest side of a region instead of taking turns.
# - With more dimensions, the box touches more regions. With fifteen dimensions, a search for five neighbours among 8,000 points visits nearly every node.
# - A map that grows while the car drives needs a tree that allows insertion *and* stays balanced. Incremental trees rebuild unbalanced branches in the background.
#
# This is the same search in three libraries:
#
# ```python
# near = scipy.spatial.KDTree(xyz, leafsize=10).query_ball_point(post, r=0.5)
# near = sklearn.neighbors.KDTree(xyz, leaf_size=40).query_radius([post], r=0.5)[0]
# count, near, squared = open3d.geometry.KDTreeFlann(pcd).search_radius_vector_3d(post, 0.5)
# ```
#
# ## Summary
#
# - A kd-tree cuts space by each axis in turn.
# - A search goes left if the box reaches below the cut, and right if it reaches the cut or beyond. It does not miss any point.
# - The order of arrival shapes the tree. Inserting medians first gives the fewest levels, and a random order is nearly as good.
#
# **Sources.** The kd-tree: [Bentley 1975](https://doi.org/10.1145/361002.361007). Medians and expected logarithmic search: [Friedman, Bentley and Finkel 1977](https://doi.org/10.1145/355744.355745). How SciPy's tree cuts: [Maneewongvatana and Mount 1999](https://arxiv.org/abs/cs/9901013) and [its documentation](https://docs.scipy.org/doc/scipy/reference/generated/scipy.spatial.KDTree.html). Growing maps: [Cai, Xu and Zhang 2021](https://arxiv.org/abs/2102.10808).
#
# **Next:** 05 · Euclidean clustering

# %% [markdown]
# ## If you want more
#
# Number 3 takes about an hour, the others about half an hour each.
#
# 1. Write `nearest(tree, target)`, which shrinks its radius to the best distance so far. Which side should it visit first? (It should visit the target's side first. The radius is then soon small, and a small radius prunes more of the other side.)
# 2. Cut the longest side of the region instead of taking turns. Count the visits on a street, which is longer than it is high.
# 3. Write `remove(tree, index)`. The node that replaces the removed node must still separate the two branches below it.

# %% [markdown] tags=["footer"]
# (footer)
