"""Ask two questions about a student's own function in a notebook.

Nothing is graded. Choices unfold without a kernel, so they also work in a saved notebook.

>>> ask_about(filter_ground)
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from random import Random

from utils.checks.compiled import as_python
from utils.checks.limits import TimeUp
from utils.checks.waiting_cells import has_passed, print_waiting
from utils.display import show
from utils.lent.stubs import own
from utils.questions.cases import cases_of, exercises_with_cases, shown_code, value_phrase
from utils.questions.choices import arrange, distractors, with_first
from utils.questions.texts import NOTATION, is_easy, is_value, same_answer
from utils.questions.versions import OWN_SECONDS, Versions
from utils.remote_objects import ENDLESS_LOOP_HINT


@dataclass(frozen=True)
class Card:
    """A question with one right choice.

    Attributes
    ----------
    case : int
        Index of its case.
    text : str
        The question; code is between backticks.
    before, after : str
        A line before and after its change; empty if no line changes.
    code : str
        The call that the question is about.
    choices : tuple of str
    key : int
        Index of the right choice.
    explanations : tuple of str
        Texts that appear when readers open the choices.
    """

    case: int
    text: str
    before: str
    after: str
    code: str
    choices: tuple[str, ...]
    key: int
    explanations: tuple[str, ...]

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """The letter, text and explanation of each choice."""
        return list(zip("ABCD", self.choices, self.explanations, strict=False))


def predict(versions: Versions, random: Random) -> Iterator[Card]:
    """Ask for the value of each case."""
    for number in random.sample(range(len(versions.cases)), len(versions.cases)):
        right, code = versions.own[number], versions.cases[number].code
        arranged = arrange(right, distractors(right, versions.values_near(number), code), random)
        if is_value(right) and arranged:
            wrong = (
                f"No. The notebook ran these lines, and the value is `{right}`. With one small "
                "change in the function, the value would be the one that you chose."
            )
            texts = ["Right. The notebook ran these lines, and this is the value." if text == right
                     else wrong for text in arranged[0]]  # fmt: skip
            question = f"What is {value_phrase(code)}?"
            yield Card(number, question, "", "", shown_code(code), *arranged, tuple(texts))


def what_if(versions: Versions, random: Random) -> Iterator[Card]:
    """Ask for the value of a case after a change of one line, preferably with easy numbers."""
    pairs = [
        (change, number)
        for change, number in itertools.product(versions.changes, range(len(versions.cases)))
        if is_value(versions.own[number])
        and is_value(change.outcomes[number])
        and not same_answer(versions.own[number], change.outcomes[number])
    ]
    random.shuffle(pairs)
    pairs.sort(key=lambda pair: not is_easy(pair[0].outcomes[pair[1]]))  # stable
    for change, number in pairs:
        before, right = versions.own[number], change.outcomes[number]
        code = versions.cases[number].code
        nearby = distractors(right, versions.values_near(number), code)
        arranged = arrange(right, with_first(before, nearby), random)
        if arranged and versions.confirms(number, right, change):
            yield Card(
                number,
                f"Suppose that you change line {change.line} of the cell with your function as "
                f"shown here. What is {value_phrase(code)} then?",
                change.before,
                change.after,
                shown_code(code),
                *arranged,
                tuple(_explain_change(text, before, right) for text in arranged[0]),
            )


def _explain_change(choice: str, before: str, after: str) -> str:
    ran = "The notebook ran the changed function,"
    if choice == after:
        return f"Right. {ran} and this is the value. Without the change, it is `{before}`."
    if choice == before:
        return f"No. This is the value without the change. {ran} and the value is `{after}`."
    return f"No. {ran} and the value is `{after}`. Another small change would give your choice."


def ask_about(
    function: Callable,
    exercise: str | None = None,
    kinds: Sequence[Callable[[Versions, Random], Iterator[Card]]] = (predict, what_if),
) -> None:
    """Ask two questions about your own function, which has to pass its checks first.

    The same code gets the same questions.

    Parameters
    ----------
    function : callable
        Your function or class for an exercise.
    exercise : str, optional
        Name of the exercise, if a class contains several. By default, the name of the function.
    kinds : sequence of callable, optional
        Kinds of questions; one card of each is shown.

    Raises
    ------
    LookupError
        If there are no questions about this function.
    """
    function = own(function)
    exercise = exercise or function.__name__
    if not cases_of(exercise):
        names = ", ".join(exercises_with_cases())
        raise LookupError(f"There are no questions about {exercise!r}, only about {names}.")
    if not has_passed(exercise, function):
        print_waiting(exercise, function)
        return
    try:
        cards = make_cards(as_python(function), exercise, kinds)
    except TimeUp:
        print(
            f"There are no questions, because {exercise} did not return within {OWN_SECONDS:.0f} s "
            f"on a few points. {ENDLESS_LOOP_HINT.capitalize()}"
        )
        return
    except (OSError, TypeError, SyntaxError, ValueError):
        cards = []
    if not cards:
        print(f"No question about this version of {exercise} has one clear answer.")
        return
    numbered = list(enumerate(cards, start=1))
    show(
        "".join([*itertools.starmap(_as_html, numbered), f"<p>{NOTATION}</p>"]),
        "\n\n".join([*itertools.starmap(_as_text, numbered), NOTATION]),
    )


def make_cards(function: Callable, exercise: str, kinds: Sequence[Callable]) -> list[Card]:
    """Return one card of each kind about different cases, if possible; see `Versions`."""
    versions = Versions(
        function, exercise, tuple(case for case in cases_of(exercise) if not case.run)
    )
    random = Random(versions.source)
    cards: list[Card] = []
    for kind in kinds:
        used = {card.case for card in cards}
        new = (card for card in kind(versions, random) if card.case not in used)
        cards += itertools.islice(new, 1)
    return cards


def _as_html(number: int, card: Card) -> str:
    # JupyterLab removes the margins of <pre>, so that the change and the call would look like one.
    pre = "<pre style='margin:0.6em 0'>"
    change = f"{pre}- {escape(card.before)}\n+ {escape(card.after)}</pre>" if card.after else ""
    choices = "".join(
        f"<details><summary>{letter}. <code>{escape(choice)}</code></summary>"
        f"<div style='margin:0 0 0.5em 1.2em'>{_with_code(explanation)}</div></details>"
        for letter, choice, explanation in card.rows
    )
    return (
        "<div style='border-left:4px solid #0072B2;padding:0.3em 0.8em;margin:0.6em 0;"
        f"line-height:1.5'><div><b>Question {number}.</b> {_with_code(card.text)}</div>{change}"
        f"{pre}{escape(card.code)}</pre>{choices}</div>"
    )


def _with_code(text: str) -> str:
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))


def _as_text(number: int, card: Card) -> str:
    change = f"- {card.before}\n+ {card.after}\n\n" if card.after else ""
    choices = "\n".join(f"{letter}. {choice}" for letter, choice, _ in card.rows)
    letter, _, explanation = card.rows[card.key]
    return (
        f"Question {number}. {card.text}\n\n{change}{card.code}\n\n{choices}\n\n"
        f"Answer: {letter}. {explanation}"
    )
