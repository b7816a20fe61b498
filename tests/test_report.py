"""The report shows the results of a class; its second version has no names."""

import base64
import dataclasses
import hashlib
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from grader.classroom.collect.instructor_answers import read_answers, store_answers
from grader.classroom.item_analysis import (
    common_messages,
    count_not_started,
    hardest_checks,
    items_of,
)
from grader.classroom.submissions import Submission
from grader.console import print_class
from grader.course.deadlines import TermRules
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import Course
from grader.course.roster import Person
from grader.intake.submission import SubmittedFiles
from grader.judging.verdict import (
    FAILED,
    JUDGED,
    CheckResult,
    ExerciseResult,
    Gain,
    MessageKind,
    Slip,
    Verdict,
)
from grader.lms.distribution import distribution_of
from grader.lms.marks_table import format_duration, marks_table
from grader.lms.report import MIN_SUBMISSIONS, GradingRun, write_report
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
)
from tests import prerequisites
from tests.browser import BROWSER, PDF_TO_TEXT, printed_lines, rendered_page

SIX, SEVEN = find_lesson("06_filter_ground"), find_lesson("07_filter_by_distance")
STAGE = SIX.stage


def check(passed, name="keeps", title="Keeps it", message="", points=1.0, visible=True, **about):
    return CheckResult(name, title, passed, points * passed, points, message, visible, **about)


def verdict(student, checks, cause="", lesson=SIX, **more):
    first = next((check.name for check in checks if not check.passed), "") if cause else ""
    score, most = sum(c.score for c in checks), sum(c.max_score for c in checks)
    exercise = ExerciseResult("filter_ground", score, most, tuple(checks), cause, first)
    return Verdict(lesson.name, student, JUDGED, score, most, (exercise,), (), 0.0, "", **more)


def submitted(verdict_of):
    lesson = find_lesson(verdict_of.lesson)
    return Submission(verdict_of.student, lesson, Path(f"{lesson.name}.ipynb")), verdict_of


def report(folder, verdicts, *about, **more):
    return write_report(Course(folder), [submitted(v) for v in verdicts], *about, **more).read_text(
        "utf-8"
    )


def result(student, status, score, penalty=0.0, lesson=SIX, most=30.0):
    return NotebookResult(student, STAGE, lesson.name, status, score, most, penalty)


STATES = {
    "missing": (MISSING, None, "–"),
    "zero": (MARKED, 0.0, "0"),
    "excused": (EXCUSED, None, "exc."),
    "excused, with work": (EXCUSED, 12.0, "(12)"),
    "waiting": (WAITING, 12.5, "12.5 …"),
    "not entered": (WAITING, None, "…"),
    "marked": (MARKED, 29.125, "29.1"),
}


def class_of(results, stages=(), unlisted=(), people=None):
    people = people or tuple(dict.fromkeys(Person(result.student) for result in results))
    return ClassResults(people, tuple(results), tuple(stages), unlisted)


@pytest.mark.parametrize("kind", STATES)
def test_each_state_of_a_notebook_has_its_own_cell_text(kind):
    status, score, shown = STATES[kind]
    (row,) = marks_table([SIX], class_of([result("ada", status, score)]), {}).rows
    assert row.cells[0].text == shown


def test_a_late_penalty_is_subtracted_and_explained():
    results = class_of(
        [result("ada", MARKED, 20.0, penalty=5.0)],
        [StageResult("ada", STAGE, MARKED, 20.0, 30.0, 5.0, late=timedelta(hours=27, minutes=5))],
    )
    table = marks_table([SIX], results, {})
    (row,) = table.rows
    assert row.cells[0].text == "15" and "20 minus 5" in row.cells[0].meaning
    assert (row.late.text, row.total.text) == ("1 d 3 h, −5", "15 of 30")
    assert table.has_late


