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
# ![The same laser scan drawn twice, coloured by distance. The upper picture shows the view ahead as rows of dots, with labels at a cyclist, a turning car, a pedestrian and a parked car. The lower picture shows the scan from above, as rings around the sensor.](01_preview.png)
#
# Both pictures show the same laser scan. The upper one is the scanner's own view of the street ahead, with one row of dots per laser beam. The lower one shows the scan from above. A scan is a list of points, called a *point cloud*.
#
# **After this lesson you can**
# - explain how a laser scanner measures a point, and what each of its parameters changes,
# - process a hundred thousand points with one line of NumPy instead of a loop, and measure how much faster that line is,
# - remove the rows of a scan that are not real points.
#
# **You write** `horizontal_distance` (points) and `drop_invalid` (points). **Time:** (time), in two sittings of 40 and 35 minutes. **You need** basic Python. The lesson explains the NumPy it uses.

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %% [markdown]
# ## Your first line of code
#
# A scanner on the roof of a car has made one full turn. The scan shows a straight road and three box-shaped cars. Each row of its cloud is a [return](#Words-of-the-course), a place from which laser light came back. The columns are x, y, z and intensity. The sensor is at the origin. The x axis points forward, y to the left and z up, always in metres.

# %%
import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import FloatSlider, IntSlider, interact

from utils import check, is_written, load_cloud, load_street, plots, predict, show_table
from utils.scenes import simple_highway

frame = simple_highway()
highway = frame.cloud
figure, axes = plt.subplots(figsize=(8.5, 5.2), layout="compressed")
plots.from_above(highway, values=highway[:, 2], span=(-2.6, -1), label="height z (m)", axes=axes,
                 limits=((-25, 35), (-16, 16)), title="Rings on the road, with gaps at the cars")
for x, y in ((15, 0), (8, -4), (-12, 4)):
    plots.ring(axes, x, y, radius=2.8, text="car")

# %% [markdown]
# `highway[:, 0]` is the column of x values. `highway[:, 0] > 0` tests for each row whether the return is ahead of the sensor. The result is a *mask*, with one `True` or `False` per row. `highway[mask]` keeps the rows where the mask is `True`.
#
# Now it is your turn. Change the comparison so that only the three cars remain, and run the cell again. How do the cars differ from the road? This cell is not checked. An answer is below.

# %%
mine = highway[highway[:, 0] > 0]
plots.from_above(mine, values=mine[:, 2], span=(-2.6, -1), label="height z (m)",
                 limits=((-25, 35), (-16, 16)), title=f"Your mask keeps {len(mine)} returns");

# %% [markdown]
# <details><summary>An answer</summary>
#
# The road is lower than the cars, so compare heights: `highway[highway[:, 2] > -2.5]`. This also removes a few low returns from the cars. In lesson 06, you turn this line into a filter.
# </details>
#
# These four lines show most of the NumPy that you need to work with a cloud:

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
# None of these lines needs a loop, because each one works on all the returns at once. Code like this is called *vectorised*.
#
# ## One pulse
#
# *A LiDAR measures how long light takes to come back.*
#
# LiDAR stands for *light detection and ranging*. A laser sends a pulse of a few nanoseconds, and a detector next to it waits for the echo. How long does it wait? Every lesson asks a few questions like this. Guess before you read on.

# %%
echo = predict("A car is 30 m ahead. How long after the pulse does its echo arrive?",
               choices=["0.2 seconds", "0.2 milliseconds", "0.2 microseconds", "0.2 nanoseconds"])

# %% [markdown]
# The light travels to the car and back. An echo that arrives after a time $t$ therefore comes from the range
#
# $$r = \frac{c\,t}{2}, \qquad c = 299\,792\,458\ \text{m/s}.$$

# %%
SPEED_OF_LIGHT = 299_792_458  # metres per second
echo.compare(f"{2 * 30 / SPEED_OF_LIGHT * 1e6:.1f} microseconds",
             "The round trip is 60 m, and light travels 300 m in a microsecond. "
             "Even an echo from 120 m arrives within a microsecond.")
