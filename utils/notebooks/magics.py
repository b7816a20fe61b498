"""Parse a code cell as Python in which IPython commands do nothing.

Commands such as `%matplotlib inline`, `!pip list` and `plot?` only make sense in an open notebook.
`None` replaces them here, because the caller needs only the notebook's functions. Every line keeps
its number, so that an error points to the student's own line.
"""

from __future__ import annotations

import ast

# Cells with these magics run in the notebook's own namespace. Cells with other magics contain
# another language or throw-away code.
PYTHON_MAGICS = ("%%time", "%%capture", "%%prun")
# IPython reads the whole cell again for each command. A student writes a few commands; a cell with
# more commands than this limit is treated as invalid Python.
_MAX_COMMANDS = 100


def parse_cell(source: str) -> ast.Module:
    """Parse a code cell.

    Parameters
    ----------
    source : str
        Python, possibly with IPython commands.

    Returns
    -------
    ast.Module
        Its nodes have the line numbers of `source`.

    Raises
    ------
    SyntaxError
        The cell is not valid Python, even without its magics.
    """
    try:
        tree = ast.parse(source)
    except SyntaxError:
        source = _without_magics(source)
        tree = ast.parse(source)
    return _MagicsRemover().visit(tree) if "get_ipython" in source else tree


class _MagicsRemover(ast.NodeTransformer):
    """Replaces the calls into which IPython translates magics with `None`."""

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if ast.unparse(node.func).startswith("get_ipython()."):
            return ast.copy_location(ast.Constant(None), node)
        return self.generic_visit(node)


def hiding_magic(source: str) -> str:
    """Return the magic that keeps the code of a cell from the notebook, or an empty text."""
    magic, _, rest = source.lstrip().partition("\n")
    if not magic.startswith("%%"):
        return ""
    name = magic.split()[0]
    return hiding_magic(rest) if name in PYTHON_MAGICS else name


def _without_magics(source: str) -> str:
    """Translate a cell with IPython magics into Python."""
    if hiding_magic(source):
        return ""
    blank = source[: len(source) - len(source.lstrip())].count("\n")
    source = source.split("\n", blank)[-1]
    first, _, rest = source.partition("\n")
    if first.lstrip().startswith("%%"):
        return "\n" * (blank + 1) + _without_magics(rest)
    return "\n" * blank + _transform(source)


def _transform(source: str) -> str:
    """Translate magics with IPython, which is slow to import and needed by few cells."""
    from IPython.core.inputtransformer2 import TransformerManager

    class Manager(TransformerManager):
        """Pads joined lines with blank lines, and stops after `_MAX_COMMANDS` commands."""

        def do_token_transforms(self, lines: list[str]) -> list[str]:
            for _ in range(_MAX_COMMANDS):
                changed, lines = self.do_one_token_transform(lines)
                if not changed:
                    break
            return lines

        def do_one_token_transform(self, lines: list[str]) -> tuple[bool, list[str]]:
            changed, new = super().do_one_token_transform(lines)
            pairs = enumerate(zip(lines, new, strict=False))
            command = next((number for number, (old, now) in pairs if old != now), len(new))
            new[command + 1 : command + 1] = ["\n"] * (len(lines) - len(new))
            return changed, new

    return Manager().transform_cell(source)
