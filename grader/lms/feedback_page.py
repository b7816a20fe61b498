"""A student's feedback as one self-contained HTML page that works offline."""

from __future__ import annotations

import functools
import re
from pathlib import Path

import jinja2
from markupsafe import Markup

from grader.classroom.pages import format_code
from grader.course.mathml import STYLE, markdown_page
from grader.course.settings import course_title, stage_title
from grader.lms.feedback import ExerciseFeedback, Feedback, LessonFeedback, SanitizedText
from grader.lms.results import format_points
from grader.untrusted_text import one_line


def feedback_page(feedback: Feedback) -> str:
    """Render a student's feedback page for a stage."""
    return render_template("feedback.html", feedback=feedback, style_of_formulas=STYLE)


def render_template(template: str, **content: object) -> str:
    """Fill in a template; texts in `content` are escaped."""
    return _environment().get_template(template).render(content)


def format_stage(stage: str) -> str:
    """Format a stage name as in "Stage 1 · Numbers"; other names are returned unchanged."""
    match = re.fullmatch(r"stage(\d+)_\w+", stage)
    return f"Stage {match[1]} · {stage_title(stage)}" if match else stage


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
        "points": format_points,
        "coded": format_code,
        "as_html": _as_html,
        "in_words": format_stage,
        "one_line": one_line,
    }
    environment.globals |= {
        "name_of": _name,
        "mark_of": _mark,
        "score_of": _score,
        "course": course_title(),
    }
    return environment


def _as_html(text: SanitizedText) -> Markup:
    return Markup(markdown_page(text.markdown, text.attachments))


def _name(feedback: ExerciseFeedback) -> str:
    """Return the name of a function unchanged, and the name of a written answer as words."""
    name = feedback.exercise.name
    return name.replace("_", " ") if feedback.exercise.by_hand else name


def _mark(feedback: ExerciseFeedback) -> str:
    if not feedback.counts:
        return "does not count"
    if feedback.mark.is_waiting:
        return f"not graded yet, of {format_points(feedback.exercise.points)}"
    return f"{format_points(feedback.mark.score)} of {format_points(feedback.exercise.points)}"


def _score(lesson: LessonFeedback) -> str:
    maximum = format_points(lesson.result.max_score)
    if lesson.result.score is None:
        return f"{lesson.result.status}, of {maximum}"
    return f"{format_points(lesson.result.score)} of {maximum}"
