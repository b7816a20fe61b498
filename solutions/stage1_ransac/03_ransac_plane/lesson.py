# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [one_round, slopes_of, success_rate, good_samples, drive]
# ---

# %% [markdown]
# # 03 · The road as a plane
#
# ![A street seen from the side. A line runs through a band of dark road points and rises gently to the right; pale points of cars, people and trees stand above it.](03_preview.png)
#
# A street is full of things, and one of them is flat: the road. Find that plane, and whatever sticks out of it is an obstacle. Nobody has to tell the car how high its sensor is mounted, or whether the street climbs.
#
# **After this lesson you can**
# - describe a plane by four numbers and measure distances from it,
# - find the ground among cars, walls and people with RANSAC, and notice when it has found a wall instead,
# - refine the plane, distinguish scatter from bias, and say how many rounds RANSAC needs.
#
# **You write** `plane_through` (points), `point_plane_distance` (points), `ransac_plane` (points), `fit_plane` (points) and `iterations_needed` (points). **You need** the idea of RANSAC from lesson 02. There is a place to stop half way. **Time:** (time).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street, and the one flat thing in it
#
# *From the side, the road is the only thing that looks like a line.*
#
# We take the street around the car from the scan in `cloud.txt`: x forward, y left, z up in metres, the sensor at the origin, then intensity. Every eighth [return](#Words-of-the-course) is enough.
#
# The pavements lie only a hand higher than the road. Road and pavements together are the *ground*: what we want to find here.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots, predict, replay, show_table

cloud = load_cloud("cloud.txt")
nearby = (cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)
rows = np.flatnonzero(nearby)[::8]
street = cloud[rows]
side = ((-10, 30), (-2.6, 1.2))
print(f"{len(street):,} of {len(cloud):,} returns")
plots.from_side(street, limits=side, title="The street around the car, from the side");

# %% [markdown]
# **Predict first.** Look at the picture and write down two numbers. The first answer comes in the next cell, the second one when you meet RANSAC.

# %%
share = predict("What share of these points is ground?", between=(0, 100), unit="%")
all_three = predict("You pick three of these points at random. "
                    "How likely is it that all three lie on the ground?",
                    between=(0, 100), unit="%")

# %% [markdown]
# The scan was simulated, so its labels say what each return hit. We use them to judge results; none of your functions sees them.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
kinds = truth["classes"][rows]
is_ground = kinds == names.index("ground")
share.compare(100 * is_ground.mean(),
              "Most beams look down, so more than half of the points are ground. Most of the "
              "others are cars: they stand close to the sensor and are tall.")

# %% [markdown]
# ## The naive idea: the best plane for all points
#
# *Least squares listens to every point, and obstacles are points, too.*
#
# At school you learn to put a line through a cloud of measurements: make the sum of the squared errors as small as possible. The same works for a plane $z = \alpha x + \beta y + \gamma$. Let us give it all points.

# %%
table = np.column_stack([street[:, :2], np.ones(len(street))])
alpha, beta, gamma = np.linalg.lstsq(table, street[:, 2], rcond=None)[0]
naive = np.array([alpha, beta, -1.0, gamma])  # the same as alpha x + beta y - z + gamma = 0
above = (table @ [alpha, beta, gamma] - street[:, 2])[is_ground]
print(f"The plane runs {np.median(above):.2f} m above the ground.")
print(f"{(np.abs(above) < 0.2).sum()} of {is_ground.sum():,} ground points lie within 0.2 m of it.")
plots.plane_model(street, naive, limits=side,
                  title="Least squares over all points: a plane in mid-air");

# %% [markdown]
# The plane floats above the ground, because every car pulls it upwards, and squares make that worse: a point that is 1 m away counts as much as a hundred points that are 10 cm away. A better tool must find the points that agree, and ignore the rest.
#
# That is RANSAC, which you met in lesson 02 with lines. For planes we need two tools first: a plane through three points, and distances from it.

# %% [markdown]
# ## The idea: three points, one plane
#
# *A plane is a direction perpendicular to it, and a distance.*
#
# Think of a sheet of cardboard with a pencil glued upright to it. The direction of the pencil says how the sheet is turned; then only its distance from us is free. The pencil is the *normal* $n = (a, b, c)$, and a fourth number, $d$, goes with the distance. All points $(x, y, z)$ with
#
# $$a x + b y + c z + d = 0$$
#
# form the plane. Given three points $p, q, r$ of it, the two sides $q - p$ and $r - p$ lie in the plane, and their cross product is perpendicular to both:
#
# $$n = (q - p) \times (r - p), \qquad d = -\, n \cdot p .$$
#
# Two details decide whether this works on the road.
#
# - **Length.** Four numbers and their doubles, $(2a, 2b, 2c, 2d)$, describe the same plane. We divide by the length of $n$, so that $n$ has length 1. Then $a x + b y + c z + d$ is a distance in metres, and $|d|$ that of the plane from the sensor.
# - **Points on one line.** They do not fix a plane: it can turn about the line. Their cross product is $(0, 0, 0)$, and dividing by its length gives `nan`. Measured points hardly ever do that exactly, but three returns of one [beam](#Words-of-the-course) that lie side by side nearly do: then noise decides where their plane points.
#
# The sign stays free: $(a, b, c, d)$ and $(-a, -b, -c, -d)$ are the same plane, seen from its two sides.

# %%
u, v = np.array([2.0, 0.0, 0.0]), np.array([1.0, 3.0, 0.0])
print("u x v =", np.cross(u, v), "  length:", np.linalg.norm(np.cross(u, v)))
print("v x u =", np.cross(v, u), "  the other side")
print("u x 2u =", np.cross(u, 2 * u), "  one line, no plane")

# %% [markdown]
# ## Exercise 1 · `plane_through` (points)
#
# The plane through three points, with a normal of length 1; `None` when the points lie on one line.

