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
# ![A street from above. Cars, people, trees and house fronts are drawn as coloured clusters; among them, scattered over the road, small grey crosses: clusters that were too small and now count as noise.](09_preview.png)
#
# Clustering gives every point a [cluster](#Words-of-the-course), even if the cluster is three drops of water. If each of them becomes a box, the car brakes for spray. If we throw away too much, it does not brake for a child.
#
# **After this lesson you can**
# - remove small clusters from a labelled cloud, without changing the others,
# - say what a minimum size costs: which people it removes, and at which distance.
#
# **You write** `filter_clusters` (points). **You need** boolean masks (lesson 01) and an idea of what cluster labels are (lesson 05). **Time:** (time)

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A wet street, in clusters
#
# *A label says which points belong together, not whether they are worth anything.*
#
# We take the course's scan within 30 m and above the road, and it has rained: the wheels throw up spray, and a scanner sees spray. The drops are invented; the rest is the scan you know.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_cloud, plots, predict, scenes
from utils.datasets import DATA

scan, truth = load_cloud("cloud.txt"), np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
useless = np.isin(truth["classes"], [names.index("invalid"), names.index("ego")])
wanted = (scan[:, 2] >= -1.2) & (np.hypot(scan[:, 0], scan[:, 1]) < 30) & ~useless

rng = np.random.default_rng(9)
size_of_puff = rng.geometric(0.1, 60).astype(np.intp)  # most puffs of spray are tiny, a few are not
middle = rng.uniform([-15, -3, -0.9], [25, 3, 0.2], (60, 3)).repeat(size_of_puff, axis=0)
spray = np.column_stack([rng.normal(middle, 0.12), np.full(len(middle), 0.1)])
puff = 10_000 + np.arange(60).repeat(size_of_puff)  # numbers that no object has

cloud = np.vstack([scan[wanted], spray])
objects = np.concatenate([truth["objects"][wanted], puff])  # what each return hit; 0 is the road
print(f"{len(cloud):,} points, {len(spray)} of them spray")

# %% [markdown]
# So that this lesson does not depend on your lesson 05, the labels come from the simulator, which knows what each [return](#Words-of-the-course) hit. Every object is one cluster, and so is every square metre of road that got past the ground filter. The labels run from 1 to N, as yours do.

# %%
def labels_from_truth(points, objects):
    """One cluster for each object; the road, object 0, falls into squares of a metre."""
    square = np.where(objects[:, None] == 0, np.floor(points[:, :2]), 0)
    return np.unique(np.column_stack([objects, square]), axis=0, return_inverse=True)[1].ravel() + 1


cluster_labels = labels_from_truth(cloud, objects)
print(f"{cluster_labels.max()} clusters; the labels of some points:")
cluster_labels[::7000]

# %%
street = ((-20, 30), (-10, 10))  # x from, to; y from, to
plots.clusters(cloud, cluster_labels, limits=street, title="Everything is a cluster");

# %% [markdown]
# Some of these clusters have thousands of points, some have three. How many are small?

# %%
how_many_small = predict(f"How many of the {cluster_labels.max()} clusters have fewer than 100 points?",
                         between=(0, int(cluster_labels.max())))
share_of_small = predict("What share of all points do those small clusters hold together?",
                         between=(0, 100), unit="%")

# %%
sizes = np.bincount(cluster_labels)[1:]  # how often each label occurs; label 0 does not, yet
small = sizes < 100
how_many_small.compare(small.sum(), "A scan holds few large things and many small ones: each puff "
                       "of spray, each pole and each patch of road is a cluster of its own.")
share_of_small.compare(100 * sizes[small].sum() / sizes.sum(), "They are small: it takes hundreds of "
                       "them to make up for one house front.")
axes = plots.curves({}, {"clusters": (np.arange(1, len(sizes) + 1), np.sort(sizes)[::-1])},
                    across="rank, from the largest to the smallest", up="points",
                    title="A few giants and a long tail")
axes.axhline(100, color="black", linestyle=":", label="100 points")
axes.set_xscale("log"); axes.set_yscale("log"); axes.legend();

