"""Fetch functions out of a notebook of one's own, without running the notebook.

A notebook tells a story: it loads, draws, plays. Of that only what the functions need is executed.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import io
import linecache
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FunctionType, ModuleType, SimpleNamespace

from utils.notebooks import slicing
from utils.notebooks.pasting import is_stub, to_paste
from utils.notebooks.reading import UnreadableNotebook, decode_notebook
from utils.notebooks.statements import Statement

_PROJECT = Path(__file__).resolve().parents[2]
# What these do at the top level of a notebook is its story: pictures, films, and streets that
# take seconds to simulate.
_STORY = (
    "matplotlib.pyplot",
    "utils.drive",
    "utils.films",
    "utils.plots",
    "utils.recording",
    "utils.scene3d",
    "utils.scenes",
)
_LOADING: set[Path] = set()  # a notebook may load one that loads it
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def load_my_functions(
    name: str | os.PathLike, paste: str | Iterable[str] = ()
) -> SimpleNamespace | None:
    """Fetch the functions that you wrote in another notebook. Save that notebook first.

    Parameters
    ----------
    name : str or path
        Such as ``"06_filter_ground.ipynb"``. Looked for in the working folder, in the folders
        beside it and in the course's ``notebooks``; or give a path.
    paste : str or iterable of str, optional
        Names of functions to print, with all of that notebook that they use: imports, constants,
        other functions. They are ready to be pasted where they are needed, and nothing runs.

    Returns
    -------
    types.SimpleNamespace or None
        None where something is printed; else the functions and classes of the notebook, as
        attributes. A function that is still a stub raises NotImplementedError, with a sentence,
        when it is called; it has an attribute ``is_stub``.

    Raises
    ------
    FileNotFoundError
        There is no such notebook; the message says where it was looked for.
    ValueError
        The file is not a notebook.
    LookupError
        It does not define what is to be printed.

    Notes
    -----
    What the functions need runs: a table that they look things up in, a cloud that one of them
    uses. Pictures, films and simulated streets are made for none but those that the notebook
    checks, and whatever the notebook prints stays there.

    Examples
    --------
    >>> ground = load_my_functions("06_filter_ground.ipynb")
    >>> obstacles = ground.filter_ground(cloud, -1.2)
    >>> load_my_functions("06_filter_ground.ipynb", paste="voxel_grid")
    """
    path = _find(Path(name).expanduser())
    if path in _LOADING:
        raise RecursionError(f"{path.name} is waiting for its own functions.")
    cells = _cells(path)
    if paste:
        print(to_paste([paste] if isinstance(paste, str) else paste, cells, path.stem))
        return None
    _LOADING.add(path)
    try:
        # Sliders run what they decorate.
        statements = slicing.parse_notebook(cells)[0]
        statements = [found for found in statements if not _is_slider(found.node)]
        names = _functions(statements)
        return SimpleNamespace(**_execute(_needed(names, statements), names, path.name))
    finally:
        _LOADING.remove(path)


def _find(wanted: Path) -> Path:
    """The notebook of this name in the usual places."""
    if wanted.suffix != ".ipynb":
        wanted = wanted.with_name(wanted.name + ".ipynb")
    here = Path.cwd()
    folders = [
        here,
        *sorted(path for path in here.parent.glob("*/") if path.is_dir()),
        *sorted((_PROJECT / "notebooks").glob("*/")),
    ]
    for folder in folders:
        # Folders of other people may be closed to us.
        with contextlib.suppress(OSError):
            if (folder / wanted).is_file():
                return folder / wanted
    seen = sorted(
        {
            path.name
            for folder in (here, *(_PROJECT / "notebooks").glob("*/"))
            for path in folder.glob("*.ipynb")
        }
    )
    similar = difflib.get_close_matches(wanted.name, seen, n=1, cutoff=0.4)
    advice = f" Did you mean {similar[0]}?" if similar else ""
    alone = not (_PROJECT / "notebooks").is_dir()
    remedy = f"Upload your {wanted.name} beside this notebook" if alone else "Save it there"
    raise FileNotFoundError(
        f"There is no notebook {str(wanted)!r} in {here}, in the folders beside it or in the "
        f"course's notebooks.{advice} {remedy}, or give its path. (The judge sees one "
        "notebook only: paste what it needs into that notebook.)"
    )


def _cells(path: Path) -> list[str]:
    """Source of a notebook's code cells."""
    try:
        cells = decode_notebook(path.read_bytes(), path.name).code
    except UnreadableNotebook:
        raise ValueError(
            f"{path} cannot be read as a notebook. Open it in Jupyter, save it "
            "there, and try again."
        ) from None
    for number, source in enumerate(cells, start=1):
        # So that Python can show the line in which one of these functions fails.
        filename = _filename(path.name, number)
        linecache.cache[filename] = (len(source), None, source.splitlines(True), filename)
    return cells


