"""Recognise names of the standard library that the running Python is too old to have.

Such a name raises an exception here, although the code is right. A name in a ``try`` statement that
handles errors proves nothing, because the code may work without it. The same holds for all names if
the code mentions ``hasattr``, ``getattr`` or ``version_info``.
"""

from __future__ import annotations

import ast
from collections.abc import Container, Iterable, Iterator
from itertools import accumulate

from utils.notebooks.newer_syntax import RUNNING_VERSION

# From the lists of changes in Python's documentation, limited to names that an answer might use.
_NAMES_ADDED = {
    (3, 12): (
        *("collections.abc.Buffer", "itertools.batched", "math.sumprod"),
        *("random.binomialvariate", "types.get_original_bases", "typing.TypeAliasType"),
        "typing.override",
    ),
    (3, 13): (
        *("copy.replace", "glob.translate", "math.fma", "os.process_cpu_count", "queue.ShutDown"),
        *("re.PatternError", "statistics.kde", "statistics.kde_random", "typing.NoDefault"),
        *("typing.ReadOnly", "typing.TypeIs", "typing.get_protocol_members", "typing.is_protocol"),
        "warnings.deprecated",
    ),
    (3, 14): (
        *("annotationlib", "compression", "concurrent.futures.InterpreterPoolExecutor"),
        *("concurrent.interpreters", "functools.Placeholder", "heapq.heapify_max"),
        *("heapq.heappop_max", "heapq.heappush_max", "heapq.heappushpop_max"),
        *("heapq.heapreplace_max", "operator.is_none", "operator.is_not_none", "pathlib.types"),
        *("string.templatelib", "typing.evaluate_forward_ref"),
    ),
}
ADDED_IN = {name: version for version, names in _NAMES_ADDED.items() for name in names}
"""The version of Python that added a name."""
_VERSION_TESTS = {"hasattr", "getattr", "version_info"}


def newer_names(
    nodes: Iterable[ast.AST], python: tuple[int, ...] = (), own_modules: Container[str] = ()
) -> Iterator[tuple[int, str]]:
    """Yield the names that only a newer Python provides.

    Parameters
    ----------
    nodes : iterable of ast.AST
        The statements that a function needs, with their imports.
    python : tuple of int, optional
        The version of Python that ran the code, if it is known. If that version lacks a name as
        well, the name is not reported.
    own_modules : container of str, optional
        Names of the student's own modules, which replace those of the standard library.

    Yields
    ------
    index : int
        Index of the statement in `nodes`.
    reason : str
        The rest of a sentence that begins with the cell or file.
    """
    nodes = list(nodes)
    if any(_name(inner) in _VERSION_TESTS for node in nodes for inner in ast.walk(node)):
        return
    modules = {}
    for node in nodes:
        for inner in _unguarded(node):
            if isinstance(inner, ast.Import):
                for alias in inner.names:
                    root = alias.name.partition(".")[0]
                    modules[alias.asname or root] = alias.name if alias.asname else root
    for index, node in enumerate(nodes):
        for inner in _unguarded(node):
            for name in _library_names(inner, modules):
                version = ADDED_IN.get(name, RUNNING_VERSION)
                was_absent = python and python < version
                if (
                    version > RUNNING_VERSION
                    and not was_absent
                    and name.partition(".")[0] not in own_modules
                ):
                    needed = ".".join(map(str, version))
                    yield index, f"uses {name}, which needs Python {needed} or later"


def _unguarded(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes in a statement except those in a ``try`` statement that handles errors."""
    waiting = [node]
    while waiting:
        inner = waiting.pop()
        if not (isinstance(inner, (ast.Try, ast.TryStar)) and inner.handlers):
            yield inner
            waiting.extend(ast.iter_child_nodes(inner))


def _library_names(node: ast.AST, modules: dict[str, str]) -> Iterator[str]:
    """Yield the dotted names of modules and of their members that one node uses."""
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield from _prefixes(alias.name)
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        for alias in node.names:
            yield from _prefixes(f"{node.module}.{alias.name}")
    elif isinstance(node, ast.Attribute):
        parts = [node.attr]
        while isinstance(node := node.value, ast.Attribute) and len(parts) < 3:
            parts.append(node.attr)
        if isinstance(node, ast.Name) and node.id in modules:
            yield ".".join([modules[node.id], *reversed(parts)])


def _prefixes(dotted: str) -> Iterator[str]:
    yield from accumulate(dotted.split("."), lambda first, rest: f"{first}.{rest}")


def _name(node: ast.AST) -> str:
    return getattr(node, "id", "") or getattr(node, "attr", "")
