"""A ray-casting LiDAR: what a rotating laser scanner would have measured, with the truth beside it.

Each beam is one ray. It returns the distance to the first surface it meets, with Gaussian noise
along the ray, unless the echo is lost. The world stands still during a sweep.

Coordinates: a `utils.simulator.world.World` lies in the frame of the vehicle (x forward, y left,
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
    """One sweep of the sensor; row i of every array belongs to the same return.

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
        Seconds since the sweep began.
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
        Beam by beam, each in the order of its azimuth, anticlockwise from straight ahead.
        Coordinates are rounded to the micrometre and intensities to the hundredth, so that
        processors which differ in the last bit of a sine agree on the result.
    """
    rays = ray_directions(sensor)
    rng = np.random.default_rng(seed)
    # Drawn for every ray, hit or not: what a ray meets does not change the luck of the others.
    shape = rays.shape[1:]
    noise, flicker = rng.standard_normal(shape), rng.standard_normal(shape)
    luck, penetration = rng.random(shape), rng.standard_exponential(shape)

    sources = list(_sources(world, sensor))
    hits, distance, cosine = _nearest(world, sensor, rays, sources, penetration)
    found = np.isfinite(distance)
    distance[~found] = 1.0  # any number that can be computed with
    materials = [solid.material for _, _, solid in sources] + [world.ground.material]
    reflectivity = np.array([material.reflectivity for material in materials])[hits]
    loss = np.array([material.loss for material in materials])[hits]

    measured = distance + sensor.range_noise * noise
    kept = found & (luck >= _risk(sensor, loss, reflectivity * cosine, distance))
    kept &= (measured >= sensor.minimum_range) & (measured <= sensor.maximum_range)
    # The unluckiest rays of all are the ones reported at the origin.
    invalid = _smallest(luck, sensor.invalid_returns)
    kept |= invalid
    brightness = reflectivity * (0.5 + 0.5 * cosine) * (1 + 0.15 * flicker)

    cloud = np.empty((np.count_nonzero(kept), 4))
    cloud[:, :3] = np.round((rays[:, kept] * measured[kept]).T, 6) + 0.0  # no -0.0
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


def _risk(
    sensor: Sensor, loss: np.ndarray, brightness: np.ndarray, distance: np.ndarray
) -> np.ndarray:
    """Probability that each echo is lost: by chance, by its material, or for its weakness."""
    kept = (1 - sensor.dropout) * (1 - loss)
    if sensor.weakest_signal:
        signal = brightness * (100.0 / distance) ** 2
        kept *= 1 - np.exp(-signal / sensor.weakest_signal)
    return 1 - kept


def _smallest(values: np.ndarray, count: int) -> np.ndarray:
    """A mask of the `count` smallest values, but never of all."""
    count = min(count, values.size - 1)
    chosen = np.zeros(values.size, dtype=bool)
    chosen[np.argpartition(values, count, axis=None)[:count]] = True
    return chosen.reshape(values.shape)


def _sources(world: World, sensor: Sensor) -> Iterator[tuple[str, int, Solid]]:
    """Class, identity and solid, in sensor coordinates, of all there is to hit but ground.

    Less what is farther away than an echo is reported from, however lucky its noise.
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


def _nearest(
    world: World,
    sensor: Sensor,
    rays: np.ndarray,
    sources: list[tuple[str, int, Solid]],
    penetration: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For every ray the index of what it hits first (-1: the ground), distance and cosine."""
    distance, cosine = world.ground.crossings(rays, sensor.origin)
    hits = np.full(distance.shape, -1, dtype=np.int32)
    for index, (_, _, solid) in enumerate(sources):
        for block in _blocks(solid, sensor):
            enter, leave, facing = solid.crossings(rays[(slice(None), *block)])
            # A solid that contains the sensor is not seen from inside.
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
    """The blocks (beams, firings) of rays that can possibly meet a solid: at most two."""
    lowest, highest = solid.elevations()
    # A hair more than needed, for the rounding of the angles.
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
