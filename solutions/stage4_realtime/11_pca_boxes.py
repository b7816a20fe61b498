# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     packages: [scikit-learn]
# ---

# %% [markdown]
# # 11 · Boxes that turn
#
# ![A car that stands diagonally, seen from above, with two boxes: a dashed one along the street, half of it empty, and a smaller one turned with the car.](pictures/11_preview.png)
#
# A box along the street around a car across the street is mostly air. In this lesson the points themselves say how to turn the box, and you will see when they mislead.
#
# **After this lesson you can**
# - find the directions in which a cloud is longest and shortest, and know what their signs and their order are worth,
# - put an upright, turned box around any cluster, with every point inside,
# - say how far such a heading can be trusted, and why it jumps from frame to frame.
#
# **You write** `principal_axes` (10 points) and `get_oriented_boxes` (20 points). **Time:** about 60 minutes. **You need** axis-aligned boxes (lesson 08) and matrix products.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A car across the street
#
# *What the scanner gives us of a car is the two sides that face it.*
#
# Label 10 in our scan is a car that turns out of a drive. As in lesson 08 we borrow the labels from the truth that comes with the scan; label 0 is no obstacle.

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

car = cloud[labels == 10, :3]
print(f"{len(car):,} points; their box along x and y covers "
      f"{np.prod(np.ptp(car[:, :2], axis=0)):.1f} m²")
around_car = ((4.0, 10.4), (1.0, 6.4))
plots.from_above(car, limits=around_car, title="The turning car, from above");

# %% [markdown]
# **Predict first.** By how many degrees is this car turned against the x axis? Estimate it from the picture and write it down. Then imagine a computer that sees only a list of numbers: what could it compute to find that angle?

# %% [markdown]
# ## The naive idea: fit a line
#
# *Regression measures errors along y only, so its answer depends on how the car happens to stand.*
#
# A line $y = ax + b$ through the points has the slope $a = \tan\theta$. NumPy fits it in one call. To try it out, we need a car whose heading we know: a block of random points, turned by $\theta$ about z,
#
# $$\begin{pmatrix} x' \\ y' \end{pmatrix} = \begin{pmatrix} \cos\theta & -\sin\theta \\ \sin\theta & \cos\theta \end{pmatrix} \begin{pmatrix} x \\ y \end{pmatrix}.$$

# %%
def turned(points, angle):
    """Points (n, 3) turned about the z axis by an angle in radians, anticlockwise."""
    x, y, z = points[:, :3].T
    return np.column_stack([x * np.cos(angle) - y * np.sin(angle),
                            x * np.sin(angle) + y * np.cos(angle), z])


def block(length, width, height, n=600):
    """Random points of a solid block around the origin."""
    return np.random.default_rng(1).uniform(-0.5, 0.5, (n, 3)) * [length, width, height]


ahead = np.array([8.0, 0.0, 0.0])
figure, panels = plt.subplots(1, 3, figsize=(8.5, 3.5), layout="compressed")
for degrees, axes in zip((20, 50, 80), panels):
    points = turned(block(4.2, 1.8, 1.4), np.radians(degrees)) + ahead
    slope, height = np.polyfit(points[:, 0], points[:, 1], 1)
    plots.boxes([], cloud=points, limits=((5.4, 10.6), (-2.6, 2.6)), axes=axes,
                title=f"true {degrees}°, line {np.degrees(np.arctan(slope)):.0f}°")
    axes.get_legend().remove()
    axes.plot([5, 11], [5 * slope + height, 11 * slope + height], color="black", linewidth=2)

# %% [markdown]
# Near the x axis the line is nearly right. The steeper the car stands, the more it lags behind. Turn the street by a quarter and the same car gets another heading: no property of the car at all.
#
# ## The idea: the direction of greatest spread
#
# *Look along every direction, and take the one in which the points are spread most.*
#
# Let $m$ be the mean of the points and $u$ a direction, a vector of length 1. Projected onto $u$, point $p$ lands at $u \cdot (p - m)$. The mean square of that is the *variance* along $u$:
#
# $$s^2(u) = \frac1n \sum_p \bigl(u \cdot (p - m)\bigr)^2 = u^{\mathsf T} C\, u, \qquad C = \frac1n \sum_p (p - m)(p - m)^{\mathsf T}.$$
#
# The *covariance matrix* $C$, 3 x 3, is all that we need to know of the points, be they ten or a million. Let us look round in steps of one degree.

