"""Copies are found, and independent answers are not flagged as similar."""

import ast
import json
import re
import shutil

import pytest

from grader import cli, commands
from grader.classroom.similarity import comparison
from grader.classroom.similarity.answers import (
    answers_in,
    kept_answers,
    read_notebook_parts,
    suggested_answers,
)
from grader.classroom.similarity.comparison import compare
from grader.classroom.similarity.page import format_percent, write_similarity
from grader.classroom.similarity.stage import compare_stage
from grader.course.kept_answers import ANOTHER_CELL, answers_to, fill_in
from grader.course.lessons import lesson_of
from grader.course.paths import Course
from grader.intake.submission import SubmittedFiles
from tests.course_lessons import COURSE

pytestmark = pytest.mark.usefixtures("reading_without_fork")

ALL = tuple(sorted(exercise.name for lesson in COURSE for exercise in lesson.machine_graded))


def answer(exercise, source):
    found, problems = answers_in(source.split(ANOTHER_CELL), lesson_of(exercise))
    assert not problems
    return found.get(exercise)


def written_answers(exercise, right=None):
    """Return the kept answers to an exercise by name; each name stands for a student."""
    found = {
        variant.name: answer(exercise, variant.source)
        for variant in answers_to(exercise)
        if right in (None, variant.right)
    }
    return {name: pairs for name, pairs in found.items() if pairs}


def compare_answers(exercise, answers, kept=()):
    return compare(exercise, answers, kept, suggested_answers(lesson_of(exercise))[exercise])


def names_of(comparison):
    return {frozenset(pair.students) for pair in comparison.pairs}


# ---- answers that are not flagged ----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("exercise", ALL)
def test_independent_answers_are_not_flagged(exercise, monkeypatch):
    """Right answers, which were written independently, are not flagged even at lower thresholds."""
    monkeypatch.setattr(comparison, "MIN_SHARE", comparison.MIN_SHARE - 0.1)
    monkeypatch.setattr(comparison, "MIN_BITS", comparison.MIN_BITS - 3)
    assert compare_answers(exercise, written_answers(exercise, right=True)).pairs == ()


# Pairs of answers, at least one of them wrong, in which one is an edited version of the other.
CHANGED_PAIRS = {
    "ransac_line": [("does not test for None", "the two points in one array")],
    "get_bounding_boxes": [("minimum and maximum with elif", "elif, the maximum first")],
    "filter_clusters": [
        (
            "renumbers labels inside the loop",
            "renumbers labels inside the loop, and fails on an empty array",
        )
    ],
    "get_oriented_boxes": [
        (
            "edges of the convex hull, an axis-aligned box if there is no hull",
            "a convex hull of clusters that have none",
        )
    ],
    "detect_obstacles": [("boxes around parts of the road", "the road stays in")],
}


@pytest.mark.slow
@pytest.mark.parametrize("exercise", ALL)
def test_wrong_answers_are_flagged_only_if_one_is_an_edit_of_the_other(exercise):
    found = names_of(compare_answers(exercise, written_answers(exercise)))
    assert found <= set(map(frozenset, CHANGED_PAIRS.get(exercise, [])))


def test_answers_that_follow_the_hints_are_not_flagged():
    answers = written_answers("euclidean_clustering", right=True)
    hints = answers["the hints followed to the letter"]
    assert len(hints.steps) > 10
    class_ = {**answers, "bo": hints}
    assert compare_answers("euclidean_clustering", class_).pairs == ()
    assert names_of(compare("euclidean_clustering", class_)), (
        "an answer that the lesson does not suggest is flagged"
    )


def test_short_answers_are_never_flagged():
    class_ = {f"student {number}": answer("filter_ground", SHORT) for number in range(3)}
    others = written_answers("filter_ground")
    comparison = compare_answers("filter_ground", {**class_, **others})
    assert not any(name.startswith("student") for pair in names_of(comparison) for name in pair)


