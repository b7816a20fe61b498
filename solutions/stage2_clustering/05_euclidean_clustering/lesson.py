# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [sklearn.cluster, scipy.cluster, scipy.sparse.csgraph, hdbscan, dbscan, open3d, pcl]
#     lent: [which_thresholds, pieces_at, two_errors, measure]
# ---

# %% [markdown]
# # 05 · Euclidean clustering
#
# ![The same street from above, twice. On the left, all points look alike. On the right, nearly every car, person, pole and wall has its own colour and marker.](05_preview.png)
#
# A scan is only a list of points, but a driver sees a lorry, two people and a wall. This lesson turns points into obstacles with a single rule.
#
# **After this lesson you can**
# - turn a cloud into labelled obstacles with a queue and a distance threshold,
# - explain what the threshold does, and why no threshold is right everywhere,
# - predict from measurements how long an algorithm will take on a full scan.
#
# **You write** `euclidean_clustering` (points). **You need** NumPy masks (lesson 01). Lesson 04 helps, but you do not need its code. **Time:** (time), in two sittings of 50 and 40 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street without a road
#
# *The road connects nearly all obstacles with each other, so we remove it first.*
#
# We take one scan and keep the surroundings of the [ego car](#Words-of-the-course), the car that carries the scanner. We drop all [returns](#Words-of-the-course) more than 1.2 m below the sensor. They come from the road and from the lowest half metre of everything else (lesson 06 explains the 1.2). We also drop returns closer than 2 m, because they come from the ego car.

# %%
from collections import deque
from time import process_time

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, is_written, load_street, plots, predict, replay, show_table
from utils.breaking import show_broken, tell_apart
from utils.scene3d import Scene

# Each row is one return: x (forward), y (left) and z (up) in metres from the sensor, and intensity.
cloud, truth = load_street()  # `truth` says what each return hit
x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
standing = (z > -1.2) & (x > -8) & (x < 22) & (np.abs(y) < 9) & (np.hypot(x, y) > 2)
near = cloud[standing]
print(f"{len(cloud):,} returns in the scan, {len(near):,} of them from obstacles nearby")

# %% [markdown]
# The algorithm of this lesson is slow, so we keep only one point in each cube of 20 cm.

# %% tags=["folded"]
# @title Keep the first point in each cube of 20 cm (you need not read this)
cubes = np.floor(near[:, :3] / 0.2)
kept = np.sort(np.unique(cubes, axis=0, return_index=True)[1])
obstacles = near[kept]
street = ((-8, 22), (-9, 9))  # x from, to; y from, to
plots.from_above(obstacles, limits=street, title=f"{len(obstacles):,} points from above");

# %% [markdown]
# Count the obstacles in this picture. When two things are close together, how do you decide whether to count one or two?

# %%
counted = predict("How many separate obstacles do you count?")

# %% [markdown]
# ## The naive idea: all points around a first one
#
# Give a new label to the first point without a label, and to all other unlabelled points within some radius of it. Repeat this until all points have a label. Let us try radii of 0.5 m and 3 m.

# %%
def balls(points, radius):
    """Label points in balls of equal radius, each around the first point without a label."""
    labels = np.zeros(len(points), dtype=int)
    while 0 in labels:
        centre = points[np.argmin(labels), :3]  # argmin: the first point that still has label 0
        in_ball = np.linalg.norm(points[:, :3] - centre, axis=1) < radius
        labels[in_ball & (labels == 0)] = labels.max() + 1
    return labels


figure, rows = plt.subplots(2, 1, figsize=(8.5, 9.5), layout="compressed")
for radius, axes in zip((0.5, 3.0), rows):
    plots.clusters(obstacles, balls(obstacles, radius), limits=street, axes=axes,
                   title=f"Balls with a radius of {radius} m")
plots.ring(rows[1], 8.9, -0.3, radius=3.0, text="one ball");

# %% [markdown]
# Small balls tear a wall into confetti. Large balls join a pedestrian and half a car (in the ring), and the wall is still in pieces. The two ends of a wall are not close to each other, but each piece is close to the *next* piece.
#
# ## The idea: neighbours of neighbours
#
# *Two points are neighbours if they are close. A cluster contains all the points that you can reach by going from neighbour to neighbour.*
#
# Here are seven points. A line connects every two points that are less than 0.8 m apart.

