# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [scipy.spatial, sklearn.neighbors]
#     given: [Node, KdTree]
# ---

# %% [markdown]
# # 04 · The KD-tree
#
# ![A street from above, cut by straight lines into ever smaller rectangles. Around a pedestrian lies a small circle. Nearly all rectangles are hatched: the search never entered them.](pictures/04_preview.png)
#
# "Who is near me?" Clustering asks this question once for every point of a scan, and a scan has a hundred thousand points, ten times a second. This lesson builds the structure that answers it by looking at almost nobody.
#
# **After this lesson you can**
# - build a KD-tree, by hand on paper and in code,
# - search it within a radius, and say for every region why it was looked at or left out,
# - balance it, and show by counting what balance buys.
#
# **You write** `insert` (15 points), `search` (25 points) and `median_order` (20 points). **Time:** about 45 minutes. **You need** Python classes (a glance will do) and lesson 01.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Who is near the pedestrian?
#
# *A handful of points are near. Everybody else had to be asked to find that out.*
#
# Here is one turn of the scanner without the road. A person walks on the pavement, two metres ahead and six to the right. Which returns lie within half a metre of the middle of that person?

# %%
from collections import deque
from math import dist
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots
from utils.visits import depth_of, watched

# One row per return: x forward, y left, z up in metres from the sensor, and intensity.
cloud = load_cloud("cloud.txt")
own_car = np.hypot(cloud[:, 0], cloud[:, 1]) < 2
obstacles = cloud[(cloud[:, 2] > -1.2) & ~own_car, :3]
person, reach = np.array([2.4, -6.1, -0.5]), 0.5

begin = perf_counter()
is_near = np.linalg.norm(obstacles - person, axis=1) <= reach
seconds = perf_counter() - begin
print(f"{is_near.sum()} of {len(obstacles):,} points are near. "
      f"To find them we computed {len(obstacles):,} distances in {1000 * seconds:.1f} ms.")
print(f"The same question for every point: {len(obstacles) ** 2:,} distances, "
      f"about {seconds * len(obstacles) / 60:.1f} minutes.")

# %% [markdown]
# **Predict first.** How few points could one look at and still be *certain* to have found all neighbours? And what would one have to know about the others beforehand?
#
# ## The naive idea: sort by x
#
# *A sorted list finds a place in it quickly. But a street has more than one direction.*
#
# Think of a phone book: nobody reads it from the start. If the points are sorted by x, all neighbours of the person stand in a short piece of the list, from $x - 0.5$ to $x + 0.5$, and halving finds both ends in a few steps. The rest cannot be near.

# %%
in_strip = np.abs(obstacles[:, 0] - person[0]) <= reach
street = ((-10, 25), (-12, 12))  # x from, to; y from, to
axes = plots.kept_and_removed(obstacles, in_strip, limits=street,
                              title=f"To be asked: {in_strip.sum():,} points for {is_near.sum()} "
                                    "neighbours")
axes.add_patch(plt.Circle(person[:2], reach, fill=False, linewidth=1.5, zorder=9))
axes.annotate("the person", person[:2], xytext=(6, -5.5), zorder=9,
              arrowprops={"arrowstyle": "-"})
for axis, name in enumerate("xyz"):
    strip = np.abs(obstacles[:, axis] - person[axis]) <= reach
    print(f"sorted by {name}: {strip.sum():6,} points to ask")

# %% [markdown]
# Better, but the strip crosses the whole street: a wall, a lamp post and a cyclist on the other side are asked because they happen to be as far *ahead* as the person. Sorting by y gives a strip in the other direction with the same trouble, and sorting by z is hopeless: nearly everything stands at the height of a person. What we want is the *square* where two strips cross. But a list cannot be sorted by x and by y at once.
#
# ## The idea: x and y take turns
#
# *Cut the plane by x, each half by y, each quarter by x again.*
#
# A **KD-tree** (a tree over points with $k$ dimensions) is a phone book for places. Each point becomes a *node* and cuts the region that it falls into, in two:
#
# - the root cuts by x: whoever has a smaller x goes to the left, everybody else to the right;
# - the nodes on the second level cut by y, again smaller to the left and everybody else to the right;
# - the third level cuts by x again, and so on. In space the turns are x, y, z, x, y, z, ...
#
# At depth $d$ (the root has depth 0) the axis is $d \bmod k$: in Python, `depth % len(point)`.
#
# We practise on eleven points. First, how the cuts come about as one point after another arrives; the numbers are the rows of the array.

