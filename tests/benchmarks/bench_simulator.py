"""Time the simulated scanner: `python -m tests.benchmarks.bench_simulator`.

Times are medians over several runs on one core. The project's target is a 64-beam frame of a
street with 60 obstacles in less than 0.5 s.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from statistics import median

import numpy as np

from utils.scenes import Frame, city_block, lesson_street, random_street, simple_highway
from utils.scoring import plane_iou
from utils.simulator import scanner

TARGET = 0.5


def seconds(call: Callable[[], object], runs: int = 7) -> float:
    """Return the median time of a call in seconds, after one call to warm up."""
    call()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return median(times)


def street_of(obstacles: int) -> Callable[[], Frame]:
    """Return a function that creates the easiest random street with this many obstacles or more."""
    for percent in range(101):
        difficulty = percent / 100
        if len(random_street(0, difficulty).boxes) >= obstacles:
            return partial(random_street, 0, difficulty)
    raise RuntimeError(f"No street shows {obstacles} obstacles.")


def without_culling(call: Callable[[], Frame]) -> float:
    """Return the seconds for one frame if the scanner tests every ray against every solid."""
    blocks = scanner._blocks
    scanner._blocks = lambda solid, sensor: [(slice(None), slice(None))]
    try:
        return seconds(call, runs=1)
    finally:
        scanner._blocks = blocks


def main() -> None:
    frames: dict[str, Callable[[], Frame]] = {
        "simple highway": simple_highway,
        "lesson street": lesson_street,
        "city block": lambda: city_block()[10],
        "60 obstacles": street_of(60),
        "crowded street": lambda: random_street(0, 1.0),
    }
    for name, make in frames.items():
        frame = make()
        print(
            f"{name:15} {len(frame.cloud):7} returns {len(frame.boxes):4} obstacles seen "
            f"{1000 * seconds(make):7.1f} ms"
        )

    street = frames["60 obstacles"]
    quick = seconds(street)
    print(f"\n64-beam street of 60 obstacles: {TARGET / quick:.1f} times faster than the target")
    print(f"culling saves a factor of {without_culling(street) / quick:.1f}")

    boxes = np.array([box.corners for box in street().boxes])
    print(
        f"overlaps between {len(boxes)} boxes: "
        f"{1000 * seconds(lambda: plane_iou(boxes, boxes)):.1f} ms"
    )
    fresh = [sys.executable, "-c", "import utils.simulator"]
    bare = [sys.executable, "-c", "import numpy"]
    extra = seconds(lambda: subprocess.run(fresh, check=True)) - seconds(
        lambda: subprocess.run(bare, check=True)
    )
    print(f"importing utils.simulator: {1000 * extra:.0f} ms beyond numpy")


if __name__ == "__main__":
    main()