# %% nbgrader={"grade": false, "grade_id": "plane_through", "locked": false, "schema_version": 3, "solution": true, "task": false}
def plane_through(p, q, r):
    """The plane through three points.

    Parameters
    ----------
    p, q, r : ndarray, shape (3,)
        x, y, z in metres.

    Returns
    -------
    tuple or array of four floats, or None
        (a, b, c, d) of a x + b y + c z + d = 0 with a unit normal (a, b, c) of either sign;
        None when the points lie on one line.
    """
    # 1. The cross product of the sides from p to q and from p to r.
    # 2. Its length. As good as zero, say below 1e-9? Then there is no plane.
    # 3. Divide by the length; choose d so that p lies on the plane.
    # roughly 6 lines
    ### BEGIN SOLUTION
    normal = np.cross(q - p, r - p)
    length = np.linalg.norm(normal)
    if length < 1e-9:
        return None
    normal = normal / length
    return (*normal, -normal @ p)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `np.cross(u, v)` is perpendicular to u and v. The sides are `q - p` and `r - p`.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.linalg.norm(normal)` is the length. Test it before you divide by it, and compute d after: $d = -(a x_p + b y_p + c z_p)$ with the new a, b, c.
# </details>
# <details><summary>Hint 3</summary>
#
# `normal = np.cross(...)`; `length = ...`; `if length < 1e-9: return None`; divide; return `(normal[0], normal[1], normal[2], -(normal @ ...))`.
# </details>

# %% [markdown]
# **A case to do by hand.** Three points of a level road, 1.7 m below the sensor. The sides are $q - p = (5, -3, 0)$ and $r - p = (2, 2, 0)$, and their cross product is $(0, 0, 16)$: straight up. Expected: $(0, 0, 1, 1.7)$, or all four with the other sign (a `-0.` is a 0); and `None` for three points on one line.

# %%
p, q, r = np.array([[4.0, 1.0, -1.7], [9.0, -2.0, -1.7], [6.0, 3.0, -1.7]])
print("a level road:", np.asarray(plane_through(p, q, r)))
print("on one line: ", plane_through(*np.array([[0.0, 0, 0], [1, 1, 1], [3, 3, 3]])))

# %% [markdown]
# **Look before you check.** Three returns of the road, far apart, and the plane through them. It should lie in the road, and the printed length should be 1.

# %%
corners = np.array([street[np.argmin(np.linalg.norm(street[:, :3] - place, axis=1)), :3]
                    for place in [(-8, 1, -1.9), (6, -1, -1.6), (16, 3, -1.4)]])
plane = plane_through(*corners)
print("plane:", np.round(plane, 3), "  length of the normal:", np.linalg.norm(plane[:3]).round(6))
axes = plots.plane_model(street, plane, limits=side, title="A plane through three returns")
axes.plot(corners[:, 0], corners[:, 2], "s", color="black", markersize=8);

# %% nbgrader={"grade": true, "grade_id": "test_plane_through", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(plane_through)

# %% [markdown]
# ## Exercise 2 · `point_plane_distance` (points)
#
# *With a unit normal, putting a point into the equation gives its distance.*
#
# Start on the plane and walk along the normal. Because $n$ has length 1, each metre adds exactly 1 to $a x + b y + c z + d$. On the plane it is 0, so at a point $p$ it is the number of metres walked:
#
# $$\text{distance}(p) = |\,a x_p + b y_p + c z_p + d\,|$$
#
# Without the bars the number has a sign: positive on the side to which the normal points, negative on the other. A distance has none.
#
# Mind the fourth column. A cloud of shape (n, 4) times a plane of four numbers is a legal product, and it multiplies the intensity with $d$.

# %% nbgrader={"grade": false, "grade_id": "point_plane_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def point_plane_distance(points, plane):
    """Distance of each point from a plane.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity, which does not count.
    plane : tuple or array of four floats
        (a, b, c, d) with a unit normal (a, b, c).

    Returns
    -------
    ndarray, shape (n,)
        Distances in metres, never negative.
    """
    # 1. x, y and z of all points, times the normal: one number per point.
    # 2. Add d and take the absolute value.
    # roughly 2 lines
    ### BEGIN SOLUTION
    normal, offset = np.asarray(plane[:3]), plane[3]
    return np.abs(points[:, :3] @ normal + offset)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `a, b, c, d = plane` unpacks the four numbers. `points[:, 0]` is the column of all x.
# </details>
# <details><summary>Hint 2</summary>
#
# `a * points[:, 0] + b * points[:, 1] + ...` does it for all points at once; so does `points[:, :3] @ normal`.
# </details>
# <details><summary>Hint 3</summary>
#
# One line: `return np.abs(... + d)` with the three products for the dots.
# </details>

# %% [markdown]
# **A case to do by hand.** The level road again, $(0, 0, 1, 1.7)$: here the distance is $|z + 1.7|$. Four points: one on the road, one on a kerb, a car's roof, the bottom of a pothole. Expected: 0, 0.13, 1.5 and 0.1. The pothole is 10 cm *below* the plane, and 0.1 all the same.

# %%
four = np.array([[5.0, 2.0, -1.7, 0.3], [6.0, 4.0, -1.57, 0.3],
                 [9.0, 0.0, -0.2, 0.8], [7.0, 1.0, -1.8, 0.2]])
print(np.round(point_plane_distance(four, (0.0, 0.0, 1.0, 1.7)), 2))

# %% [markdown]
# **Look before you check.** Colour is the distance from the plane that you drew above. The road should have the colour of 0 m along its whole length, though it climbs.

# %%
distances = point_plane_distance(street, plane)
plots.from_side(street, values=distances, label="distance from the plane (m)",
                limits=side, span=(0, 1.5),
                title="The road has the colour of 0 m, what stands on it has not");

# %% nbgrader={"grade": true, "grade_id": "test_point_plane_distance", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(point_plane_distance)

# %% [markdown]
# ## RANSAC: let three random points speak for all
#
# *A plane through three ground points collects the whole ground; a plane through anything else collects little.*
#
# One *round* of RANSAC: take three different points at random, the *sample*. Put a plane through them. Count its [inliers](#Words-of-the-course): the points that are no farther away than a threshold, here 0.2 m. The function below does one round with your two functions.

# %%
def one_round(rng):
    """The rows of a sample of the street, the plane through it, and the mask of its inliers."""
    three = rng.choice(len(street), size=3, replace=False)
    attempt = plane_through(*street[three, :3])
    return three, attempt, point_plane_distance(street, attempt) <= 0.2

# %% [markdown]
# Four rounds, four pictures. Squares are the sample, dots the inliers, crosses all others. How to read the line: a plane has no edge that one could draw from the side, so we cut it open at y = 0, straight ahead of the sensor, and draw the cut. A plane that also leans sideways is higher or lower to the left and right of this cut. So dots and squares may lie far from the line: they are near the plane, at another y.

# %% tags=["folded"]
# @title Draws four rounds (you need not read this)
rng = np.random.default_rng(2)
figure, panels = plt.subplots(4, 1, figsize=(8.5, 9.6), sharex=True, layout="compressed")
for number, axes in enumerate(panels, start=1):
    three, attempt, agrees = one_round(rng)
    title = f"Round {number}: {is_ground[three].sum()} of 3 on the ground, {agrees.sum():,} inliers"
    plots.plane_model(street, attempt, agrees, limits=side, axes=axes, title=title)
    axes.plot(street[three, 0], street[three, 2], "s", color="black", markersize=7)
    axes.set_xlabel("x, forward (m)" if number == 4 else "")
    axes.get_legend().remove()
    axes.set_title(title, loc="left", fontsize=12, fontweight="bold", pad=6)

picks = rng.integers(len(street), size=(1_000_000, 3))
all_three.compare(100 * is_ground[picks].all(axis=1).mean(),
                  "Counted in a million picks. By formula: each point is ground with the "
                  f"probability w, so all three are with w x w x w = {is_ground.mean() ** 3:.0%}. "
                  "That is rare for one round, and common among fifty.")

# %% [markdown]
# A sample that touches a car gives a plane that cuts through the street at an odd angle and has few inliers. As soon as all three points are ground and lie well apart, the count jumps. So: play many rounds, and keep the plane with the most inliers. Nothing about roads goes into it, only one assumption: the ground is the largest plane there is.
#
# ## Exercise 3 · `ransac_plane` (points)
#
# Return the best plane and the mask of its inliers. A sample may lie on one line (`plane_through` says `None`): skip it, and count the round. With fewer than three points there is no sample.

# %% nbgrader={"grade": false, "grade_id": "ransac_plane", "locked": false, "schema_version": 3, "solution": true, "task": false}
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    """Find the plane with the most points near it.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity, which does not count.
    max_iterations : int
        Number of rounds; the sample of each is three different rows.
    distance_tolerance : float
        Threshold: the largest distance of an inlier from the plane in metres.
    rng : numpy.random.Generator or int
        Generator or int seed; pass it through np.random.default_rng(rng).

    Returns
    -------
    model : tuple or array of four floats, or None
        (a, b, c, d) with a unit normal; None where no sample gave a plane.
    inliers : ndarray of bool, shape (n,)
        True where the distance from the model is at most distance_tolerance;
        all False where the model is None, as for fewer than three points.
    """
    # 1. The generator; no model so far, and a mask that is all False.
    # 2. Fewer than three points: that is the answer already.
    # 3. max_iterations times: three different rows, the plane through them (or the next round),
    #    the mask of the points near it. More inliers than the best so far? Keep both.
    # roughly 13 lines
    ### BEGIN SOLUTION
    rng = np.random.default_rng(rng)
    model, inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 3:
        return model, inliers
    for _ in range(max_iterations):
        sample = rng.choice(len(points), 3, replace=False)
        candidate = plane_through(*points[sample, :3])
        if candidate is None:
            continue
        close = point_plane_distance(points, candidate) <= distance_tolerance
        if np.count_nonzero(close) > np.count_nonzero(inliers):
            model, inliers = candidate, close
    return model, inliers
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# It is the loop of lesson 02 with three points in place of two. Before the loop: `rng = np.random.default_rng(rng)`, which takes a generator or a whole number, `model = None`, and `inliers = np.zeros(len(points), dtype=bool)`.
# </details>
# <details><summary>Hint 2</summary>
#
# A round: `i = rng.choice(len(points), 3, replace=False)`, then `plane_through(*points[i, :3])`; the star hands over the three rows as p, q and r. When it is None, `continue`.
# </details>
# <details><summary>Hint 3</summary>
#
# The end of a round: build the mask `point_plane_distance(...) <= distance_tolerance`. If its `np.count_nonzero(...)` beats that of the best mask, replace model **and** mask. A `.sum()` says the same, more slowly. After the loop return both, in this order.
# </details>

# %% [markdown]
# **A small case first.** Seven points: five on a floor at z = −1.7 m, two above it. Sixty rounds with a threshold of 0.1 m. Expected: the plane $(0, 0, 1, 1.7)$ or its negative, and a mask of five times `True`, then twice `False`.

# %%
seven = np.array([[0.0, 0.0, -1.7], [4.0, 0.0, -1.7], [1.0, 3.0, -1.7],
                  [5.0, 4.0, -1.7], [2.0, 5.0, -1.7],
                  [1.5, 1.0, -0.2], [3.0, 2.0, 0.5]])
model, inliers = ransac_plane(seven, 60, 0.1, 1)
print("plane:", np.asarray(model), "\nmask: ", inliers)
plots.plane_model(seven, model, inliers, 0.1, limits=((-1, 6), (-2.3, 1)), title="Five of seven");

# %% [markdown]
# **Look before you check.** Now the street. The band should hold the ground from end to end, and little of the cars above it.

# %%
model, inliers = ransac_plane(street, 50, 0.2, np.random.default_rng(1))
print("plane:", np.round(model, 3))
plots.plane_model(street, model, inliers, 0.2, limits=side, title="Found by your ransac_plane");

# %%
from utils.scene3d import Scene

inliers = np.asarray(inliers)
(Scene("The same in space: green the ground, orange what is left")
 .add_plane(street[inliers], model).add_obstacles(street[~inliers]).show())

# %% nbgrader={"grade": true, "grade_id": "test_ransac_plane", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(ransac_plane)

# %% [markdown]
# **Your run, round by round.** *Your* function on a street of 64 points: a road, a car on it, a house front beside it. Where a round is wrong, the player begins there and says why.

# %%
replay(ransac_plane)

# %% [markdown]
# ## Play: how thick is the ground?
#
# *Too thin a band loses ground, too thick a band swallows wheels, feet and whole bonnets.*

# %%
def shares(near):
    """What of the ground and what of all the rest a mask holds, in words."""
    return (f"{near[is_ground].mean():.0%} of the ground, {near[~is_ground].mean():.0%} of the rest")


@interact(threshold=FloatSlider(value=0.2, min=0.02, max=0.8, step=0.02,
                                description="threshold", continuous_update=False))
def show_threshold(threshold):
    found, near = ransac_plane(street, 50, threshold, 1)
    plots.plane_model(street, found, near, threshold, limits=side,
                      title=f"Within {threshold:.2f} m: {shares(near)}")
    plt.show()

# %% [markdown]
# The same without a slider: what is *not* within the threshold, from above.

# %% tags=["folded"]
# @title Draws what is left with three thresholds (you need not read this)
figure, panels = plt.subplots(3, 1, figsize=(8.5, 8), layout="compressed")
for threshold, axes in zip((0.03, 0.2, 0.8), panels):
    found, near = ransac_plane(street, 50, threshold, 1)
    plots.from_above(street[~near], limits=((-10, 30), (-5, 5)), axes=axes,
                     title=f"Left with {threshold} m. Gone: {shares(near)}")
    print(f"threshold {threshold} m: the plane rises by {-100 * found[0] / found[2]:.1f} %")

# %% [markdown]
# The street was built with a slope of 2.2 %, with a crown in the middle and with kerbs.
#
# - **0.03 m:** more than a third of the ground is left, as if obstacles lay there, and noise is not the reason: a crowned road leaves the best plane by several centimetres, to both sides.
# - **0.2 m:** the ground is gone, and the obstacles have lost only their lowest part.
# - **0.8 m:** most of what stands there is gone, too. More inliers are to be had by cutting through the cars than by lying in the road, so the plane tilts: look at its slope.

# %% [markdown]
# ## When the wall wins
#
# *RANSAC finds the largest plane. Nothing in it says that it must be the ground.*
#
# Beside the street stands a house. In the next picture RANSAC gets only the right-hand pavement and the house front.

# %%
x, y = cloud[:, 0], cloud[:, 1]
beside = cloud[(x > -1) & (x < 13) & (y > -8.6) & (y < -4)][::3]
won, near = ransac_plane(beside, 100, 0.2, 1)
plots.plane_model(beside, won, near, 0.2, view="above", limits=((-2, 14), (-9, -3.5)),
                  title=f"From above: a wall, normal ({won[0]:z.1f}, {won[1]:z.1f}, {won[2]:z.1f})");

# %% [markdown]
# The house front holds more points than the pavement, so it wins, and by the rules. The normal gives it away: that of the ground points up or down, $|c|$ near 1; that of a wall lies flat, $|c|$ near 0. Three cures, which may be combined:
#
# - look only where ground can be (the region of interest of lesson 07),
# - refuse every plane of a sample whose normal is far from vertical, before you count its inliers,
# - take the largest plane away and search the rest: that finds wall after wall, and then the ground.

# %% [markdown]
# **A good place to stop.** You can find the ground, and you know how the search is fooled. The second half sharpens the plane and asks how often the search succeeds. If you come back to it later, run all cells above this one first: in JupyterLab with *Run*, *Run All Above Selected Cell*, in Colab with *Runtime*, *Run before*.

# %% [markdown]
# ## Refit: let all inliers speak
#
# *Three points find the ground; thousands describe it.*
#
# RANSAC's plane goes exactly through three noisy points. If they lie half a metre apart, a centimetre of noise becomes a degree of tilt. But now we know the inliers, and nearly all obstacles are gone. Least squares, which failed on all points, is the right tool for these: it lets thousands of points average out their noise.
#
# The street was built with a slope of 2.2 %. In a moment you run your RANSAC with thirty different seeds and measure the slope of each plane, before and after a least-squares fit to its inliers.

# %%
calmer = predict("After the fit to all inliers, how do the thirty slopes scatter?",
                 choices=["less, and around the true slope",
                          "less, but to one side of it",
                          "as much as before"])

# %% [markdown]
# ## The plane with the smallest squares
#
# *The best normal is the direction in which the points spread least.*
#
# Which plane makes the sum of squared distances smallest? Two questions: where does it lie, and which way does it face?
#
# **Where.** Keep the normal $n$ fixed. Along it, each point is at the position $n \cdot p$, and the plane at one single position. The position that has the smallest sum of squared differences to many numbers is their mean. So the best plane goes through the mean of the points, whatever its normal is. Subtract the mean from all points, and $d$ is out of the way.
#
# **Which way.** A centred point $q$ is $|n \cdot q|$ away from the plane. So the sum of the squared distances is
#
# $$S(n) = \textstyle\sum (n \cdot q)^2 ,$$
#
# and this says how far the points reach along $n$: their *spread* in this direction. A road spreads far along itself, and hardly at all upwards. The best normal is the direction of least spread. Here are twelve points of a slope, seen from the side, and $S$ for every direction from 0 to 180 degrees: the *first* direction has the largest sum of squares, the *last* one the smallest.

# %% tags=["folded"]
# @title Draws the spread in every direction (you need not read this)
along = np.linspace(-3, 3, 12)
heights = 0.3 * along + 0.25 * np.tile([1, -1, 0.5, -0.5], 3)
section = np.column_stack([along, heights]) - [along.mean(), heights.mean()]
first, last = np.linalg.svd(section, full_matrices=False)[2]
angles = np.arange(181)
directions = np.column_stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])
spread = ((section @ directions.T) ** 2).sum(axis=0)

figure, (seen, curve) = plt.subplots(2, 1, figsize=(8.5, 7), layout="compressed")
plots.line_model(section, [*last, 0], limits=((-5, 5), (-2.2, 2.2)), axes=seen,
                 title="Twelve points and the line with the smallest squares")
seen.set(xlabel="x, forward (m)", ylabel="z, up (m)")
for name, direction, length in (("first", first * np.sign(first[0]), 2.0),
                                ("last", last * np.sign(last[1]), 1.4)):
    seen.annotate("", length * direction, (0, 0), arrowprops={"arrowstyle": "->", "lw": 2})
    seen.text(*(length * direction + [0.45, -0.1]), name, ha="left", va="center", fontsize=11)
marks = {name: (np.degrees(np.arctan2(*direction[::-1])) % 180, ((section @ direction) ** 2).sum())
         for name, direction in (("first", first), ("last", last))}
plots.curves({"sum of squares along this direction": (angles, spread)},
             {f"{name} direction": ([angle], [value]) for name, (angle, value) in marks.items()},
             across="direction (degrees): 0 is forward, 90 is up", up="S (m²)", axes=curve,
             title="The sum of squares in every direction");

# %% [markdown]
# **How to find it in space.** The *singular value decomposition* gives three directions $v_1, v_2, v_3$, perpendicular to each other, sorted from the most to the least spread, and for each a singular value $s_k$ with $S(v_k) = s_k^2$. No direction between them is better than the last one: so $n = v_3$. (*If you want more* has the proof, in five lines.)
#
# Four points of a rough floor, 4 m long and 2 m wide, up to 10 cm too high or too low:

# %%
floor = np.array([[0.0, 0.0, -1.6], [4.0, 0.0, -1.8], [0.0, 2.0, -1.8], [4.0, 2.0, -1.6]])
from_mean = floor - floor.mean(axis=0)
_, singular, directions = np.linalg.svd(from_mean, full_matrices=False)
for value, direction in zip(singular, directions):
    squares = ((from_mean @ direction) ** 2).sum()
    print(f"along {np.abs(direction.round(2))}: sum of squares {squares:.2f} = {value:.2f}²")

# %% [markdown]
# `full_matrices=False` matters: without it, NumPy builds an n x n matrix as well, and for 50,000 points that is 20 gigabytes.
#
# ## Exercise 4 · `fit_plane` (points)
#
# The plane with the smallest sum of squared distances, for any direction: a wall is a plane, too.

# %% nbgrader={"grade": false, "grade_id": "fit_plane", "locked": false, "schema_version": 3, "solution": true, "task": false}
def fit_plane(points):
    """The least-squares plane of some points.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        At least three points that are not all on one line; the intensity does not count.

    Returns
    -------
    tuple or array of four floats
        (a, b, c, d) with a unit normal (a, b, c) of either sign: the plane with the smallest
        sum of squared distances.
    """
    # 1. The mean of x, y and z, and the coordinates relative to it.
    # 2. Their singular value decomposition; the normal is the direction of least spread.
    # 3. d, so that the mean lies on the plane.
    # roughly 4 lines
    ### BEGIN SOLUTION
    centre = points[:, :3].mean(axis=0)
    by_spread = np.linalg.svd(points[:, :3] - centre, full_matrices=False)[2]
    least = by_spread[2]
    return (*least, -least @ centre)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Subtract the mean first. Without that, the first direction only points from the sensor to the cloud.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.linalg.svd(...)` returns three things; the third holds one direction per *row*, and the last row belongs to the smallest spread.