# %% tags=["folded"]
# @title Find all pairs of points closer than a distance (you need not read this)
def close_pairs(points, distance):
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)  # one row and column per point
    return np.argwhere(np.triu(gaps < distance, k=1))  # k=1: each pair once

# %%
seven = np.array([[0.0, 0.0], [2.0, 0.1], [0.45, 0.15], [2.3, -0.2], [0.45, -0.15],
                  [0.91, 0.0], [1.5, -1.1]])
figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
plots.graph(seven, close_pairs(seven, 0.8), names=True, axes=axes,
            limits=((-0.2, 2.5), (-1.3, 0.3)), title="Which points are closer than 0.8 m?");

# %% [markdown]
# Points 0 and 5 are 0.91 m apart, so they are not neighbours. But points 2 and 4 are neighbours of both, so these four points are one cluster. Points 1 and 3 are the second cluster. Point 6 has no neighbours and is a cluster of its own.
#
# Points and lines like these form a *graph*, and the lines are its *edges*. With points $p_1, \dots, p_n$ and a threshold $d$, there is an edge between $i$ and $j$ if
#
# $$\lVert p_i - p_j \rVert \;<\; d .$$
#
# The double bars denote the straight-line distance in space, $\sqrt{\Delta x^2 + \Delta y^2 + \Delta z^2}$. The clusters are the separate pieces of this graph, which are called its *connected components*. They depend only on $d$. You do not choose a first point, a number of clusters or a shape.
#
# Here the cluster of a car grows from one point. Each step adds all points within half a metre of a member of the cluster.

# %% tags=["folded"]
# @title Grow a cluster step by step (you need not read this)
ahead, left = obstacles[:, 0], obstacles[:, 1]
car = obstacles[(ahead > 4.7) & (ahead < 10) & (left > -5) & (left < 0.5), :3]
member = np.arange(len(car)) == np.argmin(car @ [1, 1, 0])  # start at the lower left corner
states = []  # for each point after each step: 0 not reached, 1 joins now, 2 joined before
for _ in range(13):
    gap = np.linalg.norm(car[:, None] - car[member], axis=2).min(axis=1)  # to the nearest member
    states.append(np.where(member, 2, gap < 0.5))
    member = gap < 0.5
shown = (1, 5, 9, 13)
plots.growth(car, [states[step - 1] for step in shown], columns=2,
             titles=[f"step {step}" for step in shown],
             names=("not reached", "joins now", "joined before"),
             title="A cluster grows half a metre at a time");

# %% [markdown]
# The cluster ends where the car ends. The pedestrian next to it stays grey, because no point bridges the gap. But every step compares *all* points with *all* members, even with members whose neighbours joined long ago.
#
# ## The queue: ask each point exactly once
#
# Let new members wait in a queue, and ask each of them for its neighbours only once. Here are the seven points again, starting at point 0, with a threshold of 0.8 m:
#
# | point taken from the queue | its neighbours | points that now get label 1 | queue afterwards |
# |---|---|---|---|
# | (start) | | 0 | 0 |
# | 0 | 2, 4 | 2, 4 | 2, 4 |
# | 2 | 0, 4, 5 | 5 | 4, 5 |
# | 4 | 0, 2, 5 | none | 5 |
# | 5 | 2, 4 | none | empty, so cluster 1 is complete |
#
# Then point 1 starts cluster 2, and so on. The final labels are `[1, 2, 1, 2, 1, 1, 3]`.
#
# Point 5 is a neighbour of points 2 *and* 4, but it enters the queue only once, because a point gets its label **when it enters the queue, not when it leaves**. If you label points when they leave, the queue gets seven entries instead of four: 0, 2, 4, 4, 5, 5, 5. On the car above, a point has about twenty neighbours, so the queue would grow practically without end.
#
# Python's queue is called `deque`, and NumPy finds the new neighbours:

# %%
queue = deque([7])      # a queue with one entry
queue.extend([3, 9])    # two more join at the back
print("first in line:", queue.popleft(), "  still waiting:", list(queue))

gaps = np.array([0.0, 0.3, 0.9, 0.2])
taken = np.array([4, 0, 0, 0])
print("close and without a label:", np.flatnonzero((gaps < 0.5) & (taken == 0)))

