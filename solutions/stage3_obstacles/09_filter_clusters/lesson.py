# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [left_over, lost_by, gone_at]
# ---

# %% [markdown]
# # 09 · Filter clusters
#
# ![A street from above. Cars, people, trees and house fronts are coloured clusters. Small grey crosses on the road are clusters that were too small and now count as noise.](09_preview.png)
#
# Clustering puts every point into a [cluster](#Words-of-the-course), even if this cluster is only three drops of water. If each cluster becomes a box, the car brakes for spray. If we remove too many clusters, it does not brake for a child.
#
# **After this lesson you can**
# - remove small clusters from a labelled cloud, without changing the others,
# - say which people a minimum size removes, and at what distance.
#
# **You write** `filter_clusters` (points). **Time:** (time). **You need** boolean masks (lesson 01) and the idea of cluster labels (lesson 05).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A wet street, in clusters
#
# We take the part of the course's scan that is within 30 m and above the road. We pretend that it has rained, and add 60 puffs of spray from the wheels.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_street, plots, predict, scenes, show_table

scan, truth = load_street()  # `truth` says what each return hit
names = truth["class_names"].tolist()
useless = np.isin(truth["classes"], [names.index("invalid"), names.index("ego")])
wanted = (scan[:, 2] >= -1.2) & (np.hypot(scan[:, 0], scan[:, 1]) < 30) & ~useless

# %% tags=["folded"]
# @title Add the spray (you need not read this)
rng = np.random.default_rng(9)
size_of_puff = rng.geometric(0.1, 60).astype(np.intp)  # most puffs of spray are tiny, a few are not
middle = rng.uniform([-15, -3, -0.9], [25, 3, 0.2], (60, 3)).repeat(size_of_puff, axis=0)
spray = np.column_stack([rng.normal(middle, 0.12), np.full(len(middle), 0.1)])
puff = 10_000 + np.arange(60).repeat(size_of_puff)  # numbers that no object has

cloud = np.vstack([scan[wanted], spray])
objects = np.concatenate([truth["objects"][wanted], puff])  # the object of each return; 0 is the road
print(f"{len(cloud):,} points, {len(spray)} of them spray")

# %% [markdown]
# The labels come from the simulator. Every object is one cluster, and so is every square metre of road that is left after the ground filter. (The ground is not flat, so some of it is less than 1.2 m below the sensor.) Labels run from 1 to N, as in lesson 05.

# %%
def labels_from_truth(points, objects):
    """Return one label per object, and one per square metre of the road, which is object 0."""
    square = np.where(objects[:, None] == 0, np.floor(points[:, :2]), 0)
    return np.unique(np.column_stack([objects, square]), axis=0, return_inverse=True)[1].ravel() + 1


cluster_labels = labels_from_truth(cloud, objects)
print(f"{cluster_labels.max()} clusters; the labels of some points:")
cluster_labels[::7000]

# %%
street = ((-20, 30), (-10, 10))  # x from, to; y from, to
plots.clusters(cloud, cluster_labels, limits=street, title="Everything is a cluster");

# %% [markdown]
# How many of these clusters are small?

# %%
how_many_small = predict(f"How many of the {cluster_labels.max()} clusters have fewer than 100 points?",
                         between=(0, int(cluster_labels.max())))
share_of_small = predict("What share of all points do these small clusters contain in total?",
                         between=(0, 100), unit="%")

# %%
sizes = np.bincount(cluster_labels)[1:]  # how often each label occurs, from 1 upwards
small = sizes < 100
how_many_small.compare(small.sum(), "A scan contains few large objects and many small ones. Each puff "
                       "of spray, each pole and each patch of road is a cluster of its own.")
share_of_small.compare(100 * sizes[small].sum() / sizes.sum(), "It takes hundreds of small clusters "
                       "to have as many points as the largest house front.")
axes = plots.curves({}, {"clusters": (np.arange(1, len(sizes) + 1), np.sort(sizes)[::-1])},
                    across="rank, from the largest to the smallest", up="points",
                    title="A few giants and a long tail")
axes.axhline(100, color="black", linestyle=":", label="100 points")
axes.set_xscale("log"); axes.set_yscale("log"); axes.legend();