# </details>
# <details><summary>Hint 3</summary>
#
# With `centre = points[:, :3].mean(axis=0)` and the last row as `normal`: return `(*normal, d)` with `d = -(normal @ centre)`. The rows have length 1 already.
# </details>

# %% [markdown]
# **A small case first.** The rough floor from above: its mean is at z = −1.7 m, and what is too high and too low cancels out. Expected: $(0, 0, 1, 1.7)$ or its negative.

# %%
print(np.round(fit_plane(floor), 2))

# %% [markdown]
# **Look before you check.** Thirty runs of RANSAC, each with its own seed, and the slope of the plane: that of three points; that of the least-squares plane of all inliers; and that of a second fit, to the points within 0.1 m of the first one.

# %%
BUILT = 2.2  # per cent


def slope_of(plane):
    """How much a plane rises per metre forward, in per cent."""
    return -100 * plane[0] / plane[2]


def slopes_of(seeds):
    """Slopes of RANSAC's planes of the street, one for each seed, and of what fits their inliers."""
    slopes = {"three points": [], "all inliers": [], "again, within 0.1 m": [],
              "inliers on the ground": []}
    for seed in seeds:
        found, near = ransac_plane(street, 50, 0.2, seed)
        refitted = fit_plane(street[near])
        again = fit_plane(street[point_plane_distance(street, refitted) <= 0.1])
        planes = (found, refitted, again, fit_plane(street[near & is_ground]))
        for values, one in zip(slopes.values(), planes):
            values.append(slope_of(one))
    return slopes