# %%
looking = np.arange(0, 181)
directions = np.column_stack([np.cos(np.radians(looking)), np.sin(np.radians(looking))])
spread = np.var(car[:, :2] @ directions.T, axis=0)
best, worst = looking[spread.argmax()], looking[spread.argmin()]
axes = plots.curves({"variance": (looking, spread)}, across="looking direction (°)",
                    up="variance along it (m²)", title="Spread of the turning car, seen from above")
axes.axvline(best, color="black", linestyle="--", label=f"largest: {best}°")
axes.axvline(worst, color="black", linestyle=":", label=f"smallest: {worst}°")
axes.legend()
print(f"largest at {best}°, smallest at {worst}°: {abs(best - worst)}° apart")
true_yaw = truth["box_yaws"][truth["box_identities"] == 10][0]
print(f"true heading of the car: {np.degrees(true_yaw) % 180:.0f}°")

# %% [markdown]
# The largest and the smallest stand at right angles, and not by chance: a symmetric matrix has orthogonal *eigenvectors*, and they are exactly these directions, the **principal axes**. The eigenvalues are the variances along them. This is *principal component analysis*, PCA.
#
# Compare with your prediction. The largest spread and the true heading disagree by more than a careless eye. Keep that in mind; we come back to it.

# %% [markdown]
# ## Two ways to compute, three things to watch
#
# *Order, sign and handedness are conventions, and libraries do not agree on them.*
#
# `np.linalg.eigh` takes a symmetric matrix apart. `np.linalg.svd` takes the centred points themselves and needs no covariance: its singular values are the square roots of $n$ times the variances, and tiny variances survive better. Here are both, for body height and arm span of four people:

# %%
people = np.array([[1.60, 1.58], [1.71, 1.74], [1.80, 1.79], [1.93, 1.97]])
deviation = people - people.mean(axis=0)
values, vectors = np.linalg.eigh(np.cov(people, rowvar=False, bias=True))
_, singular, rows = np.linalg.svd(deviation, full_matrices=False)
print("eigh: variances", values.round(5), "axes in columns\n", vectors.round(3))
print("svd:  variances", (singular**2 / len(people)).round(5), "axes in rows\n", rows.round(3))

# %% [markdown]
# - **Order.** `eigh` sorts upwards, `svd` downwards. And one puts axes in columns, the other in rows.
# - **Sign.** If $u$ is an axis, so is $-u$. An axis has no front; nothing in the points says where the headlights are.
# - **Handedness.** Three axes at right angles form a right-handed triple, like thumb, index and middle finger of the right hand, or a left-handed one. The determinant says which: $+1$ or $-1$. Only a right-handed triple is a *rotation*; the other kind is a mirror, and a mirrored car is another car.
#
# `np.cov` hides a fourth trap: by default it takes *rows* as variables. Without `rowvar=False` a cloud of 1,000 points gives a matrix of 1,000 x 1,000.

# %% [markdown]
# ## Exercise 1 · `principal_axes` (10 points)
#
# Return the three axes as columns, by decreasing variance, right-handed. A cluster may hold a single point: any right-handed axes are right then.