# %% [markdown]
# ## Exercise · `euclidean_clustering` (points)
#
# Give each point the label of its cluster. The cluster of the first point gets label 1, the next new cluster gets label 2, and so on. (Any other numbering of the same groups is also right, but differs from the labels in the text.)
#
# - **Two points are neighbours if their distance in x, y and z is less than `threshold`.** Intensity is not a coordinate.
# - **Compare a point with all points at once**, in one line of NumPy. A neighbour search, such as your kd-tree or `scipy.spatial`, is allowed but not needed.
# - **Use a queue, not recursion.** A wall has thousands of points, but Python usually raises a `RecursionError` after about a thousand nested calls.
# - **Do not use libraries that do the clustering for you**, such as `sklearn.cluster`, `scipy.cluster` and the `connected_components` of `scipy.sparse.csgraph`.

# %% nbgrader={"grade": false, "grade_id": "euclidean_clustering", "locked": false, "schema_version": 3, "solution": true, "task": false}
def euclidean_clustering(cloud, threshold=0.5):
    """Group the points of a cloud into clusters, which are connected by chains of neighbours.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres, then perhaps intensity. May be empty.
    threshold : float
        Two points are neighbours if they are closer than this distance in metres.

    Returns
    -------
    ndarray of int, shape (n,)
        The label of each point, from 1 to the number of clusters.
    """
    # 1. Set all labels to 0, which means "no label yet". Set the number of clusters to 0.
    # 2. Go through all points, and skip each point that already has a label.
    # 3. Otherwise, start a new cluster. Count it, label the point, and put it into a new queue.
    # 4. While the queue is not empty, take its first point, and find all points without a label
    #    that are closer to it than the threshold.
    # 5. Label these points at once, and add them to the queue.
    # roughly 14 lines
    ### BEGIN SOLUTION
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
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Use two nested loops. The outer loop goes through all points and starts clusters. The inner loop runs as long as the queue is not empty, and completes *one* cluster. As a condition, an empty `deque` counts as `False`, and so does the label 0.
# </details>
# <details><summary>Hint 2</summary>
#
# `cloud[:, :3] - cloud[i, :3]` has shape (n, 3) and contains the difference between every point and point `i`. Compute the length of each row with `axis=1`, as `balls` does above. "Close" and "without a label" are two masks. Put each of them in parentheses, and combine them with `&`. Then `np.flatnonzero` turns the result into row numbers.
# </details>
# <details><summary>Hint 3</summary>
#
# *Before* the inner loop, label the starting point, and make a new queue that contains only this point. The body of the inner loop has five lines:
#
# 1. `i = queue.popleft()`
# 2. Compute the distances from point `i` to all points.
# 3. `new = np.flatnonzero(...)` with both conditions
# 4. Assign the number of the cluster to `labels[new]`.
# 5. `queue.extend(new)`
# </details>

# %% [markdown]
# **Seven points first.** If this cell or the next one never finishes, stop it with ■. In that case, points never leave the queue, or they enter it again and again. A point that gets label 0 still counts as unlabelled, so it enters again.

# %%
in_space = np.column_stack([seven, np.zeros(7)])  # the seven points, all at height 0
seven_labels = euclidean_clustering(in_space, 0.8)
print("your labels:", seven_labels)
print("by hand:    [1 2 1 2 1 1 3]")
figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
plots.graph(seven, close_pairs(seven, 0.8), labels=seven_labels, names=True, axes=axes,
            limits=((-0.2, 2.5), (-1.3, 0.3)), title="Your clusters of the seven points");

# %% [markdown]
# **Look before you check.** Now cluster the street, which takes a few seconds at most. Nearly every object should have its own colour and marker (the pairs repeat after 42 clusters). You should see neither confetti nor a single colour for everything. A few objects are torn or joined, such as the turning car 7 m ahead. That is not your mistake, as you will see.

# %%
labels = euclidean_clustering(obstacles)
plots.clusters(obstacles, labels, names=True, limits=street,
               title="Your clusters, threshold 0.5 m");

# %%
# The same clusters in 3-D. Drag to rotate the view, and scroll to zoom.
(Scene("Your clusters", alt="The clusters of the street in space, each in its own colour.")
 .add_clusters(obstacles, labels).add_ego_car().show(interactive=True))