def test_the_sum_includes_missing_notebooks_but_not_excused_ones():
    results = class_of(
        [
            result("ada", MARKED, 30.0),
            result("ada", MISSING, None, lesson=SEVEN),
            result("bo", EXCUSED, None),
            result("bo", WAITING, 10.0, lesson=SEVEN),
        ]
    )
    ada, bo = marks_table([SIX, SEVEN], results, {}).rows
    assert (ada.total.text, ada.total.meaning) == ("30 of 60", "1 missing")
    assert (bo.total.text, bo.total.meaning) == ("10 of 30 …", "1 waiting for a grader")


def test_students_missing_from_the_roster_are_counted_separately(tmp_path):
    verdicts, results = [verdict("yan ", [check(True)])], class_of([result("yan", MISSING, None)])
    page = report(tmp_path, verdicts, results)
    assert page.count("not in the gradebook") == 1 and "not on the roster" not in page
    (tmp_path / "roster.csv").write_text("id\nyan\n")
    page = report(tmp_path, verdicts, results)
    assert "1 student and 1 not on the roster, " in page
    assert page.count(">not on the roster<") == 1
    assert "1 students" not in page


def test_auditors_are_counted_separately_from_students(tmp_path):
    people = (Person("ada", section="A"), Person("guest", section="A", role="auditor"))
    results = class_of([result("ada", MARKED, 30.0), result("guest", AUDITOR, 20.0)], people=people)
    verdicts = [verdict(person.id, [check(True)]) for person in people]
    page = report(tmp_path, verdicts, results)
    assert "1 student, 1 auditor, 2 notebooks" in page
    assert '<td class="number" data-head="Students">1</td>' in page


def test_the_page_says_that_only_submissions_are_listed_if_there_is_no_roster(tmp_path):
    results = class_of([result("ada", MARKED, 1.0)], unlisted=("zoe",))
    note = "There is no roster.csv, so only students with a submission are listed."
    assert note in report(tmp_path, [], results)
    (tmp_path / "roster.csv").write_text("id\nada\n")
    page = report(tmp_path, [], results)
    assert note not in page
    assert "marks in the gradebook but are not on the roster: zoe." in page


def test_students_with_the_same_name_are_shown_with_their_ids(tmp_path):
    people = (Person("kim1", "Kim", "Lee"), Person("kim2", "Kim", "Lee"), Person("bo", "Bo", "Ek"))
    results = class_of([result(person.id, MARKED, 1.0) for person in people], people=people)
    rows = re.findall(r'<th scope="row">(.*?)</th>', report(tmp_path, [], results))
    assert [re.sub("<.*?>", "", row) for row in rows] == ["Kim Lee kim1", "Kim Lee kim2", "Bo Ek"]


def test_submission_times_are_in_the_courses_time_zone(tmp_path):
    submitted_at = datetime(2026, 7, 1, 22, 30, tzinfo=UTC)
    stage = StageResult("ada", STAGE, MARKED, 1.0, 30.0, submitted_at=submitted_at)
    (tmp_path / "deadlines.toml").write_text('timezone = "Europe/Berlin"\n')
    page = report(tmp_path, [], class_of([result("ada", MARKED, 1.0)], [stage]))
    assert "submitted 02 July 2026, 00:30 CEST" in page


def test_the_mean_of_a_section_includes_only_students_with_a_mark():
    people = tuple(Person(name, section=name[0].upper()) for name in ("a1", "a2", "a3", "b1"))
    results = class_of(
        [
            result("a1", MARKED, 15.0, penalty=3.0),
            result("a1", EXCUSED, 0.0, lesson=SEVEN),
            result("a2", MARKED, 30.0),
            result("a2", MISSING, None, lesson=SEVEN),
            result("a3", MISSING, None),
            result("b1", EXCUSED, None),
            result("guest", AUDITOR, 30.0),
        ],
        people=(*people, Person("guest", section="B", role="auditor")),
    )
    a, b = marks_table([SIX, SEVEN], results, {}).sections
    assert (a.name, a.student_count, a.marked_count, a.mean) == (
        "A",
        3,
        2,
        pytest.approx((0.4 + 0.5) / 2),
    )
    assert (b.name, b.student_count, b.marked_count, b.mean) == ("B", 1, 0, None)


