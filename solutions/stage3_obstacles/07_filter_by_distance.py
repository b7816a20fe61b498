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
# ![A street from above. A dashed circle of 10 m around the sensor holds strong dots of cars and people; outside it, pale crosses. A long solid box reaches 30 m ahead, and a small box covers our own car.](pictures/07_preview.png)
#
# A scan reaches 80 m in every direction, behind the houses and into the next street. Before a computer compares points with points, it should ask of each one: can you matter to me within the next second?
#
# **After this lesson you can**
# - keep what is near, with the right kind of distance, and say what a metre more costs,
# - cut a region of interest out of a street,
# - find and remove the returns that are no obstacles at all: your own car, and rays that never came back.
#
# **You write** `filter_by_distance` (20 points), `crop_region` (5 points) and `remove_ego_returns` (5 points). **Time:** about 45 minutes. **You need** boolean masks (lesson 01 or 06).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## The whole scan, for once
#
# *A scanner does not know what is near: it reports everything it can reach.*
#
# So far our pictures showed a few dozen metres of street. Here is the full turn: x forward, y left, z up in metres, the sensor at the origin, then intensity.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots

cloud = load_cloud("cloud.txt")
low, high = cloud[:, :3].min(axis=0), cloud[:, :3].max(axis=0)
print(f"{len(cloud):,} returns; x from {low[0]:.0f} to {high[0]:.0f} m, "
      f"y from {low[1]:.0f} to {high[1]:.0f} m, z from {low[2]:.1f} to {high[2]:.1f} m")
plots.from_above(cloud, limits=((-80, 80), (-45, 45)), title="One turn, everything it reached");

# %% [markdown]
# **Predict first.** Draw a circle of 10 m around the sensor, in your mind. The sensor reaches 80 m, so the circle covers one part in sixty-four of the area. Which share of all returns lies inside: about 2 %, a fifth, or more than half? Write your guess down; your own function will answer.

# %% [markdown]
# ## The naive idea: the length of the row
#
# *A row is not a place: it holds a height and a brightness, too.*
#
# `np.linalg.norm` gives the length of a vector, so `np.linalg.norm(cloud, axis=1)` looks like the distance of each point. It adds up the squares of *all* columns, intensity included. In our file the intensity runs from 0 to 1 and hardly shows. But many drivers report it from 0 to 255. The same street, from such a driver:

# %%
street = ((-15, 35), (-14, 14))
other_driver = cloud * [1, 1, 1, 255]
length_of_row = np.linalg.norm(other_driver, axis=1)
plots.kept_and_removed(other_driver, length_of_row <= 10, limits=street,
                       title="Length of the row up to 10: the street is empty");

# %% [markdown]
# Every car is gone, and nothing raised an error. Three columns, then: `np.linalg.norm(cloud[:, :3], axis=1)`, the straight line from the sensor to the point? A lorry carries its sensor 3.4 m up. A child stands 5.7 m in front of it; the lorry brakes for everything within 6 m.

# %%
from utils.ground import Ground
from utils.simulator import Sensor, World, layers, scan
from utils.streets import numbered, placed
from utils.traffic import pedestrian

on_a_lorry = Sensor(elevations=layers(64, -50, 15), azimuth_step=np.radians(0.3),
                    origin=(0, 0, 3.4))
yard = World(Ground(), numbered([placed(pedestrian(1.2), 5.7, 0)]))
seen = scan(yard, on_a_lorry, seed=7).cloud
slanted = np.linalg.norm(seen[:, :3], axis=1)

ahead = np.abs(seen[:, 1]) < 2
axes = plots.kept_and_removed(seen[ahead], slanted[ahead] <= 6, view="side",
                              limits=((-9, 9), (-3.8, 1)),
                              title="3-D distance up to 6 m: the child is not seen")
turn = np.linspace(0, 2 * np.pi, 200)
axes.plot(6 * np.cos(turn), 6 * np.sin(turn), color="black", linestyle="--", linewidth=1)
axes.axvline(6, color="black", linestyle=":", linewidth=1)
axes.text(6.2, 0.5, "6 m along the road")
axes.text(5.9, -2.15, "child")
axes.text(-5.6, 0.5, "6 m in a straight line");

# %% [markdown]
# The straight line to the child starts 3.4 m above the road, so it is longer than the way that the lorry's bumper has to go. A ball around the sensor is the wrong shape: it gets narrower towards the road, where everybody stands.