SHORT = (
    "def filter_ground(cloud, ground_level=-1.2):\n    return cloud[~(cloud[:, 2] < ground_level)]"
)


def test_an_answer_that_many_write_is_not_flagged():
    answers = written_answers("get_bounding_boxes", right=True)
    original = answers["a dictionary of running extremes, printing and warning"]
    few = {**answers, "copy": original}
    many = {**few, **{f"copy {number}": original for number in range(6)}}
    assert names_of(compare_answers("get_bounding_boxes", few)) == {
        frozenset({"copy", "a dictionary of running extremes, printing and warning"})
    }
    assert compare_answers("get_bounding_boxes", many).pairs == ()


# ---- copies that are flagged ---------------------------------------------------------------------

ORIGINAL = """\
def get_bounding_boxes(cloud, cluster_labels):
    extremes = {}
    for point, label in zip(cloud[:, :3], cluster_labels):
        if label <= 0:
            continue
        low, high = extremes.get(label, (point, point))
        extremes[label] = np.minimum(low, point), np.maximum(high, point)
    boxes = np.empty((len(extremes), 8, 3))
    row = 0
    for label in sorted(extremes):
        low, high = extremes[label]
        table = np.array(np.meshgrid(*zip(low, high), indexing="ij"))
        boxes[row] = table.reshape(3, 8).T
        row += 1
    return boxes
"""
DISGUISED = {
    "the same": ORIGINAL,
    "other names": """\
import numpy
def get_bounding_boxes(points, numbers):
    corners = {}
    for p, n in zip(points[:, :3], numbers):
        if n <= 0:
            continue
        smallest, largest = corners.get(n, (p, p))
        corners[n] = numpy.minimum(smallest, p), numpy.maximum(largest, p)
    result = numpy.empty((len(corners), 8, 3))
    k = 0
    for n in sorted(corners):
        smallest, largest = corners[n]
        grid = numpy.array(numpy.meshgrid(*zip(smallest, largest), indexing="ij"))
        result[k] = grid.reshape(3, 8).T
        k += 1
    return result
""",
    "another order": """\
def get_bounding_boxes(cloud, cluster_labels):
    row = 0
    extremes = {}
    for point, label in zip(cloud[:, :3], cluster_labels):
        if 0 >= label:
            continue
        low, high = extremes.get(label, (point, point))
        extremes[label] = np.minimum(low, point), np.maximum(high, point)
    boxes = np.empty((len(extremes), 8, 3))
    for label in sorted(extremes):
        low, high = extremes[label]
        table = np.array(np.meshgrid(*zip(low, high), indexing="ij"))
        row = 1 + row
        boxes[row - 1] = table.reshape(3, 8).T
    return boxes
""",
    "another layout, with comments": '''\
def get_bounding_boxes(cloud: np.ndarray, cluster_labels: np.ndarray) -> np.ndarray:
    """All of this is my own work."""
    extremes: dict = {}          # nothing so far
    for (point,
         label) in zip(cloud[:, :3], cluster_labels):
        if label <= 0.0: continue   # noise
        low, high = extremes.get(
            label, (point, point))
        print("at", label)
        extremes[label] = (np.minimum(low, point),
                           np.maximum(high, point))
    boxes = np.empty((len(extremes), 0x8, 3)); row = 0
    for label in sorted(extremes):
        (low, high) = extremes[label]
        table = np.array(np.meshgrid(*zip(low, high), indexing='ij'))

        boxes[row] = table.reshape(3, 8).T

        row = row + 1
    return (boxes)
''',
    "while for for": """\
def get_bounding_boxes(cloud, cluster_labels):
    extremes = {}
    place = 0
    while place < len(cloud):
        point, label = cloud[place, :3], cluster_labels[place]
        place += 1
        if label <= 0:
            continue
        low, high = extremes.get(label, (point, point))
        extremes[label] = np.minimum(low, point), np.maximum(high, point)
    boxes = np.empty((len(extremes), 8, 3))
    labels = sorted(extremes)
    row = 0
    while row < len(labels):
        low, high = extremes[labels[row]]
        table = np.array(np.meshgrid(*zip(low, high), indexing="ij"))
        boxes[row] = table.reshape(3, 8).T
        row += 1
    return boxes
""",
    "a helper": """\
def widened(extremes, label, point):
    low, high = extremes.get(label, (point, point))
    return np.minimum(low, point), np.maximum(high, point)

def corners(low, high):
    table = np.array(np.meshgrid(*zip(low, high), indexing="ij"))
    return table.reshape(3, 8).T
# ---- another cell ----
def get_bounding_boxes(cloud, cluster_labels):
    extremes = {}
    for point, label in zip(cloud[:, :3], cluster_labels):
        if label <= 0:
            continue
        extremes[label] = widened(extremes, label, point)
    boxes = np.empty((len(extremes), 8, 3))
    row = 0
    for label in sorted(extremes):
        low, high = extremes[label]
        boxes[row] = corners(low, high)
        row += 1
    return boxes
""",
    "all at once": """\
def grow(d, n, p):
    # start with the point itself
    b, a = d.get(n, (p, p))
    return np.minimum(b, p), np.maximum(a, p)
# ---- another cell ----
def get_bounding_boxes(c, n):
    i, d = 0, {}
    while i < len(n):
        if n[i] > 0:
            d[n[i]] = grow(d, n[i], c[i, :3])
        i += 1
    k, out = 0, np.empty((len(d), 8, 3))
    for q in sorted(d):
        b, a = d[q]
        t = np.array(np.meshgrid(*zip(b, a), indexing="ij"))
        out[k] = t.reshape(3, 8).T
        k = k + 1
    return out
""",
}