# %% nbgrader={"grade": false, "grade_id": "principal_axes", "locked": false, "schema_version": 3, "solution": true, "task": false}
def principal_axes(points):
    """Find the directions in which points are spread most, least, and in between.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; a fourth column is ignored.

    Returns
    -------
    ndarray, shape (3, 3)
        Orthonormal axes, one in each column, by decreasing variance; right-handed: the
        determinant is +1. Signs are free as far as that allows.
    """
    # 1. No points at all: any right-handed axes will do.
    # 2. Centre the points and compute their covariance matrix, 3 x 3.
    # 3. Its eigenvectors, the one of the largest variance first.
    # 4. A negative determinant: flip the sign of one column.
    # roughly 8 lines
    ### BEGIN SOLUTION
    xyz = points[np.isfinite(points[:, :3]).all(axis=1), :3]
    if len(xyz) == 0:
        return np.eye(3)
    centred = xyz - xyz.mean(axis=0)
    variances, ascending = np.linalg.eigh(centred.T @ centred / len(xyz))
    by_spread = ascending[:, ::-1]
    if np.linalg.det(by_spread) < 0:
        by_spread[:, 2] *= -1
    return by_spread
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Take `points[:, :3]` and subtract their mean over the rows, `axis=0`. Do not divide by the standard deviation: that would make every direction equally wide.
# </details>
# <details><summary>Hint 2</summary>
#
# With the centred points in `q`, the covariance is `q.T @ q / len(q)`: 3 x 3 even for one point. `np.linalg.eigh` gives variances and vectors, ascending; `[:, ::-1]` turns the order of columns round.
# </details>
# <details><summary>Hint 3</summary>
#
# At the end test `np.linalg.det(axes) < 0`. If so, `axes[:, 2] = -axes[:, 2]`. For no points return `np.eye(3)` before anything else.
# </details>

# %% [markdown]
# **Look before you check.** The long arrow should run along the block, the short one across it, in both views. The determinant should be 1.

# %%
def draw_axes(points, matrix):
    """Points with two standard deviations along each axis, from above and from the side."""
    figure, panels = plt.subplots(1, 2, figsize=(8.5, 3.8), layout="compressed")
    middle = points.mean(axis=0)
    for view, up, panel in (("above", 1, panels[0]), ("side", 2, panels[1])):
        plots.boxes([], cloud=points, view=view, limits=((5, 11), (-3, 3)), axes=panel)
        for axis, style, name in zip(matrix.T, ("-", "--", ":"), ("first", "second", "third")):
            end = middle + 2 * np.std(points @ axis) * axis
            panel.plot([middle[0], end[0]], [middle[up], end[up]], style, color="black",
                       linewidth=2.5, label=name)
            panel.plot(end[0], end[up], "o", color="black")
        panel.legend(*[part[1:] for part in panel.get_legend_handles_labels()])
        panel.set_aspect("equal")


sample = turned(block(4.2, 1.8, 1.4), np.radians(35)) + ahead
axes_of_sample = principal_axes(sample)
print(axes_of_sample.round(2), " determinant:", np.linalg.det(axes_of_sample).round(3))
draw_axes(sample, axes_of_sample)

# %% nbgrader={"grade": true, "grade_id": "test_principal_axes", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(principal_axes)

# %% [markdown]
# ## A rotation in three costumes
#
# *Nine numbers, four or three: the same turn, and only one of them is unambiguous.*
#
# Your matrix $A$ turns the x axis into the first principal axis. The same turn can be written as
#
# - a **rotation matrix**: nine numbers, $A^{\mathsf T}A = I$ and $\det A = 1$;
# - a **quaternion** $(x, y, z, w)$: turn by $\varphi$ about the unit vector $n$, written $\left(n\sin\tfrac\varphi2, \cos\tfrac\varphi2\right)$. Four numbers of length 1; $q$ and $-q$ are the same turn;
# - **Euler angles**: yaw about z, pitch about y, roll about x. Three numbers, but the *order* of the three turns matters.
#
# Take the axes of our turning car, in space this time.

# %%
from scipy.spatial.transform import Rotation

turn = Rotation.from_matrix(principal_axes(car))
quaternion = turn.as_quat()
same = np.allclose(Rotation.from_quat(-quaternion).as_matrix(), turn.as_matrix())
print("quaternion:", quaternion.round(3), "  its negative is the same turn:", same)
yaw, pitch, roll = turn.as_euler("ZYX", degrees=True)
print(f"as Z, then Y, then X: yaw {yaw:7.1f}°, pitch {pitch:6.1f}°, roll {roll:7.1f}°")
other_roll, other_pitch, other_yaw = turn.as_euler("XYZ", degrees=True)
print(f"as X, then Y, then Z: yaw {other_yaw:7.1f}°, pitch {other_pitch:6.1f}°, "
      f"roll {other_roll:7.1f}°")
