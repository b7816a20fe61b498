"""Time exact clustering and box detection on full scans, in the lessons and in other libraries.

All implementations run in turn on the same cloud, and ratios compare times of the same round. The
clouds are `cloud.txt`, a random street, and the files in the folder REAL_CLOUDS. The latter are
KITTI frames, which are not part of the project. The lessons and dbscan also run on two worst cases
for a grid of cells. `implementations.py` explains how to install the other libraries; a missing one
is skipped with a message. ROUNDS and PATIENCE (seconds for a slow implementation) limit the time.

The script prints a table in Markdown. It writes `.bench/measured.json` (under "clustering") and
`.bench/clustering.png`.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tests.benchmarks.implementations import CLUSTERING, DETECTORS, RADIUS, all_pairs
from tests.benchmarks.racing import (
    FOLDER,
    PATIENCE,
    ROUNDS,
    Result,
    exponent,
    race,
    same_partition,
    save_results,
)
from utils import load_cloud, scenes

OURS = "ours, full speed"
# Implementations that run on the worst cases for a grid.
GRIDS = {name: CLUSTERING[name] for name in ("ours, Numba", OURS, "ours, taught", "dbscan (PyPI)")}
# The palette of Okabe and Ito (2008), which colour-blind readers can distinguish.
COLOURS = ["#0072B2", "#56B4E9", "#009E73", "#D55E00", "#E69F00", "#CC79A7", "#000000", "#999999"]
SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)


def scans() -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and points of every cloud; a random street's name contains its seed."""
    yield "cloud.txt", load_cloud("cloud.txt")[:, :3]
    seed = int(os.environ.get("SEED", np.random.SeedSequence().entropy % 10**6))
    yield f"random street {seed}", scenes.city_block(seed=seed, frames=1)[0].cloud[:, :3]
    folder = os.environ.get("REAL_CLOUDS")
    for path in sorted(Path(folder).rglob("*")) if folder else ():
        if path.suffix in (".bin", ".pcd") and path.stat().st_size > 1_000_000:
            yield f"{path.parent.name}/{path.name}", load_cloud(path)[:, :3]