@pytest.mark.parametrize("disguise", DISGUISED)
def test_a_disguised_copy_is_found(disguise):
    class_ = written_answers("get_bounding_boxes", right=True)
    class_.pop("a dictionary of running extremes, printing and warning")  # similar to ORIGINAL
    class_ |= {
        "first": answer("get_bounding_boxes", ORIGINAL),
        "second": answer("get_bounding_boxes", DISGUISED[disguise]),
    }
    assert names_of(compare_answers("get_bounding_boxes", class_)) == {
        frozenset({"first", "second"})
    }


def rename_variables(source):
    """Return the source with other variable names and another layout."""
    trees = [ast.parse(cell) for cell in source.split(ANOTHER_CELL)]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name)]
    own = {node.id for node in nodes if isinstance(node.ctx, ast.Store)}
    for node in nodes:
        node.id = f"my_{node.id}" if node.id in own else node.id
    return ANOTHER_CELL.join(f"# mine\n{ast.unparse(tree)}\n" for tree in trees)


# Copies of these answers are not found, because the lesson suggests such code to every student.
AS_TAUGHT = {
    "euclidean_clustering": ["a queue and NumPy"],
    "euclidean_clustering_accelerated": ["three steps, with one tree for all open pairs"],
    "get_oriented_boxes": ["roof corners first, in zigzag order, and a heading by bisection"],
    "insert": ["prints, uses single precision and returns the node"],
    "principal_axes": ["eigenvectors of the covariance"],
    "ransac_plane": ["excludes a point at the threshold", "the loop of the lesson"],
    "search": ["a stack of places", "strictly closer than the tolerance"],
}


@pytest.mark.slow
@pytest.mark.parametrize("exercise", ALL)
def test_a_copy_of_any_long_answer_is_found_and_no_other_pair(exercise):
    class_ = written_answers(exercise, right=True)
    missed = set()
    for variant in answers_to(exercise):
        if not variant.right or re.search("^%", variant.source, re.MULTILINE):
            continue
        copy = answer(exercise, rename_variables(variant.source))
        found = names_of(compare_answers(exercise, {**class_, "copy": copy}))
        assert found <= {frozenset({variant.name, "copy"})}
        if not found and statements_in(variant.source) >= 8 and not variant.follows_hints:
            missed.add(variant.name)
    assert missed == set(AS_TAUGHT.get(exercise, []))


