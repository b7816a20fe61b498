"""The league drives in the sandbox, awards points, and writes a page with pseudonyms."""

import csv
import html
import json
import re
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from extension.league import drives, page, season
from extension.league.drives import (
    DETECTOR,
    MAX_BOXES,
    MAX_FAILURES,
    DriveResult,
    drive_in_sandbox,
    from_json,
    repeat_drive,
)
from extension.league.page import problem_sentences, write_league
from extension.league.pseudonyms import pseudonyms
from extension.league.ranking import counted_metres, standings
from extension.league.season import (
    COURSE_DETECTOR,
    TRUE_BOXES,
    Entrant,
    Season,
    drive_class,
    lesson_of_league,
)
from extension.league.streets import draw_streets
from grader import cli
from grader.course.kept_answers import answers_to, fill_in
from grader.course.paths import PROJECT, Course
from grader.judging.verdict_key import add_imports
from grader.sandbox import Limits
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from tests import prerequisites
from tests.browser import BROWSER, rendered_page
from tests.executors import InlineExecutor
from utils.drive import Street, on_time
from utils.drive.actors import standing_actor
from utils.drive.loop import drive
from utils.simulator.sensor import Sensor, layers
from utils.simulator.streets import EGO_LANE, StreetPlan
from utils.simulator.traffic import car

SEED = 271_828_182_845_904_523_536
LESSON = lesson_of_league("stage4_realtime")
SPARSE_SENSOR = Sensor(layers(6, -2.0, -9.0), np.radians(2.0), maximum_range=30.0)
NARROW_SENSOR = Sensor(layers(2, 0.0, -1.0), np.radians(90), maximum_range=5.0)
EMPTY_PLAN = StreetPlan(parked=np.inf, furniture=np.inf, walkers=np.inf)
FREE_STREET = Street(1, "A made-up street", plan=EMPTY_PLAN)
BLOCKED_STREET = replace(FREE_STREET, actors=(standing_actor(car(), 30.0, EGO_LANE),))

IMPORTS = "import numpy as np\n"
AHEAD = (
    IMPORTS
    + """
def detect_obstacles(cloud):
    ahead = cloud[(cloud[:, 0] > 3) & (abs(cloud[:, 1]) < 1) & (cloud[:, 2] > -1.2), :3]
    if not len(ahead):
        return []
    (a, c, e), (b, d, f) = ahead.min(axis=0), ahead.max(axis=0)
    return [[[x, y, z] for z in (e, f) for x, y in ((a, c), (b, c), (b, d), (a, d))]]
"""
)


def detector_returning(expression, before=""):
    """Return the code of a detector that answers every cloud with `expression`."""
    return f"{IMPORTS}{before}\ndef detect_obstacles(cloud):\n    return {expression}\n"


def drive_with(sandbox, source, street=FREE_STREET, seconds=2.0, **limits):
    program = Program((source,), (DETECTOR,))
    limits = Limits(**{"call_seconds": 1.0, "total_seconds": 20.0, **limits})
    with StudentProxy(program, sandbox, limits) as student:
        return drive_in_sandbox(street, student, "k", seconds=seconds, sensor=NARROW_SENSOR)


# Streets and names --------------------------------------------------------------------------


def test_streets_depend_only_on_the_seed():
    once, again, others = draw_streets(SEED), draw_streets.__wrapped__(SEED), draw_streets(SEED + 1)
    assert [street.number for street in once] == [1, 2, 3, 4, 5, 6]
    for first, second, other in zip(once, again, others, strict=True):
        assert first.seed == second.seed != other.seed
        places = [[actor.obstacle.pose.x for actor in street.actors] for street in (first, second)]
        assert places[0] == places[1] != [actor.obstacle.pose.x for actor in other.actors]
    assert len({street.seed for street in once}) == len(once)
    assert all(SEED not in (street.seed, street.number) for street in once)


def test_pseudonyms_are_stable_and_different_in_another_course():
    students = [f"student{number}" for number in range(300)]
    names = pseudonyms(students, SEED)
    assert len(set(names.values())) == 300
    assert pseudonyms(reversed(students), SEED) == names
    others = pseudonyms(students, SEED + 1)
    assert sum(names[student] == others[student] for student in students) < 5
    alone = pseudonyms(["student7"], SEED)["student7"]
    assert alone == names["student7"]