# %% nbgrader={"grade": true, "grade_id": "test_euclidean_clustering", "locked": true, "points": 40, "schema_version": 3, "solution": false, "task": false}
check(euclidean_clustering)

# %% [markdown]
# **A good place to stop.** Your clustering works. Save the notebook. The second sitting takes 40 minutes. When you come back, first run all the cells above this one.

# %% [markdown]
# **Your run, step by step.** The player shows how *your* function works through the seven points and five more. A circle marks the point that is asked for its neighbours, and squares mark the points that wait. If a step is wrong, the player starts there and explains why.

# %%
replay(euclidean_clustering)

# %% [markdown]
# **By hand.** Click into the drawing to add a point, and drag it. Where does a single new point join all seven into one cluster?
#
# <details><summary>An answer</summary>
#
# For example at (1.5, -0.35). This place is less than 0.8 m away from points 1, 5 and 6, and each of them belongs to a different cluster.
# </details>

# %%
from utils.by_hand import Drawing, drag_points


def draw_clusters(flat):
    labels = euclidean_clustering(np.column_stack([flat, np.zeros(len(flat))]), 0.8)
    return Drawing(f"clusters: {len(np.unique(labels))}", labels=labels,
                   edges=close_pairs(flat, 0.8))


drag_points(draw_clusters, seven, can_add=True, limits=((-0.3, 2.7), (-1.5, 0.5)))

# %% [markdown]
# The scan is simulated, so we know which object each return comes from.

# %% tags=["folded"]
# @title List the twelve largest clusters and their objects (you need not read this)
objects = truth["objects"][standing][kept]  # the object of each point; 0 is the road
kinds = truth["class_names"][truth["classes"][standing][kept]]  # its kind

sizes, table = np.bincount(labels), []
for label in np.argsort(-sizes, kind="stable")[:12]:
    mine = labels == label
    length, width, height = np.ptp(obstacles[mine, :3], axis=0)
    names = [f"{kinds[objects == number][0]} {number}" for number in np.unique(objects[mine])]
    table.append((f"{label}: {', '.join(names)}", sizes[label],
                  f"{length:.1f} x {width:.1f} x {height:.1f} m"))
show_table(["cluster and its objects", "points", "size along x, y and z"], table)

# %%
there = np.unique(objects[objects > 0])
in_pieces = [number for number in there if len(np.unique(labels[objects == number])) > 1]
shared = [label for label in np.unique(labels) if len(np.unique(objects[labels == label])) > 1]
print(f"{labels.max()} clusters for {len(there)} objects:")
print(f"  {len(in_pieces)} objects are split into several clusters, "
      f"{len(shared)} clusters contain several objects,")
print(f"  {np.sum(sizes[1:] < 10)} clusters have fewer than ten points")
counted.compare(len(there), "You count objects that you recognise. The program sees only gaps. A "
                "gap inside an object makes two clusters, and two objects that touch make one.")

# %% [markdown]
# The program finds cars, people and walls without knowing what a car is.
#
# ## Chains also join separate objects
#
# Look at the longest cluster.

# %%
lengths = [np.ptp(obstacles[labels == label, :2], axis=0).max()
           for label in range(1, labels.max() + 1)]
longest = 1 + int(np.argmax(lengths))
in_it = np.unique(objects[labels == longest])
print(f"Cluster {longest} is {max(lengths):.1f} m long. A chain of at least "
      f"{int(max(lengths) / 0.5) + 1} steps, each shorter than half a metre, connects its ends.")
print(f"In reality, it consists of {len(in_it)} walls, with the numbers {in_it.tolist()}.")
wall = np.where(labels == longest, np.searchsorted(in_it, objects) + 1, 0)  # 1, 2, 3; 0: others
axes = plots.clusters(obstacles, wall, limits=((-8, 22), (-10, 9)),
                      title=f"{len(in_it)} walls form the longest cluster (other points are pale)")
axes.get_legend().remove()
plots.ring(axes, -2.0, -8.2, radius=1.5, text="touches two walls");

# %% [markdown]
# A single stray point in a gap is a bridge. Two people who walk side by side are also one cluster, because they are less than half a metre apart.

