"""Show output as HTML in a notebook and as text everywhere else."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell


def shell() -> InteractiveShell | None:
    """Return the running IPython shell, or None in plain Python."""
    # If IPython is running, it is already imported. Importing it here would be slow.
    ipython = sys.modules.get("IPython")
    return ipython.get_ipython() if ipython else None


def show(html: str, text: str) -> None:
    """Display HTML in a notebook; print text elsewhere.

    Parameters
    ----------
    html, text : str
        The same content in both formats.
    """
    if shell() is None:
        print(text)
        return
    from IPython.display import display

    display({"text/html": html, "text/plain": text}, raw=True)