def test_a_folder_name_that_is_not_text_has_a_pseudonym():
    assert pseudonyms(["\udcff"], SEED)["\udcff"]


# One drive in the sandbox -------------------------------------------------------------------


def test_a_drive_in_the_sandbox_equals_one_in_this_process(sandbox):
    program = Program((AHEAD,), (DETECTOR,))
    with StudentProxy(program, sandbox) as student:
        driven = drive_in_sandbox(BLOCKED_STREET, student, seconds=5.0, sensor=SPARSE_SENSOR)
    functions = {}
    exec(AHEAD, functions)
    expected = drive(
        BLOCKED_STREET, functions[DETECTOR], clock=on_time, seconds=5.0, sensor=SPARSE_SENSOR
    )
    assert not driven.collision and not driven.failed
    assert driven.metres == pytest.approx(expected.metres, abs=0.1)
    assert 18 < driven.metres < 28 and driven.needless == (False,)


def test_stored_answers_reproduce_the_drive(sandbox):
    driven = drive_with(
        sandbox, detector_returning("np.random.rand(3, 8, 3) * 9 - 4"), BLOCKED_STREET, 3.0
    )
    assert not driven.stopped
    stored = from_json(driven.as_json())
    assert stored == driven
    again, report = repeat_drive(stored, BLOCKED_STREET, seconds=3.0, sensor=NARROW_SENSOR)
    assert (round(again.metres, 1), report.collision) == (driven.metres, driven.collision)
    assert tuple(map(str, report.brakings)) == driven.brakings


ODD_ANSWERS = {
    "a text": "'boxes'",
    "nothing": "None",
    "an object": "type('Box', (), {'__array__': 5, '__len__': 6})()",
    "a function": "detect_obstacles",
    "flat": "np.zeros((5, 3))",
    "texts": "[[['1'] * 3] * 8] * 2 + ['x']",
    "too many boxes": f"np.zeros(({MAX_BOXES + 1}, 8, 3))",
    "raises": "1 / 0",
    "raises a word": "(_ for _ in ()).throw(type('Secret', (Exception,), {})('a word'))",
    "not written": "(_ for _ in ()).throw(NotImplementedError('write it'))",
}


@pytest.mark.parametrize("answer", ODD_ANSWERS.values(), ids=ODD_ANSWERS)
def test_a_detector_without_boxes_is_stopped_with_a_fixed_message(answer, sandbox):
    driven = drive_with(sandbox, detector_returning(answer), seconds=4.0)
    assert driven.failed == MAX_FAILURES and driven.metres == 0
    assert driven.stopped.startswith(f"The detector returned no boxes for {MAX_FAILURES} scans. ")
    assert driven.failure in driven.stopped
    assert "Secret" not in driven.stopped and "word" not in driven.stopped


ACCEPTED_BOXES = {
    "no box": ("[]", 0),
    "none that is finite": ("np.full((4, 8, 3), np.nan)", 0),
    "infinitely far": ("np.full((4, 8, 3), 1e300)", 0),
    "one of two is finite": ("np.stack([np.full((8, 3), np.inf), np.ones((8, 3))])", 1),
    "whole numbers": ("np.ones((2, 8, 3), dtype=int)", 2),
    "small floats": ("np.ones((2, 8, 3), dtype=np.float16)", 2),
}


@pytest.mark.parametrize(("answer", "count"), ACCEPTED_BOXES.values(), ids=ACCEPTED_BOXES)
def test_boxes_that_are_not_finite_are_dropped(answer, count, sandbox):
    driven = drive_with(sandbox, detector_returning(answer), seconds=0.5)
    assert not driven.stopped and not driven.failed
    drives, _ = repeat_drive(driven, FREE_STREET, seconds=0.5, sensor=NARROW_SENSOR)
    assert {len(moment.boxes) for moment in drives.moments} == {count}


def test_a_few_failed_scans_are_reported_but_do_not_stop_a_drive(sandbox):
    source = detector_returning(
        "calls.append(0) or ([] if len(calls) % 5 else 1 / 0)", "calls = []"
    )
    driven = drive_with(sandbox, source, seconds=2.0)
    assert not driven.stopped and driven.failed == 4
    (sentence,) = problem_sentences(driven)
    assert sentence == (
        "The detector returned no boxes for 4 scans. detect_obstacles raised ZeroDivisionError."
    )