# %% [markdown]
# ## Play: how close is close?
#
# In this smaller part of the street, two pedestrians walk at the lower left. At the top, a car is turning next to a cyclist.

# %% tags=["folded"]
# @title Cut out this part of the street (you need not read this)
in_yard = (ahead > 1.3) & (ahead < 11) & (left > -7) & (left < 6.2)
yard, window = obstacles[in_yard], ((1, 11), (-7, 7.6))
true_number = np.unique(objects[in_yard], return_inverse=True)[1].ravel() + 1
figure, axes = plt.subplots(figsize=(6, 6.8), layout="compressed")
plots.clusters(yard, true_number, limits=window, axes=axes, title="The true objects")
axes.get_legend().texts[0].set_text(f"{true_number.max()} objects")
plots.ring(axes, 2.5, -5.8, radius=1.1, text="two people")
plots.ring(axes, 7.0, 3.8, radius=2.4, text="one car")
axes.text(2.5, 2.3, "a cyclist");

# %%
parted = predict("Is there a threshold that keeps the two people apart and the car in one piece?",
                 choices=["yes, a small one", "yes, a large one", "no"])

# %% [markdown]
# **Count in one line.** Clusters of a few points are often spray or noise, so lesson 09 drops small clusters. How many clusters have at least ten points at each of these three thresholds? `np.bincount(found)` returns the number of points with each label, starting with label 0. Replace the question mark.

# %%
for threshold in (0.3, 0.5, 0.7):
    found = euclidean_clustering(yard, threshold)
    larger = "?"  # change this: the number of clusters with at least ten points
    print(f"at {threshold} m: {found.max()} clusters, {larger} of them with at least ten points")

# %% [markdown]
# <details><summary>An answer</summary>
#
# `larger = np.sum(np.bincount(found) >= 10)` gives 7, 5 and 5. In this part of the street, six objects have at least ten points. At 0.3 m, pieces of the turning car are three of the seven clusters. At all three thresholds, the two people share one cluster.
# </details>

# %%
@interact(threshold=FloatSlider(value=0.5, min=0.1, max=2.5, step=0.1,
                                description="threshold", continuous_update=False))
def show_threshold(threshold):
    figure, axes = plt.subplots(figsize=(6, 6.8), layout="compressed")
    plots.clusters(yard, euclidean_clustering(yard, threshold), like=true_number, limits=window,
                   axes=axes, title=f"threshold {threshold:.1f} m")
    plt.show()

# %%
# The same without a slider, for two thresholds. Each obstacle keeps its colour.
figure, panels = plt.subplots(1, 2, figsize=(8.5, 5.6), layout="compressed")
for threshold, axes in zip((0.5, 1.5), panels):
    plots.clusters(yard, euclidean_clustering(yard, threshold), like=true_number, limits=window,
                   axes=axes, title=f"threshold {threshold} m")
plots.ring(panels[0], 7.0, 3.8, radius=2.4, text="torn")
plots.ring(panels[0], 2.5, -5.8, radius=1.1, text="joined")
plots.ring(panels[1], 5.5, 3.6, radius=3.2, text="joined");

# %% [markdown]
# At 0.5 m, the number of clusters is right only because two errors cancel out.

# %%
def which_thresholds(thresholds):
    """Return two masks of thresholds: the two people are apart, and the car is whole."""
    people, slanted = (15, 16), 10  # their numbers in the truth
    apart, whole = [], []
    for threshold in thresholds:
        found = euclidean_clustering(yard, threshold)
        one, other, car = (set(found[objects[in_yard] == n].tolist()) for n in (*people, slanted))
        apart.append(not one & other)  # no cluster contains points of both
        whole.append(len(car) == 1)
    return np.array(apart), np.array(whole)

# %%
tried = np.round(np.arange(0.05, 2.51, 0.05), 2)
apart, whole = which_thresholds(tried)
print(f"The two people are apart at thresholds up to {tried[apart].max()} m. "
      f"The car is in one piece at {tried[whole].min()} m and above.")
both = tried[apart & whole]
parted.compare("no" if len(both) == 0 else "yes, a small one" if both.min() < 0.5
               else "yes, a large one",
               "The two people are closer to each other than neighbouring points on the car's "
               "roof are, because the beams hit the roof at a flat angle. No threshold is right "
               "for both.")

