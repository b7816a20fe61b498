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
# ![A street seen from the side. A line runs through a band of dark road points and rises gently to the right. Above it are the pale points of cars, people and trees.](03_preview.png)
#
# A street is full of obstacles, but the road itself is nearly flat. Once you know the plane of the road, every point well above it belongs to an obstacle. This works for a sensor at any height, even if the street climbs.
#
# **After this lesson you can**
# - describe a plane by four numbers and measure distances from it,
# - find the ground among cars, walls and people with RANSAC, and notice when it has found a wall instead,
# - refine a plane, distinguish scatter from bias, and say how many rounds RANSAC needs.
#
# **You write** `plane_through` (points), `point_plane_distance` (points), `ransac_plane` (points), `fit_plane` (points) and `iterations_needed` (points). You may use any package listed at the end of this notebook. **You need** the idea of RANSAC from lesson 02. **Time:** (time), in four sittings of about 40, 40, 25 and 30 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## The road is the flat part of a street
#
# We use every eighth [return](#Words-of-the-course) from the street around the car, taken from the scan in `cloud.txt`. Its columns are x (forward), y (left) and z (up), in metres from the sensor, and intensity. The *ground*, which we want to find, is the road and the pavements together. A pavement is a raised path for pedestrians next to the road, and the step up to it is the *kerb*.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_street, plots, predict, replay, show_table

cloud, truth = load_street()  # `truth` says what each return hit
nearby = (cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)
rows = np.flatnonzero(nearby)[::8]
street = cloud[rows]
side = ((-10, 30), (-2.6, 1.2))
print(f"{len(street):,} of {len(cloud):,} returns")
plots.from_side(street, limits=side, title="The street around the car, from the side");

# %% [markdown]
# **Predict first.** Look at the picture and guess two numbers.

# %%
share = predict("What share of these points is on the ground?", between=(0, 100), unit="%")
all_three = predict("You pick three of these points at random. "
                    "How likely is it that all three are on the ground?",
                    between=(0, 100), unit="%")

# %% [markdown]
# The scan is simulated, so we know what each return hit. We use this truth only to judge our results.

# %% tags=["folded"]
# @title Read the truth and compare your guess (you need not read this)
names = truth["class_names"].tolist()
kinds = truth["classes"][rows]
is_ground = kinds == names.index("ground")
share.compare(100 * is_ground.mean(),
              "Most beams point down, so more than half of the points are on the ground. Most of the "
              "other points belong to cars, which are tall and close to the sensor.")

# %% [markdown]
# ## The naive idea: the best plane for all points
#
# You probably know how to fit a line to measurements: you make the sum of the squared errors as small as possible. This also works for a plane $z = \alpha x + \beta y + \gamma$. We fit one to all the points.

# %%
table = np.column_stack([street[:, :2], np.ones(len(street))])
alpha, beta, gamma = np.linalg.lstsq(table, street[:, 2], rcond=None)[0]
naive = np.array([alpha, beta, -1.0, gamma])  # the same as alpha x + beta y - z + gamma = 0
above = (table @ [alpha, beta, gamma] - street[:, 2])[is_ground]
print(f"The plane runs {np.median(above):.2f} m above the ground.")
print(f"Ground points within 0.2 m of it: {(np.abs(above) < 0.2).sum()} of {is_ground.sum():,}")
plots.plane_model(street, naive, limits=side,
                  title="Least squares with all points gives a plane in mid-air");

# %% [markdown]
# The plane floats above the ground, because every car pulls it upwards. Squaring the errors makes this worse, because a point 1 m away counts as much as a hundred points 10 cm away. A better method finds the points that agree with each other, and ignores the rest.
#
# In lesson 02, RANSAC did this for lines. For planes, it needs two tools: the plane through three points, and distances from a plane.

# %% [markdown]
# ## The idea: three points give a plane
#
# Think of a sheet of cardboard with a pencil glued upright to it. The direction of the pencil tells you how the sheet is turned, and one more number tells you how far away it is. The pencil is the *normal* $n = (a, b, c)$, and the number is $d$. A point $(x, y, z)$ is on the plane if
#
# $$a x + b y + c z + d = 0 .$$
#
# Take three points $p, q, r$ on the plane. The *cross product* of two sides of their triangle is perpendicular to both:
#
# $$n = (q - p) \times (r - p), \qquad d = -\, n \cdot p .$$

# %% tags=["folded"]
# @title Draw the cross product of two sides (you need not read this)
first, second, normal = np.array([[2.0, 0, 0], [1, 3, 0], [0, 0, 1]])
slant = np.array([[1, 0], [0.45, 0.35], [0, 1]])  # x to the right, y to the back, z up
figure, axes = plt.subplots(figsize=(8.5, 3.9), layout="compressed", facecolor="white")
sheet = np.array([0 * first, first, first + second, second])
axes.fill(*(sheet @ slant).T, color="#56B4E9", alpha=0.25)
for edge in (first, second):  # right angles between the normal and both sides
    step = 0.15 * edge / np.linalg.norm(edge)
    corner = np.array([step, step + 0.15 * normal, 0.15 * normal])
    axes.plot(*(corner @ slant).T, color="#57606A", lw=1)
for name, tip, colour, line in (("q", first, "#0072B2", "-"), ("r", second, "#0072B2", "-"),
                                ("n", normal, "#D55E00", "-"),
                                ("−n, the other side", -normal, "#D55E00", "--")):
    axes.annotate("", tip @ slant, (0, 0),
                  arrowprops={"arrowstyle": "-|>", "color": colour, "linestyle": line, "lw": 2})
    axes.text(*(tip @ slant + [0.1, 0.04]), name, fontsize=11)
