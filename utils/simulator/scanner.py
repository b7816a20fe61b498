"""Ray-casting LiDAR: the measurements of a rotating laser scanner with their ground truth.

Each pulse is one ray. It measures the distance to the first surface on its path, with Gaussian
noise along the ray, unless the echo is lost. The world does not move during a scan.

Coordinates: a `utils.simulator.world.World` is in the frame of the vehicle (x forward, y left,
z up, the origin on the road beneath the sensor). A `Scan` has the *sensor* at its origin.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from utils.simulator.pose import Pose
from utils.simulator.sensor import Sensor, ray_directions
from utils.simulator.shapes import Solid
from utils.simulator.world import World

CLASSES: tuple[str, ...] = (
    "invalid",
    "ground",
    "car",
    "truck",
    "pedestrian",
    "cyclist",
    "pole",
    "wall",
    "foliage",
    "ego",
)
"""Names of the classes; the index of a name is its code in `Scan.classes`."""


@dataclass(frozen=True, eq=False)
class Scan:
    """One turn of the sensor; row i of every array belongs to the same return.

    Parameters
    ----------
    cloud : ndarray, shape (n, 4)
        x, y, z in metres with the sensor at the origin, and the intensity from 0 to 1.
    classes : ndarray of uint8, shape (n,)
        Index into `CLASSES`.
    objects : ndarray of int32, shape (n,)
        Identity of the obstacle; 0 for ground, ego and invalid returns.
    beams : ndarray of uint16, shape (n,)
        Index into the sensor's elevations.
    times : ndarray, shape (n,)
        Seconds since the scan began.
    """

    cloud: np.ndarray
    classes: np.ndarray
    objects: np.ndarray
    beams: np.ndarray
    times: np.ndarray


def scan(world: World, sensor: Sensor, seed: int | Sequence[int]) -> Scan:
    """Scan a world once.

    Parameters
    ----------
    world : World
        In the frame of the vehicle that carries the sensor.
    sensor : Sensor
    seed : int or sequence of int
        The same seed gives the same scan.

    Returns
    -------
    Scan
        Returns ordered by beam, then by azimuth, anticlockwise from straight ahead. Coordinates
        are rounded to the micrometre and intensities to the hundredth. Processors that differ in
        the last bit of a sine therefore give the same result.
    """
    rays = ray_directions(sensor)
    rng = np.random.default_rng(seed)
    # Random numbers are drawn for every ray, so that hits do not change the numbers of other rays.
    shape = rays.shape[1:]
    noise, flicker = rng.standard_normal(shape), rng.standard_normal(shape)
    luck, penetration = rng.random(shape), rng.standard_exponential(shape)

    sources = list(_sources(world, sensor))
    hits, distance, cosine = _nearest_hits(world, sensor, rays, sources, penetration)
    found = np.isfinite(distance)
    distance[~found] = 1.0  # an arbitrary finite number
    materials = [solid.material for _, _, solid in sources] + [world.ground.material]
    reflectivity = np.array([material.reflectivity for material in materials])[hits]
    loss = np.array([material.loss for material in materials])[hits]

    measured = distance + sensor.range_noise * noise
    kept = found & (luck >= _loss_probability(sensor, loss, reflectivity * cosine, distance))
    kept &= (measured >= sensor.minimum_range) & (measured <= sensor.maximum_range)
    # The rays with the smallest random numbers are reported at the origin.
    invalid = _smallest_mask(luck, sensor.invalid_returns)
    kept |= invalid
    brightness = reflectivity * (0.5 + 0.5 * cosine) * (1 + 0.15 * flicker)

    cloud = np.empty((np.count_nonzero(kept), 4))
    cloud[:, :3] = np.round((rays[:, kept] * measured[kept]).T, 6) + 0.0  # turns -0.0 into 0.0
    cloud[:, 3] = np.round(np.clip(brightness[kept], 0.0, 1.0), 2)
    codes = [CLASSES.index(kind) for kind, _, _ in sources] + [CLASSES.index("ground")]
    identities = [identity for _, identity, _ in sources] + [0]
    classes = np.array(codes, dtype=np.uint8)[hits[kept]]
    objects = np.array(identities, dtype=np.int32)[hits[kept]]
    blank = invalid[kept]
    cloud[blank], classes[blank], objects[blank] = 0.0, CLASSES.index("invalid"), 0
    beams, firings = np.nonzero(kept)
    times = firings / (sensor.firings * sensor.rotation_rate)
    return Scan(cloud, classes, objects, beams.astype(np.uint16), times)


def _loss_probability(
    sensor: Sensor, loss: np.ndarray, brightness: np.ndarray, distance: np.ndarray
) -> np.ndarray:
    """Return the loss probability of each echo, from dropout, material and weak signal."""
    kept = (1 - sensor.dropout) * (1 - loss)
    if sensor.weakest_signal:
        signal = brightness * (100.0 / distance) ** 2
        kept *= 1 - np.exp(-signal / sensor.weakest_signal)
    return 1 - kept


def _smallest_mask(values: np.ndarray, count: int) -> np.ndarray:
    """Return a mask of the `count` smallest values, but never of all values."""
    count = min(count, values.size - 1)
    chosen = np.zeros(values.size, dtype=bool)
    chosen[np.argpartition(values, count, axis=None)[:count]] = True
    return chosen.reshape(values.shape)


def _sources(world: World, sensor: Sensor) -> Iterator[tuple[str, int, Solid]]:
    """Yield the class, ID and solid of every object except the ground, in sensor coordinates.

    Obstacles beyond the maximum range, with a margin for noise, are omitted.
    """
    x, y, z = sensor.origin
    to_sensor = Pose(-x, -y, -z)
    too_far = sensor.maximum_range + 20 * sensor.range_noise
    for part in world.ego:
        yield "ego", 0, part.moved(to_sensor)
    for obstacle in world.obstacles:
        base = to_sensor.then(world.base(obstacle))
        if math.hypot(base.x, base.y) - math.hypot(*obstacle.size) > too_far:
            continue
        for part in obstacle.solids:
            yield obstacle.kind, obstacle.identity, part.moved(base)


def _nearest_hits(
    world: World,
    sensor: Sensor,
    rays: np.ndarray,
    sources: list[tuple[str, int, Solid]],
    penetration: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return, for every ray, the index of the first solid (-1: ground), distance and cosine."""
    distance, cosine = world.ground.crossings(rays, sensor.origin)
    hits = np.full(distance.shape, -1, dtype=np.int32)
    for index, (_, _, solid) in enumerate(sources):
        for block in _blocks(solid, sensor):
            enter, leave, facing = solid.crossings(rays[(slice(None), *block)])
            # A solid that contains the sensor is invisible from inside.
            met = (enter > 0) & (enter <= leave)
            if solid.material.depth:
                enter = enter + solid.material.depth * penetration[block]
                met &= enter < leave
            met &= enter < distance[block]
            np.copyto(distance[block], enter, where=met)
            np.copyto(cosine[block], facing, where=met)
            np.copyto(hits[block], index, where=met)
    return hits, distance, cosine


def _blocks(solid: Solid, sensor: Sensor) -> Iterator[tuple[slice, slice]]:
    """Yield at most two blocks (beams, firings) of rays that may hit a solid."""
    lowest, highest = solid.elevations()
    # The tolerance accounts for rounding of the angles.
    beams = [
        beam
        for beam, elevation in enumerate(sensor.elevations)
        if lowest - 1e-9 <= elevation <= highest + 1e-9
    ]
    if not beams:
        return
    rows = slice(beams[0], beams[-1] + 1)
    step = 2 * math.pi / sensor.firings
    first, last = solid.azimuths()
    start, stop = math.ceil(first / step - 1e-6), math.floor(last / step + 1e-6) + 1
    if stop - start >= sensor.firings:
        yield rows, slice(0, sensor.firings)
        return
    start, stop = start % sensor.firings, start % sensor.firings + stop - start
    if start < min(stop, sensor.firings):
        yield rows, slice(start, min(stop, sensor.firings))
    if stop > sensor.firings:
        yield rows, slice(0, stop - sensor.firings)
