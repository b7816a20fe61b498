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
# ![A street from above, cut by straight lines into ever smaller rectangles. Around a pedestrian lies a small circle. Nearly all rectangles are hatched: the search never entered them.](04_preview.png)
#
# "What is near this point?" Clustering asks this question once for every point of a scan. A scan has a hundred thousand points, ten times a second. This lesson builds a structure that answers the question without comparing all points, and still misses none.
#
# **After this lesson you can**
# - build a kd-tree, by hand on paper and in code,
# - search it within a radius, and explain why each branch was visited or skipped,
# - balance it, and show by counting how much work a balanced tree saves.
#
# **You write** `insert` (points), `search` (points) and `median_order` (points). **You need** lesson 01 and a little of Python's classes. There are two places to stop. **Time:** (time).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## What is near the lamp post?
#
# *Few points are near. To find that out, every other point was compared, too.*
#
# Here is one scan without the road and without [our own car](#Words-of-the-course). A lamp post stands four metres ahead and four to the right. Which [returns](#Words-of-the-course) lie within half a metre of a point in the middle of it?

# %%
from dataclasses import dataclass
from math import dist
from time import process_time

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, is_written, load_cloud, plots, predict, show_table
from utils.replays import play, walk
from utils.visits import depth_of, place_of, watched

# One row per return: x forward, y left, z up in metres from the sensor, and intensity.
cloud = load_cloud("cloud.txt")
own_car = np.hypot(cloud[:, 0], cloud[:, 1]) < 2
obstacles = cloud[(cloud[:, 2] > -1.2) & ~own_car, :3]
post, half_a_metre = np.array([4.3, -4.3, -0.4]), 0.5

begin = process_time()
for _ in range(100):  # once is too short for the processor's clock
    is_near = np.linalg.norm(obstacles - post, axis=1) <= half_a_metre
seconds = (process_time() - begin) / 100
print(f"{is_near.sum()} of {len(obstacles):,} points are near. "
      f"To find them we computed {len(obstacles):,} distances in {1000 * seconds:.1f} ms.")
print(f"The same question for every point: {len(obstacles) ** 2:,} distances, "
      f"about {seconds * len(obstacles) / 60:.1f} minutes.")

# %% [markdown]
# To be certain, a search must look at every point that is near. How many others will it look at? Guess now. The tree that you build in this lesson gives the answer at its end.

# %%
few = predict(f"Your finished tree holds all {len(obstacles):,} points. How many of them will it "
              f"look at, to find the {is_near.sum()} that are near?")

# %% [markdown]
# ## The naive idea: sort by x
#
# *A sorted list finds a place quickly. But a street has more than one direction.*
#
# If the points are sorted by x, all neighbours of the lamp post stand in one short piece of the list, from $x - 0.5$ to $x + 0.5$. Halving the list again and again finds both ends of that piece in a few steps. No other point can be near.

# %%
in_strip = np.abs(obstacles[:, 0] - post[0]) <= half_a_metre
street = ((-10, 25), (-12, 12))  # x from, to; y from, to
axes = plots.kept_and_removed(obstacles, in_strip, limits=street,
                              title=f"To compare: {in_strip.sum():,} points for {is_near.sum()} "
                                    "neighbours")
axes.add_patch(plt.Circle(post[:2], half_a_metre, fill=False, linewidth=1.5, zorder=9))
axes.axvspan(post[0] - half_a_metre, post[0] + half_a_metre, alpha=0.25)
axes.annotate("the lamp post", post[:2], xytext=(8, -6.5), zorder=9,
              arrowprops={"arrowstyle": "-"})
for axis, name in enumerate("xyz"):
    strip = np.abs(obstacles[:, axis] - post[axis]) <= half_a_metre
    print(f"sorted by {name}: {strip.sum():6,} points to compare, "
          f"{strip.sum() / is_near.sum():5.1f} for each neighbour")

