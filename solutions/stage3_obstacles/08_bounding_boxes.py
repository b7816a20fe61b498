# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 08 · Bounding boxes
#
# ![A street seen from above: every car, person, pole and wall has an orange box around its points. One car stands diagonally, its true outline is dashed, and the box leaves much of its own floor empty.](pictures/08_preview.png)
#
# A cluster is a thousand points. A car that has to brake cannot ask a thousand points whether they are in its way. It asks a box.
#
# **After this lesson you can**
# - put a box around every obstacle with two NumPy calls and number its corners so that any program can draw it,
# - say what such a box promises, and what it costs when a car stands diagonally.
#
# **You write** `get_bounding_boxes` (20 points). **Time:** about 45 minutes. **You need** boolean masks (lesson 01) and the idea of cluster labels (lesson 05).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street, already sorted
#
# *A label says which obstacle a point belongs to; label 0 says: to none.*
#
# Lesson 05 finds clusters. So that this notebook stands alone, we borrow the truth that comes with the scan: for each return the number of the object it hit. Road, our own car and everything beyond 20 m get label 0.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_cloud, plots
from utils.datasets import DATA

cloud = load_cloud("cloud.txt")
truth = np.load(DATA / "cloud_truth.npz")
stands_near = (cloud[:, 2] >= -1.2) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 20)
labels = np.where(stands_near, truth["objects"], 0)
kinds = dict(zip(truth["box_identities"].tolist(), truth["box_kinds"].tolist()))
present = [label for label in np.unique(labels).tolist() if label > 0]

print(f"{len(cloud):,} returns, {np.count_nonzero(labels):,} of them on {len(present)} obstacles")
print("labels:", present)

# %% [markdown]
# Look at the labels: some numbers are missing. Those objects are hidden or too far away. Gaps are normal: every filter that removes a cluster leaves one.

# %%
street = ((-14, 22), (-10, 9))  # x from, to; y from, to
plots.clusters(cloud[labels > 0], labels[labels > 0], names=True, limits=street,
               title="The obstacles around us, from above");

# %% [markdown]
# **Predict first.** Ahead on the left a car turns out of a drive: label 10. Seen from above, a car covers about 7 m². How many square metres will a box cover whose sides run along x and y? Write a number down.

# %% [markdown]
# ## The naive idea: a centre and a radius
#
# *A circle is the shortest description of an obstacle, and it describes almost none.*
#
# Three numbers for each cluster: the mean of its points, and the distance to the farthest of them. Everything inside the circle is taken.

# %%
axes = plots.clusters(cloud[labels > 0], labels[labels > 0], limits=street,
                      title="One circle for each obstacle")
turn = np.linspace(0, 2 * np.pi, 90)
circles_in_lane, obstacles_in_lane = [], []
for label in present:
    xy = cloud[labels == label, :2]
    middle = xy.mean(axis=0)
    radius = np.linalg.norm(xy - middle, axis=1).max()
    axes.plot(middle[0] + radius * np.cos(turn), middle[1] + radius * np.sin(turn), color="black",
              linewidth=0.8)
    if abs(middle[1]) - radius < 1:
        circles_in_lane.append(label)
    if (np.abs(xy[:, 1]) < 1).any():
        obstacles_in_lane.append(label)
axes.axhspan(-1, 1, color="black", alpha=0.08)
print(f"our lane is the grey strip: {len(circles_in_lane)} circles reach into it, "
      f"but only {len(obstacles_in_lane)} obstacles do")

# %% [markdown]
# People and poles look fine. But cars get circles that bulge into the next lane, and a house front is a line: its circle is as wide as the house is long. A car that believes these circles does not drive another metre.
#
# Obstacles are long in one direction and short in another. So let us give each direction its own numbers.

