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
# ![One turn of a laser scanner, drawn twice, with colour for distance. Above, rows of returns in which a cyclist, a turning car, a pedestrian and a parked car are named. Below, the same returns from above, in rings around the sensor.](01_preview.png)
#
# Both pictures show the same data. The upper one shows the street ahead as a laser scanner sees it, with one row of dots for each laser beam. The lower one is a map of the result: a list of points in space, called a *point cloud*.
#
# **After this lesson you can**
# - explain how a laser scanner measures a point, and what each of its parameters changes,
# - process a hundred thousand points with one line of NumPy instead of a loop, and measure how much faster that is,
# - remove the returns that are not points.
#
# **You write** `horizontal_distance` (points) and `drop_invalid` (points). **Time:** (time). **You need** basic Python. The lesson explains the NumPy that it uses.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Your first line of code
#
# *A cloud is a table with one row per return and the columns x, y, z and intensity.*
#
# A scanner on the roof of a car has turned around once, on a straight road with three box-shaped cars. Each row of its cloud is a [return](#Words-of-the-course), a place from which light came back. The sensor is the origin; x points forward, y to the left and z up, always in metres.

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
                 limits=((-25, 35), (-16, 16)), title="Rings on the road, with gaps at the cars")
for x, y in ((15, 0), (8, -4), (-12, 4)):
    plots.ring(axes, x, y, radius=2.8, text="car")

# %% [markdown]
# `highway[:, 0]` is the column of all x. `highway[:, 0] > 0` tests for each row whether the return is ahead of the sensor. The result is a *mask*, one `True` or `False` per row. `highway[mask]` keeps the rows where the mask is `True`.
#
# Now it is your turn. Change the comparison so that only the three cars are left, and run the cell again. How do the cars differ from the road? Nothing is checked here, and an answer is below.

# %%
mine = highway[highway[:, 0] > 0]
plots.from_above(mine, values=mine[:, 2], span=(-2.6, 0), label="height z (m)",
                 limits=((-25, 35), (-16, 16)), title=f"Your mask keeps {len(mine)} returns");

# %% [markdown]
# <details><summary>An answer</summary>
#
# The road is low, so compare heights: `highway[highway[:, 2] > -2.5]`. This also removes a few low returns from the cars. Lesson 06 makes a filter of this line.
# </details>
#
# You need little more NumPy than this to work with a cloud:

# %%
heights = highway[:, 2]                     # a column: one number per return
is_left = highway[:, 1] > 0                 # a comparison: one True or False per return
left = highway[is_left]                     # a mask keeps the rows where it is True
left_ahead = highway[is_left & (highway[:, 0] > 0)]  # & means "and"; keep the parentheses

print("heights:   ", heights.shape, heights[:3].round(2))
print("is_left:   ", is_left.shape, is_left[:3], "and so on;", is_left.sum(), "are True")
print("left:      ", left.shape)
print("left_ahead:", left_ahead.shape)

# %% [markdown]
# None of these lines needs a loop, because each works on all returns at once. Such code is called *vectorised*.
#
# ## One pulse
#
# *A LiDAR measures how long light takes to come back.*
#
# LiDAR stands for *light detection and ranging*. A laser sends a pulse that lasts a few nanoseconds, and a detector next to it waits for the echo. How long does it wait? Every lesson has a few such questions; guess before you read on.

# %%
echo = predict("A car is 30 m ahead. How long after the pulse does its echo arrive?",
               choices=["0.2 seconds", "0.2 milliseconds", "0.2 microseconds", "0.2 nanoseconds"])

# %% [markdown]
# The light travels to the car and back. An echo that arrives after the time $t$ therefore comes from the range
#
# $$r = \frac{c\,t}{2}, \qquad c = 299\,792\,458\ \text{m/s}.$$

# %%
SPEED_OF_LIGHT = 299_792_458  # metres per second
echo.compare(f"{2 * 30 / SPEED_OF_LIGHT * 1e6:.1f} microseconds",
             "There and back is 60 m, and light travels 300 m in a microsecond. "
             "So a scanner can send its next pulse about a microsecond later.")
later = 2 * 0.02 / SPEED_OF_LIGHT
print(f"if the car were 2 cm farther away, the echo would be {later * 1e12:.0f} picoseconds later")