ENDLESS_DETECTORS = {
    "never ends": ("while True: pass", "loop that never ends"),
    "leaves": ("import os; os._exit(0)", "ended in the middle"),
    "eats memory": ("return bytearray(2**33)", ""),
}


@pytest.mark.parametrize(("line", "words"), ENDLESS_DETECTORS.values(), ids=ENDLESS_DETECTORS)
def test_a_detector_that_never_answers_stops_only_its_own_drive(line, words, sandbox):
    source = f"{IMPORTS}def detect_obstacles(cloud):\n    {line}\n"
    driven = drive_with(sandbox, source, call_seconds=0.5)
    assert driven.stopped and words in driven.stopped and driven.metres == 0
    assert counted_metres(FREE_STREET, driven) == 0
    assert not drive_with(sandbox, detector_returning("[]"), seconds=0.5).stopped


def test_the_message_about_an_unreadable_notebook_does_not_quote_it():
    submitted_files = drives.SubmittedFiles("<b>mine</b>.ipynb", b"{", "")
    driven = drives.drive_submission(submitted_files, LESSON.name, 1, SEED, "process")
    assert driven.stopped == "The notebook cannot be read."


def test_a_detector_can_use_a_module_that_a_cell_writes(monkeypatch):
    cells = [
        "%%writefile mine.py\ndef boxes(cloud):\n    return []\n",
        "from mine import boxes\ndef detect_obstacles(cloud):\n    return boxes(cloud)\n",
    ]
    notebook = json.loads(LESSON.released.read_text("utf-8"))
    notebook["cells"] += [
        {"cell_type": "code", "metadata": {}, "outputs": [], "source": cell} for cell in cells
    ]
    submitted_files = drives.SubmittedFiles(LESSON.released.name, json.dumps(notebook).encode(), "")
    monkeypatch.setattr(drives, "draw_streets", lambda seed: [FREE_STREET])
    monkeypatch.setattr(
        drives,
        "drive_in_sandbox",
        lambda street, student, key: drive_in_sandbox(
            street, student, key, seconds=1.0, sensor=SPARSE_SENSOR
        ),
    )
    driven = drives.drive_submission(submitted_files, LESSON.name, 1, SEED, "process")
    assert not driven.failure and not driven.stopped and driven.metres > 0


def test_the_key_of_a_drive_covers_the_files_that_decide_it(monkeypatch):
    files = add_imports([Path(drives.__file__)])
    names = {path.relative_to(PROJECT).as_posix() for path in files}
    assert {
        "extension/league/streets.py",
        "grader/sandbox/inside/worker.py",
        "utils/drive/planner.py",
        "utils/simulator/scanner.py",
    } <= names
    read = set()
    monkeypatch.setattr(drives, "key_of_files", lambda about, files: read.update(files) or "key")
    drives._rules_fingerprint.__wrapped__(LESSON)
    assert {LESSON.source, LESSON.solved, LESSON.released} <= read
    assert not names & {
        "extension/league/page.py",
        "extension/league/ranking.py",
        "utils/plots/style.py",
    }


# Points ---------------------------------------------------------------------------------------


def test_metres_count_only_beyond_the_stopping_distance():
    free = 30 / 3.6 * 0.5 + (30 / 3.6) ** 2 / 14
    assert counted_metres(FREE_STREET, DriveResult(1, 100.0)) == round(100 - free)
    assert counted_metres(
        FREE_STREET, DriveResult(1, 100.0, needless=(True, False, True))
    ) == round(80 - free)
    assert counted_metres(FREE_STREET, DriveResult(1, free)) == 0
    assert counted_metres(FREE_STREET, DriveResult(1, 100.0, collision="A sentence.")) == 0
    assert counted_metres(FREE_STREET, DriveResult(1, 100.0, stopped="A sentence.")) == 0


def boxes_everywhere():
    x, y = np.mgrid[-4:40:3.0, -6:6:3.0].reshape(2, -1)
    return np.stack([box(*place) for place in zip(x, y, strict=True)])


def box(x, y=0.0, size=2.0):
    floor = [(x, y - size / 2), (x + size, y - size / 2), (x + size, y + size / 2)]
    floor.append((x, y + size / 2))
    return np.array([(*corner, z) for z in (-1.7, 0.0) for corner in floor])