# %% [markdown]
# A filter by size therefore removes most of the *clusters*, but hardly any of the *points*.
#
# ## The naive idea: remove one, close the gap
#
# Labels run from 1 to N without gaps, and you may want to keep them that way. Then, whenever you remove a cluster, you subtract 1 from all higher labels. Here are four clusters of 5, 1, 2 and 4 points, and we want at least 3.

# %%
labels = np.array([1, 1, 1, 1, 1, 2, 3, 3, 4, 4, 4, 4])
for number in range(1, 5):
    how_many = np.sum(labels == number)
    verdict = "stays" if how_many else "no point has this label"
    if 0 < how_many < 3:
        labels[labels == number] = 0
        labels[labels > number] -= 1  # close the gap
        verdict = "goes, and higher labels drop by 1"
    points = f"{how_many} point," if how_many == 1 else f"{how_many} points,"
    print(f"label {number}: {points:9} {verdict:33}", labels)

# %% [markdown]
# The cluster of two points is still there. When cluster 2 was removed, cluster 3 became the new cluster 2. But the loop went on to label 3, and never tested the new cluster 2. If two small clusters have consecutive labels, the second one survives. A test with a single small cluster does not show this mistake.
#
# ## The idea: label 0 means noise
#
# Let $c_i$ be the label of point $i$, and let $m$ be the minimum size. The new label is
#
# $$c_i' = \begin{cases} c_i & \text{if } c_i \text{ occurs at least } m \text{ times,}\\ 0 & \text{otherwise.}\end{cases}$$
#
# The other labels do not change, so no cluster is skipped. The labels may then have gaps, which lesson 08 allows.
#
# Now we only have to count, and NumPy has two tools for this. Here are the shoe sizes of eight people:

# %%
shoes = np.array([41, 38, 44, 41, 41, 38, 39, 44])
kinds, which, how_many = np.unique(shoes, return_inverse=True, return_counts=True)
print("np.unique    sizes", kinds, " people with each size", how_many)
print("             for each person, the index of the size:", which)
print("np.bincount  of size 41:", np.bincount(shoes)[41], " of size 40:", np.bincount(shoes)[40])

# %% [markdown]
# So `kinds[which]` is the array of shoes again, and `how_many[which]` says for each person how many people wear the same size.
#
# ## Exercise · `filter_clusters` (points)
#
# Set the labels of clusters with fewer than `min_num_points` points to 0. A cluster of exactly `min_num_points` points stays. Points with label 0 keep this label, however many there are. The labels may have gaps, and the array may be empty. Labels are never NaN. All packages listed at the end are allowed.

# %% nbgrader={"grade": false, "grade_id": "filter_clusters", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_clusters(cluster_labels, min_num_points=100):
    """Turn clusters that are too small into noise.

    Parameters
    ----------
    cluster_labels : ndarray of int, shape (n,)
        The cluster of each point (1 or greater), or 0 for points that belong to no cluster.
    min_num_points : int
        Clusters with fewer points than this are removed.

    Returns
    -------
    ndarray of int, shape (n,)
        A new array, with 0 for the points of clusters that are too small. All other labels are
        unchanged.
    """
    # 1. Count how many points have each label.
    # 2. Find the size of each point's cluster.
    # 3. Return a new array, with 0 if that size is too small, and the old label otherwise.
    # roughly 3 lines
    ### BEGIN SOLUTION
    _, row, size = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    size_of_its_cluster = size[row]
    return np.where(size_of_its_cluster < min_num_points, 0, cluster_labels)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# You need the cluster size for each *point*, not for each cluster. One comparison is then enough, and the answer has the same length as `cluster_labels`.
# </details>
# <details><summary>Hint 2</summary>
#
# For the shoes, this was `how_many[which]`. Do the same with `cluster_labels` in place of `shoes`. Or loop over the labels, read from the original array, and write to a copy.
# </details>
# <details><summary>Hint 3</summary>
#
# `np.where(condition, a, b)` builds a new array, with `a` where the condition is true and `b` elsewhere. The condition is "the size of the point's cluster is less than `min_num_points`", `a` is 0 and `b` is `cluster_labels`.
# </details>

# %% [markdown]
# **Try it on ten points first.** Cluster 1 has four points, clusters 2 and 3 have two each, cluster 5 has one, and one point is already noise. A minimum of two removes cluster 5, and a minimum of three also removes clusters 2 and 3. The last line shows whether your function changed its input.

