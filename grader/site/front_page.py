"""Build the front page: the goal and the panel of the course, and a card for each lesson."""

from __future__ import annotations

import base64
import importlib
import io
import json
import re
from dataclasses import dataclass

import nbformat
from PIL import Image, ImageSequence

from grader.course import durations
from grader.course.build import Origin
from grader.course.lessons import OPTIONAL_FOLDER, Lesson, every_lesson, optional_lessons, stages
from grader.course.paths import PROJECT
from grader.course.settings import stage_title
from grader.site.html_outputs import TEMPLATES
from grader.site.lesson import title_of
from grader.site.pictures import Pictures

README = PROJECT / "README.md"
# A course may have a panel at the top of its front page, with scripts of its own.
PANEL = PROJECT / "docs" / "front_page" / "panel.py"
FILM = re.compile(r"^!\[(.+?)\]\((\S+\.gif)\)$", re.M)
PREVIEW = re.compile(r"!\[(.*?)\]\(attachment:(\S+?)\)")
CARD_PIXELS = 480  # longer side of a card's picture in pixels
WEBP_QUALITY = 80  # WebP quality of the film
# Position of the still picture in the film, from 0 to 1. Readers who turn off animation see it.
STILL_POSITION = 0.45


@dataclass(frozen=True)
class LessonCard:
    """Content of a lesson's card on the front page."""

    number: str
    title: str
    address: str
    picture: str
    minutes: int
    writes: tuple[str, ...]


def page(origin: Origin, pictures: Pictures, pdf: str = "") -> str:
    """Render the front page as Markdown for MyST, with a link to the file `pdf` if there is one."""
    alt, film_path = FILM.search(README.read_text("utf-8")).groups()
    film = (PROJECT / film_path).read_bytes()
    return TEMPLATES.get_template("index.md").render(
        film=pictures.keep(_as_webp(film), ".webp"),
        still=pictures.keep(_extract_still(film), ".png"),
        size=Image.open(io.BytesIO(film)).size,
        alt=alt,
        panel=_panel(pictures),
        stages={
            name: [card(lesson, pictures) for lesson in _lessons_of(stage)]
            for stage, name in stage_titles()
        },
        lessons={name: _lessons_of(stage) for stage, name in stage_titles()},
        origin=origin,
        pdf=pdf,
    )


def _panel(pictures: Pictures) -> str:
    """Return the HTML of the course's own panel, or "" if the course has none."""
    if not PANEL.exists():
        return ""
    return importlib.import_module("docs.front_page.panel").panel(pictures.keep)


def stage_titles() -> list[tuple[str, str]]:
    """Return each stage with its title. The last entry is for optional lessons, if any."""
    titled = [
        (stage, f"Stage {number}: {stage_title(stage)}")
        for number, stage in enumerate(stages(), start=1)
    ]
    return [*titled, (OPTIONAL_FOLDER, "Optional")] if optional_lessons() else titled


def _lessons_of(stage: str) -> list[Lesson]:
    return [lesson for lesson in every_lesson() if lesson.stage == stage]


def card(lesson: Lesson, pictures: Pictures) -> LessonCard:
    """Build the card of a lesson, with its preview picture."""
    first = json.loads(lesson.released.read_text("utf-8"))["cells"][0]
    preview = PREVIEW.search("".join(first["source"]))
    picture = ""
    if preview:
        content = base64.b64decode(first["attachments"][preview[2]]["image/png"])
        # The alt text is empty, because the title next to the picture already describes the link.
        picture = pictures.tag(_scale_down(content), "", "")
    return LessonCard(
        lesson.number,
        title_of(lesson),
        f"{lesson.stage}/{lesson.name}.html",
        picture,
        durations.stated_minutes(nbformat.read(lesson.released, as_version=4)),
        tuple(exercise.name for exercise in lesson.machine_graded) or lesson.steps,
    )


def _scale_down(content: bytes) -> bytes:
    """Scale a picture down to the size of a card, as PNG."""
    with Image.open(io.BytesIO(content)) as picture:
        small = picture.convert("RGB")
    small.thumbnail((CARD_PIXELS, CARD_PIXELS))
    return _as_png(small)


def _as_webp(film: bytes) -> bytes:
    """Convert a film to WebP, which takes little more than half as many bytes as GIF."""
    with Image.open(io.BytesIO(film)) as picture:
        duration = picture.info["duration"]
        first, *others = [frame.convert("RGB") for frame in ImageSequence.Iterator(picture)]
    buffer = io.BytesIO()
    first.save(
        buffer,
        "WEBP",
        save_all=True,
        append_images=others,
        duration=duration,
        loop=0,
        quality=WEBP_QUALITY,
        method=2,
    )
    return buffer.getvalue()


def _extract_still(film: bytes) -> bytes:
    """Extract the still picture of a film, as PNG."""
    with Image.open(io.BytesIO(film)) as picture:
        picture.seek(int(picture.n_frames * STILL_POSITION))
        return _as_png(picture.convert("RGB"))


def _as_png(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.quantize(128).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
