# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 07 · Filter by distance
#
# ![A street from above. A dashed circle of 10 m around the sensor holds strong dots of cars and people; outside it, pale crosses. A long solid box reaches 30 m ahead, and a small box covers our own car.](07_preview.png)
#
# A scan reaches 80 m in every direction, behind the houses and into the next street. Before a computer compares points with points, it should ask of each one: can you matter to me before I can stop?
#
# **After this lesson you can**
# - keep the points that are near, with the right kind of distance, and say what one more metre costs,
# - cut a region of interest out of a street,
# - find and remove [returns](#Words-of-the-course) that do not come from obstacles.
#
# **You write** `filter_by_distance` (points), `crop_region` (points) and `remove_ego_returns` (points). **Time:** (time). **You need** boolean masks (lesson 01 or 06).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## The whole scan, for once
#
# *A scanner does not know what is near: it reports everything it can reach.*
#
# So far our pictures showed a few dozen metres of street. Here is all of the scan: x forward, y left, z up in metres, the sensor at the origin; then intensity.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_cloud, plots, predict, show_table

cloud = load_cloud("cloud.txt")
low, high = cloud[:, :3].min(axis=0), cloud[:, :3].max(axis=0)
print(f"{len(cloud):,} returns; x from {low[0]:.0f} to {high[0]:.0f} m, "
      f"y from {low[1]:.0f} to {high[1]:.0f} m, z from {low[2]:.1f} to {high[2]:.1f} m")
plots.from_above(cloud, limits=((-80, 80), (-80, 30)), title="One scan, everything it reached");

# %% [markdown]
# Draw a circle of 10 m around the sensor, in your mind. The sensor reaches 80 m, so this circle covers one part in sixty-four of the area, 1.6 %. Move the slider to your guess; your own function will answer.

# %%
within_10 = predict("What share of all returns lies within 10 m of the sensor?",
                    between=(0, 100), unit="%")

# %% [markdown]
# ## The naive idea: a ball around the sensor
#
# *A straight line to the sensor is not the way that is left to drive.*
#
# Lesson 01 threw the intensity out of the distance. So three columns, `np.linalg.norm(cloud[:, :3], axis=1)`: the straight line from the sensor to the point? Think of a lorry that carries its sensor 3.4 m up and brakes for everything within 6 m. A child stands 5.7 m in front of it. Here is the yard from the side, to scale:

# %% tags=["folded"]
# @title Scan a lorry's yard (you need not read this)
from utils.ground import Ground
from utils.simulator import Sensor, World, layers, scan
from utils.streets import numbered, placed
from utils.traffic import pedestrian

on_a_lorry = Sensor(elevations=layers(64, -50, 15), azimuth_step=np.radians(0.3),
                    origin=(0, 0, 3.4))
yard = World(Ground(), numbered([placed(pedestrian(1.2), 5.7, 0)]))
yard_scan = scan(yard, on_a_lorry, seed=7)
in_front = np.abs(yard_scan.cloud[:, 1]) < 2
seen, is_child = yard_scan.cloud[in_front], yard_scan.objects[in_front] > 0


def draw_yard(rows, keep, title):
    """The yard from the side, to scale, with 6 m along the road and 6 m in a straight line."""
    axes = plots.kept_and_removed(rows, keep, view="side to scale", limits=((-9, 9), (-3.9, 1)),
                                  title=title)
    turn = np.linspace(0, 2 * np.pi, 200)
    axes.plot(6 * np.cos(turn), 6 * np.sin(turn), color="black", linestyle="--", linewidth=1)
    axes.axvline(6, color="black", linestyle=":", linewidth=1)
    axes.text(6.15, 0.1, "6 m along\nthe road")
    axes.text(-5.7, 0.1, "6 m in a\nstraight line")
    plots.ring(axes, 5.7, -2.8, radius=0.75, text="child")


slanted = np.linalg.norm(seen[:, :3], axis=1)
draw_yard(seen, slanted <= 6, "3-D distance up to 6 m: the child is not seen")
print(f"of {is_child.sum()} returns of the child, {(slanted[is_child] <= 6).sum()} are kept")

