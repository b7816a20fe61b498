"""The commands, options, targets and links in the READMEs and guides exist."""

import argparse
import importlib.util
import re
import subprocess

import pytest
from nbgrader.apps import NbGraderApp

from grader.cli import build_parser
from grader.course.paths import PROJECT

GIT_FILES = subprocess.run(
    ["git", "ls-files", "*.md", ":!solutions/*_cell.md", ":!grader/site/*"],
    cwd=PROJECT,
    capture_output=True,
    text=True,
)
READMES = GIT_FILES.stdout.split() or [
    str(path.relative_to(PROJECT))
    for path in sorted([*PROJECT.glob("*/README.md"), *PROJECT.glob("docs/**/*.md")])
]
[VERBS] = [
    action.choices
    for action in build_parser()._actions
    if isinstance(action, argparse._SubParsersAction)
]
FENCED = re.compile(r"^```\w*\n(.*?)^```", re.M | re.S)


def text_of(readme):
    return (PROJECT / readme).read_text("utf-8")


def commands_in(text):
    """Yield the commands in a text: lines of fenced blocks and code between backticks."""
    for block in FENCED.findall(text):
        yield from (line.partition(" #")[0].strip() for line in block.split("\n"))
    yield from re.findall(r"`([^`\n]+)`", FENCED.sub("", text))


def commands(readme, program):
    """Return the arguments of all commands in a README that call a program."""
    start = re.compile(rf"(?:sudo |\S*/)?{program} (.+)")
    matches = [start.match(command) for command in commands_in(text_of(readme))]
    return [match[1] for match in matches if match]


def anchors(text):
    """Yield the anchors of a text's headings, to which links can point."""
    for heading in re.findall(r"^#+ (.+)$", FENCED.sub("", text), re.M):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def test_the_readmes_contain_commands():
    assert {"README.md", "docs/grading.md", "tests/README.md"} <= {*READMES}
    verbs = {rest.split()[0] for rest in commands("docs/grading.md", "python -m grader")}
    assert len(verbs & {*VERBS}) >= 8


@pytest.mark.parametrize("readme", READMES)
def test_every_grader_command_exists_with_its_options(readme):
    for rest in commands(readme, r"python3? -m grader"):
        verb, *words = rest.split()
        if verb == "--help" or readme == "docs/commands.md":  # the page is generated
            continue
        options = [
            word.split("=")[0].strip("[]") for word in words if word.strip("[").startswith("--")
        ]
        assert verb in VERBS, rest
        assert [
            option for option in options if option not in VERBS[verb]._option_string_actions
        ] == [], rest


@pytest.mark.parametrize("readme", READMES)
def test_every_nbgrader_command_exists(readme):
    for rest in commands(readme, "nbgrader"):
        assert rest.split()[0] in NbGraderApp.subcommands, rest


@pytest.mark.parametrize("readme", READMES)
def test_every_make_target_exists(readme):
    targets = re.findall(r"^([\w-]+):", (PROJECT / "Makefile").read_text("utf-8"), re.M)
    for rest in commands(readme, "make"):
        assert rest.split()[0] in targets, rest


@pytest.mark.parametrize("readme", READMES)
def test_every_module_to_run_exists(readme):
    for rest in commands(readme, r"python3? -m"):
        name = rest.split()[0]
        if name.partition(".")[0] in ("grader", "tests", "utils"):
            assert importlib.util.find_spec(name), rest


@pytest.mark.parametrize("readme", READMES)
def test_every_link_has_a_target(readme):
    prose = re.sub(r"`[^`\n]+`", "", FENCED.sub("", text_of(readme)))
    for link in re.findall(r"\]\((?!https?:|mailto:)([^)\s]+)\)", prose):
        path, _, anchor = link.partition("#")
        target = (PROJECT / readme).parent / path if path else PROJECT / readme
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target.read_text("utf-8")), link


def test_addresses_of_gradebooks_name_their_driver():
    """Without a driver in the address, SQLAlchemy looks for its default driver and fails."""
    addresses = re.findall(r'"(\w[\w+]*://[^"]+)"', text_of("docs/platforms/nbgrader.md"))
    databases = [address for address in addresses if not address.startswith("http")]
    assert {database.partition(":")[0] for database in databases} == {"sqlite", "postgresql+pg8000"}
