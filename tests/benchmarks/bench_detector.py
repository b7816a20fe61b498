"""Time lesson 12's detector step by step, and measure its quality.

The detector runs on `cloud.txt`, ROUNDS times; `bench_clustering.py` compares it with PCL. Quality
is the F1 score over one frame of each of the eight streets of lesson 12, and of eight other
streets. The standard errors come from a jackknife over streets. Recall is measured on the labelled
frames in REAL_CLOUDS, with Wilson's 95 % interval, which is wide because there are only a few cars.

Rows of the table are not directly comparable; a note below the table says why.
`search_detector.py` searches for better parameters.

The script adds its results to `.bench/measured.json`, under "detector by steps" and "quality".
"""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType

import numpy as np

from grader.course.lessons import load_reference
from tests.benchmarks.racing import ROUNDS, save_results
from utils import load_cloud, scenes
from utils.boxes import Box, plane_iou
from utils.scoring.card import OVERLAPS, score_card, within
from utils.scoring.counting import match

STEPS = (
    "drop_invalid",
    "crop_region",
    "remove_ego_returns",
    "ransac_plane",
    "fit_plane",
    "point_plane_distance",
    "voxel_grid",
    "euclidean_clustering_accelerated",
    "filter_clusters",
    "get_oriented_boxes",
)
CARRIAGEWAY = ((-15, 35), (-4, 6.4))
DETECTION_REGION = ((-15, 35), (-7, 9))
CAUTION = """
Real frames have labels only in the view of a camera, so false boxes cannot be counted there, and
only cars count. Simulated frames make a detector look better: their labels are exact, nothing in
them reflects or is wet, and the same author drew the streets and used them to choose the
parameters. In simulated frames, people also count."""
STREETS = {"lesson 12's streets": range(8), "eight others": range(100, 108)}


def detector_with(change: Callable[[dict], dict]) -> Callable[[np.ndarray], np.ndarray]:
    """Return lesson 12's detector with some of its steps replaced by `change(steps)`."""
    detect = load_reference("12_streaming_obstacles").detect_obstacles
    steps = detect.__globals__
    return FunctionType(detect.__code__, steps | change(steps), argdefs=detect.__defaults__)


class TimedDetector:
    """The detector with a timer around each of its steps."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = {}
        self._detect = detector_with(
            lambda steps: {name: self._timed(name, steps[name]) for name in STEPS}
        )

    def _timed(self, step: str, function: Callable) -> Callable:
        def timed(*arguments):
            start = time.perf_counter()
            answer = function(*arguments)
            self._seconds[step] = time.perf_counter() - start
            return answer

        return timed

    def __call__(self, cloud: np.ndarray) -> dict[str, float]:
        """Run the detector; return the seconds for each step, for the rest, and in total."""
        self._seconds.clear()
        start = time.perf_counter()
        self._detect(cloud)
        whole = time.perf_counter() - start
        rest = whole - sum(self._seconds.values())
        return self._seconds | {"the rest": rest, "whole": whole}


def step_times(cloud: np.ndarray) -> dict[str, list[float]]:
    """Return the seconds of each step in each round."""
    detector = TimedDetector()
    detector(cloud)
    rounds = [detector(cloud) for _ in range(ROUNDS)]
    return {name: [seconds[name] for seconds in rounds] for name in rounds[0]}


def f1_of_streets(seeds: range) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return F1 at each of `OVERLAPS`, and the standard errors."""
    detect = load_reference("12_streaming_obstacles").detect_obstacles
    frames = [scenes.city_block(seed, frames=1)[0] for seed in seeds]
    card = score_card([detect(frame.cloud) for frame in frames], frames, CARRIAGEWAY)
    return card["F1"].values, card["F1"].errors


def labelled_recordings(folder: Path) -> Iterator[tuple[Path, np.ndarray]]:
    """Yield each labelled recording, and the corners of its boxes in the region, (N, 8, 3).

    Boxes with fewer than 30 returns are omitted.
    """
    for table in sorted(folder.rglob("*_boxes.csv")):
        with table.open() as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
        boxes = [
            Box(
                (row["cx"], row["cy"], row["cz"]),
                (row["l"], row["w"], row["h"]),
                row["yaw"],
                "car",
                0,
            ).corners
            for row in rows
            if row["npts"] >= 30
        ]
        corners = np.array(boxes).reshape(-1, 8, 3)
        recording = table.with_name(table.name.replace("_boxes.csv", ".bin"))
        yield recording, corners[within(corners, DETECTION_REGION)]


def wilson(hits: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """Return Wilson's interval for a proportion (1927), which is also valid at 0 and 1."""
    share, spread = hits / count, z**2 / count
    middle = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * np.sqrt(share * (1 - share) / count + spread / (4 * count))
    return float(middle - half), float(middle + half)


def recall_on_real(folder: Path) -> dict[str, tuple[int, int]]:
    """Return the number of hits and of labelled cars at each of `OVERLAPS`."""
    detect = load_reference("12_streaming_obstacles").detect_obstacles
    hits, count = dict.fromkeys(OVERLAPS, 0), 0
    for path, truth in labelled_recordings(folder):
        overlaps = plane_iou(detect(load_cloud(path)), truth)
        count += len(truth)
        for least in OVERLAPS:
            hits[least] += int(np.count_nonzero(match(overlaps, least) >= 0))
    return {str(least): (number, count) for least, number in hits.items()}


def main() -> None:
    """Measure, print the tables and record the results."""
    seconds = step_times(load_cloud("cloud.txt"))
    print(f"\n**The detector on cloud.txt**, {ROUNDS} rounds\n")
    print("| | shortest ms | median ms | quartiles |\n|---|---:|---:|---:|")
    for name, values in seconds.items():
        least, low, middle, high = 1000 * np.percentile(values, (0, 25, 50, 75))
        print(f"| {name} | {least:.1f} | {middle:.1f} | {low:.1f} to {high:.1f} |")
    quality: dict[str, object] = {}
    print(f"\n| F1 at an IoU of | {' | '.join(map(str, OVERLAPS))} |\n|---|---:|---:|---:|")
    for name, seeds in STREETS.items():
        values, errors = quality[name] = f1_of_streets(seeds)
        texts = (f"{value:.2f} ± {error:.2f}" for value, error in zip(values, errors, strict=True))
        print(f"| {name} | {' | '.join(texts)} |")
    folder = os.environ.get("REAL_CLOUDS")
    found = recall_on_real(Path(folder)) if folder else {}
    if any(count for _, count in found.values()):
        quality["recall on real frames"] = found
        texts = [
            f"{hits} of {count} ({wilson(hits, count)[0]:.2f} to {wilson(hits, count)[1]:.2f})"
            for hits, count in found.values()
        ]
        print(f"| recall, real cars with 30 returns | {' | '.join(texts)} |")
    print(CAUTION)
    save_results("detector by steps", seconds)
    save_results("quality", quality)


if __name__ == "__main__":
    main()
