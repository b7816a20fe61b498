"""Feedback of many students in one zip, named so that a learning platform gives each their own.

Both platforms go by the names of what was handed in, which `collect` keeps beside the work.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.classroom.collect.record import read_record
from grader.classroom.submissions import find_submissions
from grader.course.archives import zipped
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.lms.feedback import Feedback, FeedbackWriter, LessonFeedback, NotReady
from grader.lms.feedback_notebook import feedback_notebook
from grader.lms.feedback_page import feedback_page

# How `Source.archive` ends: the owner as the archive calls them, and the file that they handed in.
_HANDED = re.compile(r": (?P<owner>[^/:]+)/(?P<file>[^/]+)(?:/.*)?$")
_TEAM = "handed in as {}, which may be a team: give each of them their own page"


@dataclass(frozen=True)
class Returned:
    """What a platform is given.

    Attributes
    ----------
    files : dict of str to bytes
        By name.
    left : tuple of str
        A sentence on each student who gets nothing by it.
    """

    files: dict[str, bytes] = field(default_factory=dict)
    left: tuple[str, ...] = ()


def for_moodle(course: Course, stage: str, all_feedback: Sequence[Feedback]) -> Returned:
    """A page for each, for *Upload multiple feedback files in a zip*.

    Moodle finds the participant by the number in ``{name}_{number}_assignsubmission_file_{file}``.
    A team has a number of its own, which as a participant's would be somebody else's. In each
    assignment a person has another number; who handed in to several gets a page for each, and
    Moodle passes over those of the others.
    """
    sources, roster = _sources(course, stage), read_roster(course)
    shared = _shared(sources)
    files, left = {}, []
    for feedback in all_feedback:
        person = feedback.person
        handed = [one for one in sources.get(person.id, {}).values() if one.participant]
        if not handed:
            left.append(f"{person.id}: their work was not collected from a zip of Moodle's")
            continue
        for owner, number in sorted({(one.owner, one.participant) for one in handed}):
            name = owner.removesuffix(f"_{number}")
            named = roster is None or person in roster.like(name) or name.endswith(number)
            if owner in shared or not named:
                left.append(f"{person.id}: {_TEAM.format(name)}")
                continue
            path = f"{owner}_assignsubmission_file_{stage}_feedback.html"
            files[path] = feedback_page(feedback).encode()
    return Returned(files, tuple(left))


def for_canvas(course: Course, stage: str, all_feedback: Sequence[Feedback]) -> Returned:
    """A notebook for each that was handed in, for *Upload Submissions*.

    Canvas finds the file that is answered by ``{name}_{user id}_{attachment id}_{file}``, and calls
    the answer like that file. Who handed in a zip gets a zip, with the page.
    """
    sources = _sources(course, stage)
    shared = _shared(sources)
    files, left = {}, []
    for feedback in all_feedback:
        id, lessons = (
            feedback.person.id,
            {lesson.lesson.name: lesson for lesson in feedback.lessons},
        )
        mine = {name: one for name, one in sources.get(id, {}).items() if one.attachment}
        team = {one.owner for one in mine.values()} & shared
        answers = {
            f"{one.owner}_{one.attachment}_{one.file}": answer
            for name, one in mine.items()
            if not team and (answer := _answer(feedback, lessons[name], one.file))
        }
        files |= answers
        if team:
            left.append(f"{id}: {_TEAM.format(min(team))}")
        elif not answers:
            left.append(f"{id}: no notebook of theirs was collected from a zip of Canvas's")
    return Returned(files, tuple(left))


@dataclass(frozen=True)
class Platform:
    """Where feedback is handed back to.

    Attributes
    ----------
    returns : callable
        From course, stage and feedback to `Returned`.
    next_step : str
        What to do with the zip.
    """

    returns: Callable[[Course, str, Sequence[Feedback]], Returned]
    next_step: str


PLATFORMS = {
    "moodle": Platform(
        for_moodle,
        "In Moodle: the assignment's Submissions, Actions, Upload multiple feedback files in a "
        "zip; where lessons of the stage are assignments of their own, in each of them. It is "
        "offered where the assignment's feedback types include feedback files.",
    ),
    "canvas": Platform(
        for_canvas,
        "In Canvas: Grades, the assignment's menu, Upload Submissions. It is offered after "
        "Download Submissions. Each file becomes an attachment to a comment.",
    ),
}


@dataclass(frozen=True)
class Written:
    """What came of handing back a stage.

    Attributes
    ----------
    pages : tuple of pathlib.Path
        One for each student.
    archive : pathlib.Path or None
        The zip for a learning platform; None where nobody would get anything by it.
    left : tuple of str
        A sentence on each student who has no page, or is not in the zip.
    """

    pages: tuple[Path, ...]
    archive: Path | None
    left: tuple[str, ...]


def write_feedback(
    course: Course,
    stage: str,
    students: Collection[str],
    folder: Path,
    platform: str | None,
    progress: Callable[[int, int, object], None],
) -> Written:
    """Write ``<folder>/<stage>/<student>.html``, and the zip of a platform beside the stage.

    Parameters
    ----------
    course : grader.course.paths.Course
    stage : str
    students : collection of str
        Only for them; for all where it is empty.
    folder : pathlib.Path
        Made where there is none.
    platform : str or None
        One of `PLATFORMS`.
    progress : callable
        Called with (done, total, student) after each page.

    Raises
    ------
    grader.course.roster.RosterTrouble, grader.course.deadlines.DeadlinesTrouble
    """
    writer = FeedbackWriter(course, stage)
    people = writer.people(students)
    all_feedback, pages = [], []
    left = [f"{id}: has marks, and is not on the roster" for id in writer.strangers()]
    for done, person in enumerate(people, start=1):
        try:
            feedback = writer.feedback(person)
        except NotReady as reason:
            left.append(str(reason))
        else:
            path = folder / stage / f"{person.id}.html"
            write_atomically(feedback_page(feedback), path)
            all_feedback.append(feedback)
            pages.append(path)
        progress(done, len(people), person.id)
    if not platform or not pages:
        return Written(tuple(pages), None, tuple(left))
    returned = PLATFORMS[platform].returns(course, stage, all_feedback)
    archive = folder / f"{stage}_{platform}.zip" if returned.files else None
    if archive:
        write_atomically(zipped(returned.files), archive)
    return Written(tuple(pages), archive, (*left, *returned.left))


@dataclass(frozen=True)
class _Handed:
    """How a learning platform calls a file that somebody handed in.

    Attributes
    ----------
    owner, file : str
    attachment : int
        Canvas's number of it; 0 elsewhere.
    participant : str
        Moodle's number of whose it is; empty elsewhere.
    """

    owner: str
    file: str
    attachment: int
    participant: str


def _sources(course: Course, stage: str) -> dict[str, dict[str, _Handed]]:
    """Where the files that count came from, by student and lesson."""
    found: dict[str, dict[str, _Handed]] = {}
    for submission in find_submissions(course, [stage]):
        source = read_record(submission.place(course)).files.get(submission.path.name)
        match = source and _HANDED.search(source.archive)
        if match:
            handed = _Handed(match["owner"], match["file"], source.order, source.participant)
            found.setdefault(submission.student, {})[submission.lesson.name] = handed
    return found


def _shared(sources: dict[str, dict[str, _Handed]]) -> set[str]:
    """Owners of whom more than one student has work: teams."""
    owners = Counter(
        owner for mine in sources.values() for owner in {one.owner for one in mine.values()}
    )
    return {owner for owner, count in owners.items() if count > 1}


def _answer(feedback: Feedback, lesson: LessonFeedback, file: str) -> bytes | None:
    """What is handed back for a file: something that opens under its name."""
    if file.lower().endswith(".zip"):
        return zipped({f"{feedback.result.stage}_feedback.html": feedback_page(feedback).encode()})
    return feedback_notebook(feedback, lesson) if file.lower().endswith(".ipynb") else None