# %% [markdown]
# ## The idea: a box is six numbers
#
# *For each axis the smallest and the largest value: nothing of the cluster lies outside.*
#
# For a cluster $C$ the box is
#
# $$[\min_{p \in C} x_p,\ \max_{p \in C} x_p] \times [\min_{p \in C} y_p,\ \max_{p \in C} y_p] \times [\min_{p \in C} z_p,\ \max_{p \in C} z_p].$$
#
# Such a box is called *axis-aligned*: its sides run along x, y and z, whatever the obstacle does. It is a **keep-out volume**: where a box is, the car may not be. That promise holds only if every point of the cluster is inside; one forgotten corner and it is worthless.
#
# NumPy takes minima along an axis of an array. On a table of temperatures, three cities (columns) on four days (rows):

# %%
temperatures = np.array([[18, 25, 7],
                         [21, 29, 3],
                         [16, 31, 9],
                         [19, 27, 5]])
print("coldest of each city:", temperatures.min(axis=0))
print("coldest of each day: ", temperatures.min(axis=1))

# %% [markdown]
# ## Eight corners, numbered in binary
#
# *A corner chooses, three times, between the smaller and the larger value: three bits, eight numbers.*
#
# Programs that draw boxes want corners. Corner $k$ takes the larger x if `k & 1`, the larger y if `k & 2`, the larger z if `k & 4`. The operator `&` asks whether a bit is set:
#
# | corner | binary (z y x) | x | y | z |
# |---|---|---|---|---|
# | 0 | 000 | min | min | min |
# | 1 | 001 | max | min | min |
# | 2 | 010 | min | max | min |
# | 3 | 011 | max | max | min |
# | 4 to 7 | 1.. | the same again | | max |
#
# So 0 to 3 are the floor and 4 to 7 the roof, each straight above the one four numbers below. Here is the same thing flat: a ticket of 2 km or 5 km, on foot or by train.

# %%
for number in range(4):
    print(number, "5 km" if number & 1 else "2 km", "by train" if number & 2 else "on foot")

block = [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0],
         [0, 0, 1.5], [4, 0, 1.5], [0, 2, 1.5], [4, 2, 1.5]]
plots.corner_numbers(block, title="A block of 4 x 2 x 1.5 m");

# %% [markdown]
# ## Exercise · `get_bounding_boxes` (20 points)
#
# One box for each label above 0, in ascending order of the labels. Labels may have gaps. On an empty road there are no boxes; the answer is then an array of shape (0, 8, 3), so that the next step need not ask.

# %% nbgrader={"grade": false, "grade_id": "get_bounding_boxes", "locked": false, "schema_version": 3, "solution": true, "task": false}
def get_bounding_boxes(cloud, cluster_labels):
    """Put an axis-aligned box around each cluster.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity.
    cluster_labels : ndarray of int, shape (n,)
        The cluster of each point; 0 for points of no cluster.

    Returns
    -------
    ndarray, shape (N, 8, 3)
        Corners in metres, one box for each label > 0, in ascending label order. Corner k has
        the larger x if k & 1, the larger y if k & 2, the larger z if k & 4.
    """
    # 1. Which labels above 0 occur?
    # 2. For each of them: the x, y, z of its points, their smallest and their largest values.
    # 3. Build the eight corners from these six numbers.
    # 4. Return all boxes as one array, shape (0, 8, 3) where there are none.
    # roughly 6 lines
    ### BEGIN SOLUTION
    measured = np.isfinite(cloud[:, :3]).all(axis=1)
    takes_larger = (np.arange(8)[:, None] & [1, 2, 4]) > 0
    boxes = []
    for label in np.unique(cluster_labels[measured & (cluster_labels > 0)]):
        points = cloud[measured & (cluster_labels == label), :3]
        boxes.append(np.where(takes_larger, points.max(axis=0), points.min(axis=0)))
    return np.array(boxes).reshape(-1, 8, 3)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `np.unique` lists the labels that occur, in ascending order. Leave out 0. For one label, `cloud[cluster_labels == label, :3]` are its points.