# %% [markdown]
# The straight line to the child starts 3.4 m above the road: even to the top of its head it is longer than 6 m, though along the road only 5.7 m are left. A ball around the sensor is the wrong shape: it gets narrower towards the road, where people stand.
#
# ## Exercise 1 · `filter_by_distance` (points)
#
# *What counts is how far we can still drive, and cars do not drive upwards.*
#
# The horizontal distance of lesson 01 forgets the height:
#
# $$d(p) = \sqrt{x_p^2 + y_p^2}, \qquad \text{keep } \{\, p : d(p) \le r \,\}.$$
#
# All points with $d \le r$ form an upright cylinder around the sensor. Keep the rows whose horizontal distance is at most `distance`. The cloud may have three columns or four, and it may be empty.

# %% nbgrader={"grade": false, "grade_id": "filter_by_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_by_distance(cloud, distance=10.0):
    """Keep the points near the sensor, measured along the ground.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres, the sensor at the origin; then intensity.
    distance : float
        Largest horizontal distance in metres.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with sqrt(x^2 + y^2) <= distance, all columns, in the same order.
    """
    # 1. The horizontal distance of every point, from the columns x and y alone.
    # 2. Compare all of them with `distance`: one True or False per point.
    # 3. Index the cloud with the result.
    # roughly 2 lines
    ### BEGIN SOLUTION
    along_the_road = np.hypot(cloud[:, 0], cloud[:, 1])
    return cloud[along_the_road <= distance]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Pythagoras in the plane: square `cloud[:, 0]` and `cloud[:, 1]`, add, take the root. Column 2 is the height and stays out.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.sqrt(x**2 + y**2)` or `np.hypot(x, y)` gives one number per point. `<=` turns it into a mask, and `cloud[mask]` keeps the rows.
# </details>
# <details><summary>Hint 3</summary>
#
# Two lines: `d = np.hypot(...)` of the first two columns; `return cloud[d ...]` with the comparison for the dots. Compare with the parameter, not with 10.
# </details>
#
# **Four points first.** The first and the last are farther than 10 m. The second hangs high in a tree and the third lies deep under a bridge, but along the road they are 6.3 m and 5 m away. Two rows should be left: `[6, 2, 9, 0.1]` and `[4, 3, -12, 0.1]`.

# %%
four = np.array([[11.0, 1.0, 0.0, 0.1],
                 [6.0, 2.0, 9.0, 0.1],
                 [4.0, 3.0, -12.0, 0.1],
                 [13.0, 2.0, -0.2, 0.1]])
filter_by_distance(four)

# %% [markdown]
# **Look before you check.** The first picture should be a disc of radius 10 m, with a hole around us, into which no beam looks down, and gaps where obstacles cast shadows. In the second, the child should be there from head to feet.

# %%
near = filter_by_distance(cloud)
plots.from_above(near, limits=((-14, 14), (-11, 11)), title=f"{len(near):,} near points")

rows = np.column_stack([seen[:, :3], np.arange(len(seen))])  # a number in place of intensity
kept = filter_by_distance(rows, 6.0)[:, 3].astype(int)
draw_yard(seen, np.isin(np.arange(len(seen)), kept), "Your function: 6 m around the lorry")
within_10.compare(100 * len(near) / len(cloud),
                  "Equal angles are unequal distances on the road, so the rings of the beams "
                  "crowd together near the car. And what stands near hides what lies far.")

# %% nbgrader={"grade": true, "grade_id": "test_filter_by_distance", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_by_distance)

# %% [markdown]
# ## Play: how far should the car look?
#
# *Near the sensor a metre more brings thousands of points; far away it brings dozens.*
#
# The truth of this scan says what each return hit, so we can draw the obstacles alone, without the road. A car drives ahead of us in our own lane, right on the line y = 0. At which radius does it appear? And where does the picture stop growing? The next cell answers both.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
no_obstacle = [names.index(kind) for kind in ("invalid", "ground", "ego")]
obstacles = cloud[~np.isin(truth["classes"], no_obstacle)]
thin = obstacles[::4]  # every fourth point is enough to look at


@interact(radius=IntSlider(value=10, min=2, max=60, description="radius (m)",
                           continuous_update=False))
def show_radius(radius):
    plots.from_above(filter_by_distance(thin, radius), limits=((-35, 55), (-20, 25)),
                     title=f"Obstacles within {radius} m")
    plt.show()

# %% tags=["folded"]
# @title The same without a slider (you need not read this)
def first_radius(number):
    """The smallest radius in whole metres that leaves 20 returns of an object."""
    hits = cloud[truth["objects"] == number]
    return next(radius for radius in range(1, 81) if len(filter_by_distance(hits, radius)) >= 20)


def share_within(radii):
    """For each radius the share of the obstacles' returns that your filter leaves."""
    return [len(filter_by_distance(obstacles, radius)) / len(obstacles) for radius in radii]


radii = (10, 20, 30, 60)
shares = share_within(radii)
axes = plots.from_above(thin, limits=((-35, 55), (-20, 25)), title="Three radii in one picture")
for radius, share in zip(radii[:-1], shares):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle="--"))
    axes.text(0.82 * radius, -0.57 * radius, f"{radius} m: {share:.0%}", ha="center", va="center",
              bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1})
plots.ring(axes, 20.6, 0, radius=2, text="ahead of us")
print(f"the car ahead of us appears at {first_radius(11)} m")
print("share of the obstacles' returns:",
      ", ".join(f"{share:.0%} within {radius} m" for radius, share in zip(radii, shares)))

# %% [markdown]
# ## Cost saved against what is lost
#
# *Comparing every point with every other costs n²: halve the points, and three quarters of the work are gone.*
#
# The next step of the pipeline looks for neighbours, and the plainest way compares each point with all others: twice the points, four times the work. So we count what a radius leaves of the points above the ground, and square it.
#
# And what is lost? We count the cars, lorries, cyclists and pedestrians of which your filter leaves at least 20 returns. The dotted lines say how far a car must see what stands: it drives on for half a second while it thinks, then brakes with 7 m/s². At the speed $v$ that is $0.5\,\mathrm{s} \cdot v + v^2 / 14\,\mathrm{m/s^2}$ from its bumper, and 2.5 s from 50 km/h. (What drives towards us takes part of the way itself: in these 2.5 s the car 55 m ahead comes 13 m nearer.) The line is the theory for points that are spread evenly over the area; the markers are what your function finds.

# %% tags=["folded"]
# @title What a radius saves and what it loses (you need not read this)
kinds = [names.index(kind) for kind in ("car", "truck", "pedestrian", "cyclist")]
upright = cloud[:, 2] >= -1.2
is_user = upright & np.isin(truth["classes"], kinds)
users = np.column_stack([cloud[:, :3], truth["objects"]])[is_user]  # x, y, z, number of the object


def points_within(radii):
    """For each radius the number of points above the ground that your filter leaves."""
    return [len(filter_by_distance(cloud[upright], radius)) for radius in radii]


def users_within(radii):
    """For each radius the number of road users of which it leaves at least 20 returns."""
    numbers = [filter_by_distance(users, radius)[:, 3] for radius in radii]
    return [int((np.unique(one, return_counts=True)[1] >= 20).sum()) for one in numbers]


bumper = 2.6  # metres ahead of the sensor: a radius begins at the sensor, braking at the bumper
metres_per_second = np.array([30, 50]) / 3.6
stops = bumper + 0.5 * metres_per_second + metres_per_second**2 / 14
radii = np.array([4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 60, 80])
points = np.array(points_within([*radii, *stops])) / upright.sum()
road_users = np.array(users_within([*radii, *stops]))
road_users = road_users / road_users[12]
evenly = np.arange(4, 81)
figure, (cost, loss) = plt.subplots(1, 2, figsize=(8.5, 4.4), layout="compressed", sharey=True)
plots.curves({"points, if spread evenly": (evenly, (evenly / 80) ** 2)},
             {"points": (radii, points[:13]), "work, n²": (radii, points[:13] ** 2)},
             across="radius (m)", up="share that is left", title="What is to be done", axes=cost)
plots.curves({}, {"road users": (radii, road_users[:13])},
             across="radius (m)", title="Who is seen", axes=loss)
for speed, stop, near, some in zip((30, 50), stops, points[13:], road_users[13:]):
    for axes in (cost, loss):
        axes.axvline(stop, color="black", linestyle=":", linewidth=1)
    loss.text(stop + 0.8, 0.1 if speed == 30 else 0.25, f"stops from {speed} km/h")
    print(f"{speed} km/h: stands {stop:.1f} m from where the sensor was; beyond lie\n"
          f"         {1 - near:.0%} of the points, {1 - near**2:.0%} of the work "
          f"and {1 - some:.0%} of the road users")

# %% [markdown]
# Points and road users do not come at the same rate. Beyond the second dotted line few points are left to save, but many road users are left to lose: the far ones cost little, and a fast car needs them most. The shorter radius is enough for 30 km/h and no more. And a circle treats walls and cars alike. It cannot tell a house front from a lane. A box can.
#
# ## The idea: a region of interest
#
# *A street is long and narrow, and so is what can get in our way.*
#
# A box is given by two corners: the smallest and the largest x, y and z. A point is inside when *all* of its coordinates lie between them:
#
# $$\begin{aligned} x_{\min} \le x_p &\le x_{\max} \\ \text{and}\quad y_{\min} \le y_p &\le y_{\max} \\ \text{and}\quad z_{\min} \le z_p &\le z_{\max}. \end{aligned}$$
#
# NumPy compares a table of points with one corner column by column, and `.all(axis=1)` asks of each row whether it is `True` throughout:

# %%
sample = np.array([[3.0, 1.0, 2.5], [5.0, 2.0, -0.3], [-1.0, 4.0, 9.9]])
table = sample <= (4.0, 2.0, 3.0)
print(table)
print("all of the row:", table.all(axis=1), "  any of the row:", table.any(axis=1))

# %% [markdown]
# ## Exercise 2 · `crop_region` (points)
#
# Keep the rows inside the box, its faces included.

# %% nbgrader={"grade": false, "grade_id": "crop_region", "locked": false, "schema_version": 3, "solution": true, "task": false}
def crop_region(cloud, minimum, maximum):
    """Keep the points inside a box.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity.
    minimum, maximum : three numbers each
        Smallest and largest x, y and z in metres: tuple, list or array.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with minimum <= (x, y, z) <= maximum, all columns, in the same order.
    """
    # 1. The coordinates without the intensity.
    # 2. Compare them with both corners: two tables of True and False.
    # 3. A row is inside when both tables are True in all three columns.
    # roughly 3 lines
    ### BEGIN SOLUTION
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) & (xyz <= maximum)).all(axis=1)
    return cloud[inside]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `cloud[:, :3] >= minimum` compares every x with the first number, every y with the second and every z with the third, even when `minimum` is a tuple.
# </details>
# <details><summary>Hint 2</summary>
#
# Combine tables with `&`, and put each side in parentheses: `(a >= b) & (a <= c)`. Python's `and` and the chain `b <= a <= c` do not work on arrays.
# </details>
# <details><summary>Hint 3</summary>
#
# `inside = (... & ...).all(axis=1)`; then index the cloud, not `cloud[:, :3]`, so that the intensity stays.
# </details>
#
# **Six points first.** The region reaches 30 m ahead and 10 m back, from the first metre of the right pavement to the left kerb. The third point is inside. Each of the others leaves it on one side only: behind, ahead, on the right, on the left, above. One row should be left, `[1, 2, -1, 0.4]`.

# %%
region = (-10, -5, -2), (30, 6, 1)
six = np.array([[-11.0, 2.0, -1.0, 0.4],
                [31.0, 2.0, -1.0, 0.4],
                [1.0, 2.0, -1.0, 0.4],
                [1.0, -6.0, -1.0, 0.4],
                [1.0, 7.0, -1.0, 0.4],
                [1.0, 2.0, 1.5, 0.4]])
crop_region(six, *region)

# %% [markdown]
# **Look before you check.** Nothing may stick out of the rectangle. Then three ways to keep less of the street compete, on everything that stands above the ground.

# %%
def outline(axes, minimum, maximum):
    """Draw the walls of a box, seen from above."""
    length, width = maximum[0] - minimum[0], maximum[1] - minimum[1]
    axes.add_patch(plt.Rectangle(minimum[:2], length, width, fill=False, linestyle="--"))


street = ((-15, 35), (-14, 14))  # x from, to; y from, to
lane = crop_region(cloud, *region)
axes = plots.from_above(lane, limits=street, title=f"{len(lane):,} points in the region")
outline(axes, *region)

# %% nbgrader={"grade": true, "grade_id": "test_crop_region", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(crop_region)

# %%
fewest = predict("Which of the three keeps the fewest points above the ground?",
                 choices=["circle of 10 m", "circle of 30 m", "region of interest"])

# %% tags=["folded"]
# @title Circle against box (you need not read this)
def left_by(name):
    """Points, wall points, road users ahead in the street, and all road users ahead."""
    def keep(rows):
        if name == "region of interest":
            return crop_region(rows, *region)
        return filter_by_distance(rows, 10 if name == "circle of 10 m" else 30)

    walls = cloud[upright & (truth["classes"] == names.index("wall"))]
    ahead = users[users[:, 0] > 0]
    in_street = ahead[np.abs(ahead[:, 1] - 0.5) < 5.5]
    found = [int((np.unique(keep(rows)[:, 3], return_counts=True)[1] >= 20).sum())
             for rows in (in_street, ahead)]
    return len(keep(cloud[upright])), len(keep(walls)), *found


left = {name: left_by(name) for name in ("circle of 10 m", "circle of 30 m", "region of interest")}
show_table(["", "points", "on walls", "road users ahead, in the street", "and on the pavements, too"],
           [(name, f"{some:,}", f"{walls:,}", in_street, ahead)
            for name, (some, walls, in_street, ahead) in left.items()])
fewest.compare(min(left, key=lambda name: left[name][0]),
               "Half of the points above the ground lie on house fronts. The box leaves them all "
               "out, and far ahead there are few points to keep.")

# %% [markdown]
# The box sees as far ahead as the big circle, with fewer points than the small one, and without a single wall. What it gives up are the pavements, and who walks there: compare the last column. Somebody who steps off the pavement will be in the box only when they are on the road. That choice is yours: make it on purpose.
#
# ## Who is standing so close?
#
# Now take what stands above the ground and within 10 m of the sensor, sort it by distance, and look at the nearest returns.

# %%
nearest = predict("How far away is the nearest return of all that are left?",
                  between=(0, 10), step=0.1, unit="m", digits=1)

# %%
close = filter_by_distance(cloud[upright])
distances = np.sort(np.hypot(close[:, 0], close[:, 1]))
print("the nearest returns, in metres:", distances[:6].round(2))
print(f"within 3 m: {(distances < 3).sum()} returns")
close_up = ((-4, 6), (-3.5, 3.5))
axes = plots.from_above(close, limits=close_up, title="Something stands within arm's reach")
ego_box = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)  # around our own car, as the sensor sees it
outline(axes, *ego_box)
axes.text(-1.4, -1.6, "our own car")
nearest.compare(distances[0],
                "Some rays that found no echo are stored as a return at (0, 0, 0), the sensor "
                "itself. The next ones are parts of our own car.")

# %% [markdown]
# *A scanner also sees the car that carries it, and it reports some rays that never came back.* So two kinds of returns are no obstacles:
#
# - **Returns of [our own car](#Words-of-the-course)**: the lowest [beams](#Words-of-the-course) graze our mirrors, tailgate and aerial. They move with us and never go away: a cluster that is always 1.3 m off, and a car that never starts.
# - **Invalid returns**: a ray without an echo is sometimes stored as (0, 0, 0). Its height, 0, is above any ground level; its distance, 0, is below any radius. It survives both filters.
#
# The naive cure is a minimum distance: forget everything within 3 m.

# %%
too_near = np.hypot(close[:, 0], close[:, 1]) < 3
axes = plots.kept_and_removed(close, ~too_near, limits=close_up,
                              title="A circle that covers our car covers the places beside it, too")
outline(axes, *ego_box)
axes.add_patch(plt.Circle((0, 0), 3, fill=False, linestyle=":"))
plots.ring(axes, 0.5, -2.3, radius=0.4)
axes.text(1.05, -2.3, "a child here?", va="center");

# %% [markdown]
# Between the dashed box and the dotted circle there is room for a child beside the door, and we would be blind to it. A car is a box, so cut out a box: this time, keep what is *not* inside. The dashed one is generous, 0.6 m wider on each side than the mirrors; whoever builds a car measures it to the centimetre.
#
# ## Exercise 3 · `remove_ego_returns` (points)
#
# Keep the rows that `crop_region` would throw away. A point on a face is inside. You have the mask already: this exercise is one thought, and no new mask. What is the opposite of "inside in x and y and z"?

# %%
kept_ahead = predict("Somebody keeps what is outside in x AND in y AND in z. And the car ahead of us?",
                     choices=["it stays", "it goes, too"])

# %% nbgrader={"grade": false, "grade_id": "remove_ego_returns", "locked": false, "schema_version": 3, "solution": true, "task": false}
def remove_ego_returns(cloud, minimum, maximum):
    """Remove the points inside a box, such as the one around our own car.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity.
    minimum, maximum : three numbers each
        Smallest and largest x, y and z of the box in metres: tuple, list or array.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows that are not inside the box, faces included; all columns, in the same order.
    """
    # 1. Which rows are inside? As in crop_region.
    # 2. Keep the others: ~ turns every True of a mask into False and the other way round.
    # roughly 3 lines
    ### BEGIN SOLUTION
    xyz = cloud[:, :3]
    is_ours = ((xyz >= minimum) & (xyz <= maximum)).all(axis=1)
    return cloud[~is_ours]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# You have the mask of the rows inside already, in `crop_region`. Which of its entries do you want now?
# </details>
# <details><summary>Hint 2</summary>
#
# Invert at the very end, one value per row: `~inside`. Turning each comparison round instead calls for `.any(axis=1)` in place of `.all(axis=1)`.
# </details>
# <details><summary>Hint 3</summary>
#
# Copy the line with `inside = ...` and return `cloud[~inside]`.
# </details>
#
# **Five points first.** The first is our left mirror. The others share two coordinates with our car: a car ahead, one behind, a wall on the left, a child on the right. Only the first row may go.

# %%
five = np.array([[0.9, 1.0, -0.6, 0.4],
                 [9.0, 0.0, -0.7, 0.4],
                 [-4.0, 0.0, -0.7, 0.4],
                 [0.5, 6.0, -0.7, 0.4],
                 [0.5, -3.0, -0.7, 0.4]])
remove_ego_returns(five, *ego_box)

# %% [markdown]
# **Look before you check.** The box should be empty, and only the box.

# %%
free = remove_ego_returns(close, *ego_box)
axes = plots.from_above(free, limits=close_up,
                        title=f"{len(close) - len(free)} returns of our own car removed")
outline(axes, *ego_box)

outside = (cloud[:, :3] < ego_box[0]) | (cloud[:, :3] > ego_box[1])  # column by column
is_ahead = truth["objects"] == 11
kept_ahead.compare("it stays" if outside.all(axis=1)[is_ahead].any() else "it goes, too",
                   "It is outside in x, but inside in y: it drives in our lane. What is not inside "
                   "is outside in x OR in y OR in z.")

# %% nbgrader={"grade": true, "grade_id": "test_remove_ego_returns", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(remove_ego_returns)

# %% [markdown]
# ## The returns that never were
#
# *(0, 0, 0) is inside the sensor: nothing can be there.*
#
# The box of our car ends 0.4 m below the sensor, so the invalid returns lie outside it and survive once more. This sensor measures nothing nearer than 1 m. A second, small box around the sensor itself is therefore safe, and your function takes any box. (`drop_invalid` of lesson 01 does the same, and removes points that are not numbers, too.)

# %%
steps = {"raw scan": cloud, "above the ground": cloud[upright], "within 10 m": close,
         "without our own car": free,
         "without the sensor itself": remove_ego_returns(free, (-0.1,) * 3, (0.1,) * 3)}
show_table(["", "returns", "invalid", "the nearest"],
           [(step, f"{len(rows):,}", (rows[:, :3] == 0).all(axis=1).sum(),
             f"{np.hypot(rows[:, 0], rows[:, 1]).min():.2f} m") for step, rows in steps.items()])

# %% [markdown]
# ## Common mistakes
#
# *None of them raises an error; each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | `np.linalg.norm(cloud, axis=1)` | bright points vanish, or all of them |
# | `np.linalg.norm(cloud[:, :3], axis=1)` | a ball: what is near but far below the sensor goes, such as the child before the lorry |
# | `(np.abs(x) <= r) & (np.abs(y) <= r)` | a square, with corners 41 % too far away |
# | `x**2 + y**2 <= r` | a disc that is much too small: 3.2 m for 10 |
# | `cloud[:, 0] <= r` | half a street: everything behind us stays |
# | `any` where `all` belongs | nearly everything stays, since most heights are inside |

# %% tags=["folded"]
# @title Two of them as pictures (you need not read this)
x, y = cloud[:, 0], cloud[:, 1]
wrong = {"a square": (np.abs(x) <= 10) & (np.abs(y) <= 10), "squared ≤ plain": x**2 + y**2 <= 10}
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4.4), layout="compressed")
for (name, keep), axes in zip(wrong.items(), panels):
    plots.kept_and_removed(cloud[::6], keep[::6], limits=((-16, 16), (-16, 16)), title=name,
                           axes=axes)
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, linestyle="--"))

# %% [markdown]
# ## Let it drive
#
# *A region is judged by who steps into it.*
#
# Without points; skip it if you like. A car drives ten seconds at 30 km/h, and sees what your `crop_region` leaves. The rest is given, up to a driver who brakes for what is in the lane, or will be, within the stopping distance from above. Five seconds on, a child runs out from the kerb. Our lane reaches 1.3 m to either side.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own


def drive_with(half_width):
    """Ten seconds of a street, seen as far as this to either side."""
    mine, low, high = own(crop_region), (-5, -half_width, -2.5), (35, half_width, 1)
    return drive_street(2, chain(region=lambda points: mine(points, low, high)), seconds=10,
                        clock=on_time)


drive_with(1.6) if is_written(crop_region) else print(
    "crop_region is not written, or has not passed its check.")

# %% [markdown]
# The region holds all of our lane, and it is too narrow: what will be in the lane in a second is not in it yet. Try `drive_with(6)`. How narrow may it be before the drive ends at the child again?
#
# <details><summary>An answer</summary>
#
# 2.5 m will do: the car brakes after 7.1 s, with 8 m to go, much as with 6 m. With 2.2 m it brakes 0.3 s later, with 5 m to go, and that is too late.
# </details>

# %% [markdown]
# ## In practice
#
# - The region is not a fixed box. It follows the planned path and the lanes of a map, and it grows with the speed, because the stopping distance does.
# - Filters that look at each point alone may come in any order: it matters for speed, not for the result. (For a voxel grid or a plane fit it matters for both.) The cheapest that removes most comes first: a distance needs a handful of operations per point, a plane fit hundreds.
# - The box around a car comes from its drawings and must be checked after every change: a bicycle on the rack is a new obstacle that never goes away.
# - What a filter removes is gone for all who come after it. Safety systems keep the raw scan and watch for things that appear at the edge of the region.
#
# The same with Open3D (from 0.18 on), faces included as in yours. PCL's `CropBox` has `setMin`, `setMax` and, for our own car, `setNegative(true)`.
#
# ```python
# box = open3d.geometry.AxisAlignedBoundingBox(min_bound=(-10, -5, -2), max_bound=(30, 6, 1))
# lane = point_cloud.crop(box)
# outside = point_cloud.crop(box, invert=True)
# ```
#
# ## Summary
#
# - Distance on a road is horizontal: x and y count, height and intensity do not.
# - Points crowd near the sensor. A radius removes much of the area and little of the data; a box around the road removes walls and keeps the view ahead.
# - Our own car and invalid returns are the nearest "obstacles" of every scan. They survive ground and distance filters and need boxes of their own.
#
# **Sources.** Sensor, mounting and coordinates: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Boxes and intervals as filters: PCL's [CropBox](https://pointclouds.org/documentation/classpcl_1_1_crop_box.html) and [PassThrough](https://pointclouds.org/documentation/classpcl_1_1_pass_through.html). Broadcasting a corner over a table: [NumPy user guide](https://numpy.org/doc/stable/user/basics.broadcasting.html).
#
# **Next:** 08 · Bounding boxes

# %% [markdown]
# ## If you want more
#
# 1. Write `crop_lane(cloud, width, curvature)`, a region that bends with the road: $|y - \tfrac{1}{2} \kappa x^2| \le w / 2$.
# 2. A beam that looks down by the angle $\alpha$ from the height $h$ draws a ring of radius $h / \tan\alpha$ on a flat road, and each ring holds equally many returns. Which share of the road's returns should lie within 10 m? Compare with `filter_by_distance` on the returns of the class `ground`. (`utils.simulator.hdl64().elevations` holds the angles, `origin[2]` the height.)
# 3. Load a recording of your own with `load_cloud("path/to/file.pcd")` and find the box of its car: which points stay in the same place over ten frames of a drive?

# %% [markdown] tags=["footer"]
# (footer)