axes.text(-0.2, -0.05, "p", fontsize=11)
axes.set(xlim=(-1.2, 5), ylim=(-1.1, 1.25), aspect="equal")
axes.set_title("The cross product of q − p and r − p is perpendicular to both", loc="left",
               fontsize=12, fontweight="bold", pad=6)
axes.set_axis_off()

# %% [markdown]
# Two details matter in practice.
#
# - **Length.** $(2a, 2b, 2c, 2d)$ describes the same plane. We divide $n$ by its length, which makes it a *unit normal*, with length 1. Then $a x + b y + c z + d$ is a distance in metres.
# - **Points on one line.** Such points do not determine a plane, because a plane through them can still turn about the line. Their cross product is $(0, 0, 0)$, and dividing it by its length gives `nan`. Rounding errors may leave a length of $10^{-17}$, so compare the length with a tiny number, not with 0. (In lesson 02, you could compare with 0, because the difference of two equal points is exactly 0.)
#
# The sign is up to you. $(a, b, c, d)$ and $(-a, -b, -c, -d)$ describe the same plane, seen from its two sides.

# %% [markdown]
# ## Exercise 1 · `plane_through` (points)
#
# Return the plane through three points, with a normal of length 1. Return `None` if the points are on one line.

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
        None if the points are on one line.
    """
    # 1. Compute the cross product of the sides from p to q and from p to r.
    # 2. Compute its length. If it is nearly zero, say below 1e-9, return None.
    # 3. Divide the cross product by its length, and choose d so that p is on the plane.
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
# `np.linalg.norm(normal)` is the length. Test it before you divide by it. After the division, compute $d = -(a x_p + b y_p + c z_p)$ with the new a, b and c.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `normal = np.cross(...)` and `length = ...`, then `if length < 1e-9: return None`. Divide the normal by its length, and return `(normal[0], normal[1], normal[2], -(normal @ ...))`.
# </details>

# %% [markdown]
# **A case to do by hand.** Three points of a level road are 1.7 m below the sensor. The cross product of the sides $(5, -3, 0)$ and $(2, 2, 0)$ is $(0, 0, 16)$, which points straight up. So the plane is $(0, 0, 1, 1.7)$, or all four numbers with the opposite sign (`-0.` equals 0). For three points on one line, the answer is `None`.

# %%
p, q, r = np.array([[4.0, 1.0, -1.7], [9.0, -2.0, -1.7], [6.0, 3.0, -1.7]])
print("a level road:", np.asarray(plane_through(p, q, r)))
print("on one line: ", plane_through(*np.array([[0.0, 0, 0], [1, 1, 1], [3, 3, 3]])))

# %% [markdown]
# **Look before you check.** The plane through three returns from the road should run along the road, and the printed length should be 1.

# %% tags=["folded"]
# @title Draw your plane through three returns (you need not read this)
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
# Imagine that you start on the plane and walk along the normal. Because $n$ has length 1, each metre adds exactly 1 to $a x + b y + c z + d$. On the plane, this sum is 0. At a point $p$, it is therefore the number of metres that you have walked. On the other side of the plane the sum is negative, so the distance is its absolute value:
#
# $$\text{distance}(p) = |\,a x_p + b y_p + c z_p + d\,|$$
#
# Be careful with the fourth column. NumPy does not complain if you multiply a cloud of shape (n, 4) by the four numbers of a plane. But then it also multiplies the intensity by $d$.

# %% nbgrader={"grade": false, "grade_id": "point_plane_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def point_plane_distance(points, plane):
    """Distance of each point from a plane.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity, which is not used.
    plane : tuple or array of four floats
        (a, b, c, d) with a unit normal (a, b, c).

    Returns
    -------
    ndarray, shape (n,)
        Distances in metres, never negative.
    """
    # 1. Multiply x, y and z of all points by the normal. This gives one number per point.
    # 2. Add d and take the absolute value.
    # roughly 2 lines
    ### BEGIN SOLUTION
    normal, offset = np.asarray(plane[:3]), plane[3]
    return np.abs(points[:, :3] @ normal + offset)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `a, b, c, d = plane` unpacks the four numbers. `points[:, 0]` is the column of x values.
# </details>
# <details><summary>Hint 2</summary>
#
# `a * points[:, 0] + b * points[:, 1] + ...` computes the sum for all points at once. `points[:, :3] @ normal` gives the same, but without d.
# </details>
# <details><summary>Hint 3</summary>
#
# One line is enough. Write `return np.abs(... + d)`, with the three products in place of the dots.
# </details>

# %% [markdown]
# **A case to do by hand.** For the level road $(0, 0, 1, 1.7)$, the distance is $|z + 1.7|$. The four points are on the road, on a kerb, on a car's roof and at the bottom of a pothole. Their distances are 0, 0.13, 1.5 and 0.1. The pothole is 10 cm *below* the plane, but its distance is positive.

# %%
four = np.array([[5.0, 2.0, -1.7, 0.3], [6.0, 4.0, -1.57, 0.3],
                 [9.0, 0.0, -0.2, 0.8], [7.0, 1.0, -1.8, 0.2]])
print(np.round(point_plane_distance(four, (0.0, 0.0, 1.0, 1.7)), 2))

# %% [markdown]
# **Look before you check.** The colour shows the distance from the plane above. The road should have the colour of 0 m along its whole length, although it climbs.

# %%
distances = point_plane_distance(street, plane)
plots.from_side(street, values=distances, label="distance from the plane (m)",
                limits=side, span=(0, 1.5),
                title="The road has the colour of 0 m; cars and people do not");

# %% nbgrader={"grade": true, "grade_id": "test_point_plane_distance", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(point_plane_distance)

# %% [markdown]
# **A good place to stop.** You have both tools. Save the notebook. In the second sitting, you use them to find the ground.

# %% [markdown]
# ## RANSAC: try planes through random points
#
# **The second sitting begins here.** If you have closed the notebook, first run all the cells above. In JupyterLab, choose *Run*, *Run All Above Selected Cell*. In Colab, choose *Runtime*, *Run before*.
#
# *A plane through three ground points is usually near most of the ground. Other planes are near only a few points.*
#
# In one *round*, RANSAC draws three different points at random, the *sample*, and computes the plane through them. Then it counts the [inliers](#Words-of-the-course) of this plane, the points within a threshold of it. Here the threshold is 0.2 m.

# %%
def one_round(rng):
    """Draw a sample of the street; return its rows, its plane, and the mask of the inliers."""
    three = rng.choice(len(street), size=3, replace=False)
    attempt = plane_through(*street[three, :3])
    return three, attempt, point_plane_distance(street, attempt) <= 0.2

# %% [markdown]
# Here are four rounds. Squares mark the sample, dots the inliers, and crosses all other points. The line shows where the plane cuts through y = 0, straight ahead of the sensor. If a plane leans sideways, its inliers on the left or right may be far from this line.

# %% tags=["folded"]
# @title Draw four rounds (you need not read this)
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
                  "We counted this in a million picks. A formula says the same. Each point is on the "
                  "ground with probability w, so all three are on the ground with probability "
                  f"w · w · w = {is_ground.mean() ** 3:.0%}. In a single round, this "
                  "usually does not happen, but in fifty rounds it happens several times.")

# %% [markdown]
# A plane through a car usually cuts through the street at an odd angle and has few inliers. If all three points are on the ground and far apart, the count jumps. So RANSAC runs many rounds and keeps the plane with the most inliers, which we call the *largest* plane. The only assumption is that this plane is the ground.
#
# ## Exercise 3 · `ransac_plane` (points)
#
# Return the best plane and the mask of its inliers. If `plane_through` returns `None`, skip the sample, but count the round. With fewer than three points, you cannot draw a sample.

# %% nbgrader={"grade": false, "grade_id": "ransac_plane", "locked": false, "schema_version": 3, "solution": true, "task": false}
def ransac_plane(points, max_iterations, distance_tolerance, rng):
    """Find the plane with the most points near it.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity, which is not used.
    max_iterations : int
        Number of rounds. Each draws a sample of three different rows.
    distance_tolerance : float
        Threshold: the largest distance of an inlier from the plane in metres.
    rng : numpy.random.Generator or int
        Generator or int seed; pass it through np.random.default_rng(rng).

    Returns
    -------
    model : tuple or array of four floats, or None
        (a, b, c, d) with a unit normal; None if no sample gives a plane.
    inliers : ndarray of bool, shape (n,)
        True where the distance from the model is at most distance_tolerance;
        all False if the model is None, for example with fewer than three points.
    """
    # 1. Make the generator. Start with no model and a mask that is all False.
    # 2. With fewer than three points, return these two.
    # 3. In each of max_iterations rounds, draw three different rows and compute their plane. If
    #    there is none, go on to the next round. Make the mask of the points near the plane. If
    #    it has more inliers than the best mask so far, keep this plane and its mask.
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
# The loop is the same as in lesson 02, with three points instead of two. Before the loop, write `rng = np.random.default_rng(rng)`, which accepts a generator or a whole number, `model = None`, and `inliers = np.zeros(len(points), dtype=bool)`.
# </details>
# <details><summary>Hint 2</summary>
#
# In each round, write `i = rng.choice(len(points), 3, replace=False)`, then `plane_through(*points[i, :3])`. The star passes the three rows as p, q and r. If the result is `None`, use `continue`.
# </details>
# <details><summary>Hint 3</summary>
#
# At the end of a round, make the mask `point_plane_distance(...) <= distance_tolerance`. If its `np.count_nonzero(...)` is larger than that of the best mask, replace model **and** mask. After the loop, return both, in this order.
# </details>

# %% [markdown]
# **A small case first.** Five of the seven points are on a floor at z = −1.7 m, and two are above it. So the plane is $(0, 0, 1, 1.7)$ or its negative, and the mask is five times `True`, then twice `False`.

# %%
seven = np.array([[0.0, 0.0, -1.7], [4.0, 0.0, -1.7], [1.0, 3.0, -1.7],
                  [5.0, 4.0, -1.7], [2.0, 5.0, -1.7],
                  [1.5, 1.0, -0.2], [3.0, 2.0, 0.5]])
model, inliers = ransac_plane(seven, 60, 0.1, 1)
print("plane:", np.asarray(model), "\nmask: ", inliers)
plots.plane_model(seven, model, inliers, 0.1, limits=((-1, 6), (-2.3, 1)), title="Five of seven");

# %% [markdown]
# **Look before you check.** Now your function searches the street. The band should contain the ground from end to end, and only a little of the cars.

# %%
model, inliers = ransac_plane(street, 50, 0.2, np.random.default_rng(1))
print("plane:", np.round(model, 3))
plots.plane_model(street, model, inliers, 0.2, limits=side, title="The plane that your ransac_plane found");

# %% tags=["folded"]
# @title Draw the same in 3D (you need not read this)
from utils.scene3d import Scene

inliers = np.asarray(inliers)
(Scene("The same in 3D: the ground in green, all other points in orange")
 .add_plane(street[inliers], model).add_obstacles(street[~inliers]).show())

# %% nbgrader={"grade": true, "grade_id": "test_ransac_plane", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(ransac_plane)

# %% [markdown]
# **Your run, round by round.** The player runs *your* function on 64 points of a road, a car and a house front. If a round is wrong, the player starts there and says why.

# %%
replay(ransac_plane)

# %% [markdown]
# ## The threshold: how thick is the ground?
#
# *A thin band misses some of the ground. A thick band also removes wheels, feet and large parts of cars.*

# %%
def shares(near):
    """Say what share of the ground, and of all other points, a mask contains."""
    return (f"{near[is_ground].mean():.0%} of the ground, {near[~is_ground].mean():.0%} of the rest")


@interact(threshold=FloatSlider(value=0.2, min=0.02, max=0.8, step=0.02,
                                description="threshold", continuous_update=False))
def show_threshold(threshold):
    found, near = ransac_plane(street, 50, threshold, 1)
    plots.plane_model(street, found, near, threshold, limits=side,
                      title=f"Within {threshold:.2f} m: {shares(near)}")
    plt.show()

# %% [markdown]
# Here is the same without a slider. The pictures show the points that are *not* within the threshold, seen from above.

# %% tags=["folded"]
# @title Draw what is left with three thresholds (you need not read this)
figure, panels = plt.subplots(3, 1, figsize=(8.5, 8), layout="compressed")
for threshold, axes in zip((0.03, 0.2, 0.8), panels):
    found, near = ransac_plane(street, 50, threshold, 1)
    plots.from_above(street[~near], limits=((-10, 30), (-5, 5)), span=(-2, 0.5), axes=axes,
                     title=f"A threshold of {threshold} m removes {shares(near)}")
    print(f"threshold {threshold} m: the plane climbs by {-100 * found[0] / found[2]:.1f} %")

# %% [markdown]
# The simulated street has a slope of 2.2 %, kerbs and a *crown*, which means that its middle is higher than its edges. The next picture shows the ground from behind the car, without its slope. The line is the plane with a threshold of 0.03 m. Blue points are within this threshold.

# %% tags=["folded"]
# @title Draw the ground from behind (you need not read this)
from utils.plots.style import BLUE, PALE

found, near = ransac_plane(street, 50, 0.03, 1)
near, lateral = np.asarray(near), np.array([-5, 5])
axes = plots.curves({"plane": (lateral, 1.73 - (found[1] * lateral + found[3]) / found[2])}, {},
                    across="y, left (m)", up="height (m), stretched",
                    title="The crown and the kerb, and a plane that follows only one side")
for mask, marker, colour in ((near, ".", BLUE), (~near, "x", PALE)):
    x, y, z = street[mask & is_ground & (np.abs(street[:, 0]) < 5), :3].T
    axes.plot(y, z - 0.022 * x + 1.73, marker, color=colour, markersize=3, zorder=1)
axes.set_xlim(5, -5);

# %% [markdown]
# - **0.03 m:** More than a third of the ground is left. The cause is the crown, not noise. The two sides of the road lean in different directions, and a thin band can follow only one of them. (The right-hand pavement leans like the left side.)
# - **0.2 m:** The ground is gone, and the obstacles have lost only their lowest part.
# - **0.8 m:** Most of the obstacles are also gone. A plane that cuts through the cars has more inliers than the road, so the plane tilts. Look at its slope.

# %% [markdown]
# ## When the wall wins
#
# In the next picture, RANSAC gets only the right-hand pavement and the house front next to it.

# %%
x, y = cloud[:, 0], cloud[:, 1]
beside = cloud[(x > -1) & (x < 13) & (y > -8.6) & (y < -4)][::3]
won, near = ransac_plane(beside, 100, 0.2, 1)
plots.plane_model(beside, won, near, 0.2, view="above", limits=((-2, 14), (-9, -3.5)),
                  title=f"From above: a wall with the normal ({won[0]:z.1f}, {won[1]:z.1f}, {won[2]:z.1f})");

# %% [markdown]
# The house front has more points than the pavement, so it wins fairly. The normal reveals the mistake. The normal of the ground points up or down, so $|c|$ is near 1. The normal of a wall is horizontal, so $|c|$ is near 0.
#
# The next scan is from a drive through another street, where a lorry comes towards us and passes. Again, we use only the street around the car, so this cloud contains no houses. (The second cell below takes a few seconds.)

# %%
passing = predict("Which plane is the largest in this scan?",
                  choices=["the ground", "the side of the lorry", "a plane between the two"])

# %%
from utils.scenes import city_block


def around_us(cloud):
    """Return the street around the car: every eighth return."""
    return cloud[(cloud[:, 0] > -10) & (cloud[:, 0] < 30) & (np.abs(cloud[:, 1]) < 5)][::8]


passed = around_us(city_block(frames=30)[21].cloud)
largest, near = ransac_plane(passed, 200, 0.2, 1)
passing.compare("the ground" if abs(largest[2]) > 0.9 else "the side of the lorry",
                "The side has more points than the ground, and it hides the ground behind it.")

# %% tags=["folded"]
# @title Draw the largest plane (you need not read this)
figure, (above, aside) = plt.subplots(2, 1, figsize=(8.5, 7.4), layout="compressed")
plots.plane_model(passed, largest, near, 0.2, view="above", limits=((-10, 30), (-6, 6)), axes=above,
                  title=f"From above: the largest plane, with |c| = {abs(largest[2]):.2f}")
plots.plane_model(passed, largest, near, limits=((-10, 30), (-2.6, 2.2)), axes=aside,
                  title="The same from the side")
low, high = np.percentile(passed[near], [5, 95], axis=0)
middle = (low + high) / 2
plots.ring(aside, middle[0], middle[2], radius=0.6 * (high - low)[0]);

# %% [markdown]
# The ring marks the side of the lorry. More rounds do not help here, because the lorry really is the largest plane. Looking at the normal does help. There are three remedies, which you can combine:
#
# - search only where ground is possible (the region of interest in lesson 07),
# - skip every plane whose normal is far from vertical, before you count its inliers,
# - remove the largest plane and search the remaining points, until you find the ground.

# %% [markdown]
# **A good place to stop.** Your `ransac_plane` finds the ground, and you know how the search can fail. Save the notebook. In the third sitting, you improve the plane.

# %% [markdown]
# ## Refit the plane to all inliers
#
# **The third sitting begins here.** Remember that `ransac_plane` returns the largest plane and the mask of the points near it. If you have closed the notebook, first run all the cells above.
#
# *Three points are enough to find the ground, but thousands describe it better.*
#
# RANSAC's plane goes exactly through three noisy points. If they are half a metre apart, an error of 1 cm tilts the plane by about a degree. But now we know the inliers, and nearly all the obstacles are gone. Least squares is the right tool for these points, because it averages the noise of thousands of them.
#
# You will measure the slopes of thirty planes, from thirty seeds, before and after such a fit.

# %%
calmer = predict("After the fit to all inliers, how do the thirty slopes scatter?",
                 choices=["less, and around the true slope",
                          "less, but on one side of the true slope",
                          "as much as before"])

# %% [markdown]
# ## The plane with the smallest squares
#
# Which plane has the smallest sum of squared distances? We need to know where it is and how it is turned.
#
# **Where it is.** Keep the normal $n$ fixed. For a level road, $n = (0, 0, 1)$, and $n \cdot p$ is simply the height z. The best level plane is at the mean height. The same is true for any $n$. Measured along $n$, each point has the position $n \cdot p$, while the whole plane has one position. The sum of squared differences is smallest if the plane's position is the mean of the points' positions. So the best plane goes through the mean of the points. We subtract the mean from all points, and then we no longer need $d$.
#
# **How it is turned.** After this step, a point $q$ is $|n \cdot q|$ away from the plane. The sum of the squared distances is
#
# $$S(n) = \textstyle\sum (n \cdot q)^2 .$$
#
# It measures the *spread* of the points along $n$. The points of a road spread far along the road, and hardly at all upwards. So the best normal is the direction of least spread. The figure shows twelve points on a slope, seen from the side, and $S$ for every direction.

# %% tags=["folded"]
# @title Draw the spread in every direction (you need not read this)
along = np.linspace(-3, 3, 12)
heights = 0.3 * along + 0.25 * np.tile([1, -1, 0.5, -0.5], 3)
section = np.column_stack([along, heights]) - [along.mean(), heights.mean()]
first, last = np.linalg.svd(section, full_matrices=False)[2]
angles = np.arange(181)
directions = np.column_stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))])
spread = ((section @ directions.T) ** 2).sum(axis=0)

figure, (seen, curve) = plt.subplots(2, 1, figsize=(8.5, 7), layout="compressed")
plots.line_model(section, [*last, 0], limits=((-5, 5), (-2.2, 2.2)), axes=seen,
                 title="Twelve points and the line with the smallest sum of squares")
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
# **How to find it in 3D.** The *singular value decomposition* gives three perpendicular directions $v_1, v_2, v_3$, sorted from the largest spread to the smallest. For each direction, it also gives a singular value $s_k$ with $S(v_k) = s_k^2$. No other direction has a smaller sum than the last one, so $n = v_3$. (*If you want more* contains the proof.)
#
# The example is a rough floor of four points, 4 m long and 2 m wide. Each point is 10 cm too high or too low:

# %%
floor = np.array([[0.0, 0.0, -1.6], [4.0, 0.0, -1.8], [0.0, 2.0, -1.8], [4.0, 2.0, -1.6]])
from_mean = floor - floor.mean(axis=0)
_, singular, directions = np.linalg.svd(from_mean, full_matrices=False)
for value, direction in zip(singular, directions):
    squares = ((from_mean @ direction) ** 2).sum()
    print(f"along {np.abs(direction.round(2))}: sum of squares {squares:.2f} = {value:.2f}²")

# %% [markdown]
# Without `full_matrices=False`, NumPy also builds an n × n matrix. For 50,000 points, this matrix needs 20 gigabytes.
#
# ## Exercise 4 · `fit_plane` (points)
#
# Return the plane with the smallest sum of squared distances. It may face in any direction, because a wall is also a plane.

# %% nbgrader={"grade": false, "grade_id": "fit_plane", "locked": false, "schema_version": 3, "solution": true, "task": false}
def fit_plane(points):
    """The least-squares plane of some points.

    Parameters
    ----------
    points : ndarray, shape (n, 3) or (n, 4)
        At least three points that are not all on one line; the intensity is not used.

    Returns
    -------
    tuple or array of four floats
        (a, b, c, d) with a unit normal (a, b, c) of either sign: the plane with the smallest
        sum of squared distances.
    """
    # 1. Compute the mean of x, y and z, and subtract it from the coordinates.
    # 2. Compute the singular value decomposition. The normal is the direction of least spread.
    # 3. Choose d so that the mean is on the plane.
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
# Subtract the mean first. Otherwise, the first direction only points from the sensor to the cloud.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.linalg.svd(...)` returns three things. The third contains one direction per *row*, and the last row is the direction of the smallest spread.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `centre = points[:, :3].mean(axis=0)`, and call the last row `normal`. Then return `(*normal, d)` with `d = -(normal @ centre)`. The rows already have length 1.
# </details>

# %% [markdown]
# **A small case first.** The mean of the rough floor is at z = −1.7 m, and its errors cancel out. So the plane is $(0, 0, 1, 1.7)$ or its negative.

# %%
print(np.round(fit_plane(floor), 2))

# %% [markdown]
# **Look before you check.** For each of thirty seeds, we compute three slopes. The first belongs to the plane through three points, and the second to the least-squares plane of all its inliers. The third belongs to a new fit to the points within 0.1 m of the second plane. The fourth printed line, "inliers on the ground", is explained after the check. Each line shows the mean and, after ±, the standard deviation. All four means should be near 2.2 %, the slope of the simulated street.

# %%
BUILT = 2.2  # per cent


def slope_of(plane):
    """Return how much a plane climbs in the forward direction, in per cent."""
    return -100 * plane[0] / plane[2]


def slopes_of(seeds):
    """Return, for each seed, the slopes of RANSAC's plane and of three fits to its inliers."""
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
# @title Draw the slopes (you need not read this)
shown = {name: (np.arange(30), slopes[name]) for name in list(slopes)[:3]}
built = {"as built": ([0, 29], [BUILT, BUILT])}
figure, panels = plt.subplots(2, 1, figsize=(8.5, 7.4), layout="compressed")
plots.curves(built, shown, up="slope of the street (%)", axes=panels[0],
             title="Refitting reduces the scatter")
