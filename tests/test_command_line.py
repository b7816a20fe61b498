"""The command line: help texts are complete, and errors say what to do."""

import argparse

import pytest

from grader import cli, commands, console
from grader.course.lessons import optional_lessons
from grader.course.paths import PROJECT, Course

PARSER = cli.build_parser()
[COMMANDS] = [
    action.choices for action in PARSER._actions if isinstance(action, argparse._SubParsersAction)
]
SIX = PROJECT / "notebooks" / "stage3_obstacles" / "06_filter_ground.ipynb"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_a_description_an_example_and_help_for_each_option(name):
    command = COMMANDS[name]
    assert command.description.rstrip().endswith(".")
    assert max(map(len, command.description.splitlines())) < 80
    examples = command.epilog.splitlines()[1:]
    assert examples
    for example in examples:
        words = example.split("python -m grader ")[1].replace("'", "").split()
        PARSER.parse_args(words)  # exits if an example is wrong
    for action in command._actions:
        assert action.help and len(action.help.split()) >= 2, action


def test_the_example_commands_in_the_help_can_be_parsed(capsys):
    for call in cli.TERM_EXAMPLES:
        PARSER.parse_args(call.split())
    with pytest.raises(SystemExit):
        PARSER.parse_args(["--help"])
    text = capsys.readouterr().out
    places = [text.index(f"\n    {name} ") for name in ("doctor", "release", "grade", "new")]
    assert places == sorted(places)
    assert f"python -m grader {cli.TERM_EXAMPLES[0]}" in text


@pytest.mark.parametrize("value", ["0", "-3", "many"])
@pytest.mark.parametrize("call", ["demo --students", "demo --workers", "grade --workers"])
def test_numbers_must_be_at_least_1(call, value, capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main([*call.split(), value])
    assert ended.value.code == 2
    assert f"{call.split()[1]}: must be at least 1, not {value}." in capsys.readouterr().err


@pytest.fixture
def course(tmp_path, monkeypatch):
    """Return an empty course for the commands, and fail if they request a sandbox."""
    course = Course(tmp_path)
    monkeypatch.setattr(commands, "Course", lambda: course)
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: pytest.fail("requested a sandbox"))
    return course


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (PROJECT / "notebooks", "is a folder. Name one notebook,"),
        (PROJECT / "nothing.ipynb", "nothing.ipynb does not exist."),
        (PROJECT / "README.md", "README.md is not a notebook"),
        (optional_lessons()[0].released, "is an optional lesson. It is not graded"),
    ],
)
def test_judge_checks_the_file_before_it_requests_a_sandbox(file, message, course, capsys):
    assert cli.main(["judge", str(file)]) == 2
    assert message in capsys.readouterr().err


def test_an_archive_without_notebooks_is_an_error(course, capsys):
    status = cli.main(["collect", str(PROJECT / "README.md"), "--stage", "stage3_obstacles"])
    output = capsys.readouterr()
    assert status == 2
    assert "No notebook was collected for stage3_obstacles. Name another archive, or" in output.err
    assert "1 file\n" in output.out and "Collecting" not in output.err


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("similarity stage1_ransac", "collect ARCHIVE --stage stage1_ransac"),
        ("feedback", "There is no feedback to write yet."),
        ("collect nothing.zip --stage stage1_ransac", "nothing.zip does not exist."),
        ("report", "Nothing has been graded yet."),
    ],
)
def test_an_error_is_not_preceded_by_a_progress_bar(call, message, course, capsys):
    assert cli.main(call.split()) == 2
    output = capsys.readouterr()
    assert message in output.err and "━" not in output.err


def test_a_faulty_roster_is_reported_before_a_progress_bar(course, monkeypatch, sandbox, capsys):
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: sandbox)
    for command in ("grade", f"collect {SIX} --stage stage3_obstacles"):
        (course.root / "roster.csv").write_text("idd\nx\n")
        assert cli.main(command.split()) == 2
        output = capsys.readouterr()
        assert "roster.csv: the first line" in output.err and "━" not in output.err


def test_grade_suggests_collect_in_an_empty_course(course, monkeypatch, sandbox, capsys):
    monkeypatch.setattr(commands, "choose_sandbox", lambda *_: sandbox)
    assert cli.main(["grade"]) == 2
    assert "Run: python -m grader collect ARCHIVE --stage STAGE" in capsys.readouterr().err


def remaining_phrases(times, total, first=0):
    """Return the phrases about the remaining time if items are finished at these times."""
    clock = iter([0.0, *times])
    estimate = console.RemainingTime(lambda: next(clock))
    phrases = []
    for done in range(first, first + len(times) + 1):
        estimate.update(done, total)
        phrases.append(estimate.describe())
    return phrases


def test_the_remaining_time_follows_from_the_work_of_this_run():
    assert remaining_phrases([20, 40, 60], 84)[:3] == ["", "", ""], "too early for an estimate"
    assert remaining_phrases([20, 40, 60], 84)[3] == "about 27 minutes left"  # 81 items of 20 s
    assert remaining_phrases([20, 40, 60], 84, first=60)[3] == "about 7 minutes left"  # 21 items
    assert remaining_phrases([2, 4, 6], 30)[3] == "", "less than a minute"
    assert remaining_phrases([20] * 3, 12)[3] == "about 1 minute left"  # 3 at a time, 9 items


def test_long_work_is_announced_once_in_a_sentence(monkeypatch, capsys):
    clock = iter(range(0, 10_000, 30))
    estimate = console.RemainingTime(lambda: next(clock))
    monkeypatch.setattr(console, "RemainingTime", lambda: estimate)
    with console.progress_bar("Driving") as advance:
        for done in range(20):
            advance(done, 84, None)
    output = capsys.readouterr().err
    sentence = "Driving: about 40 minutes left, estimated after 3 of 84."
    assert output.count("estimated after") == 1 and sentence in output


def test_a_progress_bar_appears_when_work_begins(capsys):
    with console.progress_bar("Judging") as advance:
        advance(0, 0, "")
    assert "Judging" not in capsys.readouterr().err
    with console.progress_bar("Judging") as advance:
        advance(1, 2, "ada")
    assert "Judging: ada" in capsys.readouterr().err
    with console.progress_bar("Judging") as advance:
        advance(0, 0, "waiting for workers")
    assert "waiting for workers" in capsys.readouterr().err
