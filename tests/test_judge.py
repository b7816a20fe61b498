"""Right answers get full points, wrong answers get fewer, and every notebook gets a verdict."""

import ast
import dataclasses
import itertools
import json
import re
import subprocess
import sys

import matplotlib.pyplot as plt
import pytest

from grader.authoring.trial import note_mismatches
from grader.course.kept_answers import ANOTHER_CELL, answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT
from grader.course.standalone import make_standalone
from grader.intake import preflight
from grader.intake.notebook import read_notebook
from grader.intake.submission import read_submitted_files
from grader.judging import judge as judging
from grader.judging import repair
from grader.judging.judge import UnknownLesson, judge, program_for
from grader.judging.runner import run_checks
from grader.judging.verdict import read_verdict, write_verdict
from grader.judging.verdict_key import verdict_key
from grader.sandbox import Limits
from grader.sandbox.student import StudentProxy
from tests.course_lessons import COURSE
from tests.students import answers_in, student_with
from utils.notebooks import slicing

LIMITS = Limits(call_seconds=6)
# Functions of earlier lessons that lesson 12 uses, and the detector that its hints describe.
EARLIER_FUNCTIONS = {
    "01_point_clouds": ("drop_invalid",),
    "06_filter_ground": ("filter_ground", "voxel_grid"),
    "07_filter_by_distance": ("crop_region", "remove_ego_returns"),
    "09_filter_clusters": ("filter_clusters",),
    "10_accelerated_clustering": ("euclidean_clustering_accelerated",),
    "11_pca_boxes": ("get_oriented_boxes",),
}
AS_HINTED = """\
def detect_obstacles(cloud, threshold=0.5, min_num_points=10, ground_level=-1.2,
                     minimum=(-15.0, -7.0, -3.0), maximum=(35.0, 9.0, 1.0)):
    points = drop_invalid(cloud[:, :3])
    points = crop_region(points, minimum, maximum)
    points = remove_ego_returns(points, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    points = filter_ground(points, ground_level)
    points = voxel_grid(points)
    labels = euclidean_clustering_accelerated(points, threshold)
    return get_oriented_boxes(points, filter_clusters(labels, min_num_points))
"""


def notebooks(right, few):
    """Yield parameters (lesson, variants) of notebooks that together contain every variant.

    A notebook contains one variant of each exercise. If an exercise has no wrong variants left, its
    stub stays. A wrong variant that also defines another exercise is alone in its notebook. Only
    `make proof` runs more than `few` notebooks of a lesson.
    """
    for lesson in COURSE:
        names = [exercise.name for exercise in lesson.machine_graded]
        columns, alone = [], []
        for name in names:
            variants = [variant for variant in answers_to(name) if variant.right == right]
            others = "|".join(other for other in names if other != name) or "no other"
            twofold = [
                not right and bool(re.search(rf"^def ({others})\b", item.source, re.M))
                for item in variants
            ]
            alone += [[item] for item, both in zip(variants, twofold, strict=True) if both]
            columns.append([item for item, both in zip(variants, twofold, strict=True) if not both])
        if right:
            longest = max(map(len, columns))
            columns = [(column * longest)[:longest] for column in columns]
        rows = [[variant for variant in row if variant] for row in itertools.zip_longest(*columns)]
        for turn, chosen in enumerate([*rows, *alone]):
            yield pytest.param(
                lesson,
                chosen,
                id=f"{lesson.name}: " + "; ".join(variant.name for variant in chosen),
                marks=pytest.mark.slow if turn < few else pytest.mark.proof,
            )


@pytest.mark.slow
def test_the_solution_earns_everything(lesson, sandbox):
    verdict = judge(lesson.solved, 1, sandbox)
    assert [
        test.message for exercise in verdict.exercises for test in exercise.tests if not test.passed
    ] == []
    assert verdict.score == verdict.max_score
    assert verdict.problems == ()


