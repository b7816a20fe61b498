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
# ![A street from above. Inside a dashed circle of 10 m around the sensor, the points of cars and people are bold dots. Outside it, points are pale crosses. A long box with solid lines reaches 30 m ahead, and a small box covers the ego car.](07_preview.png)
#
# A scan reaches 80 m in every direction, past houses and into the next street. The car can stop long before it gets that far, so a filter drops the distant points first.
#
# **After this lesson you can**
# - keep the points near the car, use the right kind of distance, and say what a larger radius costs,
# - cut a straight or bent region of interest out of a street,
# - find and remove [returns](#Words-of-the-course) that do not come from obstacles.
#
# **You write** `filter_by_distance` (points), `crop_region` (points) and `remove_ego_returns` (points). **You need** boolean masks (lesson 01 or 06). All packages listed at the end are allowed. **Time:** (time: 60).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## The whole scan
#
# The columns are x (forward), y (left) and z (up), in metres from the sensor, and the intensity.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider, interact

from utils import check, load_street, plots, predict, show_table

cloud, truth = load_street()  # `truth` says what each return hit
low, high = cloud[:, :3].min(axis=0), cloud[:, :3].max(axis=0)
print(f"{len(cloud):,} returns; x from {low[0]:.0f} to {high[0]:.0f} m, "
      f"y from {low[1]:.0f} to {high[1]:.0f} m, z from {low[2]:.1f} to {high[2]:.1f} m")
plots.from_above(cloud, limits=((-80, 80), (-80, 30)), title="One scan, out to 80 m");

# %% [markdown]
# Imagine a circle with a radius of 10 m around the sensor. It covers only 1/64 of the area that the sensor reaches, or 1.6 %.

# %%
within_10 = predict("What share of all returns is within 10 m of the sensor?",
                    between=(0, 100), unit="%")

# %% [markdown]
# ## The naive idea: a ball around the sensor
#
# Why do we not use the straight-line distance, `np.linalg.norm(cloud[:, :3], axis=1)`? Think of a lorry in a yard. It carries its sensor 3.4 m above the ground, and brakes for everything within 6 m. A child is 5.7 m in front of the sensor. Here is the yard from the side, to scale.

# %% tags=["folded"]
# @title Scan the yard of a lorry (you need not read this)
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
    """Draw the yard from the side, with 6 m along the road and 6 m in a straight line."""
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
print(f"{(slanted[is_child] <= 6).sum()} of the {is_child.sum()} returns from the child are kept")

# %% [markdown]
# The straight line starts 3.4 m above the ground. Even to the top of the child's head, it is longer than 6 m, although the child is only 5.7 m ahead. A ball is the wrong shape, because it gets narrower towards the ground, where people stand.
#
# ## Exercise 1 · `filter_by_distance` (points)
#
# *Cars do not drive upwards, so only the horizontal distance counts.*
#
# $$d(p) = \sqrt{x_p^2 + y_p^2}, \qquad \text{keep } \{\, p : d(p) \le r \,\}.$$
#
# Keep the rows whose horizontal distance is at most `distance`.
#
# In all three exercises, the cloud may have three or four columns, and it may be empty, but it does not contain NaN. If no row is left, return an empty array with the same columns.

