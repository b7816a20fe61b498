"""Write the page that shows similar answers side by side, for a person to compare."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from grader.classroom.pages import render
from grader.classroom.similarity.answers import ComparedAnswer
from grader.classroom.similarity.comparison import Pair
from grader.classroom.similarity.stage import StageComparison
from grader.course.atomic_files import write_atomically
from grader.course.paths import Course

MAX_PAIRS = 50


@dataclass(frozen=True)
class Side:
    """One of two compared answers. Lines with a counterpart in the other answer are marked."""

    student: str
    lines: tuple[tuple[str, bool], ...]


@dataclass(frozen=True)
class SharedFunction:
    """Two students' similar answers to one exercise."""

    exercise: str
    sentences: tuple[str, ...]
    sides: tuple[Side, Side]


@dataclass(frozen=True)
class PairSection:
    """The section of the page about two students, with all their similar functions."""

    students: tuple[str, str]
    pairs: tuple[Pair, ...]
    functions: tuple[SharedFunction, ...]


def similarity_page(course: Course, stage: str) -> Path:
    """Return the path of a stage's page."""
    return course.report / f"similarity_{stage}.html"


def write_similarity(course: Course, compared: StageComparison) -> Path:
    """Write the page and return its path."""
    pairs = compared.pairs
    shown_pairs = [
        PairSection(
            pair.students,
            pair.pairs,
            tuple(_shared_function(answers, compared) for answers in pair.pairs),
        )
        for pair in pairs[:MAX_PAIRS]
    ]
    page = render(
        "similarity.html",
        compared=compared,
        pairs=shown_pairs,
        more=len(pairs) - len(shown_pairs),
        made=datetime.now().strftime("%d %B %Y, %H:%M"),
        percent=format_percent,
    )
    path = similarity_page(course, compared.stage)
    write_atomically(page, path)
    return path


def format_percent(share: float) -> str:
    """Format a share in per cent. Only a share of exactly 0 or 1 is shown as 0 % or 100 %."""
    if 0 < share < 1:
        share = min(max(share, 0.01), 0.99)
    return f"{100 * share:.0f} %"


def _shared_function(pair: Pair, compared: StageComparison) -> SharedFunction:
    answers = [compared.answers[pair.exercise, student] for student in pair.students]
    sides = (
        Side(student, _marked_lines(answer, alike))
        for student, answer, alike in zip(pair.students, answers, pair.similar_steps, strict=True)
    )
    return SharedFunction(pair.exercise, tuple(_sentences(pair, *answers)), tuple(sides))


def _marked_lines(
    answer: ComparedAnswer, similar_steps: frozenset[int]
) -> tuple[tuple[str, bool], ...]:
    steps = (answer.steps[index] for index in similar_steps)
    marked = {line for step in steps for line in range(step.first, step.last + 1)}
    return tuple(
        (line, number in marked) for number, line in enumerate(answer.text.split("\n"), start=1)
    )


def _sentences(
    pair: Pair, first_answer: ComparedAnswer, second_answer: ComparedAnswer
) -> Iterator[str]:
    """Yield sentences about the similarity, and about how unusual it is in this class."""
    counts = [
        f"{len(alike)} of {steps} steps in {student}'s answer"
        for student, alike, steps in zip(
            pair.students, pair.similar_steps, pair.step_counts, strict=True
        )
    ]
    equality = _equality_sentence(first_answer, second_answer)
    yield f"{counts[0]} and {counts[1]} are alike. {equality}"
    in_class, kept = pair.other_counts
    others = f"{in_class} from students" + (f" and {kept} from the course" if kept else "")
    verb = "does" if pair.exclusive_steps == 1 else "do"
    exclusive = (
        f"{pair.exclusive_steps} of these steps {verb} not occur in any of the other answers "
        f"({others})."
        if pair.exclusive_steps
        else "Each of these steps also occurs in another student's answer or in one of the "
        "course's answers."
    )
    with_kept = (
        f", and with one of the course's answers it is {format_percent(pair.nearest_shares[1])}"
    )
    yield (
        f"{exclusive} The two answers have "
        f"{format_percent(pair.share)} of their unusual code in common. The highest share that "
        "either has in common with another student's answer is "
        f"{format_percent(pair.nearest_shares[0])}{with_kept if kept else ''}."
    )


def _equality_sentence(first_answer: ComparedAnswer, second_answer: ComparedAnswer) -> str:
    """Return a sentence that describes how similar two answers are."""
    if first_answer.text == second_answer.text:
        return "The two answers are identical, including comments."
    if first_answer.code == second_answer.code:
        return "The two answers differ only in comments and layout."
    if [step.words for step in first_answer.steps] == [step.words for step in second_answer.steps]:
        return "The two answers have the same steps and differ only in names and other details."
    return "These steps are highlighted."