first = turn.as_matrix()[:, 0]
print(f"first axis, seen from above: {np.degrees(np.arctan2(first[1], first[0])):.1f}°")

# %% [markdown]
# Same turn, two yaws. With ZYX the yaw comes first, and it is exactly the direction of the first axis seen from above: $\psi = \operatorname{atan2}(A_{21}, A_{11})$. With XYZ the yaw is what is left after rolling and pitching, and means nothing to somebody who looks at a street. Vehicles use ZYX.
#
# ## Why only yaw
#
# *A car leans by a degree or two. If its box leans more, the box is wrong, not the car.*
#
# Look at pitch and roll above: the car seems to lie on its side, nose in the air. The points are to blame: many on the bonnet, none on the underside. And a pedestrian is longest upwards, so the "first axis" of a person is the vertical, and its yaw is arbitrary.
#
# A tempting repair: make the box in 3-D, as long, wide and high as its axes say, then set pitch and roll to zero. What does that do to the promise that all points are inside?

# %%
def outside_flattened(points):
    """Share of points outside their 3-D PCA box after its pitch and roll are set to zero."""
    turn = Rotation.from_matrix(principal_axes(points))
    own = turn.inv().apply(points)
    size, middle = np.ptp(own, axis=0), turn.apply((own.max(axis=0) + own.min(axis=0)) / 2)
    upright = Rotation.from_euler("Z", turn.as_euler("ZYX")[0])
    return (np.abs(upright.inv().apply(points - middle)) > size / 2 + 1e-9).any(axis=1).mean()


shares = {f"{kinds[label]} {label}": round(100 * outside_flattened(cloud[labels == label, :3]), 1)
          for label in (10, 1, 2, 7, 12, 14, 20, 30)}
plots.compare(shares, label="points outside their own box (%)",
              title="A 3-D box flattened afterwards forgets its points");

# %% [markdown]
# Cars lose a few points; walkers, poles and walls lose most: there the axes are numbered differently, the longest of a pole is up, and after flattening length, width and height stand in each other's place. Order matters: **first decide that the box is upright, then measure.**
#
# So: look from above, find the yaw in the plane, and measure in the turned frame.

# %% [markdown]
# ## Turn the street, not the box
#
# *In a frame that is turned with the car, the best box is the plain one from lesson 08.*
#
# 1. Seen from above, the first principal axis $(a_x, a_y)$ gives $\psi = \operatorname{atan2}(a_y, a_x)$.
# 2. Turn all points by $-\psi$. Now the car is parallel to x.
# 3. Minimum and maximum, four floor corners, four roof corners.
# 4. Turn the corners by $+\psi$: back to the street.
#
# The function `turned` from above does steps 2 and 4. A turn keeps distances, so what is inside in one frame is inside in the other: the promise holds by construction. To look from above, set the heights to zero:

# %%
print((car * [1, 1, 0] + 0.0)[:3])
for name, points in (("in space", car), ("from above", car * [1, 1, 0])):
    first = principal_axes(points)[:, 0]
    print(f"first axis {name}: ({first[0]:.2f}, {first[1]:.2f}, {first[2]:.2f})")

# %% [markdown]
# ## Exercise 2 · `get_oriented_boxes` (20 points)
#
# One upright, turned box for each label above 0, in ascending order. Use `principal_axes` from above, or any other way to find a good yaw.

