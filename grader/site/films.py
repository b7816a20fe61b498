"""Films on the pages of lessons, which load only when a reader plays them."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from html import escape

from PIL import Image

from grader.course.films import FILM, POSTER
from grader.course.lessons import Lesson
from grader.site.pictures import Pictures

DESCRIPTION = "film.toml"


@dataclass(frozen=True)
class LessonFilm:
    """The film in a lesson's folder.

    Attributes
    ----------
    below : str
        Heading of the section that shows the film, below its first code cell.
    alt, caption : str
        Description for readers who cannot see the film, and the text below it.
    """

    lesson: Lesson
    below: str
    alt: str
    caption: str

    def html(self, pictures: Pictures, path_to_root: str) -> str:
        """Return the film as HTML, and add its files to the site."""
        film, poster = self.lesson.folder / FILM, self.lesson.folder / POSTER
        source = pictures.keep(film.read_bytes(), film.suffix)
        still = pictures.keep(poster.read_bytes(), poster.suffix)
        with Image.open(poster) as picture:
            width, height = picture.size
        return (
            f'<figure class="lesson-film"><video controls muted loop playsinline preload="none" '
            f'src="{path_to_root}{source}" poster="{path_to_root}{still}" width="{width}" '
            f'height="{height}" aria-label="{escape(self.alt)}"></video>'
            f"<figcaption>{escape(self.caption)}</figcaption></figure>"
        )


def film_of(lesson: Lesson) -> LessonFilm | None:
    """Return the film of a lesson, if the lesson has one."""
    path = lesson.folder / DESCRIPTION
    if not path.exists():
        return None
    return LessonFilm(lesson, **tomllib.loads(path.read_text("utf-8")))
