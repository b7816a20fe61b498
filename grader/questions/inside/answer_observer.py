"""Observe a student's answer: read its source, run small cases, and record each step.

This module runs in the sandbox, next to the student's code, and is sent there as text. It contains
no expected answer. Everything that it returns is untrusted, because student code may change it.

`read_answer` has to be called first. `run_cases` inserts calls into the student's code that count
statements and record values. `trace_case` gets the same data from `sys.settrace`, without changing
the code. The two can therefore verify each other.
"""

import ast
import builtins
import collections
import contextlib
import signal
import sys
from collections.abc import Callable, Iterator

import numpy as np

from utils.notebooks import slicing
from utils.notebooks.edits import edits_of
from utils.notebooks.small_cases import SEEDS, plain_value

MAX_STEPS = 10_000
"""Number of statements after which a small case counts as endless."""
MAX_SECONDS = 0.3
"""Processor seconds after which a small case counts as endless, even if it runs few statements."""
MAX_OWN_SECONDS = 1.0
"""The same limit for the student's own version, whose calls are counted, which takes longer."""
MAX_NOTES = 400
DECOMPOSITIONS = 2
"""Number of other choices of singular vectors and eigenvectors to try."""
_SIMPLE = (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Expr, ast.Return, ast.Continue, ast.Break)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_JUMPS = (ast.Return, ast.Continue, ast.Break, ast.Raise)  # a call below one would not run
CONSTRUCTS = {
    ast.Lambda: "a lambda function",
    ast.NamedExpr: "the operator :=",
    ast.ListComp: "a list comprehension",
    ast.SetComp: "a set comprehension",
    ast.DictComp: "a dict comprehension",
    ast.GeneratorExp: "a generator expression",
    ast.ClassDef: "a class",
    ast.Try: "try",
    ast.With: "with",
    ast.Match: "match",
    ast.Yield: "yield",
    ast.YieldFrom: "yield from",
    ast.Global: "global",
    ast.Nonlocal: "nonlocal",
    ast.Starred: "a starred expression",
    ast.IfExp: "a conditional expression",
}

_cells: list[str] = []
_statements: list[slicing.Statement] = []


class _TooManySteps(BaseException):
    """A case runs too many statements or too long. Few answers catch a `BaseException`."""


def read_answer(cells: list, exercise: str, given: list, others: list, unchanged: list) -> dict:
    """Describe the statements that belong to an answer.

    Parameters
    ----------
    cells : list of str
        Source of the notebook's code cells.
    exercise : str
    given : list of str
        Classes of the lesson that contain the exercise if no function has its name.
    others : list of str
        Other exercises, which do not belong to this answer.
    unchanged : list of int
        Numbers of the cells that the student did not change.

    Returns
    -------
    dict
        ``places``: cell, first and last line of each statement. ``statements``: cell, first and
        last line, and the names that it changes, for each simple statement that is alone on its
        lines. ``edits`` and ``deletions``: cell, first and last line, and the new text.
        ``words``: cell, line, kind and text of names and constructs.
    """
    parsed, _ = slicing.parse_notebook(cells)
    names = [exercise] if any(exercise in statement.binds for statement in parsed) else given
    _cells[:] = cells
    _statements[:] = [
        statement
        for statement in slicing.slice_for(names, parsed)
        if statement.cell not in unchanged and not statement.binds & set(others)
    ]
    kinds = (*_FUNCTIONS, ast.ClassDef)
    definitions = [statement for statement in _statements if isinstance(statement.node, kinds)]
    return {
        "places": [
            [statement.cell, _first_line(statement.node), statement.node.end_lineno]
            for statement in _statements
        ],
        "statements": [row for definition in definitions for row in _simple_statements(definition)],
        "edits": [
            [edit.cell, edit.first, edit.last, edit.text] for edit in edits_of(cells, definitions)
        ],
        "deletions": [row for definition in definitions for row in _deletions(definition)],
        "words": [row for statement in _statements for row in _words(statement)],
    }


