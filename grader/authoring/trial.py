"""Try a lesson as its author: ``python -m grader try 14`` judges all that is kept with it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grader.course.kept_answers import KeptAnswer, MalformedAnswers, answers_to, fill_in
from grader.course.lessons import Exercise, Lesson
from grader.judging.judge import judge
from grader.judging.verdict import FAILED, ExerciseResult, Verdict
from grader.sandbox import Sandbox
from utils.checks import checks_of
from utils.checks.diagnosis import known_mistakes

SEEDS = (1, 2, 3)
FEWEST_CHECKS = 3


@dataclass(frozen=True)
class Finding:
    """Something that was tried, or looked for.

    Attributes
    ----------
    good : bool
    sentence : str
        What was found, and what to do if it is not good.
    """

    good: bool
    sentence: str


def try_lesson(lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    """Yield what is right, wrong or missing in a lesson that has been built.

    Parameters
    ----------
    lesson : grader.course.lessons.Lesson
    sandbox : grader.sandbox.Sandbox
        What runs the answers.
    """
    try:
        yield from _findings(lesson, sandbox)
    except MalformedAnswers as error:
        yield Finding(False, str(error))


def _findings(lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    if not lesson.machine_graded:
        yield Finding(True, "It has no exercise with points: there is nothing to judge.")
        return
    for exercise in lesson.machine_graded:
        yield from _what_is_missing(exercise, lesson)
    verdict = judge(lesson.solved, SEEDS[0], sandbox)
    if verdict.status == FAILED:
        reason = verdict.faults[0].strip().splitlines()[-1]
        yield Finding(False, f"The lesson cannot be judged: {reason}")
        return
    yield from _solution_and_stub(lesson, sandbox)
    for exercise in lesson.machine_graded:
        yield from _answers(exercise, lesson, sandbox)


def _solution_and_stub(lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    for seed in SEEDS:
        verdict = judge(lesson.solved, seed, sandbox)
        most = f"{verdict.max_score:g}"
        if verdict.score < verdict.max_score:
            yield Finding(
                False,
                f"The solution earns {verdict.score:g} of {most} points with seed {seed}. "
                f"{_first_failure(verdict)}",
            )
            return
    yield Finding(True, f"The solution earns {most} of {most} points with {len(SEEDS)} seeds.")
    score = judge(lesson.released, SEEDS[0], sandbox).score
    sentence = f"The untouched notebook earns {score:g} points."
    yield Finding(score == 0, sentence if score == 0 else f"{sentence} It should earn none.")


def _what_is_missing(exercise: Exercise, lesson: Lesson) -> Iterator[Finding]:
    name, count = exercise.name, len(checks_of(exercise.name))
    if count < FEWEST_CHECKS:
        yield Finding(
            False,
            f"{name} has {count} visible checks. Add an example for each property to "
            f"utils/checks/lesson_{lesson.number}.py, until there are {FEWEST_CHECKS}.",
        )
    hidden = lesson.tests.is_file() and f'"{name}"' in lesson.tests.read_text("utf-8")
    if not hidden:
        yield Finding(
            False, f"{name} has no hidden test. Write one in {lesson.name}/{lesson.tests.name}."
        )
    kinds = {answer.right for answer in _kept(name, lesson)}
    for kind, word in ((True, "right"), (False, "wrong")):
        if kind not in kinds:
            yield Finding(
                False,
                f"{name} has no {word} answer. Write one in {lesson.name}/answers/{name}.txt, as "
                "a student would.",
            )


def _answers(exercise: Exercise, lesson: Lesson, sandbox: Sandbox) -> Iterator[Finding]:
    for answer in _kept(exercise.name, lesson):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{lesson.name}.ipynb"
            path.write_text(fill_in(lesson, {exercise.name: answer.source}), "utf-8")
            verdict = judge(path, SEEDS[0], sandbox)
        broken = broken_claims(answer, verdict)
        (result,) = (one for one in verdict.exercises if one.name == exercise.name)
        kind = "right" if answer.right else "wrong"
        earned = f"{exercise.name}, {kind}: {answer.name}: {result.score:g} of {result.max_score:g}"
        yield Finding(not broken, f"{earned} points. {' '.join(broken)}".strip())


def _kept(exercise: str, lesson: Lesson) -> tuple[KeptAnswer, ...]:
    is_there = (lesson.folder / "answers" / f"{exercise}.txt").is_file()
    return answers_to(exercise) if is_there else ()


def broken_claims(answer: KeptAnswer, verdict: Verdict) -> list[str]:
    """Compare what a kept answer says about itself with a verdict on it.

    Parameters
    ----------
    answer : grader.course.kept_answers.KeptAnswer
    verdict : grader.judging.verdict.Verdict
        On a notebook with this answer to its exercise.

    Returns
    -------
    list of str
        A sentence for each claim that does not hold.
    """
    (result,) = (exercise for exercise in verdict.exercises if exercise.name == answer.exercise)
    failed = {test.name: test.message for test in result.tests if not test.passed}
    if answer.right:
        return [] if result.score == result.max_score else [f"It loses {_names(failed)}."]
    return [*_broken_losses(answer, result, failed), *_broken_words(answer, result, verdict)]


def _broken_losses(
    answer: KeptAnswer, result: ExerciseResult, failed: dict[str, str]
) -> Iterator[str]:
    if not answer.loses:
        yield "It does not say which checks it loses: add a line `# loses: ...`."
    for name in answer.loses:
        if not any(test.name.startswith(name) for test in result.tests):
            names = _names(test.name for test in result.tests)
            yield f"There is no check {name}. The checks are: {names}."
        elif not any(key.startswith(name) for key in failed):
            yield f"It passes {name}; it loses {_names(failed)}."
    others = [name for name in failed if not name.startswith(answer.loses)]
    if answer.loses_only and others:
        yield f"It also loses {_names(others)}."
    if result.score == result.max_score:
        yield "It earns everything, although it is wrong."


def _broken_words(answer: KeptAnswer, result: ExerciseResult, verdict: Verdict) -> Iterator[str]:
    messages = "\n".join([*(test.message for test in result.tests), *verdict.problems])
    if answer.says not in messages:
        yield f"No message says {answer.says!r}."
    shown = [
        mistake.says for mistake in known_mistakes(answer.exercise) if mistake.says in result.cause
    ]
    if len(shown) != bool(answer.told) or answer.told not in "".join(shown):
        wanted = f"the mistake {answer.told!r}" if answer.told else "no mistake"
        yield f"It should be shown {wanted}; it is shown {shown or 'none'}."


def _names(checks: object) -> str:
    return ", ".join(checks) or "no check"


def _first_failure(verdict: Verdict) -> str:
    for exercise in verdict.exercises:
        for test in exercise.tests:
            if not test.passed:
                return f"{exercise.name}, “{test.title}”: {test.message.splitlines()[0]}"
    return " ".join(verdict.problems)
