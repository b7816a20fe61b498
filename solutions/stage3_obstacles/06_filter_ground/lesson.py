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
# A LiDAR returns points from the road as well as from obstacles. The car should drive on the road, so every road point that stays in the cloud is a *phantom obstacle*.
#
# **After this lesson you can**
# - remove the ground from a scan with a single comparison, and say when that is not enough,
# - thin out a cloud to a fifth of its points, and say which objects keep the largest share of their points.
#
# **You write** `filter_ground` (points) and `voxel_grid` (points). **You need** NumPy arrays and boolean masks (lesson 01). All packages listed at the end are allowed. **Time:** (time: 65), in two sittings of about 25 and 40 minutes.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## One scan
#
# The file `cloud.txt` contains one scan from a 64-beam LiDAR on the roof of the [ego car](#Words-of-the-course). Each row is one [return](#Words-of-the-course): x (forward), y (left) and z (up) in metres, and an intensity between 0 and 1.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_street, plots, predict, show_table

cloud, truth = load_street()  # `truth` says what each return hit
print(f"{len(cloud):,} returns, {cloud.shape[1]} columns, heights from "
      f"{cloud[:, 2].min():.1f} to {cloud[:, 2].max():.1f} m")
cloud[:3]

# %%
street = ((-15, 40), (-12, 12))  # x from, to; y from, to
plots.from_above(cloud, limits=street, title="The street from above, coloured by height");

# %% [markdown]
# Make two guesses first.

# %%
peak = predict("At which height z are the most returns?", between=(-3, 3), step=0.05,
               unit="m", digits=2)
share = predict("What share of all returns comes from the ground (road and pavement)?",
                between=(0, 100), unit="%")

# %% [markdown]
# The scan is simulated, so we know what each return comes from.

# %%
kinds = truth["class_names"][truth["classes"]]  # one word per return, such as "ground" or "car"

plots.histogram(cloud[:, 2], label="height z (m)", marks={"road under the car": -1.73},
                title="How many returns are at each height")
counts, edges = np.histogram(cloud[:, 2], bins=np.arange(-3.5, 3.05, 0.1))
fullest = np.argmax(counts)
peak.compare(edges[fullest] + 0.05, f"The peak is between {edges[fullest]:.1f} and "
             f"{edges[fullest + 1]:.1f} m, and comes from the ground. The road under the car is "
             "1.73 m below the sensor, but the street climbs, and the pavement is higher.")
share.compare(100 * np.mean(kinds == "ground"), "Most beams point downwards, but more than half "
              "of the returns come from objects in their way, mostly from walls and cars.")

# %% [markdown]
# The tall peak is the road and the pavement, and the long shoulder to its right is everything else. A good ground level is at the foot of the peak, where the shoulder begins.
#
# ## The naive idea: ground is where z is 0
#
# On a map, the ground has height 0. So we keep the points above z = 0, and look at them from the side.

# %%
near = cloud[np.abs(cloud[:, 1]) < 4]  # a slice of street, 8 m wide
plots.from_side(near, level=0.0, limits=((-15, 40), (-3, 3)),
                title="Above z = 0 hardly any part of a car is left");

# %% [markdown]
# Near us, whole cars are below the line. In this cloud, z = 0 is the height of our sensor, and their roofs are lower. Farther ahead, roofs reach above the line, because the street climbs. Other cars carry their sensor higher or lower, so the level must be a parameter.
#
# ## The idea: one level, a little above the road
#
# Let $g$ be the ground level. Keep the points
#
# $$\{\, p : z_p \ge g \,\}.$$
#
# The road is at about $-1.7$ m, so $g = -1.2$ m leaves half a metre for kerbs, bumps, slopes and noise. Cars lose their wheels, but they hardly fall apart. With the clustering of lesson 05, seven of the ten cars within 25 m are still one cluster. In each of the other three, at least 96 % of the remaining points are in one cluster.
#
# ## Exercise 1 · `filter_ground` (points)
#
# Keep the rows at or above `ground_level`, with a mask as in lesson 01. The cloud may have three or four columns, and it may be empty. If no row is left, return an empty array with the same columns. No cloud contains NaN, here or in the checks.

