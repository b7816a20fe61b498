"""Drive the twenty streets with reference detectors, for comparison with a student's drive.

Run this file with the project on PYTHONPATH to update the results in `utils.drive.standards`.
"""

from __future__ import annotations

import sys

from grader.course.lessons import all_lessons
from utils.drive import STREETS, drive_street, occupied_squares, on_time
from utils.drive.standards import DRIVERS, DriveResult, drive_result, store_results
from utils.notebooks.my_functions import load_my_functions
from utils.tracking import tracker_from


def drive_all(name: str) -> dict[int, DriveResult]:
    """Drive every street with one of `DRIVERS`, and return the results by street number.

    All the detectors are faster than the scanner. They are not timed, so that the results are the
    same on every machine.
    """
    detect = tracker = None
    if name == DRIVERS[1]:
        lesson = next(lesson for lesson in all_lessons() if lesson.number == "12")
        course = load_my_functions(lesson.solved)
        detect, tracker = course.detect_obstacles, tracker_from(course)
    elif name == DRIVERS[2]:
        detect = occupied_squares
    results = {}
    for street in STREETS:
        trip = drive_street(street, detect, tracker, clock=on_time)
        print(trip, flush=True)
        results[street.number] = drive_result(trip.report)
    return results


def main() -> None:
    """Drive all streets with all drivers, and store the results."""
    store_results({name: drive_all(name) for name in DRIVERS})


if __name__ == "__main__":
    sys.exit(main())
