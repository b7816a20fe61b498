"""What the READMEs tell people to type and to open is there."""

import argparse
import importlib.util
import re
import subprocess

import pytest
from nbgrader.apps import NbGraderApp

from grader.cli import parser
from grader.course.paths import PROJECT

LISTED = subprocess.run(
    ["git", "ls-files", "*README.md", "solutions/student_readme.md"],
    cwd=PROJECT,
    capture_output=True,
    text=True,
)
READMES = LISTED.stdout.split() or [
    str(path.relative_to(PROJECT)) for path in sorted(PROJECT.glob("*/README.md"))
]
[VERBS] = [
    action.choices for action in parser()._actions if isinstance(action, argparse._SubParsersAction)
]
FENCED = re.compile(r"^```\w*\n(.*?)^```", re.M | re.S)


def text_of(readme):
    return (PROJECT / readme).read_text("utf-8")


def typed(text):
    """The commands in a text: lines of fenced blocks, and what stands between backticks."""
    for block in FENCED.findall(text):
        yield from (line.partition(" #")[0].strip() for line in block.split("\n"))
    yield from re.findall(r"`([^`\n]+)`", FENCED.sub("", text))


def commands(readme, program):
    """What follows a program's name in the commands that begin with it."""
    begin = re.compile(rf"(?:sudo |\S*/)?{program} (.+)")
    found = [begin.match(command) for command in typed(text_of(readme))]
    return [one[1] for one in found if one]


def anchors(text):
    """Where links into a text may point."""
    for heading in re.findall(r"^#+ (.+)$", FENCED.sub("", text), re.M):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def test_there_are_some():
    assert {"README.md", "grader/README.md", "tests/README.md"} <= {*READMES}
    told = {rest.split()[0] for rest in commands("grader/README.md", "python -m grader")}
    assert len(told & {*VERBS}) > 10


@pytest.mark.parametrize("readme", READMES)
def test_every_verb_of_the_grader_is_one_with_these_options(readme):
    for rest in commands(readme, r"python3? -m grader"):
        verb, *words = rest.split()
        options = [
            word.split("=")[0].strip("[]") for word in words if word.strip("[").startswith("--")
        ]
        assert verb in VERBS, rest
        assert [
            option for option in options if option not in VERBS[verb]._option_string_actions
        ] == [], rest


@pytest.mark.parametrize("readme", READMES)
def test_every_command_of_nbgrader_is_one(readme):
    for rest in commands(readme, "nbgrader"):
        assert rest.split()[0] in NbGraderApp.subcommands, rest


@pytest.mark.parametrize("readme", READMES)
def test_every_target_of_make_is_one(readme):
    targets = re.findall(r"^([\w-]+):", (PROJECT / "Makefile").read_text("utf-8"), re.M)
    for rest in commands(readme, "make"):
        assert rest.split()[0] in targets, rest


@pytest.mark.parametrize("readme", READMES)
def test_every_module_to_run_is_one(readme):
    for rest in commands(readme, r"python3? -m"):
        name = rest.split()[0]
        if name.partition(".")[0] in ("grader", "tests", "utils"):
            assert importlib.util.find_spec(name), rest


@pytest.mark.parametrize("readme", READMES)
def test_every_link_points_to_something(readme):
    prose = re.sub(r"`[^`\n]+`", "", FENCED.sub("", text_of(readme)))
    for link in re.findall(r"\]\((?!https?:|mailto:)([^)\s]+)\)", prose):
        path, _, anchor = link.partition("#")
        there = (PROJECT / readme).parent / path if path else PROJECT / readme
        assert there.exists(), link
        if anchor:
            assert anchor in anchors(there.read_text("utf-8")), link


def test_addresses_of_gradebooks_name_their_driver():
    """Without, a traceback asks for one that nobody installs."""
    addresses = re.findall(r'"(\w[\w+]*://[^"]+)"', text_of("grader/README.md"))
    databases = [address for address in addresses if not address.startswith("http")]
    assert {database.partition(":")[0] for database in databases} == {"sqlite", "postgresql+pg8000"}
