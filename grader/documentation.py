"""Generate parts of the documentation: syllabus, steps for students, and command reference.

In `PAGES_WITH_SECTIONS`, text between ``<!-- name -->`` and ``<!-- end -->`` is generated.
"""

from __future__ import annotations

import argparse
import itertools
import re
from collections.abc import Iterator
from pathlib import Path

import nbformat

from grader.course import durations
from grader.course.lessons import Lesson, all_lessons, stages
from grader.course.paths import PROJECT
from grader.course.settings import stage_title

COMMANDS = PROJECT / "docs" / "commands.md"
PAGES_WITH_SECTIONS = tuple(
    PROJECT / page for page in ("README.md", "docs/teaching.md", "notebooks/README.md")
)
_SECTION = re.compile(r"(<!-- (\w+) -->)(.*?)(<!-- end -->)", re.S)
_OPTION = re.compile(r"(?<!\S)--\w[\w-]*")
_OUTCOMES = re.compile(r"\*\*After this lesson you can\*\*\n((?:- .*\n)+)")


def generated_pages(parser: argparse.ArgumentParser) -> dict[Path, bytes]:
    """Return the existing pages with generated content, by path.

    The numbers come from the built notebooks, and the commands from the parser.
    """
    sections = {
        "hours": f"{round(sum(map(_stated_minutes, all_lessons())) / 60)}",
        "stages": f"\n{_stages_table()}",
        "lessons": f"\n{_lessons_table()}",
        "outcomes": f"\n{_outcomes_section()}",
        "work": f"\n{_work_section()}",
    }

    def fill_section(mark: re.Match) -> str:
        return mark[1] + sections[mark[2]] + mark[4]

    pages = {COMMANDS: _commands_page(parser)} if COMMANDS.is_file() else {}
    for path in filter(Path.is_file, PAGES_WITH_SECTIONS):
        pages[path] = _SECTION.sub(fill_section, path.read_text("utf-8"))
    return {path: text.encode() for path, text in pages.items()}


def write(parser: argparse.ArgumentParser) -> list[tuple[str, Path]]:
    """Write the pages that have changed; see `grader.course.build.build`."""
    changed = _changed_pages(parser)
    for path, text in changed.items():
        path.write_bytes(text)
    return [("wrote", path) for path in changed]


def check(parser: argparse.ArgumentParser) -> list[str]:
    """Return a sentence for each page that is out of date."""
    stale = [path.relative_to(PROJECT) for path in _changed_pages(parser)]
    return [f"{path} is out of date. Run: python -m grader build" for path in stale]


def _changed_pages(parser: argparse.ArgumentParser) -> dict[Path, bytes]:
    return {
        path: text for path, text in generated_pages(parser).items() if path.read_bytes() != text
    }


# ---- syllabus ------------------------------------------------------------------------------------


def _stated_minutes(lesson: Lesson) -> int:
    return durations.stated_minutes(nbformat.read(lesson.solved, as_version=4))


def lesson_title(lesson: Lesson) -> str:
    """Return the heading of a lesson's notebook, without the lesson's number."""
    heading = nbformat.read(lesson.released, as_version=4).cells[0].source.partition("\n")[0]
    return re.sub(r"^# (\d\d · )?", "", heading)


def _exercise_names(lesson: Lesson) -> str:
    return ", ".join(f"`{exercise.name}`" for exercise in lesson.machine_graded)


def _stages_table() -> str:
    rows = []
    for week, stage in enumerate(stages(), start=1):
        lessons = [lesson for lesson in all_lessons() if lesson.stage == stage]
        titles = ", ".join(f"{lesson.number} {lesson_title(lesson)}" for lesson in lessons)
        hours = sum(map(_stated_minutes, lessons)) / 60
        points = sum(exercise.points for lesson in lessons for exercise in lesson.exercises)
        rows.append(f"| {week} | {stage_title(stage)} | {titles} | {hours:.1f} | {points:g} |\n")
    return "| week | stage | lessons | hours | points |\n|---|---|---|---:|---:|\n" + "".join(rows)


def _lessons_table() -> str:
    rows = [
        f"| {lesson.number} "
        f"| [{lesson_title(lesson)}](../notebooks/{lesson.stage}/{lesson.name}.ipynb) "
        f"| {_stated_minutes(lesson)} | {sum(exercise.points for exercise in lesson.exercises):g} "
        f"| {_exercise_names(lesson)} |\n"
        for lesson in all_lessons()
    ]
    heading = "| no. | lesson | minutes | points | students write |\n|---|---|---:|---:|---|\n"
    return heading + "".join(rows)


def _outcomes_section() -> str:
    parts = []
    for stage, lessons in itertools.groupby(all_lessons(), key=lambda lesson: lesson.stage):
        parts.append(f"**{stage_title(stage)}.** After this stage, students can\n\n")
        for lesson in lessons:
            text = nbformat.read(lesson.released, as_version=4).cells[0].source
            if found := _OUTCOMES.search(text):
                # Links within the notebook would not work on this page.
                text = re.sub(r"\[([^]]+)\]\(#[^)]*\)", r"\1", found[1])
                # In a lesson, the outcomes address the student.
                text = re.sub(r"\byou\b", "they", re.sub(r"\byour\b", "their", text))
                parts.append(re.sub(r"[,.]$", "", text, flags=re.M))
        parts.append("\n")
    return "".join(parts)


def _work_section() -> str:
    """Return the steps for students, from the README in the students' zips."""
    path = PROJECT / "solutions" / "student_readme.md"
    if not path.is_file():
        return ""
    return re.search(r"^## Work\n\n(.*?)^## ", path.read_text("utf-8"), re.M | re.S)[1]


# ---- commands ------------------------------------------------------------------------------------


def _commands_page(parser: argparse.ArgumentParser) -> str:
    (action,) = parser._subparsers._group_actions
    parts = [
        "# Commands\n\nThis page is generated. "
        "`python -m grader COMMAND --help` shows the same text in a terminal.\n"
    ]
    for name, command in action.choices.items():
        parts.append("\n".join(_command_section(name, command)) + "\n")
    return "\n".join(parts)


def _command_section(name: str, command: argparse.ArgumentParser) -> Iterator[str]:
    usage = " ".join(command.format_usage().removeprefix("usage: ").split())
    # In one line, because a line that begins with "1." would begin a list.
    description = " ".join((command.description or "").split())
    yield f"## {name}\n\n{_mark_options(description)}\n"
    yield f"```\n{usage}\n```\n"
    options = [option for option in command._actions if option.dest != "help"]
    if options:
        yield "| argument | meaning |\n|---|---|"
    for option in options:
        help_text = command._get_formatter()._expand_help(option) if option.help else ""
        yield f"| {_format_argument(option)} | {_mark_options(help_text)} |".replace("  |", " |")
    if command.epilog:
        calls = "\n".join(map(str.strip, command.epilog.splitlines()[1:]))
        yield f"\nExamples:\n\n```sh\n{calls}\n```"


def _mark_options(text: str) -> str:
    """Mark options as code, because the website would turn two hyphens in text into a dash."""
    return _OPTION.sub(r"`\g<0>`", text)


def _format_argument(option: argparse.Action) -> str:
    value = option.metavar or (option.choices and "{" + ",".join(option.choices) + "}") or ""
    if not option.option_strings:
        return f"`{value}`"
    value = "" if option.nargs == 0 else f" {value or option.dest.upper()}"
    return ", ".join(f"`{text}{value}`" for text in option.option_strings)