# %% nbgrader={"grade": false, "grade_id": "filter_ground", "locked": false, "schema_version": 3, "solution": true, "task": false}
def filter_ground(cloud, ground_level=-1.2):
    """Remove the ground, and keep the points at or above a height.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres from the sensor, then perhaps intensity.
    ground_level : float
        Height in metres, relative to the sensor.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows with z >= ground_level, with all columns and in the same order.
    """
    # 1. Compare the heights of all points with the level. This gives one True or False per point.
    # 2. Index the cloud with the result.
    # roughly 2 lines
    ### BEGIN SOLUTION
    stands_above = cloud[:, 2] >= ground_level
    return cloud[stands_above]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `cloud[:, 2]` is the column of heights. Which comparison means "at or above"?
# </details>
# <details><summary>Hint 2</summary>
#
# The comparison gives a mask with one `True` or `False` per row. Select the rows with it: `cloud[mask]`, not `cloud[:, mask]`.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `mask = cloud[:, 2] ...` with the comparison and `ground_level` in place of the dots. Then write `return cloud[mask]`. Do not write -1.2 here, because it is already the default value of the parameter.
# </details>

# %% [markdown]
# **Seven points first.** Four of them are above -1.2 m: the bumper, the door, the roof and the sign. Only these four rows should be left, with all four columns.

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
# **Look before you check.** The first picture should show the street without its road, except for some streaks more than 20 m ahead. In the second picture, nothing should be below the dashed line.

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
# We raise the level from -1.2 m, and your function removes more and more points. Make a guess before you move the slider.

# %%
first = predict("If the level rises step by step, what kind of object vanishes first?",
                choices=["a car", "a pedestrian", "a wall"])

# %%
thin = cloud[::12]  # every twelfth point is enough for a picture
heights = (-2, 0.5)  # the heights in metres at both ends of the colour scale


@interact(level=FloatSlider(value=-1.2, min=-2.2, max=0.6, step=0.1, description="level (m)",
                            continuous_update=False))
def show_level(level):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street, span=heights,
                     title=f"{len(kept) / len(thin):.0%} of the points are above {level:.1f} m")
    plt.show()

# %% [markdown]
# Here is the same without a slider, for three levels. A colour means the same height in all three pictures.

# %%
figure, rows = plt.subplots(3, 1, figsize=(8.5, 10.5), layout="compressed")
for level, axes in zip((-1.6, -1.2, -0.5), rows):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street, span=heights, axes=axes,
                     title=f"ground_level = {level} m keeps {len(kept) / len(thin):.0%}")
plots.ring(rows[1], -11.7, -2.7, radius=2.5, text="a car")
plots.ring(rows[2], -11.7, -2.7, radius=2.5, text="no car");

# %% [markdown]
# **What vanishes first?** Your function can answer this. We use objects within 15 m that have at least a hundred returns.

# %%
def vanishes_at(kind, levels):
    """Return the first of the rising levels at which an object of this kind has no returns."""
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
for thing, level in gone.items():
    print(f"{thing} vanishes at {level:4.1f} m")
first.compare(min(gone, key=gone.get), "A car is lower than a person. A rising level removes low "
              "objects first, not small ones. (The wall is a garden wall, 1.3 m high. On house "
              "fronts within 15 m, the top beam reaches only 0.5 m above the sensor.)")

# %% [markdown]
# ## Theory against practice: what does the best level cost?
#
# If the level is too low, ground points stay (phantom obstacles). If it is too high, obstacle points are removed (blind spots). We count both errors of your `filter_ground` at many levels.

# %%
ground = cloud[kinds == "ground"]
objects = truth["objects"]  # the number of the object that each return comes from; 0 if none
upright = cloud[objects > 0]  # all returns from objects that stand on the ground


