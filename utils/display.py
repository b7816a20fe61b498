"""Show something where a notebook is, and print it where there is none."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell


def shell() -> InteractiveShell | None:
    """The running IPython; None in plain Python."""
    # Nobody runs IPython without having imported it, and importing it takes a while.
    ipython = sys.modules.get("IPython")
    return ipython.get_ipython() if ipython else None


def show(html: str, text: str) -> None:
    """Display HTML in a notebook; print text elsewhere.

    Parameters
    ----------
    html, text : str
        The same in two ways.
    """
    if shell() is None:
        print(text)
        return
    from IPython.display import display

    display({"text/html": html, "text/plain": text}, raw=True)