later = 2 * 0.02 / SPEED_OF_LIGHT
print(f"if the car were 2 cm farther away, the echo would arrive {later * 1e12:.0f} picoseconds later")

# %% [markdown]
# To distinguish 30.00 m from 30.02 m, a scanner must measure time differences as small as the last number above. (A picosecond is a millionth of a microsecond.)
#
# A range alone does not give a point, but the scanner also knows where it aimed. The *azimuth* $\alpha$ is the angle around the vertical axis, from straight ahead towards the left. The *elevation* $\varepsilon$ is the angle above the horizon. The picture below the formulas shows both angles. With the range, they give the point:
#
# $$x = r\cos\varepsilon\cos\alpha, \qquad y = r\cos\varepsilon\sin\alpha, \qquad z = r\sin\varepsilon.$$

# %% tags=["folded"]
# @title Draw the two angles (you need not read this)
from utils.plots.style import BLUE, VERMILION

figure, pair = plt.subplots(1, 2, figsize=(8.5, 2.7), layout="compressed", facecolor="white")
views = (("From above: the azimuth α", "r cos ε", "α", "x = r cos ε cos α", "y = r cos ε sin α"),
         ("From the side: the elevation ε", "r", "ε", "r cos ε", "z = r sin ε"))
for axes, (title, longest, angle, across, up) in zip(pair, views):
    axes.plot([0, 4, 4], [0, 0, 3], "--", color="black", linewidth=1.2)
    axes.annotate("", (4, 3), (0, 0), arrowprops={
        "arrowstyle": "-|>", "color": BLUE, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0})
    turn = np.linspace(0, np.arctan2(3, 4), 30)
    axes.plot(1.2 * np.cos(turn), 1.2 * np.sin(turn), color=VERMILION, linewidth=2.2)
    for x, y, text, colour in ((1.5, 0.5, angle, VERMILION), (1.6, 1.9, longest, BLUE),
                               (2.3, -0.4, across, "black"), (5.4, 1.5, up, "black"),
                               (-0.2, -0.4, "sensor", "black")):
        axes.text(x, y, text, color=colour, ha="center", va="center", fontsize=11)
    axes.set(xlim=(-0.8, 6.8), ylim=(-0.8, 3.2), aspect="equal")
    axes.set_title(title, loc="left", fontsize=12, fontweight="bold", pad=6)
    axes.set_axis_off()

# %%
def point_of(range_, azimuth, elevation):
    """Return x, y and z of an echo. The angles are in degrees."""
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
# A scanner turns a stack of lasers that point at different elevations, and fires all of them at every step. Each laser is a [beam](#Words-of-the-course), each single shot is a *ray*, and all the returns from one turn form a *scan*. The cloud above comes from a small scanner with 8 beams and 128 steps, 2.6 m above the road. Like nearly all data in this course, it is simulated, so we know the truth.
#
# In the first picture, the car ahead casts a *shadow*, so the outermost ring has a gap behind it. The four gaps in the innermost ring are not obstacles. There, the corners of the roof under the scanner block the steepest beam.
#
# A scanner sees only the side of a car that faces the scanner. The next picture shows the rays straight ahead, from the side.

# %%
ahead = highway[(highway[:, 0] > 0) & (np.abs(highway[:, 1]) < 0.1)]
figure, axes = plt.subplots(figsize=(8.5, 3.4), layout="compressed")
plots.from_side(ahead, values=ahead[:, 2], span=(-2.6, -1), label="height z (m)", axes=axes,
                level=-2.6, limits=((-2, 22), (-3.2, 0.6)), title="The rays that go straight ahead")
axes.plot([13, 13, 14, 14, 16, 16, 17, 17], [-2.6, -1.3, -1.3, -0.6, -0.6, -1.3, -1.3, -2.6],
          color="black")  # the outline of the car, which the simulator knows
axes.text(15, -1.7, "car", ha="center")
for x, _, z, _ in ahead:  # one row at a time; _ is a number that we do not need
    axes.plot([0, x], [0, z], color="black", linewidth=0.4)
print("the rays end at x =", ahead[:, 0].round(1), "m")