CHEAP = {
    "no boxes": np.empty((0, 8, 3)),
    "boxes everywhere": boxes_everywhere(),
    "one around everything": box(-30.0, size=60.0)[None],
    "fixed boxes next to the road": np.stack([box(x, y) for x in (5, 15, 25) for y in (-4, 4)]),
    **{f"one box {x} m ahead": box(2.6 + x)[None] for x in (1, 3, 4, 5, 7, 9, 12)},
}


def cheap_points(street, boxes):
    result = drive(street, lambda cloud: boxes, clock=on_time, sensor=NARROW_SENSOR)
    return counted_metres(street, drives._summarise_drive(result, ""))


@pytest.mark.parametrize("name", ("no boxes", "boxes everywhere", "one box 4 m ahead"))
def test_cheap_detectors_earn_hardly_any_points(name):
    """True boxes earn about 100 points; the next test covers all cheap detectors and streets."""
    assert cheap_points(draw_streets(SEED)[1], CHEAP[name]) <= 20


@pytest.mark.proof
@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize("seed", (SEED, SEED + 1))
def test_true_boxes_beat_cheap_detectors_in_every_street(number, seed):
    street = draw_streets(seed)[number]
    assert counted_metres(street, drives._summarise_drive(drive(street), "")) > 50
    assert max(cheap_points(street, boxes) for boxes in CHEAP.values()) <= 20


def entrant(name, student=True):
    return Entrant(name, student, lambda: None, None)


def season_of(drives):
    known = {entrant(TRUE_BOXES, False): {1: DriveResult(1, 120.0)}}
    known |= {entrant(name): {1: driven} for name, driven in drives.items()}
    return Season(LESSON, (FREE_STREET,), (), known)


def test_places_are_shared_and_references_have_none():
    ranked = standings(
        season_of(
            {
                "ada": DriveResult(1, 90.0),
                "ben": DriveResult(1, 110.0, near_misses=2),
                "cem": DriveResult(1, 90.0),
                "dot": DriveResult(1, 60.0, collision="Crash."),
                "eva": DriveResult(1, stopped="Stop."),
            }
        )
    )
    order = [(rank.entrant.name, rank.place) for rank in ranked]
    assert order == [
        (TRUE_BOXES, None),
        ("ben", 1),
        ("ada", 2),
        ("cem", 2),
        ("dot", 4),
        ("eva", 4),
    ]
    assert (ranked[1].near_misses, ranked[4].collisions, ranked[5].stopped) == (2, 1, 1)


# A class --------------------------------------------------------------------------------------


@pytest.fixture
def course(tmp_path):
    def submit(student, answers=None):
        path = tmp_path / "submitted" / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(fill_in(LESSON, answers or {}), "utf-8")

    course = Course(tmp_path)
    submit("ada")
    submit("ben", {DETECTOR: detector_returning("[]")})
    return course, submit


@pytest.fixture
def jobs(monkeypatch):
    """Replace the drives with a function that records each job; return the list of jobs."""
    calls = []

    def drive_submission(submitted_files, lesson, number, seed, sandbox):
        calls.append((submitted_files and submitted_files.name, number))
        key = drives.drive_key(submitted_files, draw_streets(seed)[number - 1], LESSON)
        return DriveResult(number, 100.0 + number, key=key)

    monkeypatch.setattr(season, "drive_submission", drive_submission)
    return calls


def drive_the_class(course, sandbox, progress=lambda *about: None, **more):
    return drive_class(course, LESSON, SEED, sandbox, InlineExecutor, 2, progress, **more)


def test_one_student_drives_while_others_take_part_with_stored_drives(course, jobs, sandbox):
    folder, submit = course
    only_ada = drive_the_class(folder, sandbox, students=["ada"])
    assert [entrant.name for entrant in only_ada.students] == ["ada"]
    assert len(jobs) == 3 * len(draw_streets(SEED))  # two reference entrants
    jobs.clear()
    submit("ada", {DETECTOR: detector_returning("None")})
    both = drive_the_class(folder, sandbox, students=["ben"])
    assert [entrant.name for entrant in both.students] == ["ben"], "Ada's new work has not driven"
    assert len(jobs) == len(draw_streets(SEED))
    assert {entrant.name for entrant in drive_the_class(folder, sandbox).students} == {"ada", "ben"}


