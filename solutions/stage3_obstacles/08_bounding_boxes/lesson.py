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
# ![A street from above. An orange box surrounds each car, person, pole and wall. One car is at an angle to the street. Its true outline is dashed, and much of its box is empty.](08_preview.png)
#
# A [cluster](#Words-of-the-course) has hundreds or thousands of points. A car that has to brake has no time to compare all of these points with its path. It compares only a box around them.
#
# **After this lesson you can**
# - put a box around every obstacle, and compute its eight corners from six numbers,
# - explain what such a box guarantees, and what it costs when a car is at an angle.
#
# **You write** `get_bounding_boxes` (points). **Time:** (time). **You need** boolean masks (lesson 01) and the idea of cluster labels (lesson 05).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street with labels
#
# *A label says which obstacle a point belongs to. Label 0 means no obstacle.*
#
# Here the labels come from the simulator, which knows where each [return](#Words-of-the-course) comes from. The road, the ego car and everything beyond 20 m get label 0.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_street, plots, predict, show_table
from utils.breaking import show_broken, tell_apart

cloud, truth = load_street()  # `truth` says what each return hit
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
print(f"car 10 is {length:.2f} m long and {width:.2f} m wide, and covers {length * width:.1f} m²")

# %% [markdown]
# In the picture, only the obstacles with the most points show their labels. Some numbers are missing from the printed list, because those objects are hidden or too far away. Ahead on the left, a car with label 10 is turning out of a driveway. Imagine a box around its points, with sides parallel to x and y.

# %%
area = predict("How many square metres will the box around car 10 cover?",
               between=(0, 30), step=0.5, unit="m²", digits=1)

# %% [markdown]
# ## The naive idea: a centre and a radius
#
# *Three numbers make a circle, but few obstacles are round.*
#
# Put a circle around each cluster. Its centre is the mean of the points, and it reaches to the farthest point. Everything inside the circle counts as blocked.

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
print(f"The grey strip is our lane. {len(circles_in_lane)} circles reach into it, "
      f"but only {len(obstacles_in_lane)} obstacles do.")

# %% [markdown]
# The circles fit people and poles. But the circle of a car reaches into the next lane, and the circle of a house front is as wide as the house is long. Many obstacles are long in one direction and short in another, so each direction needs its own numbers.
#
# ## The idea: a box is six numbers
#
# Take the smallest and the largest x of the points, and do the same for y and z. For a cluster $C$, the box is
#
# $$\begin{aligned} &[\min_{p \in C} x_p,\ \max_{p \in C} x_p] \\ \times\ &[\min_{p \in C} y_p,\ \max_{p \in C} y_p] \\ \times\ &[\min_{p \in C} z_p,\ \max_{p \in C} z_p]. \end{aligned}$$
#
# Such a box is called *axis-aligned*, because its sides are parallel to the axes, even if the obstacle is not. It is a **keep-out volume**, which the car must not enter. That is safe only if every point of the cluster is inside.
#
# In NumPy, `min(axis=0)` gives the minimum of each column, and `min(axis=1)` gives the minimum of each row. Here are the temperatures in three cities (columns) on four days (rows).

# %%
temperatures = np.array([[18, 25, 7],
                         [21, 29, 3],
                         [16, 31, 9],
                         [19, 27, 5]])
print("coldest in each city:", temperatures.min(axis=0))
print("coldest on each day: ", temperatures.min(axis=1))

# %% [markdown]
# ## Eight corners in an agreed order
#
# *On each axis, a corner has the smaller or the larger value, so there are 2 × 2 × 2 = 8 corners.*
#
# Programs that draw a box connect its corners by their numbers. In our order, x changes fastest, then y, and then z:
#
# | corner | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
# |---|---|---|---|---|---|---|---|---|
# | x | min | **max** | min | **max** | min | **max** | min | **max** |
# | y | min | min | **max** | **max** | min | min | **max** | **max** |
# | z | min | min | min | min | **max** | **max** | **max** | **max** |
#
# Corners 0 to 3 are the floor, and corners 4 to 7 are the roof. You can fill in this table with three nested loops, with x in the innermost loop. You can also write the number $k$ of a corner as a sum of 1, 2 and 4, such as 5 = 4 + 1. Corner $k$ has the larger x if its sum contains 1, the larger y if it contains 2, and the larger z if it contains 4.
#
# Python tests this with `&`: `a & b` has a binary 1 only where both numbers have a 1. So `5 & 4` is 4, because 5 contains the 4, and `5 & 2` is 0, because 5 does not contain the 2. An `if` treats 0 as False and every other number as True. In this example, two binary digits choose a trip of 2 km or 5 km, on foot or by train.

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
# Return one box for each label above 0, in ascending order of the labels. Labels may have gaps. If no label is above 0, return an array of shape (0, 8, 3). Rows with NaN have label 0, so they need no special case. All packages listed at the end are allowed. A different order of the corners costs no points, but `check` shows a note, and the edges in the pictures cross.