# %% [markdown]
# To distinguish 30.00 m from 30.02 m, a scanner must distinguish times that differ by the last number above. (A picosecond is a millionth of a microsecond.)
#
# A range alone is not a point, but the scanner also knows where it aimed. The *azimuth* $\alpha$ is the angle around the vertical axis, from straight ahead towards the left. The *elevation* $\varepsilon$ is the angle above the horizon. The range and these two angles make a point:
#
# $$x = r\cos\varepsilon\cos\alpha, \qquad y = r\cos\varepsilon\sin\alpha, \qquad z = r\sin\varepsilon.$$

# %%
def point_of(range_, azimuth, elevation):
    """x, y and z of an echo; the angles are in degrees."""
    azimuth, elevation = np.radians(azimuth), np.radians(elevation)
    flat = range_ * np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), range_ * np.sin(elevation)])


for azimuth, where in ((0, "ahead"), (90, "to the left"), (-90, "to the right")):
    print(f"30 m {where}, 3 degrees down:", point_of(30, azimuth, -3).round(2))

# %% [markdown]
# ## One turn
#
# *A turning beam draws a ring on the road, and an obstacle leaves a gap in the ring.*
#
# A scanner stacks several lasers at different elevations, turns the stack and fires all lasers at every step. Each laser is a [beam](#Words-of-the-course), each single shot is a *ray*, and all returns of one turn are a *scan*. The cloud above comes from a small scanner with 8 beams and 128 steps. It is simulated, like everything in this course, so we know the truth.
#
# In the first picture, the outermost ring has a gap behind the car ahead, because that car casts a *shadow*. A scanner sees only the side of a car that faces it. Here are the rays that go straight ahead, from the side.

# %%
ahead = highway[(highway[:, 0] > 0) & (np.abs(highway[:, 1]) < 0.1)]
figure, axes = plt.subplots(figsize=(8.5, 3.4), layout="compressed")
plots.from_side(ahead, values=ahead[:, 2], span=(-2.6, 0), label="height z (m)", axes=axes,
                limits=((-2, 22), (-3.2, 0.6)), title="The rays that go straight ahead")
for x, _, z, _ in ahead:  # row by row; _ stands for numbers that we do not need
    axes.plot([0, x], [0, z], color="black", linewidth=0.4)
print("the rays end at x =", ahead[:, 0].round(1), "m")

# %% [markdown]
# The steep rays meet the road, each a little farther out. The two flattest rays meet the car, 13 m ahead. Rays above the car would meet nothing, and the cloud would have no rows for them. A point cloud therefore says nothing about free space.
#
# ## Play: build your own scanner
#
# *The number of beams, the step and the noise each change the scan in their own way.*
#
# Now you change the scanner: the number of beams, the azimuth step between two shots, and the [noise](#Words-of-the-course) of the range. The street stays the same. With 32 beams, each of the four cars and three pedestrians within 12 m has at least eight returns.

# %%
left_over = predict("With only 4 beams, how many of these seven still have five returns or more?",
                    between=(0, 7))

# %% tags=["folded"]
# @title A street, and a scanner with your parameters (you need not read this)
from utils.scenes import random_street
from utils.simulator import Sensor, layers


def scan_with(beams=32, step=0.8, noise=0.02):
    """A frame of the street; the step is in degrees, the noise in metres."""
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
# The same without sliders: one scanner, then one parameter made worse at a time. Each title ends with the number of all returns. Two circles mark a pole (left) and a pedestrian (right), with the number of their returns.

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
# With fewer beams, the rings are farther apart, and the pedestrian is between two of them. With larger steps, the thin pole is between two rays. With more noise, nothing disappears, but walls become thick and flat surfaces rough.
#
# How many returns of each car and each pedestrian are left? The simulator knows.

# %% tags=["folded"]
# @title Count the returns of each object (you need not read this)
counted = {}
for beams in (32, 16, 8, 4):
    returns = np.bincount(scan_with(beams).scan.objects, minlength=100)
    counted[f"{beams} beams"] = [returns[box.identity] for box in cars + pedestrians]
show_table(["returns of a", *counted],
           [(f"{box.kind} at {distance_of(box):.1f} m", *numbers)
            for box, *numbers in zip(cars + pedestrians, *counted.values())])
