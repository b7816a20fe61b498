# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [two_errors, vanishes_at, points_left, by_voxels]
# ---

# %% [markdown]
# # 06 · Filter the ground
#
# ![A street seen from the side. A dashed line half a metre above the road separates grey points of the road below from dark points of cars, people and walls above.](06_preview.png)
#
# To a LiDAR, road and obstacle are the same: points. The road is where the car may go, so every point of it that stays in the cloud is an obstacle that is not there.
#
# **After this lesson you can**
# - remove the ground from a scan with a single comparison, and say when that is not enough,
# - thin a cloud to a fifth of its points, and say which objects benefit and which suffer.
#
# **You write** `filter_ground` (points) and `voxel_grid` (points). **You need** NumPy arrays and boolean masks (lesson 01). **Time:** (time).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## One scan
#
# *All heights are measured from the sensor.*
#
# The file `cloud.txt` holds one scan of a 64-beam LiDAR on the roof of [our own car](#Words-of-the-course): one row per [return](#Words-of-the-course), with x (forward), y (left) and z (up) in metres and an intensity between 0 and 1. All coordinates are measured from the sensor.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots, predict, show_table

cloud = load_cloud("cloud.txt")
print(f"{len(cloud):,} returns, {cloud.shape[1]} columns, heights from "
      f"{cloud[:, 2].min():.1f} to {cloud[:, 2].max():.1f} m")
cloud[:3]

# %%
street = ((-15, 40), (-12, 12))  # x from, to; y from, to
plots.from_above(cloud, limits=street, title="The street from above, coloured by height");

# %% [markdown]
# Think of where the sensor sits, and what it hits. Two guesses, before you see how the heights are distributed:

# %%
peak = predict("At which height z do the most returns lie?", between=(-3, 3), step=0.1,
               unit="m", digits=1)
share = predict("What share of all returns is ground (road and pavement)?",
                between=(0, 100), unit="%")

# %% [markdown]
# The scan was simulated, so for each return we know what it hit.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
kinds = truth["class_names"][truth["classes"]]  # for each return a word, such as "ground" or "car"

plots.histogram(cloud[:, 2], label="height z (m)", marks={"road under the car": -1.73},
                title="Where the returns are, by height")
counts, edges = np.histogram(cloud[:, 2], bins=np.arange(-3.5, 3.05, 0.1))
fullest = np.argmax(counts)
peak.compare(edges[fullest] + 0.05, f"Most lie between {edges[fullest]:.1f} and "
             f"{edges[fullest + 1]:.1f} m: that is the ground. The sensor sits 1.73 m above the "
             "road under the car; the street climbs, and a pavement is a kerb higher.")
share.compare(100 * np.mean(kinds == "ground"), "Most beams point downwards, but more than half "
              "of the returns come from what stands in their way, most of them from walls and cars.")

# %% [markdown]
# The tall peak is road and pavement; it is wide because the street slopes. The long shoulder to its right is everything else: cars, people, walls, trees. A good ground level lies at the foot of the peak, where the shoulder begins.
#
# ## The naive idea: ground is where z is 0
#
# *Heights are relative to the sensor, and nothing in the data says how high the sensor is.*
#
# A map has its zero on the ground. So let us keep what lies above the line z = 0 and look from the side.

# %%
near = cloud[np.abs(cloud[:, 1]) < 4]  # a slice of street, 8 m wide
plots.from_side(near, level=0.0, limits=((-15, 40), (-3, 3)),
                title="Above z = 0 there is hardly a car left");

# %% [markdown]
# Whole cars lie below the line: their roofs are lower than our sensor. The zero of this cloud is on *our* roof.
#
# The level depends on how the sensor is mounted, so it must be a parameter.
#
# ## The idea: one level, a little above the road
#
# *Half a metre of margin forgives bumps, slopes and noise, and costs the wheels of the cars.*
#
# Let $g$ be the ground level. Keep the points
#
# $$\{\, p : z_p \ge g \,\}.$$
#
# With the road at about $-1.7$ m, $g = -1.2$ m leaves half a metre for kerbs, potholes and range noise. We lose wheels and feet, but nearly all of a car without wheels still makes one cluster. (Of nine cars within 25 m, six do at half a metre; three lose some points, and lesson 05 shows why.)
#
# ## Exercise 1 · `filter_ground` (points)
#
# A mask of lesson 01, with the level as a parameter. Keep the rows at or above `ground_level`. The cloud may have three columns or four, and it may be empty.

