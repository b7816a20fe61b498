# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [sklearn.cluster, scipy.cluster, scipy.sparse.csgraph, hdbscan, dbscan, open3d, pcl]
#     packages: [scikit-learn]
# ---

# %% [markdown]
# # 05 · Euclidean clustering
#
# ![A street from above, twice. On the left all points look alike. On the right each car, person, pole and wall has a colour and a marker of its own.](pictures/05_preview.png)
#
# A scan is a list of points and says nothing about things. A driver sees a van, two people, a wall. This lesson makes things out of points, with one rule that fits into a sentence: whoever stands close to a member belongs to the cluster.
#
# **After this lesson you can**
# - turn a cloud into numbered obstacles with a queue and a distance,
# - say what the threshold does, and why no threshold is right everywhere,
# - predict from a measurement how long an algorithm will take on a full scan.
#
# **You write** `euclidean_clustering` (40 points). **Time:** about 45 minutes. **You need** NumPy masks (lesson 01). Lesson 04 helps, but nothing here depends on its code.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street without a road
#
# *Clustering starts where the road ends: everything that touches the road would be one cluster.*
#
# We take one turn of a 64-beam scanner, keep the surroundings of the car, and drop what lies more than 1.2 m below the sensor: the road, and with it the lowest half metre of everything (lesson 06 says why 1.2). Returns closer than 2 m come from our own car, so they go too.

# %%
from collections import deque
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots

# One row per return: x forward, y left, z up in metres from the sensor, and intensity.
cloud = load_cloud("cloud.txt")
x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
standing = (z > -1.2) & (x > -8) & (x < 22) & (np.abs(y) < 9) & (np.hypot(x, y) > 2)
near = cloud[standing]
print(f"{len(cloud):,} returns in the scan, {len(near):,} of them stand on the road nearby")

# %% [markdown]
# The lesson's algorithm is slow, and we shall measure how slow. To play with it, we keep one point per cube of 20 cm: same street, fewer points.

# %%
cubes = np.floor(near[:, :3] / 0.2)
kept = np.sort(np.unique(cubes, axis=0, return_index=True)[1])
obstacles = near[kept]
street = ((-8, 22), (-9, 9))  # x from, to; y from, to
plots.from_above(obstacles, limits=street, title=f"{len(obstacles):,} points from above");

# %% [markdown]
# **Predict first.** How many obstacles do you count? Where two things stand close together, what made you say "two", or "one"? Write down a rule that a computer could follow.

# %% [markdown]
# ## The naive idea: all points around a first one
#
# *A ball has one size. Obstacles do not.*
#
# Take a point that has no number yet. Everything within a radius of it gets its number. Repeat until all points are numbered. Which radius? Let us try half a metre and three metres.

# %%
def balls(points, radius):
    """Number the points by balls of one radius, each around the first point still free."""
    number = np.zeros(len(points), dtype=int)
    while 0 in number:
        centre = points[np.argmin(number), :3]  # argmin: the first point that still has a 0
        in_ball = np.linalg.norm(points[:, :3] - centre, axis=1) < radius
        number[in_ball & (number == 0)] = number.max() + 1
    return number


figure, rows = plt.subplots(2, 1, figsize=(8.5, 9.5), layout="compressed")
for radius, axes in zip((0.5, 3.0), rows):
    plots.clusters(obstacles, balls(obstacles, radius), limits=street, axes=axes,
                   title=f"Balls of {radius} m")

# %% [markdown]
# Small balls tear a wall into confetti; big ones swallow a pedestrian together with half a car, and the wall is still in pieces. No radius is right, because the question is wrong. What holds a wall together is not that its ends are close. Each piece of it is close to the *next* piece.
#
# ## The idea: friends of friends
#
# *Two points are friends when they are close. A cluster is everybody you can reach from friend to friend.*
#
# Here are seven points, and a line for each pair less than a metre apart.

# %%
seven = np.array([[0.0, 0.0], [3.0, 0.2], [0.8, 0.3], [3.6, -0.3], [0.6, -0.6], [1.5, -0.2],
                  [2.6, -1.4]])
distances = np.linalg.norm(seven[:, None] - seven[None], axis=2)  # 7 x 7: everyone to everyone
pairs = np.argwhere(np.triu(distances < 1.0, k=1))
figure, axes = plt.subplots(figsize=(8.5, 4), layout="compressed")
plots.graph(seven, pairs, names=True, axes=axes, title="Who is whose friend?");