# %% [markdown]
# The steep rays hit the road, each a little farther out. The two uppermost rays hit the back of the car, 13 m ahead. A ray above the car would hit nothing and leave no row in the cloud. So a place without points may be free, or it may be hidden behind an obstacle.
#
# ## Play: build your own scanner
#
# Now you choose the number of beams, the azimuth step between two shots, and the [noise](#Words-of-the-course) in the range. The scanner is now in a street, which stays the same. With 32 beams, each of the four cars and three pedestrians within 12 m has at least eight returns.

# %%
left_over = predict("With only 4 beams, how many of these seven still have at least five returns?",
                    between=(0, 7))

# %% tags=["folded"]
# @title Build a street and a scanner with your parameters (you need not read this)
from utils.scenes import random_street
from utils.simulator import Sensor, layers


def scan_with(beams=32, step=0.8, noise=0.02):
    """Return a frame of the street. The step is in degrees, the noise in metres."""
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
# Here is the same without sliders. The first picture shows the full scan, and in each of the others, one parameter is worse. The titles give the total number of returns. The circles mark a pole (left) and a pedestrian (right), with the number of returns from each.

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
# With fewer beams, the rings are farther apart, and the pedestrian falls between two of them. With larger steps, the thin pole falls between two rays. With more noise, nothing disappears, but walls look thicker and flat surfaces look rough.
#
# How many returns does each car and each pedestrian still have? The simulator knows.

# %% tags=["folded"]
# @title Count the returns of each object (you need not read this)
counted = {}
for beams in (32, 16, 8, 4):
    returns = np.bincount(scan_with(beams).scan.objects, minlength=100)
    counted[f"{beams} beams"] = [returns[box.identity] for box in cars + pedestrians]
show_table(["returns from a", *counted],
           [(f"{box.kind} at {distance_of(box):.1f} m", *numbers)
            for box, *numbers in zip(cars + pedestrians, *counted.values())])
left_over.compare(sum(n >= 5 for n in counted["4 beams"]),
                  "In the last column of the table, the four cars still have many returns, but "
                  "no pedestrian has five. A ring leaves many returns on a car, but only one or "
                  "two on a pedestrian, or none.")

# %% [markdown]
# ## A cloud is an array
#
# For the rest of this lesson, we use one scan of a street from a 64-beam scanner. Its fourth column is the *intensity* of the echo, between 0 and 1. Bright paint and number plates reflect a lot of light, but tyres and windows reflect only a little.

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
intensity = cloud[:, 3] if cloud.shape[1] == 4 else np.zeros(len(cloud))  # not all files have one
axes = plots.from_above(cloud, values=intensity, span=(0, 0.6), label="intensity", limits=street,
                        title="The same points, coloured by intensity")
bright = cloud[intensity > 0.9]
axes.plot(bright[:, 0], bright[:, 1], "s", color="black", markersize=3)
plots.ring(axes, 5.1, -2.9, radius=1.2, text="number plate")
print(f"{len(bright)} of {len(cloud):,} returns are brighter than 0.9 (black squares)");

# %% [markdown]
# The small groups of points next to the sensor are parts of the [ego car](#Words-of-the-course), which carries the scanner: a mirror, the tailgate and the aerial.
#
# People are easier to find in three dimensions.

# %%
people = predict("How many pedestrians are in the next picture? Do not count cyclists.")

# %% [markdown]
# Drag the picture to turn it.

# %%
from utils.scene3d import Scene

nearby = cloud[(np.abs(cloud[:, 0]) < 25) & (np.abs(cloud[:, 1]) < 12)]
Scene("The street in space").add_cloud(nearby).add_ego_car().show(interactive=True)

# %% [markdown]
# A second file contains the truth: the object that each return came from, and the position of each car and pedestrian. `load_street` reads both files.

