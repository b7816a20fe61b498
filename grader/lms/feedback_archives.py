"""Build zips of feedback with file names that an LMS can match with its students.

Canvas and Moodle use the names of the submitted files, which `collect` records with the submission.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.course.archives import make_zip
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.course.roster import read_roster, section_slug
from grader.lms.collected_files import CollectedFile, collected_files
from grader.lms.feedback import Feedback, FeedbackCollector, FeedbackNotReady, LessonFeedback
from grader.lms.feedback_notebook import feedback_notebook
from grader.lms.feedback_page import feedback_page
from grader.lms.results import WAITING

_TEAM_REASON = "submitted as {}, which may be a team"


@dataclass(frozen=True)
class FeedbackArchive:
    """Content of a feedback archive for one LMS.

    Attributes
    ----------
    files : dict of str to bytes
        File contents by name.
    skipped : tuple of str
        One sentence for each student whose submission did not come from this LMS.
    teams : tuple of str
        One sentence for each submission of a team, to which the LMS cannot return feedback.
    """

    files: dict[str, bytes] = field(default_factory=dict)
    skipped: tuple[str, ...] = ()
    teams: tuple[str, ...] = ()


def build_moodle_archive(
    course: Course, stage: str, all_feedback: Sequence[Feedback]
) -> FeedbackArchive:
    """Build an archive of pages for Moodle's *Upload multiple feedback files in a zip*.

    Moodle finds a participant by the number in ``{name}_{number}_assignsubmission_file_{file}``. A
    team also has a number, which may be another student's participant number. A student has a
    different number in each assignment. The archive has one page for each number, and Moodle
    ignores the pages that belong to other assignments.
    """
    sources, roster = collected_files(course, [stage]), read_roster(course)
    teams = _team_owners(sources)
    files, skipped, team_sentences = {}, [], []
    for feedback in all_feedback:
        person = feedback.person
        own_files = [file for file in sources.get(person.id, {}).values() if file.participant]
        if not own_files:
            skipped.append(f"{person.id}: the work was not collected from a Moodle zip")
            continue
        for owner, number in sorted({(file.owner, file.participant) for file in own_files}):
            name = owner.removesuffix(f"_{number}")
            named = roster is None or person in roster.find_people(name) or name.endswith(number)
            if owner in teams or not named:
                team_sentences.append(f"{person.id}: {_TEAM_REASON.format(name)}")
                continue
            path = f"{owner}_assignsubmission_file_{stage}_feedback.html"
            files[path] = feedback_page(feedback).encode()
    return FeedbackArchive(files, tuple(skipped), tuple(team_sentences))


def build_canvas_archive(
    course: Course, stage: str, all_feedback: Sequence[Feedback]
) -> FeedbackArchive:
    """Build an archive with feedback on each submitted file, for Canvas's *Upload Submissions*.

    Canvas finds the original file by ``{name}_{user id}_{attachment id}_{file}`` and gives the
    feedback the same name. For a submitted zip, the feedback is a zip that contains the page.
    """
    sources = collected_files(course, [stage])
    teams = _team_owners(sources)
    files, skipped, team_sentences = {}, [], []
    for feedback in all_feedback:
        id, lessons = (
            feedback.person.id,
            {lesson.lesson.name: lesson for lesson in feedback.lessons},
        )
        own_files = {name: file for name, file in sources.get(id, {}).items() if file.attachment}
        team = {file.owner for file in own_files.values()} & teams
        contents = {
            f"{file.owner}_{file.attachment}_{file.file}": content
            for name, file in own_files.items()
            if not team and (content := _feedback_file(feedback, lessons[name], file.file))
        }
        files |= contents
        if team:
            team_sentences.append(f"{id}: {_TEAM_REASON.format(min(team))}")
        elif not contents:
            skipped.append(f"{id}: no notebook was collected from a Canvas zip")
    return FeedbackArchive(files, tuple(skipped), tuple(team_sentences))


@dataclass(frozen=True)
class Platform:
    """An LMS to which feedback can be uploaded.

    Attributes
    ----------
    build_archive : callable
        Builds a `FeedbackArchive` from course, stage and feedback.
    next_step : str
        Instructions for uploading the zip.
    """

    build_archive: Callable[[Course, str, Sequence[Feedback]], FeedbackArchive]
    next_step: str


PLATFORMS = {
    "moodle": Platform(
        build_moodle_archive,
        "In Moodle: the assignment's Submissions, Actions, Upload multiple feedback files in a "
        "zip. This action appears only if the assignment's feedback types include feedback files. "
        "If each lesson of the stage is a separate assignment, upload the zip to each of them.",
    ),
    "canvas": Platform(
        build_canvas_archive,
        "In Canvas: Grades, the assignment's menu, Upload Submissions. This entry appears only "
        "after Download Submissions. Each file becomes an attachment to a comment.",
    ),
}


@dataclass(frozen=True)
class WrittenFeedback:
    """The files that `write_feedback` wrote.

    Attributes
    ----------
    pages : tuple of pathlib.Path
        One page per student.
    archive : pathlib.Path or None
        The zip for the LMS; None without an LMS, or if the zip would be empty.
    skipped : tuple of str
        One sentence for each student without a page.
    unreached : tuple of str
        One sentence for each student with a page for whom the zip contains nothing.
    waiting : tuple of str
        Lessons with a part that a grader still has to grade, each with its students.
    lacks_zip : bool
        Whether a zip was expected but would be empty, although not all students are in teams.
    """

    pages: tuple[Path, ...]
    archive: Path | None
    skipped: tuple[str, ...]
    unreached: tuple[str, ...] = ()
    waiting: tuple[str, ...] = ()
    lacks_zip: bool = False


def write_feedback(
    course: Course,
    stage: str,
    students: Collection[str],
    folder: Path,
    platform: str | None,
    progress: Callable[[int, int, object], None],
    section: str = "",
) -> WrittenFeedback:
    """Write ``<folder>/<stage>/<student>.html``, and the zip for an LMS next to the stage's folder.

    Parameters
    ----------
    course : grader.course.paths.Course
    stage : str
    students : collection of str
        IDs of the students to include; empty for all.
    folder : pathlib.Path
        Created if it does not exist.
    platform : str or None
        One of `PLATFORMS`.
    progress : callable
        Called with (done, total, student) after each student.
    section : str, optional
        The section to which `students` belong. It becomes a part of the zip's name.

    Raises
    ------
    grader.course.roster.RosterError, grader.course.deadlines_file.DeadlinesError
    """
    collector = FeedbackCollector(course, stage)
    people = collector.people(students)
    all_feedback, pages = [], []
    unlisted = () if section else collector.unlisted_ids()
    skipped = [f"{id}: has marks but is not on the roster" for id in unlisted]
    for done, person in enumerate(people, start=1):
        try:
            feedback = collector.feedback(person)
        except FeedbackNotReady as reason:
            skipped.append(str(reason))
        else:
            path = folder / stage / f"{person.id}.html"
            write_atomically(feedback_page(feedback), path)
            all_feedback.append(feedback)
            pages.append(path)
        progress(done, len(people), person.id)
    waiting = tuple(_waiting_lessons(all_feedback))
    if not platform or not pages:
        return WrittenFeedback(tuple(pages), None, tuple(skipped), waiting=waiting)
    upload = PLATFORMS[platform].build_archive(course, stage, all_feedback)
    parts = [stage, platform, *[section_slug(section)] * bool(section)]
    archive = folder / f"{'_'.join(parts)}.zip" if upload.files else None
    if archive:
        write_atomically(make_zip(upload.files), archive)
    return WrittenFeedback(
        tuple(pages),
        archive,
        tuple(skipped),
        (*upload.skipped, *upload.teams),
        waiting,
        lacks_zip=archive is None and bool(upload.skipped),
    )


def _waiting_lessons(all_feedback: Sequence[Feedback]) -> Iterator[str]:
    """Yield the lessons with a part that a grader still has to grade, each with its students."""
    students_by_lesson: dict[str, list[str]] = {}
    for feedback in all_feedback:
        for lesson in feedback.lessons:
            if lesson.result.status == WAITING:
                students_by_lesson.setdefault(lesson.lesson.name, []).append(feedback.person.id)
    for lesson, ids in students_by_lesson.items():
        yield f"{lesson} for {', '.join(ids)}"


def _team_owners(sources: dict[str, dict[str, CollectedFile]]) -> set[str]:
    """Return the owners that are teams, because their files belong to several students."""
    owners = Counter(
        owner for files in sources.values() for owner in {file.owner for file in files.values()}
    )
    return {owner for owner, count in owners.items() if count > 1}


def _feedback_file(feedback: Feedback, lesson: LessonFeedback, file: str) -> bytes | None:
    """Build the feedback on one submitted file, in the format of the submitted file."""
    if file.lower().endswith(".zip"):
        return make_zip(
            {f"{feedback.result.stage}_feedback.html": feedback_page(feedback).encode()}
        )
    return feedback_notebook(feedback, lesson) if file.lower().endswith(".ipynb") else None