# %% nbgrader={"grade": false, "grade_id": "filter_ground", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_ground(cloud, ground_level=-1.2):
    """Remove the ground: keep the points at or above a height.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres, the sensor at the origin; then intensity.
    ground_level : float
        Height in metres, relative to the sensor.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with z >= ground_level, all columns, in the same order.
    """
    # 1. Compare the heights of all points with the level: one True or False per point.
    # 2. Index the cloud with the result.
    # roughly 2 lines
    ### BEGIN SOLUTION
    stands_above = cloud[:, 2] >= ground_level
    return cloud[stands_above]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `cloud[:, 2]` is the column of heights. Which comparison says "at or above"?
# </details>
# <details><summary>Hint 2</summary>
#
# The comparison gives a mask: one `True` or `False` per row. Index rows with it: `cloud[mask]`, not `cloud[:, mask]`.
# </details>
# <details><summary>Hint 3</summary>
#
# `mask = cloud[:, 2] ...` with the comparison and `ground_level` for the dots; then `return cloud[mask]`. Do not write -1.2 into the function: it is the default of the parameter already.
# </details>

# %% [markdown]
# **Seven points first.** Four of them stand above -1.2 m: the bumper, the door, the roof and the sign. These four rows should come back, in this order and with all four columns.

# %%
seven = np.array([[6.0, 0.5, -1.73, 0.20],   # road
                  [6.2, 0.5, -0.90, 0.90],   # a bumper
                  [8.0, -2.0, -1.58, 0.30],  # a kerb
                  [8.1, -2.0, -1.15, 0.40],  # the lowest part of a door
                  [9.0, 3.0, 0.10, 0.60],    # the roof of a van
                  [9.5, 3.0, -1.70, 0.10],   # road
                  [4.0, 1.0, 1.40, 0.80]])   # a sign
print(filter_ground(seven))

# %% [markdown]
# **Look before you check.** The first picture should show a street without a road, but for some streaks more than 20 m ahead, which we shall come back to. In the second, nothing may lie below the dashed line.

# %%
obstacles = filter_ground(cloud)
print(f"{len(cloud):,} points in, {len(obstacles):,} points out")
figure, (above, beside) = plt.subplots(2, 1, figsize=(8.5, 7), layout="compressed")
plots.from_above(obstacles, limits=street, title="From above", axes=above)
plots.from_side(filter_ground(near), level=-1.2, limits=((-15, 40), (-3, 3)),
                title="From the side", axes=beside);

# %% nbgrader={"grade": true, "grade_id": "test_filter_ground", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(filter_ground)
# %% [markdown]
# ## Play: how high is high enough?
#
# *Too low and the ground comes back; too high and obstacles go.*

# %%
thin = cloud[::12]  # every twelfth point is enough to look at


@interact(level=FloatSlider(value=-1.2, min=-2.2, max=0.6, step=0.1, description="level (m)",
                            continuous_update=False))
def show_level(level):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street,
                     title=f"{len(kept) / len(thin):.0%} of the points stand above {level:.1f} m")
    plt.show()

# %% [markdown]
# The same without a slider: three levels. Colours mean the same heights in all of them.

# %%
figure, rows = plt.subplots(3, 1, figsize=(8.5, 10.5), layout="compressed")
for level, axes in zip((-1.6, -1.2, -0.5), rows):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street, axes=axes,
                     title=f"ground_level = {level} m keeps {len(kept) / len(thin):.0%}")
plots.ring(rows[1], -11.7, -2.7, radius=2.5, text="a car")
plots.ring(rows[2], -11.7, -2.7, radius=2.5, text="no car");

