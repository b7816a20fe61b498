"""Totals over the term: lowest lessons are left out, and the pass mark is applied."""

import csv
import io
import itertools

import pytest

from grader.course.deadlines import Deadlines, TermRules
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.roster import Person
from grader.lms.exporters import EXPORTERS, ExportOptions
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.marks_table import marks_table
from grader.lms.overview import overview_of
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    combined_status,
)
from grader.lms.term import describe_term, term_result

LESSONS = ("01_point_clouds", "02_ransac_line", "03_ransac_plane", "06_filter_ground")
MOST = (10.0, 40.0, 50.0, 30.0)
DROP, PASS = TermRules(drop_lowest=1), TermRules(pass_mark=50)


def notebooks(*scores, status=None, penalties=(0.0,) * 4, student="ada"):
    """Return results in the lessons; a score of None is missing work, and (x,) waits."""
    found = []
    for lesson, most, score, penalty in zip(LESSONS, MOST, scores, penalties, strict=False):
        waits = isinstance(score, tuple)
        (score,) = score if waits else (score,)
        state = WAITING if waits else MISSING if score is None else MARKED
        stage = find_lesson(lesson).stage
        about = (student, stage, lesson, status or state, score, most, penalty)
        found.append(NotebookResult(*about))
    return found


def total(results, rules):
    term = term_result(results, rules)
    return term.points, term.max_score, [lesson[:2] for lesson in term.dropped]


def test_everything_counts_without_rules():
    term = term_result(notebooks(10.0, 20.0, None, 0.0), TermRules())
    assert (term.points, term.max_score, term.dropped) == (30.0, 130.0, ())
    assert (term.is_waiting, term.passed) == (False, None)


@pytest.mark.parametrize(
    ("scores", "dropped", "expected"),
    [
        ((9.0, 20.0, 30.0, 20.0), ["02"], (59.0, 90.0)),  # 50 % is less than 90, 60 and 67 %
        ((4.0, 20.0, 30.0, 20.0), ["01"], (70.0, 120.0)),  # the share decides, not the points
        ((9.0, None, 30.0, 20.0), ["02"], (59.0, 90.0)),  # missing work counts as 0
        ((5.0, 20.0, 50.0, 30.0), ["02"], (85.0, 90.0)),  # equal shares: more points are left out
        ((0.0, None, 0.0, 0.0), ["03"], (0.0, 80.0)),
        ((10.0, 40.0, 50.0, 30.0), ["03"], (80.0, 80.0)),
        ((None, None, None, None), ["03"], (None, 80.0)),  # missing work is not a 0
    ],
)
def test_the_lesson_with_the_lowest_share_is_left_out(scores, dropped, expected):
    assert total(notebooks(*scores), DROP) == (*expected, dropped)


def test_dropping_never_lowers_the_share():
    for scores in itertools.product((None, 0.0, 3.5, 9.0), (0.0, 38.0), (None, 25.0), (7.0, 30.0)):
        shares = [
            term_result(notebooks(*scores), TermRules(drop_lowest=count)).share
            for count in range(4)
        ]
        assert shares == sorted(shares), scores


def test_a_late_penalty_may_make_a_lesson_the_lowest():
    on_time = notebooks(9.0, 30.0, 40.0, 20.0)
    late = notebooks(9.0, 30.0, 40.0, 20.0, penalties=(0.0, 0.0, 35.0, 0.0))
    assert total(on_time, DROP) == (79.0, 100.0, ["06"])
    assert total(late, DROP) == (59.0, 80.0, ["03"])


def test_at_least_one_lesson_always_counts():
    """Early in a term, `drop_lowest` may exceed the number of lessons released so far."""
    rules = TermRules(drop_lowest=3)
    assert total(notebooks(7.0), rules) == (7.0, 10.0, [])
    assert total(notebooks(7.0, 40.0), rules) == (40.0, 40.0, ["01"])
    assert total(notebooks(7.0, 40.0, 30.0, None), rules) == (40.0, 40.0, ["01", "03", "06"])


def test_equal_lessons_are_left_out_in_their_order():
    equal = [NotebookResult("ada", "s", lesson, MARKED, 5.0, 20.0) for lesson in ("02", "01", "03")]
    assert term_result(equal, DROP).dropped == ("02",)
    assert term_result(equal, TermRules(drop_lowest=2)).max_score == 20.0


def test_excused_lessons_are_neither_dropped_nor_counted():
    results = notebooks(9.0, 20.0) + notebooks(1.0, 1.0, 1.0, 1.0, status=EXCUSED)[2:]
    assert total(results, DROP) == (9.0, 10.0, ["02"])
    for status in (EXCUSED, AUDITOR):
        term = term_result(
            notebooks(9.0, None, status=status), TermRules(drop_lowest=1, pass_mark=50)
        )
        assert (term.points, term.max_score, term.dropped, term.passed) == (None, 0.0, (), None)
        assert describe_term(term, PASS) == "No lesson counts."


@pytest.mark.parametrize(
    ("scores", "passed"),
    [
        ((10.0, 40.0, 15.0, 0.0), True),  # 65 of 130
        ((10.0, 40.0, 14.99, 0.0), False),
        ((10.0, 40.0, 14.9951, 0.0), True),  # shown as 65
        ((None, 40.0, 25.0, None), True),
        ((None, None, None, None), False),
        ((0.0, None, None, None), False),
    ],
)
def test_the_pass_mark_is_a_share_of_the_possible_points(scores, passed):
    assert term_result(notebooks(*scores), PASS).passed is passed