plots.curves(built, shown, across="seed", up="slope of the street (%)", axes=panels[1],
             title="The same, enlarged: some planes through three points are outside the picture")
panels[1].set_ylim(1.92, 2.24)
panels[1].get_legend().remove()

fitted, before = slopes["all inliers"], slopes["three points"]
off = abs(np.mean(fitted) - BUILT) > 3 * np.std(fitted) / len(fitted) ** 0.5
answer = ("as much as before" if np.std(fitted) > 0.5 * np.std(before)
          else "less, but on one side of the true slope" if off
          else "less, and around the true slope")
calmer.compare(answer,
               "Averaging reduces errors that differ from run to run, but not errors that are the "
               "same in every run. Here, wheels and bumpers are within the threshold. Most of "
               "them are behind us and lift the plane there, so it climbs less.")

# %% nbgrader={"grade": true, "grade_id": "test_fit_plane", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(fit_plane)

# %% [markdown]
# The symbols of "all inliers" are close together, but all of them are below "as built". An estimate can vary little and still always be wrong on the same side. It is then *biased*. (The planes through three points are also biased, on average more than twice as much, but the scatter hides it.) More points do not reduce a bias. You have to find its cause.
#
# - **Points that do not belong there.** The threshold also lets in wheels and bumpers. "Inliers on the ground" leaves them out with the help of the truth, and most of the error is gone. On a real road, we do not know the truth. But the plane is now good enough for a smaller threshold, and "again, within 0.1 m" does just as well.
# - **A surface that is not a plane.** A small error remains because of the crown and the kerbs.
#
# The slope of a plane through three points is off by about 0.3 %. At a distance of 30 m, this is an error of 9 cm in height. The bias of the first fit causes 2 cm there, and the bias of the second only 5 mm.