@pytest.mark.parametrize(
    ("score", "text"), [(8.26, "8.3"), (28.96, "28.96"), (30.0, "30"), (19.996, "20")]
)
def test_the_terminal_rounds_points_as_the_report_does(capsys, score, text):
    results = class_of([result("ada", MARKED, score)])
    (shown,) = marks_table([SIX], results, {}).rows
    assert shown.cells[0].text == text
    print_class([submitted(verdict("ada", [check(True)]))], results)
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if "ada" in line]
    assert row == ["ada", text]


def test_the_terminal_names_the_exercise_of_the_first_problem(capsys):
    short = verdict("ada", [check(False)], "2 rows are wrong.")
    named = verdict("bo", [check(False)], "filter_ground returned None.")
    print_class([submitted(short), submitted(named)])
    output = capsys.readouterr().out
    assert "filter_ground: 2 rows are wrong." in output
    assert output.count("filter_ground") == 2


def test_the_first_problem_is_in_an_exercise_that_counts(capsys):
    results = class_of([result("ada", MARKED, 0.0)])
    rules = TermRules(excluded_exercises=frozenset({"filter_ground"}))
    wrong = submitted(verdict("ada", [check(False)], "2 rows are wrong."))
    for excluding, shown in ((results, True), (dataclasses.replace(results, rules=rules), False)):
        print_class([wrong], excluding)
        assert ("2 rows are wrong." in capsys.readouterr().out) == shown


def test_a_failed_judge_gives_no_mark():
    failed = dataclasses.replace(verdict("ada", []), status=FAILED)
    results = class_of([result("ada", WAITING, None)])
    (row,) = marks_table([SIX], results, {"ada": {SIX.name: failed}}).rows
    assert row.cells[0].text == "?"


@pytest.mark.parametrize(
    "time, words",
    [
        (timedelta(seconds=2), "1 min"),
        (timedelta(hours=5, minutes=20), "5 h 20 min"),
        (timedelta(days=2), "2 d"),
        (timedelta(days=2, hours=1, minutes=59), "2 d 1 h"),
    ],
)
def test_a_duration_has_at_most_two_units(time, words):
    assert format_duration(time) == words


def test_the_text_about_a_mean_lists_the_included_scores():
    results = class_of(
        [
            result("a", MARKED, 30.0, penalty=10.0),
            result("b", WAITING, 15.0),
            result("c", MARKED, 0.0),
            result("d", MISSING, None),
            result("e", EXCUSED, None),
            result("f", WAITING, None),
        ]
    )
    distribution = distribution_of(SIX, results, [])
    assert (distribution.mean, distribution.median, distribution.count) == (15.0, 15.0, 3)
    assert distribution.population == (
        "for 3 students with a score, 1 of whom is still waiting for a grader; not counted: "
        "1 not yet entered, 1 missing, 1 excused"
    )
    assert distribution.histogram == (1, 0, 0, 0, 0, 1, 0, 0, 0, 1)


def test_counts_and_seconds_describe_the_latest_run(tmp_path):
    verdicts = [verdict(name, [check(True)]) for name in ("ada", "bo")]
    assert "2 notebooks (2 judged earlier) ·" in report(
        tmp_path, verdicts, run=GradingRun(0, 2, 1.4)
    )
    both = report(tmp_path, verdicts, run=GradingRun(1, 1, 3.4))
    assert "2 notebooks (1 judged in 3 s, 1 judged earlier)" in both
    assert "judged in" not in report(tmp_path, verdicts)


def test_the_page_names_the_sandbox(tmp_path):
    verdicts, label = [verdict("ada", [check(True)])], "bubblewrap 0.8.0 (/usr/bin/bwrap)"
    assert f"sandbox: {label}</p>" in report(tmp_path, verdicts, run=GradingRun(1, 0, 1.4, label))
    on_a_cluster = report(tmp_path, verdicts, run=GradingRun(1, 0, 1.4))
    assert "sandbox" not in on_a_cluster


def test_unreadable_files_do_not_count_as_started():
    wrong = verdict("dee", [check(False)], "2 rows are wrong.")
    unreadable = verdict("cy", [])
    assert [(c.failed, c.tried) for c in hardest_checks([unreadable, wrong])] == [(1, 1)]
    assert [item.tried for item in items_of([unreadable, wrong])] == [1]


