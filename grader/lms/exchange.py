"""Release notebooks through nbgrader's exchange so that each works alone in its folder."""

from __future__ import annotations

import json
from pathlib import Path

from nbgrader.exchange.default import ExchangeReleaseAssignment

from grader.course.atomic_files import write_atomically
from grader.course.lessons import all_lessons
from grader.course.standalone import make_standalone


class ReleaseStandalone(ExchangeReleaseAssignment):
    """Releases the notebooks of the course with its tools packed into their setup cell.

    The rest of a notebook is unchanged, so the judge treats both versions alike.
    """

    def do_copy(self, src: str, dest: str, log: object = None) -> None:
        """Copy an assignment into the exchange; see nbgrader."""
        super().do_copy(src, dest, log)
        for path in sorted(Path(dest).rglob("*.ipynb")):
            if _is_lesson(path):
                write_atomically(make_standalone(path.read_bytes()), path)


def _is_lesson(path: Path) -> bool:
    """Return whether a notebook is part of the course; instructors may also release others."""
    try:
        metadata = json.loads(path.read_bytes())["metadata"]["lidar_obstacle_lab"]
        return metadata["lesson"] in {lesson.name for lesson in all_lessons()}
    except (ValueError, KeyError, TypeError):
        return False