# %% nbgrader={"grade": false, "grade_id": "get_bounding_boxes", "locked": false, "schema_version": 3, "solution": true, "task": false}
def get_bounding_boxes(cloud, cluster_labels):
    """Put an axis-aligned box around each cluster.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres, then perhaps intensity.
    cluster_labels : ndarray of int, shape (n,)
        The cluster of each point, or 0 for points that belong to no cluster.

    Returns
    -------
    ndarray, shape (N, 8, 3)
        Corners in metres of one box for each label > 0, in ascending order of the labels. For
        drawing, corner k has the larger x if k & 1, the larger y if k & 2, and the larger z if
        k & 4.
    """
    # 1. Find the labels above 0 that occur.
    # 2. For each of them, take the smallest and the largest x, y and z of its points.
    # 3. Build the eight corners from these six numbers.
    # 4. Return all boxes as one array, with shape (0, 8, 3) if there are none.
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
# `np.unique` lists the labels that occur, in ascending order. Leave out 0. For one label, `cloud[cluster_labels == label, :3]` contains its points.
# </details>
# <details><summary>Hint 2</summary>
#
# `low = points.min(axis=0)` and `high = points.max(axis=0)` contain three numbers each. The x of corner k is `high[0] if k & 1 else low[0]`. For y, use index 1 and `k & 2`. For z, use index 2 and `k & 4`.
# </details>
# <details><summary>Hint 3</summary>
#
# Start with `boxes = np.zeros((len(found), 8, 3))`, where `found` contains the labels above 0. Then write the loop `for row, label in enumerate(found)`, and inside it the loop `for k in range(8)`, which fills `boxes[row, k]`.
# </details>
#
# **One box first.** For seven points around the origin, the result should have the shape (1, 8, 3). Its first corner should be (−2, −1.5, −1.2), and its last corner (3, 2.5, 0.8). The corners should be in the same order as in the block above.

# %%
seven = np.array([[0.5, 0.2, -0.1], [-2.0, 0.4, 0.3], [3.0, -0.3, 0.2], [0.1, -1.5, -0.4],
                  [-0.6, 2.5, 0.1], [1.0, 0.7, -1.2], [-0.2, -0.5, 0.8]])
one = get_bounding_boxes(seven, np.ones(7, dtype=int))
print("shape:", one.shape)
print(one[0])
plots.corner_numbers(one[0], title="The box of seven points");

# %% [markdown]
# **Look before you check.** Every obstacle should be inside its box, and no box should reach back to the sensor.

# %%
boxes = get_bounding_boxes(cloud, labels)
print("shape:", boxes.shape)
plots.boxes(boxes, cloud=cloud[labels > 0], limits=street, names=present,
            title="Your boxes, from above")
turning = boxes[present.index(10)]
area.compare(np.prod(np.ptp(turning[:, :2], axis=0)),
             "A box that cannot turn must be larger when the car is at an angle. This box would "
             "be even larger, but the scanner saw only the sides of the car that face it.")

# %% nbgrader={"grade": true, "grade_id": "test_get_bounding_boxes", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(get_bounding_boxes)

# %% [markdown]
# Here are the same boxes in 3-D. Drag to rotate the view, and scroll to zoom.

# %%
from utils.scene3d import Scene

(Scene("Your boxes in space").add_clusters(cloud[labels > 0], labels[labels > 0], names=False)
 .add_boxes(boxes).add_ego_car().show(interactive=True))