UNTOUCHED = check(False, kind=MessageKind.NOT_STARTED, subject="filter_ground")


def test_exercises_that_were_not_started_are_not_listed_as_mistakes(tmp_path):
    empty = [
        dataclasses.replace(
            verdict(name, [check(False)]),
            exercises=(
                ExerciseResult("filter_ground", 0.0, 1.0, (UNTOUCHED,), "It is a stub.", ""),
            ),
        )
        for name in ("ada", "bo", "cy")
    ]
    wrong = verdict("dee", [check(False)], "`<` stands where `>=` is asked for.")
    calls_a_stub = verdict("ed", [check(False, kind=MessageKind.NOT_STARTED, subject="voxel_grid")])
    assert count_not_started([*empty, wrong, calls_a_stub]) == [("filter_ground", 3)]
    assert [mistake[2] for mistake in common_messages([*empty, wrong])] == [1]
    assert [item.tried for item in items_of([*empty, wrong])] == [1]
    assert [(c.failed, c.tried) for c in hardest_checks([*empty, wrong])] == [(1, 1)]
    assert "No check failed" in report(tmp_path, empty)
    other_verdicts = [
        verdict(name, [check(False)], f"{count} rows; at least 4 are wanted.")
        for name, count in (("eve", 2), ("flo", 3))
    ]
    assert common_messages([wrong, *other_verdicts])[0] == (
        *("filter_ground", "… rows; at least 4 are wanted.", 2),
    )
    page = report(tmp_path, [*empty, wrong])
    assert "<code>&lt;</code> stands where <code>&gt;=</code> is asked for." in page
    assert "(number of students in parentheses): <code>filter_ground</code> (3)." in page


def scores_and_passes(number):
    """Return each student's score in other checks, and whether the student passes a check.

    Students with higher scores are more likely to pass.
    """
    random = np.random.default_rng(5)
    other_scores = random.permutation(number) / 4
    return other_scores, other_scores + random.normal(0, 1.5, number) > 2


@pytest.mark.parametrize("number", [19, 20, 45])
def test_discrimination_is_the_correlation_with_the_other_checks(number):
    other_scores, passes = scores_and_passes(number)
    class_ = [
        verdict(f"s{i}", [check(bool(passed), points=3.0), check(True, "other", points=points)])
        for i, (points, passed) in enumerate(zip(other_scores, passes, strict=True))
    ]
    first, other = items_of(class_)
    assert (first.passed, first.tried) == (passes.sum(), number)
    if number < 20:
        assert first.discrimination is None
    else:
        assert first.discrimination == pytest.approx(np.corrcoef(other_scores, passes)[0, 1])
        assert 0.1 < first.discrimination < 0.95
    assert other.discrimination is None, "all students pass it"


def test_two_checks_with_the_same_title_are_two_items():
    shown, hidden = check(True, "a"), check(False, "b", visible=False)
    assert [item.tried for item in items_of([verdict("ada", [shown, hidden])])] == [1, 1]


def test_the_page_says_if_a_class_is_too_small_for_discrimination(tmp_path):
    page = report(tmp_path, [verdict("ada", [check(True)]), verdict("bo", [check(False)])])
    assert "fewer than 20 students" in page


def test_damaged_files_and_timeouts_are_listed(tmp_path):
    slow = check(False, message="It takes ages.", kind=MessageKind.OUT_OF_TIME)
    damaged = dataclasses.replace(verdict("bo", []), problems=("It is cut off.",))
    page = report(tmp_path, [verdict("ada", [slow], "It takes ages."), damaged])
    assert ">Out of time</h2>" in page and ">Repaired, unusual or unreadable files</h2>" in page
    assert "<td>It is cut off.</td>" in page
    clean = report(tmp_path, [verdict("ada", [check(True)])])
    assert "Out of time" not in clean and "unreadable" not in clean