# %%
ten = np.array([1, 1, 2, 2, 3, 3, 1, 0, 5, 1])
print("labels        ", ten)
for minimum, expected in ((2, [1, 1, 2, 2, 3, 3, 1, 0, 0, 1]), (3, [1, 1, 0, 0, 0, 0, 1, 0, 0, 1])):
    yours = np.asarray(filter_clusters(ten, minimum))
    print(f"at least {minimum}     {yours}\n   expected    {np.array(expected)}"
          f"   <- {'agrees' if np.array_equal(yours, expected) else 'differs'}")
print("labels, after ", ten)
axes = plots.clusters(np.column_stack([np.arange(10), np.zeros(10)]),
                      filter_clusters(ten, 3), limits=((-0.7, 9.7), (-0.6, 0.6)),
                      title="At least 3 points: there should be one cluster and six noise points")
axes.set_yticks([]); axes.set_ylabel(""); axes.set_xlabel("row"); axes.set_xticks(range(10));

# %% [markdown]
# **Look before you check.** Most cars, people, trees and house fronts should be left, in their old colours. The spray and the pieces of road should be grey crosses.

# %%
filtered = filter_clusters(cluster_labels)  # the default minimum is 100
print(f"{len(np.unique(cluster_labels))} clusters in, {len(np.unique(filtered[filtered > 0]))} out, "
      f"{np.mean(filtered == 0):.1%} of the points are noise now")
plots.clusters(cloud, filtered, limits=street, title="Clusters of at least 100 points");

# %% tags=["folded"]
# @title Show in 3-D what is left (you need not read this)
from utils.scene3d import Scene

some = np.abs(cloud[:, 1]) < 15
(Scene("Clusters of at least 100 points, and grey noise").add_clusters(cloud[some], filtered[some])
 .add_ego_car().show(interactive=True))

# %% nbgrader={"grade": true, "grade_id": "test_filter_clusters", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_clusters)

# %% [markdown]
# ## Play: how small is too small?
#
# The 60 puffs of spray have 10 points on average, but their sizes differ widely.

# %%
last_puff = predict("What is the smallest minimum that removes all spray?")

# %% tags=["folded"]
# @title Prepare the slider (you need not read this)
# Draw all points that the slider can remove, and every fourth of the other points.
thin = np.flatnonzero((np.arange(len(cloud)) % 4 == 0) | (sizes[cluster_labels - 1] < 600))


def left_over(minimum):
    """Return the new labels of the points that are drawn."""
    return filter_clusters(cluster_labels, minimum)[thin]


def lost_by(minimum):
    """Return how many puffs of spray are left, and how many obstacles of each kind are gone."""
    kept = filter_clusters(cluster_labels, minimum) > 0
    gone = np.unique(objects[~kept & (objects > 0) & (objects < 10_000)])
    first = [np.flatnonzero(truth["objects"] == number)[0] for number in gone]
    kinds, counts = np.unique(np.array(names)[truth["classes"][first]], return_counts=True)
    return len(np.unique(objects[kept & (objects >= 10_000)])), dict(zip(kinds.tolist(), counts.tolist()))

# %% [markdown]
# Move the slider until the road is clear. Which obstacles disappear together with the spray?

# %%
@interact(minimum=IntSlider(value=5, min=5, max=600, step=5, description="min points",
                            continuous_update=False))
def show_minimum(minimum):
    puffs_left, kinds_gone = lost_by(minimum)
    plots.clusters(cloud[thin], left_over(minimum), limits=street, title=f"at least {minimum} points")
    plt.show()
    print(f"puffs of spray left: {puffs_left}; removed obstacles:",
          ", ".join(f"{kind} ({count})" for kind, count in kinds_gone.items()) or "none")

# %%
largest_puff = np.bincount(puff - 10_000).max()
last_puff.compare(largest_puff + 1, f"The largest puff has {largest_puff} points. A minimum that is "
                  "greater by one removes it, and also every obstacle that is not larger.")
print("obstacles that this minimum removes:",
      ", ".join(f"{kind} ({count})" for kind, count in lost_by(int(largest_puff) + 1)[1].items()))

# %% [markdown]
# The same without a slider, for three minima:

# %%
figure, rows = plt.subplots(3, 1, figsize=(8.5, 12), layout="compressed")
for minimum, axes in zip((10, 100, 500), rows):
    plots.clusters(cloud[thin], left_over(minimum), limits=street, axes=axes,
                   title=f"min_num_points = {minimum}")

