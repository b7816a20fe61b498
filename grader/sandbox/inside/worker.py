"""The process in which a student's code runs, and nothing else.

It reads its limits, then the notebook's code cells, then answers calls until the pipe closes.
It knows no expected answer, no score and no secret: whatever a student makes it say
is only an answer, and the judge decides whether the answer is right.

Run by `grader.sandbox`, inside the sandbox: ``python -I -B worker.py READ WRITE``.
"""

import ast
import builtins
import contextlib
import dataclasses
import operator
import os
import resource
import signal
import sys
import types
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

_HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(_HERE))

import importing  # noqa: E402
import semaphores  # noqa: E402
import syscalls  # noqa: E402
import wire  # noqa: E402
import wire_format  # noqa: E402

from utils.notebooks import slicing  # noqa: E402
from utils.notebooks.edits import Edit, edits_of  # noqa: E402
from utils.notebooks.forbidden import forbidden_part, refusal  # noqa: E402

LONGEST_TEXT = 400
# Of functions that call each other until one raises.
MOST_PLACES = 8
# What comes along with an attribute at most: a small tree, whose nodes have a few small values.
MOST_OBJECTS, MOST_ATTRIBUTES, MOST_NUMBERS = 64, 12, 12
SCALARS = (type(None), bool, int, float, np.generic)
# Names that are not there because the lesson does not allow what they are imported from.
_REFUSED: dict[str, str] = {}


def main(read_end: int, write_end: int) -> None:
    """Serve one notebook."""
    rules = wire.receive(read_end)
    volunteer_for_the_memory_killer()
    become_nobody(rules["user"])
    set_limits(rules["limits"])
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)  # for good, with the next line
    syscalls.deny(sockets=rules.get("sockets", True))
    semaphores.poll()
    sys.meta_path.insert(0, importing.Forbidden(rules["forbidden"]))
    wire.send(write_end, "ready")

    start = wire.receive(read_end)
    sys.meta_path.append(importing.Beside(start["modules"], rules["forbidden"]))
    statements, problems = slicing.parse_notebook(start["cells"])
    statements, own = with_given_code(statements, start["names"], start["given"])
    statements, refusals = without_forbidden(statements, rules["forbidden"])
    needed = slicing.slice_for(start["names"], statements)
    # No line of the student has run: this is still what their text says.
    # An answer may be a method of a class of one's own.
    uses = {name: used_by((name, *own), start["names"], statements) for name in start["names"]}
    lines = {name: slicing.lines_of((name, *own), statements) for name in start["names"]}
    alone = {
        name: slicing.places_of(definitions_of((name, *own), start["names"], statements))
        for name in start["names"]
    }
    mended = (start["mend"], *own) if start["mend"] else ()
    theirs = definitions_of(mended, start["names"], statements)
    # A helper may have passed checks of its own, so that of edits as likely these come later.
    own_first = sorted(theirs, key=lambda statement: start["mend"] not in statement.binds)
    edits = edits_of(start["cells"], own_first)
    told = [[edit.cell, edit.first, edit.last, edit.text] for edit in edits]
    read = {
        "problems": [*problems, *refusals],
        "uses": uses,
        "lines": lines,
        "alone": alone,
        "edits": told,
    }
    wire.send(write_end, read)

    namespace = make_namespace()
    failures = run(needed, namespace)
    lend_members(own, start["given"]["source"], namespace)
    missing = missing_from(namespace, start["names"], own)
    wire.send(write_end, {"problems": failures, "missing": missing})
    objects = {}
    while True:
        try:
            request = wire.receive(read_end)
        except wire.WireClosed:
            return
        if "whole" in request:
            # `exec`, `globals()` and the like bind names that nobody can read off the text.
            run(statements, namespace)
            missing = missing_from(namespace, start["names"], own)
            wire.send(write_end, {"missing": missing})
        elif "edit" in request:
            objects.clear()
            reply(write_end, request["id"], define(edits[request["edit"]], theirs, namespace))
        else:
            reply(write_end, request["id"], answer(request, namespace, objects))