def is_hidden(check):
    """Return whether a check is hidden; visible checks are the same for every seed."""
    return not check.is_shown


def faults_on_other_seeds(path, lesson, sandbox):
    """Return the failures of hidden tests with four more seeds.

    The failures depend on the scenes and not on the sandbox, so the functions run in this process.
    In lessons with a given class, they run in the sandbox, because the class exists only there.
    """
    cells = read_notebook(path).code
    if lesson.header.given:
        with StudentProxy(program_for(lesson, cells, {}), sandbox, LIMITS) as student:
            return faults_of(lesson, student)
    try:
        return faults_of(lesson, student_with(lesson, answers_in(lesson, cells)))
    finally:
        plt.close("all")  # some answers draw figures


def faults_of(lesson, student):
    return [
        (seed, outcome.check.name, str(outcome.failure))
        for seed in (22, 333, 4444, 55555)
        for outcome in run_checks(lesson, student, seed, is_hidden)
        if outcome.failure
    ]


@pytest.mark.slow
def test_the_solution_earns_everything_with_four_more_seeds(lesson, sandbox):
    assert faults_on_other_seeds(lesson.solved, lesson, sandbox) == []


@pytest.mark.slow
def test_a_detector_made_of_the_lessons_functions_earns_everything(sandbox, tmp_path):
    cells = []
    for name, functions in EARLIER_FUNCTIONS.items():
        statements, _ = slicing.parse_notebook([find_lesson(name).source.read_text("utf-8")])
        cells.append(
            "".join(
                f"{ast.unparse(statement.node)}\n"
                for statement in slicing.slice_for(functions, statements)
            )
        )
    lesson = find_lesson("12_streaming_obstacles")
    path = tmp_path / f"{lesson.name}.ipynb"
    right = next(variant.source for variant in answers_to("match_boxes") if variant.right)
    path.write_text(
        fill_in(
            lesson,
            {"detect_obstacles": ANOTHER_CELL.join([*cells, AS_HINTED]), "match_boxes": right},
        ),
        "utf-8",
    )
    verdict = judge(path, 1, sandbox)
    assert verdict.score == verdict.max_score
    assert faults_on_other_seeds(path, lesson, sandbox) == []


@pytest.mark.slow
def test_an_untouched_notebook_earns_nothing(lesson, sandbox, tmp_path, monkeypatch):
    for_colab = tmp_path / f"{lesson.name}.ipynb"
    for_colab.write_bytes(make_standalone(lesson.released.read_bytes()))
    # The text shows that the notebook is untouched, so the judge needs no sandbox.
    from_text = [judge(path, 1, None) for path in (lesson.released, for_colab)]
    monkeypatch.setattr(preflight, "_is_as_released", lambda *about: False)
    judged = judge(lesson.released, 1, sandbox)
    assert judged.score == 0
    assert all(
        "is not started" in test.message or "for the same reason" in test.message
        for exercise in judged.exercises
        for test in exercise.tests
    )
    for verdict in from_text:
        own = {"seconds": judged.seconds, "key": judged.key, "fingerprint": judged.fingerprint}
        assert dataclasses.replace(verdict, **own) == judged


@pytest.mark.parametrize(
    "change",
    [
        lambda cells: cells[:-1] + ["def filter_ground(cloud):\n    return cloud"],
        lambda cells: [cell for cell in cells if "def filter_ground" not in cell],
        lambda cells: [cell.replace("raise NotImplementedError", "return cloud") for cell in cells],
        lambda cells: [*cells, "filter_ground = len"],
        lambda cells: [cells[0], "filter_ground = len", *cells[1:]],
    ],
    ids=["the last cell", "a cell less", "each stub", "a cell at the end", "a cell between"],
)
def test_changed_notebooks_do_not_count_as_released(change):
    lesson = find_lesson("06_filter_ground")
    released = read_notebook(lesson.released).code
    assert preflight._is_as_released(lesson, ["", *released, " \n"])
    assert not preflight._is_as_released(lesson, change([*released]))


