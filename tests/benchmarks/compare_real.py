"""Compare simulated frames with real ones, for the table and the pictures of the data card.

    REAL_CLOUDS=folder python -m tests.benchmarks.compare_real [--pictures data/pictures]

The folder contains KITTI recordings, which are not part of this project: `data_1/*.pcd`,
`kitti_000008.bin`, `kitti_000008_boxes.csv` and `simpleHighway.pcd`.
"""

from __future__ import annotations

import argparse
import csv
import os
from pathlib import Path

import numpy as np

from utils.scenes import Frame, city_block, lesson_street, simple_highway
from utils.simulator import CLASSES, highway_sensor, ray_directions

RANGES = (0, 5, 10, 15, 20, 30, 50, 120)
HEIGHTS = (-30, -2.0, -1.6, -1.2, -0.5, 0.0, 0.5, 1.0, 10)


def read_highway(folder: Path) -> np.ndarray:
    """Return the published highway frame, whose origin is on the road, in sensor coordinates."""
    lines = (folder / "simpleHighway.pcd").read_text().split("DATA ascii\n")[1]
    return np.array(lines.split(), dtype=float).reshape(-1, 3) - highway_sensor().origin


def highway_counts(points: np.ndarray) -> list[int]:
    """Count the returns of the ground and of each of the three cars.

    A return belongs to a car if it is at least 0.4 m nearer than the ground on its ray.
    """
    sensor = highway_sensor()
    rays = ray_directions(sensor).reshape(3, -1)
    ranges = np.linalg.norm(points, axis=1)
    ray = np.argmax(points / ranges[:, None] @ rays, axis=1)
    raised = ranges < sensor.origin[2] / -rays[2][ray] - 0.4
    cars = np.array([(15.0, 0.0), (8.0, -4.0), (-12.0, 4.0)])
    distances = np.linalg.norm(points[raised, None, :2] - cars, axis=2)
    return [int(np.sum(~raised)), *np.bincount(distances.argmin(axis=1), minlength=3).tolist()]


def neighbours(cloud: np.ndarray) -> list[float]:
    """Return quartiles of the number of neighbours within 0.5 m of every 30th point."""
    from scipy.spatial import cKDTree

    tree = cKDTree(cloud[:, :3])
    counts = tree.query_ball_point(cloud[::30, :3], 0.5, return_length=True) - 1
    return np.percentile(counts, (25, 50, 75)).tolist()


def read_pcd(path: Path) -> np.ndarray:
    """Read a binary PCD file with four float32 fields."""
    content = path.read_bytes()
    header, _ = content.split(b"DATA binary\n", 1)
    count = int(header.split(b"POINTS ")[1].split()[0])
    return np.frombuffer(content, "<f4", 4 * count, len(header) + 12).reshape(-1, 4).astype(float)


def labelled_cars(folder: Path) -> list[tuple[float, int]]:
    """Return the distance and number of points of each labelled car that is truncated below 0.3."""
    with (folder / "kitti_000008_boxes.csv").open() as table:
        rows = [row for row in csv.DictReader(table) if float(row["trunc"]) < 0.3]
    return [(float(np.hypot(float(r["cx"]), float(r["cy"]))), int(r["npts"])) for r in rows]


def returns_at_ten_metres(cars: list[tuple[float, int]]) -> str:
    """Return quartiles of the returns per car, scaled to 10 m by the square of the distance."""
    scaled = [count * (reach / 10) ** 2 for reach, count in cars if 5 < reach < 25]
    return " / ".join(f"{value:.0f}" for value in np.percentile(scaled, (25, 50, 75)))


def simulated_cars(frame: Frame) -> list[tuple[float, int]]:
    """Return the distance and number of returns of every simulated car."""
    cars = (box for box in frame.boxes if box.kind == "car")
    return [(float(np.hypot(*box.centre[:2])), box.returns) for box in cars]


def share(values: np.ndarray, edges: tuple[float, ...]) -> list[float]:
    """Return the percentage of the values in each bin."""
    return (100 * np.histogram(values, edges)[0] / len(values)).tolist()


def print_table(clouds: dict[str, np.ndarray]) -> None:
    """Print a table in Markdown with one column per cloud."""
    print("| |", " | ".join(clouds), "|")
    print("|---|" + "---:|" * len(clouds))
    columns = {name: list(_figures(cloud)) for name, cloud in clouds.items()}
    for rows in zip(*columns.values(), strict=True):
        print(f"| {rows[0][0]} |", " | ".join(value for _, value in rows), "|")


def _figures(cloud: np.ndarray):
    """Yield each row's label and formatted number for one cloud."""
    reach = np.hypot(cloud[:, 0], cloud[:, 1])
    yield "returns", f"{len(cloud):,}".replace(",", " ")
    for low, high, value in zip(RANGES, RANGES[1:], share(reach, RANGES), strict=False):
        yield f"{low} to {high} m away", f"{value:.1f} %"
    for low, high, value in zip(HEIGHTS, HEIGHTS[1:], share(cloud[:, 2], HEIGHTS), strict=False):
        name = f"z from {low} to {high} m"
        name = f"z below {high} m" if low == HEIGHTS[0] else name
        yield f"z above {low} m" if high == HEIGHTS[-1] else name, f"{value:.1f} %"
    quartiles = " / ".join(f"{value:.0f}" for value in neighbours(cloud))
    yield "neighbours within 0.5 m (quartiles)", quartiles
    quartiles = " / ".join(f"{value:.0f}" for value in neighbours(cloud[cloud[:, 2] > -1.2]))
    yield "neighbours within 0.5 m, only points above z = -1.2 m (quartiles)", quartiles
    quartiles = " / ".join(f"{value:.2f}" for value in np.percentile(cloud[:, 3], (5, 50, 95)))
    yield "intensity (5th, 50th and 95th percentiles)", quartiles
    box = np.all((cloud[:, :3] > (-1.5, -1.7, -1)) & (cloud[:, :3] < (2.6, 1.7, -0.4)), axis=1)
    yield "returns from the ego car", str(np.count_nonzero(box))
    yield "returns at exactly (0, 0, 0)", str(np.count_nonzero((cloud[:, :3] == 0).all(axis=1)))