# %% [markdown]
# ## Theory: how many points is a person?
#
# *At twice the distance, an object has a quarter of the points.*
#
# The rays of the scanner spread out, so fewer of them hit a person who is far away. The angles between neighbouring rays are $\delta_\varphi$ sideways and $\delta_\theta$ up and down. At a distance $r$, the rays are $r\,\delta_\varphi$ and $r\,\delta_\theta$ metres apart. The number of rays that hit an area $A$ is therefore
#
# $$N(r) = \frac{A}{\delta_\varphi\,\delta_\theta\,r^2}$$
#
# Our scanner has $\delta_\varphi = 0.18°$, and its upper [beams](#Words-of-the-course) are $0.33°$ apart. The scanner sees about $0.4\ \mathrm{m}^2$ of a pedestrian above the ground level of this cloud.
#
# One scan contains few people, so we simulate ten more streets.

# %%
reach_of_100 = predict("Up to what distance does a person in plain view have 100 points?",
                       between=(0, 60), unit="m")

# %% tags=["folded"]
# @title Find the clusters of a street, and people in plain view (you need not read this)
def plain_view(frame):
    """Return for each cluster of a frame whether it is a person and nothing closer hides it."""
    points, classes = frame.cloud, frame.scan.classes
    use = (points[:, 2] >= -1.2) & ~np.isin(classes, [names.index("invalid"), names.index("ego")])
    x, y, z = points[use, :3].T
    angle, away, objects_there = np.arctan2(y, x), np.hypot(x, y), frame.scan.objects[use]
    free = []
    for box in frame.boxes:
        if box.kind == "pedestrian":
            middle = np.arctan2(box.centre[1], box.centre[0])
            far = np.hypot(box.centre[0], box.centre[1])
            corners = np.arctan2(box.corners[:, 1], box.corners[:, 0])
            wide = np.abs((corners - middle + np.pi) % (2 * np.pi) - np.pi).max()
            beside = np.abs((angle - middle + np.pi) % (2 * np.pi) - np.pi)
            low, high = -1.2 / far, box.corners[:, 2].max() / far  # the slopes of rays that hit it
            blocked = ((beside < wide) & (away < far - 0.6) & (z / away > low) & (z / away < high)
                       & (objects_there != box.identity)).any()
            if not blocked:
                free.append(box.identity)
    labels = labels_from_truth(points[use], objects_there)
    return np.isin(objects_there[np.unique(labels, return_index=True)[1]], free)


def clusters_of(frame):
    """Return the labels of a simulated frame, and the kind and distance of each cluster."""
    points, classes = frame.cloud, frame.scan.classes
    use = (points[:, 2] >= -1.2) & ~np.isin(classes, [names.index("invalid"), names.index("ego")])
    labels = labels_from_truth(points[use], frame.scan.objects[use])
    first = np.unique(labels, return_index=True)[1]  # any point of a cluster will do
    return labels, np.array(names)[classes[use][first]], np.hypot(*points[use][first, :2].T)

# %% tags=["folded"]
# @title Count the points on people in ten streets (you need not read this)
frames = [scenes.random_street(seed, difficulty=0.9) for seed in range(10)]
streets = [clusters_of(frame) for frame in frames]
kind = np.concatenate([kinds for _, kinds, _ in streets])
distance = np.concatenate([distances for _, _, distances in streets])
size = np.concatenate([np.bincount(labels)[1:] for labels, _, _ in streets])
in_view = np.concatenate([plain_view(frame) for frame in frames])


def theory(distance, area=0.4):
    """Return how many points an object has if the scanner sees `area` square metres of it."""
    return area / (np.radians(0.18) * np.radians(1 / 3) * distance ** 2)


r = np.array([4.0, 80.0])
axes = plots.curves({"a person, in theory": (r, theory(r))},
                    {name: (distance[group], size[group]) for name, group in (
                        ("ground", kind == "ground"), ("car", kind == "car"),
                        ("person, partly hidden", (kind == "pedestrian") & ~in_view),
                        ("person in plain view", (kind == "pedestrian") & in_view))},
                    across="distance (m)", up="points", title="Points on an object, by its distance")