def two_errors(levels):
    """Return, for each level, the share of ground points that stay and of obstacle points removed."""
    stays = [len(filter_ground(ground, level)) / len(ground) for level in levels]
    goes = [1 - len(filter_ground(upright, level)) / len(upright) for level in levels]
    return np.array(stays), np.array(goes)

# %%
levels = np.round(np.arange(-2.2, 0.3, 0.05), 2)
ground_kept, obstacles_lost = two_errors(levels)

axes = plots.curves({"ground that stays": (levels, ground_kept),
                     "obstacle points removed": (levels, obstacles_lost)},
                    across="ground_level (m)", up="share of the points of this kind",
                    title="The two errors of a ground level")
axes.axvline(-1.2, color="black", linestyle=":", label="the default, -1.2 m")
axes.legend()
crossing = levels[np.argmin(np.abs(ground_kept - obstacles_lost))]
print(f"the curves cross at {crossing:.2f} m; half of the ground is below "
      f"{np.median(ground[:, 2]):.2f} m")

# %% [markdown]
# The default is to the right of the crossing on purpose. A phantom obstacle makes the car brake for nothing. Losing the lowest half metre of an obstacle costs little. Even so, some ground points stay. Where are they?

# %%
left_over = filter_ground(ground)
distance = np.hypot(left_over[:, 0], left_over[:, 1])
print(f"{len(left_over):,} ground points stay, "
      + (f"the nearest of them {distance.min():.0f} m away" if len(distance) else "none at all"))
plots.from_side(ground[np.abs(ground[:, 1]) < 6], level=-1.2, limits=((-40, 75), (-3.5, 1)),
                title="Far ahead, the road rises above the level");

# %% [markdown]
# A slope of one degree lifts the road by 0.5 m over 30 m, which uses up our whole margin. Near the car, one level is enough. For the whole scan, fit a plane to the road with RANSAC (lesson 03).

# %% [markdown]
# **A good place to stop.** Your filter works. Save the notebook. In the second sitting (40 minutes), you thin out the cloud.

# %% [markdown]
# ## Thinning: too many points near the car
#
# *If you have just opened the notebook, run all the cells above.*
#
# *On vertical surfaces, the density of points falls with the square of the distance. On the road, it falls even faster.*
#
# The next lessons compare each point with its neighbours, so fewer points mean less work. The naive way is to keep every fifth row. We try this on `upright`, the returns from all objects on the ground. (This part does not need exercise 1.)

# %% tags=["folded"]
# @title Show what is left of a wall, a pedestrian and three cars (you need not read this)
def show_what_is_left(methods):
    """Show how many points of five objects each method leaves; `methods` maps names to functions."""
    table = []
    for kind, number in (("wall", 30), ("pedestrian", 15), ("car", 1), ("car", 8), ("car", 72)):
        rows = np.flatnonzero(objects[objects > 0] == number)
        far = np.hypot(*upright[rows, :2].mean(axis=0))
        table.append((f"{kind} {number}", f"{far:.0f} m", f"{len(rows):,}",
                      *(f"{method(rows):,}" for method in methods.values())))
    show_table(["object", "distance", "returns", *methods], table)

# %%
def by_skipping(rows):
    """Return how many of these rows of `upright` are left if we keep every fifth row."""
    return np.sum(rows % 5 == 0)


show_what_is_left({"every fifth": by_skipping})

# %% [markdown]
# Skipping rows thins out everything by the same factor. The wall still has more points than its shape needs, but the last two cars have only about twenty and thirty. We want the same density everywhere.
#
# ## The idea: one point per cube of space
#
# Let us cut space into cubes with sides of length $s$. A cube is called a [*voxel*](#Words-of-the-course), which is a pixel with volume. The point $p$ is in the cell
#
# $$\left(\left\lfloor \tfrac{x}{s} \right\rfloor,\ \left\lfloor \tfrac{y}{s} \right\rfloor,\ \left\lfloor \tfrac{z}{s} \right\rfloor\right).$$
#
# The brackets mean *round down*, even below zero, so $\lfloor -0.2 \rfloor = -1$. Points with the same three whole numbers are in the same cell. We replace them by their mean in all columns, the *centroid*.
#
# `np.unique` lists the different numbers in an array and counts them. It also returns, for each entry of the array, its position in that list. A cell is three numbers, so the function `as_numbers` below first turns each row into one number.

