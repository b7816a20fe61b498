# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 06 · Filter the ground
#
# ![A street seen from the side. A dashed line half a metre above the road separates grey road points below from dark points of cars, people and walls above.](pictures/06_preview.png)
#
# Nearly half of what a LiDAR sees is road. Road is where the car may go, so every road point that stays in the cloud is an obstacle that is not there.
#
# **After this lesson you can**
# - take the road out of a scan with a single comparison, and say when that is not enough,
# - thin a cloud to a tenth of its points without losing a pedestrian.
#
# **You write** `filter_ground` (20 points) and `voxel_grid` (10 points). **Time:** about 45 minutes. **You need** NumPy arrays and boolean masks (lesson 01).

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## One turn of the scanner
#
# *The sensor is the origin, so the road has negative heights.*
#
# The file `cloud.txt` holds one full turn of a 64-beam LiDAR on the roof of a car: one row per return, with x (forward), y (left) and z (up) in metres and an intensity between 0 and 1. All coordinates are measured from the sensor.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, interact

from utils import check, load_cloud, plots

cloud = load_cloud("cloud.txt")
print(f"{len(cloud):,} returns, {cloud.shape[1]} columns, heights from "
      f"{cloud[:, 2].min():.1f} to {cloud[:, 2].max():.1f} m")
cloud[:3]

# %%
street = ((-15, 40), (-12, 12))  # x from, to; y from, to
plots.from_above(cloud, limits=street, title="The street from above, coloured by height");

# %% [markdown]
# **Predict first.** The sensor sits on the roof, 1.73 m above the road. Before you run the next cell: at which heights do you expect the most returns? And what share of all returns is road?

# %%
plots.histogram(cloud[:, 2], label="height z (m)", marks={"road under the car": -1.73},
                title="Where the returns are, by height");

# %% [markdown]
# The tall peak is road and pavement: it has a width, because the street slopes and the scanner is never quite exact. The long shoulder to its right is everything else: cars, people, walls, trees. A good ground level lies at the foot of the peak, where the shoulder begins.

# %% [markdown]
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
# Teaching sheets often say "remove everything below 1 metre, for example". For a sensor 1.73 m above the road that is as wrong as 0. The level depends on how the sensor is mounted, so it must be a parameter.

# %% [markdown]
# ## The idea: one level, a little above the road
#
# *Half a metre of margin buys freedom from bumps, slopes and noise, and costs the wheels of the cars.*
#
# Let $g$ be the ground level. Keep the points
#
# $$\{\, p : z_p \ge g \,\}.$$
#
# With the road at about $-1.7$ m, $g = -1.2$ m leaves half a metre for kerbs, potholes and range noise. We lose wheels and feet, but a car without wheels is still a car to a clustering algorithm.
#
# In NumPy a condition on a column gives one `True` or `False` per row, and indexing with it keeps the rows that are `True`, in order. For example, the bright returns of a scan:

# %%
sample = np.array([[5.0, 0.2, -1.7, 0.1],
                   [7.1, 1.4, -0.3, 0.9],
                   [9.8, -2.0, 0.4, 0.7]])
is_bright = sample[:, 3] > 0.5
print(is_bright)
print(sample[is_bright])

# %% [markdown]
# ## Exercise 1 · `filter_ground` (20 points)
#
# Keep the rows at or above `ground_level`. The cloud may have three columns or four, and it may be empty.

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
# The comparison gives a mask, as `is_bright` above. Index rows with it: `cloud[mask]`, not `cloud[:, mask]`.
# </details>
# <details><summary>Hint 3</summary>
#
# `mask = cloud[:, 2] ...` with the comparison and `ground_level` for the dots; then `return cloud[mask]`. Do not write -1.2 into the function: it is the default of the parameter already.
# </details>

# %% [markdown]
# **Look before you check.** The first picture should show a street without a road; in the second, nothing may lie below the dashed line.

# %%
obstacles = filter_ground(cloud)
print(f"{len(cloud):,} points in, {len(obstacles):,} points out")
figure, (above, beside) = plt.subplots(2, 1, figsize=(8.5, 7), layout="compressed")
plots.from_above(obstacles, limits=street, title="From above", axes=above)
plots.from_side(filter_ground(near), level=-1.2, limits=((-15, 40), (-3, 3)),
                title="From the side", axes=beside);