# </details>
# <details><summary>Hint 2</summary>
#
# `low = points.min(axis=0)` and `high = points.max(axis=0)` hold three numbers each. Corner k is `[high[0] if k & 1 else low[0], ...]`, and the same for y with 2 and for z with 4.
# </details>
# <details><summary>Hint 3</summary>
#
# Start with `boxes = np.zeros((len(names), 8, 3))`, where `names` are the labels above 0: that has the right shape for none, too. Then two loops: `for row, name in enumerate(names)` and inside it `for k in range(8)`, filling `boxes[row, k]`.
# </details>

# %% [markdown]
# **Look before you check.** Every obstacle should sit in its box, and no box should reach back to the sensor. Beside it, the corner numbers of the turning car: compare them with the block above.

# %%
boxes = get_bounding_boxes(cloud, labels)
print("shape:", boxes.shape)
plots.boxes(boxes, cloud=cloud[labels > 0], names=present, limits=street,
            title="Axis-aligned boxes, from above")
turning = present.index(10)
plots.corner_numbers(boxes[turning], title="The box of the turning car");

# %% nbgrader={"grade": true, "grade_id": "test_get_bounding_boxes", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(get_bounding_boxes)

# %% [markdown]
# ## What a box is good for
#
# *Two boxes collide exactly if they overlap on every axis: six comparisons, no points.*
#
# Let our car plan to drive straight on, in a corridor 2 m wide and 16 m long. Which obstacles stand in it? Compare low with high and high with low, for all boxes at once:

# %%
corridor_low, corridor_high = np.array([2.0, -1.0, -1.5]), np.array([18.0, 1.0, 0.3])
low, high = boxes.min(axis=1), boxes.max(axis=1)  # (N, 3) each
in_the_way = ((low < corridor_high) & (high > corridor_low)).all(axis=1)
for row in np.flatnonzero(in_the_way):
    # The bumper is 2.6 m ahead of the sensor.
    print(f"{kinds[present[row]]} {present[row]}: {low[row, 0] - 2.6:.1f} m left for the bumper")
print(f"{6 * len(boxes)} comparisons instead of {6 * np.count_nonzero(labels):,}")

corridor = np.array([corridor_low, corridor_high])
axes = plots.boxes(boxes, cloud=cloud[labels > 0], limits=((-2, 20), (-6, 6)),
                   title="Our corridor (dashed) and who stands in it")
plots.boxes(get_bounding_boxes(corridor, np.array([1, 1])), reference=True, label="corridor",
            names=["corridor"], axes=axes);

# %% [markdown]
# Notice how the corridor was drawn: your function made its eight corners from just two points.
#
# ## Play: turn a car
#
# *A box that cannot turn must grow.*
#
# Here is the turning car of label 10, put straight and then turned by as much as you like. Its box follows. At which angle is the box largest? (Turned points are no new scan: of a car that really stood like that, the scanner would see other parts.)

# %%
row = np.flatnonzero(truth["box_identities"] == 10)[0]
centre, yaw = truth["box_centres"][row], truth["box_yaws"][row]
length, width = truth["box_sizes"][row][:2]


def turned(points, angle):
    """Points turned about z by an angle in radians, anticlockwise."""
    x, y, z = points[:, :3].T
    return np.column_stack([x * np.cos(angle) - y * np.sin(angle),
                            x * np.sin(angle) + y * np.cos(angle), z])


# The middle of the car is the origin, and the sides that were seen face us.
straight = turned(cloud[labels == 10, :3] - centre, -(yaw + np.pi))
outline = np.array([[x, y, 0.0] for x in (-length / 2, length / 2)
                    for y in (-width / 2, width / 2)])
ahead = np.array([8.0, 0.0, 0.0])  # where we put it


def box_area(points):
    """Square metres that the box of one cluster covers."""
    box = get_bounding_boxes(points, np.ones(len(points), dtype=int))[0]
    return np.prod(np.ptp(box[:, :2], axis=0))


