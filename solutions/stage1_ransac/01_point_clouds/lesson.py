# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     lent: [rings, nearer_than, profile]
# ---

# %% [markdown]
# # 01 · Point clouds
#
# ![One turn of a laser scanner, twice, with colour for distance. Above, as the scanner sees it: rows of returns in which a cyclist, a turning car, a pedestrian and a parked car are named. Below, the same returns as a map: a street from above, with rings of dots around the sensor.](01_preview.png)
#
# Both pictures show the same numbers. The upper one is how a scanner meets the street ahead: one row of dots for each of its laser beams. The lower one is what it reports: a list of points in space, a *point cloud*. Every lesson of this course is about making sense of that list.
#
# **After this lesson you can**
# - explain how a laser scanner measures a point, and what each of its parameters changes,
# - process a hundred thousand points with one line of NumPy instead of a loop, and measure how much faster that is,
# - remove the returns that are not points.
#
# **You write** `horizontal_distance` (points) and `drop_invalid` (points). **Time:** (time). **You need** Python; a little NumPy helps, and what is used is explained.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Your first line of code
#
# *A cloud is a table: one row for each return, its columns x, y, z and intensity.*
#
# A scanner has turned around once, on a straight road with three box-shaped cars. Each row of its cloud is a [return](#Words-of-the-course): light came back from there. The sensor is the origin; x points forward, y to the left, z up, all in metres. That never changes in this course.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, IntSlider, interact

from utils import check, is_written, load_cloud, plots, predict, show_table
from utils.scenes import simple_highway

frame = simple_highway()
highway = frame.cloud
figure, axes = plt.subplots(figsize=(8.5, 5.2), layout="compressed")
plots.from_above(highway, values=highway[:, 2], span=(-2.6, 0), label="height z (m)", axes=axes,
                 limits=((-25, 35), (-16, 16)), title="Rings on the road, and where the cars tear them")
for x, y in ((15, 0), (8, -4), (-12, 4)):
    plots.ring(axes, x, y, radius=2.8, text="car")

# %% [markdown]
# `highway[:, 0]` is the column of all x. `highway[:, 0] > 0` asks of each row whether it lies ahead, and `highway[...]` with the answers in its brackets keeps the rows where they are `True`. Now you: change the comparison, run the cell again, and look. Only the three cars shall be left. What tells them from the road? No check waits here, and an answer stands below.

# %%
mine = highway[highway[:, 0] > 0]
plots.from_above(mine, values=mine[:, 2], span=(-2.6, 0), label="height z (m)",
                 limits=((-25, 35), (-16, 16)), title=f"Your mask keeps {len(mine)} returns");

# %% [markdown]
# <details><summary>An answer</summary>
#
# The road is low, so ask for height: `highway[highway[:, 2] > -2.5]`. That drops a few returns low on the cars, too; lesson 06 makes a filter of this one line, and looks at what it costs.
# </details>
#
# These four bits of NumPy are enough to work with a cloud:

# %%
heights = highway[:, 2]                     # a column: one number per return
is_left = highway[:, 1] > 0                 # a comparison: one True or False per return
left = highway[is_left]                     # a mask picks the rows that are True
left_ahead = highway[is_left & (highway[:, 0] > 0)]  # & for "and"; put comparisons in parentheses

print("heights:   ", heights.shape, heights[:3].round(2))
print("is_left:   ", is_left.shape, is_left[:3], "holds", is_left.sum(), "times")
print("left:      ", left.shape)
print("left_ahead:", left_ahead.shape)

# %% [markdown]
# No loop anywhere: each line treats every return at once. That is called *vectorised*, and you will measure further down what it gains.
#
# ## One pulse
#
# *A LiDAR measures one thing: how long light takes to come back.*
#
# LiDAR stands for *light detection and ranging*. A laser sends a pulse of a few nanoseconds; a detector beside it waits for the echo. Before the formula, a guess. You will find a few such questions in every lesson: answer first, and the answer will stand beside your guess.

# %%
echo = predict("A car drives 30 m ahead. How long after the pulse does its echo arrive?",
               choices=["0.2 seconds", "0.2 milliseconds", "0.2 microseconds", "0.2 nanoseconds"])

# %% [markdown]
# Light travels there and back. So for an echo after the time $t$, the range is
#
# $$r = \frac{c\,t}{2}, \qquad c = 299\,792\,458\ \text{m/s}.$$

