"""A table that stays one on a narrow screen, where lines of text are broken."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from utils.display import show


def show_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Show rows below headings: the first column at the left, the others at the right.

    Parameters
    ----------
    headings : sequence of str
        One for each column; on a narrow screen these are wrapped.
    rows : iterable of sequences
        Text, or what `str` makes text of.
    """
    cells = [[str(cell) for cell in row] for row in rows]
    show(_as_html(headings, cells), _as_text(headings, cells))


def _as_html(headings: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    # A heading that says nothing is none: whoever listens to a table would hear an empty one.
    head = _row([("th" if cell else "td", cell) for cell in headings])
    rows = "".join(_row([("td", cell) for cell in row]) for row in cells)
    return f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"


def _row(cells: Sequence[tuple[str, str]]) -> str:
    written = (
        f"<{tag} style='text-align:{'right' if column else 'left'}'>{escape(cell)}</{tag}>"
        for column, (tag, cell) in enumerate(cells)
    )
    return f"<tr>{''.join(written)}</tr>"


def _as_text(headings: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(headings, *cells, strict=True)]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (headings, *cells)
    )