# %% [markdown]
# Most clusters are small, and the small ones hold next to nothing of the cloud. That is why a filter by size works at all: it removes most of the *clusters* and hardly any of the *points*.
#
# ## The naive idea: remove one, close the gap
#
# *Never renumber a list while you walk along it.*
#
# Labels run from 1 to N without gaps, and it feels right to keep it so: whenever a cluster goes, the later ones move up by one. Here are four clusters of 5, 1, 2 and 4 points, and we want at least 3.

# %%
labels = np.array([1, 1, 1, 1, 1, 2, 3, 3, 4, 4, 4, 4])
for number in range(1, 5):
    how_many = np.sum(labels == number)
    verdict = "stays" if how_many else "no point has this label"
    if 0 < how_many < 3:
        labels[labels == number] = 0
        labels[labels > number] -= 1  # close the gap
        verdict = "goes, and the later ones move up"
    print(f"label {number}: {how_many} points, {verdict:33}", labels)

# %% [markdown]
# Look for the cluster of two points: it is still there. When cluster 2 went, cluster 3 became the new 2. The loop then moved on to 3 and never looked back. Of two consecutive small labels, the second survives.
#
# It is a nasty mistake: on a test cloud with a single small cluster all is well.
#
# ## The idea: one number for "belongs to nothing"
#
# *Label 0 means noise; all other labels stay as they are.*
#
# Let $c_i$ be the label of point $i$ and $m$ the smallest size that counts. Then the new label is
#
# $$c_i' = \begin{cases} c_i & \text{if } c_i \text{ occurs at least } m \text{ times,}\\ 0 & \text{otherwise.}\end{cases}$$
#
# Nothing moves, so nothing can be skipped, and cluster 17 of the last picture is cluster 17 of the next. There may be gaps in the numbers. Lesson 08 draws a box for each label above 0 and does not mind.
#
# All that remains is to count. NumPy has two tools for that. Take the shoe sizes of eight people:

# %%
shoes = np.array([41, 38, 44, 41, 41, 38, 39, 44])
kinds, which, how_many = np.unique(shoes, return_inverse=True, return_counts=True)
print("np.unique    sizes", kinds, " pairs of each", how_many)
print("             for each person, the row of the table:", which)
print("np.bincount  of size 41:", np.bincount(shoes)[41], " of size 40:", np.bincount(shoes)[40])

# %% [markdown]
# A table of counts, indexed with one entry per person, gives back one count per person: `how_many[which]` tells each of the eight how many wear the same size. No loop is needed.
#
# ## Exercise · `filter_clusters` (points)
#
# Set the labels of clusters with fewer than `min_num_points` points to 0. A cluster of exactly `min_num_points` points stays. Points that have label 0 already keep it, however many they are. There may be gaps in the labels, and there may be no labels at all.

# %% nbgrader={"grade": false, "grade_id": "filter_clusters", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_clusters(cluster_labels, min_num_points=100):
    """Turn clusters that are too small into noise.

    Parameters
    ----------
    cluster_labels : ndarray of int, shape (n,)
        The cluster of each point, 1 or greater; 0 for points that belong to none.
    min_num_points : int
        Clusters with fewer points than this are removed.

    Returns
    -------
    ndarray of int, shape (n,)
        A new array: 0 for the points of clusters that are too small, all other
        labels as they were.
    """
    # 1. Count how many points carry each label.
    # 2. From that, the size of the cluster of each point.
    # 3. A new array: 0 where that size is too small, the old label elsewhere.
    # roughly 3 lines
    ### BEGIN SOLUTION
    _, row, size = np.unique(cluster_labels, return_inverse=True, return_counts=True)
    size_of_its_cluster = size[row]
    return np.where(size_of_its_cluster < min_num_points, 0, cluster_labels)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# You need a size for each *point*, not for each cluster. Then it is one comparison, and the answer has the length of `cluster_labels`.
