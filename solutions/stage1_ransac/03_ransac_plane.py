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
# # 03 · The road as a plane
#
# ![A street seen from the side. A line runs through a band of dark road points and rises gently to the right; pale points of cars, people and trees stand above it.](pictures/03_preview.png)
#
# A street is full of things, and one of them is flat: the road. Find that plane, and whatever sticks out of it is an obstacle. Nobody has to tell the car how high its sensor is mounted, or whether the street climbs.
#
# **After this lesson you can**
# - describe a plane by four numbers and measure distances from it,
# - find the road among cars, walls and people with RANSAC, and say how many iterations that takes,
# - sharpen the result, and notice when a wall has won.
#
# **You write** `plane_through` (5 points), `point_plane_distance` (10 points), `ransac_plane` (25 points), `fit_plane` (5 points) and `iterations_needed` (5 points). **Time:** about 60 minutes. **You need** the idea of RANSAC from lesson 02.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## A street, and the one flat thing in it
#
# *From the side, the road is the only thing that looks like a line.*
#
# We take the street around the car from the scan in `cloud.txt`: x forward, y left, z up in metres, the sensor at the origin, then intensity. Every fourth return is enough.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots

cloud = load_cloud("cloud.txt")
nearby = (cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)
rows = np.flatnonzero(nearby)[::4]
street = cloud[rows]
side = ((-10, 30), (-2.6, 1.2))
print(f"{len(street):,} of {len(cloud):,} returns")
plots.from_side(street, limits=side, title="The street around the car, from the side");

# %% [markdown]
# **Predict first.** Look at the picture: which share of these points is road? Now close your eyes and pick three points at random. How likely is it that all three lie on the road? Write both numbers down.

# %% [markdown]
# ## The naive idea: the best plane for all points
#
# *Least squares is fair to every point, and obstacles are points, too.*
#
# At school you learn to put a line through a cloud of measurements: make the sum of the squared errors as small as possible. The same works for a plane $z = ax + by + c$. Let us give it all points.

# %%
table = np.column_stack([street[:, :2], np.ones(len(street))])
a, b, c = np.linalg.lstsq(table, street[:, 2], rcond=None)[0]
fair = np.array([a, b, -1.0, c])  # z = a x + b y + c, written as a x + b y - z + c = 0
plots.plane_model(street, fair, limits=side, title="The fairest plane of all is nobody's plane");

# %% [markdown]
# The plane floats above the road, because every car, wall and tree pulls it upwards. It lies where nothing is. A better tool must not be fair: it must find the points that agree, and ignore the rest.
#
# That is RANSAC, which you met in lesson 02 with lines. For planes we need two tools first: a plane through three points, and distances from it.

# %% [markdown]
# ## The idea: three points, one plane
#
# *A plane is a direction perpendicular to it, and a distance.*
#
# All points $(x, y, z)$ with
#
# $$a x + b y + c z + d = 0$$
#
# form a plane. The vector $n = (a, b, c)$ is perpendicular to it: the *normal*. Given three points $p, q, r$, the two sides $q - p$ and $r - p$ lie in the plane, and their cross product is perpendicular to both:
#
# $$n = (q - p) \times (r - p), \qquad d = -\, n \cdot p .$$
#
# Two details decide whether this works on the road.
#
# - **Length.** Four numbers and their doubles, $(2a, 2b, 2c, 2d)$, describe the same plane. We divide by the length of $n$, so that $n$ has length 1. Then $a x + b y + c z + d$ is a distance in metres.
# - **Points on one line.** They do not fix a plane: it can turn about the line. Their cross product is $(0, 0, 0)$, and dividing by its length gives `nan`. Measured points hardly ever do that exactly, but three returns of one ring nearly do: then noise decides where their plane points.
#
# The sign stays free: $(a, b, c, d)$ and $(-a, -b, -c, -d)$ are the same plane, seen from its two sides.

# %%
u, v = np.array([2.0, 0.0, 0.0]), np.array([1.0, 3.0, 0.0])
print("u x v =", np.cross(u, v), "  length:", np.linalg.norm(np.cross(u, v)))
print("v x u =", np.cross(v, u), "  the other side")
print("u x 2u =", np.cross(u, 2 * u), "  one line, no plane")

# %% [markdown]
# ## Exercise 1 · `plane_through` (5 points)
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
# `np.cross(u, v)` is upright on u and v. The sides are `q - p` and `r - p`.
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
# **Look before you check.** Three returns of the road, far apart, and the plane through them. It should lie in the road, and the printed length should be 1.

