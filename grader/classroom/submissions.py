"""What a class has handed in, and where its verdicts lie."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.course.lessons import Lesson, all_lessons, find_lesson, stages
from grader.course.paths import Course
from grader.intake.handed_in import HandedIn, read_handed_in


@dataclass(frozen=True)
class Submission:
    """One notebook that a student handed in."""

    student: str
    lesson: Lesson
    path: Path

    def verdict_path(self, course: Course) -> Path:
        """Where its verdict is kept."""
        return course.verdicts / self.student / self.lesson.stage / f"{self.lesson.name}.json"

    def read(self, course: Course) -> HandedIn:
        """What lies there; not what lies elsewhere, in another student's folder."""
        place = course.submitted.resolve() / self.student / self.lesson.stage
        if self.path.parent.resolve() != place:
            return HandedIn(
                self.path.name,
                b"",
                f"{self.path.name} lies behind a link to another folder. Hand in the file itself.",
            )
        return read_handed_in(self.path)


def find_submissions(course: Course, stages: Iterable[str] = ()) -> list[Submission]:
    """Everything under ``submitted/<student>/<stage>/`` that is a lesson of the course.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str, optional
        Only these stages; by default all.

    Returns
    -------
    list of Submission
        In order of student and lesson.
    """
    found = [
        Submission(path.parent.parent.name, lesson, path)
        for lesson in all_lessons()
        if not stages or lesson.stage in stages
        for path in course.submitted.glob(f"*/{lesson.stage}/{lesson.name}.ipynb")
    ]
    return sorted(found, key=lambda submission: (submission.student, submission.lesson.name))


def unaccounted_files(course: Course) -> list[tuple[Path, str]]:
    """Files in ``submitted/`` that nobody judges, each with the reason."""
    judged = {submission.path for submission in find_submissions(course)}
    found = []
    for path in sorted(course.submitted.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(course.submitted).parts)
        if path in judged or path.is_dir() or hidden or path.name == "timestamp.txt":
            continue
        reason = _reason(path.relative_to(course.submitted))
        if reason:
            found.append((path.relative_to(course.root), reason))
    return found


def _reason(path: Path) -> str:
    """Why a file is no submission; empty where it belongs to one."""
    if len(path.parts) != 3 or path.parts[1] not in stages():
        return "it does not lie in <student>/<stage>/"
    if path.suffix == ".py":
        return ""  # a module that a notebook may import
    lesson = find_lesson(path.stem)
    if lesson is None or path.suffix != ".ipynb":
        return "it is no notebook of the course"
    if lesson.stage != path.parts[1]:
        return f"{lesson.name} belongs to {lesson.stage}"
    return f"it is a copy by name: only {lesson.name}.ipynb is judged. Rename the one that counts"