# %%
points = np.array([[-6.2, 7.0], [-6.3, 8.4], [-5.2, 7.1], [-5.7, 6.3], [7.2, 6.1], [8.0, 5.3],
                   [7.2, 7.1], [0.2, -7.1], [1.7, -6.9], [-1.2, -7.2], [2.2, -8.9]])
window = ((-10, 10), (-10, 10))


class Node:
    """A point in the tree: where it is, its row in the cloud, and what hangs below it."""

    def __init__(self, point, index):
        self.point, self.index = point, index
        self.left = self.right = None


class KdTree:
    """A KD-tree. It passes its work on to the functions that you write in this lesson."""

    def __init__(self):
        self.root = None  # an empty tree

    def insert(self, point, index):
        insert(self, point, index)

    def search(self, target, tolerance):
        return search(self, target, tolerance)

    def plant(self, points, left, right, indices=None):
        """Build a finished tree from a table: left[i] and right[i] are rows, -1 for none."""
        nodes = [Node(p, i) for p, i in zip(points, indices or range(len(points)))]
        for node, low, high in zip(nodes, left, right):
            node.left = nodes[low] if low >= 0 else None
            node.right = nodes[high] if high >= 0 else None
        self.root = nodes[0] if nodes else None


# The table of the finished tree: what hangs to the left and to the right of each row.
left = np.array([1, -1, 3, -1, 5, 7, -1, 9, -1, -1, -1])
right = np.array([2, -1, 6, 4, -1, -1, -1, 8, -1, 10, -1])
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9), layout="compressed")
for count, axes in zip((1, 3, 5, 11), grid.flat):
    young = KdTree()
    young.plant(points[:count], np.where(left < count, left, -1)[:count],
                np.where(right < count, right, -1)[:count])
    plots.kd_splits(points[:count], young.root, limits=window, axes=axes,
                    title=f"after {count} point{'s' * (count > 1)}")

# %% [markdown]
# Follow point 4 at (7.2, 6.1). It starts at the root and answers one question per node:
#
# | at node | question | answer | so it goes |
# |---|---|---|---|
# | 0, cuts x at -6.2 | is 7.2 smaller? | no | right, to node 2 |
# | 2, cuts y at 7.1 | is 6.1 smaller? | yes | left, to node 3 |
# | 3, cuts x at -5.7 | is 7.2 smaller? | no | right, where nobody is: here it stays |
#
# Nobody moves when a new point arrives: it takes the first free place on its way down. The same tree, drawn as a tree:

# %%
plots.kd_tree(young.root, title="The tree of the eleven points, in their order of arrival");

# %% [markdown]
# ## Exercise 1 · `insert` (15 points)
#
# *Walk down, one question per level, and take the first free place.*
#
# The classes above are ready. `tree.insert(point, index)` calls your function with the tree as first argument. Use a loop: a function that calls itself once per level ends in a `RecursionError` as soon as a tree is a thousand levels deep, and we shall meet such a tree.