# </details>
# <details><summary>Hint 2</summary>
#
# With the shoes it was `how_many[which]`. Do the same with `cluster_labels` in place of `shoes`. Or go label by label, with a copy to write into and the original to read from.
# </details>
# <details><summary>Hint 3</summary>
#
# `np.where(condition, a, b)` builds a new array: `a` where the condition holds, `b` elsewhere. The condition is "the size of its cluster is less than `min_num_points`", `a` is 0 and `b` is `cluster_labels`.
# </details>

# %% [markdown]
# **Try it on ten points first.** Cluster 1 has four of them, clusters 2 and 3 have two each, one after the other, cluster 5 has one, and one point is noise already. With a minimum of two, one label should go; with three, two more should. The last line shows whether your function wrote into what it was given.

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
                      title="With at least 3: there should be one cluster and six noise points")
axes.set_yticks([]); axes.set_ylabel(""); axes.set_xlabel("row"); axes.set_xticks(range(10));

# %% [markdown]
# **Look before you check.** What is left should be cars, people, trees and house fronts in their old colours. The road should be free of clusters and full of grey crosses.

# %%
filtered = filter_clusters(cluster_labels)  # the minimum is 100 where none is given
print(f"{len(np.unique(cluster_labels))} clusters in, {len(np.unique(filtered[filtered > 0]))} out, "
      f"{np.mean(filtered == 0):.1%} of the points are noise now")
plots.clusters(cloud, filtered, limits=street, title="Clusters of at least 100 points");

# %% tags=["folded"]
# @title What is left, to turn in space (you need not read this)
from utils.scene3d import Scene

some = (np.arange(len(cloud)) % 4 == 0) & (np.abs(cloud[:, 1]) < 15)
(Scene("Clusters of at least 100 points, and grey noise").add_clusters(cloud[some], filtered[some])
 .add_ego_car().show(interactive=True))

# %% nbgrader={"grade": true, "grade_id": "test_filter_clusters", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_clusters)

# %% [markdown]
# ## Play: how small is too small?
#
# *The setting that clears the road also clears the pavement.*

# %%
last_puff = predict("From which minimum on is the last puff of spray gone?")

# %% tags=["folded"]
# @title What the slider shows (you need not read this)
# Of what the slider never removes every fourth point is enough to look at; of the rest all.
thin = np.flatnonzero((np.arange(len(cloud)) % 4 == 0) | (sizes[cluster_labels - 1] < 600))


def left_over(minimum):
    """The new labels of the points that are drawn."""
    return filter_clusters(cluster_labels, minimum)[thin]


def lost_by(minimum):
    """How many puffs of spray are left, and how many obstacles of each kind are gone."""
    kept = filter_clusters(cluster_labels, minimum) > 0
    gone = np.unique(objects[~kept & (objects > 0) & (objects < 10_000)])
    first = [np.flatnonzero(truth["objects"] == number)[0] for number in gone]
    kinds, counts = np.unique(np.array(names)[truth["classes"][first]], return_counts=True)
    return len(np.unique(objects[kept & (objects >= 10_000)])), dict(zip(kinds.tolist(), counts.tolist()))

# %% [markdown]
# Move the slider until the road is clear. What went with the spray?

# %%
@interact(minimum=IntSlider(value=5, min=5, max=600, step=5, description="min points",
                            continuous_update=False))
def show_minimum(minimum):
    puffs_left, kinds_gone = lost_by(minimum)
    plots.clusters(cloud[thin], left_over(minimum), limits=street, title=f"at least {minimum} points")
    plt.show()
    print(f"{puffs_left} puffs of spray are left; gone are:",
          ", ".join(f"{count} {kind}" for kind, count in kinds_gone.items()) or "no obstacles")

# %%
largest_puff = np.bincount(puff - 10_000).max()
last_puff.compare(largest_puff + 1, f"The largest puff has {largest_puff} points. With one more as "
                  "the minimum it goes, and so does each obstacle that has no more points than it.")
print("with that minimum these obstacles are gone:",
      ", ".join(f"{count} {kind}" for kind, count in lost_by(int(largest_puff) + 1)[1].items()))

# %% [markdown]
# The same without a slider: three sizes.

# %%
figure, rows = plt.subplots(3, 1, figsize=(8.5, 12), layout="compressed")
for minimum, axes in zip((10, 100, 500), rows):
    plots.clusters(cloud[thin], left_over(minimum), limits=street, axes=axes,
                   title=f"min_num_points = {minimum}")

