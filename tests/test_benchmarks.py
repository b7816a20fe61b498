"""The benchmark of the judge runs to its end, here with one student and one wrong answer."""

import pytest

from grader.course.lessons import find_lesson
from tests.benchmarks import bench_judge
from tests.course_lessons import COURSE

pytestmark = pytest.mark.slow


def test_a_copy_of_the_course_earns_full_marks(tmp_path, monkeypatch):
    monkeypatch.setattr(bench_judge, "STUDENTS", 1)
    lessons = [lesson for lesson in COURSE if lesson.stage == "stage3_obstacles"]
    bench_judge.time_grade(lessons, tmp_path / "course")  # raises AssertionError otherwise


@pytest.mark.parametrize("name", ["10_accelerated_clustering", "12_streaming_obstacles"])
def test_notebooks_with_steps_and_earlier_functions_are_timed(name, monkeypatch):
    monkeypatch.setattr(bench_judge, "WRONG_ANSWERS", 1)
    lesson = find_lesson(name)
    right, wrong = bench_judge.time_mistakes(lesson)
    assert len(right) == 1
    assert len(wrong) == len(lesson.machine_graded)