# %%
corners = np.array([street[np.argmin(np.linalg.norm(street[:, :3] - place, axis=1)), :3]
                    for place in [(-8, 1, -1.9), (6, -1, -1.6), (16, 3, -1.4)]])
plane = plane_through(*corners)
print("plane:", np.round(plane, 3), "  length of the normal:", np.linalg.norm(plane[:3]).round(6))
print("on one line:", plane_through(*np.array([[0.0, 0, 0], [1, 1, 1], [3, 3, 3]])))
axes = plots.plane_model(street, plane, limits=side, title="A plane through three returns")
axes.plot(corners[:, 0], corners[:, 2], "s", color="black", markersize=8);

# %% nbgrader={"grade": true, "grade_id": "test_plane_through", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(plane_through)

# %% [markdown]
# ## Exercise 2 · `point_plane_distance` (10 points)
#
# *With a unit normal, putting a point into the equation gives its distance.*
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
# **Look before you check.** Colour is the distance from the plane above. The road should be dark along its whole length, though it climbs.

# %%
distances = point_plane_distance(street, plane)
plots.from_side(street, values=distances, label="distance from the plane (m)", limits=side,
                title="The road is dark, what stands on it is bright");

# %% nbgrader={"grade": true, "grade_id": "test_point_plane_distance", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(point_plane_distance)

# %% [markdown]
# ## RANSAC: let three random points speak for all
#
# *A plane through three road points collects the whole road; a plane through anything else collects little.*
#
# Draw three different points at random, put a plane through them, and count its *inliers*: the points within a tolerance. Four draws, with your own two functions:

# %%
rng = np.random.default_rng(20)
figure, panels = plt.subplots(2, 2, figsize=(8.5, 6.4), layout="compressed")
for axes in panels.flat:
    three = rng.choice(len(street), size=3, replace=False)
    attempt = plane_through(*street[three, :3])
    agrees = point_plane_distance(street, attempt) < 0.2
    plots.plane_model(street, attempt, agrees, limits=side, axes=axes)
    axes.plot(street[three, 0], street[three, 2], "s", color="black", markersize=7)

# %% [markdown]
# A draw that hits a car or a wall gives a plane that cuts through the street at an odd angle and has few inliers. As soon as all three points are road, the count jumps. So: draw often, and keep the plane with the most inliers. Nothing about roads goes into it, only this: the road is the largest plane there is.
#
# ## Exercise 3 · `ransac_plane` (25 points)
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
        Number of samples to try; each is three different rows.
    distance_tolerance : float
        Largest distance of an inlier from the plane in metres.
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
        if close.sum() > inliers.sum():
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
# The end of a round: build the mask `point_plane_distance(...) <= distance_tolerance`. If its `.sum()` beats that of the best mask, replace model **and** mask. After the loop return both, in this order.
# </details>

# %% [markdown]
# **Look before you check.** The band should hold the road from end to end, and little of the cars above it.

# %%
model, inliers = ransac_plane(street, 50, 0.2, np.random.default_rng(1))
print("plane:", np.round(model, 3))
plots.plane_model(street, model, inliers, 0.2, limits=side, title="Found by your ransac_plane");

# %%
from utils.scene3d import Scene

inliers = np.asarray(inliers)
(Scene("The same in space: green the plane, red what stands on it")
 .add_plane(street[inliers], model).add_obstacles(street[~inliers]).show())

# %% nbgrader={"grade": true, "grade_id": "test_ransac_plane", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(ransac_plane)

# %% [markdown]
# ## Play: how thick is a road?
#
# *Too thin a band loses the road, too thick a band swallows kerbs, wheels and feet.*

# %%
@interact(tolerance=FloatSlider(value=0.2, min=0.02, max=0.8, step=0.02,
                                description="tolerance", continuous_update=False))
def show_tolerance(tolerance):
    found, near = ransac_plane(street, 50, tolerance, 1)
    plots.plane_model(street, found, near, tolerance, limits=side,
                      title=f"{near.mean():.0%} of the points within {tolerance:.2f} m")
    plt.show()

# %% [markdown]
# The same without a slider, from above: what is *not* within the tolerance.

# %%
figure, panels = plt.subplots(3, 1, figsize=(8.5, 7.5), layout="compressed")
for tolerance, axes in zip((0.03, 0.2, 0.8), panels):
    _, near = ransac_plane(street, 50, tolerance, 1)
    plots.from_above(street[~near], limits=((-10, 30), (-5, 5)), axes=axes,
                     title=f"tolerance {tolerance} m: {(~near).sum():,} points are left")