# %% [markdown]
# ## Theory: how many points is a person?
#
# *Twice as far away, a quarter of the points.*
#
# The scanner fires a grid of rays, $\delta_\varphi$ apart to the side and $\delta_\theta$ apart in height. At a distance $r$, neighbouring rays are $r\,\delta_\varphi$ and $r\,\delta_\theta$ metres apart. A thing that shows the scanner an area $A$ therefore catches
#
# $$N(r) = \frac{A}{\delta_\varphi\,\delta_\theta\,r^2}$$
#
# of them. Our scanner has $\delta_\varphi = 0.18°$, and its upper [beams](#Words-of-the-course) are $0.33°$ apart. What a pedestrian shows above the ground level of this cloud is about $0.4\ \mathrm{m}^2$.
#
# One scan holds few people. So let us draw ten more streets, and find out how many points a person, a car or a piece of road really has.

# %%
reach_of_100 = predict("How far away may a person in plain view be, to have 100 points?",
                       between=(0, 60), unit="m")

# %% tags=["folded"]
# @title Who stands in plain view (you need not read this)
def plain_view(frame):
    """For each cluster of a frame, whether it is a person with nothing nearer in the way."""
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

# %%
def clusters_of(frame):
    """Labels of a simulated frame, with kind and distance of each cluster."""
    points, classes = frame.cloud, frame.scan.classes
    use = (points[:, 2] >= -1.2) & ~np.isin(classes, [names.index("invalid"), names.index("ego")])
    labels = labels_from_truth(points[use], frame.scan.objects[use])
    first = np.unique(labels, return_index=True)[1]  # any point of a cluster will do
    return labels, np.array(names)[classes[use][first]], np.hypot(*points[use][first, :2].T)


frames = [scenes.random_street(seed, difficulty=0.9) for seed in range(10)]
streets = [clusters_of(frame) for frame in frames]
kind = np.concatenate([kinds for _, kinds, _ in streets])
distance = np.concatenate([distances for _, _, distances in streets])
size = np.concatenate([np.bincount(labels)[1:] for labels, _, _ in streets])


in_view = np.concatenate([plain_view(frame) for frame in frames])


def theory(distance, area=0.4):
    """Points on a thing that shows the scanner `area` square metres."""
    return area / (np.radians(0.18) * np.radians(1 / 3) * distance ** 2)


r = np.array([4.0, 80.0])
axes = plots.curves({"a person, in theory": (r, theory(r))},
                    {name: (distance[group], size[group]) for name, group in (
                        ("ground", kind == "ground"), ("car", kind == "car"),
                        ("person, hidden in part", (kind == "pedestrian") & ~in_view),
                        ("person in plain view", (kind == "pedestrian") & in_view))},
                    across="distance (m)", up="points", title="Points on a thing against its distance")
axes.axhline(100, color="black", linestyle=":")
axes.set_xscale("log"); axes.set_yscale("log"); axes.set_xlim(4, 80)
axes.set_xticks([5, 10, 20, 40, 80], ["5", "10", "20", "40", "80"]); axes.minorticks_off()
plt.setp(axes.lines, markersize=4)
middling = (kind == "pedestrian") & (distance > 5) & (distance < 25)
over = size / theory(distance)  # times the line
for what, group in (("in plain view", middling & in_view), ("hidden in part", middling & ~in_view)):
    low, mid, high = np.quantile(over[group], [0.1, 0.5, 0.9])
    print(f"{group.sum():3} people 5 to 25 m away, {what}: {mid:.2f} times the points of the line, "
          f"most of them {low:.2f} to {high:.2f} times")
reach_of_100.compare(np.sqrt(theory(1.0) / 100), "That is where the line crosses the dotted one. In "
                     f"theory a person has {theory(1.0):,.0f} points at 1 m, and a hundredth of "
                     "that ten times as far away.")