# %%
SPEED_OF_LIGHT = 299_792_458  # metres per second
echo.compare(f"{2 * 30 / SPEED_OF_LIGHT * 1e6:.1f} microseconds",
             "There and back are 60 m, and light covers 300 m in a microsecond. "
             "So a scanner can send its next pulse a microsecond later.")
print(f"if the car were 2 cm farther away: {2 * 0.02 / SPEED_OF_LIGHT * 1e12:.0f} picoseconds later")

# %% [markdown]
# So a scanner hardly waits. But its clock must be good: to tell 30.00 m from 30.02 m it has to tell times apart that differ by the last number above; a picosecond is a millionth of a microsecond.
#
# A range alone is not a point. But the scanner knows where it aimed: the *azimuth* $\alpha$ is the angle around the vertical, from straight ahead towards the left, and the *elevation* $\varepsilon$ is the angle above the horizon. Range and two angles make a point:
#
# $$x = r\cos\varepsilon\cos\alpha, \qquad y = r\cos\varepsilon\sin\alpha, \qquad z = r\sin\varepsilon.$$

# %%
def point_of(range_, azimuth, elevation):
    """x, y, z of an echo; angles in degrees."""
    azimuth, elevation = np.radians(azimuth), np.radians(elevation)
    flat = range_ * np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), range_ * np.sin(elevation)])


for azimuth, where in ((0, "ahead"), (90, "to the left"), (-90, "to the right")):
    print(f"30 m {where}, 3 degrees down:", point_of(30, azimuth, -3).round(2))

# %% [markdown]
# ## One turn
#
# *A beam that turns around draws a ring on the road, and an obstacle tears the ring.*
#
# Stack several lasers at different elevations, let the stack turn, and fire all of them at every step. Each laser is a [beam](#Words-of-the-course), each single shot a *ray*, and all returns of one turn are a *scan*. The cloud above is one of a small sensor: 8 beams, 128 steps. It is simulated, as everything in this course, so later we can ask what is true.

# %%
print(f"8 x 128 = {8 * 128} rays, {len(highway)} returns")
counts = np.bincount(frame.scan.beams)  # how often each number occurs: 0, 1, 2 and so on
print("returns of each beam, the steepest first:", counts)

# %% [markdown]
# All missing rays belong to the two steepest beams. They hit the roof of our own car, at its four corners. This scanner reports nothing that is nearer than 5 m along the ray.
#
# Look at the first picture again. The outermost ring is torn behind the car ahead of us: that car casts a *shadow*. A scanner sees fronts, never backs. Here are the rays that go straight ahead, from the side.

# %%
ahead = highway[(highway[:, 0] > 0) & (np.abs(highway[:, 1]) < 0.1)]
figure, axes = plt.subplots(figsize=(8.5, 3.4), layout="compressed")
plots.from_side(ahead, values=ahead[:, 2], span=(-2.6, 0), label="height z (m)", axes=axes,
                limits=((-2, 22), (-3.2, 0.6)), title="The rays that go straight ahead")
for x, _, z, _ in ahead:  # row by row; _ stands for numbers that we do not need
    axes.plot([0, x], [0, z], color="black", linewidth=0.4)
print("they end at x =", ahead[:, 0].round(1), "m")

# %% [markdown]
# The steep rays meet the road, each a little farther out. The two flattest meet the car, 13 m ahead. Had they looked up instead, they would have met nothing, and there would be no row for them: a point cloud says nothing about free space.
#
# ## Play: build your own scanner
#
# *Beams, steps and noise: each of the three leaves its own mark in the scan.*
#
# Three parameters decide what a scan looks like: the number of beams, the azimuth step between two firings, and the [noise](#Words-of-the-course) of the range. The street stays the same; you change the scanner. With 32 beams, each of the four cars and three pedestrians within 12 m has at least eight returns.

# %%
left_over = predict("With only 4 beams: how many of these seven still have five returns or more?",
                    between=(0, 7))

# %% tags=["folded"]
# @title A street, seen by a scanner of your own (you need not read this)
from utils.scenes import random_street
from utils.simulator import Sensor, layers


