"""Release notebooks, and each student's feedback, through nbgrader's exchange."""

from __future__ import annotations

import glob
import json
from pathlib import Path

from nbgrader.exchange.default import ExchangeReleaseAssignment, ExchangeReleaseFeedback

from grader.course.atomic_files import write_atomically
from grader.course.lessons import all_lessons
from grader.course.standalone import make_standalone
from grader.untrusted_text import one_line


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


class ReleaseFeedbackPerStudent(ExchangeReleaseFeedback):
    """Releases feedback per student, so that one damaged submission does not stop the others.

    nbgrader reads two files of the submission. The student owns one of them in the exchange, and a
    submission that was copied by hand has neither.
    """

    def copy_files(self) -> None:
        """Copy the pages of each student into the exchange; see nbgrader."""
        for name in sorted(glob.glob(self.src_path)):
            fault = _fault_of_feedback(Path(name))
            if fault:
                self.log.warning(
                    "The feedback for %s was not released, because %s. Give the student the pages "
                    "in %s yourself.",
                    one_line(Path(name).parent.name),
                    fault,
                    one_line(name),
                )
                continue
            self.src_path = glob.escape(name)
            super().copy_files()


def _fault_of_feedback(folder: Path) -> str:
    """Return why nbgrader cannot release the pages in a folder, or an empty text."""
    for name in ("timestamp.txt", "submission_secret.txt"):
        try:
            text = (folder / name).read_text()
        except FileNotFoundError:
            return f"{name} is missing"
        except (OSError, UnicodeError):
            return f"{name} cannot be read"
    return "" if text else f"{name} is empty"


def _is_lesson(path: Path) -> bool:
    """Return whether a notebook is part of the course; instructors may also release others."""
    try:
        metadata = json.loads(path.read_bytes())["metadata"]["lidar_obstacle_lab"]
        return metadata["lesson"] in {lesson.name for lesson in all_lessons()}
    except (ValueError, KeyError, TypeError):
        return False