# %% [markdown]
# ## What a box is good for
#
# *Two boxes collide if they overlap on every axis, and only then. This test takes six comparisons.*
#
# The car is going to drive straight ahead, through a corridor 2 m wide and 16 m long. Which obstacles are in it? Two boxes overlap on an axis if the low end of each box is below the high end of the other box.
#
# The function below tests only x, so it finds every obstacle ahead of us. Change its last line so that it tests all three axes. This task has no check. Of the four blocks below the function, only the first is in the corridor. The others are behind it, to the left of it and above it. The next cell then lists the obstacles of the street that your function finds. In this list, a `truck` is a lorry.

# %%
corridor = np.array([[2.0, -1.0, -1.5], [18.0, 1.0, 0.3]])  # its smallest and largest x, y, z


def in_corridor(boxes, corridor):
    """Return for each box (N, 8, 3) whether it overlaps the corridor, as a mask (N,)."""
    low, high = boxes.min(axis=1), boxes.max(axis=1)  # (N, 3) each
    # Change this line, which tests only x.
    return (low[:, 0] < corridor[1, 0]) & (high[:, 0] > corridor[0, 0])


places = np.array([[8, -1, -1.5], [-8, -1, -1.5], [8, 3, -1.5], [8, -1, 2]])
print("yours:   ", in_corridor(np.array(block) + places[:, None], corridor))
print("expected: [ True False False False]")

# %% tags=["folded"]
# @title Draw the obstacles in your corridor (you need not read this)
blocked = in_corridor(boxes, corridor)
for row in np.flatnonzero(blocked):
    # The bumper is 2.6 m ahead of the sensor.
    gap = boxes[row, :, 0].min() - 2.6
    print(f"{kinds[present[row]]} {present[row]}: {abs(gap):.1f} m",
          "ahead of the bumper" if gap > 0 else "behind the bumper")
axes = plots.boxes(boxes[blocked], cloud=cloud[labels > 0], limits=((-2, 20), (-9, 9)),
                   names=[present[row] for row in np.flatnonzero(blocked)],
                   title="The corridor (dashed), and the obstacles that you find in it")
# Your function makes the eight corners of the corridor from just two points.
plots.boxes(get_bounding_boxes(corridor, np.array([1, 1])), reference=True, label="corridor",
            axes=axes);

# %% [markdown]
# <details><summary>An answer</summary>
#
# Write `return ((low < corridor[1]) & (high > corridor[0])).all(axis=1)`. Only a cyclist and a pedestrian are then left.
# </details>
#
# How many comparisons do the boxes save?

# %%
by_point, by_box = 6 * np.count_nonzero(labels), 6 * len(boxes)
show_table(["paths", "comparisons with points", "building the boxes", "comparisons with boxes"],
           [[paths, f"{paths * by_point:,}", f"{by_point:,}", f"{paths * by_box:,}"]
            for paths in (1, 100)])

# %% [markdown]
# Building the boxes costs as much as one test of all points, because minimum and maximum look at every coordinate. But you build them only once per scan, and the car may test a hundred paths.
#
# ## Play: turn a car
#
# Now you can turn car 10.

# %%
largest = predict("At which heading is the box around the whole car largest?",
                  between=(0, 90), step=5, unit="°")

# %% tags=["folded"]
# @title A car to turn (you need not read this)
def turned(points, angle):
    """Return points turned anticlockwise about the z axis by an angle in radians."""
    x, y, z = points[:, :3].T
    return np.column_stack([x * np.cos(angle) - y * np.sin(angle),
                            x * np.sin(angle) + y * np.cos(angle), z])


# The middle of the car is the origin, and the sides that were seen face us.
straight = turned(cloud[labels == 10, :3] - centre, -(yaw + np.pi))
outline = np.array([[x, y, 0.0] for x in (-length / 2, length / 2)
                    for y in (-width / 2, width / 2)])
ahead = np.array([8.0, 0.0, 0.0])  # where the pictures show the car


def box_area(points):
    """Return the area in square metres that the box of one cluster covers."""
    box = get_bounding_boxes(points, np.ones(len(points), dtype=int))[0]
    return np.prod(np.ptp(box[:, :2], axis=0))


def draw_turned(degrees, axes=None):
    """Draw the turned points and the true outline of the car, and the box of the outline."""
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
# Here is the same without a slider. The true outline of the car is dashed, and its scanned points are grey. (At another heading, a real scanner would see other parts of the car.)

# %%
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4), layout="compressed")
for degrees, axes in zip((5, 40), panels):
    draw_turned(degrees, axes)
    axes.get_legend().remove()