def scan_with(beams=32, step=0.8, noise=0.02):
    """A frame of the street; the step in degrees, the noise in metres."""
    sensor = Sensor(elevations=layers(beams, -25.0, 2.0), azimuth_step=np.radians(step),
                    range_noise=noise)
    return random_street(seed=3, sensor=sensor)


def distance_of(box):
    return np.hypot(*box.centre[:2])


block = ((-12, 20), (-10, 10))
cars, pedestrians = ([box for box in sorted(scan_with().boxes, key=distance_of)
                      if box.kind == kind and distance_of(box) < 12]
                     for kind in ("car", "pedestrian"))
marked = [box for box in scan_with().boxes if box.kind == "pole" and distance_of(box) < 12]
marked += pedestrians[-1:]

# %%
@interact(beams=IntSlider(value=32, min=4, max=32, step=4, description="beams",
                          continuous_update=False),
          step=FloatSlider(value=0.8, min=0.8, max=6, step=0.4, description="step (°)",
                           continuous_update=False),
          noise=FloatSlider(value=0.02, min=0, max=0.5, step=0.02, description="noise (m)",
                            continuous_update=False))
def show_scanner(beams, step, noise):
    seen = scan_with(beams, step, noise).cloud
    plots.from_above(seen, limits=block, title=f"{len(seen):,} returns")
    plt.show()

# %% [markdown]
# The same without sliders: one scanner, and what happens when one of its three parameters gets worse. Each title ends with the number of all returns; the rings hold a pole and a pedestrian, with the number of theirs.

# %%
scanners = {"32 beams, 0.8°, 2 cm": {}, "8 beams": {"beams": 8},
            "steps of 4°": {"step": 4.0}, "30 cm of noise": {"noise": 0.3}}
figure, rows = plt.subplots(2, 2, figsize=(8.5, 6.0), layout="compressed")
for (name, change), axes in zip(scanners.items(), rows.flat):
    frame = scan_with(**change)
    plots.from_above(frame.cloud, limits=block, axes=axes, title=f"{name}: {len(frame.cloud):,}")
    for box in marked:
        plots.ring(axes, *box.centre[:2], radius=1.2,
                   text=f"{np.sum(frame.scan.objects == box.identity)}")

# %% [markdown]
# Fewer beams: the rings lie farther apart, and a pedestrian slips between two of them. Coarser steps: gaps along each ring, and the thin pole vanishes. More noise: all is there, but walls grow thick and flat things rough.
#
# How much is left of each car and each pedestrian? The simulator knows which return came from which.

# %% tags=["folded"]
# @title Count the returns of each (you need not read this)
counted = {}
for beams in (32, 16, 8, 4):
    returns = np.bincount(scan_with(beams).scan.objects, minlength=100)
    counted[f"{beams} beams"] = [returns[box.identity] for box in cars + pedestrians]
show_table(["returns of a", *counted],
           [(f"{box.kind} at {distance_of(box):.1f} m", *numbers)
            for box, *numbers in zip(cars + pedestrians, *counted.values())])
left_over.compare(sum(n >= 5 for n in counted["4 beams"]),
                  "The last column of the table: all four cars, and no pedestrian. A car is "
                  "long and tall, so some ring crosses it; a pedestrian fits between two rings.")

# %% [markdown]
# ## A cloud is an array
#
# *One row per return, one column per quantity; rows that follow each other need not be neighbours in space.*
#
# From here on we use one scan of a 64-beam scanner on the roof of a car. The file has a row for each return: x, y, z, and the *intensity* of the echo between 0 and 1. Bright paint and number plates throw back much light, tyres and windows little.

# %%
cloud = load_cloud("cloud.txt")
print(f"shape {cloud.shape}: {len(cloud):,} rows of {cloud.shape[1]} numbers, "
      f"{cloud.nbytes / 1e6:.1f} MB per turn, {10 * cloud.nbytes / 1e6:.0f} MB per second")
print(cloud[:3])

street = ((-15, 25), (-11, 11))
axes = plots.from_above(cloud, limits=street, title="Coloured by height")
for name, place, text in (("cyclist", (3.2, 1.9), (0, 2.5)), ("turning\ncar", (7.3, 3.6), (10, 4.9)),
                          ("parked car", (-5.3, -2.9), (-9, -5.3)), ("lorry", (16, 4.1), (17, 7)),
                          ("house front", (2, -8.2), (5, -9.8))):
    axes.annotate(name, place, text, ha="center", va="center", arrowprops={"arrowstyle": "-"})