# %% nbgrader={"grade": false, "grade_id": "insert", "locked": false, "schema_version": 3, "solution": true, "task": false}
def insert(tree, point, index):
    """Hang a point into a KD-tree.

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
# **Look before you check.** Your tree should look exactly like the one above.

# %%
tree = KdTree()
for index, point in enumerate(points):
    tree.insert(point, index)
plots.kd_tree(tree.root, title="Your tree");

# %% nbgrader={"grade": true, "grade_id": "test_insert", "locked": true, "points": 15, "schema_version": 3, "solution": false, "task": false}
check(KdTree, exercise="insert")

# %% [markdown]
# ## Searching: what may be left out?
#
# *A circle that lies on one side of a cut has no business on the other.*
#
# Given a target $t$ and a tolerance $r$, we want all points with distance at most $r$. Look at a node that cuts along some axis at the coordinate $s$. On that axis the circle reaches from $t - r$ to $t + r$: these are the ends of a **box** around it, drawn dotted below. Now ask two separate questions:
#
# $$\text{left, if } t - r < s \qquad\qquad \text{right, if } t + r \ge s$$
#
# If the box does not reach a side, nothing there can be near, and the whole branch with all its nodes is left out: it is *pruned*. If the box lies across the cut, both sides must be searched.
#
# **Why is there an equals sign on the right only?** A point with exactly the coordinate $s$ stands on the right: that is how `insert` decided. With $t + r = s$ it is at distance $r$, and "at most $r$" includes it. Write `>` and you lose this neighbour, though only when a cut goes exactly through it: the kind of bug that lives for years. It did, in the course from which these eleven points come.
#
# We search within 3 m of (-6, 7), this time in a better tree of the same points; where it comes from is the last part of this lesson.
#
# | at node | box along its axis | left? | right? | the point itself |
# |---|---|---|---|---|
# | 7, cuts x at 0.2 | -9 to -3 | yes | **no: five nodes pruned** | far |
# | 0, cuts y at 7.0 | 4 to 10 | yes | yes | near |
# | 3, cuts x at -5.7 | -9 to -3 | nobody there | yes | near |
# | 9, cuts y at -7.2 | 4 to 10 | no, and nobody there | nobody there | far |
# | 1, cuts x at -6.3 | -9 to -3 | nobody there | yes | near |
# | 2, cuts y at 7.1 | 4 to 10 | nobody there | nobody there | near |

# %%
# The better tree as a table: point 7 is the root. Squares: looked at. Hatched: pruned.
order = [7, 0, 5, 3, 1, 8, 4, 9, 2, 10, 6]
better = KdTree()
better.plant(points[order], [1, 3, 5, -1, -1, -1, -1, -1, -1, -1, -1],
             [2, 4, 6, 7, 8, 9, 10, -1, -1, -1, -1], order)
target, tolerance = np.array([-6.0, 7.0]), 3.0
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9), layout="compressed")
for count, axes in zip((1, 2, 4, 6), grid.flat):
    looked_at = [7, 0, 3, 9, 1, 2][:count]
    near_ones = [i for i in looked_at if dist(points[i], target) <= tolerance]
    plots.kd_search(points, better.root, target, tolerance, looked_at, found=near_ones,
                    limits=window, axes=axes, title=f"step {count}: at node {looked_at[-1]}")

# %% [markdown]
# In the first pictures the hatched regions are simply not reached *yet*. What is hatched in the last one was never entered. The right half was discarded by a single comparison, at the root.
#
# One more saving: the distance takes a square root, the box does not. Some programs compute the distance only for points inside the box. Do so if you like, but the *circle* decides: a corner of the box is 1.41 tolerances away (1.73 in space).

# %% [markdown]
# ## Exercise 2 · `search` (25 points)
#
# *At each node: is it near? And for each side: may somebody be near there?*
#
# Return the indices of all points within `tolerance`, in any order. Two branches may wait at the same time, so keep a list of places that you still have to visit; with each, its depth. `math.dist(p, q)` is the distance of two points (imported above as `dist`).

# %% nbgrader={"grade": false, "grade_id": "search", "locked": false, "schema_version": 3, "solution": true, "task": false}
def search(tree, target, tolerance):
    """Find the points of a KD-tree within a distance of a target.

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
    # 2. As long as places wait, take one. If nobody is there (None), take the next.
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
# **Look before you check.** `watched` notes which nodes your search looks at. Left the better tree, right yours, which grew in order of arrival. The green rings must be the same four; compare the hatched regions.

# %%
figure, panels = plt.subplots(1, 2, figsize=(8.5, 5), layout="compressed")
for title, one, axes in zip(("the better tree", "your tree"), (better, tree), panels):
    with watched(one) as visited:
        found = one.search(target, tolerance)
    plots.kd_search(points, one.root, target, tolerance, visited, found=found, limits=window,
                    axes=axes, title=title)

# %% nbgrader={"grade": true, "grade_id": "test_search", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(KdTree, exercise="search")

# %% [markdown]
# ## Play: how much is left out?
#
# *The smaller the circle, the more is left out. A circle as large as the street saves nothing.*
#
# Seen from above, with one point per cube of 40 cm, the street is a few hundred points. They go into the tree in random order. Move the circle. Where does the search look at many nodes although it finds nobody?

# %%
rng = np.random.default_rng(4)
near = obstacles[(np.abs(obstacles[:, 0] - 7.5) < 17) & (np.abs(obstacles[:, 1]) < 11)]
flat = np.unique(np.floor(near[:, :2] / 0.4), axis=0, return_index=True)[1]
flat = rng.permutation(near[flat, :2])
garden = KdTree()
for index, point in enumerate(flat):
    garden.insert(point, index)