# %% [markdown]
# ## Theory against practice: the empty corners
#
# The length and the width of a turned car both add to its extent along x and along y. For length $l$, width $w$ and heading $\theta$, the box covers the area
#
# $$A(\theta) = (l\cos\theta + w\sin\theta)\,(l\sin\theta + w\cos\theta).$$
#
# We measure the same area with your function, for the outline of the car and for its scanned points.

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
print(f"At 45° the box covers {theory[9]:.1f} m², and {1 - length * width / theory[9]:.0%} of it is "
      "empty.")
seen = measured["boxes of the scanned points"][1]
print(f"The smallest box of the scanned points covers {min(seen):.1f} m², at "
      f"{degrees[np.argmin(seen)]}°. The car covers {length * width:.1f} m².")
largest.compare(degrees[theory.argmax()],
                "If you multiply the formula out, you get l w + (l² + w²) sin(2θ) / 2. The sine is "
                "largest when 2θ is 90°. At that heading, the box is a square.")

# %% [markdown]
# The boxes of the scanned points are smaller, because a scanner sees only the sides that face it.
#
# So an axis-aligned box is wrong in two ways. It contains air, so it blocks parts of the street that are free. It does not contain parts that the scanner missed, so the real obstacle may stick out. How large are these two errors in this street?

# %% tags=["folded"]
# @title What sticks out of your boxes (you need not read this)
vehicles = np.isin(truth["box_kinds"], ["car", "truck", "cyclist"])
vehicles &= np.isin(truth["box_identities"], present)
off = np.degrees(truth["box_yaws"][vehicles]) % 90  # a quarter turn changes nothing
off = np.minimum(off, 90 - off)
print(f"{vehicles.sum()} vehicles: {np.count_nonzero(off < 10)} are within 10° of our axes, "
      f"and the worst is {off.max():.0f}° off")

across = np.linspace(-0.5, 0.5, 50)
spots = np.array([(x, y, 0.0) for x in across for y in across])  # spread over a footprint
for name in (10, 4, 13):
    row = np.flatnonzero(truth["box_identities"] == name)[0]
    footprint = turned(spots * truth["box_sizes"][row], truth["box_yaws"][row])
    footprint = (footprint + truth["box_centres"][row])[:, :2]
    box = boxes[present.index(name), :, :2]
    outside = ((footprint < box.min(axis=0)) | (footprint > box.max(axis=0))).any(axis=1)
    print(f"{kinds[name]} {name}: {outside.mean():.0%} of its footprint is outside its box")

# %% [markdown]
# On a straight street, nearly every vehicle is parallel to us, and axis-aligned boxes contain little air. The larger error is the part of a vehicle that is outside its box. The scanner sees only the back or one side of many vehicles, so their boxes are too short or too narrow. Lesson 11 turns the box with the car.

# %% [markdown]
# ## Common mistakes
#
# | what the code does | what you see |
# |---|---|
# | uses `if x < low: ... elif x > high: ...` | boxes are slightly too small or infinite, because a new minimum is never tried as a maximum |
# | starts with `low = high = 0` | every box reaches to the sensor |
# | draws a box around label 0 | one box over the whole street, with the ego car inside |
# | loops over `range(1, labels.max())` | the last obstacle has no box, and gaps raise an error |
# | uses `.max()` without `axis=0` | an error at `high[0]`, or cubes, because x, y and z share one number |
# | returns `np.array(boxes)` of an empty list | shape (0,), so the next step fails on an empty road |
#
# The first mistake is hard to notice, because most boxes are right. We try it on all obstacles of this scan, with three axes each.

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
                  "Most of them are heights. A scan lists its rows from the top beam down, so the "
                  "first point of a cluster is often its highest. It becomes the first minimum, and "
                  "elif then never compares it with the maximum.")

# %% [markdown]
# Here are two more mistakes.

# %% tags=["folded"]
# @title Two more mistakes (you need not read this)
from_zero = np.vstack([cloud, np.zeros((len(present), 4))])
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.6), layout="compressed")
plots.boxes(get_bounding_boxes(from_zero, np.concatenate([labels, present])), limits=street,
            cloud=cloud[labels > 0], axes=left, title="low = high = 0 at the start")