left_over.compare(sum(n >= 5 for n in counted["4 beams"]),
                  "The last column of the table shows all four cars, and no pedestrian. A ring "
                  "leaves many returns on a car, but one or two on a pedestrian, or none.")

# %% [markdown]
# ## A cloud is an array
#
# *Each row is a return, and each column a quantity.*
#
# From here on we use one scan of a 64-beam scanner in a street. Each row holds x, y, z, and the *intensity* of the echo between 0 and 1. Bright paint and number plates reflect much light, tyres and windows only a little.

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
                        title="The same points, coloured by intensity")
bright = cloud[cloud[:, 3] > 0.9]
axes.plot(bright[:, 0], bright[:, 1], "s", color="black", markersize=3)
plots.ring(axes, 5.1, -2.9, radius=1.2, text="number plate")
print(f"{len(bright)} of {len(cloud):,} returns are brighter than 0.9 (black squares)");

# %% [markdown]
# The small groups of points next to the sensor are parts of the [ego car](#Words-of-the-course): a mirror, the tailgate and the aerial.
#
# People are easier to find in three dimensions.

# %%
people = predict("How many pedestrians are in the next picture? Do not count cyclists.")

# %% [markdown]
# Drag the points to turn them.

# %%
from utils.scene3d import Scene

nearby = cloud[(np.abs(cloud[:, 0]) < 25) & (np.abs(cloud[:, 1]) < 12)]
Scene("The street in space").add_cloud(nearby).add_ego_car().show(interactive=True)

# %% [markdown]
# A second file holds the truth: which object each return came from, and where each car and each pedestrian was.

# %%
from utils.datasets import DATA

truth = np.load(DATA / "cloud_truth.npz")
axes = plots.from_above(cloud, limits=street, title="The pedestrians and the numbers of their returns")
found = 0
for kind, (x, y, _), returns in zip(truth["box_kinds"], truth["box_centres"], truth["box_returns"]):
    if kind == "pedestrian" and abs(x) < 25 and abs(y) < 12:
        found += 1
        plots.ring(axes, x, y, radius=0.8, text=f"{returns}")
people.compare(found, "The one with 9 returns is a child behind the car that is parked on the left. "
                      "A scanner cannot see through cars, so most of the child is not in the cloud.")

# %% [markdown]
# ## The naive idea: the length of the row
#
# *A row of a cloud is not a vector, because its columns do not all mean the same.*
#
# For a car that has to brake, the distance *along the road* matters. Whether the laser hit a bumper or the roof above it must make no difference. NumPy has a function for the length of a vector, so the first idea is `np.linalg.norm(cloud, axis=1)`. We try it on a strip straight ahead, less than 30 cm to either side. There, the distance along the road is simply x.

# %%
strip = cloud[(np.abs(cloud[:, 1]) < 0.3) & (cloud[:, 0] > 3) & (cloud[:, 0] < 21)]
x = strip[:, 0]
error = np.linalg.norm(strip, axis=1) - x
plots.curves({}, {"returns straight ahead": (x, error)}, across="x, the distance along the road (m)",
             up="error of the length (m)", title="The error is largest near the car")
worst = error.argmax()
print(f"largest error: {error[worst]:.3f} m, at a distance of {x[worst]:.1f} m")
print(f"the same return without its intensity:  {np.linalg.norm(strip[worst, :3]) - x[worst]:.3f} m")
print(f"without its intensity and its height:   {np.linalg.norm(strip[worst, :2]) - x[worst]:.3f} m")

# %% [markdown]
# The error is largest near the car, where it matters most. The column of points just before 9 m is a pedestrian who crosses the road. By this measure, the feet are farther away than the head.
#
# There are two causes. The main one is height, because the length runs down to the road at a slant. The other one is intensity, which is squared and added as well. Here it adds a centimetre, but other sensors report intensities up to 255. The rest, in the last line, is not an error, because the return is a little to the side.
#
# ## The idea: measure on the ground
#
# *Leave out the height and use only x and y.*
#
# The *horizontal distance* of a point $(x, y, z)$ from the sensor is
#
# $$d = \sqrt{x^2 + y^2}.$$
#
# All points of a lamp post have the same $d$, from bottom to top.
#
# ## Exercise 1 · `horizontal_distance` (points)
#
# Return one distance per point. The cloud may have three or four columns, and it may be empty. NumPy is enough; of the packages listed at the end, this lesson forbids nothing.

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
    # 2. Square both, add them and take the square root (np.sqrt), for all points at once.
    # roughly 2 lines
    ### BEGIN SOLUTION
    x, y = cloud[:, 0], cloud[:, 1]
    return np.sqrt(x**2 + y**2)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# A column of n numbers behaves like a single number: `heights * 2` doubles all of them. So write Pythagoras' theorem as if for one point.