# %% [markdown]
# ## The idea: distance along the road
#
# *What counts is how far we can still drive, and cars do not drive upwards.*
#
# The horizontal distance of a point $p$ forgets its height:
#
# $$d(p) = \sqrt{x_p^2 + y_p^2}, \qquad \text{keep } \{\, p : d(p) \le r \,\}.$$
#
# All points with $d \le r$ form an upright cylinder around the sensor. NumPy computes with whole columns at once:

# %%
sample = np.array([[3.0, 1.0, 2.5, 0.1],
                   [5.0, 2.0, -0.3, 0.9],
                   [-1.0, 4.0, 9.9, 0.7]])
print("x times y:    ", sample[:, 0] * sample[:, 1])
print("square root:  ", np.sqrt(sample[:, 3]))
print("rows with z<3:", sample[sample[:, 2] < 3].tolist())

# %% [markdown]
# ## Exercise 1 · `filter_by_distance` (20 points)
#
# Keep the rows whose horizontal distance is at most `distance`. The cloud may have three columns or four, and it may be empty.

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

# %% [markdown]
# **Look before you check.** The left picture should be a disc of radius 10 m, with gaps only where obstacles cast shadows. On the right, the lorry's yard: the child should be there, from head to feet.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.9), layout="compressed")
near = filter_by_distance(cloud)
plots.from_above(near, limits=((-14, 14), (-14, 14)), axes=left, title=f"{len(near):,} near points")
plots.from_side(filter_by_distance(seen[ahead], 6.0), limits=((-8, 8), (-3.8, 1)), axes=right,
                title="6 m around the lorry")
print(f"{len(near) / len(cloud):.0%} of all returns lie within 10 m. What did you predict?")

# %% nbgrader={"grade": true, "grade_id": "test_filter_by_distance", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_by_distance)

# %% [markdown]
# ## Play: how far should the car look?
#
# *Near the sensor a metre more brings thousands of points; far away it brings a dozen.*
#
# Move the slider. At which radius does a second car ahead appear? Where do the points stop coming?

# %%
thin = cloud[::6]  # every sixth point is enough to look at


@interact(distance=FloatSlider(value=10, min=2, max=60, step=1, description="radius (m)",
                               continuous_update=False))
def show_distance(distance):
    kept = filter_by_distance(thin, distance)
    plots.from_above(kept, limits=((-60, 60), (-32, 32)),
                     title=f"{len(kept) / len(thin):.0%} of the points within {distance:.0f} m")
    plt.show()

# %% [markdown]
# The same without a slider: three radii.

# %%
figure, panels = plt.subplots(1, 3, figsize=(8.5, 3.2), layout="compressed")
numbered_rows = np.column_stack([thin[:, :3], np.arange(len(thin))])  # number for intensity
for distance, axes in zip((5, 10, 30), panels):
    is_near = np.zeros(len(thin), dtype=bool)
    is_near[filter_by_distance(numbered_rows, distance)[:, 3].astype(int)] = True
    plots.kept_and_removed(thin, is_near, limits=((-32, 32), (-26, 26)), axes=axes,
                           title=f"{distance} m: {is_near.mean():.0%}")

# %% [markdown]
# ## Theory against practice: where do the points lie?
#
# *Equal angles are unequal distances on the road, so the rings of the beams crowd together near the car.*
#
# A beam that looks down by the angle $\alpha$ from the height $h$ meets a flat road at the distance $h / \tan\alpha$ and draws a ring there. Each ring holds equally many returns. So the share of road returns within a radius is the share of rings within it, and that we can count without any scan.
#
# To see whether this is true, scan an empty flat road, and compare with our street. Your own function does the counting.

# %%
from utils.datasets import DATA
from utils.simulator import hdl64

sensor = hdl64()
downwards = -np.array([angle for angle in sensor.elevations if angle < 0])
rings = sensor.origin[2] / np.tan(downwards)
radii = np.geomspace(3.5, 80, 60)
in_theory = [(rings <= radius).sum() / (rings <= 80).sum() for radius in radii]

truth = np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
roads = {"an empty road": scan(World(), sensor, seed=7).cloud,
         "our street": cloud[truth["classes"] == names.index("ground")]}
few = radii[::4]
axes = plots.curves(
    {"rings within the radius": (radii, in_theory)},
    {name: (few, [len(filter_by_distance(road, radius)) / len(road) for radius in few])
     for name, road in roads.items()},
    across="radius (m)", up="share of the road returns",
    title="Half of the road lies within a few steps")
axes.set_xscale("log")
axes.set_xticks([4, 6, 10, 20, 40, 80], [4, 6, 10, 20, 40, 80])
axes.minorticks_off()

