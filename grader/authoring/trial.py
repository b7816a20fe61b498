"""Try a lesson while writing it: ``python -m grader try 14`` judges its own answers."""

from __future__ import annotations

import re
import tempfile
import traceback
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import nbformat

from grader.course import recorded_answers
from grader.course.kept_answers import KeptAnswer, MalformedAnswers, answers_to, fill_in
from grader.course.lessons import Exercise, Lesson
from grader.course.notebook_runs import NotebookStopped, run_notebook
from grader.course.paths import PROJECT
from grader.judging.judge import judge
from grader.judging.verdict import FAILED, ExerciseResult, Verdict
from grader.sandbox import Sandbox
from utils.checks import checks_of
from utils.checks.diagnosis import known_mistakes

SEEDS = (1, 2, 3)
MIN_CHECKS = 3


@dataclass(frozen=True)
class Finding:
    """The result of one trial.

    Attributes
    ----------
    is_good : bool
    sentence : str
        The result and, if there is a problem, how to fix it. Lines after the first quote
        messages.
    """

    is_good: bool
    sentence: str


def try_lesson(lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    """Yield findings about a built lesson: what is right, wrong or missing.

    Stop after a problem that would cause most of the later ones.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    sandbox : grader.sandbox.Sandbox
    """
    try:
        yield from _missing_parts(lesson)
        if lesson.machine_graded:
            yield _judge_solution(lesson, sandbox)
        yield from _run_notebooks(lesson)
        if lesson.machine_graded:
            yield from _judge_answers(lesson, sandbox)
        else:
            yield Finding(True, "The lesson has no graded exercises, so there is nothing to judge.")
    except (_LessonUnusable, MalformedAnswers) as error:
        yield Finding(False, str(error))


class _LessonUnusable(Exception):
    """A file of the lesson cannot be used; `str()` is the sentence to show."""


def _missing_parts(lesson: Lesson) -> Iterator[Finding]:
    for exercise in lesson.machine_graded:
        yield from _missing_from_exercise(exercise, lesson)
    if lesson.machine_graded and not lesson.tests.is_file():
        raise _LessonUnusable(
            f"{lesson.tests.relative_to(PROJECT)} does not exist. Write the hidden tests there."
        )


def _judge_solution(lesson: Lesson, sandbox: Sandbox) -> Finding:
    for seed in SEEDS:
        verdict = judge(lesson.solved, seed, sandbox)
        if verdict.status == FAILED:
            raise _LessonUnusable(
                f"The lesson cannot be judged: {_describe_fault(verdict, lesson)}"
            )
        if verdict.score < verdict.max_score:
            raise _LessonUnusable(
                f"The solution earns {verdict.score:g} of {verdict.max_score:g} points with seed "
                f"{seed}. Correct the solution or the check.{_quote_failures(verdict)}"
            )
    points = f"{verdict.max_score:g} points"
    return Finding(True, f"The solution earns all {points} with {len(SEEDS)} seeds.")


def _run_notebooks(lesson: Lesson) -> Iterator[Finding]:
    """Run the solved and the released notebook, and update the stored answers."""
    try:
        recorded = recorded_answers.record(lesson)
    except recorded_answers.UnstorableAnswers as reason:
        raise _LessonUnusable(str(reason)) from None
    yield Finding(True, "The solved notebook runs to the end.")
    path = recorded_answers.answers_path(lesson)
    stored = path.read_bytes() if path.is_file() else b"{}"
    if lesson.machine_graded and recorded_answers.changed_answers(stored, recorded):
        path.write_bytes(recorded)
        yield Finding(
            True,
            "The results shown to students who have not written an answer were stored in "
            f"{path.relative_to(PROJECT)}.",
        )
    try:
        notebook = nbformat.read(lesson.released, as_version=4)
        run_notebook(notebook, lesson.released.parent, checks_may_fail=True)
        yield Finding(True, "The untouched notebook runs to the end.")
    except NotebookStopped as reason:
        yield Finding(False, f"The untouched notebook does not run to the end: {reason}")


def _judge_answers(lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    score = judge(lesson.released, SEEDS[0], sandbox).score
    sentence = f"The untouched notebook earns {score:g} points."
    yield Finding(score == 0, sentence if score == 0 else f"{sentence} It should earn 0.")
    for exercise in lesson.machine_graded:
        yield from _judge_kept_answers(exercise, lesson, sandbox)


def _missing_from_exercise(exercise: Exercise, lesson: Lesson) -> Iterator[Finding]:
    name, count = exercise.name, _count_checks(exercise.name)
    if count < MIN_CHECKS:
        yield Finding(
            False,
            f"Visible checks for {name}: {count}. Add one for each property in "
            f"utils/checks/lesson_{lesson.number}.py, until there are at least {MIN_CHECKS}.",
        )
    if lesson.tests.is_file() and f'"{name}"' not in lesson.tests.read_text("utf-8"):
        yield Finding(
            False, f"{name} has no hidden test. Write one in {lesson.name}/{lesson.tests.name}."
        )
    kinds = {answer.right for answer in _read_kept_answers(name, lesson)}
    for kind, word in ((True, "right"), (False, "wrong")):
        if kind not in kinds:
            yield Finding(
                False,
                f"{name} has no {word} answer. Write one in {lesson.name}/answers/{name}.txt, as "
                "a student would.",
            )


def _count_checks(exercise: str) -> int:
    """Count the visible checks; raise `_LessonUnusable` if their file cannot be imported."""
    try:
        return len(checks_of(exercise))
    except LookupError:
        return 0
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)
        places = [(frame.filename, frame.lineno) for frame in frames if _is_in_lesson_checks(frame)]
        if isinstance(error, SyntaxError):
            places.append((error.filename, error.lineno))
        where = "".join(f"{_path_in_project(path)}, line {line}: " for path, line in places[-1:])
        raise _LessonUnusable(f"{where}{type(error).__name__}: {error}") from None


def _is_in_lesson_checks(frame: traceback.FrameSummary) -> bool:
    return "/utils/checks/lesson_" in Path(frame.filename).as_posix()


def _path_in_project(path: str) -> str:
    return Path(path).as_posix().removeprefix(f"{PROJECT.as_posix()}/")


def _describe_fault(verdict: Verdict, lesson: Lesson) -> str:
    text = verdict.faults[0].strip()
    lines = re.findall(rf'{re.escape(lesson.tests.name)}(?:", line |:)(\d+)', text)
    reason = re.sub(r"^E\s+", "", text.splitlines()[-1])
    where = f"{lesson.tests.relative_to(PROJECT)}, line {lines[-1]}: " if lines else ""
    return where + reason


def _judge_kept_answers(exercise: Exercise, lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    for answer in _read_kept_answers(exercise.name, lesson):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{lesson.name}.ipynb"
            path.write_text(fill_in(lesson, {exercise.name: answer.source}), "utf-8")
            verdict = judge(path, SEEDS[0], sandbox)
        broken = note_mismatches(answer, verdict)
        (result,) = (judged for judged in verdict.exercises if judged.name == exercise.name)
        kind = "right" if answer.right else "wrong"
        earned = f"{exercise.name}, {kind}: {answer.name}: {result.score:g} of {result.max_score:g}"
        yield Finding(not broken, f"{earned} points. {' '.join(broken)}".strip())


def _read_kept_answers(exercise: str, lesson: Lesson) -> tuple[KeptAnswer, ...]:
    is_there = (lesson.folder / "answers" / f"{exercise}.txt").is_file()
    return answers_to(exercise) if is_there else ()


def note_mismatches(answer: KeptAnswer, verdict: Verdict) -> list[str]:
    """Compare the notes of a kept answer with a verdict on it.

    Parameters
    ----------
    answer : grader.course.kept_answers.KeptAnswer
    verdict : grader.judging.verdict.Verdict
        The verdict on a notebook with this answer.

    Returns
    -------
    list of str
        One sentence for each note that disagrees with the verdict.
    """
    (result,) = (exercise for exercise in verdict.exercises if exercise.name == answer.exercise)
    failed = {test.name: test.message for test in result.tests if not test.passed}
    if answer.right:
        return [] if result.score == result.max_score else [f"It fails {_join_names(failed)}."]
    return [*_loss_mismatches(answer, result, failed), *_quote_mismatches(answer, result, verdict)]


def _loss_mismatches(
    answer: KeptAnswer, result: ExerciseResult, failed: dict[str, str]
) -> Iterator[str]:
    if not answer.loses:
        yield "Its notes do not list the checks that it fails. Add a line `# loses: ...`."
    names, claimed = [test.name for test in result.tests], {*answer.loses}
    passed = claimed - _add_short_names(failed)
    others = [name for name in failed if not _add_short_names([name]) & claimed]
    if unknown := claimed - _add_short_names(names):
        checks = _join_names(names)
        yield f"There is no check {_join_names(sorted(unknown))}. The checks are: {checks}."
    elif passed or (answer.loses_only and others):
        yield f"It fails {_join_names(failed)}, but its notes list {_join_names(answer.loses)}."
    if result.score == result.max_score:
        yield "It is wrong, but earns all points."


def _quote_mismatches(
    answer: KeptAnswer, result: ExerciseResult, verdict: Verdict
) -> Iterator[str]:
    messages = "\n".join([*(test.message for test in result.tests), *verdict.problems])
    if answer.says not in messages:
        yield f"No message contains {answer.says!r}. The messages are: {_quote_messages(result)}"
    known = dict.fromkeys(mistake.description for mistake in known_mistakes(answer.exercise))
    shown = [sentence for sentence in known if sentence in result.cause]
    if len(shown) != bool(answer.told) or answer.told not in "".join(shown):
        wanted = f"the mistake {answer.told!r}" if answer.told else "no mistake"
        seen = " and ".join(map(repr, shown)) or "none"
        yield f"The student should see {wanted}, but sees {seen}."


def _add_short_names(tests: Iterable[str]) -> set[str]:
    """Return the names of tests. For parametrized tests, add the name without the case's ID."""
    return {form for name in tests for form in (name, name.partition("[")[0])}


def _join_names(checks: Iterable[str]) -> str:
    return ", ".join(checks) or "no check"


def _quote_messages(result: ExerciseResult) -> str:
    messages = dict.fromkeys(test.message for test in result.tests if not test.passed)
    return "\n".join(("", *messages)) if messages else "none."


def _quote_failures(verdict: Verdict) -> str:
    """Quote the problems in a verdict, or else the first failure of each exercise, one per line.

    Later failures of an exercise often have the same cause as the first, so they are left out.
    """
    lines = [*verdict.problems]
    for exercise in verdict.exercises:
        failed = [test for test in exercise.tests if not test.passed]
        if failed and not verdict.problems:
            lines.append(f"{exercise.name}, “{failed[0].title}”: {failed[0].message}")
            lines += [f"More failed checks: {len(failed) - 1}."] * (len(failed) > 1)
    return "".join(f"\n{line}" for line in lines)