# %% [markdown]
# ## Theory against practice: what does the best level cost?
#
# *No single height separates ground from obstacles; the best one balances two errors.*
#
# With the truth we can count two kinds of error for every level: ground that stays (an obstacle that is not there) and obstacle that goes (a blind spot). Your own `filter_ground` does the counting.

# %%
ground = cloud[kinds == "ground"]
objects = truth["objects"]  # the number of the object behind each return; 0: none
upright = cloud[objects > 0]  # all returns from objects that stand on the ground


def two_errors(levels):
    """For each level the share of the ground that stays, and of the obstacles that go."""
    stays = [len(filter_ground(ground, level)) / len(ground) for level in levels]
    goes = [1 - len(filter_ground(upright, level)) / len(upright) for level in levels]
    return np.array(stays), np.array(goes)

# %%
levels = np.round(np.arange(-2.2, 0.3, 0.05), 2)
ground_kept, obstacles_lost = two_errors(levels)

axes = plots.curves({"ground that stays": (levels, ground_kept),
                     "obstacles that go": (levels, obstacles_lost)},
                    across="ground_level (m)", up="share of its points",
                    title="The two errors of a ground level")
axes.axvline(-1.2, color="black", linestyle=":", label="the default, -1.2 m")
axes.legend()
crossing = levels[np.argmin(np.abs(ground_kept - obstacles_lost))]
print(f"the curves cross at {crossing:.2f} m; half of the ground lies below "
      f"{np.median(ground[:, 2]):.2f} m")

# %% [markdown]
# The default stands to the right of the crossing. That is a choice: an obstacle that is not there makes the car brake for nothing in every scan, while the lowest half metre of an obstacle is what we can spare.
#
# And at the default some ground is still there. Where does it come from? Look along the street, from far behind to far ahead.

# %%
left_over = filter_ground(ground)
distance = np.hypot(left_over[:, 0], left_over[:, 1])
print(f"{len(left_over):,} ground points stay, "
      + (f"the nearest of them {distance.min():.0f} m away" if len(distance) else "none at all"))
plots.from_side(ground[np.abs(ground[:, 1]) < 6], level=-1.2, limits=((-40, 75), (-3.5, 1)),
                title="The road is not flat: far ahead it rises above the level");

# %% [markdown]
# A street has a crown, a kerb and a slope. One degree of slope lifts the road by 0.5 m over 30 m: exactly our margin. Near the car a level is enough. For the whole scan, fit a plane to the road, as RANSAC does in lesson 03.

# %% [markdown]
# ## Thinning: too many points where we need them least
#
# *The density of a scan falls with the square of the distance on whatever stands upright, and faster on the road: most points lie where everything is already clear.*
#
# The next lessons compare points with their neighbours, which takes time for every point. So we want fewer points. The naive way is to keep every fifth row. From here on we use `upright`, the returns of all objects that stand on the ground. We take them from the truth: what follows does not need your exercise 1.

# %% tags=["folded"]
# @title What is left of a wall, of a pedestrian and of three cars (you need not read this)
def show_what_is_left(ways):
    """Show, for some objects, how many points each way of thinning leaves: a dict of functions."""
    table = []
    for kind, number in (("wall", 30), ("pedestrian", 15), ("car", 1), ("car", 8), ("car", 72)):
        rows = np.flatnonzero(objects[objects > 0] == number)
        far = np.hypot(*upright[rows, :2].mean(axis=0))
        table.append((f"{kind} {number}", f"{far:.0f} m", f"{len(rows):,}",
                      *(f"{way(rows):,}" for way in ways.values())))
    show_table(["object", "distance", "returns", *ways], table)

# %%
def by_skipping(rows):
    """How many of these rows of `upright` are left when every fifth row is kept."""
    return np.sum(rows % 5 == 0)


show_what_is_left({"every fifth": by_skipping})