# %% nbgrader={"grade": true, "grade_id": "test_filter_ground", "locked": true, "points": 20, "schema_version": 3, "solution": false, "task": false}
check(filter_ground)

# %% [markdown]
# ## Play: how high is high enough?
#
# *Too low and the road comes back; too high and the pedestrians go.*
#
# Move the slider. When does the first ring of road appear? When does the first car vanish?

# %%
thin = cloud[::6]  # every sixth point is enough to look at


@interact(level=FloatSlider(value=-1.2, min=-2.2, max=0.6, step=0.1, description="level (m)",
                            continuous_update=False))
def show_level(level):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street,
                     title=f"{len(kept) / len(thin):.0%} of the points stand above {level:.1f} m")
    plt.show()

# %% [markdown]
# The same without a slider: three levels.

# %%
figure, rows = plt.subplots(3, 1, figsize=(8.5, 10), layout="compressed")
for level, axes in zip((-1.6, -1.2, -0.5), rows):
    kept = filter_ground(thin, level)
    plots.from_above(kept, limits=street, axes=axes,
                     title=f"ground_level = {level} m keeps {len(kept) / len(thin):.0%}")

# %% [markdown]
# ## Theory against practice: what does the best level cost?
#
# *No single height separates road from obstacles; the best one balances two errors.*
#
# This scan was simulated, so we know what each return truly hit. That lets us count two kinds of error for every level: road that stays (a ghost obstacle) and obstacle that goes (a blind spot). Your own `filter_ground` does the counting.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
names = truth["class_names"].tolist()
road = cloud[truth["classes"] == names.index("ground")]
things = cloud[~np.isin(truth["classes"], [names.index(n) for n in ("ground", "invalid", "ego")])]
print(f"{len(road) / len(cloud):.0%} of all returns are road and pavement. What did you predict?")

levels = np.arange(-2.2, 0.3, 0.05)
road_kept = [len(filter_ground(road, level)) / len(road) for level in levels]
things_lost = [1 - len(filter_ground(things, level)) / len(things) for level in levels]

axes = plots.curves({"road that stays": (levels, road_kept),
                     "obstacles that go": (levels, things_lost)},
                    across="ground_level (m)", up="share of its points",
                    title="The two errors of a ground level")
axes.axvline(-1.2, color="black", linestyle=":", label="the default, -1.2 m")
axes.legend()
crossing = levels[np.argmin(np.abs(np.subtract(road_kept, things_lost)))]
print(f"the curves cross at {crossing:.2f} m; the road is at {np.median(road[:, 2]):.2f} m")

# %% [markdown]
# The curves cross a little above the road; the default stands to the right of the crossing. That is a choice: a ghost obstacle makes the car brake for nothing on every frame, while the lower half metre of an obstacle is the half we can spare.
#
# And at the default some road is still there. Where does it come from?

# %%
left_over = filter_ground(road)
far = np.hypot(left_over[:, 0], left_over[:, 1])
print(f"{len(left_over)} road points stay, "
      + (f"the nearest of them {far.min():.0f} m away" if len(far) else "none at all"))
plots.from_side(road[np.abs(road[:, 1]) < 6], level=-1.2, limits=((-40, 75), (-3.5, 1)),
                title="The road is not flat: far away it rises above the level");

# %% [markdown]
# A street has a crown, a kerb and a slope. One degree of slope lifts the road by 0.5 m over 30 m: exactly our margin. Near the car a level is enough. For the whole scan, fit a plane to the road, as RANSAC does in lesson 03.

# %% [markdown]
# ## Thinning: too many points where we need them least
#
# *The density of a scan falls with the square of the distance on whatever stands upright, and faster on the road: most points lie where everything is already clear.*
#
# The next lessons compare points with their neighbours, which takes time for every point. So we want fewer points. The naive way is to keep every hundredth:

# %%
standing = cloud[:, 2] >= -1.2
objects = truth["objects"][standing]  # the number of the object that each return hit


