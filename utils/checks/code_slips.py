"""Find slips in the source of a function that can occur in any exercise.

A slip describes only the source, so the description is true in every exercise. It is shown with a
failed check if no known mistake explains the failure.
"""

import ast
import contextlib
import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from numbers import Number
from types import FunctionType

import numpy as np

_LOOPS = (ast.For, ast.While)
_MUTABLE = (ast.List, ast.Dict, ast.Set)
_CHANGES = ("append", "extend", "insert", "add", "update", "pop", "remove")


@dataclass(frozen=True)
class CodeSlip:
    """A slip in the source of a function.

    Attributes
    ----------
    description : str
        One sentence about the code.
    hint : str
        How to fix it.
    """

    description: str
    hint: str


def find_code_slip(function: Callable, returned_none: bool) -> CodeSlip | None:
    """Return the first slip in the source of a function, or None.

    Parameters
    ----------
    function : callable
    returned_none : bool
        Whether a check failed because the answer was None. Otherwise the function may be one that
        returns nothing, such as `insert`, and a `print` in it is not a slip.
    """
    with contextlib.suppress(OSError, TypeError, SyntaxError, ValueError):
        [node] = ast.parse(textwrap.dedent(inspect.getsource(function))).body
        if isinstance(node, ast.FunctionDef) and isinstance(function, FunctionType):
            return (
                (_find_print(node) if returned_none else None)
                or _find_return_in_loop(node)
                or _find_mutable_default(node)
                or _find_notebook_variable(node, function)
            )
    return None


def _walk_body(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes inside a node, but not those of functions and classes defined in it."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, (ast.FunctionDef, ast.Lambda, ast.ClassDef)):
            yield child
            yield from _walk_body(child)


def _find_print(node: ast.FunctionDef) -> CodeSlip | None:
    parts = list(_walk_body(node))
    gives = (ast.Yield, ast.YieldFrom)
    if any(
        isinstance(part, gives) or (isinstance(part, ast.Return) and part.value) for part in parts
    ):
        return None
    if any(isinstance(part, ast.Call) and ast.unparse(part.func) == "print" for part in parts):
        return CodeSlip(
            "The function prints its result and returns nothing.",
            "Return the result. `print` only displays it.",
        )
    return None


def _find_return_in_loop(node: ast.FunctionDef) -> CodeSlip | None:
    for loop in _walk_body(node):
        if not isinstance(loop, _LOOPS) or not isinstance(loop.body[-1], ast.Return):
            continue
        is_endless = isinstance(loop, ast.While) and isinstance(loop.test, ast.Constant)
        parts = list(_walk_body(loop))
        jumps = any(isinstance(part, (ast.Continue, ast.Break)) for part in parts)
        # A loop with `continue` or `break` may rightly return the first row that it finds. A list
        # that was created before the loop would still be incomplete.
        value = loop.body[-1].value
        names = [part for part in parts if isinstance(part, ast.Name)]
        set_inside = {name.id for name in names if not _is_read(name)}
        is_incomplete = isinstance(value, ast.Name) and value.id not in set_inside
        if not is_endless and (is_incomplete or not jumps):
            return CodeSlip(
                "`return` is inside a loop, so the loop ends when it first reaches `return`.",
                "Indent `return` one level less, so that it comes after the loop.",
            )
    return None


def _find_mutable_default(node: ast.FunctionDef) -> CodeSlip | None:
    names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    defaults = zip(reversed(names), reversed(node.args.defaults), strict=False)
    kept = {name for name, default in defaults if isinstance(default, _MUTABLE)}
    for part in _walk_body(node):
        target = None
        if isinstance(part, ast.Call) and isinstance(part.func, ast.Attribute):
            target = part.func.value if part.func.attr in _CHANGES else None
        elif isinstance(part, ast.AugAssign):
            target = part.target
        if isinstance(target, ast.Name) and target.id in kept:
            return CodeSlip(
                f"The default value of `{target.id}` is created only once, so it keeps the "
                "changes of earlier calls.",
                "Create the value inside the function, so that each call starts with a new one.",
            )
    return None


def _find_notebook_variable(node: ast.FunctionDef, function: FunctionType) -> CodeSlip | None:
    read = {part.id for part in ast.walk(node) if isinstance(part, ast.Name) and _is_read(part)}
    parameters = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    unread = [name for name in parameters if name not in read]
    data = (np.ndarray, Number, list, tuple)
    used = [
        part.id
        for part in _walk_body(node)
        if isinstance(part, ast.Name)
        and _is_read(part)
        and part.id in function.__code__.co_names
        and isinstance(function.__globals__.get(part.id), data)
    ]
    if unread and used:
        return CodeSlip(
            f"The function uses the notebook's variable `{used[0]}` but not its parameter "
            f"`{unread[0]}`.",
            "Use the parameter, which holds the argument of each call.",
        )
    return None


def _is_read(name: ast.Name) -> bool:
    return isinstance(name.ctx, ast.Load)