axes.axhline(100, color="black", linestyle=":")
axes.set_xscale("log"); axes.set_yscale("log"); axes.set_xlim(4, 80)
axes.set_xticks([5, 10, 20, 40, 80], ["5", "10", "20", "40", "80"]); axes.minorticks_off()
plt.setp(axes.lines, markersize=4)
plt.setp(axes.lines[-2], markersize=8, markeredgecolor="black")  # the few people in plain view
middling = (kind == "pedestrian") & (distance > 5) & (distance < 25)
over = size / theory(distance)  # measured points as a multiple of the theory
rows = []
for what, group in (("in plain view", middling & in_view), ("partly hidden", middling & ~in_view)):
    low, mid, high = np.quantile(over[group], [0.1, 0.5, 0.9])
    rows.append([what, group.sum(), f"{mid:.2f}", f"{low:.2f} to {high:.2f}"])
show_table(["people 5 to 25 m away", "number", "points divided by theory (median)",
            "8 of 10 people have"], rows)
reach_of_100.compare(np.sqrt(theory(1.0) / 100), "There, the line crosses the dotted line. In "
                     f"theory, a person has {theory(1.0):,.0f} points at 1 m, and a hundredth of "
                     "that at 10 m.")

# %% [markdown]
# Up to 25 m, people in plain view are close to the line. But most people are partly hidden by something closer, and often have less than half as many points. So the line shows about how many points a person has *at best*. On logarithmic axes, $1/r^2$ is a straight line with slope $-2$.
#
# Beyond 25 m, even people in plain view are below the line, most of them far below. All six of them are where the street is about a metre lower than here. Only the upper 20 to 60 cm of them are above our ground level, instead of about 1.2 m of a person nearby. So the visible area $A$ is much smaller than $0.4\ \mathrm{m}^2$.
#
# A person beyond the crossing of the two lines has fewer than 100 points, even in plain view. A minimum size is therefore also a *maximum distance*. How far must a car see? As in lesson 07, a car drives on for half a second while it thinks, and then brakes at 7 m/s². We measure from the scanner, and the bumper is 2.6 m ahead of it.

# %%
speed = 50 / 3.6
stopping = 2.6 + 0.5 * speed + speed ** 2 / 14
print(f"From 50 km/h, a car stops {stopping:.1f} m beyond the place where its scanner was.")
rows = []
for minimum in (5, 10, 30, 100, 300):
    reach = np.sqrt(theory(1.0) / minimum)
    nearer = (kind == "pedestrian") & (distance < reach)
    rows.append([minimum, f"{reach:.1f} m", "yes" if reach > stopping else "no",
                 f"{np.mean(size[nearer] < minimum):.0%}"])
show_table(["min_num_points", "keeps people in plain view up to (theory)", "in time from 50 km/h",
            "removes this share of all people within that distance"], rows)

# %% [markdown]
# The distances above 25 m hold on a level street. Where the street falls, as above, they are shorter. Even within these distances, each minimum removes about a third of all people or more. Most of the people that it removes are partly hidden by something closer.
#
# ## Practice: what does it cost?
#
# Pieces of road are *ghosts*, or phantom obstacles. A larger minimum removes more ghosts, but also more people. Your `filter_clusters` shows how many.

# %%
minima = np.array([1, 2, 5, 10, 20, 30, 50, 100, 200, 400, 800])
person, ghost, near = kind == "pedestrian", kind == "ground", distance < 15


def gone_at(minimum):
    """Return for each cluster of the ten streets whether the filter removes it."""
    return np.concatenate([~np.isin(np.unique(labels), filter_clusters(labels, minimum))
                           for labels, _, _ in streets])

# %% tags=["folded"]
# @title Draw what each minimum removes (you need not read this)
gone = np.array([gone_at(minimum) for minimum in minima.tolist()])
shown = {"the ghosts": ghost, "the people within 15 m": person & near,
         "the people beyond 15 m": person & ~near}
axes = plots.curves({name: (minima, gone[:, group].mean(axis=1)) for name, group in shown.items()},
                    across="min_num_points", up="share that is removed",
                    title=f"{ghost.sum()} ghosts and {person.sum()} people in ten streets")
axes.axvline(100, color="black", linestyle=":")
axes.set_xscale("log")
for minimum in (10, 100):
    row = gone[minima.tolist().index(minimum)]
    print(f"min_num_points = {minimum} removes",
          ", ".join(f"{row[group].mean():.0%} of {name}" for name, group in shown.items()))