# %% [markdown]
# At 0.03 m road points are thrown out, and not by noise: a road has a crown and kerbs, which leave the best plane by several centimetres. At 0.8 m the cars lose their lower halves, and the plane tilts to catch more of them. In between, each centimetre more brings a little more road and takes a little more of wheels and feet.

# %% [markdown]
# ## Refit: let all inliers speak
#
# *Three points find the road; thousands describe it.*
#
# The model goes exactly through three noisy points. If they lie close together, a centimetre of noise becomes a degree of tilt. But now we know the inliers, and the obstacles are gone. Least squares, which failed on all points, is the best tool for these.
#
# Which plane makes the sum of squared distances smallest? It passes through the mean of the points. Its normal is the direction in which the centred points spread least, and the *singular value decomposition* finds the directions of spread, sorted from most to least:

# %%
flat = np.array([[0.0, 0.0, 0.1], [4.0, 0.0, -0.1], [0.0, 2.0, -0.1], [4.0, 2.0, 0.1]])
_, spreads, directions = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)
for spread, direction in zip(spreads, directions):
    print(f"spread {spread:.2f} along {np.abs(direction.round(2))}")

# %% [markdown]
# `full_matrices=False` matters: without it, NumPy builds an n x n matrix as well, and for 50 000 points that is 20 gigabytes.
#
# ## Exercise 4 · `fit_plane` (5 points)
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
# **Look before you check.** This street was built with a slope of 2.2 %, and `utils.scenes` knows it. Thirty runs of RANSAC, each with its own seed: the slope before and after refitting.

# %%
from utils.scenes import ROAD


def slope_of(plane):
    """How much a plane rises per metre forward, in per cent."""
    return -100 * plane[0] / plane[2]


seeds = np.arange(30)
before, after = [], []
for seed in seeds:
    found, near = ransac_plane(street, 50, 0.2, int(seed))
    before.append(slope_of(found))
    after.append(slope_of(fit_plane(street[near])))
print(f"slope: {np.mean(before):.2f} ± {np.std(before):.2f} % before, "
      f"{np.mean(after):.2f} ± {np.std(after):.2f} % after refitting, {100 * ROAD.slope:.2f} % as built")
plots.curves({"as built": (seeds[[0, -1]], [100 * ROAD.slope] * 2)},
             {"three points": (seeds, before), "all inliers": (seeds, after)},
             across="seed", up="slope of the road (%)", title="Refitting calms the plane");

# %% nbgrader={"grade": true, "grade_id": "test_fit_plane", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(fit_plane)

# %% [markdown]
# Look where the squares lie. Refitting takes away the scatter, but not the whole error: nearly all of them are a little below "as built". The road has a crown and kerbs, and the best plane through those has not quite the slope of the road. An estimate can be precise and still be off, always to the same side: it is *biased*.
#
# ## How many iterations?
#
# *The number depends on the share of inliers, not on the number of points.*
#
# Let $w$ be the share of road points. A sample of $s = 3$ is good when all of it is road: probability $w^s$. It fails with $1 - w^s$, and $N$ samples all fail with $(1 - w^s)^N$. We want to be right with the confidence $C$, such as 0.99:
#
# $$1 - (1 - w^s)^N \ge C \quad\Longleftrightarrow\quad N \ge \frac{\log(1 - C)}{\log(1 - w^s)} .$$
#
# The direction of the inequality turns because $\log(1 - w^s)$ is negative. Mind both ends: with $w = 1$ every sample is good and one is enough; with $w = 0$ no number is.
#
# ## Exercise 5 · `iterations_needed` (5 points)