axes = plots.from_above(cloud, values=cloud[:, 3], span=(0, 0.6), label="intensity", limits=street,
                        title="Coloured by intensity: the same points, another column")
bright = cloud[cloud[:, 3] > 0.9]
axes.plot(bright[:, 0], bright[:, 1], "s", color="black", markersize=3)
plots.ring(axes, 5.1, -2.9, radius=1.2, text="number plate")
print(f"{len(bright)} of {len(cloud):,} returns are brighter than 0.9: black squares");

# %% [markdown]
# The small tufts beside the sensor are parts of [our own car](#Words-of-the-course): a mirror, the tailgate and the aerial.
#
# From above, everything lies flat. In space people are easier to find.

# %%
people = predict("How many people on foot are in the next picture? Those on bicycles do not count.")

# %% [markdown]
# Drag the points to turn them. Look along the street from behind, then from the side.

# %%
from utils.scene3d import Scene

nearby = cloud[(np.abs(cloud[:, 0]) < 25) & (np.abs(cloud[:, 1]) < 12)]
Scene("The street in space").add_cloud(nearby).add_ego_car().show(interactive=True)

# %% [markdown]
# With the scan comes a file of what is true: which return came from what, and where each car and each pedestrian stood.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
axes = plots.from_above(cloud, limits=street, title="The people on foot, and their returns")
found = 0
for kind, (x, y, _), returns in zip(truth["box_kinds"], truth["box_centres"], truth["box_returns"]):
    if kind == "pedestrian" and abs(x) < 25 and abs(y) < 12:
        found += 1
        plots.ring(axes, x, y, radius=0.8, text=f"{returns}")
people.compare(found, "The one with 9 returns is a child behind the car that is parked on the left: "
                      "what hides from the scanner is not in the cloud, and nobody finds it there.")

# %% [markdown]
# ## The naive idea: the length of the row
#
# *A row of a cloud is not a vector: its columns do not all mean the same.*
#
# How far away is a return? A car brakes for what stands in its way *along the road*. Whether the laser hit a bumper or the roof above it must make no difference. NumPy has a function for the length of a vector, so the first idea is `np.linalg.norm(cloud, axis=1)`. We try it on a narrow strip straight ahead, less than 30 cm to either side. There the distance along the road is simply x.

# %%
strip = cloud[(np.abs(cloud[:, 1]) < 0.3) & (cloud[:, 0] > 3) & (cloud[:, 0] < 21)]
x = strip[:, 0]
error = np.linalg.norm(strip, axis=1) - x
plots.curves({}, {"returns straight ahead": (x, error)}, across="x, the distance along the road (m)",
             up="error of the length (m)", title="The nearer the return, the larger the error")
worst = error.argmax()
print(f"largest error: {error[worst]:.3f} m, at a distance of {x[worst]:.1f} m")
print(f"the same return, without its intensity: {np.linalg.norm(strip[worst, :3]) - x[worst]:.3f} m")
print(f"without its height, too:                {np.linalg.norm(strip[worst, :2]) - x[worst]:.3f} m")

# %% [markdown]
# The error is largest near the car, where it counts. The column of points just before 9 m is somebody who crosses the road: by this length, the feet are farther away than the head.
#
# There are two reasons. The length runs down to the road at a slant, so height is mixed in: that is nearly all of it. And the length of a whole row also squares and adds the intensity. Here that is a centimetre; but metres plus brightness mean nothing, and another sensor counts brightness up to 255. What is left in the last line is no error: the return lies a little to the side.
#
# ## The idea: measure on the ground
#
# *Leave the height out; two columns are enough.*
#
# The *horizontal distance* of a point $(x, y, z)$ from the sensor is
#
# $$d = \sqrt{x^2 + y^2}.$$
#
# All points of a lamp post have the same $d$, from foot to lamp.
#
# ## Exercise 1 · `horizontal_distance` (points)
#
# Return one distance per point. The cloud may have three columns or four, and it may be empty.

