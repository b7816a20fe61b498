# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [directions, success_rate, slope_errors]
# ---

# %% [markdown]
# # 02 · RANSAC: a line through the crowd
#
# ![The same twenty points drawn twice. On the left, the least-squares line through all of them is nearly flat. On the right, the RANSAC line follows a diagonal row of points. A band around the line contains its inliers, and crosses mark the outliers.](02_preview.png)
#
# Half of these points are near a line, as you can see at a glance. The usual way to fit a line, on the left, misses it. RANSAC, on the right, finds it by trying lines at random.
#
# **After this lesson you can**
# - find a line even if half of the points are wrong, with an algorithm of a dozen lines,
# - say how often RANSAC fails, and how many rounds it needs,
# - name what real systems add to RANSAC.
#
# **You write** `line_through` (points), `point_line_distance` (points) and `ransac_line` (points). **Time:** (time), in three sittings of 40, 40 and 35 minutes. **You need** Python and arrays, but not lesson 01.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Twenty points, half of them wrong
#
# A laser scanner looks around at the height of your knee. Seen from above, each [return](#Words-of-the-course) is a point (x, y) in metres, with x forward and y to the left. A wall gives a straight, slightly rough row of points. People, a bicycle and a litter bin in front of it give points as well.
#
# We make such points ourselves, so that we know the answer. Ten are near the line y = x, each moved by up to 0.6 m in x and in y. They are the [inliers](#Words-of-the-course). The other ten, the *outliers*, can be anywhere.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, IntSlider, SelectionSlider, interact

from utils import check, load_cloud, plots, predict, replay, show_table
from utils.breaking import show_broken, tell_apart


def quiz_points(rng):
    """Return 20 points: the first 10 along y = x, the others anywhere. Shape (20, 2)."""
    steps = np.arange(-5, 5)
    along_the_line = np.column_stack([steps, steps]) + rng.uniform(-0.6, 0.6, (10, 2))
    anywhere = rng.uniform(-5, 5, (10, 2))
    return np.vstack([along_the_line, anywhere])


points = quiz_points(np.random.default_rng(18))
window = ((-8, 8), (-6.5, 6.5))
print(f"shape {points.shape}: one row per point, x and y in metres")
print(points[:3].round(2))
plots.line_model(points, limits=window, title="Where is the wall?");

# %% [markdown]
# `np.random.default_rng(18)` is a *random generator*. The number is its *seed*. It decides what the generator draws, so every student sees the same points.

# %% [markdown]
# ## The naive idea: fit all of them
#
# The classic method, `np.polyfit`, finds the line with the smallest sum of *squared* errors. We fit it to all twenty points, and then to the ten inliers alone, which we would not know in a real scan. The fit uses the dots and ignores the crosses.

# %% tags=["folded"]
# @title Save space in small pictures (you need not read this)
def small(axes):
    """Remove the legend, and move the title close to the axes."""
    axes.get_legend().remove()
    axes.set_title(axes.get_title(loc="left"), loc="left", fontsize=11, fontweight="bold", pad=6)

# %%
figure, pair = plt.subplots(1, 2, figsize=(8.5, 3.8), layout="compressed")
for count, axes in zip((20, 10), pair):
    slope, height = np.polyfit(points[:count, 0], points[:count, 1], 1)
    used = np.arange(20) < count
    small(plots.line_model(points, (slope, -1, height), used, limits=window, axes=axes,
                           title=f"fitted to {count} points: slope {slope:.2f}"))

print("The ten inliers and one outlier at x = 4:")
for y in (4, -5, -20, -80):
    slope, _ = np.polyfit([*points[:10, 0], 4], [*points[:10, 1], y], 1)
    print(f"    outlier at y = {y:3d}: slope {slope:6.2f}")

# %% [markdown]
# The true slope is 1. Ten outliers make the line nearly flat. Even a single outlier can turn it as far as you like, if it is far enough away. The errors are squared, so a point 10 m away counts as much as a hundred points 1 m away. We must find out which points are wrong *before* we fit.
#
# ## A line for every direction
#
# *A normal can describe a line in any direction.*
#
# The formula from school, y = m x + h with slope m and height h, fails for a wall straight ahead of the car:

# %%
p, q = (2.0, -3.0), (2.0, 4.0)
try:
    print((q[1] - p[1]) / (q[0] - p[0]))
except ZeroDivisionError as error:
    print("slope of a wall straight ahead:", error)

# %% [markdown]
# We therefore describe a line by three numbers $(a, b, c)$. A point $(x, y)$ is on the line if
#
# $$a\,x + b\,y + c = 0.$$
#
# The pair $(a, b)$ is the *normal*, an arrow at right angles to the line. To compute it from two points $p$ and $q$ on the line:
#
# - Subtract the points. The direction of the line is $(d_x, d_y) = q - p$.
# - Rotate this arrow by a quarter turn. The result $(-d_y,\ d_x)$ is a normal.
# - Divide it by its length $\sqrt{d_x^2 + d_y^2}$. The result $(a, b)$ has length 1 and is called the *unit normal*.
# - Compute $c$. Because $p$ satisfies the equation, $c = -(a\,p_x + b\,p_y)$.