# %% nbgrader={"grade": false, "grade_id": "get_oriented_boxes", "locked": false, "schema_version": 3, "solution": true, "task": false}
def get_oriented_boxes(cloud, cluster_labels):
    """Put a box around each cluster that is turned with it about the z axis.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity.
    cluster_labels : ndarray of int, shape (n,)
        The cluster of each point; 0 for points of no cluster.

    Returns
    -------
    ndarray, shape (N, 8, 3)
        Corners in metres, one box for each label > 0, in ascending label order; (0, 8, 3)
        where there are none. Each box contains all points of its cluster. Its floor is at
        their smallest z and its roof at their largest: first the four corners of the floor,
        going round, then the four above them in the same order.
    """
    # For each label above 0:
    # 1. the yaw of the first principal axis of its points, seen from above,
    # 2. its points turned by -yaw, their smallest and largest x, y, z,
    # 3. four floor corners going round, then four roof corners,
    # 4. the corners turned by +yaw.
    # roughly 12 lines
    ### BEGIN SOLUTION
    measured = np.isfinite(cloud[:, :3]).all(axis=1)
    boxes = []
    for label in np.unique(cluster_labels[measured & (cluster_labels > 0)]):
        points = cloud[measured & (cluster_labels == label), :3]
        along = principal_axes(points * [1, 1, 0])[:, 0]
        heading = np.arctan2(along[1], along[0])
        straight = turned(points, -heading)
        (back, right, bottom), (front, left, top) = straight.min(axis=0), straight.max(axis=0)
        around = [(front, left), (back, left), (back, right), (front, right)]
        corners = [(x, y, z) for z in (bottom, top) for x, y in around]
        boxes.append(turned(np.array(corners), heading))
    return np.array(boxes).reshape(-1, 8, 3)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# The loop over labels and the `.reshape(-1, 8, 3)` at the end are as in lesson 08. `first = principal_axes(points * [1, 1, 0])[:, 0]` is the direction, `np.arctan2(first[1], first[0])` the yaw.
# </details>
# <details><summary>Hint 2</summary>
#
# `turned(points, -yaw)` has the car parallel to x; `low` and `high` are its minimum and maximum. Floor corners going round: (low x, low y), (high x, low y), (high x, high y), (low x, high y), all at low z.
# </details>
# <details><summary>Hint 3</summary>
#
# The roof is the same four with high z. Put all eight into an array of shape (8, 3) and append `turned(that_array, yaw)` to a list: plus yaw this time. If boxes look mirrored, the two signs are the same.
# </details>

# %% [markdown]
# **Look before you check.** Every point should lie inside the box of its obstacle, and the boxes should turn. Most parked cars look crooked; there is more about that below.

# %%
boxes = get_oriented_boxes(cloud, labels)
figure, (wide, close) = plt.subplots(1, 2, figsize=(8.5, 3.8), layout="compressed")
plots.boxes(boxes, cloud=cloud[labels > 0], limits=((-10, 20), (-10, 10)), axes=wide,
            title="The street")
plots.boxes(boxes, cloud=cloud[labels > 0], limits=around_car, axes=close, title="The turning car");

# %%
from utils.scene3d import Scene

# Drag to turn the street, scroll to come nearer.
(Scene("Your boxes in space").add_cloud(cloud[stands_near]).add_oriented_boxes(boxes)
 .add_ego_car().show(interactive=True))

# %% nbgrader={"grade": true, "grade_id": "test_get_oriented_boxes", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(get_oriented_boxes)

# %% [markdown]
# ## Play: turn the car
#
# *The plain box breathes with the heading; the turned one should not.*
#
# Move the slider. Orange: your box. Dashed: the box along x and y.

# %%
car_centre = np.append((car[:, :2].min(axis=0) + car[:, :2].max(axis=0)) / 2, 0)


def floor_area(box):
    """Square metres of an upright box whose corners go round."""
    return np.linalg.norm(box[1] - box[0]) * np.linalg.norm(box[2] - box[1])


def draw_both(degrees, axes=None):
    """The scanned car, turned by some degrees more, with both boxes."""
    points = turned(car - car_centre, np.radians(degrees)) + ahead
    box = get_oriented_boxes(points, np.ones(len(points), dtype=int))
    axes = plots.boxes(box, cloud=points, limits=((4.8, 11.2), (-3.2, 3.2)), axes=axes,
                       title=f"{degrees}°: {floor_area(box[0]):.1f} m²")
    (x, y), (to_x, to_y) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    axes.plot([x, to_x, to_x, x, x], [y, y, to_y, to_y, y], "--", color="black", linewidth=1)


