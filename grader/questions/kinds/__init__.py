"""The kinds of questions; each module has a function that makes candidates for questions.

A candidate has at least three choices. Its key has not been verified yet.
"""

from collections.abc import Callable, Iterator
from random import Random

from grader.questions.answer import Behaviour
from grader.questions.kinds.cost import cost
from grader.questions.kinds.necessary import necessary
from grader.questions.kinds.predict import predict
from grader.questions.kinds.trace import trace
from grader.questions.kinds.what_if import what_if
from grader.questions.kinds.which_line import which_line
from grader.questions.question import Question

KINDS: tuple[Callable[[Behaviour, Random], Iterator[Question]], ...] = (
    predict,
    trace,
    cost,
    which_line,
    what_if,
    necessary,
)