def statements_in(source):
    cells = map(ast.parse, source.split(ANOTHER_CELL))
    nodes = (node for cell in cells for node in ast.walk(cell))
    named = (ast.FunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom)
    return sum(isinstance(node, ast.stmt) and not isinstance(node, named) for node in nodes)


# ---- numbers and sentences -----------------------------------------------------------------------


def test_the_numbers_about_a_pair_are_counted():
    others = {
        "ada": "def f(a):\n    return a",
        "bo": ORIGINAL,
        "cy": ORIGINAL.replace("row += 1", "row = row + 1  # next"),
    }
    answers = {name: answer("get_bounding_boxes", text) for name, text in others.items()}
    assert answers.pop("ada") is None, "no student wrote it"
    answers["dee"] = answer(
        "get_bounding_boxes", "def get_bounding_boxes(a, b):\n    extremes = {}\n    return None"
    )
    (pair,) = compare("get_bounding_boxes", answers, [answers["dee"]] * 4).pairs
    assert pair.students == ("bo", "cy")
    assert pair.share == 1.0
    assert pair.step_counts == (14, 14)
    assert pair.similar_steps == (frozenset(range(14)), frozenset(range(14)))
    assert pair.exclusive_steps == 13  # all steps except the empty dictionary
    assert pair.other_counts == (1, 4)
    assert pair.nearest_shares == (0.0, 0.0)  # all students have this dictionary


@pytest.mark.parametrize(
    "share, words", [(1, "100 %"), (0.9999, "99 %"), (0.001, "1 %"), (0, "0 %"), (0.256, "26 %")]
)
def test_only_identical_answers_show_100_percent(share, words):
    assert format_percent(share) == words


# ---- a class on disk -----------------------------------------------------------------------------

LESSON = lesson_of("get_bounding_boxes")


def submit(course, student, text, lesson=LESSON):
    path = course.submitted / student / lesson.stage / f"{lesson.name}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")


@pytest.fixture
def course(tmp_path):
    """Return a course of eight students, of whom one copied from another."""
    course = Course(tmp_path)
    others = [v for v in answers_to("get_bounding_boxes") if v.right]
    others = [v.source for v in others if not v.name.startswith("a dictionary")]
    for number, source in enumerate([*others, ORIGINAL, DISGUISED["other names"]]):
        submit(course, f"s{number}", fill_in(LESSON, {"get_bounding_boxes": source}))
    return course


def last_two(course):
    return tuple(sorted(path.name for path in course.submitted.iterdir())[-2:])


def test_a_stage_is_compared_and_shown(course):
    result = compare_stage(course, LESSON.stage)
    assert [pair.students for pair in result.pairs] == [last_two(course)]
    page = write_similarity(course, result).read_text("utf-8")
    assert page.count('class="code"') == 2
    assert "numpy.minimum(smallest, p)" in page
    assert "have the same steps and differ only in names and other details." in page
    assert "14 of 14 steps" in page
    assert not re.search(r"\bsrc=|\bhref=\"[^#]|@import|url\(", page), "needs no other file"


def declare_team(course, *ids):
    lines = [
        json.dumps({"student": id, "stage": LESSON.stage, "label": "a" * 64}) + "\n" for id in ids
    ]
    (course.submitted / ".whose.jsonl").write_text("".join(lines))


def test_names_are_shown_as_in_the_report(course):
    first, second = last_two(course)
    roster = f"id,first_name,last_name\n{first},Ada,Ash\n{second},,\n"
    (course.root / "roster.csv").write_text(roster)
    result = compare_stage(course, LESSON.stage)
    assert result.pairs[0].students == (f"{first} (Ada Ash)", second)
    page = write_similarity(course, result).read_text("utf-8")
    assert f"{first} (Ada Ash) and {second}" in page