# </details>
# <details><summary>Hint 2</summary>
#
# `cloud[:, 0]` is the x of every point (all rows, column 0). Which column is y?
# </details>
# <details><summary>Hint 3</summary>
#
# `np.hypot(a, b)` is the square root of a² + b², also for whole columns. Return it for the columns 0 and 1.
# </details>

# %% [markdown]
# **Three points first.** Their (x, y) are (3, 4), (−6, 8) and (0, 7). Their heights and intensities must make no difference. Expected: 5, 10 and 7.

# %%
three = np.array([[3.0, 4.0, -1.7, 0.1], [-6.0, 8.0, 4.0, 0.9], [0.0, 7.0, 2.5, 1.0]])
print("yours:   ", np.round(horizontal_distance(three), 2))
print("expected: [ 5. 10.  7.]")

# %% [markdown]
# **Look before you check.** The colour shows your distance, so it should change in circles around the sensor. Each dashed line, at 5, 10, 15 and 20 m, should follow one colour.

# %%
some = cloud[::8]
axes = plots.from_above(some, values=horizontal_distance(some), span=(0, 20), limits=street,
                        label="horizontal distance (m)", title="Equal colour, equal distance")
for radius in (5, 10, 15, 20):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle="--"))

# %% nbgrader={"grade": true, "grade_id": "test_horizontal_distance", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(horizontal_distance)

# %% [markdown]
# ## Theory against practice: where the rings are
#
# *Equal angles between the beams mean unequal distances on the road.*
#
# A beam that points down by the angle $\delta$ from the height $h$ meets a flat road at the distance
#
# $$d = \frac{h}{\tan\delta}.$$
#
# Our sensor is $h = 1.73$ m above the road. The simulator knows the angle of each beam, and which returns come from the road. Your function measures the distance of each ring, once ahead of the car and once behind it.

# %% tags=["folded"]
# @title Measure the rings with your function (you need not read this)
from utils.simulator import hdl64

is_road = truth["classes"] == truth["class_names"].tolist().index("ground")
is_road &= np.abs(cloud[:, 1]) < 2.5  # without the pavements
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
# Near the car, the measured rings are on the curve. Farther out, the rings ahead are nearer than the curve says and the rings behind are farther away, because the street climbs. The printed gaps grow faster than the distance, although the upper beams, which reach far, are closer together than the lower ones. A pedestrian far away therefore gets only a few points.
#
# ## Why no loop?
#
# *NumPy does the same work in machine code instead of Python.*
#
# A scanner makes ten turns a second, so all processing of a turn must fit into 100 ms. Here is your function, written with a loop.

# %%
import math


def with_a_loop(cloud):
    """The same distances, point by point."""
    return [math.sqrt(row[0] * row[0] + row[1] * row[1]) for row in cloud]


faster = predict("On 100,000 points, the loop takes how many times as long as your function?")

# %% tags=["folded"]
# @title A stopwatch (you need not read this)
import inspect
from time import process_time


def seconds(function, cloud):
    """Processor time of one call in seconds; short calls are repeated."""
    function = inspect.unwrap(function)  # without any function around it
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
                   "For every single number, Python looks up a function, unpacks the number and "
                   "makes a new object. NumPy does that once for a whole column.")
else:
    print("horizontal_distance is not written yet, so only the loop is measured.")
plots.timing({name: (counts, series) for name, series in times.items()}, fit=False,
             title="Time for n points, on logarithmic axes")
for name, series in times.items():
    slope = np.polyfit(np.log(counts[3:]), np.log(series[3:]), 1)[0]
    print(f"{name}: {series[-1] * 1e3:.2f} ms for 100,000 points; grows like n^{slope:.2f} above 3,000")