def test_sums_of_tenths_reach_the_pass_mark():
    tenths = [NotebookResult("ada", "s", f"{number}", MARKED, 0.1, 0.3) for number in range(3)]
    assert term_result(tenths, TermRules(pass_mark=100 / 3)).passed


def test_waiting_work_leaves_the_pass_mark_undecided():
    """The result may still change, because a grader may give waiting work fewer points."""
    for scores in ((10.0, 40.0, (30.0,), 0.0), (0.0, 0.0, (0.0,), 0.0), (1.0, (None,))):
        term = term_result(notebooks(*scores), TermRules(drop_lowest=1, pass_mark=50))
        assert term.is_waiting and term.passed is None
        assert "not final" in describe_term(term, PASS)


def test_a_dropped_lesson_counts_neither_for_nor_against_passing():
    rules = TermRules(drop_lowest=1, pass_mark=60)
    scores = (10.0, 40.0, 0.0, 3.0)  # 53 of 130, or 53 of 80 without 03
    assert term_result(notebooks(*scores), PASS).passed is False
    term = term_result(notebooks(*scores), rules)
    assert term.passed is True
    assert describe_term(term, rules) == (
        "53 of 80 points (66.3 %); without 03_ransac_plane; reaches the pass mark of 60 %."
    )
    assert "59.99 %" in describe_term(term_result(notebooks(5.999), TermRules()), TermRules())


# ---- where the rules are shown ------------------------------------------------------------------

ADA, BO, CY, DEE = Person("ada"), Person("bo", section="B"), Person("cy"), Person("dee")
RULES = TermRules(frozenset({"voxel_grid"}), 1, 60)


def results_of(by_person, rules):
    stages, all_results = [], []
    for own in by_person.values():
        all_results += own
        for stage in dict.fromkeys(result.stage for result in own):
            part = [result for result in own if result.stage == stage]
            known = [result.score for result in part if result.score is not None]
            most = sum(result.max_score for result in part)
            score = sum(known) if known else None
            stages.append(StageResult(part[0].student, stage, combined_status(part), score, most))
    return ClassResults(tuple(by_person), tuple(all_results), tuple(stages), rules=rules)


def class_with(rules):
    return results_of(
        {
            ADA: notebooks(10.0, 40.0, 0.0, 3.0),
            BO: notebooks(None, None, None, None, student="bo"),
            CY: notebooks(10.0, 40.0, (50.0,), 30.0, student="cy"),
            DEE: notebooks(9.0, 9.0, 9.0, 9.0, student="dee", status=AUDITOR),
        },
        rules,
    )


def scores(results, assignment=None):
    exported = EXPORTERS["csv"].write(ExportOptions(Course(), results, assignment))
    rows = list(csv.DictReader(io.StringIO(exported.content.decode("utf-8-sig"))))
    return {row.pop("Student"): row for row in rows}


def test_scores_csv_shows_totals_and_the_pass_mark():
    rows = scores(class_with(RULES))
    assert {id: (row["Total"], row["Out of"], row["Passed"]) for id, row in rows.items()} == {
        "out of": ("130", "130", ""),
        "ada": ("53", "80", "yes"),
        "bo": ("", "", "no"),
        "cy": ("80", "80", "waiting"),
        "dee": ("", "", ""),
    }
    assert rows["ada"]["03_ransac_plane"] == "0", "a dropped lesson stays in the table"


def test_marks_of_single_assignments_follow_no_rule_of_the_term():
    plain, ruled = class_with(TermRules()), class_with(RULES)
    assert scores(plain, "stage1_ransac") == scores(ruled, "stage1_ransac")
    options = [
        ExportOptions(Course(), results, "stage1_ransac", True) for results in (plain, ruled)
    ]
    assert collect_marks(options[0]).marks == collect_marks(options[1]).marks


def test_scores_csv_has_no_new_column_without_rules():
    rows = scores(class_with(TermRules()))
    assert "Passed" not in rows["ada"]
    assert (rows["ada"]["Total"], rows["ada"]["Out of"]) == ("53", "130")


def test_the_report_shows_totals_and_pass_marks():
    results = class_with(RULES)
    lessons = [find_lesson(lesson) for lesson in LESSONS]
    table = marks_table(lessons, results, {})
    assert [(row.total.text, row.passed.text) for row in table.rows] == [
        ("53 of 80", "yes"),
        ("–", "no"),
        ("80 of 80 …", "…"),
        ("aud.", ""),
    ]
    assert table.rows[0].total.meaning == "without 03"
    head = overview_of(results, Deadlines({}, rules=RULES), table, {})
    reach = "60 % of the possible points; reached by 1 of 3 students, not decided yet for 1."
    assert head.passed == reach
    assert head.mean.endswith("for 2 students with a mark.")
    assert (
        "Lessons that count in stage3_obstacles: 06 (30 points in total, without voxel_grid)."
        in head.counted
    )
    assert head.settings == (
        "exercises that do not count: voxel_grid; totals leave out each student's lowest lesson; "
        "pass mark 60 %"
    )
    plain = marks_table(lessons, class_with(TermRules()), {})
    assert not plain.has_pass_mark and plain.rows[0].total.text == "53 of 130"
    assert overview_of(class_with(TermRules()), None, plain, {}).passed == ""
