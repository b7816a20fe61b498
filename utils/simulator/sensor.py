"""Rotating multi-beam LiDARs: directions of their rays, their ranges, and three presets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np


@dataclass(frozen=True)
class Sensor:
    """A rotating multi-beam LiDAR.

    Parameters
    ----------
    elevations : tuple of float
        Angle of every beam above the horizon, in radians, in any order; see `layers`.
    azimuth_step : float
        Angle between two firings of a beam, in radians. A turn has round(2 pi / step) firings.
    origin : tuple of float
        Position of the sensor in the vehicle frame, in metres; origin[2] is its height.
    minimum_range, maximum_range : float
        Limits in metres; nearer and farther echoes are not reported.
    range_noise : float
        Standard deviation of the range, in metres.
    dropout : float
        Share of echoes that are lost at random.
    weakest_signal : float
        Signal at which an echo is lost with probability 1/e. The signal is
        reflectivity * cos(incidence) * (100 m / range)**2. With 0 no echo is too weak.
    rotation_rate : float
        Turns per second.
    invalid_returns : int
        Number of lost rays per turn that are reported at exactly (0, 0, 0), as in real recordings.

    Raises
    ------
    ValueError
        There is no beam, or the azimuth step or the range is impossible.
    """

    elevations: tuple[float, ...]
    azimuth_step: float
    origin: tuple[float, float, float] = (0.0, 0.0, 1.73)
    minimum_range: float = 1.0
    maximum_range: float = 80.0
    range_noise: float = 0.02
    dropout: float = 0.0
    weakest_signal: float = 0.0
    rotation_rate: float = 10.0
    invalid_returns: int = 0

    def __post_init__(self) -> None:
        if not len(self.elevations):
            raise ValueError("A sensor needs at least one beam: `elevations` is empty.")
        if not 0 < self.azimuth_step <= 2 * math.pi:
            raise ValueError(
                f"The azimuth step must be an angle in radians, above 0 and up to a full circle, "
                f"not {self.azimuth_step}."
            )
        if not 0 <= self.minimum_range < self.maximum_range:
            raise ValueError(
                f"The minimum range must be at least 0 and smaller than the maximum range, "
                f"but they are {self.minimum_range} and {self.maximum_range}."
            )

    @property
    def firings(self) -> int:
        """Number of azimuths in one turn."""
        return max(1, round(2 * math.pi / self.azimuth_step))


def layers(count: int, lowest: float, highest: float) -> tuple[float, ...]:
    """Return elevations in radians of `count` evenly spaced beams between angles in degrees."""
    return tuple(np.radians(np.linspace(lowest, highest, count)).tolist())


def highway_sensor() -> Sensor:
    """Return the 8-layer sensor of the simple highway: 8 x 128 rays, 5 to 50 m, 2.6 m high.

    The lowest layer points 30 degrees downwards, and the layers are an eighth of 26 degrees apart.
    """
    return Sensor(
        elevations=layers(8, -30.0, -30.0 + 26.0 * 7 / 8),
        azimuth_step=math.pi / 64,
        origin=(0.0, 0.0, 2.6),
        minimum_range=5.0,
        maximum_range=50.0,
        range_noise=0.05,
    )


def hdl64() -> Sensor:
    """Return a 64-beam, 10 Hz sensor 1.73 m above the road: 128 000 rays, about 120 000 returns.

    It has two blocks of 32 beams from +2 to -24.8 degrees. The upper beams are a third of a degree
    apart, the lower ones about half a degree. The model is the Velodyne HDL-64E on KITTI's car
    (A. Geiger et al., "Vision meets robotics: the KITTI dataset", IJRR 2013).
    """
    return Sensor(
        elevations=layers(32, 2.0, -8.33) + layers(32, -8.83, -24.8),
        azimuth_step=math.radians(0.18),
        dropout=0.01,
        weakest_signal=0.05,
        invalid_returns=3,
    )


def vlp16() -> Sensor:
    """Return a 16-beam, 10 Hz sensor 1.73 m above the road: 28,800 rays.

    The beams are 2 degrees apart, from -15 to +15 degrees, so a level road nearer than 6.5 m has no
    returns. The model is the Velodyne VLP-16, which many small robots carry (VLP-16 User Manual,
    63-9243).
    """
    return Sensor(
        elevations=layers(16, -15.0, 15.0),
        azimuth_step=math.radians(0.2),
        maximum_range=100.0,
        range_noise=0.03,
        dropout=0.01,
        weakest_signal=0.05,
        invalid_returns=3,
    )


@lru_cache(maxsize=8)
def ray_directions(sensor: Sensor) -> np.ndarray:
    """Return unit directions of all rays of a turn, shape (3, beams, firings), read-only."""
    elevations = np.array(sensor.elevations)[:, np.newaxis]
    azimuths = np.arange(sensor.firings) * (2 * math.pi / sensor.firings)
    flat = np.cos(elevations)
    upward = np.broadcast_to(np.sin(elevations), (len(elevations), len(azimuths)))
    rays = np.stack([flat * np.cos(azimuths), flat * np.sin(azimuths), upward])
    rays.setflags(write=False)
    return rays