# %% [markdown]
# **A good place to stop.** You can refit a plane, and you know what a refit does not correct. Save the notebook. In the fourth sitting, you compute how many rounds you need.

# %% [markdown]
# ## How many rounds?
#
# **The fourth sitting begins here.** If you have closed the notebook, first run all the cells above.
#
# Let $w$ be the share of ground points. A sample of $s = 3$ points is good if all of them are on the ground, which has the probability $w^s$. So a sample is bad with probability $1 - w^s$, and all samples of $N$ rounds are bad with probability $(1 - w^s)^N$. We want at least one good sample with a confidence $C$, such as 0.99:
#
# $$1 - (1 - w^s)^N \ge C \quad\Longleftrightarrow\quad N \ge \frac{\log(1 - C)}{\log(1 - w^s)} .$$
#
# The inequality changes direction because we divide by $\log(1 - w^s)$, which is negative.
#
# ## Exercise 5 · `iterations_needed` (points)
#
# Return the smallest whole number $N$ that satisfies the inequality. Return 1 for `inlier_ratio` 1, because every sample is then good, and `math.inf` for 0, because no sample is good. `confidence` is never 0 or 1.

# %% nbgrader={"grade": false, "grade_id": "iterations_needed", "locked": false, "schema_version": 3, "solution": true, "task": false}
def iterations_needed(inlier_ratio, sample_size, confidence):
    """How many rounds RANSAC needs.

    Parameters
    ----------
    inlier_ratio : float
        Share w of inliers among the points, from 0 to 1.
    sample_size : int
        Number s of points in a sample: two for a line, three for a plane.
    confidence : float
        Wanted probability of at least one sample without outliers; above 0 and below 1.

    Returns
    -------
    int, or math.inf
        The smallest whole N with 1 - (1 - w^s)^N >= confidence; 1 for w = 1; math.inf for
        w = 0, because no number is then enough.
    """
    # 1. Compute the probability of a good sample.
    # 2. If it is 1 or 0, you already know the answer.
    # 3. Otherwise, divide the logarithms and round up.
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
# `math.log` takes one number, and `math.ceil` rounds up to a whole number.
# </details>
# <details><summary>Hint 2</summary>
#
# `math.log(0)` raises an error, and `math.log(1)` is 0, so you cannot divide by it. Each of the two cases needs its own `if`.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `good = inlier_ratio ** sample_size`. Return 1 if it is 1, and `math.inf` if it is 0. Otherwise, return `math.ceil(math.log(1 - ...) / math.log1p(-good))`. `math.log1p(x)` is the logarithm of 1 + x. It also works if `good` is so small that `1 - good` is rounded to 1.
# </details>

