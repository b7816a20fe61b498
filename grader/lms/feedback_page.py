"""A student's feedback as one HTML page that needs nothing beside it, and no network."""

from __future__ import annotations

import functools
import re
from pathlib import Path

import jinja2
from markupsafe import Markup

from grader.classroom.pages import coded
from grader.course.mathml import STYLE, markdown_page
from grader.lms.feedback import ExerciseFeedback, Feedback, LessonFeedback, Text
from grader.lms.results import write_number


def feedback_page(feedback: Feedback) -> str:
    """The page of a student for a stage."""
    return rendered("feedback.html", feedback=feedback, style_of_formulas=STYLE)


def rendered(template: str, **content: object) -> str:
    """One of the templates, filled in; all text in `content` is text."""
    return _environment().get_template(template).render(content)


def stage_in_words(stage: str) -> str:
    """Such as "Stage 3 · obstacles"; another name as it is."""
    found = re.fullmatch(r"stage(\d+)_(\w+)", stage)
    return f"Stage {found[1]} · {found[2].replace('_', ' ')}" if found else stage


@functools.cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "points": write_number,
        "coded": coded,
        "as_html": _as_html,
        "in_words": stage_in_words,
    }
    environment.globals |= {"name_of": _name, "mark_of": _mark, "score_of": _score}
    return environment


def _as_html(text: Text) -> Markup:
    return Markup(markdown_page(text.markdown, text.attachments))


def _name(one: ExerciseFeedback) -> str:
    """A function by its name, a written answer by what it is about."""
    name = one.exercise.name
    return name.replace("_", " ") if one.exercise.by_hand else name


def _mark(one: ExerciseFeedback) -> str:
    if one.mark.waiting:
        return f"to be graded, of {write_number(one.exercise.points)}"
    return f"{write_number(one.mark.score)} of {write_number(one.exercise.points)}"


def _score(lesson: LessonFeedback) -> str:
    most = write_number(lesson.result.max_score)
    if lesson.result.score is None:
        return f"{lesson.result.standing}, of {most}"
    return f"{write_number(lesson.result.score)} of {most}"
