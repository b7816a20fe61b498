"""Time exact clustering and box detection on full scans, in the lessons and in other libraries.

All implementations run in turn on the same cloud, and ratios compare times of the same round. Each
turn is a call with cold caches and another one right after it. The race is repeated while one busy
process per processor is running. The clouds are `cloud.txt`, a random street, and the files in the
folder REAL_CLOUDS, which are not part of the project. The lessons and dbscan also run on two worst
cases for a grid of cells. `implementations.py` explains how to install the other libraries; a
missing one is skipped with a message. ROUNDS and PATIENCE (seconds for a slow implementation) limit
the time. SEED draws the orders and the street.

The script prints tables in Markdown. It writes `.bench/measured.json` (under "clustering") and
`.bench/clustering.png`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from grader.classroom.executors import processor_count
from tests.benchmarks.implementations import CLUSTERING, DETECTORS, RADIUS, all_pairs
from tests.benchmarks.load import busy
from tests.benchmarks.racing import (
    FOLDER,
    PATIENCE,
    ROUNDS,
    SEED,
    exponent,
    machine,
    race,
    same_partition,
    save_results,
    started,
)
from utils import load_cloud, scenes

OURS, COMPILED = "ours, full speed", "ours, Numba"
THREADS = "ours, Numba on all processors"
# Implementations that run on the worst cases for a grid.
GRIDS = {
    name: CLUSTERING[name] for name in (THREADS, COMPILED, OURS, "ours, taught", "dbscan (PyPI)")
}
# The palette of Okabe and Ito (2008), which colour-blind readers can distinguish.
COLOURS = [
    "#0072B2",
    "#56B4E9",
    "#009E73",
    "#D55E00",
    "#E69F00",
    "#CC79A7",
    "#000000",
    "#999999",
    "#DDCC00",
]
SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)


def scans() -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and points of every cloud."""
    yield "cloud.txt", load_cloud("cloud.txt")[:, :3]
    yield f"random street {SEED}", scenes.city_block(seed=SEED, frames=1)[0].cloud[:, :3]
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


def compare(name: str, implementations: dict, cloud: np.ndarray, truth: np.ndarray | None) -> dict:
    """Time all implementations on a cloud, print a table and return a record for the JSON file."""
    with started(implementations, cloud) as competitors:
        quiet = race(competitors)
        with busy(processor_count()):
            loaded = race(competitors)
    record = {
        "points": len(cloud),
        "other threads": [quiet.others, loaded.others],
        "seconds": {
            "quiet": quiet.seconds,
            "cold caches": quiet.cold,
            "other work": loaded.seconds,
        },
        "processors": quiet.processors,
        "bytes": {name: competitor.memory for name, competitor in competitors.items()},
        "answers": {
            name: describe(competitor.answer, truth) for name, competitor in competitors.items()
        },
    }
    print_times(name, record)
    return record


def describe(answer: np.ndarray, truth: np.ndarray | None) -> str:
    """Return the number of boxes, or whether the labels are right."""
    if truth is None:
        return f"{len(answer)} boxes"
    return "right" if same_partition(answer, truth) else "WRONG"


def print_times(name: str, record: dict) -> None:
    """Print the times on one cloud as a table in Markdown."""
    quiet, loaded = record["other threads"]
    print(f"\n**{name}**, {record['points']:,} points, {ROUNDS} rounds or fewer")
    print(f"Other running threads: {quiet:.1f}, and {loaded:.1f} with other work\n")
    conditions = " | ".join(f"{condition}, ms" for condition in record["seconds"])
    print(f"| least and median time | {conditions} | processors used | memory, MB | answer |")
    print("|---|---:|---:|---:|---:|---:|---|")
    for program, answer in record["answers"].items():
        cells = [
            "{:,.1f}, {:,.1f}".format(*1000 * np.nanpercentile(seconds[program], (0, 50)))
            for seconds in record["seconds"].values()
        ]
        cells.append(f"{record['processors'][program]:.1f}")
        cells.append(f"{record['bytes'][program] / 1e6:,.0f}")
        print(f"| {program} | {' | '.join(cells)} | {answer} |")


def print_ratios(records: dict[str, dict], reference: str) -> None:
    """Print how many times as long as a reference the programs take, as a table in Markdown."""
    first = next(iter(records.values()))
    if reference not in first["answers"]:
        return
    print(f"\n**Times as long as {reference}**, median of the rounds, over {len(records)} scans\n")
    print(f"| program | {' | '.join(first['seconds'])} |\n|---|---:|---:|---:|")
    for program in first["answers"]:
        cells = []
        for condition in first["seconds"]:
            times = [record["seconds"][condition] for record in records.values()]
            ratios = [np.nanmedian(np.divide(each[program], each[reference])) for each in times]
            cells.append(f"{with_two_digits(min(ratios))} to {with_two_digits(max(ratios))}")
        print(f"| {program} | {' | '.join(cells)} |")


