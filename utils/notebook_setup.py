"""Set up a notebook; its first cell calls `begin` after finding the course folder."""

from __future__ import annotations

import os

from utils import health
from utils.display import shell, show
from utils.lent import lend_answers
from utils.static_widgets import install_stand_in
from utils.tracebacks import hide_course_frames

# Figures and 3D scenes are dark on white. A dark notebook inverts them and rotates the hue by half
# a turn, so that blue stays blue. The first two selectors are for JupyterLab, the last for VS Code.
# An exported page shows cells that a notebook folds. The style shrinks such a cell to one line,
# which readers can drag open. Code is wrapped in exported pages, and in JupyterLab on a phone,
# where only 43 of up to 100 columns fit.
STYLE = """<style>
[data-jp-theme-light="false"] :is(.jp-RenderedImage, .jp-RenderedMarkdown) img,
[data-jp-theme-light="false"] .jp-RenderedHTML iframe[srcdoc],
.vscode-dark .output :is(img, iframe[srcdoc]) { filter: invert(0.9) hue-rotate(180deg); }
body.jp-Notebook .celltag_folded .cm-editor {
  height: 2.2em; overflow: auto; resize: vertical;
}
body.jp-Notebook .highlight pre { white-space: pre-wrap; overflow-wrap: anywhere; }
@media (max-width: 640px) {
  .jp-CodeCell .jp-Editor .cm-content {
    white-space: pre-wrap; overflow-wrap: anywhere; flex-shrink: 1;
  }
  .jp-CodeCell .jp-OutputArea-output pre { word-break: normal; overflow-wrap: anywhere; }
}
</style>"""

NOTEBOOK_BACKENDS = ("", "inline", "ipympl", "nbagg", "notebook", "widget")


def begin(number: str) -> None:
    """Check the installation and prepare the notebook for a lesson.

    Without ipywidgets, sliders are replaced by static ones. In a notebook, styles for dark themes
    are added. Tracebacks are shortened, and stored answers for the lesson become available.

    Parameters
    ----------
    number : str
        Number of the lesson, such as "06".
    """
    print(health())
    show_figures_inline()
    install_stand_in()
    if shell() is not None:
        show(STYLE, "")
    hide_course_frames()
    lend_answers(number)


def show_figures_inline() -> None:
    """Show figures below their cells, even if MPLBACKEND names a backend without notebooks.

    The kernel leaves such a backend as it is, and then no figure appears. Images for containers and
    clusters often set it.
    """
    backend = os.environ.get("MPLBACKEND", "").lower()
    known = backend in NOTEBOOK_BACKENDS or backend.startswith("module://")
    if getattr(shell(), "kernel", None) and not known:
        shell().enable_matplotlib("inline")