# %% [markdown]
# **A case to do by hand.** You toss a coin and wait for heads, so $w = 0.5$ and $s = 1$. The probability of heads is $1 - 0.5^3 = 0.875$ in three tosses, and $1 - 0.5^4 = 0.9375$ in four. So for a confidence of 0.9, the answer is 4.

# %%
print("tosses of a coin:", iterations_needed(0.5, 1, 0.9))

# %% [markdown]
# **Look before you check.** In both columns, the numbers should fall from infinity to 1. A plane should need at least as many rounds as a line.

# %%
show_table(["share of inliers", "rounds for a line", "rounds for a plane"],
           [(w, *(iterations_needed(w, size, 0.99) for size in (2, 3)))
            for w in (0, 0.1, 0.3, 0.5, 0.7, 0.9, 1)])

# %% nbgrader={"grade": true, "grade_id": "test_iterations_needed", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(iterations_needed)

# %% [markdown]
# ## Theory against practice: how often do you find the ground?
#
# *The formula assumes that every plane through three ground points finds the ground.*
#
# Your `ransac_plane` searches 700 points of the street with 1, 2, 4, ... 64 rounds, a hundred times each. A run succeeds if its inliers contain nine tenths of the true ground. Then it searches a second cloud, which reaches 20 m in all directions. This cloud also contains the house fronts and trees, so its share of ground is smaller. (The second cell below takes up to 10 seconds.)