def run_cases(versions: list, codes: list, watched: list) -> list:
    """Run each case with each version of the answer.

    Parameters
    ----------
    versions : list
        An edit for each version; None for the student's own version.
    codes : list of str
        Statements of each case; the last one is an expression.
    watched : list
        Index of a case, cell, line and name, for values to report; all values if it is empty.

    Returns
    -------
    list
        For each version a list with the result of each case, up to one that does not end, or None
        if it is not valid code.
    """
    results = []
    for version in versions:
        recorder = _Recorder()
        try:
            _define(version, recorder)
        except Exception:
            results.append(None)
            continue
        runs = []
        for number, code in enumerate(codes):
            recorder.watched = {
                (cell, line, name) for case, cell, line, name in watched if case == number
            }
            recorder.watches_all = not watched
            # Two runs show most versions that are random. Choices are verified with all seeds.
            seeds = _seeds_of(code)[:2] if version else _seeds_of(code)
            runs.append(_run(code, seeds, recorder))
            # The other cases might not end either.
            if version and runs[-1]["outcome"] == ["endless"]:
                break
        results.append(runs)
    return results


def evaluate(version: list | None, code: str) -> list:
    """Return the outcomes of a case with a version of the answer that is not instrumented.

    There is one outcome for each choice of singular vectors and eigenvectors.
    """
    return _with_each_decomposition(lambda: _evaluate(version, code))


def trace_case(code: str) -> list:
    """Return how often each line runs, and the values after it, as seen by Python's own tracing.

    There is one result for each choice of singular vectors and eigenvectors.
    """
    return _with_each_decomposition(lambda: _trace_case(code))


def _evaluate(version: list | None, code: str) -> list:
    try:
        _define(version, None)
    except Exception:
        return ["invalid"]
    outcomes = [_outcome(code, seed) for seed in _seeds_of(code)]
    return (
        outcomes[0] if all(_are_equal(outcome, outcomes[0]) for outcome in outcomes) else ["varies"]
    )


def _trace_case(code: str) -> dict:
    _define(None, None)
    tracer = _Tracer({name for statement in _statements for name in _all_names(statement.node)})
    sys.settrace(tracer.enter)
    try:
        outcome = _outcome(code, SEEDS[0])
    finally:
        sys.settrace(None)
    counts = [[*place, count] for place, count in tracer.counts.items()]
    return {"outcome": outcome, "counts": counts, "notes": tracer.notes[:MAX_NOTES]}


# ---- decompositions ------------------------------------------------------------------------------


def _with_each_decomposition(run: Callable) -> list:
    """Return the results of a function with different singular vectors and eigenvectors.

    The signs of these vectors are free, and so are the vectors for equal values. LAPACK chooses
    them, so students cannot know them. There is one result if the function needs no such vectors.
    """
    results = []
    for variant in range(1 + DECOMPOSITIONS):
        with _other_vectors(variant) as calls:
            results.append(run())
        if not calls:
            break
    return results


@contextlib.contextmanager
def _other_vectors(variant: int) -> Iterator[list]:
    """Replace NumPy's decompositions, and yield a list with the name of each call."""
    originals = {name: getattr(np.linalg, name) for name in ("svd", "eig", "eigh")}
    calls = []

    def replace(name: str) -> None:
        def decompose(matrix: object, *arguments: object, **keywords: object) -> object:
            calls.append(name)
            matrix = _disturbed(matrix, variant) if variant else matrix
            parts = originals[name](matrix, *arguments, **keywords)
            if not variant or not isinstance(parts, tuple):
                return parts
            return type(parts)(*_with_other_signs(name, parts, variant))

        setattr(np.linalg, name, decompose)

    for name in originals:
        replace(name)
    try:
        yield calls
    finally:
        for name, original in originals.items():
            setattr(np.linalg, name, original)


def _disturbed(matrix: object, variant: int) -> np.ndarray:
    """Return a matrix with changes far below all tolerances, which make its values different."""
    matrix = np.asarray(matrix, dtype=float)
    noise = np.random.default_rng(variant).standard_normal(matrix.shape)
    if matrix.ndim > 1 and matrix.shape[-1] == matrix.shape[-2]:
        noise = noise + noise.swapaxes(-1, -2)
    return matrix + 1e-13 * np.abs(matrix).max(initial=0.0) * noise