def test_every_exercise_has_five_right_and_eight_wrong_variants(lesson):
    for exercise in lesson.exercises:
        if not exercise.by_hand:
            right = [variant.right for variant in answers_to(exercise.name)]
            assert right.count(True) >= 5, exercise.name
            assert right.count(False) >= 8, exercise.name


@pytest.mark.parametrize("chosen, variants", list(notebooks(right=True, few=1)))
def test_right_variants_earn_everything(chosen, variants, sandbox, tmp_path):
    path = notebook_of(chosen, variants, tmp_path)
    answered = {variant.exercise for variant in variants}
    verdict = judge(path, 1, sandbox, limits=LIMITS)
    for result in verdict.exercises:
        assert [test.message for test in result.tests if not test.passed] == []
        assert result.name not in answered or result.score == result.max_score
    assert verdict.problems == ()


@pytest.mark.parametrize("chosen, variants", list(notebooks(right=True, few=0)))
def test_right_variants_earn_everything_with_four_more_seeds(chosen, variants, sandbox, tmp_path):
    path = notebook_of(chosen, variants, tmp_path)
    assert faults_on_other_seeds(path, chosen, sandbox) == []


def notebook_of(lesson, variants, folder):
    """Write a notebook that contains the given variants; return its path."""
    path = folder / f"{lesson.name}.ipynb"
    answers = {variant.exercise: variant.source for variant in variants}
    path.write_text(fill_in(lesson, answers), "utf-8")
    return path


@pytest.mark.parametrize("chosen, variants", list(notebooks(right=False, few=1)))
def test_wrong_variants_lose_the_checks_in_their_notes(
    chosen, variants, sandbox, tmp_path, monkeypatch
):
    monkeypatch.setattr(repair, "ONE_SLIP_KEEPS", 0)  # so only the checks decide
    verdict = judge(notebook_of(chosen, variants, tmp_path), 1, sandbox, limits=LIMITS)
    broken = {answer.name: note_mismatches(answer, verdict) for answer in variants}
    assert broken == {answer.name: [] for answer in variants}


def test_hidden_tests_differ_from_seed_to_seed():
    from extension import samples

    assert not (
        samples.obstacles_of_street(1, 50)[:, :3] == samples.obstacles_of_street(2, 50)[:, :3]
    ).all()


def test_the_cluster_oracle_agrees_with_brute_force():
    import numpy as np

    from extension import samples

    cloud = samples.remove_ties(np.random.default_rng(3).uniform(0, 4, (200, 3)), 0.5)
    labels = samples.cluster_labels(cloud, 0.5)
    reach = np.linalg.norm(cloud[:, None] - cloud[None], axis=2) < 0.5
    for _ in range(8):  # 2^8 steps are enough for any cluster of 200 points
        reach = reach @ reach
    assert np.array_equal(reach, labels[:, None] == labels[None])


