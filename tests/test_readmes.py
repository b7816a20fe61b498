"""The commands, options, targets, links and paths in the READMEs, guides and lessons exist."""

import argparse
import importlib
import importlib.util
import json
import re
import shlex
import subprocess
from fnmatch import fnmatch
from pathlib import PurePosixPath

import pytest
from nbgrader.apps import NbGraderApp

from grader.cli import build_parser
from grader.course.lessons import all_lessons, optional_lessons
from grader.course.paths import PROJECT

GIT_FILES = subprocess.run(
    ["git", "ls-files"], cwd=PROJECT, capture_output=True, text=True
).stdout.splitlines()
READMES = [
    name
    for name in GIT_FILES
    if name.endswith(".md")
    and not name.endswith("_cell.md")
    and not name.startswith("grader/site/")
] or [
    str(path.relative_to(PROJECT))
    for path in sorted([*PROJECT.glob("*/README.md"), *PROJECT.glob("docs/**/*.md")])
]
LESSONS = [
    str(lesson.released.relative_to(PROJECT)) for lesson in (*all_lessons(), *optional_lessons())
]
# The docstrings of these programs contain sample calls.
PROGRAMS = ["utils/drive/__main__.py", "utils/play.py"]
PARSER = build_parser()
[VERBS] = [
    action.choices for action in PARSER._actions if isinstance(action, argparse._SubParsersAction)
]
FENCED = re.compile(r"^```\w*\n(.*?)^```", re.M | re.S)
# A folder, a path with a folder, or the name of a file.
PATH = re.compile(r"(?:[\w.-]+/)+[\w.-]*|[\w-]+\.(?:csv|db|html|json|jsonl|md|npz|py|toml|txt|zip)")
EXAMPLE = re.compile(r"_NN\b|_14\b|free_distance")


def text_of(readme):
    text = (PROJECT / readme).read_text("utf-8")
    if readme in LESSONS:
        cells = json.loads(text)["cells"]
        return "\n\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
    return text


def code_in(text):
    """Return the inline code of a Markdown text."""
    return re.findall(r"`([^`\n]+)`", FENCED.sub("", text))


def commands_in(text):
    """Yield the commands in a text: in fenced or indented blocks, or between backticks."""
    for block in FENCED.findall(text):
        lines = block.replace("\\\n", "").split("\n")
        yield from (line.partition(" #")[0].strip() for line in lines)
    yield from re.findall(r"^    (\S.*)", FENCED.sub("", text), re.M)
    yield from code_in(text)


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


def assert_parsed(parser, arguments):
    """Fail if a parser rejects the arguments of a documented command."""
    try:
        parser.parse_args(shlex.split(arguments))
    except SystemExit as ended:
        assert ended.code == 0, arguments  # 0 after --help


@pytest.mark.parametrize("readme", READMES)
def test_every_grader_command_can_be_parsed(readme):
    for call in commands(readme, r"python3? -m grader"):
        # A sentence may name a command without its arguments. The parser writes docs/commands.md.
        if call not in VERBS and readme != "docs/commands.md":
            assert_parsed(PARSER, call)


@pytest.mark.parametrize("readme", READMES)
def test_every_option_in_a_sentence_belongs_to_a_command(readme):
    all_options = {
        option for command in VERBS.values() for option in command._option_string_actions
    }
    for code in code_in(text_of(readme)):
        verb = VERBS.get(code.partition(" ")[0])
        options = re.findall(r"(?:^| )(--\w[\w-]*)", code)
        if verb or code.startswith("--"):
            assert {*options} <= {*(verb._option_string_actions if verb else all_options)}, code


@pytest.mark.parametrize("readme", READMES)
def test_every_option_is_marked_as_code(readme):
    """The website prints two hyphens in a sentence as a dash."""
    prose = re.sub(r"`[^`\n]+`|<!--.*?-->", "", FENCED.sub("", text_of(readme)))
    assert re.findall(r"(?<!\S)--\w.*", prose) == []


@pytest.mark.parametrize("readme", READMES)
def test_every_nbgrader_command_exists(readme):
    for rest in commands(readme, "nbgrader"):
        assert rest.split()[0] in NbGraderApp.subcommands, rest


@pytest.mark.parametrize("readme", READMES)
def test_every_make_target_exists(readme):
    targets = re.findall(r"^([\w-]+):", (PROJECT / "Makefile").read_text("utf-8"), re.M)
    for rest in commands(readme, "make"):
        assert rest.split()[0] in targets, rest


def test_no_make_target_depends_on_itself():
    targets = re.findall(r"^([.\w/-]+):(?!=)", (PROJECT / "Makefile").read_text("utf-8"), re.M)
    targets.remove(".PHONY")
    assert ".venv/ready-proof" in targets
    command = ["make", "--dry-run", "--always-make", *targets]
    made = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True)
    assert "Circular" not in made.stdout + made.stderr


@pytest.mark.parametrize("page", [*READMES, *LESSONS, *PROGRAMS])
def test_every_module_to_run_exists_and_takes_its_arguments(page):
    for call in commands(page, r"python3? -m"):
        name, _, arguments = call.partition(" ")
        if name.partition(".")[0] in ("grader", "tests", "utils"):
            spec = importlib.util.find_spec(name)
            assert spec, call
            if arguments and name.startswith("utils."):
                program = f"{name}.__main__" if spec.submodule_search_locations else name
                module = importlib.import_module(program)
                assert_parsed(module.build_parser(), arguments)


@pytest.mark.parametrize("readme", READMES)
def test_every_link_has_a_target(readme):
    prose = re.sub(r"`[^`\n]+`", "", FENCED.sub("", text_of(readme)))
    for link in re.findall(r"\]\((?!https?:|mailto:)([^)\s]+)\)", prose):
        path, _, anchor = link.partition("#")
        target = (PROJECT / readme).parent / path if path else PROJECT / readme
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target.read_text("utf-8")), link


@pytest.fixture(scope="module")
def tracked():
    """Return the paths of the course's files and folders, and the ends of these paths."""
    if not GIT_FILES:
        pytest.skip("this copy of the course has no git repository")
    files = map(PurePosixPath, GIT_FILES)
    parts = {place.parts for file in files for place in (file, *file.parents)}
    return {"/".join(path[start:]) for path in parts for start in range(len(path))}


@pytest.fixture(scope="module")
def written():
    """Return the patterns of the files that the grader writes, and its code, which names others."""
    ignored = (PROJECT / ".gitignore").read_text("utf-8").splitlines()
    patterns = [line.strip("/") for line in ignored if not line.startswith("#")]
    code = [path.read_text("utf-8") for path in (PROJECT / "grader").rglob("*.py")]
    return patterns, "".join(code)


@pytest.mark.parametrize("readme", READMES)
def test_every_path_in_a_sentence_exists_or_is_written_by_the_grader(readme, tracked, written):
    patterns, grader = written
    for code in filter(PATH.fullmatch, code_in(text_of(readme))):
        path = PurePosixPath(code)
        assert (
            str(path) in tracked
            or EXAMPLE.search(code)
            or any(fnmatch(path.parts[0], pattern) for pattern in patterns)
            or f'"{path.name}"' in grader
        ), code


def test_addresses_of_gradebooks_name_their_driver():
    """Without a driver in the address, SQLAlchemy looks for its default driver and fails."""
    addresses = re.findall(r'"(\w[\w+]*://[^"]+)"', text_of("docs/platforms/nbgrader.md"))
    databases = [address for address in addresses if not address.startswith("http")]
    assert {database.partition(":")[0] for database in databases} == {"sqlite", "postgresql+pg8000"}