def test_a_declared_team_is_mentioned_but_not_reported(course):
    first, second = last_two(course)
    for student in (first, second):
        submit(course, student, fill_in(LESSON, {"get_bounding_boxes": ORIGINAL}))
    assert compare_stage(course, LESSON.stage).shared_notebooks
    declare_team(course, first, second)
    result = compare_stage(course, LESSON.stage)
    assert (result.pairs, result.shared_notebooks) == ((), ())
    page = write_similarity(course, result).read_text("utf-8")
    assert f"not compared with each other: {first} and {second}." in page
    declare_team(course, first, "s0")
    assert compare_stage(course, LESSON.stage).shared_notebooks, "two students of different teams"


@pytest.mark.parametrize("folder", [".", "submitted"])
def test_a_class_is_compared_with_an_earlier_course(course, folder, tmp_path, monkeypatch, capsys):
    """Work of an earlier course is found, but two students of that course are not reported."""
    last = Course(tmp_path / "course-2025")
    *_, second = last_two(course)
    for student, words in (("anna", "other names"), ("bea", "other names")):
        submit(last, student, fill_in(LESSON, {"get_bounding_boxes": DISGUISED[words]}))
    shutil.rmtree(course.submitted / second)
    monkeypatch.setattr(commands, "Course", lambda: course)
    options = ["similarity", LESSON.stage, "--earlier", str(last.root / folder)]
    assert cli.main(options) == 0
    output = capsys.readouterr().out
    first = sorted(path.name for path in course.submitted.iterdir())[-1]
    assert f"{first} and course-2025/anna" in output and f"{first} and course-2025/bea" in output
    assert "anna and" not in output and "identical" not in output
    page = (course.report / f"similarity_{LESSON.stage}.html").read_text("utf-8")
    assert "students and 2 from earlier courses" in page
    assert {path.name for path in course.submitted.iterdir()}.isdisjoint({"anna", "bea"})
    assert cli.main([*options, "--earlier", str(tmp_path / "empty")]) == 2
    assert "Correct --earlier." in capsys.readouterr().err


def test_the_command_prints_similar_answers(course, monkeypatch, capsys):
    monkeypatch.setattr(commands, "Course", lambda: course)
    assert cli.main(["similarity", LESSON.stage]) == 0
    output = capsys.readouterr().out
    assert " and ".join(last_two(course)) in output
    assert str(course.report / f"similarity_{LESSON.stage}.html") in output