# %% tags=["folded"]
# @title Draw the quarter turn (you need not read this)
from utils.plots.style import BLUE, GREEN, VERMILION

p, q = np.array([1.0, 2.0]), np.array([4.0, 6.0])
axes = plots.line_model(np.array([p, q]), (-0.8, 0.6, -0.4), limits=((-6, 9), (0, 8)),
                        title="A quarter turn of the direction gives a normal")
for arrow, colour, width, text, place in (
        ((3, 4), VERMILION, 2.2, "direction\n$(d_x, d_y)$ = (3, 4)", (5.2, 4.0)),
        ((-4, 3), GREEN, 2.2, "quarter turn\n$(-d_y, d_x)$ = (−4, 3)", (-0.6, 5.2)),
        ((-0.8, 0.6), BLUE, 5.0, "unit normal\n$(a, b)$ = (−0.8, 0.6)", (-2.0, 1.7))):
    axes.annotate("", p + arrow, p, zorder=4, arrowprops={
        "arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0})
    axes.text(*place, text, color=colour, ha="center", va="center")
corner = p + 0.45 * np.array([(0.6, 0.8), (-0.2, 1.4), (-0.8, 0.6)])  # marks the right angle
axes.plot(*corner.T, color="black", linewidth=1)
for point, name in ((p, "p"), (q, "q")):
    axes.annotate(name, point, (8, -12), textcoords="offset points")
small(axes)

# %% [markdown]
# In the picture, p = (1, 2), q = (4, 6), and the direction (3, 4) has length 5. The last number is c = −(−0.8 · 1 + 0.6 · 2) = −0.4.
#
# ## Exercise 1 · `line_through` (points)
#
# Compute the line through two points. Its normal may point to either side. If the two points are equal, return `None`, because many lines go through a single point. In that case, their differences are exactly 0, and so is the length. You may use any package listed at the end, but NumPy is enough.

# %% nbgrader={"grade": false, "grade_id": "line_through", "locked": false, "schema_version": 3, "solution": true, "task": false}
def line_through(p, q):
    """The line through two points.

    Parameters
    ----------
    p, q : ndarray, shape (2,)
        x and y in metres.

    Returns
    -------
    tuple (a, b, c) of float, or None
        The line a x + b y + c = 0 with a² + b² = 1; None if the points are equal.
    """
    # 1. Compute the direction from p to q.
    # 2. Compute its length. If the length is 0, return None.
    # 3. Rotate the direction by a quarter turn and divide it by the length. This gives a and b.
    # 4. Compute c so that p is on the line.
    # roughly 6 lines
    ### BEGIN SOLUTION
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if not length > 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `p[0]` is the x of p, and `p[1]` is its y. `np.hypot(dx, dy)` is the length of the arrow (dx, dy).
# </details>
# <details><summary>Hint 2</summary>
#
# A normal of the direction (dx, dy) is (-dy, dx). Swap the two numbers, and change the sign of the first. If you forget the sign, you mirror the arrow instead of turning it.
# </details>
# <details><summary>Hint 3</summary>
#
# Test whether `length == 0` before you divide. Then divide both parts of the normal by the length to get `a` and `b`. Add a times the x of p and b times the y of p. Their sum with a minus sign is c. Return a, b and c, separated by commas.
# </details>

# %% [markdown]
# **Two lines by hand first.** The first goes through (0, 1) and (4, 1), and the second is the line in the picture. All three of your numbers may have the opposite sign, because that describes the same line.

# %%
print("yours:   ", np.round(line_through(np.array([0.0, 1.0]), np.array([4.0, 1.0])), 2) + 0)
print("expected: [ 0.  1. -1.]")
print("yours:   ", np.round(line_through(np.array([1.0, 2.0]), np.array([4.0, 6.0])), 2))
print("expected: [-0.8  0.6 -0.4]")

# %% [markdown]
# **Look before you check.** There is one vertical line, one horizontal line and one slanted line. Each should go through its two points.

# %%
axes = None
for p, q in [((6, -3), (6, 3)), ((-5, 4), (1, 4)), ((-4, -5), (3, 2))]:
    two = np.array([p, q], dtype=float)
    a, b, c = line_through(*two)
    axes = plots.line_model(two, (a, b, c), limits=window, axes=axes, title="Three lines")
    print(f"through {p} and {q}: a = {a + 0:5.2f}, b = {b + 0:5.2f}, c = {c + 0:5.2f}")
small(axes)
print("two equal points:", line_through(two[0], two[0]))

# %% nbgrader={"grade": true, "grade_id": "test_line_through", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(line_through)

# %% [markdown]
# ## How far from the line?
#
# *With a unit normal, the equation of the line measures distances.*
#
# Put the coordinates of a point into $a\,x + b\,y + c$. On the line, the result is 0. If you move 1 m along the normal, from $(x, y)$ to $(x + a,\ y + b)$, it grows by $a \cdot a + b \cdot b = 1$. So the result is a number of metres, positive on one side of the line and negative on the other. The distance is its absolute value:
#
# $$\text{distance} = |a\,x + b\,y + c|.$$
#
# If the normal had length 5, all distances would be five times too large.
#
# In an array, `points[:, 0]` is the column of x values, with one number per point. Arithmetic and `np.abs` work on whole columns, so you need no loop.
#
# ## Exercise 2 · `point_line_distance` (points)
#
# Compute the distance of every point from one line, in metres.

# %% nbgrader={"grade": false, "grade_id": "point_line_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def point_line_distance(points, line):
    """Distance of each point from a line.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x and y in metres; n may be 0.
    line : (a, b, c)
        The line a x + b y + c = 0 with a² + b² = 1, as from `line_through`.

    Returns
    -------
    ndarray, shape (n,)
        Distances in metres, never negative.
    """
    # 1. Unpack the three numbers of the line.
    # 2. Compute a x + b y + c for all points at once, and return its absolute value.
    # roughly 2 lines
    ### BEGIN SOLUTION
    a, b, c = line
    return np.abs(a * points[:, 0] + b * points[:, 1] + c)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `a, b, c = line` unpacks the line. Write the formula as if x and y were single numbers, with `points[:, 0]` in place of x.
# </details>
# <details><summary>Hint 2</summary>
#
# `points[0]` is the first point. `points[:, 0]` takes column 0 of all rows, so it is the x of every point.
# </details>
# <details><summary>Hint 3</summary>
#
# Compute `value = a * ... + b * ... + c`, with the two columns in place of the dots. Then return `np.abs(value)`.
# </details>

# %% [markdown]
# **Three points first.** The line y = 1 is (0, 1, −1). One point is on the line, one is 2 m above it and one is 2 m below it. So the distances are 0, 2 and 2.

# %%
three = np.array([[0.0, 1.0], [2.0, 3.0], [5.0, -1.0]])
print("yours:   ", np.round(point_line_distance(three, (0.0, 1.0, -1.0)), 2))
print("expected: [0. 2. 2.]")

# %% [markdown]
# **Look before you check.** Each point is the centre of a circle whose radius is your distance. Every circle should just touch the line.

# %%
line = line_through(np.array([-5.0, -2.0]), np.array([5.0, 3.0]))
some = points[[3, 8, 9, 10, 14, 17]]
axes = plots.line_model(some, line, limits=window, title="Each circle touches the line")
for point, distance in zip(some, point_line_distance(some, line)):
    axes.add_patch(plt.Circle(point, distance, fill=False, linewidth=0.8))

# %% nbgrader={"grade": true, "grade_id": "test_point_line_distance", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(point_line_distance)

# %% [markdown]
# **A good place to stop.** You can compute a line and measure distances from it. Save the notebook. The second sitting takes 40 minutes. When you come back, first run all the cells above this one.

# %% [markdown]
# ## The idea: two points make a line, and all points vote
#
# *The right line has many points near it, and a wrong line has only a few.*
#
# RANSAC stands for *random sample consensus*. It works in *rounds*. Each round
#
# 1. draws a random *sample* of two points, the smallest number that determines a line,
# 2. counts the *consensus*, which is the number of points within a threshold of that line. These points are its inliers.
#
# At the end, the line with the most inliers wins.
#
# If either point is an outlier, the line can go anywhere, and few other points are near it. If both are inliers, the line follows the wall and is near the wall's other points. An outlier costs only one vote, whether it is 3 m or 300 m away.
#
# Your two functions are enough to watch RANSAC at work. `<=` compares each distance with the threshold, here 1 m, and gives a *mask* with one True or False per point. The sum of a mask is the number of True values. `points[chosen]` picks the two chosen rows, and the star in front passes them as two arguments. In the four rounds below, rings mark the sample, dots the points within the threshold, and crosses the others.

# %%
rng = np.random.default_rng(3)
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for axes in grid.flat:
    chosen = rng.choice(20, size=2, replace=False)
    candidate = line_through(*points[chosen])
    near = point_line_distance(points, candidate) <= 1.0
    small(plots.line_model(points, candidate, near, 1.0, limits=window, axes=axes,
                           title=f"points {chosen[0]} and {chosen[1]}: {near.sum()} of 20 are near"))
    ring_x, ring_y = points[chosen].T  # .T swaps rows and columns, so the first row holds all x
    axes.plot(ring_x, ring_y, "o", color="black", markersize=11, fillstyle="none")

# %% [markdown]
# A sample is *good* if both of its points belong to the wall, that is, to rows 0 to 9.

# %%
good_samples = predict("You draw two of the twenty points at random. How often is the sample good?",
                       between=(0, 100), unit="%")

# %% [markdown]
# Twenty points form only 190 pairs, so we can try them all.

# %%
from itertools import combinations

pairs = list(combinations(range(20), 2))
good_samples.compare(100 * np.mean([i < 10 and j < 10 for i, j in pairs]),
                     "The first point belongs to the wall in 10 of 20 cases, and the second in 9 of "
                     "the other 19. The product is a little less than one half times one half.")

# %% [markdown]
# About one sample in four is good, but RANSAC does not know which. So it repeats the round many times and remembers the best line:

# %%
rng = np.random.default_rng(3)
counts = []
for number in range(1, 11):
    chosen = rng.choice(20, size=2, replace=False)
    near = point_line_distance(points, line_through(*points[chosen])) <= 1.0
    counts.append(near.sum())
    print(f"round {number:2d}: points {chosen[0]:2d} and {chosen[1]:2d}, {near.sum():2d} near, "
          f"the best so far has {max(counts):2d}")

# %% [markdown]
# Round 4 found the wall. Rounds 2, 7 and 9 also drew two points of the wall, but their two points are less than half as far apart as those of round 4. The wall is rough, so a line through two close points has the wrong direction. Later you will measure how much this matters.
#
# ## Bad samples
#
# Some samples do not determine a line. The same point may be drawn twice. `rng.choice(n, size=2, replace=False)` prevents this by drawing two *different* indices, like two cards from a pack. But two rows may also have equal coordinates, because scanners round their measurements, and some report a strong echo twice. How often does each happen? We round the coordinates to whole metres and draw 5,000 samples:

# %%
rng = np.random.default_rng(0)
rounded = np.round(points)
samples = {"drawn with replacement": [rng.integers(20, size=2) for _ in range(5000)],
           "without": [rng.choice(20, size=2, replace=False) for _ in range(5000)]}
for name, drawn in samples.items():
    same_row = np.mean([i == j for i, j in drawn])
    twins = np.mean([(rounded[i] == rounded[j]).all() for i, j in drawn])
    print(f"{name:>23}: the same row {same_row:.1%}, equal coordinates {twins:.1%}")

# %% [markdown]
# Such a sample is called *degenerate*. Your `line_through` returns `None` for it, and RANSAC goes on to the next round. The twenty unrounded points are all different, so code without a test for `None` works on them. On a scan with equal rows, it crashes in some runs.
#
# ## Exercise 3 · `ransac_line` (points)
#
# Combine your `line_through` and `point_line_distance` into RANSAC.

# %% nbgrader={"grade": false, "grade_id": "ransac_line", "locked": false, "schema_version": 3, "solution": true, "task": false}
def ransac_line(points, max_iterations, distance_tolerance, rng):
    """Find the line with the most points near it by trying random samples.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x and y in metres; n may be 0.
    max_iterations : int
        Number of samples of two points to draw.
    distance_tolerance : float
        Largest distance of an inlier from the line, in metres.
    rng : numpy.random.Generator or int
        Generator or int seed, the source of all randomness; the first line passes it
        through np.random.default_rng(rng).

    Returns
    -------
    line : tuple (a, b, c) of float, or None
        The best line found, or None if there is none, for example with fewer than two points.
    inliers : ndarray of bool, shape (n,)
        True for each point within distance_tolerance of that line.
    """
    rng = np.random.default_rng(rng)  # takes a seed as well as a generator
    # 1. Prepare the best result so far: no line, and a mask of n times False.
    # 2. With fewer than two points, there is nothing to draw, so return this result.
    # 3. Repeat max_iterations times:
    #    a. Draw two different indices, and compute the line through these two points.
    #    b. If `line_through` returns None, go on to the next round.
    #    c. Make the mask of the points within distance_tolerance of the line.
    #    d. If it has more inliers than the best so far, keep this line and its mask.
    # 4. Return the best line and its mask.
    # roughly 12 lines
    ### BEGIN SOLUTION
    best_line, best_inliers = None, np.zeros(len(points), dtype=bool)
    if len(points) < 2:
        return best_line, best_inliers
    for _ in range(max_iterations):
        first, second = rng.choice(len(points), size=2, replace=False)
        line = line_through(points[first], points[second])
        if line is None:
            continue
        inliers = point_line_distance(points, line) <= distance_tolerance
        if inliers.sum() > best_inliers.sum():
            best_line, best_inliers = line, inliers
    return best_line, best_inliers
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# The cell with the four rounds contains steps 3a and 3c. You still have to remember the best line, test for `None`, and handle fewer than two points. `np.zeros(n, dtype=bool)` is a mask of n times False.
# </details>
# <details><summary>Hint 2</summary>
#
# `rng.choice(len(points), size=2, replace=False)` gives two indices, and `points[index]` is the point with that index. `continue` goes on to the next round of a loop. `mask.sum()` counts the inliers.
# </details>
# <details><summary>Hint 3</summary>
#
# In each round, draw the sample `i, j = ...` and compute `candidate = line_through(...)`. If it `is None`, skip the rest of the round. Then compute `mask = ... <= distance_tolerance`. If its sum is larger than that of the best mask, replace *both* the best line and the best mask. Return after the loop, not inside it.
# </details>

# %% [markdown]
# **Five points first.** Four of them are on the line y = 1. More than half of all samples are good, so twenty rounds will find that line.

# %%
five = np.array([[0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [2.0, 4.0]])
line, inliers = ransac_line(five, 20, 0.1, 0)
print("yours:   ", np.round(line, 2) + 0, inliers)
print("expected: [ 0.  1. -1.] or [ 0. -1.  1.], and four times True, then False")

# %% [markdown]
# **Look before you check.** Your function runs ten rounds on the twenty points for each of four seeds. Most of the four lines should follow the diagonal. With so few rounds, about one run in ten misses it, even if your function is right.

# %%
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for seed, axes in enumerate(grid.flat):
    line, inliers = ransac_line(points, 10, 1.0, seed)
    small(plots.line_model(points, line, inliers, 1.0, limits=window, axes=axes,
                           title=f"seed {seed}: {np.sum(inliers)} inliers"))

# %% nbgrader={"grade": true, "grade_id": "test_ransac_line", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(ransac_line)

# %% [markdown]
# **Your run, round by round.** The player shows the samples that *your* function draws, with a threshold of 0.5 m. If a round is wrong, the player starts there and says why.

# %%
replay(ransac_line)

# %% [markdown]
# **By hand.** Drag the ringed point up. At which height does RANSAC accept the point as an inlier, and at which does it reject the point again? What does the least-squares line do?
#
# <details><summary>An answer</summary>
#
# RANSAC accepts the point at about y = 1.4 m and rejects it again before 6 m. In between, the point is an inlier and may turn the line by a few degrees. Elsewhere, it has no effect at all. The least-squares line never rejects the point. It turns farther with each metre that you drag.
# </details>

# %%
from utils.by_hand import Drawing, drag_points


def two_lines(eleven):
    line, inliers = ransac_line(eleven, 200, 1.0, 0)
    slope, height = np.polyfit(eleven[:, 0], eleven[:, 1], 1)
    return Drawing(f"RANSAC: {np.sum(inliers)} of {len(eleven)} points within 1 m",
                   labels=np.where(inliers, 1, 2), names={1: "inliers", 2: "outliers"},
                   lines={"RANSAC": line, "least squares": (slope, -1, height)}, tolerance=1.0)


drag_points(two_lines, np.vstack([points[:10], (4, -5)]), movable=[10], limits=window)

# %% [markdown]
# **A good place to stop.** Your RANSAC works. Save the notebook. The third sitting takes 35 minutes. When you come back, first run all the cells above this one.

# %% [markdown]
# ## Play: rounds and threshold
#
# Each round of your `ransac_line` draws two points and counts the points near their line. A run with another seed draws other samples, so it may find another line.

# %%
same_line = predict("After how many rounds do ten seeds all give the same line?",
                    choices=["20 rounds", "200 rounds", "2,000 rounds"])

# %% [markdown]
# Change one slider at a time, and try a few different seeds.

# %%
@interact(rounds=SelectionSlider(options=[10, 20, 50, 100, 200, 500, 1000, 2000],
                                 description="rounds", continuous_update=False),
          threshold=FloatSlider(value=1.0, min=0.1, max=4.0, step=0.1, description="threshold (m)",
                                continuous_update=False, style={"description_width": "initial"}),
          seed=IntSlider(value=0, min=0, max=9, description="seed", continuous_update=False))
def show_ransac(rounds, threshold, seed):
    line, inliers = ransac_line(points, rounds, threshold, seed)
    plots.line_model(points, line, inliers, threshold, limits=window,
                     title=f"{np.sum(inliers)} of {len(points)} within {threshold:.1f} m")
    plt.show()

# %% [markdown]
# Here is the same without sliders: the directions of the lines that ten seeds find. The true direction is 45°.

# %%
def directions(rounds, threshold):
    """Return the direction of the line that each of ten seeds finds, from 0 to 180 degrees."""
    lines = [ransac_line(points, rounds, threshold, seed)[0] for seed in range(10)]
    return np.array([np.degrees(np.arctan2(-a, b)) % 180 for a, b, _ in lines])

# %%
always_the_same = []
for rounds in (20, 200, 2_000):
    found = directions(rounds, 1.0)
    different = len(np.unique(found.round(3)))
    print(f"{rounds:5,} rounds: different lines: {different}; "
          f"their directions: {found.min():.0f}° to {found.max():.0f}°")
    if different == 1:
        always_the_same.append(f"{rounds:,} rounds")
if always_the_same:
    same_line.compare(always_the_same[0],
                      "Only one of the 190 possible samples gives a line with 12 inliers, and a run "
                      "must draw exactly this sample. A good line is easier to find. After 20 rounds, "
                      "all ten directions are within about 10° of the wall.")

# %% [markdown]
# Even the best line is not exactly at 45°, because it goes through two points that are up to 0.6 m off in x and in y. What does the threshold change? All points of the wall are within 0.85 m of the true line, the length of (0.6, 0.6). The pictures show four thresholds. The printed lines show how much the ten directions differ for six thresholds.

# %%
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for threshold, axes in zip((0.2, 0.5, 1.0, 3.5), grid.flat):
    line, inliers = ransac_line(points, 50, threshold, 5)
    small(plots.line_model(points, line, inliers, threshold, limits=window, axes=axes,
                           title=f"{np.sum(inliers)} within {threshold} m"))
    print(f"within {threshold} m: {np.sum(inliers[:10])} of the wall's 10 points; "
          f"other points: {np.sum(inliers[10:])}")
for threshold in (0.2, 0.5, 1.0, 2.0, 3.0, 4.0):
    print(f"threshold {threshold} m: the directions of ten seeds spread over "
          f"{np.ptp(directions(200, threshold)):4.1f}°")

# %% [markdown]
# A narrow band gives nearly the same direction every time, but at 0.2 m it loses half of the wall's points. A wide band includes other points. Many lines then have nearly the same number of inliers, so the direction varies. Here 0.5 m is a good compromise. It keeps nearly the whole wall and only one other point, and its direction hardly varies. Our 1 m is on the safe side, because no point of the wall is farther from the true line. It costs a few degrees of accuracy.
#
# ## Theory against practice: how many rounds?
#
# The *inlier ratio* $w$ is the share of inliers among all points. For the twenty points, it is 50 %.

# %%
every_second = predict("With 10 rounds, at what inlier ratio do half of all runs fail?",
                       between=(0, 100), unit="%")

# %% [markdown]
# Both points of a good sample must be inliers, so a sample is good with a probability of about $w \cdot w$, and bad with probability $1 - w^2$. All the samples of $N$ rounds are bad with probability $(1 - w^2)^N$. So RANSAC succeeds with probability
#
# $$P = 1 - (1 - w^2)^N.$$
#
# If half of all runs fail, then $P = \frac{1}{2}$. We solve this for $w$.

# %%
every_second.compare(100 * np.sqrt(1 - 0.5 ** (1 / 10)),
                     "At this ratio, only one sample in 15 is good, so ten rounds draw a good one in only "
                     "half of all runs. RANSAC can find a line even if only a quarter of all points belong to it.")

# %% [markdown]
# Now test your own function on two hundred scenes with a known inlier ratio. A run succeeds if it finds at least 80 % of the points on the line.

# %% tags=["folded"]
# @title Make scenes with a known inlier ratio (you need not read this)
def scene(rng, inlier_ratio, roughness, n=60):
    """Return points on a rough line 20 m long, and others at least 1 m away from it."""
    on_line = np.arange(n) < round(inlier_ratio * n)
    xy = rng.uniform(-10, 10, (n, 2))
    xy[on_line, 1] = rng.normal(0, roughness, on_line.sum())
    close = ~on_line & (np.abs(xy[:, 1]) < 1)
    xy[close, 1] += np.sign(xy[close, 1])
    return xy, on_line

# %%
def success_rate(rounds, inlier_ratio, roughness=0.005, threshold=0.2, runs=200):
    """Return the share of runs in which your ransac_line finds the line."""
    found = 0
    for seed in range(runs):
        rng = np.random.default_rng((seed, rounds, round(100 * inlier_ratio)))
        xy, on_line = scene(rng, inlier_ratio, roughness)
        inliers = np.asarray(ransac_line(xy, rounds, threshold, rng)[1])
        found += inliers[on_line].mean() >= 0.8
    return found / runs

# %%
ratios = np.array([0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
w = np.linspace(0.1, 1, 100)
theory = {f"{rounds} rounds": (w, 1 - (1 - w**2) ** rounds) for rounds in (2, 10, 40)}
measured = {f"{rounds} rounds": (ratios, [success_rate(rounds, ratio) for ratio in ratios])
            for rounds in (2, 10, 40)}
axes = plots.curves(theory, measured, across="inlier ratio w", up="share of runs that find the line",
                    title="Your RANSAC against theory")
axes.axhline(0.5, color="black", linewidth=0.6)
show_table(["w = 0.3", "theory", "measured"],
           [(f"{rounds} rounds", f"{1 - (1 - 0.3**2) ** rounds:.0%}",
             f"{measured[f'{rounds} rounds'][1][1]:.0%}") for rounds in (2, 10, 40)])

# %% [markdown]
# Your measurements follow the curves, but two hundred runs are only a sample, so they are off by a few percentage points. The formula itself promises slightly too much, because RANSAC does not put the first point back before it draws the second. If 12 of 60 points are inliers, ten rounds succeed in 32 % of all runs instead of 34 %.
#
# Follow the ten-round curve from left to right. If a fifth of the points are inliers, most runs fail. With two thirds or more, nearly all runs succeed. The table for w = 0.3 shows that more rounds make up for fewer inliers.
#
# The points of these walls deviate from a line by only half a centimetre (standard deviation). With half of the points on such a wall, the formula promises that eight rounds find it in 90 % of all runs. What about a rough wall?

# %%
rough_wall = predict("If the points deviate by 0.25 m, what share of the runs finds the wall with 8 rounds?",
                     between=(0, 100), unit="%")

# %%
rounds = np.array([1, 2, 4, 8, 16, 32])
many = np.linspace(1, 32, 200)
measured = {f"deviation {roughness} m": (
    rounds, [success_rate(count, 0.5, roughness, 0.6) for count in rounds.tolist()])
    for roughness in (0.005, 0.1, 0.25)}
plots.curves({"theory for w = 0.5": (many, 1 - (1 - 0.5**2) ** many)}, measured, across="rounds",
             up="share of runs that find the line", title="A rough wall needs more rounds")
rough_wall.compare(100 * success_rate(8, 0.5, 0.25, 0.6),
                   "Two inliers close together are not a good sample on a rough wall, because the line "
                   "through them has the wrong direction. The formula counts them as good.")

# %% [markdown]
# The rougher the wall, the farther the measurements are below the curve. With enough rounds, the gap closes. In practice, use two or three times as many rounds as the formula says.
#
# ## What real systems add
#
# Variants of RANSAC improve the score, the sample or the final line:
#
# | variant | weakness of plain RANSAC | improvement |
# |---|---|---|
# | MSAC | every point inside the band counts 1 and every other point 0, so two different lines may both score 10 | keeps the line with the smallest sum of min(d², t²), for distances d and threshold t |
# | PROSAC | it draws all points equally often | draws the most reliable points first, such as strong echoes |
# | LO-RANSAC | a line through two rough points has the wrong direction | refits each new best line to all its inliers |
#
# The last idea is worth a try. Least squares failed because of the outliers, but RANSAC has just removed them. RANSAC finds *which* points belong to the line, and least squares then finds *where* the line is.
#
# Write this refit. The last line of `refit` still fits all twenty points, so the line in the picture is nearly flat. Change it so that it fits only the inliers (the dots). Which line is closer to the true slope of 1, yours or the line that RANSAC found? This cell is not checked. An answer is below.

# %%
def refit(points, inliers):
    """Return slope and height of the least-squares line through the inliers."""
    return np.polyfit(points[:, 0], points[:, 1], 1)  # change this line


(a, b, c), inliers = ransac_line(points, 40, 1.0, 0)
slope, height = refit(points, np.asarray(inliers))
plots.line_model(points, (slope, -1, height), inliers, limits=window,
                 title=f"Slope {slope:.2f} by your refit, {-a / b:.2f} by RANSAC alone");

# %% [markdown]
# <details><summary>An answer</summary>
#
# `return np.polyfit(points[inliers, 0], points[inliers, 1], 1)`. RANSAC's line goes through two rough points and has a slope of 1.18. The refit uses all eleven inliers, and its slope is 0.98.
# </details>
#
# How much does a refit help? We try it on 300 sets of twenty points and measure the error of the direction.

# %% tags=["folded"]
# @title Measure the directions of 300 lines (you need not read this)
def slope_errors():
    """Return the errors of 300 directions in degrees: by RANSAC alone, and after a refit."""
    alone, refitted = [], []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        twenty = quiz_points(rng)
        (a, b, _), inliers = ransac_line(twenty, 40, 1.0, rng)
        alone.append(abs(np.degrees(np.arctan(-a / b)) - 45))
        slope = np.polyfit(*twenty[inliers].T, 1)[0]
        refitted.append(abs(np.degrees(np.arctan(slope)) - 45))
    return np.array(alone), np.array(refitted)

# %%
alone, refitted = slope_errors()
share = np.linspace(0, 1, 300)
plots.curves({"RANSAC alone": (np.sort(alone), share),
              "then least squares on its inliers": (np.sort(refitted), share)},
             across="error of the direction (degrees)", up="share of runs with at most this error",
             title="RANSAC and least squares together").set_xlim(0, 12)
print(f"median error: {np.median(alone):.1f} degrees by RANSAC alone, "
      f"{np.median(refitted):.1f} degrees after least squares")

# %% [markdown]
# ## From twenty points to a street
#
# Your function also works on thousands of points. `cloud.txt` is one scan of a street from the roof of a car, with x, y and z in metres from the scanner and the intensity. We take a thin slice at the scanner's height, to the right of the car, and ignore z. The slice contains house fronts, cars, trees and people. Your function finds the wall with the most points, which need not be the longest. Then it searches the remaining points for the next wall.

# %%
cloud = load_cloud("cloud.txt")
x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
in_slice = (np.abs(z) < 0.3) & (x > -25) & (x < 25) & (y > -17) & (y < -1)
left_over = cloud[in_slice, :2]

figure, panels = plt.subplots(2, 1, figsize=(8.5, 7.2), layout="compressed")
for name, axes in zip(("the first wall", "the next wall, in the remaining points"), panels):
    line, inliers = ransac_line(left_over, 100, 0.1, 1)
    plots.line_model(left_over, line, inliers, 0.1, limits=((-25, 25), (-17, 0)), axes=axes,
                     title=f"{name}: {np.sum(inliers):,} of {len(left_over):,} points")
    axes.lines[-1].set_linewidth(0.5)  # a thin line does not hide the inliers
    left_over = left_over[~np.asarray(inliers)]  # ~ inverts a mask

# %% [markdown]
# The people and cars in front of the walls do no harm. A line has no ends, so the second line follows house fronts on both sides of the first wall.
#
# ## Common mistakes
#
# | mistake | what you see |
# |---|---|
# | no `abs` in the distance | all points on one side of the line count as inliers |
# | the normal is not divided by its length | the band is too thin for points far apart, and too wide for points close together |
# | the last line is returned, not the best | each seed gives another line, however many rounds you run |
# | line and mask are not replaced together | the inliers are not along the line |
# | the line is y = m x + h | an exception, or a wall straight ahead is not found |
# | squared distances are compared with the threshold | the band has the wrong width: 0.25 acts like 0.5 |

# %% tags=["folded"]
# @title Draw three of these mistakes (you need not read this)
diagonal, other = np.array([1, -1, 0]) / np.sqrt(2), np.array([0.2, 1.0, -3.0]) / np.hypot(0.2, 1.0)
value = points @ diagonal[:2] + diagonal[2]
shown = {"correct": (diagonal, np.abs(value) <= 1.0),
         "no abs": (diagonal, value <= 1.0),
         "normal too long": (diagonal, np.abs(5 * value) <= 1.0),
         "the mask of another line": (other, np.abs(value) <= 1.0)}
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for (name, (line, mask)), axes in zip(shown.items(), grid.flat):
    small(plots.line_model(points, line, mask, 1.0, limits=window, axes=axes,
                           title=f"{name}: {mask.sum()} inliers"))

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(ransac_line)

# %% [markdown]
# ## In practice
#
# - The threshold depends on the range noise and on the roughness of the wall. Two or three times the noise is a good first value.
# - You do not know the inlier ratio beforehand. After each new best line, real programs compute how many rounds its inlier ratio requires, and stop after that many. `max_iterations` is then only a limit.
# - Keep the seed, so that you can repeat a run exactly when you debug it.
# - The wall with the most points may not be the one you meant.
#
# scikit-learn has a RANSAC for any model of the form y = f(x). It measures distances along y, so it cannot find a wall straight ahead. At the end, it fits the line to all its inliers, as we did:
#
# ```python
# from sklearn.linear_model import RANSACRegressor
# ransac = RANSACRegressor(max_trials=50, residual_threshold=1.0, random_state=0)
# ransac.fit(points[:, :1], points[:, 1])  # then ransac.inlier_mask_ and ransac.estimator_.coef_
# ```
#
# ## Summary
#
# - A single bad point can turn a least-squares line in any direction.
# - In each round, RANSAC draws the smallest sample that determines a model, and counts the inliers. The model with the most inliers wins.
# - RANSAC succeeds with probability 1 − (1 − w²)^N, so with fewer inliers you need many more rounds.
# - Draw without replacement, and be ready for `None`.
# - A least-squares fit to the inliers makes a good line better.
#
# **Sources.** RANSAC: [Fischler and Bolles 1981](https://doi.org/10.1145/358669.358692). MSAC: [Torr and Zisserman 2000](https://doi.org/10.1006/cviu.1999.0832). PROSAC: [Chum and Matas 2005](https://doi.org/10.1109/CVPR.2005.221). LO-RANSAC: [Chum, Matas and Kittler 2003](https://doi.org/10.1007/978-3-540-45243-0_31). USAC, which combines such variants: [Raguram et al. 2013](https://doi.org/10.1109/TPAMI.2012.257).
#
# **Next:** 03 · The road as a plane

# %% [markdown]
# ## If you want more
#
# 1. (30 minutes) Turn your function into MSAC, which keeps the line with the smallest sum of min(d², t²). Compare the two on many sets of twenty points, for thresholds from 0.3 to 3 m.
#    <details><summary>An answer</summary>On the 300 sets from above, with 40 rounds, both have about the same error at 0.3 m. MSAC is better for thresholds of about 0.7 m and more. At 1 m, the median errors are 2.2° (plain) and 1.6° (MSAC). At 3 m, they are 7.1° and 2.6°. So with MSAC, the choice of the threshold matters much less.</details>
# 2. (25 minutes) Draw the second point only from the quarter of the points that are nearest to the first, or only from the farthest quarter. Try both on the twenty points, with ten rounds and many seeds. How often are fewer than eight of the wall's ten points inliers, and why?
#    <details><summary>An answer</summary>It is better to draw points far apart, because roughness turns a short line more than a long one. In 1,000 runs, RANSAC missed the wall in 10 % with any second point, in 18 % with a near one and in 3 % with a far one. On a street with many objects, near points may be better, because neighbours more often belong to the same wall.</details>

# %% [markdown]
# ### Breaking it on purpose
#
# *A good tester looks for the smallest input on which a wrong function shows its mistake.*
#
# This takes about 20 minutes. Three colleagues have each sent you a `ransac_line`, but not its code. The figure shows what their functions and yours find in fifteen points, with a threshold of 0.5 m. What is wrong with A, B and C?

# %%
show_broken(ransac_line)

# %% [markdown]
# For each version, find a cloud where its answer differs from yours. Use as few points as you can. The best cloud exposes only that version. Once a cloud exposes a version, the cell tells you what is wrong with it. Nothing is graded here.

# %%
# Give each of A, B and C a list of points [x, y]: A=[[...], [...]].
tell_apart(ransac_line, A=None, B=None, C=None)

# %% [markdown] tags=["footer"]
# (footer)
