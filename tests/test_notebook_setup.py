"""The first cell of a notebook adds a style to exported pages."""

import json
import re
from html import unescape

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter
from nbformat.v4 import new_code_cell, new_output

from tests.browser import BROWSER, rendered_page
from tests.prerequisites import CHROMIUM
from utils.notebook_setup import STYLE

# Measures the height of each code cell, and how far its text extends beyond the right edge.
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