# %% [markdown]
# That is better than all points. But the strip crosses the whole street: a cyclist, a house front and, beyond the picture, a hedge are in it, because they are as far *ahead* as the post. Sorting by y gives a strip along the kerb, full of other posts and trees. Sorting by z hardly helps, since most points are about as high as the middle of the post. We want the *square* in which two strips cross. But one list cannot be sorted by x and by y at once.
#
# ## The idea: x and y take turns
#
# *Cut the plane by x, each half by y, each quarter by x again.*
#
# A **kd-tree** is a tree of points with $k$ dimensions. Each point becomes a *node*, and cuts, or *splits*, the region that it falls into in two:
#
# - the first node, the *root*, cuts by x: points with a smaller x go to the left, all others to the right;
# - the nodes of the second level cut by y: again smaller to the left, all others to the right;
# - the third level cuts by x again, and so on. In space the turns are x, y, z, x, y, z, ...
#
# The root has depth 0, its children have depth 1. At depth $d$ the axis is $d \bmod k$: in Python, `depth % len(point)`.
#
# These are the two classes. `@dataclass` writes the `__init__` for us: `Node(point, index)` is a node without children, and `KdTree()` is an empty tree.

# %%
@dataclass(eq=False, repr=False)
class Node:
    """A point in the tree: where it is, its row in the cloud, and what hangs below it."""

    point: list
    index: int
    left: object = None  # or another node
    right: object = None


@dataclass(eq=False, repr=False)
class KdTree:
    """A kd-tree. It passes its work on to the functions that you write in this lesson."""

    root: object = None  # or the first node

    def insert(self, point, index):
        insert(self, point, index)

    def search(self, target, tolerance):
        return search(self, target, tolerance)


# %% tags=["folded"]
# @title Trees ready-made from a table, for the pictures (you need not read this)
def plant(self, points, left, right, indices=None):
    """Build a finished tree from a table: left[i] and right[i] are rows, -1 for none."""
    nodes = [Node(p, i) for p, i in zip(points, indices or range(len(points)))]
    for node, low, high in zip(nodes, left, right):
        node.left = nodes[low] if low >= 0 else None
        node.right = nodes[high] if high >= 0 else None
    self.root = nodes[0] if nodes else None


KdTree.plant = plant  # the checks use it, too


def first_of(count):
    """The tree of the first so many of the eight points, in their order."""
    sides = (1, -1, 3, -1, -1, 7, -1, -1), (2, 4, 5, 6, -1, -1, -1, -1)
    left, right = [[row if row < count else -1 for row in side[:count]] for side in sides]
    tree = KdTree()
    tree.plant(eight[:count].tolist(), left, right)
    return tree


def better_of_seven():
    """A tree of the seven points with row 3 as its root."""
    order, tree = [3, 0, 2, 1, 4, 6, 5], KdTree()
    tree.plant(seven[order].tolist(), [1, 3, 5, -1, -1, -1, -1], [2, 4, 6, -1, -1, -1, -1], order)
    return tree


# %% [markdown]
# We practise on seven points. First, how the cuts come about as one point after another arrives. The numbers are the rows of the array.

# %%
seven = np.array([[-1.0, 2], [-6, -3], [6, 5], [3, -4], [-4, 7], [4, 8], [8, -7]])
eight = np.vstack([seven, [2, 5]])  # one more for later
window = ((-10, 10), (-10, 10))
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9), layout="compressed")
for count, axes in zip((1, 2, 4, 7), grid.flat):
    plots.kd_splits(seven[:count], first_of(count).root, limits=window, axes=axes,
                    title=f"after {count} point{'s' * (count > 1)}")

# %% [markdown]
# Follow point 6 at (8, -7). It starts at the root and answers one question at each node:
#
# | at node | question | answer | so it goes |
# |---|---|---|---|
# | 0, cuts x at -1 | is 8 smaller? | no | right, to node 2 |
# | 2, cuts y at 5 | is -7 smaller? | yes | left, to node 3 |
# | 3, cuts x at 3 | is 8 smaller? | no | right, where no node is: here it stays |
#
# The other points do not move. A new point takes the first free place on its way down. Now an eighth point arrives, at (2, 5). Find its place with a pencil.

