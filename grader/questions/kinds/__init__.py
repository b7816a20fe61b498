"""The kinds of questions. Each module has a function that yields candidates for questions.

A candidate has at least three choices, and a key that has not been verified yet.
"""

from collections.abc import Callable, Iterator
from random import Random

from grader.questions.answer import Behaviour
from grader.questions.kinds.cost import cost_questions
from grader.questions.kinds.deletion import deletion_questions
from grader.questions.kinds.predict import prediction_questions
from grader.questions.kinds.trace import trace_questions
from grader.questions.kinds.what_if import what_if_questions
from grader.questions.kinds.which_line import which_line_questions
from grader.questions.question import Question

KINDS: tuple[Callable[[Behaviour, Random], Iterator[Question]], ...] = (
    prediction_questions,
    trace_questions,
    cost_questions,
    which_line_questions,
    what_if_questions,
    deletion_questions,
)