def _with_other_signs(name: str, parts: tuple, variant: int) -> Iterator[np.ndarray]:
    """Yield the parts of a decomposition, with the opposite sign of every second vector."""
    for part in parts:
        if np.ndim(part) < 2:
            yield part
        elif name == "svd" and part is parts[-1]:
            yield part * _signs(part.shape[-2], variant)[:, None]
        else:
            yield part * _signs(part.shape[-1], variant)


def _signs(count: int, variant: int) -> np.ndarray:
    return np.where((np.arange(count) + variant) % 2, 1.0, -1.0)


# ---- source --------------------------------------------------------------------------------------


def _first_line(node: ast.AST) -> int:
    return min(
        [node.lineno, *(decorator.lineno for decorator in getattr(node, "decorator_list", ()))]
    )


def _blocks(tree: ast.AST) -> Iterator[list]:
    """Yield each list of statements inside a function."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.ClassDef, ast.Module)):
            continue
        for name in ("body", "orelse", "finalbody"):
            body = getattr(node, name, None)
            if isinstance(body, list) and body and isinstance(body[0], ast.stmt):
                yield body


def _inner_statements(tree: ast.AST) -> list:
    return [statement for body in _blocks(tree) for statement in body]


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _simple_statements(statement: slicing.Statement) -> Iterator[list]:
    inner = _inner_statements(statement.node)
    occupied = collections.Counter(
        line
        for node in inner
        for line in range(
            node.lineno, (node.end_lineno if isinstance(node, _SIMPLE) else node.lineno) + 1
        )
    )
    for node in inner:
        lines = range(node.lineno, node.end_lineno + 1)
        alone = all(occupied[line] == 1 for line in lines) and node.lineno != statement.node.lineno
        if isinstance(node, _SIMPLE) and alone and not _is_docstring(node):
            yield [statement.cell, node.lineno, node.end_lineno, sorted(_changed_names(node))]


def _changed_names(node: ast.AST) -> set:
    """Return the names of local variables that a simple statement may change."""
    targets = {
        ast.Assign: lambda: node.targets,
        ast.AugAssign: lambda: [node.target],
        ast.AnnAssign: lambda: [node.target],
        ast.Expr: lambda: [getattr(getattr(node.value, "func", None), "value", None)],
    }.get(type(node), list)()
    names = set()
    for target in targets:
        for part in target.elts if isinstance(target, (ast.Tuple, ast.List)) else [target]:
            while isinstance(part, (ast.Subscript, ast.Attribute, ast.Starred)):
                part = part.value
            if isinstance(part, ast.Name):
                names.add(part.id)
    return names


def _all_names(node: ast.AST) -> set:
    return {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}


def _bound_names(tree: ast.AST) -> Iterator[str]:
    """Yield each argument, and each name that gets a value."""
    for node in ast.walk(tree):
        if isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def _deletions(statement: slicing.Statement) -> Iterator[list]:
    """Yield an edit for each simple statement that can be deleted from its block."""
    bound = collections.Counter(_bound_names(statement.node))
    functions = [node for node in ast.walk(statement.node) if isinstance(node, _FUNCTIONS)]
    results = [node.body[-1] for node in functions if isinstance(node.body[-1], ast.Return)]
    for body in _blocks(statement.node):
        for node in body:
            own = collections.Counter(_bound_names(node))
            # Without its only value, a name might have one from another cell of the notebook.
            keeps_names = all(own[name] < bound[name] for name in own)
            is_simple = isinstance(node, _SIMPLE) and not _is_docstring(node)
            # Without its result, the function would only return None.
            if len(body) > 1 and is_simple and keeps_names and node not in results:
                blank = "\n" * (node.end_lineno - node.lineno)
                text = f"{' ' * node.col_offset}pass{blank}"
                yield [statement.cell, node.lineno, node.end_lineno, text]


def _words(statement: slicing.Statement) -> Iterator[list]:
    """Yield the library names, builtins and constructs that a statement uses."""
    for node in ast.walk(statement.node):
        line = getattr(node, "lineno", statement.node.lineno)
        if isinstance(node, ast.Attribute):
            yield [statement.cell, line, "name", node.attr]
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            for name in [getattr(node, "module", None), *(alias.name for alias in node.names)]:
                if name:
                    yield [statement.cell, line, "name", name]
        elif isinstance(node, ast.Name) and hasattr(builtins, node.id):
            yield [statement.cell, line, "name", node.id]
        for construct in _constructs_at(node):
            yield [statement.cell, line, "construct", construct]


def constructs_of(tree: ast.AST) -> Iterator[str]:
    """Yield the names of the constructs in some code."""
    for node in ast.walk(tree):
        yield from _constructs_at(node)


def _constructs_at(node: ast.AST) -> Iterator[str]:
    if type(node) in CONSTRUCTS:
        yield CONSTRUCTS[type(node)]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        yield "the operator @"
    if isinstance(node, _FUNCTIONS):
        inner = [child for child in ast.walk(node) if child is not node]
        called = {getattr(call.func, "id", "") for call in inner if isinstance(call, ast.Call)}
        if node.decorator_list:
            yield "a decorator"
        if any(isinstance(child, _FUNCTIONS) for child in inner):
            yield "a function inside a function"
        if node.name in called:
            yield "recursion"


# ---- running -------------------------------------------------------------------------------------


def _namespace() -> dict:
    return vars(sys.modules["__main__"])


def _define(version: list | None, recorder: object) -> None:
    """Run the statements of the answer again, with an edit in one of them."""
    for statement in _statements:
        node = _edited(statement, version) if version else None
        node = node or _parse_lines(statement, _lines_of(statement.cell))
        if recorder:
            node = _instrument(node, statement.cell)
        module = ast.fix_missing_locations(ast.Module([node], []))
        code = compile(
            module, f"code cell {statement.cell}", "exec", statement.future, dont_inherit=True
        )
        exec(code, _namespace())
    if recorder:
        _namespace().update(__step__=recorder.step, __note__=recorder.note)


def _lines_of(cell: int) -> list[str]:
    return _cells[cell - 1].split("\n")


def _parse_lines(statement: slicing.Statement, lines: list[str]) -> ast.stmt:
    """Parse a statement again, because an instrumented tree must not be used twice."""
    first, last = _first_line(statement.node), statement.node.end_lineno
    if not isinstance(statement.node, (*_FUNCTIONS, ast.ClassDef)):
        return statement.node
    return _parse_block(lines, first, last)


def _parse_block(lines: list[str], first: int, last: int) -> ast.stmt:
    tree = ast.parse("\n" * (first - 1) + "\n".join(lines[first - 1 : last]))
    return tree.body[0]


def _edited(statement: slicing.Statement, version: list) -> ast.stmt | None:
    """Return the statement with an edit, or None if the edit is in another statement."""
    cell, edit_first, edit_last, text = version
    first, last = _first_line(statement.node), statement.node.end_lineno
    if cell != statement.cell or not (first <= edit_first and edit_last <= last):
        return None
    lines = _lines_of(cell)
    new_lines = text.split("\n")
    lines[edit_first - 1 : edit_last] = new_lines
    return _parse_block(lines, first, last + len(new_lines) - (edit_last - edit_first + 1))


def _instrument(tree: ast.stmt, cell: int) -> ast.stmt:
    """Insert calls that count each statement inside functions and record what it changes."""
    if not isinstance(tree, (*_FUNCTIONS, ast.ClassDef)):
        return tree
    for body in list(_blocks(tree)):
        changed = []
        for node in body:
            is_fixed = _is_docstring(node) or isinstance(node, (ast.Global, ast.Nonlocal))
            if not is_fixed:
                changed.append(_call(f"__step__({cell}, {node.lineno})", node))
            changed.append(node)
            names = _changed_names(node) if isinstance(node, _SIMPLE) else ()
            if names and not isinstance(node, _JUMPS):
                call = f"__note__({cell}, {node.lineno}, {sorted(names)!r}, locals())"
                changed.append(_call(call, node))
        body[:] = changed
    return tree


def _call(source: str, node: ast.stmt) -> ast.stmt:
    call = ast.parse(source).body[0]
    for part in ast.walk(call):
        ast.copy_location(part, node)
    return call


class _Recorder:
    """Counts the statements of a run, and records the values after them."""

    def __init__(self) -> None:
        self.watched, self.watches_all = set(), False
        self.reset()

    def reset(self) -> None:
        self.counts, self.notes, self.calls = collections.Counter(), [], 0

    def count_call(self, frame: object, event: str, argument: object) -> None:
        self.calls += event in ("call", "c_call")

    def step(self, cell: int, line: int) -> None:
        self.counts[cell, line] += 1
        if self.counts.total() > MAX_STEPS:
            raise _TooManySteps

    def note(self, cell: int, line: int, names: list[str], values: dict) -> None:
        for name in names:
            is_watched = self.watches_all or (cell, line, name) in self.watched
            if is_watched and name in values and len(self.notes) < MAX_NOTES:
                self.notes.append([cell, line, name, plain_value(values[name])])


class _Tracer:
    """Records the same facts as `_Recorder` for unchanged code, with `sys.settrace`."""

    def __init__(self, names: set) -> None:
        self.names, self.notes = names, []
        self.counts, self.previous = collections.Counter(), {}

    def enter(self, frame: object, event: str, argument: object) -> object:
        code = frame.f_code
        if not code.co_filename.startswith("code cell ") or code.co_name.startswith("<"):
            return None
        return self.inside

    def inside(self, frame: object, event: str, argument: object) -> object:
        if event == "exception":
            self.previous.pop(frame, None)
        if event in ("line", "return") and frame in self.previous:
            cell, line = self.previous.pop(frame)
            for name, value in frame.f_locals.items():
                if name in self.names and len(self.notes) < MAX_NOTES:
                    self.notes.append([cell, line, name, plain_value(value)])
        if event == "line":
            place = int(frame.f_code.co_filename.removeprefix("code cell ")), frame.f_lineno
            self.counts[place] += 1
            self.previous[frame] = place
        return self.inside


def _seeds_of(code: str) -> tuple:
    return SEEDS if "rng" in code else SEEDS[:1]


def _run(code: str, seeds: tuple, recorder: _Recorder) -> dict:
    runs = []
    for seed in seeds:
        recorder.reset()
        if recorder.watches_all:
            sys.setprofile(recorder.count_call)
            outcome = _outcome(code, seed, MAX_OWN_SECONDS)
            sys.setprofile(None)
        else:
            outcome = _outcome(code, seed)
        counts = [[*place, count] for place, count in recorder.counts.items()]
        run = {"outcome": outcome, "counts": counts, "notes": recorder.notes}
        runs.append({**run, "calls": recorder.calls})
    first = runs[0]
    if not all(_are_equal(run["outcome"], first["outcome"]) for run in runs):
        first["outcome"] = ["varies"]
    # Questions leave out counts and values that depend on random numbers.
    for name in ("counts", "notes"):
        if not all(_are_equal(run[name], first[name]) for run in runs):
            first[name] = []
    return first


def _outcome(code: str, seed: int, seconds: float = MAX_SECONDS) -> list:
    """Return the outcome of a case: a value, the name of an exception, or "endless"."""
    namespace = {**_namespace(), "np": np, "rng": seed}
    try:
        *statements, last = ast.parse(code).body
        with _time_limit(seconds):
            exec(compile(ast.Module(statements, []), "<case>", "exec"), namespace)
            value = eval(compile(ast.Expression(last.value), "<case>", "eval"), namespace)
        return ["value", plain_value(value)]
    except BaseException as error:
        name = type(error).__name__
        if isinstance(error, _TooManySteps) or name in ("CallTimeout", "RecursionError"):
            return ["endless"]
        return ["error", name[:60]]


@contextlib.contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    def stop(*signal_and_frame: object) -> None:
        raise _TooManySteps

    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


def _are_equal(first: object, second: object) -> bool:
    return repr(first) == repr(second)