# %%
def success_rate(points, rounds, ground):
    """Return the share of a hundred runs that find nine tenths of the ground points."""
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
                    title="Your success rate, compared with the formula")
axes.set_xscale("log", base=2)
axes.set_xticks(numbers, numbers);

# %% [markdown]
# With house fronts, every measurement is below the formula. On the street, only some are. Not every good sample gives a good plane, for two reasons.
#
# - **The model.** Real ground is not one plane, because it has a crown, kerbs and pavements. If one of the three points is on a pavement, their plane may fit nothing.
# - **Noise.** If three points are close together or nearly on one line, a little noise tilts their plane so much that it misses the distant ground.
#
# Between the house fronts, two good samples in three fail. *If you want more* shows that the model causes most of these failures. More rounds help. In practice, engineers run two or three times as many rounds as the formula says. A million points do not need more rounds than a thousand.

# %% [markdown]
# ## Common mistakes
#
# | mistake | what you see |
# |---|---|
# | the normal is not divided by its length | the band is far too thin, because a large triangle has a long normal |
# | no `np.abs` | all points on one side of the plane are inliers, however far away they are |
# | `d` has the wrong sign | the plane is as far above the sensor as the ground is below it |
# | the last sample wins, not the best | each run gives another plane |
# | no test for `None` | an error occurs, but only in a few runs |
# | `points @ plane` with four columns | the inliers depend on intensity |