# %%
slopes = slopes_of(range(30))
for name, values in slopes.items():
    print(f"{name:>22}: {np.mean(values):.3f} ± {np.std(values):.3f} %")
print(f"{'as built':>22}: {BUILT:.3f} %")

# %% tags=["folded"]
# @title Draws the slopes (you need not read this)
shown = {name: (np.arange(30), slopes[name]) for name in list(slopes)[:3]}
built = {"as built": ([0, 29], [BUILT, BUILT])}
figure, panels = plt.subplots(2, 1, figsize=(8.5, 7.4), layout="compressed")
plots.curves(built, shown, up="slope of the street (%)", axes=panels[0],
             title="Refitting calms the plane")
plots.curves(built, shown, across="seed", up="slope of the street (%)", axes=panels[1],
             title="The same, closer: some of the triangles are outside")
panels[1].set_ylim(1.92, 2.24)
panels[1].get_legend().remove()

fitted, before = slopes["all inliers"], slopes["three points"]
off = abs(np.mean(fitted) - BUILT) > 3 * np.std(fitted) / len(fitted) ** 0.5
answer = ("as much as before" if np.std(fitted) > 0.5 * np.std(before)
          else "less, but to one side of it" if off
          else "less, and around the true slope")
calmer.compare(answer,
               "Averaging removes what differs from run to run. What is the same in every run "
               "stays: here wheels and bumpers that lie within the threshold. Most of them are "
               "behind us and lift the plane there, so that it climbs less.")