def draw_turned(degrees, axes=None):
    """The car's points and true outline, turned, and the box of the outline."""
    angle = np.radians(degrees)
    car = turned(outline, angle) + ahead
    one = np.ones(4, dtype=int)
    axes = plots.boxes(get_bounding_boxes(car, one), cloud=turned(straight, angle) + ahead,
                       limits=((5.3, 10.7), (-2.4, 2.4)), axes=axes,
                       title=f"{degrees}°: {box_area(car):.1f} m²")
    axes.plot(*car[[0, 1, 3, 2, 0], :2].T, color="black", linestyle="--", linewidth=1)


@interact(degrees=IntSlider(value=40, min=0, max=90, step=5, description="heading (°)",
                            continuous_update=False))
def show_turned(degrees):
    draw_turned(degrees)
    plt.show()

# %% [markdown]
# The same without a slider. Dashed: the true outline of the car. Grey: what the scanner saw of it.

# %%
figure, panels = plt.subplots(1, 3, figsize=(8.5, 3.4), layout="compressed")
for degrees, axes in zip((0, 20, 45), panels):
    draw_turned(degrees, axes)
    axes.get_legend().remove()

# %% [markdown]
# ## Theory against practice: the empty corners
#
# *At 45 degrees more than half of a car's box is air.*
#
# A rectangle of length $l$ and width $w$, turned by $\theta$, reaches $l\cos\theta + w\sin\theta$ along x and $l\sin\theta + w\cos\theta$ along y. So its box covers
#
# $$A(\theta) = (l\cos\theta + w\sin\theta)\,(l\sin\theta + w\cos\theta).$$
#
# Your function measures the same for the outline of the car and for the points that the scanner really saw.

# %%
degrees = np.arange(0, 91, 5)
angles = np.radians(degrees)
theory = ((length * np.cos(angles) + width * np.sin(angles))
          * (length * np.sin(angles) + width * np.cos(angles)))
measured = {"boxes of the whole outline": (degrees, [box_area(turned(outline, a)) for a in angles]),
            "boxes of the scanned points": (degrees, [box_area(turned(straight, a)) for a in angles])}
axes = plots.curves({"theory": (degrees, theory)}, measured, across="heading of the car (°)",
                    up="area of its box (m²)", title="What a diagonal car costs")
axes.axhline(length * width, color="black", linestyle=":", label=f"the car: {length * width:.1f} m²")
axes.set_ylim(0)
axes.legend(loc="lower center")
print(f"at 45° the box covers {theory[9]:.1f} m²: {1 - length * width / theory[9]:.0%} of it is empty")
print(f"label 10 in our scan: {box_area(cloud[labels == 10]):.1f} m²")

# %% [markdown]
# Was your prediction near the last line? The scanned points lie below the theory, because a scanner sees only the sides that face it: your box holds what was *seen*. The far corner of a car can stick out of it. Real systems add a margin, or fit a box of car size to the two visible sides.
#
# Too large a box closes a free piece of street. And it is not even safe: where the scanner saw nothing, the box ends too early. How much of each footprint lies outside its box, and how many vehicles of this street stand askew?

# %%
vehicles = np.isin(truth["box_kinds"], ["car", "truck", "cyclist"])
vehicles &= np.isin(truth["box_identities"], present)
off = np.degrees(truth["box_yaws"][vehicles]) % 90  # a quarter turn changes nothing
off = np.minimum(off, 90 - off)
print(f"{vehicles.sum()} vehicles, {np.count_nonzero(off < 10)} of them within 10° of our axes, "
      f"the worst {off.max():.0f}° off")

across = np.linspace(-0.5, 0.5, 50)
spots = np.array([(x, y, 0.0) for x in across for y in across])  # all over a footprint
for name in (10, 4, 13):
    row = np.flatnonzero(truth["box_identities"] == name)[0]
    footprint = turned(spots * truth["box_sizes"][row], truth["box_yaws"][row])
    footprint = (footprint + truth["box_centres"][row])[:, :2]
    box = boxes[present.index(name), :, :2]
    outside = ((footprint < box.min(axis=0)) | (footprint > box.max(axis=0))).any(axis=1)
    print(f"{kinds[name]} {name}: {outside.mean():.0%} of its footprint is outside its box")