# %% [markdown]
# Skipping rows thins everything by the same factor. The wall still has far more points than its shape needs, and the last car, 29 m away, is down to a few dozen. We want the same density everywhere.
#
# ## The idea: one point per box of space
#
# *Cut space into cubes and replace all points of a cube by their mean.*
#
# With cubes of side $s$ (a [*voxel*](#Words-of-the-course), a pixel with volume), a point $p$ lies in the cell
#
# $$\left(\left\lfloor \tfrac{x}{s} \right\rfloor,\ \left\lfloor \tfrac{y}{s} \right\rfloor,\ \left\lfloor \tfrac{z}{s} \right\rfloor\right).$$
#
# Points with the same three whole numbers share a cell. Their mean, the *centroid*, stands for all of them, intensity included.
#
# Two tools of NumPy do most of the work. `np.unique` finds the different numbers of an array, and tells for each which of them it is. A cell is three numbers, so `as_numbers` first makes one of each row: computers sort numbers several times as fast as rows.

# %%
def as_numbers(rows):
    """One whole number for each row of whole numbers: equal for equal rows, and for no others."""
    rows = np.asfortranarray(rows)  # column by column in memory: sooner gone through
    rows = rows - rows.min(axis=0)
    extent = rows.max(axis=0) + 1
    if not np.log2(extent).sum() < 62:  # more rows are possible than there are numbers
        return np.unique(rows, axis=0, return_inverse=True)[1].ravel()
    return np.ravel_multi_index(rows.T.astype(int), extent.astype(int))


cells = np.array([[0, 1], [3, 2], [0, 1], [0, 1]])
different, which, how_many = np.unique(as_numbers(cells), return_inverse=True, return_counts=True)
print("a number for each row:", as_numbers(cells), "  different ones:", different)
print("row by row:", which, "  how many of each:", how_many)

# %% [markdown]
# So rows 0, 2 and 3 are of kind 0, and row 1 is of kind 1. Now add up something for each kind, here four prices. There is a trap:

# %%
prices = np.array([10, 1, 5, 2])

sums = np.zeros(2)
sums[which] += prices
print("sums[which] += prices: ", sums, "   only the last one of each kind!")

sums = np.zeros(2)
np.add.at(sums, which, prices)
print("np.add.at:             ", sums, "  10 + 5 + 2, and 1")

# %% [markdown]
# `sums[which] += prices` reads all old values first, which are zeros, and then writes 10, 1, 5 and 2 to their places. Place 0 is written three times, and the last write, 2, wins. `np.add.at` adds one after the other. It takes whole rows as well as single numbers.
#
# ## Exercise 2 · `voxel_grid` (points)
#
# Return one centroid per occupied cell, in any order.