def with_given_code(
    statements: list[slicing.Statement], names: list[str], given: dict
) -> tuple[list[slicing.Statement], frozenset[str]]:
    """Put the lesson's own code where it belongs.

    It takes the place of whatever the notebook makes of it, but for what the notebook may write
    anew: where it does so, above the last check of it, all runs as it stands there.

    Parameters
    ----------
    statements : list of slicing.Statement
        The notebook's.
    names : list of str
        What will be called.
    given : dict
        ``names`` that the lesson gives, those of them that are ``open`` to a notebook, and their
        ``source`` as it was released.

    Returns
    -------
    statements : list of slicing.Statement
    own : frozenset of str
        What the notebook has written anew.
    """
    released, _ = slicing.parse_notebook([given["source"]])
    # No place in the notebook is the lesson's fault.
    released = [dataclasses.replace(statement, cell=0) for statement in released]
    theirs, may_change = frozenset(given["names"]), frozenset(given["open"])
    ends = [slicing.end_of_checks(checked, statements) for checked in (may_change, names)]
    end = ends[0] or ends[1] or len(statements)
    kept, own = _less_given(statements, released, theirs, may_change, end)
    bound = theirs.union(*(statement.binds for statement in kept))
    if not own and not bound.issuperset(names):
        # Answers that are nowhere else are perhaps in a class below its checks.
        kept, own = _less_given(statements, released, theirs, may_change, len(statements))
    if not own:
        kept = [statement for statement in kept if statement.cell]
    return [*released, *kept], own


def _less_given(
    statements: list[slicing.Statement],
    released: list[slicing.Statement],
    theirs: frozenset[str],
    may_change: frozenset[str],
    end: int,
) -> tuple[list[slicing.Statement], frozenset[str]]:
    """A notebook without what it makes of the lesson's code; and what it may write anew, and does.

    Of that counts what stands above a position. What is as it was released stays in its place.
    """
    as_released = {ast.dump(statement.node): statement for statement in released}
    kept, own = [], set()
    for position, statement in enumerate(statements):
        about = (statement.binds | statement.changes) & theirs
        same = as_released.get(ast.dump(statement.node)) if about else None
        if same:
            kept.append(same)
        elif about and about <= may_change and position < end:
            kept.append(statement)
            own |= about
        elif not statement.changes & theirs and not (statement.binds and statement.binds <= theirs):
            kept.append(statement)
    return kept, frozenset(own)


def lend_members(own: Iterable[str], source: str, namespace: dict) -> None:
    """Give classes of the notebook the methods of the lesson's that they lack.

    Parameters
    ----------
    own : iterable of str
        Names of what the notebook has written anew.
    source : str
        Of what the lesson gives.
    namespace : dict
        The notebook's, in which these methods look up names.
    """
    if not own:
        return
    lessons = {}
    with contextlib.suppress(BaseException):  # of metaclasses, and names that mean something else
        for statement in slicing.parse_notebook([source])[0]:
            exec(slicing.compile_statement(statement, "the lesson"), namespace, lessons)
        for name in own:
            for member, value in vars(lessons[name]).items():
                is_method = isinstance(value, types.FunctionType) and not member.startswith("_")
                if is_method and not hasattr(namespace[name], member):
                    setattr(namespace[name], member, value)


def without_forbidden(
    statements: list[slicing.Statement], forbidden: Iterable[str]
) -> tuple[list[slicing.Statement], list[str]]:
    """Leave out imports that the lesson forbids; also return a sentence for each cell with one.

    The names that such a statement binds are remembered, for when they are missed. Where it lies
    within another statement, it raises.
    """
    kept, sentences = [], {}
    for statement in statements:
        modules = [module for _, module in slicing.imported_modules([statement])]
        refused = next((name for name in modules if forbidden_part(name, forbidden)), None)
        if refused:
            sentences[
                f"Code cell {statement.cell} imports {refused}, which is not allowed in this "
                "lesson: it does the exercise for you."
            ] = True
            _REFUSED.update(dict.fromkeys(statement.binds, refused))
            importing.refuse_imports(statement.node, forbidden)
        if not refused or not isinstance(statement.node, ast.Import | ast.ImportFrom):
            kept.append(statement)
    return kept, list(sentences)


def used_by(
    parts: tuple[str, ...], names: list[str], statements: list[slicing.Statement]
) -> list[str]:
    """The functions among `names` that an answer calls, directly or not: its parts call them."""
    needed = slicing.slice_for(parts, statements)
    bound = set().union(*(statement.binds for statement in needed))
    return [other for other in names if other in bound and other != parts[0]]