def test_a_league_of_a_few_streets_is_part_of_the_whole_league(course, jobs, sandbox):
    short = drive_the_class(course[0], sandbox, street_count=2)
    assert [street.number for street in short.streets] == [1, 2]
    assert {number for _, number in jobs} == {1, 2}
    jobs.clear()
    assert len(drive_the_class(course[0], sandbox).streets) == len(draw_streets(SEED))
    assert {number for _, number in jobs} == {3, 4, 5, 6}
    jobs.clear()
    assert len(drive_the_class(course[0], sandbox, street_count=2).streets) == 2
    assert jobs == []


def test_the_command_takes_a_student_and_a_number_of_streets(
    course, jobs, sandbox, monkeypatch, capsys
):
    monkeypatch.setattr("extension.league.command.Course", lambda: course[0])
    monkeypatch.setattr("grader.classroom.executors.EXECUTORS", {"processes": InlineExecutor})
    monkeypatch.setattr(page, "_film_best_drive", lambda *about: None)
    call = ["league", LESSON.stage, "--seed", str(SEED), "--sandbox", sandbox.name]
    assert cli.main([*call, "--student", "zoe"]) == 2
    assert "zoe" in capsys.readouterr().err and jobs == []
    assert cli.main([*call, "--student", "ada", "--streets", "1"]) == 0
    assert len(jobs) == 3 and {number for _, number in jobs} == {1}


def test_a_class_drives_once_and_new_submissions_drive_again(course, jobs, sandbox):
    course, submit = course
    progress = []
    first = drive_the_class(course, sandbox, lambda *about: progress.append(about[:2]))
    assert len(jobs) == 4 * 6 and progress[0] == (0, 24) and progress[-1] == (24, 24)
    assert [student.name for student in first.students] == ["ada", "ben"]
    jobs.clear()
    assert drive_the_class(course, sandbox).drives.values() and jobs == []
    submit("ben", {DETECTOR: detector_returning("[[]]")})
    drive_the_class(course, sandbox)
    assert [number for _, number in jobs] == [1, 2, 3, 4, 5, 6]


def test_ctrl_c_keeps_finished_drives(course, jobs, sandbox):
    def stop(finished, total, what):
        if finished == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drive_the_class(course[0], sandbox, stop)
    finished = len(list(course[0].verdicts.rglob("street_*.json")))
    jobs.clear()
    drive_the_class(course[0], sandbox)
    assert finished == 5 and len(jobs) == 24 - 5


def test_a_drive_with_a_damaged_file_is_repeated(course, jobs, sandbox):
    drive_the_class(course[0], sandbox)
    file = next(course[0].verdicts.glob("ada/*/.league/street_1.json"))
    for text in ("", "{}", "[]", "null", '{"street": 1}'):
        file.write_text(text)
        jobs.clear()
        drive_the_class(course[0], sandbox)
        assert len(jobs) == 1, text


def test_a_drive_that_kills_its_process_twice_is_a_fault(course, jobs, sandbox, monkeypatch):
    original, tries = season.drive_submission, []

    def deadly(submitted_files, lesson, number, seed, sandbox):
        if submitted_files and b"[[]]" in submitted_files.data and number == 2:
            tries.append(number)
            raise BrokenExecutor("died")
        return original(submitted_files, lesson, number, seed, sandbox)

    course, submit = course
    submit("eve", {DETECTOR: detector_returning("[[]]")})
    monkeypatch.setattr(season, "drive_submission", deadly)
    result = drive_the_class(course, sandbox)
    assert len(tries) == 2
    assert result.faults == [f"eve, street 2: {season.PROCESS_DIED}"]
    assert not list(course.verdicts.glob("eve/*/.league/street_2.json"))
    ranked = {standing.entrant.name: standing.points for standing in standings(result)}
    assert 0 < ranked["eve"] < ranked["ada"]


def test_a_starved_detector_drives_again_alone(course, jobs, sandbox, monkeypatch):
    original, tries = season.drive_submission, []

    def starved(submitted_files, *about):
        driven = original(submitted_files, *about)
        if submitted_files is None and about[1] == 3:
            tries.append(driven)
            return replace(driven, starved=len(tries) == 1)
        return driven

    monkeypatch.setattr(season, "drive_submission", starved)
    result = drive_the_class(course[0], sandbox)
    assert len(tries) == 2 and not result.faults and not result.omitted_streets