# %% nbgrader={"grade": false, "grade_id": "horizontal_distance", "locked": false, "schema_version": 3, "solution": true, "task": false}
def horizontal_distance(cloud):
    """Distance of each point from the sensor, measured along the ground.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres, the sensor at the origin; then intensity.

    Returns
    -------
    ndarray, shape (n,)
        sqrt(x² + y²) in metres. Neither height nor intensity counts.
    """
    # 1. Take the column of x and the column of y.
    # 2. Square both, add, take the root (np.sqrt): all points at once, no loop.
    # roughly 2 lines
    ### BEGIN SOLUTION
    x, y = cloud[:, 0], cloud[:, 1]
    return np.sqrt(x**2 + y**2)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# A column of n numbers behaves like a single number: `heights * 2` doubles all of them. So write Pythagoras as if for one point.
# </details>
# <details><summary>Hint 2</summary>
#
# `cloud[:, 0]` is x of every point (all rows, column 0). Which column is y?
# </details>
# <details><summary>Hint 3</summary>
#
# `np.hypot(a, b)` is the root of a² + b², for whole columns too. Return it for the columns 0 and 1.
# </details>

# %% [markdown]
# **Three points first.** Along x and y they lie 3 m and 4 m, 6 m and 8 m, and 0 m and 7 m from the sensor; heights and intensities are there to mislead. Expected: 5, 10 and 7.

# %%
three = np.array([[3.0, 4.0, -1.7, 0.1], [-6.0, 8.0, 4.0, 0.9], [0.0, 7.0, 2.5, 1.0]])
print("yours:   ", np.round(horizontal_distance(three), 2))
print("expected: [ 5. 10.  7.]")

# %% [markdown]
# **Look before you check.** Coloured by your distance, the street should change in circles around the sensor: each dashed line, at 5, 10, 15 and 20 m, runs along one colour. One return in eight is enough for that.

# %%
some = cloud[::8]
axes = plots.from_above(some, values=horizontal_distance(some), span=(0, 20), limits=street,
                        label="horizontal distance (m)", title="Equal colour, equal distance")
for radius in (5, 10, 15, 20):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle="--"))

# %% nbgrader={"grade": true, "grade_id": "test_horizontal_distance", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(horizontal_distance)

# %% [markdown]
# ## Theory against practice: where the rings lie
#
# *Equal angles between the beams are unequal distances on the road: a scanner sees sharply only what is near.*
#
# A beam that looks down by the angle $\delta$ from the height $h$ meets a flat road at the distance
#
# $$d = \frac{h}{\tan\delta}.$$
#
# Our sensor sits $h = 1.73$ m above the road. For each beam we know its angle and, because the scan is simulated, which returns are road. Your function measures where its ring lies, once ahead of the car and once behind.

# %% tags=["folded"]
# @title The rings in the scan, by your function (you need not read this)
from utils.simulator import hdl64

is_road = truth["classes"] == truth["class_names"].tolist().index("ground")
is_road &= np.abs(cloud[:, 1]) < 2.5  # not the pavement beside it
downwards = -np.degrees(np.array(hdl64().elevations))


def rings(side):
    """Angle and measured distance of the beams that met the road at least 10 times."""
    angle_of, ring_of = [], []
    for beam, angle in enumerate(downwards):
        met_road = is_road & side & (truth["beams"] == beam)
        if met_road.sum() >= 10:
            angle_of.append(angle)
            ring_of.append(np.median(horizontal_distance(cloud[met_road])))
    return np.array(angle_of), np.array(ring_of)

# %%
angles = np.linspace(2.5, 25, 100)
axes = plots.curves({"flat road": (angles, 1.73 / np.tan(np.radians(angles)))},
                    {"yours, ahead": rings(cloud[:, 0] > 2), "yours, behind": rings(cloud[:, 0] < -2)},
                    across="angle below the horizon (degrees)", up="distance of the ring (m)",
                    title="Each beam draws a ring: theory, and your measurement")
axes.set_ylim(0, 45)
places = 1.73 / np.tan(np.radians(np.sort(downwards[downwards > 1])[::-1]))  # near to far
some = [np.abs(places - place).argmin() for place in (5, 10, 20, 40)]
show_table(["a ring at", "the next beam's ring"],
           [(f"{places[i]:.1f} m", f"{places[i + 1] - places[i]:.2f} m farther out") for i in some])