# %% nbgrader={"grade": false, "grade_id": "filter_by_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_by_distance(cloud, distance=10.0):
    """Keep the points near the sensor, with distances measured along the ground.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres from the sensor, then perhaps intensity.
    distance : float
        Largest horizontal distance in metres.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with sqrt(x^2 + y^2) <= distance, with all columns and in the same order.
    """
    # 1. Use only the columns x and y to compute the horizontal distance of every point.
    # 2. Compare all of them with `distance`. This gives one True or False per point.
    # 3. Index the cloud with the result.
    # roughly 2 lines
    ### BEGIN SOLUTION
    along_the_road = np.hypot(cloud[:, 0], cloud[:, 1])
    return cloud[along_the_road <= distance]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Use Pythagoras in the plane: square `cloud[:, 0]` and `cloud[:, 1]`, add them, and take the square root.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.sqrt(x**2 + y**2)` or `np.hypot(x, y)` gives one number per point. `<=` turns it into a mask, and `cloud[mask]` keeps the rows.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `d = np.hypot(...)` with the first two columns, and `return cloud[d ...]` with the comparison in place of the dots. Compare with the parameter `distance`, not with the number 10.
# </details>
#
# **Four points first.** The first and the last point are more than 10 m away. The second is in a tree and the third is under a bridge, but along the road they are only 6.3 m and 5 m away. Only these two rows should be left.

# %%
four = np.array([[11.0, 1.0, 0.0, 0.1],
                 [6.0, 2.0, 9.0, 0.1],
                 [4.0, 3.0, -12.0, 0.1],
                 [13.0, 2.0, -0.2, 0.1]])
filter_by_distance(four)

# %% [markdown]
# **Look before you check.** The first picture should show a disc with a radius of 10 m. It has a hole around the car, where no beam reaches the road, and shadows behind obstacles. In the second picture, the child should be blue from head to toe.

# %%
near = filter_by_distance(cloud)
plots.from_above(near, limits=((-14, 14), (-11, 11)), title=f"{len(near):,} near points")

rows = np.column_stack([seen[:, :3], np.arange(len(seen))])  # row numbers instead of intensity
kept = filter_by_distance(rows, 6.0)[:, 3].astype(int)
draw_yard(seen, np.isin(np.arange(len(seen)), kept), "Your function: 6 m around the lorry")
within_10.compare(100 * len(near) / len(cloud),
                  "The angles between neighbouring beams are similar, so their rings on the road are "
                  "close together near the car. Also, near objects hide objects behind them.")

# %% nbgrader={"grade": true, "grade_id": "test_filter_by_distance", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_by_distance)

# %% [markdown]
# ## Play: how far should the car look?
#
# *Near the sensor, one more metre adds thousands of points. Far away, it adds dozens.*
#
# The scan is simulated, so we know what each return comes from, and can draw only the obstacles. A car drives ahead of us in our lane, on the line y = 0. At which radius does it appear? Beyond which radius does the picture hardly change?

# %%
names = truth["class_names"].tolist()
no_obstacle = [names.index(kind) for kind in ("invalid", "ground", "ego")]
obstacles = cloud[~np.isin(truth["classes"], no_obstacle)]
thin = obstacles[::4]  # every fourth point is enough for a picture


@interact(radius=IntSlider(value=10, min=2, max=60, description="radius (m)",
                           continuous_update=False))
def show_radius(radius):
    plots.from_above(filter_by_distance(thin, radius), limits=((-35, 55), (-20, 25)),
                     span=(-1.2, 0.8), title=f"Obstacles within {radius} m")
    plt.show()

# %% tags=["folded"]
# @title The same without a slider (you need not read this)
def first_radius(number):
    """Return the smallest radius, in whole metres, that leaves 20 returns of an object."""
    hits = cloud[truth["objects"] == number]
    return next(radius for radius in range(1, 81) if len(filter_by_distance(hits, radius)) >= 20)


def share_within(radii):
    """Return the share of the obstacles' returns that your filter keeps, for each radius."""
    return [len(filter_by_distance(obstacles, radius)) / len(obstacles) for radius in radii]


radii = (10, 20, 30, 60)
shares = share_within(radii)
axes = plots.from_above(thin, limits=((-35, 55), (-20, 25)), title="Three radii in one picture")
for radius, share in zip(radii[:-1], shares):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle="--"))
    axes.text(0.82 * radius, -0.57 * radius, f"{radius} m: {share:.0%}", ha="center", va="center",
              bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1})
plots.ring(axes, 20.6, 0, radius=2, text="ahead of us")
print(f"the car ahead of us appears at {first_radius(11)} m, with 20 returns")
print("share of the obstacles' returns:",
      ", ".join(f"{share:.0%} within {radius} m" for radius, share in zip(radii, shares)))

# %% [markdown]
# ## What a radius removes, and what it loses
#
# *Comparing every point with every other point takes n² steps, so half the points need only a quarter of the work.*
#
# The next cell counts how much each radius leaves: points above the ground, work (points squared), and road users. A road user counts if at least 20 of its returns are left.
#
# The dotted lines show how far ahead a car must see a stationary obstacle. The car drives on for half a second while it thinks, and then brakes at 7 m/s². From the speed $v$, it stops after $0.5\,\mathrm{s} \cdot v + \frac{v^2}{2 \cdot 7\,\mathrm{m/s^2}}$, measured from its bumper, 2.6 m ahead of the sensor.

# %% tags=["folded"]
# @title What a radius removes and what it loses (you need not read this)
kinds = [names.index(kind) for kind in ("car", "truck", "pedestrian", "cyclist")]
upright = cloud[:, 2] >= -1.2
is_user = upright & np.isin(truth["classes"], kinds)
users = np.column_stack([cloud[:, :3], truth["objects"]])[is_user]  # x, y, z, number of the object


def points_within(radii):
    """Return the number of points above the ground that your filter keeps, for each radius."""
    return [len(filter_by_distance(cloud[upright], radius)) for radius in radii]


def users_within(radii):
    """Return the number of road users that keep at least 20 returns, for each radius."""
    numbers = [filter_by_distance(users, radius)[:, 3] for radius in radii]
    return [int((np.unique(left, return_counts=True)[1] >= 20).sum()) for left in numbers]


bumper = 2.6  # metres ahead of the sensor, where a radius starts; braking starts at the bumper
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
             across="radius (m)", up="share that is left", title="Points and work", axes=cost)
plots.curves({}, {"road users": (radii, road_users[:13])},
             across="radius (m)", title="Road users seen", axes=loss)
for speed, stop, near, some in zip((30, 50), stops, points[13:], road_users[13:]):
    for axes in (cost, loss):
        axes.axvline(stop, color="black", linestyle=":", linewidth=1)
    loss.text(stop + 0.8, -0.03, f"stops from {speed} km/h", rotation=90)
    print(f"From {speed} km/h, the car needs a radius of {stop:.1f} m. This removes {1 - near:.0%} of "
          f"the points\nand {1 - near**2:.0%} of the work, and loses {1 - some:.0%} of the road users.")

# %% [markdown]
# Beyond the second dotted line, there are few points left to remove, but many road users left to lose. A circle also keeps house fronts. A box can leave them out.
#
# ## The idea: a region of interest
#
# *A street is long and narrow, and so is the region that matters to the car.*
#
# A box is defined by two corners: the smallest and the largest x, y and z. A point is inside if *all* of its coordinates are between them.
#
# $$\begin{aligned} x_{\min} \le x_p &\le x_{\max} \\ \text{and}\quad y_{\min} \le y_p &\le y_{\max} \\ \text{and}\quad z_{\min} \le z_p &\le z_{\max}. \end{aligned}$$
#
# NumPy compares a table of points with a corner column by column. Then `.all(axis=1)` says for each row whether all of its entries are `True`:

# %%
sample = np.array([[3.0, 1.0, 2.5], [5.0, 2.0, -0.3], [-1.0, 4.0, 9.9]])
table = sample <= (4.0, 2.0, 3.0)
print(table)
print("all in the row:", table.all(axis=1), "  any in the row:", table.any(axis=1))

# %% [markdown]
# ## Exercise 2 · `crop_region` (points)
#
# Keep the rows inside the box, including points on its faces.

# %% nbgrader={"grade": false, "grade_id": "crop_region", "locked": false, "schema_version": 3, "solution": true, "task": false}
def crop_region(cloud, minimum, maximum):
    """Keep the points inside a box.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres, then perhaps intensity.
    minimum, maximum : three numbers each
        Smallest and largest x, y and z in metres, as tuples, lists or arrays.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with minimum <= (x, y, z) <= maximum, with all columns and in the same order.
    """
    # 1. Take the coordinates without the intensity.
    # 2. Compare them with both corners. This gives two tables of True and False.
    # 3. Keep each row for which both tables are True in all three columns.
    # roughly 3 lines
    ### BEGIN SOLUTION
    xyz = cloud[:, :3]
    inside = ((xyz >= minimum) & (xyz <= maximum)).all(axis=1)
    return cloud[inside]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `cloud[:, :3] >= minimum` compares every x with the first number, every y with the second and every z with the third, even if `minimum` is a tuple.
# </details>
# <details><summary>Hint 2</summary>
#
# Combine tables with `&`, and put each side in parentheses: `(a >= b) & (a <= c)`. Python's `and` and the chain `b <= a <= c` do not work on arrays.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `inside = (... & ...).all(axis=1)`. Then index the cloud, not `cloud[:, :3]`, so that you keep the intensity.
# </details>
#
# **Six points first.** The region is 40 m of the street. The third point is inside. Each of the others is outside on one side only: behind, ahead, right, left or above. Only the row `[1, 2, -1, 0.4]` should be left.

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
# **Look before you check.** No point should be outside the dashed box. The dotted circles, with radii of 10 m and 30 m, are for the comparison below.

# %%
def outline(axes, minimum, maximum):
    """Draw the walls of a box, seen from above."""
    length, width = maximum[0] - minimum[0], maximum[1] - minimum[1]
    axes.add_patch(plt.Rectangle(minimum[:2], length, width, fill=False, linestyle="--"))


lane = crop_region(cloud, *region)
axes = plots.from_above(lane, limits=((-15, 35), (-14, 14)),
                        title=f"{len(lane):,} points in the region")
outline(axes, *region)
for radius in (10, 30):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle=":"))

# %% nbgrader={"grade": true, "grade_id": "test_crop_region", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(crop_region)

# %%
fewest = predict("Which of these keeps the fewest points above the ground?",
                 choices=["circle of 10 m", "circle of 30 m", "region of interest"])

# %% tags=["folded"]
# @title Circle against box (you need not read this)
def left_by(name):
    """Count points, wall points, road users ahead in the street, and all road users ahead."""
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
show_table(["", "points", "on walls", "road users ahead in the street", "all road users ahead"],
           [(name, f"{some:,}", f"{walls:,}", in_street, ahead)
            for name, (some, walls, in_street, ahead) in left.items()])
fewest.compare(min(left, key=lambda name: left[name][0]),
               "Half of the points above the ground are on house fronts. The box leaves out all of "
               "them, and far ahead there are few points to keep.")

# %% [markdown]
# The box reaches as far ahead as the large circle, but has fewer points than the small one, and not a single wall. It leaves out the people on the pavements, who enter the box only when they reach the kerb.
#
# ## A region that bends
#
# *While the driver holds the steering wheel still, the car follows a circle.*
#
# In the straight lane ahead, the first obstacle is a pedestrian. What is in the way if the driver steers left? A circle of radius $R$ has the *curvature* $\kappa = 1/R$. At a distance $x$ ahead, the middle of the lane has moved to the left by about $\tfrac{1}{2} \kappa x^2$. A lane of width $w$ therefore consists of the points with
#
# $$|y_p - \tfrac{1}{2} \kappa x_p^2| \le w / 2.$$
#
# The formula is good while $x$ is small compared with $R$. On a circle with a radius of 25 m, the formula puts the middle 9 cm too far to the right at 10 m ahead, and 2 m too far at 20 m.
#
# The function below keeps a straight lane. Change one line so that the lane bends. This task has no check. Of the three points in the last line of the cell, the first and the third should be left. In the picture, all blue points should be between the dashed lines.

# %%
def crop_lane(cloud, width, curvature):
    """Keep the points in a lane that bends. A curvature of 0.04 (1/m) is a circle of 25 m."""
    middle = 0  # change this to the y of the middle of the lane at the x of each point
    return cloud[np.abs(cloud[:, 1] - middle) <= width / 2]


print(crop_lane(np.array([[10.0, 2.0, -1.0], [10.0, 0.0, -1.0], [20.0, 8.5, -1.0]]), 2.6, 0.04))

# %% tags=["folded"]
# @title Draw the lane (you need not read this)
ahead = upright & (truth["objects"] > 0) & (cloud[:, 0] > 0) & (cloud[:, 0] < 25)
rows = np.column_stack([cloud[ahead, :3], np.flatnonzero(ahead)])  # numbers instead of intensity
in_lane = crop_lane(rows, 2.6, 0.04)[:, 3].astype(int)
axes = plots.kept_and_removed(cloud[ahead], np.isin(np.flatnonzero(ahead), in_lane),
                              limits=((0, 25), (-6, 14)), title="A lane that bends to the left")
plots.ring(axes, 8.9, -0.3, radius=0.8, text="pedestrian")
for side in (-1.3, 1.3):
    x = np.linspace(0, 25)
    axes.plot(x, 0.02 * x**2 + side, color="black", linestyle="--", linewidth=1)
numbers, sizes = np.unique(truth["objects"][in_lane], return_counts=True)
hits = [in_lane[truth["objects"][in_lane] == number] for number in numbers[sizes >= 20]]
for metres, first in sorted((cloud[rows, 0].min(), rows[0]) for rows in hits):
    print(f"{metres:4.0f} m ahead: {names[truth['classes'][first]]}")

# %% [markdown]
# <details><summary>An answer</summary>
#
# Write `middle = curvature * cloud[:, 0]**2 / 2`. The pedestrian is no longer in the lane. Instead, a car that turns towards us is in the lane, 6 m ahead, with a parked lorry (`truck`) behind it.
# </details>
#
# ## Returns that do not come from obstacles
#
# We sort the points above the ground within 10 m by their distance.

# %%
nearest = predict("How far away is the nearest of these returns?",
                  between=(0, 10), step=0.1, unit="m", digits=1)

# %%
close = filter_by_distance(cloud[upright])
distances = np.sort(np.hypot(close[:, 0], close[:, 1]))
print("the nearest returns, in metres:", distances[:6].round(2))
print(f"within 3 m: {(distances < 3).sum()} returns")
close_up = ((-4, 6), (-3.5, 3.5))
axes = plots.from_above(close, limits=close_up, title="What is so close?")
ego_box = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)  # around the ego car, as the sensor sees it
outline(axes, *ego_box)
axes.text(-1.4, -1.6, "ego car")
nearest.compare(distances[0],
                "Some rays without an echo are stored as returns at (0, 0, 0), the place of the "
                "sensor itself. The next returns come from the ego car.")

# %% [markdown]
# These returns are of two kinds:
#
# - **Returns from the [ego car](#Words-of-the-course)**: The lowest [beams](#Words-of-the-course) hit its mirrors, tailgate and aerial. These returns look like an obstacle that is always 1.3 m away, so the car would never drive off.
# - **Invalid returns**: A ray without an echo is sometimes stored as (0, 0, 0). This point is above the ground level and within every radius, so it survives both filters.
#
# The naive solution is a minimum distance. We drop everything within 3 m.

# %%
too_near = np.hypot(close[:, 0], close[:, 1]) < 3
axes = plots.kept_and_removed(close, ~too_near, limits=close_up,
                              title="The circle also covers the space next to the car")
outline(axes, *ego_box)
axes.add_patch(plt.Circle((0, 0), 3, fill=False, linestyle=":"))
plots.ring(axes, 0.5, -2.3, radius=0.4)
axes.text(-0.05, -2.3, "a child here?", ha="right", va="center");

# %% [markdown]
# Between the dashed box and the dotted circle, there is room for a child next to the door, but the car would not see this child. A car has the shape of a box, so we cut out a box. (Ours is 0.6 m wider on each side than the car with its mirrors.)
#
# ## Exercise 3 · `remove_ego_returns` (points)
#
# A colleague has already written this function. It should remove the points inside a box and keep all others, but it has a mistake.

# %%
def remove_like_a_colleague(cloud, minimum, maximum):
    """Remove the points inside a box. (This version is wrong.)"""
    outside = (cloud[:, :3] < minimum) | (cloud[:, :3] > maximum)  # one column for each axis
    return cloud[outside.all(axis=1)]

# %%
kept_ahead = predict("The colleague's version removes the ego car. What happens to the car "
                     "ahead of us?", choices=["it stays", "it is removed"])

# %% tags=["folded"]
# @title Draw what the colleague's version keeps (you need not read this)
is_vehicle = upright & np.isin(truth["classes"], [names.index(kind) for kind in ("car", "truck")])
rows = np.column_stack([cloud[is_vehicle, :3], np.flatnonzero(is_vehicle)])  # numbers, not intensity
left_over = remove_like_a_colleague(rows, *ego_box)[:, 3].astype(int)
axes = plots.kept_and_removed(cloud[is_vehicle], np.isin(np.flatnonzero(is_vehicle), left_over),
                              limits=((-14, 26), (-8, 10)),
                              title="The colleague's version: what is left of cars and lorries")
outline(axes, *ego_box)
plots.ring(axes, 20.6, 0, radius=2, text="ahead of us")
kept_ahead.compare("it stays" if (truth["objects"][left_over] == 11).any() else "it is removed",
                   "The car is outside in x but inside in y, because it drives in our lane. The "
                   "function keeps only points that are outside in x AND in y AND in z.")

# %% [markdown]
# The colleague's version also removes all points at the height of the box, so each car within 25 m loses more than half of its points. Find the mistake, and write the function without it. You may also use your mask from `crop_region`. A point on a face counts as inside.

# %% nbgrader={"grade": false, "grade_id": "remove_ego_returns", "locked": false, "schema_version": 3, "solution": true, "task": false}
def remove_ego_returns(cloud, minimum, maximum):
    """Remove the points inside a box, such as the box around the ego car.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres, then perhaps intensity.
    minimum, maximum : three numbers each
        Smallest and largest x, y and z of the box in metres, as tuples, lists or arrays.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows neither inside the box nor on its faces, with all columns and in the same order.
    """
    # 1. Make a mask with one value for each row: True if the point is not inside the box.
    # 2. Index the cloud with it.
    # roughly 2 lines
    ### BEGIN SOLUTION
    xyz = cloud[:, :3]
    is_ours = ((xyz >= minimum) & (xyz <= maximum)).all(axis=1)
    return cloud[~is_ours]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# When is a point not inside the box? It is enough if one of its coordinates is outside.
# </details>
# <details><summary>Hint 2</summary>
#
# Which word in the colleague's last line demands that all three coordinates are outside? Or start from your mask in `crop_region`. `~` turns every True in a mask into False, and every False into True.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `.any(axis=1)` instead of `.all(axis=1)`. Or copy the line with `inside = ...` from `crop_region`, and return `cloud[~inside]`.
# </details>
#
# **Five points first.** The first is the left mirror. Each of the others is inside on two axes, but not on all three: a car ahead, a car behind, a wall on the left, and a child on the right. Only the first row should be removed.

# %%
five = np.array([[0.9, 1.0, -0.6, 0.4],
                 [9.0, 0.0, -0.7, 0.4],
                 [-4.0, 0.0, -0.7, 0.4],
                 [0.5, 6.0, -0.7, 0.4],
                 [0.5, -3.0, -0.7, 0.4]])
remove_ego_returns(five, *ego_box)

# %% [markdown]
# **Look before you check.** The box should be empty, and nothing else should be missing.

# %%
free = remove_ego_returns(close, *ego_box)
axes = plots.from_above(free, limits=close_up,
                        title=f"{len(close) - len(free)} returns of the ego car removed")
outline(axes, *ego_box);

# %% nbgrader={"grade": true, "grade_id": "test_remove_ego_returns", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(remove_ego_returns)

# %% [markdown]
# ## The invalid returns
#
# The box of the ego car ends 0.4 m below the sensor, so the invalid returns are outside it and survive. Your function works with any box, and the sensor measures nothing closer than 1 m. So it is safe to remove a second, small box around the sensor. (`drop_invalid` of lesson 01 also removes them.)

# %%
steps = {"raw scan": cloud, "above the ground": cloud[upright], "within 10 m": close,
         "without the ego car": free,
         "without the sensor itself": remove_ego_returns(free, (-0.1,) * 3, (0.1,) * 3)}
show_table(["", "returns", "invalid", "nearest"],
           [(step, f"{len(rows):,}", (rows[:, :3] == 0).all(axis=1).sum(),
             f"{np.hypot(rows[:, 0], rows[:, 1]).min():.2f} m") for step, rows in steps.items()])

# %% [markdown]
# ## Common mistakes
#
# | what the code contains | what you see |
# |---|---|
# | `np.linalg.norm(cloud[:, :3], axis=1)` | points just inside the circle vanish if they are far below the sensor, such as the child in front of the lorry |
# | `np.linalg.norm(cloud, axis=1)` | the same points vanish, and a few more; if intensities reach 255, nearly all points vanish |
# | `(np.abs(x) <= r) & (np.abs(y) <= r)` | a square, whose corners are 41 % too far away |
# | `x**2 + y**2 <= r` | hardly anything, because the radius is 3.2 m instead of 10 m, and most returns within 3.2 m come from the ego car |
# | `any` instead of `all` | nearly everything, because most heights are inside the region |

# %% tags=["folded"]
# @title Draw two of these mistakes (you need not read this)
x, y = cloud[:, 0], cloud[:, 1]
wrong = {"a square": (np.abs(x) <= 10) & (np.abs(y) <= 10), "squared ≤ plain: hardly anything": x**2 + y**2 <= 10}
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4.4), layout="compressed")
for (name, keep), axes in zip(wrong.items(), panels):
    plots.kept_and_removed(cloud[::6], keep[::6], limits=((-16, 16), (-16, 16)), title=name,
                           axes=axes)
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, linestyle="--"))

# %% [markdown]
# ## Let it drive
#
# This drive is optional. A car drives for ten seconds at 30 km/h, and sees only the points that your `crop_region` keeps. The driver brakes for obstacles within the stopping distance that are in the lane, or will be soon. After five seconds, a child runs into the street from the kerb. The lane reaches 1.3 m to either side. The cell takes 10 to 30 seconds.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own  # own(f) is your function f, never a stored answer


def drive_with(half_width):
    """Drive ten seconds through a street that the car sees up to `half_width` on each side."""
    mine, low, high = own(crop_region), (-5, -half_width, -2.5), (35, half_width, 1)
    return drive_street(2, chain(region=lambda points: mine(points, low, high)), seconds=10,
                        clock=on_time)


drive_with(6) if is_written(crop_region) else print(
    "crop_region is not written, or has not passed its check.")

# %% [markdown]
# With 6 m to either side, the car brakes with 9 m to go. Now try `drive_with(1.6)`. The region still contains the whole lane, so why does the car hit the child? Then find the narrowest region that is wide enough, in steps of 10 cm. Can you beat 2.5 m?
#
# <details><summary>An answer</summary>
#
# With 1.6 m, the car sees the child only when the child is almost in the lane. The narrowest region that is wide enough reaches 2.3 m to either side. With it, the car brakes after 7.2 s with 7 m to go, and does not hit the child. With 2.2 m or 1.6 m, the car brakes after 7.4 s with 5 m to go, which is too late.
# </details>

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(filter_by_distance)

# %% [markdown]
# ## In practice
#
# - In real cars, the region follows the planned path and grows with the stopping distance.
# - The box around a car must be checked after every change to the car. A bicycle on the rack is a new obstacle that never goes away.
#
# PCL has `CropBox`. Open3D (version 0.18 or later) also keeps points on the faces:
#
# ```python
# box = open3d.geometry.AxisAlignedBoundingBox(min_bound=(-10, -5, -2), max_bound=(30, 6, 1))
# lane = point_cloud.crop(box)
# outside = point_cloud.crop(box, invert=True)
# ```
#
# ## Summary
#
# - Distance on a road is horizontal, so it uses only x and y.
# - A radius removes most of the area, but not most of the points. A box around the road removes walls and keeps the view ahead.
# - The ego car and invalid returns survive the ground and distance filters, and need boxes of their own.
#
# **Sources.** Sensor, mounting and coordinates: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). A box as a filter: PCL's [CropBox](https://pointclouds.org/documentation/classpcl_1_1_crop_box.html). Broadcasting a corner over a table: [NumPy user guide](https://numpy.org/doc/stable/user/basics.broadcasting.html).
#
# **Next:** 08 · Bounding boxes

# %% [markdown]
# ## If you want more
#
# 1. From the height $h$, a beam that points downwards at an angle $\alpha$ draws a ring of radius $h / \tan\alpha$ on a flat road. Each ring has the same number of returns. What share of the road's returns should be within 10 m? Compare your result with the share that your function keeps of the class `ground`. (`utils.simulator.hdl64().elevations` contains the angles, and `origin[2]` is the height.) (20 minutes)
# 2. Load your own recording with `load_cloud("path/to/file.pcd")`, and find the box of its car. Which points stay in place over ten frames? (20 minutes)

# %% [markdown] tags=["footer"]
# (footer)