# %% nbgrader={"grade": false, "grade_id": "voxel_grid", "locked": false, "schema_version": 3, "solution": true, "task": false}
def voxel_grid(cloud, voxel_size=0.2):
    """Thin a cloud: one centroid per occupied cube.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres; then intensity.
    voxel_size : float
        Side of a cube in metres.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The mean of all columns over the points of each occupied cell
        floor(xyz / voxel_size); any order of rows.
    """
    # 1. An empty cloud has no cells: return an empty cloud with the same columns.
    # 2. The cell of each point: three whole numbers. Mind what happens below zero.
    # 3. The different cells, which of them each point is in, and how many points each holds.
    # 4. Add up the rows of each cell: np.add.at(sums, which, rows) does that in one go.
    # 5. Divide the sums by the counts.
    # roughly 7 lines
    ### BEGIN SOLUTION
    cloud = cloud[np.isfinite(cloud[:, :3]).all(axis=1)]
    if len(cloud) == 0:
        return cloud
    cell_of_point = np.floor(cloud[:, :3] / voxel_size)
    _, rank, count = np.unique(as_numbers(cell_of_point), return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), cloud.shape[1]))
    np.add.at(sums, rank, cloud)
    return sums / count[:, None]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `np.floor(cloud[:, :3] / voxel_size)` gives the cells. `.astype(int)` alone would round towards zero and glue the cells on both sides of the sensor together.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.unique(as_numbers(cells), return_inverse=True, return_counts=True)` gives three things. The second says for each point which cell it belongs to; the third has one entry for each cell.
# </details>
# <details><summary>Hint 3</summary>
#
# `sums = np.zeros((number_of_cells, cloud.shape[1]))`, then `np.add.at(sums, which, cloud)`. Divide by the counts as a column, `counts[:, None]`, so that each row is divided by its own number.
# </details>

# %% [markdown]
# **Four voxels first.** Seven points, cells of half a metre. Two points share a cell, three share another, and two are alone. By hand: the two become (0.2, 0.2, 0.2) with intensity 0.3, the three become (0.7, 0.7, 0.2) with 0.4.

# %% tags=["folded"]
# @title Draws points, cells and centroids (you need not read this)
def draw_cells(points, centroids, size, up=1, title=""):
    """From above, or from the side with up=2; the lines are the borders of the cells."""
    figure, axes = plt.subplots(figsize=(8.5, 4.2), layout="compressed")
    low, high = np.floor(points.min(axis=0) / size), np.floor(points.max(axis=0) / size) + 1
    for column, axis, draw_line in ((0, axes.xaxis, axes.axvline), (up, axes.yaxis, axes.axhline)):
        borders = np.arange(low[column], high[column] + 1) * size
        for border in borders:
            draw_line(border, color="0.8", linewidth=0.8)
        axis.set_ticks(borders[::len(borders) // 10 + 1])
    axes.plot(points[:, 0], points[:, up], "o", color="0.6",
              markersize=3.5 if len(points) > 50 else 9,
              label=f"{len(points):,} points")
    axes.plot(centroids[:, 0], centroids[:, up], "x", color="#D55E00", markersize=7,
              markeredgewidth=2, label=f"{len(centroids):,} centroids")
    axes.set(aspect="equal", xlabel="x, forward (m)", ylabel="y, left (m)" if up == 1 else "z, up (m)")
    axes.spines[:].set_visible(False)
    axes.set_title(title, loc="left", fontweight="bold", pad=26)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)

# %%
few = np.array([[0.1, 0.1, 0.2, 0.2], [0.3, 0.3, 0.2, 0.4],                          # two
                [0.6, 0.8, 0.3, 0.1], [0.8, 0.6, 0.1, 0.3], [0.7, 0.7, 0.2, 0.8],    # three
                [0.7, 0.2, 0.1, 0.6], [-0.2, 0.3, 0.1, 0.5]])                        # alone
four = voxel_grid(few, 0.5)
print(np.round(four, 3))
draw_cells(few, four, 0.5, title="Seven points from above, in four cells of 0.5 m");

# %% [markdown]
# **Look before you check.** Now the flank of a real car, from the side. Each square that holds points should hold exactly one centroid, and the shape of the car should survive.

# %%
flank = cloud[(objects == 1) & (cloud[:, 1] > -2.4)]
flank[:, 1] = -2.1  # pressed flat, so that each square of the picture is one cell
draw_cells(flank, voxel_grid(flank, 0.2), 0.2, up=2,
           title="The flank of a car from the side, cells of 0.2 m");

# %% nbgrader={"grade": true, "grade_id": "test_voxel_grid", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(voxel_grid)
# %% [markdown]
# And the walls, pedestrians and cars from above? Both ways of thinning leave about as many points in all, so the comparison is fair.

# %%
def by_voxels(rows):
    """How many centroids the voxel grid leaves of these rows of `upright`."""
    return len(voxel_grid(upright[rows], 0.2))

# %%
everything = np.arange(len(upright))
print(f"In all: {by_skipping(everything):,} by skipping, {by_voxels(everything):,} centroids")
show_what_is_left({"every fifth": by_skipping, "voxels of 0.2 m": by_voxels})

# %% [markdown]
# The grid takes from the near and gives to the far. What is near keeps fewer points than by skipping, but plenty; the two far cars keep more than twice as many. A centroid stands for a piece of surface, and a surface far away has as many pieces as one nearby.
#
# ## Play: detail against cost
#
# *Bigger cells save work, until the objects melt.*

# %%
fewer = predict("A cell of 0.4 m holds eight times the volume of a cell of 0.2 m. "
                "How many times fewer points will be left?", between=(1, 8), step=0.1,
                digits=1)

# %%
@interact(size=FloatSlider(value=0.2, min=0.1, max=1.0, step=0.1, description="cell (m)",
                           continuous_update=False))
def show_cells(size):
    draw_cells(flank, voxel_grid(flank, size), size, up=2, title=f"cells of {size:.1f} m")
    plt.show()

# %%
def points_left(sizes):
    """How many centroids are left of all that stands on the ground, for each size of the cells."""
    return np.array([len(voxel_grid(upright, size)) for size in sizes])

# %%
sizes = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6])
left = points_left(sizes)
axes = plots.curves({"surfaces: $s^{-2}$": (sizes, left[3] * (sizes / sizes[3]) ** -2),
                     "poles and edges: $s^{-1}$": (sizes, left[3] * (sizes / sizes[3]) ** -1)},
                    {"your voxel_grid": (sizes, left)},
                    across="cell size (m)", up="points left",
                    title="Points left by a voxel grid")
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xticks(sizes, [f"{size:g}" for size in sizes])
axes.set_yticks([300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000],
                ["300", "1,000", "3,000", "10,000", "30,000", "100,000", "300,000"])
axes.minorticks_off()
fewer.compare(left[2] / left[3], "A LiDAR sees surfaces, not volumes: four times fewer cells "
              "touch a surface, two times fewer touch a pole or an edge. A street has both.")

# %% [markdown]
# A surface of area $A$ passes through about $A / s^2$ cubes of side $s$: a line of slope $-2$ on logarithmic axes. A pole or an edge of length $L$ passes through $L / s$ cubes: slope $-1$. The measured points lie in between. At the left end they rise less than either line: there is little to merge where most cells hold a single point.

# %% [markdown]
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | `<` instead of `>=` | a road without cars: the complement |
# | the wrong column, `cloud[:, 1]` | half a street: everything on the right is gone |
# | `abs(z)` in the comparison | everything stays: heights below the sensor count as high |
# | `.astype(int)` without `np.floor` | cells around the sensor are twice as wide |
# | `sums[which] += cloud` | centroids are pulled towards the sensor |
# | `0.2` written into the function | the slider does nothing |

# %% tags=["folded"]
# @title Four masks, three of them wrong (you need not read this)
wrong = {"as it should be": thin[:, 2] > -1.2, "< instead of >=": ~(thin[:, 2] > -1.2),
         "column 1 instead of 2": thin[:, 1] > -1.2, "abs(z)": np.abs(thin[:, 2]) > -1.2}
figure, grid = plt.subplots(2, 2, figsize=(8.5, 7.8), layout="compressed")
for (name, keep), axes in zip(wrong.items(), grid.flat):
    plots.kept_and_removed(thin, keep, limits=((-10, 20), (-12, 12)), title=name, axes=axes)

# %% [markdown]
# ## Let it drive
#
# *A level is judged by what a car does with it.*
#
# Without points; skip it if you like. A car drives ten seconds up a street that climbs by 6 %, and sees it through your `filter_ground`. The rest is given: thinning, clusters, boxes, and a driver who brakes for every box in the lane that is nearer than the way it needs to stop.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own


def drive_with(level, street=6, seconds=10):
    """Ten seconds of a street, seen through your filter."""
    mine = own(filter_ground)
    return drive_street(street, chain(ground=lambda points: mine(points, level)),
                        seconds=seconds, clock=on_time)


drive_with(-1.2) if is_written(filter_ground) else print(
    "filter_ground is not written, or has not passed its check.")

# %% [markdown]
# It brakes for bare asphalt: 0.53 m above the road under us, a climb of 6 % reaches the level 9 m ahead of the sensor. (The strip counts from the bumper, 2.6 m further on, and from where that is when the answer comes.) Open a braking below the strip to see its frame. Which level drives through? Then send the same level downhill, where somebody crosses after ten seconds: `drive_with(level, street=16, seconds=13)`. A level is right for one slope; lesson 03 has a plane that climbs along.
#
# <details><summary>An answer</summary>
#
# At -0.6 m the car never brakes. Downhill the same level leaves a box of the person in the last scans only: too late, and the drive ends there.
# </details>

# %% [markdown]
# ## In practice
#
# - Libraries have both filters. In Open3D the second exercise is one call; its grid begins at the lowest corner of the cloud, ours at the sensor:
#
#   ```python
#   import open3d
#   cloud = open3d.io.read_point_cloud("scan.pcd")
#   thinned = cloud.voxel_down_sample(voxel_size=0.2)
#   ```
#
#   In the Point Cloud Library they are [`PassThrough`](https://pcl.readthedocs.io/projects/tutorials/en/latest/passthrough.html) on the field "z", with `setFilterLimits`, and [`VoxelGrid`](https://pcl.readthedocs.io/projects/tutorials/en/latest/voxel_grid.html), with `setLeafSize`.
# - Cars do not use one level. They fit planes piece by piece; or they go outward along one azimuth, from [beam](#Words-of-the-course) to beam, and look for the first jump in height: on a flat road neighbouring rings lie at foreseeable distances, and an obstacle shortens them.
# - Level and margin come from calibration: the sensor's height changes by centimetres with the load of the car.
# - A voxel grid stands at the start of nearly every pipeline; 0.1 to 0.3 m is usual in a city. The real-time lessons (10 to 12) show when you can do without.
#
# ## Summary
#
# - Coordinates are relative to the sensor; the ground level is a property of the car.
# - One comparison removes nearly all of the ground; slopes and kerbs need a plane.
# - A voxel grid evens out density. Cells twice as wide leave between two and four times fewer points, as long as most cells hold several.
#
# **Sources.** A sensor 1.73 m above the road: set-up of the KITTI data set, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Voxel grid: [Rusu and Cousins 2011](https://doi.org/10.1109/ICRA.2011.5980567). Ground by lines in sectors of azimuth: [Himmelsbach et al. 2010](https://doi.org/10.1109/IVS.2010.5548059); by planes, piece by piece: [Zermas et al. 2017](https://doi.org/10.1109/ICRA.2017.7989591).
#
# **Next:** 07 · Filter by distance

