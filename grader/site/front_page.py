"""The front page: the film, what one builds, and a card for each lesson."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import dataclass

import nbformat
from PIL import Image, ImageSequence

from grader.course import durations
from grader.course.build import Origin
from grader.course.lessons import OPTIONAL, Lesson, every_lesson, optional_lessons, stages
from grader.course.paths import PROJECT
from grader.site.html_outputs import TEMPLATES
from grader.site.lesson import title_of
from grader.site.pictures import Pictures

README = PROJECT / "README.md"
FILM = re.compile(r"^!\[(.+?)\]\((\S+\.gif)\)$", re.M)
STAGE = re.compile(r"^\| (\d+) · ([^|]+?) \|", re.M)
PREVIEW = re.compile(r"!\[(.*?)\]\(attachment:(\S+?)\)")
CARD = 480  # pixels of its longer side
QUALITY = 80  # of the film
STILL = 0.45  # of the film, whose picture stands for it where nothing may move


@dataclass(frozen=True)
class LessonCard:
    """A lesson on the front page."""

    number: str
    title: str
    address: str
    picture: str
    minutes: int
    writes: tuple[str, ...]


def page(origin: Origin, pictures: Pictures) -> str:
    """The front page as Markdown for MyST."""
    alt, place = FILM.search(README.read_text("utf-8")).groups()
    film = (PROJECT / place).read_bytes()
    return TEMPLATES.get_template("index.md").render(
        film=pictures.keep(_light(film), ".webp"),
        still=pictures.keep(_still(film), ".png"),
        size=Image.open(io.BytesIO(film)).size,
        alt=alt,
        stages={name: [card(one, pictures) for one in _of(stage)] for stage, name in titles()},
        lessons={name: _of(stage) for stage, name in titles()},
        origin=origin,
    )


def titles() -> list[tuple[str, str]]:
    """Each stage with what the README calls it, and last what is beside the course."""
    known = dict(STAGE.findall(README.read_text("utf-8")))
    found = []
    for stage in stages():
        number, _, name = stage.removeprefix("stage").partition("_")
        found.append((stage, f"Stage {number}: {known.get(number, name.replace('_', ' '))}"))
    return [*found, (OPTIONAL, "Optional: beside the course")] if optional_lessons() else found


def _of(stage: str) -> list[Lesson]:
    return [lesson for lesson in every_lesson() if lesson.stage == stage]


def card(lesson: Lesson, pictures: Pictures) -> LessonCard:
    """What the front page says of a lesson, and its preview."""
    first = json.loads(lesson.released.read_text("utf-8"))["cells"][0]
    found = PREVIEW.search("".join(first["source"]))
    picture = ""
    if found:
        content = base64.b64decode(first["attachments"][found[2]]["image/png"])
        # The title beside it says where the link goes.
        picture = pictures.tag(_small(content), "", "")
    return LessonCard(
        lesson.number,
        title_of(lesson),
        f"{lesson.stage}/{lesson.name}.html",
        picture,
        durations.in_all(nbformat.read(lesson.solved, as_version=4)),
        tuple(exercise.name for exercise in lesson.machine_graded) or lesson.steps,
    )


def _small(content: bytes) -> bytes:
    """A picture no larger than a card needs it, as PNG."""
    with Image.open(io.BytesIO(content)) as picture:
        small = picture.convert("RGB")
    small.thumbnail((CARD, CARD))
    return _png(small)


def _light(film: bytes) -> bytes:
    """The same film as WebP, in little more than half the bytes."""
    with Image.open(io.BytesIO(film)) as picture:
        pace = picture.info["duration"]
        first, *others = [frame.convert("RGB") for frame in ImageSequence.Iterator(picture)]
    buffer = io.BytesIO()
    first.save(
        buffer,
        "WEBP",
        save_all=True,
        append_images=others,
        duration=pace,
        loop=0,
        quality=QUALITY,
        method=2,
    )
    return buffer.getvalue()


def _still(film: bytes) -> bytes:
    """One picture of a film, as PNG."""
    with Image.open(io.BytesIO(film)) as picture:
        picture.seek(int(picture.n_frames * STILL))
        return _png(picture.convert("RGB"))


def _png(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.quantize(128).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