@interact(degrees=IntSlider(value=0, min=-90, max=90, step=5, description="turn by (°)",
                            continuous_update=False))
def show_both(degrees):
    draw_both(degrees)
    plt.show()

# %% [markdown]
# The same without a slider:

# %%
figure, panels = plt.subplots(1, 3, figsize=(8.5, 3.5), layout="compressed")
for degrees, axes in zip((-55, -20, 30), panels):
    draw_both(degrees, axes)
    axes.get_legend().remove()

# %% [markdown]
# The area stays the same whatever the heading: your box turns with the points. But look again at the flank of the car. The box is crooked, always in the same way. That is not your mistake.

# %% [markdown]
# ## Theory against practice: the points lie
#
# *PCA finds the main direction of the points, and a scanner puts points on two sides of a car only.*
#
# From the corner we see an L: a long side of length $a$ and a short one of length $b$. Put the corner at the origin, the long side along x, and the points evenly along both. Then
#
# $$C_{xx} = \frac{a^3/3}{a+b} - \left(\frac{a^2/2}{a+b}\right)^2\!, \qquad C_{yy} = \frac{b^3/3}{a+b} - \left(\frac{b^2/2}{a+b}\right)^2\!, \qquad C_{xy} = -\frac{a^2 b^2}{4(a+b)^2}.$$
#
# $C_{xy}$ is not zero, so the first axis leans away from the long side, by
#
# $$\theta = \tfrac12 \operatorname{atan2}\bigl(2\,C_{xy},\ C_{xx} - C_{yy}\bigr).$$
#
# Now let your own `principal_axes` measure some L's.

# %%
def lean(ratio):
    """Angle in degrees between the first axis of an L of sides 1 and ratio, and its long side."""
    whole = 1 + ratio
    xx = 1 / 3 / whole - (0.5 / whole) ** 2
    yy = ratio**3 / 3 / whole - (ratio**2 / 2 / whole) ** 2
    xy = -(ratio**2) / (4 * whole**2)
    return np.degrees(-0.5 * np.arctan2(2 * xy, xx - yy))


def measured_lean(ratio):
    long_side = np.column_stack([np.arange(0, 1, 0.001), np.zeros(1000), np.zeros(1000)])
    short = np.arange(0, ratio, 0.001)
    points = np.vstack([long_side, np.column_stack([0 * short, short, 0 * short])])
    first = principal_axes(points)[:, 0]
    return np.degrees(np.arctan2(abs(first[1]), abs(first[0])))


ratios = np.linspace(0.02, 1, 50)
some = np.array([0.1, 0.2, 0.3, 0.43, 0.6, 0.8, 0.95])
axes = plots.curves({"theory": (ratios, lean(ratios))},
                    {"your principal_axes": (some, [measured_lean(ratio) for ratio in some])},
                    across="short side / long side", up="lean of the first axis (°)",
                    title="How far the first axis of an L leans")
axes.axvline(1.8 / 4.2, color="black", linestyle=":", label=f"a car: {lean(1.8 / 4.2):.0f}°")
axes.legend();

# %% [markdown]
# The lean of a car is not noise. It is there in every frame, and more points do not help. A square L leans by 45°: its first axis is the diagonal.
#
# One cure is to ask another question: not *where are the points spread most?* but *which rectangle around them is the smallest?* Try all headings between 0 and 90°; a rectangle looks the same after a quarter turn. It costs ninety times as much, but it does not care where the points lie thick and where thin.

# %%
def smallest_rectangle_yaw(points):
    """Heading in radians, from 0 to a quarter turn, of the smallest rectangle around points."""
    trials = np.radians(np.arange(0, 90))
    areas = [np.prod(np.ptp(turned(points, -trial)[:, :2], axis=0)) for trial in trials]
    return trials[np.argmin(areas)]


