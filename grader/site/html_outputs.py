"""What a cell showed as HTML that needs no kernel, with its pictures in files of their own."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterator, Sequence
from html import escape, unescape

import jinja2
from nbformat import NotebookNode
from nbformat.v4 import new_output

from grader.site.pictures import Pictures
from grader.site.widget_states import ANSWER, POSITION, QUESTION

UP = "../"  # lessons lie in the folder of their stage
FILM = (
    "A film of what the cell above has drawn, frame by frame. The text around it says what moves."
)
DATA = re.compile(r'<img src="data:image/(?:png|gif);base64,([^"]+)"( alt="[^"]*")?[^>]*>')
SCENE = re.compile(
    r'<iframe srcdoc="([^"]*)" title="([^"]*)" width="(\d+)" height="(\d+)"[^>]*></iframe>'
    r"<div>(.*?)</div>",
    re.S,
)
OVERWRITTEN = re.compile(r"[^\n]*\r(?!\n)")
TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("grader.site"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
)


def shown(outputs: Sequence[NotebookNode], pictures: Pictures) -> list[NotebookNode]:
    """Outputs for the page.

    Parameters
    ----------
    outputs : sequence of nbformat.NotebookNode
        As `grader.site.widget_states` left them.
    pictures : Pictures
        Gets what they show.
    """
    first = next((n for n, one in enumerate(outputs) if POSITION in _data(one)), len(outputs))
    found = [_plain(output, pictures) for output in outputs[:first]]
    if first < len(outputs):
        found.append(_as_html(_positions(outputs[first:], pictures)))
    return found


def _data(output: NotebookNode) -> dict:
    return output.get("data", {})


def _plain(output: NotebookNode, pictures: Pictures) -> NotebookNode:
    if output.output_type == "stream":
        return new_output("stream", name=output.name, text=OVERWRITTEN.sub("", output.text))
    html = html_of(output, pictures)
    return _as_html(html) if html else output


def _as_html(html: str) -> NotebookNode:
    return new_output("display_data", data={"text/html": html})


def html_of(output: NotebookNode, pictures: Pictures) -> str:
    """An output as HTML; empty where it is only text."""
    data = _data(output)
    if QUESTION in data:
        return TEMPLATES.get_template("question.html").render(
            data[QUESTION], key=key_of(data[QUESTION]["question"])
        )
    if ANSWER in data:
        return TEMPLATES.get_template("answer.html").render(
            data[ANSWER], key=key_of(data[ANSWER]["question"])
        )
    for kind, alt in (("image/png", "A figure."), ("image/gif", FILM)):
        if kind in data:
            about = output.metadata.get(kind, {})
            content = base64.b64decode(data[kind])
            return pictures.tag(content, about.get("alt", alt), UP, about.get("width"))
    if "text/html" in data:
        return _with_files(data["text/html"], pictures)
    return ""


def key_of(question: str) -> str:
    """By which the page knows a question again, where its answer stands."""
    return hashlib.sha256(question.encode()).hexdigest()[:12]


def _with_files(html: str, pictures: Pictures) -> str:
    """The same HTML with scenes and pictures in files beside the page."""

    def scene(found: re.Match) -> str:
        page, title, width, height, instead = found.groups()
        place = pictures.keep(unescape(page).encode(), ".html")
        # What stands instead is for who runs no scripts; it would hide itself where one runs.
        return (
            f'<iframe class="scene" src="{UP}{place}" title="{title}" loading="lazy" '
            f'width="{width}" height="{height}"></iframe>'
            f"<noscript>{DATA.sub(picture, instead)}</noscript>"
        )

    def picture(found: re.Match) -> str:
        alt = unescape((found[2] or ' alt="A picture."')[6:-1])
        return pictures.tag(base64.b64decode(found[1]), alt, UP)

    return DATA.sub(picture, SCENE.sub(scene, html))


def _positions(outputs: Sequence[NotebookNode], pictures: Pictures) -> str:
    """The positions of sliders, one of which is shown, to choose among without a script."""
    found: list[dict] = []
    for output in outputs:
        if POSITION in _data(output):
            found.append({"about": _data(output)[POSITION], "html": ""})
        else:
            found[-1]["html"] += html_of(output, pictures) or _as_text(output)
    own = found[0]["about"]["all"]
    name = hashlib.sha256("".join(one["html"] for one in found).encode()).hexdigest()[:12]
    return TEMPLATES.get_template("positions.html").render(
        rows=list(_rows(own, found)), positions=[one["html"] for one in found], name=name, own=own
    )


def _rows(own: list[list[str]], found: list[dict]) -> Iterator[tuple[str, list[tuple[int, str]]]]:
    """For each slider its title and, in order, (number of the position, value)."""
    for title, value in own:
        moved = [
            (number, one["about"]["value"])
            for number, one in enumerate(found)
            if one["about"].get("slider") == title
        ]
        yield title, sorted([*moved, (0, value)], key=lambda position: float(position[1]))


def _as_text(output: NotebookNode) -> str:
    text = output.get("text", "") or _data(output).get("text/plain", "")
    return f"<pre>{escape(OVERWRITTEN.sub('', text))}</pre>" if text.strip() else ""
