"""Enter verdicts into nbgrader's gradebook, each submission completely or not at all.

A submission is entered if the gradebook differs from its verdicts, for example after an interrupted
run, or if the due date or the points have changed. The comparison is repeated afterwards, and
remaining differences are reported. Only one process may write at a time.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence

import nbformat
from nbgrader.api import Gradebook, SubmittedNotebook
from nbgrader.preprocessors import AssignLatePenalties
from nbgrader.utils import compute_checksum, determine_grade
from sqlalchemy.orm import Session

from grader.classroom.folders import unmatched_folders
from grader.classroom.submissions import ReplacedSubmission, Submission
from grader.course.deadlines import Deadlines
from grader.course.deadlines_file import read_deadlines
from grader.course.paths import Course
from grader.course.roster import read_roster
from grader.judging.verdict import Verdict
from grader.lms.answer_fingerprints import (
    fingerprints,
    read_fingerprints,
    regrade,
    write_fingerprints,
)
from grader.lms.autograded_copy import build_judged_copy, graded_cells
from grader.lms.autograded_folder import replace_folder, write_draft
from grader.lms.differences import differences
from grader.lms.gradebook import database_problem, open_gradebook
from grader.lms.gradebook_dates import enter_due_dates, set_extension
from grader.lms.gradebook_students import enrol
from grader.lms.mark_history import log_changes
from grader.lms.mark_inputs import record_inputs
from grader.lms.marks_by_hand import lost_marks, lost_sentence, restore_marks, share_marks_in_teams
from grader.lms.penalties import load_late_penalties, penalty_of
from grader.lms.registration import register_stages
from grader.lms.stage_entries import StageEntry, group_entries
from grader.lms.submission_times import naive_submission_time
from grader.lms.withdrawal import withdraw
from grader.untrusted_text import one_line


class GradebookError(Exception):
    """The gradebook is not complete; the message is shown to the user."""


def enter_verdicts(
    course: Course,
    judged: Sequence[tuple[Submission, Verdict]],
    stages: Iterable[str],
    progress: Callable[[int, int, object], None],
    student: str | None = None,
    restore: bool = False,
    notify: Callable[[str], None] = print,
) -> None:
    """Update the gradebook to match the verdicts, and log the marks that changed.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (Submission, Verdict)
    stages : iterable of str
        Stages that were graded. In these stages, withdrawn submissions are removed.
    progress : callable
        Called with (done, total, student) after each student's stage.
    student : str, optional
        Enter only this student, and do not change the others.
    restore : bool
        Whether to restore manual marks and comments that are only in the log.
    notify : callable
        Called with a sentence about each change apart from entering scores.

    Raises
    ------
    GradebookError
        If some submissions could not be entered; all others are entered first.
    grader.course.roster.RosterError, grader.course.deadlines_file.DeadlinesError
    """
    roster, deadlines = read_roster(course), read_deadlines(course) or Deadlines({})
    unknown = unmatched_folders(course, roster) if roster else {}
    entries, trouble = group_entries(course, judged, unknown)
    with open_gradebook(course) as book:
        log_changes(course, book)  # log marks given by hand since the last run
        late_penalties = load_late_penalties(course)
        register_stages(course, book, dict.fromkeys(stages), notify)
        if roster:
            enrol(book, roster)
        enter_due_dates(course, book, deadlines)
        submitted = {(submission.student, submission.lesson.stage) for submission, _ in judged}
        trouble += withdraw(course, book, stages, submitted, student)
        for done, entry in enumerate(entries, start=1):
            problems = differences(course, book, entry, late_penalties, deadlines)
            if problems:
                problems = _try_to_enter(course, book, entry, late_penalties, deadlines)
                trouble += problems
            if not problems:
                record_inputs(course, entry, deadlines)
            progress(done, len(entries), entry.student)
        students = {student for student, _ in submitted}
        lost = lost_marks(course, book, students)
        restored = restore_marks(course, book, lost) if lost and restore else []
        entered = [*restored, *share_marks_in_teams(course, book, stages)]
        for sentence in entered:
            notify(sentence)
        if entered:
            for entry in entries:  # a late penalty depends on the marks by hand
                if differences(course, book, entry, late_penalties, deadlines):
                    trouble += _try_to_enter(course, book, entry, late_penalties, deadlines)
            lost = lost_marks(course, book, students)
        if lost:
            trouble.append(lost_sentence(course, lost))
        keys = {
            (submission.student, submission.lesson.name): verdict.key
            for submission, verdict in judged
        }
        log_changes(course, book, keys)
    if trouble:
        sentences = map(one_line, dict.fromkeys(trouble))  # they contain the names of folders
        raise GradebookError("The gradebook is not complete:\n" + "\n".join(sentences))


def _try_to_enter(
    course: Course,
    book: Gradebook,
    entry: StageEntry,
    late_penalties: AssignLatePenalties,
    deadlines: Deadlines,
) -> list[str]:
    """Enter one submission and return a sentence about each remaining problem."""
    try:
        trouble = _enter_submission(course, book, entry, late_penalties, deadlines)
    except ReplacedSubmission as replaced:  # the old marks stay until the new file is judged
        return [str(replaced)]
    except Exception as error:  # one student's failure must not stop the others
        if database_problem(error):
            raise
        trouble = [f"{entry.name}: {type(error).__name__}: {error}"]
    return trouble + differences(course, book, entry, late_penalties, deadlines)


def _enter_submission(
    course: Course,
    book: Gradebook,
    entry: StageEntry,
    late_penalties: AssignLatePenalties,
    deadlines: Deadlines,
) -> list[str]:
    """Enter one submission: write its files to a draft, update the gradebook, move the draft.

    Returns
    -------
    list of str
        One sentence for each copy that does not show the student's work.
    """
    copies, modules, problems = {}, {}, []
    for submission, verdict in entry.judged:
        submitted_files = submission.read_again(course, verdict.fingerprint)
        copy, complaint = build_judged_copy(submitted_files, submission.lesson, verdict)
        copies[submission.lesson.name] = copy
        if complaint:
            problems.append(
                f"{entry.name}: the points were entered, but the copy in autograded/ does not show "
                f"the student's work. {complaint}"
            )
        for name, source in submitted_files.modules.items():
            path = submission.path.with_name(f"{name}.py").relative_to(
                submission.stage_folder(course)
            )
            modules[path] = source.encode()
    folder = course.autograded / entry.student / entry.stage
    draft = folder.with_name(f".{folder.name}.part")
    write_draft(course, entry, copies, modules, draft)
    old_answers = read_fingerprints(course, entry.student, entry.stage)
    answers = {name: fingerprints(copy) for name, copy in copies.items()}
    times = entry.lesson_times(deadlines)
    with _one_transaction(book):
        book.update_or_create_student(entry.student)
        submission = book.update_or_create_submission(
            entry.stage, entry.student, timestamp=naive_submission_time(entry.folders(course))
        )
        set_extension(course, submission, deadlines)
        for notebook in submission.notebooks:
            copy = copies.get(notebook.name)
            if copy is None:
                _enter_as_missing(notebook)
            else:
                previous = old_answers.get(notebook.name, {})
                _save(notebook, copy, previous, answers[notebook.name])
        book.db.flush()
        book.db.expire_all()  # reload the sums, which the database computes
        for notebook in submission.notebooks:
            penalty = penalty_of(submission, notebook, late_penalties, deadlines, times)
            notebook.late_submission_penalty = penalty
    replace_folder(draft, folder)
    write_fingerprints(course, entry.student, entry.stage, answers)
    return problems


def _save(
    notebook: SubmittedNotebook,
    autograded_copy: nbformat.NotebookNode,
    old_fingerprints: dict[str, str],
    new_fingerprints: dict[str, str],
) -> None:
    """Save the scores in the cells of a copy, like nbgrader's SaveAutoGrades."""
    cells = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(autograded_copy)}
    for grade in notebook.grades:
        score, _ = determine_grade(cells[grade.name])
        regrade(grade, score, old_fingerprints.get(grade.name) == new_fingerprints.get(grade.name))
    for comment in notebook.comments:
        cell = cells[comment.name]
        untouched = cell.metadata.nbgrader.get("checksum") == compute_checksum(cell)
        comment.auto_comment = "No response." if untouched else None


def _enter_as_missing(notebook: SubmittedNotebook) -> None:
    for grade in notebook.grades:
        grade.auto_score, grade.needs_manual_grade = 0.0, False


@contextlib.contextmanager
def _one_transaction(book: Gradebook) -> Iterator[None]:
    """Combine nbgrader's separate commits into one final commit; after an error, roll back."""
    session: Session = book.db()
    commit, session.commit = session.commit, session.flush
    try:
        yield
        commit()
    except BaseException:
        session.rollback()
        raise
    finally:
        del session.commit
