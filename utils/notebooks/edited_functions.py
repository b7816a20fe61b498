"""Run the source of a function again after each edit; see `utils.notebooks.edits`."""

from __future__ import annotations

import ast
import contextlib
import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import FunctionType

from utils.notebooks import slicing
from utils.notebooks.edits import Edit, edits_of


@dataclass(frozen=True)
class Definition:
    """The definition of a function in a notebook.

    Attributes
    ----------
    lines : list of str
        Its lines, without the indentation of a method.
    first : int
        Number of its first line in the cell.
    statement : utils.notebooks.slicing.Statement
    edits : list of utils.notebooks.edits.Edit
        The likeliest first.
    """

    lines: list[str]
    first: int
    statement: slicing.Statement
    edits: list[Edit]


def read_definition(exercise: str, function: Callable) -> Definition:
    """Read the definition of the function with the code of an exercise.

    Parameters
    ----------
    exercise : str
    function : callable
        The student's function, or a class with a method that is the exercise.

    Raises
    ------
    OSError, TypeError, SyntaxError, ValueError
        If the source is not known, or is not one definition.
    """
    source, first = inspect.getsourcelines(function_with_code(exercise, function))
    text = textwrap.dedent("".join(source))
    (statement,) = slicing.parse_notebook([text])[0]
    if not isinstance(statement.node, ast.FunctionDef):
        raise ValueError(f"{exercise} is not defined with def.")
    return Definition(text.split("\n"), first, statement, edits_of([text], [statement]))


def edited_functions(
    function: Callable, statement: slicing.Statement, edits: Iterable[Edit]
) -> Iterator[tuple[Edit, Callable]]:
    """Yield the edits of a definition that are valid, and the function or class after each."""
    name = statement.node.name
    part = function_with_code(name, function)
    for edit in edits:
        namespace = dict(part.__globals__)
        with contextlib.suppress(Exception):
            exec(compile(edit.statement, "<changed>", "exec", flags=statement.future), namespace)
            changed = namespace[name]
            yield edit, _class_with(function, name, changed) if part is not function else changed


def function_with_code(exercise: str, function: Callable) -> Callable:
    """Return the function with the code of an exercise.

    If a class contains the exercise, this is a method, or a function of the notebook with the same
    name that the method calls.
    """
    if not isinstance(function, type):
        return function
    method = vars(function).get(exercise)
    if not isinstance(method, FunctionType) or exercise not in method.__code__.co_names:
        return method
    called = method.__globals__.get(exercise)
    return called if isinstance(called, FunctionType) else method


def _class_with(kind: type, name: str, changed: FunctionType) -> type:
    """Return a subclass in which `changed` replaces a method, or the function that it calls."""
    if function_with_code(name, kind) is vars(kind).get(name):
        return type(kind.__name__, (kind,), {name: changed})
    methods = {
        own: FunctionType(
            method.__code__, changed.__globals__, own, method.__defaults__, method.__closure__
        )
        for own, method in vars(kind).items()
        if isinstance(method, FunctionType)
    }
    return type(kind.__name__, (kind,), methods)