# %% tags=["folded"]
# @title Turn each row into one number (you need not read this)
def as_numbers(rows):
    """Return one whole number for each row of whole numbers, equal only for equal rows."""
    rows = np.asfortranarray(rows)  # stored column by column, which is faster
    rows = rows - rows.min(axis=0)
    extent = rows.max(axis=0) + 1
    if not np.log2(extent).sum() < 62:  # too many possible rows for 64-bit numbers
        return np.unique(rows, axis=0, return_inverse=True)[1].ravel()
    return np.ravel_multi_index(rows.T.astype(int), extent.astype(int))


# %%
cells = np.array([[0, 1], [3, 2], [0, 1], [0, 1]])
different, which, how_many = np.unique(as_numbers(cells), return_inverse=True, return_counts=True)
print("a number for each row:", as_numbers(cells), "  different ones:", different)
print("row by row:", which, "  how many of each:", how_many)

# %% [markdown]
# Row (3, 2) becomes 7. Its difference from the smallest entries, 0 and 1, is (3, 1), and 3 · 2 + 1 = 7. (The 2 is the number of possible second entries.) `np.unique(cells, axis=0, ...)` does the same without `as_numbers`, but is slower.
#
# These numbers have no meaning of their own. Rows 0, 2 and 3 have the first number, so they are of kind 0. Row 1 has the second number, so it is of kind 1. Suppose that each row has a price, and that we want the sum of the prices of each kind. There is a trap:

# %%
prices = np.array([10, 1, 5, 2])

sums = np.zeros(2)
sums[which] += prices
print("sums[which] += prices: ", sums, "   only the last one of each kind!")

sums = np.zeros(2)
np.add.at(sums, which, prices)
print("np.add.at:             ", sums, "  10 + 5 + 2, and 1")

# %% [markdown]
# `sums[which] += prices` first reads the old values, which are zeros. Then it writes 10, 1, 5 and 2 to their places. Place 0 is written three times, and only the last value, 2, stays. `np.add.at` adds the values one after the other. It can also add whole rows.
#
# ## Exercise 2 · `voxel_grid` (points)
#
# Return one centroid per occupied cell, in any order.

# %% nbgrader={"grade": false, "grade_id": "voxel_grid", "locked": false, "schema_version": 3, "solution": true, "task": false}
def voxel_grid(cloud, voxel_size=0.2):
    """Thin out a cloud to one centroid per occupied cube.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        Columns x, y and z in metres, then perhaps intensity.
    voxel_size : float
        Side length of a cube in metres.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The mean of all columns over the points of each occupied cell
        floor(xyz / voxel_size). The rows may be in any order.
    """
    # 1. If the cloud is empty, return an empty cloud with the same columns.
    # 2. Find the cell of each point: three whole numbers, rounded down, even below zero.
    # 3. Find the different cells, the cell of each point, and the number of points in each cell.
    # 4. Add up the rows of each cell. np.add.at(sums, which, rows) does this in one step.
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
# `np.floor(cloud[:, :3] / voxel_size)` gives the cells. On its own, `.astype(int)` would round towards zero and merge the cells on both sides of the sensor.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.unique(as_numbers(cells), return_inverse=True, return_counts=True)` gives three arrays. The second says which cell each point is in. The third says how many points each cell contains.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `sums = np.zeros((number_of_cells, cloud.shape[1]))`, and then `np.add.at(sums, which, cloud)`. Divide by the counts as a column, `counts[:, None]`, so that each row is divided by its own count.
# </details>