def test_a_street_that_stops_the_true_boxes_does_not_count(course, jobs, sandbox, monkeypatch):
    original = season.drive_submission

    def unfair(submitted_files, lesson, number, seed, sandbox):
        driven = original(submitted_files, lesson, number, seed, sandbox)
        hit = submitted_files is None and number == 4
        return replace(driven, collision="The car hits a person.") if hit else driven

    monkeypatch.setattr(season, "drive_submission", unfair)
    result = drive_the_class(course[0], sandbox)
    assert [street.number for street in result.streets] == [1, 2, 3, 5, 6]
    assert [street.number for street in result.omitted_streets] == [4]


def test_a_stage_without_a_detector_has_no_league(capsys):
    assert cli.main(["league", "stage3_obstacles"]) == 2
    assert "No exercise in stage3_obstacles is a detector" in capsys.readouterr().err


def test_the_error_about_missing_submissions_names_their_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("extension.league.command.Course", lambda: Course(tmp_path))
    arguments = ["league", LESSON.stage, "--sandbox", "process", "--seed", str(SEED)]
    assert cli.main(arguments) == 2
    assert "python -m grader collect ARCHIVE" in capsys.readouterr().err


# The page -------------------------------------------------------------------------------------

HOSTILE = "<script>alert(1)</script>"


@pytest.fixture
def league_files(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "_film_best_drive", lambda *about: None)
    drives = {
        "ada": DriveResult(1, 90.0, needless=(True,), near_misses=1,
                           brakings=("road mistaken for an obstacle, 9 m ahead, frame 31",)),
        HOSTILE: DriveResult(1, 60.0,
                             collision="The car hits a person at 20 km/h. Seen never."),
        "=1+1": DriveResult(1, stopped="detect_obstacles did not answer within 5 seconds."),
        "finn": DriveResult(1, fault="Traceback: something of ours"),
    }  # fmt: skip
    course = Course(tmp_path)
    text, names_file = write_league(course, season_of(drives), SEED, "No sandbox.")
    return text.read_text("utf-8"), names_file.read_text("utf-8"), course


def test_the_page_has_results_but_no_names(league_files):
    text, names_file, course = league_files
    for name in ("ada", "finn", HOSTILE, "<script", "=1+1", "Traceback"):
        assert name not in text
    for words in (
        "does not affect marks",
        "The car braked needlessly: road mistaken for an obstacle, 9 m ahead, frame 31.",
        "The car hits a person at 20 km/h.",
        "did not answer within 5 seconds",
        "but the detector was not the cause",
        "Near misses: 1.",
        TRUE_BOXES,
        "No sandbox.",
    ):
        assert words in text
    for name in pseudonyms(["ada", "finn", HOSTILE, "=1+1"], SEED).values():
        assert name in text


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER, reason=prerequisites.CHROMIUM)
def test_names_in_the_ranking_are_on_one_line(league_files, tmp_path):
    """Headings wrap instead of names, because the page is at most 62rem wide."""
    using = """
      const names = [...document.querySelectorAll("tbody th")];
      const line = document.createElement("b");
      line.textContent = "x"; line.style.display = "block"; names[0].append(line);
      const height = line.offsetHeight; line.remove();
      const tallest = Math.max(...names.map((name) => name.clientHeight));
      const table = document.querySelector("table");
      document.title = `${tallest < 2 * height} ${table.offsetWidth <= document.body.clientWidth}`;
    """
    text = re.sub(r"<meta http-equiv[^>]+>", "", league_files[0])
    text = text.replace("</head>", "<style>body { width: 62rem; padding: 0; }</style></head>")
    text = text.replace("</body>", f'<script type="module">{using}</script></body>')
    shown, _ = rendered_page(text, tmp_path / "browser", "elsewhere")
    assert re.findall("<title>(.*?)</title>", shown) == ["true true"]