# %% nbgrader={"grade": false, "grade_id": "iterations_needed", "locked": false, "schema_version": 3, "solution": true, "task": false}
def iterations_needed(inlier_ratio, sample_size, confidence):
    """How many samples RANSAC needs.

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
# **Look before you check.** Each line of the table should fall to 1, and a plane should need more samples than a line.

# %%
print("share of inliers:", "".join(f"{w:>8.1f}" for w in (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1)))
for name, size in (("a line", 2), ("a plane", 3)):
    numbers = [iterations_needed(w, size, 0.99) for w in (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1)]
    print(f"{name:>16}:", "".join(f"{number:>8}" for number in numbers))

# %% nbgrader={"grade": true, "grade_id": "test_iterations_needed", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(iterations_needed)

# %% [markdown]
# ## Theory against practice: how often do you find the road?
#
# *The formula counts samples without outliers, but three road points close together make a poor plane, too.*
#
# We let your `ransac_plane` search the street with 1, 2, 4, ... samples, a hundred times each, and call a run a success when it collects nine tenths of the road. A second cloud holds the pavements, walls and trees as well, so its share of road is smaller.

# %%
def success_rate(points, iterations, road):
    """Share of a hundred runs that find nine tenths of the road points."""
    runs = [ransac_plane(points, iterations, 0.2, seed)[1] for seed in range(100)]
    return np.mean([(inliers & road).sum() >= 0.9 * road.sum() for inliers in runs])


rng = np.random.default_rng(2)
wide = cloud[np.hypot(cloud[:, 0], cloud[:, 1]) < 20]
theory, measured = {}, {}
numbers = np.array([1, 2, 4, 8, 16, 32, 64])
steps = np.geomspace(1, 64, 100)
for name, points in {"the street": street, "with walls and trees": wide}.items():
    few = points[rng.choice(len(points), 700, replace=False)]
    _, near = ransac_plane(few, 300, 0.15, 0)
    road = point_plane_distance(few, fit_plane(few[near])) < 0.15
    w = road.mean()
    label = f"{name}, w = {w:.2f}"
    theory[label] = (steps, 1 - (1 - w**3) ** steps)
    measured[label] = (numbers, [success_rate(few, int(n), road) for n in numbers])
    print(f"{label}: three of three with probability {w**3:.2f}, "
          f"{iterations_needed(w, 3, 0.99)} samples for 99 %")
axes = plots.curves(theory, measured, across="samples", up="share of successful runs",
                    title="Your success rate against the formula")
axes.set_xscale("log", base=2)
axes.set_xticks(numbers, numbers);

# %% [markdown]
# Compare $w$ and $w^3$ with what you predicted. Your measurements follow the curves from below: the formula is a promise about luck, not about noise. In practice one takes two or three times the number it gives. It is still small, and it would be the same for a million points.

# %% [markdown]
# ## When the wall wins
#
# *RANSAC finds the largest plane. Nobody said that it is the road.*
#
# Beside the street stands a house. In the next picture RANSAC gets only the right-hand pavement and the house front.

# %%
x, y = cloud[:, 0], cloud[:, 1]
beside = cloud[(x > -1) & (x < 13) & (y > -8.6) & (y < -4)][::3]
won, near = ransac_plane(beside, 100, 0.2, 1)
figure, (above, from_side) = plt.subplots(2, 1, figsize=(8.5, 6.4), layout="compressed")
plots.plane_model(beside, won, near, 0.2, view="above", limits=((-2, 14), (-9, -3.5)), axes=above,
                  title=f"From above: a wall, normal ({won[0]:.1f}, {won[1]:.1f}, {won[2]:.1f})")

rest, ground = beside, won
while abs(ground[2]) < 0.9:  # the normal of a road points up or down
    ground, near = ransac_plane(rest, 100, 0.2, 1)
    found, rest = rest, rest[~near]
plots.plane_model(found, ground, near, 0.2, limits=((-2, 14), (-2.6, 1.2)), axes=from_side,
                  title="From the side: the next plane whose normal points up");

# %% [markdown]
# The house front holds more points than the pavement, so it wins, and by the rules. The normal gives it away: that of a road points up or down, $|c|$ near 1; that of a wall lies flat, $|c|$ near 0. Three cures, which may be combined:
#
# - look only where a road can be (the region of interest of lesson 07),
# - accept only candidates whose normal is within some 15 degrees of the vertical,
# - take the largest plane away and search the rest, as above. That finds wall after wall, and the road.

# %% [markdown]
# ## Plane or level?
#
# *A level is one number for the whole street; a plane climbs with it.*
#
# The simplest way to remove a road is to cut the cloud at one height, as lesson 06 does: everything below $z = -1.2$ m is road. Compare that with your plane, for every possible height of the cut. For a *height above the plane* the sign matters, so we turn the normal upwards first.
#
# The scan was simulated, so we know which return is road. There are two errors: road that stays becomes a ghost obstacle, and obstacle that goes becomes a blind spot.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
kinds = truth["classes"][rows]
is_road = kinds == names.index("ground")
is_thing = ~np.isin(kinds, [names.index(name) for name in ("ground", "invalid", "ego")])

_, near = ransac_plane(street, 50, 0.2, 1)
refitted = np.array(fit_plane(street[near]))
road_up = refitted * np.sign(refitted[2])
heights = {"one level": street[:, 2], "your plane": street[:, :3] @ road_up[:3] + road_up[3]}
errors = {}
for name, height in heights.items():
    cuts = np.linspace(np.median(height[is_road]), height[is_road].max() + 0.3, 80)
    errors[name] = (100 * np.array([(height[is_thing] < cut).mean() for cut in cuts]),
                    100 * np.array([(height[is_road] >= cut).mean() for cut in cuts]))
axes = plots.curves(errors, across="obstacle points that go (%)", up="road points that stay (%)",
                    title="The two errors, for every height of the cut")
axes.set_ylim(-1, 30)
for name, cut, marker in (("one level", -1.2, "o"), ("your plane", 0.2, "s")):
    lost, left = (heights[name][is_thing] < cut).mean(), (heights[name][is_road] >= cut).mean()
    axes.plot(100 * lost, 100 * left, marker, color="black", label=f"{name}, cut at {cut} m")
    print(f"{name}, cut at {cut} m: {lost:.1%} of the obstacle points go, "
          f"{left:.2%} of the road stays")
axes.legend();

# %% [markdown]
# Both get rid of the road. But the level must keep a margin for the whole slope, and so it cuts off the lower half of everything downhill; the plane can cut close. The price is work, some hundred operations per point, and a new way to fail: a level never mistakes a wall for the road.
#
# Nor is a plane the last word. A street has a crown and kerbs, and far away it bends. The farther you look, the less one plane is enough.

# %% [markdown]
# ## Common mistakes
#
# *Most of them give a plane, only not this one.*
#
# | what was written | what you see |
# |---|---|
# | the normal is not divided by its length | the band is far too thin: a large triangle has a long normal |
# | no `np.abs` | everything on one side of the plane counts as an inlier, however far |
# | `d` with the wrong sign | a plane as far above the sensor as the road is below |
# | the last sample wins, not the best | another plane in each run |
# | no test for `None` | an error, once in many runs |
# | `points @ plane` with four columns | inliers that depend on brightness |

# %%
height = heights["your plane"]
mirrored = road_up * [1, 1, 1, -1]
wrong = {"not normalised, from a triangle of 4 m²": (road_up, np.abs(8 * height) < 0.2),
         "no abs, and a normal that points down": (road_up, -height < 0.2),
         "d with the wrong sign": (mirrored, np.abs(height + 2 * mirrored[3]) < 0.2)}
figure, panels = plt.subplots(3, 1, figsize=(8.5, 8), layout="compressed")
for (name, (plane, mask)), axes in zip(wrong.items(), panels):
    plots.plane_model(street, plane, mask, 0.2, limits=((-10, 30), (-2.6, 2.4)),
                      title=name, axes=axes)

# %% [markdown]
# ## In practice
#
# - The frame before is the best guess for this one: a car tries its last road plane first and needs a handful of samples.
# - Libraries stop as soon as the inliers found so far make more samples pointless: they call `iterations_needed` in the loop, with the best ratio so far.
# - Samples need not be uniform. Points of the lower beams are road more often, and three points far apart make a better plane.
# - Large areas take several planes, one for each piece of road, or a grid of heights.
#
# ## If you want more
#
# 1. Stop early: put `iterations_needed` into `ransac_plane`. How many samples does the street need on average?
# 2. Refuse candidates that are not road-like, by their normal, before you count inliers. How much time does it save?
# 3. MSAC sums up the squared distances, cut off at the tolerance, instead of counting. Is its plane better before the refit?
#
# ## Summary
#
# - A plane is a unit normal and an offset; the sign is free, the length is not.
# - RANSAC finds the largest agreement. The share of inliers decides how many samples it takes, the number of points does not.
# - Refit with all inliers, then look at the normal: the largest plane may be a wall.
#
# **Sources.** RANSAC: [Fischler and Bolles 1981](https://doi.org/10.1145/358669.358692). MSAC: [Torr and Zisserman 2000](https://doi.org/10.1006/cviu.1999.0832). Least-squares planes by SVD: [Shakarji 1998](https://doi.org/10.6028/jres.103.043). The loop in a library: [PCL, planar segmentation](https://pcl.readthedocs.io/projects/tutorials/en/latest/planar_segmentation.html).
#
# **Next:** 04 · The KD-tree

# %% [markdown] tags=["footer"]
# (footer)
