"""Output on the terminal, such as progress, verdicts and the scores of a class."""

from __future__ import annotations

import contextlib
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from grader.judging.verdict import FAILED

if TYPE_CHECKING:
    from grader.classroom.collect.collection_report import CollectionReport, Question
    from grader.classroom.doctor import Finding
    from grader.classroom.similarity.stage import StageComparison
    from grader.classroom.submissions import Submission
    from grader.course.lessons import Lesson
    from grader.judging.verdict import Verdict
    from grader.lms.exporters import ExportResult
    from grader.lms.feedback_archives import WrittenFeedback
    from grader.lms.mark_history import MarkChange
    from grader.lms.results import ClassResults, NotebookResult
    from grader.sandbox import Sandbox


LEGEND = {
    "-": "- nothing submitted",
    "ex": "ex excused",
    "aud": "aud auditor",
    "*": "* waiting for a grader",
    "?": "? not entered yet",
}


# Finished items before the first estimate. Items run in parallel, so one alone is misleading.
MIN_FINISHED = 3
MIN_SECONDS_SHOWN = 60.0


@contextlib.contextmanager
def progress_bar(title: str) -> Iterator[Callable[[int, int, object], None]]:
    """Show a progress bar on stderr; yield a function that updates it with (done, total, item).

    Until the total is known, `item` is a sentence about the work. The bar appears only when work
    begins, so an earlier error does not look like an interruption. The bar shows an estimate of the
    remaining time. If the work is long, the first estimate is also printed, because a log does not
    contain the bar.
    """
    columns = (
        TextColumn("{task.description}", markup=False),  # a folder's name may contain brackets
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
    )
    title = printable_text(title)
    progress = Progress(*columns, console=Console(stderr=True))
    task = progress.add_task(title, total=None, left="")
    estimate = RemainingTime()

    def advance(done: int, total: int, item: object) -> None:
        text = printable_text(f"{title}: {item}" if isinstance(item, str) and item else title)
        is_first = estimate.seconds is None
        estimate.update(done, total)
        progress.update(
            task, completed=done, total=total, description=text, left=estimate.describe()
        )
        if total or text != title:
            progress.start()
        if is_first and (estimate.seconds or 0) >= MIN_SECONDS_SHOWN:
            print_notice(f"{title}: {estimate.describe()}, estimated after {done} of {total}.")

    try:
        yield advance
    finally:
        if progress.live.is_started:
            progress.stop()