COLOURS = {
    "ground": "#BBBBBB",
    "wall": "#444444",
    "foliage": "#009E73",
    "pole": "#CC79A7",
    "car": "#0072B2",
    "truck": "#56B4E9",
    "pedestrian": "#D55E00",
    "cyclist": "#E69F00",
    "ego": "#000000",
}


def draw_street(frame: Frame, folder: Path) -> None:
    """Draw `cloud.txt` from above, coloured by true class, with the true boxes."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(10, 6.4), layout="constrained")
    for name, colour in COLOURS.items():
        points = frame.cloud[frame.scan.classes == CLASSES.index(name)]
        size = 0.15 if name in ("ground", "wall") else 0.8
        axes.plot(*points[:, :2].T, ",", color=colour, rasterized=True)
        axes.scatter(*points[:, :2].T, s=size, color=colour, linewidths=0)
        axes.plot([], [], "o", color=colour, label=name)
    for box in frame.boxes:
        if box.kind not in ("wall", "foliage"):
            outline = box.corners[[0, 1, 2, 3, 0]]
            axes.plot(outline[:, 0], outline[:, 1], color="black", lw=0.6)
    axes.add_patch(plt.Circle((0, 0), 10, fill=False, ls=":", color="black"))
    axes.set(xlim=(-20, 26), ylim=(-13, 16), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.legend(loc="upper left", ncols=3, fontsize="small")
    figure.savefig(folder / "street.png", dpi=90, metadata={"Software": None})


def draw(simulated: Frame, folder: Path, cars: list[tuple[float, int]], clouds: dict) -> None:
    """Plot returns by distance and height, and returns per car, without showing real points."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    blue, orange = "#0072B2", "#D55E00"
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    for name, cloud in clouds.items():
        ours = name in ("cloud.txt", "city block")
        style = {"color": blue if ours else orange, "lw": 1.6, "ls": "-" if ours else "--"}
        reach = np.hypot(cloud[:, 0], cloud[:, 1])
        for axis, values, edges in (
            (axes[0], reach, np.arange(0, 41, 1.0)),
            (axes[1], cloud[:, 2], np.arange(-3, 3, 0.1)),
        ):
            counts = np.histogram(values, edges)[0] / len(values) / np.diff(edges)
            axis.stairs(100 * counts, edges, **style)
    axes[0].set(xlabel="horizontal distance (m)", ylabel="% of returns per metre")
    axes[1].set(xlabel="height z (m)", ylabel="% of returns per metre")
    own = simulated_cars(simulated)
    axes[2].loglog(*zip(*own, strict=True), "o", color=blue, label="simulated")
    axes[2].loglog(*zip(*cars, strict=True), "s", color=orange, mfc="none", label="real (KITTI)")
    axes[2].set(xlabel="distance of a car (m)", ylabel="returns", xlim=(3, 100), ylim=(1, 2e4))
    axes[2].legend(frameon=False)
    axes[0].plot([], [], color=blue, label="simulated")
    axes[0].plot([], [], color=orange, ls="--", label="real (KITTI)")
    axes[0].legend(frameon=False)
    figure.savefig(folder / "against_real.png", dpi=90, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pictures", type=Path, help="folder for the two pictures")
    arguments = parser.parse_args()
    lesson, city = lesson_street(), city_block()[0]
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
        draw_street(lesson, arguments.pictures)
    if not os.environ.get("REAL_CLOUDS"):
        raise SystemExit("Set REAL_CLOUDS to a folder of KITTI recordings first.")
    folder = Path(os.environ["REAL_CLOUDS"])

    real = {f"city {p.stem[-2:]}": read_pcd(p) for p in sorted((folder / "data_1").glob("*.pcd"))}
    kitti = np.fromfile(folder / "kitti_000008.bin", "<f4").reshape(-1, 4).astype(float)
    clouds = {"cloud.txt": lesson.cloud, "city block": city.cloud, **real, "object 8": kitti}
    print_table(clouds)

    cars = labelled_cars(folder)
    for name, pairs in (
        ("real", cars),
        ("cloud.txt", simulated_cars(lesson)),
        ("city block", simulated_cars(city)),
    ):
        near = sorted(pair for pair in pairs if pair[0] < 25)
        print(f"\nReturns per car, {name}:", ", ".join(f"{r:.1f} m: {n}" for r, n in near))
        print("  scaled to 10 m (quartiles):", returns_at_ten_metres(near))

    print(
        "\nHighway, ground and three cars:",
        highway_counts(simple_highway().cloud[:, :3]),
        "ours,",
        highway_counts(read_highway(folder) - 0.1),
        "recorded",
    )
    if arguments.pictures:
        draw(lesson, arguments.pictures, cars, clouds)


if __name__ == "__main__":
    main()
