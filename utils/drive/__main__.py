"""Drive through the simulator's streets with the detector in one of your notebooks.

    python -m utils.drive 12_streaming_obstacles.ipynb
    python -m utils.drive 12_streaming_obstacles.ipynb --street 3
    python -m utils.drive 12_streaming_obstacles.ipynb --street 3 --to film.mp4
    python -m utils.drive 12_streaming_obstacles.ipynb --street 3 --to strip.html

Without a notebook the car sees the true boxes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from utils.drive import STREETS, drive_street
from utils.drive.standards import DriveResult, drive_result, reference_results

SUFFIXES = (".mp4", ".gif", ".png", ".html", ".rrd", ".mcap")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 after an error, 130 after Ctrl-C."""
    options = build_parser().parse_args(arguments)
    try:
        detect = tracker = None
        if options.notebook:
            from utils.play import load_detector

            detect, tracker = load_detector(options.notebook)
        return _drive(options, detect, tracker)
    except (ValueError, OSError) as problem:
        print(problem)
        return 2
    except NotImplementedError as problem:
        print(f"The detector calls a function that is not written yet: {problem}")
        return 2


def _drive(options: argparse.Namespace, detect: object, tracker: object) -> int:
    streets = [STREETS[number - 1] for number in options.street or range(1, len(STREETS) + 1)]
    if options.to and len(streets) != 1:
        print("--to needs exactly one street. Choose a street, for example with --street 3.")
        return 2
    done: dict[int, DriveResult] = {}
    stopped = False
    for street in streets:
        try:
            trip = drive_street(street, detect, tracker, seconds=options.seconds)
            done[street.number] = drive_result(trip.report)
            print(trip)
            if options.to:
                print(f"{options.to}: {trip.save(options.to)}")
        except KeyboardInterrupt:
            print("\nStopped.")
            stopped = True
            break
    _compare(done, options.seconds)
    return 130 if stopped else 0


def _compare(done: dict[int, DriveResult], seconds: float) -> None:
    """Print the total of all drives above the stored results for the same streets."""
    if not done:
        return
    print(f"\n{'yours':28} {sum(done.values(), start=DriveResult())}")
    if seconds == 20.0:
        for name, result in reference_results(done).items():
            print(f"{name:28} {result}")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line ``python -m utils.drive``."""
    parser = argparse.ArgumentParser(
        prog="python -m utils.drive",
        description=__doc__.split("\n\n")[0],
        epilog="Streets: " + " · ".join(f"{street.number} {street.title}" for street in STREETS),
    )
    parser.add_argument(
        "notebook",
        nargs="?",
        metavar="NOTEBOOK",
        help="notebook that defines detect_obstacles(cloud) (default: drive with the true boxes)",
    )
    parser.add_argument(
        "--street",
        type=int,
        nargs="+",
        choices=range(1, len(STREETS) + 1),
        metavar="N",
        help=f"numbers of the streets to drive, 1 to {len(STREETS)} (default: all)",
    )
    parser.add_argument(
        "--to",
        type=_file,
        metavar="FILE",
        help="write a film (.mp4, .gif), its last picture (.png), a page that shows each braking "
        "event (.html), or a file for Rerun (.rrd) or for Foxglove and RViz (.mcap)",
    )
    parser.add_argument(
        "--seconds",
        type=_seconds,
        default=20.0,
        help="seconds to drive in each street (default: 20)",
    )
    return parser


def _file(text: str) -> Path:
    path = Path(text)
    if path.suffix not in SUFFIXES:
        raise argparse.ArgumentTypeError(f"{path.name} must end in one of {', '.join(SUFFIXES)}")
    return path


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 1.0 <= seconds <= 60.0:
        raise argparse.ArgumentTypeError(f"must be a number from 1 to 60, not {text!r}")
    return seconds


if __name__ == "__main__":
    sys.exit(main())