# %% [markdown]
# On logarithmic axes, $t = k\,n^p$ is a straight line with slope $p$. On the right, both lines have a slope of about 1, so ten times the points take about ten times as long. Vectorising changes $k$, not $p$. On the left, your curve is flatter, because each call of NumPy costs some time, even for a few points.
#
# ## Returns that are not points
#
# *A lost echo can look like an obstacle at the sensor.*
#
# Your function can answer the question of an emergency brake: how far away is the nearest obstacle?

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
# The car would brake as hard as it can, for no reason. The nearest "obstacle" is exactly at the sensor. Many scanners write a row at (0, 0, 0) when an echo is lost. This scan has three of them.
#
# Other scanners write NaN, *not a number*, or an infinite range. NaN spreads through every sum, and it is not equal to anything, not even to itself.

# %%
nan = np.nan
print("nan == nan:", nan == nan, "   nan < 5:", nan < 5, "   nan > 5:", nan > 5)
one_bad = np.array([[4.0, 1.0, -1.5], [nan, nan, nan], [6.0, 2.0, -1.4]])
print("mean of the cloud:", one_bad.mean(axis=0))
print("first attempt, one_bad[one_bad != nan]:", one_bad[one_bad != nan])

# %% [markdown]
# The first attempt keeps every number, even NaN, and loses the rows. `np.isfinite` works better. It is False for NaN and for both infinities, number by number. With `axis=1`, `all` and `any` combine the numbers of each row. `~` inverts a mask:

# %%
table = np.array([[1.0, 2.0], [np.inf, 3.0], [0.0, 0.0]])
print(np.isfinite(table))
print("whole row finite:  ", np.isfinite(table).all(axis=1))
print("a 0 in the row:    ", (table == 0).any(axis=1))
print("no 0 in the row:   ", ~(table == 0).any(axis=1))

# %% [markdown]
# ## Exercise 2 · `drop_invalid` (points)
#
# Keep the rows that are points. A row is *not* a point if one of its coordinates is not finite, or if all three are exactly 0. A point exactly to the left of the sensor has x = 0 and is valid. A point with an intensity of NaN is also valid.

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
        The rows of the cloud, in the same order and with all columns, except those
        with a NaN or infinite coordinate and those at exactly (0, 0, 0).
    """
    # 1. Take the three coordinates; the intensity does not matter.
    # 2. A mask: are all three finite?
    # 3. A mask: are all three equal to 0?
    # 4. Keep the rows where the first mask is True and the second is False.
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
# In a good row, every coordinate is finite: `all`. In a lost return, every coordinate is 0: `all` again, then inverted. With `any`, you would lose the points straight to the left.
# </details>
# <details><summary>Hint 3</summary>
#
# `finite = np.isfinite(...).all(axis=1)` and `zero = (... == 0).all(axis=1)`, both from the three coordinates. Then index the cloud with `finite & ~zero`.
# </details>

# %% [markdown]
# **Six rows first.** Three of them are points and must come back unchanged: the first and the last two.

# %%
six = np.array([[6.0, 2.0, -1.7, 0.4],      # an ordinary point
                [0.0, 0.0, 0.0, 0.3],       # a lost echo
                [nan, 1.0, 2.0, 0.5],       # not a number
                [4.0, -np.inf, 1.0, 0.5],   # infinitely far
                [0.0, 5.0, -1.6, 0.1],      # a point exactly to the left
                [4.0, -3.0, 1.0, nan]])     # a point with an intensity of NaN
print("yours:")
print(drop_invalid(six))
print("expected:")
print(six[[0, 4, 5]])

# %% [markdown]
# **Look before you check.** We damage the scan as heavy rain would. Four thousand echoes are lost, and a thousand rows become NaN. The bar at 0 m must be gone afterwards, and no other bar may change. The small bar at 1 m shows real points of the ego car, which lesson 07 removes. Rows with NaN have no bar; only the number of rows shows that they are gone.

# %%
def profile(scan, clean):
    """The number of rows, the number in each metre up to 20 m, and the smallest distance.

    With `clean`, drop_invalid first removes the rows that are not points.
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
    plots.histogram(np.repeat(np.arange(20) + 0.5, bars[name].astype(int)), bins=np.arange(21), axes=axes,
                    label="horizontal distance (m), one bar per metre",
                    title=f"{name}: {rows:,} rows, the nearest at {nearest:.2f} m")