# %% [markdown]
# The dotted line marks the default. It removes all ghosts, but also the people beyond 15 m and many of the people near the car. The removed people near the car are partly hidden, for example by a parked car, and may step out at any moment. With a smaller minimum, nearly all ghosts still go, and nearly all people near the car stay.
#
# But no minimum removes the ghosts and keeps the distant people. Their *sizes* overlap, so size alone cannot distinguish them. In the thinned clouds of lesson 12, a person has tens of points rather than hundreds, so the minimum is smaller there.
#
# ## A minimum that falls with the distance
#
# *At twice the distance, ask for a quarter of the points.*
#
# A fixed minimum asks a distant person for more visible area than a person nearby. If $m_{10}$ is the minimum at 10 m, then
#
# $$m(r) = m_{10} \cdot \left(\frac{10\,\mathrm{m}}{r}\right)^2$$
#
# requires the same area at every distance. The function below requires 100 points everywhere. Change one line, so that the minimum is 100 points at 10 m and falls like $m(r)$. This task has no check. How many distant people come back, and how many ghosts? And is your minimum better than a fixed minimum of 10?

# %%
def minimum_at(distance):
    """Return the smallest number of points that a cluster must have at each distance (m)."""
    return 100 + 0 * distance  # change this line


print("minimum at 5, 10, 20 and 40 m:", minimum_at(np.array([5.0, 10.0, 20.0, 40.0])))

# %% tags=["folded"]
# @title Compare three minima in the ten streets (you need not read this)
show_table(["minimum", "ghosts left", "people left within 15 m", "people left beyond 15 m"],
           [[name, *(f"{np.sum(size[group] >= least[group])} of {group.sum()}"
                     for group in (ghost, person & near, person & ~near))]
            for name, least in (("100 everywhere", np.full(len(size), 100)),
                                ("yours", minimum_at(distance)),
                                ("10 everywhere", np.full(len(size), 10)))])
r = np.geomspace(4, 80, 50)
axes = plots.curves({"your minimum": (r, minimum_at(r))},
                    {"ghosts": (distance[ghost], size[ghost]),
                     "people": (distance[person], size[person])},
                    across="distance (m)", up="points", title="Your minimum, by the distance")
axes.axhline(10, color="black", linestyle=":", label="10 points")
axes.legend(loc="lower left")
axes.set_xscale("log"); axes.set_yscale("log"); axes.set_xlim(4, 80)
axes.set_xticks([5, 10, 20, 40, 80], ["5", "10", "20", "40", "80"]); axes.minorticks_off()
plt.setp(axes.lines, markersize=4);

# %% [markdown]
# <details><summary>An answer</summary>
#
# Write `return 100 * (10 / distance)**2`. Of the 201 people beyond 15 m, 73 come back, but 203 ghosts come back as well. All of these ghosts are beyond 30 m, where fewer than 12 points are enough. A fixed minimum of 10 is better here. It keeps 66 of the distant people and 67 of the 69 people near the car, but only 40 ghosts. Near the car, the falling minimum keeps only 42 people, because it asks for more area than a partly hidden person shows.
# </details>
#
# ## A maximum number of points does not work
#
# Some pipelines also drop clusters with too *many* points, such as house fronts. Here are our largest clusters. Does a maximum separate the cars from the walls?

# %%
rows = []
for label in np.argsort(sizes)[::-1][:14] + 1:  # labels of the largest clusters
    members = cluster_labels == label
    index = truth["objects"] == objects[members][0]
    away = np.hypot(*cloud[members, :2].mean(axis=0))
    rows.append([names[truth["classes"][index][0]], f"{away:.1f} m", f"{members.sum():,}"])
show_table(["kind", "distance", "points"], rows)

# %% [markdown]
# No, because a car nearby has more points than a wall that is farther away. A maximum in *metres* works better, because no car is 10 m long. But a bus can be longer, so a car must still brake for a large cluster in its lane.
#
# ## Common mistakes
#
# | what the code does | what you see |
# |---|---|
# | renumbers the labels inside the loop | if small clusters have consecutive labels, every second one is still there |
# | renumbers the labels at the end | no cluster is missing, but the colours have changed |
# | compares `label < min_num_points` | the first 99 clusters are gone, whatever their size |
# | compares with `>` instead of `<` | only spray, road and other small clusters are left |
# | deletes the labels of small clusters | a later error, because there are fewer labels than points |
# | writes `cluster_labels[...] = 0` | no error, until a later step needs the old labels |
#
# In the pictures, rings mark up to five of the clusters that are wrongly kept or removed. To save time, the pictures and their legends contain only every fourth point of a cluster of 600 points or more.

