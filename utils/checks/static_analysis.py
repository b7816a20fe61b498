"""Find the other functions and the forbidden modules that a student's function uses."""

import dis
import functools
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

from utils.lent.stubs import own

# Written by `python -m grader build` from the headers of the lessons.
_FORBIDDEN = Path(__file__).with_name("forbidden.json")


def refused_modules(function: Callable, lesson: str) -> list[str]:
    """Return the forbidden modules that a function uses, itself or through functions it calls.

    Parameters
    ----------
    function : callable
    lesson : str
        Name of the lesson's module, such as "lesson_05".

    Returns
    -------
    list of str
        The names as listed in the lesson's header.
    """
    forbidden = forbidden_in(lesson)
    used = set(_modules_of(function)) if forbidden else ()
    return [
        module for module in forbidden if any(f"{name}.".startswith(f"{module}.") for name in used)
    ]


def functions_used(function: Callable) -> dict[str, Callable]:
    """Return the functions of the same notebook that a function calls, directly or not, by name."""
    return {
        name: own(value)
        for part in _functions(function)
        for code in _codes(part.__code__)
        for name, value in _globals_in(code, part)
        if isinstance(value, FunctionType) and value is not function
    }


def forbidden_in(lesson: str) -> tuple[str, ...]:
    """Return the modules that a lesson forbids; see `refused_modules`."""
    return tuple(_forbidden().get(lesson, ()))


@functools.cache
def _forbidden() -> dict[str, list[str]]:
    return json.loads(_FORBIDDEN.read_text("utf-8"))


def _modules_of(function: Callable) -> Iterator[str]:
    """Yield the dotted names of the modules that code imports, or reaches through globals."""
    for part in _functions(function):
        for code in _codes(part.__code__):
            for instruction in dis.get_instructions(code):
                if instruction.opname == "IMPORT_NAME":
                    yield instruction.argval
                    yield from (f"{instruction.argval}.{name}" for name in code.co_names)
            for _, value in _globals_in(code, part):
                yield from _reached(value, code.co_names)


def _globals_in(code: CodeType, function: FunctionType) -> Iterator[tuple[str, object]]:
    """Yield the names and values of the globals that code loads; attributes do not count."""
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield instruction.argval, function.__globals__.get(instruction.argval)


def _reached(value: object, names: tuple[str, ...]) -> Iterator[str]:
    """Yield the names of a module and of its attributes in `names`, or a value's home module."""
    waiting, seen = [value], []
    while waiting:
        value = waiting.pop()
        if not isinstance(value, ModuleType):
            yield str(getattr(value, "__module__", ""))
        elif value not in seen:
            seen.append(value)
            yield value.__name__
            waiting += [vars(value).get(name) for name in names]


def _functions(function: object) -> list[FunctionType]:
    """Return a function, those it calls, and methods of classes it uses, all of one notebook."""
    found, waiting, home = [], [function], getattr(function, "__module__", None)
    while waiting:
        value = waiting.pop()
        value = getattr(value, "__wrapped__", value)
        if not isinstance(value, FunctionType | type) or value.__module__ != home:
            continue
        if value in found:
            continue
        found.append(value)
        if isinstance(value, type):
            waiting += vars(value).values()
        else:
            for code in _codes(value.__code__):
                waiting += [used for _, used in _globals_in(code, value)]
    return [used for used in found if isinstance(used, FunctionType)]


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and those nested in it."""
    yield code
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _codes(value)
