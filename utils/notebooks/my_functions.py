"""Fetch functions out of a notebook of one's own, without running the notebook.

A notebook tells a story: it loads, draws, plays. Of that only what defines something is
executed: functions, classes, imports and plain constants.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import json
import linecache
import os
from pathlib import Path
from types import FunctionType, SimpleNamespace

_PROJECT = Path(__file__).resolve().parents[2]
# Their bodies are Python of the notebook's own namespace; other cell magics hold other things.
_PYTHON_MAGICS = ("%%time", "%%capture", "%%prun")


def load_my_functions(name: str | os.PathLike) -> SimpleNamespace:
    """Fetch the functions that you wrote in another notebook. Save that notebook first.

    Parameters
    ----------
    name : str or path
        Such as ``"06_filter_ground.ipynb"``. Looked for in the working folder, in the folders
        beside it and in the course's ``notebooks``; or give a path.

    Returns
    -------
    types.SimpleNamespace
        The functions and classes of the notebook, as attributes. A function that is still a
        stub raises NotImplementedError, with a sentence, when it is called; it has an attribute
        ``is_stub``.

    Raises
    ------
    FileNotFoundError
        There is no such notebook; the message says where it was looked for.
    ValueError
        The file is not a notebook.

    Examples
    --------
    >>> ground = load_my_functions("06_filter_ground.ipynb")
    >>> obstacles = ground.filter_ground(cloud, -1.2)
    """
    path = _find(Path(name).expanduser())
    namespace = {"__name__": path.stem}
    found = {}
    for number, source in enumerate(_code_cells(path), start=1):
        tree, filename = _parse(source), f"<{path.name}, code cell {number}>"
        # So that Python can show the line in which one of these functions fails.
        linecache.cache[filename] = (len(source), None, source.splitlines(True), filename)
        for node in filter(_defines, tree.body):
            bound = _execute(node, namespace, path.name, filename)
            found.update({key: namespace[key] for key in bound})
    return SimpleNamespace(**found)


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
    raise FileNotFoundError(
        f"There is no notebook {str(wanted)!r} in {here}, in the folders beside it or in the "
        f"course's notebooks.{advice} Save it there, or give its path. (The judge sees one "
        "notebook only: paste what it needs into that notebook.)"
    )


def _code_cells(path: Path) -> list[str]:
    """Source of each code cell."""
    try:
        cells = json.loads(path.read_bytes().decode("utf-8-sig"))["cells"]
        return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    except (ValueError, KeyError, TypeError):
        raise ValueError(
            f"{path} cannot be read as a notebook. Open it in Jupyter, save it "
            "there, and try again."
        ) from None


def _parse(source: str) -> ast.Module:
    """A cell as Python, line by line where it stands; empty where it is something else."""
    try:
        return ast.parse(source)
    except (SyntaxError, ValueError):
        lines = source.splitlines()
        if lines and lines[0].startswith("%%"):
            if not lines[0].startswith(_PYTHON_MAGICS):
                return ast.Module([], [])
            lines[0] = ""
    # `%matplotlib inline`, `!pip list`, `?plot`, `plot?`: commands of the notebook, not Python.
    plain = [
        "" if line.lstrip()[:1] in ("%", "!", "?") or line.rstrip().endswith("?") else line
        for line in lines
    ]
    try:
        return ast.parse("\n".join(plain))
    except (SyntaxError, ValueError):
        return ast.Module([], [])


def _defines(node: ast.stmt) -> bool:
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        # Sliders run what they decorate.
        return not any(
            "interact" in ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list
        )
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return True
    if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        plain = all(isinstance(target, (ast.Name, ast.Tuple)) for target in targets)
        return plain and (
            isinstance(node.value, ast.Lambda)
            or not any(
                isinstance(part, (ast.Call, ast.Await, ast.NamedExpr, ast.Yield, ast.comprehension))
                for part in ast.walk(node.value)
            )
        )
    return False


def _execute(node: ast.stmt, namespace: dict, notebook: str, filename: str) -> list[str]:
    """Execute one definition; the names of the functions and classes that it binds."""
    before = dict(namespace)
    if isinstance(node, ast.FunctionDef) and _is_stub(node):
        namespace[node.name] = _stub(node.name, notebook)
    else:
        code = compile(ast.Module([node], type_ignores=[]), filename, "exec")
        try:
            exec(code, namespace)
        except Exception:
            # A constant made from a cloud, a module that is not installed: part of the story.
            # Whoever needs it gets Python's own words when the function is called.
            return []
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        return []
    return [
        name
        for name, value in namespace.items()
        if value is not before.get(name)
        and isinstance(value, (FunctionType, type))
        or name == getattr(node, "name", None)
    ]


def _is_stub(function: ast.FunctionDef) -> bool:
    last = function.body[-1]
    return (
        isinstance(last, ast.Raise)
        and last.exc is not None
        and ast.unparse(last.exc).split("(")[0] == "NotImplementedError"
    )


def _stub(name: str, notebook: str) -> FunctionType:
    def stub(*arguments, **keywords):
        raise NotImplementedError(
            f"{name} in {notebook} is still a stub. Write it there, save the notebook, and run "
            "load_my_functions again."
        )

    stub.__name__ = stub.__qualname__ = name
    stub.__doc__ = f"Still a stub in {notebook}."
    stub.is_stub = True
    return stub