def definitions_of(
    parts: tuple[str, ...], names: list[str], statements: list[slicing.Statement]
) -> list[slicing.Statement]:
    """Where a notebook defines an answer, and the helpers that it has for it alone."""
    others = frozenset(names) - frozenset(parts)
    kinds = (ast.FunctionDef, ast.ClassDef)
    return [
        statement
        for statement in slicing.slice_for(parts, statements)
        if statement.cell and isinstance(statement.node, kinds) and not statement.binds & others
    ]


def define(edit: Edit, theirs: list[slicing.Statement], namespace: dict) -> dict:
    """Define some functions anew, one of them with an edit."""
    try:
        node = ast.parse(edit.statement).body[0]
        for statement in theirs:
            ends = statement.node.lineno <= edit.last and edit.first <= statement.node.end_lineno
            if statement.cell == edit.cell and ends:
                statement = dataclasses.replace(statement, node=node)
            exec(slicing.compile_statement(statement, f"code cell {statement.cell}"), namespace)
    except BaseException as error:
        return {"error": describe(error)}
    return {"result": None}


def missing_from(namespace: dict, names: list[str], own: frozenset[str]) -> list[str]:
    """The names that a notebook does not define, be it as a method of a class of its own."""
    classes = [namespace.get(name) for name in own]
    return [
        name
        for name in names
        if name not in namespace and not any(name in dir(class_) for class_ in classes)
    ]