# %% tags=["folded"]
# @title Draw three mistakes on the street (you need not read this)
def moved_up_in_the_loop(labels, minimum):
    labels = labels.copy()
    for number in range(1, labels.max() + 1):
        if np.sum(labels == number) < minimum:
            labels[labels == number] = 0
            labels[labels > number] -= 1
    return labels


size_at = sizes[cluster_labels - 1]  # for each point, the size of its cluster
wrong = {"Renumbered in the loop": moved_up_in_the_loop(cluster_labels, 100) > 0,
         "label < min_num_points": cluster_labels >= 100,
         "> instead of <": size_at <= 100}
figure, rows = plt.subplots(3, 1, figsize=(8.5, 12), layout="compressed")
for (name, kept), axes in zip(wrong.items(), rows):
    wrongly_kept = np.unique(cluster_labels[kept & (size_at < 100)])
    wrongly_gone = np.unique(cluster_labels[~kept & (size_at >= 100)])
    plots.kept_and_removed(cloud[thin], kept[thin], limits=street, axes=axes,
                           title=f"{name}: {len(wrongly_kept)} small clusters stay, "
                                 f"{len(wrongly_gone)} large ones go")
    mistaken, rings = wrongly_gone if len(wrongly_gone) else wrongly_kept, []
    for label in mistaken[np.argsort(-sizes[mistaken - 1])]:  # five of them, the largest first
        x, y = np.median(cloud[cluster_labels == label, :2], axis=0)
        if -19 < x < 29 and abs(y) < 7 and all(np.hypot(x - a, y - b) > 3 for a, b in rings):
            rings = [*rings, (x, y)][:5]
    for x, y in rings:
        plots.ring(axes, x, y, radius=1.4)

# %% [markdown]
# ## Let it drive
#
# This drive is optional. A car drives for ten seconds at 30 km/h, and your `filter_clusters` decides which clusters are too small to brake for. The other steps are given. They also thin out the scan, so obstacles have fewer points than in the pictures above. After nine seconds, a cyclist from a side street is in our lane. The cell takes about 15 seconds.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own  # own(f) is your function f, never a stored answer


def drive_with(min_num_points, street=3):
    """Drive ten seconds through a street, and remove clusters of fewer points."""
    mine = own(filter_clusters)
    return drive_street(street, chain(keep=lambda labels: mine(labels, min_num_points)), seconds=10,
                        clock=on_time)


drive_with(10) if is_written(filter_clusters) else print(
    "filter_clusters is not written, or has not passed its check.")

# %% [markdown]
# The car brakes early and stays 2 m away from the cyclist. Now try the default, `drive_with(100)`. **A challenge:** find the largest minimum, in steps of 10, with which the car does not hit the cyclist. And what does a minimum of 1 do in the rain? Try `drive_with(1, street=8)`.
#
# <details><summary>An answer</summary>
#
# With 100, the cyclist never has a box, and the car hits the cyclist at 30 km/h. The largest minimum is 40. With 50, the cyclist first has a box one second before the collision, and the car brakes with 3 m to go. In the rain, with a minimum of 1, the car brakes for a drop at once and drives only 8 m. With 10, it drives 82 m without braking. A cluster of ten drops is nearly always above the bonnet of the ego car. There, the driver ignores a box until it has stayed in place for a second.
# </details>