class RemainingTime:
    """Estimates the remaining time of a task from the items that were finished in this run.

    Parameters
    ----------
    clock : callable, optional
        Returns the current time in seconds.

    Attributes
    ----------
    seconds : float or None
        None until enough items are finished.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.seconds: float | None = None
        self._clock = clock
        self._start: tuple[float, int] | None = None

    def update(self, done: int, total: int) -> None:
        """Record that `done` of `total` items are finished; the first call starts the clock."""
        if not total:
            return
        now = self._clock()
        start_time, first_done = self._start = self._start or (now, done)
        finished = done - first_done
        if finished >= MIN_FINISHED:
            self.seconds = (now - start_time) / finished * (total - done)

    def describe(self) -> str:
        """Return a phrase such as "about 13 minutes left", or nothing for a short time."""
        if self.seconds is None or self.seconds < MIN_SECONDS_SHOWN:
            return ""
        minutes = round(self.seconds / 60)
        return f"about {minutes} minute{'s' * (minutes != 1)} left"


def printable_text(text: object) -> str:
    """Replace the unprintable characters in a text, such as those in an unusual file name.

    A line break is replaced as well, because a second line could look like a sentence of the
    grader. Spaces stay as they are, so that a file name can be copied from the terminal.
    """
    return "".join(c if c.isprintable() else "\ufffd" for c in str(text))


def printable_lines(text: object) -> str:
    """Replace the unprintable characters in a text of the grader, but keep its line breaks."""
    return "\n".join(map(printable_text, str(text).split("\n")))


def print_notice(sentence: str) -> None:
    """Print a sentence on stderr, above the progress bar if there is one."""
    print(printable_text(sentence), file=sys.stderr)


def warn_if_unprotected(sandbox: Sandbox) -> None:
    """Print a warning if the sandbox does not protect this machine."""
    if sandbox.warning:
        Console(stderr=True).print(sandbox.warning, style="bold red", highlight=False)


def print_verdict(verdict: Verdict, excluded: Collection[str] = ()) -> None:
    """Print one verdict in readable form; exercises in `excluded` do not count."""
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    for sentence in verdict.problems:
        console.print(f"! {printable_text(sentence)}", markup=False)
    if verdict.status == FAILED:
        for line in "\n".join(verdict.faults).splitlines():
            _print_with_mark(console, "", line, "dim")
        console.print(f"\n{verdict.lesson}: not judged", style="bold", markup=False)
        return
    for exercise in verdict.exercises:
        remark = " (switched off: does not count)" if exercise.name in excluded else ""
        console.print(
            f"\n{exercise.name}: {exercise.score:g} of {exercise.max_score:g} points{remark}",
            style="bold",
            markup=False,
        )
        for test in exercise.tests:
            _print_with_mark(console, "passed" if test.passed else "FAILED", test.title)
            for line in test.message.splitlines():
                _print_with_mark(console, "", line, "dim")
        if exercise.slip:
            points_kept = f"+{exercise.slip.score:g}" if exercise.slip.score else ""
            _print_with_mark(console, points_kept, exercise.slip.sentence)
    points, maximum = verdict.points_without(excluded)
    console.print(
        f"\n{verdict.lesson}: {points:g} of {maximum:g} points ({verdict.seconds:.1f} s)",
        style="bold",
        markup=False,
    )


def _print_with_mark(console: Console, mark: str, text: str, style: str = "") -> None:
    """Print a mark and a text side by side, with all lines of the text equally indented."""
    grid = Table.grid(padding=(0, 2, 0, 0))
    grid.add_column(no_wrap=True, width=8)
    grid.add_row(Text(f"  {mark}"), Text(printable_text(text), style))
    console.print(grid)


def print_finding(finding: Finding) -> None:
    """Print one finding of the command ``doctor``."""
    mark = "ok   " if finding.is_good else "FIX  "
    style = "" if finding.is_good else "bold red"
    text = f"{mark} {finding.subject}: {printable_lines(finding.text)}"
    Console(highlight=False, soft_wrap=True).print(text, markup=False, style=style)


def print_class(
    judged: Sequence[tuple[Submission, Verdict]], results: ClassResults | None = None
) -> None:
    """Print one row per student, with marks from the gradebook or else scores from verdicts."""
    stages = {submission.lesson.stage for submission, _ in judged}
    lessons = sorted({verdict.lesson for _, verdict in judged})
    if results and results.notebooks:
        marked = [result for result in results.notebooks if result.stage in stages]
        lessons = sorted({result.lesson for result in marked})
    students = {person.id: {} for person in results.people} if results else {}
    enrolled = set(students)
    for submission, verdict in judged:
        students.setdefault(submission.student, {})[verdict.lesson] = verdict
    late = _late_texts(results, stages)
    table = Table(
        title="Scores by lesson",
        title_justify="left",
        box=SIMPLE_HEAD,
        show_footer=True,
        padding=(0, 1, 0, 0),
        expand=True,
    )
    table.add_column("Student", "out of", overflow="fold", min_width=14, max_width=30)
    for lesson in lessons:
        scores = [verdict.max_score for _, verdict in judged if verdict.lesson == lesson]
        max_score = (
            results.lessons[lesson] if results and lesson in results.lessons else max(scores)
        )
        table.add_column(lesson[:2], f"{max_score:g}", justify="right", no_wrap=True, min_width=5)
    if late:
        table.add_column("Late", no_wrap=True)
    table.add_column("First problem", no_wrap=True, ratio=1)
    cells = []
    for student, verdicts in students.items():
        if student in enrolled:
            scores = [_mark_text(results.notebook(student, lesson)) for lesson in lessons]
            first_fault = _first_fault(verdicts.values(), results)
        else:
            scores = [_score_text(verdicts.get(lesson), results) for lesson in lessons]
            first_fault = "not on the roster, so no mark was entered" if results else ""
            first_fault = first_fault or _first_fault(verdicts.values(), results)
        cells += scores
        lateness = (late.get(student, ""),) if late else ()
        table.add_row(escape(printable_text(student)), *scores, *lateness, first_fault)
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    console.print(table)
    legend = [text for sign, text in LEGEND.items() if any(sign in cell for cell in cells)]
    if legend and results:
        console.print(" · ".join(legend), markup=False, style="dim")


def print_term(notebooks: Sequence[NotebookResult], total: str) -> None:
    """Print a student's results in all lessons of the term, and a sentence about the total."""
    from grader.lms.marks_table import format_duration
    from grader.lms.results import format_points

    table = Table(title="The term so far", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("Lesson", no_wrap=True)
    for heading in ("Points", "Of", "Penalty", "Late"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("Status")
    for result in notebooks:
        table.add_row(
            result.lesson,
            "-" if result.score is None else format_points(result.score),
            f"{result.max_score:g}",
            f"-{format_points(result.penalty)}" if result.penalty else "",
            format_duration(result.late) if result.late else "",
            result.status,
        )
    Console(highlight=False, width=None if sys.stdout.isatty() else 120).print(table)
    print(f"Total: {total}")


def print_history(changes: Sequence[MarkChange]) -> None:
    """Print the history of a student's marks."""
    table = Table(title="Changed marks", title_justify="left", box=SIMPLE_HEAD)
    for heading in ("Recorded", "Lesson", "Exercise"):
        table.add_column(heading, no_wrap=True)
    for heading in ("From", "To"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("By")
    for change in changes:
        when = datetime.fromisoformat(change.when).astimezone()
        marks = ("-" if mark is None else f"{mark:.4g}" for mark in (change.before, change.after))
        by, _, key = (
            change.by.partition(" ") if change.by.startswith("verdict") else (change.by, "", "")
        )
        cells = (change.lesson, change.exercise, *marks, f"{by} {key[:8]}".strip())
        table.add_row(f"{when:%Y-%m-%d %H:%M}", *(escape(printable_text(cell)) for cell in cells))
    Console(highlight=False, width=None if sys.stdout.isatty() else 120).print(table)


def print_similarity(compared: StageComparison, limit: int = 10) -> None:
    """Print the similar answers in a stage, most unusual first."""
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    for same in compared.shared_notebooks:
        sameness = "identical files" if same.same_bytes else "identical cells"
        console.print(
            printable_text(f"{same.lesson}, {sameness}: {', '.join(same.students)}"), markup=False
        )
    pairs = compared.pairs
    if not pairs:
        console.print("No two answers are similar enough to be listed.")
        return
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("Students")
    table.add_column("Unusual code in both")
    table.add_column("Highest share with a third answer", justify="right")
    for pair in pairs[:limit]:
        table.add_row(
            escape(printable_text(" and ".join(pair.students))),
            "\n".join(f"{answers.exercise} {answers.share:.0%}" for answers in pair.pairs),
            "\n".join(f"{answers.nearest_shares[0]:.0%}" for answers in pair.pairs),
        )
    console.print(table)
    if len(pairs) > limit:
        console.print(f"Similar pairs that are not shown: {len(pairs) - limit}.")
    console.print("The last column compares the two answers with those of all other students.")
    console.print("The table shows which answers are similar, but not why. Ask the students.")


def print_unaccounted(files: Sequence[tuple[Path, str]], limit: int = 20) -> None:
    """Print the files that were not judged, and why."""
    if not files:
        return
    lines = [f"{len(files)} files were not judged:" if len(files) > 1 else "1 file was not judged:"]
    lines += [
        f"  {printable_text(path)}: {printable_text(reason)}" for path, reason in files[:limit]
    ]
    if len(files) > limit:
        lines.append(f"  and {len(files) - limit} more; the report lists all of them")
    Console(highlight=False, soft_wrap=True).print("\n".join(lines), markup=False)


def print_notes(sentences: Sequence[str]) -> None:
    """Print notes that need the instructor's attention."""
    for sentence in sentences:
        Console(highlight=False, soft_wrap=True).print(
            f"! {printable_text(sentence)}", markup=False
        )


def print_exported(exported: ExportResult, path: Path, backup: Path | None, next_step: str) -> None:
    """Print a summary of an exported file: its marks, missing marks, and the next step."""
    students = f"{exported.mark_count} student{'s' * (exported.mark_count != 1)}"
    lines = [f"{printable_text(path)} contains marks for {students}."]
    if backup:
        lines.append(f"The previous file was renamed to {printable_text(backup.name)}.")
    lines += [printable_text(note) for note in exported.notes]
    Console(highlight=False, soft_wrap=True).print("\n".join(lines), markup=False)
    if exported.failures:
        title = f"Marks that could not be exported: {len(exported.failures)}"
        text = "\n  ".join([title, *map(printable_text, exported.failures)])
        Console(highlight=False, soft_wrap=True, stderr=True).print(
            text, markup=False, style="bold red"
        )
    if next_step:
        print(next_step)


def print_autograder(
    path: Path, lessons: Sequence[Lesson], uncounted_items: Sequence[str] = ()
) -> None:
    """Print which lessons an autograder judges, and how to upload it."""
    exercises = [exercise for lesson in lessons for exercise in lesson.exercises]
    machine = sum(exercise.points for exercise in exercises if not exercise.by_hand)
    by_hand = [exercise for exercise in exercises if exercise.by_hand]
    lines = [
        f"{printable_text(path)} judges {', '.join(lesson.name for lesson in lessons)}.",
        f"In Gradescope, create a programming assignment with Autograder Points: {machine:g}. "
        "Upload the zip under Configure Autograder. Then submit the course's solutions under Test "
        "Autograder.",
        "Students may use the container's version of Python or an older one. On Ubuntu 24.04, "
        "this is Python 3.12. Code that needs a newer Python gets no mark.",
        "The zip contains the course's secret seed and hidden tests. Do not give it to students.",
    ]
    if by_hand:
        names = ", ".join(f"{exercise.name} ({exercise.points:g} points)" for exercise in by_hand)
        lines.insert(2, f"Grade by hand in Gradescope: {names}.")
    if uncounted_items:
        lines.append(
            "This autograder also gives points for lessons or exercises that do not count "
            f"according to deadlines.toml: {', '.join(uncounted_items)}. To leave them out, grade "
            "on this machine, and run: python -m grader export --format gradescope"
        )
    Console(highlight=False, soft_wrap=True).print("\n".join(lines), markup=False)


def print_feedback(feedback: Sequence[WrittenFeedback]) -> None:
    """Print where feedback was written, and which feedback was left out."""
    for item in feedback:
        if item.pages:
            count = f"{len(item.pages)} page{'s' * (len(item.pages) > 1)}"
            zipped = f", and {printable_text(item.archive)} for upload" if item.archive else ""
            text = f"{printable_text(item.pages[0].parent)}: {count}{zipped}"
            Console(highlight=False, soft_wrap=True).print(text, markup=False)
    lists = (
        ("Not final, because some answers still have to be graded by hand:", "waiting"),
        ("Not in the zip. Give these students their pages yourself:", "unreached"),
    )
    for title, name in lists:
        sentences = [sentence for item in feedback for sentence in getattr(item, name)]
        if sentences:
            text = "\n  ".join([title, *map(printable_text, sentences)])
            Console(highlight=False, soft_wrap=True).print(text, markup=False)
    skipped = [sentence for item in feedback for sentence in item.skipped]
    if skipped:
        text = "\n  ".join(["No feedback was written for:", *map(printable_text, skipped)])
        Console(highlight=False, soft_wrap=True, stderr=True).print(
            text, markup=False, style="bold red"
        )


def print_collected(report: CollectionReport) -> None:
    """Print the result of collecting, and the files that need a decision."""
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    for path, kind, count in report.archives:
        console.print(
            f"{printable_text(path)}: {kind}, {count} file{'s' * (count != 1)}", markup=False
        )
    if report.states:
        console.print(_collected_table(report))
    for sentence in _collection_sentences(report):
        console.print(printable_text(sentence), markup=False, soft_wrap=True)
    _print_questions(console, "For your information", report.remarks)
    _print_questions(console, "Collected, but the owner is uncertain", report.doubts)
    _print_questions(console, "Not collected until you decide", report.questions)
    if any("/" in question.name for question in report.questions):
        console.print(
            "\nTo ignore one of these files from now on, add --who 'FILE=-'.", markup=False
        )


def _collected_table(report: CollectionReport) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("Student", no_wrap=True)
    for lesson in report.lessons:
        table.add_column(lesson.number, no_wrap=True)
    table.add_column("Submitted" if report.late_students or report.undecided else "")
    for student, states in report.states.items():
        is_late = student in report.late_students
        when = "unknown" if student in report.undecided else "late" if is_late else ""
        table.add_row(
            escape(printable_text(student)),
            *(states.get(lesson, "-") for lesson in report.lessons),
            escape(printable_text(when)),
        )
    return table


def _collection_sentences(report: CollectionReport) -> Iterator[str]:
    counts = Counter(state for states in report.states.values() for state in states.values())
    state_texts = (
        ("new", "new"),
        ("newer", "newer than the previous version, which is kept in .older/"),
        ("same", "unchanged"),
        ("kept", "left out, because a newer version, or one with work, was already collected"),
    )
    counted = [f"{counts[state]} {text}" for state, text in state_texts if counts[state]]
    yield f"Notebooks: {'; '.join(counted) or 'none'}."
    if report.roster is None:
        yield (
            "There is no roster.csv, so the folders are named as in the archive. Add a roster to "
            "match students by name or number."
        )
    else:
        submitters = {*report.states, *report.earlier_students}
        absent = [person for person in report.roster.people if person.id not in submitters]
        auditors = [person.id for person in absent if person.is_auditor]
        students = [person.id for person in absent if not person.is_auditor]
        excused = [student for student in students if student in report.excused_students]
        missing = [student for student in students if student not in report.excused_students]
        if missing:
            yield (
                f"Students on the roster without a submission: {len(missing)} "
                f"({', '.join(missing)})."
            )
        if excused:
            yield f"Excused students without a submission: {', '.join(excused)}."
        if auditors:
            yield f"Auditors without a submission: {', '.join(auditors)}."
    if report.ignored:
        some = ", ".join(list(report.ignored)[:5]) + (", …" if len(report.ignored) > 5 else "")
        yield f"Files that no lesson needs were not collected: {some}."
    if report.students_with_time is not None:
        collected = sum(map(bool, report.states.values()))
        yield (
            "The table contains submission times for "
            f"{len(report.students_with_time)} of the {collected} students with notebooks."
        )
    students_by_reason: dict[str, list[str]] = {}
    for student, reason in report.undecided.items():
        students_by_reason.setdefault(reason, []).append(student)
    for reason, students in students_by_reason.items():
        yield (
            f"It is unknown whether these students submitted late: {', '.join(students)}. "
            f"Reason: {reason}."
        )
    if report.undecided:
        yield (
            "Write each missing time, such as 2026-11-22 18:30:00 UTC, into timestamp.txt in the "
            "student's folder."
        )
    if report.late_students:
        yield (
            f"Late, but without a submission time: {', '.join(report.late_students)}. No penalty "
            "is subtracted until the time is known. Add times with --timestamps FILE, or write "
            "each "
            "time, such as 2026-11-22 18:30:00 UTC, into timestamp.txt in the student's folder."
        )


def _print_questions(console: Console, title: str, questions: Sequence[Question]) -> None:
    if not questions:
        return
    console.print(f"\n{title}:", style="bold", markup=False)
    for question in questions:
        console.print(
            f"  {printable_text(question.name)}\n      {printable_text(question.text)}.",
            markup=False,
            soft_wrap=True,
        )


def _late_texts(results: ClassResults | None, stages: Collection[str]) -> dict[str, str]:
    """Return how late each student's work is and the penalty, or "time unknown".

    If there are several stages, the texts name the stage: ``stage3 1 d 9 h -18``.
    """
    from grader.lms.marks_table import format_duration
    from grader.lms.results import rounded_points

    late = {}
    for result in results.stages if results else ():
        if result.stage in stages and (result.late or result.undecided):
            penalty = f" -{rounded_points(result.penalty)}" if result.penalty else ""
            prefix = f"{result.stage.partition('_')[0]} " if len(stages) > 1 else ""
            text = f"{format_duration(result.late)}{penalty}" if result.late else "time unknown"
            late.setdefault(result.student, []).append(prefix + text)
    return {student: ", ".join(texts) for student, texts in late.items()}


def _mark_text(result: NotebookResult) -> str:
    """Return a student's mark for a lesson, or a sign that `LEGEND` explains."""
    from grader.lms.results import rounded_points

    signs = {"missing": "-", "excused": "ex", "auditor": "aud"}
    if result.status in signs:
        return signs[result.status]
    if result.score is None:
        return "?"
    return f"{rounded_points(result.score)}{'*' * (result.status == 'waiting')}"


def _score_text(verdict: Verdict | None, results: ClassResults | None) -> str:
    from grader.lms.results import rounded_points

    if verdict is None:
        return "-"
    points = results.judged_points(verdict) if results else verdict.score
    return rounded_points(points) if verdict.status == "judged" else "?"


def _first_fault(verdicts: Iterable[Verdict], results: ClassResults | None) -> str:
    excluded = results.rules.excluded_exercises if results else ()
    faults = [
        cause if exercise.name in cause else f"{exercise.name}: {cause}"
        for verdict in verdicts
        for exercise in verdict.exercises
        if exercise.name not in excluded
        for cause in exercise.cause.splitlines()[:1]
    ]
    problems = [
        sentence
        for verdict in verdicts
        if not any(exercise.tests for exercise in verdict.exercises)
        for sentence in verdict.problems
    ]
    return escape(printable_text(next(iter(problems + faults), "")))