def returns_of(kind, at_least=100):
    """Rows of `obstacles` on each object of a kind: a dictionary of number -> rows."""
    is_kind = truth["classes"][standing] == names.index(kind)
    numbers, sizes = np.unique(objects[is_kind], return_counts=True)
    return {n: np.flatnonzero(is_kind & (objects == n)) for n in numbers[sizes >= at_least]}


chosen = {"wall": returns_of("wall", 3000), "pedestrian": returns_of("pedestrian")}
for kind, members in chosen.items():
    for number, rows in members.items():
        distance = np.hypot(*obstacles[rows, :2].mean(axis=0))
        print(f"{kind:>10} {number:3d}, {distance:4.1f} m away: {len(rows):6,} returns, "
              f"{(rows % 100 == 0).sum():4d} after skipping")

# %% [markdown]
# The walls keep dozens of points, the pedestrians a handful or fewer. Skipping rows thins everything by the same factor. We want the opposite: the same density everywhere.
#
# ## The idea: one point per box of space
#
# *Cut space into cubes and replace all points of a cube by their mean.*
#
# With cubes of side $s$ (a *voxel*, a pixel with volume), a point $p$ lies in the cell
#
# $$\left(\left\lfloor \tfrac{x}{s} \right\rfloor,\ \left\lfloor \tfrac{y}{s} \right\rfloor,\ \left\lfloor \tfrac{z}{s} \right\rfloor\right).$$
#
# Points with the same three whole numbers share a cell. Their mean, the *centroid*, stands for all of them, intensity included.
#
# `np.unique` finds the different rows of an array, and tells for each row which of them it is:

# %%
cells = np.array([[0, 1], [3, 2], [0, 1], [0, 1]])
different, which, how_many = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
print("different rows:\n", different)
print("row by row:", which.ravel(), "  how many of each:", how_many)

# %% [markdown]
# ## Exercise 2 · `voxel_grid` (10 points)
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
    cell_of_point = np.floor(cloud[:, :3] / voxel_size).astype(int)
    occupied, rank, count = np.unique(cell_of_point, axis=0, return_inverse=True,
                                      return_counts=True)
    sums = np.zeros((len(occupied), cloud.shape[1]))
    np.add.at(sums, rank.ravel(), cloud)
    return sums / count[:, None]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# `np.floor(cloud[:, :3] / voxel_size)` gives the cells. `.astype(int)` alone would round towards zero and glue the cells on both sides of the sensor together.
# </details>
# <details><summary>Hint 2</summary>
#
# `np.unique(cells, axis=0, return_inverse=True, return_counts=True)` gives three things. The second says for each point which cell it belongs to; apply `.ravel()` to it.
# </details>
# <details><summary>Hint 3</summary>
#
# `sums = np.zeros((number_of_cells, cloud.shape[1]))`, then `np.add.at(sums, which, cloud)`. Divide by the counts as a column, `counts[:, None]`, so that each row is divided by its own number.
# </details>

# %% [markdown]
# **Look before you check.** Left: all points of a patch with a car. Right: your centroids. The shape should survive, and the points should stand about evenly.

# %%
patch = obstacles[(np.abs(obstacles[:, 0] - 8) < 7) & (np.abs(obstacles[:, 1]) < 6)]
thinned = voxel_grid(patch, 0.2)
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4.2), layout="compressed")
window = ((1, 15), (-6, 6))
plots.from_above(patch, limits=window, axes=left, title=f"{len(patch):,} points")
plots.from_above(thinned, limits=window, axes=right, title=f"{len(thinned):,} centroids");

# %% [markdown]
# And the walls and pedestrians from above? To be fair, let skipping keep as many points in all as the grid does. And look at the cars, too: some are far away.

# %%
step = round(len(obstacles) / len(voxel_grid(obstacles, 0.2)))
print(f"one row in {step} is about as many points as there are centroids")
for kind, members in {**chosen, "car": returns_of("car", 50)}.items():
    for number, rows in members.items():
        distance = np.hypot(*obstacles[rows, :2].mean(axis=0))
        print(f"{kind:>10} {number:3d}, {distance:4.1f} m away: {len(rows):6,} returns, "
              f"{(rows % step == 0).sum():4d} after skipping, "
              f"{len(voxel_grid(obstacles[rows], 0.2)):4d} centroids")

