"""Tables that remain readable on a narrow screen, where printed lines would be wrapped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from utils.display import show


def show_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Show a table with its first column aligned left and all others aligned right.

    Parameters
    ----------
    headings : sequence of str
        One per column; on a narrow screen, headings are wrapped.
    rows : iterable of sequences
        One value per column; `str` converts values to text.
    """
    cells = [[str(cell) for cell in row] for row in rows]
    show(_as_html(headings, cells), _as_text(headings, cells))


def _as_html(headings: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    # An empty heading becomes an ordinary cell, because screen readers announce headings.
    head = _row([("th" if cell else "td", cell) for cell in headings])
    rows = "".join(_row([("td", cell) for cell in row]) for row in cells)
    return f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"


def _row(cells: Sequence[tuple[str, str]]) -> str:
    cells_html = (
        f"<{tag} style='text-align:{'right' if column else 'left'}'>{escape(cell)}</{tag}>"
        for column, (tag, cell) in enumerate(cells)
    )
    return f"<tr>{''.join(cells_html)}</tr>"


def _as_text(headings: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(headings, *cells, strict=True)]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (headings, *cells)
    )
