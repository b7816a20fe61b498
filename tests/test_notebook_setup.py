"""The first cell of a notebook adds a style to exported pages and lets figures appear."""

import json
import re
from html import unescape

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter
from nbformat.v4 import new_code_cell, new_output

from grader.course.paths import PROJECT
from tests.browser import BROWSER, rendered_page
from tests.notebook_runs import errors_of, outputs_of, run
from tests.prerequisites import CHROMIUM
from utils.notebook_setup import STYLE

# A script that measures the height of each code cell, and how far its text extends beyond the
# right edge.
MEASURE = """<script>addEventListener("load", () => {
  document.body.dataset.measured = JSON.stringify(
    [...document.querySelectorAll(".cm-editor")].map(
      cell => [cell.clientHeight, cell.querySelector("pre").scrollWidth - cell.clientWidth]));
});</script>"""


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER, reason=CHROMIUM)
def test_an_exported_page_folds_cells_and_wraps_lines(tmp_path):
    long, many = "x = [" + "1, " * 200 + "]", "y = 1\n" * 60
    style = new_output("display_data", data={"text/html": STYLE})
    notebook = nbformat.v4.new_notebook(
        cells=[
            new_code_cell("begin()", outputs=[style]),
            new_code_cell(long),
            new_code_cell(many),
            new_code_cell(many, metadata={"tags": ["folded"]}),
        ]
    )
    page = HTMLExporter().from_notebook_node(notebook)[0].replace("</body>", f"{MEASURE}</body>")
    measured = re.search(r'data-measured="([^"]*)"', rendered_page(page, tmp_path, "")[0])[1]
    (line, _), (wrapped, beyond), (open_, _), (folded, _) = json.loads(unescape(measured))
    assert wrapped > 2 * line and beyond <= 0
    assert open_ > 20 * line and folded < 2 * line


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["Agg", "TkAgg", None])
def test_figures_appear_whatever_backend_the_environment_names(tmp_path, monkeypatch, backend):
    """The kernel has its own display hook; a figure must appear even without `show`."""
    if backend is None:
        monkeypatch.delenv("MPLBACKEND", raising=False)
    else:
        monkeypatch.setenv("MPLBACKEND", backend)
    setup = f"import sys; sys.path.insert(0, {str(PROJECT)!r}); import utils; utils.begin('01')"
    figure = "import matplotlib.pyplot as plt\nplt.plot([1, 2])"
    notebook = nbformat.v4.new_notebook(cells=[new_code_cell(source) for source in (setup, figure)])
    run(notebook, tmp_path, kernel_name="python3")
    assert not errors_of(notebook)
    pictures = [
        output for _, output in outputs_of(notebook) if "image/png" in output.get("data", ())
    ]
    assert len(pictures) == 1
