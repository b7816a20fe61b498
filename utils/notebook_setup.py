"""What the first cell of each notebook does, once the course's folder is found."""

from __future__ import annotations

from utils import health
from utils.display import shell, show
from utils.lent import lend_answers
from utils.static_widgets import stand_in
from utils.tracebacks import show_no_frames_of_ours

# A figure is dark on white, and so is a scene in space. In a dark notebook they are turned round,
# and turned back in hue: blue stays blue. JupyterLab, then VS Code.
# A page that a notebook is exported to has open what the notebook folds: one line of it is enough,
# and can be dragged open. Lines of code are wrapped there, and in JupyterLab on a phone, which
# shows 43 columns of the hundred that code may have.
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


def begin(number: str) -> None:
    """Say whether everything is there, do without sliders, lend answers, suit the dark.

    Parameters
    ----------
    number : str
        Of the lesson, such as "06".
    """
    print(health())
    stand_in()
    if shell() is not None:
        show(STYLE, "")
    show_no_frames_of_ours()
    lend_answers(number)