# %%
where = predict("Where does (2, 5) go?",
                choices=["left of 3", "left of 5", "right of 4", "right of 5"])

# %%
where.compare(place_of(first_of(8).root, 7),
              "At node 0 it goes right: 2 is not smaller than -1. Node 2 cuts y at 5, and 5 is not "
              "smaller than 5: equal goes right, to node 5. That one cuts x at 4: 2 is smaller, so "
              "the point goes left, where no node is yet.")
plots.kd_tree(first_of(8).root, title="The same tree drawn as a tree, with row 7 at (2, 5)");

# %% [markdown]
# ## Exercise 1 · `insert` (points)
#
# *Walk down, one question per level, and take the first free place.*
#
# `tree.insert(point, index)` calls your function with the tree as first argument. Use a loop: a function that calls itself once per level ends in a `RecursionError` as soon as a tree is a thousand levels deep, and we shall meet such a tree.

# %% nbgrader={"grade": false, "grade_id": "insert", "locked": false, "schema_version": 3, "solution": true, "task": false}
def insert(tree, point, index):
    """Hang a point into a kd-tree.

    Parameters
    ----------
    tree : KdTree
        Its `root` is a Node, or None while the tree is empty. It is changed.
    point : sequence of k floats
        x, y or x, y, z in metres.
    index : int
        The row of the point in its cloud.
    """
    # 1. Make the new node. In an empty tree it is the root, and that is all.
    # 2. Otherwise start at the root, at depth 0.
    # 3. The axis is depth % len(point). Strictly smaller goes left, everything else right.
    # 4. Is there a child on that side? Then go on from there, one level deeper.
    # 5. If not, the new node becomes that child, and the walk ends.
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
# You need two variables that change on the way down: the node where you are, and the depth. A `while True:` loop with a `return` where the new node is hung on is a good shape.
# </details>
# <details><summary>Hint 2</summary>
#
# There are two cases, and they look alike. If the point is smaller along the axis, look at `node.left`: when it is `None`, put the new node there and return; when not, go there. Otherwise the same with `node.right`.
# </details>
# <details><summary>Hint 3</summary>
#
# In the loop: `axis = depth % len(point)`; then `if point[axis] < node.point[axis]:` and, inside, `if node.left is None:` set it and return, else `node = node.left`. The `else:` branch is its mirror image. The last line of the loop adds 1 to the depth.
# </details>

# %% [markdown]
# **A tiny tree first.** Three points on paper: (5, 5) is the root. (2, 8) is smaller in x and goes left, (7, 3) goes right. `grow` makes a tree with your function. Should a cell never end, stop it with ■: a loop that nothing leaves goes on for ever.

# %%
def grow(points, order=None):
    """A kd-tree of points, inserted in this order of rows; by default from first to last."""
    points, tree = np.asarray(points).tolist(), KdTree()  # Python's own numbers are quicker
    for row in range(len(points)) if order is None else order:
        tree.insert(points[row], row)
    return tree


# %%
tiny = grow([[5, 5], [2, 8], [7, 3]])
for index in range(3):
    print(f"row {index}: {place_of(tiny.root, index)}")
print("expected: the root, left of 0, right of 0")

# %% [markdown]
# **Look before you check.** Your tree of the eight points should look exactly like the one above.

# %%
by_arrival = grow(eight)
plots.kd_tree(by_arrival.root, title="Your tree");

# %% nbgrader={"grade": true, "grade_id": "test_insert", "locked": true, "points": 15, "schema_version": 3, "solution": false, "task": false}
check(KdTree, exercise="insert")

# %% [markdown]
# **A good place to stop.** You can grow a tree. The next exercise searches it.