def _filename(notebook: str, cell: int) -> str:
    return f"<{notebook}, code cell {cell}>"


def _is_slider(node: ast.stmt) -> bool:
    return isinstance(node, _DEFINITIONS) and any(
        "interact" in ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list
    )


def _functions(statements: list[Statement]) -> set[str]:
    """Names of the functions and classes that the statements define."""
    names = set()
    for statement in statements:
        value = getattr(statement.node, "value", None)
        if isinstance(statement.node, _DEFINITIONS):
            names.add(statement.node.name)
        elif isinstance(statement.node, (ast.Assign, ast.AnnAssign)) and (
            isinstance(value, ast.Lambda) or isinstance(value, ast.Name) and value.id in names
        ):
            names |= statement.binds
    return names


def _needed(names: set[str], statements: list[Statement]) -> list[Statement]:
    """The statements that functions need, in the order of the notebook.

    An exercise gets all that it needs, as the judge gives it. Another function gets that too,
    unless the story would be told for it: then it gets definitions and plain constants.
    """
    story = set(_story_names(statements))
    plain = [statement for statement in statements if _is_plain(statement.node)]
    kept = set()
    for name in names:
        needed = slicing.slice_for([name], statements)
        if not slicing.is_checked(name, statements) and any(
            statement.uses & story and not isinstance(statement.node, _DEFINITIONS)
            for statement in needed
        ):
            needed = slicing.slice_for([name], plain)
        kept.update(needed)
    return [statement for statement in statements if statement in kept]


def _story_names(statements: list[Statement]) -> Iterator[str]:
    """Names under which a notebook imports what tells its story."""
    for statement in statements:
        if isinstance(statement.node, (ast.Import, ast.ImportFrom)):
            module = getattr(statement.node, "module", None)
            for alias in statement.node.names:
                origin = f"{module}.{alias.name}" if module else alias.name
                if any(f"{origin}.".startswith(f"{teller}.") for teller in _STORY):
                    yield alias.asname or alias.name.split(".")[0]


def _is_plain(node: ast.stmt) -> bool:
    """Whether a statement defines or imports something, or names a constant without a call."""
    if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
        return isinstance(node.value, ast.Lambda) or not any(
            isinstance(part, (ast.Call, ast.Await, ast.NamedExpr, ast.Yield, ast.comprehension))
            for part in ast.walk(node)
        )
    return isinstance(node, (*_DEFINITIONS, ast.Import, ast.ImportFrom))


def _execute(needed: list[Statement], names: set[str], notebook: str) -> dict[str, Callable]:
    """Execute statements; the functions and classes of these names as they were last defined."""
    # Data classes look their module up. Nobody can import one with a dot before the suffix.
    module = sys.modules[notebook] = ModuleType(notebook)
    found = {}
    with contextlib.redirect_stdout(io.StringIO()):  # what a notebook prints is for its reader
        for statement in needed:
            _execute_one(statement, module)
            found.update(
                (name, getattr(module, name))
                for name in statement.binds & names
                if callable(getattr(module, name, None))
            )
    return found


def _execute_one(statement: Statement, module: ModuleType) -> None:
    """Execute a statement in a module; a stub says that it is one when it is called."""
    node, notebook = statement.node, module.__name__
    if is_stub(node):
        setattr(module, node.name, _stub(node.name, notebook))
        return
    # A statement that fails is passed over. Whoever needs it gets Python's own words when the
    # function is called.
    with contextlib.suppress(Exception, SystemExit):
        code = slicing.compile_statement(statement, _filename(notebook, statement.cell))
        exec(code, vars(module))


def _stub(name: str, notebook: str) -> FunctionType:
    def stub(*arguments: object, **keywords: object) -> None:
        raise NotImplementedError(
            f"{name} in {notebook} is still a stub. Write it there, save the notebook, and run "
            "load_my_functions again."
        )

    stub.__name__ = stub.__qualname__ = name
    stub.__doc__ = f"Still a stub in {notebook}."
    stub.is_stub = True
    return stub