# %% [markdown]
# Near the car the measured rings lie on the curve. Farther out those ahead come too early and those behind too late: the street climbs. And look at the printed gaps: they grow faster than the distance, although the upper beams of this scanner, which reach far, stand closer together than the lower ones. So points crowd near the car, and a pedestrian far away gets only a few of them. Keep that in mind whenever a later lesson asks for "at least so many points".
#
# ## Why no loop?
#
# *NumPy does the same work in the same order, in machine code instead of Python.*
#
# A scanner delivers ten turns a second, so all processing of a turn must fit into 100 ms. Here is the loop that you did not write.

# %%
import math


def with_a_loop(cloud):
    """The same distances, point by point."""
    return [math.sqrt(row[0] * row[0] + row[1] * row[1]) for row in cloud]


faster = predict("On 100,000 points: how many times as long as your function does the loop take?")

# %% tags=["folded"]
# @title A stopwatch (you need not read this)
import inspect
from time import process_time


def seconds(function, cloud):
    """Time that the processor spends on a call; what is short is repeated."""
    function = inspect.unwrap(function)  # itself, without what may be around it
    begin, runs = process_time(), 0
    while process_time() - begin < 0.05:
        function(cloud)
        runs += 1
    return (process_time() - begin) / runs

# %%
counts = np.array([100, 300, 1_000, 3_000, 10_000, 30_000, 100_000])
times = {"loop": [seconds(with_a_loop, cloud[:n]) for n in counts]}
if is_written(horizontal_distance):
    times["yours"] = [seconds(horizontal_distance, cloud[:n]) for n in counts]
    faster.compare(times["loop"][-1] / times["yours"][-1],
                   "Python looks up, unpacks and allocates anew for every single number. NumPy "
                   "does that once for the whole column, and the rest is plain arithmetic.")
else:
    print("horizontal_distance is not written yet: there is only the loop to measure.")
plots.timing({name: (counts, series) for name, series in times.items()}, fit=False,
             title="Time for n points, both axes logarithmic")
for name, series in times.items():
    slope = np.polyfit(np.log(counts[3:]), np.log(series[3:]), 1)[0]
    print(f"{name}: {series[-1] * 1e3:.2f} ms for 100,000 points; from 3,000 points on n^{slope:.2f}")

# %% [markdown]
# On logarithmic axes $t = k\,n^p$ is a straight line of slope $p$. Towards the right both lines rise with a slope of about 1: ten times the points, about ten times the time. Being vectorised changes $k$, not $p$; the gap between the lines is the price of Python's handling of every single number. At the left end your curve goes flat: calling NumPy costs a few microseconds, however little there is to do.
#
# ## A return from nowhere
#
# *Some rows are not points, and they look nearest of all.*
#
# Your function can answer the question that an emergency brake asks ten times a second: how near is the nearest thing?

# %%
def nearer_than(limit):
    """The rows of the scan with a horizontal distance below `limit` metres."""
    return cloud[horizontal_distance(cloud) < limit]

# %%
too_near = nearer_than(0.5)
print(f"nearest return: {np.min(horizontal_distance(too_near), initial=99):.2f} m")
print("all rows nearer than 0.5 m:")
print(too_near)

# %% [markdown]
# The car would brake as hard as it can, for nothing: an obstacle in the very middle of the sensor. When an echo is lost, many scanners write a row all the same, at exactly (0, 0, 0). This scan holds three; each frame of the street recordings that this course grew from holds one.
#
# Others write NaN, *not a number*, or an infinite range. NaN spreads through every sum, and it is not equal to anything, itself included.

# %%
nan = np.nan
print("nan == nan:", nan == nan, "   nan < 5:", nan < 5, "   nan > 5:", nan > 5)
one_bad = np.array([[4.0, 1.0, -1.5], [nan, nan, nan], [6.0, 2.0, -1.4]])
print("mean of the cloud:", one_bad.mean(axis=0))
print("naive repair, one_bad[one_bad != nan]:", one_bad[one_bad != nan])

# %% [markdown]
# The naive repair keeps every number, NaN included, and it even loses the rows. Ask with a function instead. `np.isfinite` is False for NaN and for both infinities, number by number. To come from numbers to rows, `all` and `any` go along an axis; `~` turns a mask around:

# %%
table = np.array([[1.0, 2.0], [np.inf, 3.0], [0.0, 0.0]])
print(np.isfinite(table))
print("whole row finite:  ", np.isfinite(table).all(axis=1))
print("a 0 in the row:    ", (table == 0).any(axis=1))
print("no 0 in the row:   ", ~(table == 0).any(axis=1))