# %% [markdown]
# ## Searching: what may be left out?
#
# *A circle that lies on one side of a cut cannot hold a point from the other side.*
#
# Given a target $t$ and a radius $r$ (the parameter `tolerance`), we want all points with a distance of at most $r$. Look at a node that cuts along some axis at the coordinate $s$. On that axis the circle reaches from $t - r$ to $t + r$. These are the ends of a **box** around it, drawn dotted below. Now ask two separate questions:
#
# $$\text{search the left branch, if } t - r < s$$
#
# $$\text{search the right branch, if } t + r \ge s$$
#
# If the box does not reach a side, no point there can be near. The whole branch with all its nodes is left out: it is *pruned*. If the box lies across the cut, both sides must be searched.
#
# **Why is there an equals sign on the right only?** A point with exactly the coordinate $s$ stands on the right: that is how `insert` decided. With $t + r = s$ it may be at distance $r$, and "at most $r$" includes it. With `>` you lose this neighbour, though only when the box ends exactly at the cut. Such a bug can stay unseen for years.
#
# Try it on the seven points, in a better tree of them: row 3 is the root. Where that order comes from is the last part of this lesson. We search within 4 m of (-3, 4).

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
# Now the whole search. Squares: looked at. Green: found. Hatched, and crossed out in the tree: pruned.

# %%
looked_at, near_ones = [3, 0, 1, 4], [i for i in range(7) if dist(seven[i], target) <= radius]
reached = {"right of node 3": target[0] + radius >= seven[3, 0],
           "left of node 0": target[1] - radius < seven[0, 1]}
never = [branch for branch in reached if not reached[branch]]
pruned.compare(" and ".join(never) or "none",
               "At node 3 the box ends at x = 1, and the cut is at 3: no point to the right can be "
               "near. At node 0 the box reaches from y = 0 to 8, across the cut at 2: both sides "
               "are searched. Node 1 is far away, and yet the search has to look at it: the box "
               "reaches into its region.")
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
# One comparison, at the root, left out three of the seven points.
#
# The *box* decides where to go on, but the *circle* decides what is found: a corner of the box is 1.41 radii away (1.73 in space).
#
# ## Exercise 2 · `search` (points)
#
# *At each node: is it near? And for each side: can a point be near there?*
#
# Return the indices of all points within `tolerance`, in any order. Two branches may wait at the same time, so keep a list of places that you still have to visit, each with its depth. `math.dist(p, q)` is the distance of two points (imported above as `dist`).

# %% nbgrader={"grade": false, "grade_id": "search", "locked": false, "schema_version": 3, "solution": true, "task": false}
def search(tree, target, tolerance):
    """Find the points of a kd-tree within a distance of a target.

    Parameters
    ----------
    tree : KdTree
        As `insert` builds it. It stays as it is.
    target : sequence of k floats
        x, y or x, y, z in metres.
    tolerance : float
        Radius in metres; a point at exactly this distance is found.

    Returns
    -------
    list of int
        The indices of the points found, in any order.
    """
    # 1. One place waits: the root, at depth 0. Nothing is found yet.
    # 2. As long as places wait, take one. If no node is there (None), take the next.
    # 3. If its point is within the tolerance of the target, note its index.
    # 4. If the box reaches below the split along this node's axis, the left child waits too.
    # 5. If it reaches the split or beyond, the right child waits too.
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
# Start with a search that leaves nothing out: put both children of every node onto the list. It finds the right points. Then add the two conditions, one for each child.
# </details>
# <details><summary>Hint 2</summary>
#
# `waiting = [(tree.root, 0)]`, then `while waiting:` and `node, depth = waiting.pop()`. The conditions compare one coordinate, `target[axis]` less or plus the tolerance, with `node.point[axis]`. Two times `if`, never `else`: both can be true.
# </details>
# <details><summary>Hint 3</summary>
#
# The left child waits when `target[axis] - tolerance` is smaller than the split, the right child when `target[axis] + tolerance` is greater than or equal to it. Children wait with `depth + 1`. A node is found when `dist(node.point, target)` is at most the tolerance, whatever the box says.
# </details>

# %% [markdown]
# **A tiny search first**, in the better tree above. `trace` runs your search, and notes which nodes it looks at.

# %%
def trace(tree, target, tolerance):
    """The nodes that a search looks at, in order; and what it finds."""
    with watched(tree) as visited:
        found = tree.search(target, tolerance)
    return visited, [] if found is None else sorted(found)