# %% [markdown]
# Points 0 and 5 are more than a metre apart and no friends, but 2 (and 4) stands between them: one cluster. Point 6 has no friend and is a cluster of its own. Nobody told us that there are three clusters; we read it off.
#
# As a formula: with points $p_1, \dots, p_n$ and a threshold $d$, draw the graph with an edge between $i$ and $j$ wherever
#
# $$\lVert p_i - p_j \rVert = \sqrt{(x_i - x_j)^2 + (y_i - y_j)^2 + (z_i - z_j)^2} \;<\; d .$$
#
# The clusters are the *connected components* of this graph: its separate pieces. The definition mentions no first point, no number of clusters and no shape, so the result depends on $d$ alone.
#
# On a real car we let a cluster grow in rounds: start at one point, and in each round everybody joins who stands within half a metre of a member. Triangles join in this round, squares have joined before.

# %%
ahead, left = obstacles[:, 0], obstacles[:, 1]
car = obstacles[(ahead > 4.7) & (ahead < 10) & (left > -5) & (left < 0.5), :3]
member = np.arange(len(car)) == np.argmin(car @ [1, 1, 0])  # start at the lower left corner
frames = []
for _ in range(14):
    gap = np.linalg.norm(car[:, None] - car[member], axis=2).min(axis=1)  # to the nearest member
    frames.append(np.where(member, 2, gap < 0.5))
    member = gap < 0.5
shown = (0, 1, 2, 4, 6, 8, 10, 12)
plots.growth(car, [frames[step] for step in shown], titles=[f"round {step}" for step in shown],
             title="A car joins, half a metre at a time");

# %% [markdown]
# The cluster walks along the rear and the flank and ends where the car ends: nobody bridges the gap to the pedestrian, who stays grey for ever. But look at the price. In every round, *all* points were compared with *all* members, those deep inside included, which were processed long ago.
#
# ## The queue: ask everybody exactly once
#
# *A point has news only once, right after it joined. So let new members wait in a queue, and ask each one a single time.*
#
# The seven points again, from point 0, with threshold 1 m:
#
# | taken from the queue | its friends | of these new, so labelled 1 | queue afterwards |
# |---|---|---|---|
# | (start) | | 0 | 0 |
# | 0 | 2, 4 | 2, 4 | 2, 4 |
# | 2 | 0, 4, 5 | 5 | 4, 5 |
# | 4 | 0, 2, 5 | none | 5 |
# | 5 | 2, 4 | none | empty: cluster 1 is complete |
#
# Then the next point without a label, 1, starts cluster 2, and so on. The labels are `[1, 2, 1, 2, 1, 1, 3]`.
#
# Look at point 5. It is a friend of 2 *and* of 4, yet it waits in the queue only once. That works because a point gets its label **when it enters the queue, not when it leaves**. Label it on leaving, and 4 would find it still unlabelled and queue it again; on a real car, with dozens of friends for each point, the queue grows many times longer than the cloud.
#
# Python has a queue ready, and NumPy finds the new friends:

# %%
queue = deque([7])      # a queue with one entry
queue.extend([3, 9])    # two more join at the back
print("first in line:", queue.popleft(), "  still waiting:", list(queue))

gaps = np.array([0.0, 0.3, 0.9, 0.2])
taken = np.array([4, 0, 0, 0])
print("close and free:", np.flatnonzero((gaps < 0.5) & (taken == 0)))

# %% [markdown]
# ## Exercise · `euclidean_clustering` (40 points)
#
# Give each point the number of its cluster: 1 for the cluster of the first point, 2 for the next new one, and so on.
#
# - **Friends stand strictly closer than `threshold`**, in x, y and z. Intensity is not a place.
# - **Find them by comparing with all points at once**, in one line of NumPy. The KD-tree of lesson 04 and other short cuts have their turn in lesson 10.
# - **No recursion.** A function that calls itself for every friend hits Python's limit of about a thousand nested calls; a wall in a full scan has many thousands of points.
# - **Allowed:** NumPy, `deque`, and look-ups of neighbours such as `scipy.spatial`. **Not allowed:** libraries that do the clustering, such as `sklearn.cluster`, `scipy.cluster` and the `connected_components` of `scipy.sparse.csgraph`.

