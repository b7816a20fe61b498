"""Pages that need nothing beside them, from the templates in this folder."""

from __future__ import annotations

import functools
from pathlib import Path

import jinja2


@functools.cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render(template: str, **content: object) -> str:
    """Fill in a template of ``templates/``; whatever is filled in is text, and no HTML."""
    return _environment().get_template(template).render(**content)
