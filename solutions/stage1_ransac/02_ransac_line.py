# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 02 · RANSAC: a line through the crowd
#
# ![Twenty points, drawn twice. On the left, a line fitted to all of them by least squares cuts flat through the cloud and follows nothing. On the right, the line found by RANSAC runs along a diagonal row of points; a band around it holds them as inliers, and the others are marked with crosses as outliers.](pictures/02_preview.png)
#
# Half of these points lie on a line. You see it at a glance. The best-known way of fitting a line, on the left, does not. RANSAC, on the right, does, by doing what sounds like a bad idea: it guesses.
#
# **After this lesson you can**
# - find a line among points of which half are wrong, with an algorithm of a dozen lines,
# - say how often it fails, and how many guesses you have to pay for,
# - name what real systems add to it.
#
# **You write** `line_through` (5 points), `point_line_distance` (10 points) and `ransac_line` (25 points). **Time:** about 50 minutes. **You need** Python and arrays. Nothing from lesson 01 is taken for granted.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Twenty points, ten of them liars
#
# *Real measurements are not a model plus a little noise: some of them are about something else.*
#
# Imagine a laser scanner that looks around at the height of your knee and reports, for each direction, where its light met something. Seen from above, each echo is a point (x, y) in metres. A wall gives a straight row of points, a little rough. But people stand in front of the wall, and a bicycle, and a litter bin: points as well, and they have nothing to do with the wall. Where is the wall?
#
# We make such points ourselves, so that we know the answer. Ten lie along the line y = x, each moved by up to 0.6 m in x and in y. These are the *inliers*. Ten lie anywhere: the *outliers*.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, IntSlider, interact

from utils import check, load_cloud, plots


def quiz_points(rng):
    """20 points: the first 10 along y = x, the others anywhere. Shape (20, 2)."""
    steps = np.arange(-5, 5)
    along_the_line = np.column_stack([steps, steps]) + rng.uniform(-0.6, 0.6, (10, 2))
    anywhere = rng.uniform(-5, 5, (10, 2))
    return np.vstack([along_the_line, anywhere])


points = quiz_points(np.random.default_rng(18))
window = ((-8, 8), (-6.5, 6.5))
print("shape:", points.shape, "- one row per point, x and y in metres")
print(points[:3].round(2))
plots.line_model(points, limits=window, title="Where is the wall?");


def small(axes):
    """Make room in a small picture: no legend, and the title close to the axes."""
    axes.get_legend().remove()
    axes.set_title(axes.get_title(loc="left"), loc="left", fontsize=11, fontweight="bold", pad=6)

# %% [markdown]
# `np.random.default_rng(18)` is a *random generator*; the number, its *seed*, decides what it draws, so everybody sees the same points.
#
# **Predict first.** Hold a pencil to the screen where you see the line. Which points would you leave out? And if you drew a random line through two of the twenty points, how often would it be right?
#
# ## The naive idea: fit all of them
#
# *Least squares listens to every point, and most to those that shout loudest.*
#
# The classic way takes the line for which the sum of the *squared* errors is smallest. NumPy has it as `np.polyfit` (and for new code recommends its twin in `numpy.polynomial`). We fit it once to all twenty points, and once to the ten that we know to be inliers, which is cheating: in a real scan nobody tells you. Dots take part in the fit, crosses do not.

# %%
figure, pair = plt.subplots(1, 2, figsize=(8.5, 3.8), layout="compressed")
for count, axes in zip((20, 10), pair):
    slope, height = np.polyfit(points[:count, 0], points[:count, 1], 1)
    used = np.arange(20) < count
    small(plots.line_model(points, (slope, -1, height), used, limits=window, axes=axes,
                           title=f"fitted to {count} points: slope {slope:.2f}"))

print("The ten inliers and one single outlier at x = 4:")
for y in (4, -5, -20, -80):
    slope, _ = np.polyfit([*points[:10, 0], 4], [*points[:10, 1], y], 1)
    print(f"    outlier at y = {y:3d}: slope {slope:6.2f}")

# %% [markdown]
# The true slope is 1. Ten outliers nearly flatten the line; and one single outlier turns it as far as you like, if only it lies far enough off. That is the square: a point 10 m away weighs as much as a hundred points 1 m away. No amount of averaging helps. We must find out who lies *before* we average.
#
# ## A line without a slope
#
# *Write a line by its normal, and no direction is special any more.*
#
# First we need lines. The formula from school, y = m x + q, fails for the wall straight ahead of the car:

# %%
p, q = (2.0, -3.0), (2.0, 4.0)
try:
    print((q[1] - p[1]) / (q[0] - p[0]))
except ZeroDivisionError as error:
    print("slope of a wall straight ahead:", error)

# %% [markdown]
# So we write a line with three numbers $(a, b, c)$ instead: it consists of the points with
#
# $$a\,x + b\,y + c = 0.$$
#
# The pair $(a, b)$ is the *normal*: an arrow at right angles to the line. Given two points $p$ and $q$ on the line,
#
# - the direction along the line is $(d_x, d_y) = q - p$;
# - a quarter turn makes it the normal: $(-d_y,\ d_x)$;
# - divided by its length $\sqrt{d_x^2 + d_y^2}$, it has length 1: a *unit normal* $(a, b)$. You will see what that is good for in the next exercise;
# - and $c$ is whatever makes $p$ fulfil the equation: $c = -(a\,p_x + b\,p_y)$.
#
# For example, p = (0, 1) and q = (4, 1) give the direction (4, 0), the quarter turn (0, 4), the unit normal (0, 1), and c = −1: the line 0 x + 1 y − 1 = 0, that is y = 1.
#
# When p and q are the same point, the length is 0 and there is no line: or rather, there are too many. The function then says so by returning `None`.

# %% [markdown]
# ## Exercise 1 · `line_through` (5 points)
#
# The line through two points. Whether the normal points to one side or to the other does not matter.

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
        The line a x + b y + c = 0 with a² + b² = 1; None when the points are equal.
    """
    # 1. The direction from p to q.
    # 2. Its length; if that is 0, return None.
    # 3. A quarter turn, divided by the length: a and b.
    # 4. c, so that p lies on the line.
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
# `p[0]` is x of p and `p[1]` its y. `np.hypot(dx, dy)` is the length of the arrow (dx, dy).
# </details>
# <details><summary>Hint 2</summary>
#
# The normal of the direction (dx, dy) is (-dy, dx): swap, and change one sign. If you swap without the sign, you mirror the line instead of turning it.
# </details>
# <details><summary>Hint 3</summary>
#
# With `a` and `b` divided by the length, c is minus (a times x of p, plus b times y of p). Return the three with commas between them. Test `length == 0` before you divide.
# </details>

# %% [markdown]
# **Look before you check.** Each line should run through its two points: an upright one, a level one, a slanted one.

# %%
pairs = [((2, -3), (2, 4)), ((-5, 1), (4, 1)), ((-4, -5), (3, 2))]
figure, row = plt.subplots(1, 3, figsize=(8.5, 3.1), layout="compressed")
for (p, q), axes in zip(pairs, row):
    two = np.array([p, q], dtype=float)
    a, b, c = line_through(*two)
    small(plots.line_model(two, (a, b, c), limits=((-7, 7), (-7, 7)), axes=axes,
                           title=f"a = {a + 0:.2f}, b = {b + 0:.2f}, c = {c + 0:.2f}"))
print("two equal points:", line_through(two[0], two[0]))

# %% nbgrader={"grade": true, "grade_id": "test_line_through", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(line_through)

# %% [markdown]
# ## How far from the line?
#
# *With a unit normal, the equation of the line is a ruler.*
#
# Put a point into $a\,x + b\,y + c$. On the line you get 0. Take one step of 1 m along the normal, from $(x, y)$ to $(x + a,\ y + b)$: the value grows by $a \cdot a + b \cdot b = 1$. So the value counts metres, with a plus on one side of the line and a minus on the other. The distance is its absolute value:
#
# $$\text{distance} = |a\,x + b\,y + c|.$$
#
# Had the normal length 5, all distances would be five times too long. That is why we divided.
#
# A word on arrays: `points[:, 0]` is the column of all x, one number per point. Arithmetic on columns treats all points at once, `np.abs` too. No loop is needed: `3 * points[:, 0] + 2` is an array of 20 numbers.
#
# ## Exercise 2 · `point_line_distance` (10 points)
#
# The distances of all points from one line, in metres.

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
        Distances in metres, none of them negative.
    """
    # 1. The three numbers of the line.
    # 2. a x + b y + c for all points at once, and its absolute value.
    # roughly 2 lines
    ### BEGIN SOLUTION
    a, b, c = line
    return np.abs(a * points[:, 0] + b * points[:, 1] + c)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `a, b, c = line` takes a line apart. Then write the formula as if x and y were single numbers, with `points[:, 0]` for x.