# %%
visited, found = trace(better, target, radius)
print(f"found {found}, expected {near_ones}")
print(f"looked at {sorted(visited)}, expected {sorted(looked_at)}")

# %% [markdown]
# **Look before you check.** Fifteen points, the tree that your `insert` makes of them, and *your* search within 4 m of (2, -1), node by node. Hatched regions are pruned for good, dotted ones not reached yet, and a ring marks the node of this step. At the end three points must be green and four branches pruned. Where a step is wrong, the player begins there and says why.

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
# *The smaller the circle, the more is left out. A circle as large as the street saves nothing.*
#
# Here are a hundred and twenty points of the street, seen from above, in a tree that they entered in random order. Move the circle and change its radius. Even where nothing is found the search looks at some nodes: it has to walk down to where a point would be.

# %%
rng = np.random.default_rng(4)
near = obstacles[(np.abs(obstacles[:, 0] - 7.5) < 17) & (np.abs(obstacles[:, 1]) < 11), :2]
one_per_metre = np.unique(np.floor(near), axis=0, return_index=True)[1]
flat = np.round(near[rng.permutation(one_per_metre)[:120]], 2)
garden = grow(flat)


def draw_search(x, radius, axes=None):
    visited, found = trace(garden, [x, -0.3], radius)
    plots.kd_search(flat, garden.root, [x, -0.3], radius, visited, found=found, names=False,
                    limits=((-13, 29), (-12, 12)), axes=axes,
                    title=f"within {radius:.1f} m of x = {x:.1f} m")


@interact(x=FloatSlider(value=8.8, min=-2, max=18, step=0.2, description="x (m)",
                        continuous_update=False),
          radius=FloatSlider(value=2.0, min=0.2, max=10, step=0.2, description="radius (m)",
                             continuous_update=False))
def show_search(x, radius):
    draw_search(x, radius)
    plt.show()

# %%
# The same without sliders: two radii.
figure, panels = plt.subplots(2, 1, figsize=(8.5, 11), layout="compressed")
for metres, axes in zip((2.0, 8.0), panels):
    draw_search(8.8, metres, axes)

# %% [markdown]
# **A good place to stop.** You can insert and search: two exercises of three are behind you. The second half asks in which *order* the points should arrive, and counts what you gain.

# %% [markdown]
# ## Balance: the order of arrival shapes the tree
#
# *The first point decides for all that come after it. So let the middle one come first.*
#
# A thousand points need at least ten levels: nine full levels hold only $2^9 - 1 = 511$ points. How many there really are depends on the order of arrival. Here are three orders: random; sorted by x and y, as the points of a wall arrive along a [beam](#Words-of-the-course); and the same wall, shuffled.

# %%
def levels(points, order=None):
    """Number of levels of the tree that your insert grows."""
    return depth_of(grow(points, order).root)


# %%
thousand = rng.uniform(0, 10, (1000, 2))
wall = np.column_stack([np.linspace(0, 10, 1000), np.linspace(5, 6, 1000)])
for name, rows in {"random order": thousand, "along a wall, end to end": wall,
                   "the same wall, shuffled": rng.permutation(wall)}.items():
    print(f"{name:>25}: {levels(rows):4d} levels")

# %% [markdown]
# The sorted wall makes a tree that is a list: every point goes to the right of the one before. Searching it is hardly better than comparing all points, and an `insert` that calls itself would have stopped at Python's limit. Shuffling mends most of it. But can we have the best tree for certain?
#
# A tree has the fewest levels if every node has as many nodes to its left as to its right. So the root must be the **median** along x: half of the other points are smaller. In each half, the next point to insert is the median along y. And so on, each part along its own axis.

# %%
root_row = predict("The better tree has row 3 as its root, the median along x. Which row would it "
                   "be if y were cut first? The rows are "
                   + ", ".join(f"{row} ({x:g}, {y:g})" for row, (x, y) in enumerate(seven)),
                   choices=["row 0", "row 2", "row 5", "row 6", "row 3"])