# %% nbgrader={"grade": true, "grade_id": "test_fit_plane", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(fit_plane)

# %% [markdown]
# Look where the symbols of "all inliers" lie: close together, and below "as built". An estimate can be precise and still be off, always to the same side: it is *biased*. (So are the planes of three points, in the mean by more than twice as much. Among so much scatter nobody sees it.) More points do not help against that. One has to find the cause.
#
# - **What should not be there.** The threshold also lets wheels and bumpers in. Most of those are behind us: they lift that end of the plane, and it climbs less. The last line of the table, "inliers on the ground", leaves them out with the help of the labels, and most of the error is gone. We have no labels on the road, but we can fit again with a smaller threshold, now that the plane is good enough for one: "again, within 0.1 m" does as well.
# - **What is not a plane.** A small error remains. The street has a crown and kerbs, and which parts of them we see changes along the way. No plane is quite right there.
#
# What does it matter? An error of 0.3 % in the slope, as with three points, is 9 cm at a distance of 30 m. The bias of the first fit is 2 cm there, that of the second 5 mm.
#
# ## How many rounds?
#
# *The number depends on the share of inliers, not on the number of points.*
#
# Let $w$ be the share of ground points. A sample of $s = 3$ points is good when all of it is ground: probability $w^s$. It is bad with probability $1 - w^s$, and $N$ rounds all have bad samples with probability $(1 - w^s)^N$. We want at least one good sample with the confidence $C$, such as 0.99:
#
# $$1 - (1 - w^s)^N \ge C \quad\Longleftrightarrow\quad N \ge \frac{\log(1 - C)}{\log(1 - w^s)} .$$
#
# The direction of the inequality turns because $\log(1 - w^s)$ is negative. Mind both ends: with $w = 1$ every sample is good and one is enough; with $w = 0$ no number is.
#
# ## Exercise 5 · `iterations_needed` (points)