# %% [markdown]
# ## If you want more
#
# 1. Write `filter_ground_sloped(cloud, ground_level, slope)` whose level rises with distance. Which slope leaves the fewest errors in the curve above?
# 2. Keep, of each cell, the point nearest to the centroid instead of the centroid itself. When is an invented point a problem?
# 3. Load a recording of your own with `load_cloud("path/to/file.pcd")` and find its ground level from the histogram alone.

# %% [markdown]
# ### Who vanishes first?
#
# Your function can tell, with the truth at hand. We ask for the objects that have a hundred returns or more and stand within 15 m.

# %%
first = predict("Raise the level step by step. Of which kind does one vanish first?",
                choices=["a car", "a pedestrian", "a wall"])

# %%
def vanishes_at(kind, levels):
    """The first of some rising levels at which an object of this kind has no return left."""
    mine = (kinds == kind) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 15)
    numbers, sizes = np.unique(truth["objects"][mine], return_counts=True)
    for level in levels:
        for number in numbers[sizes >= 100]:
            if len(filter_ground(cloud[mine & (truth["objects"] == number)], level)) == 0:
                return level
    return np.inf

# %%
rising = np.round(np.arange(-1.2, 1.01, 0.1), 1)
gone = {f"a {kind}": vanishes_at(kind, rising) for kind in ("car", "pedestrian", "wall")}
for name, level in gone.items():
    print(f"{name} vanishes at {level:4.1f} m")
first.compare(min(gone, key=gone.get), "A car is lower than a person. What a level loses first is "
              "not what is small, but what is low. (The wall is that of a garden, 1.3 m high. Of "
              "the house fronts the top beam sees 0.5 m above the sensor, and no more.)")

# %% [markdown] tags=["footer"]
# (footer)
