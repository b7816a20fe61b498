"""Improve nbgrader's feedback pages: exercise names next to scores, and offline formulas."""

from __future__ import annotations

import re

from nbformat import NotebookNode

from grader.course.mathml import STYLE, MathPage

# nbgrader's template labels a cell only with its type.
_KIND = re.compile(
    r'(<li><a href="#(?:test_)?(\w+)">)(?:Test cell|Coding free-response|Written response)(?=</a>)'
)

# nbgrader's template lets wide pictures overflow the page.
_PICTURES = "img { max-width: 100%; height: auto; }"


class FeedbackExporter(MathPage):
    """Exports the pages of ``nbgrader generate_feedback``."""

    def from_notebook_node(
        self, nb: NotebookNode, resources: dict | None = None, **options: object
    ) -> tuple[str, dict]:
        """Render a graded notebook as a page; see nbconvert."""
        page, resources = super().from_notebook_node(nb, resources, **options)
        page = page.replace("</head>", f"<style>{STYLE} {_PICTURES}</style></head>", 1)
        return _KIND.sub(r"\1\2", page), resources