# %% [markdown]
# **By hand.** A minimum of 40 is small enough for the cyclist, but a person has fewer points. Below, a person is in the road, and two cars are parked on our right. Drag the ringed person. At each place, the simulator makes one new scan with the scanner of the drive, and the given steps thin it out and cluster it. Your `filter_clusters`, here with a minimum of 30, decides whether the person has a box. The title counts the returns that hit the person, and the points of the person's cluster after thinning.
#
# Where in our lane does the person have no box? Now try other minima, such as `drag_person(40)`. What is the largest minimum, in steps of 10, with which the person has a box wherever the car must brake? Then drive through this street with `drive_past(30)`. The person is where you left them.
#
# <details><summary>An answer</summary>
#
# With 30, the person has a box nearly everywhere up to 6 m, in fewer than half of the places from 7 m to 13.5 m, and hardly anywhere beyond 14 m. The steps before yours keep one point per cube of 20 cm, and a few centimetres decide how many cubes have a point. At the start, 25 points are left. At y = -0.4, only 20 cm farther to the left, there are 35.
#
# The largest minimum is 20, and it is only just small enough. In 110 places, half a metre apart, the smallest cluster has 20 points. For the person at the start, the car then brakes with 9 m to go, and stops in time. With 30, it brakes with 3 m to go, and hits the person at 19 km/h.
#
# Between the parked cars, at (11, -3), only 4 points are left. There, even a minimum of 10 removes the person.
# </details>

# %% tags=["folded"]
# @title Draw the street with the person (you need not read this)
from utils.by_hand import Drawing, drag_points
from utils.drive.person import SCENERY, look_at_person, street_with_person

place = [11.0, -0.6]  # where the person is: metres ahead of the scanner, and to its left


def drag_person(min_num_points):
    """Show a person to drag, and whether your function leaves this person a box."""
    mine = own(filter_clusters)

    def show_person(points):
        place[:] = points[1].tolist()
        seen = look_at_person(*place, lambda labels: mine(labels, min_num_points))
        result = "no box"
        if seen.has_box:
            result = "a box, and the car brakes" if seen.brakes else "a box, and the car drives on"
        return Drawing(f"{seen.returns} returns, cluster of {seen.points}: {result}",
                       labels=[0, 1 if seen.has_box else 2],
                       names={0: "scanner", 1: "person with a box", 2: "person without a box"},
                       **SCENERY)

    drag_points(show_person, [(0, 0), place], movable=[1], limits=((-3, 25), (-5, 5)))


def drive_past(min_num_points):
    """Drive ten seconds through the street, with the person where you left them."""
    return drive_with(min_num_points, street_with_person(*place))

# %%
drag_person(30) if is_written(filter_clusters) else print(
    "filter_clusters is not written, or has not passed its check.")

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(filter_clusters)

# %% [markdown]
# ## In practice
#
# In many libraries, the minimum is a setting of the clustering itself:
#
# ```python
# # PCL, in C++
# extraction.setMinClusterSize(100); extraction.setMaxClusterSize(25000);
# # scikit-learn; noise is -1
# labels = sklearn.cluster.HDBSCAN(min_cluster_size=100).fit_predict(xyz)
# # Open3D: filter afterwards
# labels = np.array(point_cloud.cluster_dbscan(eps=0.5, min_points=1))
# ```
#
# - After a voxel grid (lesson 06), sizes hardly depend on distance, up to the range where the beams are farther apart than the cells.
# - Time helps more than size. In the next frame, spray is somewhere else, but a person is not. Trackers therefore keep small clusters for a few frames, and drop those that do not come back (lesson 12).
#
# ## Summary
#
# - The points of small clusters get label 0, and all other labels stay the same.
# - Count first, then decide for all points at once. Renumbering inside a loop skips clusters.
# - The number of points falls with the square of the distance, so a minimum size is also a maximum distance.
#
# **Sources.** Minimum and maximum cluster sizes: [Point Cloud Library, Euclidean cluster extraction](https://pcl.readthedocs.io/projects/tutorials/en/latest/cluster_extraction.html). Noise as a label of its own: [Ester et al. 1996](https://cdn.aaai.org/KDD/1996/KDD96-037.pdf). Rain and fog in scans: [Heinzler et al. 2020](https://doi.org/10.1109/LRA.2020.2972865).
#
# **Next:** 10 · Clustering in real time

# %% [markdown]
# ## If you want more
#
# Each task takes 10 to 20 minutes.
#
# 1. Filter by extent. Drop clusters that are longer than 8 m or less than 0.3 m high. Which mistakes are left?
# 2. Add a parameter `max_num_points`. Find a value that removes more walls than cars in this scan.
# 3. Many robots carry a scanner with 16 beams, which gives an object only about a sixth of the points. Run `from utils.simulator import vlp16` and pass `sensor=vlp16()` to `scenes.random_street`. Which minimum keeps most people within 15 m?

# %% [markdown] tags=["footer"]
# (footer)