# %% nbgrader={"grade": false, "grade_id": "euclidean_clustering", "locked": false, "schema_version": 3, "solution": true, "task": false}
def euclidean_clustering(cloud, threshold=0.5):
    """Group the points of a cloud into clusters: friends of friends.

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
    # 1. All labels are 0, which means "none yet". The counter of clusters is 0 too.
    # 2. Go through the points. One that has a label already needs nothing more.
    # 3. Otherwise a new cluster begins: count it, label the point, put it into a new queue.
    # 4. As long as someone waits: take the first, and find all points closer than
    #    the threshold that have no label.
    # 5. Label these at once, and let them join the queue.
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
# Two loops, one inside the other. The outer one goes through all points and starts clusters. The inner one runs as long as the queue is not empty and makes *one* cluster complete. An empty `deque` counts as `False`, so `while` can ask the queue itself.
# </details>
# <details><summary>Hint 2</summary>
#
# `cloud[:, :3] - cloud[i, :3]` is the way from point `i` to every point, shape (n, 3). Its length, row by row, is what `balls` computed above with `axis=1`. "Close" and "free" are two masks: join them with `&`, each in parentheses, and let `np.flatnonzero` turn the result into row numbers.
# </details>
# <details><summary>Hint 3</summary>
#
# The body of the inner loop has four lines. `i = queue.popleft()`. Then the distances from point `i` to all points. Then `new = np.flatnonzero(...)` with both conditions. Then write the number of the cluster to `labels[new]` and extend the queue by `new`. The two lines *before* the inner loop do the same for the starting point.
# </details>

# %% [markdown]
# **Look before you check.** Each thing should have one colour and one marker (markers repeat after 42 clusters). Neither confetti nor one colour for everything.

# %%
start_time = perf_counter()
labels = euclidean_clustering(obstacles)
print(f"{labels.max()} clusters in {perf_counter() - start_time:.2f} s")
plots.clusters(obstacles, labels, names=True, limits=street,
               title="Your clusters, threshold 0.5 m");

# %% nbgrader={"grade": true, "grade_id": "test_euclidean_clustering", "locked": true, "points": 40, "schema_version": 3, "solution": false, "task": false}
check(euclidean_clustering)

# %% [markdown]
# Compare with the number you wrote down. And what *are* these clusters? The scan was simulated, so for every return we know the thing it hit. Here are the twelve largest.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
objects = truth["objects"][standing][kept]  # the number of the thing behind each point
kinds = truth["class_names"][truth["classes"][standing][kept]]  # and what kind of thing it is

sizes = np.bincount(labels)
for label in np.argsort(-sizes, kind="stable")[:12]:
    mine = labels == label
    length, width, height = np.ptp(obstacles[mine, :3], axis=0)
    things = ", ".join(f"{kind} {number}" for number, kind in
                       dict(zip(objects[mine].tolist(), kinds[mine])).items())
    print(f"cluster {label:2d}: {sizes[label]:4d} points, "
          f"{length:4.1f} x {width:3.1f} x {height:3.1f} m   {things}")
print(f"{labels.max()} clusters of {len(np.unique(objects[objects > 0]))} things; "
      f"{np.sum(sizes[1:] < 10)} clusters have fewer than ten points")

# %% [markdown]
# Cars, people and walls, found without knowing what a car is. But some clusters hold more than one thing, and there are crumbs. The next section explains the first; lesson 09 sweeps up the second.
#
# ## Chains link: a blessing and a curse
#
# *The rule that holds a wall together also holds together what merely stands close.*
#
# **Predict first.** What is the longest cluster, in metres and in multiples of the threshold?

# %%
lengths = [np.ptp(obstacles[labels == label, :2], axis=0).max()
           for label in range(1, labels.max() + 1)]
longest = 1 + int(np.argmax(lengths))
print(f"cluster {longest} is {max(lengths):.1f} m long: "
      f"a chain of at least {int(max(lengths) / 0.5) + 1} friendships joins its ends")
plots.kept_and_removed(obstacles, labels == longest, limits=street,
                       title="The longest chain (kept), and all the rest");

# %% [markdown]
# That is the blessing: no shape and no size had to be foreseen. And the curse, in the list above: a cluster may hold several things that touch. A single stray point in a gap is a bridge, and two people who walk side by side leave less than half a metre between them.
#
# ## Play: how close is close?
#
# *Too small and things fall apart; too large and they run together.*
#
# Move the slider, and watch the two pedestrians at the lower left and the cyclist beside the slanted car.

# %%
in_yard = (ahead > 1.3) & (ahead < 11) & (left > -7) & (left < 6.2)
yard, window = obstacles[in_yard], ((1, 11), (-7, 6.5))


@interact(threshold=FloatSlider(value=0.5, min=0.1, max=2.5, step=0.1,
                                description="threshold", continuous_update=False))
def show_threshold(threshold):
    found = euclidean_clustering(yard, threshold)
    plots.clusters(yard, found, limits=window, title=f"threshold {threshold:.1f} m")
    plt.show()

# %%
# The same without a slider: the truth and three thresholds.
panels = {"what is there": np.unique(objects[in_yard], return_inverse=True)[1] + 1}
panels |= {f"threshold {d} m": euclidean_clustering(yard, d) for d in (0.25, 0.5, 1.5)}
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9.8), layout="compressed")
for (title, numbers), axes in zip(panels.items(), grid.flat):
    plots.clusters(yard, numbers, limits=window, axes=axes, title=title)

# %% [markdown]
# At 1.5 m cyclist and car ride as one. At 0.25 m the slanted car falls to pieces, and still the two pedestrians are a single wide person. Let us count these two errors for all cars, lorries, pedestrians and cyclists of the street: how many lie in more than one piece, and how many share a cluster with something else?

# %%
users = np.unique(objects[np.isin(kinds, ["car", "truck", "pedestrian", "cyclist"])])
thresholds = np.array([0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.25, 1.5, 2.0])
torn, joined = [], []
for threshold in thresholds:
    found = euclidean_clustering(obstacles, threshold)
    clusters_of = [np.unique(found[objects == user]) for user in users]
    torn.append(np.mean([len(pieces) > 1 for pieces in clusters_of]))
    joined.append(np.mean([(objects[np.isin(found, pieces)] != user).any()
                           for user, pieces in zip(users, clusters_of)]))
axes = plots.curves({"torn to pieces": (thresholds, torn),
                     "joined with others": (thresholds, joined)},
                    across="threshold (m)", up=f"share of {len(users)} road users",
                    title="The two errors of a threshold")
axes.axvline(0.5, color="black", linestyle=":")
axes.text(0.52, 0.9, "the default, 0.5 m");

# %% [markdown]
# Nowhere are both curves zero. Two people stand closer to each other than neighbouring points on a surface that the beams only graze, so *no* threshold is right for both. But the errors are not equally bad. A torn car counts here even if it lost a single stray point, and lesson 09 removes such crumbs; joined things stay joined. That is why one stays to the left of where the curves cross: 0.5 m is a usual choice.
#
# ## Theory against practice: what does it cost?
#
# *Everybody is asked once, and everybody is compared with everybody: n times n.*
#
# **Predict first.** With twice as many points, how much longer will it take? And the whole scan?

# %%
rng = np.random.default_rng(1)
counts, seconds = [], []
for n in (250, 500, 1000, 2000, 4000, 8000):
    sample = near[rng.choice(len(near), n, replace=False)]
    start_time = perf_counter()
    euclidean_clustering(sample)
    counts.append(n)
    seconds.append(perf_counter() - start_time)
    if seconds[-1] > 5:  # a slow machine need not wait for the last point
        break

reach = np.array([counts[-1] / 4, len(cloud)])
foreseen = seconds[-1] * (reach / counts[-1]) ** 2
axes = plots.timing({"yours": (counts, seconds), "foreseen": (reach, foreseen)},
                    title="Time of euclidean_clustering, and what n² foresees for the full scan")
axes.axhline(0.1, color="black", linestyle=":")
axes.text(len(cloud), 0.12, "one turn of the scanner: 0.1 s", ha="right")
print(f"{counts[-1]:,} points took {seconds[-1]:.2f} s; the last doubling made it "
      f"{seconds[-1] / seconds[-2]:.1f} times slower")
print(f"{len(cloud):,} points would take about {foreseen[-1]:.0f} s: "
      f"{foreseen[-1] / 0.1:,.0f} turns of the scanner")

# %% [markdown]
# On logarithmic axes a power $n^k$ is a straight line of slope $k$. For small clouds the line is flatter than theory says: calling NumPy costs some microseconds, no matter how short the array. For large ones each doubling costs about four times as much, $k = 2$, and we may extrapolate. A full turn has about $120\,000$ points; $120\,000^2$ is $14\,400\,000\,000$ distances. The scanner delivers a new turn every 0.1 s.
#
# Faster hardware does not help against an exponent. Fewer comparisons do: a point ten metres away need not be measured to know that it is no friend. The KD-tree of lesson 04 leaves it out, and lesson 10 brings the full scan below a turn.

# %% [markdown]
# ## Common mistakes
#
# *Most show from above; one shows only on the clock.*
#
# | what was written | what you see |
# |---|---|
# | compared with the first point of the cluster only | confetti: balls instead of chains |
# | distance compared with `threshold ** 2` | 0.5 acts as 0.25: things fall to pieces |
# | squared distance compared with `threshold` | 0.5 acts as 0.71: here it mends a car by luck, elsewhere it joins two |
# | labels counted from 0 | the first obstacle, drawn as pale crosses, passes for noise |
# | counter raised for every point | as many clusters as points |
# | distance over all four columns | nothing here, where intensities end at 1; confetti on recordings where they end at 255 |
# | labelled when taken out of the queue | the same picture, much later or practically never: points queue over and over |
# | the function calls itself for each friend | no picture but a `RecursionError`, at the first wall |

# %%
wrong = {"first point only": balls(yard, 0.5),
         "distance < threshold ** 2": euclidean_clustering(yard, 0.5 ** 2),
         "distance ** 2 < threshold": euclidean_clustering(yard, 0.5 ** 0.5),
         "labels from 0": euclidean_clustering(yard) - 1}
figure, grid = plt.subplots(2, 2, figsize=(8.5, 9.8), layout="compressed")
for (title, numbers), axes in zip(wrong.items(), grid.flat):
    plots.clusters(yard, numbers, limits=window, axes=axes, title=title)

# %% [markdown]
# ## In practice
#
# - This algorithm, with a KD-tree for the friends, is `EuclideanClusterExtraction` in the Point Cloud Library, which also drops clusters below and above a given size.
# - Beams spread. Ours are a third of a degree apart around the horizon: 17 cm at 30 m, half a metre at 90 m. Out there a fixed threshold cuts every car into slices, so real systems let it grow with distance, or compare neighbours in the image of beams and azimuths by the *angle* of the step between them.
# - Detectors trained on labelled scans find pedestrians beside cars better. Clustering stays beside them as a safety net: it also finds the sofa that fell off a lorry, which no training set had.
#
# ## If you want more
#
# 1. Let the threshold grow with the distance from the sensor, `0.3 + 0.01 * r`. Does either of the two errors shrink?
# 2. Let only points with at least five friends pass on their label. That is DBSCAN. Does it part the two pedestrians? What becomes of the points that nobody reaches?
# 3. Find the friends with your `KdTree` from lesson 04 (its tolerance is `<=`, ours `<`). At how many points does it overtake NumPy?
# 4. Count how often each point would enter the queue if it were labelled on leaving.
#
# ## Summary
#
# - A cluster is a connected component: everybody reachable from friend to friend, no first point, no shape, no number given.
# - The queue asks each point once, provided that it is labelled on entering.
# - The threshold weighs torn against joined things; none is right everywhere.
# - Comparing all with all costs n²: fine for thousands of points, hopeless for a scan.
#
# **Sources.** Euclidean clustering of point clouds: [Rusu 2009](http://mediatum.ub.tum.de/doc/800632/941254.pdf), section 6.2, and the [PCL tutorial](https://pcl.readthedocs.io/projects/tutorials/en/latest/cluster_extraction.html). The same clusters under other names: DBSCAN with `min_samples=1`, [Ester et al. 1996](https://www.aaai.org/Papers/KDD/1996/KDD96-037.pdf); single linkage cut at the threshold, [Gower and Ross 1969](https://doi.org/10.2307/2346439); friends of friends among galaxies, [Huchra and Geller 1982](https://ui.adsabs.harvard.edu/abs/1982ApJ...257..423H). By angles in the range image: [Bogoslavskyi and Stachniss 2016](https://doi.org/10.1109/IROS.2016.7759050).
#
# **Next:** 06 · Filter the ground

# %% [markdown] tags=["footer"]
# (footer)