# %% tags=["folded"]
# @title Draw the first three mistakes (you need not read this)
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

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(ransac_plane)

# %% [markdown]
# ## In practice
#
# Open3D does this search in one call, with the same parameters. It returns the four numbers and the rows of the inliers:
#
# ```python
# points = open3d.utility.Vector3dVector(street[:, :3])
# plane, rows = open3d.geometry.PointCloud(points).segment_plane(
#     distance_threshold=0.2, ransac_n=3, num_iterations=50)
# ```
#
# - Real systems first try the ground plane of the previous frame.
# - You can make good samples more likely. The lower beams hit the ground more often, and points far apart give a better plane.
#
# ## Summary
#
# - A unit normal and an offset describe a plane. The sign does not matter, but the length of the normal does.
# - RANSAC finds the plane with the most inliers. The number of rounds depends on the share of inliers, not on the number of points.
# - Look at the normal, because the largest plane may be a wall.
# - Refit the plane to all inliers. This removes scatter, but not all of the bias.
#
# **Sources.** RANSAC: [Fischler and Bolles 1981](https://doi.org/10.1145/358669.358692). Least-squares planes by SVD: [Shakarji 1998](https://doi.org/10.6028/jres.103.043). The loop in a library: [PCL, planar segmentation](https://pcl.readthedocs.io/projects/tutorials/en/latest/planar_segmentation.html), [Open3D, plane segmentation](https://www.open3d.org/docs/release/tutorial/geometry/pointcloud.html#Plane-segmentation).
#
# **Next:** 04 · The kd-tree

# %% [markdown]
# ## If you want more
#
# Here are two programming tasks, which take about half an hour each:
#
# 1. Stop early, as libraries do. In `ransac_plane`, call `iterations_needed` with the best inlier ratio so far. How many rounds does the street need on average?
# 2. Skip planes that are not nearly level before you count their inliers. How much time does this save? Does the lorry in the drive below still win?
#
# Below are two finished experiments and a proof. They take about 20 minutes in all.

# %% [markdown]
# ### Noise, or the model?
#
# Why do good samples fail? We draw 2,000 samples, and ask whether all three points are on the ground, and whether their plane contains nine tenths of the ground. Then we ask the same for a street whose ground is one perfect plane. The only error left is the sensor's noise of 2 cm *along the ray*. The rays meet the road at a flat angle, so the noise moves a point up or down by only about 6 mm.

# %%
def good_samples(points, ground):
    """Draw 2,000 samples of three points.

    Returns the share of samples on the ground, the share of these that succeed, and the share of
    all samples that succeed.
    """
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
    """Return the points with the ground on one plane, except for 2 cm of noise along each ray."""
    table = np.column_stack([points[:, :2], np.ones(len(points))])
    level = table @ np.linalg.lstsq(table[ground], points[ground, 2], rcond=None)[0]
    flat = points.copy()
    flat[ground, 2] = level[ground]
    ranges = np.linalg.norm(flat[:, :3], axis=1)
    noise = np.random.default_rng(4).normal(0, 0.02, len(points))
    flat[ground, :3] *= (1 + noise / ranges)[ground, np.newaxis]  # the sensor is the origin
    return flat