# %% [markdown]
# A *dendrogram* shows all thresholds in one picture. At the bottom are all pieces of at least six points at a threshold of 0.22 m, with the names of their true objects. Two branches meet at the threshold that joins them. Each branch that the line at 0.5 m crosses is one cluster. The line is too high for the two people (15 and 16), and too low for the car (10).

# %%
def pieces_at(thresholds):
    """Return one row of each larger piece at the first threshold, and its label at each one."""
    found = np.array([euclidean_clustering(yard, threshold) for threshold in thresholds])
    _, rows, sizes = np.unique(found[0], return_index=True, return_counts=True)
    rows = np.sort(rows[sizes >= 6])  # larger: at least six points
    return rows, found[:, rows]

# %%
rising = np.geomspace(0.22, 3.0, 50)
rows, found = pieces_at(rising)
order = np.lexsort(found)  # pieces that join are side by side
place = np.arange(len(rows)) * 1.0  # where the branch of each piece is
axes = plots.curves({"the default, 0.5 m": ([-0.7, len(rows) - 0.3], [0.5, 0.5])},
                    up="threshold (m)", title="At which threshold do pieces join?")
for low, high, now in zip(rising, rising[1:], found[1:, order]):
    axes.vlines(np.unique(place), low, high, color="black")
    for label in np.unique(now):
        ends = place[now == label].min(), place[now == label].max()
        axes.hlines(high, *ends, color="black")
        place[now == label] = np.mean(ends)
axes.set(yscale="log", xlim=(-0.7, len(rows) - 0.3), ylim=(0.21, 3))
axes.minorticks_off()
axes.set_yticks([0.25, 0.5, 0.7, 1, 2, 3], ["0.25", "0.5", "0.7", "1", "2", "3"])
axes.set_xticks(range(len(rows)), [f"{kinds[in_yard][row]} {objects[in_yard][row]}"
                                   for row in rows[order]], rotation=60, ha="right");

# %% [markdown]
# ## The two errors
#
# *A higher threshold tears fewer obstacles into pieces, but joins more of them.*
#
# How many cars, lorries, pedestrians and cyclists in the street are in more than one piece, and how many share a cluster with something else?

# %%
def two_errors(thresholds):
    """Return the share of road users that are torn, and the share joined with others."""
    users = np.unique(objects[np.isin(kinds, ["car", "truck", "pedestrian", "cyclist"])])
    torn, joined = [], []
    for threshold in thresholds:
        found = euclidean_clustering(obstacles, threshold)
        clusters_of = [np.unique(found[objects == user]) for user in users]
        torn.append(np.mean([len(pieces) > 1 for pieces in clusters_of]))
        joined.append(np.mean([(objects[np.isin(found, pieces)] != user).any()
                               for user, pieces in zip(users, clusters_of)]))
    return np.array(torn), np.array(joined)

# %%
thresholds = np.array([0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.25, 1.5, 2.0])
torn, joined = two_errors(thresholds)
axes = plots.curves({"torn to pieces": (thresholds, torn),
                     "joined with others": (thresholds, joined)},
                    across="threshold (m)", up="share of the road users",
                    title="The two errors of a threshold")
axes.axvline(0.5, color="black", linestyle=":")
axes.text(0.52, 0.9, "the default, 0.5 m")
for threshold in (0.5, 0.7):
    here = thresholds == threshold
    print(f"at {threshold} m, {torn[here][0]:.1%} are torn and {joined[here][0]:.1%} are joined")

# %% [markdown]
# The two errors are never both zero, but they are not equally bad. A car counts as torn even if it has lost only one stray point, and lesson 09 removes such crumbs as [noise](#Words-of-the-course). Joined objects stay joined.
#
# At 0.7 m, no road user is torn. Why do we not use 0.7 m? Because a parked car and a car that drives past it at 8 m/s become one cluster at 0.64 m. A single box around both hides the moving car.
#
# ## Theory against practice: what does it cost?
#
# *Each of the n points is compared with all n points, which takes n² distances.*

# %%
doubling = predict("With twice as many points, how many times as long will it take?",
                   between=(1, 8), step=0.1, unit="times", digits=1)