spot = present.index(10)
principal = principal_axes(car * [1, 1, 0])[:, 0]
print(f"principal axis:     {np.degrees(np.arctan2(principal[1], principal[0])) % 90:5.1f}°, "
      f"{floor_area(boxes[spot]):.1f} m²")
yaw = smallest_rectangle_yaw(car)
print(f"smallest rectangle: {np.degrees(yaw):5.1f}°, "
      f"{np.prod(np.ptp(turned(car, -yaw)[:, :2], axis=0)):.1f} m²")
print(f"truth:              {np.degrees(true_yaw) % 90:5.1f}°")

# %% [markdown]
# Nearer, if not yet there: much of the far half of this car was out of sight.
#
# ## From frame to frame
#
# *A heading that is good in one frame can still flip in the next.*
#
# A tracker looks at ten frames a second. Here is a square where a car drives in circles. In each frame we take its points and ask for its heading.

# %%
from utils.scenes import cyclist

times, headings = [], {"truth": [], "principal axis": [], "smallest rectangle": []}
for frame in cyclist(seed=0)[::2]:
    box = next(box for box in frame.boxes if box.identity == 1)
    points = frame.cloud[frame.scan.objects == 1, :3]
    points = points[points[:, 2] > box.centre[2] - box.size[2] / 2 + 0.35]  # off the ground
    principal = principal_axes(points * [1, 1, 0])[:, 0]
    times.append(frame.time)
    headings["truth"].append(box.yaw)
    headings["principal axis"].append(np.arctan2(principal[1], principal[0]))
    headings["smallest rectangle"].append(smallest_rectangle_yaw(points))
times = np.array(times)
headings = {name: np.array(values) for name, values in headings.items()}

axes = plots.curves({"truth, without jumps": (times, np.degrees(np.unwrap(headings["truth"])))},
                    {name: (times, np.degrees(values)) for name, values in headings.items()},
                    across="time (s)", up="heading (°)", title="What comes out of each frame")

# %% [markdown]
# Jumps everywhere, and only some are the method's fault:
#
# - The truth jumps by 360° because angles do.
# - The principal axis jumps by 180° because an axis has no front.
# - The smallest rectangle jumps by 90° because a rectangle has four equal directions. PCA does so, too, whenever we see the car from behind and its width is longer than what is left of its length.
#
# The box does not mind: as a set of corners it is the same after a half turn. A tracker does mind. The cure costs one line: of all headings that differ by quarter turns, take the one nearest to the frame before. `np.unwrap` does that, given the period. One question stays open, which of the four is the front; the direction of motion answers it, and here the truth of the first frame does.

# %%
def steady(values, start):
    """Headings without jumps of quarter turns, the first one nearest to `start`."""
    smooth = np.unwrap(values, period=np.pi / 2)
    return smooth + np.round((start - smooth[0]) / (np.pi / 2)) * np.pi / 2


true_headings = np.unwrap(headings["truth"])
followed = {name: steady(headings[name], true_headings[0])
            for name in ("principal axis", "smallest rectangle")}
axes = plots.curves({"truth": (times, np.degrees(true_headings))},
                    {name: (times, np.degrees(values)) for name, values in followed.items()},
                    across="time (s)", up="heading (°)", title="The same, followed from frame to frame")
for name, values in followed.items():
    errors = np.degrees(np.abs(values - true_headings))
    print(f"{name:>18}: {np.median(errors):4.1f}° off in a typical frame, "
          f"{errors.max():4.1f}° in the worst")

# %% [markdown]
# Now both follow the car around. What is left of the principal axis's error is the lean of the L, and it swings from one side to the other as the car shows us its other corner. The smallest rectangle hardly errs at all.
#
# Which one should you use? PCA costs one small matrix and never fails; it is right for hedges, walls and lone posts and good enough to see whether a lane is free. To track a car, pay for the rectangle.

