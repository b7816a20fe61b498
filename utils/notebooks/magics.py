"""A code cell as Python, in which commands to the notebook do nothing.

`%matplotlib inline`, `!pip list` and `plot?` are for the one who sits before the notebook. Where
its functions are wanted, and nobody sits there, they are `None`. Every line keeps its number, so
that an error is told where its author finds it.
"""

from __future__ import annotations

import ast

# The bodies of these run in the notebook's own namespace; other cell magics hold another
# language, or throw-away code.
_PYTHON_MAGICS = ("%%time", "%%capture", "%%prun")
# For each command IPython reads the cell anew. A person writes a few; what is left after so many
# is a mistake in Python, which costs its cell.
_MOST_COMMANDS = 100


def parse_cell(source: str) -> ast.Module:
    """Parse a code cell.

    Parameters
    ----------
    source : str
        Python with IPython's additions to it.

    Returns
    -------
    ast.Module
        Its nodes stand in the lines of `source`.

    Raises
    ------
    SyntaxError
        It is no Python, magics or not.
    """
    try:
        tree = ast.parse(source)
    except SyntaxError:
        source = _without_magics(source)
        tree = ast.parse(source)
    return _Muted().visit(tree) if "get_ipython" in source else tree


class _Muted(ast.NodeTransformer):
    """Puts `None` where a method of IPython is called: that is what a magic turns into."""

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if ast.unparse(node.func).startswith("get_ipython()."):
            return ast.copy_location(ast.Constant(None), node)
        return self.generic_visit(node)


def _without_magics(source: str) -> str:
    """Python text of a cell with IPython magics."""
    blank = source[: len(source) - len(source.lstrip())].count("\n")
    source = source.split("\n", blank)[-1]
    first, _, rest = source.partition("\n")
    if first.lstrip().startswith("%%"):
        is_python = first.split()[0] in _PYTHON_MAGICS
        return "\n" * (blank + 1) + _without_magics(rest) if is_python else ""
    return "\n" * blank + _transform(source)


def _transform(source: str) -> str:
    """IPython's own translation; needed for few cells and slow to import."""
    from IPython.core.inputtransformer2 import TransformerManager

    class Manager(TransformerManager):
        """Fills up with blank lines what it makes one line of, and comes to an end."""

        def do_token_transforms(self, lines: list[str]) -> list[str]:
            for _ in range(_MOST_COMMANDS):
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