# %% [markdown]
# The empty road follows the theory. In our street even more of the road is near, because parked cars and houses catch the flat beams before they reach the far end of it.
#
# So a radius of 10 m removes 98 % of the area, but much less of the points. If you wanted to save work with it, that is a disappointment. Let us see what is saved, and what it costs.

# %% [markdown]
# ## Cost saved against what is lost
#
# *Comparing every point with every other costs n²: halve the points, and three quarters of the work are gone.*
#
# The next step of the pipeline looks for neighbours. The plainest way compares each point with all others. We time that on what your filter leaves of the obstacles, thinned to every twelfth point, for growing radii. On logarithmic axes a power of n is a straight line; the legend says which power fits.

# %%
import time


def count_neighbours(points):
    """How many points lie within 0.5 m of each point: every point against every other."""
    return [(((points - point) ** 2).sum(axis=1) < 0.25).sum() for point in points]


standing = thin[thin[:, 2] >= -1.2, :3][::2]
numbers, seconds = [], []
for radius in (5, 6, 8, 10, 15, 80):
    kept = filter_by_distance(standing, radius)
    begin = time.perf_counter()
    count_neighbours(kept)
    numbers.append(len(kept))
    seconds.append(time.perf_counter() - begin)
    print(f"within {radius:2d} m: {len(kept):6,} points, {seconds[-1]:6.2f} s")
plots.timing({"your filter, then all pairs": (numbers, seconds)},
             title="Work grows with the square of the points that are left");

# %% [markdown]
# And what is lost? The truth of this scan knows every car, lorry, cyclist and pedestrian. We count those of which at least 20 returns are left. The dotted lines say how far a car must see: it drives on for half a second while it thinks, then brakes with 7 m/s². At the speed $v$ that is $0.5\,\mathrm{s} \cdot v + v^2 / 14\,\mathrm{m/s^2}$.

# %%
kinds = [names.index(kind) for kind in ("car", "truck", "pedestrian", "cyclist")]
users = np.isin(truth["classes"], kinds)
upright = cloud[:, 2] >= -1.2
returns = np.column_stack([cloud[:, :3], truth["objects"]])[users & upright]  # x, y, z, number


def users_left(radius):
    """Road users with at least 20 returns within a radius."""
    _, count = np.unique(filter_by_distance(returns, radius)[:, 3], return_counts=True)
    return (count >= 20).sum()


distances_upright = np.hypot(*cloud[upright, :2].T)
radii = np.array([4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 60, 80])
points = np.array([len(filter_by_distance(cloud[upright], radius)) for radius in radii])
axes = plots.curves({"points": (radii, points / points[-1]),
                     "work, n²": (radii, (points / points[-1]) ** 2),
                     "road users": (radii, [users_left(r) / users_left(80) for r in radii])},
                    across="radius (m)", up="share that is left",
                    title="What a radius saves, and what it loses")
bumper = 2.6  # metres ahead of the sensor: a radius begins at the sensor, braking at the bumper
for speed in (30, 50):
    metres_per_second = speed / 3.6
    stop = bumper + 0.5 * metres_per_second + metres_per_second**2 / 14
    axes.axvline(stop, color="black", linestyle=":", linewidth=1)
    axes.text(stop + 0.6, 0.04, f"stops from\n{speed} km/h")
    near = (distances_upright <= stop).mean()
    print(f"{speed} km/h: stands {stop:.1f} m from where the sensor was; beyond lie {1 - near:.0%} of "
          f"the points, {1 - near**2:.0%} of the work and "
          f"{1 - users_left(stop) / users_left(80):.0%} of the road users")

# %% [markdown]
# Points and road users do not come at the same rate. Beyond the second dotted line few points are left to save, but many road users are left to lose: the far ones cost little, and a fast car needs them most. The shorter radius is enough for 30 km/h and no more. And a circle treats walls and cars alike. It cannot tell a house front from a lane. A box can.

# %% [markdown]
# ## The idea: a region of interest
#
# *A street is long and narrow, and so is what can get in our way.*
#
# A box is given by two corners: the smallest and the largest x, y and z. A point is inside when *all* of its coordinates lie between them:
#
# $$x_{\min} \le x_p \le x_{\max} \ \text{ and }\ y_{\min} \le y_p \le y_{\max} \ \text{ and }\ z_{\min} \le z_p \le z_{\max}.$$
#
# NumPy compares a table of points with one corner column by column, and `.all(axis=1)` asks of each row whether it is `True` throughout:

# %%
limit = np.array([4.0, 2.0, 3.0])
table = sample[:, :3] <= limit
print(table)
print("all of the row:", table.all(axis=1), "  any of the row:", table.any(axis=1))

# %% [markdown]
# ## Exercise 2 · `crop_region` (5 points)
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

# %% [markdown]
# **Look before you check.** The region reaches 30 m ahead and 10 m back, from the first metre of the right pavement to the left kerb. Nothing may stick out of the rectangle.

# %%
def outline(axes, minimum, maximum):
    """Draw the walls of a box, seen from above."""
    length, width = maximum[0] - minimum[0], maximum[1] - minimum[1]
    axes.add_patch(plt.Rectangle(minimum[:2], length, width, fill=False, linestyle="--"))


region = (-10, -5, -2), (30, 6, 1)
lane = crop_region(cloud, *region)
axes = plots.from_above(lane, limits=street, title=f"{len(lane):,} points in the region")
outline(axes, *region)

# %% nbgrader={"grade": true, "grade_id": "test_crop_region", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(crop_region)

# %% [markdown]
# Circle against box, on everything that stands above the road:

# %%
choices = {"circle of 10 m": lambda rows: filter_by_distance(rows, 10),
           "circle of 30 m": lambda rows: filter_by_distance(rows, 30),
           "region of interest": lambda rows: crop_region(rows, *region)}
ahead = returns[returns[:, 0] > 0]
in_street = np.abs(ahead[:, 1] - 0.5) < 5.5
walls = cloud[upright & (truth["classes"] == names.index("wall"))]
print(f"{'':20}   points   walls   road users ahead: in the street, and with the pavements")
for name, keep in choices.items():
    users = [(np.unique(keep(rows)[:, 3], return_counts=True)[1] >= 20).sum()
             for rows in (ahead[in_street], ahead)]
    print(f"{name:20} {len(keep(cloud[upright])):8,} {len(keep(walls)):7,} {users[0]:7} {users[1]:7}")

# %% [markdown]
# The box sees as far ahead as the big circle, with fewer points than the small one, and without a single wall. What it gives up are the pavements, and who walks there: the last column. Somebody who steps off the pavement will be in the box only when they are on the road: that choice is yours, and it should be a conscious one.

# %% [markdown]
# ## Who is standing so close?
#
# *A scanner also sees the car that carries it, and it reports some rays that never came back.*
#
# Take the obstacles near the car, sort them by distance, and look at the nearest ones.
#
# **Predict first.** How near is the nearest return that survives the ground level and your distance filter?

# %%
obstacles = filter_by_distance(cloud[upright])
distances = np.sort(np.hypot(obstacles[:, 0], obstacles[:, 1]))
print("the nearest returns, in metres:", distances[:6].round(2))
print(f"within 3 m: {(distances < 3).sum()} returns")
close_up = ((-4, 6), (-4, 4))
axes = plots.from_above(obstacles, limits=close_up, title="Something stands within arm's reach")
ego_box = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)  # around our own car, as the sensor sees it
outline(axes, *ego_box)
axes.text(-1.4, -1.6, "our own car");

# %% [markdown]
# Two kinds of returns that are no obstacles:
#
# - **Ego returns**: the lowest beams graze our own mirrors, tailgate and aerial. They move with us and never go away: a cluster that is always 1.3 m off, and a car that never starts.
# - **Invalid returns**: a ray without an echo is sometimes stored as (0, 0, 0). Its height, 0, is above any ground level; its distance, 0, is below any radius. It survives both filters.
#
# The naive cure is a minimum distance: forget everything within 3 m.

# %%
too_near = np.hypot(obstacles[:, 0], obstacles[:, 1]) < 3
axes = plots.kept_and_removed(obstacles, ~too_near, limits=close_up,
                              title="A circle that covers our car covers the places beside it, too")
outline(axes, *ego_box)
axes.add_patch(plt.Circle((0, 0), 3, fill=False, linestyle=":"))
axes.text(0.5, -2.35, "a child here?", ha="center");

# %% [markdown]
# Between the dashed box and the dotted circle there is room for a child beside the door, and we would be blind to it. A car is a box, so cut out a box: this time, keep what is *not* inside. The dashed one is generous, 0.6 m wider on each side than the mirrors; who builds a car measures it to the centimetre.
#
# Mind your logic there. "Not (inside in x and y and z)" is "outside in x **or** y **or** z". Someone who asks for outside in x *and* y *and* z throws away nearly everything: whatever shares just one coordinate with our car.
#
# ## Exercise 3 · `remove_ego_returns` (5 points)
#
# Keep the rows that are not inside the box.

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