@pytest.mark.parametrize(
    "stage, words", [("stage9", "no stage stage9"), (LESSON.stage, "Fewer than two")]
)
def test_the_command_reports_a_missing_class(stage, words, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(commands, "Course", lambda: Course(tmp_path))
    assert cli.main(["similarity", stage]) == 2
    assert words in capsys.readouterr().err


def test_identical_files_are_reported_as_identical(tmp_path):
    course = Course(tmp_path)
    own = fill_in(LESSON, {"get_bounding_boxes": ORIGINAL})
    run = json.loads(own)
    run["metadata"]["language_info"] = {"version": "3.12.1"}
    run["cells"][5]["outputs"] = []
    given = fill_in(LESSON, {})
    texts = {"ada": own, "bo": own, "cy": json.dumps(run), "dee": given, "eve": given}
    for student, text in texts.items():
        submit(course, student, text)
    same = compare_stage(course, LESSON.stage).shared_notebooks
    assert [(pair.students, pair.same_bytes, pair.own_cells) for pair in same] == [
        (("ada", "bo"), True, 1),
        (("ada", "bo", "cy"), False, 1),
    ], "but not two unchanged notebooks"


# ---- hostile notebooks ---------------------------------------------------------------------------

HOSTILE = {
    "brackets": "get_bounding_boxes = " + "(" * 50_000,
    "signs": "def get_bounding_boxes(a, b):\n    return " + "-" * 100_000 + "1",
    "a sum": "def get_bounding_boxes(a, b):\n    return " + "+".join(["a"] * 30_000),
    "names of names": "def get_bounding_boxes(a, b):\n    return a" + ".b" * 50_000,
    "ifs in ifs": "def get_bounding_boxes(a, b):\n"
    + "".join(f"{' ' * (4 + n)}if a:\n" for n in range(95))
    + " " * 100
    + "return 1",
    "long": "def get_bounding_boxes(a, b):\n" + "    a = a + 1\n" * 2_000 + "    return a",
    "one long line": "def get_bounding_boxes(a, b):\n    return '" + "x" * 100_000 + "'",
}


@pytest.mark.end_to_end
@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_notebook_affects_only_its_author(kind, course):
    pair = last_two(course)
    submit(course, "a", fill_in(LESSON, {"get_bounding_boxes": HOSTILE[kind]}))
    result = compare_stage(course, LESSON.stage)
    assert [found.students for found in result.pairs] == [pair]
    assert {student for student, *_ in result.problems} <= {"a"}
    assert write_similarity(course, result).stat().st_size < 200_000


def test_an_answer_that_is_too_long_is_reported():
    for kind in ("long", "one long line"):
        text = fill_in(LESSON, {"get_bounding_boxes": HOSTILE[kind]})
        work = read_notebook_parts(SubmittedFiles("08_bounding_boxes.ipynb", text.encode()), LESSON)
        assert work.problems == ("get_bounding_boxes is too long to be compared.",)


def test_compared_code_never_runs(tmp_path):
    trap = tmp_path / "ran"
    source = f"open({str(trap)!r}, 'w')\n" + ORIGINAL.replace(
        "cloud, cluster_labels", f"cloud, cluster_labels=open({str(trap)!r}, 'w')", 1
    )
    text = fill_in(LESSON, {"get_bounding_boxes": source})
    work = read_notebook_parts(SubmittedFiles("08_bounding_boxes.ipynb", text.encode()), LESSON)
    assert work.answers["get_bounding_boxes"].steps
    assert not trap.exists()


def test_submitted_code_is_escaped_on_the_page(course):
    evil = ORIGINAL.replace("boxes = np", "'</div><script>alert(1)</script>'; boxes = np")
    for student, name in zip(last_two(course), ("<b>x", "<i>y"), strict=True):
        shutil.rmtree(course.submitted / student)
        submit(course, name, fill_in(LESSON, {"get_bounding_boxes": evil}))
    page = write_similarity(course, compare_stage(course, LESSON.stage)).read_text("utf-8")
    assert "&lt;script&gt;alert(1)" in page
    assert not re.search(r"<script|<b>x|<i>y", page)


@pytest.mark.parametrize("is_written", [False, True])
def test_a_function_in_a_module_counts(is_written):
    """A module may be next to the notebook, or written by a cell of the notebook."""
    text = fill_in(
        LESSON, {"get_bounding_boxes": "from mine import boxes\nget_bounding_boxes = boxes"}
    )
    module = "import numpy as np\n" + ORIGINAL.replace("get_bounding_boxes", "boxes")
    notebook, modules = json.loads(text), {"mine": module}
    if is_written:
        cell = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
        notebook["cells"].insert(0, {**cell, "source": f"%%writefile mine.py\n{module}"})
        modules = {}
    data = json.dumps(notebook).encode()
    submitted_files = SubmittedFiles("08_bounding_boxes.ipynb", data, modules=modules)
    answers = read_notebook_parts(submitted_files, LESSON).answers
    assert len(answers["get_bounding_boxes"].steps) > 14


def test_every_kept_answer_is_read():
    for exercise, answers in kept_answers(lesson_of("search")).items():
        assert len(answers) == sum(variant.right for variant in answers_to(exercise))