# %% nbgrader={"grade": false, "grade_id": "iterations_needed", "locked": false, "schema_version": 3, "solution": true, "task": false}
def iterations_needed(inlier_ratio, sample_size, confidence):
    """How many rounds RANSAC needs.

    Parameters
    ----------
    inlier_ratio : float
        Share w of inliers among the points, from 0 to 1.
    sample_size : int
        Points in a sample, s: two for a line, three for a plane.
    confidence : float
        Wanted probability of at least one sample without outliers; above 0 and below 1.

    Returns
    -------
    int, or math.inf
        The smallest whole N with 1 - (1 - w^s)^N >= confidence; 1 for w = 1; math.inf for
        w = 0, where no number is enough.
    """
    # 1. The probability of a good sample.
    # 2. Both ends first: is it 1, is it 0?
    # 3. The quotient of the logarithms, rounded up.
    # roughly 6 lines
    ### BEGIN SOLUTION
    good_sample = inlier_ratio**sample_size
    if good_sample >= 1:
        return 1
    if good_sample <= 0:
        return math.inf
    return max(1, math.ceil(math.log(1 - confidence) / math.log1p(-good_sample)))
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `math.log` takes one number, `math.ceil` rounds up to a whole one.
# </details>
# <details><summary>Hint 2</summary>
#
# `math.log(0)` raises an error, and `math.log(1)` is 0, by which nobody can divide: both ends need an `if` of their own.
# </details>
# <details><summary>Hint 3</summary>
#
# With `good = inlier_ratio ** sample_size`: 1 if it is 1, `math.inf` if it is 0, else `math.ceil(math.log(1 - ...) / math.log1p(-good))`, and at least 1. `math.log1p(x)` is the logarithm of 1 + x, also where `good` is so small that `1 - good` is rounded to 1.
# </details>

# %% [markdown]
# **A case to do by hand.** You toss a coin and wait for heads: $w = 0.5$, $s = 1$. Three tosses bring it with probability $1 - 0.5^3 = 0.875$, four with $1 - 0.5^4 = 0.9375$. So for a confidence of 0.9 the answer is 4.

# %%
print("tosses of a coin:", iterations_needed(0.5, 1, 0.9))

# %% [markdown]
# **Look before you check.** Both columns should fall to 1, and a plane should need at least as many rounds as a line.

# %%
show_table(["share of inliers", "a line", "a plane"],
           [(w, *(iterations_needed(w, size, 0.99) for size in (2, 3)))
            for w in (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1)])

# %% nbgrader={"grade": true, "grade_id": "test_iterations_needed", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(iterations_needed)

# %% [markdown]
# ## Theory against practice: how often do you find the ground?
#
# *The formula counts samples without outliers. It does not ask whether the ground is a plane.*
#
# Your `ransac_plane` searches 700 points of the street in 1, 2, 4, ... rounds, a hundred times each. The labels say what is ground, and a run is a success when its inliers hold nine tenths of it. A second cloud reaches 20 m to all sides and holds the house fronts and trees as well, so its share of ground is smaller.

# %%
def success_rate(points, rounds, ground):
    """Share of a hundred runs that find nine tenths of the ground points."""
    masks = [ransac_plane(points, rounds, 0.2, seed)[1] for seed in range(100)]
    return np.mean([(near & ground).sum() >= 0.9 * ground.sum() for near in masks])

# %%
rng = np.random.default_rng(2)
wide = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 20)
searched, theory, measured = {}, {}, {}
numbers = np.array([1, 2, 4, 8, 16, 32, 64])
steps = np.geomspace(1, 64, 100)
for name, place in {"the street": rows, "with house fronts": wide}.items():
    few = rng.choice(place, 700, replace=False)
    points, on_ground = cloud[few], truth["classes"][few] == names.index("ground")
    w = on_ground.mean()
    label = f"{name}, w = {w:.2f}"
    searched[label] = points, on_ground
    theory[label] = (steps, 1 - (1 - w**3) ** steps)
    measured[label] = (numbers, [success_rate(points, int(n), on_ground) for n in numbers])
axes = plots.curves(theory, measured, across="rounds", up="share of successful runs",
                    title="Your success rate against the formula")
axes.set_xscale("log", base=2)
axes.set_xticks(numbers, numbers);

# %% [markdown]
# With house fronts every measurement falls short of the formula, and on the street some do. The formula counts samples without outliers. It does not ask whether their planes are any good, and for two reasons some are not.
#
# - **Noise.** Where three points lie close together or nearly in a line, a little noise tilts their plane so much that it loses the far ground.
# - **The model.** A real ground is not one plane: it has a crown, kerbs and pavements. Three good points, one of them on a pavement, make a plane that fits nothing.
#
# Between the house fronts two good samples in three fail, most of them for the second reason. *If you want more* presses the ground flat and counts. More rounds help against both: in practice one plays two or three times as many as the formula says. That is still few, and they would be as few for a million points.

# %% [markdown]
# ## Common mistakes
#
# *Most of them give a plane, only not this one.*
#
# | what was written | what you see |
# |---|---|
# | the normal is not divided by its length | the band is far too thin: a large triangle has a long normal |
# | no `np.abs` | everything on one side of the plane counts as an inlier, however far |
# | `d` with the wrong sign | a plane as far above the sensor as the ground is below |
# | the last sample wins, not the best | another plane in each run |
# | no test for `None` | an error, once in many runs |
# | `points @ plane` with four columns | inliers that depend on brightness |

# %% tags=["folded"]
# @title Draws the first three mistakes (you need not read this)
_, near = ransac_plane(street, 50, 0.2, 1)
refitted = np.array(fit_plane(street[near]))
upward = refitted * np.sign(refitted[2])  # its normal points up
height = street[:, :3] @ upward[:3] + upward[3]
mirrored = upward * [1, 1, 1, -1]
wrong = {"not divided by its length, from a triangle of 4 m²": (upward, np.abs(8 * height) < 0.2),
         "no abs, and a normal that points down": (upward, -height < 0.2),
         "d with the wrong sign": (mirrored, np.abs(height + 2 * mirrored[3]) < 0.2)}
figure, panels = plt.subplots(3, 1, figsize=(8.5, 8), layout="compressed")
for (name, (plane, mask)), axes in zip(wrong.items(), panels):
    plots.plane_model(street, plane, mask, 0.2, limits=((-10, 30), (-2.6, 2.4)),
                      title=name, axes=axes)

