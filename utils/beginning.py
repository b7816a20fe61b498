"""What the first cell of each notebook does, once the course's folder is found."""

from __future__ import annotations

from utils import health
from utils.lent import lend_answers
from utils.showing import shell, show

# A figure is dark on white, and so is a scene in space. In a dark notebook both are turned round,
# and turned back in hue: blue stays blue. JupyterLab, then VS Code.
DARK = """<style>
[data-jp-theme-light="false"] :is(.jp-RenderedImage, .jp-RenderedMarkdown) img,
[data-jp-theme-light="false"] iframe[srcdoc],
.vscode-dark .output :is(img, iframe[srcdoc]) { filter: invert(0.9) hue-rotate(180deg); }
</style>"""


def begin(number: str) -> None:
    """Say whether everything is there, lend answers to stubs, and suit dark notebooks.

    Parameters
    ----------
    number : str
        Of the lesson, such as "06".
    """
    print(health())
    if shell() is not None:
        show(DARK, "")
    lend_answers(number)