def draw_search(x, radius, axes=None):
    with watched(garden) as visited:
        found = garden.search([x, -0.3], radius)
    plots.kd_search(flat, garden.root, [x, -0.3], radius, visited, found=found, names=False,
                    limits=street, axes=axes, title=f"within {radius:.1f} m of x = {x:.1f} m")


@interact(x=FloatSlider(value=8.8, min=-8, max=24, step=0.2, description="x (m)",
                        continuous_update=False),
          radius=FloatSlider(value=1.0, min=0.2, max=10, step=0.2, description="tolerance",
                             continuous_update=False))
def show_search(x, radius):
    draw_search(x, radius)
    plt.show()

# %%
# The same without sliders: two tolerances.
figure, panels = plt.subplots(2, 1, figsize=(8.5, 10.5), layout="compressed")
for radius, axes in zip((1.0, 6.0), panels):
    draw_search(8.8, radius, axes)

# %% [markdown]
# ## Balance: the order of arrival shapes the tree
#
# *The first point decides for all who come after it. So let the middle one come first.*
#
# **Predict first.** A thousand points take at least ten levels, since $2^{10} = 1024$. How many levels will there be if the points arrive in random order? And sorted by x and y, as they do along a wall?

# %%
def grow(rows):
    """A KD-tree of points inserted from first to last."""
    tree = KdTree()
    for index, point in enumerate(rows.tolist()):  # one by one, Python's own numbers are quicker
        tree.insert(point, index)
    return tree


thousand = rng.uniform(0, 10, (1000, 2))
wall = np.column_stack([np.linspace(0, 10, 1000), np.linspace(5, 6, 1000)])
for name, rows in {"random order": thousand, "along a wall, end to end": wall,
                   "the same wall, shuffled": rng.permutation(wall)}.items():
    begin = perf_counter()
    depth = depth_of(grow(rows).root)
    print(f"{name:>25}: {depth:4d} levels, grown in {1000 * (perf_counter() - begin):4.0f} ms")

# %% [markdown]
# The sorted wall makes a tree that is a list: every point goes to the right of the one before. Searching it is no better than asking everybody (and a recursive `insert` would have stopped at the limit). Shuffling mends most of it. Can we have the best tree, for certain?
#
# A tree is as shallow as possible if every node has as many nodes to its left as to its right. So the root must be the **median** along x: half of all points are smaller. In the left part, the next one to insert is the median along y; and so on, each part along its own axis.
#
# For an even number there are two in the middle. We take the *lower* one: of $m$ sorted points, the one at place $\lfloor (m - 1) / 2 \rfloor$, counted from 0. Then the depth is $\lfloor \log_2 n \rfloor + 1$ as long as no coordinate occurs twice.
#
# Try it on four points: (-6.3, 8.4), (-6.2, 7.0), (-5.7, 6.3), (-5.2, 7.1). Sorted by x they stand as written. The lower median, at place 1, is (-6.2, 7.0). To its left remains one point, to its right two, and their lower median along y is (-5.7, 6.3).
#
# A worksheet that many have copied starts with (-5.2, 7.1) instead, "the median of the x-values". It is the largest: nobody can ever go to its right.

# %%
four = np.array([[-6.3, 8.4], [-6.2, 7.0], [-5.7, 6.3], [-5.2, 7.1]])
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
for title, rows, axes in (("lower medians first", [1, 0, 2, 3], panels[0]),
                          ("the worksheet's order", [3, 1, 2, 0], panels[1])):
    plots.kd_tree(grow(four[rows]).root, title=title, axes=axes)

# %% [markdown]
# ## Exercise 3 · `median_order` (20 points)
#
# *The median first; then the same for what is smaller, and for the rest.*
#
# Return the order in which to insert: a list of row numbers. The worked example gives `[1, 0, 2, 3]`; `[1, 2, 3, 0]` is as good, since left and right do not disturb each other. You need not build a tree here: the parts of a sorted list *are* what will go left and right.

