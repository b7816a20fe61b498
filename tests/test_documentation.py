"""The generated parts of the documentation, and the version number in several files."""

import argparse
import itertools
import json
import re

import pytest

from grader import cli, documentation
from grader.course.lessons import all_lessons
from grader.course.paths import PROJECT
from grader.course.settings import course_title, stage_title, version
from utils.in_sandbox import INSTALLED


def page(name):
    return (PROJECT / name).read_text("utf-8")


def test_no_generated_page_is_stale():
    assert documentation.check(cli.build_parser()) == []


def test_every_command_and_option_is_in_the_reference():
    parts = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", page("docs/commands.md"), re.M | re.S))
    [commands] = [
        action.choices
        for action in cli.build_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    ]
    assert parts.keys() == commands.keys() and len(parts) >= 16
    for name, command in commands.items():
        options = {text for action in command._actions for text in action.option_strings}
        assert all(f"`{option}" in parts[name] for option in options - {"-h", "--help"}), name


@pytest.mark.parametrize(
    "path",
    sorted(
        [
            *PROJECT.glob("solutions/*/*/lesson.py"),
            *PROJECT.glob("docs/**/*.md"),
            PROJECT / "README.md",
        ]
    ),
    ids=lambda path: f"{path.parent.name}/{path.name}",
)
def test_every_table_begins_with_a_row_of_titles(path):
    """Without this row, a page shows bars and hyphens; screen readers read each title."""
    for above, row in itertools.pairwise(path.read_text("utf-8").splitlines()):
        if re.fullmatch(r"(# )?\|[-:| ]+\|", row):
            assert re.match(r"(# )?\|", above), above
            assert not re.search(r"\| *\|", above), above


def test_no_sentence_of_the_reference_becomes_a_list():
    assert re.findall(r"^\d+\. .*", page("docs/commands.md"), re.M) == []


def test_the_syllabus_has_the_minutes_and_points_of_each_notebook():
    text = page("docs/teaching.md")
    rows = re.findall(r"^\| (\d\d) \| \[.*?\]\((.*?)\) \| (\d+) \| (\d+) \|", text, re.M)
    assert [row[0] for row in rows] == [lesson.number for lesson in all_lessons()]
    for (_, link, minutes, points), lesson in zip(rows, all_lessons(), strict=True):
        assert (PROJECT / "docs" / link).resolve() == lesson.released
        notebook = lesson.released.read_text("utf-8")
        assert f"about {minutes} minutes" in "".join(json.loads(notebook)["cells"][0]["source"])
        assert int(points) == sum(map(int, re.findall(r'"points": (\d+)', notebook)))
    hours = sum(int(row[2]) for row in rows) / 60
    readme = page("README.md")
    assert f"about <!-- hours -->{hours:.0f}<!-- end --> hours" in readme
    weeks = re.findall(r"^\| \d \| .* \| ([\d.]+) \| (\d+) \|$", readme, re.M)
    assert [points for _, points in weeks[:4]] == ["100"] * 4  # a lecturer may add stages
    assert sum(float(hours) for hours, _ in weeks) == pytest.approx(hours, abs=0.2)


def test_stage_titles_have_a_fallback():
    assert stage_title("stage4_realtime") == "Real time"
    assert stage_title("stage5_own_lessons") == "own lessons"


def test_all_files_have_the_same_version(capsys):
    with pytest.raises(SystemExit):
        cli.main(["--version"])
    assert capsys.readouterr().out == f"{course_title()} {version()}\n"
    assert f"\nversion: {version()}\n" in page("CITATION.cff")
    assert re.findall(r"^## (.+)$", page("CHANGELOG.md"), re.M)[0] == version()


def test_the_threat_model_names_each_package_in_the_sandbox():
    [sentence] = re.findall(r"the packages (.*?)\. Modules that", page("docs/security.md"))
    named = {name.lower() for name in re.split(r", | and ", sentence)}
    assert named == {*INSTALLED, "ipython"}