# %% [markdown]
# ## Exercise 2 · `drop_invalid` (points)
#
# Keep the rows that are points. A row is *not* a point when one of its coordinates is not finite, or when all three are exactly 0. A point exactly to the left of the sensor has x = 0 and is fine; so is a point whose intensity is missing.

# %% nbgrader={"grade": false, "grade_id": "drop_invalid", "locked": false, "schema_version": 3, "solution": true, "task": false}
def drop_invalid(cloud):
    """Remove the returns that are not points.

    Parameters
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
        x, y, z in metres, the sensor at the origin; then intensity.

    Returns
    -------
    ndarray, shape (m, 3) or (m, 4)
        The rows without those that have a NaN or infinite coordinate, or that lie
        at exactly (0, 0, 0). All columns, in the same order.
    """
    # 1. Take the three coordinates; intensity has no say.
    # 2. A mask: are all three finite?
    # 3. A mask: are all three equal to 0?
    # 4. Keep the rows where the first holds and the second does not.
    # roughly 4 lines
    ### BEGIN SOLUTION
    xyz = cloud[:, :3]
    is_somewhere = np.isfinite(xyz).all(axis=1)
    is_origin = (xyz == 0).all(axis=1)
    return cloud[is_somewhere & ~is_origin]
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# Build two masks with one entry per row, as for `table` above, from the columns `cloud[:, :3]`.
# </details>
# <details><summary>Hint 2</summary>
#
# "Finite" must hold for every coordinate of a good row: `all`. A bad row has 0 in every coordinate: `all` again, then turned around. With `any` you would lose the points straight to the left.
# </details>
# <details><summary>Hint 3</summary>
#
# `finite = np.isfinite(...).all(axis=1)` and `zero = (... == 0).all(axis=1)`, both of the three coordinates. Then index the cloud with `finite & ~zero`.
# </details>

# %% [markdown]
# **Six rows first.** Three of them are points, and have to come back as they were: the first, and the two at the end.

# %%
six = np.array([[6.0, 2.0, -1.7, 0.4],      # a point like any other
                [0.0, 0.0, 0.0, 0.3],       # a lost echo
                [nan, 1.0, 2.0, 0.5],       # not a number
                [4.0, -np.inf, 1.0, 0.5],   # infinitely far
                [0.0, 5.0, -1.6, 0.1],      # a point exactly to the left
                [4.0, -3.0, 1.0, nan]])     # a point whose intensity is missing
print("yours:")
print(drop_invalid(six))
print("expected:")
print(six[[0, 4, 5]])

# %% [markdown]
# **Look before you check.** We break the scan as heavy rain would: four thousand echoes lost, and a thousand rows that are not a number. Before, a bar stands at 0 m; after, it must be gone, and no other bar may change. The small one at 1 m stays: real points of our own car, which lesson 07 takes out. Rows with NaN have no bar at all: you see in the number of rows that they are gone.

# %%
def profile(scan, clean):
    """The number of rows, how many lie in each metre up to 20 m, and the nearest distance.

    With `clean`, drop_invalid takes the lost returns out before.
    """
    if clean:
        scan = drop_invalid(scan)
    distance = horizontal_distance(scan)
    return len(scan), np.histogram(distance, bins=np.arange(21))[0], np.nanmin(distance)

# %%
rng = np.random.default_rng(1)
wet = cloud.copy()
wet[rng.choice(len(wet), 4000, replace=False), :3] = 0.0
wet[rng.choice(len(wet), 1000, replace=False), :3] = nan
figure, pair = plt.subplots(2, 1, figsize=(8.5, 6.0), sharex=True, sharey=True, layout="compressed")
bars = {}
for (name, clean), axes in zip({"before": False, "after": True}.items(), pair):
    rows, bars[name], nearest = profile(wet, clean)
    plots.histogram(np.repeat(np.arange(20) + 0.5, bars[name]), bins=np.arange(21), axes=axes,
                    label="horizontal distance (m), one bar for each metre",
                    title=f"{name}: {rows:,} rows, the nearest at {nearest:.2f} m")
axes.set_xticks(range(0, 21, 2))
print("bars that changed, by their left edge:", np.flatnonzero(bars["before"] != bars["after"]), "m")

# %% nbgrader={"grade": true, "grade_id": "test_drop_invalid", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(drop_invalid)