# %% [markdown]
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | turned by +yaw both times | the box stands far from its car, turned about the sensor by twice the yaw |
# | yaw in degrees passed to `np.cos` | boxes at any angle but the right one |
# | divided by the standard deviation (z-score) | every cluster is "turned" by 45°; and where z was set to 0 before, an error: 0 / 0 |
# | not centred | the first axis points from the sensor to the car |
# | columns left in ascending order | the "heading" is the width; and where z was set to 0 before, the first axis is the vertical, and every yaw is 0 |
# | determinant -1 | the box is right, but it is no rotation: SciPy refuses to make quaternion or Euler angles of it |
# | size taken in 3-D, flattened afterwards | points outside: see above |

# %%
points = turned(block(4.2, 1.8, 1.4), np.radians(25)) + [8.0, 2.0, 0.0]
one = np.ones(len(points), dtype=int)
box = get_oriented_boxes(points, one)[0]
flat_yaw = np.radians(25)
scaled = (points - points.mean(axis=0)) / points.std(axis=0) * [1, 1, 0]
wrong_first = principal_axes(scaled)[:, 0]
middle = points.mean(axis=0)
far_first = np.linalg.eigh(points.T @ points)[1][:, 2]
figure, panels = plt.subplots(1, 3, figsize=(8.5, 4.2), layout="compressed")
view = ((3.5, 11.5), (-7.5, 4.5))
plots.boxes(turned(box, -2 * flat_yaw)[None], cloud=points, limits=view, axes=panels[0],
            title="turned the wrong way")
for axes, direction, title in ((panels[1], wrong_first, "z-score: 45°"),
                               (panels[2], far_first, "not centred")):
    plots.boxes([], cloud=points, limits=view, axes=axes, title=title)
    ends = middle + np.outer([-3, 3], direction)
    axes.plot(ends[:, 0], ends[:, 1], color="black", linewidth=2)
for axes in panels:
    axes.get_legend().remove()

# %% [markdown]
# ## In practice
#
# - Detectors that learn predict the yaw directly, and suffer from the same half turn. nuScenes scores orientation by itself, KITTI together with detection.
# - Trackers keep yaw as part of their state and let motion decide the front: cars rarely drive backwards at 50 km/h.
# - A good box around what was *seen* is still not the box around the car. Systems extend it away from the sensor to the size of an ordinary car.
#
# ## If you want more
#
# 1. **Smallest rectangle, exactly.** One side of it always lies on an edge of the convex hull ([rotating calipers](https://en.wikipedia.org/wiki/Rotating_calipers)). Use `scipy.spatial.ConvexHull` and try only those headings. Mind clusters on a line: they have no hull.
# 2. **L-shape fitting.** Instead of the area, score a heading by how close the points lie to the two nearest sides: sum of 1 / max(distance, 0.05 m) over all points, the larger the better ([Zhang et al. 2017](https://doi.org/10.1109/IVS.2017.7995698)). Draw it into the last curve.
# 3. Use your favourite yaw in `get_oriented_boxes`. Any of them earns full points: the judge asks for boxes that are upright, contain all points and are not much larger than needed.
#
# ## Summary
#
# - Principal axes are the eigenvectors of the covariance: order them, mind that signs are free, and make the triple right-handed.
# - Of the three Euler angles a car on a road needs one. Decide for upright first, measure afterwards, and every point stays inside.
# - A heading is known up to half turns, a rectangle's up to quarter turns. Choose the one nearest to the last frame.
# - The points of a scan lie on two sides of a car, so its first axis leans. Smallest rectangles and L-shapes hardly do.
#
# **Sources.** Principal components: [Jolliffe and Cadima 2016](https://doi.org/10.1098/rsta.2015.0202). How bad PCA boxes can be: [Dimitrov, Knauer, Kriegel and Rote 2006](https://www.researchgate.net/publication/235758825_On_the_bounding_boxes_obtained_by_principal_component_analysis). Quaternions and Euler angles: [SciPy, Rotation](https://docs.scipy.org/doc/scipy/reference/generated/scipy.spatial.transform.Rotation.html).
#
# **Next:** 12 · Streaming obstacles

# %% [markdown] tags=["footer"]
# (footer)