def worst_cases() -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the name, points and right labels of clouds on which a grid of cells helps least."""
    rng = np.random.default_rng(3)
    inner, outer = (v / np.linalg.norm(v, axis=1)[:, None] for v in rng.normal(size=(2, 30_000, 3)))
    nested = np.vstack([0.05 * inner, (0.05 + RADIUS + 1e-4) * outer])
    yield (
        "30 000 points in a ball inside a shell of 30 000 points",
        nested,
        np.arange(60_000) // 30_000,
    )
    edge = 1e7 ** (1 / 3) * RADIUS / 3**0.5  # such that there is one point per ten cells
    sparse = rng.uniform(0, edge, (1_000_000, 3))
    yield "a million points, one for every ten cells", sparse, all_pairs(sparse)()


def row(name: str, result: Result, ours: Result, right: str) -> list[str]:
    """Return the cells of one table row."""
    middle, low, high = result.times_as_long_as(ours)
    spread = np.nanpercentile(result.seconds, (25, 75)) * 1000
    return [
        name,
        f"{1000 * result.least:,.1f}",
        f"{1000 * result.median:,.1f}",
        f"{spread[0]:,.1f} to {spread[1]:,.1f}",
        f"{middle:.2f} ({low:.2f} to {high:.2f})",
        f"{result.memory / 1e6:,.0f}",
        right,
    ]


def print_table(title: str, rows: list[list[str]], last: str) -> None:
    """Print a table in Markdown."""
    head = ["", "shortest ms", "median ms", "quartiles", "times as long", "memory MB", last]
    print(f"\n{title}\n\n| {' | '.join(head)} |\n|---|---:|---:|---:|---:|---:|---|")
    for cells in rows:
        print(f"| {' | '.join(cells)} |")


def compare(
    implementations: dict, name: str, cloud: np.ndarray, ours: str, truth: np.ndarray | None
) -> dict:
    """Time all implementations on a cloud, print a table and return a record for the JSON file."""
    results = race(implementations, cloud)
    rows, record = [], {}
    for implementation, result in results.items():
        if truth is None:
            right = str(len(result.answer))
        else:
            right = "right" if same_partition(result.answer, truth) else "WRONG"
        rows.append(row(implementation, result, results[ours], right))
        record[implementation] = {
            "seconds": result.seconds[~np.isnan(result.seconds)].tolist(),
            "bytes": result.memory,
            "answer": right,
            "times as long": result.times_as_long_as(results[ours]),
        }
    last = "boxes" if truth is None else "partition"
    print_table(f"**{name}**, {len(cloud):,} points, {ROUNDS} rounds", rows, last)
    return {"points": len(cloud), "implementations": record}


def turns_side_by_side(scan: np.ndarray, count: int) -> np.ndarray:
    """Return `count` points: copies of a scan, 300 m apart, the last one incomplete."""
    turns = [scan + [0, 300.0 * number, 0] for number in range(-(-count // len(scan)))]
    few = np.random.default_rng(0).permutation(turns.pop())[: count - len(scan) * len(turns)]
    return np.ascontiguousarray(np.vstack([*turns, few]))


def scale(scan: np.ndarray) -> dict[str, dict]:
    """Time each implementation on growing clouds until it is too slow; print and return times."""
    found: dict[str, dict] = {}
    implementations = dict(CLUSTERING)
    for size in SIZES:
        results = race(implementations, turns_side_by_side(scan, size), memory=False)
        for name, result in results.items():
            series = found.setdefault(name, {"points": [], "seconds": []})
            series["points"].append(size)
            series["seconds"].append(result.least)
        implementations = {
            name: implementation
            for name, implementation in implementations.items()
            if name in results and 4 * results[name].median < PATIENCE
        }
    print("\n**Growing clouds**: whole turns side by side, times in seconds, fitted exponent\n")
    for name, series in found.items():
        series["exponent"] = exponent(series["points"], series["seconds"])
        times = ", ".join(f"{seconds:.3f}" for seconds in series["seconds"])
        print(f"- {name}: {times}; n to the power of {series['exponent']:.2f}")
    return found


def draw_bars(name: str, measured: dict, scale: str, axes) -> None:
    """Draw the shortest time of each implementation on one cloud as bars."""
    least = {
        implementation: 1000 * min(found["seconds"])
        for implementation, found in measured["implementations"].items()
    }
    ordered = sorted(least, key=least.get, reverse=True)
    colours = [
        "#0072B2" if implementation.startswith("ours") else "#BBBBBB" for implementation in ordered
    ]
    drawn = axes.barh(ordered, [least[implementation] for implementation in ordered], color=colours)
    axes.bar_label(
        drawn, [f"{least[implementation]:,.0f} ms" for implementation in ordered], padding=3
    )
    axes.set(xscale=scale, xlabel="ms", title=name)
    axes.margins(x=0.2)
    axes.spines[["top", "right"]].set_visible(False)


def draw(record: dict, path: Path) -> None:
    """Save a figure of the results on the first cloud and of the times on growing clouds."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplot_mosaic(
        [["clusters", "growth"], ["boxes", "growth"]],
        figsize=(11, 5.5),
        height_ratios=(8, 3),
        layout="constrained",
    )
    name, first = next(iter(record["clustering"].items()))
    draw_bars(f"Clusters of {first['points']:,} points ({name})", first, "log", axes["clusters"])
    draw_bars("From that scan to boxes", record["detector"][name], "linear", axes["boxes"])
    for number, (implementation, series) in enumerate(record["scaling"].items()):
        label = f"{implementation}: n^{series['exponent']:.2f}"
        style = {"marker": "os^vD<>P"[number % 8], "color": COLOURS[number % 8]}
        axes["growth"].loglog(series["points"], series["seconds"], label=label, **style)
    axes["growth"].set(xlabel="points", ylabel="s", title="Turns of the scanner, side by side")
    axes["growth"].legend(fontsize="small", frameon=False, loc="upper left", ncols=2)
    axes["growth"].margins(y=0.25)
    figure.savefig(path, dpi=90, metadata={"Software": None})


def main() -> None:
    """Measure, print the tables and write the files."""
    about = {"python": sys.version.split()[0], "machine": platform.machine(), "rounds": ROUNDS}
    record = about | {"radius": RADIUS, "clustering": {}, "worst": {}, "detector": {}}
    clouds = {name: np.ascontiguousarray(cloud, dtype=float) for name, cloud in scans()}
    for name, cloud in clouds.items():
        record["clustering"][name] = compare(CLUSTERING, name, cloud, OURS, all_pairs(cloud)())
    for name, cloud, truth in worst_cases():
        record["worst"][name] = compare(GRIDS, name, cloud, OURS, truth)
    print("\n## From the raw scan to boxes")
    for name, cloud in clouds.items():
        record["detector"][name] = compare(DETECTORS, name, cloud, "ours", None)
    record["scaling"] = scale(clouds["cloud.txt"])
    path = save_results("clustering", record)
    draw(record, FOLDER / "clustering.png")
    print(f"\nWritten: {path} and {FOLDER / 'clustering.png'}")


if __name__ == "__main__":
    main()