axes.set_xticks(range(0, 21, 2))
print("bars that changed, by their left edge:", np.flatnonzero(bars["before"] != bars["after"]), "m")

# %% nbgrader={"grade": true, "grade_id": "test_drop_invalid", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(drop_invalid)

# %% [markdown]
# ## Common mistakes
#
# *Each mistake leaves its mark in a picture or in the shape of the result.*
#
# | mistake | what you see |
# |---|---|
# | `abs(x) + abs(y)` | diamonds instead of circles |
# | no square root | "up to 10 m" keeps only points nearer than 3.2 m |
# | `cloud[0]` and `cloud[1]`, rows instead of columns | four numbers instead of one per point |
# | `x == 0` as a test for lost returns | points exactly to the left and right also disappear |
# | `cloud[cloud != nan]` | every number stays, in one long row |

# %% tags=["folded"]
# @title Two of these mistakes (you need not read this)
xs, ys = cloud[:, 0], cloud[:, 1]
wrong = {"abs(x) + abs(y)": np.abs(xs) + np.abs(ys), "no square root": xs * xs + ys * ys}
figure, pair = plt.subplots(2, 1, figsize=(8.5, 9.4), layout="compressed")
for (name, values), axes in zip(wrong.items(), pair):
    plots.kept_and_removed(cloud, values <= 10, limits=((-15, 15), (-11, 11)), axes=axes,
                           title=f"{name}, up to 10")
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, linestyle="--"))
print(f"points of this scan with x = 0 that are not lost returns: {((xs == 0) & (ys != 0)).sum()}")

# %% [markdown]
# ## In practice
#
# - Scanners send ranges and angles, and a driver program turns them into points, as `point_of` does. Some drivers write NaN for missing returns, and others leave them out. Look for NaN and for (0, 0, 0) in a new recording before you trust its nearest point.
# - A turn takes 100 ms. At 50 km/h the car moves 1.4 m in that time, so real systems correct each return for this motion.
#
# Open3D removes points that are not finite with one call, and PCL does so with `pcl::removeNaNFromPointCloud`. Rows at (0, 0, 0) are finite, so both keep them:
#
# ```python
# import open3d as o3d
# scan = o3d.io.read_point_cloud("scan.pcd")  # x, y, z; the intensity is not kept
# scan = scan.remove_non_finite_points(remove_nan=True, remove_infinite=True)
# ```
#
# ## Summary
#
# - Range, azimuth and elevation give a point. A turn gives a scan, which is a list of points.
# - Columns and masks are far faster than a loop.
# - The distance that matters for driving is horizontal: sqrt(x² + y²).
# - Rows at (0, 0, 0) and rows with NaN are not points. Remove them first.
#
# **Sources.** How LiDARs work: [Behroozpour et al. 2017](https://doi.org/10.1109/MCOM.2017.1700030). The sensor and its place on the car: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Arrays instead of loops: [Harris et al. 2020](https://doi.org/10.1038/s41586-020-2649-2).
#
# **Next:** 02 · RANSAC: a line through the crowd

# %% [markdown]
# ## If you want more
#
# 1. (20 minutes) Write `azimuth(cloud)` in degrees with `np.arctan2`. Draw the scan as the scanner saw it: azimuth to the left, elevation upwards, coloured by your distance. The upper picture at the top of this lesson was made this way.
# 2. (15 minutes) A pedestrian is 0.5 m wide and 1.7 m tall. The 64-beam scanner has steps of 0.18° and beams a third of a degree apart. Beyond which distance does the pedestrian get fewer than 10 returns? Compare with `truth["box_returns"]`.
#    <details><summary>An answer</summary>At the distance d, one step is 0.00314 d wide and the beams are 0.00582 d apart. So 0.5 / (0.00314 d) × 1.7 / (0.00582 d) returns fit, about 46,500 / d². These are fewer than 10 beyond 68 m. In the scan it also happens much nearer, because other objects are in front.</details>

# %% [markdown] tags=["footer"]
# (footer)