def test_points_carried_forward_do_not_mark_a_file_as_unreadable(tmp_path):
    """Such points follow from an ordinary mistake, so the file itself is in order."""
    both = ("line_through", "point_line_distance")
    gains = [
        Gain("ransac_line", 25.0, helpers, wrong, before=0.0, after=12.08)
        for helpers, wrong in ((both[:1], both[:1]), (both, both), (both, both[:1]), (both, ()))
    ]
    verdicts = []
    for name, gain in zip(("ada", "bo", "cy", "di"), gains, strict=True):
        [exercise] = verdict(name, [check(False)], gain.sentence).exercises
        about = {"exercises": (dataclasses.replace(exercise, gain=gain),)}
        plain = verdict(name, [check(False)])
        verdicts.append(dataclasses.replace(plain, problems=(gain.sentence,), **about))
    assert "unreadable files</h2>" not in report(tmp_path, verdicts)
    form = (
        "{}, which ransac_line calls, is right, but ransac_line needs its result in another form."
    )
    assert {message for _, message, _ in common_messages(verdicts)} == {
        "line_through, which ransac_line calls, is wrong.",
        "line_through and point_line_distance, which ransac_line calls, are wrong.",
        f"line_through, which ransac_line calls, is wrong. {form.format(both[1])}",
        f"{form.format(both[0])} {form.format(both[1])}",
    }
    # A file is still listed if the student forges this sentence.
    for problem in (f"Cell 3 was skipped: {gains[0].sentence}", gains[1].sentence):
        forged = dataclasses.replace(verdicts[0], problems=(problem,))
        assert "unreadable files</h2>" in report(tmp_path, [forged])


def test_exercises_that_were_not_started_are_in_the_order_of_the_course():
    stub = dict(score=0.0, max_score=1.0, cause="It is a stub.")
    done = ExerciseResult("first", 1.0, 1.0, ())
    exercises = [
        ExerciseResult(name, tests=(dataclasses.replace(UNTOUCHED, subject=name),), **stub)
        for name in ("first", "second")
    ]
    first_only = dataclasses.replace(verdict("ada", []), exercises=(done, exercises[1]))
    both = dataclasses.replace(verdict("bo", []), exercises=tuple(exercises))
    assert count_not_started([first_only, both]) == [("first", 1), ("second", 2)]


def test_identical_submissions_are_listed_except_unchanged_releases(tmp_path):
    given = SubmittedFiles(SEVEN.released.name, SEVEN.released.read_bytes()).fingerprint()
    verdicts = [
        *(verdict(name, [check(True)], fingerprint="one and the same") for name in ("ada", "bo")),
        *(verdict(name, [check(True)], lesson=SEVEN, fingerprint=given) for name in ("ada", "bo")),
        verdict("cy", [check(True)], fingerprint="another"),
    ]
    page = report(tmp_path, verdicts)
    (same,) = re.findall(r">Identical files</h2>.*?</tbody>", page, re.DOTALL)
    assert same.count("<tr>") == 2, "the heading and one row"
    assert "<td>ada, bo</td>" in same and SEVEN.name not in same


def test_identical_submissions_of_a_declared_team_are_not_listed(tmp_path):
    course = Course(tmp_path)
    store_answers(course, [STAGE], read_answers(course, None, [STAGE], {"Team Red": "ada,bo"}, {}))
    files = [verdict(name, [check(True)], fingerprint="same") for name in ("ada", "bo")]
    assert "Identical files" not in report(tmp_path, files)
    files.append(verdict("cy", [check(True)], fingerprint="same"))
    assert "<td>ada, bo, cy</td>" in report(tmp_path, files)


def test_the_page_links_to_the_other_files_of_the_course(tmp_path):
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / f"similarity_{STAGE}.html").touch()
    (tmp_path / "scores.csv").touch()
    (tmp_path / "handed_back" / STAGE).mkdir(parents=True)
    page = report(tmp_path, [verdict("ada", [check(True)])])
    links = re.findall(r'<li><a href="([^"]+)"', page)
    assert all((tmp_path / "report" / link).exists() for link in links)
    assert len(links) == 4


HOSTILE_MARKUP = "<script>alert(1)</script><img src=x onerror=alert(2)>"