# </details>
# <details><summary>Hint 2</summary>
#
# `points[0]` is the first point. `points[:, 0]` is x of every point: all rows, column 0.
# </details>
# <details><summary>Hint 3</summary>
#
# Compute `value = a * ... + b * ... + c` with the two columns for the dots, and return `np.abs(value)`.
# </details>

# %% [markdown]
# **Look before you check.** Around each point we draw a circle whose radius is your distance. Every circle should just touch the line.

# %%
line = line_through(np.array([-5.0, -2.0]), np.array([5.0, 3.0]))
axes = plots.line_model(points[10:], line, limits=window, title="Each circle touches the line")
for point, distance in zip(points[10:], point_line_distance(points[10:], line)):
    axes.add_patch(plt.Circle(point, distance, fill=False, linewidth=0.8))

# %% nbgrader={"grade": true, "grade_id": "test_point_line_distance", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(point_line_distance)

# %% [markdown]
# ## The idea: let two speak, then ask everyone
#
# *A wrong line has few friends.*
#
# RANSAC stands for *random sample consensus*:
#
# 1. **Random sample.** Draw two points, as few as make a line.
# 2. **Consensus.** Count how many points lie within a tolerance of that line: its inliers.
# 3. Repeat, and keep the line with the most inliers.
#
# If one of the two is an outlier, the line runs through the crowd at random and few others agree. If both are inliers, the line runs along the wall and all the wall agrees. Inliers support each other; outliers have nothing in common. And an outlier that disagrees costs one vote, whether it is 3 m away or 300.
#
# Your two functions are enough to watch it work. `<=` compares every distance with the tolerance and gives one True or False per point: a *mask*. Its sum counts the True. `points[chosen]` picks the rows whose numbers are in `chosen`; they have a ring around them. Dots agree with the line, crosses do not.

# %%
rng = np.random.default_rng(3)
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for axes in grid.flat:
    chosen = rng.choice(20, size=2, replace=False)
    guess = line_through(*points[chosen])
    agree = point_line_distance(points, guess) <= 1.0
    small(plots.line_model(points, guess, agree, 1.0, limits=window, axes=axes,
                           title=f"points {chosen[0]} and {chosen[1]}: {agree.sum()} of 20 agree"))
    axes.plot(*points[chosen].T, "o", color="black", markersize=11, fillstyle="none")

# %% [markdown]
# ## Bad draws
#
# *A sample must make a line: draw without replacement, and be ready for twins.*
#
# Two traps lie in "draw two points". The first: drawing the same point twice. `rng.choice(n, size=2, replace=False)` draws two *different* indices, as from a pack of cards without putting the first one back. The second: two different rows with the same coordinates. Scanners round, and some report a strong echo twice. How often does either happen? We round the coordinates to whole metres and draw 5,000 times:

# %%
rng = np.random.default_rng(0)
rounded = np.round(points)
draws = {"drawn with replacement": [rng.integers(20, size=2) for _ in range(5000)],
         "without": [rng.choice(20, size=2, replace=False) for _ in range(5000)]}
for name, pairs in draws.items():
    same_row = np.mean([i == j for i, j in pairs])
    twins = np.mean([(rounded[i] == rounded[j]).all() for i, j in pairs])
    print(f"{name:>23}: the same row {same_row:.1%}, equal coordinates {twins:.1%}")

# %% [markdown]
# Such a sample is called *degenerate*: it does not determine a model. Your `line_through` answers `None`, and the round is lost; RANSAC simply goes on with the next. Code that does not ask for `None` stops with an exception: not in the first run, but some day in the rain.
#
# ## Exercise 3 · `ransac_line` (25 points)
#
# Put it together. Use your own `line_through` and `point_line_distance`.