# %% [markdown]
# ## In practice
#
# Open3D has the search in one call. Its parameters are yours; it gives back the four numbers and the rows of the inliers:
#
# ```python
# points = open3d.utility.Vector3dVector(street[:, :3])
# plane, rows = open3d.geometry.PointCloud(points).segment_plane(
#     distance_threshold=0.2, ransac_n=3, num_iterations=50)
# ```
#
# - The frame before is the best guess for this one: a car tries its last ground plane first. *Ten frames of a drive*, below, shows how much of the ground that already holds.
# - Libraries stop as soon as the inliers found so far make more rounds pointless: they call `iterations_needed` in the loop, with the best share so far.
# - Samples need not be uniform. Points of the lower beams are ground more often, and three points far apart make a better plane.
# - Large areas take several planes, one for each piece of road, or a grid of heights: far away a street bends, and the farther you look, the less one plane is enough.
#
# ## Summary
#
# - A plane is a unit normal and an offset; the sign is free, the length is not.
# - RANSAC finds the largest agreement. The share of inliers decides how many rounds it takes, the number of points does not.
# - Look at the normal: the largest plane may be a wall.
# - Refit with all inliers. That removes scatter, but not all of the bias: what is wrongly inside the threshold stays wrong.
#
# **Sources.** RANSAC: [Fischler and Bolles 1981](https://doi.org/10.1145/358669.358692). MSAC: [Torr and Zisserman 2000](https://doi.org/10.1006/cviu.1999.0832). Least-squares planes by SVD: [Shakarji 1998](https://doi.org/10.6028/jres.103.043). The loop in a library: [PCL, planar segmentation](https://pcl.readthedocs.io/projects/tutorials/en/latest/planar_segmentation.html), [Open3D, plane segmentation](https://www.open3d.org/docs/release/tutorial/geometry/pointcloud.html#Plane-segmentation).
#
# **Next:** 04 · The kd-tree

# %% [markdown]
# ## If you want more
#
# 1. Stop early: put `iterations_needed` into `ransac_plane`. How many rounds does the street need on average?
# 2. Refuse samples whose plane is not nearly level, by its normal, before you count inliers. How much time does it save? Does the lorry still win?
# 3. MSAC sums up the squared distances, cut off at the threshold, instead of counting. Is its plane better before the refit?

# %% [markdown]
# ### Noise, or the model?
#
# Why do good samples fail? Look at them one by one. Are all three points on the ground? And does their plane hold nine tenths of it? Then the same for a street that is not real: its ground is pressed flat, and nothing is left but 2 cm of noise.

# %%
def good_samples(points, ground):
    """Shares of 2,000 samples: all three on the ground; of these, a success; of all, a success."""
    rng = np.random.default_rng(3)
    pure, success = np.zeros((2, 2000), dtype=bool)
    for number in range(2000):
        three = rng.choice(len(points), size=3, replace=False)
        plane = plane_through(*points[three, :3])
        near = plane is not None and point_plane_distance(points, plane) <= 0.2
        pure[number] = ground[three].all()
        success[number] = (near & ground).sum() >= 0.9 * ground.sum()
    return pure.mean(), success[pure].mean(), success.mean()

# %%
def flattened(points, ground):
    """The same points, the ground laid into its own least-squares plane, but for 2 cm of noise."""
    table = np.column_stack([points[:, :2], np.ones(len(points))])
    level = table @ np.linalg.lstsq(table[ground], points[ground, 2], rcond=None)[0]
    flat = points.copy()
    flat[ground, 2] = (level + np.random.default_rng(4).normal(0, 0.02, len(points)))[ground]
    return flat

# %%
for label, (points, on_ground) in searched.items():
    pure, kept, chance = good_samples(points, on_ground)
    _, kept_if_flat, _ = good_samples(flattened(points, on_ground), on_ground)
    print(f"{label}: {pure:.0%} of the samples lie on the ground.")
    print(f"    {kept:.0%} of these hold nine tenths of it; with a flat ground, {kept_if_flat:.0%}")
    print(f"    rounds for 99 %: {iterations_needed(on_ground.mean(), 3, 0.99)} by the formula, "
          f"{iterations_needed(chance, 1, 0.99)} with the measured chance of a sample")

# %% [markdown]
# - **Noise.** It tilts small triangles on a flat ground, too: there one sample in four or five fails.
# - **The model.** Around us nine tenths of the ground lie between 9 cm below the best plane and 13 cm above. Between the house fronts two samples in three fail, and pressing the ground flat saves most of them. On the street alone, which has hardly any pavement, it saves few. A better model helps more than rounds do, such as a plane for each piece of road.

# %% [markdown]
# ### Plane or level?
#
# *A level is one number for the whole street; a plane climbs with it.*
#
# The simplest way to remove ground is to cut the cloud at one height, as lesson 06 does: everything below $z = -1.2$ m goes. Compare that with your plane, for every possible height of the cut.
#
# There are two errors: ground that stays becomes a ghost obstacle, and obstacle that goes becomes a blind spot.

# %%
is_obstacle = ~np.isin(kinds, [names.index(name) for name in ("ground", "invalid", "ego")])
heights = {"one level": street[:, 2], "your plane": height}
errors = {}
for name, height in heights.items():
    cuts = np.linspace(np.median(height[is_ground]), height[is_ground].max() + 0.3, 80)
    errors[name] = (100 * np.array([(height[is_obstacle] < cut).mean() for cut in cuts]),
                    100 * np.array([(height[is_ground] >= cut).mean() for cut in cuts]))
axes = plots.curves(errors, across="obstacle points that go (%)", up="ground points that stay (%)",
                    title="The two errors, for every height of the cut")
axes.set_ylim(-1, 30)
for name, cut, marker in (("one level", -1.2, "o"), ("your plane", 0.2, "s")):
    lost, left = (heights[name][is_obstacle] < cut).mean(), (heights[name][is_ground] >= cut).mean()
    axes.plot(100 * lost, 100 * left, marker, color="black", label=f"{name}, cut at {cut} m")
    print(f"{name}, cut at {cut} m: {lost:.1%} of the obstacle points go, "
          f"{left:.2%} of the ground stays")
    for where, part in (("behind us", street[:, 0] < 0), ("ahead of us", street[:, 0] >= 0)):
        print(f"    {where} {(heights[name][is_obstacle & part] < cut).mean():.1%} "
              "of the obstacle points go")
