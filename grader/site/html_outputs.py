"""Convert outputs of a cell to HTML that needs no kernel, with pictures in separate files."""

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
from grader.site.widget_states import ANSWER_TYPE, POSITION_TYPE, QUESTION_TYPE

PATH_TO_ROOT = "../"  # from the folder of a lesson's stage to the root of the site
FILM_ALT = (
    "A film of the pictures that the cell above draws. The surrounding text describes the motion."
)
EMBEDDED_PICTURE = re.compile(
    r'<img src="data:image/(?:png|gif);base64,([^"]+)"( alt="[^"]*")?[^>]*>'
)
EMBEDDED_SCENE = re.compile(
    r'<iframe srcdoc="([^"]*)" title="([^"]*)" width="(\d+)" height="(\d+)"[^>]*></iframe>'
    r"<div>(.*?)</div>",
    re.S,
)
OVERWRITTEN_TEXT = re.compile(r"[^\n]*\r(?!\n)")
TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("grader.site"),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
)


def page_outputs(outputs: Sequence[NotebookNode], pictures: Pictures) -> list[NotebookNode]:
    """Convert the outputs of a cell for the page.

    Parameters
    ----------
    outputs : sequence of nbformat.NotebookNode
        Outputs as recorded by `grader.site.widget_states`.
    pictures : Pictures
        Collection to which the pictures are added.
    """
    first = next(
        (n for n, output in enumerate(outputs) if POSITION_TYPE in _data(output)), len(outputs)
    )
    converted = [_simplify_output(output, pictures) for output in outputs[:first]]
    if first < len(outputs):
        converted.append(_as_html(_positions(outputs[first:], pictures)))
    return converted


def _data(output: NotebookNode) -> dict:
    return output.get("data", {})


def _simplify_output(output: NotebookNode, pictures: Pictures) -> NotebookNode:
    if output.output_type == "stream":
        return new_output("stream", name=output.name, text=OVERWRITTEN_TEXT.sub("", output.text))
    html = html_of(output, pictures)
    return _as_html(html) if html else output


def _as_html(html: str) -> NotebookNode:
    return new_output("display_data", data={"text/html": html})


def html_of(output: NotebookNode, pictures: Pictures) -> str:
    """Convert an output to HTML; empty if the output is plain text."""
    data = _data(output)
    if QUESTION_TYPE in data:
        return TEMPLATES.get_template("question.html").render(
            data[QUESTION_TYPE], key=key_of(data[QUESTION_TYPE]["question"])
        )
    if ANSWER_TYPE in data:
        return TEMPLATES.get_template("answer.html").render(
            data[ANSWER_TYPE], key=key_of(data[ANSWER_TYPE]["question"])
        )
    for kind, alt in (("image/png", "A figure."), ("image/gif", FILM_ALT)):
        if kind in data:
            about = output.metadata.get(kind, {})
            content = base64.b64decode(data[kind])
            return pictures.tag(content, about.get("alt", alt), PATH_TO_ROOT, about.get("width"))
    if "text/html" in data:
        return _extract_files(data["text/html"], pictures)
    return ""


def key_of(question: str) -> str:
    """Return a key by which the page finds the answer to a question."""
    return hashlib.sha256(question.encode()).hexdigest()[:12]


def _extract_files(html: str, pictures: Pictures) -> str:
    """Replace embedded scenes and pictures in HTML with links to separate files."""

    def save_scene(match: re.Match) -> str:
        page, title, width, height, fallback = match.groups()
        place = pictures.keep(unescape(page).encode(), ".html")
        # A style shows the picture instead of the scene on paper, and to readers without scripts.
        # A scene hides the element that follows it, so the frame is the last element of a group.
        return (
            f'<div><div class="still">{save_picture(EMBEDDED_PICTURE.search(fallback))}</div>'
            f'<iframe class="scene" src="{PATH_TO_ROOT}{place}" title="{title}" loading="lazy" '
            f'width="{width}" height="{height}"></iframe></div>'
        )

    def save_picture(match: re.Match) -> str:
        alt = unescape((match[2] or ' alt="A picture."')[6:-1])
        return pictures.tag(base64.b64decode(match[1]), alt, PATH_TO_ROOT)

    return EMBEDDED_PICTURE.sub(save_picture, EMBEDDED_SCENE.sub(save_scene, html))


def _positions(outputs: Sequence[NotebookNode], pictures: Pictures) -> str:
    """Format recorded slider positions, so readers can switch between them without a script."""
    positions: list[dict] = []
    for output in outputs:
        if POSITION_TYPE in _data(output):
            positions.append({"about": _data(output)[POSITION_TYPE], "html": ""})
        else:
            positions[-1]["html"] += html_of(output, pictures) or _as_text(output)
    own_values = positions[0]["about"]["all"]
    name = hashlib.sha256("".join(part["html"] for part in positions).encode()).hexdigest()[:12]
    return TEMPLATES.get_template("positions.html").render(
        rows=list(_rows(own_values, positions)),
        positions=[part["html"] for part in positions],
        name=name,
        own=own_values,
        call=positions[0]["about"].get("call"),
    )


def _rows(
    own_values: list[list[str]], positions: list[dict]
) -> Iterator[tuple[str, list[tuple[int, str]]]]:
    """Yield each slider's title and sorted values, each value as (index in `positions`, value)."""
    for title, value in own_values:
        moved = [
            (number, recorded["about"]["value"])
            for number, recorded in enumerate(positions)
            if recorded["about"].get("slider") == title
        ]
        yield title, sorted([*moved, (0, value)], key=lambda position: float(position[1]))


def _as_text(output: NotebookNode) -> str:
    text = output.get("text", "") or _data(output).get("text/plain", "")
    return f"<pre>{escape(OVERWRITTEN_TEXT.sub('', text))}</pre>" if text.strip() else ""
