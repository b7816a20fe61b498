"""What an instructor should know about the marks of a class, a sentence each."""

from __future__ import annotations

from collections.abc import Iterator

from grader.lms.results import ClassResults


def notes(results: ClassResults) -> Iterator[str]:
    """What a person has still to decide or to look at."""
    for stage in results.stages:
        if stage.undecided:
            yield (
                f"{stage.student}, {stage.stage}: timestamp.txt does not say a time that can be "
                "read, such as 2026-11-22 18:30:00 UTC; whether the work is late is undecided. "
                "Write the time, and run grade again."
            )