axes.legend();

# %% [markdown]
# Both get rid of the ground. But the street climbs: the level must lie above the highest ground in sight, and so it cuts deep into everything downhill, behind us. The plane can cut close everywhere. The price is work, 50 rounds with about eight operations for each point, and a new way to fail: a level never mistakes a wall for the ground.

# %% [markdown]
# ### Ten frames of a drive
#
# *A single scan can be lucky. A drive shows when the method fails.*
#
# In a drive a wall may win at any time. The third cure needs no change to your function: take the largest plane away and search the rest. After ten planes it gives up: a loop that waits for luck needs an end.

# %%
def ground_plane(points, rounds=100, threshold=0.2, seed=1):
    """The largest plane whose normal points up or down, and the rows of its inliers."""
    left = np.arange(len(points))
    for _ in range(10):
        plane, near = ransac_plane(points[left], rounds, threshold, seed)
        if plane is None or abs(plane[2]) > 0.9:
            return plane, left[near]
        left = left[~near]  # not ground: take it away, and search the rest
    return None, left[:0]


ground, found = ground_plane(beside)
near = np.isin(np.arange(len(beside)), found)
plots.plane_model(beside, ground, near, 0.2, limits=((-2, 14), (-2.6, 1.2)),
                  title="From the side: the largest plane whose normal points up");

# %% [markdown]
# Until now you had one scan. A car has ten [frames](#Words-of-the-course) a second. We drive for three seconds at 5 m/s through another street, which climbs by 2.2 %, too, and take every third frame: the same piece of street around the car, the number of rounds from your formula for a share of 0.3, a search, a refit. Making the frames takes some seconds.

# %%
won_by_ground = predict("In how many of the ten frames is the largest plane the ground?",
                        between=(0, 10))

# %%
def open_drive(source):
    """The frames of a drive; each has a cloud."""
    from utils import fetch_recording
    from utils.scenes import city_block

    return city_block(frames=30) if source == "simulated" else fetch_recording(source)


def around_us(cloud):
    """The street around the car: every eighth return."""
    return cloud[(cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)][::8]


def drive(source):
    """For every third frame: |c| of the largest plane; of the ground plane its share, its slope, the
    sensor's height above it, and how many points are near that of the frame before, compared."""
    rounds, frames, before, lines = iterations_needed(0.3, 3, 0.99), open_drive(source), None, []
    for number in range(0, len(frames), 3):
        points = around_us(frames[number].cloud)
        largest, _ = ransac_plane(points, rounds, 0.2, 1)
        plane, found = ground_plane(points, rounds)
        plane = fit_plane(points[found])
        height = abs(plane[3] / plane[2])  # at x = y = 0, below the sensor
        near, near_before = ((point_plane_distance(points, one) <= 0.2).sum()
                             for one in (plane, plane if before is None else before))
        still = math.nan if before is None else near_before / near
        lines.append((number, abs(largest[2]), len(found) / len(points), slope_of(plane),
                      height, still))
        before = plane
    return lines

# %%
SOURCE = "simulated"  # "udacity_city" fetches a real street instead: see below
lines = drive(SOURCE)
show_table(["frame", "|c| of the largest plane", "share of ground", "slope", "height of the sensor",
            "inliers of the plane before, compared with the new one"],
           [(number, f"{upright:.2f}", f"{part:.0%}", f"{slope:.2f} %", f"{height:.2f} m",
             "-" if math.isnan(still) else f"{still:.0%}")
            for number, upright, part, slope, height, still in lines])
won_by_ground.compare(sum(upright > 0.9 for _, upright, *_ in lines),
                      "Where |c| is near 0, the largest plane stands upright. The next picture "
                      "shows what it is. The search for the largest plane whose normal points up "
                      "finds the ground in those frames, too.")

# %% [markdown]
# Read the table. The sensor is mounted 1.73 m above the road, and the street climbs by 2.2 %: the plane finds both in every frame, from nothing but points. It is off by a centimetre and by a tenth of a per cent or so at most, in each frame in another way: scatter and bias again. The last column says how good the plane of 0.3 s ago still is.
#
# Here is the frame in which the ground did worst.

# %%
worst = min(lines, key=lambda line: line[1])[0]
points = around_us(open_drive(SOURCE)[worst].cloud)
largest, near = ransac_plane(points, 200, 0.2, 1)
figure, (above, aside) = plt.subplots(2, 1, figsize=(8.5, 7.4), layout="compressed")
plots.plane_model(points, largest, near, 0.2, view="above", limits=((-10, 30), (-6, 6)), axes=above,
                  title=f"Frame {worst}, from above: the largest plane has |c| = {abs(largest[2]):.2f}")
plots.plane_model(points, largest, near, limits=((-10, 30), (-2.6, 2.2)), axes=aside,
                  title="The same from the side")
low, high = np.percentile(points[near], [5, 95], axis=0)
middle = (low + high) / 2
plots.ring(aside, middle[0], middle[2], radius=0.6 * (high - low)[0]);

# %% [markdown]
# In the ring is the side of a lorry, which comes towards us and passes. It is so close that it fills more of the view than the ground does, and it hides the ground behind it. No number of rounds helps here: the search did what it was told. Looking at the normal helps.
#
# **A real street.** With a connection you can put `"udacity_city"` in the place of `"simulated"` and run the last cells again. That fetches 22 frames, about 40 MB, that the [KITTI project](https://www.cvlibs.net/datasets/kitti) recorded, under its own licence, which is shown first. Nobody knows the true slope there, but the height of the sensor is stated: 1.73 m. Do you find it?

# %% [markdown]
# ### Why the last direction wins
#
# The three directions of a singular value decomposition are chosen so that the points' positions along any two of them do not go up and down together: $\sum (v_1 \cdot q)(v_2 \cdot q) = 0$, and so on. Every unit normal is a mixture, $n = \alpha v_1 + \beta v_2 + \gamma v_3$ with $\alpha^2 + \beta^2 + \gamma^2 = 1$. Put it into $S$. All products of two different directions are zero, and what remains is
#
# $$S(n) = \alpha^2 s_1^2 + \beta^2 s_2^2 + \gamma^2 s_3^2 :$$
#
# an average of the three spreads, with weights that add up to 1. An average is never smaller than its smallest number, and it gets there by giving all the weight to it: $\gamma = 1$, so $n = v_3$. The last direction wins.

# %% [markdown] tags=["footer"]
# (footer)