# %% [markdown]
# People in plain view lie along the line, some a little above it. They are few: most people of a street are hidden in part by something nearer, and have half of the points that the line says, or far fewer. So read the line as what a person has *at best*. On logarithmic axes $1/r^2$ is a straight line of slope $-2$.
#
# A person farther away than the crossing has fewer than 100 points, even in plain view. A minimum size is therefore also a *maximum distance*. How far is far enough? As in lesson 07, a car drives on for half a second while it thinks, then brakes with 7 m/s². Its bumper is 2.6 m ahead of the scanner, from which we measure.

# %%
speed = 50 / 3.6
stopping = 2.6 + 0.5 * speed + speed ** 2 / 14
print(f"from 50 km/h, a car comes to stand {stopping:.1f} m from where its scanner was")
for minimum in (5, 10, 30, 100, 300):
    reach = np.sqrt(theory(1.0) / minimum)
    nearer = (kind == "pedestrian") & (distance < reach)
    print(f"min_num_points = {minimum:3d}: people in plain view up to {reach:4.1f} m"
          f"{'' if reach > stopping else ', too late'}; of all people nearer than that, "
          f"{np.mean(size[nearer] < minimum):.0%} have fewer points")

# %% [markdown]
# ## Practice: what does it cost?
#
# *Every minimum trades ghosts against people; the exchange rate depends on the distance.*
#
# Pieces of road are ghosts: the more of them go, the better. People must stay. Your own `filter_clusters` does the counting, for people nearer and farther than 15 m.

# %%
minima = np.array([1, 2, 5, 10, 20, 30, 50, 100, 200, 400, 800])


def gone_at(minimum):
    """For each cluster of the ten streets, whether the filter removes it."""
    return np.concatenate([~np.isin(np.unique(labels), filter_clusters(labels, minimum))
                           for labels, _, _ in streets])

# %%
gone = np.array([gone_at(minimum) for minimum in minima.tolist()])
person, ghost, near = kind == "pedestrian", kind == "ground", distance < 15
shown = {"the ghosts": ghost, "the people within 15 m": person & near,
         "the people beyond 15 m": person & ~near}
axes = plots.curves({name: (minima, gone[:, group].mean(axis=1)) for name, group in shown.items()},
                    across="min_num_points", up="share that is removed",
                    title=f"{ghost.sum()} ghosts and {person.sum()} people in ten streets")
axes.axvline(100, color="black", linestyle=":")
axes.set_xscale("log")
for minimum in (10, 100):
    row = gone[minima.tolist().index(minimum)]
    print(f"min_num_points = {minimum:3d}:",
          ", ".join(f"{row[group].mean():.0%} of {name}" for name, group in shown.items()))

# %% [markdown]
# Look along the dotted line of the default. The ghosts are gone, but so are the people beyond 15 m, and many of the people near the car: those half hidden by a parked one, and just these may step out from behind it. Further left the price for those near the car falls quickly, while nearly all ghosts still go.
#
# But no value clears the ghosts and spares the distant people. The two overlap in *size*, so size alone cannot tell them apart. The default of 100 suits a car that drives slowly and cares for large things close by. Lesson 12 works on thinned clouds, where a person has tens of points rather than hundreds, and needs a smaller minimum.
#
# ## Too big is a mistake, too
#
# *A minimum removes what is nothing; a maximum removes what is everything.*
#
# Some pipelines also drop clusters with too *many* points: house fronts, or a car and a wall that grew together. The table shows the largest clusters of our cloud. A single number that parts the cars from the walls would have to lie between them.

# %%
big = np.argsort(sizes)[::-1][:14] + 1  # labels of the largest clusters
for label in big:
    members = cluster_labels == label
    index = truth["objects"] == objects[members][0]
    away = np.hypot(*cloud[members, :2].mean(axis=0))
    print(f"{names[truth['classes'][index][0]]:>10} {away:5.1f} m away: {members.sum():6,} points")

