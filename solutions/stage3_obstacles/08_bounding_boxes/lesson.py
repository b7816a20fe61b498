# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [box_area]
# ---

# %% [markdown]
# # 08 · Bounding boxes
#
# ![A street seen from above: every car, person, pole and wall has an orange box around its points. One car stands diagonally, its true outline is dashed, and the box leaves much of its own floor empty.](08_preview.png)
#
# A [cluster](#Words-of-the-course) is hundreds of points, or thousands. A car that has to brake has no time to ask each of them whether it is in its way. It asks a box.
#
# **After this lesson you can**
# - put a box around every obstacle, and compute its eight corners from six numbers,
# - say what such a box guarantees, and what it costs when a car stands diagonally.
#
# **You write** `get_bounding_boxes` (points). **Time:** (time). **You need** boolean masks (lesson 01) and the idea of cluster labels (lesson 05).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street, already sorted
#
# *A label says which obstacle a point belongs to; label 0 says: to none.*
#
# Lesson 05 finds clusters. So that this notebook stands alone, we borrow the truth that comes with the scan: for each [return](#Words-of-the-course) the number of the object it hit. Road, our own car and everything beyond 20 m get label 0.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_cloud, plots, predict
from utils.breaking import show_broken, tell_apart
from utils.datasets import DATA

cloud = load_cloud("cloud.txt")
truth = np.load(DATA / "cloud_truth.npz")
stands_near = (cloud[:, 2] >= -1.2) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 20)
labels = np.where(stands_near, truth["objects"], 0)
kinds = dict(zip(truth["box_identities"].tolist(), truth["box_kinds"].tolist()))
present = [label for label in np.unique(labels).tolist() if label > 0]

row = np.flatnonzero(truth["box_identities"] == 10)[0]
centre, yaw = truth["box_centres"][row], truth["box_yaws"][row]
length, width = truth["box_sizes"][row][:2]
street = ((-14, 22), (-10, 9))  # x from, to; y from, to
plots.clusters(cloud[labels > 0], labels[labels > 0], names=True, limits=street,
               title="The obstacles around us, from above")
print(f"{len(cloud):,} returns, {np.count_nonzero(labels):,} of them on {len(present)} obstacles")
print("labels:", present)
print(f"car 10: {length:.1f} m long and {width:.1f} m wide, {length * width:.1f} m² from above")

# %% [markdown]
# Look at the labels: some numbers are missing. Those objects are hidden or too far away. Gaps are normal: every filter that removes a cluster leaves one.
#
# Ahead on the left a car turns out of a drive: label 10. Put a box around its points, with sides that run along x and y.

# %%
area = predict("How many square metres will the box around car 10 cover?",
               between=(0, 30), step=0.5, unit="m²", digits=1)

# %% [markdown]
# ## The naive idea: a centre and a radius
#
# *Three numbers make a circle, but few obstacles are round.*
#
# For each cluster we take the mean of its points, and the distance to the farthest of them: x, y and a radius. Everything inside the circle is taken.

# %% tags=["folded"]
# @title One circle for each obstacle (you need not read this)
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
# People and poles look fine. But cars get circles that bulge into the next lane, and a house front is a line: its circle is as wide as the house is long. With these circles our lane looks blocked by parked cars and houses.
#
# Obstacles are long in one direction and short in another. So let us give each direction its own numbers.
#
# ## The idea: a box is six numbers
#
# *For each axis the smallest and the largest value: nothing of the cluster lies outside.*
#
# For a cluster $C$ the box is
#
# $$\begin{aligned} &[\min_{p \in C} x_p,\ \max_{p \in C} x_p] \\ \times\ &[\min_{p \in C} y_p,\ \max_{p \in C} y_p] \\ \times\ &[\min_{p \in C} z_p,\ \max_{p \in C} z_p]. \end{aligned}$$
#
# This is a box along the axes, *axis-aligned* in the language of programmers: its sides run along x, y and z, whatever the obstacle does. It is a **keep-out volume**: where a box is, the car may not be. That promise holds only if every point of the cluster is inside.
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
# ## Eight corners in an agreed order
#
# *A corner chooses, three times, between the smaller and the larger value: eight corners.*
#
# Programs that draw boxes want corners, and they join them by their numbers. Ours are counted with x changing fastest, then y, then z:
#
# | corner | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
# |---|---|---|---|---|---|---|---|---|
# | x | min | **max** | min | **max** | min | **max** | min | **max** |
# | y | min | min | **max** | **max** | min | min | **max** | **max** |
# | z | min | min | min | min | **max** | **max** | **max** | **max** |
#
# So 0 to 3 are the floor and 4 to 7 the roof, each straight above the one four numbers below. You may fill in this table with three nested loops, x in the innermost. Or you may read the choice off the number: each is a sum of 1, 2 and 4, and corner $k$ takes the larger x if its sum contains the 1, the larger y if it contains the 2, the larger z if it contains the 4.
#
# Python asks for that with `&`. Between masks, `&` combines True with True. Between whole numbers it does the same with their binary digits: `5 & 4` is 4, since 5 = 4 + 1 contains the 4, and `5 & 2` is 0, since it does not contain the 2. In an `if`, 0 counts as False and every other number as True. Here with two digits, for a ticket of 2 km or 5 km, on foot or by train:

# %%
for number in range(4):
    print(f"{number} = {number:02b} in binary: & 1 is {number & 1}, & 2 is {number & 2}:",
          "5 km" if number & 1 else "2 km", "by train" if number & 2 else "on foot")

block = [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0],
         [0, 0, 1.5], [4, 0, 1.5], [0, 2, 1.5], [4, 2, 1.5]]
plots.corner_numbers(block, title="A block of 4 x 2 x 1.5 m");

# %% [markdown]
# ## Exercise · `get_bounding_boxes` (points)
#
# One box for each label above 0, in ascending order of the labels. Labels may have gaps. On an empty road there are no boxes; the answer is then an array of shape (0, 8, 3), so that the next step need not ask. The order of the corners costs no points; in another one, `check` tells you, and the edges in the pictures cross.

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
        Corners in metres, one box for each label > 0, in ascending label order. For drawing,
        corner k has the larger x if k & 1, the larger y if k & 2, the larger z if k & 4.
    """
    # 1. Which labels above 0 occur?
    # 2. For each of them: the x, y, z of its points, their smallest and their largest values.
    # 3. Build the eight corners from these six numbers.
    # 4. Return all boxes as one array, shape (0, 8, 3) where there are none.
    # roughly 9 lines
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
# `low = points.min(axis=0)` and `high = points.max(axis=0)` hold three numbers each. Corner k is `[high[0] if k & 1 else low[0], ...]`, and the same for y, which is `high[1]` or `low[1]`, with 2, and for z with 4.
# </details>
# <details><summary>Hint 3</summary>
#
# Start with `boxes = np.zeros((len(names), 8, 3))`, where `names` are the labels above 0: that has the right shape for none, too. Then two loops: `for row, name in enumerate(names)` and inside it `for k in range(8)`, filling `boxes[row, k]`.
# </details>
#
# **One box first.** Seven points around the origin: x from −2 to 3, y from −1.5 to 2.5, z from −1.2 to 0.8. The shape should be (1, 8, 3), the first corner (−2, −1.5, −1.2), the last one (3, 2.5, 0.8), and the numbers in the picture those of the block above.

# %%
seven = np.array([[0.5, 0.2, -0.1], [-2.0, 0.4, 0.3], [3.0, -0.3, 0.2], [0.1, -1.5, -0.4],
                  [-0.6, 2.5, 0.1], [1.0, 0.7, -1.2], [-0.2, -0.5, 0.8]])
one = get_bounding_boxes(seven, np.ones(7, dtype=int))
print("shape:", one.shape)
print(one[0])
plots.corner_numbers(one[0], title="The box of seven points");

# %% [markdown]
# **Look before you check.** Every obstacle should sit in its box, and no box should reach back to the sensor. The names are the labels: 10 is the turning car.

# %%
boxes = get_bounding_boxes(cloud, labels)
print("shape:", boxes.shape)
beside = (9, 16)  # their names would lie on another box: they are written on the right
axes = plots.boxes(boxes, cloud=cloud[labels > 0], limits=street,
                   names=["" if label in beside else label for label in present],
                   title="Your boxes, from above")
for label in beside:
    x, y = boxes[present.index(label), :, :2].T
    axes.text(x.max() + 0.3, y.mean(), label, fontweight="bold", va="center")
turning = boxes[present.index(10)]
area.compare(np.prod(np.ptp(turning[:, :2], axis=0)),
             "A box that cannot turn must grow when the car stands diagonally. It would be larger "
             "still, but the scanner saw only the sides of the car that face it.")

# %% nbgrader={"grade": true, "grade_id": "test_get_bounding_boxes", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(get_bounding_boxes)

# %% [markdown]
# The same boxes in space. Drag to turn the street, scroll to come nearer.

# %%
from utils.scene3d import Scene

(Scene("Your boxes in space").add_clusters(cloud[labels > 0], labels[labels > 0], names=False)
 .add_boxes(boxes).add_ego_car().show(interactive=True))

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

by_point, by_box = 6 * np.count_nonzero(labels), 6 * len(boxes)
print("comparisons, if the planner asks once:", f"{by_point:,} with points,",
      f"{by_point:,} to build the boxes + {by_box:,} with boxes")
print("comparisons, if it asks 100 times:    ", f"{100 * by_point:,} with points,",
      f"{by_point:,} to build the boxes + {100 * by_box:,} with boxes")

corridor = np.array([corridor_low, corridor_high])
axes = plots.boxes(boxes, cloud=cloud[labels > 0], limits=((-2, 20), (-6, 6)),
                   title="Our corridor (dashed) and who stands in it")
plots.boxes(get_bounding_boxes(corridor, np.array([1, 1])), reference=True, label="corridor",
            names=["corridor"], axes=axes);

# %% [markdown]
# Boxes are not free: minimum and maximum look once at each coordinate of each return, which is as much work as asking all points once. It is done once a scan. A planner that compares a hundred paths asks a hundred times.
#
# Notice how the corridor was drawn: your function made its eight corners from just two points.
#
# ## Play: turn a car
#
# *A box that cannot turn must grow.*
#
# Here is the turning car of label 10, put straight and then turned by as much as you like. Its box follows.

# %%
largest = predict("At which heading is the box around the whole car largest?",
                  between=(0, 90), step=5, unit="°")

# %% tags=["folded"]
# @title A car to turn (you need not read this)
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
# The same without a slider. Dashed: the true outline of the car. Grey: what the scanner saw of it. (Turned points are no new scan: of a car that really stood like that, the scanner would see other parts.)

# %%
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
for degrees, axes in zip((5, 40), panels):
    draw_turned(degrees, axes)
    axes.get_legend().remove()

# %% [markdown]
# ## Theory against practice: the empty corners
#
# *More than half of a diagonal car's box is air.*
#
# A rectangle of length $l$ and width $w$, turned by $\theta$, reaches $l\cos\theta + w\sin\theta$ along x and $l\sin\theta + w\cos\theta$ along y. So its box covers
#
# $$A(\theta) = (l\cos\theta + w\sin\theta)\,(l\sin\theta + w\cos\theta).$$
#
# Your function measures the same for the outline of the car and for the points that the scanner really saw.

# %% tags=["folded"]
# @title Theory and your boxes (you need not read this)
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
seen = measured["boxes of the scanned points"][1]
print(f"the smallest box of the scanned points covers {min(seen):.1f} m², at "
      f"{degrees[np.argmin(seen)]}°; the car itself {length * width:.1f} m²")
largest.compare(degrees[theory.argmax()],
                "Multiplied out, the area is l w + (l² + w²) sin(2θ) / 2, and the sine is largest "
                "where 2θ is 90°. There the box is a square.")

# %% [markdown]
# The boxes of the scanned points lie below the theory, because a scanner sees only the sides that face it: your box holds what was *seen*. The far corner of a car can stick out of it. Real systems add a margin, or fit a box of car size to the two visible sides.
#
# So a box along the axes errs in both ways. It closes a free piece of street where there is air in it. And it ends too early where the scanner saw nothing. How much of each footprint lies outside its box, and how many vehicles of this street stand askew?

# %% tags=["folded"]
# @title What sticks out of your boxes (you need not read this)
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
# On a straight street nearly everything is parallel to us, and boxes along the axes hold little air. One diagonal car stands out; at a junction there would be many. Lesson 11 turns the box with the car. What was not seen stays outside of that box, too.

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
# The first one is hard to notice, because it is right for most clusters. Let it box all obstacles of this scan, each along three axes.

# %%
too_small = predict(f"How many of the {3 * len(present)} maxima does elif get wrong?",
                    between=(0, 3 * len(present)))

# %% tags=["folded"]
# @title Minimum and maximum with elif (you need not read this)
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
              title=f"elif: {len(wrong_by)} of {3 * len(present)} maxima are wrong")
too_small.compare(len(wrong_by),
                  "Mostly heights: a scan lists its rows from the top beam down, so the first "
                  "point of a cluster is often its highest. As a new minimum it takes the first "
                  "branch, and elif never shows it to the second.")

# %% [markdown]
# Two more, drawn with your own function on doctored data: the origin slipped into every cluster, and noise taken for an obstacle.

# %% tags=["folded"]
# @title Two more mistakes (you need not read this)
from_zero = np.vstack([cloud, np.zeros((len(present), 4))])
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.6), layout="compressed")
plots.boxes(get_bounding_boxes(from_zero, np.concatenate([labels, present])), limits=street,
            cloud=cloud[labels > 0], axes=left, title="low = high = 0 to start with")
plots.boxes(get_bounding_boxes(cloud, labels + 1), limits=((-82, 82), (-82, 30)),
            cloud=cloud[::4], axes=right, title="label 0 boxed, too");

# %% [markdown]
# ## Let it drive
#
# *A box that is too wide blocks a lane that is free.*
#
# Without points; skip it if you like. A car drives ten seconds through a quiet street on your `get_bounding_boxes`; the rest is given. Whoever mounted its scanner left it turned by 12°, so that x is not quite where the car is heading. Boxes along the scanner's axes stand askew in the street then, and their corners reach out.

# %%
from utils.drive import askew, chain, drive_street, on_time
from utils.lent import is_written, own


def drive_with(degrees):
    """Ten seconds of a quiet street behind a scanner that sits turned."""
    return drive_street(1, askew(chain(boxes=own(get_bounding_boxes)), degrees), seconds=10,
                        clock=on_time)


drive_with(12) if is_written(get_bounding_boxes) else print(
    "get_bounding_boxes is not written, or has not passed its check.")

# %% [markdown]
# Try `drive_with(0)`. From how many degrees on does a parked car block the lane? Lesson 11 turns the boxes instead.
#
# <details><summary>An answer</summary>
#
# Up to 4° nothing does. From 5° on the long box of a lorry does, from 8° on that of a parked car; and from 9° on the car stands still before the first one, after 13 m at most.
# </details>

# %% [markdown]
# ## In practice
#
# - Boxes along the axes are the usual first test for collisions. Game engines and planners look closer only where two of them overlap.
# - Data sets describe a box by centre, size and heading instead of eight corners: KITTI by seven numbers, with the centre of the *floor* in the camera's coordinates; nuScenes by ten, with the heading as a quaternion. Corners are for drawing, the short form is for computing.
# - A single stray point inflates a box. Systems with noisy sensors take the 1st and 99th percentile instead of minimum and maximum, and give up the promise that nothing lies outside.
#
# The same with Open3D, for one cluster. Its corners come in another order: number 3 stands above 0, and 4 is the opposite corner, so look before you draw. PCL's `getMinMax3D` gives the two corners alone.
#
# ```python
# box = open3d.geometry.AxisAlignedBoundingBox.create_from_points(point_cloud.points)
# low, high = box.min_bound, box.max_bound
# corners = np.asarray(box.get_box_points())
# ```
#
# ## Summary
#
# - A box is a minimum and a maximum for each axis; its corners are the eight ways to combine them.
# - It is a keep-out volume: every point of the cluster is inside, and so is some air.
# - Label 0 is not an obstacle, labels have gaps, and no obstacles still make an array.
# - Obstacles along the axes leave little air in it, diagonal ones more than half. What was not seen may stick out.
#
# **Sources.** Boxes as collision volumes: [Ericson, Real-Time Collision Detection, chapter 4](https://realtimecollisiondetection.net/). Boxes in a benchmark: [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). NumPy reductions: [numpy.min](https://numpy.org/doc/stable/reference/generated/numpy.min.html).
#
# **Next:** 09 · Filter clusters

# %% [markdown]
# ## If you want more
#
# 1. Get rid of the loop: sort the points by label and use `np.minimum.reduceat`. How much faster is it with a thousand clusters?
# 2. Give every box a margin of 0.2 m and count which of them now overlap. What does that say about the free gaps in this street?
# 3. Replace minimum and maximum by percentiles. How many points of the street leave their boxes?

# %% [markdown]
# ### Breaking it on purpose
#
# *Whoever tests looks for the smallest input on which right and wrong part.*
#
# Three colleagues have sent in their `get_bounding_boxes`, without the code. Here are their boxes from above: dots have label 1, squares 3, and crosses 0. What is wrong with A, B and C?

# %%
show_broken(get_bounding_boxes)

# %% [markdown]
# Write a cloud for each on which it answers otherwise than yours, in as few rows as you can; best is one that accuses nobody else. This is not graded. As soon as a cloud tells a version, you read what it does.

# %%
# For each of A, B and C its rows, a point and its label [x, y, z, label] each: A=[[...], [...]].
tell_apart(get_bounding_boxes, A=None, B=None, C=None)

# %% [markdown] tags=["footer"]
# (footer)