def test_only_the_reports_own_script_runs(tmp_path):
    bad = dataclasses.replace(
        verdict(
            HOSTILE_MARKUP,
            [check(False, title=HOSTILE_MARKUP, message=f"`{HOSTILE_MARKUP}`")],
            f"{HOSTILE_MARKUP} `{HOSTILE_MARKUP}`",
        ),
        problems=(HOSTILE_MARKUP,),
    )
    results = class_of(
        [result("ada", MARKED, 1.0)],
        people=(Person("ada", HOSTILE_MARKUP, HOSTILE_MARKUP, section=HOSTILE_MARKUP),),
    )
    page = report(
        tmp_path,
        [bad],
        results,
        warning=HOSTILE_MARKUP,
        unjudged_files=[(Path(HOSTILE_MARKUP), HOSTILE_MARKUP)],
    )
    ((kind, script),) = re.findall(r"<script([^>]*)>(.*?)</script>", page, re.DOTALL)
    assert kind == ' type="module"'
    assert not re.search(r"<img|alert\(1\)</script>", page)
    (allowed,) = re.findall(r"script-src 'sha256-([^']+)'", page)
    assert allowed == base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert not re.search(r"\bsrc=|@import|url\(", page.replace("img src=x", "")), (
        "the page needs no other file"
    )


# Texts that identify a student or that a student wrote, which the page without names must omit.
SECRET = (
    "whostudent",
    "firstname",
    "lastname",
    "sectionname",
    "mailaddress",
    "lmsnumber",
    "messagetext",
    "causetext",
    "problemtext",
    "slipbefore",
    "slipafter",
    "filename",
    "reasontext",
    "warningtext",
    "undecidedtext",
    "githublogin",
    "fingerprint",
    "faulttext",
)


def test_the_page_without_names_contains_no_personal_data(tmp_path):
    secret = dict(
        zip(SECRET, (f"{word}{number}x" for number, word in enumerate(SECRET)), strict=True)
    )
    people, verdicts, stages, results = [], [], [], []
    for number in range(6):
        own = {word: f"{text}{number}" for word, text in secret.items()}
        words = ("firstname", "lastname", "mailaddress", "sectionname", "lmsnumber", "githublogin")
        people.append(Person(own["whostudent"], *(own[word] for word in words)))
        plain = verdict(own["whostudent"], [check(number % 2 == 0, message=own["messagetext"])])
        exercise = dataclasses.replace(
            plain.exercises[0],
            cause=own["causetext"],
            first="keeps",
            slip=Slip(1, 1, own["slipbefore"], own["slipafter"], 0.5),
        )
        verdicts.append(
            dataclasses.replace(
                plain,
                exercises=(exercise,),
                problems=(own["problemtext"],),
                fingerprint="fingerprint",
                faults=(own["faulttext"],),
            )
        )
        results.append(result(own["whostudent"], MARKED, 20.0))
        stages.append(
            StageResult(
                own["whostudent"], STAGE, MARKED, 20.0, 30.0,
                submitted_at=datetime(2031, 1, 1, tzinfo=UTC), undecided=own["undecidedtext"],
            )
        )  # fmt: skip
    named = report(
        tmp_path,
        verdicts,
        class_of(results, stages, people=tuple(people)),
        warning=secret["warningtext"],
        unjudged_files=[(Path(secret["filename"]), secret["reasontext"])],
    )
    page = (tmp_path / "report" / "anonymous.html").read_text("utf-8")
    assert "whostudent0x0" in named and "messagetext" in named, "the page with names contains it"
    assert not [word for word in SECRET if word in page]
    assert "2031" not in page and "<script" not in page
    assert "Mean 20.0" in page and "Keeps it" in page and "3 of 6" in page