wide = ((-95, 95), (-95, 45))
with_noise = get_bounding_boxes(cloud, labels + 1)  # label 0 is now label 1
plots.boxes(with_noise[1:], limits=wide, cloud=cloud[::4], axes=right, reference=True,
            label="right boxes", title="also a box around label 0")
plots.boxes(with_noise[:1], axes=right, label="wrong boxes");

# %% [markdown]
# ## Let it drive
#
# This drive is optional. A car drives for ten seconds through a quiet street with your `get_bounding_boxes`. The other steps are given. The cell takes about 15 seconds.

# %%
from utils.drive import askew, chain, drive_street, on_time
from utils.lent import is_written, own  # own(f) is your function f, never a stored answer


def drive_with(degrees):
    """Drive ten seconds through a quiet street with a scanner that is turned by some degrees."""
    return drive_street(1, askew(chain(boxes=own(get_bounding_boxes)), degrees), seconds=10,
                        clock=on_time)


drive_with(0) if is_written(get_bounding_boxes) else print(
    "get_bounding_boxes is not written, or has not passed its check.")

# %% [markdown]
# The car never brakes. Now imagine that a mechanic mounts the scanner at an angle of 12°, and try `drive_with(12)`. The boxes are now at an angle to the street, and their corners reach into our lane. **A challenge:** find the largest angle, in whole degrees, at which the car still drives 82 m without braking.
#
# <details><summary>An answer</summary>
#
# It is 4°. At 5° and above, the long box of a lorry blocks the lane. At 8° and above, so does the box of a parked car. At 9° and above, our car stops in front of a parked car after at most 13 m.
# </details>

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(get_bounding_boxes)

# %% [markdown]
# ## In practice
#
# - Axis-aligned boxes are the usual first test for collisions. Programs look closer only if two boxes overlap.
# - Data sets store the centre, size and heading of a box instead of its corners. KITTI uses seven numbers, with the centre of the *floor*. nuScenes uses ten numbers, four of which describe the heading (a *quaternion*).
# - A single stray point inflates a box. With noisy sensors, systems use the 1st and 99th percentiles, and give up the guarantee that no point is outside.
#
# Open3D does the same for one cluster, but the corners have another order. Corner 3 is above corner 0, and corner 4 is opposite corner 0.
#
# ```python
# box = open3d.geometry.AxisAlignedBoundingBox.create_from_points(point_cloud.points)
# low, high = box.min_bound, box.max_bound
# corners = np.asarray(box.get_box_points())
# ```
#
# ## Summary
#
# - A box is a minimum and a maximum on each axis. Its corners are the eight combinations.
# - It is a keep-out volume, because every point of the cluster is inside. It also contains air, which fills more than half of it if a car is at 45° to the axes. Parts that the scanner did not see may stick out.
# - Label 0 is not an obstacle, labels may have gaps, and the result is an array even without obstacles.
#
# **Sources.** Boxes as collision volumes: [Ericson, Real-Time Collision Detection, chapter 4](https://realtimecollisiondetection.net/). Boxes in a benchmark: [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). NumPy reductions: [numpy.min](https://numpy.org/doc/stable/reference/generated/numpy.min.html).
#
# **Next:** 09 · Filter clusters

# %% [markdown]
# ## If you want more
#
# Each task takes 10 to 20 minutes, and so does *Breaking it on purpose*.
#
# 1. Replace the loop. Sort the points by label, and use `np.minimum.reduceat`. How much faster is this with a thousand clusters?
# 2. Give every box a margin of 0.2 m, and count the boxes that overlap. Which gaps in this street are closed now?
# 3. Replace the minimum and the maximum by percentiles. How many points of the street are then outside their boxes?

# %% [markdown]
# ### Breaking it on purpose
#
# *A good tester looks for the smallest input on which a right and a wrong function give different results.*
#
# Three colleagues have written their own `get_bounding_boxes`, but do not show their code. In the pictures of their boxes, dots have label 1, squares have label 3, and crosses have label 0. What is wrong with A, B and C?

# %%
show_broken(get_bounding_boxes)

# %% [markdown]
# For each version, write a cloud on which its boxes differ from yours, with as few rows as you can. Once a cloud exposes a version, you see what is wrong with it.

# %%
# For each of A, B and C, give rows [x, y, z, label] with positions in metres: A=[[...], [...]].
tell_apart(get_bounding_boxes, A=None, B=None, C=None)

# %% [markdown] tags=["footer"]
# (footer)
