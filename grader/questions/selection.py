"""Choose questions about one answer, of different kinds and with verified keys."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from dataclasses import replace
from random import Random

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import Lesson
from grader.questions.answer import Answer, Behaviour, outcomes_of
from grader.questions.kinds import KINDS
from grader.questions.question import DEPTHS, Question
from grader.questions.verification import Verifier
from grader.sandbox import Sandbox
from grader.sandbox.failures import StudentError, StudentStopped
from utils.notebooks.reading import decode_notebook
from utils.questions.texts import ERROR, is_easy

# Number of other right answers in which the outcomes are compared.
MAX_PEERS = 4
# In this order, one question of each kind is chosen: first an easy and a hard one.
EASY, HARD = ("predict", "trace", "cost"), ("what if", "necessary", "which line")
# Candidates of one kind to verify before trying another kind.
MAX_TRIES = 5
# Added to a question about a vector that has two right directions.
FREE_SIGNS = " Your result may have all signs reversed."
# Two questions of these kinds must not share a case, because one may contain the other's answer.
REVEALING = ({"predict", "which line"}, {"trace", "cost"}, {"cost"})


def candidates(behaviour: Behaviour, random: Random) -> list[Question]:
    """Return all questions about an answer, with keys that are not verified yet."""
    return [question for kind in KINDS for question in kind(behaviour, random)]


def choose_questions(
    behaviour: Behaviour, sandbox: Sandbox, count: int, random: Random
) -> list[Question]:
    """Return up to `count` questions with verified keys, the easiest first.

    Kinds are repeated only if there are not enough of them. Questions share a case only if they
    have to, and never if the text of one could contain the answer to the other.
    """
    by_kind: dict[str, list[Question]] = {}
    for question in candidates(behaviour, random):
        by_kind.setdefault(question.kind, []).append(question)
    for questions in by_kind.values():
        random.shuffle(questions)
        questions.sort(key=_rank)  # stable, so that the order stays random within a rank
    chosen: list[Question] = []
    with Verifier(behaviour, sandbox) as verifier:
        for kind in _kinds_in_turn(list(by_kind), count, random):
            if len(chosen) == count:
                break
            question = _next_question(by_kind[kind], chosen, verifier)
            chosen += [question] if question else []
    return sorted(chosen, key=lambda question: DEPTHS[question.kind])


def _rank(question: Question) -> tuple[bool, bool, bool]:
    """Return a sort key: questions about this code, about values and with easy numbers first."""
    right = question.right_choice
    is_hard = not (is_easy(right) and is_easy(question.text))
    return not question.is_about_code, right.startswith(ERROR), is_hard


def _kinds_in_turn(kinds: list[str], count: int, random: Random) -> Iterator[str]:
    """Yield kinds: an easy one, a hard one, the others, and then all of them again."""
    easy = [kind for kind in kinds if kind in EASY]
    hard = [kind for kind in kinds if kind in HARD]
    random.shuffle(easy)
    random.shuffle(hard)
    order = easy[:1] + hard[:1]
    rest = easy[1:] + hard[1:]
    random.shuffle(rest)
    yield from (order + rest) * count


def _next_question(
    questions: list[Question], chosen: list[Question], verifier: Verifier
) -> Question | None:
    """Return the next verified question of a kind, and remove those that were tried."""
    possible = [question for question in questions if not _reveals(question, chosen)]
    used = {code for question in chosen for code in _codes(question)}
    # The sort is stable, so questions about unused cases come first in the order of their rank.
    possible.sort(key=lambda question: not used.isdisjoint(_codes(question)))
    for question in possible[:MAX_TRIES]:
        questions.remove(question)
        if verifier.confirms(question):
            has_free_signs = verifier.has_free_signs(question)
            return (
                replace(question, text=question.text + FREE_SIGNS) if has_free_signs else question
            )
    return None


def _reveals(question: Question, chosen: list[Question]) -> bool:
    """Return whether a question may contain the answer to a chosen one, or the other way round."""
    return any(
        {question.kind, other.kind} in REVEALING and _codes(question) & _codes(other)
        for other in chosen
    )


def _codes(question: Question) -> set[str]:
    return {claim.code for claim in question.claims}


@functools.cache
def peer_outcomes(lesson: Lesson, exercise: str, sandbox: Sandbox) -> tuple[tuple[str, ...], ...]:
    """Return the outcomes of some other right answers, from the lesson's kept answers."""
    if not (lesson.folder / "answers" / f"{exercise}.txt").is_file():
        return ()
    peers = []
    for source in [answer.source for answer in answers_to(exercise) if answer.right][:MAX_PEERS]:
        answer = Answer(lesson, exercise, _code_with_answer(lesson, exercise, source), {})
        # A kept answer may fail here, for example if a package is not installed.
        with contextlib.suppress(StudentError, StudentStopped):
            peers.append(outcomes_of(answer, sandbox))
    return tuple(peers)


def _code_with_answer(lesson: Lesson, exercise: str, source: str) -> tuple[str, ...]:
    """Return the code of a notebook with one answer."""
    text = fill_in(lesson, {exercise: source})
    return decode_notebook(text.encode(), lesson.name).code
