"""Stand-ins for students that run in this process, because a sandbox is too slow for many calls."""

import copy
from types import SimpleNamespace

from grader.judging.judge import given_code
from utils.notebooks import slicing


def with_copied_arguments(function):
    """Wrap a function so that it gets copies of its arguments, as it does from the judge."""

    def call(*arguments, **keywords):
        given, named = copy.deepcopy((arguments, keywords))
        return function(*given, **named)

    return call


def student_with(lesson, answers):
    """Return a stand-in for the `StudentProxy` of a notebook with these answers."""
    names = {name: with_copied_arguments(function) for name, function in answers.items()}
    if "KdTree" in lesson.names:
        space = dict(answers)
        exec(given_code(lesson), space)
        space["KdTree"].node = space["Node"]
        names["KdTree"] = space["KdTree"]
    return SimpleNamespace(**names, exercise="", close=lambda: None)


def answers_in(lesson, cells, *classes):
    """Return the functions of a lesson, and some classes, that a notebook defines, by name."""
    statements, _ = slicing.parse_notebook(cells)
    space = {"__name__": "__main__", "display": lambda *values: None}
    for statement in slicing.slice_for([*lesson.names, *classes], statements):
        exec(slicing.compile_statement(statement, f"code cell {statement.cell}"), space)
    return {name: space[name] for name in [*lesson.names, *classes]}
