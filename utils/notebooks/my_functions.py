"""Load your functions from another notebook without running all of it.

A notebook also loads clouds, draws them and plays films. This module skips such statements and
executes only those that the functions need.
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
from utils.notebooks.pasting import is_stub, text_to_paste
from utils.notebooks.reading import UnreadableNotebook, decode_notebook
from utils.notebooks.statements import Statement

_PROJECT = Path(__file__).resolve().parents[2]
# The top level of a notebook uses these modules only to show something: pictures, films, and
# streets that take seconds to simulate.
_PRESENTATION_MODULES = (
    "matplotlib.pyplot",
    "utils.by_hand",
    "utils.drive",
    "utils.films",
    "utils.plots",
    "utils.recording",
    "utils.scene3d",
    "utils.scenes",
)
_NOTEBOOKS_BEING_LOADED: set[Path] = set()  # guards against notebooks that load each other
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


def load_my_functions(
    name: str | os.PathLike, paste: str | Iterable[str] = ()
) -> SimpleNamespace | None:
    """Load the functions that you wrote in another notebook. Save that notebook first.

    Parameters
    ----------
    name : str or path
        A path, or a name such as ``"06_filter_ground.ipynb"``. A name is searched for in the
        working folder, in the folders next to it and in the course's ``notebooks``.
    paste : str or iterable of str, optional
        Names of functions to print, ready to paste, with everything they use from that notebook:
        imports, constants, other functions. Nothing runs in this case.

    Returns
    -------
    types.SimpleNamespace or None
        The functions and classes of the notebook as attributes; None if `paste` is given. A
        function that is still a stub has an attribute ``is_stub`` and raises NotImplementedError
        with an explanation when it is called.

    Raises
    ------
    FileNotFoundError
        The notebook does not exist; the message names the folders searched.
    ValueError
        The file is not a notebook.
    LookupError
        The notebook does not define a function to print.

    Notes
    -----
    Statements that the functions need are executed, for example to build a lookup table or load a
    cloud. Pictures, films and simulated streets are created only if a function that the notebook
    checks needs them. The notebook's output is discarded.

    Examples
    --------
    >>> ground = load_my_functions("06_filter_ground.ipynb")
    >>> obstacles = ground.filter_ground(cloud, -1.2)
    >>> load_my_functions("06_filter_ground.ipynb", paste="voxel_grid")
    """
    path = _find_notebook(Path(name).expanduser())
    if path in _NOTEBOOKS_BEING_LOADED:
        raise RecursionError(
            f"{path.name} loads its own functions, directly or through another notebook."
        )
    cells = _code_cells(path)
    if paste:
        print(text_to_paste([paste] if isinstance(paste, str) else paste, cells, path.stem))
        return None
    _NOTEBOOKS_BEING_LOADED.add(path)
    try:
        # Sliders are left out, because a slider runs the function that it decorates.
        statements = slicing.parse_notebook(cells)[0]
        statements = [found for found in statements if not _is_slider(found.node)]
        names = _defined_names(statements)
        return SimpleNamespace(**_execute(_needed_statements(names, statements), names, path.name))
    finally:
        _NOTEBOOKS_BEING_LOADED.remove(path)


def _find_notebook(name: Path) -> Path:
    """Find a notebook by its name in the usual folders."""
    if name.suffix not in ("", ".ipynb") and name.is_file():
        raise ValueError(f"{name} is not a notebook. Name a file that ends in .ipynb.")
    if name.suffix != ".ipynb":
        name = name.with_name(name.name + ".ipynb")
    here = Path.cwd()
    folders = [
        here,
        *sorted(path for path in here.parent.glob("*/") if path.is_dir()),
        *sorted((_PROJECT / "notebooks").glob("*/")),
    ]
    for folder in folders:
        # Folders of other users may not be readable.
        with contextlib.suppress(OSError):
            if (folder / name).is_file():
                return folder / name
    seen = sorted(
        {
            path.name
            for folder in (here, *(_PROJECT / "notebooks").glob("*/"))
            for path in folder.glob("*.ipynb")
        }
    )
    similar = difflib.get_close_matches(name.name, seen, n=1, cutoff=0.7)
    advice = f" Did you mean {similar[0]}?" if similar else ""
    alone = not (_PROJECT / "notebooks").is_dir()
    remedy = f"Upload your {name.name} next to this notebook" if alone else "Save it there"
    raise FileNotFoundError(
        f"There is no notebook {str(name)!r} in {here}, in the folders next to it or in the "
        f"course's notebooks.{advice} {remedy}, or give its path. The judge sees only one "
        "notebook, so paste the functions that it needs into that notebook."
    )


def _code_cells(path: Path) -> list[str]:
    """Return the source of a notebook's code cells."""
    try:
        cells = decode_notebook(path.read_bytes(), path.name).code
    except UnreadableNotebook:
        raise ValueError(
            f"{path} cannot be read as a notebook. Open it in Jupyter, save it "
            "there, and try again."
        ) from None
    for number, source in enumerate(cells, start=1):
        # The cache lets tracebacks show the line in which one of these functions fails.
        filename = _filename(path.name, number)
        linecache.cache[filename] = (len(source), None, source.splitlines(True), filename)
    return cells