# %% [markdown]
# The grid is no gift to everybody: what is near keeps fewer points than by skipping, but plenty. What it saves there goes to what is far: compare the last cars. A centroid stands for a piece of surface, and a surface far away has as many pieces as one nearby.

# %% nbgrader={"grade": true, "grade_id": "test_voxel_grid", "locked": true, "points": 10, "schema_version": 3, "solution": false, "task": false}
check(voxel_grid)

# %% [markdown]
# ## Play: detail against cost
#
# *Bigger cells save work, until the objects melt.*

# %%
@interact(size=FloatSlider(value=0.2, min=0.1, max=1.5, step=0.1, description="cell (m)",
                           continuous_update=False))
def show_cells(size):
    few = voxel_grid(patch[::2], size)
    plots.from_above(few, limits=window, title=f"cells of {size:.1f} m: {len(few):,} points")
    plt.show()

# %% [markdown]
# How fast does the number of points fall? A LiDAR sees surfaces, not volumes. A surface of area $A$ passes through about $A / s^2$ cubes of side $s$: a line of slope $-2$ on logarithmic axes. A pole or an edge of length $L$ passes through $L / s$ cubes: slope $-1$. A street has both, so expect something in between. And at the left end there is nothing to merge: most cells hold a single point.

# %%
sizes = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6])
counts = np.array([len(voxel_grid(obstacles, size)) for size in sizes])
axes = plots.curves({"surfaces: $s^{-2}$": (sizes, counts[3] * (sizes / sizes[3]) ** -2),
                     "poles and edges: $s^{-1}$": (sizes, counts[3] * (sizes / sizes[3]) ** -1)},
                    {"your voxel_grid": (sizes, counts)},
                    across="cell size (m)", up="points left",
                    title="Points left by a voxel grid")
axes.set_xscale("log")
axes.set_yscale("log")

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
# | `0.2` written into the function | the slider does nothing |

# %%
wrong = {"< instead of >=": ~(thin[:, 2] >= -1.2), "column 1 instead of 2": thin[:, 1] >= -1.2,
         "abs(z)": np.abs(thin[:, 2]) >= -1.2}
figure, rows = plt.subplots(1, 3, figsize=(8.5, 3.2), layout="compressed")
for (name, keep), axes in zip(wrong.items(), rows):
    plots.kept_and_removed(thin, keep, limits=((-10, 20), (-12, 12)), title=name, axes=axes)

# %% [markdown]
# ## In practice
#
# - Cars do not use one level. They fit planes piece by piece; or they go outward along one azimuth, from beam to beam, and look for the first jump in height: on a flat road neighbouring rings lie at foreseeable distances, and an obstacle shortens them.
# - Level and margin come from calibration: the sensor's height changes by centimetres with the load of the car.
# - A voxel grid stands at the start of nearly every pipeline; 0.1 to 0.3 m is usual in a city. The real-time lessons (10 to 12) show when you can do without.
#
# ## If you want more
#
# 1. Write `filter_ground_sloped(cloud, ground_level, slope)` whose level rises with distance. Which slope leaves the fewest errors in the curve above?
# 2. Keep, of each cell, the point nearest to the centroid instead of the centroid itself. When is an invented point a problem?
# 3. Load a recording of your own with `load_cloud("path/to/file.pcd")` and find its ground level from the histogram alone.
#
# ## Summary
#
# - Coordinates are relative to the sensor; the ground level is a property of the car.
# - One comparison removes nearly all of the road; slopes and kerbs need a plane.
# - A voxel grid evens out density; doubling the cell divides the points by two to four.
#
# **Sources.** Ground height and margin: sensor set-up of the KITTI data set, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Voxel grid: [Rusu and Cousins 2011](https://doi.org/10.1109/ICRA.2011.5980567). Ground by lines in sectors of azimuth: [Himmelsbach et al. 2010](https://doi.org/10.1109/IVS.2010.5548059); by planes, piece by piece: [Zermas et al. 2017](https://doi.org/10.1109/ICRA.2017.7989591).
#
# **Next:** 07 · Filter by distance

# %% [markdown] tags=["footer"]
# (footer)