# %% [markdown]
# **Four voxels first.** Here are seven points in cells of half a metre. Two points share a cell and become (0.2, 0.2, 0.2) with intensity 0.3. Three share another cell and become (0.7, 0.7, 0.2) with intensity 0.4. The other two are alone in their cells.

# %% tags=["folded"]
# @title Draw points, cells and centroids (you need not read this)
def draw_cells(points, centroids, size, up=1, title=""):
    """Draw from above, or from the side with up=2; the lines are the borders of the cells."""
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
# **Look before you check.** Here is the side of a car that faces us. Each square with points should contain exactly one centroid, and you should still recognise the car.

# %%
flank = cloud[(objects == 1) & (cloud[:, 1] > -2.4)]
flank[:, 1] = -2.1  # flattened, so that each square in the picture is one cell
draw_cells(flank, voxel_grid(flank, 0.2), 0.2, up=2,
           title="The side of a car, in cells of 0.2 m");

# %% nbgrader={"grade": true, "grade_id": "test_voxel_grid", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(voxel_grid)
# %% [markdown]
# Both methods leave about the same number of points in total.

# %%
def by_voxels(rows):
    """Return how many centroids the voxel grid makes from these rows of `upright`."""
    return len(voxel_grid(upright[rows], 0.2))

# %%
everything = np.arange(len(upright))
print(f"In total: {by_skipping(everything):,} by skipping, {by_voxels(everything):,} centroids")
show_what_is_left({"every fifth": by_skipping, "voxels of 0.2 m": by_voxels})

# %% [markdown]
# The near objects keep fewer points than with skipping, but still plenty. The two distant cars (8 and 72) keep about four and three times as many. A centroid represents one piece of a surface, and a distant surface has as many pieces as a near one.
#
# ## Play: detail against cost
#
# *Larger cells save work, until the objects lose their shape.*

# %%
fewer = predict("A cell of 0.4 m has eight times the volume of a cell of 0.2 m. "
                "By which factor will the number of points fall?", between=(1, 8), step=0.1,
                digits=1)

# %%
@interact(size=FloatSlider(value=0.2, min=0.1, max=1.0, step=0.1, description="cell (m)",
                           continuous_update=False))
def show_cells(size):
    draw_cells(flank, voxel_grid(flank, size), size, up=2, title=f"cells of {size:.1f} m")
    plt.show()

# %%
def points_left(sizes):
    """Return how many centroids of all objects on the ground each cell size leaves."""
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
fewer.compare(left[2] / left[3], "A LiDAR sees surfaces, not volumes. With cells twice as wide, "
              "a quarter as many cells touch a surface, and half as many touch a pole or an edge. "
              "A street has both.")

# %% [markdown]
# A surface of area $A$ touches about $A / s^2$ cubes, and a pole of length $L$ touches about $L / s$ cubes. At the left end, your squares rise less than either line, because most of these small cells contain a single point.

# %% [markdown]
# ## Common mistakes
#
# | what the code does | what you see |
# |---|---|
# | compares with `<` instead of `>=` | the road without the cars |
# | uses the wrong column, `cloud[:, 1]` | half a street, because everything on the right is gone |
# | compares `abs(z)` with the level | the whole cloud, because no absolute value is below -1.2 |
# | uses `.astype(int)` without `np.floor` | cells around the sensor are twice as wide |
# | adds with `sums[which] += cloud` | centroids are too close to the sensor |
# | uses the number 0.2 and not the parameter | the slider does nothing |

# %% tags=["folded"]
# @title The wrong column (you need not read this)
columns = {"column 2, the height": 2, "column 1, the distance to the left": 1}
figure, panels = plt.subplots(1, 2, figsize=(8.5, 4.2), layout="compressed")
for (name, column), axes in zip(columns.items(), panels):
    plots.kept_and_removed(thin, thin[:, column] > -1.2, limits=((-10, 20), (-12, 12)),
                           title=name, axes=axes)