# %%
cloud, truth = load_street()
axes = plots.from_above(cloud, limits=street, title="Each pedestrian, with its number of returns")
found = 0
for kind, (x, y, _), returns in zip(truth["box_kinds"], truth["box_centres"], truth["box_returns"]):
    if kind == "pedestrian" and abs(x) < 25 and abs(y) < 12:
        found += 1
        aside = y < -6  # above this ring is another ring, so the number is to the right
        plots.ring(axes, x, y, radius=0.8, text="" if aside else f"{returns}")
        if aside:
            axes.text(x + 1, y - 0.7, returns, bbox={"color": "white", "alpha": 0.85, "pad": 1})
people.compare(found, "The one with 9 returns is a child behind the car parked on the left. A scanner "
                      "cannot see through a car, so most of the child is missing from the cloud.")

# %% [markdown]
# Here is the scene again, with the pedestrians in orange. Two of them are close together, and only a few points belong to the child.

# %%
is_near = (np.abs(cloud[:, 0]) < 25) & (np.abs(cloud[:, 1]) < 12)
on_person = truth["classes"] == truth["class_names"].tolist().index("pedestrian")
(Scene("The pedestrians in orange").add_cloud(cloud[is_near & ~on_person], colour="#999999")
 .add_cloud(cloud[is_near & on_person], colour="#D55E00", size=4, name="points on pedestrians")
 .add_ego_car().show())

