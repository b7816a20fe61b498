"""Find the other functions and the forbidden modules that a student's function uses."""

import ast
import dis
import functools
import importlib.util
import json
import linecache
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType, ModuleType

from utils.display import shell
from utils.lent.stubs import own

# Written by `python -m grader build` from the headers of the lessons that are judged.
_FORBIDDEN = Path(__file__).with_name("forbidden.json")
# Top-level modules that the judge's sandbox can import: Python's own, those of
# `utils.in_sandbox.INSTALLED`, IPython, and the packages that these depend on.
_AVAILABLE = frozenset(
    (
        *sys.stdlib_module_names,
        *("numpy", "scipy", "matplotlib", "mpl_toolkits", "pylab", "shapely", "sklearn", "joblib"),
        *("tqdm", "threadpoolctl", "PIL", "dateutil", "IPython", "traitlets", "utils", ""),
        "builtins",
    )
)


def refused_modules(function: Callable, lesson: str) -> list[str]:
    """Return the forbidden modules that a function uses, directly or through functions it calls.

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
    forbidden = forbidden_modules(lesson)
    used = set(_modules_of(function)) if forbidden else ()
    return [
        module for module in forbidden if any(f"{name}.".startswith(f"{module}.") for name in used)
    ]


def absent_modules(function: Callable, lesson: str) -> list[str]:
    """Return the installed modules that a function uses and that the judge does not have.

    The student's own modules are not included, because they are submitted with the notebook. Nor
    are modules that the notebook imports in a ``try`` statement, which provides a fallback. A
    lesson that is not judged may use every module. The parameters are those of `refused_modules`.
    """
    if lesson not in _load_forbidden_modules():
        return []
    tops = dict.fromkeys(name.partition(".")[0] for name in _modules_of(function))
    return [
        name
        for name in tops
        if name not in _AVAILABLE and _is_installed(name) and not _has_fallback(name, function)
    ]


def _is_installed(module: str) -> bool:
    """Return whether a module is in a folder of installed packages."""
    if module == "__main__":  # the notebook itself, or the program that runs it
        return False
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return False
    places = [] if spec is None else [spec.origin or "", *(spec.submodule_search_locations or ())]
    return any(Path(place).parts and "-packages" in place for place in places)


def _has_fallback(module: str, function: Callable) -> bool:
    """Return whether a cell imports a module in a ``try`` statement, with a fallback for it."""
    code = getattr(function, "__code__", None)
    own_cell = "".join(linecache.getlines(code.co_filename)) if code else ""
    cells = [own_cell, *(shell().user_ns.get("In", ()) if shell() else ())]
    return any(module in cell and _imports_in_try(module, cell) for cell in cells)


def _imports_in_try(module: str, cell: str) -> bool:
    try:
        tree = ast.parse(cell)
    except SyntaxError:  # a cell with IPython magics
        return False
    attempts = (node for node in ast.walk(tree) if isinstance(node, ast.Try))
    imports = (
        node
        for attempt in attempts
        for part in attempt.body
        for node in ast.walk(part)
        if isinstance(node, ast.Import | ast.ImportFrom)
    )
    names = (
        name
        for node in imports
        for name in (
            [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else [alias.name for alias in node.names]
        )
    )
    return any(name.partition(".")[0] == module for name in names)


def functions_used(function: Callable) -> dict[str, Callable]:
    """Return the notebook's functions that a function calls, directly or indirectly, by name."""
    return {
        name: own(value)
        for part in _functions_reached_from(function)
        for code in _nested_codes(part.__code__)
        for name, value in _globals_in(code, part)
        if isinstance(value, FunctionType) and value is not function
    }


def forbidden_modules(lesson: str) -> tuple[str, ...]:
    """Return the modules that a lesson forbids; see `refused_modules`."""
    return tuple(_load_forbidden_modules().get(lesson, ()))


@functools.cache
def _load_forbidden_modules() -> dict[str, list[str]]:
    return json.loads(_FORBIDDEN.read_text("utf-8"))


def _modules_of(function: Callable) -> Iterator[str]:
    """Yield the dotted names of the modules that code imports, or reaches through globals."""
    for part in _functions_reached_from(function):
        for code in _nested_codes(part.__code__):
            for instruction in dis.get_instructions(code):
                if instruction.opname == "IMPORT_NAME":
                    yield instruction.argval
                    yield from (f"{instruction.argval}.{name}" for name in code.co_names)
            for _, value in _globals_in(code, part):
                yield from _reached_modules(value, code.co_names)


def _globals_in(code: CodeType, function: FunctionType) -> Iterator[tuple[str, object]]:
    """Yield the names and values of the globals that code loads; attributes are not included."""
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield instruction.argval, function.__globals__.get(instruction.argval)


def _reached_modules(value: object, names: tuple[str, ...]) -> Iterator[str]:
    """Yield the names of the modules that a value reaches through attributes in `names`.

    A value that is not a module reaches the module that defines it.
    """
    waiting, seen = [value], []
    while waiting:
        value = waiting.pop()
        if not isinstance(value, ModuleType):
            yield str(getattr(value, "__module__", ""))
        elif value not in seen:
            seen.append(value)
            yield value.__name__
            waiting += [vars(value).get(name) for name in names]


def _functions_reached_from(function: object) -> list[FunctionType]:
    """Return a function, the functions it calls, and the methods of classes it uses.

    Only functions and classes of the same notebook are included.
    """
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
            for code in _nested_codes(value.__code__):
                waiting += [used for _, used in _globals_in(code, value)]
    return [used for used in found if isinstance(used, FunctionType)]


def _nested_codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code object and those nested in it."""
    yield code
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _nested_codes(value)