# %% nbgrader={"grade": false, "grade_id": "ransac_line", "locked": false, "schema_version": 3, "solution": true, "task": false}
def ransac_line(points, max_iterations, distance_tolerance, rng):
    """Find the line with the most points near it, by random samples.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        x and y in metres; n may be 0.
    max_iterations : int
        How many samples of two points to draw.
    distance_tolerance : float
        Largest distance of an inlier from the line, in metres.
    rng : numpy.random.Generator or int
        Generator or int seed, the source of all randomness; the first line passes it
        through np.random.default_rng(rng).

    Returns
    -------
    line : tuple (a, b, c) of float, or None
        The best line found; None when there was none, as for fewer than two points.
    inliers : ndarray of bool, shape (n,)
        True for each point within distance_tolerance of that line.
    """
    rng = np.random.default_rng(rng)  # takes a seed as well as a generator
    # 1. The best so far: no line, and a mask of n times False.
    # 2. With fewer than two points there is nothing to draw: return that.
    # 3. Repeat max_iterations times:
    #    a. Draw two different indices and take the line through these points.
    #    b. No line? Go on with the next round.
    #    c. The mask of the points within distance_tolerance of the line.
    #    d. More inliers than the best so far? Then keep this line and its mask.
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
# Look at the cell with the four guesses: it holds steps 3a and 3c. What is missing is the memory of the best, the test for `None`, and the case of fewer than two points. `np.zeros(n, dtype=bool)` is n times False.
# </details>
# <details><summary>Hint 2</summary>
#
# Draw with `rng.choice(len(points), size=2, replace=False)`; it gives two indices, and `points[index]` is the point. `continue` goes on with the next round of a loop. Count with `mask.sum()`.
# </details>
# <details><summary>Hint 3</summary>
#
# In each round: `i, j = ...` the draw; `candidate = line_through(...)`; skip if it `is None`; `mask = ... <= distance_tolerance`; if its sum is larger than that of the best mask, replace *both* the best line and the best mask. Return after the loop, not inside.
# </details>

# %% [markdown]
# **Look before you check.** Ten rounds on the quiz, four times with another seed. Most of the four should lie along the diagonal. With so few rounds, about one run in ten goes astray: that is no mistake of yours.

# %%
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.0), layout="compressed")
for seed, axes in enumerate(grid.flat):
    line, inliers = ransac_line(points, 10, 1.0, seed)
    small(plots.line_model(points, line, inliers, 1.0, limits=window, axes=axes,
                           title=f"seed {seed}: {np.sum(inliers)} inliers"))

# %% nbgrader={"grade": true, "grade_id": "test_ransac_line", "locked": true, "points": 25, "schema_version": 3, "solution": false, "task": false}
check(ransac_line)

# %% [markdown]
# ## Play: patience and tolerance
#
# *Too narrow a band loses the wall's own points; too wide a band lets every line win.*
#
# Change one slider at a time. With 10 rounds, then with 100: how many of ten seeds give a line that misses the wall? At which tolerance does the line begin to wobble?

# %%
@interact(rounds=IntSlider(value=10, min=1, max=100, description="rounds", continuous_update=False),
          tolerance=FloatSlider(value=1.0, min=0.1, max=4.0, step=0.1, description="tolerance",
                                continuous_update=False),
          seed=IntSlider(value=0, min=0, max=20, description="seed", continuous_update=False))
def show_ransac(rounds, tolerance, seed):
    line, inliers = ransac_line(points, rounds, tolerance, seed)
    plots.line_model(points, line, inliers, tolerance, limits=window,
                     title=f"{np.sum(inliers)} of {len(points)} within {tolerance:.1f} m")
    plt.show()

# %% [markdown]
# The same without sliders: three tolerances, fifty rounds each. The middle one fits best: the wall's points were moved by up to 0.6 m in x and in y, so they lie within 0.85 m of the true line. The line that was found goes through two of them, so it is not quite the true one.

# %%
figure, row = plt.subplots(1, 3, figsize=(8.5, 3.1), layout="compressed")
for tolerance, axes in zip((0.2, 1.0, 3.5), row):
    line, inliers = ransac_line(points, 50, tolerance, 5)
    small(plots.line_model(points, line, inliers, tolerance, limits=((-7, 7), (-7, 7)), axes=axes,
                           title=f"{np.sum(inliers)} within {tolerance} m"))

# %% [markdown]
# ## Theory against practice: how many rounds?
#
# *Every outlier is paid for in rounds, and each costs more than the last.*
#
# Let $w$ be the share of inliers, the *inlier ratio*. A draw of two points is good when both are inliers: about $w \cdot w$ of all draws. A draw is bad with probability $1 - w^2$; all of $N$ draws are bad with $(1 - w^2)^N$. So RANSAC succeeds with probability
#
# $$P = 1 - (1 - w^2)^N.$$
#
# Now your own function has to prove it. We make scenes with a known inlier ratio, run it two hundred times on each, and count the runs that found the line: at least 80 % of its points. **Predict first:** with 10 rounds, how low may the inlier ratio be until every second run fails?