@pytest.mark.parametrize(
    "content, sentence",
    [
        (b"", "is empty"),
        (b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "not text"),
        (b'{"cells": [{"cell_type": "co', "not valid JSON"),
        (b'{"nbformat": 4}', "no cells"),
        (b"[1, 2, 3]", "no cells"),
        (b'{"cells": 7}', "no cells"),
        (b"[" * 100_000, "not valid JSON"),
    ],
)
def test_an_unreadable_file_gets_a_verdict_with_the_reason(content, sentence, sandbox, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_bytes(content)
    verdict = judge(path, 1, sandbox)
    assert verdict.score == 0
    assert verdict.max_score == 30
    assert sentence in verdict.problems[0]


def test_a_byte_order_mark_and_the_old_format_are_read(sandbox, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    answers = {
        exercise: next(variant.source for variant in answers_to(exercise) if variant.right)
        for exercise in ("filter_ground", "voxel_grid")
    }
    text = fill_in(find_lesson("06_filter_ground"), answers)
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert judge(path, 1, sandbox).score == 30
    cells = [
        {"cell_type": "code", "input": cell["source"], "language": "python", "outputs": []}
        for cell in json.loads(text)["cells"]
        if cell["cell_type"] == "code"
    ]
    path.write_text(
        json.dumps(
            {"nbformat": 3, "nbformat_minor": 0, "metadata": {}, "worksheets": [{"cells": cells}]}
        ),
        "utf-8",
    )
    assert judge(path, 1, sandbox).score == 30


@pytest.mark.slow
def test_a_bad_cell_does_not_affect_the_other_exercise(sandbox, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    good = next(variant.source for variant in answers_to("voxel_grid") if variant.right)
    path.write_text(
        fill_in(
            find_lesson("06_filter_ground"),
            {"filter_ground": "def filter_ground(cloud:\n    return", "voxel_grid": good},
        ),
        "utf-8",
    )
    verdict = judge(path, 1, sandbox)
    assert [result.score for result in verdict.exercises] == [0, 20]
    assert "not valid Python" in verdict.problems[0]
    assert "which was skipped" in verdict.exercises[0].tests[0].message


def test_an_answer_above_its_stub_counts(sandbox, tmp_path):
    lesson = find_lesson("09_filter_clusters")
    content = json.loads(lesson.released.read_text("utf-8"))
    first = next(cell for cell in content["cells"] if cell["cell_type"] == "code")
    right = next(answer.source for answer in answers_to("filter_clusters") if answer.right)
    first["source"] = "".join(first["source"]) + "\n\n" + right
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(json.dumps(content), "utf-8")
    assert judge(path, 1, sandbox).score == 20


@pytest.mark.slow
def test_only_full_marks_are_cached(sandbox, tmp_path, monkeypatch):
    lesson, calls = find_lesson("09_filter_clusters"), []
    right, wrong = (
        next(answer.source for answer in answers_to("filter_clusters") if answer.right is wanted)
        for wanted in (True, False)
    )

    def counted_decide(*about):
        calls.append(about)
        return original_decide(*about)

    original_decide = judging._decide
    monkeypatch.setattr(judging, "_decide", counted_decide)
    monkeypatch.setattr(judging, "_full_mark_decisions", {})

    def judge_notebook(answer, seed=1, student="", module=None):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        path = folder / f"{lesson.name}.ipynb"
        path.write_text(fill_in(lesson, {"filter_clusters": answer}), "utf-8")
        if module:
            (folder / "helpers.py").write_text(module, "utf-8")
        before = len(calls)
        verdict = judge(path, seed, sandbox, student=student)
        return verdict, len(calls) - before

    first, runs = judge_notebook(right, student="ada")
    assert (first.score, runs) == (first.max_score, 1)
    (stored,) = judging._full_mark_decisions.values()
    second, runs = judge_notebook(right, student="bob")
    assert (second.exercises, second.student, runs) == (first.exercises, "bob", 0)
    assert second.key != first.key
    assert judge_notebook(right + "\n# mine", student="eve")[1] == 1
    # Other notebooks add only keys to the cache, because they share the first one's results.
    assert all(
        exercise is stored.exercises[0]
        for others in judging._full_mark_decisions.values()
        for exercise in others.exercises
    )
    assert judge_notebook(right, seed=2)[1] == 1
    assert judge_notebook(right, module="x = 1")[1] == 1
    assert [judge_notebook(wrong)[1] for _ in range(2)] == [1, 1]


def test_a_renamed_file_is_recognised(tmp_path, sandbox):
    lesson = find_lesson("06_filter_ground")
    for name in ("Copy of 06_filter_ground (1).ipynb", "my homework.ipynb"):
        path = tmp_path / name
        path.write_bytes(lesson.released.read_bytes())
        assert judge(path, 1, sandbox).lesson == "06_filter_ground"
    path = tmp_path / "other.ipynb"
    path.write_text('{"cells": [], "metadata": {}}')
    with pytest.raises(UnknownLesson, match="matched with a lesson"):
        judge(path, 1, sandbox)


def test_verdicts_share_equal_results_in_memory(sandbox, tmp_path):
    """Sharing saves memory, because most results are equal in a class of ten thousand."""
    lesson = find_lesson("06_filter_ground")
    verdict = judge(lesson.released, 1, sandbox)
    write_verdict(verdict, tmp_path / "verdict.json")
    copy, other = read_verdict(tmp_path / "verdict.json"), read_verdict(tmp_path / "verdict.json")
    assert copy == other == verdict == verdict.compact()
    assert all(
        first is second for first, second in zip(copy.exercises, other.exercises, strict=True)
    )


def test_a_stored_verdict_is_read_back(sandbox, tmp_path):
    lesson = find_lesson("06_filter_ground")
    verdict = judge(lesson.released, 1, sandbox)
    write_verdict(verdict, tmp_path / "a" / "verdict.json")
    assert read_verdict(tmp_path / "a" / "verdict.json") == verdict
    (tmp_path / "half.json").write_text((tmp_path / "a" / "verdict.json").read_text()[:200])
    assert read_verdict(tmp_path / "half.json") is None
    assert read_verdict(tmp_path / "none.json") is None


def test_the_key_depends_on_seed_and_content(tmp_path):
    lesson = find_lesson("06_filter_ground")
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_bytes(lesson.released.read_bytes())
    key = verdict_key(read_submitted_files(path), lesson, 1)
    assert verdict_key(read_submitted_files(path), lesson, 1) == key
    assert verdict_key(read_submitted_files(path), lesson, 2) != key
    path.write_bytes(path.read_bytes() + b" ")
    assert verdict_key(read_submitted_files(path), lesson, 1) != key


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "grader", *map(str, arguments)],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        timeout=600,
    )


@pytest.mark.slow
def test_the_command_line_prints_one_json_object(sandbox):
    lesson = find_lesson("06_filter_ground")
    done = command("judge", lesson.solved, "--json", "--seed", 2**64 + 5, "--sandbox", sandbox.name)
    assert done.returncode == 0, done.stderr
    verdict = json.loads(done.stdout)
    assert set(verdict) == {
        "lesson",
        "student",
        "status",
        "score",
        "max_score",
        "exercises",
        "problems",
        "seconds",
    }
    assert verdict["score"] == verdict["max_score"] == 30
    assert set(verdict["exercises"][0]) == {"name", "score", "max_score", "tests", "slip"}
    assert set(verdict["exercises"][0]["tests"][0]) == {
        "name",
        "title",
        "passed",
        "score",
        "max_score",
        "message",
        "visible",
    }


@pytest.mark.slow
def test_the_command_line_explains_wrong_arguments(tmp_path):
    assert command("judge", tmp_path / "nothing.ipynb").returncode == 2
    assert "does not exist" in command("judge", tmp_path / "nothing.ipynb").stderr
    assert command("grade", "stage9_none").returncode == 2
    assert "The stages are" in command("grade", "stage9_none").stderr
    assert command("frobnicate").returncode == 2


def test_grading_without_a_sandbox_is_refused(monkeypatch, capsys):
    from grader import cli
    from grader.sandbox import bubblewrap

    monkeypatch.setattr(bubblewrap, "_find_program", lambda: (None, "bubblewrap is not installed."))
    lesson = find_lesson("06_filter_ground")
    assert cli.main(["judge", str(lesson.released), "--seed", str(2**64)]) == 2
    assert "--sandbox process" in capsys.readouterr().err
    assert (
        cli.main(["judge", str(lesson.released), "--seed", str(2**64), "--sandbox", "process"]) == 0
    )
    assert "WARNING: no sandbox" in capsys.readouterr().err