# %%
for label, (points, on_ground) in searched.items():
    pure, kept, chance = good_samples(points, on_ground)
    _, kept_if_flat, _ = good_samples(flattened(points, on_ground), on_ground)
    print(f"{label}: {pure:.0%} of the samples are on the ground.")
    print(f"    {kept:.0%} of these find nine tenths of it; on a perfect plane, {kept_if_flat:.0%}")
    print(f"    rounds for 99 %: {iterations_needed(on_ground.mean(), 3, 0.99)} by the formula, "
          f"{iterations_needed(chance, 1, 0.99)} from the measured success rate of a sample")

# %% [markdown]
# - **The model.** On the perfect plane, nine good samples in ten succeed. On the real ground of the street, seven in ten succeed, and between the house fronts only one in three. So crown, kerbs and pavements cause most failures. Within 20 m, nine tenths of the ground are between 8 cm below the best plane and 12 cm above it.
# - **Noise.** It causes the failures that remain on the perfect plane, about one in ten.
#
# With a better model, such as one plane for each piece of road, many more samples would succeed.

# %% [markdown]
# ### Ten frames of a drive
#
# During a drive, a wall or a lorry may win at any time. The third remedy works without any change to your function.

# %%
def ground_plane(points, rounds=100, threshold=0.2, seed=1):
    """Return the largest plane whose normal points up or down, and the rows of its inliers."""
    left = np.arange(len(points))
    for _ in range(10):
        plane, near = ransac_plane(points[left], rounds, threshold, seed)
        if plane is None or abs(plane[2]) > 0.9:
            return plane, left[near]
        left = left[~near]  # this is not the ground, so search the rest
    return None, left[:0]


ground, found = ground_plane(beside)
near = np.isin(np.arange(len(beside)), found)
cut = -6  # draw the plane in the middle of its points, not at y = 0
moved = None if ground is None else (*ground[:3], ground[3] + ground[1] * cut)
plots.plane_model(beside, moved, near, 0.2, limits=((-2, 14), (-2.6, 1.2)),
                  title="From the side, cut at y = −6 m: the largest level plane");

# %% [markdown]
# The scanner delivers ten [frames](#Words-of-the-course) a second. We drive for three seconds at 5 m/s through the street with the lorry, which also climbs by 2.2 %. In every third frame, we search for the ground and refit its plane. For the number of rounds, we use your formula with a share of 0.3. (This takes up to 10 seconds.)

# %%
won_by_ground = predict("In how many of the ten frames is the largest plane the ground?",
                        between=(0, 10))

# %%
def open_drive(source):
    """Return the frames of a drive; each has a `cloud`."""
    from utils import fetch_recording
    from utils.scenes import city_block

    return city_block(frames=30) if source == "simulated" else fetch_recording(source)


def drive(source):
    """Find the ground in every third frame.

    Returns a tuple for each frame: its number, |c| of the largest plane, the share of points
    near the ground plane, the slope of the ground plane in per cent, and the height of the
    sensor above it in metres.
    """
    rounds, frames, lines = iterations_needed(0.3, 3, 0.99), open_drive(source), []
    for number in range(0, len(frames), 3):
        points = around_us(frames[number].cloud)
        largest, _ = ransac_plane(points, rounds, 0.2, 1)
        _, found = ground_plane(points, rounds)
        plane = fit_plane(points[found])
        height = abs(plane[3] / plane[2])  # at x = y = 0, below the sensor
        lines.append((number, abs(largest[2]), len(found) / len(points), slope_of(plane), height))
    return lines

# %%
SOURCE = "simulated"  # "udacity_city" downloads a real street instead, as explained below
lines = drive(SOURCE)
show_table(["frame", "|c| of the largest plane", "points near the ground plane", "slope",
            "height of the sensor"],
           [(number, f"{upright:.2f}", f"{part:.0%}", f"{slope:.2f} %", f"{height:.2f} m")
            for number, upright, part, slope, height in lines])
won_by_ground.compare(sum(upright > 0.9 for _, upright, *_ in lines),
                      "If |c| is near 0, the largest plane is the side of the lorry. Even in "
                      "those frames, the search for the largest plane whose normal points up "
                      "finds the ground.")

# %% [markdown]
# The sensor is mounted 1.73 m above the road. The plane gives this height and the slope in every frame, from the points alone. Its errors differ from frame to frame, and are at most about 1 cm and 0.1 %.
#
# **A real street.** If you are online, set `SOURCE = "udacity_city"` and run the last cells again. They show you the licence of the [KITTI project](https://www.cvlibs.net/datasets/kitti) and then download 22 of its frames (about 40 MB). We do not know the true slope there, but we know the height of the sensor, 1.73 m. Does your plane give the same height?

# %% [markdown]
# ### Why the last direction wins
#
# The three directions of a singular value decomposition have a special property: $\sum (v_1 \cdot q)(v_2 \cdot q) = 0$, and the same is true for the other two pairs. Every unit normal is a mixture $n = \alpha v_1 + \beta v_2 + \gamma v_3$ with $\alpha^2 + \beta^2 + \gamma^2 = 1$. If you put this mixture into $S$, all products of two different directions are zero:
#
# $$S(n) = \alpha^2 s_1^2 + \beta^2 s_2^2 + \gamma^2 s_3^2 .$$
#
# This is a weighted average of the three spreads, with weights that add up to 1. An average is never smaller than its smallest number. It equals this number if all the weight is there, that is, if $\gamma = 1$ and $n = v_3$.

# %% [markdown] tags=["footer"]
# (footer)