# %% [markdown]
# ## Let it drive
#
# This drive is optional. A car drives for ten seconds up a street that climbs by 6 %, and your `filter_ground` filters its scans. The driver brakes for every box in the lane that is closer than the stopping distance. The cell takes 10 to 30 seconds.

# %%
from utils.drive import chain, drive_street, on_time
from utils.lent import is_written, own  # own(f) is your function f, never a stored answer


def drive_with(level, street=6, seconds=10):
    """Drive through a street with your filter."""
    mine = own(filter_ground)
    return drive_street(street, chain(ground=lambda points: mine(points, level)),
                        seconds=seconds, clock=on_time)


drive_with(-0.6) if is_written(filter_ground) else print(
    "filter_ground is not written, or has not passed its check.")

# %% [markdown]
# With -0.6 m, the car drives 82 m without braking. Now try the default, `drive_with(-1.2)`. The car brakes for bare asphalt, and gets less than half as far. The level is 0.53 m above the road under the car, and a road that climbs by 6 % reaches this level 9 m ahead of the sensor. Open a braking event below the strip to see its frame. (The strip measures distances from the bumper, which is 2.6 m ahead of the sensor. So 9 m from the sensor is 6.4 m in the strip. The box begins even nearer, at about 4 m in the strip, because it also contains the pavement, which is about 10 cm higher than the lane.)
#
# Is -0.6 m the better level? Try it downhill, where a pedestrian crosses after ten seconds, with `drive_with(-0.6, street=16, seconds=13)`. Is there a level with which the car drives 82 m uphill and stops in time downhill?
#
# <details><summary>An answer</summary>
#
# No. Downhill, the car hits the pedestrian at 30 km/h with a level of -0.6 m, and at 4 km/h with -1.2 m. With -1.7 m, it brakes in time. A level is right for one slope only, but the plane of lesson 03 follows the road.
# </details>

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(voxel_grid)

# %% [markdown]
# ## In practice
#
# - In Open3D, a voxel grid takes one call. Its grid starts at the lowest corner of the cloud, but ours starts at the sensor.
#
#   ```python
#   import open3d
#   cloud = open3d.io.read_point_cloud("scan.pcd")
#   thinned = cloud.voxel_down_sample(voxel_size=0.2)
#   ```
#
#   The Point Cloud Library has [`PassThrough`](https://pcl.readthedocs.io/projects/tutorials/en/latest/passthrough.html) and [`VoxelGrid`](https://pcl.readthedocs.io/projects/tutorials/en/latest/voxel_grid.html).
# - Real cars fit a plane to each piece of the road. Other programs choose a direction (its angle is called *azimuth*), go outwards from [beam](#Words-of-the-course) to beam, and look for the first jump in height.
# - Nearly every pipeline begins with a voxel grid. In a city, the cells are usually 0.1 to 0.3 m wide.
#
# ## Summary
#
# - Heights are relative to the sensor, so the right ground level depends on the car.
# - One comparison removes nearly all of the ground. Slopes need a plane.
# - A voxel grid makes the density of points more even.
#
# **Sources.** A sensor 1.73 m above the road: KITTI data set, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Voxel grid: [Rusu and Cousins 2011](https://doi.org/10.1109/ICRA.2011.5980567). Finding the ground with lines in sectors of azimuth: [Himmelsbach et al. 2010](https://doi.org/10.1109/IVS.2010.5548059); with planes: [Zermas et al. 2017](https://doi.org/10.1109/ICRA.2017.7989591).
#
# **Next:** 07 · Filter by distance

# %% [markdown]
# ## If you want more
#
# 1. Write `filter_ground_sloped(cloud, ground_level, slope)`, whose level rises with distance. Which slope gives the fewest errors in the figure above? (20 minutes)
# 2. In each cell, keep the point nearest to the centroid instead of the centroid itself. When does it matter that a centroid was never measured? (20 minutes)
# 3. Load your own recording with `load_cloud("path/to/file.pcd")`, and find its ground level from the histogram. (10 minutes)

# %% [markdown] tags=["footer"]
# (footer)