# %% [markdown]
# ## The naive idea: the length of the row
#
# *A row of a cloud is not a vector, because its columns measure different things.*
#
# A car that has to brake needs the distance *along the road*, no matter whether the laser hit a bumper or the roof above it. NumPy has a function for the length of a vector, so we first try `np.linalg.norm(cloud, axis=1)`. We test it on a strip straight ahead, less than 30 cm to either side. In this strip, the distance along the road is simply x.

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
# The error is largest near the car, where it matters most. The column of points just before 9 m is a pedestrian crossing the road. According to this measure, the feet are farther away than the head. The column at 20 m is the back of a car.
#
# There are two causes. The main one is height, because the length is measured at a slant, from the roof down to the return. The other is intensity, which is squared and added as well. Here it adds a centimetre, but other sensors report intensities up to 255. The small value in the last printed line is not an error, because the return is a little to one side.
#
# ## The idea: measure on the ground
#
# The *horizontal distance* of a point $(x, y, z)$ from the sensor leaves out the height:
#
# $$d = \sqrt{x^2 + y^2}.$$
#
# All points of an upright lamp post have nearly the same $d$, from bottom to top.
#
# ## Exercise 1 · `horizontal_distance` (points)
#
# Return one distance per point. The cloud may have three or four columns, and it may be empty. You may use any package listed at the end, but NumPy is enough.

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
        sqrt(x² + y²) in metres. Height and intensity make no difference.
    """
    # 1. Take the x column and the y column.
    # 2. Square both, add them and take the square root (np.sqrt), for all points at once.
    # roughly 2 lines
    ### BEGIN SOLUTION
    x, y = cloud[:, 0], cloud[:, 1]
    return np.sqrt(x**2 + y**2)
    ### END SOLUTION

# %% [markdown]
# <details><summary>Hint 1</summary>
#
# You can compute with a column as if it were a single number. For example, `heights * 2` doubles every height. So write Pythagoras' theorem as you would for one point.
# </details>
# <details><summary>Hint 2</summary>
#
# `cloud[:, 0]` takes column 0 of all rows, so it is the x of every point. Which column is y?
# </details>
# <details><summary>Hint 3</summary>
#
# `np.hypot(a, b)` is the square root of a² + b², and it also works on whole columns. Return it for columns 0 and 1.
# </details>

# %% [markdown]
# **Three points first.** They are at (3, 4), (−6, 8) and (0, 7), so their distances are 5, 10 and 7. Their heights and intensities must make no difference.

# %%
three = np.array([[3.0, 4.0, -1.7, 0.1], [-6.0, 8.0, 4.0, 0.9], [0.0, 7.0, 2.5, 1.0]])
print("yours:   ", np.round(horizontal_distance(three), 2))
print("expected: [ 5. 10.  7.]")

# %% [markdown]
# **Look before you check.** The colour shows your distance, so it should change in circles around the sensor. Along each dashed circle, at 5, 10, 15 and 20 m, the colour should stay the same.

# %%
some = cloud[::8]
axes = plots.from_above(some, values=horizontal_distance(some), span=(0, 20), limits=street,
                        label="horizontal distance (m)", title="Points of equal colour are equally far away")
for radius in (5, 10, 15, 20):
    axes.add_patch(plt.Circle((0, 0), radius, fill=False, linestyle="--"))

# %% nbgrader={"grade": true, "grade_id": "test_horizontal_distance", "locked": true, "points": 5, "schema_version": 3, "solution": false, "task": false}
check(horizontal_distance)

# %% [markdown]
# ## Theory against practice: where the rings are
#
# *Beams at equal angles do not draw rings at equal distances.*
#
# If a beam leaves the sensor at a height $h$ and points down by an angle $\delta$, it hits a flat road at the distance
#
# $$d = \frac{h}{\tan\delta}.$$
#
# The sensor of this scan is only $h = 1.73$ m above the road. The simulator knows the angle of each beam and which returns come from the road. Your function measures the distance of each ring, once ahead of the car and once behind it.

# %% tags=["folded"]
# @title Measure the rings with your function (you need not read this)
from utils.simulator import hdl64

is_road = truth["classes"] == truth["class_names"].tolist().index("ground")
is_road &= np.abs(cloud[:, 1]) < 2.5  # without the pavements
downwards = -np.degrees(np.array(hdl64().elevations))


def rings(side):
    """Return angle and distance of each beam that hit the road at least 10 times."""
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
                    title="Each beam draws a ring: theory and your measurement")
axes.set_ylim(0, 45)
places = 1.73 / np.tan(np.radians(np.sort(downwards[downwards > 1])[::-1]))  # near to far
some = [np.abs(places - place).argmin() for place in (5, 10, 20, 40)]
show_table(["a ring at", "the next beam's ring"],
           [(f"{places[i]:.1f} m", f"{places[i + 1] - places[i]:.2f} m farther out") for i in some])

# %% [markdown]
# Near the car, the measured rings are on the curve. Farther out, the rings ahead are nearer than the curve predicts and the rings behind are farther away, because the street climbs. Ahead, the road rises towards the beams, and behind the car it falls away from them.
#
# The curve also explains the white disc around the sensor. The steepest beam points 24.8° down. On a flat road, its ring is at 3.7 m, and the scanner sees no road inside it. At the front and the back, the car itself blocks the steepest beams, so the disc is larger there.
#
# The gaps in the table grow faster than the distance, although the upper beams, which reach far, are closer together than the lower ones. A distant pedestrian therefore gets only a few points.

# %% [markdown]
# **A good place to stop.** You can measure the distance of every point. Save the notebook. The second sitting takes 35 minutes. When you come back, first run all the cells above this one.

# %% [markdown]
# ## Why no loop?
#
# *NumPy does the same work in machine code instead of Python.*
#
# A scanner makes ten turns a second, so a program has only 100 ms for each turn. Here is your function, written with a loop.

# %%
import math


def with_a_loop(cloud):
    """Return the same distances, computed one point at a time."""
    return [math.sqrt(row[0] * row[0] + row[1] * row[1]) for row in cloud]


faster = predict("The loop takes longer than your function. How many times as long, for 100,000 points?")

# %% tags=["folded"]
# @title A stopwatch (you need not read this)
import inspect
from time import process_time


def seconds(function, cloud):
    """Return the processor time of one call in seconds. Short calls are repeated."""
    function = inspect.unwrap(function)  # without any wrappers
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
                   "For each number, Python looks up a function, unpacks the number and makes a "
                   "new object. NumPy does this only once for a whole column.")
else:
    print("horizontal_distance is not written, or has not passed its check, so only the loop is "
          "measured.")
plots.timing({name: (counts, series) for name, series in times.items()}, fit=False,
             title="Time for n points, on logarithmic axes")
for name, series in times.items():
    slope = np.polyfit(np.log(counts[3:]), np.log(series[3:]), 1)[0]
    print(f"{name}: {series[-1] * 1e3:.2f} ms for 100,000 points; grows like n^{slope:.2f} above 3,000")

# %% [markdown]
# On logarithmic axes, $t = k\,n^p$ is a straight line with slope $p$. On the right, both lines have a slope of about 1, so ten times as many points take about ten times as long. Vectorising changes $k$, but not $p$. On the left, your line is flatter, because every NumPy call takes some time, even for a few points.
#
# ## Returns that are not points
#
# *A lost echo can look like an obstacle at the sensor.*
#
# An emergency brake must know how far away the nearest obstacle is. Your function can tell it:

# %%
def nearer_than(limit):
    """Return the rows of the scan with a horizontal distance below `limit` metres."""
    return cloud[horizontal_distance(cloud) < limit]

# %%
too_near = nearer_than(0.5)
print(f"nearest return: {np.min(horizontal_distance(too_near), initial=99):.2f} m")
print("all rows nearer than 0.5 m:")
print(too_near)

# %% [markdown]
# The car would brake as hard as it can, for no reason, because the nearest "obstacle" is exactly at the sensor. Many scanners write a row at (0, 0, 0) when an echo is lost. This scan contains three such rows.
#
# Other scanners write NaN (*not a number*) or an infinite range instead. One NaN turns a whole sum into NaN. It is not equal to anything, not even to itself.

# %%
nan = np.nan
print("nan == nan:", nan == nan, "   nan < 5:", nan < 5, "   nan > 5:", nan > 5)
one_bad = np.array([[4.0, 1.0, -1.5], [nan, nan, nan], [6.0, 2.0, -1.4]])
print("mean of the cloud:", one_bad.mean(axis=0))
print("first attempt, one_bad[one_bad != nan]:", one_bad[one_bad != nan])

# %% [markdown]
# The first attempt keeps every number, even NaN, but loses the rows. `np.isfinite` works better. It tests each number, and gives False for NaN and for plus or minus infinity. With `axis=1`, `all` and `any` combine the numbers of each row. `~` inverts a mask:

# %%
table = np.array([[1.0, 2.0], [np.inf, 3.0], [0.0, 0.0]])
print(np.isfinite(table))
print("whole row finite:  ", np.isfinite(table).all(axis=1))
print("a 0 in the row:    ", (table == 0).any(axis=1))
print("no 0 in the row:   ", ~(table == 0).any(axis=1))

# %% [markdown]
# ## Exercise 2 · `drop_invalid` (points)
#
# Keep the rows that are points. Drop a row if any of its coordinates is NaN or infinite, or if all three are exactly 0. A point exactly to the left of the sensor has x = 0 and is valid. A point whose intensity is NaN is also valid.

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
        All rows except those with a NaN or infinite coordinate and those at exactly
        (0, 0, 0). The order of the rows and the columns stay as they are.
    """
    # 1. Take the three coordinates; the intensity does not matter.
    # 2. Make a mask: are all three finite?
    # 3. Make a second mask: are all three equal to 0?
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
# Build two masks from the columns `cloud[:, :3]`. Each has one entry per row, as for `table` above.
# </details>
# <details><summary>Hint 2</summary>
#
# In a good row, *all* coordinates are finite, so use `all`. In a lost return, *all* coordinates are 0, so use `all` again and invert the mask. With `any`, you would lose the points exactly to the left.
# </details>
# <details><summary>Hint 3</summary>
#
# Write `finite = np.isfinite(...).all(axis=1)` and `zero = (... == 0).all(axis=1)`, with the three coordinates in place of the dots. Then index the cloud with `finite & ~zero`.
# </details>