# %%
middle_y = np.median(seven[:, 1])
root_row.compare(f"row {np.flatnonzero(seven[:, 1] == middle_y)[0]}",
                 f"The median of y is {middle_y:g}: three points have a smaller y, three a greater "
                 "one. By x it is row 3: three are smaller than 3, three greater. Row 6 has the "
                 "greatest x: no point could go to its right.")
figure, panels = plt.subplots(2, 1, figsize=(8.5, 8), layout="compressed")
for title, order, axes in (("medians first", [3, 0, 2, 1, 4, 6, 5], panels[0]),
                           ("greatest x first, then medians", [6, 0, 1, 3, 5, 4, 2], panels[1])):
    one = grow(seven, order)
    plots.kd_tree(one.root, title=f"{title}: {depth_of(one.root)} levels", axes=axes)

# %% [markdown]
# Who takes the last of the sorted points for the middle one starts with the greatest x. The root has an empty right side, and a level more than it needs.
#
# Of an even number of points there are two in the middle. We take the *lower* one: of $m$ sorted points, the one at place $\lfloor (m - 1) / 2 \rfloor$, counted from 0. Then the tree has $\lfloor \log_2 n \rfloor + 1$ levels, as long as no coordinate occurs twice.
#
# ## Exercise 3 · `median_order` (points)
#
# *The median first; then the same for the points that are smaller, and for the rest.*
#
# Return the order in which to insert: a list of row numbers. You need not build a tree here: the parts of a sorted list *are* what will go left and right.

# %% nbgrader={"grade": false, "grade_id": "median_order", "locked": false, "schema_version": 3, "solution": true, "task": false}
def median_order(points):
    """The order in which points make a balanced kd-tree.

    Parameters
    ----------
    points : ndarray, shape (n, k)
        n points with k = 2 or 3 coordinates in metres. n may be 0.

    Returns
    -------
    list of int
        Each row number from 0 to n - 1 once. In every part of the tree the lower median along
        the current axis comes before all others of that part.
    """
    # 1. One part waits: all rows, at depth 0. The order is empty.
    # 2. As long as parts wait, take one. A part without rows is done.
    # 3. Sort its rows by their coordinate along the axis of this depth.
    # 4. The row at place (number of rows - 1) // 2 is next in the order.
    # 5. The rows before it and the rows after it wait as parts of the next depth.
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
# Carry row numbers, not points: start with `np.arange(len(points))`. `points[rows, axis]` is one coordinate of those rows.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.argsort(values)` says at which places the sorted values stand *within the part*. To get sorted row numbers, use it as an index: `rows[np.argsort(values)]`.
# </details>
# <details><summary>Hint 3</summary>
#
# After sorting, `m = (len(rows) - 1) // 2`. `rows[m]` joins the order; `rows[:m]` and `rows[m + 1:]` join the list of parts, both with `depth + 1`. As in `search`, a list of pairs and a `while` loop do it. A function that calls itself is fine here, too: a balanced tree is never deep.
# </details>

# %% [markdown]
# **Four points first.** They stand sorted by x. The lower median, at place 1, is row 1. To its left remains row 0, to its right rows 2 and 3. Along y these have 3 and 6, so their lower median is row 2.

# %%
four = np.array([[1, 8], [2, 5], [6, 3], [9, 6]])
print(f"your order: {np.asarray(median_order(four)).tolist()}")
print("expected:   [1, 0, 2, 3]; as good are [1, 2, 0, 3] and [1, 2, 3, 0]")

# %% [markdown]
# **Look before you check.** The fifteen points should now make four full levels, with row 4 on top.

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
# *Each level of a balanced tree halves what is left: twice the points, one more level.*
#
# A clock depends on the machine; the number of nodes looked at does not. We take 125 to 8,000 points of the scan, in space, and search around about fifty of them, each time with the radius that just holds the five nearest; all that for three draws. There are four orders of arrival. The last one is a made-up wall along which x, y and z all rise.

# %% tags=["folded"]
# @title One search for five neighbours, counted (you need not read this)
ORDERS = {
    "medians first": lambda points: points[median_order(points)],
    "random order": lambda points: points,
    "sorted by x": lambda points: points[np.argsort(points[:, 0])],
    "a sorted wall": lambda points: np.sort(points, axis=0),
}