def test_each_value_has_a_label_on_a_phone(league_files):
    """Narrow screens hide the headings and show labels; the first cell is the row's title."""
    tables = re.findall("<table.*?</table>", league_files[0], re.DOTALL)
    assert tables
    for table in tables:
        headings = re.findall('<th(?: class="number")?>(.*?)</th>', table)
        for row in re.findall("<tr.*?</tr>", table.partition("<tbody>")[2], re.DOTALL):
            labels = re.findall('<td[^>]* data-head="(.*?)"', row)
            assert labels in (headings[1:], headings[:1] + headings[2:])


def test_shared_places_are_in_the_order_of_pseudonyms(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "_film_best_drive", lambda *about: None)
    students = [f"student{number:02}" for number in range(20)]
    paths = write_league(
        Course(tmp_path), season_of({student: DriveResult(1, 90.0) for student in students}), SEED
    )
    rows = list(csv.DictReader(paths[1].read_text("utf-8").splitlines()))
    names = [row["Pseudonym"] for row in rows]
    assert names == sorted(names) and [row["Student"] for row in rows] != students
    text = paths[0].read_text("utf-8")
    assert sorted(names, key=text.index) == names


def test_names_are_in_a_file_separate_from_the_page(league_files):
    text, names_file, course = league_files
    rows = list(csv.DictReader(names_file.splitlines()))
    assert {row["Student"] for row in rows} == {"ada", "finn", HOSTILE, "'=1+1"}
    assert {row["Student"]: row["Pseudonym"] for row in rows}["ada"] in text
    assert page.page_path(course, "x").parent != page.real_names_path(course, "x").parent


def test_the_film_shows_the_best_detector_in_the_hardest_street(monkeypatch):
    streets = (FREE_STREET, replace(FREE_STREET, number=2), replace(FREE_STREET, number=3))
    crash = "The drive ends."
    drives = {
        entrant(TRUE_BOXES, False): {n: DriveResult(n, 120.0) for n in (1, 2, 3)},
        entrant("best"): {
            1: DriveResult(1, 110.0),
            2: DriveResult(2, 90.0),
            3: DriveResult(3, 9.0, crash),
        },
        entrant("next"): {n: DriveResult(n, 100.0, crash * (n > 1)) for n in (1, 2, 3)},
    }
    filmed = []

    def record(driven, street):
        filmed.append(street.number)
        raise LookupError

    monkeypatch.setattr(page, "repeat_drive", record)
    with pytest.raises(LookupError):
        page._film_best_drive(
            *(lambda league: (league, standings(league)))(Season(LESSON, streets, (), drives)), str
        )
    assert filmed == [2]


@pytest.mark.proof
def test_a_class_drives_and_right_answers_drive_farther(tmp_path, sandbox, monkeypatch):
    """Run the command on real submissions in the first two streets."""
    answers = {answer.name: answer.source for answer in answers_to(DETECTOR)}
    submitted_files = {
        "right": answers["the functions of the lessons, pasted into separate cells"],
        "blind": answers["returns no boxes"],
        "walls": answers["one box around everything"],
        "raises": detector_returning("1 / 0"),
        "hangs": f"{IMPORTS}def detect_obstacles(cloud):\n    while True: pass\n",
    }
    for student, source in submitted_files.items():
        path = tmp_path / "submitted" / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in(LESSON, {DETECTOR: source}), "utf-8")
    monkeypatch.setattr("extension.league.command.Course", lambda: Course(tmp_path))
    two = {seed: draw_streets(seed)[:2] for seed in (SEED,)}
    monkeypatch.setattr(season, "draw_streets", two.__getitem__)
    options = ["league", LESSON.stage, "--sandbox", sandbox.name, "--seed", str(SEED)]
    assert cli.main(options) == 0
    rows = list(csv.DictReader((tmp_path / "report" / f"league_{LESSON.stage}.csv").open()))
    points = {row["Student"]: int(row["Metres that count"]) for row in rows}
    assert points.pop("right") > 100
    assert max(points.values()) <= 20 and points["hangs"] == points["raises"] == 0
    text = (tmp_path / "league" / f"{LESSON.stage}.html").read_text("utf-8")
    assert "data:video/mp4" in text or "data:image/gif" in text
    assert COURSE_DETECTOR in html.unescape(text)
    assert not any(f">{student}<" in text for student in submitted_files)
    assert (
        json.loads(next(tmp_path.glob("verdicts/right/*/.league/street_1.json")).read_text())[
            "metres"
        ]
        > 60
    )