# %%
def scene(rng, inlier_ratio, roughness, n=60):
    """Points on a line 20 m long, more or less rough, and others at least 1 m away from it."""
    on_line = np.arange(n) < round(inlier_ratio * n)
    xy = rng.uniform(-10, 10, (n, 2))
    xy[on_line, 1] = rng.normal(0, roughness, on_line.sum())
    close = ~on_line & (np.abs(xy[:, 1]) < 1)
    xy[close, 1] += np.sign(xy[close, 1])
    return xy, on_line


def success_rate(rounds, inlier_ratio, roughness=0.005, tolerance=0.2, runs=200):
    """Share of runs in which your ransac_line finds the line."""
    found = 0
    for seed in range(runs):
        rng = np.random.default_rng((seed, rounds))
        xy, on_line = scene(rng, inlier_ratio, roughness)
        inliers = np.asarray(ransac_line(xy, rounds, tolerance, rng)[1])
        found += inliers[on_line].mean() >= 0.8
    return found / runs


ratios = np.array([0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
w = np.linspace(0.1, 1, 100)
theory = {f"{rounds} rounds": (w, 1 - (1 - w**2) ** rounds) for rounds in (2, 10, 40)}
measured = {f"{rounds} rounds": (ratios, [success_rate(rounds, ratio) for ratio in ratios])
            for rounds in (2, 10, 40)}
plots.curves(theory, measured, across="inlier ratio w", up="share of runs that find the line",
             title="Your RANSAC against theory");

# %% [markdown]
# Read it from left to right for ten rounds: hopeless, fair, safe. And read it upwards at w = 0.3: two rounds are a gamble, ten succeed more often than not, forty nearly always. Lesson 03 turns the formula around and asks for the number of rounds directly.
#
# These walls were smooth, to half a centimetre. Theory counts every pair of inliers as a good sample. But two rough points *close to each other* make a crooked line. **Predict first:** on a rougher wall, will your measurement lie above the curve or below it?

# %%
rounds = np.array([1, 2, 3, 5, 8, 12, 20, 30, 40])
many = np.linspace(1, 40, 200)
measured = {f"wall rough to {roughness} m": (
    rounds, [success_rate(count, 0.5, roughness, 0.6) for count in rounds])
    for roughness in (0.005, 0.1, 0.25)}
plots.curves({"theory for w = 0.5": (many, 1 - (1 - 0.5**2) ** many)}, measured, across="rounds",
             up="share of runs that find the line", title="Rough points need more rounds");

# %% [markdown]
# Below, and the rougher the farther below; with enough rounds the gap closes. So in practice take the number from the formula, and then two or three times as many: rounds are cheap.
#
# ## What real systems add
#
# *Each variant mends one weakness: the score, the draw, or the final line.*
#
# | variant | plain RANSAC's weakness | what it does instead |
# |---|---|---|
# | MSAC | a point counts 1 just inside the band and 0 just outside; of two lines with 12 inliers, either may win | adds up min(d², t²) for the distances d and the tolerance t, and keeps the smallest sum: closer is better |
# | PROSAC | all points are equally likely to be drawn, though some are known to be better (strong echo, close match) | draws from the best few first and widens the circle slowly |
# | LO-RANSAC | a line through two rough points is crooked, even if both are inliers | fits the line anew to all its inliers each time a new best one is found |
#
# The last idea is worth a try. Least squares failed because of the outliers. RANSAC has just removed them. So let the two work together: RANSAC finds *who* belongs to the line, least squares *where* it runs.

# %%
def slope_error(slope):
    """Angle in degrees between a slope and the true one, 1."""
    return abs(np.degrees(np.arctan(slope)) - 45)


alone, refitted = [], []
for seed in range(300):
    rng = np.random.default_rng(seed)
    sample = quiz_points(rng)
    (a, b, _), inliers = ransac_line(sample, 40, 1.0, rng)
    alone.append(slope_error(-a / b))
    refitted.append(slope_error(np.polyfit(*sample[inliers].T, 1)[0]))

share = np.linspace(0, 1, 300)
plots.curves({"RANSAC alone": (np.sort(alone), share),
              "then least squares on its inliers": (np.sort(refitted), share)},
             across="error of the direction (degrees)", up="share of runs with at most this error",
             title="Two that work together").set_xlim(0, 20)
print(f"half of the runs are better than {np.median(alone):.1f} degrees alone, "
      f"{np.median(refitted):.1f} degrees refitted")

# %% [markdown]
# ## From the quiz to the street
#
# *The same dozen lines, the same two parameters, thousands of points.*
#
# `cloud.txt` holds one full turn of a scanner on the roof of a car in a street: x, y, z in metres, measured from the scanner, and the brightness of the echo. We cut out a thin slice at the scanner's own height, to the right of the car, and forget the height. What is left is a set of points in the plane: house fronts, cars, trees, people. Your function looks for the longest wall; then, among what is left, for the next.

# %%
cloud = load_cloud("cloud.txt")
x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
in_slice = (np.abs(z) < 0.3) & (x > -25) & (x < 25) & (y > -17) & (y < -1)
left_over = cloud[in_slice, :2]

figure, panels = plt.subplots(2, 1, figsize=(8.5, 7.2), layout="compressed")
for name, axes in zip(("the first wall", "what is left, and the next wall"), panels):
    line, inliers = ransac_line(left_over, 100, 0.1, 1)
    plots.line_model(left_over, line, inliers, 0.1, limits=((-25, 25), (-17, 0)), axes=axes,
                     title=f"{name}: {np.sum(inliers):,} of {len(left_over):,} points")
    left_over = left_over[~np.asarray(inliers)]  # ~ turns a mask around

# %% [markdown]
# Nobody told it about house fronts, and people and cars in front of them do no harm. In lesson 03 the same idea, with one dimension more, finds the road.
#
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | no `abs` in the distance | half of the plane counts as inliers: everything on one side of the line |
# | the normal is not divided by its length | the band is too thin for points far apart, too wide for points close together |
# | the last line is returned, not the best | another line with each seed, however many rounds |
# | line and mask are not replaced together | inliers that do not lie along the line drawn |
# | y = m x + q for the line | an exception, or no wall that runs straight ahead |
# | squared distance compared with the tolerance | 0.25 acts as 0.5: the band has another width than you asked for |

# %%
diagonal, other = np.array([1, -1, 0]) / np.sqrt(2), np.array([0.2, 1.0, -3.0]) / np.hypot(0.2, 1.0)
value = points @ diagonal[:2] + diagonal[2]
wrong = {"no abs": (diagonal, value <= 1.0),
         "normal too long": (diagonal, np.abs(5 * value) <= 1.0),
         "another mask": (other, np.abs(value) <= 1.0)}
figure, row = plt.subplots(1, 3, figsize=(8.5, 3.1), layout="compressed")
for (name, (line, mask)), axes in zip(wrong.items(), row):
    small(plots.line_model(points, line, mask, 1.0, limits=((-7, 7), (-7, 7)), axes=axes,
                           title=f"{name}: {mask.sum()} inliers"))

# %% [markdown]
# ## In practice
#
# - The tolerance comes from the sensor and the thing: range noise, plus how rough a wall may be. Two or three times the noise is a good start.
# - Nobody knows the inlier ratio beforehand. Real programs stop early: after each new best line they take its own inlier ratio, compute how many rounds that needs, and stop when they are done. `max_iterations` is then only the emergency brake.
# - Keep the seed. An algorithm that rolls dice is hard to debug, unless yesterday's dice can be rolled again: that is why `rng` is a parameter.
# - When two walls are there, RANSAC finds the one with more points, not the one you meant. In lesson 03 a wall will win over the road.
#
# ## If you want more
#
# 1. Turn your function into MSAC: keep the line with the smallest sum of min(d², t²). At which tolerances does it beat the plain one on the quiz points?
# 2. Stop early: after each new best line, compute from its inlier ratio how many rounds suffice for 99 %.
# 3. Draw the second point only among the neighbours of the first, or only far from it. Which of the two helps on quiz points, which on the street, and why?
#
# ## Summary
#
# - Least squares trusts every point; one bad point can turn its line anywhere.
# - RANSAC draws as few points as make a model, counts who agrees, and keeps the best.
# - It succeeds with probability 1 − (1 − w²)^N: fewer inliers, many more rounds.
# - Degenerate samples happen. Draw without replacement, expect `None`, and go on.
# - Afterwards, least squares on the inliers makes a good line better.
#
# **Sources.** RANSAC: [Fischler and Bolles 1981](https://doi.org/10.1145/358669.358692). MSAC: [Torr and Zisserman 2000](https://doi.org/10.1006/cviu.1999.0832). PROSAC: [Chum and Matas 2005](https://doi.org/10.1109/CVPR.2005.221). LO-RANSAC: [Chum, Matas and Kittler 2003](https://doi.org/10.1007/978-3-540-45243-0_31). A survey in code: [Raguram et al. 2013](https://doi.org/10.1109/TPAMI.2012.257).
#
# **Next:** 03 · The road as a plane

# %% [markdown] tags=["footer"]
# (footer)