def volunteer_for_the_memory_killer() -> None:
    """Ask Linux to end this process, and not the grader, when the machine runs out of memory."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")


def become_nobody(user: int | None) -> None:
    """Leave root for good: limits on processes do not bind root."""
    if user is not None:
        os.setgroups([])
        os.setgid(user)
        os.setuid(user)


def set_limits(limits: dict[str, int]) -> None:
    """Set resource limits that cannot be raised again."""
    for name, value in limits.items():
        which = getattr(resource, name)
        allowed = resource.getrlimit(which)[1]
        if allowed != resource.RLIM_INFINITY:
            value = min(value, allowed)
        resource.setrlimit(which, (value, value))


def make_namespace() -> dict:
    """A fresh `__main__`, with an IPython that agrees to everything and does nothing."""
    main_module = types.ModuleType("__main__")
    sys.modules["__main__"] = main_module
    builtins.get_ipython = lambda: _Agreeable()
    builtins.display = lambda *values, **options: None
    return main_module.__dict__


class _Agreeable:
    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *values, **options: None


def run(statements: Iterable[slicing.Statement], namespace: dict) -> list[dict]:
    """Execute statements one by one; describe each failure, by its own line where that is known."""
    failures = []
    for statement in statements:
        try:
            code = slicing.compile_statement(statement, f"code cell {statement.cell}")
            exec(code, namespace)
        except BaseException as error:  # SystemExit too: nothing a cell does ends the judging
            failure = describe(error)
            failure["place"] = (
                failure["place"] or f"code cell {statement.cell}, line {statement.node.lineno}"
            )
            failures.append(failure)
    return failures


def answer(request: dict, namespace: dict, objects: dict[int, object]) -> dict:
    """Do what a request asks for; the result, or what went wrong.

    A request names a function of the notebook, or a method or an attribute (with dots, an
    attribute's) of an object that an earlier answer left here under a number. With `each` there
    are several calls, and a list of what they return. `seconds`, where it is not None, are how long
    they may take.
    """
    try:
        if request["object"] is None:
            wanted = namespace[request["name"]]
        else:
            wanted = operator.attrgetter(request["name"])(objects[request["object"]])
        with interrupted_after(request["seconds"]):
            results = [wanted(*arguments, **request["keywords"]) for arguments in request["calls"]]
    except BaseException as error:
        return {"error": describe(error)}
    if request["each"]:
        return {"result": results}
    result = results[0] if results else wanted
    seen = observed(result, request["calls"][0]) if request["observe"] else {}
    if not request["calls"] and not callable(result):
        seen["beside"] = beside(request["object"], objects)
    if wire_format.is_plain(result):
        return {"result": result, **seen}
    kept = held(result, objects)
    if request["calls"]:
        seen |= {"beside": beside(kept["object"], objects), "methods": methods(result)}
    return {**kept, "callable": callable(result), **seen}


class TookTooLong(BaseException):
    """What is called goes on and on: few answers catch this."""


@contextlib.contextmanager
def interrupted_after(seconds: float | None) -> Iterator[None]:
    """Raise `TookTooLong` after some seconds of the processor: cheaper than another process.

    Code that catches it is interrupted again, and who sleeps is not; they have the judge's clock.
    """

    def stop(*signal_and_frame: object) -> None:
        raise TookTooLong

    if seconds is None:
        yield
        return
    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, seconds)
    try:
        yield
    finally:
        signal.signal(signal.SIGPROF, signal.SIG_IGN)
        signal.setitimer(signal.ITIMER_PROF, 0)


def held(value: object, objects: dict[int, object]) -> dict:
    """Keep an object, under a number by which it can be asked for."""
    objects[len(objects)] = value
    return {"object": len(objects) - 1, "type": type(value).__name__}


def beside(number: int, objects: dict[int, object]) -> list:
    """The attributes of an object, and of those that it leads to: who asks for one walks a tree.

    Two tables, as lists of columns: whose attribute, its name and its value, of plain ones; whose
    attribute, its name, the number and the type of the object that it holds, of the others.
    """
    plain, others = [[], [], []], [[], [], [], []]
    waiting = [number]
    for number in waiting:  # grows while it is walked
        attributes = getattr(objects[number], "__dict__", None)
        if type(attributes) is not dict or len(attributes) > MOST_ATTRIBUTES:
            continue
        for name, value in attributes.items():
            if is_small(value):
                row, table = (number, str(name), value), plain
            elif wire_format.is_plain(value) or callable(value):
                continue
            else:
                kept = held(value, objects)
                row, table = (number, str(name), *kept.values()), others
                if len(waiting) < MOST_OBJECTS:
                    waiting.append(kept["object"])
            for column, content in zip(table, row, strict=True):
                column.append(content)
    return [plain, others]


def is_small(value: object) -> bool:
    """Whether a value is a number, or a few of them."""
    if type(value) is np.ndarray:
        return value.size <= MOST_NUMBERS
    if type(value) in (list, tuple):
        return len(value) <= MOST_NUMBERS and all(isinstance(item, SCALARS) for item in value)
    return isinstance(value, SCALARS)


def methods(value: object) -> list[str]:
    """Names of the methods of an object's class; what is called is looked up only then."""
    names = [name for name, member in vars(type(value)).items() if callable(member)]
    return [name for name in names if not name.startswith("_")][:MOST_ATTRIBUTES]


def observed(result: object, arguments: list) -> dict:
    """What became of the arguments, and which of them share their memory with the result."""
    arrays = [value if isinstance(value, np.ndarray) else np.empty(0) for value in arguments]
    shared = [
        position
        for position, array in enumerate(arrays)
        if isinstance(result, np.ndarray) and np.shares_memory(result, array)
    ]
    return {"arguments": arguments, "shared": shared}


def reply(write_end: int, number: int, content: dict) -> None:
    """Send an answer, or say why it cannot be sent."""
    try:
        wire.send(write_end, {"id": number, **content})
    except wire.WireClosed:
        raise
    except wire_format.TooLarge:
        wire.send(
            write_end,
            {
                "id": number,
                "error": {
                    "type": "MemoryError",
                    "message": "it returned more data than any answer needs",
                },
            },
        )
    except Exception as error:  # an object that cannot be turned into an array, or read
        wire.send(write_end, {"id": number, "error": describe(error)})


def describe(error: BaseException) -> dict:
    """Plain data about an exception: type, message, the notebook's last line and function in it.

    And the lines of other functions that led there, the outermost first.
    """
    places, function, trace = {}, None, error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_filename.startswith("code cell "):
            places.pop(code, None)  # what calls itself has one place, the last
            places[code], function = f"{code.co_filename}, line {trace.tb_lineno}", code.co_name
        trace = trace.tb_next
    *through, place = places.values() or [None]
    try:
        message = str(error)
    except BaseException:
        message = ""
    if isinstance(error, NameError) and error.name in _REFUSED:
        error = refusal(_REFUSED[error.name])
        message = str(error)
    return {
        "type": type(error).__name__[:100],
        "message": message[:LONGEST_TEXT],
        "place": place,
        "through": through[:MOST_PLACES],
        "function": function and function[:100],
    }


def serve(read_end: int, write_end: int) -> None:
    """Serve one notebook, in silence: printing, reading and warnings do no harm."""
    silence = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(silence, standard)
    os.close(silence)
    main(read_end, write_end)


if __name__ == "__main__":
    serve(*(os.dup(int(number)) for number in sys.argv[1:3]))