# %%
def measure(counts, seconds):
    """Fill one list with numbers of points, and one with the processor's time in seconds."""
    for number in (250, 500, 1000, 2000, 4000, 8000):
        some = near[np.random.default_rng(1).choice(len(near), number, replace=False)]
        begin, runs = process_time(), 0
        while runs == 0 or process_time() - begin < 0.2:  # one run is too short to measure
            euclidean_clustering(some)
            runs += 1
        counts.append(number)
        seconds.append((process_time() - begin) / runs)
        if seconds[-1] > 5:  # skip the longest runs on slow machines
            break

# %%
if is_written(euclidean_clustering):
    counts, seconds = [], []
    measure(counts, seconds)
    reach = np.array([counts[-1] / 4, len(cloud)])
    expected = seconds[-1] * (reach / counts[-1]) ** 2
    axes = plots.timing({"yours": (counts, seconds), "expected": (reach, expected)},
                        title="Time of your function, and n² extended to the full scan")
    axes.axhline(0.1, color="black", linestyle=":")
    axes.text(len(cloud), 0.12, "one turn of the scanner: 0.1 s", ha="right")
    print(f"{len(cloud):,} points would take about {expected[-1]:.0f} s, "
          f"or {expected[-1] / 0.1:,.0f} turns of the scanner")
    doubling.compare(seconds[-1] / seconds[-2], "Twice as many points are each compared with "
                     "twice as many, so the time grows by a factor of 2 times 2. Small clouds give "
                     "less than 4, because every NumPy call takes a few microseconds, even for an "
                     "empty array.")
else:
    print("There is nothing to measure yet. Write euclidean_clustering first.")

# %% [markdown]
# On logarithmic axes, a power $n^k$ is a straight line with slope $k$. Towards the right, your line approaches $k = 2$. A full scan has more than a hundred thousand points, so the function would compute more than ten thousand million distances.
#
# Faster hardware helps little. If it is ten times as fast, it handles only √10 or about three times as many points in the same time. Fewer comparisons help more. The kd-tree of lesson 04 skips points that are far away, and lesson 10 clusters the full scan in less than one turn.

# %% [markdown]
# ## Common mistakes
#
# | what the code does | what you see |
# |---|---|
# | compares points only with the first point of the cluster | confetti, because clusters are balls and not chains |
# | compares the distance with `threshold ** 2` | 0.5 acts like 0.25, and obstacles fall to pieces |
# | compares the squared distance with `threshold` | 0.5 acts like 0.71, which repairs one car by luck and joins two others outside the picture |
# | gives the first cluster the label 0 | the cell never finishes, because 0 means *no label* |
# | subtracts 1 from all labels at the end | the first obstacle is drawn as noise, with pale crosses |
# | counts a new cluster for every point | labels are far above the number of clusters |
# | uses all four columns for the distance | nothing here, because intensities end at 1, but confetti in recordings with intensities up to 255 |

# %%
right = euclidean_clustering(yard)
wrong = {"first point only": balls(yard, 0.5),
         "distance < threshold ** 2": euclidean_clustering(yard, 0.5 ** 2),
         "distance ** 2 < threshold": euclidean_clustering(yard, 0.5 ** 0.5),
         "1 subtracted at the end": right - 1}
figure, grid = plt.subplots(2, 2, figsize=(8.5, 10.4), layout="compressed")
for (title, numbers), axes in zip(wrong.items(), grid.flat):
    plots.clusters(yard, numbers, like=right, limits=window, axes=axes, title=title)

# %% [markdown]
# ## Let it drive
#
# This drive is optional. A car drives for ten seconds at 30 km/h with your `euclidean_clustering`. The other steps thin the points with a grid of 0.4 m, drop clusters of fewer than ten points, and put boxes around the rest. The driver brakes for every box in the lane that is closer than the stopping distance. The speed of your code does not matter. Near the end, two people cross the street side by side. The cell takes 15 to 60 seconds.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import own


def drive_with(threshold):
    """Drive ten seconds through a street that your function clusters."""
    mine = own(euclidean_clustering)
    return drive_street(11, chain(cluster=lambda points: mine(points, threshold), voxel=0.4),
                        seconds=10, clock=on_time)


drive_with(0.5) if is_written(euclidean_clustering) else print(
    "euclidean_clustering is not written, or has not passed its check.")

