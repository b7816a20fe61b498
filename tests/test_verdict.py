"""Storing, publishing and validating verdicts."""

import dataclasses
import json

import pytest

from grader.console import print_verdict
from grader.judging import verdict as verdict_module
from grader.judging.verdict import (
    JUDGED,
    CheckResult,
    ExerciseResult,
    Gain,
    MessageKind,
    Slip,
    Verdict,
    read_verdict,
    write_verdict,
)


def full_verdict():
    """Return a verdict in which every field has a value."""
    last = (False, MessageKind.SAME_REASON, "größer", "Hint: Look.")
    tests = (
        CheckResult("a", "Holds", True, 1.25, 1.25, "", True),
        CheckResult("test_b", "Fails", False, 0.0, 8.75, "For “größer”.", *last),
    )
    slip = Slip(3, 14, "    return x", "    return -x", 4.75)
    gain = Gain("filter_ground", 10.0, ("first", "second"), ("second",), 1.25, 6.0)
    about = ("filter_ground", 6.0, 10.0, tests, "It fails.", "test_b", slip, gain)
    exercises = (ExerciseResult(*about),)
    about = {"key": "of rules", "faults": ("no",), "starved": True, "fingerprint": "of a file"}
    return Verdict("06", "ada", JUDGED, 6.0, 10.0, exercises, ("A cell.",), 3.25, **about)


def test_a_verdict_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "new" / "folder" / "verdict.json"
    for verdict in (full_verdict(), dataclasses.replace(full_verdict(), exercises=(), faults=())):
        write_verdict(verdict, str(path))
        assert read_verdict(str(path)) == verdict
        assert [file.name for file in path.parent.iterdir()] == ["verdict.json"]


def test_a_published_verdict_has_only_some_fields():
    verdict = full_verdict()
    published = json.loads(json.dumps(verdict.as_dict()))
    shown = ("name", "title", "passed", "score", "max_score", "message", "visible")
    assert published == {
        "lesson": "06",
        "student": "ada",
        "status": "judged",
        "score": 6.0,
        "max_score": 10.0,
        "exercises": [
            {
                "name": "filter_ground",
                "score": 6.0,
                "max_score": 10.0,
                "tests": [
                    {name: getattr(test, name) for name in shown}
                    for test in verdict.exercises[0].tests
                ],
                "slip": {"cell": 3, "line": 14, "score": 4.75},
            }
        ],
        "problems": ["A cell."],
        "seconds": 3.25,
    }
    assert verdict == full_verdict()


def test_equal_parts_of_verdicts_share_memory():
    first, other = full_verdict().compact(), full_verdict().compact()
    assert first == other == full_verdict() and first.exercises[0] is other.exercises[0]
    another = dataclasses.replace(full_verdict().exercises[0], score=0.0)
    another = dataclasses.replace(full_verdict(), exercises=(another,)).compact()
    assert another.exercises[0].tests[1] is first.exercises[0].tests[1]
    assert another.exercises[0].score == 0.0
    assert verdict_module._intern.cache_info().maxsize > 5000  # room for all checks and outcomes


def test_a_valid_verdict_is_immutable_and_not_starved():
    verdict = full_verdict()
    assert verdict.without_starved_flag() == dataclasses.replace(verdict, starved=False) != verdict
    plain = Verdict("06", "ada", JUDGED, 0.0, 30.0, (), (), 0.0, "")
    assert (plain.faults, plain.starved, plain.fingerprint) == ((), False, "")
    exercise = ExerciseResult("f", 0.0, 1.0, ())
    assert (exercise.cause, exercise.first) == ("", "")
    for made in (verdict, *verdict.exercises, *verdict.exercises[0].tests):
        with pytest.raises(dataclasses.FrozenInstanceError):
            made.score = 100.0


@pytest.mark.parametrize(
    ("before", "score_text"),
    [
        ("    keep = z < level", "keep = z < level"),
        ("keep = (\n    z < level)", "keep = ("),
        ("  " + "x" * 130, "x" * 100),
    ],
)
@pytest.mark.parametrize("score", [0.0, 1.5])
def test_the_sentence_about_a_slip_has_its_place_and_its_score(before, score_text, score):
    slip = Slip(3, 7, before, "keep = z >= level", score)
    where = f"One change in code cell 3, line 7 (`{score_text}`) would correct this exercise."
    assert slip.sentence.startswith(where)
    assert ("the exercise keeps" in slip.sentence) == (score > 0)
    assert slip.__dataclass_params__.frozen


def change_of(*way, to):
    """Return a function that sets one field of a verdict file, or deletes it if `to` is None."""

    def change(content):
        *before, last = way
        for step in before:
            content = content[step]
        if to is None:
            del content[last]
        else:
            content[last] = to

    return change


@pytest.mark.parametrize(
    "change",
    [
        change_of("exercises", to=7),  # would raise TypeError
        change_of("exercises", to=None),  # would raise KeyError
        change_of("faults", to=None),
        change_of("score", to=None),
        change_of("more", to=1),
        change_of("exercises", 0, "tests", 0, "name", to=None),
        change_of("exercises", 0, "tests", 0, "name", to=[]),  # not hashable
    ],
)
def test_an_invalid_file_gives_no_verdict(tmp_path, change):
    path = tmp_path / "verdict.json"
    write_verdict(full_verdict(), path)
    content = json.loads(path.read_text("utf-8"))
    change(content)
    path.write_text(json.dumps(content), "utf-8")
    assert read_verdict(path) is None
    path.write_bytes(b"\xff" + path.read_bytes())
    assert read_verdict(path) is read_verdict(tmp_path / "none.json") is None


def test_lines_of_a_text_are_indented_next_to_its_mark(capsys):
    words = " ".join(["[bold]word"] * 30)
    test = CheckResult("a", "A title of " + words, False, 0.0, 1.0, "Because " + words, True)
    exercise = ExerciseResult("f", 0.0, 1.0, (test,), "", "a")
    print_verdict(dataclasses.replace(full_verdict(), exercises=(exercise,), problems=()))
    _, head, *lines, _, end = capsys.readouterr().out.rstrip().split("\n")
    assert head == "f: 0 of 1 points" and end.startswith("06: 0 of 1 points")
    assert len(lines) == 8 and lines[0].startswith("  FAILED  A title of [bold]word")
    assert lines[4].startswith(" " * 10 + "Because [bold]")
    assert all(line.startswith(" " * 10 + "[bold]") for line in (*lines[1:4], *lines[5:]))


def test_the_command_judge_says_why_the_judge_failed(capsys):
    verdict = dataclasses.replace(full_verdict(), status="judge_failed", faults=("Why.\nWhere.",))
    print_verdict(verdict)
    *_, why, where, _, end = capsys.readouterr().out.rstrip().split("\n")
    assert (why.strip(), where.strip(), end) == ("Why.", "Where.", "06: not judged")
    assert why.startswith("  ")  # a line of the fault cannot look like a result