def test_the_page_without_names_omits_lessons_with_few_submissions(tmp_path):
    enough = [verdict(f"s{n}", [check(False)], "Wrong.") for n in range(MIN_SUBMISSIONS)]
    few = [verdict(f"s{n}", [check(False)], "No.", SEVEN) for n in range(MIN_SUBMISSIONS - 1)]
    report(tmp_path, [*enough, *few])
    page = (tmp_path / "report" / "anonymous.html").read_text("utf-8")
    assert page.count(SEVEN.name) == 1, "only in the sentence about omitted lessons"
    assert f"0 of {MIN_SUBMISSIONS}" in page and f"{MIN_SUBMISSIONS - 1}" not in re.findall(
        r"of (\d)", page
    )


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER, reason=prerequisites.CHROMIUM)
def test_sorting_and_searching_students_needs_no_network(tmp_path):
    scores = {"cy": 9.0, "ada": 10.0, "bo": 8.5}
    results = class_of([result(name, MARKED, score) for name, score in scores.items()])
    page = report(tmp_path, [verdict(name, [check(True)]) for name in scores], results)
    using = """
      const heads = document.querySelectorAll("table.marks thead [role=button]");
      heads[1].click();
      const names = () => [...document.querySelectorAll("table.marks tbody tr")]
        .filter((row) => !row.hidden).map((row) => row.cells[0].textContent.trim()).join(" ");
      const said = [names()];
      heads[1].click(); said.push(names());
      heads[0].click(); said.push(names());
      const search = document.getElementById("search");
      search.value = "AD"; search.dispatchEvent(new Event("input"));
      said.push(names(), document.getElementById("found").textContent);
      document.title = said.join(" | ");
    """
    (policy,) = re.findall(r"<meta http-equiv[^>]+>", page)
    page = page.replace(policy, "").replace(
        "</body>", f'<script type="module">{using}</script></body>'
    )
    shown, requested = rendered_page(page, tmp_path / "browser", "elsewhere")
    (title,) = re.findall("<title>(.*?)</title>", shown)
    assert title == "bo cy ada | ada cy bo | ada bo cy | ada | 1 found"
    assert requested == []


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER, reason=prerequisites.CHROMIUM)
def test_the_sum_stays_visible_next_to_all_lessons_of_a_term(tmp_path):
    """The window of this test is narrower than the table, which scrolls below the sum."""
    lessons = [lesson for lesson in all_lessons() if lesson.exercises]
    results = class_of([result("ada", MARKED, 28.26, lesson=lesson) for lesson in lessons])
    verdicts = [verdict("ada", [check(True)], lesson=lesson) for lesson in lessons]
    page = report(tmp_path, verdicts, results)
    using = """
      const part = document.querySelector(".scroll");
      const edge = part.getBoundingClientRect().right;
      const sums = [...part.querySelectorAll(".sum")].map((cell) => cell.getBoundingClientRect());
      const isVisible = sums.every((sum) => sum.right <= edge + 1);
      document.title = `${sums.length} ${isVisible} ${part.scrollWidth > part.clientWidth}`;
    """
    (policy,) = re.findall(r"<meta http-equiv[^>]+>", page)
    page = page.replace(policy, "<style>body { width: 42rem; }</style>").replace(
        "</body>", f'<script type="module">{using}</script></body>'
    )
    shown, _ = rendered_page(page, tmp_path / "browser", "elsewhere")
    assert re.findall("<title>(.*?)</title>", shown) == ["3 true true"]


@pytest.mark.slow
@pytest.mark.skipif(not (BROWSER and PDF_TO_TEXT), reason=prerequisites.PDF_TO_TEXT)
def test_no_printed_page_ends_with_a_heading(tmp_path):
    page = report(tmp_path, [verdict("ada", [check(True)])])
    rows = "<tr><td>check</td><td>passed</td></tr>"
    table = "<table class='cards'><thead><tr><th>What</th><th>How</th></tr></thead>{}</table>"
    sections = "".join(
        f"<h2>Heading</h2><p class='soft'>Heading's words</p>{table.format(rows * (2 + n % 3))}"
        f"<details><summary>Heading of a fold</summary>{table.format(rows * (3 + n % 5))}</details>"
        for n in range(90)
    )
    sheets = printed_lines(page.replace("</body>", f"{sections}</body>"), tmp_path / "paper")
    last = [[line for line in sheet if line.strip()][-1] for sheet in sheets]
    assert len(sheets) > 15
    assert [line for line in last if re.search("Heading|What", line)] == []