# %% [markdown]
# **Six rows first.** The first row and the last two are points, and must come back unchanged.

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
# **Look before you check.** We damage the scan as heavy rain would: four thousand echoes are lost, and a thousand rows become NaN. Your function must remove the bar at 0 m and leave all other bars as they are. The small bar at 1 m shows real points on the ego car, which lesson 07 removes. Rows with NaN are not in any bar. Only the number of rows shows that they are gone.

# %%
def profile(scan, clean):
    """Return the number of rows, the number in each metre up to 20 m, and the smallest distance.

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
# | mistake | what you see |
# |---|---|
# | `abs(x) + abs(y)` | diamonds instead of circles |
# | no square root | a limit of "10 m" keeps only points nearer than 3.2 m |
# | `cloud[0]` and `cloud[1]`, rows instead of columns | four numbers instead of one per point |
# | `x == 0` as the test for lost returns | points exactly to the left and right also disappear |
# | `cloud[cloud != nan]` | every number is kept, in one long row |

# %% tags=["folded"]
# @title Draw two of these mistakes (you need not read this)
xs, ys = cloud[:, 0], cloud[:, 1]
wrong = {"abs(x) + abs(y)": np.abs(xs) + np.abs(ys), "no square root": xs * xs + ys * ys}
figure, pair = plt.subplots(2, 1, figsize=(8.5, 9.4), layout="compressed")
for (name, values), axes in zip(wrong.items(), pair):
    plots.kept_and_removed(cloud, values <= 10, limits=((-15, 15), (-11, 11)), axes=axes,
                           title=f"{name}, up to 10")
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, linestyle="--"))
pair[0].plot([10, 0, -10, 0, 10], [0, 10, 0, -10, 0], color="black", linewidth=1)  # the diamond
print(f"points of this scan with x = 0 that are not lost returns: {((xs == 0) & (ys != 0)).sum()}")

# %% [markdown] tags=["questions"]
# (questions)

# %%
from utils import ask_about

ask_about(drop_invalid)

# %% [markdown]
# ## In practice
#
# - A scanner sends ranges and angles, and a driver program turns them into points, as `point_of` does. Some drivers write NaN for a missing return, and others write no row. In a new recording, look for NaN and for (0, 0, 0) before you trust the nearest point.
# - A turn takes 100 ms. At 50 km/h, the car moves 1.4 m in that time, so real systems correct each return for this motion.
#
# Open3D (below) and PCL (`pcl::removeNaNFromPointCloud`) can remove points that are not finite. Rows at (0, 0, 0) are finite, so both libraries keep them.
#
# ```python
# import open3d as o3d
# scan = o3d.io.read_point_cloud("scan.pcd")  # x, y, z; the intensity is not kept
# scan = scan.remove_non_finite_points(remove_nan=True, remove_infinite=True)
# ```
#
# ## Summary
#
# - A range, an azimuth and an elevation give a point. One turn gives a scan, which is a list of points.
# - Working with columns and masks is far faster than a loop.
# - The distance that matters for driving is horizontal: sqrt(x² + y²).
# - Rows at (0, 0, 0) and rows with NaN are not points. Remove them first.
#
# **Sources.** How a LiDAR works: [Behroozpour et al. 2017](https://doi.org/10.1109/MCOM.2017.1700030). The sensor and its place on the car: KITTI, [Geiger et al. 2013](https://www.cvlibs.net/publications/Geiger2013IJRR.pdf). Arrays instead of loops: [Harris et al. 2020](https://doi.org/10.1038/s41586-020-2649-2).
#
# **Next:** 02 · RANSAC: a line through the crowd

# %% [markdown]
# ## If you want more
#
# 1. (20 minutes) Write `azimuth(cloud)` with `np.arctan2`, in degrees. Draw the scan as the scanner saw it, with azimuth to the left and elevation upwards, coloured by your distance. The upper picture at the top of this lesson was made this way.
# 2. (15 minutes) A pedestrian is 0.5 m wide and 1.7 m tall. The 64-beam scanner has steps of 0.18°, and its upper beams are a third of a degree apart. Beyond what distance does the pedestrian get fewer than 10 returns? Compare your result with `truth["box_returns"]`.
#    <details><summary>An answer</summary>At a distance d, the steps are 0.00314 d apart and the beams 0.00582 d. The pedestrian therefore gets 0.5 / (0.00314 d) × 1.7 / (0.00582 d) returns, or about 46,500 / d². Beyond 68 m, this is fewer than 10. In the scan, some pedestrians much nearer also get fewer, because other objects are in front of them.</details>

# %% [markdown] tags=["footer"]
# (footer)