def with_two_digits(ratio: float) -> str:
    """Return a ratio with two digits or more."""
    return f"{ratio:.{max(0, 1 - int(np.floor(np.log10(ratio))))}f}"


def turns_side_by_side(scan: np.ndarray, count: int) -> np.ndarray:
    """Return `count` points: copies of a scan, 300 m apart, the last one incomplete."""
    turns = [scan + [0, 300.0 * number, 0] for number in range(-(-count // len(scan)))]
    few = np.random.default_rng(0).permutation(turns.pop())[: count - len(scan) * len(turns)]
    return np.ascontiguousarray(np.vstack([*turns, few]))


def measure_scaling(scan: np.ndarray) -> dict[str, dict]:
    """Time each implementation on growing clouds until it is too slow; print and return times."""
    found: dict[str, dict] = {name: {"points": [], "seconds": []} for name in CLUSTERING}
    quick = dict(CLUSTERING)
    for size in SIZES:
        with started(quick, turns_side_by_side(scan, size)) as competitors:
            times = race(competitors).seconds
        for name, seconds in times.items():
            found[name]["points"].append(size)
            found[name]["seconds"].append(np.nanmin(seconds))
        quick = {name: quick[name] for name in times if 4 * np.nanmedian(times[name]) < PATIENCE}
    found = {name: series for name, series in found.items() if series["points"]}
    print("\n**Growing clouds**: whole turns side by side, times in seconds, fitted exponent\n")
    for name, series in found.items():
        series["exponent"] = exponent(series["points"], series["seconds"])
        times = ", ".join(f"{seconds:.3f}" for seconds in series["seconds"])
        print(f"- {name}: {times}; n to the power of {series['exponent']:.2f}")
    return found


def draw_bars(name: str, measured: dict, axis_scale: str, axes) -> None:
    """Draw the shortest time of each implementation on one cloud as bars."""
    least = {
        name: 1000 * np.nanmin(seconds) for name, seconds in measured["seconds"]["quiet"].items()
    }
    ordered = sorted(least, key=least.get, reverse=True)
    colours = [
        "#0072B2" if implementation.startswith("ours") else "#BBBBBB" for implementation in ordered
    ]
    drawn = axes.barh(ordered, [least[implementation] for implementation in ordered], color=colours)
    axes.bar_label(
        drawn, [f"{least[implementation]:,.0f} ms" for implementation in ordered], padding=3
    )
    axes.set(xscale=axis_scale, xlabel="ms", title=name)
    axes.margins(x=0.2)
    axes.spines[["top", "right"]].set_visible(False)


def draw(record: dict, path: Path) -> None:
    """Save a figure of the results on the first cloud and of the times on growing clouds."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplot_mosaic(
        [["clusters", "growth"], ["boxes", "growth"]],
        figsize=(13, 5.5),
        height_ratios=(8, 3),
        layout="constrained",
    )
    name, first = next(iter(record["clustering"].items()))
    draw_bars(f"Clusters of {first['points']:,} points ({name})", first, "log", axes["clusters"])
    draw_bars("From that scan to boxes", record["detector"][name], "linear", axes["boxes"])
    for number, (implementation, series) in enumerate(record["scaling"].items()):
        label = f"{implementation}: n^{series['exponent']:.2f}"
        style = {"marker": "os^vD<>PX"[number], "color": COLOURS[number]}
        axes["growth"].loglog(series["points"], series["seconds"], label=label, **style)
    axes["growth"].set(xlabel="points", ylabel="s", title="Turns of the scanner, side by side")
    axes["growth"].legend(fontsize="small", frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
    figure.supxlabel(
        f"Shortest of {record['rounds']} rounds. {record['machine']}", fontsize="small"
    )
    figure.savefig(path, dpi=90, metadata={"Software": None})


def main() -> None:
    """Measure, print the tables and write the files."""
    about = {"machine": machine(), "rounds": ROUNDS, "seed": SEED, "radius": RADIUS}
    print(*(f"{name}: {value}" for name, value in about.items()), sep="; ")
    record = about | {"clustering": {}, "worst": {}, "detector": {}}
    clouds = {name: np.ascontiguousarray(cloud, dtype=float) for name, cloud in scans()}
    for name, cloud in clouds.items():
        record["clustering"][name] = compare(name, CLUSTERING, cloud, all_pairs(cloud)())
    print_ratios(record["clustering"], OURS)
    print_ratios(record["clustering"], COMPILED)
    print("\n## Worst cases")
    for name, cloud, truth in worst_cases():
        record["worst"][name] = compare(name, GRIDS, cloud, truth)
    print("\n## From the raw scan to boxes")
    for name, cloud in clouds.items():
        record["detector"][name] = compare(name, DETECTORS, cloud, None)
    print_ratios(record["detector"], "PCL")
    record["scaling"] = measure_scaling(clouds["cloud.txt"])
    path = save_results("clustering", record)
    draw(record, FOLDER / "clustering.png")
    print(f"\nWritten: {path} and {FOLDER / 'clustering.png'}")


if __name__ == "__main__":
    main()
