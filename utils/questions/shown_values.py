"""Values that students can read in the code of a case, without the code that it calls."""

from __future__ import annotations

import ast
import contextlib
import functools
import re

import numpy as np

from utils.notebooks.small_cases import plain_value
from utils.questions.texts import value_text

_LITERALS = (ast.Constant, ast.List, ast.Tuple, ast.UnaryOp, ast.USub, ast.Load)


@functools.cache
def shown_values(code: str) -> frozenset[str]:
    """Return the texts of the values that a case shows: its literals, and the arrays that it makes.

    Parameters
    ----------
    code : str
        Statements of a case. They come from the course, so they can run here.
    """
    names = {"np": np}
    values = []
    for statement in ast.parse(code).body:
        for node in ast.walk(statement):
            if isinstance(node, ast.expr) and all(map(_is_literal, ast.walk(node))):
                values.append(eval(compile(ast.Expression(node), "<case>", "eval"), names))
        # Statements that call the student's code fail, because it is not defined here.
        with contextlib.suppress(Exception):
            exec(compile(ast.Module([statement], []), "<case>", "exec"), names)
    arrays = [value for value in names.values() if isinstance(value, np.ndarray)]
    arrays += [array[:, :3] for array in arrays if array.ndim == 2]
    return frozenset(value_text(plain_value(value)) for value in [*values, *arrays]) - {""}


def _is_literal(node: ast.AST) -> bool:
    is_numpy = isinstance(node, ast.Name) and node.id == "np"
    is_constant = isinstance(node, ast.Attribute) and node.attr in ("nan", "inf")
    return isinstance(node, _LITERALS) or is_numpy or is_constant


def is_selection(text: str, code: str) -> bool:
    """Return whether a value is a list of rows that a case shows, such as points of a cloud."""
    rows = {row for shown in shown_values(code) if shown.startswith("[[") for row in _rows(shown)}
    is_list = text == "[]" or text.startswith("[[")
    return bool(rows) and is_list and rows.issuperset(_rows(text))


def _rows(text: str) -> list[str]:
    return re.findall(r"\[[^][]+\]", text)