def _filename(notebook: str, cell: int) -> str:
    return f"<{notebook}, code cell {cell}>"


def _is_slider(node: ast.stmt) -> bool:
    return isinstance(node, _DEFINITIONS) and any(
        "interact" in ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list
    )


def _defined_names(statements: list[Statement]) -> set[str]:
    """Return the names of the functions and classes that the statements define."""
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


def _needed_statements(names: set[str], statements: list[Statement]) -> list[Statement]:
    """Return the statements that functions need, in the order of the notebook.

    An exercise gets all statements that it needs, as in the judge. Any other function gets only
    definitions and plain constants if it would otherwise create pictures, films or simulations.
    """
    presentation = set(_presentation_names(statements))
    plain = [statement for statement in statements if _is_plain(statement.node)]
    kept = set()
    for name in names:
        needed = slicing.slice_for([name], statements)
        if not slicing.is_checked(name, statements) and any(
            statement.uses & presentation and not isinstance(statement.node, _DEFINITIONS)
            for statement in needed
        ):
            needed = slicing.slice_for([name], plain)
        kept.update(needed)
    return [statement for statement in statements if statement in kept]


def _presentation_names(statements: list[Statement]) -> Iterator[str]:
    """Yield the names under which a notebook imports presentation modules."""
    for statement in statements:
        if isinstance(statement.node, (ast.Import, ast.ImportFrom)):
            module = getattr(statement.node, "module", None)
            for alias in statement.node.names:
                origin = f"{module}.{alias.name}" if module else alias.name
                if any(
                    f"{origin}.".startswith(f"{presentation}.")
                    for presentation in _PRESENTATION_MODULES
                ):
                    yield alias.asname or alias.name.split(".")[0]


def _is_plain(node: ast.stmt) -> bool:
    """Return whether a statement is a definition, an import, or an assignment without a call."""
    if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
        return isinstance(node.value, ast.Lambda) or not any(
            isinstance(part, (ast.Call, ast.Await, ast.NamedExpr, ast.Yield, ast.comprehension))
            for part in ast.walk(node)
        )
    return isinstance(node, (*_DEFINITIONS, ast.Import, ast.ImportFrom))


def _execute(statements: list[Statement], names: set[str], notebook: str) -> dict[str, Callable]:
    """Execute statements; return the last definition of each function or class in `names`."""
    # Data classes look up their module by name. No import clashes with a name ending in ".ipynb".
    module = sys.modules[notebook] = ModuleType(notebook)
    found = {}
    with contextlib.redirect_stdout(io.StringIO()):  # output does not belong in this notebook
        for statement in statements:
            _execute_statement(statement, module)
            found.update(
                (name, getattr(module, name))
                for name in statement.binds & names
                if callable(getattr(module, name, None))
            )
    return found


def _execute_statement(statement: Statement, module: ModuleType) -> None:
    """Execute a statement in a module, but replace a stub with one that explains itself."""
    node, notebook = statement.node, module.__name__
    if is_stub(node):
        setattr(module, node.name, _stub(node.name, notebook))
        return
    # A statement that fails is skipped. A function that needs it fails with Python's own message
    # when it is called.
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