def five_nearest(points, targets):
    """For each target the radius that just holds its five nearest."""
    return np.sort(np.linalg.norm(points - targets[:, None], axis=2), axis=1)[:, 4] + 1e-9


def cost_of(name, n):
    """How many nodes of a tree of n points one search looks at, on average over three draws."""
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
# A tree that is a list takes long to grow: the wall stops at 1,000.
costs = {name: np.array([cost_of(name, n) for n in counts if n <= 1000 or "wall" not in name])
         for name in ORDERS}
axes = plots.curves({"all points": (counts, counts),
                     "levels of the best tree": (counts, [int(n).bit_length() for n in counts])},
                    {name: (counts[:len(cost)], cost) for name, cost in costs.items()},
                    across="points in the tree", up="nodes looked at in one search",
                    title="What a search looks at to find five")
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xticks(counts, [f"{n:,}" for n in counts])
axes.minorticks_off()
slopes = {name: np.polyfit(np.log(counts[:len(cost)]), np.log(cost), 1)[0]
          for name, cost in costs.items()}
show_table(["order", "nodes looked at", "slope", "more with each doubling"],
           [(name, f"{cost[-1]:.0f} of {counts[len(cost) - 1]:,}", f"{slopes[name]:.1f}",
             f"{np.diff(cost).mean():.1f}") for name, cost in costs.items()])

# %% [markdown]
# The sorted wall visits half of all nodes: slope 1, as if there were no tree. With medians first, each doubling adds a few nodes: one level more to walk down, and some where the box reaches across cuts. Random order looks at a fifth more or so, which is why in practice people often just shuffle. Sorting by x lies in between: the cuts by x are wasted, those by y and z are not.
#
# ### And on the clock?
#
# Your tree runs in Python, one comparison at a time. NumPy compares all points, but in compiled code. And a tree has to be built first.

# %% tags=["folded"]
# @title The clock (you need not read this)
def seconds_of(work):
    """Time that the processor spends on some work; what is short is repeated."""
    begin, runs = process_time(), 0
    while process_time() - begin < 0.05:
        work()
        runs += 1
    return (process_time() - begin) / runs


def measure(n):
    """Put into `clock`: seconds for building a tree of n points, for its search, and NumPy's."""
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
                        fit=False, title="One search, the tree already built")
    gain = numpys[-1] - yours[-1]
    print(f"Building the tree of {n:,} points took {1000 * building[-1]:.0f} ms. "
          + (f"It pays from {building[-1] / gain:,.0f} searches on." if gain > 0 else
             "At this size NumPy is still quicker, so it does not pay."))
else:
    print("Nothing to measure yet: this cell needs your own insert, search and median_order.")

# %% [markdown]
# NumPy's time grows with the number of points, and that of your search far more slowly. Where the lines cross, the better algorithm overtakes the faster language. Building counts, too: for a single question a tree does not pay. Clustering asks once for every point, here 8,000 times: compare that with the number of searches printed above the picture. A kd-tree in compiled code, as in SciPy, wins much earlier: lesson 10 uses one.
#
# ### The lamp post again
#
# Now the first question of this lesson, asked to a tree of all obstacle points.

# %%
def search_the_scan(target, tolerance):
    """Levels of a tree of all obstacle points, nodes that a search looks at, and points found."""
    tree = grow(obstacles, median_order(obstacles))
    with watched(tree) as visited:
        found = tree.search(target, tolerance)
    return depth_of(tree.root), len(visited), len(found)


# %%
height, visits, matches = search_the_scan(post, half_a_metre)
print(f"{height} levels for {len(obstacles):,} points; found {matches} of {is_near.sum()}")
few.compare(visits,
            f"The {matches} that are near have to be looked at. The others are nodes on the way "
            "down, and points in regions that the box reaches. All the rest was never touched.")

