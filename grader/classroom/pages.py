"""Render self-contained pages from the templates in this folder."""

from __future__ import annotations

import functools
import re
from pathlib import Path
from urllib.parse import quote

import jinja2
from markupsafe import Markup, escape

from grader.course.paths import PROJECT
from grader.course.settings import course_title, version

TEMPLATES = Path(__file__).parent / "templates"


@functools.cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([TEMPLATES, PROJECT / "extension"]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["urlencode"] = lambda text: quote(printable_name(text))
    environment.globals |= {"course": course_title(), "version": version()}
    return environment


def render(template: str, **content: object) -> str:
    """Fill in a template from ``templates/`` or ``extension/``; all values are escaped.

    The name of a template is its path in one of these folders.
    """
    return _environment().get_template(template).render(**content)


def format_code(text: str) -> Markup:
    """Return a text as HTML with the parts between backticks formatted as code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def printable_name(student: str) -> str:
    """Return a student's name as valid Unicode, because a folder's name may contain other bytes."""
    return student.encode("utf-8", "replace").decode()