# %% nbgrader={"grade": false, "grade_id": "median_order", "locked": false, "schema_version": 3, "solution": true, "task": false}
def median_order(points):
    """The order in which points make a balanced KD-tree.

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
    order, waiting = [], deque([(np.arange(len(points)), 0)])
    while waiting:
        rows, depth = waiting.popleft()
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
# **Look before you check.** The tree should be four levels deep and look like a pyramid, with 7 on top; the cuts should share the points out evenly.

# %%
order = median_order(points)
balanced = KdTree()
for index in order:
    balanced.insert(points[index], index)
figure, (cuts, pyramid) = plt.subplots(1, 2, figsize=(8.5, 4.4), width_ratios=[3, 4],
                                       layout="compressed")
plots.kd_splits(points, balanced.root, limits=window, axes=cuts, title="Medians first")
plots.kd_tree(balanced.root, axes=pyramid, title=f"{depth_of(balanced.root)} levels");

# %% nbgrader={"grade": true, "grade_id": "test_median_order", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(median_order)

# %% [markdown]
# ## Theory against practice: count the visits
#
# *Each level of a balanced tree halves what is left: twice the points, one more question.*
#
# A clock depends on the machine; the number of nodes looked at does not. We take samples of the scan, from 125 to 8000 points in space, and search around fifty points, each time with the tolerance that just holds the five nearest. Four trees: medians first, random order, sorted by x, and the worst case, a made-up wall along which x, y and z all rise. **Predict first:** what slope will each have on logarithmic axes?

# %%
def cost_of(tree, targets, tolerances):
    """Mean number of nodes looked at, and seconds (the best of three), for one search."""
    targets, looked_at, seconds = targets.tolist(), 0, []
    for target, tolerance in zip(targets, tolerances):
        with watched(tree) as visited:
            tree.search(target, tolerance)
        looked_at += len(visited)
    for _ in range(3):
        begin = perf_counter()
        for target, tolerance in zip(targets, tolerances):
            tree.search(target, tolerance)
        seconds.append((perf_counter() - begin) / len(targets))
    return looked_at / len(targets), min(seconds)


def five_nearest(rows, targets):
    """For each target the tolerance that just holds its five nearest."""
    return np.sort(np.linalg.norm(rows - targets[:, None], axis=2), axis=1)[:, 4] + 1e-9


counts, visits, clock = np.array([125, 250, 500, 1000, 2000, 4000, 8000]), {}, {}
for n in counts:
    sample = rng.permutation(obstacles)[:n]
    trees = {"medians first": sample[median_order(sample)], "random order": sample,
             "sorted by x": sample[np.argsort(sample[:, 0])]}
    if n <= 1000:  # a tree that is a list takes long to grow
        trees["a sorted wall"] = np.sort(sample, axis=0)
    for name, rows in trees.items():
        targets = rows[rng.choice(n, 50)]
        looked_at, seconds = cost_of(grow(rows), targets, five_nearest(rows, targets))
        visits.setdefault(name, []).append(looked_at)
        clock.setdefault(name, []).append(seconds)

axes = plots.curves({"asking everybody": (counts, counts),
                     "levels of the best tree": (counts, [int(n).bit_length() for n in counts])},
                    {name: (counts[:len(seen)], seen) for name, seen in visits.items()},
                    across="points in the tree", up="nodes looked at in one search",
                    title="What a search looks at to find five")
axes.set_xscale("log")
axes.set_yscale("log")
axes.minorticks_off()
for name, seen in visits.items():
    print(f"{name:>15}: {seen[-1]:4.0f} of {counts[len(seen) - 1]:,} nodes")

# %% [markdown]
# The sorted wall visits half of all nodes: slope 1, as if there were no tree. Medians first grows by a few nodes with each doubling: $\log n$ to walk down, plus what the box touches around the neighbours. Random order is only a little worse, which is why practice often just shuffles. Sorting by x lies in between: the cuts by x are wasted, those by y and z are not.
#
# And on the clock? Your tree runs in Python, one comparison at a time. NumPy compares all points, but in compiled code.

# %%
numpy_clock = []
for n in counts:
    rows, times = obstacles[:n], []
    for _ in range(20):
        begin = perf_counter()
        np.flatnonzero(np.linalg.norm(rows - person, axis=1) <= reach)
        times.append(perf_counter() - begin)
    numpy_clock.append(min(times))

axes = plots.timing({"your tree": (counts, clock["medians first"]),
                     "NumPy, all points": (counts, numpy_clock)},
                    title="One search: your tree against comparing with all")
slope, offset = np.polyfit(np.log(counts[-3:]), np.log(numpy_clock[-3:]), 1)
whole_scan = np.exp(offset) * len(obstacles) ** slope
print(f"foreseen for all {len(obstacles):,} points: NumPy {1e6 * whole_scan:,.0f} µs; "
      f"your tree took {1e6 * clock['medians first'][-1]:,.0f} µs for {counts[-1]:,}")

# %% [markdown]
# NumPy's line climbs towards slope 1, yours far more slowly. Where they cross, the better algorithm overtakes the faster language. A KD-tree in compiled code, as in SciPy, wins nearly from the start: lesson 10 uses one.
#
# ## Common mistakes
#
# *A search that finds too little is quiet: nothing crashes.*
#
# | what was written | what you see |
# |---|---|
# | the box decides, not the circle | points in the corners that are not neighbours |
# | `if ... else` instead of two `if` | everything beyond the nearest cut is missing |
# | `>` instead of `>=` for the right side | a point at exactly the tolerance is missing, in some directions only |
# | `<=` instead of `<` in `insert` | equal goes left: `search` then misses it |
# | the axis is always 0 | the cuts are all parallel: strips again |
# | squared distance against plain tolerance | 0.5 acts as 0.71, and 3 as 1.73 |
# | no condition before going on | right results, no hatching: every node was visited |
# | `insert` calls itself | a `RecursionError`, at the first wall |

# %%
# What the first three find in the better tree, beside what they should.
cases = [("the box decides", [-3.0, 4.0], 3.3, [0, 2, 3]),
         ("if ... else", [-0.5, -7.6], 3.0, [7, 9]),
         ("> instead of >=", [4.2, 7.1], 3.0, [])]
figure, panels = plt.subplots(1, 3, figsize=(8.5, 4.4), layout="compressed")
for (title, target, tolerance, finds), axes in zip(cases, panels):
    right_ones = [i for i in range(11) if dist(points[i], target) <= tolerance]
    plots.kd_search(points, better.root, target, tolerance, found=finds, limits=window,
                    axes=axes, title=title)
    print(f"{title:>16}: finds {finds}, should find {right_ones}")

# %% [markdown]
# ## In practice
#
# - Real trees keep 10 to 40 points in each leaf and compare with all of them: fewer jumps through memory. They store nodes in one long array, and they cut the longest side of a region rather than by turns: at the median, as SciPy does unless told otherwise, or in the middle.
# - The tree is built once per scan. Balanced building by sorting at every level costs $n \log^2 n$; selecting medians without sorting saves one logarithm.
# - With more dimensions the box touches ever more regions. From about ten on, a KD-tree visits nearly every node; image search uses approximate structures instead.
# - A map that grows while the car drives needs insertion *and* balance: incremental trees rebuild crooked branches in the background.
#
# ## If you want more
#
# 1. Write `nearest(tree, target)`: the tolerance shrinks to the best distance so far. Which side should you visit first?
# 2. Cut along the side on which the region is longest instead of by turns. Count visits on a street, which is longer than it is high.
# 3. Write `remove(tree, index)`. Why is it harder than `insert`?
# 4. Let clustering of lesson 05 ask your tree. At which size does it overtake the version that compares with all?
#
# ## Summary
#
# - A KD-tree cuts space by each axis in turn; inserting is one question per level.
# - A search looks left if the box reaches below the cut, right if it reaches the cut or beyond; everything else is left out, and it stays exact.
# - Order of arrival is everything: sorted is a list, shuffled is good, medians first is the least depth there is.
# - Counting visits shows the algorithm; the clock shows the language as well.
#
# **Sources.** KD-trees: [Bentley 1975](https://doi.org/10.1145/361002.361007). Splitting by medians and expected logarithmic search: [Friedman, Bentley and Finkel 1977](https://doi.org/10.1145/355744.355745). The cut of SciPy's tree: [Maneewongvatana and Mount 1999](https://arxiv.org/abs/cs/9901013) and [its documentation](https://docs.scipy.org/doc/scipy/reference/generated/scipy.spatial.KDTree.html). Growing maps: [Cai, Xu and Zhang 2021](https://arxiv.org/abs/2102.10808).
#
# **Next:** 05 · Euclidean clustering

# %% [markdown] tags=["footer"]
# (footer)