# %% [markdown]
# **Look before you check.** The box should be empty, and only the box.

# %%
free = remove_ego_returns(obstacles, *ego_box)
axes = plots.from_above(free, limits=close_up,
                        title=f"{len(obstacles) - len(free)} returns of our own car removed")
outline(axes, *ego_box)

# %% nbgrader={"grade": true, "grade_id": "test_remove_ego_returns", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(remove_ego_returns)

# %% [markdown]
# ## The returns that never were
#
# *(0, 0, 0) is inside the sensor: nothing can be there.*
#
# The box of our car ends 0.4 m below the sensor, so the invalid returns lie outside it and survive once more. This sensor measures nothing nearer than 1 m. A second, small box around the sensor itself is therefore safe, and your function takes any box. (`drop_invalid` of lesson 01 does the same, and removes points that are not numbers, too.)

# %%
def report(step, rows):
    invalid = (rows[:, :3] == 0).all(axis=1).sum()
    nearest = np.hypot(rows[:, 0], rows[:, 1]).min()
    print(f"{step:28} {len(rows):8,} returns, {invalid} invalid, nearest {nearest:.2f} m")


report("raw scan", cloud)
report("above the ground", cloud[upright])
report("within 10 m", obstacles)
report("without our own car", free)
report("without the sensor itself", remove_ego_returns(free, (-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)))

# %% [markdown]
# ## Common mistakes
#
# *None of them raises an error; each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | `np.linalg.norm(cloud, axis=1)` | bright points vanish, or all of them |
# | `np.linalg.norm(cloud[:, :3], axis=1)` | a ball: the road and the feet of people go first |
# | `(np.abs(x) <= r) & (np.abs(y) <= r)` | a square, with corners 41 % too far away |
# | `x**2 + y**2 <= r` | a disc that is much too small: 3.2 m for 10 |
# | `cloud[:, 0] <= r` | half a street: everything behind us stays |
# | `any` where `all` belongs | nearly everything stays, since most heights are inside; in the picture, which leaves out the heights, a cross of two endless strips |

# %%
x, y = thin[:, 0], thin[:, 1]
beside_x, beside_y = (x >= -5) & (x <= 15), (y >= -3) & (y <= 4)
wrong = {"a square": (np.abs(x) <= 10) & (np.abs(y) <= 10),
         "squared ≤ plain": x**2 + y**2 <= 10,
         "any for all": beside_x | beside_y}
figure, panels = plt.subplots(1, 3, figsize=(8.5, 3.2), layout="compressed")
for (name, keep), axes in zip(wrong.items(), panels):
    plots.kept_and_removed(thin, keep, limits=((-20, 25), (-22, 22)), title=name, axes=axes)

# %% [markdown]
# ## In practice
#
# - The region is not a fixed box. It follows the planned path and the lanes of a map, and it grows with the speed, because the stopping distance does.
# - Filters that look at each point alone may come in any order: it matters for speed, not for the result. (For a voxel grid or a plane fit it matters for both.) The cheapest that removes most comes first: a distance needs a handful of operations per point, a plane fit hundreds.
# - Ego boxes come from the drawings of the car and must be checked after every change: a bicycle on the rack is a new ego return.
# - What a filter removes is gone for all who come after it. Safety systems keep the raw scan and watch for things that appear at the edge of the region.
#
# ## If you want more
#
# 1. Write `crop_lane(cloud, width, curvature)`, a region that bends with the road: $|y - \tfrac{1}{2} \kappa x^2| \le w / 2$.
# 2. Give the circle a stopping distance: choose the radius from the speed, and draw how the work grows with it.
# 3. Load a recording of your own with `load_cloud("path/to/file.pcd")` and find its ego box: which points stay in the same place over ten frames of a drive?
#
# ## Summary
#
# - Distance on a road is horizontal: x and y count, height and intensity do not.
# - Points crowd near the sensor. A radius removes much of the area and little of the data; a box around the road removes walls and keeps the view ahead.
# - Our own car and invalid returns are the nearest "obstacles" of every scan. They survive ground and distance filters and need boxes of their own.
#
# **Sources.** Sensor, mounting and coordinates: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Crop box and pass-through filters: [Rusu and Cousins 2011](https://doi.org/10.1109/ICRA.2011.5980567). Broadcasting a corner over a table: [NumPy user guide](https://numpy.org/doc/stable/user/basics.broadcasting.html).
#
# **Next:** 08 · Bounding boxes

# %% [markdown] tags=["footer"]
# (footer)
