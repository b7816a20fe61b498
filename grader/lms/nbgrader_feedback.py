"""nbgrader's feedback, in which each score says what it is of and formulas need no network."""

from __future__ import annotations

import re

from nbformat import NotebookNode

from grader.course.mathml import STYLE, MathPage

# nbgrader's template calls a cell by its kind alone.
_KIND = re.compile(
    r'(<li><a href="#(?:test_)?(\w+)">)(?:Test cell|Coding free-response|Written response)(?=</a>)'
)

# Nor does it make room for pictures that are wider than the page.
_PICTURES = "img { max-width: 100%; height: auto; }"


class FeedbackExporter(MathPage):
    """The pages of ``nbgrader generate_feedback``."""

    def from_notebook_node(
        self, nb: NotebookNode, resources: dict | None = None, **options: object
    ) -> tuple[str, dict]:
        """Make a page of a graded notebook; see nbconvert."""
        page, resources = super().from_notebook_node(nb, resources, **options)
        page = page.replace("</head>", f"<style>{STYLE} {_PICTURES}</style></head>", 1)
        return _KIND.sub(r"\1\2", page), resources
