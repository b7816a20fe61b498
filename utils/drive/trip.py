"""A drive with its report, to show in a notebook, to print, or to save as a film or a page."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from utils.drive.loop import Drive, drive
from utils.drive.metrics import Report, measure
from utils.drive.streets import STREETS, Street
from utils.films.film import STREAMS
from utils.tracking import Tracker


@dataclass(frozen=True, eq=False, repr=False)
class Trip:
    """A drive that displays itself in a notebook."""

    drive: Drive

    @cached_property
    def report(self) -> Report:
        """Metrics of the drive and explanations of its braking events."""
        return measure(self.drive)

    def save(self, path: str | os.PathLike) -> str:
        """Write a film (.mp4, .gif), its last picture (.png), a page (.html) or a stream.

        A stream is a file for Rerun (.rrd) or for Foxglove and RViz (.mcap). It contains each scan
        with its ground and clusters, the boxes with track IDs and the decisions of the car.

        Returns
        -------
        str
            Description of the file in words.

        Raises
        ------
        ValueError
            The path has another suffix, or the package for Rerun is not installed.
        """
        if Path(path).suffix == ".html":
            from utils.drive.timeline import write_page

            write_page(self.drive, self.report, path)
            return "A page with the speed over time and the frame of each braking event."
        if Path(path).suffix in STREAMS:
            from utils.drive.stream import frames_of
            from utils.films.streams import write_stream

            write_stream(Path(path), frames_of(self.drive))
            return STREAMS[Path(path).suffix]
        from utils.drive.film import make_film

        return make_film(self.drive, self.report, path).recap

    def __str__(self) -> str:
        street, report = self.drive.street, self.report
        words = [
            f"Street {street.number} · {street.title}: {report.metres:.0f} m in "
            f"{report.seconds:.0f} s."
        ]
        for braking in report.brakings:
            time = self.drive.moments[braking.first].time
            words.append(f"  {time:4.1f} s  {'needless: ' if braking.needless else ''}{braking}")
        if report.collision:
            words.append(f"  {report.seconds:4.1f} s  {report.collision}")
        words += [f"  {line}" for line in comfort_sentences(report)]
        if self.drive.problems:
            failed, first = len(self.drive.problems), self.drive.problems[0]
            words.append(
                f"  Scans for which the detector failed: {failed}. The first failure: {first}"
            )
        return "\n".join(words)

    def __repr__(self) -> str:
        return str(self)  # for a notebook that does not show HTML

    def _repr_html_(self) -> str:
        import html

        from utils.drive.timeline import html_fragment

        street = self.drive.street
        lines = [f"<b>Street {street.number} · {html.escape(street.title)}</b>"]
        lines += [f"{self.report.metres:.0f} m in {self.report.seconds:.0f} s"]
        lines += comfort_sentences(self.report)
        lines += [html.escape(problem) for problem in self.drive.problems[:1]]
        return f"<p>{'<br>'.join(lines)}</p>{html_fragment(self.drive, self.report)}"


def comfort_sentences(report: Report) -> list[str]:
    """Describe the speed, the comfort, the closest pass and the detector's delay in sentences."""
    words = [f"Mean speed: {3.6 * report.mean_speed:.0f} km/h."]
    if report.hardest_braking > 1.0:
        words.append(
            f"Hardest braking: {report.hardest_braking:.1f} m/s². "
            f"Harsh braking: {report.harsh_seconds:.1f} s."
        )
    if report.closest_kind and report.closest_distance < 5:
        words.append(f"Closest pass: {report.closest_distance:.1f} m from {report.closest_kind}.")
    if report.near_misses:
        words.append(f"Near misses: {report.near_misses}.")
    if report.scan_age > 0.15:
        words.append(
            f"The detector is slow. The car used scans that were {report.scan_age:.1f} s old."
        )
    return words


def drive_street(
    street: int | Street,
    detect: Callable | None = None,
    tracker: Tracker | None = None,
    *,
    seconds: float = 20.0,
    clock: Callable | None = None,
) -> Trip:
    """Drive through a street with a detector, and show how the drive went.

    Parameters
    ----------
    street : int or Street
        A street, or its number from 1 to 20.
    detect : callable, optional
        ``detect_obstacles``: takes a cloud (n, 4) and returns boxes (N, 8, 3). Without a detector
        the car sees the true boxes.
    tracker : utils.tracking.Tracker, optional
        A tracker that uses your functions from lesson 12. ``Tracker(match_boxes)`` is enough; the
        course provides the other functions.
    seconds : float
        Duration of the drive; a collision ends it earlier.
    clock : callable, optional
        `utils.drive.on_time` if the detector's computing time should not count.

    Returns
    -------
    Trip
        Displays itself as the last line of a cell; ``.save("film.mp4")`` writes a film.

    Raises
    ------
    ValueError
        There is no street with this number.
    """
    if not isinstance(street, Street):
        if street not in range(1, len(STREETS) + 1):
            raise ValueError(f"There is no street {street!r}. The streets are 1 to {len(STREETS)}.")
        street = STREETS[street - 1]
    return Trip(drive(street, detect, tracker, seconds=seconds, clock=clock))