# %% [markdown]
# The tree has more than the 16 levels that $\lfloor \log_2 n \rfloor + 1$ promises: equal coordinates always go right, and many are equal. The file has whole millimetres, so many coordinates occur more than once, and all 1,653 points of the level beam have z = 0. If you move every point by a random fraction of a millimetre, the tree has 16 levels.
#
# ## Common mistakes
#
# *A search that finds too little is quiet: nothing crashes.*
#
# | what was written | what you see |
# |---|---|
# | the box decides, not the circle | points in the corners that are not neighbours |
# | `if ... else` instead of two `if` | points beyond a cut are missing |
# | `>` instead of `>=` for the right side | a point at exactly the radius is missing, in some directions only |
# | `<=` instead of `<` in `insert` | equal goes left: `search` then misses it |
# | the axis is always 0 | the cuts are all parallel: strips again |
# | squared distance against plain radius | 0.5 acts as 0.71, and 3 as 1.73 |
# | no condition before going on | right results, no hatching: every node was visited |
# | `insert` calls itself | a `RecursionError`, at the first wall |

# %% tags=["folded"]
# @title Four of these mistakes (you need not read this)
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
        plots.ring(axes, *points[wrong], radius=1.1,
                   text="missing" if wrong in right_ones else "not near")
    looks = f"; looks at {len(visited)} of {len(points)} nodes" if visited else ""
    print(f"{title:>15}: finds {finds}, should find {right_ones}{looks}")

# %% [markdown]
# ## In practice
#
# - Real trees keep 10 to 40 points in each leaf and compare with all of them: fewer jumps through memory. They store nodes in one long array, and they cut the longest side of a region rather than by turns: at the median, as SciPy does unless told otherwise, or in the middle.
# - The tree is built once per scan. Balanced building by sorting at every level costs $n \log^2 n$; selecting medians without sorting saves one logarithm.
# - With more dimensions the box touches ever more regions. From about ten on, a kd-tree visits nearly every node; image search uses approximate structures instead.
# - A map that grows while the car drives needs insertion *and* balance: incremental trees rebuild crooked branches in the background.
#
# The search of this lesson in three libraries. Open3D returns *squared* distances, too:
#
# ```python
# near = scipy.spatial.KDTree(xyz, leafsize=10).query_ball_point(post, r=0.5)
# near = sklearn.neighbors.KDTree(xyz, leaf_size=40).query_radius([post], r=0.5)[0]
# count, near, squared = open3d.geometry.KDTreeFlann(pcd).search_radius_vector_3d(post, 0.5)
# ```
#
# ## Summary
#
# - A kd-tree cuts space by each axis in turn; inserting is one question per level.
# - A search looks left if the box reaches below the cut, right if it reaches the cut or beyond. It leaves out everything else and misses no point.
# - The order of arrival shapes the tree: sorted points make a list, shuffled ones a good tree, medians first the one with the fewest levels.
# - Counting visits shows the algorithm; the clock shows the language as well.
#
# **Sources.** The kd-tree: [Bentley 1975](https://doi.org/10.1145/361002.361007). Splitting by medians and expected logarithmic search: [Friedman, Bentley and Finkel 1977](https://doi.org/10.1145/355744.355745). The cut of SciPy's tree: [Maneewongvatana and Mount 1999](https://arxiv.org/abs/cs/9901013) and [its documentation](https://docs.scipy.org/doc/scipy/reference/generated/scipy.spatial.KDTree.html). Growing maps: [Cai, Xu and Zhang 2021](https://arxiv.org/abs/2102.10808).
#
# **Next:** 05 · Euclidean clustering

# %% [markdown]
# ## If you want more
#
# 1. Write `nearest(tree, target)`: the radius shrinks to the best distance so far. Which side should you visit first? (The side of the target: a small radius prunes more of the other.)
# 2. Cut along the side on which the region is longest instead of by turns. Count visits on a street, which is longer than it is high.
# 3. Write `remove(tree, index)`. It is harder than `insert`: whatever replaces the node must still part the two branches below it.
# 4. Let clustering of lesson 05 ask your tree, and find the size at which it overtakes the version that compares with all.

# %% [markdown] tags=["footer"]
# (footer)