# %% [markdown]
# At 0.5 m, the car stops 1.5 m from the two people. Does it also stop in time with a smaller or a larger threshold? Try 0.4 and 0.9, and open a braking event to see its frame.
#
# <details><summary>An answer</summary>
#
# At 0.4 m, the two people are often in pieces of fewer than ten points, which are dropped. Their box appears late, and the car hits one of them at 24 km/h. From 0.45 to 0.85 m, it stops as it does at 0.5 m, because one box around both people is good enough if the box is steady. At 0.9 m, the box jumps. At first, when the people are far away, it surrounds only one of them, and later both. The driver cannot tell the speed of a jumping box, brakes 0.2 s later and hits a person.
# </details>

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(euclidean_clustering)

# %% [markdown]
# ## In practice
#
# - In scikit-learn, the function is called DBSCAN. With `min_samples=1`, it gives the same clusters, except that it also joins points exactly 0.5 m apart:
#
#   ```python
#   from sklearn.cluster import DBSCAN
#   labels = DBSCAN(eps=0.5, min_samples=1).fit_predict(obstacles[:, :3]) + 1
#   # Open3D: cloud.cluster_dbscan(eps=0.5, min_points=1)
#   ```
#
#   In the Point Cloud Library (PCL), it is called `EuclideanClusterExtraction`.
# - [Beams](#Words-of-the-course) spread out. Near the horizon, our beams are a third of a degree apart. That is 17 cm at 30 m, and 47 cm at 80 m, the range of our scanner. In our scan, every car beyond 40 m with at least ten returns is in pieces at 0.5 m. Real systems therefore let the threshold grow with distance, as you do in lesson 10, or use an *angle*. If the line between two neighbouring returns points almost along the beam, the returns probably come from different objects.
# - Detectors that were trained on labelled scans are better at separating people and cars. Clustering remains as a safety net. It also finds the sofa that fell off a lorry, which no training set contains.
#
# ## Summary
#
# - A cluster is a connected component. You can reach all its points by going from neighbour to neighbour.
# - Each point is asked only once, if it gets its label when it enters the queue.
# - A threshold is a compromise between torn and joined obstacles, and none is right everywhere.
# - Comparing all points with all points takes n² steps, too many for a full scan.
#
# **Sources.** Euclidean clustering of point clouds: [Rusu 2009](http://mediatum.ub.tum.de/doc/800632/941254.pdf), section 6.2, and the [PCL tutorial](https://pcl.readthedocs.io/projects/tutorials/en/latest/cluster_extraction.html). The same clusters under other names: DBSCAN with `min_samples=1`, [Ester et al. 1996](https://cdn.aaai.org/KDD/1996/KDD96-037.pdf); single linkage cut at the threshold, [Gower and Ross 1969](https://doi.org/10.2307/2346439). Clustering by angles in the range image: [Bogoslavskyi and Stachniss 2016](https://doi.org/10.1109/IROS.2016.7759050).
#
# **Next:** 06 · Filter the ground

# %% [markdown]
# ## If you want more
#
# Each task takes about half an hour, and *Breaking it on purpose* takes about 15 minutes.
#
# 1. Let only points with at least five neighbours pass on their label. That is the full DBSCAN algorithm. Does it separate the two pedestrians? What happens to points that are never reached?
# 2. Find the neighbours with your `KdTree` from lesson 04. (It compares distances with `<=`, but here the threshold needs `<`.) With how many points does the tree become faster than NumPy?

# %% [markdown]
# ### Breaking it on purpose
#
# *A good tester looks for the smallest input on which a right and a wrong function give different results.*
#
# Three colleagues have written their own `euclidean_clustering`, but do not show their code. Here are their labels for sixteen points, with a threshold of 0.8 m, next to yours. What is wrong with A, B and C?

# %%
show_broken(euclidean_clustering)

# %% [markdown]
# For each version, write a cloud on which its labels differ from yours, with as few rows as you can. The best cloud exposes only this version. Once a cloud exposes a version, you see what is wrong with it.

# %%
# For each of A, B and C, give rows [x, y, z] in metres: A=[[...], [...]].
tell_apart(euclidean_clustering, A=None, B=None, C=None)

# %% [markdown] tags=["footer"]
# (footer)
