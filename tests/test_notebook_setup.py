"""What the first cell of a notebook brings beside tools: how the notebook looks elsewhere."""

import json
import re
from html import unescape

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter
from nbformat.v4 import new_code_cell, new_output

from tests.browser import BROWSER, seen
from tests.prerequisites import CHROMIUM
from utils.notebook_setup import STYLE

# For each cell of code: how high it is, and how far it reaches beyond its right edge.
MEASURE = """<script>addEventListener("load", () => {
  document.body.dataset.measured = JSON.stringify(
    [...document.querySelectorAll(".cm-editor")].map(
      cell => [cell.clientHeight, cell.querySelector("pre").scrollWidth - cell.clientWidth]));
});</script>"""


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER, reason=CHROMIUM)
def test_an_exported_page_folds_and_wraps(tmp_path):
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
    found = re.search(r'data-measured="([^"]*)"', seen(page, tmp_path, "")[0])[1]
    (line, _), (wrapped, beyond), (open_, _), (folded, _) = json.loads(unescape(found))
    assert wrapped > 2 * line and beyond <= 0
    assert open_ > 20 * line and folded < 2 * line