# %% [markdown]
# On a straight street nearly everything is parallel to us and axis-aligned boxes are a good bargain. One diagonal car stands out; at a junction it would be every second one. Lesson 11 turns the box with the car.

# %% [markdown]
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | `if x < low: ... elif x > high: ...` | boxes a little too small, or infinite: a point that is a new minimum is never tried as a maximum |
# | `low = high = 0` to start with | every box reaches to the sensor |
# | label 0 boxed like the others | one box over the whole street, with us inside |
# | `range(1, labels.max())` | the last obstacle has no box, and gaps raise an error |
# | `.max()` without `axis=0` | cubes: one number for x, y and z |
# | `np.array(boxes)` of an empty list | shape (0,): the next step fails on an empty road |
#
# The first one is treacherous: it is right for most clusters. How many of this scan's numbers does it get wrong?

# %%
wrong_by = {}
for label in present:
    for axis in range(3):
        smallest, largest = np.inf, -np.inf
        for value in cloud[labels == label, axis]:
            if value < smallest:
                smallest = value
            elif value > largest:
                largest = value
        miss = cloud[labels == label, axis].max() - largest
        if 0 < miss < np.inf:
            wrong_by[f"{kinds[label]} {label}, {'xyz'[axis]}"] = 100 * miss
plots.compare(wrong_by, label="centimetres missing at the larger end",
              title=f"elif: {len(wrong_by)} of {3 * len(present)} maxima are wrong");

# %% [markdown]
# Mostly heights: a scan lists its rows from the top beam down, so the first point of a cluster is often its highest. As a new *minimum* it takes the first branch, and `elif` never shows it to the second.
#
# Two more, drawn with your own function on doctored data: the origin slipped into every cluster, and noise taken for an obstacle.

# %%
from_zero = np.vstack([cloud, np.zeros((len(present), 4))])
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.6), layout="compressed")
plots.boxes(get_bounding_boxes(from_zero, np.concatenate([labels, present])), limits=street,
            cloud=cloud[labels > 0], axes=left, title="low = high = 0 to start with")
plots.boxes(get_bounding_boxes(cloud, labels + 1), limits=((-80, 90), (-45, 45)),
            cloud=cloud[::4], axes=right, title="label 0 boxed, too");

# %% [markdown]
# ## In practice
#
# - Axis-aligned boxes are the workhorse of collision tests. Game engines and planners test them first and look closer only where two of them overlap.
# - Data sets describe a box by centre, size and heading instead of eight corners: KITTI by seven numbers, with the centre of the *floor* in the camera's coordinates; nuScenes by ten, with the heading as a quaternion. Corners are for drawing, the short form is for computing.
# - A single stray point inflates a box. Systems with noisy sensors take the 1st and 99th percentile instead of minimum and maximum, and give up the promise that nothing lies outside.
#
# ## If you want more
#
# 1. Get rid of the loop: sort the points by label and use `np.minimum.reduceat`. How much faster is it with a thousand clusters?
# 2. Give every box a margin of 0.2 m and count which of them now overlap. What does that say about the free gaps in this street?
# 3. Replace minimum and maximum by percentiles. How many points of the street leave their boxes?
#
# ## Summary
#
# - A box is a minimum and a maximum for each axis; its corners are the eight ways to combine them.
# - It is a keep-out volume: every point of the cluster is inside, and so is some air.
# - Label 0 is no obstacle, labels have gaps, and no obstacles still make an array.
# - The air is cheap for obstacles along the axes and dear for diagonal ones.
#
# **Sources.** Boxes as collision volumes: [Ericson, Real-Time Collision Detection, chapter 4](https://realtimecollisiondetection.net/). Boxes in a benchmark: [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). NumPy reductions: [numpy.min](https://numpy.org/doc/stable/reference/generated/numpy.min.html).
#
# **Next:** 09 · Filter clusters

# %% [markdown] tags=["footer"]
# (footer)