# %% [markdown]
# They interleave: a car close by has more points than a wall farther off. A maximum in *metres* works better: no car is 10 m long. That needs boxes first (lesson 08), and then it is one more comparison.
#
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | labels moved up inside the loop | of small neighbours every second one is still there |
# | labels moved up at the end | nothing is missing, but all the colours have changed |
# | `label < min_num_points` | the first 99 clusters are gone, whatever their size |
# | `>` instead of `<` | spray, road and distant people, and nothing else |
# | the labels of small clusters deleted | an error further on: fewer labels than points |
# | `cluster_labels[...] = 0` | all is well, until a later step needs the old labels again |

# %% tags=["folded"]
# @title Three mistakes on the street (you need not read this)
def moved_up_in_the_loop(labels, minimum):
    labels = labels.copy()
    for number in range(1, labels.max() + 1):
        if np.sum(labels == number) < minimum:
            labels[labels == number] = 0
            labels[labels > number] -= 1
    return labels


size_at = sizes[cluster_labels - 1]  # for each point, the size of its cluster
wrong = {"Moved up in the loop": moved_up_in_the_loop(cluster_labels, 100) > 0,
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
# *What is dropped is driven into.*
#
# Without points; skip it if you like. A car drives ten seconds at 30 km/h, and your `filter_clusters` says what is too small to brake for. The rest is given; it thins the scan, so a cyclist has 50 to 100 points. Nine seconds on, one who came out of a side street is in our way.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own


def drive_with(min_num_points, street=3):
    """Ten seconds of a street, without clusters that are smaller."""
    mine = own(filter_clusters)
    return drive_street(street, chain(keep=lambda labels: mine(labels, min_num_points)), seconds=10,
                        clock=on_time)


drive_with(100) if is_written(filter_clusters) else print(
    "filter_clusters is not written, or has not passed its check.")

# %% [markdown]
# Try `drive_with(10)`. And what does a minimum of 1 do in the rain, `drive_with(1, street=8)`?
#
# <details><summary>An answer</summary>
#
# With 10 the car brakes for the cyclist, with 9 m to go, and stops 2 m away. In the rain with 1 it brakes for a drop at once and comes 8 m far. With 10 it comes 82 m far and does not brake: so many drops come together nearly only over our own bonnet, and what is there the driver believes when it has stayed in one place for a second.
# </details>

# %% [markdown]
# ## In practice
#
# Libraries take the smallest size as a setting of the clustering itself:
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
# - The minimum should fall with the distance. $m(r) = m_{10} \cdot (10\,\mathrm{m} / r)^2$ asks for the same *area* everywhere. A cluster of three or four points says next to nothing.
# - Where the cloud was thinned with a voxel grid (lesson 06), a point stands for a piece of surface: sizes hardly depend on the distance, until the cells are emptier than the grid is fine.
# - Time tells more than size. Spray is somewhere else in the next frame, a person is not. Trackers therefore keep even small clusters for a few frames and drop those that do not come back (lesson 12).
# - Real scanners report several returns for one flash of light. A drop lets part of the light pass, so where there are two returns, the first came from something thin.
#
# ## Summary
#
# - A label of 0 means "belongs to no cluster"; the other labels keep their value, so that nothing shifts.
# - Count first, then decide for all points at once. Renumbering inside a loop skips clusters.
# - Points fall with the square of the distance: a minimum size is a maximum distance.
#
# **Sources.** Minimum and maximum cluster sizes: [Point Cloud Library, Euclidean cluster extraction](https://pcl.readthedocs.io/projects/tutorials/en/latest/cluster_extraction.html). Noise as a label of its own: [Ester et al. 1996](https://cdn.aaai.org/KDD/1996/KDD96-037.pdf). Rain and fog in scans: [Heinzler et al. 2020](https://doi.org/10.1109/LRA.2020.2972865).
#
# **Next:** 10 · Clustering in real time

# %% [markdown]
# ## If you want more
#
# 1. Write `filter_clusters_by_distance(cloud, cluster_labels, points_at_10m)` with the minimum $m(r)$ from above, and add its curves to the last figure. How many of the distant people come back, and how many ghosts?
# 2. Filter by extent: drop clusters that are longer than 8 m or less than 0.3 m high. What is still wrong then?
# 3. Add a parameter `max_num_points`. Find a value on `cloud.txt` that removes more walls than cars.

# %% [markdown] tags=["footer"]
# (footer)