# %% [markdown]
# ## Common mistakes
#
# *Each leaves its mark in the picture.*
#
# | what was written | what you see |
# |---|---|
# | `abs(x) + abs(y)` | diamonds instead of circles: the length of the way around the corner |
# | no square root | "up to 10 m" keeps only what is nearer than 3.2 m: 4 m count as 16 |
# | `cloud[0]` and `cloud[1]`, rows for columns | four numbers instead of one per point |
# | `np.linalg.norm(cloud, axis=1)` | nearly right, and wrong where the car must brake |
# | `x == 0` as the sign of a lost return | the points exactly to the left and right are gone, too |
# | `cloud[cloud != nan]` | everything stays, as one long row of numbers |

# %% tags=["folded"]
# @title Two of these mistakes (you need not read this)
xs, ys = cloud[:, 0], cloud[:, 1]
wrong = {"abs(x) + abs(y)": np.abs(xs) + np.abs(ys), "no square root": xs * xs + ys * ys}
figure, pair = plt.subplots(2, 1, figsize=(8.5, 9.4), layout="compressed")
for (name, values), axes in zip(wrong.items(), pair):
    plots.kept_and_removed(cloud, values <= 10, limits=((-15, 15), (-11, 11)), axes=axes,
                           title=f"{name}, up to 10")
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, linestyle="--"))
print(f"points of this scan with x = 0 that are no lost returns: {((xs == 0) & (ys != 0)).sum()}")

# %% [markdown]
# ## In practice
#
# - Scanners send packets of ranges and angles; a driver turns them into points, as `point_of` does. Some keep the rows of the scanner (an *organised* cloud, rays × beams) and mark what is missing with NaN; others drop it. Check a new recording for both before you trust its nearest point.
# - A turn takes 100 ms. At 50 km/h the car moves 1.4 m meanwhile, so real pipelines shift each return by what the car has moved since. Our simulated street holds still for a turn.
# - Intensity depends on range, angle and make of scanner. It helps to find lane markings and plates; do not compare it between two sensors.
#
# Open3D drops what is not finite with one call, and PCL has `pcl::removeNaNFromPointCloud` for it. Rows at (0, 0, 0) are finite, so both keep them:
#
# ```python
# import open3d as o3d
# scan = o3d.io.read_point_cloud("scan.pcd")  # x, y, z; the intensity is not kept
# scan = scan.remove_non_finite_points(remove_nan=True, remove_infinite=True)
# ```
#
# ## Summary
#
# - A ray gives a range; range, azimuth and elevation give a point; a turn gives a scan, a list of points.
# - Columns and masks treat all points at once: the same growth with n, a far smaller constant.
# - The distance that matters for driving is horizontal: sqrt(x² + y²).
# - Rows at (0, 0, 0) and rows with NaN are not points. Drop them first.
#
# **Sources.** How LiDARs work: [Behroozpour et al. 2017](https://doi.org/10.1109/MCOM.2017.1700030). The sensor and its place on the car: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Arrays instead of loops: [Harris et al. 2020](https://doi.org/10.1038/s41586-020-2649-2).
#
# **Next:** 02 · RANSAC: a line through the crowd

# %% [markdown]
# ## If you want more
#
# 1. Write `azimuth(cloud)` in degrees with `np.arctan2` and draw the scan as the scanner saw it: azimuth to the left, elevation upwards, coloured by your distance. The picture at the head of this lesson was made so.
# 2. Compute the distance beyond which a pedestrian, 0.5 m wide and 1.7 m tall, gets fewer than 10 returns from the 64-beam scanner (steps of 0.18°, beams a third of a degree apart). Compare with `truth["box_returns"]`.
#    <details><summary>An answer</summary>At the distance d one step is 0.00314 d wide and one beam 0.00582 d high. So 0.5 / (0.00314 d) × 1.7 / (0.00582 d) returns fit, about 46,500 / d²: fewer than 10 beyond 68 m. In the scan it happens much nearer, because others stand in the way.</details>
# 3. Run `with_a_loop` on `cloud.tolist()` instead of the array, and find out why it is faster.
#    <details><summary>An answer</summary>A list holds Python's own numbers. Each `row[0]` of an array makes a new NumPy number first, and arithmetic with those is slower than with Python's own.</details>

# %% [markdown] tags=["footer"]
# (footer)
